//! Makes the record of a mission, of which the report and the pictures are made, from a
//! `station.mcap`.
//!
//! The base knows of its drones what their telemetry says, so the record has less than that of a
//! simulated mission: of each link the strength by the on-board filter of the end nearer to the
//! head, no packets and no true strengths; of each drone the way that it has flown and no height. A
//! drone is drawn as far along the plan's first centre-line as it has flown; without a plan, along a
//! straight line.

mod messages;
mod state;

use std::collections::BTreeMap;
use std::path::Path;

use input::InputError;
use serde_json::{Value, json};
use units::{Branch, Course, Dbm, MetresPerSecond, MissionKind, NodeId, Order, Pose2, Role};
use world::{CentreLine, FloorPlan, SkeletonPlace};

use messages::{Heard, Message};
use mission::trace::{DroneFrame, Frame, LinkFrame, Node, TeamMap, Thinning, Trace};
use recordings::formats;
use station_log::{ChainLine, DroneReport, GivenOrder, Limits};

/// The time between two frames, that of a simulated mission's record.
const FRAME_US: u64 = 200_000;

/// The time after which what a drone has said of its link no longer counts, that after which the
/// station calls the drone silent.
const SILENT_US: u64 = 5_000_000;

/// The farthest apart that two messages of one recording may be: longer is no flight, and a record
/// of it would not fit into the memory.
const LONGEST_US: u64 = 24 * 3_600_000_000;

/// The floor plan's line where the station was given no map.
const WAY_FLOWN: &str = "way flown";

/// A station's recording as the record of a mission.
#[derive(Clone, Debug)]
pub struct StationRecord {
    /// The record.
    pub trace: Trace,
    /// The figures for the report's table.
    pub summary: Value,
}

/// Reads a recording; `None` for a file that is not a station's.
///
/// # Errors
/// A file that cannot be read, or whose messages lie more than a day apart.
pub fn station_record(file: &Path) -> Result<Option<StationRecord>, InputError> {
    let bytes = formats::read_bytes(file)?;
    let heard = messages::read(&bytes);
    let reports = heard.iter().filter(|heard| matches!(heard.message, Message::Report(_)));
    let Some(last) = heard.last().filter(|_| reports.count() > 0) else { return Ok(None) };
    let first = heard.first().map_or(0, |heard| heard.micros);
    if last.micros.saturating_sub(first) > LONGEST_US {
        let wrong = "its messages lie more than a day apart";
        return Err(InputError::new(wrong, "give the recording of one day").in_file(file));
    }
    let name = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into());
    Ok(Some(record_of(name, &heard)))
}

/// What a drone has said last, and when.
type Last = BTreeMap<u8, (u64, DroneReport)>;

fn record_of(name: String, heard: &[Heard]) -> StationRecord {
    let first = heard.first().map_or(0, |heard| heard.micros);
    let limits = heard.iter().rev().find_map(|heard| match &heard.message {
        Message::Limits(limits) => Some(*limits),
        _ => None,
    });
    let nodes = nodes(heard, limits);
    let flying = nodes.iter().filter(|node| node.role != Role::Base).count();
    let (floor_plan, line) = plan(heard, flying);
    let mut trace = Trace {
        scenario: name,
        seed: None,
        mission: MissionKind::Chain,
        floor_plan,
        nodes,
        launch_limit: Dbm(limits.map_or(f32::NEG_INFINITY, |limits| limits.launch_limit_dbm)),
        passage: None,
        team_map: TeamMap::default(),
        frames: Vec::new(),
    };
    let mut thinning = Thinning::default();
    let mut last = Last::new();
    let mut order = Order::Wait;
    let mut rest = heard.iter().peekable();
    let mut now = first;
    while rest.peek().is_some() {
        while let Some(heard) = rest.next_if(|heard| heard.micros <= now) {
            match &heard.message {
                Message::Report(report) => {
                    last.insert(report.node, (heard.micros, report.clone()));
                }
                Message::Ordered(given) => order = ordered(order, given),
                Message::Stop => order = Order::Stop,
                Message::Limits(_) | Message::Plan(_) => {}
            }
        }
        let drone = |(rank, node): (usize, &Node)| {
            let (way, pose) = match (node.role, last.get(&node.id.0)) {
                (Role::Base, _) => (0.0, line.base()),
                (_, Some((_, report))) => {
                    let way = line.way(rank, flying, report.odometer_m);
                    (way, line.at(way))
                }
                (_, None) => (f32::NAN, line.at(line.way(rank, flying, 0.0))),
            };
            drone(last.get(&node.id.0), now, way, pose)
        };
        let drones = trace.nodes.iter().enumerate().map(drone).collect();
        thinning.add(
            &mut trace.frames,
            Frame { time_us: now - first, order, drones, team_links: Vec::new() },
        );
        now += FRAME_US;
    }
    let summary = summary(&trace, heard, limits);
    StationRecord { trace, summary }
}

/// The nodes that were heard, and the base.
fn nodes(heard: &[Heard], limits: Option<Limits>) -> Vec<Node> {
    let mut numbers: Vec<u8> = heard
        .iter()
        .filter_map(|heard| match &heard.message {
            Message::Report(report) => Some(report.node),
            _ => None,
        })
        .collect();
    numbers.sort_unstable();
    numbers.dedup();
    // Without its number the base is the farthest neighbour that a drone has named.
    let named = heard.iter().filter_map(|heard| match &heard.message {
        Message::Report(report) => report.back,
        _ => None,
    });
    let base = limits.map(|limits| limits.base).or_else(|| named.max());
    let base = base.filter(|base| !numbers.contains(base));
    let node = |id, role| Node { id: NodeId(id), role, mission: MissionKind::Chain };
    let drone = |&id: &u8| node(id, if id == 0 { Role::Head } else { Role::Relay });
    let base = base.map(|id| node(id, Role::Base));
    numbers.iter().map(drone).chain(base).collect()
}

/// The floor plan of the recording and the line along which the drones are drawn; without a plan, a
/// straight line as long as the farthest way.
fn plan(heard: &[Heard], drones: usize) -> (FloorPlan, ChainLine) {
    let given = heard.iter().rev().find_map(|heard| match &heard.message {
        Message::Plan(plan) => Some(plan),
        _ => None,
    });
    if let Some((plan, line)) = given.and_then(|plan| Some((plan, ChainLine::of(plan)?))) {
        return (plan.floor_plan(), line);
    }
    let farthest = heard.iter().fold(0.0_f32, |farthest, heard| match &heard.message {
        Message::Report(report) => farthest.max(report.odometer_m),
        _ => farthest,
    });
    let line = ChainLine::straight(drones, farthest);
    let centre_line = CentreLine { name: WAY_FLOWN.to_owned(), points: line.points().to_vec() };
    (FloorPlan { outlines: Vec::new(), centre_lines: vec![centre_line] }, line)
}

/// The order after one that the base has taken.
fn ordered(before: Order, given: &GivenOrder) -> Order {
    let course = match before {
        Order::Explore(course) => course,
        _ => Course { speed: MetresPerSecond::ZERO, branch: None },
    };
    let speed = given.speed.map_or(MetresPerSecond::ZERO, MetresPerSecond);
    match (given.order.as_str(), before) {
        ("wait", _) => Order::Wait,
        ("hold", _) => Order::Explore(Course { speed: MetresPerSecond::ZERO, ..course }),
        ("explore", _) => Order::Explore(Course { speed, ..course }),
        ("recall", _) => Order::Return,
        ("land", _) => Order::Land,
        ("perch", _) => Order::Perch,
        ("branch", Order::Explore(_)) => {
            let branch = match given.way.as_deref() {
                Some("left") => Some(Branch::Left),
                Some("right") => Some(Branch::Right),
                Some("straight") => Some(Branch::Straight),
                _ => None,
            };
            Order::Explore(Course { branch, ..course })
        }
        _ => before,
    }
}

/// A node at one moment, by what it said last.
fn drone(said: Option<&(u64, DroneReport)>, now: u64, way: f32, pose: Pose2) -> DroneFrame {
    let fresh = said.filter(|(at, _)| now.saturating_sub(*at) <= SILENT_US);
    let back = fresh.and_then(|(_, report)| report.back.zip(report.rssi_dbm));
    DroneFrame {
        pose,
        height: f32::NAN,
        place: SkeletonPlace::main(way),
        way,
        commanded: [f32::NAN; 2],
        yaw_rate: f32::NAN,
        ranges: [f32::NAN; 4],
        state: said.map_or(agent::State::Idle, |(_, report)| state::of_code(report.state_code)),
        goal: None,
        target: None,
        battery_v: said.and_then(|(_, report)| report.battery_v).unwrap_or(f32::NAN),
        front: None,
        back: back.map(|(peer, rssi)| LinkFrame {
            peer: NodeId(peer),
            raw: Dbm(f32::NAN),
            filtered: Dbm(rssi),
            truth: Dbm(f32::NAN),
        }),
    }
}

fn summary(trace: &Trace, heard: &[Heard], limits: Option<Limits>) -> Value {
    let reports = heard.iter().filter_map(|heard| match &heard.message {
        Message::Report(report) => Some(report),
        _ => None,
    });
    let mut drones = serde_json::Map::new();
    for node in trace.nodes.iter().filter(|node| node.role != Role::Base) {
        let own = || reports.clone().filter(|report| report.node == node.id.0);
        let least = |values: &mut dyn Iterator<Item = f32>| {
            values.reduce(f32::min).map(|value| (f64::from(value) * 100.0).round() / 100.0)
        };
        let mut faults: Vec<&str> = own().map(|report| report.fault.as_str()).collect();
        faults.dedup();
        faults.retain(|fault| !fault.is_empty());
        drones.insert(
            node.to_string(),
            json!({
                "reports": own().count(),
                "farthest_m": least(&mut own().map(|report| -report.odometer_m)).map(|m| -m),
                "weakest_link_dbm": least(&mut own().filter_map(|report| report.rssi_dbm)),
                "least_battery_v": least(&mut own().filter_map(|report| report.battery_v)),
                "faults": faults,
            }),
        );
    }
    let seconds = trace.frames.last().map_or(0.0, |frame| frame.time_us as f64 * 1e-6);
    json!({
        "title": "A flight that the station recorded",
        "duration_s": seconds,
        "launch_limit_dbm": limits.map(|limits| limits.launch_limit_dbm),
        "retreat_limit_dbm": limits.map(|limits| limits.retreat_limit_dbm),
        "drones": drones,
    })
}

#[cfg(test)]
mod tests;
