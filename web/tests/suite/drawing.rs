//! A cave that is drawn is flown, or its mistake is told in one line.

use serde_json::json;
use sim_harness::scenario::Scenario;
use uchain_web::drawing::{Drawing, Mistake};

/// The corners of a gallery, m.
type Corners = &'static [[f64; 2]];

/// An L of two legs with a branch from the middle of the first one.
const L_WITH_BRANCH: [Corners; 2] =
    [&[[0.0, 0.0], [5.0, 0.0], [10.0, 0.0], [10.0, 6.0]], &[[5.0, 0.0], [5.0, -4.5]]];

fn drawn(width_m: f64, galleries: &[&[[f64; 2]]]) -> Result<String, Mistake> {
    let drawing = json!({ "width_m": width_m, "galleries": galleries });
    Drawing::read(&drawing.to_string()).unwrap().scenario()
}

#[test]
fn a_drawing_is_a_scenario_with_its_own_tunnel() {
    let text = drawn(1.6, &L_WITH_BRANCH).unwrap();
    assert!(text.contains("[tunnel]\nwidth_m = 1.6\ncentre_line_m = [[0.0, 0.0], [5.0, 0.0], "));
    assert!(
        text.contains(
            "[[tunnel.branch]]\nwidth_m = 1.6\ncentre_line_m = [[5.0, 0.0], [5.0, -4.5]]\n"
        )
    );
    let scenario = Scenario::of_text_with("drawn", &text, &Default::default()).unwrap();
    let lines = scenario.tunnel.floor_plan().centre_lines;
    let length: f32 =
        lines.iter().map(|line| world::Polyline::new(line.points.clone()).length()).sum();
    assert!((length - 20.5).abs() < 0.01, "{length} m of galleries");
}

/// Galleries, a part of what is told of them, and the legs in question.
type Case<'a> = (&'a [Corners], &'a str, &'a [[usize; 2]]);

/// Each drawing is refused with a line about the legs that are wrong in it.
#[test]
fn a_bad_drawing_is_told_in_one_line_with_its_legs() {
    let main: Corners = &[[0.0, 0.0], [5.0, 0.0], [10.0, 0.0]];
    let hook: Corners = &[[0.0, 0.0], [8.0, 0.0], [8.0, 2.5], [4.0, 2.5], [4.0, -3.0]];
    let cases: [Case; 9] = [
        (&[], "put the mouth", &[]),
        (&[&[[0.0, 0.0]]], "put the mouth", &[]),
        (&[&[[0.0, 0.0], [5.0, 0.0], [5.0, 1.0]]], "a leg of 1.0 m is shorter than", &[[0, 1]]),
        (&[hook], "two legs cross", &[[0, 0], [0, 3]]),
        (&[main, &[[5.0, 0.0], [9.0, 1.0]]], "there are 14° between them", &[[0, 1], [1, 0]]),
        (&[main, &[[5.0, 0.0], [5.0, 3.0], [9.0, 1.2]]], "1.2 m apart", &[[0, 1], [1, 1]]),
        (&[&[[0.0, 0.0], [8.0, 0.0], [8.0, 1.7], [0.0, 1.7]]], "1.7 m apart", &[[0, 0], [0, 2]]),
        (&[&[[0.0, 0.0], [6.0, 0.0], [4.47, 0.94]]], "a leg is too short for the bends", &[[0, 1]]),
        (&[main, &[[3.0, 4.0], [9.0, 4.0]]], "a branch begins at no corner", &[[1, 0]]),
    ];
    for (galleries, part, legs) in cases {
        let mistake = drawn(1.6, galleries).expect_err(part);
        assert!(mistake.line.contains(part), "{part}: {}", mistake.line);
        assert_eq!(mistake.line.lines().count(), 1);
        assert_eq!(mistake.legs, legs, "{part}");
    }
}

/// What the simulator alone refuses has no line of a file that the user does not see.
#[test]
fn what_the_simulator_refuses_is_told_without_a_file() {
    for (galleries, part) in [
        ([[0.0, 0.0], [1.6, 0.0]], "row"),
        ([[0.0, 0.0], [499.0, 100.0]], "m long"),
        ([[0.0, 0.0], [600.0, 0.0]], "over 500 m"),
    ] {
        let mistake = drawn(1.6, &[&galleries]).expect_err(part);
        assert!(mistake.line.contains(part), "{part}: {}", mistake.line);
        assert!(!mistake.line.contains(".toml"), "{}", mistake.line);
    }
}

/// A bend of short legs, and legs that part on both sides of one, are good.
#[test]
fn bends_of_short_legs_are_no_mistake() {
    let round: &[[f64; 2]] = &[[0.0, 0.0], [4.0, 0.0], [5.6, 0.6], [6.4, 2.0], [6.4, 6.0]];
    let step: &[[f64; 2]] = &[[0.0, 0.0], [4.0, 0.0], [4.0, 1.6], [8.0, 1.6]];
    for galleries in [&[round][..], &[step], &[round, &[[4.0, 0.0], [4.0, -5.0]]]] {
        drawn(1.6, galleries).unwrap_or_else(|mistake| panic!("{mistake:?}"));
    }
}

#[test]
fn json_that_is_no_drawing_is_refused() {
    for json in ["7", r#"{ "width_m": 1.6 }"#, r#"{ "width_m": 1, "galleries": [[[0, 0, 0]]] }"#] {
        let error = Drawing::read(json).unwrap_err();
        assert!(error.starts_with("this is no drawing"), "{error}");
    }
}
