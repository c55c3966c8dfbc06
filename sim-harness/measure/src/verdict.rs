//! Judges a mission as a person would who looks on: what failed, why the exploration ended, and where
//! the head came beside where it could have come.
//!
//! | module | holds |
//! |---|---|
//! | [`failure`] | the failures, each with its data |
//! | [`evidence`] | what is collected round by round, and [`head`] for the head |
//! | `branch`, `reach` | the way that was ordered, and how far the radio lets a head come on it |
//! | [`mod@criteria`] | the bounds that the scenario sets, or that its mission has |
//! | [`short`] | why explorers have not seen all |
//!
//! The verdict is made from the scenario, the world, the best chains, the metrics and the evidence,
//! and from no trace; so a campaign has it of each of its missions.

mod branch;
pub mod criteria;
mod drones;
mod ended;
pub mod evidence;
pub mod failure;
pub mod head;
mod reach;
pub mod short;

use agent::State;
use serde_json::{Value, json};
use units::{Course, MetresPerSecond, Order};
use world::World;

use super::metrics::{Reference, RunMetrics, Watch};
use mission::Mission;
use scenario::Scenario;

use branch::ordered_way;
pub use criteria::{Criterion, criteria};
use drones::Called;
pub use drones::WIDER_M;
pub use ended::Ended;
pub use evidence::Evidence;
use failure::Down;
pub use failure::Failure;
use head::{HeadFlight, Pace};
use reach::reachable_m;
pub use short::Short;

/// The head must have come to this part of where it could: our own bound.
const DEPTH: f32 = 0.95;
/// There must have been a chain in this part of the ordered hold, as in what is called converged.
const HELD: f32 = 0.95;

/// The verdict of one mission.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// Why the mission failed; empty for one that succeeded.
    pub failures: Vec<Failure>,
    /// Why the exploration ended; `None` where nothing was explored.
    pub ended: Option<Ended>,
    /// The farthest place of the head on the way that was ordered, m from the base; NaN without a
    /// chain.
    pub came_m: f32,
    /// The farthest place to which the radio and the pilot's stick would have let it come, m from
    /// the base; NaN without a chain.
    pub could_m: f32,
    /// The time for which the pilot pushed, relays waited and the head stood, s; NaN without a chain.
    pub stood_s: f32,
    /// The relays beyond need in the last 10 s of the exploration; NaN where the head did not rest.
    pub surplus_at_rest: f32,
}

impl Judgement {
    /// Whether the mission succeeded.
    #[must_use]
    pub fn is_success(&self) -> bool {
        self.failures.is_empty()
    }

    /// Whether a drone touched a wall or another drone.
    #[must_use]
    pub fn touched(&self) -> bool {
        use Failure::{TouchedDrone, TouchedStanding, TouchedWall};
        let is_touch = |failure: &Failure| {
            matches!(failure, TouchedWall(_) | TouchedDrone(_) | TouchedStanding(_))
        };
        self.failures.iter().any(is_touch)
    }

    /// The verdict as a JSON object.
    #[must_use]
    pub fn json(&self) -> Value {
        let names: Vec<_> = self.failures.iter().map(Failure::name).collect();
        json!({
            "failures": names,
            "ended": self.ended.map(Ended::name),
            "came_m": rounded(self.came_m),
            "could_m": rounded(self.could_m),
            "stood_s": rounded(self.stood_s),
            "surplus_at_rest": rounded(self.surplus_at_rest),
        })
    }
}

/// A value with two decimals; `None` where it is not finite.
fn rounded(value: f32) -> Option<f64> {
    value.is_finite().then(|| (f64::from(value) * 100.0).round() / 100.0)
}

/// Flies a whole mission, and returns its figures and its verdict.
#[must_use]
pub fn judged(
    scenario: &Scenario,
    world: &World,
    reference: &Reference,
    seed: u64,
) -> (RunMetrics, Judgement) {
    judged_of(scenario, world, reference, Mission::new(scenario, world, seed))
}

/// The same of a mission that has not begun.
#[must_use]
pub fn judged_of(
    scenario: &Scenario,
    world: &World,
    reference: &Reference,
    mut mission: Mission<'_>,
) -> (RunMetrics, Judgement) {
    let mut watch = Watch::new(scenario, world, reference);
    while !mission.is_over() {
        mission.round();
        watch.look(&mission);
    }
    let metrics = watch.verdict(&mission);
    let judgement = watch.judgement(&mission, &metrics);
    (metrics, judgement)
}

/// Judges a mission by its metrics and its evidence.
#[must_use]
pub fn judge(
    scenario: &Scenario,
    world: &World,
    reference: &Reference,
    metrics: &RunMetrics,
    evidence: &Evidence,
) -> Judgement {
    let mut failures = touches(metrics);
    failures.extend(drones::on_each_other(&evidence.drones, 2.0 * scenario.vehicle.radius));
    failures.extend(order_of_the_chain(metrics, evidence));
    let unfinished = |n: u32| (n > 0).then_some(Failure::Unfinished(n));
    failures.extend(metrics.swarm.as_ref().and_then(|swarm| unfinished(swarm.unfinished)));
    failures.extend(metrics.explore.as_ref().and_then(|explore| unfinished(explore.unfinished)));
    failures.extend(
        criteria(scenario, metrics).iter().filter_map(|criterion| criterion.failure(evidence)),
    );
    let called = Called::of(scenario, evidence);
    let home_m = drones::home_m(scenario, world, &evidence.drones);
    failures.extend(evidence.drones.iter().filter_map(|drone| called.failure(drone, home_m)));
    failures.extend(hold_missed(evidence.hold_s));

    let Some(head) = &evidence.head else {
        let nothing = f32::NAN;
        return Judgement {
            failures,
            ended: None,
            came_m: nothing,
            could_m: nothing,
            stood_s: nothing,
            surplus_at_rest: nothing,
        };
    };
    let limit = scenario.agent.launch.limit.loss().0;
    let way = ordered_way(world.skeleton(), world.base.on, &head.passed, head.choice);
    let radio_m = reachable_m(world, reference, &way, limit, head.wished_m.max(NEVER_FLOWN_M));
    let branches = branches_missed(world, head);
    // In another branch, the head is no farther on its way than the junction.
    let on_way_m = head.passed.iter().find(|passing| passing.missed(world.skeleton()).is_some());
    let came_m = head.came_m.map(|came| on_way_m.map_or(came, |passing| passing.at_m));
    failures.extend(branches);
    failures
        .extend(head.stuck.map(|stood| Failure::Stuck { at_m: stood.at_m, for_s: stood.for_s }));
    if scenario.pilot.iter().any(|step| is_push(step.task)) {
        // Where the drones begin in the air, the head waits for none.
        let relays = if metrics.needed.is_nan() { 0.0 } else { metrics.needed };
        let due_m = head.came_m.map_or(radio_m, |_| head.due_m(relays, &Pace::of(scenario)));
        failures.extend(depth_missed(came_m.unwrap_or(0.0), radio_m.min(due_m)));
    }
    let is_there = came_m.is_some_and(|came| came >= DEPTH * radio_m);
    let wished_m = head.came_m.map_or(f32::INFINITY, |_| head.wished_m);
    // Where the head came, it could come, whatever is allowed for noise.
    let could_m = radio_m.min(wished_m).max(came_m.unwrap_or(0.0));
    Judgement {
        failures,
        ended: ended(head, evidence, is_there),
        came_m: came_m.unwrap_or(0.0),
        could_m,
        stood_s: head.stood_s,
        surplus_at_rest: head.surplus_at_rest,
    }
}

/// A head that never flew is asked for this way, m: so little that any radio carries it.
const NEVER_FLOWN_M: f32 = 1.0;

/// Whether an order sends the head forward.
fn is_push(order: Order) -> bool {
    matches!(order, Order::Explore(Course { speed, .. }) if speed > MetresPerSecond::ZERO)
}

fn touches(metrics: &RunMetrics) -> Vec<Failure> {
    let all = [
        Failure::TouchedWall(metrics.wall_contacts),
        Failure::TouchedDrone(metrics.drone_contacts),
        Failure::TouchedStanding(metrics.ground_contacts),
    ];
    let counts = [metrics.wall_contacts, metrics.drone_contacts, metrics.ground_contacts];
    all.into_iter().zip(counts).filter(|(_, n)| *n > 0).map(|(failure, _)| failure).collect()
}

fn order_of_the_chain(metrics: &RunMetrics, evidence: &Evidence) -> Vec<Failure> {
    let lost = (metrics.order_lost > 0).then_some(Failure::OrderLost(metrics.order_lost));
    lost.into_iter().chain(evidence.is_disordered.then_some(Failure::OutOfOrder)).collect()
}

fn hold_missed([of_s, held_s]: [f32; 2]) -> Option<Failure> {
    let missing_s = of_s - held_s;
    (held_s < HELD * of_s).then_some(Failure::HoldMissed { missing_s, of_s })
}

fn branches_missed(world: &World, head: &HeadFlight) -> Vec<Failure> {
    let skeleton = world.skeleton();
    let missed = head.passed.iter().filter_map(|passing| {
        let gallery = skeleton.edge(passing.to.edge).name().to_owned();
        let ordered = passing.missed(skeleton)?;
        Some(Failure::BranchMissed { ordered, at_m: passing.at_m, gallery })
    });
    missed.collect()
}

/// Whether the head came less far than it could.
fn depth_missed(came_m: f32, could_m: f32) -> Option<Failure> {
    (came_m < DEPTH * could_m).then_some(Failure::DepthMissed { came_m, could_m })
}

/// Why the exploration ended. A head that fell out of it, by its own fault or for want of a link, has
/// not been stopped by the pilot.
fn ended(head: &HeadFlight, evidence: &Evidence, is_there: bool) -> Option<Ended> {
    let ended = head.ended?;
    if head.has_fallen {
        return Some(match evidence.drones.first().map(|drone| drone.state) {
            Some(State::Landing { why, .. } | State::Landed { why }) => match Down::of(why) {
                Down::Link => Ended::Radio,
                Down::Battery => Ended::Battery,
                _ => Ended::Fault,
            },
            _ => Ended::Fault,
        });
    }
    match ended {
        Ended::Radio if is_there => Some(Ended::TooFewRelays),
        ended => Some(ended),
    }
}
