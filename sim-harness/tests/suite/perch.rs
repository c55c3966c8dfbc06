//! Drones whose antennas lose 10 dB on the ground: a chain that takes off from there, and one that
//! relays from there (the built-in scenario `perch`, with points for bodies).

use agent::State;
use sim_harness::mission::Mission;
use sim_harness::scenario::{Fidelity, Scenario};
use units::Order;

/// The scenario, with its order to perch and a last order at these times.
fn perch(perch_s: u64, (last, last_s): (Order, u64)) -> Scenario {
    let mut scenario = Scenario::open("perch").unwrap().at(Fidelity::Point);
    scenario.pilot[1].at_us = perch_s * 1_000_000;
    scenario.pilot[2].at_us = last_s * 1_000_000;
    scenario.pilot[2].task = last;
    scenario
}

/// The states after each second, and how far from the base the head is, m.
fn seconds(scenario: &Scenario, until_s: u64) -> Vec<(Vec<State>, f32)> {
    seconds_of(scenario, until_s, 1)
}

/// The same with this seed.
fn seconds_of(scenario: &Scenario, until_s: u64, seed: u64) -> Vec<(Vec<State>, f32)> {
    let world = scenario.world();
    let mut mission = Mission::new(scenario, &world, seed);
    let second = |_| {
        (0..5).for_each(|_| mission.round());
        (mission.states().collect(), mission.ways().next().unwrap())
    };
    (0..until_s).map(second).collect()
}

fn count(states: &[State], name: &str) -> usize {
    states.iter().filter(|state| state.name() == name).count()
}

/// The filters of the links took the 10 dB that an antenna gains when it leaves the ground for a
/// steep fall over a short way; the head then hovered at 4 m for a minute.
#[test]
fn a_head_that_leaves_the_ground_flies_on() {
    let seconds = seconds(&perch(500, (Order::Land, 600)), 30);
    assert!(seconds[20].1 > 6.0, "{} m after 20 s", seconds[20].1);
}

#[test]
fn a_chain_relays_from_the_ground_until_it_is_called_up() {
    let up = Order::explore(units::MetresPerSecond::ZERO);
    let seconds = seconds(&perch(120, (up, 300)), 330);
    // A relay that is taking off when the order comes belongs to the chain.
    let on_the_ground = ["idle", "armed"].map(|name| count(&seconds[119].0, name));
    let in_chain = seconds[119].0.len() - on_the_ground.iter().sum::<usize>();
    assert!(in_chain > 2);
    // The two relays come to spots with a bend between them, do not wait for each other, and have
    // landed after 10 s.
    for (states, _) in &seconds[140..299] {
        assert_eq!(count(states, "perched"), in_chain, "all that flew relay from the ground");
    }
    let (states, at) = &seconds[329];
    let flies = |state: &State| matches!(state, State::OnMission(_));
    assert!(states[..in_chain].iter().all(flies), "{states:?}");
    assert!((at - seconds[200].1).abs() < 1.0, "the head is where it was");
}

#[test]
fn a_chain_on_the_ground_comes_home_when_it_is_called() {
    let seconds = seconds(&perch(60, (Order::Return, 120)), 330);
    assert!(count(&seconds[119].0, "perched") > 1);
    let (states, at) = &seconds[329];
    let down = count(states, "landed") + count(states, "idle");
    assert_eq!(down, states.len(), "{states:?}");
    assert!(*at < 4.0, "the head is home: {at} m");
}

/// In `perch-40m` all that fly land, also where only five of the six relays do and no link has much to
/// spare. A search takes 45 s at most before the drone goes to the best place that it has seen.
#[test]
fn a_chain_lands_with_few_decibels_to_spare() {
    let mut scenario = Scenario::open("perch-40m").unwrap().at(Fidelity::Point);
    for (relays, seed) in [(5, 100_001), (5, 100_002), (6, 100_001), (6, 100_003)] {
        scenario.drones.relays = relays;
        let (states, _) = seconds_of(&scenario, 370, seed).pop().unwrap();
        assert_eq!(count(&states, "perched"), relays + 1, "{relays} {seed} {states:?}");
    }
}
