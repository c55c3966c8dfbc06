//! How well the simulated craft that was fitted to one part of the flights predicts another.

use bodies::craft::battery::Battery;
use serde::Serialize;

use super::course::Step;

/// The figures of the simulated craft that a part of a flight shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shown {
    /// The ratio of true to commanded thrust; `None` where the log has no accelerometer.
    pub(super) thrust: Option<f32>,
    /// The torques about x, y and z that turn the drone, N m; `None` without motors.
    pub(super) torque_nm: Option<[f32; 3]>,
}

impl Shown {
    /// What these moments show.
    pub(super) fn by(steps: &[&Step], weighs: bool) -> Self {
        let count = steps.len() as f32;
        let mean =
            |of: &dyn Fn(&Step) -> f32| steps.iter().map(|step| of(step)).sum::<f32>() / count;
        let thrust = (weighs && count > 0.0).then(|| mean(&|step| step.finding.thrust_scale));
        let known = count > 0.0 && steps.iter().all(|step| step.torque.is_some());
        let axis = |axis: usize| {
            mean(&|step| step.torque.and_then(|torque| torque.get(axis).copied()).unwrap_or(0.0))
        };
        // What turns the drone is what the motors have to hold, which give `thrust` times as much as
        // the curve says.
        let held = thrust.unwrap_or(1.0);
        let torque_nm = known.then(|| [axis(0), axis(1), axis(2)].map(|torque| -held * torque));
        Self { thrust, torque_nm }
    }
}

/// The errors of a prediction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Of the ratio of true to commanded thrust.
    pub thrust: Option<f32>,
    /// Of the torque about x, y and z, the length of the difference, N m.
    pub torque_nm: Option<f32>,
    /// Of the voltage under load, root mean square, V.
    pub volts: Option<f32>,
}

/// What was predicted, with the fit and by the scenario's defaults.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// The log that was predicted.
    pub file: String,
    /// What the fit had seen: the first half of the same flight, or other flights of the drone.
    pub seen: &'static str,
    /// The errors of the fit.
    pub fitted: Errors,
    /// The errors of a craft with the scenario's defaults.
    pub usual: Errors,
}

/// The errors of the figures `by` on what `truth` shows.
pub(super) fn errors(by: &Shown, truth: &Shown, volts: Option<f32>) -> Errors {
    let torque = by.torque_nm.zip(truth.torque_nm).map(|(by, truth)| {
        by.iter().zip(truth).map(|(by, truth)| (by - truth).powi(2)).sum::<f32>().sqrt()
    });
    let thrust = by.thrust.zip(truth.thrust).map(|(by, truth)| (by - truth).abs());
    Errors { thrust, torque_nm: torque, volts }
}

/// The charge of a battery with this internal resistance, Ω, that has this voltage with its motors
/// off.
pub(super) fn charge_at(volts: f32, ohm: f32) -> f32 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..20 {
        let middle = 0.5 * (low + high);
        if Battery::aged(middle, ohm).volts() < volts { low = middle } else { high = middle }
    }
    low
}

/// Runs the simulated battery under the thrusts of a log, from these moments on; the root mean square
/// error of its voltage in the moments that `counts`, V. `None` without any.
pub(super) fn volts_error(
    mut battery: Battery,
    steps: &[&Step],
    counts: impl Fn(&Step) -> bool,
) -> Option<f32> {
    let (mut squares, mut count, mut last) = (0.0_f64, 0_u32, None);
    for step in steps {
        let (Some(thrust), Some(volts)) = (step.thrust, step.volts) else { continue };
        let gap = last.map_or(0.0, |last| step.time - last);
        last = Some(step.time);
        battery.advance_for(thrust, gap as f32);
        if counts(step) {
            squares += f64::from(battery.volts() - volts).powi(2);
            count += 1;
        }
    }
    (count > 0).then(|| (squares / f64::from(count)).sqrt() as f32)
}
