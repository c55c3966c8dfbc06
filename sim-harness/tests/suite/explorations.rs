//! Explorations with rigid bodies end, and touch nothing.
//!
//! None ended within 240 s while a ranger that sees no wall at a slant showed the cells behind it to be
//! free, and drones without fixes touched each other.

use sim_harness::measure::campaign;
use sim_harness::measure::metrics::Reference;
use sim_harness::scenario::{Fidelity, Scenario};

fn all_end(name: &str) {
    let scenario = Scenario::open(name).unwrap().at(Fidelity::Flight);
    let world = scenario.world();
    let reference = Reference::of(&scenario, &world);
    for (seed, run) in (1..).zip(campaign::fly(&scenario, &world, &reference, 1, 8, || ())) {
        let explore = run.explore.as_ref().unwrap();
        assert_eq!(explore.unfinished, 0, "{name}, seed {seed}: a drone still flies");
        assert!(explore.explored > 0.97, "{name}, seed {seed}: {} known", explore.explored);
        assert_eq!(run.wall_contacts, 0, "{name}, seed {seed}: a wall is touched");
        assert_eq!(run.drone_contacts, 0, "{name}, seed {seed}: two drones touch");
    }
}

#[test]
fn explorations_by_fixes_end_and_touch_nothing() {
    all_end("explore-room");
}

#[test]
fn explorations_by_flow_alone_end_and_touch_nothing() {
    all_end("explore-flow");
}
