//! The signals of a log in SI units and the board's axes, by the names of the vendor's variables.

use std::path::Path;

use flight::{Airframe, GRAVITY};
use input::InputError;
use recordings::variables::Variables;

use super::track::Track;

const DEGREE: f64 = std::f64::consts::PI / 180.0;
const MILLI: f64 = 1e-3;
/// The period of the flight code, s.
const STEP: f64 = 1e-3;
/// A log with a longer period than this, in s, is filled up to the period of the flight code.
const FAST_ENOUGH: f64 = 2.5e-3;
/// The largest value of a motor's variable.
const FULL: f64 = 65_535.0;

/// Where the specific force comes from.
#[derive(Clone, Debug)]
pub(super) enum Force {
    /// The accelerometer, m/s².
    Sensor([Track; 3]),
    /// The acceleration that the vendor's estimator gives, along the world's axes, in multiples of
    /// gravity, without gravity.
    Estimate([Track; 3]),
}

/// How a motor's voltage is known.
#[derive(Clone, Debug)]
enum Motors {
    /// By the duty (0 to 1) and the battery.
    Duties([Track; 4]),
    /// By the vendor's command (0 to 1), from which its firmware makes a voltage.
    Commands([Track; 4]),
}

/// The signals of a log; what it does not hold is `None`.
#[derive(Clone, Debug)]
pub(super) struct Signals {
    pub(super) force: Option<Force>,
    pub(super) gyro: Option<[Track; 3]>,
    motors: Option<Motors>,
    pub(super) volts: Option<Track>,
    pub(super) height: Option<Track>,
    pub(super) climb: Option<Track>,
    roll: Option<Track>,
    /// Positive lowers the nose.
    pitch: Option<Track>,
    yaw: Option<Track>,
    /// The times at which the flight code is stepped, s.
    pub(super) timeline: Vec<f64>,
    /// The median period of the log, s.
    pub(super) period: f64,
}

/// The variables that a replay can use, for an error message.
const USABLE: &str = "log acc.*, gyro.*, motor.*, pwm.*, pm.vbat or stateEstimate.*";

impl Signals {
    pub(super) fn of(log: &Variables, file: &Path) -> Result<Self, InputError> {
        let get = |name: &str, unit: f64| Track::of(log.get(name)?, unit);
        let any = |names: &[(&str, f64)]| names.iter().find_map(|(name, unit)| get(name, *unit));
        let group = |group: &str, parts: [&str; 3], unit: f64| -> Option<[Track; 3]> {
            let [a, b, c] = parts.map(|part| get(&format!("{group}.{part}"), unit));
            Some([a?, b?, c?])
        };
        let gravity = f64::from(GRAVITY);
        let sensor = group("acc", ["x", "y", "z"], gravity).map(Force::Sensor);
        let estimate = || group("stateEstimate", ["ax", "ay", "az"], gravity).map(Force::Estimate);
        let height =
            any(&[("stateEstimate.z", 1.0), ("stateEstimateZ.z", MILLI), ("range.zrange", MILLI)]);
        let mut signals = Self {
            force: sensor.or_else(estimate),
            gyro: group("gyro", ["x", "y", "z"], DEGREE),
            motors: Motors::of(&get),
            volts: any(&[("pm.vbatMV", MILLI), ("pm.vbat", 1.0)]),
            height,
            climb: any(&[("stateEstimate.vz", 1.0), ("stateEstimateZ.vz", MILLI)]),
            roll: any(&[("stateEstimate.roll", DEGREE), ("stabilizer.roll", DEGREE)]),
            // The vendor's pitch raises the nose.
            pitch: any(&[("stateEstimate.pitch", -DEGREE), ("stabilizer.pitch", -DEGREE)]),
            yaw: any(&[("stateEstimate.yaw", DEGREE), ("stabilizer.yaw", DEGREE)]),
            timeline: Vec::new(),
            period: 0.0,
        };
        signals.set_timeline();
        if signals.timeline.len() < 2 {
            let wrong = "no variable of the log is of the flight code's kind";
            return Err(InputError::new(wrong, USABLE).in_file(file));
        }
        Ok(signals)
    }

    /// The times of the fastest signal, or each millisecond where it is too slow.
    fn set_timeline(&mut self) {
        let force = match &self.force {
            Some(Force::Sensor([x, _, _]) | Force::Estimate([x, _, _])) => Some(x),
            None => None,
        };
        let motor = match &self.motors {
            Some(Motors::Duties([first, ..]) | Motors::Commands([first, ..])) => Some(first),
            None => None,
        };
        let gyro = self.gyro.as_ref().map(|[x, _, _]| x);
        let signals = [force, gyro, motor, self.volts.as_ref(), self.height.as_ref()];
        let fastest =
            signals.into_iter().flatten().min_by(|a, b| a.period().total_cmp(&b.period()));
        let Some(fastest) = fastest else { return };
        self.period = fastest.period();
        self.timeline = if self.period <= FAST_ENOUGH {
            fastest.times().collect()
        } else {
            let first = fastest.times().next().unwrap_or(0.0);
            let last = fastest.times().last().unwrap_or(0.0);
            let steps = ((last - first) / STEP) as usize;
            (0..=steps).map(|step| first + step as f64 * STEP).collect()
        };
    }

    /// The thrust in N that each motor is asked for, by the airframe's curve.
    pub(super) fn thrusts(&self, airframe: &Airframe, time: f64) -> Option<[f32; 4]> {
        let volts = match self.motors.as_ref()? {
            Motors::Duties(duties) => {
                let battery = self.volts.as_ref()?.at(time)?;
                at(duties, time)?.map(|duty| duty * battery)
            }
            Motors::Commands(commands) => at(commands, time)?.map(vendor_volts),
        };
        Some(volts.map(|volts| airframe.thrust_at(volts)))
    }

    pub(super) const fn has_motors(&self) -> bool {
        self.motors.is_some()
    }

    /// Whether a motor has its full duty.
    pub(super) fn at_full_duty(&self, time: f64) -> bool {
        match &self.motors {
            Some(Motors::Duties(duties)) => {
                at(duties, time).is_some_and(|duties| duties.iter().any(|duty| *duty >= 0.999))
            }
            _ => false,
        }
    }

    /// The specific force in the board's axes, m/s².
    pub(super) fn force_at(&self, time: f64) -> Option<[f32; 3]> {
        match self.force.as_ref()? {
            Force::Sensor(axes) => at(axes, time),
            Force::Estimate(axes) => {
                let [x, y, z] = at(axes, time)?;
                let [roll, yaw] = [&self.roll, &self.yaw]
                    .map(|angle| angle.as_ref().and_then(|angle| angle.at(time)).unwrap_or(0.0));
                let up = z + GRAVITY;
                let ahead = yaw.cos() * x + yaw.sin() * y;
                let left = yaw.cos() * y - yaw.sin() * x;
                // Without the pitch nothing is known along x: a drone that accelerates leans.
                let (forward, upright) = match &self.pitch {
                    Some(pitch) => {
                        let pitch = pitch.at(time)?;
                        let (sin, cos) = pitch.sin_cos();
                        (cos * ahead - sin * up, sin * ahead + cos * up)
                    }
                    None => (0.0, up),
                };
                let (sin, cos) = roll.sin_cos();
                Some([forward, cos * left + sin * upright, cos * upright - sin * left])
            }
        }
    }

    pub(super) fn gyro_at(&self, time: f64) -> Option<[f32; 3]> {
        at(self.gyro.as_ref()?, time)
    }

    /// The cosine of the tilt by roll and pitch, or by roll alone; `None` where neither is known.
    pub(super) fn tilt_cosine(&self, time: f64) -> Option<f32> {
        let cosine = |angle: &Option<Track>| angle.as_ref()?.at(time).map(f32::cos);
        match (cosine(&self.roll), cosine(&self.pitch)) {
            (None, None) => None,
            (roll, pitch) => Some(roll.unwrap_or(1.0) * pitch.unwrap_or(1.0)),
        }
    }

    /// What the log does not hold, each with what is not judged for that.
    pub(super) fn missing(&self) -> Vec<String> {
        let estimated = matches!(self.force, Some(Force::Estimate(_)));
        let no_yaw_or_roll = estimated && (self.roll.is_none() || self.yaw.is_none());
        [
            (self.force.is_none(), "no accelerometer in the log"),
            (estimated, "no accelerometer in the log: the estimator's acceleration is used"),
            (estimated && self.pitch.is_none(), "no pitch in the log: no force along x"),
            (no_yaw_or_roll, "no roll or no yaw in the log: the forces are not turned by it"),
            (self.gyro.is_none(), "no gyroscope in the log"),
            (self.motors.is_none(), "no motors in the log"),
            (
                matches!(self.motors, Some(Motors::Commands(_))),
                "no duties in the log: the thrust is that of the vendor's commands",
            ),
            (self.volts.is_none(), "no battery in the log"),
            (self.height.is_none(), "no height in the log"),
        ]
        .into_iter()
        .filter(|(missing, _)| *missing)
        .map(|(_, what)| what.to_owned())
        .collect()
    }
}

impl Motors {
    fn of(get: &impl Fn(&str, f64) -> Option<Track>) -> Option<Self> {
        let all = |name: &dyn Fn(u8) -> String| -> Option<[Track; 4]> {
            let [a, b, c, d] = [1, 2, 3, 4].map(|motor| get(&name(motor), 1.0 / FULL));
            Some([a?, b?, c?, d?].map(|track| track.map(|value| value.clamp(0.0, 1.0))))
        };
        let commands = || all(&|motor| format!("motor.m{motor}")).map(Self::Commands);
        let battery = get("pm.vbatMV", MILLI).or_else(|| get("pm.vbat", 1.0));
        let duties = all(&|motor| format!("pwm.m{motor}_pwm")).map(Self::Duties);
        duties.filter(|_| battery.is_some()).or_else(commands)
    }
}

/// The voltage that the vendor's firmware gives a motor for a command (0 to 1): the thrust of all
/// four in grams, and its parabola (crazyflie-firmware, `motors.c`,
/// `motorsCompensateBatteryVoltage`). On the flights of CrazyPAD, which have duties and battery as
/// well, it is within some millivolts.
fn vendor_volts(command: f32) -> f32 {
    let grams = 60.0 * command;
    (0.088 * grams - 0.000_623_9 * grams * grams).max(0.0)
}

fn at<const N: usize>(tracks: &[Track; N], time: f64) -> Option<[f32; N]> {
    let mut values = [0.0; N];
    for (value, track) in values.iter_mut().zip(tracks) {
        *value = track.at(time)?;
    }
    Some(values)
}
