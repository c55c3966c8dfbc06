//! What every drone says of itself at each round, and nothing more: 5 times a second, to whoever
//! hears it.
//!
//! A report also passes one thing along the chain, hop by hop: the span of link strengths, in from
//! the head. What the operator wants goes from end to end, apart from reports: a [`Order`].

use units::{LinkSpan, Metres, MetresPerSecond, NodeId, Phase};

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

/// Whether `a` comes after `b` on the circle of 16-bit sequence numbers.
#[must_use]
pub(crate) const fn newer(a: u16, b: u16) -> bool {
    let ahead = a.wrapping_sub(b);
    ahead != 0 && ahead < 0x8000
}
