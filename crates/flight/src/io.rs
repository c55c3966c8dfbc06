//! The inputs and outputs of one step of the flight code.

use sensors::{pmw3901, vl53l1x};
use units::{
    Acceleration, AngularVelocity, Duration, Instant, Metres, MetresPerSecond, Radians, Setpoint,
    Volts,
};

use crate::supervisor::Mode;

/// The sensor readings since the last step. A field is `None` where there is no new reading, for
/// whatever reason: the flight code itself detects that a sensor has failed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sensed {
    /// The reading of the gyroscope, new at each step (1 kHz).
    pub gyro: Option<AngularVelocity>,
    /// The reading of the accelerometer, new at each step (1 kHz).
    pub accel: Option<Acceleration>,
    /// The reading of the optic flow sensor: counts since the last reading, about 100 Hz.
    pub flow: Option<pmw3901::Motion>,
    /// The reading of the ranger that looks down, about 40 Hz.
    pub down: Option<vl53l1x::Reading>,
    /// The battery voltage at the terminals, under load.
    pub battery: Option<Volts>,
}

/// A set-point with the time at which it was given: one that is too old ends the flight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Command {
    /// The set-point that the drone is to follow.
    pub setpoint: Setpoint,
    /// The time at which the set-point was given.
    pub given: Instant,
}

/// The duty of each motor, which is the fraction, from 0 to 1, of the battery's voltage that the
/// motor is given. The motors are in the order front right, rear right, rear left, front left (M1
/// to M4 of the Crazyflie).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Duties(pub [f32; 4]);

impl Duties {
    /// All motors off.
    pub const OFF: Self = Self([0.0; 4]);
}

/// The result of one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outputs {
    /// Duties of the motors.
    pub duties: Duties,
    /// Status for the mission loop, the telemetry and the LEDs.
    pub status: Status,
}

/// The drone's state as the flight code knows it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Status {
    /// The flight mode, with the reason for it.
    pub mode: Mode,
    /// The roll, pitch and yaw.
    pub attitude: Attitude,
    /// The velocity over ground along the board's x and y; `None` while no sensor measures it.
    pub velocity: Option<[MetresPerSecond; 2]>,
    /// The height over ground; `None` while no sensor measures it.
    pub height: Option<Metres>,
    /// The state of the battery.
    pub battery: Battery,
}

/// The attitude of the board. Positive roll lowers the right side, positive pitch lowers the nose,
/// and yaw counts counter-clockwise from the heading at switch-on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Attitude {
    /// The angle about x.
    pub roll: Radians,
    /// The angle about y.
    pub pitch: Radians,
    /// The angle about z. It drifts slowly, since only the gyroscope measures it.
    pub yaw: Radians,
}

/// The state of the battery.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Battery {
    /// The voltage at the terminals, smoothed.
    pub volts: Volts,
    /// The time for which the battery can still carry the hovering drone; `None` while its voltage
    /// is unknown.
    pub endurance: Option<Duration>,
}
