//! Halls with an exit that is not opposite the entrance: a drone that keeps to the chosen wall finds the
//! exit on that side, and home again, without touching a wall.

#[allow(dead_code, reason = "the test `corners` uses all of it")]
#[path = "../corners/flight.rs"]
mod flight;
#[allow(dead_code, reason = "the test `corners` uses all of it")]
#[path = "../corners/world.rs"]
mod world;

use flight::{Errors, Flight, Random};
use units::Branch;
use world::{Tunnel, Vec2};

/// The halls that are flown through, and how many of them may fail. Before drones turned along a wall to
/// which they come aslant it were 25, then 11; since only near obstacles move them off their path, 8.
const HALLS: u64 = 200;
const MAY_FAIL: usize = 9;

/// A gallery that leads to the end of its first leg, into a hall, and on from there.
struct Hall {
    tunnel: Tunnel,
    branch: Branch,
    /// The longest way along the walls, m.
    longest: f32,
    what: String,
}

/// Draws a hall of 4 to 9 m a side and its exit: opposite, beside the entrance, at a corner, or on the
/// side.
fn draw(random: &mut Random) -> Hall {
    let width = random.between(1.0, 1.8);
    let (long, wide) = (random.between(4.0, 9.0), random.between(4.0, 9.0));
    let (margin, begins) = (0.5 * width + 0.1, random.between(5.0, 8.0));
    let ends = begins + long;
    let right = -random.between(margin, wide - margin);
    let side = if random.uniform() < 0.5 { 1.0 } else { -1.0 };
    let beyond = 8.0;
    let kind = (4.0 * random.uniform()) as u32;
    let mut to_right = true;
    let line = match kind {
        0 => {
            to_right = random.uniform() < 0.5;
            let exit = random.between(right + margin, right + wide - margin);
            vec![[0.0, 0.0], [begins + 0.6, 0.0], [ends - 0.6, exit], [ends + beyond, exit]]
        }
        _ => {
            let exit = match kind {
                1 => begins + margin + random.uniform(),
                2 => ends - margin,
                _ => random.between(begins + margin, ends - margin),
            };
            let exit = exit.min(ends - margin);
            vec![[0.0, 0.0], [exit, 0.0], [exit, right - beyond]]
        }
    };
    let mirrored = |[x, y]: Vec2| [x, side * y];
    let legs: Vec<_> = line.windows(2).map(|w| (mirrored(w[0]), mirrored(w[1]), width)).collect();
    let room = [[begins, right], [ends, right + wide]].map(mirrored);
    let is_right = to_right == (side > 0.0);
    Hall {
        tunnel: Tunnel::of_legs(&legs).with_room(room),
        branch: if is_right { Branch::Right } else { Branch::Left },
        longest: begins + 2.0 * (long + wide) + beyond,
        what: format!("{long:.1} x {wide:.1} m, gallery {width:.1} m, kind {kind}, {line:.1?}"),
    }
}

/// Flies out, and home again.
///
/// # Errors
/// What went wrong first.
fn fly(seed: u64) -> Result<(), String> {
    let mut random = Random::new(seed);
    let hall = draw(&mut random);
    let errors = Errors::ordinary(&mut random);
    let speed = random.between(0.15, 0.4);
    let mut flight = Flight::new(&hall.tunnel, 0.3, errors, random);
    flight.choose(Some(hall.branch));
    let end = hall.tunnel.length();
    for (leg, speed) in [("out", speed), ("home", -0.2)] {
        let is_there = |flight: &Flight<'_>| {
            let way = flight.way();
            flight.off() < 0.6 * hall.tunnel.width()
                && if speed > 0.0 { way > end - 2.0 } else { way < 1.0 }
        };
        let most = (hall.longest / speed.abs() * 5.0 * 2.0) as u32 + 200;
        let mut rounds = 0;
        while !is_there(&flight) {
            flight.round(speed);
            if flight.touches() {
                return Err(format!("touches {leg} at {:.1?}, {}", flight.at(), hall.what));
            }
            rounds += 1;
            if rounds > most {
                return Err(format!("is at {:.1?} {leg}, {}", flight.at(), hall.what));
            }
        }
    }
    Ok(())
}

#[test]
fn a_drone_finds_the_exit_along_the_chosen_wall_and_home() {
    let failed: Vec<_> = (60_000..60_000 + HALLS)
        .filter_map(|seed| fly(seed).err().map(|why| (seed, why)))
        .collect();
    assert!(failed.len() <= MAY_FAIL, "{} of {HALLS}: {failed:#?}", failed.len());
}
