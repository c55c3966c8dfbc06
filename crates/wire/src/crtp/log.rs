//! The log: tables and blocks.

use units::Duration;

use super::{Error, Packet, Port};

/// What is asked of the log.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LogRequest<'a> {
    /// How large the table is.
    TableInfo,
    /// A row of it.
    TableItem(u16),
    /// A new block.
    Create {
        /// Its number.
        block: u8,
        /// What is in it.
        entries: Entries<'a>,
    },
    /// More into a block.
    Append {
        /// Its number.
        block: u8,
        /// What is added.
        entries: Entries<'a>,
    },
    /// A block less.
    Delete(u8),
    /// A block is to be sent.
    Start {
        /// Its number.
        block: u8,
        /// How often; zero is once.
        period: Duration,
        /// The request's number, which is in the answer: 3 counts in 10 ms, 8 in 1 ms.
        command: u8,
    },
    /// A block is not to be sent.
    Stop(u8),
    /// All blocks less.
    Reset,
    /// Control, but of what? It is answered all the same.
    Unknown {
        /// The command.
        command: u8,
        /// The block that it names, or zero.
        block: u8,
    },
}

impl<'a> LogRequest<'a> {
    pub(super) fn parse(channel: u8, data: &'a [u8]) -> Result<Self, Error> {
        match (channel, data) {
            (_, []) => Err(Error::Length(0)),
            (0, [3, ..]) => Ok(Self::TableInfo),
            (0, [2, a, b, ..]) => Ok(Self::TableItem(u16::from_le_bytes([*a, *b]))),
            (0, [2, ..]) => Err(Error::Length(data.len())),
            (0, [command, ..]) => Err(Error::Command(*command)),
            (1, [command, rest @ ..]) => Ok(Self::control(*command, rest)),
            (channel, _) => Err(Error::Channel(channel)),
        }
    }

    fn control(command: u8, data: &'a [u8]) -> Self {
        match (command, data) {
            (2, [block, ..]) => Self::Delete(*block),
            (3, [block, period, ..]) => Self::Start {
                block: *block,
                period: Duration::from_millis(u64::from(*period) * 10),
                command,
            },
            (4, [block, ..]) => Self::Stop(*block),
            (5, _) => Self::Reset,
            (6, [block, entries @ ..]) => {
                Self::Create { block: *block, entries: Entries::new(entries) }
            }
            (7, [block, entries @ ..]) => {
                Self::Append { block: *block, entries: Entries::new(entries) }
            }
            (8, [block, a, b, ..]) => Self::Start {
                block: *block,
                period: Duration::from_millis(u16::from_le_bytes([*a, *b]).into()),
                command,
            },
            (command, data) => {
                Self::Unknown { command, block: data.first().copied().unwrap_or_default() }
            }
        }
    }

    pub(super) fn packet(&self) -> Packet {
        let table = Packet::empty(Port::Log, 0);
        let control = |command, block| Packet::empty(Port::Log, 1).with(&[command, block]);
        match self {
            Self::TableInfo => table.with(&[3]),
            Self::TableItem(id) => table.with(&[2]).with(&id.to_le_bytes()),
            Self::Create { block, entries } => control(6, *block).with(entries.0),
            Self::Append { block, entries } => control(7, *block).with(entries.0),
            Self::Delete(block) => control(2, *block),
            Self::Start { block, period, command: 3 } => {
                let tens = (period.as_micros() / 10_000).min(u8::MAX.into()) as u8;
                control(3, *block).with(&[tens])
            }
            Self::Start { block, period, .. } => {
                let millis = (period.as_micros() / 1_000).min(u16::MAX.into()) as u16;
                control(8, *block).with(&millis.to_le_bytes())
            }
            Self::Stop(block) => control(4, *block),
            Self::Reset => Packet::empty(Port::Log, 1).with(&[5]),
            Self::Unknown { command, block } => control(*command, *block),
        }
    }
}

/// What goes into a block. Clients leave the first byte of an entry that does not fit at the end of
/// a packet, and send the whole of it in the next: an entry that is not whole is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Entries<'a>(&'a [u8]);

/// A log variable in a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Entry {
    /// As what it is asked for: the number of a [`LogType`](super::LogType), perhaps.
    pub kind: u8,
    /// Its row in the table.
    pub variable: u16,
}

impl<'a> Entries<'a> {
    /// Bytes of an entry.
    const SIZE: usize = 3;

    fn new(bytes: &'a [u8]) -> Self {
        let whole = bytes.len() - bytes.len() % Self::SIZE;
        Self(bytes.get(..whole).unwrap_or_default())
    }

    /// One by one.
    pub fn iter(&self) -> impl Iterator<Item = Entry> + 'a {
        self.0.chunks_exact(Self::SIZE).filter_map(|entry| match entry {
            // The upper half says how it is stored, which the table knows better.
            [kind, a, b] => {
                Some(Entry { kind: kind & 0x0F, variable: u16::from_le_bytes([*a, *b]) })
            }
            _ => None,
        })
    }
}
