//! The place that the robots explore: a plan of free cells and walls.

use frontier::Tile;
use grid_map::{Cell, Frame, FrameError};
use robot_maps::{Cell as MapCell, Occupancy};
use units::{Metres, Point2};

/// The cells of a side of the built-in plans.
const SIDE: u16 = 80;
const RESOLUTION: Metres = Metres(0.1);
/// The thesis' room: 8 by 8 m about the origin.
const EDGE: f32 = -4.0;
/// Cells around a robot that must be free where it starts: 0.3 m.
const ROOM: i16 = 3;
/// How far a robot sees (thesis, table 3.1).
pub(crate) const REACH: Metres = Metres(4.0);
/// Of the cells that a robot can be in, each so many-th stands for those around it where what can
/// be seen is computed.
const EVERY: u16 = 2;
const BEARINGS: u16 = 240;
/// The longest side of a place, in cells: robots tell each other tiles of three cells.
const LONGEST: u16 = 3 * Tile::MOST;
/// The most cells of a place: those of `Atlas1024`.
const MOST_CELLS: u32 = 1024 * 1024;

/// A rectangle of wall: west, south, east and north, in cells, all included.
type Wall = [u16; 4];

const ROOMS: &[Wall] = &[
    [25, 0, 26, 12],
    [25, 22, 26, 50],
    [25, 60, 26, 79],
    [53, 0, 54, 25],
    [53, 35, 54, 79],
    [0, 30, 10, 31],
    [20, 30, 25, 31],
    [54, 50, 60, 51],
    [70, 50, 79, 51],
];
const MAZE: &[Wall] = &[[14, 0, 15, 62], [30, 16, 31, 79], [62, 0, 63, 62], [46, 50, 62, 51]];
const LOOP: &[Wall] = &[[16, 16, 36, 22], [16, 22, 22, 64], [22, 58, 64, 64], [58, 16, 64, 58]];
const PILLARS: &[Wall] = &[
    [12, 12, 16, 16],
    [34, 10, 38, 14],
    [58, 14, 62, 18],
    [20, 34, 24, 38],
    [44, 32, 48, 36],
    [66, 38, 70, 42],
    [10, 56, 14, 60],
    [32, 60, 36, 64],
    [56, 58, 60, 62],
];

/// The built-in plans: the thesis' empty room, and four of our own, of the same size.
pub const PLANS: [(&str, &[Wall]); 5] =
    [("room", &[]), ("rooms", ROOMS), ("maze", MAZE), ("loop", LOOP), ("pillars", PILLARS)];

/// A place to explore.
#[derive(Clone, Debug)]
pub struct World {
    /// The name.
    pub name: String,
    frame: Frame,
    is_wall: Vec<bool>,
    /// What a robot can see from some place that it can reach.
    is_visible: Vec<bool>,
    starts: Vec<Point2>,
}

impl World {
    /// The built-in plan of that name.
    #[must_use]
    pub fn plan(name: &str) -> Option<Self> {
        let (name, walls) = PLANS.iter().find(|(plan, _)| *plan == name)?;
        let origin = Point2::new(EDGE, EDGE);
        let frame = Frame::new(origin, RESOLUTION, SIDE, SIDE).ok()?;
        let is_wall = |cell: Cell| {
            let (x, y) = (cell.column, cell.row);
            let is_outer = x == 0 || y == 0 || x >= SIDE - 1 || y >= SIDE - 1;
            is_outer
                || walls.iter().any(|&[w, s, e, n]| (w..=e).contains(&x) && (s..=n).contains(&y))
        };
        // The thesis' starts for three, and three more.
        let starts = [[1.0, 1.0], [1.0, -1.0], [1.0, -3.0], [-0.5, 3.0], [-0.5, 1.0], [-0.5, -3.0]];
        let starts = starts.map(|[x, y]| Point2::new(x, y)).to_vec();
        Some(Self::new(name, frame, frame.cells().map(is_wall).collect(), starts))
    }

    /// The place of an occupancy map, brought to cells of 0.1 m, in which the robots start side by side
    /// about `start`, or where the map is widest. What the map does not know counts as wall.
    ///
    /// # Errors
    /// One line says why robots cannot fly there.
    pub fn of_map(name: &str, map: &Occupancy, start: Option<Point2>) -> Result<Self, String> {
        let (columns, rows) = (cells_along(map, map.columns()), cells_along(map, map.rows()));
        if columns.max(rows) > f64::from(LONGEST) || columns * rows > f64::from(MOST_CELLS) {
            return Err(too_large(map));
        }
        // A map that lies turned is explored as it is drawn.
        let origin = Point2::new(map.origin[0] as f32, map.origin[1] as f32);
        let frame = Frame::new(origin, RESOLUTION, columns as u16, rows as u16)
            .map_err(|error: FrameError| format!("the map has no place: {error}"))?;
        let is_wall: Vec<bool> = frame.cells().map(|cell| !is_free(map, cell)).collect();
        let world = Self::new(name, frame, is_wall, Vec::new());
        let middle = start.or_else(|| world.widest());
        let starts: Vec<Point2> = middle.map_or_else(Vec::new, |at| world.starts_about(at));
        if starts.is_empty() {
            return Err(match start {
                Some(at) => format!(
                    "the start at {:.2}, {:.2} has no free cells around it; give another",
                    at.x, at.y
                ),
                None => "the map has no free place in which a robot has room".to_owned(),
            });
        }
        Ok(Self::new(name, frame, world.is_wall, starts))
    }

    fn new(name: &str, frame: Frame, is_wall: Vec<bool>, starts: Vec<Point2>) -> Self {
        let is_visible = vec![false; is_wall.len()];
        let mut world = Self { name: name.to_owned(), frame, is_wall, is_visible, starts };
        world.starts = world.starts.iter().map(|&at| world.nearest_with_room(at)).collect();
        world.is_visible = world.visible();
        world
    }

    /// Where the cells lie.
    #[must_use]
    pub const fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Where robots start, the first of them first.
    #[must_use]
    pub fn starts(&self) -> &[Point2] {
        &self.starts
    }

    /// Whether a cell is wall; beyond the plan all is.
    #[must_use]
    pub fn is_wall(&self, cell: Cell) -> bool {
        !self.frame.contains(cell) || self.is_wall[self.frame.number(cell)]
    }

    /// Whether a robot can see a cell from some place that it can reach.
    #[must_use]
    pub fn is_visible(&self, cell: Cell) -> bool {
        self.frame.contains(cell) && self.is_visible[self.frame.number(cell)]
    }

    /// The free cells that a robot can see from some place that it can reach.
    #[must_use]
    pub fn visible_cells(&self) -> usize {
        self.is_visible.iter().filter(|visible| **visible).count()
    }

    /// Whether a robot has room in a cell.
    #[must_use]
    pub fn has_room(&self, cell: Cell) -> bool {
        let around =
            |room: i16| (-room..=room).flat_map(move |e| (-room..=room).map(move |n| (e, n)));
        around(ROOM).filter(|(e, n)| e * e + n * n <= ROOM * ROOM).all(|(east, north)| {
            self.frame.beside(cell, east, north).is_some_and(|cell| !self.is_wall(cell))
        })
    }

    /// Whether a disc of this radius touches a wall.
    #[must_use]
    pub fn is_touched(&self, middle: Point2, radius: Metres) -> bool {
        let half = 0.5 * self.frame.resolution().0;
        let reach = (radius.0 / self.frame.resolution().0).ceil() as i16;
        let Some(own) = self.frame.cell_at(middle) else { return true };
        let off = |from: f32, to: f32| ((from - to).abs() - half).max(0.0);
        let mut offsets = (-reach..=reach).flat_map(|e| (-reach..=reach).map(move |n| (e, n)));
        offsets.any(|(east, north)| match self.frame.beside(own, east, north) {
            Some(cell) if !self.is_wall(cell) => false,
            Some(cell) => {
                let centre = self.frame.centre(cell);
                off(middle.x, centre.x).hypot(off(middle.y, centre.y)) < radius.0
            }
            // The cells beyond the plan are wall; a disc that comes as far lies in its outermost ones.
            None => false,
        })
    }

    /// Where a ray ends, and whether at a wall: in the wall's cell.
    pub(crate) fn ray(&self, from: Point2, bearing: f32, reach: Metres) -> (Point2, bool) {
        let (sin, cos) = bearing.sin_cos();
        let at = |s: f32| Point2::new(from.x + s * cos, from.y + s * sin);
        let end = at(reach.0);
        let Some(wall) = self.frame.line(from, end).find(|&cell| self.is_wall(cell)) else {
            return (end, false);
        };
        // The middle of the part of the ray that lies in the cell.
        let (centre, half) = (self.frame.centre(wall), self.frame.resolution().0 / 2.0);
        let span = |from: f32, slope: f32, centre: f32| {
            let (a, b) = ((centre - half - from) / slope, (centre + half - from) / slope);
            if slope.abs() < 1e-6 { (0.0, reach.0) } else { (a.min(b), a.max(b)) }
        };
        let (x, y) = (span(from.x, cos, centre.x), span(from.y, sin, centre.y));
        (at((x.0.max(y.0) + x.1.min(y.1)) / 2.0), true)
    }

    /// The rock on the straight line between two points: the number of bodies, and their length.
    pub(crate) fn rock_between(&self, a: Point2, b: Point2) -> (u8, Metres) {
        let (mut bodies, mut cells, mut all, mut was_wall) = (0_u8, 0_u16, 0_u16, false);
        for cell in self.frame.line(a, b) {
            let is_wall = self.is_wall(cell);
            bodies = bodies.saturating_add(u8::from(is_wall && !was_wall));
            cells += u16::from(is_wall);
            all += 1;
            was_wall = is_wall;
        }
        (bodies, Metres(a.distance(b).0 * f32::from(cells) / f32::from(all.max(1))))
    }

    /// The cells in which a robot has room that it can reach from the starts.
    fn reachable(&self) -> Vec<bool> {
        let mut reached = vec![false; self.is_wall.len()];
        let start = self.starts.iter().filter_map(|&at| self.frame.cell_at(at));
        let mut open: Vec<Cell> = start.filter(|&cell| self.has_room(cell)).collect();
        while let Some(cell) = open.pop() {
            if !std::mem::replace(&mut reached[self.frame.number(cell)], true) {
                open.extend(self.frame.sides(cell).filter(|&next| self.has_room(next)));
            }
        }
        reached
    }

    fn visible(&self) -> Vec<bool> {
        let reachable = self.reachable();
        let mut visible = vec![false; self.is_wall.len()];
        let is_sample =
            |cell: &Cell| cell.row.is_multiple_of(EVERY) && cell.column.is_multiple_of(EVERY);
        for cell in self.frame.cells().filter(is_sample) {
            if !reachable[self.frame.number(cell)] {
                continue;
            }
            let from = self.frame.centre(cell);
            for n in 0..BEARINGS {
                let bearing = f32::from(n) / f32::from(BEARINGS) * std::f32::consts::TAU;
                let (sin, cos) = bearing.sin_cos();
                let end = Point2::new(from.x + REACH.0 * cos, from.y + REACH.0 * sin);
                for seen in self.frame.line(from, end).take_while(|&cell| !self.is_wall(cell)) {
                    visible[self.frame.number(seen)] = true;
                }
            }
        }
        visible
    }

    /// The middle of the cell nearest to a point in which a robot has room, or else the point.
    fn nearest_with_room(&self, point: Point2) -> Point2 {
        if self.frame.cell_at(point).is_some_and(|cell| self.has_room(cell)) {
            return point;
        }
        let places = self.frame.cells().filter(|&cell| self.has_room(cell));
        let off = |at: &Point2| at.distance(point).0;
        let centres = places.map(|cell| self.frame.centre(cell));
        centres.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(point)
    }

    /// The cell farthest from walls.
    fn widest(&self) -> Option<Point2> {
        let mut clearance = vec![0_u16; self.is_wall.len()];
        let step = |clearance: &[u16], cell, sides: [(i16, i16); 2]| {
            let beside = |(e, n)| {
                let cell = self.frame.beside(cell, e, n);
                cell.map_or(0, |cell| clearance[self.frame.number(cell)])
            };
            sides.map(beside).into_iter().min().unwrap_or(0).saturating_add(1)
        };
        let cells: Vec<Cell> = self.frame.cells().collect();
        for &cell in cells.iter().filter(|&&cell| !self.is_wall(cell)) {
            clearance[self.frame.number(cell)] = step(&clearance, cell, [(-1, 0), (0, -1)]);
        }
        for &cell in cells.iter().rev().filter(|&&cell| !self.is_wall(cell)) {
            let back = step(&clearance, cell, [(1, 0), (0, 1)]);
            let at = &mut clearance[self.frame.number(cell)];
            *at = back.min(*at);
        }
        let best = cells.into_iter().max_by_key(|&cell| clearance[self.frame.number(cell)])?;
        self.has_room(best).then(|| self.frame.centre(best))
    }

    /// Up to eight places with room, 0.6 m apart, nearest to a point.
    fn starts_about(&self, point: Point2) -> Vec<Point2> {
        let Some(first) = self.frame.cell_at(point).filter(|&cell| self.has_room(cell)) else {
            return Vec::new();
        };
        let mut reached = vec![false; self.is_wall.len()];
        let mut open = std::collections::VecDeque::from([first]);
        let mut starts: Vec<Point2> = Vec::new();
        while let Some(cell) = open.pop_front() {
            if std::mem::replace(&mut reached[self.frame.number(cell)], true) {
                continue;
            }
            let at = self.frame.centre(cell);
            if starts.iter().all(|other| other.distance(at).0 >= 0.6) {
                starts.push(at);
            }
            if starts.len() == crate::run::ROBOTS {
                break;
            }
            open.extend(self.frame.sides(cell).filter(|&next| self.has_room(next)));
        }
        starts
    }
}

/// The cells of this simulator along so many of a map's.
fn cells_along(map: &Occupancy, cells: usize) -> f64 {
    (cells as f64 * map.resolution_m / f64::from(RESOLUTION.0)).ceil()
}

/// Whether the part of a map under a cell is free somewhere and occupied nowhere.
fn is_free(map: &Occupancy, cell: Cell) -> bool {
    let ratio = f64::from(RESOLUTION.0) / map.resolution_m;
    // The small number keeps a border between two cells from counting to both.
    let under = |n: u16| {
        let (from, to) = (f64::from(n) * ratio + 1e-6, f64::from(n + 1) * ratio - 1e-6);
        from as usize..=to as usize
    };
    let states =
        under(cell.row).flat_map(|row| under(cell.column).map(move |column| map.cell(column, row)));
    states.clone().any(|state| state == MapCell::Free)
        && !{ states }.any(|state| state == MapCell::Occupied)
}

fn too_large(map: &Occupancy) -> String {
    let metres = |cells: usize| cells as f64 * map.resolution_m;
    format!(
        "the map is {:.0} by {:.0} m, and robots remember 10,485 m², 307 m long; cut a part of it out",
        metres(map.columns()),
        metres(map.rows())
    )
}
