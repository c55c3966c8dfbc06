//! The way home: every drone comes back, from a gallery whose links fade and round a hairpin, and none lands
//! on another.

use world::World;

use sim_harness::mission::Mission;
use sim_harness::scenario::Scenario;
use units::{Metres, Point2};

use crate::scenario_text;

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
    let scenario = scenario_text::read("homing/fades", FADES);
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

/// The hairpin of the drawn place of seed 3100188 (`bench chain --drawn 1 --seed 3100188`): 6.8 m from the base
/// the gallery turns back by 139 degrees, and it ends 5.6 m behind that. The head hovers at the end for a
/// minute, and is then called home.
const HAIRPIN: &str = "\
title = \"Home round a hairpin\"
duration_s = 340.0
[tunnel]
widths_m = [1.05, 1.05, 1.05, 1.63, 1.63]
centre_line_m = [[0.0, 0.0], [4.44, -5.1], [4.42, -2.33], [4.42, -1.78], [4.41, 0.51]]
[radio]
attenuation = \"rock-depth\"
loss_at_1m_db = 38.5
noise_variance_db2 = 12.4
packet_loss = 0.15
gain_error_db = 1.6
sensitivity_dbm = -85.0
[vehicle]
flow_noise_mps = 0.018
flow_scale_error = 0.013
[drones]
relays = 11
[launch]
limit_dbm = -58.0
[retreat]
limit_dbm = -66.5
[[pilot]]
at_s = 2.0
order = \"explore\"
speed_mps = 0.35
[[pilot]]
at_s = 15.6
order = \"explore\"
speed_mps = 0.0
[[pilot]]
at_s = 25.3
order = \"explore\"
speed_mps = 0.35
[[pilot]]
at_s = 38.9
order = \"explore\"
speed_mps = 0.0
[[pilot]]
at_s = 48.6
order = \"explore\"
speed_mps = 0.35
[[pilot]]
at_s = 62.2
order = \"explore\"
speed_mps = 0.0
[[pilot]]
at_s = 71.9
order = \"explore\"
speed_mps = 0.35
[[pilot]]
at_s = 75.4
order = \"explore\"
speed_mps = 0.0
[[pilot]]
at_s = 135.4
order = \"return\"
";

/// The head looked round in the hairpin, forgot its path, flew back to the end of the gallery and was there
/// when the mission ended. When it keeps its path, it must look round more than once, and each round without
/// flight had begun the 25 s until then anew.
#[test]
fn a_head_that_is_stuck_in_a_hairpin_comes_home() {
    let scenario = scenario_text::read("homing/hairpin", HAIRPIN);
    let world = scenario.world();
    // The row of twelve drones ends at 2.8 m, the hairpin is at 4.4 m, and what is behind it too.
    for seed in [3_100_188, 1, 2, 3] {
        let places = ends_at(&scenario, &world, seed);
        assert!(places.iter().all(|at| at.x < 3.6), "seed {seed}: {places:?}");
    }
}
