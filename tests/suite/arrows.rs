//! The dependencies between the packages of the workspace: each package uses only packages that stand
//! above it in one order.

use std::process::Command;

use serde_json::Value;

/// The packages in order: each may use those before it.
const ORDER: [&str; 34] = [
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
    // The simulator, the station, and what both are made of.
    "random",
    "cave-survey",
    "robot-maps",
    "world",
    "maps",
    "station-log",
    "explorers",
    "swarms",
    "cave-worlds",
    "virtual-crazyflie",
    "core-vectors",
    "sim-harness",
    "ground-station",
    "fuzz-checks",
];

/// The crates that each follow a paper; none of them uses another.
const PAPERS: [&str; 4] = ["chain", "frontier", "virtual-forces", "relay-placement"];

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
