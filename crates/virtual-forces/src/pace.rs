//! Takes a drone through the passage: when it follows the others, which way it goes, and when it lets one
//! beside it go first.

use units::{Metres, Point2};

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
        /// Rounds without progress.
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

    /// Returns the task of a drone after a step through the passage from `start` to `here`.
    pub(crate) fn crossed(&mut self, start: Point2, here: Point2, pace: Pace) -> Task {
        let Passage { entrance, way, length, .. } = self.plan.passage;
        let beyond = along(way, entrance, here) - length.0;
        // Behind one that has landed there is no room to go on.
        let has_landed = self.team.landed().next().is_some();
        let exit =
            if has_landed { self.error } else { Metres(2.0 * self.config.wanted_distance().0) };
        let [_, second] = self.plan.surveys;
        let is_through = beyond > exit.0 && self.ready(self.goals() + 2);
        match self.leg {
            Leg::Back if beyond > self.error.0 => Task::Home,
            Leg::First if is_through && second.goals() > 0 => {
                (self.leg, self.takeover) = (Leg::Second, Takeover::NONE);
                Task::Survey { reached: 0, underway: true }
            }
            Leg::First if is_through => Task::Done,
            _ => {
                let pace = self.next_pace(pace, here, along(way, start, here));
                Task::Cross { out: beyond > self.error.0, pace }
            }
        }
    }

    /// Returns the direction of a drone in the passage.
    pub(crate) fn way_through(
        &self,
        here: Point2,
        pace: Pace,
        obstacles: &Obstacles,
    ) -> Option<Point2> {
        let (config, passage) = (&self.config, &self.plan.passage);
        let others = self.team.neighbours().map(|other| other.position);
        match pace {
            Pace::Ahead { .. } => {
                let formation = self.formation(self.plan.drones);
                crossing::direction(config, passage, formation, here, others, obstacles)
            }
            Pace::Back { .. } => Some(Point2::new(-passage.way.x, -passage.way.y)),
        }
    }

    /// Returns how a drone at `here` gets on after a step that brought it `farther` ahead, in
    /// metres. A guarded drone that gets no farther goes back where another one is beside it and
    /// slightly ahead: without that, two drones before a narrow place wait for each other.
    fn next_pace(&self, pace: Pace, here: Point2, farther: f32) -> Pace {
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
                    Pace::Ahead { blocked: blocked.saturating_add(1) }
                }
            }
            Pace::Ahead { .. } | Pace::Back { .. } => Pace::Ahead { blocked: 0 },
        }
    }
}
