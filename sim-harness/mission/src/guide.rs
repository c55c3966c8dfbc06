//! Guides a pilot along the route of a map: which branch to choose at the next junction.

use scenario::{Scenario, Start};
use units::{Branch, Order};
use world::forks::forks;
use world::{SkeletonPlace, World};

/// A head has left a junction behind that is so far past it by its odometer, m: half of the width of
/// SubT's tunnels, and a tenth for the odometer.
const PAST_M: f32 = 3.0;

/// The choices along a route, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Guide {
    /// How far each junction is from where the head takes off, m, and the choice there.
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
        let row_m = Start::SPACING * scenario.drones.flying() as f32;
        let choice = |fork: world::forks::Fork| (fork.at_m - row_m, fork.branch(skeleton));
        Self { choices: forks(skeleton, &way, 0.0).into_iter().map(choice).collect() }
    }

    /// The choice at the next junction of a head whose odometer says this; `None` behind the last.
    pub(super) fn branch(&self, odometer_m: f32) -> Option<Branch> {
        let ahead = |(at_m, _): &&(f32, Option<Branch>)| at_m + PAST_M > odometer_m;
        self.choices.iter().find(ahead).and_then(|(_, branch)| *branch)
    }
}
