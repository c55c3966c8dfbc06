//! Drones that a scenario places in the air come home to a row, as those do that took off from one. Their
//! odometers counted from the base and not from their places in the row, so that each took the others for
//! farther behind than they stood: of the four drones of `cut` two landed on or beside each other and one
//! beside the base.

use sim_harness::measure::metrics::{Reference, Watch};
use sim_harness::mission::Mission;
use sim_harness::scenario::Scenario;

#[test]
fn drones_that_are_placed_in_the_air_land_apart() {
    let scenario = Scenario::open("cut").expect("the scenario is built in");
    let world = scenario.world();
    let reference = Reference::of(&scenario, &world);
    for seed in 1..=4 {
        let mut mission = Mission::new(&scenario, &world, seed);
        let mut watch = Watch::new(&scenario, &world, &reference);
        while !mission.is_over() {
            mission.round();
            watch.look(&mission);
        }
        let metrics = watch.verdict(&mission);
        let failures = watch.judgement(&mission, &metrics).failures;
        assert!(failures.is_empty(), "seed {seed}: {failures:?}");
    }
}
