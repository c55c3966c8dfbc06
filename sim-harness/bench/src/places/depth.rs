//! Makes the mission to one depth of a route: its relays, its pilot, its time, and its oracle.

use measure::oracle::{Commanded, Oracle};
use planning::plan::{Demand, RelayPlan, relays};
use scenario::{Fidelity, PilotStep, Scenario};
use units::{Course, Db, MetresPerSecond, Order};
use world::World;

use super::flown::{self, Flight};
use super::pilot;
use super::site::{Ground, Site};

/// How much stronger than the launch limit a plan wants every link, as `plan relays` does.
const MARGIN: Db = Db(3.0);
/// The speed of the pilot's stick, that of a map's own mission.
const SPEED: MetresPerSecond = MetresPerSecond(0.2);
/// When the pilot gives the first order, µs.
const BEGINS_US: u64 = 2_000_000;
/// The part of the way beyond the depth that the oracle looks at, m.
const BEYOND_M: f32 = 2.0;

/// A depth of a route, and the mission to it, or the reason why there is none.
pub(super) struct Target<'a> {
    pub(super) place: &'a str,
    pub(super) from: &'a str,
    pub(super) depth_m: Option<f32>,
    pub(super) mission: Result<Plan<'a>, String>,
}

/// A mission to a depth.
pub(super) struct Plan<'a> {
    pub(super) scenario: Scenario,
    pub(super) world: &'a World,
    pub(super) commanded: Commanded,
    /// How far from the base the head is to come, m.
    pub(super) depth_m: f32,
}

/// The missions to each depth that the route and the battery allow; one without a mission where they
/// allow none.
pub(super) fn targets<'a>(site: &'a Site, depths: &[f32], fidelity: Fidelity) -> Vec<Target<'a>> {
    let (place, from) = (&*site.place, &*site.from);
    let refused =
        |why: &str| vec![Target { place, from, depth_m: None, mission: Err(why.to_owned()) }];
    let ground = match &site.ground {
        Ok(ground) => ground,
        Err(why) => return refused(why),
    };
    let whole = whole_way(&ground.world);
    let within = depths.iter().copied().filter(|depth| *depth <= whole.way.length());
    let mut plans: Vec<Plan<'_>> = Vec::new();
    for depth in within {
        let is_carried =
            plans.last().is_none_or(|last| last.scenario.depth_m == Some(last.depth_m));
        if is_carried {
            plans.push(Plan::of(ground, &whole, depth, fidelity));
        }
    }
    if plans.is_empty() {
        return refused(&format!("the way is {:.1} m long: {}", whole.way.length(), ground.ended));
    }
    let target =
        |plan: Plan<'a>| Target { place, from, depth_m: Some(plan.depth_m), mission: Ok(plan) };
    plans.into_iter().map(target).collect()
}

/// The way to the end of the route.
fn whole_way(world: &World) -> Commanded {
    Commanded::along_main(world)
}

impl<'a> Plan<'a> {
    /// The mission to this depth, or at flight level to where the battery calls the head home before.
    fn of(ground: &'a Ground, whole: &Commanded, depth_m: f32, fidelity: Fidelity) -> Self {
        let Ground { scenario, world, .. } = ground;
        let mut scenario = scenario.at(fidelity);
        let planned = |depth_m| {
            relays(&scenario, Demand { margin: MARGIN, speed: SPEED, depth_m: Some(depth_m) })
        };
        let mut plan: RelayPlan = planned(depth_m);
        let has_battery = fidelity != Fidelity::Point;
        let endurance_s = has_battery.then_some(plan.reach.endurance_s);
        let carried_m = if has_battery { plan.reach.farthest_m } else { f32::INFINITY };
        if carried_m < depth_m {
            plan = planned(carried_m);
        }
        scenario.drones.relays = plan.links.len() - 1;
        scenario.depth_m = Some(depth_m.min(carried_m));
        let ends_s = 1e-6 * BEGINS_US as f32 + pilot::explores_s(&scenario, depth_m);
        let us = |seconds: f32| (1e6 * f64::from(seconds)) as u64;
        let explore = |speed| Order::Explore(Course { speed, branch: None });
        let returns_s = ends_s + pilot::HOLDS_S;
        scenario.pilot = vec![
            PilotStep { at_us: BEGINS_US, task: explore(SPEED) },
            PilotStep { at_us: us(ends_s), task: explore(MetresPerSecond(0.0)) },
            PilotStep { at_us: us(returns_s), task: Order::Return },
        ];
        scenario.duration_us = us(returns_s + pilot::home_s(&scenario, depth_m));
        let end = whole.way.at((depth_m + BEYOND_M).min(whole.way.length()));
        let commanded = Commanded { way: world.path_to(end), detour: None, endurance_s };
        Self { scenario, world, commanded, depth_m }
    }

    /// Flies the mission of a seed.
    pub(super) fn fly(&self, seed: u64) -> Flight {
        let oracle = Oracle::of(&self.scenario, self.world, &self.commanded, seed);
        flown::fly(self, &oracle, seed)
    }
}
