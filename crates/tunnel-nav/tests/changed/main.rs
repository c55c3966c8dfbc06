//! Regression: a changed choice of branch is heeded.
//!
//! A drone looks into a dead end that branches off, backs out, and is told to take the other branch.
//! It followed its own trail into the dead end again.

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

/// A junction with a dead end and a way on, by their angles to the gallery that leads there, in
/// degrees, counter-clockwise, and the choices that lead into them.
struct Junction {
    name: &'static str,
    dead_end: (f32, Branch),
    way_on: (f32, Branch),
}

use Branch::{Left, Right, Straight};

/// Junctions with the dead end on the left, or straight on; the others are their mirror images.
const JUNCTIONS: [Junction; 9] = [
    Junction { name: "T", dead_end: (90.0, Left), way_on: (-90.0, Right) },
    Junction { name: "Y of 60", dead_end: (30.0, Left), way_on: (-30.0, Right) },
    Junction { name: "Y of 90", dead_end: (45.0, Left), way_on: (-45.0, Right) },
    Junction { name: "Y of 120", dead_end: (60.0, Left), way_on: (-60.0, Right) },
    Junction { name: "past a side at 90", dead_end: (90.0, Left), way_on: (0.0, Right) },
    Junction {
        name: "straight past a side at 60",
        dead_end: (60.0, Left),
        way_on: (0.0, Straight),
    },
    Junction { name: "side at 90", dead_end: (0.0, Straight), way_on: (90.0, Left) },
    Junction { name: "side at 60", dead_end: (0.0, Right), way_on: (60.0, Left) },
    Junction { name: "side at 45", dead_end: (0.0, Straight), way_on: (45.0, Left) },
];

const WIDTHS: [f32; 4] = [1.0, 1.2, 1.6, 2.0];

const fn mirrored(branch: Branch, side: f32) -> Branch {
    match branch {
        Left if side < 0.0 => Right,
        Right if side < 0.0 => Left,
        branch => branch,
    }
}

impl Junction {
    /// The tunnel whose end is that of the way on, and the one whose end is the dead end.
    fn tunnels(&self, width: f32, side: f32, length: f32) -> [Tunnel; 2] {
        let straight = 4.0 + 2.0 * width;
        let end = length + 0.5 * width;
        let (dead, on) = (side * self.dead_end.0, side * self.way_on.0);
        let tunnel = |angle: f32, leg: f32| {
            Tunnel::with_legs(self.name, width, &[straight, leg], &[angle.to_radians()])
        };
        let on = tunnel(on, straight).with_gallery(straight, dead, end);
        let dead = on.with_centre_of(&tunnel(dead, length));
        [on, dead]
    }
}

/// How far a drone backs out of the dead end.
#[derive(Clone, Copy)]
enum Out {
    /// To before the junction.
    Before,
    /// To beside the branch that is chosen then, which one of its leading beams looks into.
    Beside,
}

/// Looks into the dead end, backs out, flies to the end of the way on, and home again.
///
/// # Errors
/// What went wrong first.
fn fly(junction: &Junction, width: f32, out: Out, seed: u64) -> Result<(), String> {
    let mut random = Random::new(seed);
    let side = if seed.is_multiple_of(2) { 1.0 } else { -1.0 };
    let [on, dead] = junction.tunnels(width, side, random.between(2.0, 6.0));
    let errors = Errors::ordinary(&mut random);
    let (speed, back) = (random.between(0.1, 0.4), random.between(0.1, 0.3));
    let turns_at = on.bends()[0];
    // A leading beam sees the junction from here on.
    let widest = junction.dead_end.0.abs().max(junction.way_on.0.abs()).to_radians();
    let opens = turns_at - 0.5 * width * (1.0 + libm::tanf(0.5 * widest));
    let out = match out {
        Out::Before => opens - random.between(1.2, 2.0),
        // Between where the beam that leads sees the corner and where the drone is abeam of it.
        Out::Beside => opens + random.between(0.2, 0.8) * 0.5 * width,
    };
    let mut flight = Flight::new(&dead, 0.3, errors, random);
    flight.choose(Some(mirrored(junction.dead_end.1, side)));
    let end = dead.length() - 0.8;
    flight.until(speed, "into the dead end", |flight| flight.way() > end)?;
    flight.until(-back, "out of it", |flight| flight.way() < out)?;
    flight.moves_to(&on);
    let branch = mirrored(junction.way_on.1, side);
    flight.changes_to(Some(branch));
    flight.until(speed, "on", |flight| flight.way() > on.length() - 0.9)?;
    flight.until(-back, "home", |flight| flight.way() < 0.7)
}

/// Flies at these junctions 20 times for each width.
///
/// # Panics
/// If more than one in `per` flights fails.
fn assert_heeded(junctions: &[&Junction], out: Out, per: u32) {
    let mut failed = BTreeMap::new();
    let (mut flown, mut count) = (0, 0);
    for junction in junctions {
        for width in WIDTHS {
            for seed in 0..20 {
                flown += 1;
                if let Err(why) = fly(junction, width, out, 11_000 + seed) {
                    count += 1;
                    let key = format!("{}, {width} m", junction.name);
                    failed.entry(key).or_insert((0, why)).0 += 1;
                }
            }
        }
    }
    assert!(count * per <= flown, "{count} of {flown}: {failed:#?}");
}

#[test]
fn a_drone_that_backs_out_of_a_dead_end_takes_the_branch_that_is_chosen_then() {
    assert_heeded(&JUNCTIONS.each_ref(), Out::Before, 50);
}

/// The wall before the branch has ended beside such a drone already, and will not end once more.
#[test]
fn a_drone_that_has_backed_out_to_beside_the_branch_turns_into_it() {
    let turns: Vec<_> = JUNCTIONS.iter().filter(|junction| junction.way_on.0 != 0.0).collect();
    assert_heeded(&turns, Out::Beside, 50);
}
