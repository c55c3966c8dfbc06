//! Checks what a fleet file says, in the form that all formats of fleet files share.

use input::InputError;
use serde::{Deserialize, Serialize};
use units::{Dbm, Metres, NODES, NodeId, Role, Volts};

use super::{Deck, FleetDrone, Limits};
use crate::address::Address;

/// The longest name of a drone, in letters: it must fit into a line of a phone.
const LONGEST_NAME: usize = 24;

/// What a fleet file says of one drone.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) number: u8,
    pub(super) name: String,
    pub(super) address: Address,
    /// The role; `None` for that of the number.
    pub(super) role: Option<RoleKey>,
    /// The decks; `None` for those of the role.
    pub(super) decks: Option<Vec<Deck>>,
    /// The line of the file which an error names.
    pub(super) line: usize,
}

/// A drone's part in the chain, as a file names it.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum RoleKey {
    Head,
    Relay,
    Base,
}

impl From<RoleKey> for Role {
    fn from(key: RoleKey) -> Self {
        match key {
            RoleKey::Head => Self::Head,
            RoleKey::Relay => Self::Relay,
            RoleKey::Base => Self::Base,
        }
    }
}

impl From<Role> for RoleKey {
    fn from(role: Role) -> Self {
        match role {
            Role::Head => Self::Head,
            Role::Relay => Self::Relay,
            Role::Base => Self::Base,
        }
    }
}

/// The limits of a fleet, as a file has them.
#[derive(Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LimitsTable {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) launch_limit_dbm: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) retreat_limit_dbm: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) height_m: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) battery_v: Option<f32>,
}

/// The firmware of a fleet, as a file has it.
#[derive(Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FirmwareTable {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) version: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) revision: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) radio: Option<String>,
}

/// Checks the limits and the firmware of a fleet.
pub(super) fn limits(table: LimitsTable, firmware: FirmwareTable) -> Result<Limits, InputError> {
    for (key, value) in [
        ("launch_limit_dbm", table.launch_limit_dbm),
        ("retreat_limit_dbm", table.retreat_limit_dbm),
        ("height_m", table.height_m),
        ("battery_v", table.battery_v),
    ] {
        if let Some(value) = value.filter(|value| !value.is_finite()) {
            return Err(InputError::new(format!("{key} is {value}"), "give a finite number"));
        }
    }
    Ok(Limits {
        launch: table.launch_limit_dbm.map(Dbm),
        retreat: table.retreat_limit_dbm.map(Dbm),
        height: table.height_m.map(Metres),
        battery: table.battery_v.map(Volts),
        version: firmware.version,
        radio: firmware.radio,
        revision: firmware.revision.map(|digits| digits.to_lowercase()),
    })
}

impl Entry {
    /// Checks the entry by itself.
    pub(super) fn check(self) -> Result<(NodeId, FleetDrone), InputError> {
        let Self { number, name, address, role, decks, line: _ } = self;
        let wrong = |wrong: String, remedy: &str| {
            Err(InputError::new(format!("drone {number}: {wrong}"), remedy))
        };
        if usize::from(number) >= NODES {
            return wrong("there is no such number".to_owned(), "give 0 (the head) to 15");
        }
        if name.chars().count() > LONGEST_NAME {
            return wrong(format!("the name {name:?} is too long"), "give up to 24 letters");
        }
        if name.chars().any(char::is_control) {
            return wrong(format!("the name {name:?} has control characters"), "leave them out");
        }
        let node = NodeId(number);
        let role = role.map_or(Role::usual_of(node), Role::from);
        let decks = decks.unwrap_or_else(|| Deck::usual_of(role));
        Ok((node, FleetDrone { name, address, role, decks }))
    }
}
