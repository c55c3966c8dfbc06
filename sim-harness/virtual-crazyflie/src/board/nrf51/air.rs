//! The chip between the air and the flight processor: what comes off the air, and is passed on.

use super::frame::{MTU, kind};
use super::radio::{Answer, Landed, Packet};
use super::{MAX_P2P, Nrf51, Sent, passing_on};
use crate::soc::Nanos;

impl Nrf51 {
    /// A packet that has come off the air at a moment that is not past.
    fn hear(&mut self, now: Nanos, at: Nanos, packet: Packet) {
        let at = at.max(now);
        let behind = self.flying.partition_point(|(other, _)| *other <= at);
        self.flying.insert(behind, (at, packet));
        self.run(now);
    }

    pub(in super::super) fn hear_p2p(
        &mut self,
        now: Nanos,
        at: Nanos,
        broadcast: bool,
        port: u8,
        data: &[u8],
        rssi: u8,
    ) {
        let mut bytes = vec![0xFF, 0x80 | (port & 0x0F)];
        bytes.extend_from_slice(&data[..data.len().min(MAX_P2P)]);
        self.hear(now, at, Packet { data: bytes, broadcast, rssi });
    }

    pub(in super::super) fn hear_crtp(&mut self, now: Nanos, at: Nanos, data: &[u8], rssi: u8) {
        let data = data[..data.len().min(MTU - 1)].to_vec();
        self.hear(now, at, Packet { data, broadcast: false, rssi });
    }

    pub(in super::super) fn take_sent(&mut self) -> Vec<Sent> {
        std::mem::take(&mut self.sent)
    }

    pub(in super::super) fn take_answers(&mut self) -> Vec<Answer> {
        self.state.radio.take_answers()
    }

    pub(super) fn land(&mut self, at: Nanos, packet: Packet) {
        let landed = if self.runs() { self.state.radio.land(at, packet) } else { Landed::Deaf };
        match landed {
            Landed::Taken => {}
            Landed::Deaf => self.state.counters.deaf += 1,
            Landed::NoRoom => self.state.counters.overruns += 1,
        }
    }

    /// A packet from the air goes to whom it is for.
    pub(super) fn pass_on(&mut self, packet: Packet) {
        self.state.rssi = packet.rssi;
        self.state.bluetooth = false;
        self.state.main_loop.work(passing_on(packet.data.len()));
        if packet.is_tuning() || packet.is_loaders() {
            self.obey(&packet.data);
        } else if packet.is_p2p() {
            let to = if packet.broadcast { kind::P2P_BROADCAST } else { kind::P2P };
            let mut data = vec![packet.data[1] & 0x0F, packet.rssi];
            data.extend_from_slice(&packet.data[2..]);
            self.say(to, &data);
        } else {
            let to = if packet.broadcast { kind::RAW_BROADCAST } else { kind::RAW };
            self.say(to, &packet.data);
        }
    }
}
