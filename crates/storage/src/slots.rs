//! The two slots of a record: which of them holds, and how it is replaced.

use core::fmt;

use crate::Error;

/// One of the two places of a record in the EEPROM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Slot {
    /// The slot at the lower address.
    A,
    /// The slot at the higher address.
    B,
}

impl Slot {
    /// The slot that this one is not.
    #[must_use]
    pub const fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }
}

/// A value that is kept in two slots of the EEPROM.
pub trait Record: Copy + PartialEq {
    /// The record's bytes: an array of [`Record::LENGTH`].
    type Bytes: AsRef<[u8]> + Copy + PartialEq;
    /// Bytes of a record.
    const LENGTH: usize;
    /// The addresses of slots A and B in the EEPROM.
    const ADDRESSES: [u16; 2];

    /// The record's bytes with this sequence number.
    ///
    /// # Errors
    /// [`Error::Value`] when the value could not be read back.
    fn encode(&self, sequence: u32) -> Result<Self::Bytes, Error>;

    /// The value and the sequence number of the record at the beginning of `bytes`.
    ///
    /// # Errors
    /// [`Error`].
    fn decode(bytes: &[u8]) -> Result<(Self, u32), Error>;

    /// The EEPROM address at which a slot begins.
    #[must_use]
    fn address(slot: Slot) -> u16 {
        let [a, b] = Self::ADDRESSES;
        match slot {
            Slot::A => a,
            Slot::B => b,
        }
    }
}

/// Successive readings of the same bytes. A reading counts only once the next one is the same,
/// because a bit that the bus has turned over makes a whole record look torn, or another.
#[derive(Clone, Copy, Debug)]
pub struct Readings<B> {
    last: Option<B>,
}

impl<B: PartialEq + Copy> Readings<B> {
    /// No reading yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { last: None }
    }

    /// Takes a reading and returns whether it is the same as the last one.
    pub fn confirm(&mut self, reading: B) -> bool {
        self.last.replace(reading) == Some(reading)
    }
}

impl<B: PartialEq + Copy> Default for Readings<B> {
    fn default() -> Self {
        Self::new()
    }
}

/// The contents of a record's two slots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slots<R> {
    pub(crate) a: Result<(R, u32), Error>,
    pub(crate) b: Result<(R, u32), Error>,
}

impl<R: Record> Slots<R> {
    /// Decodes the bytes that were read from the two slots.
    #[must_use]
    pub fn read(a: &[u8], b: &[u8]) -> Self {
        Self { a: R::decode(a), b: R::decode(b) }
    }

    /// The newer of the records, or `None` where neither slot holds one.
    #[must_use]
    pub fn newest(&self) -> Option<&R> {
        self.newest_in().map(|(record, _, _)| record)
    }

    /// The slot that holds the newer record.
    #[must_use]
    pub fn newest_slot(&self) -> Option<Slot> {
        self.newest_in().map(|(_, _, slot)| slot)
    }

    /// Whether both slots hold `record`.
    #[must_use]
    pub fn both_hold(&self, record: &R) -> bool {
        [&self.a, &self.b].iter().all(|slot| slot.as_ref().is_ok_and(|(held, _)| held == record))
    }

    /// The write that replaces the newer record by `record`: it goes into the other slot.
    ///
    /// # Errors
    /// [`Error::Value`] when `record` could not be read back.
    pub fn write(&self, record: &R) -> Result<Write<R>, Error> {
        let (slot, sequence) = match self.newest_in() {
            None => (Slot::A, 0),
            Some((_, sequence, slot)) => (slot.other(), sequence.wrapping_add(1)),
        };
        Write::new(slot, record, sequence)
    }

    fn newest_in(&self) -> Option<(&R, u32, Slot)> {
        match (&self.a, &self.b) {
            (Ok((_, old)), Ok((b, new))) if is_newer(*new, *old) => Some((b, *new, Slot::B)),
            (Ok((a, sequence)), _) => Some((a, *sequence, Slot::A)),
            (Err(_), Ok((b, sequence))) => Some((b, *sequence, Slot::B)),
            (Err(_), Err(_)) => None,
        }
    }
}

/// Whether sequence number `a` comes after `b` on the circle of 32-bit numbers.
const fn is_newer(a: u32, b: u32) -> bool {
    let ahead = a.wrapping_sub(b);
    ahead != 0 && ahead < 0x8000_0000
}

/// The bytes of a new record and the slot that they belong in. Its `Debug` shows no bytes, which
/// may be those of a key.
#[derive(Clone, Copy, PartialEq)]
#[must_use = "a record holds only once it has been written and read back"]
pub struct Write<R: Record> {
    slot: Slot,
    bytes: R::Bytes,
}

impl<R: Record> Write<R> {
    pub(crate) fn new(slot: Slot, record: &R, sequence: u32) -> Result<Self, Error> {
        Ok(Self { slot, bytes: record.encode(sequence)? })
    }

    /// The slot to be written, which does not hold the newer record.
    pub const fn slot(&self) -> Slot {
        self.slot
    }

    /// The EEPROM address to be written.
    #[must_use]
    pub fn address(&self) -> u16 {
        R::address(self.slot)
    }

    /// The bytes to be written.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.as_ref()
    }

    /// Whether the bytes that were read back from the slot are those that were written: the record
    /// is then whole, and newer than the one in the other slot.
    #[must_use]
    pub fn is_kept(&self, read_back: &[u8]) -> bool {
        read_back.starts_with(self.bytes())
    }
}

impl<R: Record> fmt::Debug for Write<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Write").field("slot", &self.slot).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sequence_numbers_go_round() {
        assert!(is_newer(1, 0) && !is_newer(0, 1) && !is_newer(7, 7));
        assert!(is_newer(0, u32::MAX));
    }
}
