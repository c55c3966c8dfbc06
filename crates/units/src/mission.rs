//! The vocabulary of a mission: roles, orders, phases and set-points, shared by all crates.

use core::num::NonZeroU8;

use crate::{Db, Dbm, Metres, MetresPerDb, MetresPerSecond, NodeId, RadiansPerSecond};

/// The most nodes that a mission can have, head and base included: a node's number is four bits on
/// the air.
pub const NODES: usize = 16;

/// The part that a node has in the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Role {
    /// The explorer at the far end of the chain, which the operator pilots.
    Head,
    /// A drone between the head and the base.
    Relay,
    /// The operator's end of the chain, which stays on the ground.
    Base,
}

impl Role {
    /// The role that a node has unless it is told another one: the smallest number is the head's,
    /// the largest the base's.
    #[must_use]
    pub const fn usual_of(node: NodeId) -> Self {
        match node.0 {
            0 => Self::Head,
            number if (number as usize) < NODES - 1 => Self::Relay,
            _ => Self::Base,
        }
    }

    /// The name in files and in messages.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Head => "head",
            Self::Relay => "relay",
            Self::Base => "base",
        }
    }
}

/// The mission that a drone flies. All drones of a fleet should fly the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum MissionKind {
    /// A chain of relays keeps the link between an explorer and the base.
    #[default]
    Chain,
    /// A swarm surveys an area, gathers, and crosses a passage, by virtual forces.
    Swarm,
    /// Drones explore an unknown place together, each with a map of its own.
    Explore,
}

impl MissionKind {
    /// All missions.
    pub const ALL: [Self; 3] = [Self::Chain, Self::Swarm, Self::Explore];

    /// The mission's number on the air and in records. A number that is used never changes.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Chain => 0,
            Self::Swarm => 1,
            Self::Explore => 2,
        }
    }

    /// The mission that has this number; `None` where none has.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        match code {
            0 => Some(Self::Chain),
            1 => Some(Self::Swarm),
            2 => Some(Self::Explore),
            _ => None,
        }
    }

    /// The mission's name in scenarios and settings.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Chain => "chain",
            Self::Swarm => "swarm",
            Self::Explore => "explore",
        }
    }

    /// The mission of this name; `None` where there is none.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mission| mission.name() == name)
    }
}

/// What one drone of a mission tells the others in one packet: bytes that only the mission reads.
#[derive(Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Payload {
    bytes: [u8; Self::MOST],
    length: u8,
}

impl Payload {
    /// The most bytes of a payload: what a packet of 60 bytes has left beside a header of 8, a tag of
    /// 8 and the number of the mission.
    pub const MOST: usize = 43;

    /// The payload with these bytes; `None` where they are too many.
    #[must_use]
    pub fn new(bytes: &[u8]) -> Option<Self> {
        let mut payload = Self { bytes: [0; Self::MOST], length: u8::try_from(bytes.len()).ok()? };
        payload.bytes.get_mut(..bytes.len())?.copy_from_slice(bytes);
        Some(payload)
    }

    /// The payload's bytes.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.length)).unwrap_or_default()
    }
}

impl core::fmt::Debug for Payload {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_tuple("Payload").field(&self.as_bytes()).finish()
    }
}

/// An order of the operator: to the head, to a relay, or to the whole mission.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Order {
    /// A drone on the ground stays there, and one that has landed may fly again at the next order
    /// to explore; a head in flight stops where it is.
    Wait,
    /// The head explores on this course, and the relays form the chain behind it.
    Explore(Course),
    /// The head flies back to the base, and each relay lands where it took off.
    Return,
    /// The drone lands where it is.
    Land,
    /// Each drone of the chain lands at its place, if its links bear that, and goes on relaying from the
    /// ground. The order to explore or to return calls it up again.
    Perch,
    /// The drone switches its motors off now and keeps them off until it is reset on the ground.
    Stop,
}

impl Order {
    /// The order to explore at this speed, without a choice for junctions.
    #[must_use]
    pub const fn explore(speed: MetresPerSecond) -> Self {
        Self::Explore(Course { speed, branch: None })
    }
}

/// The course of a head that explores.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Course {
    /// The speed along the tunnel, positive away from the base.
    pub speed: MetresPerSecond,
    /// The branch to take at the junctions that the head comes to; `None` where the pilot has not
    /// chosen one.
    pub branch: Option<Branch>,
}

/// A way on from a junction, as a drone sees it that comes from the base.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Branch {
    /// The gallery farthest to the left.
    Left,
    /// The gallery farthest to the right.
    Right,
    /// The gallery that goes straight on.
    Straight,
}

impl Branch {
    /// The number that stands for a choice at junctions in messages and tables: 0 for none.
    #[must_use]
    pub const fn code(choice: Option<Self>) -> u8 {
        match choice {
            None => 0,
            Some(Self::Left) => 1,
            Some(Self::Right) => 2,
            Some(Self::Straight) => 3,
        }
    }

    /// The choice at junctions that has this number; `None` where none has.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Option<Self>> {
        match code {
            0 => Some(None),
            1 => Some(Some(Self::Left)),
            2 => Some(Some(Self::Right)),
            3 => Some(Some(Self::Straight)),
            _ => None,
        }
    }
}

/// One entry of the list of the pilot's choices, which the chain passes on from the head to the
/// relays: from a place on, one choice counts at all junctions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Signpost {
    /// The number of the list, which grows by one with each change and wraps around.
    pub revision: u8,
    /// The number of this entry in the list, from 0.
    pub index: u8,
    /// The number of entries in the list, 1 to [`SIGNPOSTS`].
    pub count: u8,
    /// The way along the tunnel, by the head's odometer, from which on the choice counts.
    pub from: Metres,
    /// The choice; `None` where the pilot has made none.
    pub branch: Option<Branch>,
}

/// The most entries in the list of the pilot's choices.
pub const SIGNPOSTS: usize = 8;

/// The number that stands for a movement policy in a drone's settings (`chain::policy::REGISTRY`).
/// A policy keeps its code when other policies are added to the registry or removed from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PolicyCode(NonZeroU8);

impl PolicyCode {
    /// The code with this number; `None` for zero, which stands for no policy.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        match NonZeroU8::new(number) {
            Some(number) => Some(Self(number)),
            None => None,
        }
    }

    /// The code's number.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0.get()
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for PolicyCode {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "PolicyCode({=u8})", self.get());
    }
}

/// The stage of its mission that a node reports to its neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Phase {
    /// The node is on the ground at the base and may be launched.
    Waiting,
    /// The node is in the air and not yet a link of the chain.
    Transit,
    /// The node flies as head or relay: it is a link of the chain.
    Linked,
    /// The node is a relay that leaves its place to look for a better one: a link of the chain whose
    /// neighbours hold their places.
    Searching,
    /// The node is a head or a relay on the ground, at its place: a link of the chain.
    Perched,
    /// The node is the operator's end of the chain, on the ground for good.
    Base,
    /// The node is on the ground and out of the mission.
    Out,
}

impl Phase {
    /// Whether the node leaves the ground, or stands on it, and is no link of the chain: its antenna
    /// is not where it will be in the mission.
    #[must_use]
    pub const fn is_low(&self) -> bool {
        matches!(self, Self::Waiting | Self::Transit | Self::Out)
    }

    /// Whether the node's neighbours measure their links to it.
    #[must_use]
    pub const fn is_link(self) -> bool {
        matches!(self, Self::Linked | Self::Searching | Self::Perched | Self::Base)
    }
}

/// The weakest and the strongest of a run of adjacent links: all that a launch policy must know of
/// the whole chain, in a size that does not grow with the chain.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LinkSpan {
    /// The weakest link of the run.
    pub weakest: Dbm,
    /// The strongest link of the run.
    pub strongest: Dbm,
}

impl LinkSpan {
    /// The run `ahead`, if any, lengthened by one link.
    #[must_use]
    pub fn extended(ahead: Option<Self>, link: Dbm) -> Self {
        match ahead {
            None => Self { weakest: link, strongest: link },
            Some(run) => Self {
                weakest: Dbm(run.weakest.0.min(link.0)),
                strongest: Dbm(run.strongest.0.max(link.0)),
            },
        }
    }
}

/// The sums over a run of adjacent links, from which every drone of a chain computes the loss that
/// all links would have if they were equal: what a chain-wide movement policy must know, in a size
/// that does not grow with the chain.
///
/// With the loss r_j and the slope g_j of link j, `surplus` is Σ (r_j − r₀) / g_j: the length by
/// which the run exceeds a run whose links all have the loss r₀ = [`LinkSum::REFERENCE`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LinkSum {
    /// The sum of (r_j − r₀) / g_j.
    pub surplus: Metres,
    /// The sum of 1 / g_j.
    pub compliance: MetresPerDb,
    /// The number of links in the run.
    pub links: u8,
}

impl LinkSum {
    /// The loss r₀, in the middle of the losses of a chain's links underground. Any other value
    /// would give the same movements; this one keeps the transmitted numbers small.
    pub const REFERENCE: Db = Db(64.0);

    /// The sum over a run without any link.
    pub const NONE: Self = Self { surplus: Metres::ZERO, compliance: MetresPerDb::ZERO, links: 0 };

    /// The loss over r₀ that all links of the run would have if they were equal and the run kept
    /// its length; `None` for a run without links.
    #[must_use]
    pub fn level(self) -> Option<Db> {
        (self.compliance.0 > 0.0).then(|| Db(self.surplus.0 / self.compliance.0))
    }

    /// The sum over this run and `other`.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            surplus: self.surplus + other.surplus,
            compliance: self.compliance + other.compliance,
            links: self.links.saturating_add(other.links),
        }
    }
}

/// The set-point by which the mission loop (5 Hz) steers the control loop (1 kHz).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Setpoint {
    /// The motors are off. In the air this drops the drone, so the agent lands it first.
    #[default]
    Off,
    /// The drone holds this velocity, turn rate and height.
    Fly {
        /// Velocity along x, forward.
        forward: MetresPerSecond,
        /// Velocity along y, to the left.
        lateral: MetresPerSecond,
        /// Turn rate, counter-clockwise.
        yaw_rate: RadiansPerSecond,
        /// Height over ground.
        height: Metres,
    },
    /// The motors are off now, and stay off until the next boot.
    Stop,
}

impl Setpoint {
    /// The set-point of a drone that stands still in the air at this height.
    #[must_use]
    pub const fn hover(height: Metres) -> Self {
        Self::Fly {
            forward: MetresPerSecond::ZERO,
            lateral: MetresPerSecond::ZERO,
            yaw_rate: RadiansPerSecond::ZERO,
            height,
        }
    }
}
