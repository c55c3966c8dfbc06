//! Receiving: checks a packet in the order of the crate's documentation, and acts on the message
//! in it.

use units::{Dbm, Duration, Instant, NodeId, Order};
use wire::p2p::{
    Capsule, Commands, Header, Kind, Membership, Message, ORDER, REUSE, Report, TELEMETRY,
    Telemetry, decode_order,
};

use super::lifecycle::Lifecycle;
use super::opened::Content;
use super::{Airlink, End, Event, Opened};
use crate::clock_sync::ObservedFrame;
use crate::config::LinkConfig;
use crate::counters::Reason;
use crate::nonce;
use crate::relay_queue::{Novelty, RelayQueue, Side};
use crate::schedule::{FramePhase, Turns};
use crate::seal::{Scope, Seal};

/// Time between two refusals of another node with this node's number.
const REFUSAL_INTERVAL: Duration = Duration::from_millis(500);

impl<S: Seal> Airlink<S> {
    /// Checks a received packet and returns its event, or why it was refused.
    pub(super) fn process(
        &mut self,
        now: Instant,
        rssi: Dbm,
        opened: &Opened,
    ) -> Result<Option<Event>, Reason> {
        let opened = opened.content.as_ref().map_err(|reason| *reason)?;
        let Content { header, since_frame, message } = opened;
        if header.from == self.identity.node {
            return self.process_own_number(now, header, rssi, message.as_ref());
        }
        let prompt = self.peers.accept(now, header.from, header.counter, rssi, &self.config)?;
        let fresh = self.peers.is_fresh(header.from);
        if !fresh && header.kind != Kind::Report {
            self.synchronise(now, header, *since_frame, false);
            return Err(Reason::Stale);
        }
        let message = message.as_ref().ok_or(Reason::Body)?;
        let fresh = fresh || self.is_named_in(message);
        if prompt {
            self.synchronise(now, header, *since_frame, fresh);
        }
        let measured = (prompt && self.is_in_turn(now, *since_frame)).then_some(rssi);
        if let Some(rssi) = measured {
            self.peers.measure(header.from, rssi);
        }
        if !fresh {
            return Err(Reason::Stale);
        }
        self.peers.mark_fresh(header.from);
        self.watch_for_crowds(now, header.from, message);
        self.counters.taken.count(header.kind);
        let last = self.peers.rssi(header.from).unwrap_or(rssi);
        self.act_on(now, (measured, last), header, message)
    }

    /// Notes whether nodes that would share turns may be in range of one receiver: where this node
    /// hears one three numbers away, or a neighbour names one that is as far from it, as where nodes
    /// between them are lost, or that would share this node's turns.
    fn watch_for_crowds(&mut self, now: Instant, from: NodeId, message: &Message) {
        let me = self.identity.node;
        let is_far = |node: NodeId| node.0.abs_diff(from.0) >= REUSE / 2;
        let shares = |node: NodeId| node != me && node.0 % REUSE == me.0 % REUSE;
        let names = |report: &Report| {
            report.heard.iter().any(|heard| shares(heard.node) || is_far(heard.node))
        };
        if is_far(me) || matches!(message, Message::Report(report) if names(report)) {
            self.crowded_at = Some(now);
            self.turns = Turns::Own;
            self.due = None;
        }
    }

    /// Whether a packet that arrived at `now` came in the turn that its header names, by this node's
    /// own frame.
    fn is_in_turn(&self, now: Instant, since_frame: Duration) -> bool {
        let error = self.clock_sync.phase().until(FramePhase::before(now, since_frame));
        u64::from(error.unsigned_abs()) <= self.schedule.half_slot().as_micros()
    }

    /// Acts on a message that has passed the checks of the hop, whose packet had the strength
    /// `measured`, if it came in its turn; `rssi` is that of the last one that did.
    fn act_on(
        &mut self,
        now: Instant,
        (measured, rssi): (Option<Dbm>, Dbm),
        header: &Header,
        message: &Message,
    ) -> Result<Option<Event>, Reason> {
        let Header { from, counter, .. } = *header;
        match *message {
            Message::Report(ref report) => {
                Ok(Some(Event::Report { from, counter, report: report.clone(), rssi: measured }))
            }
            Message::Beacon(beacon) => Ok(Some(Event::Beacon { from, beacon, rssi })),
            Message::Membership(membership) => {
                if membership == Membership::Leave {
                    self.forget(from);
                }
                Ok(Some(Event::Membership { from, membership }))
            }
            Message::Mission(message) => Ok(Some(Event::Mission { from, message, rssi })),
            Message::Command(Commands { first, second }) => {
                let taken = self.accept_command(now, from, first);
                let Some(second) = second else { return taken };
                // One of them at most is for this node.
                let other = self.accept_command(now, from, second);
                if matches!(taken, Ok(None)) { other } else { taken }
            }
            Message::Telemetry(capsule) => self.accept_telemetry(now, from, capsule),
        }
    }

    /// Forgets `node`, which has left, as a neighbour. The base goes on sending it orders, because
    /// a thief with the group key can say in any node's name that it leaves, and no node may miss
    /// an order because of that.
    fn forget(&mut self, node: NodeId) {
        self.peers.forget(node);
        self.clock_sync.unfollow(node);
    }

    /// Whether `message` is a report whose sender hears this node in its present epoch.
    fn is_named_in(&self, message: &Message) -> bool {
        let me = (self.identity.node, self.epoch);
        let Message::Report(report) = message else { return false };
        report.heard.iter().any(|heard| (heard.node, heard.epoch) == me)
    }

    /// Processes a packet with this node's own number: an echo, or a packet of a second node with
    /// that number (a twin).
    ///
    /// Of two such nodes the newcomer falls silent, and of two that have both been members for a
    /// while the one with the later epoch. A recording cannot silence a node, because a refusal
    /// names the refused node's epoch, and none recorded earlier names its present one.
    fn process_own_number(
        &mut self,
        now: Instant,
        header: &Header,
        rssi: Dbm,
        message: Option<&Message>,
    ) -> Result<Option<Event>, Reason> {
        self.due = None;
        let me = self.identity.node;
        let theirs = header.counter.epoch();
        if theirs == self.epoch {
            // A counter that this node has not used yet comes from a copy of this very drone, and
            // every further packet of both would use a nonce twice.
            if self.lifecycle.next().is_some_and(|next| header.counter >= next) {
                self.lifecycle.refuse();
                return Err(Reason::Twin);
            }
            return Err(Reason::Own);
        }
        let config = LinkConfig { alive: Duration::ZERO, ..self.config };
        self.peers.accept(now, me, header.counter, rssi, &config)?;
        let settled = self.lifecycle.has_settled(now, self.config.settles_after);
        let refusal = Membership::Refused { node: me, epoch: self.epoch };
        let refused = message == Some(&Message::Membership(refusal));
        if refused && (!settled || self.epoch > theirs) {
            self.lifecycle.refuse();
        } else if settled && self.pending_refusal.is_none() {
            let at = self.last_refusal.map_or(now, |last| now.max(last + REFUSAL_INTERVAL));
            self.pending_refusal = Some((theirs, at));
        }
        Err(Reason::Twin)
    }

    /// Aligns this node's frame to that of a sender nearer to the base. A node that still listens
    /// follows any sender, so that it fits into the frame even where it is the base itself.
    fn synchronise(&mut self, now: Instant, header: &Header, since_frame: Duration, fresh: bool) {
        let listens = matches!(self.lifecycle, Lifecycle::Listening { .. });
        if header.from > self.identity.node || listens {
            let phase = FramePhase::before(now, since_frame);
            let observed = ObservedFrame { sender: header.from, fresh, phase };
            let (lost_after, jump) = (self.config.lost_after, self.schedule.half_slot());
            self.clock_sync.observe(now, observed, lost_after, jump);
        }
    }

    /// Opens a command for this drone, or relays one for another.
    fn accept_command(
        &mut self,
        now: Instant,
        from: NodeId,
        capsule: Capsule<ORDER>,
    ) -> Result<Option<Event>, Reason> {
        let me = self.identity.node;
        let (End::Drone(sender), true) = (&mut self.end, capsule.node == me) else {
            let side = side(from, me, capsule.node);
            let tries = self.config.command_tries(capsule.node);
            relay(&mut self.commands, now, side, capsule, tries, &self.config, self.turns);
            return Ok(None);
        };
        match sender.last_order() {
            Some(last) if capsule.counter < last => return Err(Reason::Outdated),
            // A repeat means that the sender has not heard this node send the command yet.
            Some(last) if capsule.counter == last => {
                if self.commands.is_done(me) {
                    self.commands.allow(me, 1);
                }
                return Ok(None);
            }
            _ => {}
        }
        let mut text = capsule.sealed;
        let (nonce, aad) =
            (nonce::command(me, capsule.counter), nonce::command_aad(me, self.epoch));
        if !self.seal.open(Scope::EndToEnd(me), &nonce, &aad, &mut text, &capsule.tag) {
            return Err(Reason::Forged);
        }
        let order = decode_order(&text).map_err(|_| Reason::Body)?;
        // A stop stands until the base's next boot, so it is never too old.
        if sender.lateness(now, capsule.counter) > self.config.held_after && order != Order::Stop {
            return Err(Reason::Held);
        }
        sender.accept(now, capsule.counter, order);
        self.commands.store(now, capsule, 1, self.turns);
        Ok(Some(Event::Order { task: order, counter: capsule.counter }))
    }

    /// At the base, opens telemetry; at a drone, relays it.
    fn accept_telemetry(
        &mut self,
        now: Instant,
        from: NodeId,
        capsule: Capsule<TELEMETRY>,
    ) -> Result<Option<Event>, Reason> {
        let (me, node, counter) = (self.identity.node, capsule.node, capsule.counter);
        let End::Base(orders) = &mut self.end else {
            // Telemetry goes the opposite way of a command.
            let side = match side(from, me, node) {
                Some(Side::Upstream) => Some(Side::Downstream),
                Some(Side::Downstream) => Some(Side::Upstream),
                None => None,
            };
            let tries = self.config.tries;
            relay(&mut self.telemetry, now, side, capsule, tries, &self.config, self.turns);
            return Ok(None);
        };
        match orders.last_telemetry(node) {
            Some(last) if counter < last => return Err(Reason::Outdated),
            Some(last) if counter == last => {
                if self.telemetry.is_done(node) {
                    self.telemetry.allow(node, 1);
                }
                return Ok(None);
            }
            _ => {}
        }
        let mut text = capsule.sealed;
        let nonce = nonce::telemetry(node, counter);
        if !self.seal.open(Scope::EndToEnd(node), &nonce, &[node.0], &mut text, &capsule.tag) {
            return Err(Reason::Forged);
        }
        let telemetry = Telemetry::decode(&text).map_err(|_| Reason::Body)?;
        orders.accept_telemetry(now, node, counter, &telemetry);
        self.telemetry.store(now, capsule, 1, self.turns);
        Ok(Some(Event::Telemetry { from: node, telemetry, counter }))
    }
}

/// The side of `me` on which the sender `from` stands on the way of a command to `far_end`, if both
/// stand on that way.
fn side(from: NodeId, me: NodeId, far_end: NodeId) -> Option<Side> {
    if from > me && me >= far_end {
        Some(Side::Upstream)
    } else if me > from && from >= far_end {
        Some(Side::Downstream)
    } else {
        None
    }
}

/// Updates the queue of a node between the capsule's ends: a new capsule that comes from upstream
/// is to be sent, and one that a node downstream sends need not be sent any more.
fn relay<const N: usize>(
    queue: &mut RelayQueue<N>,
    now: Instant,
    side: Option<Side>,
    capsule: Capsule<N>,
    tries: u8,
    config: &LinkConfig,
    turns: Turns,
) {
    let Some(side) = side else { return };
    match (queue.compare(now, &capsule, config.forgets_after), side) {
        (Novelty::New, Side::Upstream) => queue.store(now, capsule, tries, turns),
        (Novelty::New, Side::Downstream) => queue.store(now, capsule, 0, turns),
        (Novelty::Repeated, Side::Downstream) => queue.stop(capsule.node),
        // The sender has not heard this node send the capsule, or has not heard it in time.
        (Novelty::Repeated, Side::Upstream) => queue.answer(capsule.node),
        (Novelty::Old, _) => {}
    }
}
