//! One exploration of panels D to F: the head flies to its place and stops, and the chain settles.

use world::World;

use crate::metrics::{Reference, RunMetrics, Watch, converged_at};
use mission::{Linked, Mission};
use scenario::{PilotStep, Scenario};

/// One exploration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explored {
    /// The whole mission's figures.
    pub metrics: RunMetrics,
    /// The time of the mission at which the head stopped at its place, s; infinite where it did not
    /// come there.
    pub stopped_s: f32,
    /// The time from the head's stop until the first three links converged to 3 dB, s.
    pub settled_s: f32,
    /// The variance of the positions of the first two relays over the second half of the time after
    /// the head's stop, m²; NaN where the head did not come to its place, or a relay was not there.
    pub variance_m2: f32,
}

/// How far the head flies on after the order to stop, m.
const RUN_OUT_M: f32 = 0.06;
/// A head that is no farther from its place than this at the order to stop has come there, m.
pub(super) const THERE_M: f32 = 0.15;
/// The time for which a head that is held back may fly on after the other policies' heads have
/// stopped, µs: twice the time for which those fly.
const LATEST_US: u64 = 106_000_000;

/// Flies the scenario's exploration; where the head is not at its place `head_m` when the pilot stops
/// it, the pilot stops it later, when it comes there.
pub(super) fn explore(
    scenario: &Scenario,
    place: (&World, f32),
    reference: &Reference,
    seed: u64,
) -> Explored {
    let explored = flown(scenario, place, reference, seed);
    if explored.stopped_s.is_finite() {
        return explored;
    }
    match arrival_us(&stopping_at(scenario, stop_us(scenario) + LATEST_US), place, seed) {
        // The same seed flies the same way until the order differs.
        Some(at_us) => flown(&stopping_at(scenario, at_us), place, reference, seed),
        None => explored,
    }
}

/// When the pilot stops the head: the last order.
fn stop_us(scenario: &Scenario) -> u64 {
    scenario.pilot.last().map_or(0, |step| step.at_us)
}

/// How long an exploration goes on after the head's stop.
pub(super) fn rest_us(scenario: &Scenario) -> u64 {
    scenario.duration_us - stop_us(scenario)
}

/// The same exploration with the head stopped at another time, and as long a rest after it.
fn stopping_at(scenario: &Scenario, at_us: u64) -> Scenario {
    let rest_us = rest_us(scenario);
    let mut pilot = scenario.pilot.clone();
    if let Some(last) = pilot.last_mut() {
        *last = PilotStep { at_us, ..*last };
    }
    Scenario { pilot, duration_us: at_us + rest_us, ..scenario.clone() }
}

/// The moment at which the head comes to its place before its pilot stops it.
fn arrival_us(scenario: &Scenario, (world, head_m): (&World, f32), seed: u64) -> Option<u64> {
    let mut mission = Mission::new(scenario, world, seed);
    while mission.time_us() < stop_us(scenario) {
        mission.round();
        if head_way(&mission) >= head_m - RUN_OUT_M {
            return Some(mission.time_us());
        }
    }
    None
}

fn head_way(mission: &Mission<'_>) -> f32 {
    mission.ways().next().unwrap_or(f32::NAN)
}

fn flown(
    scenario: &Scenario,
    (world, head_m): (&World, f32),
    reference: &Reference,
    seed: u64,
) -> Explored {
    let stops_us = stop_us(scenario);
    let mut mission = Mission::new(scenario, world, seed);
    let mut watch = Watch::new(scenario, world, reference);
    let mut chain = Vec::new();
    let mut differences = Vec::new();
    let mut positions: Vec<[f32; 2]> = Vec::new();
    let mut is_there = false;
    while !mission.is_over() {
        mission.round();
        watch.look(&mission);
        if mission.time_us() < stops_us {
            continue;
        }
        if positions.is_empty() {
            is_there = head_way(&mission) >= head_m - RUN_OUT_M - THERE_M;
        }
        mission.chain(&mut chain);
        let since_stop = ((mission.time_us() - stops_us) as f64 * 1e-6) as f32;
        differences.push((since_stop, first_three(&chain, world)));
        let relay = |n| mission.ways().nth(n).unwrap_or(f32::NAN);
        positions.push([relay(1), relay(2)]);
    }
    let metrics = watch.verdict(&mission);
    if !is_there {
        let (stopped_s, settled_s) = (f32::INFINITY, f32::INFINITY);
        return Explored { metrics, stopped_s, settled_s, variance_m2: f32::NAN };
    }
    let half = &positions[positions.len() / 2..];
    Explored {
        metrics,
        stopped_s: (stops_us as f64 * 1e-6) as f32,
        settled_s: converged_at(differences.iter().copied(), 3.0),
        variance_m2: variance(half),
    }
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
