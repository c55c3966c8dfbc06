//! The motion patterns in which a robot looks at the surroundings of its goal.

use core::f32::consts::{PI, TAU};

use grid_map::Cell;
use units::{Metres, Point2};

use crate::ground::Ground;
use crate::network::distance;

/// The distance between two lanes of a zig-zag, and between two turns of a spiral: the distance over
/// which shadowing changes ([`RefineConfig`](crate::RefineConfig)).
const LANE: f32 = 2.0;
/// The longest leg of a random walk, m. It is a choice: half of the paper's radius.
const LEG: f32 = 5.0;
/// The most targets that are looked at in one step, all of which may lie in rock.
const MOST_TRIED: u16 = 512;

/// A motion pattern. The paper names these four and leaves the choice open (section 3.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Pattern {
    /// Lanes to and fro, from south to north.
    ZigZag,
    /// Outward, in turns around the goal.
    Spiral,
    /// Straight on to a random distance, and on in a random direction.
    RandomWalk,
    /// Along the walls, and along the edge of the area, with them to the right.
    WallFollowing,
}

impl Pattern {
    /// All patterns.
    pub const ALL: [Self; 4] = [Self::ZigZag, Self::Spiral, Self::RandomWalk, Self::WallFollowing];

    /// The name in files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ZigZag => "zig-zag",
            Self::Spiral => "spiral",
            Self::RandomWalk => "random-walk",
            Self::WallFollowing => "wall-following",
        }
    }
}

/// A robot's way in a pattern around its goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tour {
    pattern: Pattern,
    goal: Point2,
    within: f32,
    /// How many targets were tried.
    tried: u16,
    /// The direction of the robot that follows a wall: east, north, west, south.
    heading: u8,
    random: u64,
}

impl Tour {
    /// A tour that stays within a distance of the goal; `seed` is that of the random walk.
    #[must_use]
    pub const fn new(pattern: Pattern, goal: Point2, within: Metres, seed: u64) -> Self {
        let random = seed.wrapping_mul(2).wrapping_add(1);
        Self { pattern, goal, within: within.0, tried: 0, heading: 0, random }
    }

    /// The next cell to drive to, from the one where the robot is; `None` where the pattern has come to
    /// its end. A robot reaches each of these cells, and they lie within the distance of the goal.
    pub fn next<const CELLS: usize>(&mut self, ground: &Ground<CELLS>, at: Cell) -> Option<Cell> {
        match self.pattern {
            Pattern::ZigZag => self.planned(|tour, n| tour.lane_end(ground, n)),
            Pattern::Spiral => self.planned(|tour, n| {
                tour.on_spiral(n).map(|at| tour.inside(ground, ground.frame().cell_at(at)?))
            }),
            Pattern::RandomWalk => self.leg(ground, at),
            Pattern::WallFollowing => self.along_wall(ground, at),
        }
    }

    /// The next target in a list of them that a robot reaches; `target` ends the list with `None`, and
    /// leaves one out with `Some(None)`.
    fn planned(&mut self, target: impl Fn(&Self, u16) -> Option<Option<Cell>>) -> Option<Cell> {
        for _ in 0..MOST_TRIED {
            let cell = target(self, self.tried)?;
            self.tried = self.tried.saturating_add(1);
            if cell.is_some() {
                return cell;
            }
        }
        None
    }

    /// The end of a lane of the zig-zag: the reached cell that is farthest to its side.
    fn lane_end<const CELLS: usize>(&self, ground: &Ground<CELLS>, n: u16) -> Option<Option<Cell>> {
        let lane = n / 2;
        let north = f32::from(lane) * LANE - self.within;
        if north > self.within {
            return None;
        }
        let half = libm::sqrtf((self.within * self.within - north * north).max(0.0));
        let to_east = n.is_multiple_of(2) == lane.is_multiple_of(2);
        let step = ground.frame().resolution().0 * if to_east { -1.0 } else { 1.0 };
        let end = if to_east { half } else { -half };
        let count = (2.0 * half / step.abs()) as u16;
        let cells = (0..=count.min(MOST_TRIED)).filter_map(|k| {
            let east = end + f32::from(k) * step;
            let at = Point2::new(self.goal.x + east, self.goal.y + north);
            ground.frame().cell_at(at)
        });
        Some(cells.filter_map(|cell| self.inside(ground, cell)).next())
    }

    /// A point of an Archimedean spiral; the points lie as far apart as its turns.
    fn on_spiral(&self, n: u16) -> Option<Point2> {
        let angle = libm::sqrtf(2.0 * TAU * f32::from(n));
        let radius = LANE * angle / TAU;
        let (sin, cos) = (libm::sinf(angle), libm::cosf(angle));
        let at = Point2::new(self.goal.x + radius * cos, self.goal.y + radius * sin);
        (radius <= self.within).then_some(at)
    }

    /// The end of a straight leg in a random direction.
    fn leg<const CELLS: usize>(&mut self, ground: &Ground<CELLS>, at: Cell) -> Option<Cell> {
        let from = ground.frame().centre(at);
        let step = ground.frame().resolution().0;
        for _ in 0..MOST_TRIED {
            let angle = 2.0 * PI * self.draw();
            let length = LEG * self.draw();
            let (sin, cos) = (libm::sinf(angle), libm::cosf(angle));
            let count = (length / step) as u16;
            let end = (1..=count.min(MOST_TRIED))
                .map_while(|k| {
                    let far = f32::from(k) * step;
                    let to = Point2::new(from.x + far * cos, from.y + far * sin);
                    ground.frame().cell_at(to).and_then(|cell| self.inside(ground, cell))
                })
                .last();
            if end.is_some_and(|end| end != at) {
                return end;
            }
        }
        None
    }

    /// The cell beside this one to which a robot with its right hand at the wall goes on.
    fn along_wall<const CELLS: usize>(&mut self, ground: &Ground<CELLS>, at: Cell) -> Option<Cell> {
        const STEPS: [(i16, i16); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];
        let to = |heading: u8| {
            let (east, north) = STEPS.get(usize::from(heading % 4)).copied()?;
            ground.frame().beside(at, east, north).and_then(|cell| self.inside(ground, cell))
        };
        // Until it has come to a wall, the robot goes straight on.
        let is_at_wall = (0..4).any(|heading| to(heading).is_none());
        let turns: &[u8] = if self.tried == 0 && !is_at_wall { &[0] } else { &[3, 0, 1, 2] };
        let (heading, cell) = turns.iter().find_map(|turn| {
            let heading = (self.heading + turn) % 4;
            Some((heading, to(heading)?))
        })?;
        self.heading = heading;
        self.tried |= u16::from(is_at_wall);
        Some(cell)
    }

    /// The cell, if a robot reaches it and it lies within the distance.
    fn inside<const CELLS: usize>(&self, ground: &Ground<CELLS>, cell: Cell) -> Option<Cell> {
        let is_near = distance(ground.frame().centre(cell), self.goal).0 <= self.within;
        (is_near && ground.is_reached(cell)).then_some(cell)
    }

    /// A uniform number in [0, 1): xorshift64* (S. Vigna, "An experimental exploration of Marsaglia's
    /// xorshift generators, scrambled", 2016).
    fn draw(&mut self) -> f32 {
        self.random ^= self.random >> 12;
        self.random ^= self.random << 25;
        self.random ^= self.random >> 27;
        (self.random.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 40) as f32 / (1_u32 << 24) as f32
    }
}
