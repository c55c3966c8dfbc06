//! What a swarm does when positions are wrong, packets are lost and drones fail.

use proptest::prelude::*;
use swarms::{Failure, Flight, Mission, Phase, Place, Trouble, fly};
use units::Metres;
use virtual_forces::Config;

/// Two drones of 0.20 m touch below this distance of their centres, and a drone and a wall below
/// half of it.
const TOUCH: f32 = 0.20;

fn place() -> impl Strategy<Value = Place> {
    prop::sample::select(Place::ALL.to_vec())
}

fn phase() -> impl Strategy<Value = Phase> {
    prop::sample::select(Phase::ALL.to_vec())
}

/// Flies our rule.
fn flown(drones: u16, place: Place, trouble: Trouble, seed: u64) -> Flight {
    let mission = Mission { config: Config::OURS, drones, place, until: Phase::Crossing, trouble };
    fly(&mission, seed).expect("at most six drones")
}

fn nobody_touches(flight: &Flight) -> Result<(), TestCaseError> {
    for leg in &flight.legs {
        prop_assert!(leg.closest_drones.0 > TOUCH, "two drones touch: {leg:?}");
        prop_assert!(leg.closest_wall.0 > 0.5 * TOUCH, "a drone touches a wall: {leg:?}");
    }
    Ok(())
}

fn all_finish(flight: &Flight) -> Result<(), TestCaseError> {
    prop_assert_eq!(flight.legs.len(), Phase::ALL.len(), "stuck: {:?}", flight.legs);
    for leg in &flight.legs {
        prop_assert!(leg.rounds.is_some(), "stuck: {leg:?}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn with_noise_and_lost_packets_nobody_touches_and_all_finish(
        drones in 1_u16..=6,
        place in place(),
        noise in 0.01_f32..=0.10,
        loss in 0.0_f32..=0.30,
        seed in any::<u64>(),
    ) {
        let trouble = Trouble { noise: Metres(noise), loss, ..Trouble::NONE };
        let flight = flown(drones, place, trouble, seed);
        nobody_touches(&flight)?;
        all_finish(&flight)?;
    }

    #[test]
    fn when_a_drone_falls_the_rest_finish_and_nobody_touches(
        drones in 2_u16..=6,
        which in 0_u16..6,
        place in place(),
        phase in phase(),
        after in 0_u32..60,
        seed in any::<u64>(),
    ) {
        let failure = Some(Failure { drone: which % drones, phase, after, stands: 0 });
        let flight = flown(drones, place, Trouble { failure, ..Trouble::NONE }, seed);
        nobody_touches(&flight)?;
        all_finish(&flight)?;
    }

    #[test]
    fn a_drone_that_is_late_is_waited_for(
        drones in 2_u16..=6,
        which in 0_u16..6,
        place in place(),
        phase in phase(),
        after in 0_u32..60,
        stands in 1_u32..300,
        seed in any::<u64>(),
    ) {
        let failure = Some(Failure { drone: which % drones, phase, after, stands });
        let flight = flown(drones, place, Trouble { failure, ..Trouble::NONE }, seed);
        nobody_touches(&flight)?;
        all_finish(&flight)?;
    }

    #[test]
    fn with_everything_at_once_nobody_touches(
        drones in 2_u16..=6,
        which in 0_u16..6,
        place in place(),
        phase in phase(),
        after in 0_u32..60,
        noise in 0.01_f32..=0.10,
        seed in any::<u64>(),
    ) {
        let failure = Some(Failure { drone: which % drones, phase, after, stands: 0 });
        let trouble = Trouble { noise: Metres(noise), loss: 0.3, failure, ..Trouble::NONE };
        nobody_touches(&flown(drones, place, trouble, seed))?;
    }
}
