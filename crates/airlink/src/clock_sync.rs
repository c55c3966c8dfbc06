//! Synchronises the nodes' time frames without a common clock: each node aligns its frame to that
//! of the node nearest to the base that it receives, and the base keeps its own.

use units::{Duration, Instant, NodeId};

use crate::schedule::FramePhase;

/// The node whose frame this node follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Leader {
    node: NodeId,
    /// When the leader's last packet came. A leader that has been silent for
    /// `LinkConfig::lost_after` is replaced by the next node that is heard; every node sends at
    /// least a beacon a second.
    heard_at: Instant,
    /// Whether the leader was fresh when its last packet came.
    fresh: bool,
}

/// This node's frame, and the node whose frame it follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ClockSync {
    phase: FramePhase,
    leader: Option<Leader>,
    /// A phase far from the own one, and when a packet first told of it.
    doubtful: Option<(FramePhase, Instant)>,
}

/// Half a frame: longer than the turns in which a burst is sent.
const DOUBT: Duration = Duration::from_millis(50);

/// The frame of a packet's sender, derived from that packet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObservedFrame {
    pub(crate) sender: NodeId,
    pub(crate) fresh: bool,
    pub(crate) phase: FramePhase,
}

impl ClockSync {
    /// A frame on this node's own clock, which begins at `now`.
    pub(crate) const fn new(now: Instant) -> Self {
        Self { phase: FramePhase::at(now.as_micros()), leader: None, doubtful: None }
    }

    pub(crate) const fn phase(&self) -> FramePhase {
        self.phase
    }

    pub(crate) fn leader(&self) -> Option<NodeId> {
        self.leader.map(|leader| leader.node)
    }

    /// Aligns this node's frame to the one that a packet at `now` told of, unless a better leader
    /// is still heard. A difference above `jump`, which exceeds any lateness of a packet, is taken
    /// over once packets have told of it for [`DOUBT`], because one turn may have been held back.
    pub(crate) fn observe(
        &mut self,
        now: Instant,
        observed: ObservedFrame,
        lost_after: Duration,
        jump: Duration,
    ) {
        let current = self.leader.filter(|leader| now.since(leader.heard_at) <= lost_after);
        let rank = |node, fresh| (fresh, node);
        match current {
            Some(leader)
                if rank(observed.sender, observed.fresh) < rank(leader.node, leader.fresh) =>
            {
                return;
            }
            Some(_) if !self.is_likely(now, observed.phase, jump) => return,
            Some(leader) if leader.node == observed.sender => self.correct(observed.phase, jump),
            _ => self.phase = observed.phase,
        }
        self.leader = Some(Leader { node: observed.sender, heard_at: now, fresh: observed.fresh });
    }

    /// Whether `phase` is near this node's own, or near the one that has been doubtful for a while.
    fn is_likely(&mut self, now: Instant, phase: FramePhase, jump: Duration) -> bool {
        let is_near =
            |to: FramePhase| u64::from(to.until(phase).unsigned_abs()) <= jump.as_micros();
        if is_near(self.phase) {
            self.doubtful = None;
            return true;
        }
        let known = self.doubtful.filter(|(doubtful, _)| is_near(*doubtful));
        let (_, since) = *self.doubtful.insert(known.unwrap_or((phase, now)));
        now.since(since) >= DOUBT
    }

    /// Stops following `node`, and keeps the phase that it had.
    pub(crate) fn unfollow(&mut self, node: NodeId) {
        self.leader = self.leader.filter(|leader| leader.node != node);
    }

    /// Stops following any node farther from the base than `me`, and keeps the phase that it had.
    pub(crate) fn unfollow_below(&mut self, me: NodeId) {
        self.leader = self.leader.filter(|leader| leader.node > me);
    }

    /// Moves this node's phase towards the leader's. A packet can be late, when its sender was
    /// busy, but never early. So an earlier phase is taken over at once, and a later one only by an
    /// eighth of the difference each time, which is more than two clocks drift apart between two
    /// packets (100 ppm of 200 ms are 20 µs).
    fn correct(&mut self, phase: FramePhase, jump: Duration) {
        let error = self.phase.until(phase);
        let far = u64::from(error.unsigned_abs()) > jump.as_micros();
        self.phase = self.phase.moved(if far || error < 0 { error } else { (error + 7) / 8 });
    }
}
