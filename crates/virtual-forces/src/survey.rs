//! Surveys an area in rows: the goals of each drone, when it may go on, and in which direction.

use units::{Metres, Point2};

use crate::{Config, Resultant, Wait, attraction_to_goal, between_drones};

/// What a drone hears of another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heard {
    /// Where the other drone is.
    pub position: Point2,
    /// Over how many hops it is heard; 1 is a drone in radio range itself.
    pub hops: u16,
    /// How many goals it has reached.
    pub reached: u16,
}

/// The mesh over one area, of which one corner is the origin (section 4.1 of the paper).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Survey {
    cell: Metres,
    rows: u16,
    far: Metres,
}

impl Survey {
    /// Lays rows of D_int across an area: they are stacked along x, over `length`, and run along y,
    /// over `width`. What remains of `length` beyond whole rows is not covered.
    #[must_use]
    pub fn new(config: &Config, length: Metres, width: Metres) -> Self {
        let cell = config.wanted_distance();
        // A thousandth of a row, so that rounding never loses the last one.
        let rows = libm::floorf(length.0 / cell.0 + 1e-3) as u16;
        Self { cell, rows, far: Metres((width.0 - 0.5 * cell.0).max(0.5 * cell.0)) }
    }

    /// Returns the number of rows.
    #[must_use]
    pub fn rows(&self) -> u16 {
        self.rows
    }

    /// Returns the goal number `index` of drone `place` (from 0) of `drones`, or nothing after the
    /// last one. Goals are the two ends of a row in turn. Sweep k of the swarm covers the rows from
    /// k times the number of drones on; the last sweep is shifted back onto the last rows.
    #[must_use]
    pub fn goal(&self, place: u16, drones: u16, index: u16) -> Option<Point2> {
        let drones = drones.max(1);
        let sweep = index / 2;
        if sweep >= self.rows.div_ceil(drones) {
            return None;
        }
        let last = self.rows.saturating_sub(drones);
        let row = sweep.saturating_mul(drones).min(last).saturating_add(place);
        let far = (sweep % 2 == 1) != (index % 2 == 1);
        let x = (f32::from(row) + 0.5) * self.cell.0;
        Some(Point2::new(x, if far { self.far.0 } else { 0.5 * self.cell.0 }))
    }

    /// Says whether a drone of a swarm of `drones` that has `reached` goals may set out for the next
    /// one: all for which it waits have reached as many.
    #[must_use]
    pub fn may_start(
        wait: Wait,
        drones: u16,
        reached: u16,
        heard: impl IntoIterator<Item = Heard>,
    ) -> bool {
        let mut heard = heard.into_iter();
        match wait {
            Wait::Neighbours => heard.all(|other| other.hops > 2 || other.reached >= reached),
            Wait::Team => {
                let ready = heard.filter(|other| other.reached >= reached).count();
                ready + 1 >= usize::from(drones)
            }
        }
    }
}

/// Returns the direction of a drone at `here` that surveys, as a vector of 1 m: the attraction to
/// its goal, and the force to each neighbour in radio range. Returns nothing when they are in
/// balance.
#[must_use]
pub fn direction(
    config: &Config,
    here: Point2,
    goal: Point2,
    heard: impl IntoIterator<Item = Heard>,
) -> Option<Point2> {
    let distance = here.distance(goal);
    let mut sum = Resultant::new(config.weight);
    sum.add(here, goal, attraction_to_goal(config, distance));
    if distance <= config.straight_within {
        return sum.direction();
    }
    for other in heard.into_iter().filter(|other| other.hops == 1) {
        let force = between_drones(config, here.distance(other.position));
        sum.add(here, other.position, force);
    }
    sum.direction()
}

/// Returns how far of `step` a drone at `here` can go along `direction`, a vector of 1 m, without
/// coming within [`Config::guard`] of a neighbour in radio range that stands still. A drone that is
/// too near already may only go away.
#[must_use]
pub fn guarded(
    config: &Config,
    here: Point2,
    direction: Point2,
    step: Metres,
    heard: impl IntoIterator<Item = Heard>,
) -> Metres {
    let room = heard.into_iter().filter(|other| other.hops == 1).map(|other| {
        let (x, y) = (other.position.x - here.x, other.position.y - here.y);
        let ahead = x * direction.x + y * direction.y;
        let beyond = x * x + y * y - config.guard.0 * config.guard.0;
        let inside = ahead * ahead - beyond;
        if ahead <= 0.0 || inside <= 0.0 {
            f32::INFINITY
        } else {
            (ahead - libm::sqrtf(inside)).max(0.0)
        }
    });
    Metres(room.fold(step.0, f32::min))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_flown_over_from_end_to_end() {
        let survey = Survey::new(&Config::PAPER, Metres(9.0), Metres(7.5));
        for drones in 1..=12 {
            for row in 0..survey.rows() {
                let x = (f32::from(row) + 0.5) * 0.75;
                let flown = (0..drones).any(|place| {
                    (0..survey.rows()).any(|sweep| {
                        let ends = [2 * sweep, 2 * sweep + 1]
                            .map(|index| survey.goal(place, drones, index));
                        matches!(ends, [Some(a), Some(b)] if a.x == x && b.x == x && a.y != b.y)
                    })
                });
                assert!(flown, "row {row} of {drones} drones");
            }
        }
    }

    #[test]
    fn the_guard_stops_a_drone_short_of_another() {
        let heard = Heard { position: Point2::new(0.45, 0.0), hops: 1, reached: 0 };
        let config = Config::BARRIER;
        let towards =
            |x| guarded(&config, Point2::default(), Point2::new(x, 0.0), Metres(0.1), [heard]).0;
        assert!(libm::fabsf(towards(1.0) - 0.059) < 1e-5);
        assert_eq!(towards(-1.0), 0.1);
    }

    #[test]
    fn a_drone_waits_for_those_at_two_hops() {
        let behind = Heard { position: Point2::new(1.5, 0.0), hops: 2, reached: 2 };
        let wait = Wait::Neighbours;
        assert!(Survey::may_start(wait, 2, 2, [behind]));
        assert!(!Survey::may_start(wait, 2, 3, [behind]));
        assert!(Survey::may_start(wait, 2, 3, [Heard { hops: 3, ..behind }]));
    }

    #[test]
    fn a_team_waits_for_a_drone_that_is_not_heard() {
        let ready = Heard { position: Point2::new(0.75, 0.0), hops: 1, reached: 1 };
        assert!(Survey::may_start(Wait::Team, 2, 1, [ready]));
        assert!(!Survey::may_start(Wait::Team, 3, 1, [ready]));
        assert!(!Survey::may_start(Wait::Team, 2, 2, [ready]));
    }
}
