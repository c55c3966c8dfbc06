//! The radio chip's radio: what comes off the air, what is acknowledged and with what, and what
//! waits to be passed on (crazyflie2-nrf-firmware, `esb.c`).
//!
//! The module is not a medium: the caller decides which radio receives which packet, and how strong.

use std::collections::VecDeque;

use super::{ANSWERS_AFTER, LISTENS_AFTER, RAMP_UP, RECEIVES_AFTER};
use crate::soc::Nanos;

/// Slots of either queue, of which one is always empty (`RXQ_LEN`, `TXQ_LEN`).
const SLOTS: usize = 8;
/// The last channel that there is; the radio takes seven bits of the number.
const LAST_CHANNEL: u8 = 125;
const CHANNEL_BITS: u8 = 0x7F;

/// The data rate of the radio.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Datarate {
    /// 250 kbit/s.
    K250,
    /// 1 Mbit/s.
    M1,
    /// 2 Mbit/s.
    M2,
}

/// The settings of the radio.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tuning {
    /// MHz above 2400.
    pub channel: u8,
    /// The data rate.
    pub datarate: Datarate,
    /// The address at which it is spoken to alone, lowest byte first. Broadcasts have one of their
    /// own.
    pub address: [u8; 5],
    /// dBm, of those that the chip can: −30, −20, −16, −12, −8, −4, 0, 4. The amplifier behind it
    /// is not in this number.
    pub power: i8,
}

impl Tuning {
    /// The settings with which the chip starts.
    pub const DEFAULT: Self =
        Self { channel: 80, datarate: Datarate::M2, address: [0xE7; 5], power: 0 };
}

/// A packet that comes off the air, as it is there: data first byte to last, without its address.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Packet {
    pub(super) data: Vec<u8>,
    /// Whether the packet goes to the address of all chips, not to this chip's own.
    pub(super) broadcast: bool,
    /// −dBm.
    pub(super) rssi: u8,
}

impl Packet {
    /// A null packet of CRTP, in which what is not CRTP hides.
    pub(super) fn is_null(&self) -> bool {
        self.data.first().is_some_and(|header| header & 0xF3 == 0xF3)
    }

    pub(super) fn is_p2p(&self) -> bool {
        self.is_null() && self.data.get(1).is_some_and(|byte| byte & 0xF0 == 0x80)
    }

    /// A packet for the chip's own loader.
    pub(super) fn is_loaders(&self) -> bool {
        self.is_null() && self.data.get(1) == Some(&0xFE) && self.data.len() > 2
    }

    /// Sets the radio from the air.
    pub(super) fn is_tuning(&self) -> bool {
        self.is_null() && self.data.get(1) == Some(&0x03) && self.data.len() >= 4
    }
}

/// The content of the chip's acknowledgement of a packet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// When the packet had come off the air that this answers.
    pub at: Nanos,
    /// The acknowledgement's data: what the flight processor left there for it, or the chip's own
    /// empty one.
    pub data: Vec<u8>,
}

/// The outcome of a packet that came off the air.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Landed {
    Taken,
    Deaf,
    NoRoom,
}

/// The kind of the last acknowledgement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sent {
    Nothing,
    Empty,
    Service,
    Queued,
}

/// The radio.
#[derive(Debug)]
pub(super) struct Radio {
    pub(super) tuning: Tuning,
    /// The flight processor said that the radio is set.
    pub(super) ready: bool,
    /// A test: nothing but a carrier is sent, and nothing heard.
    pub(super) carrier: bool,
    /// From when on it listens even if it was never told that it is set.
    opens: Nanos,
    /// A channel that there is not was set: none is taken any more.
    stuck: bool,
    /// The radio sends, or turns round, until then.
    sends_until: Nanos,
    /// The last acknowledgement.
    on_air: Option<Answer>,
    /// The content of the slots, the oldest first: what has come off the air, passed on or not.
    slots: VecDeque<Packet>,
    incoming: VecDeque<Packet>,
    outgoing: VecDeque<Vec<u8>>,
    answers: Vec<Answer>,
    safelink: bool,
    up: bool,
    down: bool,
    sent: Sent,
    last: Vec<u8>,
    service: Option<Vec<u8>>,
}

impl Radio {
    pub(super) fn new(opens: Nanos) -> Self {
        Self {
            tuning: Tuning::DEFAULT,
            ready: false,
            carrier: false,
            opens,
            stuck: false,
            sends_until: 0,
            on_air: None,
            slots: VecDeque::new(),
            incoming: VecDeque::new(),
            outgoing: VecDeque::new(),
            answers: Vec::new(),
            safelink: false,
            up: true,
            down: true,
            sent: Sent::Nothing,
            last: Vec::new(),
            service: None,
        }
    }

    pub(super) fn listens(&self, at: Nanos) -> bool {
        (self.ready || at >= self.opens) && !self.carrier
    }

    /// Sets the channel. The vendor's code looks whether the channel that it had before is one
    /// (`esbSetChannel`): so a number that is none is taken, once, and no other is after it.
    pub(super) const fn set_channel(&mut self, channel: u8) {
        if !self.stuck {
            self.tuning.channel = channel & CHANNEL_BITS;
            self.stuck = channel > LAST_CHANNEL;
        }
    }

    /// The chip's dBm steps; what lies between 0 and 4 changes nothing (`esbSetTxPowerDbm`).
    pub(super) fn set_power(&mut self, wanted: i8) {
        self.tuning.power = match wanted {
            ..=-30 => -30,
            -29..=-20 => -20,
            -19..=-16 => -16,
            -15..=-12 => -12,
            -11..=-8 => -8,
            -7..=-4 => -4,
            -3..=0 => 0,
            1..=3 => self.tuning.power,
            4.. => 4,
        };
    }

    /// How long so many bytes of payload are on the air.
    const fn air(&self, payload: usize) -> Nanos {
        /// Preamble, address, nine bits of control, and checksum (nRF24L01+ product specification,
        /// 7.3).
        const AROUND: u64 = 8 * (1 + 5 + 2) + 9;
        let per_bit = match self.tuning.datarate {
            Datarate::K250 => 4_000,
            Datarate::M1 => 1_000,
            Datarate::M2 => 500,
        };
        (AROUND + 8 * payload as u64) * per_bit
    }

    /// It sends so many bytes of a P2P packet's data behind kind and port, and hears nothing from the
    /// command on until it has turned round: not the end of what was on the air when it began either.
    /// Then it listens, even if it was never told that it is set.
    pub(super) const fn send(&mut self, at: Nanos, data: usize) {
        self.sends_until = at + RAMP_UP + self.air(data + 2) + LISTENS_AFTER;
        self.ready = true;
    }

    /// The port and the data of the packet in the slot that comes next, which came off the air seven
    /// packets before the last one. Where the end of a packet falls into the 20 cycles in which
    /// `esbSendP2PPacket` sets the radio up, the radio sends this instead of its own.
    pub(super) fn oldest_p2p(&self) -> Option<(u8, &[u8])> {
        let packet = self.slots.front().filter(|_| self.slots.len() == SLOTS)?;
        match packet.data.as_slice() {
            [_, port, data @ ..] if packet.is_p2p() => Some((port & 0x0F, data)),
            _ => None,
        }
    }

    /// A packet has come off the air; one to the chip alone is acknowledged at once. One that began
    /// while the radio was sending or turned round is not heard.
    pub(super) fn land(&mut self, at: Nanos, packet: Packet) -> Landed {
        let began = at.saturating_sub(self.air(packet.data.len()));
        if !self.listens(at) || began < self.sends_until {
            return Landed::Deaf;
        }
        if self.incoming.len() == SLOTS - 1 {
            return Landed::NoRoom;
        }
        if self.slots.len() == SLOTS {
            self.slots.pop_front();
        }
        self.slots.push_back(packet.clone());
        if packet.broadcast {
            self.incoming.push_back(packet);
            return Landed::Taken;
        }
        let header = packet.data.first().copied().unwrap_or_default();
        if packet.is_p2p() {
            self.acknowledge(at, Vec::new());
            self.incoming.push_back(packet);
        } else if packet.is_loaders() {
            self.answer(at, false);
            self.incoming.push_back(packet);
        } else if let [header @ (0xF3 | 0xF7 | 0xFB | 0xFF), 0x05, on] = packet.data[..] {
            self.safelink = on != 0;
            self.service = Some(vec![header, 0x05, on]);
            self.answer(at, false);
            (self.up, self.down) = (true, true);
        } else {
            let is_new = !self.safelink || (header & 0x08 != 0) != self.up;
            if is_new {
                self.incoming.push_back(packet);
                self.up = !self.up;
            }
            let acknowledged = !self.safelink || (header & 0x04 != 0) != self.down;
            if acknowledged {
                self.down = !self.down;
            }
            self.answer(at, !acknowledged);
        }
        Landed::Taken
    }

    /// The packet that the main loop takes next.
    pub(super) fn take(&mut self) -> Option<Packet> {
        self.incoming.pop_front()
    }

    pub(super) fn has_packet(&self) -> bool {
        !self.incoming.is_empty()
    }

    /// Leaves a packet for an acknowledgement to take along; false where there is no room.
    pub(super) fn queue(&mut self, data: Vec<u8>) -> bool {
        let room = self.outgoing.len() < SLOTS - 1;
        if room {
            self.outgoing.push_back(data);
        }
        room
    }

    pub(super) fn take_answers(&mut self) -> Vec<Answer> {
        std::mem::take(&mut self.answers)
    }

    fn empty(&self) -> Vec<u8> {
        vec![0xF3 | u8::from(self.down) << 2]
    }

    /// Acknowledges. A packet stays in its queue until what follows shows that it has arrived.
    fn answer(&mut self, at: Nanos, again: bool) {
        if !again {
            // The vendor's code drops a queued packet after a service packet too.
            if self.sent != Sent::Empty {
                self.outgoing.pop_front();
            }
            if self.sent == Sent::Service {
                self.service = None;
            }
            (self.sent, self.last) = if let Some(service) = &self.service {
                (Sent::Service, service.clone())
            } else if let Some(queued) = self.outgoing.front() {
                let mut data = queued.clone();
                if self.safelink
                    && let Some(header) = data.first_mut()
                {
                    *header = *header & 0xF3 | u8::from(self.down) << 2;
                }
                (Sent::Queued, data)
            } else {
                (Sent::Empty, self.empty())
            };
        }
        self.acknowledge(at, self.last.clone());
    }

    /// The radio is powered off and on for a setting: an acknowledgement that is not yet off the air is
    /// lost, and nothing is heard before the receiver has ramped up.
    pub(super) fn restart(&mut self, at: Nanos) {
        if at + LISTENS_AFTER < self.sends_until && self.answers.last() == self.on_air.as_ref() {
            self.answers.pop();
        }
        self.on_air = None;
        self.sends_until = at + RECEIVES_AFTER;
    }

    /// Puts an acknowledgement on the air. The radio hears nothing until it has turned round twice.
    fn acknowledge(&mut self, at: Nanos, data: Vec<u8>) {
        self.sends_until = at + ANSWERS_AFTER + self.air(data.len()) + LISTENS_AFTER;
        let answer = Answer { at, data };
        self.on_air = Some(answer.clone());
        self.answers.push(answer);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crtp(data: &[u8]) -> Packet {
        Packet { data: data.to_vec(), broadcast: false, rssi: 50 }
    }

    const MS: Nanos = 1_000_000;

    fn listening() -> Radio {
        let mut radio = Radio::new(0);
        radio.ready = true;
        radio.land(0, crtp(&[0xFF]));
        radio.take_answers();
        radio.take();
        radio
    }

    #[test]
    fn it_is_deaf_until_told_or_for_a_while_or_until_it_sends() {
        let mut radio = Radio::new(3_000 * MS);
        assert_eq!(radio.land(3_000 * MS - 1, crtp(&[0xFF])), Landed::Deaf);
        assert_eq!(radio.land(3_000 * MS, crtp(&[0xFF])), Landed::Taken);
        let mut radio = Radio::new(3_000 * MS);
        radio.ready = true;
        assert_eq!(radio.land(600, crtp(&[0xFF])), Landed::Taken);
        let mut radio = Radio::new(3_000 * MS);
        radio.send(10 * MS, 4);
        assert_eq!(radio.land(11 * MS, crtp(&[0xFF])), Landed::Taken);
    }

    /// Measured with the vendor's program: from the end of a packet on, at 2 Mbit/s.
    #[test]
    fn it_is_deaf_for_348_microseconds_behind_what_it_acknowledges() {
        let heard = |begins: Nanos| {
            let mut radio = listening();
            radio.land(MS, crtp(&[0xFF]));
            let broadcast = Packet { data: vec![0xFF, 0x8B, 1], broadcast: true, rssi: 50 };
            let ends = MS + begins + radio.air(3);
            radio.land(ends, broadcast) == Landed::Taken
        };
        let deaf_until = (0..).find(|us| heard(us * 1_000)).unwrap();
        assert!((340..=348).contains(&deaf_until), "{deaf_until}");
    }

    #[test]
    fn a_channel_that_there_is_not_is_taken_and_none_after_it() {
        let mut radio = listening();
        for (number, channel) in [(33, 33), (200, 72), (33, 72)] {
            radio.set_channel(number);
            assert_eq!(radio.tuning.channel, channel);
        }
    }

    #[test]
    fn the_oldest_slot_has_the_packet_that_came_seven_before_the_last() {
        let mut radio = listening();
        for n in 0..9_u8 {
            assert_eq!(radio.oldest_p2p().map(|(_, data)| data[0]), n.checked_sub(8));
            let data = vec![0xFF, 0x8B, n];
            radio.land(MS, Packet { data, broadcast: true, rssi: 50 });
            radio.take();
        }
        assert_eq!(radio.oldest_p2p(), Some((11, &[1][..])));
    }

    #[test]
    fn each_packet_from_the_ground_takes_one_answer_along() {
        let mut radio = listening();
        assert!(radio.queue(vec![0x10, 1]) && radio.queue(vec![0x10, 2]));
        for at in 1..=3 {
            radio.land(at * MS, crtp(&[0xFF]));
        }
        let answers: Vec<_> = radio.take_answers().into_iter().map(|answer| answer.data).collect();
        assert_eq!(answers[..2], [vec![0x10, 1], vec![0x10, 2]]);
        assert_eq!(answers[2][0] & 0xF3, 0xF3);
    }

    #[test]
    fn a_full_queue_takes_nothing_and_acknowledges_nothing() {
        let mut radio = listening();
        for at in 1..8 {
            assert_eq!(radio.land(at * MS, crtp(&[0x30, 1])), Landed::Taken);
        }
        radio.take_answers();
        assert_eq!(radio.land(9 * MS, crtp(&[0x30, 1])), Landed::NoRoom);
        assert!(radio.take_answers().is_empty());
        assert!((0..7).all(|n| radio.queue(vec![n])) && !radio.queue(vec![8]));
    }

    #[test]
    fn a_safe_link_repeats_what_was_not_acknowledged() {
        let mut radio = listening();
        radio.land(MS, crtp(&[0xFF, 0x05, 0x01]));
        assert_eq!(radio.take_answers()[0].data, [0xFF, 0x05, 0x01]);
        // The ground's next packet has both bits turned against the chip's, which begin as ones.
        radio.land(2 * MS, crtp(&[0x33, 9]));
        assert_eq!(radio.take_answers()[0].data, [0xF3]);
        radio.queue(vec![0x00, 1]);
        radio.land(3 * MS, crtp(&[0x3F, 9]));
        assert_eq!(radio.take_answers()[0].data, [0x04, 1]);
        // The same again: the ground has not heard the answer.
        radio.land(4 * MS, crtp(&[0x3F, 9]));
        assert_eq!(radio.take_answers()[0].data, [0x04, 1]);
        assert_eq!(radio.incoming.len(), 2);
    }
}
