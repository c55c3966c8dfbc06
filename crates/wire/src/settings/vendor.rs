//! The vendor's configuration block, read so that what was set with its tools goes on to hold.
//!
//! From crazyflie-firmware, `configblockeeprom.c`, version 1:
//!
//! | byte | type | what | unit |
//! |---|---|---|---|
//! | 0 | `u32` | 0x43427830 | |
//! | 4 | `u8` | version, 1 | |
//! | 5 | `u8` | channel | |
//! | 6 | `u8` | data rate: 0, 1, 2 for 250 k, 1 M, 2 Mbit/s | |
//! | 7 | `f32` | trim in pitch | degrees |
//! | 11 | `f32` | trim in roll | degrees |
//! | 15 | `u8` | address, highest byte | |
//! | 16 | `u32` | address, the others | |
//! | 20 | `u8` | sum of all that comes before, modulo 256 | |

use core::fmt;

use units::Radians;

use super::Trim;
use crate::radio::{Address, Channel, Datarate};

/// Bytes of the block, at EEPROM address 0.
pub const VENDOR_LENGTH: usize = 21;

const MAGIC: u32 = 0x4342_7830;
const VERSION: u8 = 1;

/// What the vendor's tools set.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct VendorConfig {
    /// The radio's channel.
    pub channel: Channel,
    /// The radio's data rate.
    pub datarate: Datarate,
    /// The drone's address.
    pub address: Address,
    /// How the board is mounted.
    pub trim: Trim,
}

/// Why bytes are no configuration block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum VendorError {
    /// There are less than [`VENDOR_LENGTH`] bytes.
    Short,
    /// It does not begin like one.
    Magic,
    /// Of this version nothing is known.
    Version(u8),
    /// The sum is wrong.
    Checksum,
    /// A value is out of its range.
    Value,
}

impl fmt::Display for VendorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Short => write!(f, "a configuration block of less than {VENDOR_LENGTH} bytes"),
            Self::Magic => f.write_str("no configuration block"),
            Self::Version(version) => {
                write!(f, "a configuration block of the unknown version {version}")
            }
            Self::Checksum => f.write_str("a configuration block whose checksum is wrong"),
            Self::Value => f.write_str("a configuration block with a value out of its range"),
        }
    }
}

impl core::error::Error for VendorError {}

impl VendorConfig {
    /// The block at the beginning of `bytes`.
    ///
    /// # Errors
    /// [`VendorError`].
    pub fn decode(bytes: &[u8]) -> Result<Self, VendorError> {
        let (block, _) = bytes.split_first_chunk::<VENDOR_LENGTH>().ok_or(VendorError::Short)?;
        let [
            m0,
            m1,
            m2,
            m3,
            version,
            channel,
            datarate,
            p0,
            p1,
            p2,
            p3,
            r0,
            r1,
            r2,
            r3,
            high,
            a0,
            a1,
            a2,
            a3,
            checksum,
        ] = *block;
        if u32::from_le_bytes([m0, m1, m2, m3]) != MAGIC {
            return Err(VendorError::Magic);
        }
        if version != VERSION {
            return Err(VendorError::Version(version));
        }
        let sum = block.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
        if sum.wrapping_sub(checksum) != checksum {
            return Err(VendorError::Checksum);
        }
        let trim = Trim {
            pitch: Radians(f32::from_le_bytes([p0, p1, p2, p3]).to_radians()),
            roll: Radians(f32::from_le_bytes([r0, r1, r2, r3]).to_radians()),
        };
        Ok(Self {
            channel: Channel::new(channel).ok_or(VendorError::Value)?,
            datarate: Datarate::from_code(datarate).ok_or(VendorError::Value)?,
            address: Address::from_le_bytes([a0, a1, a2, a3, high]),
            trim: trim.check().ok_or(VendorError::Value)?,
        })
    }
}
