//! Plans of 8 by 8 m, the extent of the thesis' room, as 80 by 80 cells.

use grid_map::{Cell, Frame};
use units::{Metres, Point2};

/// The cells of a side.
pub(crate) const SIDE: u16 = 80;
const RESOLUTION: Metres = Metres(0.1);
const EDGE: f32 = -4.0;

/// A rectangle of wall: west, south, east and north, in cells, all included.
type Wall = [u16; 4];

/// A plan: the walls inside the outer one.
#[derive(Clone, Copy, Debug)]
pub struct World {
    /// The name.
    pub name: &'static str,
    walls: &'static [Wall],
}

/// The thesis' empty room, and three plans of our own.
pub const WORLDS: [World; 4] = [
    World { name: "room", walls: &[] },
    World {
        name: "rooms",
        walls: &[
            [25, 0, 26, 12],
            [25, 22, 26, 50],
            [25, 60, 26, 79],
            [53, 0, 54, 25],
            [53, 35, 54, 79],
            [0, 30, 10, 31],
            [20, 30, 25, 31],
            [54, 50, 60, 51],
            [70, 50, 79, 51],
        ],
    },
    World {
        name: "maze",
        walls: &[[14, 0, 15, 62], [30, 16, 31, 79], [62, 0, 63, 62], [46, 50, 62, 51]],
    },
    World {
        name: "loop",
        walls: &[[16, 16, 36, 22], [16, 22, 22, 64], [22, 58, 64, 64], [58, 16, 64, 58]],
    },
];

impl World {
    /// Where the cells lie.
    pub(crate) fn frame() -> Frame {
        Frame::new(Point2::new(EDGE, EDGE), RESOLUTION, SIDE, SIDE).expect("a frame of 80 cells")
    }

    /// Whether a cell is wall; beyond the plan all is.
    #[must_use]
    pub fn is_wall(&self, cell: Cell) -> bool {
        let (x, y) = (cell.column, cell.row);
        let is_outer = x == 0 || y == 0 || x >= SIDE - 1 || y >= SIDE - 1;
        let is_in = |&[w, s, e, n]: &Wall| (w..=e).contains(&x) && (s..=n).contains(&y);
        is_outer || self.walls.iter().any(is_in)
    }

    /// Where a ray ends, and whether at a wall.
    pub(crate) fn ray(&self, from: Point2, bearing: f32, reach: f32) -> (Point2, bool) {
        let frame = Self::frame();
        let at = |s: f32| Point2::new(from.x + s * bearing.cos(), from.y + s * bearing.sin());
        let steps = (reach / 0.05) as u16;
        let hit = (1..=steps)
            .map(|n| at(f32::from(n) * 0.05))
            .find(|&point| frame.cell_at(point).is_none_or(|cell| self.is_wall(cell)));
        hit.map_or_else(|| (at(reach), false), |point| (point, true))
    }

    /// The number of free cells.
    #[must_use]
    pub fn free_cells(&self) -> usize {
        Self::frame().cells().filter(|&cell| !self.is_wall(cell)).count()
    }
}
