//! The differences of the two dies: registers, their values, and the unit of a sample.
//!
//! Data sheet BST-BMI088-DS001, chapter 5, and Bosch's `bmi08_defs.h`.

use units::{Acceleration, AngularVelocity, Duration};

use super::{ACCEL, GYRO};
use crate::bus::HealthConfig;

/// One of the two dies: [`Gyro`] or [`Accel`].
pub trait Die: sealed::Sealed {
    /// The quantity that the die measures, with three axes.
    type Sample: Copy + PartialEq;

    #[doc(hidden)]
    const TABLE: Table;

    #[doc(hidden)]
    fn sample(axes: [f32; 3]) -> Self::Sample;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Gyro {}
    impl Sealed for super::Accel {}
}

/// The gyroscope, which measures [`AngularVelocity`] about the board's axes, including the sensor's
/// bias.
#[derive(Clone, Copy, Debug)]
pub enum Gyro {}

/// The accelerometer, which measures [`Acceleration`] along the board's axes, +9.81 m/s² on z at
/// rest.
#[derive(Clone, Copy, Debug)]
pub enum Accel {}

/// The registers and values of a die.
#[doc(hidden)]
#[derive(Debug)]
pub struct Table {
    pub(super) address: u8,
    /// The value of the identification register.
    pub(super) id: u8,
    /// The register that takes a soft reset.
    pub(super) reset: u8,
    /// Duration of a soft reset in ms.
    pub(super) reset_ms: u32,
    pub(super) setup: &'static [Step],
    /// The registers that must read as they were written.
    pub(super) readback: &'static [Readback],
    /// The register that signals a new sample.
    pub(super) status: u8,
    /// The first of the six registers that hold the sample.
    pub(super) data: u8,
    /// The least significant bit of a sample in SI units.
    pub(super) unit: f32,
    pub(super) health: HealthConfig,
}

/// A step of the die's configuration.
#[derive(Debug)]
pub(super) enum Step {
    /// Writes to this register this value.
    Write(u8, u8),
    /// Waits for this many milliseconds.
    WaitMs(u32),
}

/// A register that is read back to check the configuration.
#[derive(Debug)]
pub(super) struct Readback {
    pub(super) register: u8,
    /// The bits that read as they were written.
    pub(super) mask: u8,
    pub(super) value: u8,
}

/// The gyroscope's range of ±2000 °/s.
const RANGE_2000_DPS: u8 = 0x00;
/// The gyroscope's rate of 1000 samples a second with a filter of 116 Hz.
const ODR_1000_BANDWIDTH_116: u8 = 0x02;
/// The accelerometer's rate of 1600 samples a second with an average over four: a bandwidth of
/// 145 Hz, below half the control loop's 1 kHz.
const ODR_1600_OSR4: u8 = 0x8C;
/// The accelerometer's range of ±24 g, because a propeller's vibration exceeds 12 g.
const RANGE_24_G: u8 = 0x03;
/// The value that switches the accelerometer on.
const ACCEL_ON: u8 = 0x04;

/// Pause in ms after waking the accelerometer, and again after switching it on (crazyflie-firmware
/// waits 5 ms; the data sheet asks for less).
const POWER_MS: u32 = 5;

impl Die for Gyro {
    type Sample = AngularVelocity;

    const TABLE: Table = Table {
        address: GYRO,
        id: 0x0F,
        reset: 0x14,
        reset_ms: 30,
        setup: &[
            // Normal power mode.
            Step::Write(0x11, 0x00),
            Step::Write(0x0F, RANGE_2000_DPS),
            Step::Write(0x10, ODR_1000_BANDWIDTH_116),
            // INT3 is active high and push-pull; INT4, which is not connected, stays open-drain.
            Step::Write(0x16, 0x0D),
            // "Data ready" is mapped to INT3.
            Step::Write(0x18, 0x01),
            Step::Write(0x15, 0x80),
        ],
        readback: &[
            Readback { register: 0x0F, mask: 0xFF, value: RANGE_2000_DPS },
            // The highest bit reads as one.
            Readback { register: 0x10, mask: 0x07, value: ODR_1000_BANDWIDTH_116 },
        ],
        status: 0x0A,
        data: 0x02,
        unit: 2000.0 / 32768.0 * (core::f32::consts::PI / 180.0),
        // Samples come 1000 times a second, so four missing samples mean that the die has failed,
        // not that it is slow. A multicopter without a gyroscope crashes within a second, so the
        // first attempt comes at once and the next ones soon.
        health: HealthConfig {
            tolerated: 3,
            silence: Duration::from_millis(250),
            first_retry: Duration::from_millis(1),
            longest_retry: Duration::from_millis(100),
        },
    };

    fn sample(axes: [f32; 3]) -> AngularVelocity {
        AngularVelocity(axes)
    }
}

impl Die for Accel {
    type Sample = Acceleration;

    const TABLE: Table = Table {
        address: ACCEL,
        id: 0x1E,
        reset: 0x7E,
        // The data sheet asks for 1 ms; another is a margin.
        reset_ms: 2,
        setup: &[
            // The accelerometer is woken and then switched on.
            Step::Write(0x7C, 0x00),
            Step::WaitMs(POWER_MS),
            Step::Write(0x7D, ACCEL_ON),
            Step::WaitMs(POWER_MS),
            Step::Write(0x40, ODR_1600_OSR4),
            Step::Write(0x41, RANGE_24_G),
        ],
        readback: &[
            Readback { register: 0x40, mask: 0xFF, value: ODR_1600_OSR4 },
            Readback { register: 0x41, mask: 0x03, value: RANGE_24_G },
            Readback { register: 0x7D, mask: 0xFF, value: ACCEL_ON },
        ],
        status: 0x03,
        data: 0x12,
        // 24 g at full scale, with standard gravity.
        unit: 24.0 / 32768.0 * 9.806_65,
        // A drone flies on without the accelerometer, and each attempt takes time on the
        // gyroscope's bus.
        health: HealthConfig {
            tolerated: 3,
            silence: Duration::from_millis(250),
            first_retry: Duration::from_millis(20),
            longest_retry: Duration::from_secs(1),
        },
    };

    fn sample(axes: [f32; 3]) -> Acceleration {
        Acceleration(axes)
    }
}
