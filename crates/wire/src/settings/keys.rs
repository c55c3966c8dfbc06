//! What lets a drone speak: who it is, and its two keys. Made by `uchain keys provision`, brought
//! in by cable, kept in the EEPROM twice.
//!
//! | where | what |
//! |---|---|
//! | flash, [`PAGE_ADDRESS`] | the *provisioning page*: a record as the tool wrote it, sequence number 0; wiped once the EEPROM has it |
//! | EEPROM 0x240 | the record, [`Slot::A`] |
//! | EEPROM 0x340 | the record, [`Slot::B`] |
//!
//! A record takes 56 bytes:
//!
//! | byte | type | what |
//! |---|---|---|
//! | 0 | 4 bytes | `UCHK` |
//! | 4 | `u8` | version, 1 |
//! | 5 | `u32` | sequence number: the newer of two records has the larger one |
//! | 9 | `u8` | generation of the fleet's keys, from 1 |
//! | 10 | `u8` | who the drone is, 0 to 15 |
//! | 11 | `u8` | role: 0 head, 1 relay, 2 base |
//! | 12 | `u8` | bit 0: cfclient may fly the head through this drone; a base alone may have it |
//! | 13 | `u8` | the [`Issue`], 1 to 254 |
//! | 14 | 2 bytes | zero |
//! | 16 | `u32` | which fleet |
//! | 20 | 16 bytes | the group's key |
//! | 36 | 16 bytes | the drone's own key: a node's, or the base's |
//! | 52 | `u32` | CRC-32 of all that comes before |
//!
//! Reading and writing are those of the settings: [`newest`] of the two slots holds,
//! [`Write::after`] goes into the older one, and only what is read back counts.

use core::fmt;

use units::{NODES, NodeId};

use super::{Slot, crc32, epoch::Issue, newer, role_code, role_of_code};
use units::Role;

/// Bytes of a record. A multiple of a word, in which flash is written.
pub const LENGTH: usize = 56;

/// Where in the flash a provisioning page is looked for: the STM32F405's last sector, of which the
/// firmware takes nothing, so that a page can be written without touching it (ST RM0090, table 5).
pub const PAGE_ADDRESS: u32 = 0x080E_0000;

const MAGIC: [u8; 4] = *b"UCHK";
const VERSION: u8 = 1;
const MAY_FLY: u8 = 1;

/// Where in the EEPROM a slot of this record begins.
#[must_use]
pub const fn address(slot: Slot) -> u16 {
    match slot {
        Slot::A => 0x240,
        Slot::B => 0x340,
    }
}

/// A key's bytes. They are in no log: what prints it prints nothing of them.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Secret([u8; 16]);

impl Secret {
    /// These bytes, as a secret.
    #[must_use]
    pub const fn new(bytes: [u8; 16]) -> Self {
        Self(bytes)
    }

    /// The bytes, for whoever encrypts with them.
    #[must_use]
    pub const fn expose(&self) -> &[u8; 16] {
        &self.0
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secret(..)")
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Secret {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Secret(..)");
    }
}

/// What a drone was provisioned with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct KeysRecord {
    /// Which fleet it is of: a number drawn from the fleet's secret, which says nothing of it.
    pub fleet: u32,
    /// Which generation of the fleet's keys these are.
    pub generation: u8,
    /// As which of all provisionings of the fleet it was given out.
    pub issue: Issue,
    /// Who the drone is.
    pub node: NodeId,
    /// What it is.
    pub role: Role,
    /// Whether cfclient may fly the head through it.
    pub may_fly: bool,
    /// What every drone of the fleet has.
    pub group: Secret,
    /// What this drone alone has: the base's key for the base, its node's for any other.
    pub own: Secret,
}

impl KeysRecord {
    /// The record's bytes.
    ///
    /// # Errors
    /// [`Error::Value`] when it contradicts itself: what could not be read back is not written.
    pub fn encode(&self, sequence: u32) -> Result<[u8; LENGTH], Error> {
        self.check()?;
        let flags = if self.may_fly { MAY_FLY } else { 0 };
        let head = [VERSION].into_iter().chain(sequence.to_le_bytes()).chain([
            self.generation,
            self.node.0,
            role_code(self.role),
            flags,
            self.issue.get(),
            0,
            0,
        ]);
        let body = MAGIC
            .into_iter()
            .chain(head)
            .chain(self.fleet.to_le_bytes())
            .chain(*self.group.expose())
            .chain(*self.own.expose());
        let mut record = [0; LENGTH];
        for (place, byte) in record.iter_mut().zip(body) {
            *place = byte;
        }
        if let Some((body, crc)) = record.split_last_chunk_mut::<4>() {
            *crc = crc32(body).to_le_bytes();
        }
        Ok(record)
    }

    /// The record at the beginning of `bytes`, and its sequence number.
    ///
    /// # Errors
    /// [`Error`].
    pub fn decode(bytes: &[u8]) -> Result<(Self, u32), Error> {
        let (record, _) = bytes.split_first_chunk::<LENGTH>().ok_or(Error::Short)?;
        let (body, crc) = record.split_last_chunk::<4>().ok_or(Error::Short)?;
        let (magic, rest) = body.split_first_chunk::<4>().ok_or(Error::Short)?;
        let (head, rest) = rest.split_first_chunk::<12>().ok_or(Error::Short)?;
        let (fleet, rest) = rest.split_first_chunk::<4>().ok_or(Error::Short)?;
        let (group, own) = rest.split_first_chunk::<16>().ok_or(Error::Short)?;
        let own: &[u8; 16] = own.try_into().map_err(|_| Error::Short)?;
        let [version, s0, s1, s2, s3, generation, node, role, flags, issue, z0, z1] = *head;
        if *magic != MAGIC {
            return Err(Error::Magic);
        }
        // Before the CRC, which a later version may have elsewhere.
        if version != VERSION {
            return Err(Error::Version(version));
        }
        if u32::from_le_bytes(*crc) != crc32(body) {
            return Err(Error::Crc);
        }
        if flags & !MAY_FLY != 0 || [z0, z1] != [0, 0] {
            return Err(Error::Value);
        }
        let keys = Self {
            fleet: u32::from_le_bytes(*fleet),
            generation,
            issue: Issue::new(issue).ok_or(Error::Value)?,
            node: NodeId(node),
            role: role_of_code(role).ok_or(Error::Value)?,
            may_fly: flags & MAY_FLY != 0,
            group: Secret::new(*group),
            own: Secret::new(*own),
        };
        keys.check()?;
        Ok((keys, u32::from_le_bytes([s0, s1, s2, s3])))
    }

    /// Whether a page with these keys is to replace what a drone has. A page of the same fleet must
    /// be a later issue: one that was loaded twice must not set the epochs back. Another fleet's
    /// have nothing to do with those.
    #[must_use]
    pub fn supersedes(&self, current: Option<&Self>) -> bool {
        current.is_none_or(|current| self.fleet != current.fleet || self.issue > current.issue)
    }

    fn check(&self) -> Result<(), Error> {
        let known = usize::from(self.node.0) < NODES && self.generation != 0;
        if known && (!self.may_fly || self.role == Role::Base) { Ok(()) } else { Err(Error::Value) }
    }
}

/// Why bytes are no record, or keys cannot become one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error {
    /// There are less than [`LENGTH`] bytes.
    Short,
    /// It does not begin like a record: nothing was ever written here.
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
            Self::Short => write!(f, "keys of less than {LENGTH} bytes"),
            Self::Magic => f.write_str("no keys"),
            Self::Version(version) => write!(f, "keys of the unknown version {version}"),
            Self::Crc => f.write_str("keys whose checksum is wrong"),
            Self::Value => f.write_str("keys with a value out of its range"),
        }
    }
}

impl core::error::Error for Error {}

/// The keys that hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Chosen {
    /// The keys.
    pub keys: KeysRecord,
    /// Where they were read.
    pub slot: Slot,
    sequence: u32,
}

/// The newer of the records in the two slots; `None` when neither is one.
#[must_use]
pub fn newest(a: &[u8], b: &[u8]) -> Option<Chosen> {
    let (keys, sequence, slot) = newer(KeysRecord::decode(a).ok(), KeysRecord::decode(b).ok())?;
    Some(Chosen { keys, slot, sequence })
}

/// What to write, and where.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Write {
    /// The older slot.
    pub slot: Slot,
    /// The record, for the slot's beginning.
    pub record: [u8; LENGTH],
}

impl Write {
    /// The write that replaces `current`, as [`newest`] has just read it, by `keys`.
    ///
    /// # Errors
    /// [`Error::Value`], as [`KeysRecord::encode`].
    pub fn after(current: Option<&Chosen>, keys: &KeysRecord) -> Result<Self, Error> {
        let (slot, sequence) = match current {
            None => (Slot::A, 0),
            Some(current) => (current.slot.other(), current.sequence.wrapping_add(1)),
        };
        Ok(Self { slot, record: keys.encode(sequence)? })
    }
}

impl fmt::Debug for Write {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Write").field("slot", &self.slot).finish_non_exhaustive()
    }
}
