//! The requests of a host and the answers of a drone.

use agent::{BodyVelocity, Outputs};
use chain::filter::LinkEstimate;
use chain::neighbours::{Heard, MAX_NEIGHBOURS};
use chain::policy::Policy;
use heapless::Vec;
use tunnel_nav::Diagonals;
use units::{Dbm, Instant, Metres, NODES, NodeId, Order, PolicyCode, Role};

use super::frame::{Frame, FrameError, send};
use crate::words::{Words, Writer, enums, structs, whole};

/// Reports of one step at most: one of each other drone.
pub const HEARD: usize = NODES - 1;

/// The beginning of a replay: the drone that is to run it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Begin {
    /// The drone's number.
    pub node: NodeId,
    /// The drone's role.
    pub role: Role,
    /// The moment from which on the drone is at its place in the air; `None` for a drone on the
    /// ground.
    pub in_air: Option<Instant>,
    /// The movement policy.
    pub policy: PolicyCode,
    /// Whether the strengths were filtered before they were recorded, so that the drone must not
    /// filter them again.
    pub is_filtered: bool,
    /// The number of links of the recording, for the launch rule.
    pub links: u8,
}

impl Begin {
    /// The policy that the code stands for.
    ///
    /// # Errors
    /// [`Refusal::UnknownPolicy`], where this firmware has none of that code.
    pub fn policy(&self) -> Result<&'static Policy, Refusal> {
        Policy::with_code(self.policy).ok_or(Refusal::UnknownPolicy)
    }
}

/// One round of the drone.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The time by the recording's clock.
    pub now: Instant,
    /// The drone's own velocity; `None` where the recording does not have it.
    pub velocity: Option<BodyVelocity>,
    /// The ranges to the walls.
    pub ranges: Diagonals,
    /// The drone's height.
    pub height: Option<Metres>,
    /// The operator's order.
    pub order: Option<Order>,
    /// The reports that came in since the last round.
    pub heard: Vec<Heard, HEARD>,
    /// The strengths of the recording's links since the last round, for the launch rule: the link's
    /// place from the head's on, and its strength.
    pub strengths: Vec<(u8, Dbm), NODES>,
}

/// A request of the host.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "almost all are steps, and there is no heap")]
pub enum Request {
    /// Begins a replay. It ends one that is under way.
    Begin(Begin),
    /// Runs one round.
    Step(Step),
}

/// The result of one round.
#[derive(Clone, Debug, PartialEq)]
pub struct Stepped {
    /// The processor's cycles that the round took.
    pub cycles: u32,
    /// Whether the launch rule begins to call for a relay.
    pub launches: bool,
    /// The set-point, the report and the state of the drone.
    pub outputs: Outputs,
    /// The estimate of the link to each drone that was heard.
    pub estimates: Vec<(NodeId, LinkEstimate), MAX_NEIGHBOURS>,
}

/// The answer of the drone to a request.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "almost all are steps, and there is no heap")]
pub enum Answer {
    /// The replay has begun.
    Begun,
    /// The round was run.
    Stepped(Stepped),
    /// The request was not carried out.
    Refused(Refusal),
}

/// Why a request was not carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// The bytes were no frame, or the frame no request.
    Malformed,
    /// The host has another version of the records; the answer's own frame tells the drone's.
    Version,
    /// No replay has begun.
    NotBegun,
    /// There is no movement policy of this code.
    UnknownPolicy,
    /// No debugger is attached.
    NoDebugger,
    /// The drone is not on the ground.
    Airborne,
    /// The drone is on the ground, but its mission is not at its beginning.
    NotIdle,
    /// The drone has not read its settings yet.
    NotReady,
}

structs! {
    Begin { node, role, in_air, policy, is_filtered, links }
    Step { now, velocity, ranges, height, order, heard, strengths }
    Stepped { cycles, launches, outputs, estimates }
}

enums! {
    Refusal {
        0 = Malformed, 1 = Version, 2 = NotBegun, 3 = UnknownPolicy, 4 = NoDebugger, 5 = Airborne,
        6 = NotIdle, 7 = NotReady,
    }
}

/// The kinds of records.
mod kind {
    pub(super) const BEGIN: u8 = 1;
    pub(super) const BEGUN: u8 = 2;
    pub(super) const STEP: u8 = 3;
    pub(super) const STEPPED: u8 = 4;
    pub(super) const REFUSED: u8 = 5;
}

impl Request {
    /// Reads a request.
    ///
    /// # Errors
    /// When the bytes were no frame, or the frame is no request.
    pub fn parse(frame: Result<Frame<'_>, FrameError>) -> Result<(u32, Self), Refusal> {
        let frame = frame.map_err(|why| match why {
            FrameError::Version(_) => Refusal::Version,
            FrameError::Damaged | FrameError::TooLong => Refusal::Malformed,
        })?;
        let request = match frame.kind {
            kind::BEGIN => whole(frame.body, Begin::get).map(Self::Begin),
            kind::STEP => whole(frame.body, Step::get).map(Self::Step),
            _ => None,
        };
        Ok((frame.number, request.ok_or(Refusal::Malformed)?))
    }

    /// Writes the request with its number as a frame, byte by byte.
    pub fn send(&self, number: u32, byte: impl FnMut(u8)) {
        match self {
            Self::Begin(begin) => send(kind::BEGIN, number, |out| begin.put(out), byte),
            Self::Step(step) => send(kind::STEP, number, |out| step.put(out), byte),
        }
    }
}

impl Answer {
    /// Reads an answer and the number of its request; `None` where the frame is no answer.
    #[must_use]
    pub fn parse(frame: &Frame<'_>) -> Option<(u32, Self)> {
        let answer = match frame.kind {
            kind::BEGUN => whole(frame.body, |_| Some(Self::Begun)),
            kind::STEPPED => whole(frame.body, Stepped::get).map(Self::Stepped),
            kind::REFUSED => whole(frame.body, Refusal::get).map(Self::Refused),
            _ => None,
        };
        Some((frame.number, answer?))
    }

    /// Writes the answer with the number of its request as a frame, byte by byte.
    pub fn send(&self, number: u32, byte: impl FnMut(u8)) {
        let kind = match self {
            Self::Begun => kind::BEGUN,
            Self::Stepped(_) => kind::STEPPED,
            Self::Refused(_) => kind::REFUSED,
        };
        let put = |out: &mut Writer<'_>| match self {
            Self::Begun => {}
            Self::Stepped(stepped) => stepped.put(out),
            Self::Refused(why) => why.put(out),
        };
        send(kind, number, put, byte);
    }
}
