//! Drones that rest, tremble and creep in bends: afterwards the nose still points along the tunnel,
//! no wall was touched, and the drone goes on to the end of the tunnel and home again.
//!
//! Until the trail had positions, a drone ended with its nose towards the base in 7 of 100 flights
//! into a right angle, by three causes: one missing range ended a wall, and a false one
//! was taken up; the nose turned freely between four equal beams; and the forward odometer parted
//! from the way along the tunnel, so that the headings of another place were held.

mod flight;
mod world;

use std::collections::BTreeMap;
use std::f32::consts::TAU;

use flight::{Errors, Flight, ROUND, Random};
use world::Tunnel;

/// What the drone does in the bend.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rest {
    /// It hovers: no speed is commanded, and it drifts with its optic flow.
    Still,
    /// Small speeds of changing sign are commanded, and it drifts.
    Tremble,
    /// It is held at a place by a closed loop with noise.
    Hold,
    /// It is led back and forth over 0.6 m by a closed loop.
    Creep,
    /// It flies to places within 1 m at full speed, with stops.
    Hop,
    /// It flies on at once.
    Leave,
}

const RESTS: [Rest; 6] =
    [Rest::Still, Rest::Tremble, Rest::Hold, Rest::Creep, Rest::Hop, Rest::Leave];

/// One flight into a bend, a rest of 3 min there, and a flight out of it.
#[derive(Clone, Copy, Debug)]
struct Trial {
    rest: Rest,
    /// Whether the drone has flown to the bend, or is set there without a trail.
    arrives: bool,
    seed: u64,
}

fn right_angles(width: f32) -> [Tunnel; 2] {
    let of = |name, turn: f32| Tunnel::turning(name, width, 3.0 + width, &[turn.to_radians()]);
    [of("left", 90.0), of("right", -90.0)]
}

fn other_tunnels(width: f32) -> [Tunnel; 8] {
    let of = |name, turns: &[f32]| {
        let turns: Vec<_> = turns.iter().map(|turn| turn.to_radians()).collect();
        Tunnel::turning(name, width, 3.0 + width, &turns)
    };
    [
        of("60 degrees", &[60.0]),
        of("120 degrees", &[120.0]),
        of("U", &[90.0, 90.0]),
        of("Z", &[90.0, -90.0]),
        Tunnel::rounded(width, 3.0 + width, 0.8 * width),
        of("dead end", &[]),
        of("", &[90.0]).with_branch("T and right angle", -90.0, 4.0),
        of("", &[90.0]).with_branch("fork and right angle", 60.0, 4.0),
    ]
}

/// The errors of an ordinary drone; every third drone has none but of its optic flow.
fn errors(seed: u64, random: &mut Random) -> Errors {
    let errors = Errors::ordinary(random);
    if seed.is_multiple_of(3) {
        Errors { range: 0.0, missing: 0.0, bias: [0.0; 2], drift: 0.0, yaw: 0.0, ..errors }
    } else {
        errors
    }
}

/// Flies one trial.
///
/// # Errors
/// What went wrong first.
fn fly(tunnel: &Tunnel, trial: Trial) -> Result<(), String> {
    let mut random = Random::new(trial.seed);
    let errors = errors(trial.seed, &mut random);
    let bends = tunnel.bends();
    let around = match bends.len() {
        0 => tunnel.length() - 0.5,
        n => bends[((random.uniform() * n as f32) as usize).min(n - 1)],
    };
    let goal = (around + random.between(-1.2, 1.2)).clamp(0.3, tunnel.length() - 0.4);
    let start = if trial.arrives { 0.3 } else { goal };
    let mut flight = Flight::new(tunnel, start, errors, random.clone());
    for _ in 0..600 {
        if !trial.arrives || flight.way() >= goal - 0.02 {
            break;
        }
        flight.round((0.5 * (goal - flight.way())).clamp(0.06, 0.3));
        flight.check("arriving")?;
    }
    rest(&mut flight, trial.rest, goal, &mut random)?;
    let cruise = if trial.rest == Rest::Leave { random.between(0.1, 0.4) } else { 0.2 };
    let home = trial.seed.is_multiple_of(2);
    // A drone that was set into the bend has no trail home, and need not find one after a rest.
    if home && !trial.arrives && trial.rest != Rest::Leave {
        return Ok(());
    }
    let is_there = |way: f32| if home { way < 0.7 } else { way > tunnel.length() - 0.7 };
    for _ in 0..1200 {
        if is_there(flight.way()) {
            return Ok(());
        }
        flight.round(if home { -cruise } else { cruise });
        flight.check(if home { "going home" } else { "going on" })?;
    }
    Err(format!("stands at {:.1} of {:.1} m", flight.way(), tunnel.length()))
}

fn rest(flight: &mut Flight, rest: Rest, goal: f32, random: &mut Random) -> Result<(), String> {
    let end = flight.length() - 0.5;
    let period = random.between(2.0, 12.0);
    let size = random.between(0.02, 0.05);
    let places: [f32; 6] =
        std::array::from_fn(|_| (goal + random.between(-1.0, 1.0)).clamp(0.5, end));
    let mut noise = 0.0;
    for n in 0..if rest == Rest::Leave { 5 } else { 900 } {
        let t = n as f32 * ROUND;
        noise += 0.1 * (random.normal() * 0.06 - noise);
        let to = |place: f32| place - flight.way();
        let speed = match rest {
            Rest::Still | Rest::Leave => 0.0,
            Rest::Tremble if ((t / period) as u32).is_multiple_of(2) => size,
            Rest::Tremble => -size,
            Rest::Hold => 0.3 * to(goal) + 2.0 * noise,
            Rest::Creep => {
                0.5 * to(goal + 0.3 * libm::sinf(TAU * t / (2.0 * period + 6.0))) + noise
            }
            Rest::Hop => {
                let to = to(places[(t / 30.0) as usize % places.len()]);
                if to.abs() > 0.08 && random.uniform() < 0.7 { 0.4 * to.signum() } else { 0.0 }
            }
        };
        let most = if rest == Rest::Hop { 0.4 } else { 0.3 };
        flight.round(speed.clamp(-most, most));
        flight.check("resting")?;
    }
    Ok(())
}

/// The closed loops of a mission, in single right angles: no more than 3 of 960 drones are reversed. Without a bound
/// on the drift of the heading 2 were.
#[test]
fn a_relay_in_a_right_angle_keeps_its_nose() {
    let mut failures = Vec::new();
    let mut flown = 0;
    for width in [0.8, 1.0, 1.5] {
        for tunnel in &right_angles(width) {
            for rest in [Rest::Hold, Rest::Creep, Rest::Hop, Rest::Leave] {
                for arrives in [true, false] {
                    for seed in 1..=20 {
                        let trial = Trial { rest, arrives, seed };
                        flown += 1;
                        if let Err(why) = fly(tunnel, trial) {
                            failures.push(format!("{}: {trial:?}: {why}", tunnel.name));
                        }
                    }
                }
            }
        }
    }
    assert!(failures.len() <= 3, "{} of {flown}: {failures:#?}", failures.len());
}

/// A drone that is set into a right angle, where it has seen neither gallery alone, and flies at once
/// and fast: it may fly the wrong way round the corner's walls, but not turn its nose.
#[test]
fn a_drone_set_into_a_right_angle_leaves_it_nose_to_the_end() {
    let exact = Errors {
        range: 0.0,
        missing: 0.0,
        flow: 0.02,
        bias: [0.0; 2],
        scale: 1.0,
        drift: 0.0,
        yaw: 0.0,
    };
    let mut failures = Vec::new();
    for tunnel in [0.8, 1.0, 1.5].iter().flat_map(|&width| right_angles(width)) {
        let bend = tunnel.bends()[0];
        for centimetres in (-30..=30).step_by(3) {
            for (speed, pause) in [0.4, -0.4].into_iter().flat_map(|v| [(v, 1), (v, 3), (v, 5)]) {
                let start = bend + centimetres as f32 / 100.0;
                let mut flight = Flight::new(&tunnel, start, exact, Random::new(1));
                let flown = (0..60).try_for_each(|n| {
                    let is_there = (flight.way() - bend).abs() > 2.0;
                    flight.round(if n < pause || is_there { 0.0 } else { speed });
                    flight.check("leaving")
                });
                if let Err(why) = flown {
                    let name = &tunnel.name;
                    failures.push(format!("{name}: {centimetres} cm, {speed} m/s, {pause}: {why}"));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{} of them: {failures:#?}", failures.len());
}

/// Counts the failures of all tunnels, rests and widths; for the book.
#[test]
#[ignore = "a survey without an assertion: cargo test --release -p tunnel-nav -- --ignored --nocapture"]
fn survey_of_all_bends() {
    let seeds = 1001..=1040;
    let mut table = BTreeMap::<String, [u32; 2]>::new();
    for width in [0.8, 1.0, 1.5, 2.0] {
        for tunnel in right_angles(width).iter().chain(&other_tunnels(width)) {
            for rest in RESTS {
                for arrives in [true, false] {
                    for seed in seeds.clone() {
                        let result = fly(tunnel, Trial { rest, arrives, seed });
                        let name = tunnel.name.split(',').next().unwrap_or_default();
                        for row in [name.to_owned(), format!("{rest:?}, arrives: {arrives}")] {
                            let [bad, all] = table.entry(row).or_default();
                            *bad += u32::from(result.is_err());
                            *all += 1;
                        }
                        if let Err(why) = result {
                            println!("{} {rest:?} {arrives} {seed}: {why}", tunnel.name);
                        }
                    }
                }
            }
        }
    }
    for (row, [bad, all]) in &table {
        println!("{row:30} {bad:4} of {all}");
    }
}
