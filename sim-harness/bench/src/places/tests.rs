//! The benchmark in a small folder: a cave of two files, one that cannot be flown, a map, a world, and
//! files that are none of these.

use std::fs;
use std::path::{Path, PathBuf};

use super::*;
use crate::places::found::places;

/// A gallery with an entrance at its end, of which a part is in another file.
const CAVE: &str = "1 2 12 90 0\n*include part\n*entrance 1\n";
const PART: &str = "2 3 14 60 0\n";
/// A shaft, and nothing that is long enough to be flown.
const SHAFT: &str = "top bottom 9 - DOWN\nbottom end 3 0 0\n*entrance top\n";

/// A folder of this name in which the files of the test are written anew.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("uchain-places-{name}-{}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(folder.join("caves")).unwrap();
    folder
}

/// A corridor of 14 by 1.2 m, with walls of one cell.
fn corridor() -> String {
    let (columns, rows) = (282, 26);
    let cell = |n: usize| {
        let (column, row) = (n % columns, n / columns);
        let is_wall = column == 0 || row == 0 || column + 1 == columns || row + 1 == rows;
        if is_wall { "0" } else { "254" }
    };
    let cells: Vec<_> = (0..columns * rows).map(cell).collect();
    format!("P2\n{columns} {rows}\n255\n{}\n", cells.join("\n"))
}

fn small(name: &str) -> PathBuf {
    let folder = folder(name);
    let put = |file: &str, text: &str| fs::write(folder.join(file), text).unwrap();
    put("caves/cave.svx", CAVE);
    put("caves/part.svx", PART);
    put("caves/shaft.svx", SHAFT);
    put("corridor.pgm", &corridor());
    put(
        "corridor.yaml",
        "image: corridor.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n\
                          occupied_thresh: 0.65\nfree_thresh: 0.196\n",
    );
    put("metadata.yaml", "rosbag2_bagfile_information:\n  version: 5\n");
    put("notes.txt", "Nothing that was surveyed.\n");
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/maps");
    for file in ["crossing.dot", "crossing.sdf"] {
        fs::copy(maps.join(file), folder.join(file)).unwrap();
    }
    folder
}

fn bench(data: PathBuf, depths: &[f32]) -> Outcome {
    let bench = PlacesBench {
        data: Some(data),
        depths: depths.to_vec(),
        runs: Some(2),
        fidelity: None,
        each: false,
    };
    bench.run(&mut Session::new("places", 7, true, None)).unwrap()
}

#[test]
fn a_place_is_a_survey_that_no_other_includes_a_map_or_a_world() {
    let found = places(&small("found")).unwrap();
    let names: Vec<_> = found.iter().map(|place| &*place.name).collect();
    assert_eq!(names, ["caves/cave.svx", "caves/shaft.svx", "corridor.yaml", "crossing.dot"]);
}

#[test]
fn a_folder_without_places_gets_one_line() {
    let empty = folder("empty");
    for (data, words) in [
        (empty.clone(), "there is no cave, map or world in the folder"),
        (empty.join("none"), "the folder cannot be read"),
    ] {
        let error = places(&data).unwrap_err().to_string();
        assert!(error.contains(words) && error.lines().count() == 1, "{error}");
    }
    let wrong = PlacesBench {
        data: None,
        depths: vec![20.0, -1.0],
        runs: None,
        fidelity: None,
        each: false,
    };
    let error = wrong.depths().unwrap_err().to_string();
    assert_eq!(error, "--depths -1 is out of range; give numbers from 1 to 300");
}

#[test]
fn the_table_of_a_small_folder() {
    let outcome = bench(small("table"), &[12.0, 20.0, 60.0]);
    assert_eq!(outcome.table, include_str!("golden.txt"), "{}", outcome.table);
    let rows = outcome.json["rows"].as_array().unwrap();
    let keys: Vec<_> = rows[0].as_object().unwrap().keys().map(String::as_str).collect();
    let expected = [
        "place",
        "from",
        "depth_m",
        "relays",
        "fidelity",
        "runs",
        "arrived",
        "home",
        "linked",
        "below",
        "touches",
        "stood",
        "lost_place",
        "launched_over_need",
        "time_over_way",
        "why",
    ];
    assert_eq!(keys, expected);
}

#[test]
fn a_refused_place_is_a_row_that_names_the_leg() {
    let outcome = bench(small("refused"), &[200.0]);
    let rows = outcome.json["rows"].as_array().unwrap();
    let why = |place: &str| {
        let row = rows.iter().find(|row| row["place"] == place).unwrap();
        assert_eq!(row["runs"], 0);
        row["why"].as_str().unwrap().to_owned()
    };
    assert!(why("caves/shaft.svx").contains("bottom to top is a shaft of 9.0 m"));
    assert_eq!(
        why("caves/cave.svx"),
        "the way is 26.0 m long: 3: nothing that was surveyed leads on"
    );
    assert!(outcome.missed.is_empty(), "{:?}", outcome.missed);
}

/// Without the gallery that goes straight on, the route turns at the crossing; a head without a choice
/// flew into the other branch.
#[test]
fn the_head_follows_the_route_of_a_world_at_its_crossing() {
    let data = folder("crossing");
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/maps");
    fs::copy(maps.join("crossing.sdf"), data.join("crossing.sdf")).unwrap();
    let graph = fs::read_to_string(maps.join("crossing.dot")).unwrap();
    let is_kept = |line: &&str| !line.trim_start().starts_with("2  -- 3 ");
    let kept: Vec<_> = graph.lines().filter(is_kept).collect();
    assert_eq!(kept.len() + 1, graph.lines().count());
    fs::write(data.join("crossing.dot"), kept.join("\n")).unwrap();
    let outcome = bench(data, &[60.0]);
    let row = &outcome.json["rows"][0];
    assert_eq!((&row["runs"], &row["arrived"]), (&json!(2), &json!(2)), "{row}");
}
