//! What goes into a step of the flight code, and what comes out.

use sensors::{pmw3901, vl53l1x};
use units::{
    Acceleration, AngularVelocity, Duration, Instant, Metres, MetresPerSecond, Radians, Setpoint,
    Volts,
};

use crate::supervisor::Mode;

/// What the sensors brought since the last step: `None` where nothing new came in, for whatever
/// reason. That a sensor has failed is for the flight code to notice.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sensed {
    /// Gyroscope: new at each step, 1 kHz.
    pub gyro: Option<AngularVelocity>,
    /// Accelerometer: new at each step, 1 kHz.
    pub accel: Option<Acceleration>,
    /// Optic flow: counts since the last reading, about 100 Hz.
    pub flow: Option<pmw3901::Motion>,
    /// The ranger that looks down, about 40 Hz.
    pub down: Option<vl53l1x::Reading>,
    /// The battery at its terminals, under load.
    pub battery: Option<Volts>,
}

/// A set-point and when it was given: one that grows old ends the flight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Command {
    /// What to do.
    pub setpoint: Setpoint,
    /// When it was said.
    pub given: Instant,
}

/// How hard each motor is driven, as the part of the battery's voltage that it is given, 0 to 1:
/// front right, rear right, rear left, front left (M1 to M4 of the Crazyflie).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Duties(pub [f32; 4]);

impl Duties {
    /// All motors stand.
    pub const OFF: Self = Self([0.0; 4]);
}

/// What a step decided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outputs {
    /// For the motors.
    pub duties: Duties,
    /// For everyone else.
    pub status: Status,
}

/// What the flight code knows.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Status {
    /// What it is doing, and why.
    pub mode: Mode,
    /// Roll, pitch and yaw.
    pub attitude: Attitude,
    /// Velocity over ground along the board's x and y; `None` while nothing measures it.
    pub velocity: Option<[MetresPerSecond; 2]>,
    /// Height over ground; `None` while nothing measures it.
    pub height: Option<Metres>,
    /// The battery.
    pub battery: Battery,
}

/// Where the board points: positive roll lowers the right side, positive pitch lowers the nose,
/// yaw counter-clockwise from where it was switched on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Attitude {
    /// About x.
    pub roll: Radians,
    /// About y.
    pub pitch: Radians,
    /// About z. Drifts slowly: nothing but the gyroscope measures it.
    pub yaw: Radians,
}

/// The battery as the drone sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Battery {
    /// At its terminals, smoothed.
    pub volts: Volts,
    /// How long it will still carry the drone, before it has to land; `None` while nothing is
    /// known of it.
    pub endurance: Option<Duration>,
}
