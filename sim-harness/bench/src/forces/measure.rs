//! Whether swarms by virtual forces keep clear and connected, and how fast they are, by the paper's
//! rule and by ours.

use rayon::prelude::*;
use serde_json::{Value, json};
use swarms::bench::{Case, RULES, Row, SPEED, run, speed};
use swarms::{Phase, TooMany};

/// How many times each speed is measured.
const TRIES: usize = 20;

/// How fast one core flies a survey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speed {
    /// The name of the rule.
    pub rule: &'static str,
    /// The number of drones.
    pub drones: u16,
    /// Drone-rounds per second of the core's time.
    pub drone_rounds_per_s: f64,
    /// The least that is wanted.
    pub bound: f64,
}

/// Flies `cases` on all cores, `runs` times each, and calls `step` after each one.
///
/// # Errors
/// Where the number of drones of a case is none or too large.
pub fn fly(
    cases: &[Case],
    runs: usize,
    seed: u64,
    step: impl Fn() + Sync,
) -> Result<Vec<Row>, TooMany> {
    let rows = cases.par_iter().map(|case| {
        let rows = run(case, runs, seed);
        step();
        rows
    });
    Ok(rows.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

/// Measures the speed of both rules on one core.
///
/// # Errors
/// Where the number of drones is none or too large.
pub fn speeds() -> Result<Vec<Speed>, TooMany> {
    let mut speeds = Vec::new();
    for rule in &RULES {
        for (drones, bound) in SPEED {
            let drone_rounds_per_s = speed(rule, drones, TRIES)?;
            speeds.push(Speed { rule: rule.name, drones, drone_rounds_per_s, bound });
        }
    }
    Ok(speeds)
}

impl Speed {
    /// Returns a line if the speed is below its bound.
    #[must_use]
    pub fn missed(&self) -> Option<String> {
        let Self { rule, drones, drone_rounds_per_s, bound } = self;
        (drone_rounds_per_s < bound).then(|| {
            format!(
                "forces: {drone_rounds_per_s:.0} drone-rounds/s with {drones} drones by {rule}; \
                 bound {bound:.0}"
            )
        })
    }

    /// Returns the row as JSON.
    #[must_use]
    pub fn json(&self) -> Value {
        json!({
            "what": "speed of a survey on one core",
            "rule": self.rule,
            "drones": self.drones,
            "drone_rounds_per_s": self.drone_rounds_per_s.round(),
            "bound": self.bound,
        })
    }
}

/// Returns a row as JSON, with its share of the rounds of the paper's rule.
#[must_use]
pub fn json(row: &Row, rows: &[Row]) -> Value {
    json!({
        "phase": row.phase.name(),
        "place": if row.phase == Phase::Survey { "area" } else { row.place.name() },
        "drones": row.drones,
        "rule": row.rule,
        "runs": row.runs,
        "stuck": row.stuck,
        "steps": row.steps,
        "steps_sd": row.steps_sd,
        "own_steps": row.own_steps,
        "ratio_to_ideal": row.ratio_to_ideal,
        "over_paper": row.over_paper(rows),
        "min_drone_drone_dsafe": row.min_drone_drone_dsafe,
        "min_drone_wall_dsafe": row.min_drone_wall_dsafe,
        "links_lost": row.links_lost,
        "links_made": row.links_made,
        "connected": row.connected,
    })
}
