//! The inertial sensor: a gyroscope and an accelerometer, two dies with an address each, that have
//! nothing in common but the package. Each has a driver of its own, so that one that dies does not
//! take the other with it.
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

/// I²C addresses of the two dies on the Crazyflie (crazyflie-firmware, `sensors_bmi088_i2c.c`).
pub const GYRO: u8 = 0x69;
/// The accelerometer's.
pub const ACCEL: u8 = 0x18;

/// The same of both dies (data sheet BST-BMI088-DS001).
const CHIP_ID: u8 = 0x00;
/// What a soft reset is asked for with.
const RESET: u8 = 0xB6;
/// "A new sample is there", in the status register of either.
const DATA_READY: u8 = 0x80;
/// The first sample must come within as many milliseconds.
const FIRST_SAMPLE_TRIES: u32 = 50;

/// The driver of one die: `Bmi088<_, Gyro>` or `Bmi088<_, Accel>`.
#[derive(Debug)]
pub struct Bmi088<I2C, D> {
    i2c: I2C,
    die: PhantomData<D>,
}

impl<I2C: I2c, D: Die> Bmi088<I2C, D> {
    /// A driver that has not spoken to the die yet.
    pub const fn new(i2c: I2C) -> Self {
        Self { i2c, die: PhantomData }
    }

    /// Resets and configures the die and waits for a sample. Takes about 35 ms for the gyroscope
    /// and 15 ms for the accelerometer.
    ///
    /// # Errors
    /// Any but [`Error::AddressTaken`], [`Error::Silent`] and [`Error::Unsupported`].
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

    /// Reads a sample: 6 bytes, 0.21 ms at 400 kHz.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub async fn read(&mut self) -> Result<D::Sample, Error<I2C::Error>> {
        // In a variable, because a constant lies in flash, which not every DMA reaches.
        let register = [D::TABLE.data];
        let mut bytes = [0; 6];
        self.i2c.write_read(D::TABLE.address, &register, &mut bytes).await?;
        let [x0, x1, y0, y1, z0, z1] = bytes;
        let raw = [[x0, x1], [y0, y1], [z0, z1]].map(i16::from_le_bytes);
        Ok(D::sample(raw.map(|raw| f32::from(raw) * D::TABLE.unit)))
    }

    /// Whether the die still has its configuration: one whose supply dipped comes back with
    /// another, or asleep, and goes on answering.
    ///
    /// # Errors
    /// [`Error::NotKept`] if not; [`Error::Bus`].
    pub async fn verify(&mut self) -> Result<(), Error<I2C::Error>> {
        for kept in D::TABLE.kept {
            if self.read_register(kept.register).await? & kept.mask != kept.value {
                return Err(Error::NotKept { register: kept.register.into() });
            }
        }
        Ok(())
    }

    async fn await_sample<W: DelayNs>(&mut self, delay: &mut W) -> Result<(), Error<I2C::Error>> {
        for _ in 0..FIRST_SAMPLE_TRIES {
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
