//! One VL53L1x: a ranger that times light.
//!
//! Registers and values are those of ST's Ultra Lite Driver (STSW-IMG009, user manual UM2510).

mod config;
mod image;
mod reading;

pub use config::{Config, DistanceMode};
pub use reading::{CountRate, RangeStatus, Reading};

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::i2c::I2c;

use crate::Error;
use crate::error::is_absence;
use image::Image;

/// The address that every sensor of this kind has after its reset.
pub const DEFAULT_ADDRESS: u8 = 0x29;

/// IDENTIFICATION__MODEL_ID and the module type after it.
const MODEL: u16 = 0xEACC;

/// The register map, as far as the driver uses it.
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

/// A sensor is up 1.2 ms after its reset (data sheet, t_BOOT); it gets this many milliseconds.
const BOOT_TRIES: u32 = 20;
/// The first measurement, which calibrates, takes this much longer than the budget, in ms. (Twice
/// what the vendor's firmware allows for the whole of it.)
const CALIBRATION_MS: u64 = 100;

/// An address that stays silent so often is nobody's.
const SILENCES: u32 = 3;

/// The driver.
#[derive(Debug)]
pub struct Vl53l1x<I2C> {
    i2c: I2C,
    address: u8,
}

impl<I2C: I2c> Vl53l1x<I2C> {
    /// A driver for the sensor that answers at `address`; it has not been spoken to yet.
    pub const fn new(i2c: I2C, address: u8) -> Self {
        Self { i2c, address }
    }

    /// The address in use.
    #[must_use]
    pub const fn address(&self) -> u8 {
        self.address
    }

    /// Waits for the sensor, configures it and lets it calibrate itself with a first measurement.
    /// It does not range afterwards: see [`start`](Self::start).
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
    /// [`Error::AddressTaken`] if somebody answers there already, [`Error::Unsupported`] if the
    /// address is none for a device; [`Error::WrongDevice`], [`Error::Bus`].
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

    /// Begins to range, over and over.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub async fn start(&mut self) -> Result<(), Error<I2C::Error>> {
        self.write(INTERRUPT_CLEAR, &[0x01]).await?;
        self.write(MODE_START, &[0x40]).await
    }

    /// Ends ranging.
    ///
    /// # Errors
    /// [`Error::Bus`].
    pub async fn stop(&mut self) -> Result<(), Error<I2C::Error>> {
        self.write(MODE_START, &[0x00]).await
    }

    /// Takes the result of a measurement if there is a new one: one short read if not, 0.7 ms at
    /// 400 kHz if so.
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

    /// Whether a VL53L1x answers at this address.
    ///
    /// # Errors
    /// [`Error::WrongDevice`] if something else does; [`Error::Bus`].
    pub async fn identify(&mut self) -> Result<(), Error<I2C::Error>> {
        let mut model = [0; 2];
        self.read(MODEL_ID, &mut model).await?;
        match u16::from_be_bytes(model) {
            MODEL => Ok(()),
            found => Err(Error::WrongDevice { found }),
        }
    }

    /// Changes the address without looking whether that is wise.
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

    /// Writes the whole configuration. The sensor does not range while this happens.
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

    /// The first measurement finds the voltage of the light detectors; those after it start from
    /// there.
    pub(crate) async fn begin_calibration(&mut self) -> Result<(), Error<I2C::Error>> {
        self.start().await
    }

    /// Whether the first measurement is over; if so the sensor is set up for those that follow,
    /// and stopped.
    pub(crate) async fn end_calibration(&mut self) -> Result<bool, Error<I2C::Error>> {
        if !self.is_ready().await? {
            return Ok(false);
        }
        self.write(INTERRUPT_CLEAR, &[0x01]).await?;
        self.stop().await?;
        // Search the voltage within two bounds of the last, and begin there.
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
                // A sensor that has only just been let out of reset does not answer yet.
                Err(error) if is_absence(&error) => outcome = Err(error),
                Err(error) => return Err(error),
            }
            delay.delay_ms(1).await;
        }
        outcome
    }

    /// The image sets the interrupt to active high.
    async fn is_ready(&mut self) -> Result<bool, Error<I2C::Error>> {
        let mut status = [0];
        self.read(GPIO_STATUS, &mut status).await?;
        let [status] = status;
        Ok(status & 0x01 != 0)
    }

    async fn read(&mut self, register: u16, bytes: &mut [u8]) -> Result<(), Error<I2C::Error>> {
        Ok(self.i2c.write_read(self.address, &register.to_be_bytes(), bytes).await?)
    }

    /// Writes up to a chunk of the image.
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

/// Whether anybody answers at `address`. Silence is believed only when it is repeated: one lost
/// transaction must not make an address look free.
pub(crate) async fn answers<I2C: I2c>(
    i2c: &mut I2C,
    address: u8,
) -> Result<bool, Error<I2C::Error>> {
    for _ in 0..SILENCES {
        match Vl53l1x::new(&mut *i2c, address).identify().await {
            Ok(()) | Err(Error::WrongDevice { .. }) => return Ok(true),
            Err(error) if is_absence(&error) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(false)
}
