//! The cells that a robot can reach, and how far each is from a wall.

use core::fmt;
use core::ops::ControlFlow;

use grid_map::{
    Cell, CellState, Clearance, FARTHEST_CLEARANCE, Frame, GridMap, PathError, Planner,
    TooManyCells,
};
use units::Metres;

/// A map on which no place can be chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroundError {
    /// The start is a wall, unknown, or outside the map.
    StartNotFree,
    /// The map has more cells than there is room for.
    TooManyCells(TooManyCells),
    /// The cells that can be reached could not be found.
    Path(PathError),
}

impl fmt::Display for GroundError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StartNotFree => write!(f, "the start is not a free cell of the map"),
            Self::TooManyCells(why) => why.fmt(f),
            Self::Path(why) => why.fmt(f),
        }
    }
}

/// The farthest that a passage is followed to each side when its width is measured, cells.
const WIDEST: i16 = 60;

/// The reachable cells of a map of at most `CELLS` cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Ground<const CELLS: usize> {
    frame: Frame,
    /// The square of the distance from the nearest wall, cells, at most 225; 0 where a robot cannot
    /// get.
    squares: [u8; CELLS],
}

impl<const CELLS: usize> Ground<CELLS> {
    /// The cells that a robot reaches from `start` through free cells.
    ///
    /// # Errors
    /// [`GroundError`] where the start is not free, or the map or the search have no room.
    pub fn new<const MAP: usize, const MARKS: usize, const POOL: usize>(
        map: &GridMap<MAP>,
        planner: &mut Planner<MARKS, POOL>,
        start: Cell,
    ) -> Result<Self, GroundError> {
        let frame = *map.frame();
        if map.state(start) != CellState::Free {
            return Err(GroundError::StartNotFree);
        }
        let mut clearance = Clearance::<CELLS>::new(frame).map_err(GroundError::TooManyCells)?;
        clearance.update(map).map_err(GroundError::TooManyCells)?;
        let mut ground = Self { frame, squares: [0; CELLS] };
        let farthest = FARTHEST_CLEARANCE * FARTHEST_CLEARANCE;
        let free = |cell| (map.state(cell) == CellState::Free).then_some(1);
        planner
            .search(&frame, start, free, |visit| {
                let square = clearance.squared(visit.cell).unwrap_or(farthest);
                if let Some(slot) = ground.squares.get_mut(index(&frame, visit.cell)) {
                    *slot = square;
                }
                ControlFlow::Continue(())
            })
            .map_err(GroundError::Path)?;
        Ok(ground)
    }

    /// Where the cells lie.
    #[must_use]
    pub const fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Whether a robot can be in the cell.
    #[must_use]
    pub fn is_reached(&self, cell: Cell) -> bool {
        self.square(cell) > 0
    }

    /// The cells in which a robot can be.
    pub fn reached(&self) -> impl Iterator<Item = Cell> + '_ {
        self.frame.cells().filter(|&cell| self.is_reached(cell))
    }

    /// The distance of a cell's middle from that of the nearest wall, up to 15 cells; 0 where a
    /// robot cannot be.
    #[must_use]
    pub fn clearance(&self, cell: Cell) -> Metres {
        Metres(libm::sqrtf(f32::from(self.square(cell))) * self.frame.resolution().0)
    }

    /// The free width that is left beside a relay in this cell: of the narrowest of four lines
    /// through the cell, its longer part.
    #[must_use]
    pub fn free_width(&self, cell: Cell) -> Metres {
        let mut narrowest = f32::INFINITY;
        let mut width = 0.0;
        for (east, north, step) in [
            (1, 0, 1.0),
            (0, 1, 1.0),
            (1, 1, core::f32::consts::SQRT_2),
            (1, -1, core::f32::consts::SQRT_2),
        ] {
            let there = f32::from(self.run(cell, east, north)) * step;
            let back = f32::from(self.run(cell, -east, -north)) * step;
            if there + back < narrowest {
                narrowest = there + back;
                width = there.max(back);
            }
        }
        Metres(width * self.frame.resolution().0)
    }

    /// The square of the distance from the nearest wall, cells.
    pub(crate) fn square(&self, cell: Cell) -> u8 {
        if !self.frame.contains(cell) {
            return 0;
        }
        self.squares.get(index(&self.frame, cell)).copied().unwrap_or(0)
    }

    /// The number of free cells from this one in a direction.
    fn run(&self, cell: Cell, east: i16, north: i16) -> i16 {
        let free = |n: i16| {
            self.frame.beside(cell, east * n, north * n).is_some_and(|at| self.is_reached(at))
        };
        (1..=WIDEST).take_while(|&n| free(n)).count() as i16
    }
}

/// The number of a cell, row by row.
pub(crate) const fn index(frame: &Frame, cell: Cell) -> usize {
    cell.row as usize * frame.columns() as usize + cell.column as usize
}
