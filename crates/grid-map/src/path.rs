//! Shortest paths on a grid: Dijkstra's algorithm from one cell to all others, with costs in whole
//! numbers.
//!
//! A step to the side costs [`STRAIGHT_COST`], one to a corner [`DIAGONAL_COST`], each more the
//! nearer it leads to a wall, as the caller says. Cells wait in as many queues as there are costs of
//! a step (Dial, "Algorithm 360: shortest-path forest with topological ordering", 1969), which share
//! one pool of fixed size. Of a cell whose cost is final only the direction is kept from which it
//! was reached, in half a byte; its cost is told to the caller at that moment.

use core::fmt;
use core::ops::ControlFlow;

use crate::frame::{Cell, Frame};
use crate::map::TooManyCells;

/// The cost of a step to a cell with which the last one shares a side.
pub const STRAIGHT_COST: u32 = 5;
/// The cost of a step to a cell at a corner of the last one: 7 to 5 is √2 to within 1 %.
pub const DIAGONAL_COST: u32 = 7;
/// The largest factor by which nearness to a wall may lengthen a step.
const MOST_FACTOR: u32 = 16;
/// One queue for each cost of a step, and one for the cells in hand.
const QUEUES: usize = (DIAGONAL_COST * MOST_FACTOR + 1) as usize;
const NOTHING: u16 = u16::MAX;

/// The steps east and north, opposite ones four apart.
const STEPS: [(i16, i16); 8] =
    [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];

/// The marks of a cell: not reached, the start, or a direction and this.
const UNREACHED: u8 = 0;
const START: u8 = 1;
const FIRST_DIRECTION: u8 = 2;

/// A search that could not be carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PathError {
    /// The start lies outside the grid.
    NoStart,
    /// More cells wait than the pool has room for. The cells that were visited before are right.
    PoolFull,
    /// The grid has more cells than there is room for.
    TooManyCells(TooManyCells),
}

impl fmt::Display for PathError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoStart => write!(f, "the start lies outside the grid"),
            Self::PoolFull => write!(f, "more cells wait than there is room for"),
            Self::TooManyCells(why) => why.fmt(f),
        }
    }
}

/// A cell of which the cheapest way from the start is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visit {
    /// The cell.
    pub cell: Cell,
    /// The cost of the way.
    pub cost: u32,
}

/// A cell that waits, with the mark that it will have: 13 bits of column, 13 of row, and the mark.
#[derive(Clone, Copy, Debug)]
struct Waiting(u32);

impl Waiting {
    const NONE: Self = Self(0);
    const BITS: u32 = 13;
    const MASK: u32 = (1 << Self::BITS) - 1;

    const fn new(cell: Cell, mark: u8) -> Self {
        const { assert!(Frame::MOST as u32 == Self::MASK + 1, "each row and column fits the bits") };
        let row = (cell.row as u32) << Self::BITS;
        Self(cell.column as u32 | row | (mark as u32) << (2 * Self::BITS))
    }

    const fn cell(self) -> Cell {
        let column = (self.0 & Self::MASK) as u16;
        Cell::new(column, (self.0 >> Self::BITS & Self::MASK) as u16)
    }

    const fn mark(self) -> u8 {
        (self.0 >> (2 * Self::BITS)) as u8
    }
}

/// Finds shortest paths on grids of at most twice `BYTES` cells, of which at most `POOL` wait at a
/// time. An open grid of n by n cells needs room for some 16·n.
#[derive(Clone, Debug)]
pub struct Planner<const BYTES: usize, const POOL: usize> {
    frame: Option<Frame>,
    /// The marks of two cells in each byte.
    marks: [u8; BYTES],
    pool: [Waiting; POOL],
    /// For each place of the pool the one behind it in its queue, or the next one that is free.
    next: [u16; POOL],
    /// The first free place of the pool.
    free: u16,
    /// The first cell of each queue.
    queues: [u16; QUEUES],
    waiting: usize,
    /// The cost of the cells in hand.
    cost: u32,
}

impl<const BYTES: usize, const POOL: usize> Planner<BYTES, POOL> {
    /// A planner that has not searched.
    #[must_use]
    pub const fn new() -> Self {
        const { assert!(POOL > 0 && POOL < NOTHING as usize) };
        Self {
            frame: None,
            marks: [UNREACHED; BYTES],
            pool: [Waiting::NONE; POOL],
            next: [0; POOL],
            free: 0,
            queues: [0; QUEUES],
            waiting: 0,
            cost: 0,
        }
    }

    /// Forgets the last search.
    pub const fn clear(&mut self) {
        self.frame = None;
    }

    /// Searches from `start`, cheapest cells first. `factor` says by how much a step into a cell is
    /// longer than on open ground, at least 1 and at most 16, or `None` where a robot cannot be; the
    /// start itself is not asked for. A step to a corner is taken only where both cells beside it
    /// can be entered. `visit` hears of each cell once, and may end the search.
    ///
    /// # Errors
    /// [`PathError`]; what was visited before is right.
    pub fn search(
        &mut self,
        frame: &Frame,
        start: Cell,
        factor: impl Fn(Cell) -> Option<u8>,
        visit: impl FnMut(Visit) -> ControlFlow<()>,
    ) -> Result<(), PathError> {
        self.begin(frame, start)?;
        self.resume(usize::MAX, factor, visit).map(|_| ())
    }

    /// Begins a search from `start`, which [`resume`](Self::resume) carries out.
    ///
    /// # Errors
    /// [`PathError`].
    pub fn begin(&mut self, frame: &Frame, start: Cell) -> Result<(), PathError> {
        let room = 2 * BYTES;
        if frame.cell_count() > room {
            return Err(PathError::TooManyCells(TooManyCells { cells: frame.cell_count(), room }));
        }
        if !frame.contains(start) {
            return Err(PathError::NoStart);
        }
        self.reset(frame);
        self.push(0, start, START)
    }

    /// Goes on with the search that was begun, as [`search`](Self::search), for at most `most` cells;
    /// says whether it is over.
    ///
    /// # Errors
    /// [`PathError::PoolFull`]; what was visited before is right, and the search is over.
    pub fn resume(
        &mut self,
        most: usize,
        factor: impl Fn(Cell) -> Option<u8>,
        mut visit: impl FnMut(Visit) -> ControlFlow<()>,
    ) -> Result<bool, PathError> {
        let Some(frame) = self.frame else { return Ok(true) };
        let mut left = most;
        while self.waiting > 0 {
            if left == 0 {
                return Ok(false);
            }
            let cost = self.cost;
            let Some(waiting) = self.pop(cost) else {
                self.cost += 1;
                continue;
            };
            let (cell, mark) = (waiting.cell(), waiting.mark());
            if self.mark(&frame, cell) != UNREACHED {
                continue;
            }
            left -= 1;
            self.set_mark(&frame, cell, mark);
            if visit(Visit { cell, cost }).is_break() {
                return Ok(true);
            }
            self.spread(&frame, cell, cost, &factor)?;
        }
        Ok(true)
    }

    /// The cell before this one on the cheapest way from the start; `None` at the start and for
    /// cells that the last search has not visited.
    #[must_use]
    pub fn before(&self, cell: Cell) -> Option<Cell> {
        let frame = self.frame.filter(|frame| frame.contains(cell))?;
        let direction = self.mark(&frame, cell).checked_sub(FIRST_DIRECTION)?;
        let (east, north) = STEPS.get(usize::from(direction)).copied()?;
        frame.beside(cell, -east, -north)
    }

    /// The way back from a cell that was visited to the start, both included.
    pub fn way_back(&self, from: Cell) -> impl Iterator<Item = Cell> {
        let is_visited =
            |frame: &Frame| frame.contains(from) && self.mark(frame, from) != UNREACHED;
        let first = self.frame.filter(is_visited).map(|_| from);
        core::iter::successors(first, |&cell| self.before(cell))
    }

    fn reset(&mut self, frame: &Frame) {
        self.frame = Some(*frame);
        self.marks = [0; BYTES];
        self.queues = [NOTHING; QUEUES];
        self.waiting = 0;
        self.cost = 0;
        for (n, next) in self.next.iter_mut().enumerate() {
            *next = if n + 1 < POOL { n as u16 + 1 } else { NOTHING };
        }
        self.free = 0;
    }

    /// Lets the cells around one wait whose way leads through it.
    fn spread(
        &mut self,
        frame: &Frame,
        from: Cell,
        cost: u32,
        factor: &impl Fn(Cell) -> Option<u8>,
    ) -> Result<(), PathError> {
        // Of a cell that was visited no factor is needed, and most around one were.
        let around = STEPS.map(|(east, north)| {
            let cell = frame.beside(from, east, north)?;
            let is_new = self.mark(frame, cell) == UNREACHED;
            Some((cell, if is_new { Some(factor(cell)?) } else { None }))
        });
        for (n, entry) in around.iter().enumerate() {
            let Some((cell, factor)) = *entry else { continue };
            let is_diagonal = n % 2 == 1;
            let beside = |m: usize| around.get(m % 8).is_some_and(Option::is_some);
            if is_diagonal && !(beside(n - 1) && beside(n + 1)) {
                continue;
            }
            if let Some(factor) = factor {
                let step = if is_diagonal { DIAGONAL_COST } else { STRAIGHT_COST };
                let factor = u32::from(factor).clamp(1, MOST_FACTOR);
                self.push(cost + step * factor, cell, FIRST_DIRECTION + n as u8)?;
            }
        }
        Ok(())
    }

    fn push(&mut self, cost: u32, cell: Cell, mark: u8) -> Result<(), PathError> {
        let at = self.free;
        let queue = self.queues.get_mut(cost as usize % QUEUES);
        let place = self.pool.get_mut(usize::from(at)).zip(self.next.get_mut(usize::from(at)));
        let (Some((place, next)), Some(queue)) = (place, queue) else {
            return Err(PathError::PoolFull);
        };
        *place = Waiting::new(cell, mark);
        (self.free, *next, *queue) = (*next, *queue, at);
        self.waiting += 1;
        Ok(())
    }

    fn pop(&mut self, cost: u32) -> Option<Waiting> {
        let queue = self.queues.get_mut(cost as usize % QUEUES)?;
        let at = *queue;
        let waiting = *self.pool.get(usize::from(at))?;
        let next = self.next.get_mut(usize::from(at))?;
        (*queue, *next, self.free) = (*next, self.free, at);
        self.waiting -= 1;
        Some(waiting)
    }

    fn mark(&self, frame: &Frame, cell: Cell) -> u8 {
        let index = frame.index(cell);
        let byte = self.marks.get(index / 2).copied().unwrap_or(UNREACHED);
        byte >> (index % 2 * 4) & 0xF
    }

    fn set_mark(&mut self, frame: &Frame, cell: Cell, mark: u8) {
        let index = frame.index(cell);
        let shift = index % 2 * 4;
        if let Some(byte) = self.marks.get_mut(index / 2) {
            *byte = *byte & !(0xF << shift) | mark << shift;
        }
    }
}

impl<const BYTES: usize, const POOL: usize> Default for Planner<BYTES, POOL> {
    fn default() -> Self {
        Self::new()
    }
}
