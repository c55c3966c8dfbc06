//! Computes the true strength of a link between two places of the skeleton.
//!
//! A law of the path loss takes the distance along the tunnel, which is the geodesic distance of
//! the two places, the straight line between their points, and a term for the rock on that line.
//! The term (for equation (19) of the paper: the attenuation exponent) is tabulated once for all
//! pairs of places, 0.1 m apart on every edge; between them a continuous term is interpolated, one
//! that jumps is taken from the nearest pair. The table does not hold the loss itself, because the
//! logarithm of the distance is too steep to interpolate and can be computed exactly.
//!
//! The table is computed where it is first needed, and takes at most 200 bytes times the square of
//! the length in metres of what the drones fly in: 0.2 MB for 30 m, and 18 MB for the 300 m of the
//! longest route of a map. A law that ignores walls needs no table.
//!
//! Shadowing and fading belong to the places of both ends. They are the same in both directions:
//! the end that is earlier on the skeleton comes first.

mod section;
mod table;

use std::sync::Arc;

use radio_model::{Fading, Geometry, Obstruction, PathLoss, Shadowing, WAVELENGTH, WaveDraws};
use random::{Purpose, Stream};
use units::{Db, Dbm, Metres, Point2};

use super::{Skeleton, SkeletonPlace, Spot, Tunnel};
use table::{Index, Table};

pub use section::{AntennaTable, FadingTable, ModelTable, ShadowingTable};

/// What a scenario says of the radio in a place.
#[derive(Clone, Debug)]
pub struct RadioPlace {
    /// Large-scale loss.
    pub path_loss: PathLoss,
    /// The standard deviation and the decorrelation distance of shadowing.
    pub shadowing: Option<(Db, Metres)>,
    /// The factor K of small-scale fading.
    pub fading_k: Option<f32>,
    /// The seed of the fields of shadowing and fading, which are a property of the place and not
    /// of the mission.
    pub seed: u64,
}

/// What is known of the radio in a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Known {
    /// The law of the path loss.
    Law,
    /// The law and the shadows: the mean over the fades, which are a few centimetres long.
    Shadows,
    /// The law, the shadows and the fades.
    All,
}

/// The radio in one tunnel.
pub struct Radio {
    law: PathLoss,
    shadowing: Option<Shadowing>,
    fading: Option<Fading>,
    tunnel: Arc<Tunnel>,
    /// `None` for a law that ignores walls.
    table: Option<Table>,
}

impl Radio {
    /// The distance between tabulated places, in metres.
    pub const STEP: f32 = 0.1;

    /// The radio in a tunnel, with the shadowing and the fading of the place.
    #[must_use]
    pub fn of(tunnel: &Arc<Tunnel>, place: &RadioPlace) -> Self {
        let mut field = Stream::new(place.seed, Purpose::Place);
        let mut draw = || -> WaveDraws { std::array::from_fn(|_| field.uniform()) };
        let shadowing = place
            .shadowing
            .map(|(deviation, decorrelation)| Shadowing::new(deviation, decorrelation, &mut draw));
        let wavelength = Metres(WAVELENGTH);
        let fading = place.fading_k.map(|k| Fading::new(k, wavelength, &mut draw));
        Self { shadowing, fading, ..Self::survey(tunnel, place.path_loss) }
    }

    /// The radio in a tunnel without shadowing and fading.
    #[must_use]
    pub fn survey(tunnel: &Arc<Tunnel>, law: PathLoss) -> Self {
        let table = (!law.ignores_walls()).then(|| Table::of(tunnel, law));
        Self { law, shadowing: None, fading: None, tunnel: Arc::clone(tunnel), table }
    }

    fn skeleton(&self) -> &Skeleton {
        self.tunnel.skeleton()
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
        self.survey_spot(Spot::on(self.skeleton(), place))
    }

    /// Returns a point and its place, as [`survey_place`](Self::survey_place) does.
    #[must_use]
    pub fn survey_spot(&self, spot: Spot) -> SurveyedPlace {
        let place = spot.on;
        let index = self.table.as_ref().map_or_else(Index::default, |table| table.index(place));
        let half_width = 0.5 * self.skeleton().edge(place.edge).width().0;
        let at = self.skeleton().at(place).0;
        SurveyedPlace { place, at, index, point: spot.at, half_width }
    }

    /// The strength of a link between two places as far as it is known.
    #[must_use]
    pub fn known_strength(&self, a: SkeletonPlace, b: SkeletonPlace, known: Known) -> Dbm {
        self.known_strength_at(&self.survey_place(a), &self.survey_place(b), known)
    }

    /// Whether the place has shadows or fades.
    #[must_use]
    pub const fn has_fields(&self) -> bool {
        self.shadowing.is_some() || self.fading.is_some()
    }

    /// The strength of a link between two surveyed places, without noise.
    #[must_use]
    pub fn strength_at(&self, a: &SurveyedPlace, b: &SurveyedPlace) -> Dbm {
        self.known_strength_at(a, b, Known::All)
    }

    /// The strength of a link between two surveyed places as far as it is known.
    pub(super) fn known_strength_at(
        &self,
        a: &SurveyedPlace,
        b: &SurveyedPlace,
        known: Known,
    ) -> Dbm {
        let link = Geometry {
            along: Metres(self.skeleton().distance(a.place, b.place).0.max(a.at_least_from(b).0)),
            straight: a.at.distance(b.at),
        };
        let loss = self.law.loss(link, self.term(a.index, b.index));
        Dbm::after_loss(loss + self.place_loss(a, b, known))
    }

    /// The distance between two places along the tunnel.
    #[must_use]
    pub fn distance(&self, a: SkeletonPlace, b: SkeletonPlace) -> Metres {
        self.skeleton().distance(a, b)
    }

    /// The strength of a link between two points of the floor plan, each of which counts as its
    /// place on the skeleton.
    #[must_use]
    pub fn strength_between(&self, a: Point2, b: Point2) -> Dbm {
        self.strength(self.tunnel.place(a, None), self.tunnel.place(b, None))
    }

    /// The loss by what is known of shadowing and fading.
    fn place_loss(&self, a: &SurveyedPlace, b: &SurveyedPlace, known: Known) -> Db {
        let order = |place: SkeletonPlace| (place.edge, place.along);
        let (first, other) =
            if order(a.place) <= order(b.place) { (a.at, b.at) } else { (b.at, a.at) };
        let shadowing = self.shadowing.as_ref().filter(|_| known != Known::Law);
        let fading = self.fading.as_ref().filter(|_| known == Known::All);
        let shadow = shadowing.map_or(Db(0.0), |field| field.loss(first, other));
        let fade = fading.map_or(Db(0.0), |field| field.loss(first, other));
        shadow + fade
    }

    fn term(&self, row: Index, column: Index) -> f32 {
        match &self.table {
            None => self.law.term(Obstruction::NONE),
            Some(table) if self.law.jumps() => table.at(row.nearest, column.nearest),
            Some(table) => interpolated(table, row, column),
        }
    }
}

fn interpolated(table: &Table, row: Index, column: Index) -> f32 {
    let mix = |f: f32, a: f32, b: f32| a + f * (b - a);
    let across = |r: usize| {
        let (near, far) = (table.at(r, column.before), table.at(r, column.after));
        mix(column.part, near, far)
    };
    mix(row.part, across(row.before), across(row.after))
}

/// A place of the skeleton, with its index in the radio's table.
#[derive(Clone, Copy, Debug)]
pub struct SurveyedPlace {
    /// The place.
    pub place: SkeletonPlace,
    at: Point2,
    index: Index,
    /// The point itself, which in a hall may be far from its place.
    point: Point2,
    /// Half the width of the gallery of the place, m.
    half_width: f32,
}

impl SurveyedPlace {
    /// The point and its place.
    #[must_use]
    pub const fn spot(&self) -> Spot {
        Spot { at: self.point, on: self.place }
    }

    /// The least distance of two points along the tunnel. Within their galleries two points are no
    /// farther apart than their places and half of each width; in a hall they are.
    fn at_least_from(&self, other: &Self) -> Metres {
        Metres(self.point.distance(other.point).0 - self.half_width - other.half_width)
    }
}
