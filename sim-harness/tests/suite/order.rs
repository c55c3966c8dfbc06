//! Regression: relays that start in a right angle keep the order of the chain.
//!
//! Such a drone has seen neither gallery alone, and flew on into the outer corner. There, askew before
//! the outer wall, it took the long rear beam on that side for an opening, turned towards the wall
//! and on, and came back nose first: towards the base, through its neighbours. Every seed here did.

use sim_harness::measure::metrics::{Reference, Watch};
use sim_harness::mission::Mission;
use sim_harness::scenario::Scenario;

/// Flies the first minute of a mission, in which each of these seeds had a touch or lost its order.
fn keeps_its_order(name: &str, seed: u64) {
    let mut scenario = Scenario::open(name).unwrap();
    scenario.duration_us = 65_000_000;
    let world = scenario.world();
    let reference = Reference::of(&scenario, &world);
    let mut mission = Mission::new(&scenario, &world, seed);
    let mut watch = Watch::new(&scenario, &world, &reference);
    while !mission.is_over() {
        mission.round();
        watch.look(&mission);
    }
    let metrics = watch.verdict(&mission);
    let touched = metrics.drone_contacts + metrics.wall_contacts;
    assert_eq!((metrics.order_lost, touched), (0, 0), "{name}, seed {seed}");
}

#[test]
fn a_relay_that_starts_in_a_right_angle_does_not_turn_round() {
    keeps_its_order("s-turns-5", 10_093);
    keeps_its_order("s-turns-5", 10_180);
    keeps_its_order("zigzag-5", 10_031);
    keeps_its_order("zigzag-5", 10_293);
    keeps_its_order("right-angles", 10_012);
    keeps_its_order("right-angles", 10_051);
}
