//! The report that every drone sends in each round, five times a second.
//!
//! A report also carries quantities of the whole chain, which each drone updates and passes on to
//! the next: the span of link strengths from the head to the sender, and the sums over all links on
//! either side. The operator's [`Order`](units::Order)s are messages of their own.

use units::{LinkSpan, LinkSum, Metres, MetresPerSecond, NodeId, Phase, Signpost};

/// The report of one drone in one round.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Report {
    /// The sender.
    pub from: NodeId,
    /// A number that grows with every report of the sender and wraps around: the last bits of the
    /// number that the radio link gave the packet.
    pub sequence: u16,
    /// The stage of the sender's mission.
    pub phase: Phase,
    /// The sender's velocity along the tunnel, positive towards the head, by its optic flow.
    pub velocity: MetresPerSecond,
    /// The distance along the tunnel that the sender has flown since take-off, positive towards the
    /// head.
    pub odometer: Metres,
    /// The span of the links from the head to the sender, or `None` where the sender knows of none:
    /// the head itself, and a drone that hears no drone in front.
    pub links: Option<LinkSpan>,
    /// The sums over all links between the sender and the head, and between the sender and the
    /// base; [`LinkSum::NONE`] where the sender is that end, or knows of no link there.
    pub sums: [LinkSum; 2],
    /// The number of relays that wait on the ground or are taking off, as far as the sender knows:
    /// 0 to 3, where 3 also stands for more.
    pub waiting: u8,
    /// The head's velocity along the tunnel, positive away from the base, as the head reported it.
    pub head_velocity: MetresPerSecond,
    /// One entry of the list of the pilot's choices at junctions, another in each report; `None` where
    /// the sender knows of no choice.
    pub signpost: Option<Signpost>,
    /// Whether the whole chain must come home because one of its drones must: no drone can pass
    /// another in a tunnel.
    pub recall: bool,
    /// Whether the head calls for a relay ([`Governor`](crate::governor::Governor)), as far as the
    /// sender knows.
    pub calls: bool,
    /// Whether the signal does not fall evenly along the tunnel, by what the drones from the head to
    /// the sender have measured since their take-offs.
    pub is_uneven: bool,
}

impl Report {
    /// The report of a drone at rest at its take-off place that knows of no link and calls for
    /// nothing.
    #[must_use]
    pub const fn plain(from: NodeId, sequence: u16, phase: Phase) -> Self {
        Self {
            from,
            sequence,
            phase,
            velocity: MetresPerSecond::ZERO,
            odometer: Metres::ZERO,
            links: None,
            sums: [LinkSum::NONE; 2],
            waiting: 0,
            head_velocity: MetresPerSecond::ZERO,
            signpost: None,
            recall: false,
            calls: false,
            is_uneven: false,
        }
    }
}

/// Whether `a` comes after `b` on the circle of 16-bit sequence numbers.
#[must_use]
pub(crate) const fn newer(a: u16, b: u16) -> bool {
    let ahead = a.wrapping_sub(b);
    ahead != 0 && ahead < 0x8000
}
