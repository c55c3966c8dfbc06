//! Drones explore floor plans that seeds draw: `uchain bench explore`.

use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;

/// Runs the command, and returns what it printed as JSON.
fn uchain(args: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_uchain")).args(args).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {said}"))
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("uchain-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

/// The benchmark once flew robots of its own, in a simulator of their own, which never ran the agent.
#[test]
fn the_benchmark_flies_the_missions_that_run_flies() {
    let out = folder("explored");
    let args =
        ["bench", "explore", "--runs", "1", "--drawn", "1", "--seed", "3800000", "--robots", "2"];
    let rows =
        uchain(&[&args[..], &["--json", "--quiet", "--out", out.to_str().unwrap()]].concat());
    let of_bench = &rows[0]["missions"][0];
    let scenario = out.join("drawn-3800000-2.toml");
    let run =
        uchain(&["run", scenario.to_str().unwrap(), "--seed", "3800000", "--json", "--quiet"]);
    for figure in ["explored", "walls_found", "t99_s", "ended_s"] {
        let [one, other] =
            [&of_bench[figure], &run["explore"][figure]].map(|it| it.as_f64().unwrap());
        assert!((one - other).abs() < 0.01, "{figure}: {one} and {other}");
    }
    std::fs::remove_dir_all(out).unwrap();
}

/// Drones flew into the corners of doors that lay between their beams, in half of all missions, and landed
/// where they were when nothing was left.
#[test]
fn drones_explore_rooms_behind_doors_touch_nothing_and_come_home() {
    let args =
        ["bench", "explore", "--runs", "1", "--drawn", "8", "--seed", "3800000", "--robots", "2"];
    let rows = uchain(&[&args[..], &["--json", "--quiet"]].concat());
    for row in rows.as_array().unwrap() {
        let plan = &row["plan"];
        assert_eq!(row["touched"], 0, "{plan}");
        assert_eq!(row["false_success"], 0, "{plan}");
        let wrong = row["missions"][0]["wrong"].as_array().unwrap();
        assert!(
            !wrong.iter().any(|name| name.as_str().unwrap().starts_with("left-inside")),
            "{plan}"
        );
    }
    let good: u64 = rows.as_array().unwrap().iter().filter_map(|row| row["good"].as_u64()).sum();
    assert!(good >= 6, "{good} of 8 are good");
}

/// A ranger sees a cone of 27°. Drones that took its reading for one of a ray drew 6 to 19 % of the walls where there are
/// none, and small doors closed.
#[test]
fn the_maps_of_drones_show_the_walls_and_few_others_at_flight_level() {
    let args = ["bench", "explore", "--runs", "1", "--drawn", "4", "--seed", "3800000"];
    let rest = ["--robots", "2", "--fidelity", "flight", "--json", "--quiet"];
    let rows = uchain(&[&args[..], &rest].concat());
    for row in rows.as_array().unwrap() {
        let mission = &row["missions"][0];
        let false_walls = mission["false_walls"].as_f64().unwrap();
        assert!(false_walls <= 0.01, "{}: {mission}", row["plan"]);
        assert_eq!(row["touched"], 0, "{}", row["plan"]);
    }
}

/// The map is what an exploration is for, and a mission of drones left none.
#[test]
fn a_run_leaves_the_map_that_its_drones_have_drawn() {
    let out = folder("drawn-map");
    let run = ["run", "explore-room", "--json", "--quiet", "--out", out.to_str().unwrap()];
    let explored = uchain(&run)["explore"]["explored"].as_f64().unwrap();
    let map = uchain(&["map", "info", out.join("map.yaml").to_str().unwrap(), "--json"]);
    std::fs::remove_dir_all(out).unwrap();
    assert!(explored > 0.99);
    // Of the room of 4 m by 4 m a wall may take the cells beside it, 0.1 m wide.
    let free_m2 = map["free_m2"].as_f64().unwrap_or_else(|| panic!("{map}"));
    assert!(free_m2 > 0.99 * 3.8 * 3.8, "{free_m2} m²");
}
