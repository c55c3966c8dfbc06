//! Regression: the verdict of explorers and swarms counts what they saw, and explorers come home while
//! their batteries carry them.
//!
//! `run` said *success, area surveyed* of a swarm with a part of its area unflown, and *success* of explorers
//! whatever they had explored; explorers came down metres from home on empty batteries.

use std::process::Command;
use std::sync::atomic::AtomicBool;

use sim_harness::measure::campaign::{Run, Verdicts, fly_until};
use sim_harness::measure::metrics::Reference;
use sim_harness::measure::verdict::Failure;
use sim_harness::scenario::{Loss, LossKind, PilotStep, Scenario};
use units::Order;

use crate::scenario_text;

/// Four rooms with doors of 1 m at a corridor, which two drones explore in 300 s, with batteries that carry
/// them for half of that.
const OFFICE: &str = r#"
title = "An office: four rooms at a corridor"
duration_s = 400.0
mission = "explore"

[tunnel]
width_m = 1.4
centre_line_m = [[-1.0, 0.0], [9.0, 0.0]]

[[tunnel.branch]]
name = "door 1"
width_m = 1.0
centre_line_m = [[2.0, 0.0], [2.0, 2.0]]

[[tunnel.branch]]
name = "door 2"
width_m = 1.0
centre_line_m = [[2.0, 0.0], [2.0, -2.0]]

[[tunnel.branch]]
name = "door 3"
width_m = 1.0
centre_line_m = [[7.0, 0.0], [7.0, 2.0]]

[[tunnel.branch]]
name = "door 4"
width_m = 1.0
centre_line_m = [[7.0, 0.0], [7.0, -2.0]]

[[tunnel.room]]
centre_m = [2.0, 2.5]
size_m = [4.0, 3.0]

[[tunnel.room]]
centre_m = [2.0, -2.5]
size_m = [4.0, 3.0]

[[tunnel.room]]
centre_m = [7.0, 2.5]
size_m = [4.0, 3.0]

[[tunnel.room]]
centre_m = [7.0, -2.5]
size_m = [4.0, 3.0]

[vehicle]
position_noise_m = 0.01
charge = 0.5

[drones]
relays = 1

[explore]
corner_m = [-2.0, -6.0]
area_m = [12.0, 12.0]

[[pilot]]
at_s = 1.0
order = "explore"
speed_mps = 0.2
"#;

fn office() -> Scenario {
    scenario_text::read("explorers-and-swarms/office", OFFICE)
}

fn fly(scenario: &Scenario, seed: u64) -> Run {
    let world = scenario.world();
    let reference = Reference::of(scenario, &world);
    let never = AtomicBool::new(false);
    fly_until(&never, scenario, &world, &reference, seed, 1, || ()).remove(0)
}

fn names(run: &Run) -> Vec<&'static str> {
    run.judgement.failures.iter().map(Failure::name).collect()
}

/// Half of the charge, from which the way home of both has to be kept.
#[test]
fn explorers_are_home_and_down_before_their_batteries_are_empty() {
    let run = fly(&office(), 3);
    let explore = run.metrics.explore.unwrap();
    assert_eq!(names(&run), ["battery"], "{:?}", run.judgement);
    assert_eq!(explore.unfinished, 0, "each has flown home by itself: {explore:?}");
    assert!((0.3..0.99).contains(&explore.explored), "{explore:?}");
    // A drone hovers for 168 s on half of its charge.
    assert!((100.0..168.0).contains(&explore.ended_s), "{explore:?}");
}

#[test]
fn explorers_whose_time_is_over_have_not_succeeded_and_a_scenario_may_ask_for_less() {
    let mut scenario = office();
    scenario.duration_us = 60_000_000;
    let run = fly(&scenario, 3);
    assert!(names(&run).contains(&"time-over"), "{:?}", run.judgement);
    scenario.criteria.explored = Some(0.1);
    let run = fly(&scenario, 3);
    assert_eq!(names(&run), ["unfinished"], "{:?}", run.judgement);
}

#[test]
fn the_rows_of_a_lost_drone_are_flown_over_by_the_others() {
    let mut scenario = Scenario::open("swarm-b").unwrap();
    scenario.losses = vec![Loss { at_us: 40_000_000, drone: 1, how: LossKind::Gone }];
    scenario.duration_us = 340_000_000;
    let run = fly(&scenario, 3);
    let swarm = run.metrics.swarm.unwrap();
    assert_eq!((swarm.lost, swarm.unfinished), (1, 0));
    assert!(swarm.covered > 0.99, "{swarm:?}");
}

#[test]
fn a_swarm_that_is_called_home_has_not_covered_its_area_and_stands_where_it_took_off() {
    let mut scenario = Scenario::open("swarm-c").unwrap();
    let whole = fly(&scenario, 3);
    assert!(whole.judgement.is_success(), "{:?}", whole.judgement);
    // From the passage, before the first has landed behind it.
    let gathered_s = whole.metrics.swarm.unwrap().gathered_s;
    let at_us = (gathered_s * 1e6) as u64 + 10_000_000;
    let recall = PilotStep { at_us, task: Order::Return };
    scenario.pilot.push(recall);
    scenario.duration_us = 320_000_000;
    let run = fly(&scenario, 3);
    assert!(run.judgement.is_success(), "{:?}", run.judgement);
    scenario.pilot.last_mut().unwrap().at_us = 60_000_000;
    let run = fly(&scenario, 3);
    assert_eq!(names(&run), ["uncovered"], "{:?}", run.judgement);
    let verdicts = Verdicts::of(&[run]);
    assert_eq!(
        (verdicts.failed(), &verdicts.json()["failures"]["uncovered"]["value"]),
        (1, &1.0.into())
    );
}

#[test]
fn a_swarm_covers_both_areas_and_lands_apart() {
    let run = fly(&Scenario::open("swarm-both").unwrap(), 3);
    assert!(run.judgement.is_success(), "{:?}", run.judgement);
    assert!(run.metrics.swarm.unwrap().covered > 0.99, "{:?}", run.metrics.swarm);
}

/// `plan explore` ended with status 0 and said nothing of 44 touches, which its JSON told.
#[test]
fn an_exploration_whose_robots_touch_walls_has_failed() {
    let args = ["plan", "explore", "--plan", "rooms", "--drift", "--seed", "4", "--quiet"];
    let output = Command::new(env!("CARGO_BIN_EXE_uchain")).args(args).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.lines().any(|line| line.ends_with("touches of a wall")), "no touches in {said}");
}
