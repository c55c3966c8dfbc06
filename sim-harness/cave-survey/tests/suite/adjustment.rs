//! What must be true of positions, however a survey's legs lie.

use cave_survey::Survey;
use proptest::prelude::*;

use super::{assert_at, at, svx};

#[test]
fn a_loop_shares_its_error_and_reports_it() {
    let survey = svx("*fix 1 0 0 0\n1 2 10 0 0\n2 3 10 120 0\n3 1 10.6 240 0\n").unwrap();
    assert_at(&survey, "2", [0.25, 10.06, 0.0]);
    assert_at(&survey, "3", [9.08, 5.24, 0.0]);
    let worst = survey.misclosure.unwrap();
    assert!((worst.error - 0.6).abs() < 1e-6, "{worst:?}");
    assert!((worst.length - 30.6).abs() < 1e-6, "{worst:?}");
    assert_eq!(survey.loops, 1);
}

#[test]
fn a_traverse_between_two_fixed_stations_is_stretched() {
    let survey = svx("*fix 1 0 0 0\n*fix 3 0 22 0\n1 2 10 0 0\n2 3 10 0 0\n").unwrap();
    assert_at(&survey, "2", [0.0, 11.0, 0.0]);
    assert_eq!(survey.loops, 0, "cavern counts none here");
    assert!((survey.misclosure.unwrap().error - 2.0).abs() < 1e-9);
}

#[test]
fn loops_are_counted_as_cavern_counts_them() {
    let star =
        |legs: u32| (1..=legs).map(|n| format!("0 {n} 10 {} 0\n", n * 20)).collect::<String>();
    let counts = [
        (star(4), 0),
        // cavern counted one at a fixed station with five legs until its version 1.4.12.
        (star(5), 0),
        (star(16), 0),
        (
            "1 2 10 0 0\n2 3 10 120 0\n3 1 10 240 0\n1 4 10 0 0\n4 5 10 120 0\n5 1 10 240 0\n"
                .into(),
            2,
        ),
        ("1 2 10 0 0\n*equate 1 3\n*equate 3 1\n".into(), 0),
        ("1 2 10 0 0\n2 1 10 180 0\n".into(), 1),
    ];
    for (text, loops) in counts {
        assert_eq!(svx(&text).unwrap().loops, loops, "{text}");
    }
}

/// What is said of a survey that is not all joined.
fn remarks(text: &str) -> (Survey, Vec<String>) {
    let survey = svx(text).unwrap_or_else(|refusal| panic!("{text}: {refusal}"));
    let told = survey.warnings.iter().map(ToString::to_string).collect();
    (survey, told)
}

#[test]
fn a_part_that_nothing_joins_is_left_out_with_a_remark_that_names_a_station() {
    let (survey, told) = remarks(
        "*begin pot\n*begin main\n1 2 20 90 0\n2 3 20 90 0\n*end main\n*begin upstream\n1 2 15 0 0\n\
         2 3 5 0 0\n3 1 15 180 0\n*data passage station left right up down\n1 1 1 1 1\n\
         *end upstream\n*end pot\n",
    );
    assert_eq!(
        told,
        ["cave.svx:7: no leg joins station \"pot.upstream.1\" and 2 others to station \
          \"pot.main.1\": they are left out"]
    );
    let summary = survey.summary();
    assert_eq!((summary.legs, summary.stations, summary.with_dimensions), (2, 3, 0));
    assert!(survey.misclosure.is_none(), "the loop is in the part that is left out");
    assert!(survey.station_named("pot.upstream.1").is_none());
}

#[test]
fn each_part_that_nothing_joins_has_a_remark() {
    let (survey, told) =
        remarks("*fix a 0 0 0\na b 1 0 0\nc . 1 0 0\nd e 1 0 0\n*equate f g\n*fix h 1 1 1\n");
    assert_eq!(
        told,
        [
            "cave.svx:6: the fixed station \"h\" is used by no leg",
            "cave.svx:3: no leg joins station \"c\" and 1 other to a fixed one: they are left out",
            "cave.svx:4: no leg joins station \"d\" and 1 other to a fixed one: they are left out",
            "cave.svx:5: no leg joins station \"f\" and 1 other to a fixed one: they are left out",
        ]
    );
    assert_eq!(survey.summary().stations, 3);
}

#[test]
fn a_part_of_stations_without_names_has_a_remark_at_its_line() {
    let (_, told) = remarks("*fix 1 0 0 0\n2 .. 1 0 0\n3 4 1 0 0\n*equate 1 3\n");
    assert_eq!(
        told[0],
        "cave.svx:2: no leg joins station \"2\" and 1 other to a fixed one: they are left out"
    );
}

#[test]
fn where_nothing_is_fixed_on_the_earth_the_first_station_is_the_origin() {
    let (survey, told) = remarks("*cs UTM33N\n*cs out UTM33N\n1 2 10 0 0\n3 2 5 0 0\n");
    assert_at(&survey, "3", [0.0, 5.0, 0.0]);
    assert_eq!(told, ["cave.svx:3: no station is fixed, so that station \"1\" is put at 0, 0, 0"]);
}

/// A survey of random legs among few stations, every one of which hangs together with the first.
fn network() -> impl Strategy<Value = Vec<(usize, usize, f64, f64, f64)>> {
    let leg = (0usize..100, 0.5..20.0f64, 0.0..360.0f64, -60.0..60.0f64);
    prop::collection::vec(leg, 1..40).prop_map(|legs| {
        let legs = legs.into_iter().enumerate().map(|(n, (other, length, bearing, slope))| {
            // Every third leg closes a loop between stations that are there already.
            let known = n - n / 3;
            let (from, to) = if n % 3 == 2 {
                (other % known, n * 7 % known)
            } else {
                (other % (known + 1), known + 1)
            };
            (from, to, length, bearing, slope)
        });
        legs.filter(|(from, to, ..)| from != to).collect()
    })
}

fn text(legs: &[(usize, usize, f64, f64, f64)]) -> String {
    let line = |(from, to, length, bearing, slope): &(usize, usize, f64, f64, f64)| {
        format!("s{from} s{to} {length:.2} {bearing:.1} {slope:.1}\n")
    };
    legs.iter().map(line).collect()
}

fn off(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The same survey with its legs in another order; each leg keeps its direction.
fn backwards(legs: &[(usize, usize, f64, f64, f64)]) -> Survey {
    let reversed: Vec<_> = legs.iter().rev().copied().collect();
    svx(&format!("*fix s0 0 0 0\n{}", text(&reversed))).unwrap()
}

proptest! {
    #[test]
    fn the_order_of_the_lines_moves_no_station(legs in network()) {
        prop_assume!(legs.iter().any(|leg| leg.0 == 0 || leg.1 == 0));
        // Successive measurements of one leg are averaged, in one order and perhaps not the other.
        prop_assume!(legs.windows(2).all(|two| (two[0].0, two[0].1) != (two[1].0, two[1].1)));
        let Ok(survey) = svx(&format!("*fix s0 0 0 0\n{}", text(&legs))) else { return Ok(()) };
        let other = backwards(&legs);
        for station in &survey.stations {
            prop_assert!(off(station.position, at(&other, &station.name)) < 1e-6, "{}", station.name);
        }
    }

    #[test]
    fn legs_that_contradict_nothing_keep_their_measures(legs in network()) {
        let tree: Vec<_> = legs.into_iter().filter(|(from, to, ..)| to > from).collect();
        let mut reached = std::collections::HashSet::from([0]);
        let tree: Vec<_> = tree.into_iter().filter(|leg| reached.contains(&leg.0) && reached.insert(leg.1)).collect();
        prop_assume!(!tree.is_empty());
        let survey = svx(&text(&tree)).unwrap();
        for (leg, (_, _, length, ..)) in survey.legs.iter().zip(&tree) {
            let rounded = (length * 100.0).round() / 100.0;
            prop_assert!((cave_survey::norm(survey.vector(leg)) - rounded).abs() < 1e-6);
        }
        prop_assert!(survey.misclosure.is_none());
    }
}
