//! The ledger of the provisionings that a drone has sealed packets under: for each fleet the last
//! [`Issue`]. A page of keys that the ledger has, or that is older, is not taken over again, even
//! where the drone was in other fleets in between and its epochs under those keys are overwritten.
//!
//! A record takes 53 bytes:
//!
//! | byte | type | field |
//! |---|---|---|
//! | 0 | 4 bytes | `UCHL` |
//! | 4 | `u8` | version, 1; magic and CRC stay where they are in all versions |
//! | 5 | `u32` | sequence number: the newer of two records has the larger one |
//! | 9 | 8 × 5 bytes | the last fleets, the newest first: number of the fleet, last [`Issue`], or zeros |
//! | 49 | `u32` | CRC-32 of the bytes before |
//!
//! The ninth fleet takes the place of the one that the drone joined first. Of a fleet that is not
//! in the ledger the epochs begin at a random one ([`crate::epoch`]), so the page of a fleet that
//! was forgotten is unlikely to bring epochs back.

use crate::bytes::{Reader, sealed};
use crate::epoch::Issue;
use crate::keys::KeysRecord;
use crate::{Error, Record};

/// Bytes of a record.
pub const LENGTH: usize = 53;
/// The number of fleets that are remembered.
pub const FLEETS: usize = 8;

const MAGIC: [u8; 4] = *b"UCHL";
const VERSION: u8 = 1;
/// Bytes of an entry.
const ENTRY: usize = 5;

/// The last provisioning of each fleet that a drone has sealed packets under.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ledger {
    /// The number of the fleet, lowest byte first, and the issue; zeros in an entry without a
    /// fleet. The entry of the fleet that was joined last is the first.
    entries: [[u8; ENTRY]; FLEETS],
}

impl Ledger {
    /// The ledger of a drone that was never provisioned.
    pub const EMPTY: Self = Self { entries: [[0; ENTRY]; FLEETS] };

    /// The last issue of `fleet` that packets were sealed under.
    #[must_use]
    pub fn last_issue(&self, fleet: u32) -> Option<Issue> {
        let [a, b, c, d] = fleet.to_le_bytes();
        self.entries.iter().find_map(|entry| match *entry {
            [e, f, g, h, issue] if [e, f, g, h] == [a, b, c, d] => Issue::new(issue),
            _ => None,
        })
    }

    /// Whether packets may have been sealed under these keys or later ones of their fleet.
    #[must_use]
    pub fn has(&self, keys: &KeysRecord) -> bool {
        self.last_issue(keys.fleet) >= Some(keys.issue)
    }

    /// This ledger with these keys as the newest.
    #[must_use]
    pub fn with(&self, keys: &KeysRecord) -> Self {
        let [a, b, c, d] = keys.fleet.to_le_bytes();
        let others = self.entries.iter().filter(|[e, f, g, h, _]| [e, f, g, h] != [&a, &b, &c, &d]);
        let newest = [a, b, c, d, keys.issue.get()];
        let mut ledger = Self::EMPTY;
        for (place, entry) in ledger.entries.iter_mut().zip(core::iter::once(&newest).chain(others))
        {
            *place = *entry;
        }
        ledger
    }
}

impl Record for Ledger {
    type Bytes = [u8; LENGTH];
    const LENGTH: usize = LENGTH;
    const ADDRESSES: [u16; 2] = [0x2C0, 0x3C0];

    fn encode(&self, sequence: u32) -> Result<[u8; LENGTH], Error> {
        let entries = self.entries.as_flattened();
        Ok(sealed(&[&MAGIC, &[VERSION], &sequence.to_le_bytes(), entries]))
    }

    fn decode(bytes: &[u8]) -> Result<(Self, u32), Error> {
        let mut fields = Reader::of_record(bytes, LENGTH, MAGIC, VERSION)?;
        let sequence = fields.u32()?;
        let mut ledger = Self::EMPTY;
        for entry in &mut ledger.entries {
            *entry = fields.array()?;
        }
        Ok((ledger, sequence))
    }
}
