//! Driver of the BMI088, the inertial sensor: a gyroscope and an accelerometer on two dies, which
//! have an address each and share nothing but the package. Each die has a driver of its own, so
//! that the failure of one does not affect the other.
//!
//! On the Crazyflie the chip's axes are the board's, x forward, y left, z up, and the gyroscope's
//! INT3 rises when a sample is ready, 1000 times a second.

mod die;
mod keeper;

use core::marker::PhantomData;

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::i2c::I2c;

pub use die::{Accel, Die, Gyro};
pub use keeper::Keeper;

use crate::Error;
use die::Step;

/// The gyroscope's I²C address on the Crazyflie (crazyflie-firmware, `sensors_bmi088_i2c.c`).
pub const GYRO: u8 = 0x69;
/// The accelerometer's I²C address on the Crazyflie (crazyflie-firmware, `sensors_bmi088_i2c.c`).
pub const ACCEL: u8 = 0x18;

/// The identification register of either die (data sheet BST-BMI088-DS001).
const CHIP_ID: u8 = 0x00;
/// The value that requests a soft reset.
const RESET: u8 = 0xB6;
/// The bit in the status register of either die that signals a new sample.
const DATA_READY: u8 = 0x80;
/// Number of milliseconds within which the first sample must come.
const FIRST_SAMPLE_MS: u32 = 50;

/// The driver of one die: `Bmi088<_, Gyro>` or `Bmi088<_, Accel>`.
#[derive(Debug)]
pub struct Bmi088<I2C, D> {
    i2c: I2C,
    die: PhantomData<D>,
}

impl<I2C: I2c, D: Die> Bmi088<I2C, D> {
    /// A driver that has not sent anything to the die yet.
    pub const fn new(i2c: I2C) -> Self {
        Self { i2c, die: PhantomData }
    }

    /// Resets and configures the die and waits for a sample. This takes about 35 ms for the
    /// gyroscope and 15 ms for the accelerometer.
    ///
    /// # Errors
    /// Any [`Error`] but [`Error::AddressTaken`], [`Error::Silent`] and [`Error::Unsupported`].
    pub async fn init<W: DelayNs>(&mut self, delay: &mut W) -> Result<(), Error<I2C::Error>> {
        self.write(D::TABLE.reset, RESET).await?;
        delay.delay_ms(D::TABLE.reset_ms).await;
        let found = self.read_register(CHIP_ID).await?;
        if found != D::TABLE.id {
            return Err(Error::WrongDevice { found: found.into() });
        }
        for step in D::TABLE.setup {
            match *step {
                Step::Write(register, value) => self.write(register, value).await?,
                Step::WaitMs(ms) => delay.delay_ms(ms).await,
            }
        }
        self.verify().await?;
        self.await_sample(delay).await
    }

    /// Reads the latest sample of 6 bytes, which takes 0.21 ms at 400 kHz.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub async fn read(&mut self) -> Result<D::Sample, Error<I2C::Error>> {
        // The byte is in a variable, because a constant lies in flash, which not every DMA reaches.
        let register = [D::TABLE.data];
        let mut bytes = [0; 6];
        self.i2c.write_read(D::TABLE.address, &register, &mut bytes).await?;
        let [x0, x1, y0, y1, z0, z1] = bytes;
        let raw = [[x0, x1], [y0, y1], [z0, z1]].map(i16::from_le_bytes);
        Ok(D::sample(raw.map(|raw| f32::from(raw) * D::TABLE.unit)))
    }

    /// Checks that the die still has its configuration. A die whose supply dipped goes on
    /// answering, but with its default configuration, or asleep.
    ///
    /// # Errors
    /// [`Error::NotKept`] if not; [`Error::Bus`].
    pub async fn verify(&mut self) -> Result<(), Error<I2C::Error>> {
        for check in D::TABLE.readback {
            if self.read_register(check.register).await? & check.mask != check.value {
                return Err(Error::NotKept { register: check.register.into() });
            }
        }
        Ok(())
    }

    async fn await_sample<W: DelayNs>(&mut self, delay: &mut W) -> Result<(), Error<I2C::Error>> {
        for _ in 0..FIRST_SAMPLE_MS {
            if self.read_register(D::TABLE.status).await? & DATA_READY != 0 {
                return Ok(());
            }
            delay.delay_ms(1).await;
        }
        Err(Error::Timeout)
    }

    async fn read_register(&mut self, register: u8) -> Result<u8, Error<I2C::Error>> {
        let mut byte = [0];
        self.i2c.write_read(D::TABLE.address, &[register], &mut byte).await?;
        let [byte] = byte;
        Ok(byte)
    }

    async fn write(&mut self, register: u8, value: u8) -> Result<(), Error<I2C::Error>> {
        Ok(self.i2c.write(D::TABLE.address, &[register, value]).await?)
    }
}
