//! Shortens or turns a step so that it keeps clear of drones and obstacles and cuts the swarm
//! nowhere.

use heapless::Vec;
use units::{Metres, Point2};

use crate::crossing::{FORWARD, TURNS};
use crate::geometry::{left_of, moved, squared};
use crate::member::DOWN;
use crate::team::Neighbour;
use crate::{Config, Guard, Obstacles};

/// The most drones of a swarm, which is the number of bits in a set of them.
const MOST: usize = u64::BITS as usize;

/// What one drone checks its steps against. It has at most `N` neighbours.
#[derive(Clone, Debug)]
pub(crate) struct Room<'a, const N: usize> {
    here: Point2,
    obstacles: &'a Obstacles,
    /// The square of the least distance that a step may leave to an obstacle: the guard's, or what
    /// there is where that is less.
    clearance: f32,
    others: Vec<Other, N>,
}

/// A neighbour, with what does not depend on the step.
#[derive(Clone, Copy, Debug)]
struct Other {
    position: Point2,
    /// The square of its distance,
    before: f32,
    /// of the least distance that a step may leave to it,
    least: f32,
    /// of how far it may be from there, as far as a step from too near must lead away from it even so:
    /// a step s makes the squared distance to a place that is d farther ahead longer by 2 d·s less,
    away: f32,
    /// and of the distance up to which it is surely linked.
    reach: f32,
    /// Whether the link to it must be kept.
    kept: bool,
    /// The neighbours that it is surely linked with, a bit each, and its own bit; none before they
    /// are asked for.
    linked: Option<u64>,
}

/// What the end of a step means for the links: sets of neighbours, a bit each.
struct Links {
    /// Those in range of the end.
    in_range: u64,
    /// Those whose link must be kept by a neighbour in range.
    to_relay: u64,
}

/// A drone that is too near to another one goes away from it within 45° of the straight way, however
/// little is known of where the other one is: this is the square of the cosine.
const SURELY_AWAY: f32 = 0.5;

/// The distance from a drone on the ground within which no step to a drone's own place ends, m: less than
/// the 0.35 m between the places from which drones take off, and more than the 0.25 m within which one
/// stands in another's place.
const LANDED: f32 = 0.29;

/// What is taken off the radio's range, in metres, so that rounding never cuts a link.
const ROUNDING: f32 = 1e-4;

impl<'a, const N: usize> Room<'a, N> {
    /// Returns the room around a drone at `here`. Links to drones whose progress is beyond
    /// `lets_go_beyond` need not be kept. A drone that `lands` may come nearer to those on the ground.
    pub(crate) fn around(
        (here, error): (Point2, Metres),
        config: &Config,
        guard: &Guard,
        others: impl Iterator<Item = Neighbour>,
        obstacles: &'a Obstacles,
        (lets_go_beyond, lands): (u16, bool),
    ) -> Self {
        const { assert!(N <= MOST, "a set of neighbours has 64 bits") };
        let other = |other: Neighbour| {
            let (doubt, least) = match other.progress {
                DOWN if lands => (0.0, LANDED),
                _ => {
                    let doubt = doubt(config, error, other);
                    (doubt, guard.drones.0 + doubt)
                }
            };
            let range = (config.radio_range.0 - doubt - ROUNDING).max(0.0);
            let before = squared(here, other.position);
            Other {
                position: other.position,
                before,
                least: least * least,
                away: (doubt * doubt).min(SURELY_AWAY * before),
                reach: range * range,
                kept: other.progress <= lets_go_beyond && other.progress != DOWN,
                linked: None,
            }
        };
        let others = others.take(N).map(other).collect();
        let clearance =
            (guard.obstacles.0 * guard.obstacles.0).min(obstacles.squared_clearance(here));
        Self { here, obstacles, clearance, others }
    }

    /// Returns where a drone goes that wants to go `length` along `way`: the whole step, with
    /// `turns` turned as little as need be, or else a part of it straight ahead, or nowhere.
    pub(crate) fn end(&mut self, way: Point2, length: Metres, turns: bool) -> Point2 {
        let here = self.here;
        let turns = if turns { FORWARD } else { 1 };
        let left = left_of(way);
        let whole = TURNS
            .iter()
            .take(turns)
            .map(|(cos, sin)| moved(moved(here, way, cos * length.0), left, sin * length.0));
        let parts = [0.5, 0.25].map(|part| moved(here, way, part * length.0));
        whole.chain(parts).find(|end| self.allows(*end)).unwrap_or(here)
    }

    fn allows(&mut self, end: Point2) -> bool {
        let Some(links) = self.links_if_clear(end) else { return false };
        self.linked(&links) && self.clear_of_obstacles(end)
    }

    /// Returns what `end` means for the links, if it is clear of all neighbours.
    fn links_if_clear(&self, end: Point2) -> Option<Links> {
        let mut links = Links { in_range: 0, to_relay: 0 };
        let four_steps = 4.0 * squared(self.here, end);
        let mut bit = 1;
        for other in &self.others {
            let after = squared(end, other.position);
            let farther = after - other.before;
            let is_away = farther > 0.0 && farther * farther > four_steps * other.away;
            let is_clear = after >= other.least || is_away;
            if !is_clear {
                return None;
            }
            let nearer = after < other.before;
            if after <= other.reach {
                links.in_range |= bit;
            } else if other.kept && !nearer {
                links.to_relay |= bit;
            }
            bit <<= 1;
        }
        Some(links)
    }

    fn clear_of_obstacles(&self, end: Point2) -> bool {
        self.obstacles.squared_clearance_from(end, self.clearance).is_some()
    }

    /// Says whether every neighbour is in range of the end, or in range of a neighbour that is, or
    /// comes nearer: then a swarm of which one drone moves at a time stays connected.
    fn linked(&mut self, links: &Links) -> bool {
        let mut to_relay = links.to_relay;
        while to_relay != 0 {
            let index = to_relay.trailing_zeros() as usize;
            to_relay &= to_relay - 1;
            if self.linked_with(index) & links.in_range == 0 {
                return false;
            }
        }
        true
    }

    /// Returns the neighbours that are surely linked with one of them.
    fn linked_with(&mut self, index: usize) -> u64 {
        let Some(one) = self.others.get(index).copied() else { return 0 };
        if let Some(linked) = one.linked {
            return linked;
        }
        let (mut linked, mut bit) = (0, 1);
        for relay in &self.others {
            let distance = squared(relay.position, one.position);
            if distance <= one.reach && distance <= relay.reach {
                linked |= bit;
            }
            bit <<= 1;
        }
        if let Some(one) = self.others.get_mut(index) {
            one.linked = Some(linked);
        }
        linked
    }
}

/// Returns how far another drone may be from where it was heard, as seen from this one: by the
/// errors of both positions, and by its steps since then.
fn doubt(config: &Config, error: Metres, other: Neighbour) -> f32 {
    let steps = f32::from(other.age) * config.longest_step.0;
    error.0 + other.error.0 + steps
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: Point2 = Point2::new(0.0, 0.0);
    const EAST: Point2 = Point2::new(1.0, 0.0);

    fn end(others: &[(f32, f32)], turns: bool) -> Point2 {
        end_by(0.0, others, turns)
    }

    fn end_by(error: f32, others: &[(f32, f32)], turns: bool) -> Point2 {
        let others = (0..).zip(others).map(|(number, (x, y))| Neighbour {
            number,
            position: Point2::new(*x, *y),
            error: Metres(error),
            progress: 0,
            age: 0,
        });
        let open = Obstacles::default();
        let (config, guard) = (&Config::OURS, &Guard::OURS);
        Room::<4>::around((HERE, Metres(error)), config, guard, others, &open, (u16::MAX, false))
            .end(EAST, Metres(0.1), turns)
    }

    #[test]
    fn a_step_ends_short_of_another_drone_or_goes_round_it() {
        assert_eq!(end(&[], false), Point2::new(0.1, 0.0));
        assert_eq!(end(&[(0.445, 0.0)], false), Point2::new(0.05, 0.0));
        assert_eq!(end(&[(0.391, 0.0)], false), HERE);
        assert!(end(&[(0.391, 0.0)], true).y != 0.0);
    }

    #[test]
    fn the_only_link_is_kept_and_one_that_two_replace_is_not() {
        assert_eq!(end(&[(-1.09, 0.0)], false), HERE);
        assert_eq!(end(&[(-1.09, 0.0), (-0.5, 0.5)], false), Point2::new(0.1, 0.0));
    }

    #[test]
    fn a_drone_that_is_too_near_may_go_away() {
        assert_eq!(end(&[(-0.2, 0.0)], false), Point2::new(0.1, 0.0));
    }

    #[test]
    fn a_drone_that_is_too_near_by_a_doubtful_position_goes_surely_away() {
        let beside = [(-0.05, 0.3)];
        assert_eq!(end_by(0.0, &beside, false), Point2::new(0.1, 0.0), "a little farther");
        assert_eq!(end_by(0.06, &beside, false), HERE, "or perhaps nearer");
        assert!(end_by(0.06, &beside, true).y < -0.03);
    }
}
