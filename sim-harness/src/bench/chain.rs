//! Measures how well and how fast each movement policy makes links equal: five links, a head that
//! stands still, relays anywhere between it and the base, 180 s. All policies fly the same seeds.

use chain::policy::NAMES;
use serde_json::{Value, json};

use crate::campaign::{figures, fly};
use crate::input_error::InputError;
use crate::metrics::Reference;
use crate::mission::World;
use crate::scenario::Scenario;

/// The corridors, with a continuous radio and with walls counted as equation (19) prints it.
pub const SCENARIOS: [&str; 6] =
    ["s-turns-5", "zigzag-5", "winding-5", "s-turns-5-step", "zigzag-5-step", "winding-5-step"];

/// One scenario under one policy.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The scenario's name.
    pub scenario: &'static str,
    /// The policy's name.
    pub policy: &'static str,
    /// The number of missions.
    pub runs: usize,
    /// Name and value of each figure; an infinite value is `None`.
    pub figures: Vec<(&'static str, Option<f64>)>,
}

/// The figures of a campaign that a row holds, in its order.
pub const FIGURES: [&str; 8] = [
    "c3",
    "c1",
    "t3_median_s",
    "gap_db",
    "difference_db",
    "swing_p95_db",
    "position_sd_m",
    "bound_s",
];

impl Row {
    /// The row as one JSON object.
    #[must_use]
    pub fn json(&self) -> Value {
        let mut object =
            json!({ "scenario": self.scenario, "policy": self.policy, "runs": self.runs });
        if let Some(object) = object.as_object_mut() {
            object.extend(self.figures.iter().map(|(name, value)| ((*name).into(), json!(value))));
        }
        object
    }
}

/// Flies all scenarios under all policies.
///
/// # Errors
/// None, as long as the built-in scenarios are sound.
pub fn run(runs: usize, seed: u64, after_each: impl Fn() + Sync) -> Result<Vec<Row>, InputError> {
    let mut rows = Vec::new();
    for name in SCENARIOS {
        let plain = Scenario::open(name)?;
        let world = World::of(&plain);
        let reference = Reference::of(&plain, &world);
        for policy in NAMES {
            let Some(scenario) = plain.with_policy(policy) else { continue };
            let all = fly(&scenario, &world, &reference, seed, runs, &after_each);
            let measured = figures(&all);
            let value = |wanted: &'static str| {
                let found = measured.iter().find(|figure| figure.name == wanted);
                let value = found.map(|figure| figure.estimate.value);
                (wanted, value.filter(|value| value.is_finite()))
            };
            let figures = FIGURES.map(value).to_vec();
            rows.push(Row { scenario: name, policy, runs, figures });
        }
    }
    Ok(rows)
}
