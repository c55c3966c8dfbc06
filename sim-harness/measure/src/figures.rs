//! Reproduces the paper's figure 3, A to F, and tests the paper's claims about it.
//!
//! * **A to C**: three corridors, the head at rest, relays anywhere: do the links become equal?
//! * **D**: an exploration, all drones at the mouth, the head at 0.2 m/s for 50 s.
//! * **E, F**: over many seeds of D: when were the links equal after the head had stopped, and how
//!   much do the relays still move? As in the paper both look at the first three links only.
//!
//! The head stops at the same place under every policy, so that all policies hold the same chain. A
//! policy that holds its head back until relays have come takes longer to get there.

mod claims;
mod exploration;

use input::InputError;
use rayon::prelude::*;
use serde_json::{Value, json};
use world::{SkeletonPlace, Spot};

use crate::campaign::{Figure, figures, fly, fraction, mean, quantile_of};
use crate::metrics::{Reference, RunMetrics};
use mission::Mission;
use mission::trace::Trace;
use scenario::{Drones, PilotStep, Scenario, Start};

pub use exploration::Explored;
use exploration::{explore, rest_us};

/// One of the three corridors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The name of its scenario.
    pub scenario: &'static str,
    /// Its own name.
    pub name: &'static str,
    /// Where the head rests in A to C and ends in D to F, m: there a head ends in the scenario that
    /// its policy does not hold back, to 2 cm.
    pub head_m: f32,
}

/// The three corridors.
pub const CORRIDORS: [Place; 3] = [
    Place { scenario: "paper-z10", name: "Z", head_m: 11.1 },
    Place { scenario: "paper-u10", name: "U", head_m: 11.09 },
    Place { scenario: "paper-wave10", name: "winding", head_m: 12.02 },
];
/// The policies that are flown unless others are asked for: the paper's variants, its K with a small
/// gain, and the default of the firmware.
pub const VARIANTS: [&str; 5] = ["t0", "t5", "k", "k-tuned", "chain"];
/// The paper's variants, whose exploration of the first corridor is drawn as panel D.
const PAPERS: [&str; 3] = ["t0", "t5", "k"];

/// Relays in the air in A to C: those that three links need.
const RESTING_RELAYS: usize = 2;

/// One policy in one corridor.
pub struct Cell {
    /// The corridor's scenario.
    pub scenario: &'static str,
    /// The policy's name.
    pub policy: &'static str,
    /// The runs for panels A to C: relays at random places, the head hovering.
    pub convergence: Vec<RunMetrics>,
    /// The runs for panels D to F: the exploration.
    pub exploration: Vec<Explored>,
}

/// All of figure 3.
pub struct Figures {
    /// The cells, corridor by corridor, in the order of [`CORRIDORS`] and of the policies.
    pub cells: Vec<Cell>,
    /// Panels A to C: the first policy that was recorded at rest, `k` where it was flown, with one
    /// run in each corridor.
    pub resting: Vec<Trace>,
    /// Panel D: one run of each of `PAPERS`, or of the first policy where none of them was flown,
    /// in the first corridor.
    pub exploring: Vec<(&'static str, Trace)>,
    /// How long explorations go on after the head's stop; the longest of the corridors.
    pub rest_us: u64,
}

/// Flies all missions of the figure with these policies.
///
/// # Errors
/// None, as long as the built-in scenarios are sound.
pub fn make(
    policies: &[&'static str],
    runs: usize,
    seed: u64,
    after_each: impl Fn() + Sync,
) -> Result<Figures, InputError> {
    let mut made =
        Figures { cells: Vec::new(), resting: Vec::new(), exploring: Vec::new(), rest_us: 0 };
    let first = policies.first().copied();
    let rests = policies.iter().copied().find(|policy| *policy == "k").or(first);
    let is_drawn = |policy| PAPERS.contains(&policy) || first == Some(policy);
    for (n, place) in CORRIDORS.into_iter().enumerate() {
        let Place { scenario, head_m, .. } = place;
        let exploring = Scenario::open(scenario)?;
        made.rest_us = made.rest_us.max(rest_us(&exploring));
        let resting = at_rest(&exploring, head_m);
        let world = exploring.world();
        let (known, known_resting) =
            (Reference::of(&exploring, &world), Reference::of(&resting, &world));
        for &policy in policies {
            let (Some(explorer), Some(rester)) =
                (exploring.with_policy(policy), resting.with_policy(policy))
            else {
                continue;
            };
            let convergence = fly(&rester, &world, &known_resting, seed, runs, &after_each);
            let exploration = (0..runs as u64)
                .into_par_iter()
                .map(|n| {
                    let seed = seed.wrapping_add(n);
                    let explored = explore(&explorer, (&world, head_m), &known, seed);
                    after_each();
                    explored
                })
                .collect();
            if rests == Some(policy) {
                made.resting.push(Mission::record(&rester, &world, seed));
            }
            if n == 0 && is_drawn(policy) {
                made.exploring.push((policy, Mission::record(&explorer, &world, seed)));
            }
            made.cells.push(Cell { scenario, policy, convergence, exploration });
        }
    }
    Ok(made)
}

/// The number of missions that [`make`] flies with so many policies.
#[must_use]
pub const fn missions(policies: usize, runs: usize) -> usize {
    2 * runs * CORRIDORS.len() * policies
}

/// The same corridor with all drones in the air and the head at rest.
fn at_rest(exploring: &Scenario, head_m: f32) -> Scenario {
    let hold = units::Order::explore(units::MetresPerSecond::ZERO);
    let head = SkeletonPlace::main(head_m);
    Scenario {
        drones: Drones {
            relays: RESTING_RELAYS,
            start: Start::Random { head: Spot::on(exploring.tunnel.skeleton(), head) },
            ..exploring.drones.clone()
        },
        depth_m: None,
        pilot: vec![PilotStep { at_us: 0, task: hold }],
        duration_us: RESTING_US,
        ..exploring.clone()
    }
}

/// The duration of the missions of A to C, µs.
pub const RESTING_US: u64 = 180_000_000;

impl Cell {
    fn metrics(&self) -> Vec<RunMetrics> {
        self.exploration.iter().map(|explored| explored.metrics).collect()
    }

    /// The cell's figures for panels A to C.
    #[must_use]
    pub fn convergence_figures(&self) -> Vec<Figure> {
        let wanted = [
            "c3",
            "c1",
            "c_gap1",
            "t3_median_s",
            "t3_p95_s",
            "t_gap1_median_s",
            "bound_s",
            "gap_db",
            "difference_db",
            "swing_p95_db",
            "position_sd_m",
            "path_m",
        ];
        figures(&self.convergence).into_iter().filter(|f| wanted.contains(&f.name)).collect()
    }

    /// The cell's figures for panels D to F.
    #[must_use]
    pub fn exploration_figures(&self) -> Vec<Figure> {
        let runs = self.metrics();
        let of = |value: fn(&Explored) -> f32| self.exploration.iter().map(value).collect();
        let [settled, variance, stopped]: [Vec<f32>; 3] =
            [of(|run| run.settled_s), of(|run| run.variance_m2), of(|run| run.stopped_s)];
        let wanted = [
            "launched",
            "needed",
            "excess",
            "false_launch",
            "under_launch",
            "violation",
            "peak_excess_db",
            "farthest_m",
            "gap_db",
            "swing_p95_db",
        ];
        let mut all = vec![
            Figure { name: "settled", estimate: fraction(&settled, |s| s.is_finite()) },
            Figure { name: "settled_median_s", estimate: quantile_of(&settled, 0.5, |s| *s) },
            Figure { name: "settled_p95_s", estimate: quantile_of(&settled, 0.95, |s| *s) },
            Figure { name: "position_variance_m2", estimate: mean(&variance, |v| *v) },
            Figure { name: "head_there_median_s", estimate: quantile_of(&stopped, 0.5, |s| *s) },
        ];
        all.extend(figures(&runs).into_iter().filter(|f| wanted.contains(&f.name)));
        all
    }
}

impl Figures {
    fn cell(&self, scenario: &str, policy: &str) -> Option<&Cell> {
        self.cells.iter().find(|cell| cell.scenario == scenario && cell.policy == policy)
    }

    /// Returns all cells and claims as JSON.
    #[must_use]
    pub fn json(&self, runs: usize, seed: u64) -> Value {
        let cells: Vec<_> = self
            .cells
            .iter()
            .map(|cell| {
                json!({
                    "scenario": cell.scenario,
                    "policy": cell.policy,
                    "convergence": crate::campaign::json(&cell.convergence_figures()),
                    "exploration": crate::campaign::json(&cell.exploration_figures()),
                })
            })
            .collect();
        let claims: Vec<_> = self.claims().iter().map(super::claim::Claim::json).collect();
        json!({
            "figure": "3",
            "runs": runs,
            "seed": seed,
            "version": env!("CARGO_PKG_VERSION"),
            "cells": cells,
            "claims": claims,
        })
    }
}

/// The name of a policy as the paper writes it.
#[must_use]
pub fn label(policy: &str) -> &str {
    match policy {
        "t0" => "T0",
        "t5" => "T5",
        "k" => "K",
        "k-tuned" => "K tuned",
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::exploration::THERE_M;
    use super::*;

    /// Under `chain` the head waits for relays on its way; the figure compares chains of one length.
    #[test]
    fn the_head_ends_at_the_same_place_under_every_policy() {
        for Place { scenario, head_m, .. } in CORRIDORS {
            let scenario = Scenario::open(scenario).unwrap();
            let world = scenario.world();
            let reference = Reference::of(&scenario, &world);
            for policy in ["k-tuned", "chain"] {
                let scenario = scenario.with_policy(policy).unwrap();
                let explored = explore(&scenario, (&world, head_m), &reference, 1);
                let off = (explored.metrics.farthest_m - head_m).abs();
                assert!(off < THERE_M, "{}, {policy}: {off} m", scenario.name);
                assert!(explored.stopped_s.is_finite() && explored.variance_m2.is_finite());
            }
        }
    }
}
