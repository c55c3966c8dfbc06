//! Says where a drone of a swarm is to be, for observers.

use units::Point2;

use crate::{Member, Task};

/// Where a drone of a swarm is to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// The drone flies over a row of its survey, or waits at an end of it.
    Row {
        /// The row's number in its survey, from 0.
        number: u16,
        /// The end of the row that the drone leaves behind.
        from: Point2,
        /// The end of the row at which the drone is to be.
        to: Point2,
    },
    /// The drone has this place in the formation before the passage.
    Formation(Point2),
    /// The drone was recalled, and flies to where it took off.
    Home(Point2),
}

impl Target {
    /// Returns the point at which the drone is to be.
    #[must_use]
    pub const fn at(self) -> Point2 {
        match self {
            Self::Row { to: at, .. } | Self::Formation(at) | Self::Home(at) => at,
        }
    }
}

impl<const N: usize> Member<N> {
    /// Returns where the drone is to be; nothing while it crosses the passage, which has no places, and
    /// once it is to land.
    #[must_use]
    pub fn target(&self) -> Option<Target> {
        match self.task {
            Task::Survey { reached, underway } => Some(self.target_in_survey(if underway {
                reached
            } else {
                reached.saturating_sub(1)
            })),
            Task::Gather { place, .. } => Some(Target::Formation(place)),
            Task::Home => Some(Target::Home(self.home)),
            Task::Cross { .. } | Task::Done => None,
        }
    }

    /// Returns the target of a drone whose goal has this index: in a row of its own, or, after the last one,
    /// in a row of a lost drone.
    fn target_in_survey(&self, index: u16) -> Target {
        let survey = self.survey();
        // The two goals of a row are neighbours, an even one and the odd one after it.
        if let (Some(to), Some(from)) =
            (survey.goal(self.number, index), survey.goal(self.number, index ^ 1))
        {
            return Target::Row { number: survey.row(self.number, index / 2), from, to };
        }
        let (number, to) = (self.takeover.row(), self.takeover.goal(survey));
        let ends = [false, true].map(|far| survey.end(number, far));
        let from = if ends[0] == to { ends[1] } else { ends[0] };
        Target::Row { number, from, to }
    }
}

#[cfg(test)]
mod tests {
    use units::Metres;

    use super::*;
    use crate::{Config, Obstacles, Passage, Plan, Survey};

    fn plan() -> Plan {
        let area = (Metres(9.0), Metres(7.5));
        Plan {
            drones: 1,
            surveys: [Survey::new(&Config::OURS, Point2::default(), area, 1); 2],
            passage: Passage {
                entrance: Point2::new(9.75, 3.75),
                way: Point2::new(1.0, 0.0),
                width: Metres(1.51),
                length: Metres(6.0),
            },
        }
    }

    /// A drone alone flies over all rows, has a place before the passage and none in it.
    #[test]
    fn a_drone_has_a_row_then_a_place_then_none() {
        let plan = plan();
        let mut member = Member::<1>::on_the_way(Config::OURS, plan, 0);
        let (mut here, mut seen) = (Point2::default(), std::vec::Vec::new());
        for _ in 0..3000 {
            let target = member.target();
            let kind = match target {
                Some(Target::Row { number, from, to }) => {
                    assert!(number < plan.surveys[0].rows() && from != to);
                    "row"
                }
                Some(Target::Formation(_)) => "place",
                Some(Target::Home(_)) => "home",
                None => "none",
            };
            if seen.last() != Some(&kind) {
                seen.push(kind);
            }
            if kind == "none" {
                break;
            }
            here = member.step(here, Metres(0.0), [], &Obstacles::default(), Metres(0.1));
        }
        assert_eq!(seen, ["row", "place", "none"]);
    }

    #[test]
    fn a_drone_that_is_recalled_has_its_home_as_target() {
        let mut member = Member::<1>::on_the_way(Config::OURS, plan(), 0);
        let home = Point2::new(0.5, -1.0);
        member.recall(Point2::new(2.0, 2.0), home);
        assert_eq!(member.target(), Some(Target::Home(home)));
        assert_eq!(member.target().map(Target::at), Some(home));
    }
}
