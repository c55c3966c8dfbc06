//! Drones at junctions take the branch that the pilot has chosen, without touching a wall, and come
//! home the same way.

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

/// The galleries that leave from a junction, by their angles to the gallery that leads there, in
/// degrees, counter-clockwise; the choice; and the angle of the gallery that it leads to.
struct Junction {
    name: &'static str,
    galleries: &'static [f32],
    branch: Branch,
    way: f32,
}

/// All junctions with a choice to the left, or straight on; the others are their mirror images.
const JUNCTIONS: [Junction; 12] = [
    Junction { name: "T", galleries: &[90.0, -90.0], branch: Branch::Left, way: 90.0 },
    Junction { name: "Y", galleries: &[37.0, -37.0], branch: Branch::Left, way: 37.0 },
    Junction { name: "wide Y", galleries: &[60.0, -60.0], branch: Branch::Left, way: 60.0 },
    Junction { name: "side at 90", galleries: &[90.0, 0.0], branch: Branch::Left, way: 90.0 },
    Junction { name: "side at 60", galleries: &[60.0, 0.0], branch: Branch::Left, way: 60.0 },
    Junction { name: "side at 45", galleries: &[45.0, 0.0], branch: Branch::Left, way: 45.0 },
    Junction { name: "cross", galleries: &[90.0, 0.0, -90.0], branch: Branch::Left, way: 90.0 },
    Junction { name: "past 90", galleries: &[-90.0, 0.0], branch: Branch::Left, way: 0.0 },
    Junction { name: "past 60", galleries: &[-60.0, 0.0], branch: Branch::Left, way: 0.0 },
    Junction { name: "on at 90", galleries: &[90.0, 0.0], branch: Branch::Straight, way: 0.0 },
    Junction { name: "on at 60", galleries: &[60.0, 0.0], branch: Branch::Straight, way: 0.0 },
    Junction {
        name: "cross on",
        galleries: &[90.0, 0.0, -90.0],
        branch: Branch::Straight,
        way: 0.0,
    },
];

const WIDTHS: [f32; 5] = [0.8, 1.0, 1.2, 1.6, 2.2];

impl Junction {
    fn tunnel(&self, width: f32, side: f32) -> Tunnel {
        let straight = 3.0 + width;
        let way = (side * self.way).to_radians();
        let tunnel = Tunnel::turning(self.name, width, straight, &[way]);
        let others = self.galleries.iter().filter(|angle| **angle != self.way);
        others.fold(tunnel, |tunnel, angle| tunnel.with_gallery(straight, side * angle, straight))
    }

    fn branch(&self, side: f32) -> Branch {
        match self.branch {
            Branch::Left if side < 0.0 => Branch::Right,
            branch => branch,
        }
    }
}

/// Flies out, and home again.
///
/// # Errors
/// What went wrong first.
fn fly(tunnel: &Tunnel, branch: Branch, seed: u64) -> Result<(), String> {
    let mut random = Random::new(seed);
    let errors = Errors::ordinary(&mut random);
    let speed = random.between(0.1, 0.4);
    let mut flight = Flight::new(tunnel, 0.3, errors, random);
    flight.choose(Some(branch));
    let end = tunnel.length();
    for (leg, speed) in [("out", speed), ("home", -0.2)] {
        let is_there = |way: f32| if speed > 0.0 { way > end - 0.9 } else { way < 0.7 };
        let mut rounds = 0;
        while !is_there(flight.way()) {
            flight.round(speed);
            flight.check(leg)?;
            rounds += 1;
            if rounds > 900 {
                return Err(format!(
                    "stands at {:.1} of {end:.1} m on the way {leg}",
                    flight.way()
                ));
            }
        }
        if flight.off() > 0.7 * tunnel.width() {
            return Err(format!("is in another gallery on the way {leg}"));
        }
    }
    Ok(())
}

#[test]
fn a_drone_takes_the_branch_that_was_chosen_and_comes_home() {
    let mut failed = BTreeMap::new();
    let (mut flown, mut count) = (0, 0);
    for junction in &JUNCTIONS {
        for width in WIDTHS {
            for seed in 0..40 {
                let side = if seed % 2 == 0 { 1.0 } else { -1.0 };
                let tunnel = junction.tunnel(width, side);
                flown += 1;
                if let Err(why) = fly(&tunnel, junction.branch(side), 7_000 + seed) {
                    count += 1;
                    let key = format!("{}, {width} m", junction.name);
                    let entry = failed.entry(key).or_insert((0, why.clone()));
                    entry.0 += 1;
                }
            }
        }
    }
    assert!(count * 50 <= flown, "{count} of {flown}: {failed:#?}");
}
