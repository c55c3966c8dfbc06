//! The ground that a robot knows: its map, and the ways that it has found in it.

use core::ops::ControlFlow;

use grid_map::{
    Area, Beam, Cell, CellState, Frame, GridMap, Planner, STRAIGHT_COST, TooManyCells, Visit,
};
use units::{Metres, Point2};

use crate::tile::{Gain, SIDE, Tile};

/// Cells to each side of an obstacle that a robot keeps away from: 0.2 m at 0.1 m a cell, for a
/// drone of 0.13 m from rotor tip to rotor tip.
const KEPT_OFF: i16 = 2;
/// A robot that stands nearer to an obstacle may leave through so many cells.
const LEAVING: u16 = 4;
/// By how much a step through a cell that is too near to an obstacle counts as longer, where a robot may leave
/// through it or has been there, and a step beside such cells. Our own numbers: a robot flies off its way by a
/// cell, and takes a way that keeps three cells off where there is one; with 8 and 3 it missed what is seen through
/// gaps of one cell.
const NEAR_FACTOR: u8 = 5;
const BESIDE_NEAR_FACTOR: u8 = 2;
/// By how much a step through the unknown counts as longer: it may turn out to be blocked. Our own
/// number.
const UNKNOWN_FACTOR: u8 = 2;
/// Cells to each side of a tile's middle from which the tile is looked at.
const BESIDE: u16 = 4;

/// A map, and shortest ways in it. [`Atlas`] is the one with a fixed size.
pub trait Ground {
    /// Forgets everything, and lies in another frame from now on.
    ///
    /// # Errors
    /// [`TooManyCells`] where the frame has more cells than there is room for; the ground stays as it
    /// was.
    fn begin(&mut self, frame: Frame) -> Result<(), TooManyCells>;
    /// Where the cells lie.
    fn frame(&self) -> &Frame;
    /// What is known of a cell.
    fn state(&self, cell: Cell) -> CellState;
    /// Takes in what a sensor tells, as [`GridMap::sense`], from where the robot is.
    fn sense(&mut self, from: Point2, beam: &Beam);
    /// Sets what is known of a cell, as [`GridMap::set`].
    fn set(&mut self, cell: Cell, state: CellState);
    /// A rectangle with all cells whose state has changed since this was last asked; `None` where none
    /// has.
    fn take_changed(&mut self) -> Option<Area>;
    /// Whether a cell is a frontier, as [`GridMap::is_frontier`].
    fn is_frontier(&self, cell: Cell) -> bool;
    /// How many cells around a frontier are unknown, as [`GridMap::gain`].
    fn gain(&self, cell: Cell) -> u8;
    /// Notes that there is nothing more to see at a tile, whatever the map says; says whether there was room
    /// for that.
    fn close(&mut self, tile: Tile) -> bool;
    /// Forgets which tiles were closed.
    fn open_all(&mut self);
    /// Whether a tile was closed.
    fn is_closed(&self, tile: Tile) -> bool;
    /// Begins to search ways from a point to all cells that can be reached, over unknown cells too,
    /// nearest first. No way leads over the disc that is to be avoided.
    fn begin_search(&mut self, from: Point2, avoided: Option<Disc>);
    /// Goes on with the search for at most `most` cells; says whether it is over. `visit` hears of each
    /// cell once, with the map as it is, and may end the search.
    fn search(
        &mut self,
        most: usize,
        visit: impl FnMut(&Self::Map, Visit) -> ControlFlow<()>,
    ) -> bool;
    /// Whether a cell is too near to an obstacle of the map that was last searched.
    fn is_near_wall(&self, cell: Cell) -> bool;
    /// The cell before this one on the way that the last search found; `None` at the start.
    fn before(&self, cell: Cell) -> Option<Cell>;

    /// The map alone.
    type Map: Sight;
    /// The map alone.
    fn map(&self) -> &Self::Map;
}

/// A part of the floor plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// The middle.
    pub middle: Point2,
    /// The radius.
    pub radius: Metres,
}

/// From where a robot looks at a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// From beside it.
    Beside,
    /// From at most so many cells away, where no robot comes beside it: through a gap that is too narrow.
    Afar(u16),
}

impl View {
    /// The cells to each side of a tile's middle from which it is looked at.
    pub(crate) const fn cells(self) -> u16 {
        match self {
            Self::Beside => BESIDE,
            Self::Afar(cells) => cells,
        }
    }

    /// The rows of tiles to each side of a cell in which a tile may lie that is looked at from it.
    pub(crate) const fn tiles(self) -> u16 {
        // The middle of a tile lies one cell from its edge.
        self.cells().saturating_add(1) / SIDE
    }
}

/// What can be seen from where, by the map.
pub trait Sight {
    /// Whether a robot in this cell can look at the tile: no obstacle lies between, and, from afar, nothing
    /// unknown. From afar sight of one of its frontiers suffices: a gap of one cell may hide the tile's
    /// middle.
    fn shows(&self, cell: Cell, tile: Tile, view: View) -> bool;
}

impl<const BYTES: usize> Sight for GridMap<BYTES> {
    fn shows(&self, cell: Cell, tile: Tile, view: View) -> bool {
        let middle = tile.middle();
        let off = cell.column.abs_diff(middle.column).max(cell.row.abs_diff(middle.row));
        if off > view.cells() {
            return false;
        }
        let frame = self.frame();
        let is_open = |cell: Cell| match view {
            View::Beside => self.state(cell) != CellState::Occupied,
            View::Afar(_) => self.state(cell) == CellState::Free,
        };
        let sees = |end: Cell| {
            let line = frame.line(frame.centre(cell), frame.centre(end));
            line.take_while(|&on_the_way| Tile::of(on_the_way) != Some(tile)).all(is_open)
        };
        // Drones look at nothing from afar, and their flash has no room for it.
        let looks_at_edges = cfg!(feature = "straight") && matches!(view, View::Afar(_));
        let mut edge = tile.cells(frame).filter(|&cell| self.is_frontier(cell));
        sees(middle) || looks_at_edges && edge.any(sees)
    }
}

/// Whether at least `least` frontiers, this one among them, lie within `least / 2` cells to each side
/// of a frontier.
pub(crate) fn is_large<G: Ground>(ground: &G, frontier: Cell, least: u8) -> bool {
    let reach = i16::from(least / 2);
    let frame = *ground.frame();
    let around = (-reach..=reach).flat_map(|north| (-reach..=reach).map(move |east| (east, north)));
    let cells = around.filter_map(|(east, north)| frame.beside(frontier, east, north));
    let frontiers = cells.filter(|&cell| ground.is_frontier(cell));
    frontiers.take(usize::from(least)).count() == usize::from(least)
}

/// Whether no obstacle lies within so many cells to each side of a cell.
pub(crate) fn has_room<G: Ground>(ground: &G, cell: Cell, cells: u8) -> bool {
    let frame = ground.frame();
    let reach = i16::from(cells);
    let around = (-reach..=reach).flat_map(|north| (-reach..=reach).map(move |east| (east, north)));
    let mut cells = around.filter_map(|(east, north)| frame.beside(cell, east, north));
    cells.all(|cell| ground.state(cell) != CellState::Occupied)
}

/// The tiles of a map that are frontiers, each with the largest gain of its cells, row by row.
pub fn frontiers<G: Ground>(ground: &G) -> impl Iterator<Item = (Tile, Gain)> {
    let frame = *ground.frame();
    Tile::all(&frame).filter_map(move |tile| {
        let cells = tile.cells(&frame).filter(|&cell| ground.is_frontier(cell));
        let most = cells.map(|cell| ground.gain(cell)).max()?;
        Some((tile, Gain::of_cells(most)))
    })
}

/// The length of a way of that cost.
#[must_use]
pub fn length(cost: u32, frame: &Frame) -> Metres {
    Metres(cost as f32 / STRAIGHT_COST as f32 * frame.resolution().0)
}

/// A map with a planner: `BYTES` bytes for four cells each, `PAIRS` bytes for two, `BITS` for eight,
/// `TILES` for eight tiles, and room for `POOL` cells that wait in a search.
#[derive(Clone, Debug)]
pub struct Atlas<
    const BYTES: usize,
    const PAIRS: usize,
    const POOL: usize,
    const BITS: usize,
    const TILES: usize,
> {
    map: GridMap<BYTES>,
    planner: Planner<PAIRS, POOL>,
    near_wall: BitSet<BITS>,
    /// Where the map has changed since `near_wall` was brought up to date, and since the robot asked.
    changed: [Option<Area>; 2],
    /// Where the robot has been, which leads it out of where it got in before it saw the walls.
    trail: BitSet<BITS>,
    /// The tiles at which there is nothing more to see.
    closed: BitSet<TILES>,
    /// Where the last search began, and what it avoids.
    start: Option<Cell>,
    avoided: Option<Disc>,
}

/// The ground of a drone: up to 160 by 160 cells, 41 kB.
pub type Atlas160 = Atlas<6_400, 12_800, 2_560, 3_200, 365>;
/// Up to 256 by 256 cells.
pub type Atlas256 = Atlas<16_384, 32_768, 4_096, 8_192, 925>;
/// Up to 512 by 512 cells.
pub type Atlas512 = Atlas<65_536, 131_072, 8_192, 32_768, 3_656>;
/// Up to 1024 by 1024 cells.
pub type Atlas1024 = Atlas<262_144, 524_288, 16_384, 131_072, 14_621>;

impl<
    const BYTES: usize,
    const PAIRS: usize,
    const POOL: usize,
    const BITS: usize,
    const TILES: usize,
> Atlas<BYTES, PAIRS, POOL, BITS, TILES>
{
    /// An atlas of which nothing is known.
    ///
    /// # Errors
    /// [`TooManyCells`] where the frame has more cells than there is room for.
    pub const fn new(frame: Frame) -> Result<Self, TooManyCells> {
        const { assert!(PAIRS >= 2 * BYTES && 2 * BITS >= BYTES, "each cell has its place") };
        match GridMap::new(frame) {
            Ok(map) => {
                let (planner, changed) = (Planner::new(), [None; 2]);
                let (near_wall, trail, closed) = (BitSet::EMPTY, BitSet::EMPTY, BitSet::EMPTY);
                let (start, avoided) = (None, None);
                Ok(Self { map, planner, near_wall, changed, trail, closed, start, avoided })
            }
            Err(error) => Err(error),
        }
    }

    fn note(&mut self, area: Area) {
        for changed in &mut self.changed {
            *changed = Some(area.and_maybe(*changed));
        }
    }
}

impl<
    const BYTES: usize,
    const PAIRS: usize,
    const POOL: usize,
    const BITS: usize,
    const TILES: usize,
> Ground for Atlas<BYTES, PAIRS, POOL, BITS, TILES>
{
    type Map = GridMap<BYTES>;

    fn begin(&mut self, frame: Frame) -> Result<(), TooManyCells> {
        let Self { map, planner, near_wall, changed, trail, closed, start, avoided } = self;
        map.begin(frame)?;
        (*start, *avoided) = (None, None);
        *changed = [None; 2];
        planner.clear();
        near_wall.clear();
        trail.clear();
        closed.clear();
        Ok(())
    }

    fn map(&self) -> &Self::Map {
        &self.map
    }

    fn frame(&self) -> &Frame {
        self.map.frame()
    }

    fn state(&self, cell: Cell) -> CellState {
        self.map.state(cell)
    }

    fn sense(&mut self, from: Point2, beam: &Beam) {
        if let Some(area) = self.map.sense(from, beam) {
            self.note(area);
        }
        let frame = *self.map.frame();
        let is_new = |cell: &Cell| !self.trail.contains(frame.number(*cell));
        if let Some(cell) = frame.cell_at(from).filter(is_new) {
            // A step to a corner takes both cells beside it.
            for cell in frame.sides(cell).chain([cell]) {
                self.trail.insert(frame.number(cell));
            }
        }
    }

    fn set(&mut self, cell: Cell, state: CellState) {
        if self.map.set(cell, state) {
            self.note(Area::of(cell));
        }
    }

    fn take_changed(&mut self) -> Option<Area> {
        let [_, changed] = &mut self.changed;
        changed.take()
    }

    fn is_frontier(&self, cell: Cell) -> bool {
        self.map.is_frontier(cell)
    }

    fn gain(&self, cell: Cell) -> u8 {
        self.map.gain(cell)
    }

    fn close(&mut self, tile: Tile) -> bool {
        self.closed.insert(tile.number(self.map.frame()))
    }

    fn open_all(&mut self) {
        self.closed.clear();
    }

    fn is_closed(&self, tile: Tile) -> bool {
        self.closed.contains(tile.number(self.map.frame()))
    }

    fn begin_search(&mut self, from: Point2, avoided: Option<Disc>) {
        self.avoided = avoided;
        let Self { map, planner, near_wall, changed: [changed, _], start, .. } = self;
        if let Some(area) = changed.take() {
            mark_around_obstacles(near_wall, map, area);
        }
        let frame = map.frame();
        // From outside the grid no cell is reached.
        *start = frame.cell_at(from).filter(|&cell| planner.begin(frame, cell).is_ok());
    }

    fn search(
        &mut self,
        most: usize,
        mut visit: impl FnMut(&Self::Map, Visit) -> ControlFlow<()>,
    ) -> bool {
        let Self { map, planner, near_wall, trail, start, avoided, .. } = self;
        let frame = *map.frame();
        let Some(start) = *start else { return true };
        let is_avoided = |cell: Cell| {
            avoided.is_some_and(|disc| frame.centre(cell).distance(disc.middle).0 < disc.radius.0)
        };
        let is_near = |cell: Cell| near_wall.contains(frame.number(cell));
        let kept_off = |cell: Cell| match is_near(cell) {
            false if frame.sides(cell).any(is_near) => Some(BESIDE_NEAR_FACTOR),
            false => Some(1),
            true => {
                let off = cell.column.abs_diff(start.column).max(cell.row.abs_diff(start.row));
                let may = off <= LEAVING || trail.contains(frame.number(cell));
                may.then_some(NEAR_FACTOR)
            }
        };
        let factor = |cell: Cell| match map.state(cell) {
            CellState::Occupied => None,
            _ if is_avoided(cell) => None,
            CellState::Unknown => kept_off(cell).map(|factor| factor * UNKNOWN_FACTOR),
            CellState::Free => kept_off(cell),
        };
        // Where more cells wait than there is room for, what was visited before is right; a robot
        // finds the rest when it is nearer.
        planner.resume(most, factor, |at| visit(map, at)).unwrap_or(true)
    }

    fn is_near_wall(&self, cell: Cell) -> bool {
        self.near_wall.contains(self.map.frame().number(cell))
    }

    fn before(&self, cell: Cell) -> Option<Cell> {
        self.planner.before(cell)
    }
}

/// Brings the set of the cells near obstacles up to date with a map that has changed in an area.
fn mark_around_obstacles<const BYTES: usize, const BITS: usize>(
    near: &mut BitSet<BITS>,
    map: &GridMap<BYTES>,
    changed: Area,
) {
    let frame = map.frame();
    let affected = changed.grown(KEPT_OFF.unsigned_abs(), frame);
    for cell in affected.cells() {
        near.remove(frame.number(cell));
    }
    let may_reach = affected.grown(KEPT_OFF.unsigned_abs(), frame);
    for wall in may_reach.cells().filter(|&cell| map.state(cell) == CellState::Occupied) {
        for east in -KEPT_OFF..=KEPT_OFF {
            for north in -KEPT_OFF..=KEPT_OFF {
                // The corners of the square are farther off than the distance that is kept.
                let is_within = east * east + north * north < KEPT_OFF * KEPT_OFF;
                if let Some(cell) = frame.beside(wall, east, north).filter(|_| is_within) {
                    near.insert(frame.number(cell));
                }
            }
        }
    }
}

/// A set of numbers below eight times `BYTES`, a bit each.
#[derive(Clone, Debug)]
struct BitSet<const BYTES: usize>([u8; BYTES]);

impl<const BYTES: usize> BitSet<BYTES> {
    const EMPTY: Self = Self([0; BYTES]);

    const fn clear(&mut self) {
        self.0 = [0; BYTES];
    }

    /// Puts a number into the set; says whether there is room for it.
    fn insert(&mut self, number: usize) -> bool {
        let byte = self.0.get_mut(number / 8);
        byte.map(|byte| *byte |= 1 << (number % 8)).is_some()
    }

    fn remove(&mut self, number: usize) {
        if let Some(byte) = self.0.get_mut(number / 8) {
            *byte &= !(1 << (number % 8));
        }
    }

    fn contains(&self, number: usize) -> bool {
        self.0.get(number / 8).is_some_and(|byte| byte >> (number % 8) & 1 == 1)
    }
}
