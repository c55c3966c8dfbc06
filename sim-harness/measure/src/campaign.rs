//! Flies many seeded missions on all cores, and estimates their figures with confidence intervals.
//!
//! Seeds are consecutive from the first one on; results are collected in the order of the seeds,
//! so a campaign's figures do not depend on the number of threads.

pub mod grid;
mod rows;
mod verdicts;

use std::sync::atomic::{AtomicBool, Ordering};
use world::World;

use rayon::prelude::*;
use serde_json::{Map, Value, json};

use crate::metrics::{ExploreMetrics, HoldMetrics, Reference, RunMetrics, SwarmMetrics};
use crate::verdict::{Judgement, judged};
use bodies::craft::record::FlightMetrics;
use scenario::Scenario;

pub use rows::{COLUMNS, Cell, Column, Kind, Outcome, Row};
pub use verdicts::Verdicts;

/// Flies every run, and returns the figures in the order of the seeds.
#[must_use]
pub fn fly(
    scenario: &Scenario,
    world: &World,
    reference: &Reference,
    first_seed: u64,
    runs: usize,
    after_each: impl Fn() + Sync,
) -> Vec<RunMetrics> {
    let never = AtomicBool::new(false);
    let flown = fly_until(&never, scenario, world, reference, first_seed, runs, after_each);
    flown.into_iter().map(|run| run.metrics).collect()
}

/// One run of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The seed.
    pub seed: u64,
    /// The figures.
    pub metrics: RunMetrics,
    /// The verdict.
    pub judgement: Judgement,
}

/// Flies the runs until `stop` is set, and returns each that had begun by then, in the order of the
/// seeds.
#[must_use]
pub fn fly_until(
    stop: &AtomicBool,
    scenario: &Scenario,
    world: &World,
    reference: &Reference,
    first_seed: u64,
    runs: usize,
    after_each: impl Fn() + Sync,
) -> Vec<Run> {
    (0..runs as u64)
        .into_par_iter()
        .filter(|_| !stop.load(Ordering::Relaxed))
        .map(|n| {
            let seed = first_seed.wrapping_add(n);
            let (metrics, judgement) = judged(scenario, world, reference, seed);
            after_each();
            Run { seed, metrics, judgement }
        })
        .collect()
}

/// Flies the missions of these seeds until `stop` is set, with the place of the scenario in a grid.
/// Returns each that had begun by then, in the order of the seeds.
#[must_use]
pub fn fly_rows(
    stop: &AtomicBool,
    scenario: &Scenario,
    point: usize,
    seeds: &[u64],
    after_each: impl Fn(&Row) + Sync,
) -> Vec<Row> {
    let world = scenario.world();
    let reference = Reference::of(scenario, &world);
    seeds
        .par_iter()
        .filter(|_| !stop.load(Ordering::Relaxed))
        .map(|&seed| {
            let (metrics, judgement) = judged(scenario, &world, &reference, seed);
            let row = Row::of(point, &Run { seed, metrics, judgement });
            after_each(&row);
            row
        })
        .collect()
}

/// A figure with its 95 % confidence interval. In JSON, a value that is not finite is `null`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The figure.
    pub value: f64,
    /// The limits of the 95 % confidence interval; `None` where there are too few runs.
    pub interval: Option<(f64, f64)>,
}

impl Estimate {
    fn json(&self) -> Value {
        let (low, high) = self.interval.map_or((None, None), |(l, h)| (finite(l), finite(h)));
        json!({ "value": finite(self.value), "low": low, "high": high })
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// The part of the runs for which `holds` is true, with its Wilson score interval, which is of use
/// also where that is none or all of them.
#[must_use]
pub fn fraction<R>(runs: &[R], holds: impl Fn(&R) -> bool) -> Estimate {
    let count = runs.len().max(1) as f64;
    let value = runs.iter().filter(|run| holds(run)).count() as f64 / count;
    Estimate { value, interval: Some(wilson(value, count)) }
}

/// Wilson's score interval of a share that was seen in `count` trials.
fn wilson(share: f64, count: f64) -> (f64, f64) {
    let z2 = Z * Z;
    let middle = (share + z2 / (2.0 * count)) / (1.0 + z2 / count);
    let spread = Z * (share * (1.0 - share) / count + z2 / (4.0 * count * count)).sqrt();
    let half = spread / (1.0 + z2 / count);
    ((middle - half).max(0.0), (middle + half).min(1.0))
}

/// Standard deviations on each side of the middle that hold 95 % of a normal distribution.
const Z: f64 = 1.96;

/// The mean over the runs, with the normal interval of its standard error.
#[must_use]
pub fn mean<R>(runs: &[R], of: impl Fn(&R) -> f32) -> Estimate {
    let values: Vec<f64> = runs.iter().map(|run| f64::from(of(run))).collect();
    let count = values.len().max(1) as f64;
    let middle = values.iter().sum::<f64>() / count;
    let spread = values.iter().map(|v| (v - middle).powi(2)).sum::<f64>();
    let error = (spread / (count - 1.0).max(1.0) / count).sqrt();
    Estimate { value: middle, interval: Some((middle - Z * error, middle + Z * error)) }
}

/// Returns the q-quantile over *all* runs; a run that never reached the event counts as infinite.
#[must_use]
pub fn quantile_of<R>(runs: &[R], q: f64, of: impl Fn(&R) -> f32) -> Estimate {
    let mut values: Vec<f64> = runs.iter().map(|run| f64::from(of(run))).collect();
    values.sort_by(f64::total_cmp);
    let place = ((values.len().max(1) - 1) as f64 * q).round() as usize;
    let value = values.get(place).copied().unwrap_or(f64::NAN);
    let ranks = quantile_ranks(values.len(), q);
    let interval = ranks.and_then(|(low, high)| Some((*values.get(low)?, *values.get(high)?)));
    Estimate { value, interval }
}

/// Ranks of the sorted values between which the q-quantile lies, 19 times in 20: Wilson's interval
/// of the share q, as places in the list. Needs two values on either side of the quantile.
fn quantile_ranks(count: usize, q: f64) -> Option<(usize, usize)> {
    let below = (count as f64 * q).round() as usize;
    let above = count.checked_sub(below)?;
    if below < 2 || above < 2 {
        return None;
    }
    let (low, high) = wilson(below as f64 / count as f64, count as f64);
    let rank = |share: f64| ((share * count as f64) as usize).min(count - 1);
    Some((rank(low), rank(high)))
}

/// A named figure of a campaign.
pub struct Figure {
    /// The name of the figure, including its unit.
    pub name: &'static str,
    /// The value of the figure over all runs.
    pub estimate: Estimate,
}

/// All figures that the scenario of a campaign has; figures that need a head in the air at the
/// start are left out where it stands on the ground.
#[must_use]
pub fn figures(runs: &[RunMetrics]) -> Vec<Figure> {
    let figure = |name, estimate| Figure { name, estimate };
    let median = |of: fn(&RunMetrics) -> f32| quantile_of(runs, 0.5, of);
    let held = |of: fn(&HoldMetrics) -> f32| mean(runs, |run| run.held(of));
    let held_by = |part, of: fn(&HoldMetrics) -> f32| quantile_of(runs, part, |run| run.held(of));
    let none = Estimate { value: f64::NAN, interval: None };
    // Without a hold, no run converges.
    let has_hold = runs.first().is_none_or(|run| run.hold.is_ok());
    let converged = |of: fn(&HoldMetrics) -> f32| {
        if has_hold { fraction(runs, |run| run.held(of).is_finite()) } else { none }
    };
    // Where no relay can be launched, there is no false launch.
    let launches = |holds: fn(&RunMetrics) -> bool| match runs.first() {
        Some(run) if !run.launched.is_nan() => fraction(runs, holds),
        _ => none,
    };
    // Where no drone is lost, nothing is repaired.
    let repaired = |holds: fn(&RunMetrics) -> bool| match runs.first() {
        Some(run) if !run.held(|hold| hold.t_repair_s).is_nan() => fraction(runs, holds),
        _ => none,
    };
    let called_down = match runs.first() {
        Some(run) if !run.still_flying.is_nan() => fraction(runs, |run| run.still_flying == 0.0),
        _ => none,
    };
    let all = vec![
        figure("c3", converged(|hold| hold.t3_s)),
        figure("c1", converged(|hold| hold.t1_s)),
        figure("c_gap1", converged(|hold| hold.t_gap1_s)),
        figure("t3_median_s", held_by(0.5, |hold| hold.t3_s)),
        figure("t3_p95_s", held_by(0.95, |hold| hold.t3_s)),
        figure("t_gap1_median_s", held_by(0.5, |hold| hold.t_gap1_s)),
        figure("c_repair", repaired(|r| r.held(|hold| hold.t_repair_s).is_finite())),
        figure("t_repair_median_s", held_by(0.5, |hold| hold.t_repair_s)),
        figure("t_repair_p95_s", held_by(0.95, |hold| hold.t_repair_s)),
        figure("bound_s", median(|r| r.bound_s)),
        figure("t_gap1_over_bound", median(|r| r.held(|hold| hold.t_gap1_s) / r.bound_s.max(1.0))),
        figure("gap_db", held(|hold| hold.gap_db)),
        figure("difference_db", held(|hold| hold.difference_db)),
        figure("hold_spread_db", held(|hold| hold.spread_db)),
        figure("swing_p95_db", held(|hold| hold.swing_p95_db)),
        figure("position_sd_m", held(|hold| hold.position_sd_m)),
        figure("path_m", held(|hold| hold.path_m)),
        figure("hold_violation", held(|hold| hold.violation)),
        figure("relays_beyond_need", held(|hold| hold.relays_beyond_need)),
        figure("cruise_gap_db", mean(runs, |r| r.cruise_gap_db)),
        figure("launched", mean(runs, |r| r.launched)),
        figure("needed", mean(runs, |r| r.needed)),
        figure("excess", mean(runs, excess)),
        figure("false_launch", launches(|r| excess(r) > 0.0)),
        figure("under_launch", launches(|r| excess(r) < 0.0)),
        figure("violation", mean(runs, |r| r.violation)),
        figure("peak_excess_db", mean(runs, |r| r.peak_excess_db)),
        figure("farthest_m", mean(runs, |r| r.farthest_m)),
        figure("t_farthest_median_s", median(|r| r.t_farthest_s)),
        figure("head_heard_until_median_s", median(|r| r.head_heard_until_s)),
        figure("all_down", called_down),
        figure("wall_contact", fraction(runs, |r| r.wall_contacts > 0)),
        figure("drone_contact", fraction(runs, |r| r.drone_contacts > 0)),
        figure("ground_contact", fraction(runs, |r| r.ground_contacts > 0)),
        figure("order_lost", fraction(runs, |r| r.order_lost > 0)),
        figure("swarm_finished", swarm(runs, |s| f32::from(u8::from(s.unfinished == 0)))),
        figure("covered", swarm(runs, |s| s.covered)),
        figure("surveyed_s", swarm(runs, |s| s.surveyed_s)),
        figure("gathered_s", swarm(runs, |s| s.gathered_s)),
        figure("across_s", swarm(runs, |s| s.across_s)),
        figure("closest_drones_m", swarm(runs, |s| s.closest_drones_m)),
        figure("explored", explore(runs, |e| e.explored)),
        figure("walls_found", explore(runs, |e| e.walls_found)),
        figure("false_walls", explore(runs, |e| e.false_walls)),
        figure("false_free", explore(runs, |e| e.false_free)),
        figure("t50_s", explore(runs, |e| e.t50_s)),
        figure("t99_s", explore(runs, |e| e.t99_s)),
        figure("ended", explore(runs, |e| f32::from(u8::from(e.unfinished == 0)))),
        figure("ended_s", explore(runs, |e| e.ended_s)),
        figure("explorers_apart_m", explore(runs, |e| e.closest_drones_m)),
        figure("max_tilt_deg", flown(runs, |f| f.max_tilt_deg)),
        figure("max_rate_dps", flown(runs, |f| f.max_rate_dps)),
        figure("velocity_error_mps", flown(runs, |f| f.velocity_error_mps)),
        figure("min_battery_v", flown(runs, |f| f.min_battery_v)),
        figure("brought_down", flown(runs, |f| (f.ends.iter().skip(1).sum::<u32>()) as f32)),
    ];
    all.into_iter().filter(|figure| !figure.estimate.value.is_nan()).collect()
}

/// The mean of a figure that only swarms have.
fn swarm(runs: &[RunMetrics], of: impl Fn(&SwarmMetrics) -> f32) -> Estimate {
    mean(runs, |run| run.swarm.as_ref().map_or(f32::NAN, &of))
}

/// The mean of a figure that only explorations have.
fn explore(runs: &[RunMetrics], of: impl Fn(&ExploreMetrics) -> f32) -> Estimate {
    mean(runs, |run| run.explore.as_ref().map_or(f32::NAN, &of))
}

/// The mean of a figure that only rigid bodies have.
fn flown(runs: &[RunMetrics], of: impl Fn(&FlightMetrics) -> f32) -> Estimate {
    mean(runs, |run| run.flight.as_ref().map_or(f32::NAN, &of))
}

/// The number of relays that flew, less the number that an optimal chain needs.
#[must_use]
pub fn excess(run: &RunMetrics) -> f32 {
    run.launched - run.needed
}

/// The figures as a JSON object by name.
#[must_use]
pub fn json(figures: &[Figure]) -> Value {
    let entries = figures.iter().map(|f| (f.name.to_owned(), f.estimate.json()));
    Value::Object(entries.collect::<Map<_, _>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::{Scenario, builtin};

    /// Ranks that the crate `stats-ci` gave.
    #[test]
    fn a_quantile_lies_between_these_ranks() {
        assert_eq!(quantile_ranks(15, 0.5), Some((4, 11)));
        assert_eq!(quantile_ranks(15, 0.4), Some((2, 9)));
        assert_eq!(quantile_ranks(3, 0.5), None);
        assert_eq!(quantile_ranks(20, 0.99), None);
    }

    #[test]
    fn a_campaign_that_is_stopped_keeps_the_runs_that_had_begun() {
        let scenario =
            Scenario { duration_us: 200_000, ..Scenario::open(builtin::DEMONSTRATION).unwrap() };
        let world = scenario.world();
        let reference = Reference::of(&scenario, &world);
        let stop = AtomicBool::new(false);
        let fly = || {
            fly_until(&stop, &scenario, &world, &reference, 7, 1_000, || {
                stop.store(true, Ordering::Relaxed);
            })
        };
        let flown = fly();
        assert!((1..1_000).contains(&flown.len()), "{}", flown.len());
        assert!(flown.is_sorted_by(|one, next| one.seed < next.seed));
        assert!(fly().is_empty(), "none begins after the stop");
    }
}
