//! The keys of a drone with its identity, as `uchain keys provision` makes them. They come in by
//! cable, through a page of the flash, and are kept in the EEPROM.
//!
//! | where | contents |
//! |---|---|
//! | flash, [`PAGE_ADDRESS`] | the *provisioning page*: a record as the tool wrote it, sequence number 0; wiped once the EEPROM has it |
//! | EEPROM 0x240 | the record in slot A |
//! | EEPROM 0x340 | the same record in slot B, so that no earlier keys stay in the memory |
//!
//! A record takes 56 bytes:
//!
//! | byte | type | field |
//! |---|---|---|
//! | 0 | 4 bytes | `UCHK` |
//! | 4 | `u8` | version, 1 |
//! | 5 | `u32` | sequence number: the newer of two records has the larger one |
//! | 9 | `u8` | generation of the fleet's keys, from 1 |
//! | 10 | `u8` | node number, 0 to 15 |
//! | 11 | `u8` | role: 0 head, 1 relay, 2 base |
//! | 12 | `u8` | bit 0: cfclient may fly the head through this drone; only a base may have it set |
//! | 13 | `u8` | the [`Issue`], 1 to 254 |
//! | 14 | 2 bytes | zero |
//! | 16 | `u32` | number of the fleet |
//! | 20 | 16 bytes | the group's key |
//! | 36 | 16 bytes | the drone's own key: a node's, or the base's |
//! | 52 | `u32` | CRC-32 of the bytes before |
//!
//! On the page a movement policy may follow, which goes into the drone's settings when its keys are
//! taken over:
//!
//! | byte | type | field |
//! |---|---|---|
//! | 56 | 2 bytes | `UP` |
//! | 58 | `u8` | version, 1 |
//! | 59 | `u8` | code of the policy |
//! | 60 | `u32` | CRC-32 of bytes 56 to 59 |
//!
//! After that, or in its place, may follow the limits of links, which go into the settings as well:
//!
//! | byte | type | field |
//! |---|---|---|
//! | 0 | 2 bytes | `UL` |
//! | 2 | `u8` | version, 1 |
//! | 3 | `u8` | zero |
//! | 4 | `f32` | launch limit, dBm |
//! | 8 | `f32` | retreat limit, dBm |
//! | 12 | `u32` | CRC-32 of the bytes before |
//!
//! Behind those that are there may follow a mission for the settings:
//!
//! | byte | type | field |
//! |---|---|---|
//! | 0 | 4 bytes | `UCHM` |
//! | 4 | `u8` | version, 1 |
//! | 5 | `u8` | the mission's code; and 128 where the drones are fetched after it |
//! | 6 | 19 bytes | plan of a swarm's mission ([`crate::settings::SwarmPlan`]), or zeros for none |
//! | 25 | 3 bytes | zero |
//! | 28 | `u32` | CRC-32 of the bytes before |

use core::fmt;

use units::{Dbm, MissionKind, NODES, NodeId, PolicyCode, Role};

use crate::bytes::{Reader, check_crc, role_code, role_of_code, sealed};
use crate::epoch::Issue;
use crate::ledger::Ledger;
use crate::settings::{Limits, Settings, mission_byte, mission_of_byte};
use crate::swarm_plan::{self, SwarmPlan};
use crate::{Error, Record};

/// Bytes of a record: whole words, by which flash is written.
pub const LENGTH: usize = 56;

/// The flash address of the provisioning page: the STM32F405's last sector (ST RM0090, table 5).
/// The firmware's image leaves it free, so a page is written without touching the firmware.
pub const PAGE_ADDRESS: u32 = 0x080E_0000;

const MAGIC: [u8; 4] = *b"UCHK";
const VERSION: u8 = 1;
const MAY_FLY: u8 = 1;

/// The bytes of a key. `Debug` and `defmt::Format` print none of them, so no log contains a key.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Secret([u8; 16]);

impl Secret {
    /// The key with these bytes.
    #[must_use]
    pub const fn new(bytes: [u8; 16]) -> Self {
        Self(bytes)
    }

    /// The bytes, for the code that encrypts with them.
    #[must_use]
    pub const fn expose(&self) -> &[u8; 16] {
        &self.0
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secret(..)")
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Secret {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "Secret(..)");
    }
}

/// The identity and the keys that a drone was provisioned with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct KeysRecord {
    /// The fleet's number: drawn from the fleet's secret, which cannot be told from it.
    pub fleet: u32,
    /// The generation of the fleet's keys.
    pub generation: u8,
    /// The provisioning by which the drone was given these keys.
    pub issue: Issue,
    /// The drone's number.
    pub node: NodeId,
    /// The drone's part in the chain.
    pub role: Role,
    /// Whether cfclient may fly the head through this drone.
    pub may_fly: bool,
    /// The key that all drones of the fleet share.
    pub group: Secret,
    /// The key that only this drone has: the base's key for the base, its node's for any other.
    pub own: Secret,
}

impl KeysRecord {
    /// Whether a page with these keys replaces the keys that the drone has. A page of a fleet that
    /// the drone is in, or was in, must be a later issue: one that was loaded twice must not set
    /// the epochs back.
    #[must_use]
    pub fn supersedes(&self, current: Option<&Self>, ledger: &Ledger) -> bool {
        let later = current.is_none_or(|now| self.fleet != now.fleet || self.issue > now.issue);
        later && !ledger.has(self)
    }

    /// What is to be done with the contents of the provisioning page on a drone that has the keys
    /// `current`, and this ledger of those that it had.
    #[must_use]
    pub fn on_page(page: &[u8], current: Option<&Self>, ledger: &Ledger) -> Page {
        match Self::decode(page) {
            Ok((keys, _)) if keys.supersedes(current, ledger) => {
                let (policy, after) =
                    part(page.get(LENGTH..).unwrap_or_default(), POLICY_LENGTH, decode_policy);
                let (limits, after) = part(after, LIMITS_LENGTH, decode_limits);
                let (mission, _) = part(after, MISSION_LENGTH, PageMission::decode);
                Page::New { keys, policy, limits, mission }
            }
            Ok(_) => Page::Old,
            // Erased words and wiped ones, also where a wipe was cut short.
            Err(_) if page.iter().all(|byte| matches!(byte, 0 | 0xFF)) => Page::Empty,
            Err(Error::Version(version)) => Page::Unknown(version),
            Err(error) => Page::Damaged(error),
        }
    }

    fn check(&self) -> Result<(), Error> {
        let known = usize::from(self.node.0) < NODES && self.generation != 0;
        if known && (!self.may_fly || self.role == Role::Base) { Ok(()) } else { Err(Error::Value) }
    }
}

/// The contents of the provisioning page, by what is to be done with them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Page {
    /// The page was erased or wiped: there is nothing to do.
    Empty,
    /// The page holds new keys: policy, limits and mission and then the keys are written to the EEPROM, the
    /// keys into both slots, and then the page is wiped.
    New {
        /// The keys.
        keys: KeysRecord,
        /// The movement policy for the drone's settings; `None` leaves the one that is there.
        policy: Option<PolicyCode>,
        /// The limits for the drone's settings, both of them; `None` leaves those that are there.
        limits: Option<Limits>,
        /// The mission for the drone's settings; `None` leaves the one that is there.
        mission: Option<PageMission>,
    },
    /// The page holds keys that are not newer than the drone's, or that the drone has had before: it
    /// is wiped.
    Old,
    /// The page holds keys of a version that this code does not know: it stays for the firmware
    /// that does.
    Unknown(u8),
    /// The page holds no keys: it is wiped.
    Damaged(Error),
}

const POLICY_MAGIC: [u8; 2] = *b"UP";
const POLICY_VERSION: u8 = 1;

/// Bytes of a policy on the page.
pub const POLICY_LENGTH: usize = 8;

/// The bytes by which a page, after its keys, gives the drone a movement policy.
#[must_use]
pub fn encode_policy(policy: PolicyCode) -> [u8; POLICY_LENGTH] {
    sealed(&[&POLICY_MAGIC, &[POLICY_VERSION, policy.get()]])
}

fn decode_policy(bytes: &[u8]) -> Option<PolicyCode> {
    check_crc(bytes, POLICY_LENGTH).ok()?;
    match bytes {
        [m0, m1, POLICY_VERSION, code, ..] if [*m0, *m1] == POLICY_MAGIC => PolicyCode::new(*code),
        _ => None,
    }
}

/// A part of the page that may be at the beginning of these bytes, and the bytes behind it.
fn part<T>(bytes: &[u8], length: usize, decode: impl Fn(&[u8]) -> Option<T>) -> (Option<T>, &[u8]) {
    match decode(bytes) {
        Some(part) => (Some(part), bytes.get(length..).unwrap_or_default()),
        None => (None, bytes),
    }
}

/// Two letters, the version and zero.
const LIMITS_MAGIC: [u8; 4] = *b"UL\x01\0";

/// Bytes of the limits on the page.
pub const LIMITS_LENGTH: usize = 16;

/// The bytes by which a page, after its keys and its policy, gives the drone both limits of links.
#[must_use]
pub fn encode_limits(launch: Dbm, retreat: Dbm) -> [u8; LIMITS_LENGTH] {
    let [launch, retreat] = [launch, retreat].map(|limit| limit.0.to_le_bytes());
    sealed(&[&LIMITS_MAGIC, &launch, &retreat])
}

fn decode_limits(bytes: &[u8]) -> Option<Limits> {
    check_crc(bytes, LIMITS_LENGTH).ok()?;
    let limits = Limits::decode(&mut Reader::after_magic(bytes, LIMITS_MAGIC).ok()?).ok()?;
    (limits.launch.is_some() && limits.retreat.is_some()).then_some(limits)
}

const MISSION_MAGIC: [u8; 4] = *b"UCHM";
const MISSION_VERSION: u8 = 1;

/// Bytes of a mission on the page.
pub const MISSION_LENGTH: usize = 13 + swarm_plan::LENGTH;

/// Bytes of a page with all that it may hold.
pub const PAGE_LENGTH: usize = LENGTH + POLICY_LENGTH + LIMITS_LENGTH + MISSION_LENGTH;

/// A mission on the page, for the drone's settings.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PageMission {
    /// The mission.
    pub kind: MissionKind,
    /// The plan of a swarm's mission; `None` for the agent's default.
    pub swarm: Option<SwarmPlan>,
    /// Whether the drones are fetched after the mission, so that none keeps charge for its way home.
    pub fetched: bool,
}

impl PageMission {
    /// The bytes by which a page gives the drone this mission.
    ///
    /// # Errors
    /// If a drone could not keep the plan.
    pub fn encode(&self) -> Result<[u8; MISSION_LENGTH], Error> {
        let plan = SwarmPlan::encode(self.swarm.as_ref())?;
        let mission = mission_byte(self.kind, self.fetched);
        let fields: [&[u8]; 3] = [&MISSION_MAGIC, &[MISSION_VERSION, mission], &plan];
        Ok(sealed(&fields))
    }

    fn decode(bytes: &[u8]) -> Option<Self> {
        let mut fields =
            Reader::of_record(bytes, MISSION_LENGTH, MISSION_MAGIC, MISSION_VERSION).ok()?;
        let (kind, fetched) = mission_of_byte(fields.u8().ok()?)?;
        let swarm = SwarmPlan::decode(&mut fields).ok()?;
        Some(Self { kind, swarm, fetched })
    }

    /// Returns settings with this mission.
    #[must_use]
    pub const fn applied_to(self, settings: Settings) -> Settings {
        let Self { kind, swarm, fetched } = self;
        Settings { mission: kind, swarm, fetched, ..settings }
    }
}

impl Record for KeysRecord {
    type Bytes = [u8; LENGTH];
    const LENGTH: usize = LENGTH;
    const ADDRESSES: [u16; 2] = [0x240, 0x340];

    fn encode(&self, sequence: u32) -> Result<[u8; LENGTH], Error> {
        self.check()?;
        let flags = if self.may_fly { MAY_FLY } else { 0 };
        Ok(sealed(&[
            &MAGIC,
            &[VERSION],
            &sequence.to_le_bytes(),
            &[self.generation, self.node.0, role_code(self.role), flags, self.issue.get(), 0, 0],
            &self.fleet.to_le_bytes(),
            self.group.expose(),
            self.own.expose(),
        ]))
    }

    fn decode(bytes: &[u8]) -> Result<(Self, u32), Error> {
        let (record, _) = bytes.split_first_chunk::<LENGTH>().ok_or(Error::Short)?;
        let mut fields = Reader::after_magic(record, MAGIC)?;
        // Before the CRC, which another version may have elsewhere.
        let version = fields.u8()?;
        if version != VERSION {
            return Err(Error::Version(version));
        }
        check_crc(record, LENGTH)?;
        let sequence = fields.u32()?;
        let [generation, node, role, flags, issue, z0, z1] = fields.array()?;
        if flags & !MAY_FLY != 0 || [z0, z1] != [0, 0] {
            return Err(Error::Value);
        }
        let keys = Self {
            generation,
            node: NodeId(node),
            role: role_of_code(role)?,
            may_fly: flags & MAY_FLY != 0,
            issue: Issue::new(issue).ok_or(Error::Value)?,
            fleet: fields.u32()?,
            group: Secret::new(fields.array()?),
            own: Secret::new(fields.array()?),
        };
        keys.check()?;
        Ok((keys, sequence))
    }
}
