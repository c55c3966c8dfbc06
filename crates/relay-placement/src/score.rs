//! Sums of the scores of all cells around a place, from sums along rows.

use grid_map::Cell;

use crate::ground::{Ground, index};

/// The sums of the scores along each row, up to and with each cell.
pub(crate) struct Score<const CELLS: usize> {
    sums: [i32; CELLS],
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

    /// The sum over all cells whose middles lie within a radius, in cells, of that of a cell.
    pub(crate) fn around(&self, ground: &Ground<CELLS>, at: Cell, radius: f32) -> i32 {
        let frame = ground.frame();
        let reach = radius as u16;
        let first = at.row.saturating_sub(reach);
        let last = at.row.saturating_add(reach).min(frame.rows() - 1);
        let mut total = 0;
        for row in first..=last {
            let off = f32::from(row.abs_diff(at.row));
            let half = libm::sqrtf((radius * radius - off * off).max(0.0)) as u16;
            let east = at.column.saturating_add(half).min(frame.columns() - 1);
            let west = at.column.checked_sub(half.saturating_add(1));
            let sum =
                |column| self.sums.get(index(frame, Cell::new(column, row))).copied().unwrap_or(0);
            total += sum(east) - west.map_or(0, sum);
        }
        total
    }
}
