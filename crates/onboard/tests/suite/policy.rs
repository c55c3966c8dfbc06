//! A client chooses the movement policy of a drone on the ground, by its code.

use agent::Fitness;
use chain::policy::{Policy, PolicyConfig, REGISTRY};
use crtp::{ParameterId, Parameters};
use onboard::{Config, Drone, Sensed, Setup, Start};
use units::{Instant, Metres, NodeId, PolicyCode, Role};

use crate::common::{Clear, packets};

const NOW: Instant = Instant::from_micros(1_000_000);

fn drone(start: Start) -> Drone<Clear> {
    Drone::new(Config::DEFAULT, &Setup { start, ..Setup::new(NodeId(1), Role::Relay) })
}

fn code(name: &str) -> PolicyCode {
    Policy::named(name).unwrap().code
}

/// What a client reads after it has set the policy to `code`.
fn set(drone: &mut Drone<Clear>, code: u8) -> Option<PolicyCode> {
    drone.client(NOW, &packets::set(ParameterId::POLICY, &[code]));
    drone.parameters().policy
}

#[test]
fn the_parameter_shows_the_policy_that_is_flown() {
    for policy in &REGISTRY {
        let mut config = Config::DEFAULT;
        config.agent.policy = policy.config;
        let drone = Drone::<Clear>::new(config, &Setup::new(NodeId(1), Role::Relay));
        assert_eq!(drone.parameters().policy, Some(policy.code), "{}", policy.name);
    }
    let mut config = Config::DEFAULT;
    config.agent.policy.max_speed.0 *= 0.5;
    let drone = Drone::<Clear>::new(config, &Setup::new(NodeId(1), Role::Relay));
    assert_eq!(drone.parameters().policy, None, "a policy of one's own has no code");
}

#[test]
fn a_drone_on_the_ground_flies_and_stores_the_policy_that_a_client_sets() {
    let mut drone = drone(Start::OnGround);
    assert_eq!(set(&mut drone, code("t5").get()), Some(code("t5")));
    assert_eq!(drone.config().agent.policy, PolicyConfig::T5);
    assert_eq!(drone.take_unsaved().policy, Some(code("t5")));
    assert_eq!(drone.take_unsaved().policy, None, "it is stored once");
}

#[test]
fn a_code_without_a_policy_is_refused() {
    let mut drone = drone(Start::OnGround);
    for unknown in [0, 99, u8::MAX] {
        assert_eq!(set(&mut drone, unknown), Some(code("chain")), "{unknown}");
    }
    assert_eq!(drone.config().agent.policy, PolicyConfig::CHAIN);
    assert_eq!(drone.take_unsaved().policy, None);
}

#[test]
fn a_drone_in_the_air_keeps_its_policy() {
    let mut drone = drone(Start::InAir { at: NOW, flown: Metres::ZERO });
    drone.step(NOW, &Sensed { fitness: Fitness::Fit, ..Sensed::NONE });
    assert_eq!(set(&mut drone, code("t0").get()), Some(code("chain")));
    assert_eq!(drone.config().agent.policy, PolicyConfig::CHAIN);
    assert_eq!(drone.take_unsaved().policy, None);
}

/// The table of the book names every policy by its code.
#[test]
fn the_parameters_description_lists_the_registry() {
    let row = crtp::parameters().find(|row| row.name == "policy").unwrap();
    for policy in &REGISTRY {
        let listed = format!("{} {}", policy.code.get(), policy.name);
        assert!(row.meaning.contains(&listed), "{listed} is missing: {}", row.meaning);
    }
    assert_eq!(Parameters::DEFAULT.policy, None, "the drone fills it in");
}
