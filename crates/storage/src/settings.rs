//! The settings of a drone: its number and role, its radio, how its board is mounted, and how it
//! flies in the chain.
//!
//! A record takes 64 bytes:
//!
//! | byte | type | field | unit |
//! |---|---|---|---|
//! | 0 | 4 bytes | `UCHN` | |
//! | 4 | `u8` | version, 6 | |
//! | 5 | `u32` | sequence number: the newer of two records has the larger one | |
//! | 9 | `u8` | node number | |
//! | 10 | `u8` | role: 0 head, 1 relay, 2 base | |
//! | 11 | `u8` | channel | |
//! | 12 | `u8` | data rate: 0, 1, 2 for 250 k, 1 M, 2 Mbit/s | |
//! | 13 | 5 bytes | address, last byte first | |
//! | 18 | `i8` | transmit power | dBm |
//! | 19 | `u8` | movement policy by its code, or zero for the default | |
//! | 20 | `f32` | trim in pitch | rad |
//! | 24 | `f32` | trim in roll | rad |
//! | 28 | `f32` | flying height, or zero for the default | m |
//! | 32 | `f32` | launch limit, or zero for the default | dBm |
//! | 36 | `f32` | retreat limit, or zero for the default | dBm |
//! | 40 | `u8` | mission: 0 chain, 1 swarm, 2 explore; and 128 where the drones are fetched after it | |
//! | 41 | 19 bytes | plan of a swarm's mission ([`SwarmPlan`]), or zeros for the default | |
//! | 60 | `u32` | CRC-32 of the bytes before | |
//!
//! Versions 1 to 5 are read and never written. In version 5 no drone is fetched. Version 4 has no plan
//! either: its CRC stands at byte 41. Version 3 has no mission either: its CRC stands at byte 40, and the
//! drone flies in a chain. Version 2 also has zero at byte 19: no policy. Version 1 also has
//! no limits: its CRC stands at byte 32.

use units::{Dbm, Metres, MissionKind, NODES, NodeId, PolicyCode, Radians, Role};
use wire::radio::{Address, Channel, Datarate, TxPower};

use crate::bytes::{Reader, check_crc, role_code, role_of_code, sealed};
use crate::vendor::VendorConfig;
use crate::{Error, Record, swarm_plan};

pub use crate::swarm_plan::SwarmPlan;

/// Bytes of a record.
pub const LENGTH: usize = LENGTH_4 + swarm_plan::LENGTH;
/// Bytes of a record of version 4.
const LENGTH_4: usize = 45;
/// Bytes of a record of versions 2 and 3.
const LENGTH_3: usize = 44;
/// Bytes of a record of version 1.
const LENGTH_1: usize = 36;

const MAGIC: [u8; 4] = *b"UCHN";
/// The version that is written.
const VERSION: u8 = 6;
/// The version in which no drone is fetched.
const VERSION_5: u8 = 5;
/// The version without a plan.
const VERSION_4: u8 = 4;
/// The version without a mission.
const VERSION_3: u8 = 3;
/// The version without a policy.
const VERSION_2: u8 = 2;
/// The version without limits.
const VERSION_1: u8 = 1;

/// The bit of the mission's byte that says that the drones are fetched.
const FETCHED: u8 = 0x80;

/// The largest trim that is accepted: the boards of a batch differ by a degree or two, and 20° is
/// another mounting and no trim.
const MAX_TRIM: Radians = Radians(0.35);

/// The largest flying height: the down-looking ranger does not see farther (VL53L1X data sheet,
/// maximum ranging distance).
const MAX_HEIGHT: Metres = Metres(4.0);

/// The settings of a drone, which it keeps while it is switched off.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    /// The drone's number.
    pub node: NodeId,
    /// The drone's part in the chain.
    pub role: Role,
    /// The configuration of its radio.
    pub radio: Radio,
    /// The tilt of its board against the airframe.
    pub trim: Trim,
    /// The height at which it flies; `None` for the agent's default.
    pub height: Option<Metres>,
    /// The weakest links that it accepts.
    pub limits: Limits,
    /// The movement policy that it flies; `None` for the agent's default. A code that the firmware
    /// does not know, because another version of it wrote the record, also means the default.
    pub policy: Option<PolicyCode>,
    /// The mission that the drone flies. All drones of a fleet should fly the same.
    pub mission: MissionKind,
    /// The plan of a swarm's mission; `None` for the agent's default. All drones of a swarm must have
    /// the same.
    pub swarm: Option<SwarmPlan>,
    /// Whether the drones are fetched after the mission, so that none keeps charge for its way home.
    /// All drones of a fleet should have the same: one that keeps it calls the whole chain home.
    pub fetched: bool,
}

/// The weakest links that a drone accepts; `None` for the agent's default. All drones of a chain
/// should have the same limits. The agent checks that the two fit each other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    /// A last link weaker than this calls for the next relay.
    pub launch: Option<Dbm>,
    /// A back link weaker than this sends a drone back.
    pub retreat: Option<Dbm>,
}

impl Limits {
    /// The agent's own limits.
    pub const DEFAULT: Self = Self { launch: None, retreat: None };

    /// The weakest and the strongest limit that are accepted: below, the nRF51 receives nothing
    /// (its product specification, sensitivity at 250 kbit/s); above, two drones are within a
    /// hand's breadth.
    pub const RANGE: [Dbm; 2] = [Dbm(-96.0), Dbm(-20.0)];

    fn encode(self) -> Result<[[u8; 4]; 2], Error> {
        let bytes = |limit: Option<Dbm>| match limit {
            None => Ok([0; 4]),
            Some(limit) => Self::checked(limit).map(|limit| limit.0.to_le_bytes()),
        };
        Ok([bytes(self.launch)?, bytes(self.retreat)?])
    }

    pub(crate) fn decode(fields: &mut Reader<'_>) -> Result<Self, Error> {
        let mut limit = || fields.optional_f32()?.map(Dbm).map(Self::checked).transpose();
        Ok(Self { launch: limit()?, retreat: limit()? })
    }

    fn checked(limit: Dbm) -> Result<Dbm, Error> {
        let [weakest, strongest] = Self::RANGE;
        if limit >= weakest && limit <= strongest { Ok(limit) } else { Err(Error::Value) }
    }
}

/// The configuration of a drone's radio.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Radio {
    /// The channel; all drones of a chain are on one.
    pub channel: Channel,
    /// The data rate; all drones of a chain have the same.
    pub datarate: Datarate,
    /// This drone's own address, at which the vendor's tools find it.
    pub address: Address,
    /// The transmit power.
    pub power: TxPower,
}

/// The tilt of a board against its airframe, as the vendor's tools measure and sign it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Trim {
    /// The tilt in pitch.
    pub pitch: Radians,
    /// The tilt in roll.
    pub roll: Radians,
}

impl Trim {
    pub(crate) fn checked(self) -> Result<Self, Error> {
        let small = |angle: Radians| angle.abs() <= MAX_TRIM;
        if small(self.pitch) && small(self.roll) { Ok(self) } else { Err(Error::Value) }
    }
}

impl Settings {
    /// The settings of a drone that was never configured: the first relay, with the vendor's
    /// defaults (crazyflie-firmware, `configblockeeprom.c`; power: crazyflie2-nrf-firmware,
    /// `esb.c`).
    pub const DEFAULT: Self = Self {
        node: NodeId(1),
        role: Role::Relay,
        radio: Radio {
            channel: Channel::DEFAULT,
            datarate: Datarate::Mbit2,
            address: Address::DEFAULT,
            power: TxPower::Zero,
        },
        trim: Trim { pitch: Radians::ZERO, roll: Radians::ZERO },
        height: None,
        limits: Limits::DEFAULT,
        policy: None,
        mission: MissionKind::Chain,
        swarm: None,
        fetched: false,
    };

    /// These settings with the radio and the trims of the vendor's configuration block.
    #[must_use]
    pub const fn with_vendor(mut self, vendor: &VendorConfig) -> Self {
        self.radio.channel = vendor.channel;
        self.radio.datarate = vendor.datarate;
        self.radio.address = vendor.address;
        self.trim = vendor.trim;
        self
    }
}

/// The source of a drone's settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Source {
    /// They were read from this firmware's record.
    Record,
    /// There is no record: they were taken from the vendor's configuration block.
    Vendor,
    /// Neither can be read: they are [`Settings::DEFAULT`].
    Default,
}

impl Settings {
    /// The settings of a drone without a record, from what was read of the vendor's configuration
    /// block. The last byte of its address becomes the drone's number, if there is such a node.
    #[must_use]
    pub fn without_record(vendor_block: Option<&[u8]>) -> (Self, Source) {
        match vendor_block.and_then(|block| VendorConfig::decode(block).ok()) {
            None => (Self::DEFAULT, Source::Default),
            Some(vendor) => {
                let settings = Self::DEFAULT.with_vendor(&vendor);
                let [.., last] = vendor.address.0;
                match usize::from(last) < NODES {
                    true => (settings.with_node(NodeId(last)), Source::Vendor),
                    false => (settings, Source::Vendor),
                }
            }
        }
    }

    /// These settings for another node, with the role that its number usually has.
    #[must_use]
    pub const fn with_node(self, node: NodeId) -> Self {
        Self { node, role: Role::usual_of(node), ..self }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Record for Settings {
    type Bytes = [u8; LENGTH];
    const LENGTH: usize = LENGTH;
    const ADDRESSES: [u16; 2] = [0x200, 0x300];

    fn encode(&self, sequence: u32) -> Result<[u8; LENGTH], Error> {
        let trim = self.trim.checked()?;
        let height = self.height.map_or(Ok(Metres::ZERO), checked_height)?;
        let [launch, retreat] = self.limits.encode()?;
        let plan = SwarmPlan::encode(self.swarm.as_ref())?;
        Ok(sealed(&[
            &MAGIC,
            &[VERSION],
            &sequence.to_le_bytes(),
            &[
                self.node.0,
                role_code(self.role),
                self.radio.channel.number(),
                self.radio.datarate.code(),
            ],
            &self.radio.address.to_le_bytes(),
            &self.radio.power.code().to_le_bytes(),
            &[self.policy.map_or(0, PolicyCode::get)],
            &trim.pitch.0.to_le_bytes(),
            &trim.roll.0.to_le_bytes(),
            &height.0.to_le_bytes(),
            &launch,
            &retreat,
            &[mission_byte(self.mission, self.fetched)],
            &plan,
        ]))
    }

    fn decode(bytes: &[u8]) -> Result<(Self, u32), Error> {
        let mut fields = Reader::after_magic(bytes, MAGIC)?;
        // The version comes before the CRC, which stands where the version says.
        let version = fields.u8()?;
        let length = match version {
            VERSION_1 => LENGTH_1,
            VERSION_2 | VERSION_3 => LENGTH_3,
            VERSION_4 => LENGTH_4,
            VERSION_5 | VERSION => LENGTH,
            version => return Err(Error::Version(version)),
        };
        check_crc(bytes, length)?;
        let sequence = fields.u32()?;
        let mut fetched = false;
        let settings = Self {
            node: NodeId(fields.u8()?),
            role: role_of_code(fields.u8()?)?,
            radio: Radio {
                channel: Channel::new(fields.u8()?).ok_or(Error::Value)?,
                datarate: Datarate::from_code(fields.u8()?).ok_or(Error::Value)?,
                address: Address::from_le_bytes(fields.array()?),
                power: TxPower::from_code(fields.array().map(i8::from_le_bytes)?)
                    .ok_or(Error::Value)?,
            },
            policy: match (version, PolicyCode::new(fields.u8()?)) {
                (VERSION_1 | VERSION_2, Some(_)) => return Err(Error::Value),
                (_, policy) => policy,
            },
            trim: Trim { pitch: Radians(fields.f32()?), roll: Radians(fields.f32()?) }.checked()?,
            height: fields.optional_f32()?.map(Metres).map(checked_height).transpose()?,
            limits: match version {
                VERSION_1 => Limits::DEFAULT,
                _ => Limits::decode(&mut fields)?,
            },
            mission: match version {
                VERSION_1 | VERSION_2 | VERSION_3 => MissionKind::Chain,
                _ => {
                    let (mission, is_fetched) =
                        mission_of_byte(fields.u8()?).ok_or(Error::Value)?;
                    if is_fetched && version != VERSION {
                        return Err(Error::Value);
                    }
                    fetched = is_fetched;
                    mission
                }
            },
            swarm: match version {
                VERSION_5 | VERSION => SwarmPlan::decode(&mut fields)?,
                _ => None,
            },
            fetched,
        };
        Ok((settings, sequence))
    }
}

/// The byte of a mission, and whether its drones are fetched after it.
pub(crate) const fn mission_byte(mission: MissionKind, fetched: bool) -> u8 {
    mission.code() | if fetched { FETCHED } else { 0 }
}

/// The mission of such a byte; `None` for a code of no mission.
pub(crate) fn mission_of_byte(byte: u8) -> Option<(MissionKind, bool)> {
    Some((MissionKind::from_code(byte & !FETCHED)?, byte & FETCHED != 0))
}

fn checked_height(height: Metres) -> Result<Metres, Error> {
    if height > Metres::ZERO && height <= MAX_HEIGHT { Ok(height) } else { Err(Error::Value) }
}
