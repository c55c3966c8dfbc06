//! Encodes the mission for the page's script, small enough to embed.
//!
//! Whole millimetres, milliradians, millivolts and tenths of a decibel, each column as differences
//! between one frame and the next: most of them are one digit. `null` stands where there is no
//! value.

use serde_json::{Value, json};
use units::Point2;

use crate::pictures::{GROUND_LOSS, PlotFrame, launch_limit, nested, node_rgb, state_name};
use mission::trace::{Change, DroneFrame, Ground, LinkFrame, Trace, order_words};

/// The JSON text, safe within a `<script>` element. A node's columns are text before those of the
/// next are made: as values, all of them together would take twenty times the memory.
pub(super) fn json(
    trace: &Trace,
    summary: &Value,
    positions: &[PlotFrame],
    links: &[PlotFrame],
) -> String {
    let mut states: Vec<&'static str> = Vec::new();
    let nodes: Vec<String> =
        (0..trace.nodes.len()).map(|index| node(trace, index, &mut states).to_string()).collect();
    let outlines = nested(&trace.floor_plan.outlines)
        .into_iter()
        .map(|(outline, free)| json!({ "free": free, "points": points(outline) }));
    let centres = trace.floor_plan.centre_lines.iter().map(|line| points(&line.points));
    let times = column(trace.frames.iter().map(|f| i64::try_from(f.time_us / 1000).ok()));
    let entries = [
        ("mission", json!(trace.mission.name()).to_string()),
        ("limit", json!(launch_limit(trace)).to_string()),
        ("groundLoss", json!(GROUND_LOSS.0).to_string()),
        ("ended", json!(summary.pointer("/verdict/ended")).to_string()),
        ("times", json!(times).to_string()),
        ("outlines", Value::from_iter(outlines).to_string()),
        ("centres", json!(centres.collect::<Vec<_>>()).to_string()),
        ("nodes", format!("[{}]", nodes.join(","))),
        ("states", json!(states).to_string()),
        ("orders", json!(orders(trace)).to_string()),
        ("map", team_map(trace).to_string()),
        ("frames", json!({ "positions": frames(positions), "links": frames(links) }).to_string()),
    ];
    let entries = entries.map(|(name, value)| format!("\"{name}\":{value}"));
    // Within JSON, `<` can only stand in a string: written like this, no string ends the script.
    format!("{{{}}}", entries.join(",")).replace('<', "\\u003c")
}

/// Each order, and the frame from which on it stood.
fn orders(trace: &Trace) -> Vec<Value> {
    let mut orders = Vec::new();
    let mut before = None;
    for (n, frame) in trace.frames.iter().enumerate() {
        if before.replace(frame.order) != Some(frame.order) {
            orders.push(json!([n, order_words(frame.order)]));
        }
    }
    orders
}

/// What the drones of an exploration know together: where the cells lie, and for each moment at which some have
/// changed its time in ms, the cells by their numbers, as differences, and what each of them is from then on, a letter
/// each. `null` in other missions.
fn team_map(trace: &Trace) -> Value {
    let map = &trace.team_map;
    let Some(lattice) = map.lattice() else { return Value::Null };
    let letter = |change: &Change| match change.ground {
        Ground::Unknown => 'u',
        Ground::Free => 'f',
        Ground::Frontier => 'e',
        Ground::Wall => 'w',
    };
    let moment = |changes: &[Change]| {
        let cells = column(changes.iter().map(|change| i64::try_from(change.cell).ok()));
        let grounds: String = changes.iter().map(letter).collect();
        json!([changes.first().map(|change| change.time_us / 1000), cells, grounds])
    };
    let moments = map.changes().chunk_by(|one, next| one.time_us == next.time_us).map(moment);
    json!({
        "corner": points(&[lattice.corner])[0],
        "side": lattice.side_m,
        "columns": lattice.columns,
        "moments": moments.collect::<Vec<_>>(),
    })
}

fn node(trace: &Trace, index: usize, states: &mut Vec<&'static str>) -> Value {
    let drones: Vec<&DroneFrame> =
        trace.frames.iter().filter_map(|frame| frame.drones.get(index)).collect();
    let metres = |value: &dyn Fn(&DroneFrame) -> f32| {
        column(drones.iter().map(|drone| rounded(value(drone), 1000.0)))
    };
    let ranges = [0, 1, 2, 3].map(|beam: usize| {
        let of = |drone: &&DroneFrame| drone.ranges.get(beam).copied().unwrap_or(f32::NAN);
        column(drones.iter().map(|drone| range(of(drone))))
    });
    let state = column(drones.iter().map(|drone| Some(number_of(state_name(drone), states))));
    let [r, g, b] = trace.nodes.get(index).map(node_rgb).unwrap_or_default();
    json!({
        "name": trace.nodes.get(index).map(ToString::to_string),
        "role": trace.nodes.get(index).map(|node| node.role.name()),
        "colour": format!("#{r:02x}{g:02x}{b:02x}"),
        "x": metres(&|drone| drone.pose.at.x),
        "y": metres(&|drone| drone.pose.at.y),
        "z": metres(&|drone| drone.height),
        "yaw": metres(&|drone| drone.pose.yaw.0),
        "goalX": metres(&|drone| drone.goal.map_or(f32::NAN, |goal| goal.x)),
        "goalY": metres(&|drone| drone.goal.map_or(f32::NAN, |goal| goal.y)),
        "way": metres(&|drone| drone.way),
        "battery": metres(&|drone| drone.battery_v),
        "state": state,
        "ranges": ranges,
        "front": link(trace, &drones, |drone| drone.front.as_ref()),
        "back": link(trace, &drones, |drone| drone.back.as_ref()),
    })
}

fn link(
    trace: &Trace,
    drones: &[&DroneFrame],
    side: impl Fn(&DroneFrame) -> Option<&LinkFrame>,
) -> Value {
    let place = |link: &LinkFrame| trace.nodes.iter().position(|node| node.id == link.peer);
    // A peer that is not in the list cannot be shown: then there is no link.
    let known = |drone: &&DroneFrame| side(drone).filter(|link| place(link).is_some()).copied();
    let decibels = |value: &dyn Fn(&LinkFrame) -> f32| {
        column(drones.iter().map(|drone| rounded(value(&known(drone)?), 10.0)))
    };
    let peers = drones.iter().map(|drone| i64::try_from(place(&known(drone)?)?).ok());
    json!({
        "peer": column(peers),
        "raw": decibels(&|link| link.raw.0),
        "filtered": decibels(&|link| link.filtered.0),
        "truth": decibels(&|link| link.truth.0),
    })
}

/// The state's place in the list of names, where it is added if need be.
fn number_of(state: &'static str, states: &mut Vec<&'static str>) -> i64 {
    let place = states.iter().position(|known| *known == state).unwrap_or_else(|| {
        states.push(state);
        states.len() - 1
    });
    i64::try_from(place).unwrap_or(0)
}

/// A range in millimetres, negative where the beam saw nothing; `None` where none was measured.
fn range(metres: f32) -> Option<i64> {
    if metres == f32::INFINITY { Some(-1) } else { rounded(metres, 1000.0) }
}

/// Rounds to whole units; `None` for a number that is not finite.
fn rounded(value: f32, units: f64) -> Option<i64> {
    value.is_finite().then(|| (f64::from(value) * units).round() as i64)
}

/// Differences to the last known value, the first to zero.
fn column(values: impl Iterator<Item = Option<i64>>) -> Vec<Option<i64>> {
    let mut last = 0;
    let mut step = |value: i64| value - std::mem::replace(&mut last, value);
    values.map(|value| value.map(&mut step)).collect()
}

fn points(path: &[Point2]) -> Vec<[f64; 2]> {
    let millimetres = |v: f32| (f64::from(v) * 1000.0).round() / 1000.0;
    path.iter().map(|p| [p.x, p.y].map(millimetres)).collect()
}

fn frames(frames: &[PlotFrame]) -> Vec<Value> {
    let frame = |f: &PlotFrame| {
        json!({
            "left": f.left, "right": f.right, "top": f.top, "bottom": f.bottom,
            "from": f.from, "to": f.to,
        })
    };
    frames.iter().map(frame).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_is_listed_where_it_begins() {
        let trace = crate::synthetic::mission();
        let expected = json!([[0, "explore at 0.16 m/s"], [1250, "return"]]);
        assert_eq!(Value::from(orders(&trace)), expected);
    }

    #[test]
    fn a_column_is_differences_to_what_was_last_known() {
        let values = [Some(5), Some(7), None, Some(4)];
        assert_eq!(column(values.into_iter()), [Some(5), Some(2), None, Some(-3)]);
    }
}
