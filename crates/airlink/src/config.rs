//! Timeouts, intervals and repeat counts of the link.

use units::{Duration, NodeId};

/// The timeouts, intervals and repeat counts of a link. Every time is measured on the node's own
/// clock.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LinkConfig {
    /// The largest number of times that a node sends a capsule, unless it receives the same capsule
    /// from a node nearer to the destination.
    pub tries: u8,
    /// The same of a command to the head, which steers by it.
    pub head_tries: u8,
    /// Whether an outward turn that begins with a command to the head sends it twice, where the
    /// turn has room.
    pub doubles: bool,
    /// A node that was not heard for longer than this is not named in reports, and its frame is not
    /// followed.
    pub lost_after: Duration,
    /// A packet with a later epoch of a node that was heard less than this ago is taken for a
    /// second node with the same number.
    pub alive: Duration,
    /// A node that has been a member for this long keeps its number when a newcomer claims it.
    pub settles_after: Duration,
    /// A stored capsule that was stored or sent longer ago than this is no longer used to decide
    /// which capsules of its far end are new.
    pub forgets_after: Duration,
    /// A packet, or an order, that is later than this beside the fastest of its sender was held back
    /// and is refused.
    pub held_after: Duration,
    /// The strength and the phase of a packet that is later than this beside the fastest of its sender
    /// say nothing about the sender, and are not used.
    pub prompt_within: Duration,
    /// The time between two commands to the head while the operator steers it.
    pub stick_every: Duration,
    /// The base sends an order to explore to the head only until the order is this old.
    pub stick_lasts: Duration,
    /// The time that a node's telemetry has to acknowledge a new order before the base repeats it.
    pub again_after: Duration,
    /// The time between two repeats of an order, each to the next node that has not acknowledged
    /// it.
    pub again_every: Duration,
    /// The time between two repeats of an order, each to the next node, acknowledged or not.
    pub remind_every: Duration,
    /// The time between beacons.
    pub beacon_every: Duration,
    /// The time between two telemetry packets of a relay.
    pub telemetry_every: Duration,
    /// The time between two telemetry packets of the head.
    pub head_telemetry_every: Duration,
}

impl LinkConfig {
    /// The most times that a node sends a command to `node`.
    pub(crate) const fn command_tries(&self, node: NodeId) -> u8 {
        if node.0 == NodeId::HEAD.0 { self.head_tries } else { self.tries }
    }

    /// The values that gave short delays in the measurements of `tests/suite/delay.rs`.
    pub const DEFAULT: Self = Self {
        // A hop fails 10 times in a row once in 1,000 at 50 % loss, once in 35 at 70 %. Few of the
        // tries are used, because a node stops once it has heard the capsule from farther along.
        // With 20 tries telemetry of 16 nodes at 70 % loss took 4.6 s, 95th percentile, and with 10
        // 2.9 s: all turns are taken there.
        tries: 10,
        // At 70 % loss an order's delay over 15 hops, 95th percentile, was 0.93 s with 10 and is
        // 0.71 s with 20.
        head_tries: 20,
        // Reduced an order's delay over 8 hops at 20 % loss from 0.46 to 0.28 s, before nodes shared
        // turns.
        doubles: true,
        // 10 reports, 2 beacons; `chain` counts a neighbour as lost at about that time.
        lost_after: Duration::from_secs(2),
        // 5 reports: all lost at 20 % once in 3,000. A node that is back sooner after a reboot is
        // accepted when that time is over.
        alive: Duration::from_secs(1),
        settles_after: Duration::from_secs(2),
        // Three times as long as one node sends a capsule: its tries, one in a frame.
        forgets_after: Duration::from_secs(3),
        // Ten rounds of the agent: an order that is older was given for another situation. An order
        // that needs longer on its way through a chain that loses most packets is replaced by then.
        held_after: Duration::from_secs(2),
        // Six steps of the stamp. Four packets in neighbouring turns run ahead of the time by three,
        // and the two ends round by one each.
        prompt_within: Duration::from_millis(50),
        // The agent's round (design: 5 Hz).
        stick_every: Duration::from_millis(200),
        // Two rounds and a half: one lost set-point is bridged, a dead console is not.
        stick_lasts: Duration::from_millis(500),
        // Mostly enough for an order and its acknowledgement over 15 hops at 20 % loss. An earlier
        // repeat would replace the order that is still on its way: with 0.4 s, 16 nodes took 0.3 s
        // longer to stop.
        again_after: Duration::from_secs(1),
        // One repeat in a frame leaves room for the acknowledgements.
        again_every: Duration::from_millis(100),
        remind_every: Duration::from_secs(1),
        beacon_every: Duration::from_secs(1),
        telemetry_every: Duration::from_secs(1),
        head_telemetry_every: Duration::from_millis(500),
    };
}

impl Default for LinkConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}
