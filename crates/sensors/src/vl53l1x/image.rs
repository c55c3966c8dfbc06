//! The image of the sensor's configuration registers, 91 bytes from 0x2D to 0x87: ST's default with
//! the values of a [`Config`] in their places.

use super::config::{Config, Registers};

/// The first register of the image.
pub(super) const FIRST: u16 = 0x002D;
const LENGTH: usize = 91;

/// Number of bytes that are written in one transaction, so that no other device on the bus waits
/// for longer than 0.8 ms.
pub(super) const CHUNK: usize = 32;

/// The table VL53L1X_DEFAULT_CONFIGURATION of ST's Ultra Lite Driver, with the pins at the deck's
/// voltage (0x2E, 0x2F). The interrupt is active high (0x30), a measurement is discarded above a σ
/// of 90 mm (0x64) and below a signal of 1 Mcps (0x66), and the whole field of view is used (0x7F).
/// Registers that the driver writes later are zero.
#[rustfmt::skip]
const DEFAULT: [u8; LENGTH] = [
    /* 0x2D */                                                       0x00, 0x01, 0x01,
    /* 0x30 */ 0x01, 0x02, 0x00, 0x02, 0x08, 0x00, 0x08, 0x10,
    /* 0x38 */ 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0xFF, 0x00,
    /* 0x40 */ 0x0F, 0x00, 0x00, 0x00, 0x00, 0x00, 0x20, 0x0B,
    /* 0x48 */ 0x00, 0x00, 0x02, 0x0A, 0x21, 0x00, 0x00, 0x05,
    /* 0x50 */ 0x00, 0x00, 0x00, 0x00, 0xC8, 0x00, 0x00, 0x38,
    /* 0x58 */ 0xFF, 0x01, 0x00, 0x08, 0x00, 0x00, 0x01, 0xCC,
    /* 0x60 */ 0x0F, 0x01, 0xF1, 0x0D, 0x01, 0x68, 0x00, 0x80,
    /* 0x68 */ 0x08, 0xB8, 0x00, 0x00, 0x00, 0x00, 0x0F, 0x89,
    /* 0x70 */ 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01,
    /* 0x78 */ 0x0F, 0x0D, 0x0E, 0x0E, 0x00, 0x00, 0x02, 0xC7,
    /* 0x80 */ 0xFF, 0x9B, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00,
];

/// The registers that depend on a [`Config`].
mod register {
    pub(super) const PHASECAL_TIMEOUT: u16 = 0x004B;
    pub(super) const TIMEOUT_A: u16 = 0x005E;
    pub(super) const VCSEL_PERIOD_A: u16 = 0x0060;
    pub(super) const TIMEOUT_B: u16 = 0x0061;
    pub(super) const VCSEL_PERIOD_B: u16 = 0x0063;
    pub(super) const VALID_PHASE_HIGH: u16 = 0x0069;
    pub(super) const PERIOD: u16 = 0x006C;
    pub(super) const WINDOW: u16 = 0x0078;
    pub(super) const INITIAL_PHASE: u16 = 0x007A;
}
use register::*;

/// The values of the configuration registers.
pub(super) struct Image([u8; LENGTH]);

impl Image {
    /// The image of `config`, or `None` if the sensor does not support it.
    pub(super) fn of(config: &Config, oscillator: u16) -> Option<Self> {
        let Registers { preset, timeout_a, timeout_b, period } = config.registers(oscillator)?;
        let mut image = Self(DEFAULT);
        image.set(PHASECAL_TIMEOUT, &[preset.phasecal_timeout]);
        image.set(TIMEOUT_A, &timeout_a.to_be_bytes());
        image.set(VCSEL_PERIOD_A, &[preset.vcsel_period_a]);
        image.set(TIMEOUT_B, &timeout_b.to_be_bytes());
        image.set(VCSEL_PERIOD_B, &[preset.vcsel_period_b]);
        image.set(VALID_PHASE_HIGH, &[preset.valid_phase_high]);
        image.set(PERIOD, &period.to_be_bytes());
        image.set(WINDOW, &preset.window.to_be_bytes());
        image.set(INITIAL_PHASE, &preset.initial_phase.to_be_bytes());
        Some(image)
    }

    /// The image in chunks, each with its first register.
    pub(super) fn chunks(&self) -> impl Iterator<Item = (u16, &[u8])> {
        (FIRST..).step_by(CHUNK).zip(self.0.chunks(CHUNK))
    }

    fn set(&mut self, register: u16, bytes: &[u8]) {
        let offset = usize::from(register.saturating_sub(FIRST));
        for (slot, byte) in self.0.iter_mut().skip(offset).zip(bytes) {
            *slot = *byte;
        }
    }
}
