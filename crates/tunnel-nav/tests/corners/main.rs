//! Drones that rest and dither in corners: afterwards the nose still points along the tunnel.

mod flight;
mod world;

use flight::{Errors, Flight, ROUND, Random};
use world::Tunnel;

fn tunnels(width: f32) -> Vec<Tunnel> {
    let degrees = |turns: &[f32]| turns.iter().map(|t| t.to_radians()).collect::<Vec<_>>();
    let of = |name: &str, turns: &[f32]| Tunnel::turning(name, width, 3.0 + width, &degrees(turns));
    vec![
        of("right angle", &[90.0]),
        of("right angle to the right", &[-90.0]),
        of("60 degrees", &[60.0]),
        of("120 degrees", &[120.0]),
        of("U", &[90.0, 90.0]),
        of("Z", &[90.0, -90.0]),
        Tunnel::rounded(width, 3.0 + width, 0.8 * width),
        of("dead end", &[]),
        of("", &[90.0]).with_branch("T and right angle", -1.5708, 4.0),
        of("", &[90.0]).with_branch("fork and right angle", 1.0472, 4.0),
    ]
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Rest {
    /// No speed is commanded.
    Still,
    /// Zero-mean speeds whose sign flips.
    Dither,
    /// A place is held by a closed loop with noise.
    Hold,
    /// The drone creeps back and forth.
    Creep,
    /// The drone leaves at once.
    Leave,
    /// The drone flies at full speed or not at all, to a place nearby.
    Bang,
}

struct Trial {
    arrives: bool,
    rest: Rest,
    back: bool,
}

fn fly(tunnel: &Tunnel, seed: u64, trial: &Trial, trace: bool) -> Result<f32, String> {
    let mut random = Random::new(seed);
    let errors = Errors {
        range: 0.02,
        missing: 0.03,
        flow: 0.02,
        bias: [0.003 * random.normal(), 0.003 * random.normal()],
        scale: 1.0 + 0.03 * random.normal(),
        drift: random.between(-5.0, 5.0).to_radians() / 60.0,
        yaw: 0.02,
    };
    let errors = if seed % 3 == 0 {
        Errors { range: 0.0, missing: 0.0, drift: 0.0, yaw: 0.0, bias: [0.0; 2], ..errors }
    } else {
        errors
    };
    let bends = tunnel.bends();
    let around = match bends.len() {
        0 => tunnel.length() - 0.5,
        n => bends[((random.uniform() * n as f32) as usize).min(n - 1)],
    };
    let goal = (around + random.between(-1.2, 1.2)).clamp(0.3, tunnel.length() - 0.4);
    let start = if trial.arrives { 0.3 } else { goal };
    let mut flight = Flight::new(tunnel, start, errors, random.clone());
    flight.trace = trace;
    if trial.arrives {
        for _ in 0..600 {
            let left = goal - flight.place().way;
            if left < 0.02 {
                break;
            }
            flight.round((0.5 * left).clamp(0.06, 0.3));
        }
    }
    let reversed = |flight: &Flight, when: &str| {
        if flight.touches > 0 {
            return Err(format!("touched {when}"));
        }
        if flight.astray().to_degrees() > 100.0 {
            return Err(format!("reversed {when}"));
        }
        Ok(())
    };
    let arrived = flight.place().way;
    reversed(&flight, "arriving")?;
    let period = random.between(2.0, 12.0);
    let size = random.between(0.02, 0.05);
    let bang: [f32; 6] = std::array::from_fn(|_| {
        (goal + random.between(-1.0, 1.0)).clamp(0.5, tunnel.length() - 0.5)
    });
    let mut noise = 0.0;
    let rounds = if trial.rest == Rest::Leave { 5 } else { 900 };
    let cruise = if trial.rest == Rest::Leave { random.between(0.1, 0.4) } else { 0.2 };
    for n in 0..rounds {
        let t = n as f32 * ROUND;
        let way = flight.place().way;
        noise += 0.1 * (random.normal() * 0.06 - noise);
        let to = bang[(t / 30.0) as usize % 6] - way;
        let speed = match trial.rest {
            Rest::Bang => {
                if to.abs() > 0.08 && random.uniform() < 0.7 {
                    0.4 * to.signum()
                } else {
                    0.0
                }
            }
            Rest::Still | Rest::Leave => 0.0,
            Rest::Dither => {
                if (t / period) as u32 % 2 == 0 {
                    size
                } else {
                    -size
                }
            }
            Rest::Hold => (0.3 * (goal - way) + noise * 2.0).clamp(-0.3, 0.3),
            Rest::Creep => {
                let to = goal + 0.3 * libm::sinf(6.2832 * t / (2.0 * period + 6.0));
                (0.5 * (to - way) + noise).clamp(-0.3, 0.3)
            }
        };
        flight.round(speed);
        reversed(&flight, "resting")?;
    }
    let rested = flight.place().way;
    let _ = (arrived, rested);
    if trial.back {
        if !trial.arrives && trial.rest != Rest::Leave {
            return Ok(flight.worst);
        }
        for _ in 0..1200 {
            if flight.place().way < 0.6 {
                break;
            }
            flight.round(-cruise);
            reversed(&flight, "going back")?;
        }
        if flight.place().way > 0.7 {
            return Err(format!("not home but at {}", flight.place().way));
        }
    } else {
        for _ in 0..1200 {
            if flight.place().way > tunnel.length() - 0.5 {
                break;
            }
            flight.round(cruise);
            reversed(&flight, "going on")?;
        }
        if flight.place().way < tunnel.length() - 0.7 {
            return Err(format!("not on but at {} of {}", flight.place().way, tunnel.length()));
        }
    }
    Ok(flight.worst)
}

#[test]
fn survey() {
    let runs: u64 = std::env::var("RUNS").ok().and_then(|r| r.parse().ok()).unwrap_or(20);
    let first: u64 = std::env::var("FIRST").ok().and_then(|r| r.parse().ok()).unwrap_or(1);
    let mut table = std::collections::BTreeMap::<String, [u32; 2]>::new();
    let mut reasons = std::collections::BTreeMap::<String, u32>::new();
    let mut all = [0, 0];
    let which = std::env::var("TRACE").ok();
    for width in [0.8, 1.0, 1.5, 2.0] {
        for tunnel in tunnels(width) {
            for rest in
                [Rest::Still, Rest::Dither, Rest::Hold, Rest::Creep, Rest::Leave, Rest::Bang]
            {
                for arrives in [true, false] {
                    for seed in first..first + runs {
                        let trial = Trial { arrives, rest, back: seed % 2 == 0 };
                        let name = format!("{}/{rest:?}/{arrives}/{seed}", tunnel.name);
                        if let Some(which) = &which {
                            if *which != name {
                                continue;
                            }
                        }
                        let result = fly(&tunnel, seed, &trial, which.is_some());
                        if let Err(why) = &result {
                            println!("{name}: {why}");
                            let why: String = why.chars().filter(|c| !c.is_ascii_digit()).collect();
                            *reasons.entry(why).or_default() += 1;
                        }
                        let bad = u32::from(result.is_err());
                        all[0] += bad;
                        all[1] += 1;
                        for key in [
                            format!("tunnel {}", tunnel.name),
                            format!("rest {rest:?} arrives {arrives}"),
                        ] {
                            let row = table.entry(key).or_default();
                            row[0] += bad;
                            row[1] += 1;
                        }
                    }
                }
            }
        }
    }
    for (key, [bad, of]) in &table {
        println!("== {key}: {bad} of {of}");
    }
    for (key, n) in &reasons {
        println!("=== {key}: {n}");
    }
    println!("=== all {all:?}");
}
