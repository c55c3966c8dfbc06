//! What goes out: the most urgent thing that there is to say, sealed.

use units::{Instant, NodeId, Role};
use wire::p2p::{
    Capsule, Counter, Header, MAX_BODY, Membership, Message, Report, Wave, encode_order,
};
use wire::syslink::MAX_P2P;

use super::life::Life;
use super::{Airlink, End};
use crate::nonce;
use crate::seal::{Scope, Seal};

impl<S: Seal> Airlink<S> {
    /// Writes the packet that is to be sent now.
    pub(super) fn speak(&mut self, now: Instant, out: &mut [u8; MAX_P2P]) -> Option<usize> {
        let counter = self.wake(now)?;
        let (turn, place) = self.turn(now, counter)?;
        let Some(message) = self.pick(now, turn.wave, place, counter) else {
            self.close(turn, now);
            return None;
        };
        let kind = message.kind();
        let header = Header { kind, from: self.identity.node, wave: turn.wave, place, counter };
        let length = self.write(&header, &message, out);
        let not_before = now + self.schedule.spacing();
        let doubles = self.config.doubles
            && matches!((turn.wave, place), (Wave::Outward, 0))
            && matches!(&message, Message::Command(capsule) if capsule.node == NodeId::HEAD);
        self.said(turn, place, not_before, doubles);
        self.counters.sent.count(kind);
        self.life.spoke();
        Some(length)
    }

    /// The most urgent thing to say in the packet `place` of a turn of `wave`.
    fn pick(&mut self, now: Instant, wave: Wave, place: u8, counter: Counter) -> Option<Message> {
        if let Some(membership) = self.pick_membership(now) {
            return Some(Message::Membership(membership));
        }
        let last = place + 1 == self.schedule.burst();
        let picked = match wave {
            Wave::Outward => self
                .pick_command(now, wave, counter)
                .or_else(|| self.pick_double(now))
                .or_else(|| self.pick_report(now))
                .or_else(|| self.pick_telemetry(now, wave, counter)),
            // The reports of a busy chain have this place, or there would be none.
            Wave::Inward => (if last { self.pick_report(now) } else { None })
                .or_else(|| self.pick_command(now, wave, counter))
                .or_else(|| self.pick_telemetry(now, wave, counter))
                .or_else(|| self.pick_report(now)),
        };
        picked.or_else(|| self.pick_beacon(now))
    }

    fn pick_membership(&mut self, now: Instant) -> Option<Membership> {
        if matches!(self.life, Life::Leaving { .. }) {
            return Some(Membership::Leave);
        }
        if self.joins {
            self.joins = false;
            return Some(Membership::Join);
        }
        let (epoch, _) = self.refuses.take_if(|(_, at)| *at <= now)?;
        self.refused_at = Some(now);
        Some(Membership::Refused { node: self.identity.node, epoch })
    }

    /// The head's command that this turn has begun with, once more.
    fn pick_double(&mut self, now: Instant) -> Option<Message> {
        self.open.filter(|open| open.doubles)?;
        self.commands.say(now, NodeId::HEAD).map(Message::Command)
    }

    fn pick_beacon(&mut self, now: Instant) -> Option<Message> {
        if self.beacon_at > now {
            return None;
        }
        self.beacon_at = now + self.config.beacon_every;
        Some(Message::Beacon(self.beacon))
    }

    fn pick_report(&mut self, now: Instant) -> Option<Message> {
        let report = self.report.take()?;
        let heard = self.peers.name(self.identity.node, now, self.config.lost_after);
        Some(Message::Report(Report { heard, ..report }))
    }

    fn pick_command(&mut self, now: Instant, wave: Wave, counter: Counter) -> Option<Message> {
        if let End::Base(orders) = &mut self.end
            && let Some(node) = orders.next(now, wave, &self.config)
            && let (Some(task), Some(epoch)) = (orders.task(), orders.epoch(node))
        {
            orders.told(now, node, &self.config);
            let mut sealed = encode_order(task);
            let (nonce, aad) = (nonce::command(node, counter), nonce::command_aad(node, epoch));
            let tag = self.seal.seal(Scope::EndToEnd(node), &nonce, &aad, &mut sealed);
            self.commands.keep(now, Capsule { node, counter, sealed, tag }, self.config.tries);
            return self.commands.say(now, node).map(Message::Command);
        }
        self.commands.next(now, wave).map(Message::Command)
    }

    fn pick_telemetry(&mut self, now: Instant, wave: Wave, counter: Counter) -> Option<Message> {
        let every = match self.identity.role {
            Role::Head => self.config.head_telemetry_every,
            Role::Relay | Role::Base => self.config.telemetry_every,
        };
        if let (End::Drone(teller), Wave::Inward) = (&mut self.end, wave)
            && let Some(telemetry) = teller.next(now, every)
        {
            let node = self.identity.node;
            let mut sealed = telemetry.encode();
            let nonce = nonce::telemetry(node, counter);
            let tag = self.seal.seal(Scope::EndToEnd(node), &nonce, &[node.0], &mut sealed);
            self.telemetry.keep(now, Capsule { node, counter, sealed, tag }, self.config.tries);
            return self.telemetry.say(now, node).map(Message::Telemetry);
        }
        self.telemetry.next(now, wave).map(Message::Telemetry)
    }

    fn write(&self, header: &Header, message: &Message, out: &mut [u8; MAX_P2P]) -> usize {
        let clear = header.encode();
        let mut bytes = [0; MAX_BODY];
        let length = message.encode(&mut bytes);
        let body = bytes.get_mut(..length).unwrap_or_default();
        let tag = self.seal.seal(Scope::Fleet, &nonce::hop(clear), &clear, body);
        let parts: [&[u8]; 3] = [&clear, body, &tag];
        parts.into_iter().fold(0, |length, part| {
            let room = out.get_mut(length..).unwrap_or_default();
            room.iter_mut().zip(part).for_each(|(place, byte)| *place = *byte);
            length + part.len()
        })
    }
}
