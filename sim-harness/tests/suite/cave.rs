//! A surveyed cave as the tunnel of a mission.

use std::path::{Path, PathBuf};

use cave_survey::{Memory, read};
use maps::{Ends, HindranceKind, MapChoice, Route, RouteError};
use sim_harness::scenario::Scenario;
use units::Point2;
use world::Tunnel;

fn crooked() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/caves/crooked.svx")
}

fn ends(from: &str, to: &str) -> Ends {
    let given = |name: &str| (!name.is_empty()).then(|| name.to_owned());
    Ends { from: given(from), to: given(to), around_m: None }
}

fn find(text: &str, from: &str, to: &str) -> Result<(Route, Tunnel), RouteError> {
    let survey = read(&Memory::default().with("cave.svx", text), "cave.svx").unwrap();
    Route::find(&survey, &ends(from, to))
}

/// The range to the left and to the right wall at a point of the route, looking east.
fn sides(tunnel: &Tunnel, at: [f32; 2]) -> [f32; 2] {
    let at = Point2::new(at[0], at[1]);
    [[0.0, 1.0], [0.0, -1.0]].map(|direction| tunnel.range(at, direction, 50.0))
}

#[test]
fn a_passage_is_as_wide_as_it_was_measured_and_its_line_is_in_its_middle() {
    let text = "1 2 20 90 0\n2 3 20 90 0\n*data passage station left right up down\n1 1 3 2 1\n2 1 3 2 1\n3 1 3 2 1\n";
    let (route, tunnel) = find(text, "1", "3").unwrap();
    assert_eq!((&*route.from, &*route.to, route.assumed_widths), ("1", "3", 0));
    assert!((tunnel.skeleton().edge(0).line().length() - 40.0).abs() < 1e-3);
    // The base is at the station's place; the middle is 1 m to its right.
    let [left, right] = sides(&tunnel, [10.0, -1.0]);
    assert!((left - 2.0).abs() < 1e-3 && (right - 2.0).abs() < 1e-3, "{left} {right}");
}

#[test]
fn splays_give_widths_where_there_are_no_dimensions_and_none_are_assumed_without() {
    let splays = "*flags splay\n1 . 1 0 0\n1 . 2 180 0\n1 . 9 0 80\n2 . 1 0 0\n2 . 2 180 0\n";
    let (route, tunnel) = find(&format!("1 2 10 90 0\n{splays}"), "1", "2").unwrap();
    assert_eq!(route.assumed_widths, 0);
    let [left, right] = sides(&tunnel, [5.0, 0.0]);
    assert!((left - 1.0).abs() < 1e-3 && (right - 2.0).abs() < 1e-3, "{left} {right}");
    let (route, _) = find("1 2 10 90 0\n", "1", "2").unwrap();
    assert_eq!(route.assumed_widths, 2);
}

#[test]
fn a_route_follows_no_splay_no_shot_over_ground_and_no_part_that_is_left_out() {
    let head = "Cave\nSURVEY NAME: A\nSURVEY DATE: 6 29 1987\nSURVEY TEAM:\nme\n\
                DECLINATION: 0 FORMAT: DMMDLUDRLADadNF\n\nFROM TO LEN\n\n";
    let shots = "a0 a1 32.81 90 0 3 3 3 3\na1 a2 32.81 90 0 3 3 3 3\na2 w 65.62 60 0 3 3 3 3 #|LS#\n\
                 a0 s1 164.05 270 0 -999 -999 -999 -999 #|P#\ns1 s2 164.05 270 0 3 3 3 3 #|P#\n";
    let files = Memory::default().with("cave.dat", format!("{head}{shots}"));
    let survey = read(&files, "cave.dat").unwrap();
    let (route, _) = Route::find(&survey, &ends("", "")).unwrap();
    let mut named = [&*route.from, &*route.to];
    named.sort_unstable();
    assert_eq!(named, ["a0", "a2"]);
    assert!((route.length_m - 20.0).abs() < 0.01, "{}", route.length_m);
    let apart = "1 2 20 90 0\n2 3 20 90 0\n11 12 90 90 0\n12 13 90 90 0\n";
    let (route, _) = find(apart, "", "").unwrap();
    assert!((route.length_m - 40.0).abs() < 0.01 && route.warnings.len() == 1);
    assert!(matches!(find(apart, "11", ""), Err(RouteError::Unknown(_))));
}

#[test]
fn what_cannot_be_flown_is_named() {
    let dimensions =
        "*data passage station left right up down\n3 .2 .2 2 1\n4 .2 .2 2 1\n5 1 1 .2 .2\n";
    let text = format!("1 2 10 90 0\n2 3 10 90 60\n3 4 8 90 0\n4 5 8 90 0\n{dimensions}");
    let Err(RouteError::Hindered(_, _, hindrances)) = find(&text, "1", "5") else { panic!() };
    let kinds: Vec<_> = hindrances.iter().map(|it| (&*it.from, it.kind)).collect();
    assert!(matches!(kinds[0], ("2", HindranceKind::Shaft { .. })), "{kinds:?}");
    assert!(matches!(kinds[1], ("3", HindranceKind::Squeeze { .. })), "{kinds:?}");
    assert_eq!(kinds.len(), 3);
    let low = "1 2 10 90 0\n*data passage station left right up down\n1 1 1 .2 .2\n";
    let Err(RouteError::Hindered(_, _, hindrances)) = find(low, "1", "2") else { panic!() };
    assert!(matches!(hindrances[0].kind, HindranceKind::Low { .. }));
}

#[test]
fn a_small_step_is_no_shaft_and_a_slope_that_beams_see_over_is_none() {
    let (route, _) = find("1 2 10 90 0\n2 3 .25 0 +V\n3 4 10 90 29\n", "1", "4").unwrap();
    assert!((route.length_m - 20.25).abs() < 1e-9);
    assert!(matches!(find("1 2 10 90 31\n", "1", "2"), Err(RouteError::Hindered(..))));
}

#[test]
fn the_longest_way_is_flown_where_none_is_named_and_it_begins_at_the_entrance() {
    let text = "1 2 5 90 0\n2 3 30 90 0\n2 4 8 0 0\n*entrance 4\n";
    let (route, _) = find(text, "", "").unwrap();
    assert_eq!((&*route.from, &*route.to), ("4", "3"));
    let (route, _) = find(text, "1", "").unwrap();
    assert_eq!((&*route.from, &*route.to), ("1", "3"));
    let (route, _) = find(text, "", "1").unwrap();
    assert_eq!((&*route.from, &*route.to), ("3", "1"));
    let Err(RouteError::TooShort(short)) = find("1 2 9 - DOWN\n", "", "2") else { panic!() };
    assert_eq!(short.hindrances[0].to_string(), "2 to 1 is a shaft of 9.0 m at 90°");
}

#[test]
fn a_route_of_kilometres_is_cut_and_the_tunnel_holds_nothing_beside_it() {
    let leg = |n: usize| format!("{n} {} 10 90 0\n", n + 1);
    let main: String = (0..400).map(leg).collect();
    let aside: String = (1000..4900).map(leg).collect();
    let (route, tunnel) =
        find(&format!("*fix 0 0 0 0\n*fix 1000 0 9 0\n{main}{aside}"), "0", "").unwrap();
    assert!(route.is_cut && route.length_m <= 300.0);
    let corners: usize = tunnel.floor_plan().outlines.iter().map(Vec::len).sum();
    assert!(corners < 1000, "{corners}");
}

#[test]
fn a_scenario_names_a_map_beside_itself() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cave");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::copy(crooked(), folder.join("crooked.svx")).unwrap();
    let scenario = |tunnel: &str| {
        let text =
            format!("title = \"x\"\nduration_s = 1.0\n[tunnel]\n{tunnel}\n[drones]\nrelays = 1\n");
        std::fs::write(folder.join("scenario.toml"), text).unwrap();
        Scenario::read(&folder.join("scenario.toml"))
    };
    let read = scenario("map = \"crooked.svx\"\nfrom = \"crooked.1\"\nto = \"crooked.7\"").unwrap();
    let route = read.route.unwrap();
    assert_eq!((&*route.from, &*route.to), ("crooked.1", "crooked.7"));
    for (tunnel, told) in [
        ("map = \"none.svx\"", "none.svx: cannot be read"),
        ("map = \"crooked.svx\"\nto = \"crooked.77\"", "the survey has no station \"crooked.77\""),
        ("map = \"crooked.svx\"\nwidth_m = 1.0", "a map and something drawn beside it"),
        (
            "map = \"crooked.svx\"\nfrom = \"crooked.1\"\nto = \"crooked.8\"",
            "crooked.7 to crooked.8 is a shaft of 12.0 m at 90°",
        ),
        ("width_m = 1.0\nfrom = \"1\"\ncentre_line_m = [[0, 0], [9, 0]]", "belong to a map"),
        ("centre_line_m = [[0, 0], [9, 0]]", "missing key `width_m`"),
    ] {
        let error = scenario(tunnel).unwrap_err().to_string();
        assert!(error.contains(told) && error.lines().count() == 1, "{tunnel}: {error}");
    }
}

#[test]
fn a_chain_flies_in_the_crooked_cave() {
    let map = MapChoice { file: crooked(), ..MapChoice::default() };
    let scenario = Scenario::of_map(map, Some(2), Vec::new()).unwrap();
    assert_eq!(scenario.drones.relays, 2);
    assert_eq!(scenario.route.as_ref().unwrap().from, "crooked.1");
}
