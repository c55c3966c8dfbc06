//! Reproduces the paper's figure 3, A to F, and tests the paper's claims about it.
//!
//! * **A to C**: three corridors, the head at rest, relays anywhere: do the links become equal?
//! * **D**: an exploration, all drones at the mouth, the head at 0.2 m/s for 50 s, with T0, T5 and K.
//! * **E, F**: over many seeds of D: when were the links equal after the head had stopped, and how
//!   much do the relays still move? As in the paper both look at the first three links only.

use rayon::prelude::*;
use serde_json::{Value, json};

use crate::input_error::InputError;
use crate::measure::campaign::{Estimate, Figure, figures, fly, fraction, mean, quantile_of};
use crate::measure::metrics::{Reference, RunMetrics, Watch, converged_at};
use crate::measure::trace::Trace;
use crate::mission::{Linked, Mission, World};
use crate::output::pictures::{
    BoxChart, BoxGroup, BoxPlotData, Corridor, Figure3, Picture, PictureError, Variant, figure3,
};
use crate::scenario::{Drones, PilotStep, Scenario, Spot, Start};
use crate::world::SkeletonPlace;

/// The three corridors.
pub const CORRIDORS: [(&str, &str); 3] =
    [("paper-z10", "Z"), ("paper-u10", "U"), ("paper-wave10", "winding")];
/// The paper's variants, and the default policy of the firmware.
pub const VARIANTS: [&str; 4] = ["t0", "t5", "k", "chain"];

/// Seconds into the mission at which the head stops in the exploration scenarios.
const HEAD_STOPS_S: f32 = 57.0;
/// The place of the head in A to C: that at which it ends in D to F, in metres.
const HEAD_RESTS_M: f32 = 11.75;
/// Relays in the air in A to C: those that three links need.
const RESTING_RELAYS: usize = 2;

/// One variant in one corridor.
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

/// One exploration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explored {
    /// The whole mission's figures.
    pub metrics: RunMetrics,
    /// The time from the head's stop until the first three links converged to 3 dB, s.
    pub settled_s: f32,
    /// The variance of the positions of the first two relays over the second half of the time after
    /// the head's stop, m².
    pub variance_m2: f32,
}

/// All of figure 3.
pub struct Figures {
    /// The cells, corridor by corridor, in the order of [`CORRIDORS`] and [`VARIANTS`].
    pub cells: Vec<Cell>,
    /// Panels A to C: one run of `k` in each corridor.
    resting: Vec<Trace>,
    /// Panel D: one run of each of the paper's variants in the first corridor.
    exploring: Vec<Trace>,
}

/// A claim of the paper, and what was found.
pub struct Claim {
    /// The claim, in our words.
    pub claim: &'static str,
    /// The panel that it is made from.
    pub panel: &'static str,
    /// Whether the simulation confirms the claim.
    pub holds: bool,
    /// The figures that decide this.
    pub found: String,
}

/// Flies all missions of the figure.
///
/// # Errors
/// None, as long as the built-in scenarios are sound.
pub fn make(runs: usize, seed: u64, after_each: impl Fn() + Sync) -> Result<Figures, InputError> {
    let mut made = Figures { cells: Vec::new(), resting: Vec::new(), exploring: Vec::new() };
    for (n, (name, _)) in CORRIDORS.into_iter().enumerate() {
        let exploring = Scenario::open(name)?;
        let resting = at_rest(&exploring);
        let world = World::of(&exploring);
        let (known, known_resting) =
            (Reference::of(&exploring, &world), Reference::of(&resting, &world));
        for policy in VARIANTS {
            let (Some(explorer), Some(rester)) =
                (exploring.with_policy(policy), resting.with_policy(policy))
            else {
                continue;
            };
            let convergence = fly(&rester, &world, &known_resting, seed, runs, &after_each);
            let exploration = (0..runs as u64)
                .into_par_iter()
                .map(|n| {
                    let explored = explore(&explorer, &world, &known, seed.wrapping_add(n));
                    after_each();
                    explored
                })
                .collect();
            if policy == "k" {
                made.resting.push(Mission::record(&rester, &world, seed));
            }
            if n == 0 && policy != "chain" {
                made.exploring.push(Mission::record(&explorer, &world, seed));
            }
            made.cells.push(Cell { scenario: name, policy, convergence, exploration });
        }
    }
    Ok(made)
}

/// The number of missions that [`make`] flies.
#[must_use]
pub const fn missions(runs: usize) -> usize {
    2 * runs * CORRIDORS.len() * VARIANTS.len()
}

/// The same corridor with all drones in the air and the head at rest.
fn at_rest(exploring: &Scenario) -> Scenario {
    let hold = units::Order::explore(units::MetresPerSecond::ZERO);
    let head = SkeletonPlace::main(HEAD_RESTS_M);
    Scenario {
        drones: Drones {
            relays: RESTING_RELAYS,
            start: Start::Random { head: Spot::on(exploring.tunnel.skeleton(), head) },
            ..exploring.drones.clone()
        },
        depth_m: None,
        pilot: vec![PilotStep { at_us: 0, task: hold }],
        duration_us: 180_000_000,
        ..exploring.clone()
    }
}

fn explore(scenario: &Scenario, world: &World, reference: &Reference, seed: u64) -> Explored {
    let mut mission = Mission::new(scenario, world, seed);
    let mut watch = Watch::new(scenario, world, reference);
    let mut chain = Vec::new();
    let mut differences = Vec::new();
    let mut positions: Vec<[f32; 2]> = Vec::new();
    while !mission.is_over() {
        mission.round();
        watch.look(&mission);
        if mission.time_us() as f32 * 1e-6 >= HEAD_STOPS_S {
            mission.chain(&mut chain);
            let since_stop = (mission.time_us() as f64 * 1e-6) as f32 - HEAD_STOPS_S;
            differences.push((since_stop, first_three(&chain, world)));
            let relay = |n| mission.ways().nth(n).unwrap_or(f32::NAN);
            positions.push([relay(1), relay(2)]);
        }
    }
    let settled_s = converged_at(differences.iter().copied(), 3.0);
    let half = &positions[positions.len() / 2..];
    Explored { metrics: watch.verdict(&mission), settled_s, variance_m2: variance(half) }
}

/// The largest difference between adjacent ones of the three links next to the head.
fn first_three(chain: &[Linked], world: &World) -> f32 {
    let from = chain.len().saturating_sub(4);
    let nodes = &chain[from..];
    if nodes.len() < 4 {
        return f32::INFINITY;
    }
    let loss = |pair: &[Linked]| world.radio.strength(pair[0].place, pair[1].place).loss().0;
    let losses: Vec<f32> = nodes.windows(2).map(loss).collect();
    losses.windows(2).map(|pair| (pair[0] - pair[1]).abs()).fold(0.0, f32::max)
}

/// Mean over the two relays of the variance of their positions.
fn variance(positions: &[[f32; 2]]) -> f32 {
    let count = positions.len().max(1) as f32;
    let of = |relay: usize| {
        let middle = positions.iter().map(|p| p[relay]).sum::<f32>() / count;
        positions.iter().map(|p| (p[relay] - middle).powi(2)).sum::<f32>() / count
    };
    0.5 * (of(0) + of(1))
}

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
        let settled: Vec<f32> = self.exploration.iter().map(|e| e.settled_s).collect();
        let variance: Vec<f32> = self.exploration.iter().map(|e| e.variance_m2).collect();
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
        ];
        all.extend(figures(&runs).into_iter().filter(|f| wanted.contains(&f.name)));
        all
    }
}

impl Figures {
    fn cell(&self, scenario: &str, policy: &str) -> Option<&Cell> {
        self.cells.iter().find(|cell| cell.scenario == scenario && cell.policy == policy)
    }

    /// One figure of two variants in every corridor, and whether `holds` for all pairs.
    fn compare(
        &self,
        (one, other): (&str, &str),
        figure: impl Fn(&Cell) -> Estimate,
        holds: impl Fn(f64, f64) -> bool,
        unit: &str,
    ) -> (bool, String) {
        let mut all = true;
        let mut found = Vec::new();
        for (scenario, _) in CORRIDORS {
            let (Some(a), Some(b)) = (self.cell(scenario, one), self.cell(scenario, other)) else {
                continue;
            };
            let (a, b) = (figure(a).value, figure(b).value);
            all &= holds(a, b);
            found.push(format!("{scenario} {one} {a:.3} {other} {b:.3}{unit}"));
        }
        (all, found.join("; "))
    }

    /// The paper's claims about figure 3.
    #[must_use]
    pub fn claims(&self) -> Vec<Claim> {
        let claim =
            |panel, claim, (holds, found): (bool, String)| Claim { claim, panel, holds, found };
        let named = |cell: &Cell, name: &str, exploration: bool| {
            let all =
                if exploration { cell.exploration_figures() } else { cell.convergence_figures() };
            let found = all.into_iter().find(|figure| figure.name == name);
            found.map_or(Estimate { value: f64::NAN, interval: None }, |figure| figure.estimate)
        };
        vec![
            claim(
                "A to C",
                "all runs converge to equal links (3 dB) in all three corridors",
                self.compare(("k", "chain"), |c| named(c, "c3", false), |k, _| k >= 0.99, ""),
            ),
            claim(
                "D",
                "raw signal (T0) launches relays that are not needed, the filter (K) does not",
                self.compare(
                    ("t0", "k"),
                    |c| named(c, "false_launch", true),
                    |t0, k| t0 > k && k < 0.05,
                    "",
                ),
            ),
            claim(
                "E",
                "K converges faster than T5 (median after the head's stop)",
                self.compare(
                    ("k", "t5"),
                    |c| named(c, "settled_median_s", true),
                    |k, t5| k < t5,
                    " s",
                ),
            ),
            claim(
                "F",
                "K oscillates less than T0 (position variance)",
                self.compare(
                    ("k", "t0"),
                    |c| named(c, "position_variance_m2", true),
                    |k, t0| k < t0,
                    " m2",
                ),
            ),
            claim(
                "F",
                "T5 oscillates less than T0 (position variance)",
                self.compare(
                    ("t5", "t0"),
                    |c| named(c, "position_variance_m2", true),
                    |t5, t0| t5 < t0,
                    " m2",
                ),
            ),
        ]
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
                    "convergence": crate::measure::campaign::json(&cell.convergence_figures()),
                    "exploration": crate::measure::campaign::json(&cell.exploration_figures()),
                })
            })
            .collect();
        let claims: Vec<_> = self
            .claims()
            .iter()
            .map(|c| {
                json!({ "panel": c.panel, "claim": c.claim, "holds": c.holds, "found": c.found })
            })
            .collect();
        json!({
            "figure": "3",
            "runs": runs,
            "seed": seed,
            "version": env!("CARGO_PKG_VERSION"),
            "cells": cells,
            "claims": claims,
        })
    }

    /// The whole figure on one page.
    ///
    /// # Errors
    /// [`PictureError`] where a picture cannot be drawn.
    pub fn picture(&self, runs: usize) -> Result<Picture, PictureError> {
        let subtitle = format!(
            "A to C: relays anywhere, head at rest, K. D: exploration of the Z. E, F: {runs} explorations each."
        );
        let corridors = CORRIDORS.iter().zip(&self.resting);
        let variants = ["T0", "T5", "K"].into_iter().zip(&self.exploring);
        figure3(&Figure3 {
            title: "U-Chain, figure 3 again",
            subtitle: &subtitle,
            corridors: corridors.map(|((_, name), trace)| Corridor { name, trace }).collect(),
            exploration: variants.map(|(name, trace)| Variant { name, trace }).collect(),
            convergence: self.convergence_chart(),
            variance: self.variance_chart(),
        })
    }

    /// Draws panel E, the times of convergence.
    #[must_use]
    pub fn convergence_chart(&self) -> BoxChart {
        BoxChart {
            title: "Links equal after the head's stop".into(),
            value_name: "Time to 3 dB, s".into(),
            infinite_name: "never".into(),
            groups: self.groups(|explored| explored.settled_s),
        }
    }

    /// Draws panel F, the variances of the positions.
    #[must_use]
    pub fn variance_chart(&self) -> BoxChart {
        BoxChart {
            title: "How much the relays still move".into(),
            value_name: "Position variance, m\u{b2}".into(),
            infinite_name: "never".into(),
            groups: self.groups(|explored| explored.variance_m2),
        }
    }

    fn groups(&self, of: fn(&Explored) -> f32) -> Vec<BoxGroup> {
        let series = |scenario: &str| {
            let cells = self.cells.iter().filter(|cell| cell.scenario == scenario);
            cells
                .map(|cell| BoxPlotData {
                    name: label(cell.policy).into(),
                    values: cell.exploration.iter().map(of).collect(),
                })
                .collect()
        };
        CORRIDORS
            .iter()
            .map(|(scenario, name)| BoxGroup { label: (*name).into(), series: series(scenario) })
            .collect()
    }
}

fn label(policy: &str) -> &str {
    match policy {
        "t0" => "T0",
        "t5" => "T5",
        "k" => "K",
        other => other,
    }
}
