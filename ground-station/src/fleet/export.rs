//! Writes a fleet as crazyswarm2's `crazyflies.yaml`, in the newest version of that format.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, OpenOptions};
use std::io::{self, Write as _};
use std::path::Path;

use input::InputError;
use serde::Serialize;
use serde_saphyr::{FlowMap, FlowSeq};
use station_log::ChainLine;
use units::{NodeId, Role};

use super::crazyflies::{DecksTable, DroneTable, FleetTable, VERSION};
use super::entry::{FirmwareTable, LimitsTable};
use super::{Deck, Fleet, FleetDrone, Limits};

const HEADING: &str = "\
# A fleet of U-Chain as crazyflies.yaml of crazyswarm2, written by `uchain-ground --export`.
# `uchain` is for U-Chain alone; there are no keys in this file.
";

/// The type of all robots.
const TYPE: &str = "cf21";

/// The names that crazyswarm2 has taken for groups of robots.
const TAKEN: [&str; 1] = ["all"];

#[derive(Serialize)]
struct File<'a> {
    fileversion: u32,
    robots: BTreeMap<String, Robot>,
    robot_types: BTreeMap<&'a str, Type>,
    all: All,
    #[serde(skip_serializing_if = "Option::is_none")]
    uchain: Option<FleetTable>,
}

#[derive(Serialize)]
struct Robot {
    enabled: bool,
    uri: String,
    initial_position: FlowSeq<[f32; 3]>,
    r#type: &'static str,
    uchain: DroneTable,
}

#[derive(Serialize)]
struct Type {
    motion_capture: FlowMap<BTreeMap<&'static str, &'static str>>,
    big_quad: bool,
    battery: FlowMap<BTreeMap<&'static str, f32>>,
}

#[derive(Serialize)]
struct All {
    firmware_logging: FlowMap<BTreeMap<&'static str, bool>>,
}

/// Writes the fleet into a file that must not be there yet.
pub(super) fn write(fleet: &Fleet, path: &Path) -> Result<(), InputError> {
    let unwritable = |error: io::Error| match error.kind() {
        io::ErrorKind::AlreadyExists => InputError::new(
            "the file is there already",
            "give another name, since what was written into it by hand would be lost",
        ),
        _ => InputError::new(format!("cannot be written: {error}"), "give another file"),
    };
    let written = text(fleet).and_then(|text| {
        let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
        file.write_all(text.as_bytes()).inspect_err(|_| {
            // The error that is told is the first one.
            let _ = fs::remove_file(path);
        })
    });
    written.map_err(|error| unwritable(error).in_file(path))
}

/// The text of the file.
pub(super) fn text(fleet: &Fleet) -> io::Result<String> {
    let yaml = serde_saphyr::to_string(&file(fleet)).map_err(io::Error::other)?;
    Ok(format!("{HEADING}{yaml}"))
}

fn file(fleet: &Fleet) -> File<'static> {
    let names = names(fleet);
    let flying = fleet.flying().count();
    let mut rank = 0;
    let mut robots = BTreeMap::new();
    for ((node, drone), name) in fleet.drones.iter().zip(names) {
        let x = match drone.role {
            Role::Base => 0.0,
            Role::Head | Role::Relay => {
                rank += 1;
                ChainLine::straight(flying, 0.0).way(rank - 1, flying, 0.0)
            }
        };
        robots.insert(name.clone(), robot(*node, drone, &name, x));
    }
    let kind = Type {
        // The tracking of no system of motion capture: the drones have Flow decks.
        motion_capture: FlowMap(BTreeMap::from([("tracking", "none")])),
        big_quad: false,
        battery: FlowMap(BTreeMap::from([("voltage_critical", 3.7), ("voltage_warning", 3.8)])),
    };
    File {
        fileversion: VERSION,
        robots,
        robot_types: BTreeMap::from([(TYPE, kind)]),
        all: All { firmware_logging: FlowMap(BTreeMap::from([("enabled", false)])) },
        uchain: (fleet.limits != Limits::default()).then(|| common(&fleet.limits)),
    }
}

fn robot(node: NodeId, drone: &FleetDrone, name: &str, x: f32) -> Robot {
    let FleetDrone { name: own, address, role, decks } = drone;
    let has_usual = DecksTable::of(decks) == DecksTable::of(&Deck::usual_of(*role));
    Robot {
        enabled: true,
        uri: address.to_string(),
        initial_position: FlowSeq([x, 0.0, 0.0]),
        r#type: TYPE,
        uchain: DroneTable {
            number: Some(node.0),
            name: (own != name).then(|| own.clone()),
            role: Some((*role).into()),
            decks: (!has_usual).then(|| DecksTable::of(decks)),
        },
    }
}

fn common(limits: &Limits) -> FleetTable {
    let Limits { launch, retreat, height, battery, version, revision, radio } = limits.clone();
    FleetTable {
        limits: LimitsTable {
            launch_limit_dbm: launch.map(|limit| limit.0),
            retreat_limit_dbm: retreat.map(|limit| limit.0),
            height_m: height.map(|height| height.0),
            battery_v: battery.map(|volts| volts.0),
        },
        firmware: FirmwareTable { version, revision, radio },
    }
}

/// The names of the robots, in the order of the drones: a drone's own where ROS 2 takes it for the
/// name of a node, else `cf` and its number.
fn names(fleet: &Fleet) -> Vec<String> {
    let own = |drone: &FleetDrone| is_ros_name(&drone.name).then(|| drone.name.clone());
    let mut taken: BTreeSet<String> = fleet.drones.values().filter_map(own).collect();
    let name = |(node, drone): (&NodeId, &FleetDrone)| {
        own(drone).unwrap_or_else(|| {
            let mut name = format!("cf{node}");
            while !taken.insert(name.clone()) {
                name.push('x');
            }
            name
        })
    };
    fleet.drones.iter().map(name).collect()
}

/// Whether ROS 2 takes this for a part of a topic's name, and crazyswarm2 for that of one robot.
fn is_ros_name(name: &str) -> bool {
    let is_letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(is_letter)
        && !name.contains("__")
        && !TAKEN.contains(&name)
}
