//! Register-level models of the five devices, for tests and for emulators.
//!
//! A model is a device's registers and its clock: it is driven byte by byte, as the wire does it,
//! and knows nothing of a driver. What it measures and what is wrong with it can be set at any
//! time. [`Wires`] joins models to a bus with a clock of its own; [`ModelBus`], [`ModelSpi`] and
//! [`ModelDelay`] are the buses and the delay that a driver takes. An emulated peripheral drives
//! the traits [`I2cModel`] and [`SpiModel`] itself.
//!
//! ```
//! use core::cell::RefCell;
//! use sensors::models::{EepromModel, I2cModel, ModelBus, Wires};
//!
//! let memory = RefCell::new(EepromModel::new());
//! let devices: [&RefCell<dyn I2cModel>; 1] = [&memory];
//! let wires = Wires::new(&devices);
//! let driver = sensors::eeprom::Eeprom::new(ModelBus::new(&wires));
//! # let _ = driver;
//! ```

mod bmi088;
mod eeprom;
mod expander;
mod pmw3901;
mod spi;
mod vl53l1x;
mod wires;

pub use bmi088::Bmi088Model;
pub use eeprom::EepromModel;
pub use expander::ExpanderModel;
pub use pmw3901::Pmw3901Model;
pub use spi::{ModelSpi, SpiModel};
pub use vl53l1x::{Vl53l1xFault, Vl53l1xModel};
pub use wires::{ModelBus, ModelDelay, Wires};

/// A device on an I²C bus, as the wire sees it. Several may acknowledge the same address; their
/// bytes are then wired together, a zero wins.
pub trait I2cModel {
    /// A start, or a repeated start, with an address. Whether the device acknowledges; if it does
    /// it takes part in what follows up to the next start or stop.
    fn start(&mut self, address: u8, read: bool) -> bool;
    /// A byte from the controller. Whether the device acknowledges.
    fn write(&mut self, byte: u8) -> bool;
    /// A byte for the controller.
    fn read(&mut self) -> u8;
    /// A stop.
    fn stop(&mut self);
    /// Time passes.
    fn advance(&mut self, micros: u32);
}

/// What can be wrong with any device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fault {
    /// Nothing.
    #[default]
    None,
    /// It is not there, or has no supply: it acknowledges nothing, and begins anew when it is
    /// back.
    Absent,
    /// It acknowledges this many more bytes and addresses, and then nothing.
    NackAfter(u32),
    /// Of so many bytes and addresses it does not acknowledge the last, over and over.
    NackEvery {
        /// How many.
        every: u32,
        /// How many it has acknowledged since the last that it did not.
        done: u32,
    },
    /// Whatever is read from it is this byte.
    Stuck(u8),
}

impl Fault {
    /// Whether the device acknowledges now.
    const fn acknowledges(&mut self) -> bool {
        match self {
            Self::None | Self::Stuck(_) => true,
            Self::Absent | Self::NackAfter(0) => false,
            Self::NackAfter(left) => {
                *left -= 1;
                true
            }
            Self::NackEvery { every, done } => {
                let acknowledges = *done + 1 < *every;
                *done = if acknowledges { *done + 1 } else { 0 };
                acknowledges
            }
        }
    }

    /// What comes of a byte that the device sends.
    const fn read(self, byte: u8) -> u8 {
        match self {
            Self::Stuck(stuck) => stuck,
            _ => byte,
        }
    }
}

/// The byte of a register file, zero beyond its end.
fn peek(registers: &[u8], at: usize) -> u8 {
    registers.get(at).copied().unwrap_or(0)
}

/// Sets bytes of a register file, as far as it reaches.
fn poke(registers: &mut [u8], at: usize, bytes: &[u8]) {
    for (slot, byte) in registers.iter_mut().skip(at).zip(bytes) {
        *slot = *byte;
    }
}

/// A value in steps of `step`, within what 16 bits hold.
fn quantised(value: f32, step: f32) -> i16 {
    // Half a step up and then down is rounding, without a maths library; `as` saturates.
    let scaled = value / step;
    (scaled + 0.5_f32.copysign(scaled)) as i16
}
