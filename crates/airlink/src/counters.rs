//! What the link has counted since boot.

use wire::p2p::Kind;

/// Everything that came in and went out. Each count wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Packets that were taken, as far as the hop goes.
    pub taken: Kinds,
    /// Packets that were not, and capsules in those that were.
    pub refused: Refused,
    /// Packets that were sent.
    pub sent: Kinds,
    /// Turns that were due and went by, because nobody asked in time.
    pub missed: u32,
}

/// Counts by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Kinds {
    /// Beacons.
    pub beacons: u32,
    /// Reports.
    pub reports: u32,
    /// Commands, own and passed on.
    pub commands: u32,
    /// Telemetry, own and passed on.
    pub telemetry: u32,
    /// Who comes, goes, or may not.
    pub membership: u32,
}

impl Kinds {
    pub(crate) const fn count(&mut self, kind: Kind) {
        let count = match kind {
            Kind::Beacon => &mut self.beacons,
            Kind::Report => &mut self.reports,
            Kind::Command => &mut self.commands,
            Kind::Telemetry => &mut self.telemetry,
            Kind::Membership => &mut self.membership,
        };
        *count = count.wrapping_add(1);
    }

    /// All of them.
    #[must_use]
    pub fn total(&self) -> u32 {
        [self.beacons, self.reports, self.commands, self.telemetry, self.membership]
            .into_iter()
            .fold(0, u32::wrapping_add)
    }
}

/// Counts by the first check that a packet failed, in the order of the checks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Refused {
    /// No packet of this version and a known kind, or too short or too long.
    pub malformed: u32,
    /// The sender's number has no turn.
    pub no_slot: u32,
    /// The tag is wrong: not of this fleet and generation, or disturbed on the way.
    pub tag: u32,
    /// What this node has itself said in this epoch.
    pub own: u32,
    /// Of a second node with this node's number, or with the number of one that is still heard.
    pub twin: u32,
    /// Not newer than the last one of its sender.
    pub replayed: u32,
    /// The sender has not proved that it speaks now.
    pub stale: u32,
    /// Sealed well, but no message.
    pub body: u32,
    /// A capsule for this end, not sealed by the other.
    pub forged: u32,
    /// A capsule for this end that is not newer than the last.
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
            Reason::Stale => &mut self.stale,
            Reason::Body => &mut self.body,
            Reason::Forged => &mut self.forged,
            Reason::Outdated => &mut self.outdated,
        };
        *count = count.wrapping_add(1);
    }
}

/// Why a packet says nothing to this node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reason {
    Malformed,
    NoSlot,
    Tag,
    Own,
    Twin,
    Replayed,
    Stale,
    Body,
    Forged,
    Outdated,
}
