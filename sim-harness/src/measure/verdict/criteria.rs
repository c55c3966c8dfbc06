//! Compares a mission with the criteria that its scenario sets.

use super::Failure;
use crate::measure::metrics::RunMetrics;
use crate::scenario::Scenario;

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
    pub(super) fn failure(&self) -> Option<Failure> {
        let which = if self.is_most { "most" } else { "least" };
        let [before, after] = self.words;
        let found = match self.value.is_nan() {
            true => format!("{} could not be measured", self.name),
            false => format!("{before} {}{after}", self.value),
        };
        let found = format!("{found}; at {which} {} asked", self.bound);
        (!self.is_met()).then_some(Failure::Criterion { name: self.name, found })
    }
}

/// The criteria of the scenario.
#[must_use]
pub fn criteria(scenario: &Scenario, metrics: &RunMetrics) -> Vec<Criterion> {
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
        .filter_map(|(name, words, is_most, bound, value)| {
            Some(Criterion { name, words, is_most, bound: bound?, value })
        })
        .collect()
}
