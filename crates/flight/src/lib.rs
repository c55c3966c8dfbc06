//! Estimates a drone's state from its sensors, controls it, and supervises its flight: from sensor
//! readings to motor duties, a thousand times a second.
//!
//! [`Flight`] is the entry point. [`Flight::step`] takes the time, the readings since the last step
//! and the latest set-point, and returns the motor duties and the drone's status. `Flight` owns no
//! clock and no bus, never allocates and never panics. The same inputs give the same outputs, bit
//! for bit; the firmware and the simulator run exactly this type.
//!
//! | module | its part |
//! |---|---|
//! | `airframe` | mass, inertia and propellers |
//! | `calibration` | the gyroscope's bias, measured on the ground |
//! | `gyro`, `accel`, `monitor`, `battery` | check each sensor and replace failed readings |
//! | `estimator`, `attitude` | position, velocity and attitude |
//! | `drift` | the standing error of the estimated velocity |
//! | `control`, `pid`, `mixer` | from set-point to motor duties |
//! | `supervisor` | when to take off, land, or stop the motors |
//! | `replay` | the checks over the log of a flight that other code flew; for hosts only |
#![no_std]
#![allow(
    clippy::manual_clamp,
    clippy::neg_cmp_op_on_partial_ord,
    reason = "a NaN must end at a limit, and on the safe side of a comparison"
)]

mod accel;
mod airframe;
mod attitude;
mod battery;
mod calibration;
mod control;
mod drift;
mod estimator;
mod flight;
mod gyro;
mod io;
mod lowpass;
mod mixer;
mod monitor;
mod pid;
#[cfg(feature = "replay")]
pub mod replay;
mod supervisor;

pub use accel::AccelConfig;
pub use airframe::{Airframe, GRAVITY};
pub use battery::BatteryConfig;
pub use calibration::CalibrationConfig;
pub use control::{ControlConfig, ParameterGains};
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
