//! Judges a mission: the reasons why it failed, and the scenario's criteria.

use agent::{ChainDuty, Duty, LandReason, State};
use serde_json::{Value, json};
use units::Order;

use super::last_states;
use super::summary::number;
use crate::measure::metrics::RunMetrics;
use crate::measure::trace::{Node, Trace};
use crate::scenario::Scenario;

/// The reasons why the mission failed; empty for one that succeeded.
pub(super) fn failures(scenario: &Scenario, trace: &Trace, metrics: &RunMetrics) -> Vec<String> {
    let ordered = scenario.pilot.last().map(|step| step.task);
    let mut failures = Vec::new();
    let mut count = |n: u32, what: &str| {
        if n > 0 {
            failures.push(format!("{n} {what}"));
        }
    };
    count(metrics.wall_contacts, "touches of a wall");
    count(metrics.drone_contacts, "touches between drones");
    count(metrics.order_lost, "rounds in which the order of the chain was lost");
    if let Some(swarm) = &metrics.swarm {
        count(swarm.unfinished, "drones that did not finish");
    }
    if let Some(explore) = &metrics.explore {
        count(explore.unfinished, "drones that did not finish");
    }
    for criterion in criteria(scenario, metrics).iter().filter(|criterion| !criterion.met()) {
        failures.push(criterion.complaint());
    }
    let is_lost =
        |node: &Node| scenario.losses.iter().any(|loss| loss.drone == usize::from(node.id.0));
    for (node, state) in last_states(trace).filter(|(node, _)| !is_lost(node)) {
        let called_home = matches!(ordered, Some(Order::Return | Order::Land));
        let lost = match state {
            state if called_home && state.is_airborne() => {
                Some("still flew when the mission ended, although it was ordered down")
            }
            State::Landing { why, .. } | State::Landed { why } => match why {
                LandReason::LinkLost => Some("landed because it lost the base"),
                LandReason::TakeOffFailed => Some("landed because it never reached its height"),
                LandReason::Unfit(_) => Some("was brought down by a fault"),
                LandReason::Restarted => Some("restarted by itself and stays down"),
                LandReason::PositionLost => Some("landed because it did not know its position"),
                LandReason::Ordered
                | LandReason::Perched
                | LandReason::Home
                | LandReason::Done
                | LandReason::Retired => None,
            },
            State::OnMission(Duty::Chain(ChainDuty::Reconnecting { .. })) => {
                Some("heard no drone in front at the end")
            }
            _ => None,
        };
        if let Some(what) = lost {
            failures.push(format!("{node} {what}"));
        }
    }
    failures
}

/// A bound that the scenario sets, and the value that the mission reached.
pub(super) struct Criterion {
    pub(super) name: &'static str,
    /// The texts before and after the value.
    words: [&'static str; 2],
    /// Whether the bound is the most, and not the least.
    most: bool,
    bound: f32,
    value: f32,
}

impl Criterion {
    /// NaN meets no bound.
    fn met(&self) -> bool {
        if self.most { self.value <= self.bound } else { self.value >= self.bound }
    }

    /// The value that was found, and the bound.
    fn complaint(&self) -> String {
        let which = if self.most { "most" } else { "least" };
        let [before, after] = self.words;
        let found = match self.value.is_nan() {
            true => format!("{} could not be measured", self.name),
            false => format!("{before} {}{after}", self.value),
        };
        format!("{found}; at {which} {} asked", self.bound)
    }

    pub(super) fn json(&self) -> Value {
        let which = if self.most { "most" } else { "least" };
        json!({ which: number(self.bound), "value": number(self.value), "met": self.met() })
    }
}

/// The criteria of the scenario.
pub(super) fn criteria(scenario: &Scenario, metrics: &RunMetrics) -> Vec<Criterion> {
    let asked = &scenario.criteria;
    let tilt = metrics.flight.as_ref().map(|flight| flight.max_tilt_deg);
    // A point does not tilt.
    let tilt_asked = asked.tilt_deg.filter(|_| tilt.is_some());
    let rows = [
        (
            "hold_spread_db",
            ["at the end of the hold the links differed by", " dB"],
            true,
            asked.hold_spread_db,
            metrics.held(|hold| hold.spread_db),
        ),
        (
            "swing_p95_db",
            ["at the end of the hold the links swung by", " dB"],
            true,
            asked.swing_p95_db,
            metrics.held(|hold| hold.swing_p95_db),
        ),
        ("max_tilt_deg", ["a drone tilted to", "°"], true, tilt_asked, tilt.unwrap_or(f32::NAN)),
        (
            "launched",
            ["launched", " relays"],
            false,
            asked.launched.map(|n| n as f32),
            metrics.launched,
        ),
    ];
    rows.into_iter()
        .filter_map(|(name, words, most, bound, value)| {
            Some(Criterion { name, words, most, bound: bound?, value })
        })
        .collect()
}
