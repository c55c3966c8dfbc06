//! Messages between drones: one in each P2P packet, of at most 60 bytes.
//!
//! A packet is a [`Header`] in clear, a body of at most [`MAX_BODY`] bytes and a tag of [`TAG`]
//! bytes. This module lays out header and bodies; `crates/airlink` encrypts and authenticates them.
//!
//! | kind | body | bytes |
//! |---|---|---|
//! | 1 | [`Beacon`] | 3 |
//! | 2 | [`Report`] | 20, 4 for a [`Signpost`](units::Signpost), and 5 for each [`Heard`] |
//! | 3 | [`Commands`]: one or two of [`Capsule`] with an [`Order`](units::Order) in it | 19 or 38 |
//! | 4 | [`Capsule`] with [`Telemetry`] in it | 29 |
//! | 5 | [`Membership`] | 1 or 5 |
//! | 6 | [`MissionMessage`] | 1 to 44 |
//!
//! A number is rounded to the nearest step; a number beyond the range of its type becomes the
//! largest or smallest value. NaN becomes zero where there must be a number, and none where there
//! may be none. A node whose number is not below [`units::NODES`] cannot be named on the air: it is
//! left out where a node may be left out, and becomes [`units::NODES`] − 1 elsewhere.
//!
//! Each message has exactly one encoding; anything else is an [`Error`], so that this version does
//! not misread a bit that a later version gives a meaning.

mod beacon;
mod capsule;
mod commands;
mod header;
mod membership;
mod mission;
mod order;
mod report;
mod signpost;
mod steps;

use core::fmt;

pub use beacon::Beacon;
pub use capsule::{Capsule, TELEMETRY, Telemetry};
pub use commands::Commands;
pub use header::{Counter, Epoch, HEADER, Header, Kind, REUSE, STAMP_US, VERSION, Wave};
pub use membership::Membership;
pub use mission::MissionMessage;
pub use order::{ORDER, decode_order, encode_order};
pub use report::{HEARD, Heard, Report};
pub use signpost::{SIGNPOST, decode_signpost, encode_signpost};

use crate::syslink::MAX_P2P;

/// The P2P port of all packets of the chain. The vendor's examples have 0, its token ring 15
/// (crazyflie-firmware, `docs/functional-areas/p2p_api.md` and `src/modules/src/p2pDTR`).
pub const PORT: u8 = 11;

/// Bytes of the tag at the end of every packet.
pub const TAG: usize = 8;

/// The most bytes of a body.
pub const MAX_BODY: usize = MAX_P2P - HEADER - TAG;

/// A message.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Message {
    /// The sender exists: its role, state and battery.
    Beacon(Beacon),
    /// How the sender flies, and how well it hears the others.
    Report(Report),
    /// Orders of the base to one node or to two, passed on by the nodes between them.
    Command(Commands),
    /// The state of one node for the base, passed on by the nodes between them.
    Telemetry(Capsule<TELEMETRY>),
    /// A node joins or leaves the chain, or is refused.
    Membership(Membership),
    /// A drone tells the others of its mission what only the mission reads.
    Mission(MissionMessage),
}

impl Message {
    /// The kind that the header of this message has.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        match self {
            Self::Beacon(_) => Kind::Beacon,
            Self::Report(_) => Kind::Report,
            Self::Command(_) => Kind::Command,
            Self::Telemetry(_) => Kind::Telemetry,
            Self::Membership(_) => Kind::Membership,
            Self::Mission(_) => Kind::Mission,
        }
    }

    /// Writes the body to the beginning of `out` and returns its length.
    pub fn encode(&self, out: &mut [u8; MAX_BODY]) -> usize {
        match self {
            Self::Beacon(beacon) => fill(out, [&beacon.encode()]),
            Self::Report(report) => report.encode(out),
            Self::Command(commands) => commands.encode(out),
            Self::Telemetry(capsule) => capsule.encode(out),
            Self::Membership(membership) => fill(out, [&membership.encode()]),
            Self::Mission(message) => message.encode(out),
        }
    }

    /// The message of this kind with this body.
    ///
    /// # Errors
    /// [`Error::Length`], [`Error::Code`] or [`Error::Reserved`].
    pub fn decode(kind: Kind, body: &[u8]) -> Result<Self, Error> {
        match kind {
            Kind::Beacon => Beacon::decode(body).map(Self::Beacon),
            Kind::Report => Report::decode(body).map(Self::Report),
            Kind::Command => Commands::decode(body).map(Self::Command),
            Kind::Telemetry => Capsule::decode(body).map(Self::Telemetry),
            Kind::Membership => Membership::decode(body).map(Self::Membership),
            Kind::Mission => MissionMessage::decode(body).map(Self::Mission),
        }
    }
}

/// Copies the parts one behind the other, as many as there is room for, and returns their length.
fn fill<const N: usize>(out: &mut [u8; MAX_BODY], parts: [&[u8]; N]) -> usize {
    parts.into_iter().fold(0, |length, part| {
        let end = length + part.len();
        let Some(room) = out.get_mut(length..end) else { return length };
        room.copy_from_slice(part);
        end
    })
}

/// The bytes as an array, if there are `N` of them.
fn exactly<const N: usize>(bytes: &[u8]) -> Result<[u8; N], Error> {
    bytes.try_into().map_err(|_| Error::Length(bytes.len()))
}

/// Why bytes are no message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error {
    /// The packet has a version that this code does not know.
    Version(u8),
    /// There is no message of this kind.
    Kind(u8),
    /// The body has this many bytes, which are too few or too many.
    Length(usize),
    /// A field has a code without a meaning.
    Code(u8),
    /// Bits without a meaning are set, or numbers contradict each other.
    Reserved,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Version(version) => write!(f, "a packet of the unknown version {version}"),
            Self::Kind(kind) => write!(f, "a packet of the unknown kind {kind}"),
            Self::Length(bytes) => write!(f, "{bytes} bytes, which are too few or too many"),
            Self::Code(code) => write!(f, "a message with the unknown code {code:#04x}"),
            Self::Reserved => f.write_str("a message with bits that have no meaning"),
        }
    }
}

impl core::error::Error for Error {}
