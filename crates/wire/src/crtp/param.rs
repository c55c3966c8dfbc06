//! Parameters: their table, their values, and what is known of them beside.

use super::{Error, Packet, Port};

/// What is asked of the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ParamRequest<'a> {
    /// How large the table is.
    TableInfo,
    /// A row of it.
    TableItem(u16),
    /// A value.
    Read(u16),
    /// A value is to be changed.
    Write {
        /// Which.
        id: u16,
        /// To what; how many bytes count is for the table to say.
        value: &'a [u8],
    },
    /// A value is to be changed, by somebody who has not read the table.
    SetByName {
        /// Its group.
        group: &'a [u8],
        /// Its name.
        name: &'a [u8],
        /// What the client thinks it is.
        kind: u8,
        /// To what.
        value: &'a [u8],
    },
    /// Whether it can be kept.
    ExtendedType {
        /// Which.
        id: u16,
        /// Whether the answer begins with how it went.
        with_status: bool,
    },
    /// Keep it.
    Store(u16),
    /// Whether it is kept.
    StoredState(u16),
    /// Forget what was kept.
    Clear(u16),
    /// What it is when nobody has changed it.
    Default {
        /// Which.
        id: u16,
        /// Whether the answer begins with how it went.
        with_status: bool,
    },
}

impl<'a> ParamRequest<'a> {
    pub(super) fn parse(channel: u8, data: &'a [u8]) -> Result<Self, Error> {
        match (channel, data) {
            (_, []) => Err(Error::Length(0)),
            (0, [3, ..]) => Ok(Self::TableInfo),
            (0, [2, a, b, ..]) => Ok(Self::TableItem(u16::from_le_bytes([*a, *b]))),
            (0, [2, ..]) => Err(Error::Length(data.len())),
            (0, [command, ..]) => Err(Error::Command(*command)),
            (1, [a, b, ..]) => Ok(Self::Read(u16::from_le_bytes([*a, *b]))),
            (2, [a, b, value @ ..]) => Ok(Self::Write { id: u16::from_le_bytes([*a, *b]), value }),
            (1 | 2, _) => Err(Error::Length(data.len())),
            (_, [0, named @ ..]) => Self::by_name(named),
            (_, [command @ 2..=8, a, b, ..]) => {
                Ok(Self::misc(*command, u16::from_le_bytes([*a, *b])))
            }
            (_, [2..=8, ..]) => Err(Error::Length(data.len())),
            (_, [command, ..]) => Err(Error::Command(*command)),
        }
    }

    const fn misc(command: u8, id: u16) -> Self {
        match command {
            3 => Self::Store(id),
            4 => Self::StoredState(id),
            5 => Self::Clear(id),
            6 => Self::Default { id, with_status: false },
            8 => Self::Default { id, with_status: true },
            2 => Self::ExtendedType { id, with_status: false },
            _ => Self::ExtendedType { id, with_status: true },
        }
    }

    /// `group 0 name 0 type value`
    fn by_name(named: &'a [u8]) -> Result<Self, Error> {
        let wrong = Error::Length(named.len() + 1);
        let mut parts = named.splitn(3, |byte| *byte == 0);
        let (Some(group), Some(name), Some([kind, value @ ..])) =
            (parts.next(), parts.next(), parts.next())
        else {
            return Err(wrong);
        };
        Ok(Self::SetByName { group, name, kind: *kind, value })
    }

    pub(super) fn packet(&self) -> Packet {
        let on = |channel| Packet::empty(Port::Param, channel);
        let misc = |command, id: u16| on(3).with(&[command]).with(&id.to_le_bytes());
        match self {
            Self::TableInfo => on(0).with(&[3]),
            Self::TableItem(id) => on(0).with(&[2]).with(&id.to_le_bytes()),
            Self::Read(id) => on(1).with(&id.to_le_bytes()),
            Self::Write { id, value } => on(2).with(&id.to_le_bytes()).with(value),
            Self::SetByName { group, name, kind, value } => {
                on(3).with(&[0]).with(group).with(&[0]).with(name).with(&[0, *kind]).with(value)
            }
            Self::Store(id) => misc(3, *id),
            Self::StoredState(id) => misc(4, *id),
            Self::Clear(id) => misc(5, *id),
            Self::Default { id, with_status } => misc(if *with_status { 8 } else { 6 }, *id),
            Self::ExtendedType { id, with_status } => misc(if *with_status { 7 } else { 2 }, *id),
        }
    }
}
