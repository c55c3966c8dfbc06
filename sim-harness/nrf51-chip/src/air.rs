//! Packets on the air, as the radio sends and hears them.

use crate::{Cycles, MICROSECOND};

/// A data rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rate {
    /// 250 kbit/s.
    K250,
    /// 1 Mbit/s.
    M1,
    /// 2 Mbit/s.
    M2,
}

impl Rate {
    /// The duration of a bit.
    #[must_use]
    pub const fn bit(self) -> Cycles {
        match self {
            Self::K250 => 4 * MICROSECOND,
            Self::M1 => MICROSECOND,
            Self::M2 => MICROSECOND / 2,
        }
    }
}

/// A packet of Nordic's Enhanced ShockBurst.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OnAir {
    /// The channel: 2400 MHz plus so many MHz.
    pub channel: u8,
    /// The data rate.
    pub rate: Rate,
    /// The address, in the order on the air.
    pub address: [u8; 5],
    /// The power at which it is sent, in dBm.
    pub power: i8,
    /// The three bits behind the length: the packet's number and "no acknowledgement".
    pub s1: u8,
    /// The payload.
    pub payload: Vec<u8>,
    /// The number of bits besides the payload.
    pub overhead: u32,
}

/// The bits of a packet besides its payload in the format of the Crazyflie's radios: a preamble of 8,
/// an address of 40, a length of 6, 3 of the packet's number, a CRC of 16 (nRF24L01+ Product
/// Specification, 7.3).
pub const OVERHEAD: u32 = 8 + 40 + 6 + 3 + 16;

impl OnAir {
    /// How long it is on the air.
    #[must_use]
    pub fn duration(&self) -> Cycles {
        (Cycles::from(self.overhead) + self.payload.len() as Cycles * 8) * self.rate.bit()
    }
}

/// A packet that the chip has sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Transmission {
    /// When its first bit is on the air, in cycles since the chip's start.
    pub start: Cycles,
    /// When its last bit is over, or when the program cut it off.
    pub end: Cycles,
    /// Whether the program cut it off.
    pub is_cut: bool,
    /// The packet.
    pub packet: OnAir,
}

/// A packet for which the chip's transmitter ramps up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Upcoming {
    /// When its first bit will be on the air, in cycles since the chip's start.
    pub start: Cycles,
    /// The packet, as it is in memory when the ramp-up begins.
    pub packet: OnAir,
}

/// A packet that reaches the chip's antenna.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Incoming {
    /// When its first bit is on the air, in cycles since the chip's start.
    pub start: Cycles,
    /// When its last bit is over.
    pub end: Cycles,
    /// The packet.
    pub packet: OnAir,
    /// The received power in -dBm.
    pub rssi: u8,
    /// Whether its CRC is right.
    pub is_intact: bool,
}
