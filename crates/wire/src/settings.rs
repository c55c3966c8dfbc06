//! What a drone remembers while it is switched off: a record in the EEPROM, kept twice, so that a
//! power cut while one is written leaves the other.
//!
//! | EEPROM address | what |
//! |---|---|
//! | 0 | the vendor's configuration block, read by [`VendorConfig::decode`], never written |
//! | 0x200 | [`Slot::A`] |
//! | 0x240, 0x280 | [`keys`] and [`epoch`], slot A |
//! | 0x300 | [`Slot::B`] |
//! | 0x340, 0x380 | [`keys`] and [`epoch`], slot B |
//! | 0x400 | the vendor's persistent parameters, left alone |
//!
//! A record takes 44 bytes:
//!
//! | byte | type | what | unit |
//! |---|---|---|---|
//! | 0 | 4 bytes | `UCHN` | |
//! | 4 | `u8` | version, 2 | |
//! | 5 | `u32` | sequence number: the newer of two records has the larger one | |
//! | 9 | `u8` | who the drone is | |
//! | 10 | `u8` | role: 0 head, 1 relay, 2 base | |
//! | 11 | `u8` | channel | |
//! | 12 | `u8` | data rate: 0, 1, 2 for 250 k, 1 M, 2 Mbit/s | |
//! | 13 | 5 bytes | address, last byte first | |
//! | 18 | `i8` | transmit power | dBm |
//! | 19 | `u8` | zero | |
//! | 20 | `f32` | trim in pitch | rad |
//! | 24 | `f32` | trim in roll | rad |
//! | 28 | `f32` | flying height, or zero | m |
//! | 32 | `f32` | the link weaker than which a relay is launched, or zero | dBm |
//! | 36 | `f32` | the link weaker than which a drone backs up, or zero | dBm |
//! | 40 | `u32` | CRC-32 of all that comes before | |
//!
//! Version 1 had no limits: its CRC comes at 32. It is read, and never written.
//!
//! # Reading and writing
//! At boot the caller reads [`LENGTH`] bytes of each slot and asks [`newest`]. To change something
//! it asks [`Write::after`], writes that record into that slot, which is the older one, reads both
//! slots again and asks `newest` again: only what is then read back counts as remembered. However
//! much of a record is written when power goes, in whatever order, the other slot still holds the
//! settings from before, and the torn record is told from a whole one by its CRC: one in 2³² of
//! arbitrary contents would pass.

pub mod epoch;
pub mod keys;
mod vendor;

use core::fmt;

use units::{Dbm, Metres, NodeId, Radians, Role};

use crate::radio::{Address, Channel, Datarate, TxPower};

pub use vendor::{VENDOR_LENGTH, VendorConfig, VendorError};

/// Bytes of a record.
pub const LENGTH: usize = 44;

/// Of these, what versions 1 and 2 have in common.
const COMMON: usize = 32;
/// What version 2 has of its own.
const LIMITS: usize = LENGTH - 4 - COMMON;

const MAGIC: [u8; 4] = *b"UCHN";
const VERSION: u8 = 2;
/// The one without limits.
const VERSION_1: u8 = 1;

/// The largest trim that is one: the boards of a batch differ by a degree or two, and 20° is no
/// trim but another mounting.
const MAX_TRIM: Radians = Radians(0.35);

/// The largest flying height: the down-looking ranger does not see farther (VL53L1X data sheet,
/// maximum ranging distance).
const MAX_HEIGHT: Metres = Metres(4.0);

/// What a drone remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    /// Who it is.
    pub node: NodeId,
    /// What it is.
    pub role: Role,
    /// How its radio is set.
    pub radio: Radio,
    /// How its board is mounted.
    pub trim: Trim,
    /// At which height it flies; `None` for the agent's default.
    pub height: Option<Metres>,
    /// How weak links may become.
    pub limits: Limits,
}

/// How weak links may become; `None` for the agent's default. All drones of a chain should have the
/// same. That the two fit each other is the agent's to check.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    /// A last link weaker than this calls for the next relay.
    pub launch: Option<Dbm>,
    /// A back link weaker than this sends a drone back.
    pub retreat: Option<Dbm>,
}

impl Limits {
    /// The agent's own.
    pub const DEFAULT: Self = Self { launch: None, retreat: None };

    /// The weakest and the strongest that make sense: below, the nRF51 receives nothing (its
    /// product specification, sensitivity at 250 kbit/s); above, two drones are within a hand's
    /// breadth.
    pub const RANGE: [Dbm; 2] = [Dbm(-96.0), Dbm(-20.0)];

    fn encode(self) -> Result<[u8; LIMITS], Error> {
        let [l0, l1, l2, l3] = Self::put(self.launch)?;
        let [r0, r1, r2, r3] = Self::put(self.retreat)?;
        Ok([l0, l1, l2, l3, r0, r1, r2, r3])
    }

    fn decode([l0, l1, l2, l3, r0, r1, r2, r3]: [u8; LIMITS]) -> Result<Self, Error> {
        let (launch, retreat) = (Self::get([l0, l1, l2, l3])?, Self::get([r0, r1, r2, r3])?);
        Ok(Self { launch, retreat })
    }

    fn put(limit: Option<Dbm>) -> Result<[u8; 4], Error> {
        match limit {
            None => Ok([0; 4]),
            Some(limit) => Ok(Self::checked(limit)?.0.to_le_bytes()),
        }
    }

    fn get(bytes: [u8; 4]) -> Result<Option<Dbm>, Error> {
        match bytes {
            [0, 0, 0, 0] => Ok(None),
            bytes => Self::checked(Dbm(f32::from_le_bytes(bytes))).map(Some),
        }
    }

    fn checked(limit: Dbm) -> Result<Dbm, Error> {
        let [weakest, strongest] = Self::RANGE;
        if limit >= weakest && limit <= strongest { Ok(limit) } else { Err(Error::Value) }
    }
}

/// The byte that stands for `role` in the records.
pub(crate) const fn role_code(role: Role) -> u8 {
    match role {
        Role::Head => 0,
        Role::Relay => 1,
        Role::Base => 2,
    }
}

/// The role that a record's byte stands for.
pub(crate) const fn role_of_code(code: u8) -> Option<Role> {
    match code {
        0 => Some(Role::Head),
        1 => Some(Role::Relay),
        2 => Some(Role::Base),
        _ => None,
    }
}

/// How the radio is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Radio {
    /// Channel; all drones of a chain are on one.
    pub channel: Channel,
    /// Data rate; all drones of a chain speak at one.
    pub datarate: Datarate,
    /// This drone's own address, at which the vendor's tools find it.
    pub address: Address,
    /// Transmit power.
    pub power: TxPower,
}

/// By how much the board is tilted against the airframe, as the vendor's tools measure and sign it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Trim {
    /// In pitch.
    pub pitch: Radians,
    /// In roll.
    pub roll: Radians,
}

impl Trim {
    fn check(self) -> Option<Self> {
        let small = |angle: Radians| angle.abs() <= MAX_TRIM;
        (small(self.pitch) && small(self.roll)).then_some(self)
    }
}

impl Settings {
    /// What a drone is that has never been told: the first relay, with the vendor's defaults
    /// (crazyflie-firmware, `configblockeeprom.c`; power: crazyflie2-nrf-firmware, `esb.c`).
    pub const DEFAULT: Self = Self {
        node: NodeId(1),
        role: Role::Relay,
        radio: Radio {
            channel: Channel::DEFAULT,
            datarate: Datarate::Mbit2,
            address: Address::DEFAULT,
            power: TxPower::Zero,
        },
        trim: Trim { pitch: Radians::ZERO, roll: Radians::ZERO },
        height: None,
        limits: Limits::DEFAULT,
    };

    /// These settings, but with what the vendor's tools have set.
    #[must_use]
    pub const fn with_vendor(mut self, vendor: &VendorConfig) -> Self {
        self.radio.channel = vendor.channel;
        self.radio.datarate = vendor.datarate;
        self.radio.address = vendor.address;
        self.trim = vendor.trim;
        self
    }

    /// The record's bytes.
    ///
    /// # Errors
    /// [`Error::Value`] when a trim, the height or a limit is out of range: what could not be read back is
    /// not written.
    pub fn encode(&self, sequence: u32) -> Result<[u8; LENGTH], Error> {
        let trim = self.trim.check().ok_or(Error::Value)?;
        let height = match self.height {
            None => Metres::ZERO,
            Some(height) => checked_height(height)?,
        };
        let [m0, m1, m2, m3] = MAGIC;
        let [s0, s1, s2, s3] = sequence.to_le_bytes();
        let [a0, a1, a2, a3, a4] = self.radio.address.to_le_bytes();
        let [p0, p1, p2, p3] = trim.pitch.0.to_le_bytes();
        let [r0, r1, r2, r3] = trim.roll.0.to_le_bytes();
        let [h0, h1, h2, h3] = height.0.to_le_bytes();
        let role = role_code(self.role);
        let channel = self.radio.channel.number();
        let datarate = self.radio.datarate.code();
        let [power] = self.radio.power.code().to_le_bytes();
        let node = self.node.0;
        let common: [u8; COMMON] = [
            m0, m1, m2, m3, VERSION, s0, s1, s2, s3, node, role, channel, datarate, a0, a1, a2, a3,
            a4, power, 0, p0, p1, p2, p3, r0, r1, r2, r3, h0, h1, h2, h3,
        ];
        let mut record = [0; LENGTH];
        let limits = self.limits.encode()?;
        if let Some((body, crc)) = record.split_last_chunk_mut::<4>() {
            for (place, byte) in body.iter_mut().zip(common.into_iter().chain(limits)) {
                *place = byte;
            }
            *crc = crc32(body).to_le_bytes();
        }
        Ok(record)
    }

    /// The settings and the sequence number of a record at the beginning of `bytes`.
    ///
    /// # Errors
    /// [`Error`].
    pub fn decode(bytes: &[u8]) -> Result<(Self, u32), Error> {
        let (common, rest) = bytes.split_first_chunk::<COMMON>().ok_or(Error::Short)?;
        let [
            m0,
            m1,
            m2,
            m3,
            version,
            s0,
            s1,
            s2,
            s3,
            node,
            role,
            channel,
            datarate,
            a0,
            a1,
            a2,
            a3,
            a4,
            power,
            reserved,
            p0,
            p1,
            p2,
            p3,
            r0,
            r1,
            r2,
            r3,
            h0,
            h1,
            h2,
            h3,
        ] = *common;
        if [m0, m1, m2, m3] != MAGIC {
            return Err(Error::Magic);
        }
        // Before the CRC, which a later version may have elsewhere.
        let (limits, crc, length) = match version {
            VERSION_1 => {
                let (crc, _) = rest.split_first_chunk::<4>().ok_or(Error::Short)?;
                ([0; LIMITS], crc, COMMON)
            }
            VERSION => {
                let (limits, rest) = rest.split_first_chunk::<LIMITS>().ok_or(Error::Short)?;
                let (crc, _) = rest.split_first_chunk::<4>().ok_or(Error::Short)?;
                (*limits, crc, COMMON + LIMITS)
            }
            version => return Err(Error::Version(version)),
        };
        if u32::from_le_bytes(*crc) != crc32(bytes.get(..length).ok_or(Error::Short)?) {
            return Err(Error::Crc);
        }
        if reserved != 0 {
            return Err(Error::Value);
        }
        let trim = Trim {
            pitch: Radians(f32::from_le_bytes([p0, p1, p2, p3])),
            roll: Radians(f32::from_le_bytes([r0, r1, r2, r3])),
        };
        let settings = Self {
            node: NodeId(node),
            role: role_of_code(role).ok_or(Error::Value)?,
            radio: Radio {
                channel: Channel::new(channel).ok_or(Error::Value)?,
                datarate: Datarate::from_code(datarate).ok_or(Error::Value)?,
                address: Address::from_le_bytes([a0, a1, a2, a3, a4]),
                power: TxPower::from_code(i8::from_le_bytes([power])).ok_or(Error::Value)?,
            },
            trim: trim.check().ok_or(Error::Value)?,
            height: match [h0, h1, h2, h3] {
                [0, 0, 0, 0] => None,
                bytes => Some(checked_height(Metres(f32::from_le_bytes(bytes)))?),
            },
            limits: Limits::decode(limits)?,
        };
        Ok((settings, u32::from_le_bytes([s0, s1, s2, s3])))
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

fn checked_height(height: Metres) -> Result<Metres, Error> {
    if height > Metres::ZERO && height <= MAX_HEIGHT { Ok(height) } else { Err(Error::Value) }
}

/// Why bytes are no record, or settings cannot become one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error {
    /// There are less bytes than a record of its version has.
    Short,
    /// It does not begin like a record: the slot was never written.
    Magic,
    /// Of this version nothing is known.
    Version(u8),
    /// The CRC is wrong: it was not written to its end, or has been disturbed.
    Crc,
    /// A value is out of its range.
    Value,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Short => write!(f, "settings of less than {LENGTH} bytes"),
            Self::Magic => f.write_str("no settings"),
            Self::Version(version) => write!(f, "settings of the unknown version {version}"),
            Self::Crc => f.write_str("settings whose checksum is wrong"),
            Self::Value => f.write_str("settings with a value out of its range"),
        }
    }
}

impl core::error::Error for Error {}

/// One of the two places for a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Slot {
    /// The first.
    A,
    /// The second.
    B,
}

impl Slot {
    /// Where in the EEPROM it begins. Both begin a page, whatever the size of a page, so that no
    /// write touches the other.
    #[must_use]
    pub const fn address(self) -> u16 {
        match self {
            Self::A => 0x200,
            Self::B => 0x300,
        }
    }

    const fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }
}

/// The settings that hold.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Chosen {
    /// The settings.
    pub settings: Settings,
    /// Where they were read.
    pub slot: Slot,
    sequence: u32,
}

/// The newer of the records in the two slots; `None` when neither is one.
#[must_use]
pub fn newest(a: &[u8], b: &[u8]) -> Option<Chosen> {
    let (settings, sequence, slot) = newer(Settings::decode(a).ok(), Settings::decode(b).ok())?;
    Some(Chosen { settings, slot, sequence })
}

/// The newer of what two slots hold, each with its sequence number, and where it is.
fn newer<T>(a: Option<(T, u32)>, b: Option<(T, u32)>) -> Option<(T, u32, Slot)> {
    match (a, b) {
        (Some((_, old)), Some((b, new))) if is_newer(new, old) => Some((b, new, Slot::B)),
        (Some((a, sequence)), _) => Some((a, sequence, Slot::A)),
        (None, b) => b.map(|(b, sequence)| (b, sequence, Slot::B)),
    }
}

/// Whether `a` comes after `b` on the circle of 32-bit numbers.
const fn is_newer(a: u32, b: u32) -> bool {
    let ahead = a.wrapping_sub(b);
    ahead != 0 && ahead < 0x8000_0000
}

/// What to write, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Write {
    /// The older slot.
    pub slot: Slot,
    /// The record, for the slot's beginning.
    pub record: [u8; LENGTH],
}

impl Write {
    /// The write that replaces `current`, as [`newest`] has just read it, by `settings`.
    ///
    /// # Errors
    /// [`Error::Value`], as [`Settings::encode`].
    pub fn after(current: Option<&Chosen>, settings: &Settings) -> Result<Self, Error> {
        let (slot, sequence) = match current {
            None => (Slot::A, 0),
            Some(current) => (current.slot.other(), current.sequence.wrapping_add(1)),
        };
        Ok(Self { slot, record: settings.encode(sequence)? })
    }
}

/// CRC-32 as in Ethernet and zip (polynomial 0x04C11DB7, reflected). By bits: a record is written
/// once in a while, and a table would take a kilobyte.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg())
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_crc_is_that_of_the_check_string() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    }

    #[test]
    fn sequence_numbers_go_round() {
        assert!(is_newer(1, 0) && !is_newer(0, 1) && !is_newer(7, 7));
        assert!(is_newer(0, u32::MAX));
    }
}
