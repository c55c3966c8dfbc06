//! Sums of the scores of all cells around a place, from sums along rows.

use grid_map::Cell;

use crate::ground::{Ground, index};

/// The most rows to each side that a sum takes in.
const MOST_REACH: usize = 255;

/// The sums of the scores along each row, up to and with each cell.
pub(crate) struct Score<const CELLS: usize> {
    sums: [i32; CELLS],
}

/// The cells within a radius of a cell: how far they extend to each side in each row.
pub(crate) struct Disc {
    reach: u16,
    halves: [u16; MOST_REACH + 1],
}

impl Disc {
    /// The cells whose middles lie within a radius, in cells; at most 255.
    pub(crate) fn new(radius: f32) -> Self {
        let radius = radius.clamp(0.0, MOST_REACH as f32);
        let mut halves = [0; MOST_REACH + 1];
        for (off, half) in halves.iter_mut().enumerate() {
            let square = radius * radius - (off * off) as f32;
            *half = libm::sqrtf(square.max(0.0)) as u16;
        }
        Self { reach: radius as u16, halves }
    }
}

impl<const CELLS: usize> Score<CELLS> {
    /// The sums of what `of` gives for the reachable cells.
    pub(crate) fn new(ground: &Ground<CELLS>, of: impl Fn(Cell) -> i32) -> Self {
        let mut sums = [0; CELLS];
        let mut sum = 0;
        for cell in ground.frame().cells() {
            if cell.column == 0 {
                sum = 0;
            }
            if ground.is_reached(cell) {
                sum += of(cell);
            }
            if let Some(slot) = sums.get_mut(index(ground.frame(), cell)) {
                *slot = sum;
            }
        }
        Self { sums }
    }

    /// The sum over the cells of a disc around a cell.
    pub(crate) fn around(&self, ground: &Ground<CELLS>, at: Cell, disc: &Disc) -> i32 {
        let frame = ground.frame();
        let first = at.row.saturating_sub(disc.reach);
        let last = at.row.saturating_add(disc.reach).min(frame.rows().saturating_sub(1));
        let mut total = 0;
        for row in first..=last {
            let half = disc.halves.get(usize::from(row.abs_diff(at.row))).copied().unwrap_or(0);
            let east = at.column.saturating_add(half).min(frame.columns().saturating_sub(1));
            let west = at.column.checked_sub(half.saturating_add(1));
            let sum =
                |column| self.sums.get(index(frame, Cell::new(column, row))).copied().unwrap_or(0);
            total += sum(east) - west.map_or(0, sum);
        }
        total
    }
}
