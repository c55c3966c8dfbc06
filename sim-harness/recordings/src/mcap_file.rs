//! Reads the messages of an MCAP file, sound or damaged, as far as they can be told.
//!
//! The file's own lengths are believed only as far as there are bytes: nothing is set aside by a
//! length that the file claims, and no sum of lengths can overflow. The readers of the crate `mcap`
//! are made for sound files: version 0.26 panics on some that are not, and sets memory aside by
//! claimed lengths. Chunks are unpacked from zstd and lz4.
//!
//! Reading ends where the file is damaged. A chunk whose bytes do not match its checksum but whose
//! records are whole is read, and counted.

mod chunk;
mod record;

use std::collections::BTreeMap;
use std::fmt;

use crc32fast::hash;

use chunk::Chunk;
use record::{Fields, Record, Records, opcode};

/// The first bytes of an MCAP file.
pub const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// The most bytes that the chunks of a file may hold when unpacked, so that a small file cannot fill
/// the memory: as many as a file may have.
const MOST_UNPACKED: usize = super::formats::LARGEST as usize;

/// One message of a file.
pub struct Message<'a> {
    /// The topic.
    pub topic: &'a str,
    /// The time at which it was recorded, ns.
    pub time_ns: u64,
    /// The bytes.
    pub data: &'a [u8],
}

/// The place at which a file is damaged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// The number of bytes before it.
    at: usize,
    why: String,
}

impl Damage {
    fn new(at: usize, why: impl Into<String>) -> Self {
        Self { at, why: why.into() }
    }
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "is damaged at byte {} ({})", self.at, self.why)
    }
}

/// What was found in a file beside its messages.
#[derive(Debug, Default)]
pub struct Findings {
    /// The number of messages that were read.
    pub messages: usize,
    /// The place at which reading ended, unless that is the end of the data.
    pub damage: Option<Damage>,
    /// The parts of the file that do not match their checksums.
    mismatches: Mismatches,
    /// The number of records of kinds that are not known.
    unknown: usize,
}

/// The parts of a file that do not match their checksums.
#[derive(Debug, Default)]
struct Mismatches {
    chunks: usize,
    /// The place of the first of these chunks.
    first_at: usize,
    /// The number of messages in them.
    messages: usize,
    /// Whether the data as a whole do not match theirs.
    is_whole: bool,
}

impl Findings {
    /// The lines that tell of damage, for a file of which something was read.
    pub fn remarks(&self) -> Vec<String> {
        let Mismatches { chunks, first_at, messages, is_whole } = self.mismatches;
        let mut remarks = Vec::new();
        if chunks > 0 {
            remarks.push(format!(
                "{chunks} of its chunks, the first at byte {first_at}, did not match their \
                 checksums: some of their {messages} messages may be wrong"
            ));
        } else if is_whole && self.damage.is_none() {
            remarks.push(
                "its data do not match their checksum: some of its messages may be wrong".into(),
            );
        }
        if self.unknown > 0 {
            remarks.push(format!("{} of its records are of unknown kinds", self.unknown));
        }
        if let Some(damage) = &self.damage {
            remarks.push(format!("it {damage}: what stands before that was read"));
        }
        remarks
    }
}

/// Gives every message of a file to `visit`, in the order in which they stand, until the end of the
/// data or to where the file is damaged.
pub fn read(bytes: &[u8], visit: &mut dyn FnMut(&Message<'_>)) -> Findings {
    read_within(bytes, MOST_UNPACKED, visit)
}

/// The same, where the chunks may hold so many bytes when unpacked.
fn read_within(
    bytes: &[u8],
    most_unpacked: usize,
    visit: &mut dyn FnMut(&Message<'_>),
) -> Findings {
    let mut reader =
        Reader { topics: BTreeMap::new(), span_ns: None, findings: Findings::default(), visit };
    reader.findings.damage = reader.file(bytes, most_unpacked).err();
    reader.findings
}

struct Reader<'v> {
    /// The topic of each channel.
    topics: BTreeMap<u16, String>,
    /// The times between which messages must lie, in a chunk that does not match its checksum.
    span_ns: Option<(u64, u64)>,
    findings: Findings,
    visit: &'v mut dyn FnMut(&Message<'_>),
}

impl Reader<'_> {
    fn file(&mut self, bytes: &[u8], most_unpacked: usize) -> Result<(), Damage> {
        if !bytes.starts_with(MAGIC) {
            return Err(Damage::new(0, "it does not begin as an MCAP file does"));
        }
        let mut room = most_unpacked;
        for record in Records::of(bytes, MAGIC.len()) {
            let record = record?;
            match record.opcode {
                opcode::CHUNK => self.chunk(bytes, &record, &mut room)?,
                opcode::DATA_END => {
                    let data = bytes.get(..record.at).unwrap_or_default();
                    let saved = Fields::of(&record).u32()?;
                    self.findings.mismatches.is_whole = saved != 0 && saved != hash(data);
                    return Ok(());
                }
                _ => self.record(&record)?,
            }
        }
        Err(Damage::new(bytes.len(), "it ends before its data do"))
    }

    fn chunk(&mut self, bytes: &[u8], record: &Record<'_>, room: &mut usize) -> Result<(), Damage> {
        let chunk = Chunk::of(record)?;
        let unpacked = chunk.unpacked(*room);
        *room = room.saturating_sub(if chunk.is_packed() { unpacked.bytes.len() } else { 0 });
        let is_sound =
            chunk.crc == 0 || unpacked.damage.is_some() || chunk.crc == hash(&unpacked.bytes);
        let before = self.findings.messages;
        self.span_ns = (!is_sound).then_some(chunk.span_ns);
        // In a chunk that is not packed, a record has a place in the file.
        let read = match chunk.is_packed() {
            false => {
                let end = chunk.at + unpacked.bytes.len();
                self.records(Records::of(bytes.get(..end).unwrap_or_default(), chunk.at))
            }
            true => self.records(Records::of(&unpacked.bytes, 0)).map_err(|damage| {
                let why = format!("in the chunk that begins here, {}", damage.why);
                Damage::new(record.at, why)
            }),
        };
        self.span_ns = None;
        if !is_sound && read.is_ok() {
            let mismatches = &mut self.findings.mismatches;
            if mismatches.chunks == 0 {
                mismatches.first_at = record.at;
            }
            mismatches.chunks += 1;
            mismatches.messages += self.findings.messages - before;
        }
        // What could not be unpacked is the cause of a record that is cut.
        unpacked.damage.map_or(read, Err)
    }

    fn records(&mut self, records: Records<'_>) -> Result<(), Damage> {
        for record in records {
            self.record(&record?)?;
        }
        Ok(())
    }

    fn record(&mut self, record: &Record<'_>) -> Result<(), Damage> {
        match record.opcode {
            opcode::CHANNEL => self.channel(record),
            opcode::MESSAGE => self.message(record),
            opcode::MESSAGE_INDEX => message_index(record),
            opcode::HEADER | opcode::SCHEMA | opcode::ATTACHMENT | opcode::METADATA => Ok(()),
            kind if kind > opcode::LAST => {
                self.findings.unknown += 1;
                Ok(())
            }
            kind => {
                Err(Damage::new(record.at, format!("a record of the kind {kind} at a wrong place")))
            }
        }
    }

    fn channel(&mut self, record: &Record<'_>) -> Result<(), Damage> {
        let mut fields = Fields::of(record);
        let (id, _schema, topic) = (fields.u16()?, fields.u16()?, fields.text()?);
        let known = self.topics.entry(id).or_insert_with(|| topic.to_owned());
        if known == topic {
            return Ok(());
        }
        Err(Damage::new(record.at, format!("channel {id} has two topics")))
    }

    fn message(&mut self, record: &Record<'_>) -> Result<(), Damage> {
        let mut fields = Fields::of(record);
        let (id, _sequence, time_ns, _published) =
            (fields.u16()?, fields.u32()?, fields.u64()?, fields.u64()?);
        let Some(topic) = self.topics.get(&id) else {
            return Err(Damage::new(record.at, format!("a message of an unknown channel, {id}")));
        };
        if self.span_ns.is_some_and(|(first, last)| time_ns < first || last < time_ns) {
            return Err(Damage::new(record.at, "a message of a time that is not its chunk's"));
        }
        self.findings.messages += 1;
        (self.visit)(&Message { topic, time_ns, data: fields.rest() });
        Ok(())
    }
}

/// Checks an index, which is not used: a record that was another one does not have its form.
fn message_index(record: &Record<'_>) -> Result<(), Damage> {
    let mut fields = Fields::of(record);
    let (_channel, length) = (fields.u16()?, fields.u32()?);
    if u64::from(length) == fields.rest().len() as u64 {
        return Ok(());
    }
    Err(Damage::new(record.at, "an index of another length than it says"))
}

#[cfg(test)]
mod tests;
