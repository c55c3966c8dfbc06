//! How often a drone has been switched on: a number that goes up before the first packet of each
//! boot is sealed, so that no two packets ever have the same counter under the same key.
//!
//! | EEPROM address | what |
//! |---|---|
//! | 0x280 | [`Slot::A`] |
//! | 0x380 | [`Slot::B`] |
//!
//! A record takes 16 bytes, half a page of the memory:
//!
//! | byte | type | what |
//! |---|---|---|
//! | 0 | 4 bytes | `UCHE` |
//! | 4 | `u8` | version, 1; magic and CRC stay where they are in all versions |
//! | 5 | `u24` | the epoch |
//! | 8 | `u32` | for which fleet's keys |
//! | 12 | `u32` | CRC-32 of all that comes before |
//!
//! # Issues
//! Each provisioning of a fleet has a number of its own, the [`Issue`], and each issue has epochs
//! of its own, 65,793 of them. So whatever a drone has forgotten, and whichever drone had the node's
//! number before it: epochs of a new issue are new under these keys. An issue's first epoch is the
//! issue's number in each of its three bytes, and not in the highest alone, because a packet names
//! epochs by the lower two: so these begin elsewhere in each issue, too.
//!
//! # Why no epoch comes twice
//! An epoch is *used* only once [`Next::kept`] has found its whole record read back. [`next`] writes
//! into the slot that does not hold the highest epoch. So of these keys
//! - the highest used epoch is in one of the slots, whole, whatever happened to writes after it: a
//!   torn record was never used, and no write touches the slot of the highest;
//! - a slot that cannot be read beside one that can is such a torn write;
//! - a blank slot beside one that cannot be read is the very first write, torn;
//! - two slots that cannot be read come of no power cut. They may have held anything: there is an
//!   epoch only under an issue that has just come, and [`Error::Lost`] under one that was in use.
//!
//! A record that is whole, but of an unknown version, may hold a higher epoch: [`Error::Version`].

use core::fmt;

use super::{Slot, crc32, keys::KeysRecord};
use crate::p2p::Epoch;

/// Bytes of a record.
pub const LENGTH: usize = 16;

const MAGIC: [u8; 4] = *b"UCHE";
const VERSION: u8 = 1;
/// What an EEPROM holds that was never written.
const BLANK: [u8; LENGTH] = [0xFF; LENGTH];

/// Where in the EEPROM a slot of this record begins.
#[must_use]
pub const fn address(slot: Slot) -> u16 {
    match slot {
        Slot::A => 0x280,
        Slot::B => 0x380,
    }
}

/// The number of a provisioning: no two of a fleet have the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Issue(u8);

impl Issue {
    /// A fleet's first.
    pub const FIRST: Self = Self(1);
    /// A fleet's last.
    pub const LAST: Self = Self(254);
    /// How many epochs there are in one.
    pub const EPOCHS: u32 = 0x01_01_01;

    /// Issue `number`, if there is one: 1 to 254.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        if number >= Self::FIRST.0 && number <= Self::LAST.0 { Some(Self(number)) } else { None }
    }

    /// Its number.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }

    /// The one after it, if there is one.
    #[must_use]
    pub const fn next(self) -> Option<Self> {
        if self.0 < Self::LAST.0 { Some(Self(self.0 + 1)) } else { None }
    }

    /// The issue that an epoch belongs to; `None` for the few that no issue has.
    const fn of(epoch: u32) -> Option<Self> {
        let number = epoch / Self::EPOCHS;
        if number <= Self::LAST.0 as u32 { Self::new(number as u8) } else { None }
    }

    const fn first(self) -> u32 {
        Self::EPOCHS * self.0 as u32
    }
}

impl fmt::Display for Issue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Since when the drone has its present keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Provisioned {
    /// They came in this very boot, and superseded what was there
    /// ([`KeysRecord::supersedes`]): no epoch of their issue was ever used.
    Now,
    /// They came before: epochs of their issue have been used.
    Before,
}

/// The epoch to begin, and where to write that it has begun.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use = "an epoch that is not written is none"]
pub struct Next {
    /// The slot that does not hold the highest epoch.
    pub slot: Slot,
    /// The record, for the slot's beginning.
    pub record: [u8; LENGTH],
    epoch: Epoch,
}

impl Next {
    /// The epoch, if the record is what has been read back from the slot: the only way to it, since
    /// an epoch that is not kept must not be used.
    #[must_use]
    pub fn kept(&self, read_back: &[u8]) -> Option<Epoch> {
        read_back.starts_with(&self.record).then_some(self.epoch)
    }
}

/// Why there is no next epoch. The drone has to be provisioned anew; until then it is silent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error {
    /// Neither slot can be read, so that it is not known which epochs have been used.
    Lost,
    /// Of a record of this version nothing is known.
    Version(u8),
    /// Epochs of a later issue than the keys' have been used.
    Older,
    /// All epochs of the issue have been used.
    Spent,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lost => f.write_str("no epoch can be read"),
            Self::Version(version) => write!(f, "an epoch of the unknown version {version}"),
            Self::Older => f.write_str("epochs of a later issue of the keys have been used"),
            Self::Spent => f.write_str("all epochs of this issue of the keys have been used"),
        }
    }
}

impl core::error::Error for Error {}

/// What a slot holds.
#[derive(Clone, Copy)]
enum Content {
    /// Nothing was ever written.
    Blank,
    /// No record: torn, or something else's.
    Garbage,
    /// An epoch of these keys' fleet.
    Epoch(u32),
    /// An epoch of another fleet.
    Foreign,
}

/// The epoch of this boot under `keys`, by what the two slots hold.
///
/// # Errors
/// [`Error`]: the drone stays silent.
pub fn next(
    a: &[u8],
    b: &[u8],
    keys: &KeysRecord,
    provisioned: Provisioned,
) -> Result<Next, Error> {
    use Content::{Blank, Epoch as Is, Foreign, Garbage};
    let content = |bytes| match read(bytes, keys.fleet) {
        // Whatever it is, it is no epoch of an issue that has just come.
        Err(_) if provisioned == Provisioned::Now => Ok(Garbage),
        content => content,
    };
    let (highest, slot) = match (content(a)?, content(b)?) {
        (Is(a), Is(b)) if b > a => (Some(b), Slot::A),
        (Is(a), _) => (Some(a), Slot::B),
        (_, Is(b)) => (Some(b), Slot::A),
        (Garbage, Garbage) if provisioned == Provisioned::Before => return Err(Error::Lost),
        (Foreign, Blank | Garbage) => (None, Slot::B),
        (Blank | Garbage | Foreign, Blank | Garbage | Foreign) => (None, Slot::A),
    };
    let epoch = after(highest, keys.issue)?;
    Ok(Next { slot, record: encode(epoch, keys.fleet), epoch })
}

/// The first epoch of the issue that is higher than the highest used one.
fn after(highest: Option<u32>, issue: Issue) -> Result<Epoch, Error> {
    let epoch = match highest {
        Some(highest) if Issue::of(highest) > Some(issue) => return Err(Error::Older),
        Some(highest) => highest.saturating_add(1).max(issue.first()),
        None => issue.first(),
    };
    if Issue::of(epoch) != Some(issue) {
        return Err(Error::Spent);
    }
    Epoch::new(epoch).ok_or(Error::Spent)
}

fn encode(epoch: Epoch, fleet: u32) -> [u8; LENGTH] {
    let [e0, e1, e2, _] = epoch.get().to_le_bytes();
    let [f0, f1, f2, f3] = fleet.to_le_bytes();
    let [m0, m1, m2, m3] = MAGIC;
    let body = [m0, m1, m2, m3, VERSION, e0, e1, e2, f0, f1, f2, f3];
    let mut record = [0; LENGTH];
    for (place, byte) in record.iter_mut().zip(body.into_iter().chain(crc32(&body).to_le_bytes())) {
        *place = byte;
    }
    record
}

fn read(bytes: &[u8], fleet: u32) -> Result<Content, Error> {
    let Some((record, _)) = bytes.split_first_chunk::<LENGTH>() else {
        return Ok(Content::Garbage);
    };
    if *record == BLANK {
        return Ok(Content::Blank);
    }
    let [m0, m1, m2, m3, version, e0, e1, e2, f0, f1, f2, f3, crc @ ..] = *record;
    let body = [m0, m1, m2, m3, version, e0, e1, e2, f0, f1, f2, f3];
    if [m0, m1, m2, m3] != MAGIC || u32::from_le_bytes(crc) != crc32(&body) {
        return Ok(Content::Garbage);
    }
    if version != VERSION {
        return Err(Error::Version(version));
    }
    if u32::from_le_bytes([f0, f1, f2, f3]) != fleet {
        return Ok(Content::Foreign);
    }
    Ok(Content::Epoch(u32::from_le_bytes([e0, e1, e2, 0])))
}
