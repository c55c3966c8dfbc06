//! Missions beside an attacker who holds packets back, or repeats them elsewhere at once.

use sim_harness::medium::{Jams, Repeater};
use sim_harness::mission::Mission;
use sim_harness::scenario::{Changes, Scenario};
use units::Metres;
use world::SkeletonPlace;

/// The strength of a packet that was held back is not the sender's. The last one that was counted on and
/// on, so that the head flew on with a link of a place that it had left, and hovered at home for a
/// strength until its battery was empty.
#[test]
fn a_chain_whose_packets_are_held_back_stands_and_comes_home() {
    let changes = Changes { relays: Some(1), ..Changes::default() };
    let mut scenario = Scenario::open_with("demo", &changes).unwrap();
    // The pilot releases the stick, and calls the chain home.
    scenario.pilot[1].at_us = 60_000_000;
    scenario.pilot[2].at_us = 90_000_000;
    let world = scenario.world();
    let hold = Repeater { ear: 0, mouth: 1, delay_us: 1_000_450, jams: Jams::All };
    for seed in 1..=3 {
        let beside = [SkeletonPlace::main(7.0); 2];
        let mut mission = Mission::besieged(&scenario, &world, seed, &beside);
        let head = |mission: &Mission<'_>| mission.ways().next().unwrap();
        mission.advance(30_000_000);
        let begun = head(&mission);
        assert!(begun > 5.0, "seed {seed}: the head flies out, {begun} m");
        mission.repeat(&[hold]);
        mission.advance(4_000_000);
        let held = head(&mission);
        mission.advance(26_000_000);
        let stood = head(&mission);
        assert!((stood - held).abs() < 0.3, "seed {seed}: {held} m, {stood} m");
        mission.advance(180_000_000);
        for (state, way) in mission.states().zip(mission.ways()).take(2) {
            assert!(!state.is_airborne() && way < 3.0, "seed {seed}: {state:?} at {way} m");
        }
    }
}

/// A repeater makes a head that is far from the base as strong as a near one. What bounds the way is the length
/// of a link by the odometers of its ends: the default, or what the scenario says.
#[test]
fn a_head_beside_a_repeater_makes_no_link_longer_than_the_longest() {
    let changes = Changes { relays: Some(0), ..Changes::default() };
    let mut farthest = 0.0_f32;
    for (longest, seed) in [30.0, 9.0].into_iter().flat_map(|it| [1, 2, 3].map(|n| (it, n))) {
        let mut scenario = Scenario::open_with("demo", &changes).unwrap();
        scenario.agent.retreat.longest = Metres(longest);
        let world = scenario.world();
        let beside = [2.0, 2.0, 20.0, 20.0].map(SkeletonPlace::main);
        let mut mission = Mission::besieged(&scenario, &world, seed, &beside);
        let at_once = |ear, mouth| Repeater { ear, mouth, delay_us: 140, jams: Jams::Weaker };
        mission.repeat(&[at_once(0, 3), at_once(2, 1)]);
        // The pilot pushes on all the time.
        mission.advance(180_000_000);
        let way = mission.ways().next().unwrap();
        assert!(way < longest + 1.0, "seed {seed}: {way} m with links of {longest} m");
        // Without a repeater the head comes to 8.3 to 8.4 m.
        assert!(way > 9.0, "seed {seed}: {way} m");
        farthest = farthest.max(way);
    }
    // With seed 1 and links of 30 m the head comes to 16.1 m, with seeds 2 and 3 to 27.6 and 27.7 m.
    assert!(farthest > 25.0, "the repeater is not believed: {farthest} m");
}
