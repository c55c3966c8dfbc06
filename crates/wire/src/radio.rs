//! The configuration of the radio: channel, data rate, address and power, each a type that holds
//! only values that the chip accepts; and the [times](timing) that packets take.

pub mod timing;

use units::Dbm;

/// A radio channel, one per MHz from 2400 MHz.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Channel(u8);

impl Channel {
    /// The vendor's default (crazyflie-firmware, `configblockeeprom.c`).
    pub const DEFAULT: Self = Self(80);
    /// 2525 MHz (crazyflie2-nrf-firmware, `docs/protocols/syslink.md`).
    const LAST: u8 = 125;

    /// Channel `number`, if there is one.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        if number <= Self::LAST { Some(Self(number)) } else { None }
    }

    /// The number, 0 to 125.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0
    }
}

/// Bits per second on the air.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Datarate {
    /// 250 kbit/s: reaches farthest, but a Crazyradio 2 does not speak it.
    Kbit250,
    /// 1 Mbit/s.
    Mbit1,
    /// 2 Mbit/s, the vendor's default.
    Mbit2,
}

impl Datarate {
    /// The byte that stands for the rate in syslink packets and in the EEPROM.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Kbit250 => 0,
            Self::Mbit1 => 1,
            Self::Mbit2 => 2,
        }
    }

    /// Time of two bits on the air in µs: a whole number at every rate.
    #[must_use]
    pub const fn two_bits_us(self) -> u8 {
        match self {
            Self::Kbit250 => 8,
            Self::Mbit1 => 2,
            Self::Mbit2 => 1,
        }
    }

    /// The rate that this byte stands for.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        match code {
            0 => Some(Self::Kbit250),
            1 => Some(Self::Mbit1),
            2 => Some(Self::Mbit2),
            _ => None,
        }
    }
}

/// The address of a drone, as it is written: `E7 E7 E7 E7 01` ends in 01.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Address(pub [u8; 5]);

impl Address {
    /// The vendor's default (crazyflie-firmware, `configblockeeprom.c`).
    pub const DEFAULT: Self = Self([0xE7; 5]);

    /// The address with its last byte first, as it is sent and stored.
    #[must_use]
    pub const fn to_le_bytes(self) -> [u8; 5] {
        let [a, b, c, d, e] = self.0;
        [e, d, c, b, a]
    }

    /// The address that is sent and stored as these bytes.
    #[must_use]
    pub const fn from_le_bytes([e, d, c, b, a]: [u8; 5]) -> Self {
        Self([a, b, c, d, e])
    }
}

/// Transmit power: the steps that the radio chip has, before its external amplifier
/// (crazyflie2-nrf-firmware, `esb.c`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TxPower {
    /// −30 dBm.
    Minus30,
    /// −20 dBm.
    Minus20,
    /// −16 dBm.
    Minus16,
    /// −12 dBm.
    Minus12,
    /// −8 dBm.
    Minus8,
    /// −4 dBm.
    Minus4,
    /// 0 dBm, which the chip starts with.
    Zero,
    /// +4 dBm.
    Plus4,
}

impl TxPower {
    /// Every step, the weakest first.
    pub const ALL: [Self; 8] = [
        Self::Minus30,
        Self::Minus20,
        Self::Minus16,
        Self::Minus12,
        Self::Minus8,
        Self::Minus4,
        Self::Zero,
        Self::Plus4,
    ];

    /// The power.
    #[must_use]
    pub fn dbm(self) -> Dbm {
        Dbm(f32::from(self.code()))
    }

    /// The power in whole dBm, which stands for it in syslink packets and in the EEPROM.
    #[must_use]
    pub const fn code(self) -> i8 {
        match self {
            Self::Minus30 => -30,
            Self::Minus20 => -20,
            Self::Minus16 => -16,
            Self::Minus12 => -12,
            Self::Minus8 => -8,
            Self::Minus4 => -4,
            Self::Zero => 0,
            Self::Plus4 => 4,
        }
    }

    /// The step with this power in whole dBm, if the chip has it.
    #[must_use]
    pub fn from_code(code: i8) -> Option<Self> {
        Self::ALL.into_iter().find(|step| step.code() == code)
    }
}
