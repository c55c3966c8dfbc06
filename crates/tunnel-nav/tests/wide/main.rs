//! Drones in galleries that are wider than they see from the middle take the branch that the pilot has
//! chosen, without touching a wall, and come home the same way.

#[allow(dead_code, reason = "the test `corners` uses all of it")]
#[path = "../corners/flight.rs"]
mod flight;
#[allow(dead_code, reason = "the test `corners` uses all of it")]
#[path = "../corners/world.rs"]
mod world;

use std::collections::BTreeMap;

use flight::{Errors, Flight, Random};
use units::Branch;
use world::Tunnel;

/// The angles of the galleries that leave from a junction, in degrees, counter-clockwise; the first is
/// the one to which the choice leads.
const JUNCTIONS: [(&str, &[f32], Branch); 4] = [
    ("T", &[90.0, -90.0], Branch::Left),
    ("side", &[90.0, 0.0], Branch::Left),
    ("cross", &[90.0, 0.0, -90.0], Branch::Left),
    ("past", &[0.0, -90.0], Branch::Left),
];

/// Widths in m, of which the last is that of SubT's tunnel tiles.
const WIDTHS: [f32; 3] = [3.4, 4.4, 5.2];

/// The reach of the rangers, m: with the shorter one a drone sees no wall from the middle.
const REACHES: [f32; 2] = [1.8, 4.0];

fn tunnel((name, angles, _): (&str, &[f32], Branch), width: f32, side: f32) -> Tunnel {
    let straight = 6.0 + width;
    let tunnel = Tunnel::turning(name, width, straight, &[(side * angles[0]).to_radians()]);
    let others = angles.iter().skip(1);
    others.fold(tunnel, |tunnel, angle| tunnel.with_gallery(straight, side * angle, straight))
}

/// Flies out, and home again.
///
/// # Errors
/// What went wrong first.
fn fly(tunnel: &Tunnel, reach: f32, branch: Branch, seed: u64) -> Result<(), String> {
    let mut random = Random::new(seed);
    let errors = Errors::ordinary(&mut random);
    let speed = random.between(0.1, 0.4);
    let mut flight = Flight::new(tunnel, 0.3, errors, random).with_reach(reach);
    flight.choose(Some(branch));
    let end = tunnel.length();
    for (leg, speed) in [("out", speed), ("home", -0.2)] {
        let is_there = |way: f32| if speed > 0.0 { way > end - 0.9 } else { way < 0.7 };
        let mut rounds = 0;
        while !is_there(flight.way()) {
            flight.round(speed);
            flight.check(leg)?;
            rounds += 1;
            if rounds > 1_500 {
                return Err(format!("stands at {:.1} of {end:.1} m {leg}", flight.way()));
            }
        }
        if flight.off() > 0.5 * tunnel.width() {
            return Err(format!("is in another gallery on the way {leg}"));
        }
    }
    Ok(())
}

#[test]
fn in_a_wide_gallery_a_drone_takes_the_branch_that_was_chosen_and_comes_home() {
    let mut failed = BTreeMap::new();
    let (mut flown, mut count) = (0, 0);
    for junction in JUNCTIONS {
        for (width, reach) in WIDTHS.into_iter().flat_map(|w| REACHES.map(|reach| (w, reach))) {
            for seed in 0..20 {
                let (side, branch) =
                    if seed % 2 == 0 { (1.0, junction.2) } else { (-1.0, Branch::Right) };
                flown += 1;
                let tunnel = tunnel(junction, width, side);
                if let Err(why) = fly(&tunnel, reach, branch, 9_000 + seed) {
                    count += 1;
                    let key = format!("{}, {width} m, reach {reach} m", junction.0);
                    failed.entry(key).or_insert((0, why)).0 += 1;
                }
            }
        }
    }
    assert!(count * 50 <= flown, "{count} of {flown}: {failed:#?}");
}
