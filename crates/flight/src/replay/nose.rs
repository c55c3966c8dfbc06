//! How far the nose swings where unlike propellers twist a drone that lifts off.

use crate::control::{BodyState, Control, Goal, Horizontal, Vertical};
use crate::flight::FlightConfig;
use crate::mixer::{Mix, mix};

/// The swing of the nose after a twist that sets in at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoseSwing {
    /// The farthest that the nose turns, rad.
    pub peak: f32,
    /// The time after which the nose stays within 2°, s; `None` if that takes longer than 20 s.
    pub settles_after: Option<f32>,
}

/// For how long the nose is looked at, s.
const SWING_LOOKED_AT: f32 = 20.0;
/// The nose is back within this angle, rad: 2°.
const BACK_WITHIN: f32 = 0.0349;
const STEP: f32 = 1e-3;
/// The voltage of a battery in the middle of a flight, V.
const VOLTS: f32 = 3.7;

/// The swing of a drone in its first flight, whose propellers twist it by `torque` N m from lift-off
/// on: the yaw loops of the flight code on a body that only turns about z, with motors of first
/// order.
#[must_use]
pub fn nose_swing(config: &FlightConfig, torque: f32) -> NoseSwing {
    let goal =
        Goal { horizontal: Horizontal::Level, yaw_rate: 0.0, vertical: Vertical::Height(0.5) };
    let [_, _, inertia] = config.airframe.inertia;
    let mut control = Control::new();
    let (mut last, mut given, mut rate, mut yaw) = (Mix::OFF, 0.0, 0.0, 0.0_f32);
    let (mut peak, mut outside_until) = (0.0_f32, 0.0);
    let steps = (SWING_LOOKED_AT / STEP) as u32;
    for step in 1..=steps {
        let body = BodyState {
            velocity: [0.0; 2],
            position: [0.0; 2],
            climb: 0.0,
            height: 0.5,
            attitude: [0.0, 0.0, yaw],
            rates: [0.0, 0.0, rate],
            tilt_cosine: 1.0,
        };
        let wrench = control.step(&config.control, &config.airframe, &goal, &body, &last, STEP);
        last = mix(&config.airframe, &wrench, VOLTS);
        let [_, _, asked] = last.achieved.torque;
        given += STEP / config.gyro.motor_lag * (asked - given);
        rate += STEP * (torque + given) / inertia;
        yaw += STEP * rate;
        peak = peak.max(yaw.abs());
        if yaw.abs() > BACK_WITHIN {
            outside_until = step as f32 * STEP;
        }
    }
    let settles = outside_until < SWING_LOOKED_AT - STEP;
    NoseSwing { peak, settles_after: settles.then_some(outside_until) }
}
