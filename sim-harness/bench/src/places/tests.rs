//! The benchmark in a small folder: a cave of two files, one that cannot be flown, a map, a world, and
//! files that are none of these.

use std::fs;
use std::path::{Path, PathBuf};

use measure::oracle::{Commanded, Oracle};
use mission::Mission;

use super::*;
use crate::Entry;
use crate::chain::drawn::flown::{Case, Cause, Observer};
use crate::places::found::places;
use crate::places::pilot::{HOLDS_S, Pilot, Why};
use scenario::Scenario;

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

impl PlacesBench {
    /// Two missions to each depth in the places of a folder.
    fn small(data: PathBuf, depths: &[f32]) -> Self {
        Self { data, depths: depths.to_vec(), runs: Some(2), fidelity: None, each: false }
    }
}

fn bench(data: PathBuf, depths: &[f32]) -> Outcome {
    let bench = PlacesBench::small(data, depths);
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
    let wrong = PlacesBench::small(PathBuf::new(), &[20.0, -1.0]);
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

/// A straight gallery of 60 m into which the pilot sends a head for 150 s, and asks for 50 m.
fn straight() -> Scenario {
    let text = "title = \"\"\nduration_s = 400\ndepth_m = 50\n[tunnel]\nwidth_m = 1.2\n\
                centre_line_m = [[0, 0], [60, 0]]\n[drones]\nrelays = 2\n\
                [[pilot]]\nat_s = 2\norder = \"explore\"\nspeed_mps = 0.2\n\
                [[pilot]]\nat_s = 150\norder = \"explore\"\nspeed_mps = 0\n\
                [[pilot]]\nat_s = 190\norder = \"return\"\n";
    Scenario::of_text(Path::new("straight.toml"), text).unwrap()
}

#[test]
fn a_head_is_short_when_its_pilot_ends_the_exploration_however_far_it_comes_later() {
    let scenario = straight();
    let world = scenario.world();
    let commanded = Commanded::along_main(&world);
    let oracle = Oracle::of(&scenario, &world, &commanded, 7);
    let case = Case {
        seed: 7,
        scenario: &scenario,
        world: &world,
        commanded: &commanded,
        oracle: &oracle,
    };
    let mut mission = Mission::new(&scenario, &world, 7);
    let mut observer = Observer::of(case, "chain");
    let mut went_on = 0.0_f32;
    while !mission.is_over() {
        mission.round();
        observer.look(&mission);
        if mission.time_us() == 40_000_000 {
            observer.end_exploration(mission.time_us(), 0);
        }
        went_on = went_on.max(mission.ways().next().unwrap());
    }
    let flown = observer.flown(&mission);
    assert!(went_on > 12.0 && flown.depth_m < 9.0, "{} of {went_on}", flown.depth_m);
    let short = flown.wrong.iter().find(|(_, cause)| *cause == Cause::Short).unwrap();
    assert!((short.0 - 40.0).abs() < 0.01, "{short:?}");
}

#[test]
fn a_pilot_without_more_time_holds_the_head_once_and_goes_home() {
    let mut scenario = straight();
    scenario.pilot[1].at_us = 20_000_000;
    scenario.pilot[2].at_us = 60_000_000;
    let world = scenario.world();
    let mut mission = Mission::new(&scenario, &world, 7);
    let mut pilot = Pilot::of(&scenario);
    while !mission.is_over() {
        mission.round();
        if pilot.steer(&mut mission) {
            break;
        }
    }
    let (why, at_s) = pilot.ended.unwrap();
    assert_eq!(why, Why::Time);
    assert!((20.0..20.5).contains(&at_s), "{at_s}");
    let home = mission.pilot().last().unwrap();
    let home_s = home.at_us as f32 * 1e-6;
    assert_eq!(home.task, units::Order::Return);
    assert!((home_s - at_s - HOLDS_S).abs() < 0.5, "{home_s}");
}

/// The odometer counts from where the head takes off, 1.05 m in.
#[test]
fn the_pilot_stops_the_head_at_the_depth_from_the_base() {
    let mut scenario = straight();
    scenario.depth_m = Some(12.0);
    let world = scenario.world();
    let mut mission = Mission::new(&scenario, &world, 7);
    let mut pilot = Pilot::of(&scenario);
    while pilot.ended.is_none() && !mission.is_over() {
        mission.round();
        pilot.steer(&mut mission);
    }
    assert_eq!(pilot.ended.map(|(why, _)| why), Some(Why::There));
    let head_m = mission.ways().next().unwrap();
    assert!((head_m - 12.0).abs() < 0.5, "{head_m}");
}

#[test]
fn a_mission_tells_why_its_pilot_ended_the_exploration() {
    let mut told = PlacesBench::small(small("ended"), &[12.0]);
    told.each = true;
    let outcome = told.run(&mut Session::new("places", 7, true, None)).unwrap();
    let missions = outcome.json["missions"].as_array().unwrap();
    assert!(missions.iter().all(|mission| mission["ended"] == "there"), "{missions:?}");
    assert!(!missions.is_empty());
}

#[test]
fn no_two_rows_share_the_name_of_a_file() {
    let row = |place: &str| Row {
        place: place.to_owned(),
        from: "1".to_owned(),
        depth_m: Some(20.0),
        relays: None,
        fidelity: Fidelity::Point,
        flights: Vec::new(),
        refused: None,
    };
    let rows = ["ä.svx", "ö.svx", "a/b.svx", "a-b.svx", "A-B.svx"].map(row);
    let expected = [
        "ä-svx-from-1-20",
        "ö-svx-from-1-20",
        "a-b-svx-from-1-20",
        "a-b-svx-from-1-20-2",
        "A-B-svx-from-1-20-3",
    ];
    assert_eq!(row::stems(&rows), expected);
}

#[test]
fn a_folder_has_to_be_named() {
    let command = Entry::of::<PlacesBench>().command();
    let error = command.try_get_matches_from(["places"]).unwrap_err();
    assert!(error.to_string().contains("--data <DIR>"), "{error}");
    assert_eq!(error.exit_code(), 2);
}
