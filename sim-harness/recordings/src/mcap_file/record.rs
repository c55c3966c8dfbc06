//! Cuts the bytes of an MCAP file into records, and those of a record into fields.

use super::Damage;

/// The kinds of records that are told apart.
pub(super) mod opcode {
    /// The header of the file.
    pub(in super::super) const HEADER: u8 = 0x01;
    /// The form of a channel's messages.
    pub(in super::super) const SCHEMA: u8 = 0x03;
    /// A channel: its number and its topic.
    pub(in super::super) const CHANNEL: u8 = 0x04;
    /// A message.
    pub(in super::super) const MESSAGE: u8 = 0x05;
    /// A chunk of channels and messages.
    pub(in super::super) const CHUNK: u8 = 0x06;
    /// Where the messages of a chunk stand.
    pub(in super::super) const MESSAGE_INDEX: u8 = 0x07;
    /// A file within the file.
    pub(in super::super) const ATTACHMENT: u8 = 0x09;
    /// Names and texts about the file.
    pub(in super::super) const METADATA: u8 = 0x0c;
    /// The last kind that the format defines.
    pub(in super::super) const LAST: u8 = DATA_END;
    /// The end of the messages.
    pub(in super::super) const DATA_END: u8 = 0x0f;
}

/// The length of a record's kind and length.
const HEAD: usize = 9;

/// One record.
pub(super) struct Record<'a> {
    pub(super) opcode: u8,
    /// The place of its first byte.
    pub(super) at: usize,
    pub(super) body: &'a [u8],
}

impl Record<'_> {
    /// The place of the first byte behind its kind and length.
    pub(super) const fn body_at(&self) -> usize {
        self.at + HEAD
    }
}

/// The records of a piece of a file, from a place on. After damage there are no more.
pub(super) struct Records<'a> {
    bytes: &'a [u8],
    next: usize,
}

impl<'a> Records<'a> {
    pub(super) const fn of(bytes: &'a [u8], from: usize) -> Self {
        Self { bytes, next: from }
    }

    fn record(&self) -> Result<Record<'a>, Damage> {
        let at = self.next;
        let rest = self.bytes.get(at..).unwrap_or_default();
        let Some((head, behind)) = rest.split_first_chunk::<HEAD>() else {
            return Err(Damage::new(at, "a record is cut short"));
        };
        let [opcode, length @ ..] = *head;
        let length = u64::from_le_bytes(length);
        let body = usize::try_from(length).ok().and_then(|length| behind.get(..length));
        let Some(body) = body else {
            let why = format!("a record of {length} bytes where {} are left", behind.len());
            return Err(Damage::new(at, why));
        };
        Ok(Record { opcode, at, body })
    }
}

impl<'a> Iterator for Records<'a> {
    type Item = Result<Record<'a>, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.next >= self.bytes.len() {
            return None;
        }
        let record = self.record();
        self.next = match &record {
            Ok(record) => record.body_at() + record.body.len(),
            Err(_) => self.bytes.len(),
        };
        Some(record)
    }
}

/// The fields of a record that are not read yet.
pub(super) struct Fields<'a> {
    rest: &'a [u8],
    /// The place of the record.
    at: usize,
}

impl<'a> Fields<'a> {
    pub(super) const fn of(record: &Record<'a>) -> Self {
        Self { rest: record.body, at: record.at }
    }

    /// The bytes behind the fields that were read.
    pub(super) const fn rest(&self) -> &'a [u8] {
        self.rest
    }

    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], Damage> {
        let Some((taken, rest)) = self.rest.split_at_checked(count) else {
            let why = format!("a field of {count} bytes where {} are left", self.rest.len());
            return Err(Damage::new(self.at, why));
        };
        self.rest = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Damage> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    pub(super) fn u16(&mut self) -> Result<u16, Damage> {
        self.array().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Result<u32, Damage> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Result<u64, Damage> {
        self.array().map(u64::from_le_bytes)
    }

    /// A text behind its length.
    pub(super) fn text(&mut self) -> Result<&'a str, Damage> {
        let length = usize::try_from(self.u32()?).unwrap_or(usize::MAX);
        let at = self.at;
        std::str::from_utf8(self.take(length)?)
            .map_err(|_| Damage::new(at, "a name that is no text in UTF-8"))
    }
}
