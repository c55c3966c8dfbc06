//! Driver of one VL53L1x, a time-of-flight ranger.
//!
//! The registers and their values are those of ST's Ultra Lite Driver (STSW-IMG009, user manual
//! UM2510).

mod config;
mod image;
mod reading;

pub use config::{Config, DistanceMode};
#[cfg(feature = "models")]
pub(crate) use reading::METRES_PER_STEP;
pub use reading::{CountRate, RangeStatus, Reading};

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::i2c::I2c;

use crate::Error;
use crate::error::is_absence;
use image::Image;

/// The I²C address that every VL53L1x has after its reset.
pub const DEFAULT_ADDRESS: u8 = 0x29;

/// The value of IDENTIFICATION__MODEL_ID and of the module type after it.
const MODEL: u16 = 0xEACC;

/// The registers that the driver uses.
mod register {
    pub(super) const I2C_ADDRESS: u16 = 0x0001;
    pub(super) const VHV_LOOP_BOUND: u16 = 0x0008;
    pub(super) const VHV_INIT: u16 = 0x000B;
    pub(super) const GPIO_STATUS: u16 = 0x0031;
    pub(super) const INTERRUPT_CLEAR: u16 = 0x0086;
    pub(super) const MODE_START: u16 = 0x0087;
    pub(super) const RESULT: u16 = 0x0089;
    pub(super) const OSCILLATOR: u16 = 0x00DE;
    pub(super) const FIRMWARE_STATUS: u16 = 0x00E5;
    pub(super) const MODEL_ID: u16 = 0x010F;
}
use register::*;

/// Milliseconds for which the driver waits for a sensor to boot, which takes 1.2 ms (data sheet,
/// t_BOOT).
const BOOT_TRIES: u32 = 20;
/// Milliseconds beyond the budget that the first measurement, which calibrates, may take: twice
/// what the vendor's firmware allows for the whole measurement.
const CALIBRATION_MS: u64 = 100;

/// Number of attempts without an answer after which an address counts as free.
const ATTEMPTS: u32 = 3;

/// The driver of one sensor.
#[derive(Debug)]
pub struct Vl53l1x<I2C> {
    i2c: I2C,
    address: u8,
}

impl<I2C: I2c> Vl53l1x<I2C> {
    /// A driver for the sensor that answers at `address`, to which nothing has been sent yet.
    pub const fn new(i2c: I2C, address: u8) -> Self {
        Self { i2c, address }
    }

    /// The I²C address that the driver uses.
    #[must_use]
    pub const fn address(&self) -> u8 {
        self.address
    }

    /// Waits for the sensor to boot, configures it and lets it calibrate itself with a first
    /// measurement. The sensor does not range afterwards: see [`start`](Self::start).
    ///
    /// # Errors
    /// [`Error::Unsupported`] for a configuration that the sensor cannot have;
    /// [`Error::WrongDevice`], [`Error::Timeout`], [`Error::Bus`].
    pub async fn init<D: DelayNs>(
        &mut self,
        delay: &mut D,
        config: &Config,
    ) -> Result<(), Error<I2C::Error>> {
        self.await_boot(delay).await?;
        self.identify().await?;
        self.configure(config).await?;
        self.begin_calibration().await?;
        let tries = config.budget.as_micros() / 1_000 + CALIBRATION_MS;
        for _ in 0..tries {
            if self.end_calibration().await? {
                return Ok(());
            }
            delay.delay_ms(1).await;
        }
        Err(Error::Timeout)
    }

    /// Gives the sensor another address, which it keeps until its next reset.
    ///
    /// # Errors
    /// [`Error::AddressTaken`] if a device answers at the new address already,
    /// [`Error::Unsupported`] if the address is reserved; [`Error::WrongDevice`], [`Error::Bus`].
    pub async fn set_address(&mut self, new: u8) -> Result<(), Error<I2C::Error>> {
        if !(0x08..=0x77).contains(&new) {
            return Err(Error::Unsupported);
        }
        if new == self.address {
            return self.identify().await;
        }
        if answers(&mut self.i2c, new).await? {
            return Err(Error::AddressTaken);
        }
        self.move_to(new).await?;
        self.identify().await
    }

    /// Starts continuous ranging.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub async fn start(&mut self) -> Result<(), Error<I2C::Error>> {
        self.write(INTERRUPT_CLEAR, &[0x01]).await?;
        self.write(MODE_START, &[0x40]).await
    }

    /// Stops ranging.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub async fn stop(&mut self) -> Result<(), Error<I2C::Error>> {
        self.write(MODE_START, &[0x00]).await
    }

    /// Reads the result of a measurement if there is a new one. Without one this takes a short
    /// read, with one 0.7 ms at 400 kHz.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub async fn poll(&mut self) -> Result<Option<Reading>, Error<I2C::Error>> {
        if !self.is_ready().await? {
            return Ok(None);
        }
        let mut result = [0; 17];
        self.read(RESULT, &mut result).await?;
        self.write(INTERRUPT_CLEAR, &[0x01]).await?;
        Ok(Some(Reading::from_registers(result)))
    }

    /// Checks that a VL53L1x answers at the driver's address.
    ///
    /// # Errors
    /// [`Error::WrongDevice`] if another device does; [`Error::Bus`].
    pub async fn identify(&mut self) -> Result<(), Error<I2C::Error>> {
        let mut model = [0; 2];
        self.read(MODEL_ID, &mut model).await?;
        match u16::from_be_bytes(model) {
            MODEL => Ok(()),
            found => Err(Error::WrongDevice { found }),
        }
    }

    /// Changes the address without a check whether the new one is free.
    pub(crate) async fn move_to(&mut self, new: u8) -> Result<(), Error<I2C::Error>> {
        self.write(I2C_ADDRESS, &[new]).await?;
        self.address = new;
        Ok(())
    }

    /// Whether the sensor's own firmware runs.
    pub(crate) async fn is_booted(&mut self) -> Result<bool, Error<I2C::Error>> {
        let mut status = [0];
        self.read(FIRMWARE_STATUS, &mut status).await?;
        let [status] = status;
        Ok(status & 0x01 != 0)
    }

    /// Stops ranging and writes the whole configuration.
    pub(crate) async fn configure(&mut self, config: &Config) -> Result<(), Error<I2C::Error>> {
        let mut oscillator = [0; 2];
        self.read(OSCILLATOR, &mut oscillator).await?;
        let oscillator = u16::from_be_bytes(oscillator);
        let image = Image::of(config, oscillator).ok_or(Error::Unsupported)?;
        self.stop().await?;
        for (register, bytes) in image.chunks() {
            self.write(register, bytes).await?;
        }
        Ok(())
    }

    /// Starts the first measurement, which finds the bias voltage of the light detectors from which
    /// later ones start.
    pub(crate) async fn begin_calibration(&mut self) -> Result<(), Error<I2C::Error>> {
        self.start().await
    }

    /// Whether the first measurement is over. If so, this stops the sensor and sets it up for the
    /// following measurements.
    pub(crate) async fn end_calibration(&mut self) -> Result<bool, Error<I2C::Error>> {
        if !self.is_ready().await? {
            return Ok(false);
        }
        self.write(INTERRUPT_CLEAR, &[0x01]).await?;
        self.stop().await?;
        // A two-bound search of the voltage that starts at the last one (`VL53L1X_SensorInit`).
        self.write(VHV_LOOP_BOUND, &[0x09]).await?;
        self.write(VHV_INIT, &[0x00]).await?;
        Ok(true)
    }

    async fn await_boot<D: DelayNs>(&mut self, delay: &mut D) -> Result<(), Error<I2C::Error>> {
        let mut outcome = Err(Error::Timeout);
        for _ in 0..BOOT_TRIES {
            match self.is_booted().await {
                Ok(true) => return Ok(()),
                Ok(false) => outcome = Err(Error::Timeout),
                // A sensor that was released from reset a moment ago does not acknowledge yet.
                Err(error) if is_absence(&error) => outcome = Err(error),
                Err(error) => return Err(error),
            }
            delay.delay_ms(1).await;
        }
        outcome
    }

    /// Whether the interrupt pin, which the configuration makes active high, signals a new result.
    async fn is_ready(&mut self) -> Result<bool, Error<I2C::Error>> {
        let mut status = [0];
        self.read(GPIO_STATUS, &mut status).await?;
        let [status] = status;
        Ok(status & 0x01 != 0)
    }

    async fn read(&mut self, register: u16, bytes: &mut [u8]) -> Result<(), Error<I2C::Error>> {
        Ok(self.i2c.write_read(self.address, &register.to_be_bytes(), bytes).await?)
    }

    /// Writes up to [`image::CHUNK`] bytes, beginning at `register`.
    async fn write(&mut self, register: u16, bytes: &[u8]) -> Result<(), Error<I2C::Error>> {
        let mut frame = [0; 2 + image::CHUNK];
        let filled = register.to_be_bytes().into_iter().chain(bytes.iter().copied());
        for (slot, byte) in frame.iter_mut().zip(filled) {
            *slot = byte;
        }
        let (used, _) = frame.split_at((2 + bytes.len()).min(2 + image::CHUNK));
        Ok(self.i2c.write(self.address, used).await?)
    }
}

/// Whether a device answers at `address`. The address counts as free only after repeated attempts,
/// because one lost transaction must not make it look free.
pub(crate) async fn answers<I2C: I2c>(
    i2c: &mut I2C,
    address: u8,
) -> Result<bool, Error<I2C::Error>> {
    for _ in 0..ATTEMPTS {
        match Vl53l1x::new(&mut *i2c, address).identify().await {
            Ok(()) | Err(Error::WrongDevice { .. }) => return Ok(true),
            Err(error) if is_absence(&error) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(false)
}
