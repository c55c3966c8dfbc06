//! The reading of a ranger that sees a cone: it tells how far away the nearest surface in the cone is, and not in which
//! direction.
//!
//! A reading shows two things, which count differently (Moravec and Elfes, "High resolution maps from wide angle sonar",
//! 1985): *everywhere* in the cone it is free up to the distance of the reading, and *somewhere* on the arc at that
//! distance a surface is. Cells of the arc that were shown to be free are not that surface, and one that is known to be
//! occupied explains the reading. A ray through the middle of the cone, as [`GridMap::trace`] takes, draws a wall across a
//! door that is narrower than the cone.

use core::f32::consts::FRAC_1_SQRT_2;

use units::Point2;

use crate::area::Area;
use crate::frame::Frame;
use crate::map::{CellState, Evidence, GridMap, RayEnd};

/// The half angles of a cone, as tangents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Every surface within this half angle gives a reading.
    pub sure: f32,
    /// No surface beyond this half angle does.
    pub whole: f32,
}

/// What a sensor tells of the space between itself and a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// The point on the middle of the beam at the distance that the sensor tells.
    pub to: Point2,
    /// What is at that distance.
    pub end: RayEnd,
    /// The cone that the sensor sees; `None` for a ray.
    pub cone: Option<Cone>,
    /// On which side of the cone the surface is.
    pub side: Side,
}

impl Beam {
    /// A ray to a point.
    #[must_use]
    pub const fn ray(to: Point2, end: RayEnd) -> Self {
        Self { to, end, cone: None, side: Side::Unknown }
    }
}

/// On which side of a cone a surface is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// The readings do not tell.
    #[default]
    Unknown,
    /// The surface is near the left edge.
    Left,
    /// The surface is near the right edge.
    Right,
}

/// Samples of an arc to a cell's side, and the most to each side of the middle of an arc that is drawn.
const SAMPLES_A_CELL: f32 = 2.0;
const MOST_SAMPLES: u16 = (SAMPLES_A_CELL * WIDEST_CELLS) as u16;
/// A cell whose middle is less than so many cells nearer than the surface may be a part of it. Our own number: half a cell
/// would do for readings and places without errors.
const MARGIN_CELLS: f32 = 0.75;
/// A surface is not drawn where half of the arc on which it may be has more cells: the robot has to come nearer. Our own
/// number: with 3.5 drones of the simulator drew 0.9 % of the walls where there are none, and with 2.5 they drew 0.3 %.
const WIDEST_CELLS: f32 = 2.5;
/// The unknown cells behind a surface that count as a part of it: walls are not thinner. Our own number.
const BEHIND: u8 = 2;

impl<const BYTES: usize> GridMap<BYTES> {
    /// Takes in what a sensor at `from` tells. Outside the grid it does nothing; a beam that is longer than the grid, or not
    /// finite, neither. Returns the smallest rectangle with all cells whose state is another one than before.
    pub fn sense(&mut self, from: Point2, beam: &Beam) -> Option<Area> {
        let Some(cone) = beam.cone else { return self.trace(from, beam.to, beam.end) };
        let sector = Sector::new(self.frame(), from, beam.to, cone)?;
        let freed = self.free(&sector);
        let struck = match beam.end {
            RayEnd::Obstacle if sector.is_narrow() => self.strike(&sector, beam.side),
            RayEnd::Obstacle | RayEnd::Clear => None,
        };
        [freed, struck].into_iter().flatten().reduce(Area::and)
    }

    /// Shows the cells of a sector to be free.
    fn free(&mut self, sector: &Sector) -> Option<Area> {
        let frame = *self.frame();
        let mut changed = None;
        for cell in sector.around(&frame)?.cells() {
            if sector.holds(frame.centre(cell)) && self.weigh(cell, Evidence::PASSED) {
                changed = Some(Area::of(cell).and_maybe(changed));
            }
        }
        changed
    }

    /// Shows a surface on the arc at the end of a sector.
    fn strike(&mut self, sector: &Sector, side: Side) -> Option<Area> {
        let frame = *self.frame();
        let (slope, evidence) = self.surface(sector, side);
        let cell_of_length = sector.resolution / sector.length;
        let mut changed = None;
        for cells in 0..=BEHIND {
            let point = sector.point(1.0 + f32::from(cells) * cell_of_length, slope);
            let Some(cell) = frame.cell_at(point) else { break };
            let (counts, evidence) = match cells {
                0 => (true, evidence),
                _ => (self.state(cell) == CellState::Unknown, Evidence::DOUBTED),
            };
            if counts && self.weigh(cell, evidence) {
                changed = Some(Area::of(cell).and_maybe(changed));
            }
        }
        changed
    }

    /// At which slope of the arc the surface is, and how much the reading shows of that.
    fn surface(&self, sector: &Sector, side: Side) -> (f32, Evidence) {
        let may_be = |&slope: &f32| self.state_at(sector, slope) != Some(CellState::Free);
        match sector.cone.edge(side).filter(may_be) {
            Some(edge) => (edge, Evidence::DOUBTED),
            None => self.suspects(sector).surface(may_be(&0.0)),
        }
    }

    /// The state of the cell at a slope of an arc.
    fn state_at(&self, sector: &Sector, slope: f32) -> Option<CellState> {
        self.frame().cell_at(sector.point(1.0, slope)).map(|cell| self.state(cell))
    }

    /// The cells of an arc that were not shown to be free.
    fn suspects(&self, sector: &Sector) -> Suspects {
        let mut suspects = Suspects::default();
        for slope in sector.slopes() {
            match self.state_at(sector, slope) {
                Some(CellState::Occupied) => {
                    suspects.occupied = suspects.occupied.or(Some(slope));
                }
                Some(CellState::Unknown) => {
                    let [right, left] = &mut suspects.unknown;
                    let side = if slope < 0.0 { right } else { left };
                    *side = (side.0 + slope, side.1 + 1);
                }
                Some(CellState::Free) | None => {}
            }
        }
        suspects
    }
}

impl Cone {
    /// The slope at which a surface near an edge is: half of the way between where all give a reading and none does.
    fn edge(self, side: Side) -> Option<f32> {
        let edge = 0.5 * (self.sure + self.whole);
        match side {
            Side::Unknown => None,
            Side::Left => Some(edge),
            Side::Right => Some(-edge),
        }
    }
}

/// The cells of an arc that were not shown to be free, one of which the surface is.
#[derive(Clone, Copy, Debug, Default)]
struct Suspects {
    /// The slope nearest to the middle at which a cell is occupied.
    occupied: Option<f32>,
    /// The sum and the number of the slopes at which cells are unknown, to the right of the middle and to its left.
    unknown: [(f32, u16); 2],
}

impl Suspects {
    /// At which slope the surface is, and how much the reading shows of that: where a wall is known, which explains the
    /// reading, then in the middle, where it may be there, and then among the unknown cells of a side.
    fn surface(&self, may_be_in_the_middle: bool) -> (f32, Evidence) {
        let [right, left] = self.unknown;
        let (sum, count) = if left.1 > right.1 { left } else { right };
        match self.occupied {
            Some(slope) => (slope, Evidence::DOUBTED),
            None if may_be_in_the_middle => (0.0, Evidence::DOUBTED),
            None if count > 0 => (sum / f32::from(count), Evidence::DOUBTED),
            // What was shown to be free is not: a surface was not seen, or has come.
            None => (0.0, Evidence::STRUCK),
        }
    }
}

/// The part of a cone that is nearer than the surface.
#[derive(Clone, Copy, Debug)]
struct Sector {
    from: Point2,
    /// The way along the middle, from the sensor to the surface, m.
    way: [f32; 2],
    length: f32,
    cone: Cone,
    resolution: f32,
}

impl Sector {
    /// The sector of a reading; `None` where it begins outside the grid, or is longer than the grid.
    fn new(frame: &Frame, from: Point2, to: Point2, cone: Cone) -> Option<Self> {
        let way = [to.x - from.x, to.y - from.y];
        let (length, resolution) = (from.distance(to).0, frame.resolution().0);
        let most = f32::from(frame.columns().max(frame.rows())) * resolution;
        let is_sound = length > 0.0 && length <= most && frame.cell_at(from).is_some();
        is_sound.then_some(Self { from, way, length, cone, resolution })
    }

    /// Whether the arc at the end is short enough for a surface on it to be drawn.
    fn is_narrow(&self) -> bool {
        self.cone.whole * self.length <= WIDEST_CELLS * self.resolution
    }

    /// The point at a part of the length, at a slope to the left of the middle. The factor is the cosine of the angle, to
    /// its second order.
    fn point(&self, part: f32, slope: f32) -> Point2 {
        let [x, y] = self.way;
        let scale = part * (1.0 - 0.5 * slope * slope);
        Point2::new(self.from.x + scale * (x - slope * y), self.from.y + scale * (y + slope * x))
    }

    /// Slopes of the arc, half a cell apart, from the middle outwards to both sides.
    fn slopes(&self) -> impl Iterator<Item = f32> + use<> {
        let (step, whole) = (self.resolution / (SAMPLES_A_CELL * self.length), self.cone.whole);
        let slopes = (0..=MOST_SAMPLES).map(move |n| f32::from(n) * step);
        let slopes = slopes.take_while(move |slope| *slope <= whole);
        slopes.flat_map(|slope| [Some(slope), (slope > 0.0).then_some(-slope)]).flatten()
    }

    /// A rectangle with all cells of the sector.
    fn around(&self, frame: &Frame) -> Option<Area> {
        let [left, right] = [self.cone.sure, -self.cone.sure].map(|slope| self.point(1.0, slope));
        let corners = [self.from, self.point(1.0, 0.0), left, right];
        corners.into_iter().map(|at| Area::of(frame.nearest(at))).reduce(Area::and)
    }

    /// Whether the middle of a cell lies in the sector and before the surface, or the middle of the beam leads through
    /// the cell there.
    fn holds(&self, cell: Point2) -> bool {
        let [x, y] = self.way;
        let [east, north] = [cell.x - self.from.x, cell.y - self.from.y];
        // All in parts of the length.
        let square = self.length * self.length;
        let along = (east * x + north * y) / square;
        let across = (north * x - east * y) / square;
        let off = if across < 0.0 { -across } else { across };
        let side = self.resolution / self.length;
        let is_before = along < 1.0 - MARGIN_CELLS * side && along > -0.5 * side;
        is_before && (off <= self.cone.sure * along || off <= 0.5 * FRAC_1_SQRT_2 * side)
    }
}
