//! State estimator, controllers, mixer and supervisor: from sensor readings to motor duties, a
//! thousand times a second.
//!
//! [`Flight`] is the door: hand [`Flight::step`] the time, what the sensors brought and the latest
//! set-point; it returns what the motors get and what the drone knows of itself. It owns no clock
//! and no bus, never allocates and never panics, and the same inputs give the same outputs, bit
//! for bit: the firmware and the simulator run exactly this type.
//!
//! | module | its part |
//! |---|---|
//! | `airframe` | mass, inertia, propellers |
//! | `calibration` | the gyroscope's zero |
//! | `gyro`, `accel`, `monitor`, `battery` | what is believed of a sensor, and what stands in for it |
//! | `estimator`, `attitude` | where it is, how fast, and how it is turned |
//! | `control`, `pid`, `mixer` | from set-point to duties |
//! | `supervisor` | what may fly, and what ends a flight |
#![no_std]
#![allow(
    clippy::manual_clamp,
    clippy::neg_cmp_op_on_partial_ord,
    reason = "what is not a number must end at a limit, and on the safe side of a comparison"
)]

mod accel;
mod airframe;
mod attitude;
mod battery;
mod calibration;
mod control;
mod estimator;
mod flight;
mod gyro;
mod io;
mod lowpass;
mod mixer;
mod monitor;
mod pid;
mod supervisor;

pub use accel::AccelConfig;
pub use airframe::{Airframe, GRAVITY};
pub use battery::BatteryConfig;
pub use calibration::CalibrationConfig;
pub use control::ControlConfig;
pub use estimator::{
    DownConfig, Estimator, EstimatorConfig, FlowConfig, InertialConfig, Nis, Reseated, RestConfig,
    Unusable, Verdict,
};
pub use flight::{Flight, FlightConfig, Verdicts};
pub use gyro::GyroConfig;
pub use io::{Attitude, Battery, Command, Duties, Outputs, Sensed, Status};
pub use lowpass::LowPass;
pub use pid::Gains;
pub use supervisor::{Cause, Mode, NotReady, StopCause, SupervisorConfig};
