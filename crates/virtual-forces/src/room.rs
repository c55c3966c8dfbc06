//! Shortens or turns a step so that it keeps clear of drones and obstacles and cuts the swarm
//! nowhere.

use units::{Metres, Point2};

use crate::crossing::TURNS;
use crate::geometry::{moved, squared};
use crate::team::Neighbour;
use crate::{Config, Guard, Obstacles};

/// What one drone checks its steps against.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room<'a, Others> {
    pub(crate) config: &'a Config,
    pub(crate) guard: &'a Guard,
    pub(crate) others: Others,
    pub(crate) obstacles: &'a Obstacles,
    /// The progress beyond which the links to other drones need not be kept.
    pub(crate) lets_go_beyond: u16,
    /// Whether a drone may go another way than the wanted one.
    pub(crate) turns: bool,
}

/// What is taken off the radio's range, in metres, so that rounding never cuts a link.
const ROUNDING: f32 = 1e-4;

impl<Others: Iterator<Item = Neighbour> + Clone> Room<'_, Others> {
    /// Returns where a drone at `here` goes that wants to go `length` along `way`: the whole step,
    /// turned as little as need be, or else a part of it straight ahead, or nowhere.
    pub(crate) fn end(&self, here: Point2, way: Point2, length: Metres) -> Point2 {
        let turns = if self.turns { TURNS.len() } else { 1 };
        let whole = TURNS.iter().take(turns).map(|(cos, sin)| {
            let left = Point2::new(-way.y, way.x);
            moved(moved(here, way, cos * length.0), left, sin * length.0)
        });
        let parts = [0.5, 0.25].map(|part| moved(here, way, part * length.0));
        whole.chain(parts).find(|end| self.allows(here, *end)).unwrap_or(here)
    }

    fn allows(&self, here: Point2, end: Point2) -> bool {
        self.clear_of_drones(here, end)
            && self.clear_of_obstacles(here, end)
            && self.linked(here, end)
    }

    /// Returns how far another drone may be from where it was heard, as seen from this one: by the
    /// errors of both positions, and by its steps since then.
    fn doubt(&self, other: Neighbour) -> f32 {
        let steps = f32::from(other.age) * self.config.longest_step.0;
        2.0 * self.guard.position_error.0 + steps
    }

    fn clear_of_drones(&self, here: Point2, end: Point2) -> bool {
        self.others.clone().all(|other| {
            let least = self.guard.drones.0 + self.doubt(other);
            let after = squared(end, other.position);
            after >= least * least || after > squared(here, other.position)
        })
    }

    fn clear_of_obstacles(&self, here: Point2, end: Point2) -> bool {
        let after = self.obstacles.clearance(end);
        after >= self.guard.obstacles || after > self.obstacles.clearance(here)
    }

    /// Says whether every neighbour is in range of `end`, or in range of a neighbour that is, or comes
    /// nearer: then a swarm of which one drone moves at a time stays connected.
    fn linked(&self, here: Point2, end: Point2) -> bool {
        let reach = |other: Neighbour| {
            let range = (self.config.radio_range.0 - self.doubt(other) - ROUNDING).max(0.0);
            range * range
        };
        let mut kept = self.others.clone().filter(|other| other.progress <= self.lets_go_beyond);
        kept.all(|other| {
            let after = squared(end, other.position);
            after <= reach(other)
                || after < squared(here, other.position)
                || self.others.clone().any(|relay| {
                    relay.number != other.number
                        && squared(end, relay.position) <= reach(relay)
                        && squared(relay.position, other.position) <= reach(other).min(reach(relay))
                })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: Point2 = Point2::new(0.0, 0.0);
    const EAST: Point2 = Point2::new(1.0, 0.0);

    fn end(others: &[(f32, f32)], turns: bool) -> Point2 {
        let others = (0..).zip(others).map(|(number, (x, y))| Neighbour {
            number,
            position: Point2::new(*x, *y),
            progress: 0,
            age: 0,
        });
        let open = Obstacles::default();
        let (config, guard) = (&Config::OURS, &Guard::OURS);
        let room =
            Room { config, guard, others, obstacles: &open, lets_go_beyond: u16::MAX, turns };
        room.end(HERE, EAST, Metres(0.1))
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
}
