//! Regression: the verdict calls a mission failed when an onlooker would.
//!
//! `run` said *success* of a head that stood at a corner with relays waiting, of drones that landed on
//! each other, and of drones that were left inside; `campaign` said nothing of the kind.

use sim_harness::measure::campaign::{Run, Verdicts, fly_until};
use sim_harness::measure::metrics::Reference;
use sim_harness::measure::verdict::{Ended, Failure};
use sim_harness::mission::Mission;
use sim_harness::scenario::Scenario;

use crate::scenario_text;

/// A scenario of two relays with this tunnel, these further sections and these orders, each with its
/// time in seconds and its speed in m/s.
fn scenario(
    name: &str,
    tunnel: &str,
    sections: &str,
    orders: &[(f32, &str, Option<f32>)],
) -> Scenario {
    let mut text = format!(
        "title = \"A verdict\"\nduration_s = 120.0\n{sections}\n[tunnel]\nwidth_m = 1.2\n{tunnel}\n"
    );
    for (at_s, order, speed) in orders {
        text += &format!("[[pilot]]\nat_s = {at_s:.1}\norder = \"{order}\"\n");
        text += &speed.map_or_else(String::new, |speed| format!("speed_mps = {speed:.1}\n"));
    }
    scenario_text::read(&format!("verdict/{name}"), &text)
}

fn fly(scenario: &Scenario) -> Vec<Run> {
    let world = scenario.world();
    let reference = Reference::of(scenario, &world);
    let never = std::sync::atomic::AtomicBool::new(false);
    fly_until(&never, scenario, &world, &reference, 1, 2, || ())
}

fn names(run: &Run) -> Vec<&'static str> {
    run.judgement.failures.iter().map(Failure::name).collect()
}

const STRAIGHT: &str = "centre_line_m = [[0.0, 0.0], [12.0, 0.0]]";
const RELAYS: &str = "drones = { relays = 2 }";
const PUSH: Option<f32> = Some(0.2);
const STILL: Option<f32> = Some(0.0);

/// The head stands at the limit for want of a relay that may not take off for a minute.
#[test]
fn a_head_that_stands_while_relays_wait_is_stuck_and_has_not_done_its_order() {
    let late = format!(
        "{RELAYS}\n[launch]\nlimit_dbm = -48.0\narm_delay_s = 60.0\n[retreat]\nlimit_dbm = -58.0"
    );
    let orders = [(1.0, "explore", PUSH), (60.0, "explore", STILL)];
    for run in fly(&scenario("stuck", STRAIGHT, &late, &orders)) {
        assert_eq!(run.judgement.ended, Some(Ended::Stuck), "{:?}", run.judgement);
        assert!(run.judgement.stood_s > 15.0, "{:?}", run.judgement);
        assert!(run.judgement.came_m < 5.0 && run.judgement.could_m > 6.0, "{:?}", run.judgement);
        let names = names(&run);
        assert!(names.contains(&"stuck") && names.contains(&"depth-missed"), "{names:?}");
    }
}

/// A right angle after 10 m; the pilot stops the head before it.
#[test]
fn a_head_that_the_pilot_stops_has_done_its_order() {
    let corner = "centre_line_m = [[0.0, 0.0], [10.0, 0.0], [10.0, 8.0]]";
    let orders = [(2.0, "explore", PUSH), (30.0, "explore", STILL)];
    for run in fly(&scenario("stopped", corner, RELAYS, &orders)) {
        assert_eq!((names(&run), run.judgement.ended), (vec![], Some(Ended::Pilot)));
        let (came, could) = (run.judgement.came_m, run.judgement.could_m);
        assert!((5.0..7.0).contains(&came) && could < 7.0, "{came} of {could} m");
    }
}

#[test]
fn a_drone_that_was_called_home_and_landed_on_its_way_was_left_inside() {
    let orders = [(1.0, "explore", PUSH), (40.0, "return", None), (45.0, "land", None)];
    let runs = fly(&scenario("inside", STRAIGHT, RELAYS, &orders));
    for run in &runs {
        assert!(names(run).contains(&"left-inside-order"), "{:?}", run.judgement);
    }
    let verdicts = Verdicts::of(&runs);
    assert_eq!(verdicts.failed(), 2);
    let json = verdicts.json();
    let share = &json["failures"]["left-inside-order"];
    assert_eq!((&share["value"], &share["seeds"]), (&1.0.into(), &serde_json::json!([1, 2])));
    assert_eq!((&json["success"]["value"], &json["ended"]["pilot"]), (&0.0.into(), &1.0.into()));
}

/// The same order to land, and no call home.
#[test]
fn a_drone_that_was_ordered_to_land_may_land_anywhere() {
    let orders = [(1.0, "explore", PUSH), (40.0, "land", None)];
    for run in fly(&scenario("landed", STRAIGHT, RELAYS, &orders)) {
        assert_eq!(names(&run), Vec::<&str>::new());
    }
}

#[test]
fn drones_that_land_where_others_stand_are_told_of() {
    let beside = "[drones]\nrelays = 2\nstart = \"placed\"\nat_m = [4.0, 3.86, 1.5]";
    let runs = fly(&scenario("beside", STRAIGHT, beside, &[(0.4, "land", None)]));
    for run in runs {
        let names = names(&run);
        assert!(names.contains(&"touched-drone"), "{names:?}");
        let stands = ["stands-on-drone", "stands-in-anothers-place"];
        assert!(stands.iter().any(|name| names.contains(name)), "{names:?}");
    }
}

/// Drones on the ground lose 10 dB each.
#[test]
fn the_true_strength_is_what_a_receiver_gets() {
    let sections = format!("{RELAYS}\n[radio]\nground_loss_db = 10.0");
    let scenario = scenario("ground", STRAIGHT, &sections, &[]);
    let world = scenario.world();
    let mut mission = Mission::new(&scenario, &world, 1);
    mission.round();
    let loss = |one, other| {
        (mission.large_scale_strength(one, other) - mission.true_strength(one, other)).0
    };
    assert!((loss(0, 1) - 20.0).abs() < 1e-3, "two drones: {}", loss(0, 1));
    assert!((loss(0, 3) - 10.0).abs() < 1e-3, "a drone and the base: {}", loss(0, 3));
}
