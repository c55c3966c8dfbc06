//! What goes out.

use units::Instant;

use super::{
    LogType, MAX_DATA, PROTOCOL_VERSION, Packet, ParamType, Port, SupervisorCommand,
    SupervisorQuestion, Value,
};

/// Why a request was not met, by the numbers that clients know from C (`errno.h`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Errno {
    /// There is no such thing: `ENOENT`.
    Missing = 2,
    /// It cannot be read or written: `EIO`.
    Broken = 5,
    /// It is too large: `E2BIG`.
    TooBig = 7,
    /// There is no such command: `ENOEXEC`.
    NoCommand = 8,
    /// There is no more room: `ENOMEM`.
    NoRoom = 12,
    /// It may not be done: `EACCES`.
    NotAllowed = 13,
    /// It is there already: `EEXIST`.
    Exists = 17,
    /// That value it cannot have: `EINVAL`.
    Invalid = 22,
}

/// How it went, as a byte.
const fn status(outcome: Result<(), Errno>) -> u8 {
    match outcome {
        Ok(()) => 0,
        Err(why) => why as u8,
    }
}

/// What a drone answers, or says unasked.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reply<'a> {
    /// Text; of more than [`MAX_DATA`] bytes the first.
    Console(&'a [u8]),
    /// How large the log's table is.
    LogTable {
        /// Rows.
        count: u16,
        /// Changes whenever the table does.
        crc: u32,
        /// The most blocks.
        blocks: u8,
        /// The most variables in all blocks together.
        entries: u8,
    },
    /// A row of it.
    LogVariable {
        /// Which.
        id: u16,
        /// As what it is stored.
        kind: LogType,
        /// Its group …
        group: &'a str,
        /// … and its name, together no longer than 24 bytes.
        name: &'a str,
    },
    /// There is no such row.
    NoLogVariable,
    /// How a control request went.
    LogControl {
        /// The request's number.
        command: u8,
        /// The block that it named.
        block: u8,
        /// How it went.
        outcome: Result<(), Errno>,
    },
    /// How large the parameters' table is.
    ParamTable {
        /// Rows.
        count: u16,
        /// Changes whenever the table does.
        crc: u32,
    },
    /// A row of it.
    Param {
        /// Which.
        id: u16,
        /// What it is.
        kind: ParamType,
        /// Whether it can be read only.
        read_only: bool,
        /// Its group …
        group: &'a str,
        /// … and its name, together no longer than 24 bytes.
        name: &'a str,
    },
    /// There is no such row.
    NoParam,
    /// A value that was asked for.
    ParamRead {
        /// Of which.
        id: u16,
        /// Itself.
        value: Result<Value, Errno>,
    },
    /// The value after somebody wanted to change it.
    ParamWritten {
        /// Of which.
        id: u16,
        /// Itself.
        value: Result<Value, Errno>,
    },
    /// How changing a value by its name went.
    ParamSetByName {
        /// Its group.
        group: &'a [u8],
        /// Its name.
        name: &'a [u8],
        /// How it went.
        outcome: Result<(), Errno>,
    },
    /// Whether a value can be kept: it cannot.
    ParamNotExtended {
        /// Which.
        id: u16,
        /// Whether the answer begins with how it went.
        with_status: bool,
    },
    /// A value was not kept, is not, or was not forgotten.
    ParamNotKept {
        /// The request's number: 3 to keep, 4 whether it is kept, 5 to forget.
        command: u8,
        /// Which.
        id: u16,
    },
    /// What a value is when nobody has changed it.
    ParamDefault {
        /// Which.
        id: u16,
        /// Itself.
        value: Result<Value, Errno>,
        /// Whether the answer begins with how it went.
        with_status: bool,
    },
    /// How many memories there are.
    MemoryCount(u8),
    /// There is no such memory to be told about.
    NoMemoryInfo(u8),
    /// Nothing was read.
    NoMemoryRead {
        /// From which.
        memory: u8,
        /// From where.
        address: u32,
    },
    /// Nothing was written.
    NoMemoryWrite {
        /// To which.
        memory: u8,
        /// To where.
        address: u32,
    },
    /// How a high-level command went.
    HighLevel {
        /// The first bytes of the command.
        head: [u8; 3],
        /// How it went.
        outcome: Result<(), Errno>,
    },
    /// What the supervisor sees.
    Supervisor {
        /// What was asked.
        question: SupervisorQuestion,
        /// All that it sees.
        state: u16,
    },
    /// What became of a command to the supervisor, and of what it is about: whether the drone is
    /// armed, has recovered.
    Commanded {
        /// The command.
        command: SupervisorCommand,
        /// Whether it was done.
        done: bool,
        /// Whether what it is about is so now.
        holds: bool,
    },
    /// Which protocol is spoken.
    Protocol,
    /// Which firmware runs.
    Firmware(&'a str),
    /// Which drone this is.
    DeviceType(&'a str),
    /// What the link's source gives: how clients know whom they talk to.
    Source,
}

/// What a Crazyflie says of itself (crazyflie-firmware, `crtpservice.c`).
const SOURCE: &[u8; MAX_DATA] = b"Bitcraze Crazyflie\0\0\0\0\0\0\0\0\0\0\0\0";

impl Reply<'_> {
    /// As it is sent. What is too long is cut off.
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

    /// Of a log block, what comes before its values.
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

/// A log block as it is put together.
#[derive(Clone, Copy, Debug)]
pub struct LogData(Packet);

impl LogData {
    /// The most bytes of a block's values.
    pub const MAX: usize = MAX_DATA - 4;

    /// Adds a value, as a `kind`.
    #[must_use]
    pub fn with(self, value: Value, kind: LogType) -> Self {
        Self(self.0.with(value.log_bytes(kind).as_slice()))
    }

    /// As it is sent.
    #[must_use]
    pub const fn packet(self) -> Packet {
        self.0
    }
}
