//! What the two dies differ in: registers, their values, and what a step of a sample means.
//!
//! Data sheet BST-BMI088-DS001, chapter 5, and Bosch's `bmi08_defs.h`.

use units::{Acceleration, AngularVelocity, Duration};

use super::{ACCEL, GYRO};
use crate::bus::HealthConfig;

/// One of the two dies.
pub trait Die: sealed::Sealed {
    /// What it measures.
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

/// The gyroscope: [`AngularVelocity`] about the board's axes, with the sensor's bias.
#[derive(Clone, Copy, Debug)]
pub enum Gyro {}

/// The accelerometer: [`Acceleration`] along the board's axes, +9.81 m/s² on z at rest.
#[derive(Clone, Copy, Debug)]
pub enum Accel {}

#[doc(hidden)]
#[derive(Debug)]
pub struct Table {
    pub(super) address: u8,
    pub(super) id: u8,
    /// The register that takes a soft reset,
    pub(super) reset: u8,
    /// and the time of one, in ms.
    pub(super) reset_ms: u32,
    pub(super) setup: &'static [Step],
    /// What must read as it was written.
    pub(super) kept: &'static [Kept],
    /// The register that tells of a new sample.
    pub(super) status: u8,
    /// The first of the six that hold it.
    pub(super) data: u8,
    /// What one step of it is in SI units.
    pub(super) unit: f32,
    pub(super) health: HealthConfig,
}

/// A step of the set-up.
#[derive(Debug)]
pub(super) enum Step {
    /// To this register, this value.
    Write(u8, u8),
    WaitMs(u32),
}

#[derive(Debug)]
pub(super) struct Kept {
    pub(super) register: u8,
    /// The bits that keep what was written.
    pub(super) mask: u8,
    pub(super) value: u8,
}

/// ±2000 °/s.
const RANGE_2000_DPS: u8 = 0x00;
/// 1000 samples a second through a filter of 116 Hz.
const ODR_1000_BANDWIDTH_116: u8 = 0x02;
/// 1600 samples a second, averaged by four: a bandwidth of 145 Hz, below half the loop's 1 kHz.
const ODR_1600_OSR4: u8 = 0x8C;
/// ±24 g: a propeller's vibration reaches beyond 12 g.
const RANGE_24_G: u8 = 0x03;
const ACCEL_ON: u8 = 0x04;

/// After waking the accelerometer and after switching it on (crazyflie-firmware waits 5 ms; the
/// data sheet asks for less).
const POWER_MS: u32 = 5;

impl Die for Gyro {
    type Sample = AngularVelocity;

    const TABLE: Table = Table {
        address: GYRO,
        id: 0x0F,
        reset: 0x14,
        reset_ms: 30,
        setup: &[
            // Normal power.
            Step::Write(0x11, 0x00),
            Step::Write(0x0F, RANGE_2000_DPS),
            Step::Write(0x10, ODR_1000_BANDWIDTH_116),
            // INT3 active high and push-pull; INT4, which leads nowhere, stays open-drain.
            Step::Write(0x16, 0x0D),
            // "Data ready" goes to INT3.
            Step::Write(0x18, 0x01),
            Step::Write(0x15, 0x80),
        ],
        kept: &[
            Kept { register: 0x0F, mask: 0xFF, value: RANGE_2000_DPS },
            // The highest bit reads as one.
            Kept { register: 0x10, mask: 0x07, value: ODR_1000_BANDWIDTH_116 },
        ],
        status: 0x0A,
        data: 0x02,
        unit: 2000.0 / 32768.0 * (core::f32::consts::PI / 180.0),
        // Samples come 1000 times a second, so four that are missing are a die that is gone and
        // none that is slow. A multicopter without a gyroscope falls within a second: the first
        // attempt comes at once, and the next ones soon.
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
        // The data sheet's millisecond, and another.
        reset_ms: 2,
        setup: &[
            // Out of its sleep, and on.
            Step::Write(0x7C, 0x00),
            Step::WaitMs(POWER_MS),
            Step::Write(0x7D, ACCEL_ON),
            Step::WaitMs(POWER_MS),
            Step::Write(0x40, ODR_1600_OSR4),
            Step::Write(0x41, RANGE_24_G),
        ],
        kept: &[
            Kept { register: 0x40, mask: 0xFF, value: ODR_1600_OSR4 },
            Kept { register: 0x41, mask: 0x03, value: RANGE_24_G },
            Kept { register: 0x7D, mask: 0xFF, value: ACCEL_ON },
        ],
        status: 0x03,
        data: 0x12,
        // With the standard's g.
        unit: 24.0 / 32768.0 * 9.806_65,
        // A drone flies on without it, and each attempt costs the gyroscope's bus some time.
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
