//! The table of the other nodes that this node hears, which protects it from recorded packets.
//!
//! After a boot a node does not know the present counters of the others, so packets that were
//! recorded on an earlier day would look new. No packet recorded before this boot can name this
//! node's present epoch: a sender whose report names it has heard this node since, and is *fresh*.
//! From then on a recording is recognised by its counter.

use heapless::Vec;
use units::{Dbm, Duration, Instant, NODES, NodeId};
use wire::p2p::{Counter, HEARD, Heard};

use crate::config::LinkConfig;
use crate::counters::Reason;
use crate::lateness::Lateness;

#[derive(Clone, Copy, Debug)]
struct Peer {
    /// The counter of the last packet that was accepted. The radio has no queue in which packets
    /// could overtake each other, so an earlier counter means a recording.
    last: Counter,
    lateness: Lateness,
    /// When the peer's last packet came; `None` once the peer has left.
    heard_at: Option<Instant>,
    rssi: Dbm,
    /// Whether the last packet has not been named in a report yet.
    is_new: bool,
    fresh: bool,
    /// How many reports of this node have named the peer.
    times_named: u8,
}

/// All other nodes, by number.
#[derive(Clone, Debug)]
pub(crate) struct Peers {
    all: [Option<Peer>; NODES],
    /// The set of the known nodes, one bit each.
    known: u16,
}

impl Peers {
    pub(crate) const fn new() -> Self {
        Self { all: [None; NODES], known: 0 }
    }

    /// Records an authentic packet of `from`, or refuses it as a repetition, or as one that was held
    /// back. Returns whether it came as promptly as the sender's packets do.
    ///
    /// A later epoch of a node that was heard less than `alive` ago is taken for a second node with
    /// that number, and does not take the first one's place.
    pub(crate) fn accept(
        &mut self,
        now: Instant,
        from: NodeId,
        counter: Counter,
        rssi: Dbm,
        config: &LinkConfig,
    ) -> Result<bool, Reason> {
        let slot = self.all.get_mut(usize::from(from.0)).ok_or(Reason::NoSlot)?;
        let Some(peer) = slot else {
            *slot = Some(Peer {
                last: counter,
                lateness: Lateness::new(now, counter),
                heard_at: Some(now),
                rssi,
                is_new: true,
                fresh: false,
                times_named: 0,
            });
            self.known |= 1 << (from.0 & 15);
            return Ok(true);
        };
        let rebooted = counter.epoch() > peer.last.epoch();
        let recently = peer.heard_at.is_some_and(|at| now.since(at) < config.alive);
        if rebooted && peer.fresh && recently {
            return Err(Reason::Twin);
        }
        let has_left = peer.heard_at.is_none() && !rebooted;
        if counter <= peer.last || has_left {
            return Err(Reason::Replayed);
        }
        if rebooted {
            peer.times_named = 0;
            peer.lateness = Lateness::new(now, counter);
        }
        let late = peer.lateness.of(now, counter);
        if late > config.held_after {
            return Err(Reason::Held);
        }
        peer.last = counter;
        peer.heard_at = Some(now);
        // The reports of a node that is not fresh yet bring no strength into the chain.
        if !peer.fresh {
            peer.rssi = rssi;
            peer.is_new = true;
        }
        Ok(late <= config.prompt_within)
    }

    /// Takes the strength of the packet of `from` that was accepted last, which came in its turn.
    pub(crate) fn measure(&mut self, from: NodeId, rssi: Dbm) {
        if let Some(Some(peer)) = self.all.get_mut(usize::from(from.0)) {
            peer.rssi = rssi;
            peer.is_new = true;
        }
    }

    /// The strength of the last packet of `node` that came in its turn.
    pub(crate) fn rssi(&self, node: NodeId) -> Option<Dbm> {
        self.get(node).map(|peer| peer.rssi)
    }

    pub(crate) fn is_fresh(&self, node: NodeId) -> bool {
        self.get(node).is_some_and(|peer| peer.fresh)
    }

    /// Marks `node` as fresh: it has proved that its packets are no recording.
    pub(crate) fn mark_fresh(&mut self, node: NodeId) {
        if let Some(Some(peer)) = self.all.get_mut(usize::from(node.0)) {
            peer.fresh = true;
        }
    }

    /// Forgets `node`, which has left: packets of its present epoch are refused from now on, and in
    /// its next epoch it has to prove anew that it is fresh.
    pub(crate) fn forget(&mut self, node: NodeId) {
        if let Some(Some(peer)) = self.all.get_mut(usize::from(node.0)) {
            peer.heard_at = None;
            peer.fresh = false;
        }
    }

    fn get(&self, node: NodeId) -> Option<&Peer> {
        self.all.get(usize::from(node.0))?.as_ref()
    }

    /// Selects the nodes that a report names as heard: always the nearest on each side, because the
    /// drones fly by the strength of those links; then those that were named least, so that a
    /// newcomer, to which no node is fresh yet, is named soon.
    pub(crate) fn select_heard(
        &mut self,
        me: NodeId,
        now: Instant,
        lost_after: Duration,
    ) -> Vec<Heard, HEARD> {
        let mut selected = Vec::new();
        let heard = |peer: &Peer| peer.heard_at.is_some_and(|at| now.since(at) <= lost_after);
        let mut left = nodes_of(self.known)
            .filter(|node| *node != me && self.get(*node).is_some_and(heard))
            .fold(0, |set, node| set | 1 << (node.0 & 15));
        let beside = [highest(left & below(me)), lowest(left & !below(me))];
        for node in beside.into_iter().flatten() {
            left &= !(1 << node.0);
            self.add(node, &mut selected);
        }
        while !selected.is_full()
            && let Some(node) = self.least_named(left)
        {
            left &= !(1 << node.0);
            self.add(node, &mut selected);
        }
        selected
    }

    fn least_named(&self, among: u16) -> Option<NodeId> {
        let named = |node| Some((self.get(node)?.times_named, node));
        nodes_of(among).filter_map(named).min_by_key(|(times, _)| *times).map(|(_, node)| node)
    }

    fn add(&mut self, node: NodeId, selected: &mut Vec<Heard, HEARD>) {
        let Some(Some(peer)) = self.all.get_mut(usize::from(node.0)) else { return };
        let epoch = peer.last.epoch();
        let is_new = core::mem::take(&mut peer.is_new);
        if selected.push(Heard { node, rssi: peer.rssi, is_new, epoch }).is_ok() {
            // Counts that saturated would select the same nodes for ever, so all are halved below.
            peer.times_named = peer.times_named.saturating_add(1);
        }
        if peer.times_named == u8::MAX {
            for peer in self.all.iter_mut().flatten() {
                peer.times_named /= 2;
            }
        }
    }
}

/// The nodes of a set, one bit each, the lowest number first.
pub(crate) fn nodes_of(mut set: u16) -> impl Iterator<Item = NodeId> {
    core::iter::from_fn(move || {
        let node = lowest(set)?;
        set &= set.wrapping_sub(1);
        Some(node)
    })
}

/// The set of the numbers below that of `node`, one bit each.
const fn below(node: NodeId) -> u16 {
    (1_u16 << (node.0 & 15)) - 1
}

fn lowest(set: u16) -> Option<NodeId> {
    (set != 0).then(|| NodeId(set.trailing_zeros() as u8))
}

fn highest(set: u16) -> Option<NodeId> {
    (set != 0).then(|| NodeId(15_u8.saturating_sub(set.leading_zeros() as u8)))
}
