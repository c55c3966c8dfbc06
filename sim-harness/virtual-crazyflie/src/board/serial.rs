//! The serial line between the flight processor and the radio chip: its bits, and noise in both directions.

use super::noise::{Fate, Noise, Shares};
use crate::soc::UartByte;

/// A bit at 1 Mbaud, ns.
pub(super) const BIT: u32 = 1_000;
/// A receiver follows a sender whose bits are longer or shorter by so many ns: half a bit in ten.
const TOLERANCE: u32 = BIT / 20;

/// A byte from the flight processor, as the chip's receiver has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Received {
    /// The byte is there, and may be a wrong one.
    Byte(u8),
    /// The byte has no stop bit.
    Broken,
    /// The byte is lost.
    Nothing,
}

/// The line.
#[derive(Clone, Debug)]
pub(super) struct SerialLine {
    to_chip: Noise,
    to_processor: Noise,
}

impl SerialLine {
    /// A line without noise.
    pub(super) const fn clear() -> Self {
        Self { to_chip: Noise::none(), to_processor: Noise::none() }
    }

    /// Lets bytes suffer from now on, in both directions.
    pub(super) const fn disturb(&mut self, shares: Shares, seed: u64) {
        *self = Self { to_chip: Noise::new(shares, seed), to_processor: Noise::new(shares, !seed) };
    }

    /// Passes a byte of the flight processor's, whose bits last so many ns.
    pub(super) fn receive(&mut self, byte: u8, bit: u32) -> Received {
        let fits = BIT.abs_diff(bit) <= TOLERANCE;
        match self.to_chip.pass(byte) {
            Fate::Intact(byte) | Fate::Noisy(byte) if fits => Received::Byte(byte),
            Fate::Lost => Received::Nothing,
            _ => Received::Broken,
        }
    }

    /// Passes a byte for the flight processor; `None` where it is lost.
    pub(super) fn send(&mut self, byte: UartByte) -> Option<UartByte> {
        match self.to_processor.pass(byte.data) {
            Fate::Intact(data) => Some(UartByte { data, ..byte }),
            Fate::Noisy(data) => Some(UartByte { data, noise: true, ..byte }),
            Fate::Broken(data) => Some(UartByte { data, broken: true, ..byte }),
            Fate::Lost => None,
        }
    }
}
