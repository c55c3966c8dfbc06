//! The radio chip's radio: what comes off the air, what is acknowledged and with what, and what
//! waits to be passed on (crazyflie2-nrf-firmware, `esb.c`).
//!
//! The module is not a medium: the caller decides which radio receives which packet, and how strong.

use std::collections::VecDeque;

use crate::soc::Nanos;

/// Slots of either queue, of which one is always empty (`RXQ_LEN`, `TXQ_LEN`).
const SLOTS: usize = 8;
/// The chip listens after this time even if the flight processor never enabled its radio
/// (`SYSLINK_RADIO_DISABLED_TIMEOUT_MS`).
const GATE: Nanos = 3_000_000_000;

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
    /// Since when it runs.
    since: Nanos,
    /// The radio sends, or turns round, until then.
    sends_until: Nanos,
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
    pub(super) fn new(since: Nanos) -> Self {
        Self {
            tuning: Tuning::DEFAULT,
            ready: false,
            carrier: false,
            since,
            sends_until: 0,
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

    /// Since when it runs.
    pub(super) const fn since(&self) -> Nanos {
        self.since
    }

    pub(super) fn listens(&self, at: Nanos) -> bool {
        at >= self.since && (self.ready || at >= self.since + GATE) && !self.carrier
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

    /// It sends so many bytes of a P2P packet's data, which takes the time that they are on the air
    /// and that it takes to turn round, twice. It hears nothing meanwhile: not the end of what was
    /// on the air when it began either.
    pub(super) fn send(&mut self, at: Nanos, data: usize) {
        /// Preamble, address, nine bits of control, port and kind, and checksum (nRF24L01+ product
        /// specification, 7.3).
        const AROUND: u64 = 8 * (1 + 5 + 2 + 2) + 9;
        let bits = AROUND + 8 * data as u64;
        let per_bit = match self.tuning.datarate {
            Datarate::K250 => 4_000,
            Datarate::M1 => 1_000,
            Datarate::M2 => 500,
        };
        self.sends_until = at + 2 * super::RAMP_UP + bits * per_bit;
    }

    /// A packet has come off the air; one to the chip alone is acknowledged at once.
    pub(super) fn land(&mut self, at: Nanos, packet: Packet) -> Landed {
        if !self.listens(at) || at < self.sends_until {
            return Landed::Deaf;
        }
        if self.incoming.len() == SLOTS - 1 {
            return Landed::NoRoom;
        }
        if packet.broadcast {
            self.incoming.push_back(packet);
            return Landed::Taken;
        }
        let header = packet.data.first().copied().unwrap_or_default();
        if packet.is_p2p() {
            let data = self.empty();
            self.answers.push(Answer { at, data });
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
        self.answers.push(Answer { at, data: self.last.clone() });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crtp(data: &[u8]) -> Packet {
        Packet { data: data.to_vec(), broadcast: false, rssi: 50 }
    }

    fn listening() -> Radio {
        let mut radio = Radio::new(0);
        radio.ready = true;
        radio.land(0, crtp(&[0xFF]));
        radio.take_answers();
        radio.take();
        radio
    }

    #[test]
    fn it_is_deaf_until_told_or_for_three_seconds() {
        let mut radio = Radio::new(500);
        assert_eq!(radio.land(GATE, crtp(&[0xFF])), Landed::Deaf);
        assert_eq!(radio.land(GATE + 500, crtp(&[0xFF])), Landed::Taken);
        let mut radio = Radio::new(500);
        radio.ready = true;
        assert_eq!(radio.land(600, crtp(&[0xFF])), Landed::Taken);
    }

    #[test]
    fn each_packet_from_the_ground_takes_one_answer_along() {
        let mut radio = listening();
        assert!(radio.queue(vec![0x10, 1]) && radio.queue(vec![0x10, 2]));
        for at in 1..=3 {
            radio.land(at, crtp(&[0xFF]));
        }
        let answers: Vec<_> = radio.take_answers().into_iter().map(|answer| answer.data).collect();
        assert_eq!(answers[..2], [vec![0x10, 1], vec![0x10, 2]]);
        assert_eq!(answers[2][0] & 0xF3, 0xF3);
    }

    #[test]
    fn a_full_queue_takes_nothing_and_acknowledges_nothing() {
        let mut radio = listening();
        for _ in 0..7 {
            assert_eq!(radio.land(1, crtp(&[0x30, 1])), Landed::Taken);
        }
        radio.take_answers();
        assert_eq!(radio.land(2, crtp(&[0x30, 1])), Landed::NoRoom);
        assert!(radio.take_answers().is_empty());
        assert!((0..7).all(|n| radio.queue(vec![n])) && !radio.queue(vec![8]));
    }

    #[test]
    fn a_safe_link_repeats_what_was_not_acknowledged() {
        let mut radio = listening();
        radio.land(1, crtp(&[0xFF, 0x05, 0x01]));
        assert_eq!(radio.take_answers()[0].data, [0xFF, 0x05, 0x01]);
        // The ground's next packet has both bits turned against the chip's, which begin as ones.
        radio.land(2, crtp(&[0x33, 9]));
        assert_eq!(radio.take_answers()[0].data, [0xF3]);
        radio.queue(vec![0x00, 1]);
        radio.land(3, crtp(&[0x3F, 9]));
        assert_eq!(radio.take_answers()[0].data, [0x04, 1]);
        // The same again: the ground has not heard the answer.
        radio.land(4, crtp(&[0x3F, 9]));
        assert_eq!(radio.take_answers()[0].data, [0x04, 1]);
        assert_eq!(radio.incoming.len(), 2);
    }
}
