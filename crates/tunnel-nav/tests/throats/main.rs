//! A drone that flies home out of a chamber through a narrow gallery gets on, whichever distances its
//! beams read before the corners of the throat.

#[allow(dead_code, reason = "the test `corners` uses all of it")]
#[path = "../corners/flight.rs"]
mod flight;
#[allow(dead_code, reason = "the test `corners` uses all of it")]
#[path = "../corners/world.rs"]
mod world;

use flight::{Errors, Flight, Random};
use world::Tunnel;

/// Flies into the chamber or through it, and home again.
///
/// # Errors
/// What went wrong first.
fn fly(seed: u64) -> Result<(), String> {
    let mut random = Random::new(seed);
    let width = random.between(0.6, 1.2);
    let room = random.between(1.4, 3.0);
    let off = random.between(-0.5, 0.5) * (room - width);
    let name = format!("chamber {room:.2} m, {off:.2} m off");
    let bend = random.between(-0.8, 0.8);
    let tunnel = Tunnel::turning(&name, width, 7.0, &[bend]).with_chamber([3.0, 5.5], room, off);
    let errors = Errors::ordinary(&mut random);
    let speed = random.between(0.1, 0.3);
    let turns = if random.uniform() < 0.5 { 4.3 } else { 9.0 };
    let mut flight = Flight::new(&tunnel, 0.3, errors, random);
    for (leg, speed) in [("out", speed), ("home", -0.2)] {
        let is_there = |way: f32| if speed > 0.0 { way > turns } else { way < 0.7 };
        let mut rounds = 0;
        while !is_there(flight.way()) {
            flight.round(speed);
            rounds += 1;
            if rounds > 900 {
                return Err(format!(
                    "{seed}: {name}, {width:.2} m, bend {bend:.2}: stands at {:.2} m {leg}, {}",
                    flight.way(),
                    flight.beams(),
                ));
            }
        }
        flight.check(leg).map_err(|what| format!("{seed}: {name}, {width:.2} m: {what}"))?;
    }
    Ok(())
}

/// Drones that stood before the wall beside the throat for ever: both rear beams at the danger distance,
/// where they give neither speed nor push.
#[test]
fn a_drone_that_stands_beside_the_throat_finds_it() {
    for seed in [280, 435] {
        assert_eq!(fly(seed), Ok(()));
    }
}

/// By chambers of 1.4 to 3 m and galleries from 0.6 m on, with `SEEDS` of them. Of 1,000, 9 stand:
/// 4 on the way home and 5 on the way out.
#[test]
fn drones_get_home_through_throats() {
    let seeds = std::env::var("SEEDS").ok().and_then(|n| n.parse().ok()).unwrap_or(1_000);
    let failed: Vec<_> = (1..=seeds).filter_map(|seed| fly(seed).err()).collect();
    let stand = failed.iter().filter(|what| what.contains("stands")).count();
    println!("{} failed of {seeds}, {stand} stand\n{}", failed.len(), failed.join("\n"));
    assert!(stand * 1_000 <= 9 * seeds as usize, "{stand} of {seeds} drones stand");
}
