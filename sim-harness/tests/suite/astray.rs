//! Regression: a relay in a wrong branch comes back to the junction, and does not fly into it again.
//!
//! The relay of `fork-astray` begins in the air, and its odometer showed nothing there. It took that place
//! for the one where it had taken off, behind which no junction lies, and turned round 1.5 m before the
//! junction: in none of 120 missions it found the right branch.

use sim_harness::mission::Mission;
use sim_harness::scenario::Scenario;
use world::SkeletonPlace;

#[test]
fn a_relay_placed_in_a_wrong_branch_comes_back_and_stays_out_of_it() {
    let scenario = Scenario::open("fork-astray").unwrap();
    let world = scenario.world();
    let wrong = world.skeleton().edge_named("right").unwrap();
    // With seed 27 the relay took the wrong branch again, and flew back to the same place again and again.
    for seed in (3_700_000..3_700_006).chain([27]) {
        let mut mission = Mission::new(&scenario, &world, seed);
        while !mission.is_over() {
            mission.round();
        }
        let places: Vec<SkeletonPlace> = mission.places().collect();
        // The gallery is 1.4 m wide: up to 1 m in, the relay is in the junction.
        let is_out = places[1].edge != wrong || places[1].along < 1.0;
        assert!(is_out, "seed {seed}: {places:?}");
    }
}
