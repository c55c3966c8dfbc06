//! Measures whether the estimator predicts its own errors: the normalised innovation squared of
//! flow and height over many seeded flights, and the errors against the truth.
//!
//! Each flight is ten seconds in a wide room: a third of them hover, a third fly straight legs, a
//! third turn as they fly, at set-points that the seed draws anew every second. When the variances
//! of an estimator are right, the normalised innovations squared are distributed as χ²: their mean
//! is the number of their degrees of freedom, 95 % of them are below its 95 % quantile, and at 95 %
//! of all instants the mean over the flights lies within the χ² interval for that many flights.

use flight::{FlightConfig, Verdict};
use random::{Purpose, Stream};
use rayon::prelude::*;
use serde_json::{Value, json};
use units::{Metres, MetresPerSecond, Point2, RadiansPerSecond, Setpoint};
use world::Tunnel;
use world::layout::Layout;

use bodies::craft::{Craft, Surroundings};
use bodies::others::Others;
use scenario::Ground;
use scenario::VehicleSpec;

/// Length of a flight after it has taken off, ms.
const FLIGHT_MS: u64 = 10_000;
/// Height, m: the agent's.
const HEIGHT: f32 = 0.3;
/// Instants are this many milliseconds apart: every reading of a sensor falls into one.
const FLOW_EVERY: u64 = 10;
const DOWN_EVERY: u64 = 25;
/// Fastest set-points that are drawn, m/s and rad/s: those of the agent.
const FASTEST: f32 = 0.4;
const FASTEST_TURN: f32 = 1.0;

/// The kinds of flight, by the remainder of the seed.
const KINDS: [&str; 3] = ["hover", "straight", "turning"];

/// The innovations and errors of one flight.
struct Flown {
    /// Index into [`KINDS`].
    kind: usize,
    /// NIS of each reading by its instant; a reading that was not weighed has none.
    flow: Vec<Option<f32>>,
    down: Vec<Option<f32>>,
    rejected: [u32; 2],
    unusable: [u32; 2],
    error2: Errors,
}

/// Sums of squares over a flight's milliseconds.
#[derive(Clone, Copy, Default)]
struct Errors {
    velocity: f64,
    height: f64,
    tilt: f64,
    samples: u32,
}

/// One sensor's consistency.
#[derive(Clone, Debug, PartialEq)]
pub struct Consistency {
    /// `flow` or `height`.
    pub sensor: &'static str,
    /// Degrees of freedom of one reading.
    pub degrees: u32,
    /// The number of readings that were weighed.
    pub readings: u64,
    /// The number of those that were rejected or used only after insisting.
    pub rejected: u64,
    /// The number of readings that could not be weighed.
    pub unusable: u64,
    /// The mean over all readings.
    pub mean_nis: f64,
    /// The χ² interval for the mean over the flights at one instant, 95 %.
    pub interval: (f64, f64),
    /// The part of all instants at which that mean lies within it.
    pub instants_within: f64,
    /// The part of all readings below the 95 % quantile of one.
    pub below_95: f64,
    /// The mean over the flights of each kind: hover, straight, turning.
    pub by_kind: [f64; 3],
}

/// The result of the benchmark.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The number of flights.
    pub runs: usize,
    /// Flow and height.
    pub sensors: [Consistency; 2],
    /// Root mean square errors: velocity over ground in m/s, height in m, tilt in degrees.
    pub velocity_mps: f64,
    /// See above.
    pub height_m: f64,
    /// See above.
    pub tilt_deg: f64,
}

impl Report {
    /// The result as a JSON array, one object for each sensor and one for the errors.
    #[must_use]
    pub fn json(&self) -> Value {
        let round = |value: f64| (value * 1e4).round() / 1e4;
        let mut rows: Vec<Value> = self
            .sensors
            .iter()
            .map(|s| {
                json!({
                    "sensor": s.sensor,
                    "runs": self.runs,
                    "degrees": s.degrees,
                    "readings": s.readings,
                    "rejected": s.rejected,
                    "unusable": s.unusable,
                    "mean_nis": round(s.mean_nis),
                    "interval_low": round(s.interval.0),
                    "interval_high": round(s.interval.1),
                    "instants_within": round(s.instants_within),
                    "below_95": round(s.below_95),
                    "hover": round(s.by_kind[0]),
                    "straight": round(s.by_kind[1]),
                    "turning": round(s.by_kind[2]),
                })
            })
            .collect();
        rows.push(json!({
            "errors": "rms",
            "runs": self.runs,
            "velocity_mps": round(self.velocity_mps),
            "height_m": round(self.height_m),
            "tilt_deg": round(self.tilt_deg),
        }));
        Value::Array(rows)
    }
}

/// Flies all flights.
#[must_use]
pub fn run(runs: usize, seed: u64, after_each: impl Fn() + Sync) -> Report {
    let layout = Layout::corridor(&[[-10.0, 0.0], [10.0, 0.0]], 20.0);
    let room = Tunnel::dig(&layout).expect("a room is a layout that can be built");
    let all: Vec<Flown> = (0..runs as u64)
        .into_par_iter()
        .map(|n| {
            let flown = fly(&room, seed.wrapping_add(n));
            after_each();
            flown
        })
        .collect();
    let errors = all.iter().fold(Errors::default(), |sum, flown| Errors {
        velocity: sum.velocity + flown.error2.velocity,
        height: sum.height + flown.error2.height,
        tilt: sum.tilt + flown.error2.tilt,
        samples: sum.samples + flown.error2.samples,
    });
    let root = |sum: f64| libm::sqrt(sum / f64::from(errors.samples.max(1)));
    Report {
        runs,
        sensors: [
            consistency("flow", 2, &all, |flown| &flown.flow, 0),
            consistency("height", 1, &all, |flown| &flown.down, 1),
        ],
        velocity_mps: root(errors.velocity),
        height_m: root(errors.height),
        tilt_deg: root(errors.tilt).to_degrees(),
    }
}

fn fly(room: &Tunnel, seed: u64) -> Flown {
    let vehicle = VehicleSpec::DEFAULT;
    let around = Surroundings {
        tunnel: room,
        ground: Ground::GOOD,
        vehicle: &vehicle,
        others: Others::NONE,
    };
    let random = Stream::new(seed, Purpose::Craft(0));
    let config = FlightConfig::CRAZYFLIE_2_1;
    let mut craft = Craft::standing(config, Point2::default(), [1.0, 0.0], &vehicle, random)
        .hovering(Metres(HEIGHT), around);
    let mut pilot = Stream::new(seed, Purpose::Start);
    let mut flown = Flown {
        kind: (seed % 3) as usize,
        flow: vec![None; (FLIGHT_MS / FLOW_EVERY) as usize],
        down: vec![None; (FLIGHT_MS / DOWN_EVERY) as usize],
        rejected: [0; 2],
        unusable: [0; 2],
        error2: Errors::default(),
    };
    for now_ms in 0..FLIGHT_MS {
        if now_ms.is_multiple_of(1_000) {
            craft.command(drawn(seed, &mut pilot));
        }
        craft.advance(around);
        let Some(flight) = craft.flight() else { break };
        let verdicts = flight.verdicts();
        note(verdicts.flow, &mut flown, 0, now_ms / FLOW_EVERY);
        note(verdicts.down, &mut flown, 1, now_ms / DOWN_EVERY);
        compare(&craft, &mut flown.error2);
    }
    flown
}

/// The next second's set-point: hovering, straight or turning by the seed.
fn drawn(seed: u64, pilot: &mut Stream) -> Setpoint {
    let mut upto = |most: f32| most * (2.0 * pilot.uniform() - 1.0);
    let (forward, lateral, turn) = (upto(FASTEST), upto(FASTEST), upto(FASTEST_TURN));
    let (moves, turns) = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)][(seed % 3) as usize];
    Setpoint::Fly {
        forward: MetresPerSecond(moves * forward),
        lateral: MetresPerSecond(moves * lateral),
        yaw_rate: RadiansPerSecond(turns * turn),
        height: Metres(HEIGHT),
    }
}

fn note(verdict: Option<Verdict>, flown: &mut Flown, sensor: usize, instant: u64) {
    let Some(verdict) = verdict else { return };
    let nis = match verdict {
        Verdict::Used(nis) => nis,
        Verdict::Rejected(nis) => {
            flown.rejected[sensor] += 1;
            nis
        }
        Verdict::Reseated(_) => {
            flown.rejected[sensor] += 1;
            return;
        }
        Verdict::Unusable(_) => {
            flown.unusable[sensor] += 1;
            return;
        }
    };
    let places = if sensor == 0 { &mut flown.flow } else { &mut flown.down };
    if let Some(place) = places.get_mut(instant as usize) {
        *place = Some(nis.value);
    }
}

fn compare(craft: &Craft, errors: &mut Errors) {
    let Some(flight) = craft.flight() else { return };
    let (body, estimator) = (craft.body(), flight.estimator());
    let truth = body.velocity_body();
    let is = estimator.velocity();
    errors.velocity += square(is[0] - truth[0]) + square(is[1] - truth[1]);
    errors.height += square(estimator.height() - craft.height_of_deck());
    // The angle between the two verticals in body axes; small, so its sine will do.
    let up = estimator.up();
    let true_up = body.rotation()[2];
    errors.tilt += square(up[0] - true_up[0]) + square(up[1] - true_up[1]);
    errors.samples += 1;
}

fn square(value: f32) -> f64 {
    f64::from(value) * f64::from(value)
}

fn consistency(
    sensor: &'static str,
    degrees: u32,
    flights: &[Flown],
    of: impl Fn(&Flown) -> &Vec<Option<f32>>,
    place: usize,
) -> Consistency {
    // The 95 % quantiles of χ² with one and with two degrees of freedom.
    let quantile = if degrees == 1 { 3.841_459 } else { 5.991_465 };
    let instants = flights.first().map_or(0, |flown| of(flown).len());
    let (mut sum, mut readings, mut below, mut within, mut counted) = (0.0, 0_u64, 0_u64, 0, 0);
    let mut by_kind = [(0.0, 0.0); KINDS.len()];
    for flown in flights {
        for nis in of(flown).iter().flatten() {
            let (sum, count) = &mut by_kind[flown.kind];
            *sum += f64::from(*nis);
            *count += 1.0;
        }
    }
    for instant in 0..instants {
        let (mut here, mut count) = (0.0, 0_u32);
        for nis in flights.iter().filter_map(|flown| of(flown)[instant]) {
            here += f64::from(nis);
            count += 1;
            below += u64::from(nis < quantile);
        }
        if count > 0 {
            let (low, high) = interval(degrees, count);
            let mean = here / f64::from(count);
            within += u32::from((low..=high).contains(&mean));
            counted += 1;
        }
        sum += here;
        readings += u64::from(count);
    }
    let total =
        |of: fn(&Flown) -> [u32; 2]| flights.iter().map(|flown| u64::from(of(flown)[place])).sum();
    let part = |n: f64, of: f64| if of > 0.0 { n / of } else { f64::NAN };
    Consistency {
        sensor,
        degrees,
        readings,
        rejected: total(|flown| flown.rejected),
        unusable: total(|flown| flown.unusable),
        mean_nis: part(sum, readings as f64),
        interval: interval(degrees, flights.len() as u32),
        instants_within: part(f64::from(within), f64::from(counted)),
        below_95: part(below as f64, readings as f64),
        by_kind: by_kind.map(|(sum, count)| part(sum, count)),
    }
}

/// Between which two numbers the mean of `count` draws of χ² lies, 95 times in 100: the cube root
/// of Wilson and Hilferty (1931), exact to a thousandth from ten degrees of freedom on.
fn interval(degrees: u32, count: u32) -> (f64, f64) {
    let all = f64::from(degrees) * f64::from(count.max(1));
    let spread = 2.0 / (9.0 * all);
    let at = |z: f64| {
        let root = 1.0 - spread + z * libm::sqrt(spread);
        all * root * root * root / f64::from(count.max(1))
    };
    (at(-1.959_964), at(1.959_964))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables: χ² with 100 degrees of freedom, 74.222 and 129.561.
    #[test]
    fn the_interval_is_the_tables() {
        let (low, high) = interval(1, 100);
        assert!((low - 0.742_22).abs() < 2e-4 && (high - 1.295_61).abs() < 2e-4);
        let (low, high) = interval(2, 50);
        assert!((low - 1.484_44).abs() < 4e-4 && (high - 2.591_22).abs() < 4e-4);
    }
}
