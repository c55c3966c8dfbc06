//! Register-level models of the five devices and of the barometer, for tests and for emulators.
//!
//! A model has a device's registers and its clock: it is driven byte by byte, as on the wire, and
//! does not depend on a driver. The quantity that it measures and its faults can be set at any
//! time. [`Wires`] connects models to a bus with a clock of its own; [`ModelBus`], [`ModelSpi`] and
//! [`ModelDelay`] are the buses and the delay that a driver takes. An emulated peripheral calls the
//! traits [`I2cModel`] and [`SpiModel`] itself.
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
mod bmp388;
mod eeprom;
mod expander;
mod pmw3901;
mod spi;
mod vl53l1x;
mod wires;

pub use bmi088::Bmi088Model;
pub use bmp388::Bmp388Model;
pub use eeprom::EepromModel;
pub use expander::ExpanderModel;
pub use pmw3901::Pmw3901Model;
pub use spi::{ModelSpi, SpiModel};
pub use vl53l1x::{Vl53l1xFault, Vl53l1xModel};
pub use wires::{ModelBus, ModelDelay, Wires};

/// A device on an I²C bus, driven byte by byte. Several may acknowledge the same address; the bus
/// then carries the logical AND of their bytes.
pub trait I2cModel {
    /// Processes a start, or a repeated start, with an address. Returns whether the device
    /// acknowledges; if so it takes part in the transfer up to the next start or stop.
    fn start(&mut self, address: u8, read: bool) -> bool;
    /// Takes a byte from the controller, and returns whether the device acknowledges it.
    fn write(&mut self, byte: u8) -> bool;
    /// Returns the next byte for the controller.
    fn read(&mut self) -> u8;
    /// Processes a stop.
    fn stop(&mut self);
    /// Lets `micros` µs pass.
    fn advance(&mut self, micros: u32);
}

/// A fault that any device can have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fault {
    /// The device works.
    #[default]
    None,
    /// The device is missing or has no supply: it acknowledges nothing, and starts from its reset
    /// state when it is back.
    Absent,
    /// The device acknowledges this many more bytes and addresses, and then nothing.
    NackAfter(u32),
    /// The device does not acknowledge every `every`-th byte or address.
    NackEvery {
        /// Number of bytes and addresses in a cycle.
        every: u32,
        /// Number of bytes and addresses acknowledged in the present cycle.
        done: u32,
    },
    /// Every byte that is read from the device is this one.
    Stuck(u8),
}

impl Fault {
    /// Whether the device acknowledges the next byte or address.
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

    /// The byte that the controller reads when the device sends `byte`.
    const fn read(self, byte: u8) -> u8 {
        match self {
            Self::Stuck(stuck) => stuck,
            _ => byte,
        }
    }
}

/// Reads a byte of a register file, or zero beyond its end.
fn peek(registers: &[u8], at: usize) -> u8 {
    registers.get(at).copied().unwrap_or(0)
}

/// Writes bytes to a register file, up to its end.
fn poke(registers: &mut [u8], at: usize, bytes: &[u8]) {
    for (slot, byte) in registers.iter_mut().skip(at).zip(bytes) {
        *slot = *byte;
    }
}

/// Converts a value to a number of steps of `step`, limited to 16 bits.
fn quantised(value: f32, step: f32) -> i16 {
    // Adding half a step before the truncation rounds without a maths library; `as` saturates.
    let scaled = value / step;
    (scaled + 0.5_f32.copysign(scaled)) as i16
}
