//! Holds the fleet that the operator's file describes: the drones by number, with name, address and
//! decks, and the limits that all of them must have.
//!
//! | module | its part |
//! |---|---|
//! | `entry` | checks what a file says of one drone |
//! | `toml_file` | reads the project's own fleet file, in TOML |
//! | `crazyflies` | reads crazyswarm2's `crazyflies.yaml` |
//! | `export` | writes a fleet as `crazyflies.yaml` |
//!
//! No fleet file holds a key, so that anybody may see one; `uchain keys` has a file of its own for
//! the fleet's secret, which it alone writes.

mod crazyflies;
mod entry;
mod export;
#[cfg(test)]
mod tests;
mod toml_file;

use std::collections::BTreeMap;
use std::path::Path;

use input::InputError;
use serde::Deserialize;
use units::{Dbm, Metres, NodeId, Role, Volts};

use self::entry::Entry;
use crate::address::Address;

/// A fleet, as its file says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fleet {
    /// What all drones must have in common.
    pub limits: Limits,
    /// The drones, by number.
    pub drones: BTreeMap<NodeId, FleetDrone>,
}

/// What all drones of a fleet must have in common; what the file leaves out is not checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limits {
    /// A link that is weaker calls for the next relay.
    pub launch: Option<Dbm>,
    /// A link that is weaker sends its relay back.
    pub retreat: Option<Dbm>,
    /// The height at which the drones fly.
    pub height: Option<Metres>,
    /// The least voltage of a battery before a flight.
    pub battery: Option<Volts>,
    /// The firmware's version, as the drones tell it.
    pub version: Option<String>,
    /// The first digits of the firmware's revision.
    pub revision: Option<String>,
    /// The release of the radio chip's firmware, such as `2025.02`.
    pub radio: Option<String>,
}

/// One drone of a fleet.
#[derive(Clone, Debug, PartialEq)]
pub struct FleetDrone {
    /// The drone's name; empty for none.
    pub name: String,
    /// The drone's address.
    pub address: Address,
    /// The drone's part in the chain.
    pub role: Role,
    /// The decks that the drone must have.
    pub decks: Vec<Deck>,
}

/// A deck that a drone tells of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Deck {
    /// The Flow deck v2.
    Flow,
    /// The Multi-ranger deck.
    Multiranger,
}

impl Deck {
    /// The deck's name in a sentence.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Flow => "Flow deck",
            Self::Multiranger => "Multi-ranger deck",
        }
    }

    /// The decks that a drone with this part in the chain has, where its file does not name them.
    fn usual_of(role: Role) -> Vec<Self> {
        match role {
            Role::Head | Role::Relay => vec![Self::Flow, Self::Multiranger],
            Role::Base => Vec::new(),
        }
    }
}

impl Fleet {
    /// Reads and checks a fleet file: crazyswarm2's format if its name ends in `.yaml` or `.yml`,
    /// else TOML.
    ///
    /// # Errors
    /// A file that cannot be read, or says what no fleet can be.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let text = input::file::read_text(path, input::file::LARGEST_TEXT).map_err(|error| {
            let remedy = "give a fleet file in TOML, or crazyswarm2's crazyflies.yaml";
            InputError::new(format!("cannot be read: {error}"), remedy).in_file(path)
        })?;
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("yaml" | "yml") => crazyflies::parse(&text, path),
            _ => toml_file::parse(&text, path),
        }
    }

    /// Writes the fleet as crazyswarm2's `crazyflies.yaml`, into a file that must not be there yet.
    ///
    /// # Errors
    /// A file that is there already, or that cannot be written; then none is left.
    pub fn export(&self, path: &Path) -> Result<(), InputError> {
        export::write(self, path)
    }

    /// The fleet of these drones. `no_base` is how to mend a file of `path` that names no base.
    fn of(
        limits: Limits,
        entries: impl IntoIterator<Item = Entry>,
        path: &Path,
        no_base: &str,
    ) -> Result<Self, InputError> {
        let mut fleet = Self { limits, drones: BTreeMap::new() };
        for entry in entries {
            let line = entry.line;
            let added = entry.check().and_then(|(node, drone)| fleet.add(node, drone));
            added.map_err(|error| error.at_line(path, line))?;
        }
        match fleet.base() {
            Some(_) => Ok(fleet),
            None => Err(InputError::new("no drone is the base", no_base).in_file(path)),
        }
    }

    fn add(&mut self, node: NodeId, drone: FleetDrone) -> Result<(), InputError> {
        let others = || self.drones.iter();
        let twice = |what: String| InputError::new(what, "give each drone its own");
        if self.drones.contains_key(&node) {
            return Err(twice(format!("there are two drones with the number {node}")));
        }
        let is_same = |other: &FleetDrone| other.address.is_same_drone(&drone.address);
        if let Some((other, _)) = others().find(|(_, other)| is_same(other)) {
            return Err(twice(format!("drones {other} and {node} have the same address")));
        }
        let is_apart = |other: &FleetDrone| !other.address.shares_channel(&drone.address);
        if let Some((other, _)) = others().find(|(_, other)| is_apart(other)) {
            let wrong = format!("drones {other} and {node} cannot hear each other");
            let remedy = "give all drones of the chain the same channel and the same data rate";
            return Err(InputError::new(wrong, remedy));
        }
        let is_named = |other: &FleetDrone| !drone.name.is_empty() && other.name == drone.name;
        if let Some((other, _)) = others().find(|(_, other)| is_named(other)) {
            return Err(twice(format!("drones {other} and {node} have the same name")));
        }
        let alone = drone.role != Role::Relay;
        if let Some((other, _)) = others().find(|(_, other)| alone && other.role == drone.role) {
            let part = if drone.role == Role::Base { "base" } else { "head" };
            return Err(twice(format!("drones {other} and {node} are both the {part}")));
        }
        self.drones.insert(node, drone);
        Ok(())
    }

    /// The base.
    #[must_use]
    pub fn base(&self) -> Option<&FleetDrone> {
        self.drones.values().find(|drone| drone.role == Role::Base)
    }

    /// The numbers of the drones that fly.
    pub fn flying(&self) -> impl Iterator<Item = NodeId> {
        self.drones.iter().filter(|(_, drone)| drone.role != Role::Base).map(|(node, _)| *node)
    }

    /// The name of a drone in the middle of a sentence: its part in the chain, and its own name
    /// where the file gives one.
    #[must_use]
    pub fn name(&self, node: NodeId) -> String {
        let part = if node.0 == 0 { "the head".to_owned() } else { format!("relay {node}") };
        match self.drones.get(&node) {
            Some(FleetDrone { name, .. }) if !name.is_empty() => format!("{part} ({name})"),
            _ => part,
        }
    }
}
