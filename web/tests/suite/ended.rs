//! A mission that has ended stays as it is: what the user does afterwards is not part of it.

use serde_json::{Value, json};
use uchain_web::{Dropped, Flight};

use crate::bytes::{same, trace_here};

fn all_of(flight: &Flight, files: &Dropped) -> [String; 4] {
    let toml = flight.scenario_toml(files).expect("the flight has a scenario file");
    [flight.trace_csv(), flight.summary(), flight.flown(), toml]
}

/// Orders after the end were steps of the pilot, whose time no scenario file may have, and each further
/// call of `advance` flew one more round.
#[test]
fn orders_losses_and_calls_after_the_end_change_nothing() {
    let files = Dropped::new();
    for steers_before in [false, true] {
        let recipe = json!({ "scenario": "random-n15", "seed": 3, "set": ["duration_s=20"] });
        let mut flight = Flight::new(&recipe.to_string(), &files).unwrap();
        if steers_before {
            flight.advance(10_000_000);
            flight.steer("explore", 0.2, "").unwrap();
            flight.lose(2);
        }
        while flight.advance(1_000_000) {}
        let ended = all_of(&flight, &files);
        flight.steer("explore", 0.0, "").unwrap();
        flight.steer("land", 0.0, "").unwrap();
        flight.lose(1);
        assert!(!flight.advance(1_000_000), "the mission goes on after its end");
        assert_eq!(all_of(&flight, &files), ended);
    }
}

/// An order in the last round counts from its end on, which is the end of the mission.
#[test]
fn an_order_in_the_last_round_is_not_part_of_the_mission() {
    let files = Dropped::new();
    let recipe = json!({ "scenario": "random-n15", "set": ["duration_s=20"] });
    let mut flight = Flight::new(&recipe.to_string(), &files).unwrap();
    flight.advance(19_900_000);
    flight.steer("land", 0.0, "").unwrap();
    flight.lose(1);
    assert!(!flight.advance(20_000));
    same(&recipe, &flight.trace_csv(), &trace_here(&recipe, &files));
    assert!(flight.scenario_toml(&files).is_ok());
}

/// The command judges a mission between rounds, so that it flies the last one to its end.
#[test]
fn a_round_in_which_the_time_is_up_is_flown_whole() {
    let files = Dropped::new();
    let recipe = json!({ "scenario": "random-n15", "set": ["duration_s=19.9"] });
    let mut flight = Flight::new(&recipe.to_string(), &files).unwrap();
    let is_over = |flight: &Flight| flight.frame().parse::<Value>().unwrap()["over"] == true;
    while !is_over(&flight) {
        flight.advance(20_000);
    }
    assert!(!flight.advance(20_000));
    same(&recipe, &flight.trace_csv(), &trace_here(&recipe, &files));
}
