//! The errors of the drivers.

use core::fmt;

use embedded_hal::i2c;

/// The reason why a driver's call failed. `E` is the bus's own error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error<E> {
    /// The bus failed, or no device acknowledged.
    Bus(E),
    /// A device answered that is of another kind than the driver's.
    WrongDevice {
        /// The identification that was read.
        found: u16,
    },
    /// The device did not become ready within the driver's number of tries.
    Timeout,
    /// A register, or a byte of memory, does not read as it was written.
    NotKept {
        /// The address of the register or byte.
        register: u16,
    },
    /// The address that a device should get, or be found at, belongs to another device.
    AddressTaken,
    /// The data line reads as if no device drove it.
    Silent,
    /// The device cannot do what was requested.
    Unsupported,
}

impl<E> From<E> for Error<E> {
    fn from(error: E) -> Self {
        Self::Bus(error)
    }
}

impl<E: fmt::Debug> fmt::Display for Error<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bus(error) => write!(f, "the bus failed: {error:?}"),
            Self::WrongDevice { found } => write!(f, "another device answered: {found:#06x}"),
            Self::Timeout => f.write_str("the device did not become ready"),
            Self::NotKept { register } => write!(f, "register {register:#06x} was not kept"),
            Self::AddressTaken => f.write_str("the address belongs to another device"),
            Self::Silent => f.write_str("no device drives the data line"),
            Self::Unsupported => f.write_str("the device cannot do that"),
        }
    }
}

impl<E: fmt::Debug> core::error::Error for Error<E> {}

/// Whether a failure means only that no device acknowledged.
pub(crate) fn is_absence<E: i2c::Error>(error: &Error<E>) -> bool {
    match error {
        Error::Bus(bus) => matches!(bus.kind(), i2c::ErrorKind::NoAcknowledge(_)),
        _ => false,
    }
}
