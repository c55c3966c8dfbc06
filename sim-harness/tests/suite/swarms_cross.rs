//! Swarms survey two areas and cross the passage between them: `uchain bench forces`.

use std::process::{Command, Output};

use serde_json::Value;

fn uchain(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_uchain")).args(args).output().unwrap()
}

fn rows(args: &[&str]) -> Vec<Value> {
    let output = uchain(&[&["bench", "forces", "--json", "--quiet"], args].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {said}"))
}

/// Drones flew into the edge of a door, or stood on both sides of a pillar until their batteries were empty.
#[test]
fn swarms_pass_obstacles_touch_nothing_and_cover_both_areas() {
    let places = ["--place", "pillar", "--place", "block", "--place", "door"];
    let rest = ["--runs", "2", "--seed", "3530000", "--drones", "2", "--drones", "12"];
    let rows = rows(&[&places[..], &rest].concat());
    assert_eq!(rows.len(), 6);
    for row in rows {
        assert_eq!(row["good"], 2, "{row}");
    }
}

/// What rangers see at the sides of their cones had closed the passage beside the pillar.
#[test]
fn two_drones_pass_a_pillar_at_flight_level() {
    let args = ["--runs", "1", "--seed", "3530000", "--fidelity", "flight"];
    let rows = rows(&[&args[..], &["--place", "pillar", "--drones", "2"]].concat());
    assert_eq!(rows[0]["good"], 1, "{}", rows[0]);
}

#[test]
fn options_of_one_model_are_refused_with_the_other() {
    let output = uchain(&["bench", "forces", "--model", "paper", "--lose"]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("--lose belongs to --model drones"), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
}
