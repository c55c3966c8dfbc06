//! The distance of each cell from the nearest obstacle.
//!
//! It is the exact Euclidean distance between the middles of two cells, up to
//! [`FARTHEST_CLEARANCE`], by the two passes of Meijster, Roerdink and Hesselink ("A general
//! algorithm for computing distance transforms in linear time", 2000): first along columns, then
//! along rows.

use crate::frame::{Cell, Frame};
use crate::map::{CellState, GridMap, TooManyCells};

/// The distance from which on clearances are no longer told apart, cells: its square is the largest
/// that fits a byte.
pub const FARTHEST_CLEARANCE: u8 = 15;
/// The square of the distance of a cell without an obstacle within [`FARTHEST_CLEARANCE`].
const FAR: u8 = u8::MAX;
/// The cells of a row whose distances along their columns are looked at together.
const WINDOW: usize = 2 * FARTHEST_CLEARANCE as usize + 1;

/// The square of each cell's distance from the nearest occupied cell, for a grid of at most `CELLS`
/// cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Clearance<const CELLS: usize> {
    frame: Frame,
    squares: [u8; CELLS],
}

impl<const CELLS: usize> Clearance<CELLS> {
    /// The clearance of an empty map.
    ///
    /// # Errors
    /// [`TooManyCells`] where the frame has more than `CELLS` cells.
    pub const fn new(frame: Frame) -> Result<Self, TooManyCells> {
        if frame.cell_count() > CELLS {
            return Err(TooManyCells { cells: frame.cell_count(), room: CELLS });
        }
        Ok(Self { frame, squares: [FAR; CELLS] })
    }

    /// Computes the clearance of a map. Where the map's frame is another, it takes over that frame.
    ///
    /// # Errors
    /// [`TooManyCells`] where the map has more than `CELLS` cells; the clearance stays as it was.
    pub fn update<const BYTES: usize>(&mut self, map: &GridMap<BYTES>) -> Result<(), TooManyCells> {
        let cells = map.frame().cell_count();
        if cells > CELLS {
            return Err(TooManyCells { cells, room: CELLS });
        }
        self.frame = *map.frame();
        for column in 0..self.frame.columns() {
            self.along_column(map, column);
        }
        for row in 0..self.frame.rows() {
            self.along_row(row);
        }
        Ok(())
    }

    /// The square of the distance to the nearest occupied cell, in cells; `None` beyond
    /// [`FARTHEST_CLEARANCE`] and outside the grid.
    #[must_use]
    pub fn squared(&self, cell: Cell) -> Option<u8> {
        let inside = self.frame.contains(cell);
        self.get(cell).filter(|&square| inside && square != FAR)
    }

    fn get(&self, cell: Cell) -> Option<u8> {
        self.squares.get(self.frame.index(cell)).copied()
    }

    fn put(&mut self, cell: Cell, value: u8) {
        if let Some(square) = self.squares.get_mut(self.frame.index(cell)) {
            *square = value;
        }
    }

    /// Writes the distance, not its square, to the nearest obstacle of the same column.
    fn along_column<const BYTES: usize>(&mut self, map: &GridMap<BYTES>, column: u16) {
        let beyond = FARTHEST_CLEARANCE + 1;
        let mut distance = beyond;
        for row in 0..self.frame.rows() {
            let cell = Cell { row, column };
            let is_obstacle = map.state(cell) == CellState::Occupied;
            distance = if is_obstacle { 0 } else { (distance + 1).min(beyond) };
            self.put(cell, distance);
        }
        distance = beyond;
        for row in (0..self.frame.rows()).rev() {
            let cell = Cell { row, column };
            distance = self.get(cell).unwrap_or(beyond).min((distance + 1).min(beyond));
            self.put(cell, distance);
        }
    }

    /// Turns distances along the columns into squares of distances.
    fn along_row(&mut self, row: u16) {
        let beyond = FARTHEST_CLEARANCE + 1;
        let reach = u16::from(FARTHEST_CLEARANCE);
        // The distances of the cells from `reach` before to `reach` behind the one in hand, in a
        // ring: those of the row itself are overwritten.
        let mut ring = [beyond; WINDOW];
        let mut entered = 0;
        for column in 0..self.frame.columns() {
            let last = column.saturating_add(reach);
            while entered <= last {
                let cell = Cell { row, column: entered };
                let distance = if entered < self.frame.columns() { self.get(cell) } else { None };
                if let Some(slot) = ring.get_mut(usize::from(entered) % WINDOW) {
                    *slot = distance.unwrap_or(beyond);
                }
                entered += 1;
            }
            let mut least = u16::from(FAR);
            for other in column.saturating_sub(reach)..=last {
                let off = other.abs_diff(column);
                let distance = ring.get(usize::from(other) % WINDOW).copied().unwrap_or(beyond);
                if distance < beyond {
                    least = least.min(off * off + u16::from(distance) * u16::from(distance));
                }
            }
            let most = u16::from(FARTHEST_CLEARANCE) * u16::from(FARTHEST_CLEARANCE);
            // At most 225 here.
            self.put(Cell { row, column }, if least <= most { least as u8 } else { FAR });
        }
    }
}
