//! Packets from a drone to a client.

use units::Instant;

use super::{
    LogType, MAX_DATA, PROTOCOL_VERSION, Packet, ParamType, Port, SupervisorCommand,
    SupervisorQuestion, Value,
};

/// Why a request was refused, by the numbers that clients know from C (`errno.h`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Errno {
    /// There is no such item: `ENOENT`.
    Missing = 2,
    /// The item cannot be read or written: `EIO`.
    Broken = 5,
    /// The item is too large: `E2BIG`.
    TooBig = 7,
    /// There is no such command: `ENOEXEC`.
    NoCommand = 8,
    /// There is no room for more: `ENOMEM`.
    NoRoom = 12,
    /// The client is not allowed to do this: `EACCES`.
    NotAllowed = 13,
    /// The item exists already: `EEXIST`.
    Exists = 17,
    /// The value is out of its range: `EINVAL`.
    Invalid = 22,
}

/// The status byte of an answer.
const fn status(outcome: Result<(), Errno>) -> u8 {
    match outcome {
        Ok(()) => 0,
        Err(why) => why as u8,
    }
}

/// A packet that a drone sends: the answer to a request, or one that it sends by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reply<'a> {
    /// Text for the console, of which at most [`MAX_DATA`] bytes are sent.
    Console(&'a [u8]),
    /// The size of the log's table.
    LogTable {
        /// The number of rows.
        count: u16,
        /// A checksum that changes whenever the table does.
        crc: u32,
        /// The most blocks.
        blocks: u8,
        /// The most variables in all blocks together.
        entries: u8,
    },
    /// A row of the log's table.
    LogVariable {
        /// The row's number.
        id: u16,
        /// The type in which the variable is stored.
        kind: LogType,
        /// The variable's group.
        group: &'a str,
        /// The variable's name; group and name together have at most 24 bytes.
        name: &'a str,
    },
    /// The log's table has no such row.
    NoLogVariable,
    /// The outcome of a control request to the log.
    LogControl {
        /// The request's number.
        command: u8,
        /// The block that the request named.
        block: u8,
        /// Whether the request was carried out.
        outcome: Result<(), Errno>,
    },
    /// The size of the parameters' table.
    ParamTable {
        /// The number of rows.
        count: u16,
        /// A checksum that changes whenever the table does.
        crc: u32,
    },
    /// A row of the parameters' table.
    Param {
        /// The row's number.
        id: u16,
        /// The parameter's type.
        kind: ParamType,
        /// Whether clients can read the parameter but not set it.
        read_only: bool,
        /// The parameter's group.
        group: &'a str,
        /// The parameter's name; group and name together have at most 24 bytes.
        name: &'a str,
    },
    /// The parameters' table has no such row.
    NoParam,
    /// The value of a parameter, as it was asked for.
    ParamRead {
        /// The parameter's row.
        id: u16,
        /// The value.
        value: Result<Value, Errno>,
    },
    /// The value of a parameter after a request to set it.
    ParamWritten {
        /// The parameter's row.
        id: u16,
        /// The value.
        value: Result<Value, Errno>,
    },
    /// The outcome of a request to set a parameter by its name.
    ParamSetByName {
        /// The parameter's group.
        group: &'a [u8],
        /// The parameter's name.
        name: &'a [u8],
        /// Whether the parameter was set.
        outcome: Result<(), Errno>,
    },
    /// The answer to whether a parameter can be stored: it cannot.
    ParamNotExtended {
        /// The parameter's row.
        id: u16,
        /// Whether the answer begins with a status byte.
        with_status: bool,
    },
    /// The refusal to store a value, to tell whether it is stored, or to delete the stored one.
    ParamNotKept {
        /// The request's number: 3 to store, 4 to ask, 5 to delete.
        command: u8,
        /// The parameter's row.
        id: u16,
    },
    /// The default of a parameter.
    ParamDefault {
        /// The parameter's row.
        id: u16,
        /// The default.
        value: Result<Value, Errno>,
        /// Whether the answer begins with a status byte.
        with_status: bool,
    },
    /// The number of memories.
    MemoryCount(u8),
    /// There is no memory with this number to be described.
    NoMemoryInfo(u8),
    /// The refusal to read from a memory.
    NoMemoryRead {
        /// The memory's number.
        memory: u8,
        /// The address in the memory.
        address: u32,
    },
    /// The refusal to write to a memory.
    NoMemoryWrite {
        /// The memory's number.
        memory: u8,
        /// The address in the memory.
        address: u32,
    },
    /// The outcome of a high-level command.
    HighLevel {
        /// The first bytes of the command.
        head: [u8; 3],
        /// Whether the command was carried out.
        outcome: Result<(), Errno>,
    },
    /// The supervisor's state.
    Supervisor {
        /// The question.
        question: SupervisorQuestion,
        /// All bits of the state, of which the question may name one.
        state: u16,
    },
    /// The outcome of a command to the supervisor.
    Commanded {
        /// The command.
        command: SupervisorCommand,
        /// Whether the command was carried out.
        done: bool,
        /// Whether the drone is now in the state that the command asks for: armed, or recovered.
        holds: bool,
    },
    /// The protocol's version.
    Protocol,
    /// The firmware's version.
    Firmware(&'a str),
    /// The type of the drone.
    DeviceType(&'a str),
    /// The text by which clients recognise a Crazyflie, from the link's source.
    Source,
}

/// The text of the link's source (crazyflie-firmware, `crtpservice.c`).
const SOURCE: &[u8; MAX_DATA] = b"Bitcraze Crazyflie\0\0\0\0\0\0\0\0\0\0\0\0";

impl Reply<'_> {
    /// The packet to be sent; bytes that do not fit are left out.
    #[must_use]
    pub fn packet(&self) -> Packet {
        let on = Packet::empty;
        match *self {
            Self::Console(text) => on(Port::Console, 0).with(text),
            Self::MemoryCount(count) => on(Port::Memory, 0).with(&[1, count]),
            Self::NoMemoryInfo(memory) => on(Port::Memory, 0).with(&[2, memory]),
            Self::NoMemoryRead { memory, address } => no_memory(1, memory, address),
            Self::NoMemoryWrite { memory, address } => no_memory(2, memory, address),
            Self::HighLevel { head, outcome } => {
                on(Port::HighLevel, 0).with(&head).with(&[status(outcome)])
            }
            Self::Protocol => on(Port::Platform, 1).with(&[0, PROTOCOL_VERSION, 0, 0, 0]),
            Self::Firmware(name) => on(Port::Platform, 1).with(&[1]).with(name.as_bytes()),
            Self::DeviceType(name) => on(Port::Platform, 1).with(&[2]).with(name.as_bytes()),
            Self::Source => on(Port::Link, 1).with(SOURCE),
            Self::Supervisor { .. } | Self::Commanded { .. } => self.supervisor(),
            Self::LogTable { .. }
            | Self::LogVariable { .. }
            | Self::NoLogVariable
            | Self::LogControl { .. } => self.log(),
            Self::ParamTable { .. }
            | Self::Param { .. }
            | Self::NoParam
            | Self::ParamRead { .. }
            | Self::ParamWritten { .. }
            | Self::ParamSetByName { .. }
            | Self::ParamNotExtended { .. }
            | Self::ParamNotKept { .. }
            | Self::ParamDefault { .. } => self.param(),
        }
    }

    /// A [`Commanded`](Self::Commanded) as clients expect it that command on the platform's port
    /// (crazyflie-firmware, `platformservice.c`).
    #[must_use]
    pub fn old_packet(&self) -> Packet {
        match *self {
            Self::Commanded { command, done, holds } => {
                Packet::empty(Port::Platform, 0).with(&[command.code(), done.into(), holds.into()])
            }
            _ => self.packet(),
        }
    }

    fn supervisor(&self) -> Packet {
        const RESPONSE: u8 = 0x80;
        match *self {
            Self::Supervisor { question: SupervisorQuestion::Bit(bit), state } => {
                let set = state.checked_shr(bit.into()).unwrap_or_default() as u8 & 1;
                Packet::empty(Port::Supervisor, 0).with(&[RESPONSE | bit.saturating_add(1), set])
            }
            Self::Supervisor { question: SupervisorQuestion::All, state } => {
                Packet::empty(Port::Supervisor, 0).with(&[RESPONSE | 12]).with(&state.to_le_bytes())
            }
            Self::Commanded { command, done, holds } => Packet::empty(Port::Supervisor, 1).with(&[
                RESPONSE | command.code(),
                done.into(),
                holds.into(),
            ]),
            _ => Packet::NULL,
        }
    }

    fn log(&self) -> Packet {
        let table = Packet::empty(Port::Log, 0);
        match *self {
            Self::LogTable { count, crc, blocks, entries } => table
                .with(&[3])
                .with(&count.to_le_bytes())
                .with(&crc.to_le_bytes())
                .with(&[blocks, entries]),
            Self::LogVariable { id, kind, group, name } => {
                named(table.with(&[2]).with(&id.to_le_bytes()).with(&[kind as u8]), group, name)
            }
            Self::NoLogVariable => table.with(&[2]),
            Self::LogControl { command, block, outcome } => {
                Packet::empty(Port::Log, 1).with(&[command, block, status(outcome)])
            }
            _ => Packet::NULL,
        }
    }

    fn param(&self) -> Packet {
        const READ_ONLY: u8 = 0x40;
        let on = |channel| Packet::empty(Port::Param, channel);
        let misc = |command: u8, id: u16| on(3).with(&[command]).with(&id.to_le_bytes());
        match *self {
            Self::ParamTable { count, crc } => {
                on(0).with(&[3]).with(&count.to_le_bytes()).with(&crc.to_le_bytes())
            }
            Self::Param { id, kind, read_only, group, name } => {
                let kind = kind as u8 | if read_only { READ_ONLY } else { 0 };
                named(on(0).with(&[2]).with(&id.to_le_bytes()).with(&[kind]), group, name)
            }
            Self::NoParam => on(0).with(&[2]),
            Self::ParamRead { id, value } => valued(on(1).with(&id.to_le_bytes()), value, true),
            Self::ParamWritten { id, value } => valued(on(2).with(&id.to_le_bytes()), value, false),
            Self::ParamSetByName { group, name, outcome } => {
                on(3).with(&[0]).with(group).with(&[0]).with(name).with(&[0, status(outcome)])
            }
            Self::ParamNotExtended { id, with_status } => {
                misc(if with_status { 7 } else { 2 }, id).with(&[Errno::Missing as u8])
            }
            Self::ParamNotKept { command, id } => misc(command, id).with(&[Errno::Missing as u8]),
            Self::ParamDefault { id, value, with_status } => {
                valued(misc(if with_status { 8 } else { 6 }, id), value, with_status)
            }
            _ => Packet::NULL,
        }
    }

    /// The head of a log block, to which its values are added.
    #[must_use]
    pub fn log_data(block: u8, now: Instant) -> LogData {
        let [a, b, c, ..] = (now.as_micros() / 1_000).to_le_bytes();
        LogData(Packet::empty(Port::Log, 2).with(&[block, a, b, c]))
    }
}

fn no_memory(channel: u8, memory: u8, address: u32) -> Packet {
    Packet::empty(Port::Memory, channel)
        .with(&[memory])
        .with(&address.to_le_bytes())
        .with(&[Errno::Broken as u8])
}

fn named(packet: Packet, group: &str, name: &str) -> Packet {
    packet.with(group.as_bytes()).with(&[0]).with(name.as_bytes()).with(&[0])
}

fn valued(packet: Packet, value: Result<Value, Errno>, with_status: bool) -> Packet {
    match value {
        Ok(value) => {
            let packet = if with_status { packet.with(&[0]) } else { packet };
            packet.with(value.bytes().as_slice())
        }
        Err(why) => packet.with(&[why as u8]),
    }
}

/// A log block that is being put together.
#[derive(Clone, Copy, Debug)]
pub struct LogData(Packet);

impl LogData {
    /// The most bytes of a block's values.
    pub const MAX: usize = MAX_DATA - 4;

    /// Adds a value in this type.
    #[must_use]
    pub fn with(self, value: Value, kind: LogType) -> Self {
        Self(self.0.with(value.log_bytes(kind).as_slice()))
    }

    /// The packet to be sent.
    #[must_use]
    pub const fn packet(self) -> Packet {
        self.0
    }
}
