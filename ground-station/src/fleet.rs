//! Reads the fleet file: the drones of a fleet by number, with name, address and decks, and the
//! limits that all of them must have.
//!
//! ```toml
//! [limits]
//! launch_limit_dbm = -70.0
//! retreat_limit_dbm = -76.0
//!
//! [[drone]]
//! number = 0
//! name = "Ada"
//! address = "radio://0/80/2M/E7E7E7E700"
//! ```
//!
//! The file holds no keys and may be shown to anybody; `uchain keys` has a file of its own for the
//! fleet's secret, which it alone writes.

use std::collections::BTreeMap;
use std::path::Path;

use input::InputError;
use serde::Deserialize;
use units::{Dbm, Metres, NODES, NodeId, Role, Volts};

use crate::address::Address;

/// The longest name of a drone, in letters: it must fit into a line of a phone.
const LONGEST_NAME: usize = 24;

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
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    limits: LimitsTable,
    #[serde(default)]
    firmware: FirmwareTable,
    drone: Vec<DroneTable>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct LimitsTable {
    launch_limit_dbm: Option<f32>,
    retreat_limit_dbm: Option<f32>,
    height_m: Option<f32>,
    battery_v: Option<f32>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct FirmwareTable {
    version: Option<String>,
    revision: Option<String>,
    radio: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DroneTable {
    number: u8,
    #[serde(default)]
    name: String,
    address: String,
    role: Option<RoleKey>,
    decks: Option<Vec<Deck>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum RoleKey {
    Head,
    Relay,
    Base,
}

impl Fleet {
    /// Reads and checks a fleet file.
    ///
    /// # Errors
    /// A file that cannot be read, or says what no fleet can be.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let text = input::file::read_text(path, input::file::LARGEST_TEXT).map_err(|error| {
            InputError::new(format!("cannot be read: {error}"), "give a fleet file in TOML")
                .in_file(path)
        })?;
        Self::parse(&text, path)
    }

    fn parse(text: &str, path: &Path) -> Result<Self, InputError> {
        let file: File = toml::from_str(text).map_err(|error| {
            let line = error.span().map_or(1, |span| {
                1 + text.get(..span.start).unwrap_or_default().matches('\n').count()
            });
            let wrong = error.message().replace('\n', " ");
            InputError::new(wrong, "the book's chapter on the station describes the file")
                .at_line(path, line)
        })?;
        let mut fleet = Self { limits: limits(&file), drones: BTreeMap::new() };
        for table in file.drone {
            let (node, drone) = drone(table).map_err(|error| error.in_file(path))?;
            fleet.add(node, drone).map_err(|error| error.in_file(path))?;
        }
        match fleet.base() {
            Some(_) => Ok(fleet),
            None => Err(InputError::new(
                "no drone is the base",
                "add a [[drone]] with number = 15, or with role = \"base\"",
            )
            .in_file(path)),
        }
    }

    fn add(&mut self, node: NodeId, drone: FleetDrone) -> Result<(), InputError> {
        let others = || self.drones.iter();
        let twice = |what: String| InputError::new(what, "give each drone its own");
        if self.drones.contains_key(&node) {
            return Err(twice(format!("there are two drones with the number {node}")));
        }
        if let Some((other, _)) = others().find(|(_, other)| other.address == drone.address) {
            return Err(twice(format!("drones {other} and {node} have the same address")));
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

fn limits(file: &File) -> Limits {
    let table = &file.limits;
    Limits {
        launch: table.launch_limit_dbm.map(Dbm),
        retreat: table.retreat_limit_dbm.map(Dbm),
        height: table.height_m.map(Metres),
        battery: table.battery_v.map(Volts),
        version: file.firmware.version.clone(),
        radio: file.firmware.radio.clone(),
        revision: file.firmware.revision.as_ref().map(|digits| digits.to_lowercase()),
    }
}

fn drone(table: DroneTable) -> Result<(NodeId, FleetDrone), InputError> {
    let DroneTable { number, name, address, role, decks } = table;
    let wrong = |wrong: String, remedy: &str| {
        Err(InputError::new(format!("drone {number}: {wrong}"), remedy))
    };
    if usize::from(number) >= NODES {
        return wrong("there is no such number".to_owned(), "give 0 (the head) to 15");
    }
    if name.chars().count() > LONGEST_NAME || name.chars().any(char::is_control) {
        return wrong(format!("the name {name:?} is too long"), "give up to 24 letters");
    }
    let address = match address.parse() {
        Ok(address) => address,
        Err(remedy) => {
            return wrong(
                format!("{address:?} is no address"),
                &format!("{remedy}, or radio://0/80/2M/E7E7E7E70F"),
            );
        }
    };
    let node = NodeId(number);
    let role = match role {
        Some(RoleKey::Head) => Role::Head,
        Some(RoleKey::Relay) => Role::Relay,
        Some(RoleKey::Base) => Role::Base,
        None => Role::usual_of(node),
    };
    let usual = match role {
        Role::Head | Role::Relay => vec![Deck::Flow, Deck::Multiranger],
        Role::Base => Vec::new(),
    };
    Ok((node, FleetDrone { name, address, role, decks: decks.unwrap_or(usual) }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Fleet, String> {
        Fleet::parse(text, Path::new("fleet.toml")).map_err(|error| error.to_string())
    }

    const BASE: &str = "[[drone]]\nnumber = 15\naddress = \"radio://0/80/2M/E7E7E7E70F\"\n";

    #[test]
    fn a_file_with_all_keys_is_read() {
        let text = format!(
            "[limits]\nlaunch_limit_dbm = -70.0\nretreat_limit_dbm = -76.0\nheight_m = 0.4\n\
             battery_v = 3.9\n[firmware]\nversion = \"uchain 0.1.0\"\nrevision = \"0A1b\"\n\
             [[drone]]\nnumber = 0\nname = \"Ada\"\naddress = \"udp://127.0.0.1:19850\"\n\
             role = \"head\"\ndecks = [\"flow\"]\n{BASE}"
        );
        let fleet = parse(&text).unwrap();
        assert_eq!(fleet.limits.launch, Some(Dbm(-70.0)));
        assert_eq!(fleet.limits.revision.as_deref(), Some("0a1b"));
        assert_eq!(fleet.drones[&NodeId(0)].decks, [Deck::Flow]);
        assert_eq!(fleet.drones[&NodeId(15)].decks, []);
        assert_eq!(fleet.name(NodeId(0)), "the head (Ada)");
        assert_eq!(fleet.name(NodeId(3)), "relay 3");
        assert_eq!(fleet.flying().collect::<Vec<_>>(), [NodeId(0)]);
    }

    #[test]
    fn the_books_fleet_file_is_read() {
        let page = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/src/station.md"));
        let (_, block) = page.split_once("```toml\n").unwrap();
        let fleet = parse(block.split_once("```").unwrap().0).unwrap();
        assert_eq!(fleet.name(NodeId(0)), "the head (Ada)");
        assert_eq!(fleet.drones.len(), 3);
    }

    #[test]
    #[cfg(unix)]
    fn a_file_that_never_ends_is_refused() {
        let error = Fleet::read(Path::new("/dev/zero")).unwrap_err().to_string();
        assert!(error.contains("more than 16 MiB") && error.contains("; give"), "{error}");
    }

    #[test]
    fn what_is_wrong_is_said_in_one_line() {
        let drone = |number: u8, rest: &str| {
            format!("[[drone]]\nnumber = {number}\naddress = \"udp://a:{}\"\n{rest}\n", number + 1)
        };
        let cases = [
            (String::new(), "missing field"),
            (drone(0, ""), "no drone is the base"),
            (drone(16, ""), "there is no such number"),
            (format!("{BASE}{BASE}"), "two drones with the number 15"),
            (format!("{BASE}{}", drone(3, "role = \"base\"")), "both the base"),
            (format!("{}{}", drone(1, "name = \"A\""), drone(2, "name = \"A\"")), "the same name"),
            (format!("{BASE}[[drone]]\nnumber = 1\naddress = \"ten\""), "is no address"),
            (format!("{BASE}nmae = \"A\"\n"), "fleet.toml:4: unknown field"),
            (
                format!("{BASE}[[drone]]\nnumber = 1\naddress = \"radio://0/80/2M/E7E7E7E70F\""),
                "the same address",
            ),
        ];
        for (text, wanted) in cases {
            let error = parse(&text).unwrap_err();
            assert!(error.contains(wanted) && error.lines().count() == 1, "{text}\n{error}");
        }
    }
}
