//! Drones that a scenario places in the air come home to a row, as those do that took off from one. Their
//! odometers counted from the base and not from their places in the row, so that each took the others for
//! farther behind than they stood: of the four drones of `cut` two landed on or beside each other and one
//! beside the base.

use std::sync::atomic::AtomicBool;

use sim_harness::measure::campaign::fly_until;
use sim_harness::measure::metrics::Reference;
use sim_harness::scenario::Scenario;

#[test]
fn drones_that_are_placed_in_the_air_land_apart() {
    let scenario = Scenario::open("cut").expect("the scenario is built in");
    let world = scenario.world();
    let reference = Reference::of(&scenario, &world);
    let runs = fly_until(&AtomicBool::new(false), &scenario, &world, &reference, 1, 4, || ());
    assert_eq!(runs.len(), 4);
    for run in runs {
        let failures = run.judgement.failures;
        assert!(failures.is_empty(), "seed {}: {failures:?}", run.seed);
    }
}
