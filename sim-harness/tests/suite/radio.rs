//! The radio link in a mission: orders reach the head in time, telemetry reaches the base, and a
//! mission is the same in however small steps it is flown.

use std::path::Path;
use world::World;

use agent::State;
use random::{Purpose, Stream};
use sim_harness::bodies::craft::faults::{Failing, Fault};
use sim_harness::mission::Mission;
use sim_harness::mission::trace::Frame;
use sim_harness::scenario::{Fidelity, Scenario};
use units::{MetresPerSecond, Order};

fn short() -> Scenario {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenarios/short.toml");
    Scenario::read(&file).unwrap_or_else(|error| panic!("{error}"))
}

/// The same, cut off.
fn first(seconds: u64, scenario: &Scenario) -> Scenario {
    Scenario { duration_us: seconds * 1_000_000, ..scenario.clone() }
}

/// What is every 0.2 s of a mission that is flown in steps of so many microseconds.
fn in_steps(scenario: &Scenario, world: &World, step_us: u64) -> Vec<Frame> {
    let mut mission = Mission::new(scenario, world, 5);
    let mut frames = Vec::new();
    while !mission.is_over() {
        let to_round = 200_000 - mission.time_us() % 200_000;
        mission.advance(step_us.min(to_round));
        if mission.time_us().is_multiple_of(200_000) {
            frames.push(mission.frame());
        }
    }
    frames
}

#[test]
fn a_mission_is_the_same_in_however_small_steps() {
    for (fidelity, seconds) in [(Fidelity::Point, 20), (Fidelity::Flight, 6)] {
        let scenario = first(seconds, &short().at(fidelity));
        let world = scenario.world();
        let mut rounds = Mission::new(&scenario, &world, 5);
        let mut frames = Vec::new();
        while !rounds.is_over() {
            rounds.round();
            frames.push(rounds.frame());
        }
        for step_us in [10_000, 3_777, 200_000] {
            // Written out, as what was not measured is equal to nothing.
            let same =
                format!("{:?}", in_steps(&scenario, &world, step_us)) == format!("{frames:?}");
            assert!(same, "{fidelity:?} in steps of {step_us} us");
        }
    }
}

/// Through three hops at most and one packet in five lost: within half a second, nineteen times
/// in twenty.
#[test]
fn the_pilots_word_reaches_the_head_in_time() {
    for (name, fidelity) in [("demo", Fidelity::Point), ("relay-pair", Fidelity::Flight)] {
        let scenario = Scenario::open(name).unwrap().at(fidelity);
        let scenario = first(if fidelity == Fidelity::Point { 240 } else { 10 }, &scenario);
        let world = scenario.world();
        let mut mission = Mission::new(&scenario, &world, 1);
        while !mission.is_over() {
            mission.round();
        }
        let radio = mission.radio();
        println!("{name}: {radio:?}");
        assert_eq!(radio.sealed, fidelity == Fidelity::Flight);
        assert!(radio.pilot_delay_p50_s < 0.2, "{radio:?}");
        assert!(radio.pilot_delay_p95_s < 0.5, "{radio:?}");
        assert!(radio.air_time < 0.1, "{radio:?}");
        // The order is sealed five times a second.
        let most = 5.0 * scenario.duration_s();
        assert!((0.8 * most - 10.0..=most + 2.0).contains(&(radio.orders as f32)), "{radio:?}");
    }
}

#[test]
fn the_base_hears_how_everybody_is() {
    let scenario = short();
    let world = scenario.world();
    let mut mission = Mission::new(&scenario, &world, 2);
    (0..25).for_each(|_| mission.round());
    let base = mission.count() - 1;
    for member in 0..base {
        let told = mission.told(member).unwrap_or_else(|| panic!("nothing of {member}"));
        assert!(mission.time_us() - told.at_us < 3_000_000, "{told:?}");
        let state = mission.states().nth(member).unwrap();
        assert!(told.telemetry.state <= state.code().max(3), "{told:?}");
    }
    assert_eq!(mission.told(base), None);
    assert!(mission.view(base + 1).is_none());
}

#[test]
fn a_live_mission_flies_as_it_is_told() {
    let scenario = Scenario::open("demo").unwrap();
    let world = scenario.world();
    let mut mission = Mission::live(&scenario, &world, 1);
    let during = |mission: &mut Mission<'_>, seconds: u64, task| {
        for _ in 0..100 * seconds {
            mission.order(task);
            mission.advance(10_000);
        }
    };
    // The scenario's own pilot has no say.
    (0..50).for_each(|_| mission.round());
    assert!(mission.states().all(|state| state == State::Idle));
    during(&mut mission, 30, Order::explore(MetresPerSecond(0.2)));
    let head = |mission: &Mission<'_>| mission.ways().next().unwrap();
    let out = head(&mission);
    assert!(out > 4.0, "the head came to {out} m only");
    assert!(mission.radio().orders > 0);
    during(&mut mission, 40, Order::Return);
    assert_eq!(mission.states().next().unwrap().name(), "landed");
}

#[test]
fn a_silenced_drone_neither_hears_nor_is_heard() {
    let scenario = Scenario::open("relay-pair").unwrap();
    let scenario = first(9, &scenario.at(Fidelity::Flight));
    let world = scenario.world();
    let mut mission = Mission::new(&scenario, &world, 1);
    let silence = Failing { fault: Fault::RadioSilence, from_ms: 3_000, until_ms: u64::MAX };
    mission.sabotage(1, silence, &mut Stream::new(1, Purpose::Fault(1)));
    (0..14).for_each(|_| mission.round());
    let before = mission.told(1).expect("it was heard before");
    assert!(before.at_us < 3_000_000);
    (0..30).for_each(|_| mission.round());
    assert!(mission.told(1).unwrap().at_us < 3_100_000, "nothing of it after");
    let relay = mission.view(1).unwrap();
    let status = relay.outputs.unwrap().status;
    assert_eq!((status.front, status.back), (None, None), "and it hears nobody");
}
