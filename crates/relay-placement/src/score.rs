//! Sums of the scores of all cells around a place, from sums along rows.

use grid_map::{Cell, DIAGONAL_COST, Frame, STRAIGHT_COST};

use crate::ground::Ground;

/// The most rows to each side that a sum takes in: the diagonal of a grid of 200 by 200 cells.
const MOST_REACH: usize = 283;

/// The sums of the scores along each row, up to and with each cell.
pub(crate) struct Score<const CELLS: usize> {
    /// A grid has at most 8192 columns.
    sums: [i32; CELLS],
}

/// The cells around a cell that are within a radius, or a way: how far they extend to each side in each row.
pub(crate) struct Disc {
    reach: u16,
    halves: [u16; MOST_REACH + 1],
}

impl Disc {
    /// The cells whose middles lie within a radius, in cells; at most [`MOST_REACH`].
    pub(crate) fn new(radius: f32) -> Self {
        let radius = radius.clamp(0.0, MOST_REACH as f32);
        let mut halves = [0; MOST_REACH + 1];
        for (off, half) in halves.iter_mut().enumerate() {
            let square = radius * radius - (off * off) as f32;
            *half = libm::sqrtf(square.max(0.0)) as u16;
        }
        Self { reach: radius as u16, halves }
    }

    /// The cells to which a way of so many cells would lead on open ground, by the steps of the planner;
    /// at most [`MOST_REACH`]. Obstacles only lengthen a way.
    pub(crate) fn by_way(way: f32) -> Self {
        let (straight, diagonal) = (STRAIGHT_COST as f32, DIAGONAL_COST as f32);
        // Costs are whole numbers; the hundredth is for rounding.
        let most = way.clamp(0.0, MOST_REACH as f32) * straight + 0.01;
        let mut halves = [0; MOST_REACH + 1];
        for (off, half) in halves.iter_mut().enumerate() {
            let off = off as f32;
            // With more steps along the row than off it, or with more off it.
            let along = (most - (diagonal - straight) * off) / straight;
            let aside = (most - straight * off) / (diagonal - straight);
            *half = (if along >= off { along } else { aside.min(off) }).max(0.0) as u16;
        }
        Self { reach: (most / straight) as u16, halves }
    }

    /// The cells of the disc around a cell, cut off at the border of the grid: of each row the number,
    /// and the first and the last column.
    pub(crate) fn rows(
        &self,
        frame: &Frame,
        at: Cell,
    ) -> impl Iterator<Item = (u16, u16, u16)> + use<'_> {
        let first = at.row.saturating_sub(self.reach);
        let last = at.row.saturating_add(self.reach).min(frame.rows().saturating_sub(1));
        let columns = frame.columns().saturating_sub(1);
        (first..=last).map(move |row| {
            let half = self.halves.get(usize::from(row.abs_diff(at.row))).copied().unwrap_or(0);
            let west = at.column.saturating_sub(half);
            (row, west, at.column.saturating_add(half).min(columns))
        })
    }
}

impl<const CELLS: usize> Score<CELLS> {
    /// The sums of the scores of all cells, which are given row by row.
    pub(crate) fn new(frame: &Frame, scores: impl Iterator<Item = i16>) -> Self {
        let mut sums = [0; CELLS];
        let columns = usize::from(frame.columns()).max(1);
        let mut scores = scores;
        for row in sums.chunks_exact_mut(columns) {
            let mut sum = 0;
            for (slot, score) in row.iter_mut().zip(&mut scores) {
                sum += i32::from(score);
                *slot = sum;
            }
        }
        Self { sums }
    }

    /// The sums of what `of` gives for the reachable cells.
    pub(crate) fn of_reached(ground: &Ground<CELLS>, of: impl Fn(Cell) -> i16) -> Self {
        let score = |cell| if ground.is_reached(cell) { of(cell) } else { 0 };
        Self::new(ground.frame(), ground.frame().cells().map(score))
    }

    /// The sum over the cells of a disc around a cell.
    pub(crate) fn around(&self, ground: &Ground<CELLS>, at: Cell, disc: &Disc) -> i32 {
        let columns = usize::from(ground.frame().columns()).max(1);
        let first = at.row.saturating_sub(disc.reach);
        let rows = self.sums.chunks_exact(columns).skip(usize::from(first));
        let mut total = 0;
        for ((_, west, east), sums) in disc.rows(ground.frame(), at).zip(rows) {
            let sum = |column: u16| sums.get(usize::from(column)).copied().unwrap_or(0);
            total += sum(east) - west.checked_sub(1).map_or(0, sum);
        }
        total
    }
}

#[cfg(test)]
mod tests {
    use units::{Metres, Point2};

    use super::*;

    /// Each cell is in the disc of a way if, and only if, so many steps lead there.
    #[test]
    fn the_disc_of_a_way_is_what_the_planner_reaches_on_open_ground() {
        let frame = Frame::new(Point2::new(0.0, 0.0), Metres(1.0), 61, 61).unwrap();
        let middle = Cell::new(30, 30);
        for tenths in (0..300).step_by(7) {
            let way = tenths as f32 / 10.0;
            let disc = Disc::by_way(way);
            let reached = |cell: &Cell| {
                let (x, y) = (cell.column.abs_diff(30), cell.row.abs_diff(30));
                let (long, short) = (u32::from(x.max(y)), u32::from(x.min(y)));
                let cost = STRAIGHT_COST * (long - short) + DIAGONAL_COST * short;
                cost as f32 / STRAIGHT_COST as f32 <= way
            };
            let expected = frame.cells().filter(reached).count();
            let rows = disc.rows(&frame, middle);
            let found: u32 = rows.map(|(_, west, east)| u32::from(east - west) + 1).sum();
            assert_eq!(found as usize, expected, "a way of {way} cells");
        }
    }
}
