//! Reads and writes the file of a fleet.
//!
//! ```toml
//! version = 1
//!
//! [[drone]]
//! node = 3
//! role = "relay"
//! cfclient = false
//! generation = 1
//! issue = 1
//! policy = "t5"
//!
//! [fleet]
//! generation = 1
//! issued = 1
//! secret = "32 hexadecimal digits"
//! name = "8 hexadecimal digits"
//! ```
//!
//! A drone has an entry `policy` if it was given a movement policy; without it, the drone uses the
//! policy in its settings.
//!
//! The secret stands near the end of the file and the name, which is checked against it, at the
//! very end, so that a file that was cut off anywhere is refused.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::RangeInclusive;
use std::path::Path;

use airlink::keys::{FleetSecret, node as node_key};
use chain::policy::{NAMES, Policy};
use input::{InputError, suggest};
use serde::Deserialize;
use storage::Record;
use storage::epoch::Issue;
use storage::keys::{self, KeysRecord, PageMission, Secret};
use toml::{Spanned, Value};
use units::{Dbm, NODES, NodeId, Role};

use super::{Request, limits};

const VERSION: i64 = 1;

pub(super) const HEADING: &str = "\
# The keys of a fleet of drones. Keep this file secret: with it anyone can fly all of them.
# Change it with `uchain keys` alone, and never put an old copy back: it would give out numbers
# that have been given already.
";

/// A fleet: its secret, and the keys that each drone was given.
#[derive(Clone, PartialEq)]
pub struct Fleet {
    secret: [u8; 16],
    generation: u8,
    issued: Option<Issue>,
    drones: BTreeMap<u8, FleetEntry>,
}

/// The entry of one drone in the key file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FleetEntry {
    /// The role of the drone.
    pub role: Role,
    /// Whether cfclient may fly the head through this drone.
    pub may_fly: bool,
    /// The generation of its keys.
    pub generation: u8,
    /// The issue by which it has its keys.
    pub issue: Issue,
    /// The movement policy that it was given; `None` for the one in its settings.
    pub policy: Option<&'static Policy>,
}

impl std::fmt::Debug for Fleet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Fleet").field("name", &self.name()).finish_non_exhaustive()
    }
}

impl Fleet {
    pub(super) const fn new(secret: [u8; 16], generation: u8) -> Self {
        Self { secret, generation, issued: None, drones: BTreeMap::new() }
    }

    /// The name of the fleet in its files and drones. It follows from the secret without revealing
    /// it: it is a part of what would be the group's key in generation 0, which is never used.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{:08x}", self.number())
    }

    fn number(&self) -> u32 {
        let [a, b, c, d, ..] = *FleetSecret::from_bytes(self.secret).group(0).expose();
        u32::from_le_bytes([a, b, c, d])
    }

    /// The present generation of the fleet's keys.
    #[must_use]
    pub const fn generation(&self) -> u8 {
        self.generation
    }

    /// The number of issues that have been given out.
    #[must_use]
    pub fn issued(&self) -> u8 {
        self.issued.map_or(0, Issue::get)
    }

    /// The drones of the fleet, by number.
    #[must_use]
    pub const fn drones(&self) -> &BTreeMap<u8, FleetEntry> {
        &self.drones
    }

    /// The numbers of the drones whose keys are of an earlier generation.
    #[must_use]
    pub fn stale(&self) -> Vec<u8> {
        let stale = self.drones.iter().filter(|(_, drone)| drone.generation != self.generation);
        stale.map(|(node, _)| *node).collect()
    }

    /// The next issue, for this node, and the page with its keys.
    pub(super) fn give_out(
        &mut self,
        request: &Request,
    ) -> Result<(FleetEntry, Vec<u8>), InputError> {
        let Request { node, role, may_fly, policy, limits: given, mission } = *request;
        let role = role.unwrap_or(Role::usual_of(node));
        let policy = policy.or_else(|| self.drones.get(&node.0)?.policy);
        self.check_place(node, role, may_fly)?;
        given.map_or(Ok(()), limits::check)?;
        check_plan(node, role, mission.as_ref())?;
        let issue = self.issued.map_or(Some(Issue::FIRST), Issue::next).ok_or_else(|| {
            InputError::new(
                format!("all {} issues of this fleet have been given out", Issue::LAST),
                "make a new fleet with uchain keys new and provision every drone from it",
            )
        })?;
        let drone = FleetEntry { role, may_fly, generation: self.generation, issue, policy };
        let record = self.record(node, &drone).encode(0);
        let defect = |error: storage::Error| InputError::new(error.to_string(), REPORT);
        let record = record.map_err(defect)?;
        let page = page(&record, policy, given, mission.as_ref()).map_err(defect)?;
        self.issued = Some(issue);
        self.drones.insert(node.0, drone);
        Ok((drone, page))
    }

    fn check_place(&self, node: NodeId, role: Role, may_fly: bool) -> Result<(), InputError> {
        if usize::from(node.0) >= NODES {
            return Err(InputError::new(
                format!("--node {} is out of range", node.0),
                format!("give 0 (the head) to {}", NODES - 1),
            ));
        }
        if may_fly && role != Role::Base {
            return Err(InputError::new(
                "--allow-cfclient is for the base alone: through it the operator flies the head",
                "leave it out, or give --role base",
            ));
        }
        let other = self.drones.iter().find(|(number, drone)| {
            **number != node.0 && role != Role::Relay && drone.role == role
        });
        match other {
            None => Ok(()),
            Some((number, _)) => Err(InputError::new(
                format!("node {number} is the {} of this fleet already", role.name()),
                format!(
                    "give that number, or begin anew with uchain keys rekey --without {number}"
                ),
            )),
        }
    }

    fn record(&self, node: NodeId, drone: &FleetEntry) -> KeysRecord {
        let secret = FleetSecret::from_bytes(self.secret);
        let base = secret.base(drone.generation);
        let own = match drone.role {
            Role::Base => base,
            Role::Head | Role::Relay => node_key(&base, node),
        };
        KeysRecord {
            fleet: self.number(),
            generation: drone.generation,
            issue: drone.issue,
            node,
            role: drone.role,
            may_fly: drone.may_fly,
            group: Secret::new(*secret.group(drone.generation).expose()),
            own: Secret::new(*own.expose()),
        }
    }

    pub(super) fn rekey(&mut self, without: &[NodeId]) -> Result<(), InputError> {
        if let Some(stranger) = without.iter().find(|node| !self.drones.contains_key(&node.0)) {
            let known: Vec<_> = self.drones.keys().map(u8::to_string).collect();
            let known = if known.is_empty() { "none yet".to_owned() } else { known.join(", ") };
            return Err(InputError::new(
                format!("--without {}: this fleet has no such drone", stranger.0),
                format!("its drones are: {known}"),
            ));
        }
        self.generation = self.generation.checked_add(1).ok_or_else(|| {
            InputError::new(
                "this is the last generation that there is",
                "make a new fleet with uchain keys new and provision every drone from it",
            )
        })?;
        self.drones.retain(|node, _| !without.contains(&NodeId(*node)));
        Ok(())
    }

    /// The file's text.
    #[must_use]
    pub(super) fn text(&self) -> String {
        let mut text = format!("{HEADING}version = {VERSION}\n\n");
        for (node, drone) in &self.drones {
            let FleetEntry { role, may_fly, generation, issue, policy } = drone;
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "[[drone]]\nnode = {node}\nrole = \"{}\"\ncfclient = {may_fly}\ngeneration = \
                 {generation}\nissue = {issue}",
                role.name()
            );
            if let Some(policy) = policy {
                let _ = writeln!(text, "policy = \"{}\"", policy.name);
            }
            text.push('\n');
        }
        let _ = writeln!(
            text,
            "[fleet]\ngeneration = {}\nissued = {}\nsecret = \"{}\"\nname = \"{}\"",
            self.generation,
            self.issued(),
            hex(&self.secret),
            self.name()
        );
        text
    }

    pub(super) fn parse(path: &Path, text: &str) -> Result<Self, InputError> {
        let reader = Reader { path, text };
        let Version { version } = reader.toml()?;
        if *version.as_ref() != VERSION {
            return Err(reader.wrong(
                &version,
                format!(
                    "this key file has version {}, of which nothing is known",
                    version.as_ref()
                ),
                "use the uchain that wrote it, or a newer one",
            ));
        }
        let file: File = reader.toml()?;
        let fleet = reader.fleet(&file.fleet)?;
        let drones = file.drone.iter().map(|drone| reader.drone(drone, &fleet));
        let drones: Vec<_> = drones.collect::<Result<_, _>>()?;
        drones.iter().zip(&file.drone).try_fold(fleet, |mut fleet, ((node, drone), entry)| {
            let taken = fleet.drones.values().any(|other| other.issue == drone.issue);
            if taken || fleet.drones.insert(*node, *drone).is_some() {
                let wrong = "two drones have the same node or the same issue";
                return Err(reader.wrong(&entry.node, wrong.to_owned(), RESTORE));
            }
            Ok(fleet)
        })
    }
}

/// Returns the page with a drone's keys, and what else it is given.
///
/// # Errors
/// If a drone could not keep the mission's plan.
pub fn page(
    keys: &[u8; keys::LENGTH],
    policy: Option<&Policy>,
    limits: Option<[Dbm; 2]>,
    mission: Option<&PageMission>,
) -> Result<Vec<u8>, storage::Error> {
    let mut page = keys.to_vec();
    if let Some(policy) = policy {
        page.extend(keys::encode_policy(policy.code));
    }
    if let Some([launch, retreat]) = limits {
        page.extend(keys::encode_limits(launch, retreat));
    }
    if let Some(mission) = mission {
        page.extend(mission.encode()?);
    }
    Ok(page)
}

/// Checks that a drone has its part in the plan that it is given.
fn check_plan(node: NodeId, role: Role, mission: Option<&PageMission>) -> Result<(), InputError> {
    match mission.and_then(|mission| mission.swarm) {
        Some(plan) if role != Role::Base && node.0 >= plan.drones => Err(InputError::new(
            format!("--node {} has no part in a plan for {} drones", node.0, plan.drones),
            format!("give 0 to {}, or a plan for more drones", plan.drones.saturating_sub(1)),
        )),
        _ => Ok(()),
    }
}

const REPORT: &str = "this is a defect of uchain, please report it";
const RESTORE: &str = "undo what was done to it by hand, or make a new fleet with uchain keys new";

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[derive(Deserialize)]
struct Version {
    version: Spanned<i64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(rename = "version")]
    _version: i64,
    #[serde(default)]
    drone: Vec<DroneTable>,
    fleet: FleetTable,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DroneTable {
    node: Spanned<i64>,
    role: RoleKey,
    cfclient: Spanned<bool>,
    generation: Spanned<i64>,
    issue: Spanned<i64>,
    policy: Option<Spanned<String>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum RoleKey {
    Head,
    Relay,
    Base,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FleetTable {
    generation: Spanned<i64>,
    issued: Spanned<i64>,
    /// Any value, so that the parser never gets to complain of it and to quote it.
    secret: Spanned<Value>,
    name: Spanned<String>,
}

/// The file under the reader's eyes.
struct Reader<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Reader<'_> {
    fn toml<'t, T: Deserialize<'t>>(&'t self) -> Result<T, InputError> {
        toml::from_str(self.text).map_err(|error| {
            let wrong = without_keys(&error.message().lines().collect::<Vec<_>>().join(" "));
            let line = error.span().map_or(1, |span| self.line_at(span.start));
            InputError::new(format!("this is no key file: {wrong}"), RESTORE)
                .at_line(self.path, line)
        })
    }

    fn line_at(&self, byte: usize) -> usize {
        1 + self.text.bytes().take(byte).filter(|&b| b == b'\n').count()
    }

    fn wrong<T>(&self, at: &Spanned<T>, wrong: String, remedy: &str) -> InputError {
        InputError::new(wrong, remedy).at_line(self.path, self.line_at(at.span().start))
    }

    fn number(
        &self,
        value: &Spanned<i64>,
        name: &str,
        range: RangeInclusive<u8>,
    ) -> Result<u8, InputError> {
        let number = u8::try_from(*value.as_ref()).ok().filter(|number| range.contains(number));
        number.ok_or_else(|| {
            let (from, to) = (range.start(), range.end());
            let wrong = format!("{name} = {} is not within {from} to {to}", value.as_ref());
            self.wrong(value, wrong, RESTORE)
        })
    }

    fn fleet(&self, table: &FleetTable) -> Result<Fleet, InputError> {
        let generation = self.number(&table.generation, "generation", 1..=u8::MAX)?;
        let issued = self.number(&table.issued, "issued", 0..=Issue::LAST.get())?;
        let secret = table.secret.as_ref().as_str().and_then(unhex).ok_or_else(|| {
            let wrong = "the secret is not 32 hexadecimal digits";
            self.wrong(&table.secret, wrong.to_owned(), RESTORE)
        })?;
        let mut fleet = Fleet::new(secret, generation);
        fleet.issued = Issue::new(issued);
        if *table.name.as_ref() != fleet.name() {
            let wrong = "the fleet's name does not go with its secret";
            return Err(self.wrong(&table.name, wrong.to_owned(), RESTORE));
        }
        Ok(fleet)
    }

    fn policy(&self, name: &Spanned<String>) -> Result<&'static Policy, InputError> {
        let (at, name) = (name, name.as_ref());
        Policy::named(name).ok_or_else(|| {
            let wrong = format!("there is no policy \"{name}\"");
            self.wrong(at, wrong, &suggest::one_of(name, &NAMES))
        })
    }

    fn drone(&self, table: &DroneTable, fleet: &Fleet) -> Result<(u8, FleetEntry), InputError> {
        let node = self.number(&table.node, "node", 0..=NODES as u8 - 1)?;
        let generation = self.number(&table.generation, "generation", 1..=fleet.generation)?;
        let number = self.number(&table.issue, "issue", 1..=fleet.issued().max(1))?;
        let role = match table.role {
            RoleKey::Head => Role::Head,
            RoleKey::Relay => Role::Relay,
            RoleKey::Base => Role::Base,
        };
        let may_fly = *table.cfclient.as_ref();
        let policy = table.policy.as_ref().map(|name| self.policy(name)).transpose()?;
        let issue = Issue::new(number).filter(|issue| Some(*issue) <= fleet.issued);
        match issue {
            None => {
                let wrong = format!("issue = {number}, but none has been given out");
                Err(self.wrong(&table.issue, wrong, RESTORE))
            }
            Some(_) if may_fly && role != Role::Base => {
                let wrong = "cfclient = true is for the base alone".to_owned();
                Err(self.wrong(&table.cfclient, wrong, RESTORE))
            }
            Some(issue) => Ok((node, FleetEntry { role, may_fly, generation, issue, policy })),
        }
    }
}

fn unhex(text: &str) -> Option<[u8; 16]> {
    let mut bytes = [0; 16];
    if text.len() != 32 || !text.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    for (i, byte) in bytes.iter_mut().enumerate() {
        *byte = u8::from_str_radix(text.get(2 * i..2 * i + 2)?, 16).ok()?;
    }
    Some(bytes)
}

/// The text, without what might be a piece of a secret that stands in the wrong place.
fn without_keys(text: &str) -> String {
    let words = text.split_inclusive(|c: char| !c.is_ascii_alphanumeric());
    words.map(|word| if word.bytes().any(|b| b.is_ascii_digit()) { "… " } else { word }).collect()
}
