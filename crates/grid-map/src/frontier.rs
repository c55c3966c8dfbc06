//! Frontiers: where what is known meets what is not (Yamauchi, "A frontier-based approach for
//! autonomous exploration", 1997).

use crate::frame::Cell;
use crate::map::{CellState, GridMap};

/// Cells to each side of a frontier that count for its gain.
const REACH: i16 = 3;
/// The largest gain of a frontier: the 7 by 7 cells around it, without itself.
pub const MOST_GAIN: u8 = 48;

impl<const BYTES: usize> GridMap<BYTES> {
    /// Whether a cell is a frontier: free, and beside a cell of the grid of which nothing is known.
    #[must_use]
    pub fn is_frontier(&self, cell: Cell) -> bool {
        let is_unknown = |cell| self.state(cell) == CellState::Unknown;
        self.state(cell) == CellState::Free && self.frame().sides(cell).any(is_unknown)
    }

    /// All frontiers, row by row from the south.
    pub fn frontiers(&self) -> impl Iterator<Item = Cell> {
        self.frame().cells().filter(|&cell| self.is_frontier(cell))
    }

    /// The gain of a cell: how many of the 48 cells around it nothing is known of. Beyond the grid
    /// nothing can be learnt.
    #[must_use]
    pub fn gain(&self, cell: Cell) -> u8 {
        let around =
            (-REACH..=REACH).flat_map(|north| (-REACH..=REACH).map(move |east| (east, north)));
        let unknown = around
            .filter(|&(east, north)| (east, north) != (0, 0))
            .filter_map(|(east, north)| self.frame().beside(cell, east, north))
            .filter(|&cell| self.state(cell) == CellState::Unknown);
        // At most 48.
        unknown.count() as u8
    }
}
