//! Requests to the log service: its table of variables, and the blocks that it sends.

use units::Duration;

use super::{Error, Packet, Port};

/// A request to the log service.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LogRequest<'a> {
    /// The client asks for the size of the table.
    TableInfo,
    /// The client asks for this row of the table.
    TableItem(u16),
    /// A new block is to be created.
    Create {
        /// The block's number.
        block: u8,
        /// The variables of the block.
        entries: Entries<'a>,
    },
    /// Variables are to be added to a block.
    Append {
        /// The block's number.
        block: u8,
        /// The variables to be added.
        entries: Entries<'a>,
    },
    /// The block with this number is to be deleted.
    Delete(u8),
    /// A block is to be sent from now on.
    Start {
        /// The block's number.
        block: u8,
        /// The period at which the block is sent; zero sends it once.
        period: Duration,
        /// The command's number, which the answer repeats: 3 counts the period in 10 ms, 8 in 1 ms.
        command: u8,
    },
    /// The block with this number is to be sent no more.
    Stop(u8),
    /// All blocks are to be deleted.
    Reset,
    /// A control command that the service does not know; it is answered all the same.
    Unknown {
        /// The command's number.
        command: u8,
        /// The block that the command names, or zero.
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

/// The variables of a block. A client leaves the first byte of an entry that does not fit at the
/// end of a packet, and sends the whole entry in the next: an incomplete entry is ignored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Entries<'a>(&'a [u8]);

/// A log variable in a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Entry {
    /// The type in which the client wants the value: the number of a [`LogType`](super::LogType),
    /// if there is one.
    pub kind: u8,
    /// The variable's row in the table.
    pub variable: u16,
}

impl<'a> Entries<'a> {
    /// Bytes of an entry.
    const SIZE: usize = 3;

    fn new(bytes: &'a [u8]) -> Self {
        let whole = bytes.len() - bytes.len() % Self::SIZE;
        Self(bytes.get(..whole).unwrap_or_default())
    }

    /// The entries, one by one.
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
