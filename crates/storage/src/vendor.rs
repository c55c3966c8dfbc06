//! The configuration block of the vendor's firmware, read so that channel, data rate, address and
//! trims that were set with its tools keep their effect.
//!
//! From crazyflie-firmware, `configblockeeprom.c`, version 1:
//!
//! | byte | type | field | unit |
//! |---|---|---|---|
//! | 0 | `u32` | 0x43427830 | |
//! | 4 | `u8` | version, 1 | |
//! | 5 | `u8` | channel | |
//! | 6 | `u8` | data rate: 0, 1, 2 for 250 k, 1 M, 2 Mbit/s | |
//! | 7 | `f32` | trim in pitch | degrees |
//! | 11 | `f32` | trim in roll | degrees |
//! | 15 | `u8` | address, highest byte | |
//! | 16 | `u32` | address, the lower four bytes | |
//! | 20 | `u8` | sum of the bytes before, modulo 256 | |

use units::Radians;
use wire::radio::{Address, Channel, Datarate};

use crate::Error;
use crate::bytes::Reader;
use crate::settings::Trim;

/// Bytes of the block.
pub const LENGTH: usize = 21;

/// The EEPROM address of the block.
pub const ADDRESS: u16 = 0;

const MAGIC: u32 = 0x4342_7830;
const VERSION: u8 = 1;

/// The settings of the vendor's configuration block that this firmware uses.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct VendorConfig {
    /// The radio's channel.
    pub channel: Channel,
    /// The radio's data rate.
    pub datarate: Datarate,
    /// The drone's address.
    pub address: Address,
    /// The tilt of the board against the airframe.
    pub trim: Trim,
}

impl VendorConfig {
    /// The block at the beginning of `bytes`.
    ///
    /// # Errors
    /// [`Error`].
    pub fn decode(bytes: &[u8]) -> Result<Self, Error> {
        let (block, _) = bytes.split_first_chunk::<LENGTH>().ok_or(Error::Short)?;
        let mut fields = Reader::after_magic(block, MAGIC.to_le_bytes())?;
        let version = fields.u8()?;
        if version != VERSION {
            return Err(Error::Version(version));
        }
        let (sum, body) = block.split_last().ok_or(Error::Short)?;
        if body.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte)) != *sum {
            return Err(Error::Checksum);
        }
        let channel = Channel::new(fields.u8()?).ok_or(Error::Value)?;
        let datarate = Datarate::from_code(fields.u8()?).ok_or(Error::Value)?;
        let pitch = Radians(fields.f32()?.to_radians());
        let roll = Radians(fields.f32()?.to_radians());
        let highest = fields.u8()?;
        let [a0, a1, a2, a3] = fields.array()?;
        Ok(Self {
            channel,
            datarate,
            address: Address::from_le_bytes([a0, a1, a2, a3, highest]),
            trim: Trim { pitch, roll }.checked()?,
        })
    }
}
