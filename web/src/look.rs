//! What the page draws: the place, the drones and the figures, as JSON. Lengths are in metres, angles in
//! radians, strengths in dBm; a value that does not exist is `null`.

use serde_json::{Value, json};
use sim_harness::measure::metrics::RunMetrics;
use sim_harness::mission::Mission;
use sim_harness::mission::trace::{DroneFrame, Ground, LinkFrame, Trace, order_words};
use sim_harness::scenario::Scenario;
use units::{MissionKind, Point2, Role};

/// A number, rounded to hundredths: of metres, these are finer than a pixel.
fn cm(value: f32) -> Value {
    rounded(value, 100.0)
}

/// A number, rounded to a multiple of 1/`steps`; `null` where it is not finite.
fn rounded(value: f32, steps: f64) -> Value {
    if value.is_finite() { json!((f64::from(value) * steps).round() / steps) } else { Value::Null }
}

fn line(points: &[Point2]) -> Value {
    points.iter().map(|at| json!([cm(at.x), cm(at.y)])).collect()
}

/// The walls and the centre-lines of a scenario, and the route of its map.
#[must_use]
pub fn place(scenario: &Scenario) -> Value {
    let plan = scenario.tunnel.floor_plan();
    let outlines: Value = plan.outlines.iter().map(|outline| line(outline)).collect();
    let centre_lines: Value = plan.centre_lines.iter().map(|edge| line(&edge.points)).collect();
    let route = scenario.route.as_ref().map(|route| {
        let warnings: Vec<_> = route.warnings.iter().map(|warning| warning.text.clone()).collect();
        let marks: Vec<_> = route.marks.iter().map(|mark| &mark.station).collect();
        json!({
            "from": route.from,
            "to": route.to,
            "length_m": (route.length_m * 10.0).round() / 10.0,
            "ended": route.ended.to_string(),
            "stations": marks,
            "warnings": warnings,
        })
    });
    json!({ "outlines": outlines, "centre_lines": centre_lines, "route": route })
}

/// The part of a member in its mission: a swarm and explorers have no head and no relays.
fn role(mission: MissionKind, role: Role) -> &'static str {
    match (mission, role) {
        (MissionKind::Chain, _) | (_, Role::Base) => role.name(),
        (MissionKind::Swarm | MissionKind::Explore, _) => "drone",
    }
}

/// What does not change during a mission.
#[must_use]
pub fn setting(scenario: &Scenario, seed: u64, trace: &Trace) -> Value {
    let nodes: Value = trace
        .nodes
        .iter()
        .map(|node| json!({ "name": node.to_string(), "role": role(scenario.mission, node.role) }))
        .collect();
    json!({
        "name": scenario.name,
        "title": scenario.title,
        "seed": seed,
        "duration_s": scenario.duration_s(),
        "fidelity": scenario.fidelity.name(),
        "mission": scenario.mission.name(),
        "relays": scenario.drones.relays,
        "launch_dbm": rounded(scenario.agent.launch.limit.0, 10.0),
        "retreat_dbm": rounded(scenario.agent.retreat.limit.0, 10.0),
        "packet_loss": rounded(scenario.radio.reception.loss_rate, 1000.0),
        "nodes": nodes,
        "place": place(scenario),
    })
}

fn link(link: Option<&LinkFrame>) -> Value {
    link.map_or(Value::Null, |link| {
        json!({
            "peer": link.peer.0,
            "dbm": rounded(link.filtered.0, 10.0),
            "true_dbm": rounded(link.truth.0, 10.0),
        })
    })
}

/// What explorers know of their area together: where the cells lie, and the cells that have changed since the first
/// `known` changes, by their numbers, with what they are now. `null` where nothing is explored.
#[must_use]
pub fn team_map(trace: &Trace, known: usize) -> Value {
    let map = &trace.team_map;
    map.lattice().map_or(Value::Null, |lattice| {
        let changes = map.changes().get(known..).unwrap_or_default();
        let cells: Vec<usize> = changes.iter().map(|change| change.cell).collect();
        let grounds: Vec<&str> = changes.iter().map(|change| ground(change.ground)).collect();
        json!({
            "corner": [lattice.corner.x, lattice.corner.y],
            "side": lattice.side_m,
            "columns": lattice.columns,
            "rows": lattice.rows,
            "cells": cells,
            "grounds": grounds,
        })
    })
}

const fn ground(ground: Ground) -> &'static str {
    match ground {
        Ground::Unknown => "unknown",
        Ground::Free => "free",
        Ground::Frontier => "frontier",
        Ground::Wall => "wall",
    }
}

fn drone(mission: &Mission<'_>, number: usize, drone: &DroneFrame) -> Value {
    json!({
        "x": rounded(drone.pose.at.x, 1000.0),
        "y": rounded(drone.pose.at.y, 1000.0),
        "z": cm(drone.height),
        "yaw": rounded(drone.pose.yaw.0, 1000.0),
        "way": cm(drone.way),
        "state": drone.state.name(),
        "forward": cm(drone.commanded[0]),
        "battery_v": cm(drone.battery_v),
        "lost": mission.is_lost(number),
        "goal": drone.goal.map(|goal| json!([cm(goal.x), cm(goal.y)])),
        "front": link(drone.front.as_ref()),
        "back": link(drone.back.as_ref()),
    })
}

/// A mission at this moment, and whether it has ended.
#[must_use]
pub fn frame(mission: &Mission<'_>, has_ended: bool) -> Value {
    let frame = mission.frame();
    let drones: Value =
        frame.drones.iter().enumerate().map(|(n, it)| drone(mission, n, it)).collect();
    json!({
        "t": frame.time_us as f64 * 1e-6,
        "order": order_words(frame.order),
        "recalled": mission.is_recalled(),
        "over": has_ended,
        "drones": drones,
    })
}

/// The figures of a mission so far.
#[must_use]
pub fn figures(scenario: &Scenario, mission: &Mission<'_>, metrics: &RunMetrics) -> Value {
    let RunMetrics { radio, .. } = metrics;
    json!({
        "farthest_m": cm(metrics.farthest_m),
        "weak_share": rounded(metrics.violation, 1000.0),
        "order_delay_s": cm(radio.pilot_delay_p95_s),
        "packets_sent": radio.packets.sent,
        "wall_contacts": mission.wall_contacts(),
        "drone_contacts": mission.drone_contacts(),
        "explored": metrics.explore.as_ref().map(|explore| rounded(explore.explored, 1000.0)),
        "covered": metrics.swarm.as_ref().map(|swarm| rounded(swarm.covered, 1000.0)),
        "ends_s": scenario.duration_s(),
    })
}
