//! Who else is on the air, and whether it speaks now.
//!
//! After a boot a node does not know how far the others have counted, so a recording of an earlier
//! day would look new. Nobody can have recorded this node's present epoch before it began: who
//! names it has heard this node since, and is *fresh*. From then on its counter tells.

use heapless::Vec;
use units::{Dbm, Duration, Instant, NODES, NodeId};
use wire::p2p::{Counter, HEARD, Heard};

use crate::counters::Reason;

#[derive(Clone, Copy, Debug)]
struct Peer {
    /// The number of the last packet that was taken. A radio without a queue does not let packets
    /// overtake each other, so an earlier number is a repetition, or late on purpose.
    last: Counter,
    /// `None` when it has left since.
    heard_at: Option<Instant>,
    rssi: Dbm,
    fresh: bool,
    /// In how many reports it was named since it came.
    named: u8,
}

/// Everybody, by number.
#[derive(Clone, Debug)]
pub(crate) struct Peers {
    all: [Option<Peer>; NODES],
}

impl Peers {
    pub(crate) const fn new() -> Self {
        Self { all: [None; NODES] }
    }

    /// Takes in an authentic packet of `from`.
    ///
    /// A later epoch of somebody who was heard less than `alive` ago is a second node of that
    /// number, as far as one can tell; it does not take the first one's place.
    pub(crate) fn hear(
        &mut self,
        now: Instant,
        from: NodeId,
        counter: Counter,
        rssi: Dbm,
        alive: Duration,
    ) -> Result<(), Reason> {
        let place = self.all.get_mut(usize::from(from.0)).ok_or(Reason::NoSlot)?;
        let Some(peer) = place else {
            *place =
                Some(Peer { last: counter, heard_at: Some(now), rssi, fresh: false, named: 0 });
            return Ok(());
        };
        let reborn = counter.epoch() > peer.last.epoch();
        let lately = peer.heard_at.is_some_and(|at| now.since(at) < alive);
        if reborn && peer.fresh && lately {
            return Err(Reason::Twin);
        }
        let has_left = peer.heard_at.is_none() && !reborn;
        if counter <= peer.last || has_left {
            return Err(Reason::Replayed);
        }
        peer.last = counter;
        if reborn {
            peer.named = 0;
        }
        peer.heard_at = Some(now);
        peer.rssi = rssi;
        Ok(())
    }

    pub(crate) fn is_fresh(&self, node: NodeId) -> bool {
        self.get(node).is_some_and(|peer| peer.fresh)
    }

    pub(crate) fn prove(&mut self, node: NodeId) {
        if let Some(Some(peer)) = self.all.get_mut(usize::from(node.0)) {
            peer.fresh = true;
        }
    }

    /// `node` has left: nothing more of this epoch of it is taken, and in its next one it is a
    /// stranger.
    pub(crate) fn forget(&mut self, node: NodeId) {
        if let Some(Some(peer)) = self.all.get_mut(usize::from(node.0)) {
            peer.heard_at = None;
            peer.fresh = false;
        }
    }

    fn get(&self, node: NodeId) -> Option<&Peer> {
        self.all.get(usize::from(node.0))?.as_ref()
    }

    /// Whom a report names: the neighbours on both sides always, for their links are flown by; then
    /// who was named least, so that a newcomer, whom nobody is fresh for yet, soon is.
    pub(crate) fn name(
        &mut self,
        me: NodeId,
        now: Instant,
        lost_after: Duration,
    ) -> Vec<Heard, HEARD> {
        let mut names = Vec::new();
        let heard = |peer: &Peer| peer.heard_at.is_some_and(|at| now.since(at) <= lost_after);
        let mut left: u16 = numbered(&self.all)
            .filter(|(node, peer)| *node != me && heard(peer))
            .fold(0, |set, (node, _)| set | 1 << node.0);
        let beside = [highest(left & below(me)), lowest(left & !below(me))];
        for node in beside.into_iter().flatten() {
            left &= !(1 << node.0);
            self.add(node, &mut names);
        }
        while !names.is_full()
            && let Some(node) = self.least_named(left)
        {
            left &= !(1 << node.0);
            self.add(node, &mut names);
        }
        names
    }

    fn least_named(&self, among: u16) -> Option<NodeId> {
        numbered(&self.all)
            .filter(|(node, _)| among & 1 << node.0 != 0)
            .min_by_key(|(_, peer)| peer.named)
            .map(|(node, _)| node)
    }

    fn add(&mut self, node: NodeId, names: &mut Vec<Heard, HEARD>) {
        let Some(Some(peer)) = self.all.get_mut(usize::from(node.0)) else { return };
        let epoch = peer.last.epoch().low16();
        if names.push(Heard { node, rssi: peer.rssi, epoch }).is_ok() {
            // Round, not up to a stop, or the last to come would be named alone for ever.
            peer.named = peer.named.saturating_add(1);
        }
        if peer.named == u8::MAX {
            for peer in self.all.iter_mut().flatten() {
                peer.named /= 2;
            }
        }
    }
}

fn numbered(all: &[Option<Peer>; NODES]) -> impl Iterator<Item = (NodeId, &Peer)> {
    (0..).zip(all).filter_map(|(number, peer)| Some((NodeId(number), peer.as_ref()?)))
}

/// The numbers below `node`'s.
const fn below(node: NodeId) -> u16 {
    (1_u16 << (node.0 & 15)) - 1
}

fn lowest(set: u16) -> Option<NodeId> {
    (set != 0).then(|| NodeId(set.trailing_zeros() as u8))
}

fn highest(set: u16) -> Option<NodeId> {
    (set != 0).then(|| NodeId(15_u8.saturating_sub(set.leading_zeros() as u8)))
}
