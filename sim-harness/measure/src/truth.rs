//! Divides the true plan of a place into the cells of a map: where a drone's body can come to, and where
//! walls are.

use std::mem;

use grid_map::{Cell, Frame};
use units::{Metres, Point2};
use world::World;

/// The largest distance, in cells, between a wall and its drawing in a map that counts as right: a cell,
/// and half of the one in which the wall lies.
const RIGHT_CELLS: f32 = 1.5;

/// The cells of a frame to which a drone's body can come from where the drones start.
pub(super) struct Reached {
    frame: Frame,
    is_reached: Vec<bool>,
}

impl Reached {
    /// The cells of a frame, for bodies of this radius that start at these places.
    pub(super) fn new(frame: Frame, world: &World, radius: f32, starts: &[Point2]) -> Self {
        let tunnel = &world.tunnel;
        Self::by(frame, starts, |at| tunnel.is_free(at) && tunnel.bump(at, radius).is_none())
    }

    /// The cells of a frame, for bodies that start at these places and can be where `has_room` says. It is
    /// asked once about each cell that is reached and about those beside them, and about no other: the
    /// area of a swarm may be a hundred times as large as the tunnel in it.
    fn by(frame: Frame, starts: &[Point2], mut has_room: impl FnMut(Point2) -> bool) -> Self {
        let around = |at: &Point2| {
            let own = frame.cell_at(*at);
            own.into_iter().flat_map(move |cell| near(frame, cell, 1))
        };
        let mut is_asked = vec![false; frame.cell_count()];
        let mut is_reached = is_asked.clone();
        let mut open: Vec<Cell> = starts.iter().flat_map(around).collect();
        while let Some(cell) = open.pop() {
            let number = frame.number(cell);
            if !mem::replace(&mut is_asked[number], true) && has_room(frame.centre(cell)) {
                is_reached[number] = true;
                open.extend(frame.sides(cell));
            }
        }
        Self { frame, is_reached }
    }

    /// The cells, row by row from the south.
    pub(super) fn cells(&self) -> impl Iterator<Item = Cell> {
        self.frame.cells().filter(|cell| self.holds(*cell))
    }

    fn holds(&self, cell: Cell) -> bool {
        self.is_reached[self.frame.number(cell)]
    }
}

/// The cells of a frame by the true plan.
pub(super) struct Truth {
    reached: Reached,
    cells: Vec<TrueCell>,
}

#[derive(Clone, Copy, Default)]
struct TrueCell {
    /// Whether its middle lies in the free space.
    is_free: bool,
    /// Whether no wall is within [`RIGHT_CELLS`] of its middle.
    is_off_walls: bool,
}

impl Truth {
    /// The cells of a frame, for bodies of this radius that start at these places.
    pub(super) fn new(frame: Frame, world: &World, radius: f32, starts: &[Point2]) -> Self {
        let tunnel = &world.tunnel;
        let right = RIGHT_CELLS * frame.resolution().0;
        let cell = |cell| {
            let at = frame.centre(cell);
            let is_off_walls = tunnel.bump(at, right).is_none();
            TrueCell { is_free: tunnel.is_free(at), is_off_walls }
        };
        let cells = frame.cells().map(cell).collect();
        Self { reached: Reached::new(frame, world, radius, starts), cells }
    }

    /// Where the cells lie.
    pub(super) const fn frame(&self) -> &Frame {
        &self.reached.frame
    }

    /// The cells to which a drone's body can come.
    pub(super) fn reached(&self) -> impl Iterator<Item = Cell> {
        self.reached.cells()
    }

    /// The cells of rock beside which a drone's body can be: those that lie within two cells of one to
    /// which it can come.
    pub(super) fn walls(&self) -> impl Iterator<Item = Cell> {
        let frame = self.reached.frame;
        let is_rock = move |cell: &Cell| !self.cells[frame.number(*cell)].is_free;
        let rock = frame.cells().filter(is_rock);
        rock.filter(move |cell| near(frame, *cell, 2).any(|near| self.reached.holds(near)))
    }

    /// Whether a cell lies in the free space, and no wall is near.
    pub(super) fn is_open(&self, cell: Cell) -> bool {
        let TrueCell { is_free, is_off_walls, .. } = self.cells[self.reached.frame.number(cell)];
        is_free && is_off_walls
    }

    /// Whether a cell lies in the rock, and no free space is near.
    pub(super) fn is_rock(&self, cell: Cell) -> bool {
        let TrueCell { is_free, is_off_walls, .. } = self.cells[self.reached.frame.number(cell)];
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A corridor of 0.8 m round three sides of a square of 60 m, and a room of its own that no drone
    /// comes to.
    fn is_free(at: Point2) -> bool {
        let is_within = |from: f32, to: f32, value: f32| (from..to).contains(&value);
        is_within(0.0, 60.0, at.x) && is_within(0.0, 0.8, at.y)
            || is_within(59.2, 60.0, at.x) && is_within(0.0, 60.0, at.y)
            || is_within(0.0, 60.0, at.x) && is_within(59.2, 60.0, at.y)
            || is_within(20.0, 30.0, at.x) && is_within(20.0, 30.0, at.y)
    }

    /// Each cell of an area of 100 by 100 m had been asked for its walls: a million, where drones come to
    /// fifteen thousand.
    #[test]
    fn cells_far_from_where_drones_come_are_not_asked_about() {
        let area = (Point2::new(0.0, 0.0), (Metres(100.0), Metres(100.0)));
        let start = Point2::new(1.0, 0.4);
        let frame = frame_about(area, &[start]).unwrap();
        let mut asked = 0;
        let reached = Reached::by(frame, &[start], |at| {
            asked += 1;
            is_free(at)
        });
        let room = |at: Point2| (20.0..30.0).contains(&at.x) && (20.0..30.0).contains(&at.y);
        let expected = frame.cells().filter(|cell| {
            let at = frame.centre(*cell);
            is_free(at) && !room(at)
        });
        let (found, expected): (Vec<Cell>, Vec<Cell>) =
            (reached.cells().collect(), expected.collect());
        assert_eq!(found, expected);
        assert!(asked <= 2 * found.len(), "{asked} of {} cells", frame.cell_count());
    }
}
