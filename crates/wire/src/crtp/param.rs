//! Requests to the parameter service: its table, the values, and their defaults.

use super::{Error, Packet, Port};

/// A request to the parameter service. A parameter is named by its row in the table.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ParamRequest<'a> {
    /// The client asks for the size of the table.
    TableInfo,
    /// The client asks for this row of the table.
    TableItem(u16),
    /// The client asks for the value of this parameter.
    Read(u16),
    /// A parameter is to be set.
    Write {
        /// The parameter.
        id: u16,
        /// The new value; the parameter's type says how many of the bytes count.
        value: &'a [u8],
    },
    /// A parameter is to be set by its name, by a client that has not read the table.
    SetByName {
        /// The parameter's group.
        group: &'a [u8],
        /// The parameter's name.
        name: &'a [u8],
        /// The number of the type that the client sends.
        kind: u8,
        /// The new value.
        value: &'a [u8],
    },
    /// The client asks whether a parameter can be stored.
    ExtendedType {
        /// The parameter.
        id: u16,
        /// Whether the answer begins with a status byte.
        with_status: bool,
    },
    /// The value of this parameter is to be stored.
    Store(u16),
    /// The client asks whether the value of this parameter is stored.
    StoredState(u16),
    /// The stored value of this parameter is to be deleted.
    Clear(u16),
    /// The client asks for the default of a parameter.
    Default {
        /// The parameter.
        id: u16,
        /// Whether the answer begins with a status byte.
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

    /// A request to set a parameter by its name, laid out as `group 0 name 0 type value`.
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
