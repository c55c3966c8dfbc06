//! Compares a mission with the criteria that its scenario sets.

use super::{Evidence, Failure, Short};
use crate::metrics::{ExploreMetrics, RunMetrics};
use scenario::{Criteria, Scenario};

/// The names of the parts that explorers and swarms must have seen.
const EXPLORED: &str = "explored";
const COVERED: &str = "covered";

/// A bound that the scenario sets, and the value that the mission reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Criterion {
    /// The name of the metric.
    pub name: &'static str,
    /// The texts before and after the value.
    words: [&'static str; 2],
    /// Whether the bound is the most, and not the least.
    pub is_most: bool,
    /// The bound.
    pub bound: f32,
    /// The value that the mission reached; NaN where it could not be measured.
    pub value: f32,
}

impl Criterion {
    /// Whether the bound is kept. NaN meets no bound.
    #[must_use]
    pub fn is_met(&self) -> bool {
        if self.is_most { self.value <= self.bound } else { self.value >= self.bound }
    }

    /// The failure that it is where it is not met.
    pub(super) fn failure(&self, evidence: &Evidence) -> Option<Failure> {
        let which = if self.is_most { "most" } else { "least" };
        let [before, after] = self.words;
        let found = match self.value.is_nan() {
            true => format!("{} could not be measured", self.name),
            false => format!("{before} {}{after}", (1000.0 * self.value).round() / 1000.0),
        };
        let found = format!("{found}; at {which} {} asked", self.bound);
        let failure = match self.name {
            EXPLORED => Failure::Unexplored { found, why: Short::of(evidence) },
            COVERED => Failure::Uncovered { found, lost: evidence.lost() },
            name => Failure::Criterion { name, found },
        };
        (!self.is_met()).then_some(failure)
    }
}

/// The criteria of the scenario, with the bounds that each mission has by itself.
#[must_use]
pub fn criteria(scenario: &Scenario, metrics: &RunMetrics) -> Vec<Criterion> {
    let rows = of_explorers(scenario, metrics).into_iter().chain([of_swarm(scenario, metrics)]);
    rows.chain(of_chain(scenario, metrics)).filter_map(Row::criterion).collect()
}

/// A criterion whose bound may not be set.
struct Row {
    name: &'static str,
    words: [&'static str; 2],
    is_most: bool,
    bound: Option<f32>,
    value: f32,
}

impl Row {
    fn criterion(self) -> Option<Criterion> {
        let Self { name, words, is_most, bound, value } = self;
        Some(Criterion { name, words, is_most, bound: bound?, value })
    }
}

fn of_explorers(scenario: &Scenario, metrics: &RunMetrics) -> [Row; 3] {
    let asked = &scenario.criteria;
    let explore = metrics.explore.as_ref();
    let value = |of: fn(&ExploreMetrics) -> f32| explore.map_or(f32::NAN, of);
    let usual = |bound: f32| explore.map(|_| bound);
    [
        Row {
            name: EXPLORED,
            words: ["of what the drones can come to, a part of", " was explored"],
            is_most: false,
            bound: asked.explored.or(usual(Criteria::EXPLORED)),
            value: value(|explore| explore.explored),
        },
        Row {
            name: "false_walls",
            words: ["of the walls in the maps, a part of", " is none"],
            is_most: true,
            bound: asked.false_walls.or(usual(Criteria::FALSE)),
            value: value(|explore| explore.false_walls),
        },
        Row {
            name: "false_free",
            words: ["of what the maps have as free, a part of", " is rock"],
            is_most: true,
            bound: asked.false_free.or(usual(Criteria::FALSE)),
            value: value(|explore| explore.false_free),
        },
    ]
}

fn of_swarm(scenario: &Scenario, metrics: &RunMetrics) -> Row {
    let swarm = metrics.swarm.as_ref();
    Row {
        name: COVERED,
        words: ["of the area, a part of", " was flown over"],
        is_most: false,
        bound: scenario.criteria.covered.or(swarm.map(|_| Criteria::COVERED)),
        value: swarm.map_or(f32::NAN, |swarm| swarm.covered),
    }
}

fn of_chain(scenario: &Scenario, metrics: &RunMetrics) -> [Row; 4] {
    let asked = &scenario.criteria;
    let tilt = metrics.flight.as_ref().map(|flight| flight.max_tilt_deg);
    [
        Row {
            name: "hold_spread_db",
            words: ["at the end of the hold the links differed by", " dB"],
            is_most: true,
            bound: asked.hold_spread_db,
            value: metrics.held(|hold| hold.spread_db),
        },
        Row {
            name: "swing_p95_db",
            words: ["at the end of the hold the links swung by", " dB"],
            is_most: true,
            bound: asked.swing_p95_db,
            value: metrics.held(|hold| hold.swing_p95_db),
        },
        Row {
            name: "max_tilt_deg",
            words: ["a drone tilted to", "°"],
            is_most: true,
            // A point does not tilt.
            bound: asked.tilt_deg.filter(|_| tilt.is_some()),
            value: tilt.unwrap_or(f32::NAN),
        },
        Row {
            name: "launched",
            words: ["launched", " relays"],
            is_most: false,
            bound: asked.launched.map(|n| n as f32),
            value: metrics.launched,
        },
    ]
}
