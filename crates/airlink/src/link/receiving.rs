//! What comes in: the checks, in their order, and what follows from what has passed them.

use units::{Dbm, Duration, Instant, NodeId};
use wire::p2p::{
    Capsule, Header, Kind, MAX_BODY, Membership, Message, ORDER, TAG, TELEMETRY, Telemetry,
    decode_order,
};

use super::life::Life;
use super::{Airlink, End, Event};
use crate::config::LinkConfig;
use crate::counters::Reason;
use crate::follow::Told;
use crate::nonce;
use crate::relay::{Heard, Passing, Side};
use crate::seal::{Scope, Seal};

/// Time between two refusals.
const REFUSES_EVERY: Duration = Duration::from_millis(500);

impl<S: Seal> Airlink<S> {
    pub(super) fn take(
        &mut self,
        now: Instant,
        rssi: Dbm,
        data: &[u8],
    ) -> Result<Option<Event>, Reason> {
        let (header, rest) = Header::decode(data).map_err(|_| Reason::Malformed)?;
        let (sealed, tag) = rest.split_last_chunk::<TAG>().ok_or(Reason::Malformed)?;
        let mut bytes = [0; MAX_BODY];
        let body = bytes.get_mut(..sealed.len()).ok_or(Reason::Malformed)?;
        body.copy_from_slice(sealed);
        if !self.schedule.has(header.from) {
            return Err(Reason::NoSlot);
        }
        let clear = header.encode();
        if !self.seal.open(Scope::Fleet, &nonce::hop(clear), &clear, body, tag) {
            return Err(Reason::Tag);
        }
        if header.from == self.identity.node {
            return self.hear_twin(now, &header, rssi, body);
        }
        self.peers.hear(now, header.from, header.counter, rssi, self.config.alive)?;
        let fresh = self.peers.is_fresh(header.from);
        if !fresh && header.kind != Kind::Report {
            self.hear_phase(now, &header, data.len(), false);
            return Err(Reason::Stale);
        }
        let message = Message::decode(header.kind, body).map_err(|_| Reason::Body)?;
        let fresh = fresh || self.names_me(&message);
        self.hear_phase(now, &header, data.len(), fresh);
        if !fresh {
            return Err(Reason::Stale);
        }
        self.peers.prove(header.from);
        self.counters.taken.count(header.kind);
        self.hear(now, rssi, &header, message)
    }

    fn hear(
        &mut self,
        now: Instant,
        rssi: Dbm,
        header: &Header,
        message: Message,
    ) -> Result<Option<Event>, Reason> {
        let Header { from, counter, .. } = *header;
        match message {
            Message::Report(report) => Ok(Some(Event::Report { from, counter, report, rssi })),
            Message::Beacon(beacon) => Ok(Some(Event::Beacon { from, beacon, rssi })),
            Message::Membership(membership) => {
                if membership == Membership::Leave {
                    self.forget(from);
                }
                Ok(Some(Event::Membership { from, membership }))
            }
            Message::Command(capsule) => self.hear_command(now, from, capsule),
            Message::Telemetry(capsule) => self.hear_telemetry(now, from, capsule),
        }
    }

    /// `node` has left. What is to be done at its far end is not told by this: whoever has the
    /// fleet's key can say it in anybody's name, and nobody must miss an order for that.
    fn forget(&mut self, node: NodeId) {
        self.peers.forget(node);
        self.follow.forget(node);
    }

    /// Whether a report says that its sender hears this node now.
    fn names_me(&self, message: &Message) -> bool {
        let me = (self.identity.node, self.epoch.low16());
        let Message::Report(report) = message else { return false };
        report.heard.iter().any(|heard| (heard.node, heard.epoch) == me)
    }

    /// A packet with this node's own number: what it has said itself comes back, or there is
    /// another of that number.
    ///
    /// Of two, the one that has just come gives way, and of two that have both been there for a
    /// while the one with the later epoch. A recording cannot make anybody give way: nobody has
    /// refused the present epoch of a node who has not heard it.
    fn hear_twin(
        &mut self,
        now: Instant,
        header: &Header,
        rssi: Dbm,
        body: &[u8],
    ) -> Result<Option<Event>, Reason> {
        let me = self.identity.node;
        let theirs = header.counter.epoch();
        if theirs == self.epoch {
            // A number that has not been used here yet is used by a copy of this very drone, and
            // every further packet of both would use a nonce twice.
            if self.life.next().is_some_and(|next| header.counter >= next) {
                self.life.refuse();
                return Err(Reason::Twin);
            }
            return Err(Reason::Own);
        }
        self.peers.hear(now, me, header.counter, rssi, Duration::ZERO)?;
        let settled = self.life.has_settled(now, self.config.settles_after);
        let refusal = Membership::Refused { node: me, epoch: self.epoch.low16() };
        let refused = header.kind == Kind::Membership
            && Message::decode(header.kind, body) == Ok(Message::Membership(refusal));
        if refused && (!settled || self.epoch > theirs) {
            self.life.refuse();
        } else if settled && self.refuses.is_none() {
            let at = self.refused_at.map_or(now, |last| now.max(last + REFUSES_EVERY));
            self.refuses = Some((theirs.low16(), at));
        }
        Err(Reason::Twin)
    }

    /// Everybody follows who is nearer to the base; a newcomer at first anybody, so that it fits in
    /// even where it is the base.
    fn hear_phase(&mut self, now: Instant, header: &Header, length: usize, fresh: bool) {
        let listens = matches!(self.life, Life::Listening { .. });
        if header.from > self.identity.node || listens {
            let phase = self.schedule.phase_of(header, length, now);
            let told = Told { by: header.from, fresh, phase };
            self.follow.hear(now, told, self.config.lost_after, self.schedule.half_slot());
        }
    }

    fn hear_command(
        &mut self,
        now: Instant,
        from: NodeId,
        capsule: Capsule<ORDER>,
    ) -> Result<Option<Event>, Reason> {
        let me = self.identity.node;
        let (End::Drone(teller), true) = (&mut self.end, capsule.node == me) else {
            pass_on(&mut self.commands, now, side(from, me, capsule.node), capsule, &self.config);
            return Ok(None);
        };
        match teller.last() {
            Some(last) if capsule.counter < last => return Err(Reason::Outdated),
            // Whoever repeats it has not heard that it is here.
            Some(last) if capsule.counter == last => {
                if self.commands.is_settled(me) {
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
        let task = decode_order(&text).map_err(|_| Reason::Body)?;
        teller.heed(now, capsule.counter, task);
        self.commands.keep(now, capsule, 1);
        Ok(Some(Event::Order { task, counter: capsule.counter }))
    }

    fn hear_telemetry(
        &mut self,
        now: Instant,
        from: NodeId,
        capsule: Capsule<TELEMETRY>,
    ) -> Result<Option<Event>, Reason> {
        let (me, node, counter) = (self.identity.node, capsule.node, capsule.counter);
        let End::Base(orders) = &mut self.end else {
            // What is behind for a command is ahead for telemetry.
            let side = match side(from, me, node) {
                Some(Side::Behind) => Some(Side::Ahead),
                Some(Side::Ahead) => Some(Side::Behind),
                None => None,
            };
            pass_on(&mut self.telemetry, now, side, capsule, &self.config);
            return Ok(None);
        };
        match orders.last(node) {
            Some(last) if counter < last => return Err(Reason::Outdated),
            Some(last) if counter == last => {
                if self.telemetry.is_settled(node) {
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
        orders.hear(now, node, counter, &telemetry);
        self.telemetry.keep(now, capsule, 1);
        Ok(Some(Event::Telemetry { from: node, telemetry, counter }))
    }
}

/// Where `from` stands for a command to `end`, as seen from `me`, if I stand between.
fn side(from: NodeId, me: NodeId, end: NodeId) -> Option<Side> {
    if from > me && me >= end {
        Some(Side::Behind)
    } else if me > from && from >= end {
        Some(Side::Ahead)
    } else {
        None
    }
}

/// Does for `capsule` what someone between its ends does.
fn pass_on<const N: usize>(
    passing: &mut Passing<N>,
    now: Instant,
    side: Option<Side>,
    capsule: Capsule<N>,
    config: &LinkConfig,
) {
    let Some(side) = side else { return };
    match (passing.compare(now, &capsule, config.forgets_after), side) {
        (Heard::New, Side::Behind) => passing.keep(now, capsule, config.tries),
        (Heard::New, Side::Ahead) => passing.keep(now, capsule, 0),
        (Heard::Same, Side::Ahead) => passing.settle(capsule.node),
        (Heard::Same, Side::Behind) | (Heard::Old, _) => {}
    }
}
