//! Guides a pilot along the route of a map: which branch to choose at the next junction.

use scenario::Scenario;
use units::{Branch, Order};
use world::forks::{Fork, forks};
use world::{SkeletonPlace, World};

/// A head has left a junction behind that is so far past it by its odometer, m: half of the width of
/// SubT's tunnels, and a tenth for the odometer. Where the next junction is nearer than twice as far, it
/// has from half of the way to it on, so that it knows the next choice before it comes there.
const PAST_M: f32 = 3.0;

/// The choices along a route, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Guide {
    /// How far from where the head takes off it has left each junction behind, m, and the choice there.
    choices: Vec<(f32, Option<Branch>)>,
}

impl Guide {
    /// The choices along the route of a scenario's map; none where its pilot chooses, or there is no
    /// route.
    pub(super) fn of(scenario: &Scenario, world: &World) -> Self {
        let chooses = |order| matches!(order, Order::Explore(course) if course.branch.is_some());
        let has_choices = scenario.pilot.iter().any(|step| chooses(step.task));
        if scenario.route.is_none() || has_choices {
            return Self::default();
        }
        let skeleton = world.skeleton();
        let along = skeleton.edge(0).line().length();
        let way = world.path_to(SkeletonPlace { edge: 0, along });
        let row_m = scenario.drones.row_m();
        let choice = |fork: Fork| (fork.at_m - row_m, fork.branch(skeleton));
        Self::with(forks(skeleton, &way, 0.0).into_iter().map(choice).collect())
    }

    /// A guide with the choice at each junction, which is so far from where the head takes off, m.
    fn with(mut choices: Vec<(f32, Option<Branch>)>) -> Self {
        let next: Vec<f32> = choices.iter().skip(1).map(|(at_m, _)| *at_m).collect();
        let next = next.into_iter().chain([f32::INFINITY]);
        for ((at_m, _), next_m) in choices.iter_mut().zip(next) {
            *at_m += PAST_M.min(0.5 * (next_m - *at_m));
        }
        Self { choices }
    }

    /// The choice at the next junction of a head whose odometer says this; `None` behind the last.
    pub(super) fn branch(&self, odometer_m: f32) -> Option<Branch> {
        let ahead = |(past_m, _): &&(f32, Option<Branch>)| *past_m > odometer_m;
        self.choices.iter().find(ahead).and_then(|(_, branch)| *branch)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// A head that takes off 0.35 m in, and junctions on the left at 10 m, on the right at 12 m and on
    /// the left at 22 m, of which the pilot's route takes none, the second, and none.
    fn guide() -> Guide {
        Guide::with(vec![
            (9.65, Some(Branch::Straight)),
            (11.65, Some(Branch::Right)),
            (21.65, Some(Branch::Left)),
        ])
    }

    #[test]
    fn the_choice_is_that_of_the_next_junction_until_the_head_is_past_it() {
        let guide = guide();
        assert_eq!(guide.branch(0.0), Some(Branch::Straight));
        assert_eq!(guide.branch(11.65), Some(Branch::Right));
        assert_eq!(guide.branch(11.65 + PAST_M - 0.1), Some(Branch::Right));
        assert_eq!(guide.branch(11.65 + PAST_M + 0.1), Some(Branch::Left));
        assert_eq!(
            guide.branch(21.65 + PAST_M + 0.1),
            None,
            "there is no junction behind the last"
        );
        assert_eq!(Guide::default().branch(0.0), None);
    }

    #[test]
    fn of_two_junctions_two_metres_apart_the_second_has_its_own_choice() {
        let guide = guide();
        assert_eq!(guide.branch(9.65 + 0.9), Some(Branch::Straight));
        assert_eq!(guide.branch(9.65 + 1.1), Some(Branch::Right), "a metre before the second");
    }

    #[test]
    fn a_pilot_who_chooses_and_a_mission_without_a_route_have_no_guide() {
        let text = "title = \"\"\nduration_s = 60\n[tunnel]\nwidth_m = 1.2\n\
                    centre_line_m = [[0, 0], [30, 0]]\n[drones]\nrelays = 1\n\
                    [[pilot]]\nat_s = 2\norder = \"explore\"\nspeed_mps = 0.2\n";
        let scenario = Scenario::of_text(Path::new("case.toml"), text).unwrap();
        assert_eq!(Guide::of(&scenario, &scenario.world()), Guide::default());
    }
}
