//! What every route through a survey must keep: no water, one level, no slope that rangers take for a
//! wall, and a reason with a leg wherever it ends.

use std::path::{Path, PathBuf};

use benchmarks::places::invariants;
use cave_survey::{Memory, Survey, read};
use maps::{Ends, Hindrance, HindranceKind, Map, Route, RouteEnd, RouteError, STEEPEST_DEG, open};
use world::Tunnel;

/// A gallery, a sump of 12 m, and 30 m behind it.
const SUMP: &str = "1 2 20 90 0\n2 3 20 90 0\n*data diving from to tape compass fromdepth todepth\n\
                    3 4 12 90 0 -5\n*data normal from to tape compass clino\n4 5 30 90 0\n\
                    *entrance 1\n";

/// A ramp that turns four times by a right angle and passes 12 m above its own beginning.
const SPIRAL: &str = "1 2 20 0 0\n2 3 20 90 12\n3 4 20 180 12\n4 5 20 270 12\n5 6 20 0 0\n\
                      6 7 20 0 0\n*entrance 1\n";

/// A way down a slope and back above it, with a long gallery behind.
const HAIRPIN: &str = "1 2 9 90 0\n2 3 9 90 -28\n3 4 1 0 0\n4 5 9 270 0\n5 6 40 270 0\n";

/// A step, a slope and a shaft beside a gallery.
const STEPS: &str = "1 2 20 90 0\n2 3 1.88 - UP\n2 4 10 0 40\n2 5 9 - DOWN\n5 6 33 0 0\n\
                     2 7 3.5 0 -36\n*entrance 1\n";

const SQUEEZES: &str = "1 2 20 90 0\n2 3 6 90 10 ; up through squeeze\n3 4 9 90 0\n2 5 8 0 0\n\
                        *data passage station left right up down\n5 .1 .2 1 1\n*entrance 1\n";

fn survey(text: &str) -> Survey {
    read(&Memory::default().with("cave.svx", text), "cave.svx").unwrap()
}

fn find(text: &str, from: &str, to: &str) -> Result<(Route, Tunnel), RouteError> {
    let given = |name: &str| (!name.is_empty()).then(|| name.to_owned());
    let ends = Ends { from: given(from), to: given(to), around_m: None };
    Route::find(&survey(text), &ends)
}

fn told(hindrances: &[Hindrance]) -> Vec<String> {
    hindrances.iter().map(ToString::to_string).collect()
}

#[test]
fn water_ends_a_route_and_says_what_lies_beyond() {
    for (from, to) in [("", ""), ("1", "")] {
        let (route, _) = find(SUMP, from, to).unwrap();
        assert_eq!(route.to, "3", "from {from:?}");
        let RouteEnd::Hindered(end) = &route.ended else { panic!("{:?}", route.ended) };
        assert_eq!((&*end.from, &*end.to, end.kind), ("3", "4", HindranceKind::Water));
        assert_eq!(route.ended.to_string(), "3 to 4 is under water (30 m beyond)");
    }
    let error = find(SUMP, "1", "5").unwrap_err().to_string();
    assert!(error.ends_with("cannot be flown: 3 to 4 is under water (30 m beyond)"), "{error}");
    let dived =
        "*data diving from to tape compass fromdepth todepth\n1 2 12 90 0 -5\n2 3 9 90 -5 -6\n";
    let error = find(dived, "", "").unwrap_err().to_string();
    let all = "there is no way of 5 m that can be flown: 1 to 2 is under water (9 m beyond), \
               2 to 3 is under water";
    assert_eq!(error, all);
}

#[test]
fn a_route_does_not_pass_above_or_below_itself() {
    let (route, _) = find(SPIRAL, "1", "").unwrap();
    assert_eq!(route.to, "4", "{:?}", route.ended);
    let words = "4 to 5 passes 12.2 m above 1 to 2, and a floor plan has one level";
    assert_eq!(route.ended.to_string(), words);
    assert!(route.warnings.iter().any(|warning| warning.text.starts_with(words)));
    let Err(RouteError::Crosses(_, _, crossing)) = find(SPIRAL, "1", "7") else { panic!() };
    assert_eq!(crossing.leg, ["4", "5"]);
    // Where both ends are open, the longest piece is taken.
    let (route, _) = find(SPIRAL, "", "").unwrap();
    assert_eq!((&*route.from, &*route.to), ("3", "7"), "{:?}", route.warnings);
    let (route, _) = find(SPIRAL, "", "7").unwrap();
    assert_eq!((&*route.from, &*route.to), ("3", "7"));
    let (route, _) = find(HAIRPIN, "1", "").unwrap();
    assert_eq!((&*route.to, route.crossing.is_some()), ("4", true), "{:?}", route.ended);
    // A bend on a slope is no other level.
    let (route, _) = find("1 2 9 90 -25\n2 3 9 150 -25\n3 4 9 90 -25\n", "1", "").unwrap();
    assert_eq!((&*route.to, &route.ended), ("4", &RouteEnd::Survey));
}

/// A beam's cone of 27° (UM2555) at 45° to the course meets a floor of this slope 0.45 m away, where the
/// drone takes it for a wall.
#[test]
fn the_steepest_slope_is_the_one_that_no_beam_takes_for_a_wall() {
    let lower = 0.45 * 13.5_f64.to_radians().tan();
    let steepest = ((0.3 - lower) / (0.45 * 45_f64.to_radians().cos())).atan().to_degrees();
    assert!(STEEPEST_DEG < steepest && STEEPEST_DEG > steepest - 2.0, "{steepest}");
    let slope = |deg: f64| format!("1 2 20 90 0\n2 3 10 90 {deg}\n3 4 20 90 0\n");
    assert_eq!(find(&slope(29.9), "1", "").unwrap().0.to, "4");
    let (route, _) = find(&slope(-30.1), "1", "").unwrap();
    assert_eq!(route.ended.to_string(), "2 to 3 is a slope of 30°, 5.0 m high (20 m beyond)");
}

#[test]
fn a_step_is_no_shaft_and_a_refusal_names_a_leg() {
    let (route, _) = find(STEPS, "1", "2").unwrap();
    let expected = [
        "2 to 5 is a shaft of 9.0 m at 90° (33 m beyond)",
        "2 to 3 is a step of 1.88 m",
        "2 to 4 is a slope of 40°, 6.4 m high",
        "2 to 7 is a step of 2.06 m",
    ];
    assert_eq!(told(&route.hindrances), expected);
    let error = find("1 2 1.88 - UP\n2 3 4 90 0\n", "", "").unwrap_err().to_string();
    let words = "there is no way of 5 m that can be flown, but 4.0 m from 3 to 2: \
                 2 to 1 is a step of 1.88 m";
    assert_eq!(error, words);
    let error = find("1 2 3 90 0\n", "", "").unwrap_err().to_string();
    let words = "there is no way of 5 m that can be flown, but 3.0 m from ";
    assert!(error.starts_with(words), "{error}");
}

#[test]
fn a_squeeze_that_is_named_or_half_measured_is_not_flown() {
    let (route, _) = find(SQUEEZES, "1", "2").unwrap();
    let expected = [
        "2 to 3 is called a squeeze, and has no measured width (9 m beyond)",
        "2 to 5 is a squeeze of 0.30 m",
    ];
    assert_eq!(told(&route.hindrances), expected);
    // A width that was measured counts more than a word.
    let wide = "*data passage station left right up down\n2 1 1 1 1\n3 1 1 1 1\n";
    let (route, _) = find(&format!("{SQUEEZES}{wide}"), "1", "").unwrap();
    assert_eq!(route.to, "4");
    // One side that was measured counts, and the other is assumed.
    let half = "1 2 20 90 0\n*data passage station left right up down\n1 .2 - 1 1\n2 .2 - 1 1\n";
    let (_, tunnel) = find(half, "1", "2").unwrap();
    let middle = tunnel.skeleton().edge(0).line().at(10.0).0;
    let width = tunnel.range(middle, [0.0, 1.0], 9.0) + tunnel.range(middle, [0.0, -1.0], 9.0);
    assert!((width - 0.95).abs() < 0.01, "{width}");
}

/// From the middle of a passage of 5 m, beams at 45° meet its walls after 3.5 m.
#[test]
fn a_wide_passage_is_flown_with_rangers_that_see_its_walls() {
    let passage = |half: f32| {
        format!(
            "1 2 20 90 0\n2 3 20 60 0\n*data passage station left right up down\n\
             1 {half} {half} 2 1\n2 {half} {half} 2 1\n3 {half} {half} 2 1\n"
        )
    };
    let reach = |half| find(&passage(half), "1", "3").unwrap().0.long_reach_m;
    assert_eq!([reach(1.0), reach(2.5)], [None, Some(4.0)]);
}

/// The legs of a refusal or of an end are legs of the survey.
fn assert_names_a_leg(survey: &Survey, from: &str, to: &str, what: &str) {
    let same = |a: usize, name: &str| {
        let point = survey.stations[a].point;
        survey.station_named(name).is_some_and(|it| survey.stations[it].point == point)
    };
    let is_leg = survey.legs.iter().any(|leg| {
        same(leg.from, from) && same(leg.to, to) || same(leg.from, to) && same(leg.to, from)
    });
    assert!(is_leg, "{what}: {from} to {to} is no leg");
}

/// No two places of a route that are more than 4 m apart along it are within 1.5 m in the plan with
/// more than 3 m of height between.
fn assert_one_level(route: &Route, tunnel: &Tunnel, what: &str) {
    assert_eq!(invariants::one_level(route, tunnel), None, "{what}");
}

/// A drone that flies along the route, at any place across the passage, comes to the end with the
/// route's length.
fn assert_true_length(tunnel: &Tunnel, what: &str) {
    assert_eq!(invariants::true_length(tunnel), None, "{what}");
}

fn assert_invariants(survey: &Survey, ends: &Ends, what: &str) -> Option<Tunnel> {
    let mut dug = None;
    let hindrances = match Route::find(survey, ends) {
        Ok((route, tunnel)) => {
            assert_one_level(&route, &tunnel, what);
            dug = Some(tunnel);
            if let RouteEnd::Hindered(end) = &route.ended {
                assert_eq!(end.from, route.to, "{what}");
            }
            route.hindrances
        }
        Err(RouteError::Hindered(_, _, hindrances)) => {
            assert!(!hindrances.is_empty(), "{what}");
            hindrances
        }
        Err(RouteError::TooShort(short)) => {
            let has_reason = short.longest.is_some() || !short.hindrances.is_empty();
            assert!(has_reason, "{what}: {short}");
            short.hindrances
        }
        Err(RouteError::Crosses(_, _, crossing)) => {
            for [from, to] in [crossing.leg, crossing.other] {
                assert_names_a_leg(survey, &from, &to, what);
            }
            Vec::new()
        }
        Err(error) => panic!("{what}: {error}"),
    };
    for Hindrance { from, to, .. } in hindrances.iter().filter(|it| !it.to.starts_with('(')) {
        assert_names_a_leg(survey, from, to, what);
    }
    dug
}

fn crooked() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/caves/crooked.svx")
}

/// The tunnels of the longest route, and of those from and to every so-many-th station, by what they
/// are.
fn assert_all_routes(survey: &Survey, every: usize, name: &str) -> Vec<(String, Tunnel)> {
    let mut dug = Vec::new();
    let mut check = |ends: &Ends, what: String| {
        dug.extend(assert_invariants(survey, ends, &what).map(|tunnel| (what, tunnel)));
    };
    check(&Ends::default(), name.to_owned());
    let joined = |station: usize| {
        let mut legs = survey.legs.iter().filter(|leg| !leg.flags.splay && !leg.flags.surface);
        legs.any(|leg| [leg.from, leg.to].contains(&station))
    };
    for (n, station) in survey.stations.iter().enumerate().step_by(every) {
        if station.name.is_empty() || station.is_wall || !joined(n) {
            continue;
        }
        let here = Some(station.name.clone());
        let from = Ends { from: here.clone(), to: None, around_m: None };
        check(&from, format!("{name} from {}", station.name));
        let to = Ends { from: None, to: here, around_m: None };
        check(&to, format!("{name} to {}", station.name));
    }
    dug
}

#[test]
fn every_route_has_one_level_its_true_length_and_a_leg_for_what_ends_it() {
    let texts = [SUMP, SPIRAL, HAIRPIN, STEPS, SQUEEZES];
    let Ok(Map::Survey(crooked)) = open(&crooked(), None) else { panic!() };
    for (n, survey) in texts.into_iter().map(survey).chain([crooked]).enumerate() {
        for (what, tunnel) in assert_all_routes(&survey, 1, &format!("survey {n}")) {
            assert_true_length(&tunnel, &what);
        }
    }
}

#[test]
#[ignore = "needs the surveys in ../shared/data"]
fn recorded_caves_have_routes_of_one_level_and_a_leg_for_what_ends_them() {
    let caves = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/caves");
    for name in [
        "dowprov/DowProv.svx",
        "fulford/Fulfords.mak",
        "mietusia_wyznia/Surveys/Jaskinia_Mietusia_Wyznia/mietusia_wyznia.svx",
        "suhadolca/suhadolca.wpj",
    ] {
        let Ok(Map::Survey(survey)) = open(&caves.join(name), Some(&caves)) else { panic!() };
        assert_all_routes(&survey, survey.stations.len() / 40, name);
    }
}
