//! Divides the true plan of a place into the cells of a map: where a drone's body can come to, and where
//! walls are.

use grid_map::{Cell, Frame};
use units::{Metres, Point2};
use world::World;

/// The largest distance, in cells, between a wall and its drawing in a map that counts as right: a cell,
/// and half of the one in which the wall lies.
const RIGHT_CELLS: f32 = 1.5;

/// The cells of a frame by the true plan.
pub(super) struct Truth {
    frame: Frame,
    cells: Vec<TrueCell>,
}

#[derive(Clone, Copy, Default)]
struct TrueCell {
    /// Whether its middle lies in the free space.
    is_free: bool,
    /// Whether no wall is within [`RIGHT_CELLS`] of its middle.
    is_off_walls: bool,
    /// Whether a drone's body can be in its middle, and come there from where the drones start.
    is_reached: bool,
}

impl Truth {
    /// The cells of a frame, for bodies of this radius that start at these places.
    pub(super) fn new(frame: Frame, world: &World, radius: f32, starts: &[Point2]) -> Self {
        let tunnel = &world.tunnel;
        let right = RIGHT_CELLS * frame.resolution().0;
        let cell = |cell| {
            let at = frame.centre(cell);
            let is_off_walls = tunnel.bump(at, right).is_none();
            TrueCell { is_free: tunnel.is_free(at), is_off_walls, is_reached: false }
        };
        let mut truth = Self { frame, cells: frame.cells().map(cell).collect() };
        let has_room = |cell| tunnel.bump(frame.centre(cell), radius).is_none();
        let around = |at: &Point2| {
            let own = frame.cell_at(*at);
            own.into_iter().flat_map(move |cell| near(frame, cell, 1))
        };
        let mut open: Vec<Cell> = starts.iter().flat_map(around).collect();
        while let Some(cell) = open.pop() {
            let known = &mut truth.cells[frame.number(cell)];
            if known.is_free && !known.is_reached && has_room(cell) {
                known.is_reached = true;
                open.extend(frame.sides(cell));
            }
        }
        truth
    }

    /// Where the cells lie.
    pub(super) const fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The cells to which a drone's body can come.
    pub(super) fn reached(&self) -> impl Iterator<Item = Cell> {
        self.frame.cells().filter(|cell| self.cells[self.frame.number(*cell)].is_reached)
    }

    /// The cells of rock beside which a drone's body can be: those that lie within two cells of one to
    /// which it can come.
    pub(super) fn walls(&self) -> impl Iterator<Item = Cell> {
        let is_reached = |cell| self.cells[self.frame.number(cell)].is_reached;
        let is_rock = |cell: &Cell| !self.cells[self.frame.number(*cell)].is_free;
        let rock = self.frame.cells().filter(is_rock);
        rock.filter(move |cell| near(self.frame, *cell, 2).any(is_reached))
    }

    /// Whether a cell lies in the free space, and no wall is near.
    pub(super) fn is_open(&self, cell: Cell) -> bool {
        let TrueCell { is_free, is_off_walls, .. } = self.cells[self.frame.number(cell)];
        is_free && is_off_walls
    }

    /// Whether a cell lies in the rock, and no free space is near.
    pub(super) fn is_rock(&self, cell: Cell) -> bool {
        let TrueCell { is_free, is_off_walls, .. } = self.cells[self.frame.number(cell)];
        !is_free && is_off_walls
    }
}

/// The cells within so many columns and rows of a cell, itself included.
pub(super) fn near(frame: Frame, cell: Cell, cells: i16) -> impl Iterator<Item = Cell> {
    let offsets = move || -cells..=cells;
    let all = offsets().flat_map(move |east| offsets().map(move |north| (east, north)));
    all.filter_map(move |(east, north)| frame.beside(cell, east, north))
}

/// A frame of cells of 0.1 m that holds an area, by its corner and extent, and these places.
pub(super) fn frame_about(
    (corner, (east, north)): (Point2, (Metres, Metres)),
    places: &[Point2],
) -> Option<Frame> {
    const SIDE: Metres = Metres(0.1);
    let far = Point2::new(corner.x + east.0, corner.y + north.0);
    let all = || places.iter().chain([&corner, &far]);
    let least = |of: fn(&Point2) -> f32| all().map(of).fold(f32::INFINITY, f32::min);
    let most = |of: fn(&Point2) -> f32| all().map(of).fold(f32::NEG_INFINITY, f32::max);
    // Half a metre more, for ways round what stands at the edge.
    let edge = 0.5;
    let origin = Point2::new(least(|at| at.x) - edge, least(|at| at.y) - edge);
    let cells = |extent: f32| ((extent + edge) / SIDE.0).ceil() as u16;
    let (columns, rows) = (most(|at| at.x) - origin.x, most(|at| at.y) - origin.y);
    Frame::new(origin, SIDE, cells(columns), cells(rows)).ok()
}
