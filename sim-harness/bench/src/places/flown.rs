//! Flies one mission to a depth, and says what became of its drones and links.

use agent::{LandReason, State};
use measure::oracle::Oracle;
use mission::Mission;
use scenario::Scenario;
use serde_json::{Value, json};
use units::{MetresPerSecond, NodeId, Order};

use super::depth::Plan;
use super::pilot::{Pilot, Why};
use crate::chain::drawn::flown::{Case, Cause, Flown, Observer};

/// The part of the hold in which the head must be a link of the chain: as in a verdict.
const LINKED: f32 = 0.95;

/// How one mission went.
#[derive(Clone, Debug)]
pub(super) struct Flight {
    pub(super) flown: Flown,
    /// Whether the head was linked to the base in the hold.
    pub(super) is_linked: bool,
    /// The part of the exploration for which the head stood although the pilot pushed and relays
    /// waited.
    pub(super) stood: f32,
    /// How often drones touched walls, one another, or drones on the ground.
    pub(super) touches: u32,
    /// Whether a drone lost its place.
    pub(super) has_lost_place: bool,
    /// Relays launched, less those that the head's depth needs.
    pub(super) launched_over_need: f32,
    /// The time to the depth by the time that the way takes at the pilot's speed; `None` where the
    /// head did not come there.
    pub(super) time_over_way: Option<f32>,
    /// Why the pilot ended the exploration, and when, s.
    pub(super) ended: Option<(Why, f32)>,
    /// The mission as a scenario's file, with the orders that the pilot gave.
    pub(super) file: String,
}

/// Flies the mission of a seed beside its oracle.
pub(super) fn fly(plan: &Plan<'_>, oracle: &Oracle, seed: u64) -> Flight {
    let Plan { scenario, world, commanded, .. } = plan;
    let mut mission = Mission::new(scenario, world, seed);
    let mut observer =
        Observer::of(Case { seed, scenario, world, commanded, oracle }, &scenario.policy);
    let mut pilot = Pilot::of(scenario);
    let mut hold = Hold::default();
    while !mission.is_over() {
        mission.round();
        observer.look(&mission);
        hold.look(&mission);
        let explored = pilot.ended.is_none();
        let is_over = pilot.steer(&mut mission);
        if explored && pilot.ended.is_some() {
            observer.end_exploration(mission.time_us(), pilot.holds_us());
        }
        if is_over {
            break;
        }
    }
    let flown = observer.flown(&mission);
    let speed = scenario.pilot.first().map_or(0.2, |step| match step.task {
        Order::Explore(course) => course.speed.0,
        _ => 0.2,
    });
    let explored_s = pilot.ended.map_or(scenario.duration_s(), |(_, at)| at).max(1.0);
    let touches = flown.walls + flown.drones + mission.ground_contacts();
    let need = oracle.least_relays_at(flown.depth_m) as f32;
    let way_s = oracle.depth_m.max(1.0) / speed;
    Flight {
        is_linked: hold.is_linked(),
        stood: flown.stood_s / explored_s,
        touches,
        has_lost_place: has_lost_place(&mission, &flown),
        launched_over_need: flown.launched as f32 - need,
        time_over_way: flown.is_deep().then(|| flown.deep_s / way_s),
        ended: pilot.ended,
        file: file(scenario, &mission),
        flown,
    }
}

/// The scenario's file of a mission as it was flown, up to its end.
fn file(scenario: &Scenario, mission: &Mission<'_>) -> String {
    let pilot = mission.pilot().to_vec();
    let duration_us = mission.time_us();
    Scenario { pilot, duration_us, ..scenario.clone() }.resolved()
}

/// Whether a drone came down because it did not know its place, or took another place for its home.
fn has_lost_place(mission: &Mission<'_>, flown: &Flown) -> bool {
    let lost = |state: State| {
        matches!(
            state,
            State::Landing { why: LandReason::PositionLost, .. }
                | State::Landed { why: LandReason::PositionLost }
        )
    };
    mission.states().any(lost) || flown.left.iter().any(|left| left.why == "landed, home")
}

/// The rounds of the hold, and those with the head as a link of the chain.
#[derive(Default)]
struct Hold {
    rounds: [u32; 2],
    chain: Vec<mission::Linked>,
}

impl Hold {
    fn look(&mut self, mission: &Mission<'_>) {
        let holds =
            |task| matches!(task, Order::Explore(course) if course.speed <= MetresPerSecond::ZERO);
        if !holds(mission.task()) || mission.is_recalled() {
            return;
        }
        mission.chain(&mut self.chain);
        let is_link =
            self.chain.len() > 1 && self.chain.last().is_some_and(|last| last.id == NodeId::HEAD);
        let [all, linked] = &mut self.rounds;
        *all += 1;
        *linked += u32::from(is_link);
    }

    /// A head that was called home before it held was a link until then.
    fn is_linked(&self) -> bool {
        let [all, linked] = self.rounds;
        linked as f32 >= LINKED * all as f32
    }
}

impl Flight {
    /// Whether the head came as deep as the oracle's.
    pub(super) fn has_arrived(&self) -> bool {
        self.flown.is_deep()
    }

    /// Whether it arrived, was linked, and all came home without a touch.
    pub(super) fn is_good(&self) -> bool {
        self.has_arrived() && self.is_linked && self.flown.is_home() && self.touches == 0
    }

    /// The first cause of a mission that is not good.
    pub(super) fn cause(&self) -> Option<&'static str> {
        if self.is_good() {
            return None;
        }
        let counts = |cause: &Cause| !matches!(cause, Cause::Late | Cause::Weak | Cause::Order);
        let first = self.flown.wrong.iter().map(|(_, cause)| *cause).find(counts);
        Some(match first {
            Some(Cause::Short) => self.ended.map_or("short-fell", |(why, _)| why.short()),
            Some(cause) => cause.name(),
            None if !self.is_linked => "unlinked",
            None => "touched-standing-drone",
        })
    }

    /// The mission as one JSON object.
    pub(super) fn json(&self) -> Value {
        let mut json = self.flown.json();
        json["linked"] = json!(self.is_linked);
        json["cause"] = json!(self.cause());
        json["ended"] = json!(self.ended.map(|(why, _)| why.name()));
        json["ended_s"] = json!(self.ended.map(|(_, at)| f64::from(at)));
        json
    }
}
