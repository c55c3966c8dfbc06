//! The life of a node from switching on to switching off: its states, and when it may send.

use units::{Duration, Instant};
use wire::p2p::Counter;

use super::Standing;

/// The state of a node in its life. `next` is the counter of its next packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lifecycle {
    /// The node listens for the other nodes' turns until `until`, and does not send yet.
    Listening { until: Instant, next: Counter },
    /// The node has been sending since `since`.
    Member { since: Instant, next: Counter },
    /// The node announces in this many more packets that it leaves.
    Leaving { packets_left: u8, next: Counter },
    /// The node has announced that it leaves.
    Left,
    /// The node has the number of another node, which keeps it.
    Refused,
    /// The node has used up the counters of its epoch.
    Exhausted,
}

/// Number of packets that announce a leave: both of a turn, because the drone may be switched off
/// before its next.
const LEAVE_PACKETS: u8 = 2;

impl Lifecycle {
    /// The counter of the next packet, if the node may send now or later.
    pub(super) const fn next(self) -> Option<Counter> {
        match self {
            Self::Listening { next, .. }
            | Self::Member { next, .. }
            | Self::Leaving { next, .. } => Some(next),
            Self::Left | Self::Refused | Self::Exhausted => None,
        }
    }

    /// Records that the packet with this counter has been sent.
    pub(super) fn packet_sent(&mut self, counter: Counter) {
        *self = match (*self, counter.next()) {
            (Self::Leaving { packets_left: 0 | 1, .. }, _) => Self::Left,
            (Self::Leaving { packets_left, .. }, Some(next)) => {
                Self::Leaving { packets_left: packets_left - 1, next }
            }
            (Self::Member { since, .. }, Some(next)) => Self::Member { since, next },
            (Self::Member { .. } | Self::Leaving { .. }, None) => Self::Exhausted,
            (same @ (Self::Listening { .. } | Self::Left | Self::Refused | Self::Exhausted), _) => {
                same
            }
        };
    }

    /// Begins to leave. A node that has not sent anything yet leaves without a packet.
    pub(super) const fn leave(&mut self) {
        *self = match *self {
            Self::Listening { .. } => Self::Left,
            Self::Member { next, .. } => Self::Leaving { packets_left: LEAVE_PACKETS, next },
            same @ (Self::Leaving { .. } | Self::Left | Self::Refused | Self::Exhausted) => same,
        };
    }

    /// Forbids the node to send, if it still could.
    pub(super) const fn refuse(&mut self) {
        if self.next().is_some() {
            *self = Self::Refused;
        }
    }

    /// Forbids a node whose counter has no room for the time to send, if it still could.
    pub(super) const fn exhaust(&mut self) {
        if self.next().is_some() {
            *self = Self::Exhausted;
        }
    }

    /// Whether the node has been a member for `span` and still is one.
    pub(super) fn has_settled(self, now: Instant, span: Duration) -> bool {
        match self {
            Self::Member { since, .. } => now.since(since) >= span,
            Self::Listening { .. }
            | Self::Leaving { .. }
            | Self::Left
            | Self::Refused
            | Self::Exhausted => false,
        }
    }

    /// The state as the drone's other tasks see it.
    pub(super) const fn standing(self) -> Standing {
        match self {
            Self::Listening { .. } => Standing::Listening,
            Self::Member { .. } | Self::Leaving { .. } => Standing::Member,
            Self::Left => Standing::Left,
            Self::Refused => Standing::Refused,
            Self::Exhausted => Standing::Exhausted,
        }
    }
}
