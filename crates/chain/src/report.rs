//! What every drone says of itself at each round, and nothing more: 5 times a second, to whoever
//! hears it.
//!
//! A report also passes one thing along the chain, hop by hop: the span of link strengths, in from
//! the head. What the operator wants goes from end to end, apart from reports: a [`Task`].

use units::{Dbm, Metres, MetresPerSecond, NodeId};

/// Everything one drone tells its neighbours in one round.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Report {
    /// Who speaks.
    pub from: NodeId,
    /// Grows with every report of the sender, wrapping: the last bits of the number that the radio
    /// link gave the packet.
    pub sequence: u16,
    /// Where the sender is in its mission.
    pub phase: Phase,
    /// The sender's velocity along the tunnel, positive towards the head, by its optic flow.
    pub velocity: MetresPerSecond,
    /// The sender's way along the tunnel since take-off, positive towards the head.
    pub odometer: Metres,
    /// The links from the head down to the sender, or `None` where it knows of none: the head
    /// itself, and a drone that hears nobody in front.
    pub links: Option<LinkSpan>,
    /// Somebody in the chain must come home, and so everybody does: no drone passes another in a
    /// tunnel.
    pub recall: bool,
}

/// A drone's part in the chain, as far as its neighbours need to know it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Phase {
    /// On the ground at the base, free to be launched.
    Waiting,
    /// Between the ground and its place: in the air, not yet a link of the chain.
    Transit,
    /// Flying as head or relay: a link of the chain.
    Linked,
    /// The operator's end of the chain, on the ground for good.
    Base,
    /// On the ground and out of the mission.
    Out,
}

impl Phase {
    /// Whether neighbours measure themselves against this drone.
    #[must_use]
    pub const fn is_link(self) -> bool {
        matches!(self, Self::Linked | Self::Base)
    }
}

/// The weakest and the strongest of a run of links: what a launch policy must know of the whole
/// chain, in a size that does not grow with it.
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

/// What a mission can be told.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Task {
    /// Stay on the ground; a drone that has landed is free to fly again.
    Wait,
    /// Fly: the head at this speed along the tunnel, the relays between it and the base.
    Explore(MetresPerSecond),
    /// Come home: the head flies back, each relay lands where it took off.
    Return,
    /// Land where you are.
    Land,
    /// Stop the motors now and stay off. Latches until reboot.
    Stop,
}

/// Whether `a` comes after `b` on the circle of 16-bit sequence numbers.
#[must_use]
pub(crate) const fn newer(a: u16, b: u16) -> bool {
    let ahead = a.wrapping_sub(b);
    ahead != 0 && ahead < 0x8000
}
