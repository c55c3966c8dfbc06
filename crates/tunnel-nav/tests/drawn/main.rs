//! Corridors that are drawn: how many does a drone fly through and home without touching a wall and without
//! turning round?
//!
//! One in twenty-five still fails; the bound is there so that it does not become more.

#[allow(dead_code, reason = "the test `corners` uses all of it")]
#[path = "../corners/flight.rs"]
mod flight;
#[allow(dead_code, reason = "the test `corners` uses all of it")]
#[path = "../corners/world.rs"]
mod world;

use flight::{Errors, Flight, Random};
use world::{Tunnel, Vec2, add, unit};

/// The corridors that are flown through, and how many of them may fail. Before a drone that sees one wall
/// alone flew round the corner where that wall ends it were 96, before it knew its whole way home and looked
/// round in sharp bends 19, since then 12.
const CORRIDORS: u64 = 300;
const MAY_FAIL: usize = 13;

/// A leg of a corridor: from where to where, and how wide.
#[derive(Clone, Copy, Debug)]
struct Leg {
    from: Vec2,
    to: Vec2,
    width: f32,
}

/// Draws three to seven legs of 3 to 25 m that turn by 20 to 150 degrees and are 0.8 to 3 m wide, with at
/// least half a metre of rock between any two that do not meet.
fn draw(random: &mut Random) -> Vec<Leg> {
    loop {
        let count = 3 + (5.0 * random.uniform()) as usize;
        let (mut at, mut angle) = ([0.0, 0.0], 0.0);
        let mut width = random.between(0.8, 3.0);
        let mut legs: Vec<Leg> = Vec::new();
        for _ in 0..count {
            // Short legs are as likely as long ones on a scale of logarithms, and longer than wide.
            let length = 3.0 * libm::powf(25.0 / 3.0, random.uniform()) + width;
            let to = add(at, unit(angle), length);
            legs.push(Leg { from: at, to, width });
            at = to;
            let side = if random.uniform() < 0.5 { 1.0 } else { -1.0 };
            angle += side * random.between(20.0, 150.0).to_radians();
            if random.uniform() < 0.5 {
                width = random.between(0.8, 3.0);
            }
        }
        let apart = |n: usize, m: usize| {
            let (a, b) = (legs[n], legs[m]);
            let least = 0.5 * (a.width + b.width) + 0.5;
            distance(a, b) > least
        };
        if (0..count).all(|n| (0..n.saturating_sub(1)).all(|m| apart(n, m))) {
            return legs;
        }
    }
}

/// The distance of two legs, by points along them.
fn distance(a: Leg, b: Leg) -> f32 {
    let points = |leg: Leg| {
        let d = [leg.to[0] - leg.from[0], leg.to[1] - leg.from[1]];
        (0..=40).map(move |n| add(leg.from, d, n as f32 / 40.0))
    };
    let near = |p: Vec2| points(b).map(move |q| libm::hypotf(p[0] - q[0], p[1] - q[1]));
    points(a).flat_map(near).fold(f32::INFINITY, f32::min)
}

/// Flies out, and home again.
///
/// # Errors
/// What went wrong first.
fn fly(seed: u64) -> Result<(), String> {
    let mut random = Random::new(seed);
    let legs = draw(&mut random);
    let tunnel =
        Tunnel::of_legs(&legs.iter().map(|leg| (leg.from, leg.to, leg.width)).collect::<Vec<_>>());
    let errors = Errors::ordinary(&mut random);
    let speed = random.between(0.1, 0.4);
    let mut flight = Flight::new(&tunnel, 0.3, errors, random);
    let end = tunnel.length();
    for (leg, speed) in [("out", speed), ("home", -0.2)] {
        let is_there = |way: f32| if speed > 0.0 { way > end - 0.9 } else { way < 0.7 };
        let most = (end / speed.abs() * 5.0 * 2.0) as u32 + 300;
        let mut rounds = 0;
        while !is_there(flight.way()) {
            flight.round(speed);
            flight
                .check_in_legs(3.0, leg)
                .map_err(|why| format!("{why} at {:.1} of {end:.1} m", flight.way()))?;
            rounds += 1;
            if rounds > most {
                return Err(format!("stands at {:.1} of {end:.1} m {leg}", flight.way()));
            }
        }
    }
    Ok(())
}

/// In a gallery wider than 2 m a drone sees one wall alone. Where that wall ended at the inside of a bend,
/// the drone did not note an opening, flew on to the far wall, turned to the longer beam, and flew back.
#[test]
fn a_drone_turns_where_the_only_wall_ends() {
    for seed in [50_007, 50_041, 50_087] {
        assert_eq!(fly(seed), Ok(()), "{seed}");
    }
}

/// Behind a bend from a wide gallery into a narrow one a drone kept the wide one's distance from the wall
/// that it followed, and was at the other wall.
#[test]
fn a_drone_keeps_the_middle_where_the_gallery_becomes_narrower() {
    assert_eq!(fly(50_063), Ok(()));
}

/// At a bend out of a gallery wider than the beams reach a drone turned to the wrong side, flew back beside
/// its own path, and never came to the end.
#[test]
fn a_drone_that_a_bend_turned_round_comes_back_and_turns_to_the_other_side() {
    for seed in [60_085, 60_178, 60_409] {
        assert_eq!(fly(seed), Ok(()), "{seed}");
    }
}

/// The path was kept for 25.6 m, and a drone that came home from farther away turned round in a bend.
#[test]
fn a_drone_comes_home_from_afar() {
    for seed in [60_038, 60_185, 60_561] {
        assert_eq!(fly(seed), Ok(()), "{seed}");
    }
}

/// In a bend of more than a right angle the way on lies behind the drone's shoulder.
#[test]
fn a_drone_that_stands_in_a_sharp_bend_looks_round_for_the_way_on() {
    assert_eq!(fly(60_113), Ok(()));
}

#[test]
fn a_drone_flies_through_drawn_corridors_and_home() {
    let failed: Vec<_> = (50_000..50_000 + CORRIDORS)
        .filter_map(|seed| fly(seed).err().map(|why| (seed, why)))
        .collect();
    assert!(failed.len() <= MAY_FAIL, "{} of {CORRIDORS}: {failed:#?}", failed.len());
}
