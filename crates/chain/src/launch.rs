//! When a waiting relay takes off, section IV-D.
//!
//! The paper gives two rules. Its text launches "when the other flying UAVs converged to an equal
//! links configuration" and that configuration is too weak; its experiments launch as soon as "the
//! last active link reaches the fixed limit". Both are here: the second is the first with no
//! [`settled`](LaunchConfig::settled) spread asked and no [`hold`](LaunchConfig::hold).
//! Launching at once wastes a relay on every unlucky packet; waiting for the chain to settle
//! leaves the links weaker than the limit for longer. The book measures both.

use units::{Db, Dbm, Duration, Instant};

use crate::report::LinkSpan;

/// The constants of the launch policy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaunchConfig {
    /// −s_min: a last link weaker than this calls for a relay.
    pub limit: Dbm,
    /// The chain counts as equal while its strongest and weakest links differ by less; `None`
    /// does not ask.
    pub settled: Option<Db>,
    /// Both must have been so for this long.
    pub hold: Duration,
    /// How long after the drone before it has become a link a relay may follow at the earliest:
    /// TUNNEL_ARM_DELAY of the authors' firmware, 3 s, in which the new link is still forming.
    pub arm_delay: Duration,
}

impl LaunchConfig {
    /// What the paper's experiments did: at once, on the last link alone. The limit is
    /// RSSI_ARMED of the authors' firmware with its penalty of 10 dB for an antenna on the ground.
    pub const AT_ONCE: Self = Self {
        limit: Dbm(-60.0),
        settled: None,
        hold: Duration::ZERO,
        arm_delay: Duration::from_secs(3),
    };

    /// The paper's text: the chain has been equal to within 4 dB, and too weak, for 2 s.
    pub const WHEN_SETTLED: Self =
        Self { settled: Some(Db(4.0)), hold: Duration::from_secs(2), ..Self::AT_ONCE };
}

/// Watches the last link of the chain from the base's end of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaunchWatch {
    wanted_since: Option<Instant>,
}

impl LaunchWatch {
    /// A watch that has seen nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self { wanted_since: None }
    }

    /// Whether a relay should take off now. `last_link` is the strength of the link between the
    /// base and the last flying drone, `None` while nobody in the air is heard: no signal is the
    /// weakest of all. `ahead` is the span of all the links beyond it.
    pub fn step(
        &mut self,
        now: Instant,
        config: &LaunchConfig,
        last_link: Option<Dbm>,
        ahead: Option<LinkSpan>,
    ) -> bool {
        let wanted = match last_link {
            None => true,
            Some(link) => {
                let chain = LinkSpan::extended(ahead, link);
                let settled =
                    config.settled.is_none_or(|most| chain.strongest - chain.weakest < most);
                link < config.limit && settled
            }
        };
        if !wanted {
            self.wanted_since = None;
            return false;
        }
        let since = *self.wanted_since.get_or_insert(now);
        now.since(since) >= config.hold
    }
}
