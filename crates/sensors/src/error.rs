//! What can go wrong between a driver and its device.

use core::fmt;

use embedded_hal::i2c;

/// Why a driver's call failed. `E` is the bus's own error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error<E> {
    /// The bus failed, or nobody answered.
    Bus(E),
    /// Something answered, but it is not the device.
    WrongDevice {
        /// What it calls itself.
        found: u16,
    },
    /// The device did not become ready within the tries that it was given.
    Timeout,
    /// A register, or a byte of memory, reads otherwise than it was written.
    NotKept {
        /// Its address.
        register: u16,
    },
    /// The address that a device was to have, or to be found at, is another's.
    AddressTaken,
    /// The data line reads as if nobody drove it.
    Silent,
    /// The device cannot do what it was asked for.
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
            Self::Silent => f.write_str("nobody drives the data line"),
            Self::Unsupported => f.write_str("the device cannot do that"),
        }
    }
}

impl<E: fmt::Debug> core::error::Error for Error<E> {}

/// Whether a failure says no more than that nobody is there.
pub(crate) fn is_absence<E: i2c::Error>(error: &Error<E>) -> bool {
    match error {
        Error::Bus(bus) => matches!(bus.kind(), i2c::ErrorKind::NoAcknowledge(_)),
        _ => false,
    }
}
