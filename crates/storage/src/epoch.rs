//! The epoch of a drone: a number that rises with every boot, before the first packet of that boot
//! is sealed, so that no two packets ever have the same counter under the same key.
//!
//! A record takes 16 bytes, half a page of the memory:
//!
//! | byte | type | field |
//! |---|---|---|
//! | 0 | 4 bytes | `UCHE` |
//! | 4 | `u8` | version, 1; magic and CRC stay where they are in all versions |
//! | 5 | `u24` | the epoch, which is also the record's sequence number |
//! | 8 | `u32` | number of the fleet for whose keys the epoch counts |
//! | 12 | `u32` | CRC-32 of the bytes before |
//!
//! # Issues
//! Each provisioning of a fleet has a number of its own, the [`Issue`], and each issue has epochs
//! of its own, 65,793 of them. So epochs of a new issue are new under the fleet's keys, whatever a
//! drone has forgotten, and whichever drone had the node's number before. The first epoch under an
//! issue is a random one of the issue's first 32,768: a drone that has lost all memory of an issue
//! and is given its keys again does not begin where it began before.
//!
//! # Why no epoch comes twice
//! An epoch is *used* only once [`Next::kept`] has found its whole record read back from **both**
//! slots, and the [`Ledger`] has the keys. So of these keys
//! - the last used epoch was in both slots. A later write goes into one slot after the other, so
//!   whatever becomes of it, or of the reading of one slot, the other has that epoch or a later one;
//! - a slot that cannot be decoded beside one that can is a torn write, or one that was misread or
//!   has decayed: the next epoch then leaves one out, because firmware that wrote one slot alone
//!   may have used it;
//! - where the ledger has the keys, but no slot an epoch of their issue, the epochs used before are
//!   not known: [`EpochError::Lost`].
//!
//! A record that is whole, but of an unknown version, may hold a higher epoch:
//! [`EpochError::Version`].

use core::fmt;

use wire::p2p::Epoch;

use crate::bytes::{Reader, sealed};
use crate::keys::KeysRecord;
use crate::ledger::Ledger;
use crate::{Error, Record, Slot, Slots, Write};

/// Bytes of a record.
pub const LENGTH: usize = 16;

const MAGIC: [u8; 4] = *b"UCHE";
const VERSION: u8 = 1;

/// The record of an epoch: the epoch is its sequence number, the fleet its only value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EpochRecord {
    /// The number of the fleet for whose keys the epoch counts.
    pub fleet: u32,
}

impl Record for EpochRecord {
    type Bytes = [u8; LENGTH];
    const LENGTH: usize = LENGTH;
    const ADDRESSES: [u16; 2] = [0x280, 0x380];

    fn encode(&self, epoch: u32) -> Result<[u8; LENGTH], Error> {
        let [e0, e1, e2, 0] = epoch.to_le_bytes() else { return Err(Error::Value) };
        Ok(sealed(&[&MAGIC, &[VERSION, e0, e1, e2], &self.fleet.to_le_bytes()]))
    }

    fn decode(bytes: &[u8]) -> Result<(Self, u32), Error> {
        let mut fields = Reader::of_record(bytes, LENGTH, MAGIC, VERSION)?;
        let [e0, e1, e2] = fields.array()?;
        Ok((Self { fleet: fields.u32()? }, u32::from_le_bytes([e0, e1, e2, 0])))
    }
}

/// The number of a provisioning: no two provisionings of a fleet have the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Issue(u8);

impl Issue {
    /// The first issue of a fleet.
    pub const FIRST: Self = Self(1);
    /// The last issue of a fleet.
    pub const LAST: Self = Self(254);
    /// The number of epochs in one issue.
    pub const EPOCHS: u32 = 0x01_01_01;

    /// Issue `number`, if there is one: 1 to 254.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        if number >= Self::FIRST.0 && number <= Self::LAST.0 { Some(Self(number)) } else { None }
    }

    /// The issue's number.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }

    /// The issue after this one; `None` after the last.
    #[must_use]
    pub const fn next(self) -> Option<Self> {
        if self.0 < Self::LAST.0 { Some(Self(self.0 + 1)) } else { None }
    }

    /// The issue that an epoch belongs to; `None` for the few epochs that belong to none.
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

/// The epoch to begin, and the writes that record it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use = "an epoch that is not written must not be used"]
pub struct Next {
    /// The writes to carry out, one after the other: the first goes into the slot that does not
    /// hold the highest epoch.
    pub writes: [Write<EpochRecord>; 2],
    epoch: Epoch,
}

impl Next {
    /// The epoch, if its record is what has been read back from both slots, in the order of the
    /// writes. There is no other way to the epoch, since one that is not kept must not be used.
    #[must_use]
    pub fn kept(&self, read_back: [&[u8]; 2]) -> Option<Epoch> {
        let mut both = self.writes.iter().zip(read_back);
        both.all(|(write, bytes)| write.is_kept(bytes)).then_some(self.epoch)
    }
}

/// Why there is no next epoch. The drone stays silent until it is provisioned anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum EpochError {
    /// The keys have been used, but neither slot holds an epoch of theirs, so the epochs used before
    /// are not known.
    Lost,
    /// A slot holds a record of this version, which this code does not know.
    Version(u8),
    /// Epochs of a later issue than the keys' have been used.
    Older,
    /// All epochs of the issue have been used.
    Spent,
}

impl fmt::Display for EpochError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lost => f.write_str("no epoch can be read"),
            Self::Version(version) => write!(f, "an epoch of the unknown version {version}"),
            Self::Older => f.write_str("epochs of a later issue of the keys have been used"),
            Self::Spent => f.write_str("all epochs of this issue of the keys have been used"),
        }
    }
}

impl core::error::Error for EpochError {}

/// The content of a slot, judged by the present keys.
#[derive(Clone, Copy)]
enum Content {
    /// The slot was never written.
    Blank,
    /// The slot holds no record: a write was torn, or other data overwrote it.
    Garbage,
    /// This epoch was begun under keys of the same fleet.
    Epoch(u32),
    /// The slot holds an epoch of another fleet.
    Foreign,
}

/// The epoch of this boot under `keys`, after those that the two slots hold. `random` decides where
/// the epochs of an issue begin; it must come from a source of randomness.
///
/// # Errors
/// [`EpochError`]: the drone stays silent.
pub fn next(
    slots: &Slots<EpochRecord>,
    keys: &KeysRecord,
    ledger: &Ledger,
    random: u32,
) -> Result<Next, EpochError> {
    use Content::{Blank, Epoch as Is, Foreign, Garbage};
    let used = ledger.has(keys);
    let content = |slot| match content(slot, keys.fleet) {
        // No record can be an epoch of an issue under which nothing was sealed.
        Err(_) if !used => Ok(Garbage),
        content => content,
    };
    let contents = (content(slots.a)?, content(slots.b)?);
    let (highest, slot) = match contents {
        (Is(a), Is(b)) if b > a => (Some(b), Slot::A),
        (Is(a), _) => (Some(a), Slot::B),
        (_, Is(b)) => (Some(b), Slot::A),
        (Foreign, Blank | Garbage) => (None, Slot::B),
        (Blank | Garbage | Foreign, Blank | Garbage | Foreign) => (None, Slot::A),
    };
    let step = if matches!(contents, (Is(_), Is(_))) { 1 } else { 2 };
    let last_issue = highest.and_then(Issue::of).max(ledger.last_issue(keys.fleet));
    if last_issue > Some(keys.issue) {
        return Err(EpochError::Older);
    }
    let epoch = match highest {
        Some(highest) if Issue::of(highest) == Some(keys.issue) => highest + step,
        _ if used => return Err(EpochError::Lost),
        _ => keys.issue.first() + random % RANDOM_FIRSTS,
    };
    let is_of_the_issue = Issue::of(epoch) == Some(keys.issue);
    let epoch = Epoch::new(epoch).filter(|_| is_of_the_issue).ok_or(EpochError::Spent)?;
    let record = EpochRecord { fleet: keys.fleet };
    let write = |slot| Write::new(slot, &record, epoch.get()).map_err(|_| EpochError::Spent);
    Ok(Next { writes: [write(slot)?, write(slot.other())?], epoch })
}

/// The epochs of an issue that may be its first.
const RANDOM_FIRSTS: u32 = 1 << 15;

fn content(slot: Result<(EpochRecord, u32), Error>, fleet: u32) -> Result<Content, EpochError> {
    match slot {
        Ok((record, epoch)) if record.fleet == fleet => Ok(Content::Epoch(epoch)),
        Ok(_) => Ok(Content::Foreign),
        Err(Error::Blank) => Ok(Content::Blank),
        Err(Error::Version(version)) => Err(EpochError::Version(version)),
        Err(Error::Short | Error::Magic | Error::Checksum | Error::Value) => Ok(Content::Garbage),
    }
}
