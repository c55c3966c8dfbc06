//! Takes a drone through the passage: when it follows the others, which way it goes, and when it lets one
//! beside it go first.

use units::Point2;

use crate::geometry::along;
use crate::member::{Leg, Member, Task};
use crate::takeover::Takeover;
use crate::team::Neighbour;
use crate::{Obstacles, Passage, crossing};

/// How a drone gets on in a passage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// It goes ahead, but for so many rounds in which it got no farther.
    Ahead {
        /// Rounds without progress; progress begins them anew.
        blocked: u16,
    },
    /// It goes back for so many more rounds, so that a drone beside it can go first.
    Back {
        /// Rounds that are left.
        rounds: u16,
    },
}

impl<const N: usize> Member<N> {
    /// Says whether a guarded drone on the way to its place has a neighbour in the passage: it follows
    /// that one then, which keeps its link and so cannot go far ahead of it.
    pub(crate) fn is_late(&self) -> bool {
        let Passage { entrance, way, .. } = self.plan.passage;
        let inside = |other: Neighbour| along(way, entrance, other.position) > 0.0;
        self.config.guard.is_some() && self.team.neighbours().any(inside)
    }

    /// Says whether a drone at `here` is far enough behind the passage, and all are out of it. It is asked
    /// before the drone's step: a neighbour that has just begun to land keeps no link, and one step
    /// more would cut it off.
    pub(crate) fn is_through(&self, here: Point2, pace: Pace) -> bool {
        // Behind those that have landed there may be no room to go on. One that still can leaves the exit to
        // a drone that was taken for lost.
        let most = self.config.hold / 4;
        let is_held = matches!(pace, Pace::Ahead { blocked } if blocked > most);
        let is_near =
            |other: Neighbour| here.distance(other.position) <= self.config.wanted_distance();
        let has_no_room = is_held && self.team.landed().any(is_near);
        let exit = if has_no_room { self.error.0 } else { 2.0 * self.config.wanted_distance().0 };
        self.leg == Leg::First && self.beyond(here) > exit && self.ready(self.goals() + 2)
    }

    /// Returns the task of a drone that is through the passage: to survey the second area, where that is
    /// to be surveyed, or else to land.
    pub(crate) fn surveys_or_lands(&mut self) -> Task {
        let [_, second] = self.plan.surveys;
        if second.goals() == 0 {
            return Task::Done;
        }
        (self.leg, self.takeover, self.still) = (Leg::Second, Takeover::NONE, 0);
        Task::Survey { reached: 0, underway: true }
    }

    /// Begins the way through the passage: nothing that the drone met on an earlier one counts.
    pub(crate) fn enter(&mut self) -> Task {
        (self.still, self.farthest, self.side) = (0, f32::NEG_INFINITY, None);
        Task::Cross { out: false, pace: Pace::Ahead { blocked: 0 } }
    }

    /// Returns how far `here` is behind the passage, in metres.
    fn beyond(&self, here: Point2) -> f32 {
        let Passage { entrance, way, length, .. } = self.plan.passage;
        along(way, entrance, here) - length.0
    }

    /// Returns the task of a drone after a step through the passage from `start` to `here`.
    pub(crate) fn crossed(&mut self, start: Point2, here: Point2, pace: Pace) -> Task {
        let out = self.beyond(here) > self.error.0;
        if out && self.leg == Leg::Back {
            self.still = 0;
            return Task::Home;
        }
        let waits = out && !self.ready(self.goals() + 2);
        let farther = along(self.plan.passage.way, start, here);
        self.count_rounds_held_up(here, waits);
        Task::Cross { out, pace: self.next_pace(pace, here, farther, waits) }
    }

    /// Counts the rounds since the drone, which is `here`, last came a step farther through the passage than ever:
    /// one that is held up goes to and fro. Once they are so many that it [lets go](Self::is_held_up) they are
    /// not begun anew: drones on both sides of an obstacle have let go of each other then until they are past it.
    fn count_rounds_held_up(&mut self, here: Point2, waits: bool) {
        let beyond = self.beyond(here);
        if self.is_held_up() || waits {
            return;
        }
        if beyond > self.farthest + self.config.longest_step.0 {
            (self.farthest, self.still) = (beyond, 0);
        } else {
            self.still = self.still.saturating_add(1);
        }
    }

    /// Says whether the drone got no farther for so long that it keeps no links for the others.
    pub(crate) fn is_held_up(&self) -> bool {
        self.still > self.config.hold
    }

    /// Returns the direction of a drone in the passage.
    pub(crate) fn way_through(
        &mut self,
        here: Point2,
        pace: Pace,
        obstacles: &Obstacles,
    ) -> Option<Point2> {
        let formation = self.formation(self.plan.drones);
        let (config, passage) = (&self.config, &self.plan.passage);
        // The paper's drones do not land: those that are done hover, and push and pull the others on.
        let done = self.team.landed().filter(|_| config.guard.is_none());
        let others = self.team.neighbours().chain(done).map(|other| other.position);
        match pace {
            Pace::Ahead { .. } => {
                let side = &mut self.side;
                crossing::direction(config, passage, formation, here, others, obstacles, side)
            }
            Pace::Back { .. } => Some(Point2::new(-passage.way.x, -passage.way.y)),
        }
    }

    /// Returns how a drone at `here` gets on after a step that brought it `farther` ahead, in
    /// metres. A guarded drone that gets no farther goes back where another one is beside it and
    /// slightly ahead: without that, two drones before a narrow place wait for each other. One that only
    /// `waits` behind the passage is not held up.
    fn next_pace(&self, pace: Pace, here: Point2, farther: f32, waits: bool) -> Pace {
        let Some(guard) = &self.config.guard else {
            return pace;
        };
        let beside = |other: Neighbour| {
            let ahead = along(self.plan.passage.way, here, other.position);
            let first = ahead > 0.0 || (ahead == 0.0 && other.number < self.number);
            let near = here.distance(other.position).0 < 2.0 * guard.drones.0;
            first && near && ahead < guard.drones.0
        };
        match pace {
            Pace::Back { rounds } if rounds > 1 => Pace::Back { rounds: rounds - 1 },
            Pace::Ahead { blocked } if farther < 0.25 * self.config.longest_step.0 => {
                let yields = blocked >= guard.blocked_rounds && self.team.neighbours().any(beside);
                if yields {
                    Pace::Back { rounds: guard.back_rounds }
                } else {
                    let most = if waits { guard.blocked_rounds } else { u16::MAX };
                    Pace::Ahead { blocked: blocked.saturating_add(1).min(most) }
                }
            }
            Pace::Ahead { .. } | Pace::Back { .. } => Pace::Ahead { blocked: 0 },
        }
    }
}

#[cfg(test)]
mod tests {
    use units::Metres;

    use super::*;
    use crate::team::Heard;
    use crate::{Config, Plan, Survey};

    fn plan(config: &Config) -> Plan {
        let (corner, area) = (Point2::new(-9.75, -3.75), (Metres(9.0), Metres(7.5)));
        let passage = Passage {
            entrance: Point2::new(0.0, 0.0),
            width: Metres(2.26),
            way: Point2::new(1.0, 0.0),
            length: Metres(6.0),
        };
        Plan { drones: 2, surveys: [Survey::new(config, corner, area, 2); 2], passage }
    }

    /// A drone that had stood still before the passage for long took a place near its home for its home,
    /// since it counted those rounds on.
    #[test]
    fn a_drone_that_was_held_up_before_the_passage_flies_all_the_way_home_behind_it() {
        let config = Config::OURS;
        let pace = Pace::Ahead { blocked: 0 };
        let task = Task::Cross { out: false, pace };
        let still = u16::MAX;
        let mut drone = Member::<4> { task, still, ..Member::new(config, plan(&config), 0) };
        drone.leg = Leg::Back;
        let (start, here) = (Point2::new(6.9, 0.0), Point2::new(7.0, 0.0));
        assert_eq!(drone.crossed(start, here, pace), Task::Home);
        assert_eq!(drone.still, 0);
    }

    /// Two drones on the sides of a pillar held each other there until their batteries were empty.
    #[test]
    fn a_drone_that_a_link_holds_in_the_passage_for_long_lets_go_of_it() {
        let config = Config::OURS;
        let plan = plan(&config);
        let task = Task::Cross { out: false, pace: Pace::Ahead { blocked: 0 } };
        let mut drone = Member::<4> { task, ..Member::new(config, plan, 0) };
        let held = Point2::new(2.0, 0.0);
        let mut here = Point2::new(3.0, 0.0);
        let mut fly = |rounds| {
            for _ in 0..rounds {
                let progress = drone.progress();
                let other =
                    Heard { number: 1, position: held, error: Metres(0.0), hops: 1, progress };
                let other = (here.distance(held) <= config.radio_range).then_some(other);
                let open = Obstacles::default();
                here = drone.step(here, Metres(0.0), other, &open, config.longest_step);
            }
            here.distance(held)
        };
        assert!(fly(config.hold) <= config.radio_range, "the link is kept");
        assert!((0..25).any(|_| fly(20).0 > 2.0), "but not for ever");
    }

    /// Two drones that went to and fro beside a pillar held each other there, since each step ahead began their
    /// patience anew.
    #[test]
    fn a_drone_that_goes_to_and_fro_in_the_passage_lets_go_of_links() {
        let config = Config::OURS;
        let ahead = Pace::Ahead { blocked: 0 };
        let mut drone = Member::<4>::new(config, plan(&config), 0);
        let at = |round: u16| Point2::new(2.0 + 0.05 * f32::from(round % 3), 0.0);
        for round in 0..config.hold {
            assert!(!drone.is_held_up(), "after {round} rounds");
            drone.task = drone.crossed(at(round), at(round + 1), ahead);
        }
        drone.crossed(at(0), at(1), ahead);
        drone.crossed(at(1), at(2), ahead);
        assert!(drone.is_held_up());
    }
}
