//! The summary of a mission as JSON.

use agent::State;
use maps::Route;
use serde_json::{Value, json};

use bodies::craft::record::FlightMetrics;
use measure::metrics::{ExploreMetrics, HoldMetrics, RunMetrics, SwarmMetrics};
use measure::verdict::{Criterion, Judgement, criteria};
use mission::RadioMetrics;
use mission::trace::{DroneFrame, Node, Trace};
use scenario::Scenario;

use crate::pictures::state_name;

/// The summary of one mission, with the failures in words.
#[must_use]
pub fn summary(
    scenario: &Scenario,
    seed: u64,
    trace: &Trace,
    metrics: &RunMetrics,
    judgement: &Judgement,
    failures: &[String],
) -> Value {
    let drones: Vec<_> = last_drones(trace)
        .map(|(node, drone)| json!({ "id": node.id.0, "state": state_name(drone) }))
        .collect();
    let criteria: serde_json::Map<_, _> = criteria(scenario, metrics)
        .iter()
        .map(|criterion| (criterion.name.to_owned(), criterion_json(criterion)))
        .collect();
    let mut summary = json!({
        "scenario": scenario.name,
        "title": scenario.title,
        "seed": seed,
        "version": env!("CARGO_PKG_VERSION"),
        "fidelity": scenario.fidelity.name(),
        "link": scenario.link.name(),
        "policy": scenario.policy,
        "duration_s": scenario.duration_s(),
        "success": failures.is_empty(),
        "failures": failures,
        "verdict": judgement.json(),
        "metrics": metrics_json(metrics),
        "radio": radio_json(&metrics.radio),
        "drones": drones,
    });
    if let Some(summary) = summary.as_object_mut() {
        if let Some(route) = &scenario.route {
            summary.insert("route".into(), route_json(route));
        }
        if !criteria.is_empty() {
            summary.insert("criteria".into(), Value::Object(criteria));
        }
        if let Some(flight) = &metrics.flight {
            summary.insert("flight".into(), flight_json(flight));
        }
        if let Some(swarm) = &metrics.swarm {
            summary.insert("swarm".into(), swarm_json(swarm, scenario.agent.swarm.both));
        }
        if let Some(explore) = &metrics.explore {
            summary.insert("explore".into(), explore_json(explore));
        }
    }
    summary
}

/// The members and their last states.
pub fn last_states(trace: &Trace) -> impl Iterator<Item = (Node, State)> {
    last_drones(trace).map(|(node, drone)| (node, drone.state))
}

fn last_drones(trace: &Trace) -> impl Iterator<Item = (Node, &DroneFrame)> {
    let last = trace.frames.last().into_iter().flat_map(|frame| &frame.drones);
    trace.nodes.iter().copied().zip(last)
}

/// A criterion of the scenario, and what was reached.
fn criterion_json(criterion: &Criterion) -> Value {
    let which = if criterion.is_most { "most" } else { "least" };
    json!({
        which: number(criterion.bound),
        "value": number(criterion.value),
        "met": criterion.is_met(),
    })
}

/// The route of the map that was flown.
pub fn route_json(route: &Route) -> Value {
    let millimetres = |metres: f64| (metres * 1000.0).round() / 1000.0;
    let hindrances: Vec<_> = route.hindrances.iter().map(ToString::to_string).collect();
    json!({
        "from": route.from,
        "to": route.to,
        "length_m": millimetres(route.length_m),
        "height_range_m": millimetres(route.height_range_m),
        "stations": route.stations,
        "assumed_widths": route.assumed_widths,
        "is_cut": route.is_cut,
        "ended": { "why": route.ended.name(), "words": route.ended.to_string() },
        "side_galleries": route.side_galleries,
        "above_or_below": route.above_or_below,
        "median_width_m": number(route.median_width_m),
        "hindrances": hindrances,
    })
}

/// The figures of the radio.
fn radio_json(radio: &RadioMetrics) -> Value {
    let packets = &radio.packets;
    json!({
        "sealed": radio.sealed,
        "air_time": number(radio.air_time),
        "packets_sent": packets.sent,
        "packets_heard": packets.heard,
        "packets_lost": {
            "weak": packets.weak,
            "chance": packets.chance,
            "collision": packets.collisions,
            "deaf": packets.deaf,
            "cut": packets.cut,
        },
        "orders_heard": radio.orders,
        "pilot_delay_p50_s": number(radio.pilot_delay_p50_s),
        "pilot_delay_p95_s": number(radio.pilot_delay_p95_s),
    })
}

/// The figures of a swarm.
fn swarm_json(swarm: &SwarmMetrics, both_areas: bool) -> Value {
    json!({
        "both_areas": both_areas,
        "covered": number(swarm.covered),
        "lost": swarm.lost,
        "surveyed_s": number(swarm.surveyed_s),
        "gathered_s": number(swarm.gathered_s),
        "across_s": number(swarm.across_s),
        "closest_drones_m": number(swarm.closest_drones_m),
        "unfinished": swarm.unfinished,
    })
}

/// The figures of an exploration.
fn explore_json(explore: &ExploreMetrics) -> Value {
    json!({
        "explored": number(explore.explored),
        "walls_found": number(explore.walls_found),
        "false_walls": number(explore.false_walls),
        "false_free": number(explore.false_free),
        "t50_s": number(explore.t50_s),
        "t99_s": number(explore.t99_s),
        "ended_s": number(explore.ended_s),
        "closest_drones_m": number(explore.closest_drones_m),
        "unfinished": explore.unfinished,
    })
}

/// The figures of the flights.
fn flight_json(flight: &FlightMetrics) -> Value {
    let ends: serde_json::Map<_, _> =
        flight.ends().map(|(name, count)| (name.to_owned(), json!(count))).collect();
    json!({
        "max_tilt_deg": number(flight.max_tilt_deg),
        "max_rate_dps": number(flight.max_rate_dps),
        "velocity_error_mps": number(flight.velocity_error_mps),
        "min_battery_v": number(flight.min_battery_v),
        "take_offs": flight.take_offs,
        "landings": flight.landings,
        "ends": ends,
    })
}

/// Converts through text, so that 0.1 stays 0.1 and does not become the double nearest to a float;
/// a value that is not finite is `null`.
fn number(value: f32) -> Value {
    if !value.is_finite() {
        return Value::Null;
    }
    serde_json::from_str(&format!("{value}")).unwrap_or(Value::Null)
}

/// Every metric by name; `null` for one that was never reached or does not apply.
pub fn metrics_json(m: &RunMetrics) -> Value {
    let held = |of: fn(&HoldMetrics) -> f32| number(m.held(of));
    json!({
        "hold_from_s": held(|hold| hold.from_s),
        "hold_until_s": held(|hold| hold.until_s),
        "no_hold": m.hold.as_ref().err().map(ToString::to_string),
        "t3_s": held(|hold| hold.t3_s),
        "t1_s": held(|hold| hold.t1_s),
        "t_gap1_s": held(|hold| hold.t_gap1_s),
        "t_repair_s": held(|hold| hold.t_repair_s),
        "gap_db": held(|hold| hold.gap_db),
        "difference_db": held(|hold| hold.difference_db),
        "hold_spread_db": held(|hold| hold.spread_db),
        "swing_p95_db": held(|hold| hold.swing_p95_db),
        "position_sd_m": held(|hold| hold.position_sd_m),
        "path_m": held(|hold| hold.path_m),
        "hold_violation": held(|hold| hold.violation),
        "relays_beyond_need": held(|hold| hold.relays_beyond_need),
        "bound_s": number(m.bound_s),
        "launched": number(m.launched),
        "needed": number(m.needed),
        "violation": number(m.violation),
        "peak_excess_db": number(m.peak_excess_db),
        "cruise_gap_db": number(m.cruise_gap_db),
        "farthest_m": number(m.farthest_m),
        "t_farthest_s": number(m.t_farthest_s),
        "head_heard_until_s": number(m.head_heard_until_s),
        "still_flying": number(m.still_flying),
        "order_lost": m.order_lost,
        "wall_contacts": m.wall_contacts,
        "drone_contacts": m.drone_contacts,
        "ground_contacts": m.ground_contacts,
    })
}
