//! Computes the true strength of a link between two places of the skeleton.
//!
//! Equation (19) takes the distance along the tunnel, which is the geodesic distance of the two
//! places, and counts walls on the straight line between their points. The attenuation exponent is
//! tabulated once for all pairs of places, 0.1 m apart on every edge; between them a continuous
//! model is interpolated, a wall count is taken from the nearest pair. The table holds the exponent
//! and not the loss, because the logarithm of the distance is too steep to interpolate and can be
//! computed exactly.
//!
//! The table takes 400 bytes times the square of the skeleton's length in metres: 0.4 MB for 30 m,
//! and 100 MB for the 500 m that all galleries of a scenario may have together.
//!
//! Walls of paper need no table: they do not attenuate, and the distance is the straight line.
//! Between walls that leak the distance is the straight line, too, and the table holds what a wave
//! loses on its way through them, in decibels; it is interpolated, so that the loss of a wall sets
//! in over 0.1 m.

use radio_model::{Attenuation, Obstruction, PathLoss};
use units::{Db, Dbm, Point2};

use super::{Skeleton, SkeletonPlace, Tunnel};

/// The way in which walls attenuate the radio.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Walls {
    /// Waves follow the tunnel, and the exponent grows with the rock on the straight line.
    #[default]
    Rock,
    /// Waves go straight through, as in the circuit of section V-B.
    Paper,
    /// Waves go straight through, with a loss for every wall and every metre of it.
    Leaky,
}

/// The radio in one tunnel.
pub struct Radio {
    law: PathLoss,
    walls: Walls,
    skeleton: Skeleton,
    table: Table,
}

impl Radio {
    /// The distance between tabulated places, in metres.
    pub const STEP: f32 = 0.1;

    /// Computes the table for a tunnel.
    #[must_use]
    pub fn survey(tunnel: &Tunnel, law: PathLoss, walls: Walls) -> Self {
        let skeleton = tunnel.skeleton().clone();
        let table = match walls {
            Walls::Rock => Table::survey(tunnel, |between| law.exponent(between)),
            Walls::Leaky => Table::survey(tunnel, |between| between.leak().0),
            Walls::Paper => Table::default(),
        };
        Self { law, walls, skeleton, table }
    }

    /// The strength of a link between two places, without noise.
    #[must_use]
    pub fn strength(&self, a: SkeletonPlace, b: SkeletonPlace) -> Dbm {
        self.strength_at(&self.survey_place(a), &self.survey_place(b))
    }

    /// Returns a place together with its index in the table, which saves a search for each of the
    /// place's links.
    #[must_use]
    pub fn survey_place(&self, place: SkeletonPlace) -> SurveyedPlace {
        let index = match self.walls {
            Walls::Paper => Index::default(),
            Walls::Rock | Walls::Leaky => self.table.index(place),
        };
        SurveyedPlace { place, index }
    }

    /// The strength of a link between two surveyed places, without noise.
    #[must_use]
    pub fn strength_at(&self, a: &SurveyedPlace, b: &SurveyedPlace) -> Dbm {
        let loss = match self.walls {
            Walls::Paper => {
                let distance = self.skeleton.at(a.place).0.distance(self.skeleton.at(b.place).0);
                self.law.loss(distance, Obstruction::NONE)
            }
            Walls::Leaky => {
                let distance = self.skeleton.at(a.place).0.distance(self.skeleton.at(b.place).0);
                let through = self.interpolated(a.index, b.index);
                self.law.loss(distance, Obstruction::NONE) + Db(through)
            }
            Walls::Rock => {
                let distance = self.skeleton.distance(a.place, b.place);
                self.law.loss_with_exponent(distance, self.exponent(a.index, b.index))
            }
        };
        Dbm::after_loss(loss)
    }

    /// The strength of a link between two points of the floor plan, each of which counts as the
    /// place of the skeleton nearest to it.
    #[must_use]
    pub fn strength_between(&self, a: Point2, b: Point2) -> Dbm {
        self.strength(self.skeleton.locate(a), self.skeleton.locate(b))
    }

    fn exponent(&self, row: Index, column: Index) -> f32 {
        match self.law.attenuation {
            Attenuation::WallCount => self.table.at(row.nearest, column.nearest),
            Attenuation::RockDepth => self.interpolated(row, column),
        }
    }

    fn interpolated(&self, row: Index, column: Index) -> f32 {
        let mix = |f: f32, a: f32, b: f32| a + f * (b - a);
        let across = |r: usize| {
            let (near, far) = (self.table.at(r, column.before), self.table.at(r, column.after));
            mix(column.part, near, far)
        };
        mix(row.part, across(row.before), across(row.after))
    }
}

/// A place of the skeleton, with its index in the radio's table.
#[derive(Clone, Copy, Debug)]
pub struct SurveyedPlace {
    /// The place.
    pub place: SkeletonPlace,
    index: Index,
}

/// The exponents α of equation (19), or the losses through walls that leak, for all pairs of
/// tabulated places.
#[derive(Default)]
struct Table {
    /// The indices at which each edge's places begin, and the one at which the last edge's end.
    starts: Vec<usize>,
    /// How many places there are.
    places: usize,
    /// Row-major.
    values: Vec<f32>,
}

/// Between which of the tabulated places a place lies.
#[derive(Clone, Copy, Debug, Default)]
struct Index {
    before: usize,
    after: usize,
    /// The place between the two, as a part from 0 to 1.
    part: f32,
    /// The nearer of the two.
    nearest: usize,
}

impl Table {
    fn survey(tunnel: &Tunnel, of: impl Fn(Obstruction) -> f32) -> Self {
        let mut starts = vec![0];
        let mut points = Vec::new();
        for edge in tunnel.skeleton().edges() {
            let count = (edge.line().length() / Radio::STEP) as usize + 2;
            points.extend((0..count).map(|n| edge.line().at(n as f32 * Radio::STEP).0));
            starts.push(points.len());
        }
        let places = points.len();
        let mut values = vec![of(Obstruction::NONE); places * places];
        for row in 0..places {
            for column in 0..row {
                let value = of(tunnel.obstruction(points[row], points[column]));
                values[row * places + column] = value;
                values[column * places + row] = value;
            }
        }
        Self { starts, places, values }
    }

    fn index(&self, place: SkeletonPlace) -> Index {
        let edge = usize::from(place.edge).min(self.starts.len() - 2);
        let (first, last) = (self.starts[edge], self.starts[edge + 1] - 1);
        let steps = (place.along / Radio::STEP).clamp(0.0, (last - first) as f32);
        let before = first + steps as u32 as usize;
        Index {
            before,
            after: (before + 1).min(last),
            part: steps - (steps as u32) as f32,
            nearest: (first + (steps + 0.5) as u32 as usize).min(last),
        }
    }

    fn at(&self, row: usize, column: usize) -> f32 {
        self.values[row * self.places + column]
    }
}
