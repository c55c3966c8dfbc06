//! Whose clock counts: there is no common one, so everybody follows whom it hears nearest to the
//! base, and the base its own.

use units::{Duration, Instant, NodeId};

use crate::schedule::Phase;

/// A node that has been silent for as long is not followed any more. It sends something at least
/// once a second (its beacon); see `LinkConfig::lost_after`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Lead {
    node: NodeId,
    at: Instant,
    /// Whether it was known to speak now.
    fresh: bool,
}

/// The frame as this node has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Follow {
    phase: Phase,
    lead: Option<Lead>,
}

/// Somebody's frame, as a packet has told it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Told {
    pub(crate) by: NodeId,
    pub(crate) fresh: bool,
    pub(crate) phase: Phase,
}

impl Follow {
    /// On the own clock.
    pub(crate) const fn new(now: Instant) -> Self {
        Self { phase: Phase::at(now.as_micros()), lead: None }
    }

    pub(crate) const fn phase(&self) -> Phase {
        self.phase
    }

    pub(crate) fn lead(&self) -> Option<NodeId> {
        self.lead.map(|lead| lead.node)
    }

    /// Takes in a packet that came at `now`. `jump` is more than any packet is late.
    pub(crate) fn hear(&mut self, now: Instant, told: Told, lost_after: Duration, jump: Duration) {
        let current = self.lead.filter(|lead| now.since(lead.at) <= lost_after);
        let rank = |node, fresh| (fresh, node);
        match current {
            Some(lead) if rank(told.by, told.fresh) < rank(lead.node, lead.fresh) => return,
            Some(lead) if lead.node == told.by => self.correct(told.phase, jump),
            _ => self.phase = told.phase,
        }
        self.lead = Some(Lead { node: told.by, at: now, fresh: told.fresh });
    }

    /// Follows `node` no more, but goes on in step.
    pub(crate) fn forget(&mut self, node: NodeId) {
        self.lead = self.lead.filter(|lead| lead.node != node);
    }

    /// Follows nobody from farther out than `me` any more, but goes on in step.
    pub(crate) fn stop_below(&mut self, me: NodeId) {
        self.lead = self.lead.filter(|lead| lead.node > me);
    }

    /// A packet can be late, when its sender was busy, but never early. So what is earlier counts
    /// at once, and what is later only little by little: an eighth of it each time is more than
    /// two clocks drift apart between two packets (100 ppm of 200 ms are 20 µs).
    fn correct(&mut self, phase: Phase, jump: Duration) {
        let error = self.phase.until(phase);
        let far = u64::from(error.unsigned_abs()) > jump.as_micros();
        self.phase = self.phase.moved(if far || error < 0 { error } else { (error + 7) / 8 });
    }
}
