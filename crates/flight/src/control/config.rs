//! The constants of the cascade.
//!
//! The gains are the Crazyflie's (crazyflie-firmware, `platform_defaults_cf2.h`), converted from
//! degrees and 16-bit motor steps to SI units. A step of its thrust is 0.12 N / 65,535 per motor
//! (`THRUST_MAX`). Its mixer gives each motor half of a roll or pitch step and a whole yaw step.
//! With the lever l = 0.0325 m:
//!
//! | one step of | is |
//! |---|---|
//! | roll, pitch | 4 · ½ · 0.12/65,535 · l = 1.191e-7 N m |
//! | yaw | 4 · 0.12/65,535 · 0.007351 = 5.384e-8 N m |
//! | thrust | 4 · 0.12/65,535 = 7.324e-6 N |

use core::f32::consts::PI;

use crate::pid::Gains;

const DEGREE: f32 = PI / 180.0;
/// Torque per roll or pitch step of the Crazyflie's rate controller, N m.
const TILT_STEP: f32 = 1.191e-7;
/// Torque per yaw step, N m.
const YAW_STEP: f32 = 5.384e-8;
/// Thrust per thrust step, N.
const THRUST_STEP: f32 = 7.324e-6;

/// The constants of the cascade, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlConfig {
    /// Roll and pitch rate → torque, N m per rad/s.
    pub tilt_rate: Gains,
    /// Yaw rate → torque, N m per rad/s.
    pub yaw_rate: Gains,
    /// Roll and pitch → rate, rad/s per rad.
    pub tilt: Gains,
    /// Yaw → rate, rad/s per rad.
    pub yaw: Gains,
    /// Way that the drone lags behind the velocity it was asked for → velocity, m/s per m.
    pub way: f32,
    /// The largest such way, m: a drone that was held or blown away does not hurry to make up for
    /// more.
    pub most_lag: f32,
    /// Until so long after lift-off the drone learns the torque that holds its nose quickly, s.
    pub yaw_learnt_for: f32,
    /// Meanwhile the integral of the yaw rate grows by this factor faster.
    pub yaw_haste: f32,
    /// Horizontal velocity → tilt, rad per m/s.
    pub velocity: Gains,
    /// Climb rate → thrust, N per m/s.
    pub climb: Gains,
    /// Height → climb rate, m/s per m.
    pub height: Gains,
    /// Largest tilt, rad.
    pub most_tilt: f32,
    /// Largest rate about x, y and z, rad/s.
    pub most_tilt_rate: f32,
    /// Largest climb rate, m/s.
    pub most_climb: f32,
    /// Largest descent rate, m/s: a drone survives this when it meets the floor before its ranger
    /// shows it.
    pub most_descent: f32,
    /// Smallest total thrust in the air, N.
    pub least_thrust: f32,
    /// Period of the velocity and height loops, s.
    pub slow_period: f32,
}

/// The gains of a loop in the units of the Crazyflie's parameters: proportional, integral and
/// derivative.
pub type ParameterGains = [f32; 3];

impl ControlConfig {
    /// The Crazyflie's `pid_rate.roll_*` and `pid_rate.pitch_*`, motor steps per °/s.
    pub const TILT_RATE: ParameterGains = [250.0, 500.0, 2.5];
    /// The Crazyflie's `pid_rate.yaw_*`, motor steps per °/s.
    pub const YAW_RATE: ParameterGains = [120.0, 16.7, 0.0];
    /// The Crazyflie's `pid_attitude.roll_*` and `pid_attitude.pitch_*`, °/s per °.
    pub const TILT: ParameterGains = [6.0, 3.0, 0.0];
    /// The Crazyflie's `pid_attitude.yaw_*`, °/s per °.
    pub const YAW: ParameterGains = [6.0, 1.0, 0.35];
    /// The Crazyflie's `velCtlPid.vx*` and `velCtlPid.vy*`, ° per m/s.
    pub const VELOCITY: ParameterGains = [25.0, 1.0, 0.0];
    /// The Crazyflie's `velCtlPid.vz*`, 1000 motor steps per m/s.
    pub const CLIMB: ParameterGains = [25.0, 15.0, 0.0];
    /// The Crazyflie's `posCtlPid.z*`, m/s per m.
    pub const HEIGHT: ParameterGains = [2.0, 0.5, 0.0];

    /// The Crazyflie's gains, with limits of our own.
    ///
    /// The Crazyflie's rates are limited by its motors only; 5 rad/s is what the attitude loop asks
    /// for at 45°. The integral of its climb loop has a limit that is never met; here it is half
    /// the weight. Of its ±1 m/s of vertical speed a tunnel needs no more than half, and less on
    /// the way down.
    ///
    /// No two drones twist alike, and nearly all in one direction: 222 of 225 recorded flights of two
    /// Crazyflies needed a steady yaw torque of 1.6 to 5.4e-4 N m (CrazyPAD; the undamaged ones up to
    /// 3.5e-4), three of a third one 0.2 to 0.8e-4 (arplaboratory,
    /// data-driven-system-identification). The Crazyflie's yaw rate integral gives 1.5e-4, and takes
    /// 7 s for it; the rest comes from its attitude integral, of up to 360°/s. Here the rate integral
    /// gives all of it, so that the attitude integral can keep a limit at which a drone that was held
    /// does not spin. Until a second after lift-off it is about as fast as that of roll and pitch,
    /// beyond which the motors' lag of 65 ms makes the nose swing for longer; and the next flight
    /// begins with it.
    ///
    /// The gain of the way is a quarter of the Crazyflie's position loop (`PID_POS_X_KP`, 2): it
    /// trembles least within a second, and wanders no more in ten than the flow's noise makes it.
    /// The largest lag asks for 0.05 m/s.
    pub const DEFAULT: Self = Self {
        way: 0.5,
        most_lag: 0.1,
        tilt_rate: Gains {
            kp: Self::TILT_RATE[0] * TILT_STEP / DEGREE,
            ki: Self::TILT_RATE[1] * TILT_STEP / DEGREE,
            kd: Self::TILT_RATE[2] * TILT_STEP / DEGREE,
            integral_limit: 33.3 * Self::TILT_RATE[1] * TILT_STEP,
        },
        yaw_rate: Gains {
            kp: Self::YAW_RATE[0] * YAW_STEP / DEGREE,
            ki: Self::YAW_RATE[1] * YAW_STEP / DEGREE,
            kd: Self::YAW_RATE[2] * YAW_STEP / DEGREE,
            integral_limit: 6.0e-4,
        },
        yaw_learnt_for: 1.0,
        yaw_haste: 20.0,
        tilt: Gains {
            kp: Self::TILT[0],
            ki: Self::TILT[1],
            kd: Self::TILT[2],
            integral_limit: Self::TILT[1] * 20.0 * DEGREE,
        },
        yaw: Gains { kp: Self::YAW[0], ki: Self::YAW[1], kd: Self::YAW[2], integral_limit: 1.0 },
        velocity: Gains {
            kp: Self::VELOCITY[0] * DEGREE,
            ki: Self::VELOCITY[1] * DEGREE,
            kd: Self::VELOCITY[2] * DEGREE,
            integral_limit: 20.0 * DEGREE,
        },
        climb: Gains {
            kp: Self::CLIMB[0] * 1_000.0 * THRUST_STEP,
            ki: Self::CLIMB[1] * 1_000.0 * THRUST_STEP,
            kd: Self::CLIMB[2] * 1_000.0 * THRUST_STEP,
            integral_limit: 0.15,
        },
        height: Gains {
            kp: Self::HEIGHT[0],
            ki: Self::HEIGHT[1],
            kd: Self::HEIGHT[2],
            integral_limit: 0.1,
        },
        most_tilt: 20.0 * DEGREE,
        most_tilt_rate: 5.0,
        most_climb: 0.5,
        most_descent: 0.4,
        least_thrust: 20_000.0 * THRUST_STEP,
        slow_period: 0.01,
    };
}
