//! Sending: picks the most urgent message, seals it and writes the packet.

use units::{Instant, NodeId, Role};
use wire::p2p::{
    Capsule, Commands, Counter, Header, MAX_BODY, Membership, Message, ORDER, Report, Wave,
    encode_order,
};
use wire::syslink::MAX_P2P;

use super::lifecycle::Lifecycle;
use super::turns::stamped;
use super::{Airlink, End};
use crate::nonce;
use crate::seal::{Scope, Seal};

impl<S: Seal> Airlink<S> {
    /// Writes the packet to send at `now`, if one is due, and returns its length.
    pub(super) fn write_next(&mut self, now: Instant, out: &mut [u8; MAX_P2P]) -> Option<usize> {
        let next = self.next_counter(now)?;
        let (turn, place) = self.turn_and_place(now, next)?;
        let Some(counter) = stamped(next, turn, place) else {
            self.lifecycle.exhaust();
            return None;
        };
        let Some(message) = self.pick_message(now, turn.wave, place, counter) else {
            self.close_turn(turn, now);
            return None;
        };
        let kind = message.kind();
        let (from, owner) = (self.identity.node, turn.owner);
        let header = Header { kind, from, wave: turn.wave, place, owner, counter };
        let length = self.write_packet(&header, &message, out);
        let not_before = now + self.schedule.spacing();
        let repeats_command = self.config.doubles
            && place == 0
            && matches!(&message, Message::Command(commands) if commands.first.node == NodeId::HEAD);
        self.advance_turn(turn, place, not_before, repeats_command);
        self.counters.sent.count(kind);
        self.lifecycle.packet_sent(counter);
        Some(length)
    }

    /// Picks the most urgent message for the packet `place` of a turn of `wave`.
    fn pick_message(
        &mut self,
        now: Instant,
        wave: Wave,
        place: u8,
        counter: Counter,
    ) -> Option<Message> {
        if let Some(membership) = self.pick_membership(now) {
            return Some(Message::Membership(membership));
        }
        let last = place + 1 == self.schedule.burst();
        let picked = match wave {
            Wave::Outward => self
                .pick_commands(now, wave, counter)
                .or_else(|| self.pick_report(now))
                .or_else(|| self.pick_mission())
                .or_else(|| self.pick_telemetry(now, wave, counter)),
            // The last packet is kept for the report: in a busy chain commands and telemetry would
            // leave it no room.
            Wave::Inward => (if last { self.pick_report(now) } else { None })
                .or_else(|| self.pick_commands(now, wave, counter))
                .or_else(|| self.pick_telemetry(now, wave, counter))
                .or_else(|| self.pick_mission())
                .or_else(|| self.pick_report(now)),
        };
        picked.or_else(|| self.pick_beacon(now))
    }

    fn pick_membership(&mut self, now: Instant) -> Option<Membership> {
        if matches!(self.lifecycle, Lifecycle::Leaving { .. }) {
            return Some(Membership::Leave);
        }
        if self.join_pending {
            self.join_pending = false;
            return Some(Membership::Join);
        }
        let (epoch, _) = self.pending_refusal.take_if(|(_, at)| *at <= now)?;
        self.last_refusal = Some(now);
        Some(Membership::Refused { node: self.identity.node, epoch })
    }

    fn pick_beacon(&mut self, now: Instant) -> Option<Message> {
        if self.beacon_due_at > now {
            return None;
        }
        self.beacon_due_at = now + self.config.beacon_every;
        Some(Message::Beacon(self.beacon))
    }

    fn pick_report(&mut self, now: Instant) -> Option<Message> {
        let report = self.report.take()?;
        let heard = self.peers.select_heard(self.identity.node, now, self.config.lost_after);
        Some(Message::Report(Report { heard, ..report }))
    }

    fn pick_mission(&mut self) -> Option<Message> {
        self.missions.pop_front().map(Message::Mission)
    }

    /// Picks the most urgent command and, for the room that is left, the next one for another node.
    fn pick_commands(&mut self, now: Instant, wave: Wave, counter: Counter) -> Option<Message> {
        let first = match wave {
            Wave::Outward => self
                .pick_command(now, wave, counter, None)
                .or_else(|| self.pick_repeated_command(now)),
            Wave::Inward => self
                .pick_repeated_command(now)
                .or_else(|| self.pick_command(now, wave, counter, None)),
        }?;
        let second = self.pick_command(now, wave, counter, Some(first.node));
        Some(Message::Command(Commands { first, second }))
    }

    /// Picks the command to the head that this turn has begun with a second time.
    fn pick_repeated_command(&mut self, now: Instant) -> Option<Capsule<ORDER>> {
        self.open_turn.filter(|open| open.repeats_command)?;
        self.commands.take(now, NodeId::HEAD)
    }

    /// At the base, picks a new order if one is due to a node that is not `taken`; otherwise the next
    /// command in the queue.
    fn pick_command(
        &mut self,
        now: Instant,
        wave: Wave,
        counter: Counter,
        taken: Option<NodeId>,
    ) -> Option<Capsule<ORDER>> {
        if let End::Base(orders) = &mut self.end
            && let Some(node) = orders.next_recipient(now, wave, &self.config)
            && taken != Some(node)
            && let (Some(order), Some(epoch)) = (orders.order(), orders.epoch(node))
        {
            orders.mark_sent(now, node, &self.config);
            let mut sealed = encode_order(order);
            let (nonce, aad) = (nonce::command(node, counter), nonce::command_aad(node, epoch));
            let tag = self.seal.seal(Scope::EndToEnd(node), &nonce, &aad, &mut sealed);
            let capsule = Capsule { node, counter, sealed, tag };
            self.commands.store(now, capsule, self.config.command_tries(node), self.turns);
            return self.commands.take(now, node);
        }
        self.commands.take_next(now, wave, taken)
    }

    /// Picks this drone's own telemetry if it is due; otherwise the next in the queue.
    fn pick_telemetry(&mut self, now: Instant, wave: Wave, counter: Counter) -> Option<Message> {
        let every = match self.identity.role {
            Role::Head => self.config.head_telemetry_every,
            Role::Relay | Role::Base => self.config.telemetry_every,
        };
        if let (End::Drone(sender), Wave::Inward) = (&mut self.end, wave)
            && let Some(telemetry) = sender.take_due(now, every)
        {
            let node = self.identity.node;
            let mut sealed = telemetry.encode();
            let nonce = nonce::telemetry(node, counter);
            let tag = self.seal.seal(Scope::EndToEnd(node), &nonce, &[node.0], &mut sealed);
            let capsule = Capsule { node, counter, sealed, tag };
            self.telemetry.store(now, capsule, self.config.tries, self.turns);
            return self.telemetry.take(now, node).map(Message::Telemetry);
        }
        self.telemetry.take_next(now, wave, None).map(Message::Telemetry)
    }

    /// Writes the sealed packet to `out` and returns its length.
    fn write_packet(&self, header: &Header, message: &Message, out: &mut [u8; MAX_P2P]) -> usize {
        let header = header.encode();
        let mut bytes = [0; MAX_BODY];
        let length = message.encode(&mut bytes);
        let body = bytes.get_mut(..length).unwrap_or_default();
        let tag = self.seal.seal(Scope::Fleet, &nonce::hop(header), &header, body);
        let parts: [&[u8]; 3] = [&header, body, &tag];
        parts.into_iter().fold(0, |length, part| {
            let end = length + part.len();
            let Some(room) = out.get_mut(length..end) else { return length };
            room.copy_from_slice(part);
            end
        })
    }
}
