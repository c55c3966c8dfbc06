//! What becomes of a node from switching on to switching off, and whether it may speak.

use units::{Duration, Instant};
use wire::p2p::Counter;

use super::Standing;

/// Where a node is in its life. The counter is that of its next packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Life {
    Listening { until: Instant, next: Counter },
    Member { since: Instant, next: Counter },
    Leaving { more: u8, next: Counter },
    Left,
    Refused,
    Exhausted,
}

/// How often a node says that it leaves: both packets of a turn, as there may be no other.
const GOODBYES: u8 = 2;

impl Life {
    /// The next packet's number, for whoever may speak, or will.
    pub(super) const fn next(self) -> Option<Counter> {
        match self {
            Self::Listening { next, .. }
            | Self::Member { next, .. }
            | Self::Leaving { next, .. } => Some(next),
            Self::Left | Self::Refused | Self::Exhausted => None,
        }
    }

    /// A packet has gone out.
    pub(super) fn spoke(&mut self) {
        *self = match (*self, self.next().and_then(Counter::next)) {
            (Self::Leaving { more: 0 | 1, .. }, _) => Self::Left,
            (Self::Leaving { more, .. }, Some(next)) => Self::Leaving { more: more - 1, next },
            (Self::Member { since, .. }, Some(next)) => Self::Member { since, next },
            (Self::Member { .. } | Self::Leaving { .. }, None) => Self::Exhausted,
            (same @ (Self::Listening { .. } | Self::Left | Self::Refused | Self::Exhausted), _) => {
                same
            }
        };
    }

    /// It says goodbye. Who has not said anything yet just goes.
    pub(super) const fn leave(&mut self) {
        *self = match *self {
            Self::Listening { .. } => Self::Left,
            Self::Member { next, .. } => Self::Leaving { more: GOODBYES, next },
            same @ (Self::Leaving { .. } | Self::Left | Self::Refused | Self::Exhausted) => same,
        };
    }

    /// It may not speak, if it still could.
    pub(super) const fn refuse(&mut self) {
        if self.next().is_some() {
            *self = Self::Refused;
        }
    }

    /// Whether it has spoken for `span` and goes on.
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
