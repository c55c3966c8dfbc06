//! When the drone of a log was in the air, and how each flight ended.

use flight::{Airframe, GRAVITY};
use serde::Serialize;

use super::signals::Signals;

/// Motors that are asked for more than this part of the weight are on.
const ON_FROM: f32 = 0.5;
/// Motors that are asked for less than this part are off, after [`OFF_AFTER`].
const OFF_BELOW: f32 = 0.15;
/// A time without thrust that a lively flight still has, s.
const OFF_AFTER: f64 = 0.3;
/// A drone above this height over where it stood has left the floor, m: the flight code's own limit.
const LIFTED_FROM: f32 = 0.05;
/// Where no height is known, a drone has left the floor when its motors have been asked for this part
/// of its weight for [`LIFTS_FOR`].
const LIFTS_FROM: f32 = 0.7;
const LIFTS_FOR: f64 = 0.5;
/// A shorter flight is none, s.
const SHORTEST: f64 = 1.0;
/// A drone whose motors are off lies on its side or back where its z axis feels less than this part
/// of gravity: a tilt of 70°, the supervisor's limit.
const LIES_BELOW: f32 = 0.342;
/// Motors that stop higher than this let the drone fall, m.
const FALLS_FROM: f32 = 0.15;
/// Without motors and height, a drone whose body turns more than this within [`SHAKES_WITHIN`] flies,
/// rad/s.
const SHAKES_FROM: f32 = 0.1;
const SHAKES_WITHIN: f64 = 0.25;

/// One flight of a log.
#[derive(Clone, Copy, Debug)]
pub(super) struct Airborne {
    /// When the motors started, s.
    pub(super) from: f64,
    /// When it left the floor, s.
    pub(super) lifted: f64,
    /// When the motors stopped, or the log ended, s.
    pub(super) until: f64,
    pub(super) ending: Ending,
    /// The height at which it stood, m.
    pub(super) ground: f32,
}

/// How a flight ended, by the log alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ending {
    /// The log ends while the motors run.
    LogEnds,
    /// The motors stopped on the floor, and the drone stands level.
    Landed,
    /// The motors stopped at this height, m.
    MotorsStopped(f32),
    /// The drone lay on its side or back afterwards.
    Tumbled,
}

/// The flights of a log.
pub(super) fn flights(signals: &Signals, airframe: &Airframe) -> Vec<Airborne> {
    let mut flights = Vec::new();
    let mut open: Option<(f64, Option<f64>)> = None;
    let mut last_on = 0.0;
    let mut lifting_since: Option<f64> = None;
    let mut ground = 0.0;
    for &time in &signals.timeline {
        let activity = activity(signals, airframe, time);
        if activity >= if open.is_some() { OFF_BELOW } else { ON_FROM } {
            last_on = time;
            if open.is_none() {
                ground = ground_before(signals, time);
                open = Some((time, None));
                lifting_since = None;
            }
        }
        let Some((from, lifted)) = &mut open else { continue };
        lifting_since = if activity >= LIFTS_FROM { lifting_since.or(Some(time)) } else { None };
        let high = match &signals.height {
            Some(height) => height.at(time).is_some_and(|height| height - ground > LIFTED_FROM),
            None => lifting_since.is_some_and(|since| time - since >= LIFTS_FOR),
        };
        if high && lifted.is_none() {
            *lifted = Some(time);
        }
        if time - last_on > OFF_AFTER {
            flights.extend(flight(signals, (*from, *lifted), last_on, ground, false));
            open = None;
        }
    }
    if let Some((from, lifted)) = open {
        flights.extend(flight(signals, (from, lifted), last_on, ground, true));
    }
    flights
}

fn flight(
    signals: &Signals,
    (from, lifted): (f64, Option<f64>),
    until: f64,
    ground: f32,
    log_ends: bool,
) -> Option<Airborne> {
    let lifted = lifted.filter(|lifted| until - lifted >= SHORTEST)?;
    let ending = if log_ends { Ending::LogEnds } else { ending(signals, until, ground) };
    Some(Airborne { from, lifted, until, ending, ground })
}

fn ending(signals: &Signals, until: f64, ground: f32) -> Ending {
    let height = signals.height.as_ref().and_then(|height| height.at(until));
    if lies(signals, until) {
        return Ending::Tumbled;
    }
    match height.map(|height| height - ground) {
        Some(height) if height > FALLS_FROM => Ending::MotorsStopped(height),
        _ => Ending::Landed,
    }
}

/// Whether the drone lies on its side or back after its motors have stopped: by the force along its
/// z axis, or by its attitude.
fn lies(signals: &Signals, until: f64) -> bool {
    let after = signals.timeline.iter().copied();
    let after = after.filter(|time| (until + 0.5..until + 2.5).contains(time));
    let mut upright: Vec<f32> = after
        .filter_map(|time| {
            let force = signals.force_at(time).map(|[_, _, z]| z / GRAVITY);
            signals.tilt_cosine(time).or(force)
        })
        .collect();
    upright.sort_unstable_by(f32::total_cmp);
    upright.get(upright.len() / 2).is_some_and(|upright| *upright < LIES_BELOW)
}

/// The part of the weight that the motors are asked for; without motors, 1 in the air and else 0.
fn activity(signals: &Signals, airframe: &Airframe, time: f64) -> f32 {
    if signals.has_motors() {
        let thrusts = signals.thrusts(airframe, time);
        return thrusts.map_or(0.0, |all| all.iter().sum::<f32>() / airframe.weight());
    }
    let flies = match (&signals.height, &signals.gyro) {
        (Some(height), _) => height.at(time).is_some_and(|height| height > LIFTED_FROM),
        (None, Some(axes)) => axes.iter().any(|axis| {
            let mean = axis.mean(time - SHAKES_WITHIN, time);
            axis.at(time).zip(mean).is_some_and(|(rate, mean)| (rate - mean).abs() > SHAKES_FROM)
        }),
        (None, None) => false,
    };
    f32::from(u8::from(flies))
}

/// The height before a take-off, m; 0 where the log begins in the air.
fn ground_before(signals: &Signals, time: f64) -> f32 {
    let height = signals.height.as_ref();
    height.and_then(|height| height.mean(time - 1.0, time - 0.05)).unwrap_or(0.0)
}
