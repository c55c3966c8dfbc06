//! Makes the worlds in which relays are put down: from a seed, or from the map of a robot.

use std::fmt;

use grid_map::{Cell, CellState, Frame, GridMap, Planner};
use relay_placement::{Ground, GroundError};
use robot_maps::Occupancy;
use units::{Metres, Point2};

use crate::cave::{Cave, MAP_BYTES, SIDE};

/// The cells of a world.
pub const CELLS: usize = SIDE as usize * SIDE as usize;
/// The smallest side of a cell, m: smaller ones of a map are put together.
const FINEST: f64 = 0.1;

/// A planner for searches in a world: an open grid of n by n cells needs room for some 16 n.
pub type WorldPlanner = Planner<{ CELLS / 2 }, { 40 * SIDE as usize }>;

/// A map of at most [`CELLS`] cells, and the place of the base in it.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    /// The name of the world.
    pub name: String,
    /// The map; its frame begins at (0, 0).
    pub map: GridMap<MAP_BYTES>,
    /// The cell of the base.
    pub base: Cell,
    /// The lower left corner of the map in the coordinates of its file, m, and its yaw, rad.
    origin: [f64; 3],
}

/// A map that makes no world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WorldError {
    /// No cell of the map is free.
    NoFreeCell,
    /// The map has free cells, but none is left where they are put together to cells of this side, m.
    NoFreeBlock(f32),
    /// The base lies outside the map; its corners are given, m.
    BaseOutside([[f64; 2]; 2]),
    /// The base lies in a cell that is not free; the nearest free one is given, m.
    BaseNotFree([f64; 2]),
    /// The cells of the map have no size that a grid can have.
    NoFrame,
}

impl fmt::Display for WorldError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoFreeCell => f.write_str("the map has no free cell"),
            Self::NoFreeBlock(side) => write!(
                f,
                "no passage is wide enough for the cells of {side:.2} m that the map is put into"
            ),
            Self::BaseOutside(_) => f.write_str("the base lies outside the map"),
            Self::BaseNotFree(_) => f.write_str("the base stands in a wall or on unknown ground"),
            Self::NoFrame => f.write_str("the cells of the map are too small or too large"),
        }
    }
}

impl WorldError {
    /// What to do about it.
    #[must_use]
    pub fn remedy(&self) -> String {
        match self {
            Self::NoFreeCell => "give the map of a place that has been seen".to_owned(),
            Self::NoFreeBlock(_) => {
                "give the map of a smaller place, or of wider passages".to_owned()
            }
            Self::BaseOutside([[west, south], [east, north]]) => {
                format!("give a point from {west:.1},{south:.1} to {east:.1},{north:.1}")
            }
            Self::BaseNotFree([x, y]) => format!("the nearest free point is {x:.2},{y:.2}"),
            Self::NoFrame => "give a map with cells of 0.01 to 10 m".to_owned(),
        }
    }
}

impl std::error::Error for WorldError {}

impl World {
    /// The cave of a seed, with the base at its entrance.
    #[must_use]
    pub fn dig(seed: u64) -> Self {
        let Cave { map, entrance } = Cave::dig(seed);
        Self { name: format!("cave-{seed}"), map, base: entrance, origin: [0.0; 3] }
    }

    /// The world of an occupancy map, with as many of its cells put together as it takes. The base
    /// stands at a point in the coordinates of the map's file, or, where none is given, on the free
    /// cell nearest to (0, 0), where the robot that made the map began.
    ///
    /// # Errors
    /// [`WorldError`].
    pub fn of(name: &str, source: &Occupancy, base: Option<[f64; 2]>) -> Result<Self, WorldError> {
        let map = coarse(source)?;
        let mut world =
            Self { name: name.to_owned(), map, base: Cell::new(0, 0), origin: source.origin };
        world.base = match base {
            Some(at) => world.base_at(source, at)?,
            None => world
                .nearest_free(world.point([0.0, 0.0]))
                .ok_or_else(|| world.no_free_cell(source))?,
        };
        Ok(world)
    }

    /// The cells that a robot reaches from the base.
    ///
    /// # Errors
    /// See [`Ground::new`].
    pub fn ground(&self, planner: &mut WorldPlanner) -> Result<Box<Ground<CELLS>>, GroundError> {
        Ground::new(&self.map, planner, self.base).map(Box::new)
    }

    /// A point of the frame in the coordinates of the map's file, m.
    #[must_use]
    pub fn in_file(&self, point: Point2) -> [f64; 2] {
        let [x, y, yaw] = self.origin;
        let (east, north) = (f64::from(point.x), f64::from(point.y));
        let (sin, cos) = yaw.sin_cos();
        [x + cos * east - sin * north, y + sin * east + cos * north]
    }

    /// A point in the coordinates of the map's file in those of the frame.
    #[must_use]
    pub fn point(&self, [x, y]: [f64; 2]) -> Point2 {
        let (dx, dy) = (x - self.origin[0], y - self.origin[1]);
        let (sin, cos) = self.origin[2].sin_cos();
        Point2::new((cos * dx + sin * dy) as f32, (cos * dy - sin * dx) as f32)
    }

    fn base_at(&self, source: &Occupancy, at: [f64; 2]) -> Result<Cell, WorldError> {
        let nearest = self.nearest_free(self.point(at));
        let nearest = nearest.ok_or_else(|| self.no_free_cell(source))?;
        let inside = self.map.frame().cell_at(self.point(at));
        let Some(cell) = inside else {
            let far = [source.columns() as f64, source.rows() as f64];
            return Err(WorldError::BaseOutside([
                source.place(0.0, 0.0),
                source.place(far[0], far[1]),
            ]));
        };
        if self.map.state(cell) == CellState::Free {
            return Ok(cell);
        }
        Err(WorldError::BaseNotFree(self.in_file(self.map.frame().centre(nearest))))
    }

    /// Why no cell of the world is free.
    fn no_free_cell(&self, source: &Occupancy) -> WorldError {
        let mut rows = 0..source.rows();
        let is_free = |column, row| source.cell(column, row) == robot_maps::Cell::Free;
        if rows.any(|row| (0..source.columns()).any(|column| is_free(column, row))) {
            return WorldError::NoFreeBlock(self.map.frame().resolution().0);
        }
        WorldError::NoFreeCell
    }

    fn nearest_free(&self, to: Point2) -> Option<Cell> {
        let frame = self.map.frame();
        let far = |cell: &Cell| {
            let at = frame.centre(*cell);
            (at.x - to.x).hypot(at.y - to.y)
        };
        let free = frame.cells().filter(|&cell| self.map.state(cell) == CellState::Free);
        free.min_by(|a, b| far(a).total_cmp(&far(b)))
    }
}

/// The map with square blocks of cells put together: a block is occupied where one of its cells is,
/// free where at least half of them are known to be, and otherwise unknown.
fn coarse(source: &Occupancy) -> Result<GridMap<MAP_BYTES>, WorldError> {
    let block = block(source);
    let blocks =
        |cells: usize| u16::try_from(cells.div_ceil(block)).map_err(|_| WorldError::NoFrame);
    let (columns, rows) = (blocks(source.columns())?, blocks(source.rows())?);
    let resolution = Metres((source.resolution_m * block as f64) as f32);
    let frame = Frame::new(Point2::new(0.0, 0.0), resolution, columns, rows)
        .map_err(|_| WorldError::NoFrame)?;
    let mut map = GridMap::new(frame).map_err(|_| WorldError::NoFrame)?;
    for cell in frame.cells() {
        map.set(cell, state_of(source, cell, block));
    }
    Ok(map)
}

/// The side of the blocks, in cells: the smallest with which the blocks have room in a world.
fn block(source: &Occupancy) -> usize {
    let (columns, rows) = (source.columns(), source.rows());
    let longest = columns.max(rows).max(1);
    let has_room = |block: &usize| {
        let blocks = |cells: usize| cells.div_ceil(*block);
        blocks(longest) <= usize::from(Frame::MOST) && blocks(columns) * blocks(rows) <= CELLS
    };
    let finest = (FINEST / source.resolution_m).ceil().clamp(1.0, longest as f64) as usize;
    (finest..longest).find(has_room).unwrap_or(longest)
}

fn state_of(source: &Occupancy, cell: Cell, block: usize) -> CellState {
    let (west, south) = (usize::from(cell.column) * block, usize::from(cell.row) * block);
    let mut free = 0;
    for row in south..south + block {
        for column in west..west + block {
            match source.cell(column, row) {
                robot_maps::Cell::Occupied => return CellState::Occupied,
                robot_maps::Cell::Free => free += 1,
                robot_maps::Cell::Unknown => {}
            }
        }
    }
    if 2 * free >= block * block { CellState::Free } else { CellState::Unknown }
}
