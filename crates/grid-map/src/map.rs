//! The map: for each cell the evidence of range readings, in two bits.
//!
//! The evidence is the logarithm of the odds that the cell is occupied, in steps, from −1 to +2,
//! with 0 where nothing is known. A ray that passes through the cell takes one step away, a ray that
//! ends in it adds two, and the sum is clamped. `OctoMap` has the same ratio (−0.4 and +0.85; Hornung
//! et al. 2013, section 3.1) between wider limits. So one ray shows a cell to be free or occupied, a
//! wall stands two grazing rays, and a cell that a wrong reading took for occupied is free again
//! after three.

use core::fmt;

use units::Point2;

use crate::area::Area;
use crate::frame::{Cell, Frame};
use crate::ray::Ray;

/// What is known of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CellState {
    /// No reading has told, or the readings contradict each other.
    #[default]
    Unknown,
    /// The cell is free.
    Free,
    /// The cell is occupied.
    Occupied,
}

impl CellState {
    /// What two maps of the same place say together: occupied where one says so, free where one says so and none
    /// occupied.
    #[must_use]
    pub const fn or(self, other: Self) -> Self {
        match (self, other) {
            (Self::Occupied, _) | (_, Self::Occupied) => Self::Occupied,
            (Self::Free, _) | (_, Self::Free) => Self::Free,
            (Self::Unknown, Self::Unknown) => Self::Unknown,
        }
    }
}

/// What is at the end of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RayEnd {
    /// The ray ended at an obstacle.
    Obstacle,
    /// The ray met nothing as far as this.
    Clear,
}

/// A frame with more cells than the map has room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TooManyCells {
    /// The cells of the frame.
    pub cells: usize,
    /// The cells that there is room for.
    pub room: usize,
}

impl fmt::Display for TooManyCells {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the grid has {} cells, and there is room for {}", self.cells, self.room)
    }
}

const CELLS_PER_BYTE: usize = 4;
const LEAST_EVIDENCE: i8 = -1;
const MOST_EVIDENCE: i8 = 2;

/// What a reading shows of a cell, in steps of the evidence that it is occupied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Evidence(i8);

impl Evidence {
    /// The beam passed through the cell.
    pub(crate) const PASSED: Self = Self(-1);
    /// The beam ended in the cell.
    pub(crate) const STRUCK: Self = Self(2);
    /// The beam may have ended in the cell.
    pub(crate) const DOUBTED: Self = Self(1);
}

/// An occupancy grid of at most four times `BYTES` cells.
#[derive(Clone, Debug, PartialEq)]
pub struct GridMap<const BYTES: usize> {
    frame: Frame,
    /// The evidence of four cells in each byte, the first in its lowest bits, as two's complement
    /// of two bits but for 2, which is stored as −2.
    evidence: [u8; BYTES],
}

impl<const BYTES: usize> GridMap<BYTES> {
    /// The map of which nothing is known.
    ///
    /// # Errors
    /// [`TooManyCells`] where the frame has more than four times `BYTES` cells.
    pub const fn new(frame: Frame) -> Result<Self, TooManyCells> {
        let room = BYTES * CELLS_PER_BYTE;
        if frame.cell_count() > room {
            return Err(TooManyCells { cells: frame.cell_count(), room });
        }
        Ok(Self { frame, evidence: [0; BYTES] })
    }

    /// Forgets everything, and lies in another frame from now on.
    ///
    /// # Errors
    /// [`TooManyCells`] where the frame has more than four times `BYTES` cells; the map stays as it
    /// was.
    pub const fn begin(&mut self, frame: Frame) -> Result<(), TooManyCells> {
        let room = BYTES * CELLS_PER_BYTE;
        if frame.cell_count() > room {
            return Err(TooManyCells { cells: frame.cell_count(), room });
        }
        self.frame = frame;
        self.clear();
        Ok(())
    }

    /// Where the cells lie.
    #[must_use]
    pub const fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Forgets everything.
    pub const fn clear(&mut self) {
        self.evidence = [0; BYTES];
    }

    /// What is known of a cell; outside the grid nothing is.
    #[must_use]
    pub fn state(&self, cell: Cell) -> CellState {
        state_of(self.evidence(cell))
    }

    /// Sets what is known of a cell, as firmly as can be, where a map comes from elsewhere. Outside
    /// the grid it does nothing. Returns whether the cell's state is another one than before.
    pub fn set(&mut self, cell: Cell, state: CellState) -> bool {
        let evidence = match state {
            CellState::Unknown => 0,
            CellState::Free => LEAST_EVIDENCE,
            CellState::Occupied => MOST_EVIDENCE,
        };
        self.put(cell, evidence)
    }

    /// Takes in a ray from a sensor at `from`, which passed through all cells up to `to`. Outside
    /// the grid it does nothing; a ray that is longer than the grid, or not finite, neither. Returns
    /// the smallest rectangle with all cells whose state is another one than before.
    pub fn trace(&mut self, from: Point2, to: Point2, end: RayEnd) -> Option<Area> {
        let mut changed: Option<Area> = None;
        for (cell, is_last) in Ray::new(&self.frame, from, to) {
            let is_end = is_last && end == RayEnd::Obstacle;
            if self.weigh(cell, if is_end { Evidence::STRUCK } else { Evidence::PASSED }) {
                changed = Some(Area::of(cell).and_maybe(changed));
            }
        }
        changed
    }

    /// The number of cells in that state.
    #[must_use]
    pub fn count(&self, state: CellState) -> usize {
        self.frame.cells().filter(|&cell| self.state(cell) == state).count()
    }

    fn evidence(&self, cell: Cell) -> i8 {
        if !self.frame.contains(cell) {
            return 0;
        }
        let (at, shift) = place(self.frame.index(cell));
        match self.evidence.get(at).map_or(0, |byte| byte >> shift & 0b11) {
            0b00 => 0,
            0b01 => 1,
            0b10 => 2,
            _ => -1,
        }
    }

    /// Adds what a reading shows of a cell; says whether its state is another one than before.
    pub(crate) fn weigh(&mut self, cell: Cell, Evidence(by): Evidence) -> bool {
        let sum = self.evidence(cell) + by;
        self.put(cell, sum.clamp(LEAST_EVIDENCE, MOST_EVIDENCE))
    }

    /// Sets the evidence of a cell; says whether its state is another one than before.
    fn put(&mut self, cell: Cell, evidence: i8) -> bool {
        if !self.frame.contains(cell) {
            return false;
        }
        let was = self.state(cell);
        let (at, shift) = place(self.frame.index(cell));
        if let Some(byte) = self.evidence.get_mut(at) {
            *byte = *byte & !(0b11 << shift) | (evidence as u8 & 0b11) << shift;
        }
        was != state_of(evidence)
    }
}

const fn state_of(evidence: i8) -> CellState {
    match evidence {
        0 => CellState::Unknown,
        ..0 => CellState::Free,
        1.. => CellState::Occupied,
    }
}

/// The byte of a cell, and its place there.
const fn place(index: usize) -> (usize, usize) {
    (index / CELLS_PER_BYTE, index % CELLS_PER_BYTE * 2)
}
