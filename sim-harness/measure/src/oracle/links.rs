//! Finds out from which places of a way a drone can bear the next one's link.

use radio_model::{Geometry, Obstruction, PathLoss};
use units::{Db, Dbm};
use world::{Known, Path, World};

use super::{APART_M, STEP_M};
use mission::Gains;
use scenario::Scenario;

/// Shadows are taken to be no larger than so many standard deviations where a link is left out
/// because of its law alone.
const DEVIATIONS: f32 = 4.0;

/// The links between all places of a way that are no weaker than the launch limit.
pub(super) struct Links {
    last: usize,
    /// For each flying drone and place, whether the base bears it there.
    base: Vec<Vec<bool>>,
    /// For each flying drone and place, the first place from which the drone behind bears it there.
    first: Vec<Vec<Option<usize>>>,
}

impl Links {
    /// The links up to the place of this number.
    pub(super) fn of(
        scenario: &Scenario,
        world: &World,
        way: &Path,
        seed: u64,
        last: usize,
    ) -> Self {
        let limit = scenario.agent.launch.limit;
        let members = scenario.drones.members();
        let gains = Gains::of(&scenario.radio, members, seed);
        let flying = members - 1;
        // The base has the largest number.
        let from_base: Vec<_> = (0..flying).map(|drone| gains.of_link(flying, drone)).collect();
        let from_next: Vec<_> = (0..flying).map(|drone| gains.of_link(drone + 1, drone)).collect();
        let most =
            from_base.iter().chain(&from_next).fold(Db(0.0), |most, gain| Db(most.0.max(gain.0)));
        let field = Field::of(scenario, world, way, last);
        let strengths = field.strengths(limit - most);
        let clear = (APART_M / STEP_M).round() as usize;
        let bears_base = |gain: &Db| {
            let bears = |row: &Vec<Dbm>| row.first().is_none_or(|one| *one + *gain >= limit);
            strengths.iter().map(bears).collect()
        };
        let first_of = |gain: &Db| {
            let first = |(place, row): (usize, &Vec<Dbm>)| {
                let places = row.iter().take((place + 1).saturating_sub(clear));
                places.enumerate().skip(1).find(|(_, one)| **one + *gain >= limit).map(|(n, _)| n)
            };
            strengths.iter().enumerate().map(first).collect()
        };
        Self {
            last,
            base: from_base.iter().map(bears_base).collect(),
            first: from_next.iter().map(first_of).collect(),
        }
    }

    /// The number of the last place.
    pub(super) const fn last(&self) -> usize {
        self.last
    }

    /// Whether the base bears this drone at a place.
    pub(super) fn bears_from_base(&self, drone: usize, place: usize) -> bool {
        self.base.get(drone).and_then(|row| row.get(place)).is_some_and(|bears| *bears)
    }

    /// The first place from which the next drone bears this one at a place.
    pub(super) fn first_that_bears(&self, drone: usize, place: usize) -> Option<usize> {
        *self.first.get(drone)?.get(place)?
    }

    /// Whether no place behind bears the head at this one.
    pub(super) fn is_out_of_all_reach(&self, place: usize) -> bool {
        !self.bears_from_base(0, place) && self.first_that_bears(0, place).is_none()
    }
}

/// The radio along a way.
struct Field<'a> {
    world: &'a World,
    law: PathLoss,
    in_sight: f32,
    /// The most by which shadows make a link stronger, dB.
    shadows: Db,
    places: Vec<world::SkeletonPlace>,
    points: Vec<units::Point2>,
}

impl<'a> Field<'a> {
    fn of(scenario: &Scenario, world: &'a World, way: &Path, last: usize) -> Self {
        let places: Vec<_> = (0..=last).map(|n| way.at(n as f32 * STEP_M)).collect();
        let points = places.iter().map(|place| world.skeleton().at(*place).0).collect();
        let law = scenario.radio.place.path_loss;
        let shadows = scenario.radio.place.shadowing;
        Self {
            world,
            law,
            in_sight: law.term(Obstruction::NONE),
            shadows: shadows.map_or(Db(0.0), |(deviation, _)| Db(DEVIATIONS * deviation.0)),
            places,
            points,
        }
    }

    /// The strengths of all links from each place to those before it; any below `limit` may be
    /// given as none at all.
    fn strengths(&self, limit: Dbm) -> Vec<Vec<Dbm>> {
        let row = |n: usize| (0..n).map(|m| self.strength(m, n, limit)).collect();
        (0..self.places.len()).map(row).collect()
    }

    fn strength(&self, one: usize, other: usize, limit: Dbm) -> Dbm {
        let (a, b) = (self.places[one], self.places[other]);
        let link = Geometry {
            along: self.world.radio.distance(a, b),
            straight: self.points[one].distance(self.points[other]),
        };
        // Rock never makes a link stronger, so that most of the table need not be made.
        if Dbm::after_loss(self.law.loss(link, self.in_sight)) + self.shadows < limit {
            return Dbm(f32::NEG_INFINITY);
        }
        self.world.radio.known_strength(a, b, Known::Shadows)
    }
}
