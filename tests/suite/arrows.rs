//! The dependencies between the packages of the workspace: each package uses only packages that stand
//! above it in one order.

use std::process::Command;

use serde_json::Value;

/// The packages in order: each may use those before it.
const ORDER: [&str; 50] = [
    // What a drone does, without its chip.
    "units",
    "wire",
    "storage",
    "radio-model",
    "grid-map",
    "airlink",
    "frontier",
    "relay-placement",
    "sensors",
    "chain",
    "virtual-forces",
    "tunnel-nav",
    "flight",
    "agent",
    "crtp",
    "onboard",
    // The firmware.
    "uchain-firmware",
    // The input of users, and what is for real drones.
    "input",
    "fleet-keys",
    "bridge",
    // The maps and the messages that the station and the simulator share.
    "random",
    "cave-survey",
    "robot-maps",
    "world",
    "maps",
    "station-log",
    "ros2-topics",
    // The station.
    "ground-station",
    // The simulator.
    "recordings",
    "scenario",
    "explorers",
    "swarms",
    "cave-worlds",
    "nrf51-chip",
    "virtual-crazyflie",
    "core-vectors",
    "bodies",
    "medium",
    "mission",
    "measure",
    "planning",
    "report",
    "replay",
    "serve",
    "ros2",
    "stock",
    "terminal",
    "benchmarks",
    "sim-harness",
    "fuzz-checks",
];

/// The crates that each follow a paper; none of them uses another.
const PAPERS: [&str; 4] = ["chain", "frontier", "virtual-forces", "relay-placement"];

/// The first and the last of the packages that are the simulator's alone, in the order.
const SIMULATOR: [&str; 2] = ["recordings", "sim-harness"];

/// The packages of the workspace, each with the packages of the workspace that it is built with.
fn packages() -> Vec<(String, Vec<String>)> {
    let metadata = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(metadata.status.success(), "{}", String::from_utf8_lossy(&metadata.stderr));
    let metadata: Value = serde_json::from_slice(&metadata.stdout).unwrap();
    let is_built_with = |it: &&Value| it["kind"] != "dev" && !it["path"].is_null();
    let name = |it: &Value| it["name"].as_str().unwrap().to_owned();
    let packages = metadata["packages"].as_array().unwrap().iter();
    packages
        .map(|package| {
            let uses = package["dependencies"].as_array().unwrap().iter().filter(is_built_with);
            (name(package), uses.map(name).collect())
        })
        .collect()
}

#[test]
fn each_package_uses_only_packages_above_it() {
    let place = |name: &str| ORDER.iter().position(|it| *it == name);
    for (package, uses) in packages() {
        // No package uses it, and it may use all.
        if package == "xtask" {
            continue;
        }
        let own = place(&package).unwrap_or_else(|| panic!("{package} has no place in the order"));
        for other in uses {
            let above = place(&other).is_some_and(|it| it < own);
            assert!(above, "{package} uses {other}, which does not stand above it");
        }
    }
}

#[test]
fn no_paper_knows_another() {
    for (package, uses) in packages() {
        let other = uses.iter().find(|other| PAPERS.contains(&other.as_str()));
        let is_paper = PAPERS.contains(&package.as_str());
        assert!(!is_paper || other.is_none(), "{package} uses {other:?}");
    }
}

/// The station is for real drones: neither it nor a package that it is built with is of the simulator
/// alone.
#[test]
fn the_station_is_built_with_nothing_of_the_simulator() {
    let packages = packages();
    let [first, last] = SIMULATOR.map(|name| ORDER.iter().position(|it| *it == name).unwrap());
    let (mut reached, mut next) = (vec!["ground-station".to_owned()], 0);
    while let Some(package) = reached.get(next).cloned() {
        next += 1;
        let (_, uses) = packages.iter().find(|(name, _)| *name == package).unwrap();
        let new: Vec<_> = uses.iter().filter(|name| !reached.contains(name)).cloned().collect();
        reached.extend(new);
    }
    for package in reached {
        let place = ORDER.iter().position(|it| *it == package).unwrap();
        assert!(!(first..=last).contains(&place), "ground-station is built with {package}");
    }
}
