//! Reads `crazyflies.yaml`, in which crazyswarm2 lists the robots of a laboratory.
//!
//! What that format has no words for stands under the key `uchain`, which crazyswarm2 passes over:
//! in a robot its number, name, role and decks; at the top the limits and the firmware of all drones.
//! Robots that are not enabled, and types that crazyswarm2 does not connect to, are no drones of the
//! fleet. What only crazyswarm2 uses is not read: positions, motion capture, logging and parameters.

use std::collections::BTreeMap;
use std::path::Path;

use input::{InputError, suggest};
use serde::{Deserialize, Serialize};
use serde_saphyr::{Error, MessageFormatter, Spanned, UserMessageFormatter};

use super::entry::{self, Entry, FirmwareTable, LimitsTable, RoleKey};
use super::{Deck, Fleet};
use crate::address::Address;

/// The newest version of the format; a file without one has the first.
pub(super) const VERSION: u32 = 3;

#[derive(Deserialize)]
struct File {
    fileversion: Option<Spanned<u32>>,
    robots: BTreeMap<String, RobotTable>,
    #[serde(default)]
    robot_types: BTreeMap<String, TypeTable>,
    #[serde(default)]
    uchain: FleetTable,
}

#[derive(Deserialize)]
struct RobotTable {
    enabled: Spanned<bool>,
    uri: Option<Spanned<String>>,
    r#type: Option<Spanned<String>>,
    #[serde(default)]
    uchain: DroneTable,
}

#[derive(Deserialize)]
struct TypeTable {
    connection: Option<String>,
}

/// What the format has no words for, of all drones.
#[derive(Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FleetTable {
    #[serde(default)]
    pub(super) limits: LimitsTable,
    #[serde(default)]
    pub(super) firmware: FirmwareTable,
}

/// What the format has no words for, of one drone.
#[derive(Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DroneTable {
    /// The number, where the address does not end in it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) number: Option<u8>,
    /// The name, where it is not the robot's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) name: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) role: Option<RoleKey>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) decks: Option<DecksTable>,
}

/// Which decks a drone has. A list would not do: as a parameter of ROS 2 it must not be empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DecksTable {
    flow: bool,
    multiranger: bool,
}

impl DecksTable {
    pub(super) fn of(decks: &[Deck]) -> Self {
        let has = |deck| decks.contains(&deck);
        Self { flow: has(Deck::Flow), multiranger: has(Deck::Multiranger) }
    }

    fn decks(self) -> Vec<Deck> {
        let all = [(self.flow, Deck::Flow), (self.multiranger, Deck::Multiranger)];
        all.into_iter().filter(|(is_there, _)| *is_there).map(|(_, deck)| deck).collect()
    }
}

/// Reads the text of a `crazyflies.yaml`, whose path stands in errors.
pub(super) fn parse(text: &str, path: &Path) -> Result<Fleet, InputError> {
    let file: File = serde_saphyr::from_str(text).map_err(|error| unreadable(&error, path))?;
    if let Some(version) = file.fileversion.filter(|version| version.value > VERSION) {
        let wrong = format!("fileversion {} is newer than {VERSION}", version.value);
        return Err(InputError::new(wrong, "give a file of a version that is known")
            .at_line(path, line(&version)));
    }
    let mut entries = Vec::new();
    for (name, robot) in file.robots {
        entries.extend(robot.read(name, &file.robot_types, path)?);
    }
    if entries.is_empty() {
        let remedy = "set `enabled: true` for each robot that belongs to the chain";
        return Err(InputError::new("no robot is enabled", remedy).in_file(path));
    }
    entries.sort_by_key(|entry| entry.line);
    let FleetTable { limits, firmware } = file.uchain;
    let limits = entry::limits(limits, firmware).map_err(|error| error.in_file(path))?;
    let no_base =
        "give the robot at the operator `uchain: {role: base}`, or an address that ends in 0F";
    Fleet::of(limits, entries, path, no_base)
}

impl RobotTable {
    /// The entry of a robot with this name; `None` if it is no drone of the fleet.
    fn read(
        self,
        name: String,
        types: &BTreeMap<String, TypeTable>,
        path: &Path,
    ) -> Result<Option<Entry>, InputError> {
        if !self.enabled.value {
            return Ok(None);
        }
        let missing = |key: &str, remedy: &str| {
            let wrong = format!("the robot {name} has no {key}");
            InputError::new(wrong, remedy).at_line(path, line(&self.enabled))
        };
        let kind = self.r#type.ok_or_else(|| missing("type", "give one of robot_types"))?;
        let Some(known) = types.get(&kind.value) else {
            let names: Vec<_> = types.keys().map(String::as_str).collect();
            let remedy = match names[..] {
                [] => "describe it under robot_types".to_owned(),
                _ => suggest::one_of(&kind.value, &names),
            };
            let wrong = format!("the robot {name} has the unknown type {:?}", kind.value);
            return Err(InputError::new(wrong, remedy).at_line(path, line(&kind)));
        };
        if known.connection.as_deref().is_some_and(|connection| connection != "crazyflie") {
            return Ok(None);
        }
        let uri = self.uri.ok_or_else(|| missing("uri", "give its radio address"))?;
        let at = line(&uri);
        let address: Address =
            uri.value.parse().map_err(|error: InputError| error.at_line(path, at))?;
        let DroneTable { number, name: own_name, role, decks } = self.uchain;
        let number = number.or_else(|| address.number()).ok_or_else(|| {
            let wrong = format!("the address of the robot {name} ends in no number of a drone");
            let remedy = "add `uchain: {number: N}` to it, 0 (the head) to 15 (the base), or give it \
                          an address that ends in 00 to 0F";
            InputError::new(wrong, remedy).at_line(path, at)
        })?;
        let (name, decks) = (own_name.unwrap_or(name), decks.map(DecksTable::decks));
        Ok(Some(Entry { number, name, address, role, decks, line: at }))
    }
}

/// The line of a value in its file; the first is 1.
fn line<T>(value: &Spanned<T>) -> usize {
    value.referenced.line().try_into().unwrap_or(1)
}

/// The error of a text that is no such file, in one line.
fn unreadable(error: &Error, path: &Path) -> InputError {
    let said = UserMessageFormatter.format_message(error.without_snippet());
    let wrong = said.split_whitespace().collect::<Vec<_>>().join(" ");
    let line = error.location().map_or(1, |at| at.line().try_into().unwrap_or(1));
    InputError::new(wrong, "the book's chapter on the station describes the file")
        .at_line(path, line)
}
