//! Encodes the mission for the page's script, small enough to embed.
//!
//! Whole millimetres, milliradians, millivolts and tenths of a decibel, each column as differences
//! between one frame and the next: most of them are one digit. `null` stands where there is no
//! value.

use std::collections::BTreeSet;

use agent::SwarmTarget;
use serde_json::{Value, json};
use units::Point2;

use crate::pictures::{GROUND_LOSS, Picture, PlotFrame, launch_limit, nested, palette, state_name};
use mission::trace::{Change, DroneFrame, Frame, Ground, LinkFrame, Trace, order_words};

/// The JSON text, safe within a `<script>` element. A node's columns are text before those of the
/// next are made: as values, all of them together would take twenty times the memory.
pub(super) fn json(trace: &Trace, summary: &Value, charts: &[(&str, Picture)]) -> String {
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
        ("passage", json!(trace.passage.map(|corners| points(&corners))).to_string()),
        ("teamLinks", Value::from(team_links(trace)).to_string()),
        ("linkColours", json!(ramp(launch_limit(trace))).to_string()),
        ("frames", Value::Object(charts.iter().map(plots).collect()).to_string()),
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
    let aim = |place: fn(SwarmTarget) -> Option<Point2>| {
        let of = move |drone: &DroneFrame| drone.target.and_then(place);
        [|at: Point2| at.x, |at: Point2| at.y]
            .map(|axis| column(drones.iter().map(|drone| rounded(axis(of(drone)?), 1000.0))))
    };
    let row = |drone: &&DroneFrame| match drone.target? {
        SwarmTarget::Row { number, .. } => Some(i64::from(number)),
        SwarmTarget::Formation(_) | SwarmTarget::Home(_) => None,
    };
    json!({
        "name": trace.nodes.get(index).map(ToString::to_string),
        "role": trace.nodes.get(index).map(|node| node.role.name()),
        "colour": trace.nodes.get(index).map(palette::variable),
        "target": aim(|target| Some(target.at())),
        "rowFrom": aim(|target| match target {
            SwarmTarget::Row { from, .. } => Some(from),
            SwarmTarget::Formation(_) | SwarmTarget::Home(_) => None,
        }),
        "row": column(drones.iter().map(row)),
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

/// The colours of links from the weakest to the strongest, and the strengths of these two, dBm.
fn ramp(limit: Option<f64>) -> Value {
    const STEPS: u32 = 12;
    let weakest = limit.unwrap_or(palette::WEAK_DBM);
    let strongest = weakest + palette::SPARE_DB;
    let at = |step| weakest + f64::from(step) / f64::from(STEPS) * palette::SPARE_DB;
    let colours = (0..=STEPS).map(|step| palette::hex(palette::link_colour(at(step), limit)));
    json!({ "from": weakest, "to": strongest, "colours": colours.collect::<Vec<_>>() })
}

/// Each pair of members of a swarm or an exploration that ever hear each other, with the strength at each
/// moment in whole dBm.
fn team_links(trace: &Trace) -> Vec<Value> {
    let all = trace.frames.iter().flat_map(|frame| &frame.team_links);
    let pairs: BTreeSet<[u8; 2]> = all.map(|link| link.ends).collect();
    let strengths = |ends: [u8; 2]| {
        let of = |frame: &Frame| {
            let link = frame.team_links.iter().find(|link| link.ends == ends)?;
            rounded(link.strength.0, 1.0)
        };
        column(trace.frames.iter().map(of))
    };
    pairs.into_iter().map(|ends| json!({ "ends": ends, "dbm": strengths(ends) })).collect()
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

/// The places of a chart's axes of time.
fn plots((name, chart): &(&str, Picture)) -> (String, Value) {
    let plot = |f: &PlotFrame| {
        json!({
            "left": f.left, "right": f.right, "top": f.top, "bottom": f.bottom,
            "from": f.from, "to": f.to,
        })
    };
    ((*name).to_owned(), chart.frames().iter().map(plot).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use mission::trace::TeamLink;

    #[test]
    fn an_order_is_listed_where_it_begins() {
        let trace = crate::synthetic::mission();
        let expected = json!([[0, "explore at 0.16 m/s"], [1250, "return"]]);
        assert_eq!(Value::from(orders(&trace)), expected);
    }

    #[test]
    fn a_swarm_is_told_with_its_targets_its_passage_and_who_hears_whom() {
        let mut trace = crate::synthetic::mission();
        trace.frames.truncate(3);
        trace.mission = units::MissionKind::Swarm;
        trace.passage = Some(
            [[0.0, 1.0], [6.0, 1.0], [6.0, -1.0], [0.0, -1.0]].map(|[x, y]| Point2::new(x, y)),
        );
        let (from, to) = (Point2::new(-9.0, -3.0), Point2::new(-9.0, 3.0));
        trace.frames[0].drones[1].target = Some(SwarmTarget::Row { number: 4, from, to });
        trace.frames[1].drones[1].target = Some(SwarmTarget::Formation(Point2::new(-1.0, 0.5)));
        let heard = |dbm| TeamLink { ends: [1, 3], strength: units::Dbm(dbm) };
        trace.frames[0].team_links = vec![heard(-60.4)];
        trace.frames[2].team_links = vec![heard(-62.0)];
        let told: Value = serde_json::from_str(&json(&trace, &json!({}), &[])).unwrap();
        let drone = &told["nodes"][1];
        assert_eq!(drone["target"], json!([[-9000, 8000, null], [3000, -2500, null]]));
        assert_eq!(drone["rowFrom"], json!([[-9000, null, null], [-3000, null, null]]));
        assert_eq!(drone["row"], json!([4, null, null]));
        assert_eq!(told["passage"], json!([[0.0, 1.0], [6.0, 1.0], [6.0, -1.0], [0.0, -1.0]]));
        assert_eq!(told["teamLinks"], json!([{ "ends": [1, 3], "dbm": [-60, null, -2] }]));
    }

    #[test]
    fn a_column_is_differences_to_what_was_last_known() {
        let values = [Some(5), Some(7), None, Some(4)];
        assert_eq!(column(values.into_iter()), [Some(5), Some(2), None, Some(-3)]);
    }
}
