//! Counts of packets that the link has accepted, refused and sent since boot.

use wire::p2p::Kind;

/// Counts of packets and turns since boot. Each count wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Packets that passed the checks of the hop.
    pub taken: Kinds,
    /// Packets that failed a check of the hop, and capsules that failed a check of their own.
    pub refused: Refused,
    /// Packets that were sent.
    pub sent: Kinds,
    /// Turns that passed without the packet that was due in them, because
    /// [`transmit`](crate::Airlink::transmit) was called too late.
    pub missed: u32,
}

/// Counts by kind of packet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Kinds {
    /// The number of beacons.
    pub beacons: u32,
    /// The number of reports.
    pub reports: u32,
    /// The number of commands, own and relayed.
    pub commands: u32,
    /// The number of telemetry packets, own and relayed.
    pub telemetry: u32,
    /// The number of membership packets: joins, leaves and refusals.
    pub membership: u32,
    /// The number of messages of missions.
    pub missions: u32,
}

impl Kinds {
    pub(crate) const fn count(&mut self, kind: Kind) {
        let count = match kind {
            Kind::Beacon => &mut self.beacons,
            Kind::Report => &mut self.reports,
            Kind::Command => &mut self.commands,
            Kind::Telemetry => &mut self.telemetry,
            Kind::Membership => &mut self.membership,
            Kind::Mission => &mut self.missions,
        };
        *count = count.wrapping_add(1);
    }

    /// The sum over all kinds.
    #[must_use]
    pub fn total(&self) -> u32 {
        let Self { beacons, reports, commands, telemetry, membership, missions } = *self;
        [beacons, reports, commands, telemetry, membership, missions]
            .into_iter()
            .fold(0, u32::wrapping_add)
    }
}

/// Counts by the first check that a packet failed, in the order of the checks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Refused {
    /// The version or the kind is unknown, or the packet is too short or too long.
    pub malformed: u32,
    /// The sender's number has no turn.
    pub no_slot: u32,
    /// The tag is wrong: the packet is not of this fleet and key generation, or was damaged.
    pub tag: u32,
    /// The packet is an echo of one that this node has sent in this epoch.
    pub own: u32,
    /// The sender is a second node with this node's number, or with the number of a node that is
    /// still heard.
    pub twin: u32,
    /// The packet is not newer than the last one of its sender.
    pub replayed: u32,
    /// The packet, or an order in it, was held back on its way.
    pub held: u32,
    /// The sender has not proved that it sends now, so the packet may be a recording.
    pub stale: u32,
    /// The tag is right, but the body is no message.
    pub body: u32,
    /// The capsule is for this end, but was not sealed by the other end.
    pub forged: u32,
    /// The capsule is for this end, but older than the last.
    pub outdated: u32,
}

impl Refused {
    pub(crate) const fn count(&mut self, reason: Reason) {
        let count = match reason {
            Reason::Malformed => &mut self.malformed,
            Reason::NoSlot => &mut self.no_slot,
            Reason::Tag => &mut self.tag,
            Reason::Own => &mut self.own,
            Reason::Twin => &mut self.twin,
            Reason::Replayed => &mut self.replayed,
            Reason::Held => &mut self.held,
            Reason::Stale => &mut self.stale,
            Reason::Body => &mut self.body,
            Reason::Forged => &mut self.forged,
            Reason::Outdated => &mut self.outdated,
        };
        *count = count.wrapping_add(1);
    }
}

/// Why a packet, or a capsule in it, was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reason {
    Malformed,
    NoSlot,
    Tag,
    Own,
    Twin,
    Replayed,
    Held,
    Stale,
    Body,
    Forged,
    Outdated,
}
