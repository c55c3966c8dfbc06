//! An emulated radio chip that runs the vendor's firmware, on the wires of the board.
//!
//! The chip runs up to every moment at which the flight processor touches the board, and at least once
//! in [`SLICE`] beside it: shorter than a byte on the line, so that each byte is there before its last
//! bit, and so that the "wait" pin changes on time to within that. A byte for the chip counts from its
//! stop bit, before which neither side can know of it. Both run on one thread in an order that does
//! not depend on the host.
//!
//! The pins are those of crazyflie2-nrf-firmware, `pinout.h`. Left out are the one-wire memories of
//! the decks: the chip finds none. What the flight processor's power does to it is [`Power`]; the
//! machine itself runs on.

use std::collections::VecDeque;

use nrf51_chip::air::{Incoming, OVERHEAD, OnAir, Rate, Transmission, Upcoming};
use nrf51_chip::core::Fault;
use nrf51_chip::{Chip, Cycles, MICROSECOND, PinLevel};
use units::Volts;

use super::boot::RadioFirmware;
use super::{Heard, What};
use crate::board::noise::Shares;
use crate::board::nrf51::{
    ANSWERS_AFTER, Answer, Datarate, OffCause, Power, RAMP_UP, Sent, Tuning,
};
use crate::board::serial::{BIT, Received, SerialLine};
use crate::soc::{Level, Nanos, UartByte};

/// The pins of port 0.
pub(super) mod pin {
    pub(in super::super) const CHARGES: u8 = 0;
    pub(in super::super) const USB: u8 = 4;
    pub(in super::super) const SUPPLY: u8 = 10;
    pub(in super::super) const LED: u8 = 13;
    pub(in super::super) const BUTTON: u8 = 17;
    pub(in super::super) const RESET: u8 = 21;
}
/// The analog input of the battery, and the divider in front of it.
pub(super) const BATTERY: (u8, f32) = (2, 3.0);

/// The two run apart for no longer than this.
const SLICE: Nanos = 8_000;
/// A press of the button: long enough to be none of its bounces, too short to be a long one.
const PRESS: Nanos = 100_000_000;
/// The address of packets to all.
const BROADCAST: [u8; 5] = [0xFF, 0xE7, 0xE7, 0xE7, 0xE7];
/// The most payload of a packet (MAXLEN).
const LONGEST: usize = 63;

/// The chip and its wires.
#[derive(Debug)]
pub struct FirmwareChip {
    chip: Chip,
    /// The chip's cycle at which the flight processor's time begins.
    began: Cycles,
    clock: Nanos,
    power: Power,
    /// A chip that was reset gives the supply anew; until then the flight processor keeps it.
    restarts: bool,
    pressed_until: Nanos,
    wire: SerialLine,
    out: VecDeque<UartByte>,
    answers: Vec<Answer>,
    fault: Option<Fault>,
    /// The chip signals a full buffer, though it may have room.
    pub(in crate::board) stuck_full: bool,
}

impl FirmwareChip {
    pub(super) fn new(firmware: &RadioFirmware) -> Self {
        let chip = firmware.chip();
        Self {
            began: chip.now(),
            chip,
            clock: 0,
            power: Power::On,
            restarts: false,
            pressed_until: Nanos::MAX,
            wire: SerialLine::clear(),
            out: VecDeque::new(),
            answers: Vec::new(),
            fault: None,
            stuck_full: false,
        }
    }

    /// The chip itself, to look at.
    #[must_use]
    pub const fn chip(&self) -> &Chip {
        &self.chip
    }

    /// Why the chip does not go on, if it does not.
    #[must_use]
    pub const fn fault(&self) -> Option<Fault> {
        self.fault
    }

    pub(super) const fn power(&self) -> Power {
        self.power
    }

    /// The settings of the radio.
    pub(super) const fn tuning(&self) -> Tuning {
        let radio = self.chip.radio();
        let datarate = match radio.rate {
            Rate::K250 => Datarate::K250,
            Rate::M1 => Datarate::M1,
            Rate::M2 => Datarate::M2,
        };
        let [a, b, c, d, e] = radio.address;
        Tuning { channel: radio.channel, datarate, address: [e, d, c, b, a], power: radio.power }
    }

    /// The chip's cycle at a moment of the flight processor's.
    const fn cycle(&self, at: Nanos) -> Cycles {
        self.began + at * MICROSECOND / 1_000
    }

    /// The moment of a cycle; one before the flight processor's time is its beginning.
    const fn nanos(&self, cycle: Cycles) -> Nanos {
        cycle.saturating_sub(self.began) * 1_000 / MICROSECOND
    }

    pub(super) const fn due(&self) -> Nanos {
        if self.chip.is_off() { Nanos::MAX } else { (self.clock / SLICE + 1) * SLICE }
    }

    pub(super) fn advance(&mut self, now: Nanos) {
        while self.pressed_until <= now {
            self.run(self.pressed_until);
            self.pressed_until = Nanos::MAX;
            self.chip.drive_pin(pin::BUTTON, None);
        }
        self.run(now);
    }

    fn run(&mut self, now: Nanos) {
        self.clock = self.clock.max(now);
        if self.fault.is_none() {
            self.fault = self.chip.run_until(self.cycle(now)).err();
        }
        while let Some(sent) = self.chip.sent_bytes().pop_front() {
            let at = self.nanos(sent.at);
            let byte = UartByte { at, bit: BIT, data: sent.byte, noise: false, broken: false };
            self.out.push_back(byte);
        }
        for sent in self.chip.take_transmissions() {
            self.answers.extend(self.answer(sent));
        }
        for change in self.chip.take_pin_changes() {
            if change.pin == pin::SUPPLY {
                self.supply(self.nanos(change.at), change.level);
            }
        }
    }

    fn supply(&mut self, at: Nanos, level: PinLevel) {
        if level == PinLevel::High {
            self.restarts = false;
        } else if self.power == Power::On && !self.restarts {
            self.power = Power::Off { since: at, cause: OffCause::Firmware };
        }
    }

    pub(super) fn led(&self) -> bool {
        self.chip.pin(pin::LED) == PinLevel::High
    }

    pub(super) fn wait(&self) -> Level {
        match self.chip.rts() {
            _ if self.stuck_full => Level::High,
            None => Level::Released,
            Some(true) => Level::High,
            Some(false) => Level::Low,
        }
    }

    pub(super) fn take(&mut self, now: Nanos, byte: u8, bit: u32) {
        if self.power != Power::On {
            return;
        }
        let byte = match self.wire.receive(byte, bit) {
            Received::Byte(byte) => Some(byte),
            Received::Broken => None,
            Received::Nothing => return,
        };
        self.chip.receive(self.cycle(now), byte);
    }

    pub(super) fn give(&mut self, now: Nanos) -> Option<UartByte> {
        while let Some(byte) = self.out.pop_front_if(|byte| byte.at <= now) {
            if let Some(byte) = self.wire.send(byte) {
                return Some(byte);
            }
        }
        None
    }

    /// A packet comes off the air, on the channel and at the rate to which the radio is set.
    pub(super) fn hear(&mut self, heard: &Heard<'_>) {
        let radio = self.chip.radio();
        let (address, mut payload) = match heard.what {
            What::P2p { port, data, broadcast } => {
                let head = [0xFF, 0x80 | (port & 0x0F)];
                let address = if broadcast { BROADCAST } else { radio.address };
                (address, [&head, data].concat())
            }
            What::Crtp(data) => (radio.address, data.to_vec()),
        };
        payload.truncate(LONGEST);
        let packet = OnAir {
            channel: radio.channel,
            rate: radio.rate,
            address,
            power: 0,
            s1: 0,
            payload,
            overhead: OVERHEAD,
        };
        let end = self.cycle(heard.at.max(self.clock));
        let start = end.saturating_sub(packet.duration());
        self.chip.hear(Incoming { start, end, packet, rssi: heard.rssi, is_intact: true });
    }

    /// The packets for all drones that go on the air soon: those of which the chip has none of a
    /// drone's to send are left out.
    pub(super) fn take_sent(&mut self) -> Vec<Sent> {
        let tuning = self.tuning();
        let upcoming = self.chip.take_upcoming().into_iter();
        upcoming.filter_map(|it| self.sent(it, tuning)).collect()
    }

    fn sent(&self, upcoming: Upcoming, tuning: Tuning) -> Option<Sent> {
        let at = self.nanos(upcoming.start).saturating_sub(RAMP_UP);
        let OnAir { address: BROADCAST, payload, .. } = upcoming.packet else { return None };
        match payload.as_slice() {
            [0xF3 | 0xF7 | 0xFB | 0xFF, port @ 0x80..=0x8F, data @ ..] => {
                Some(Sent { at, port: port & 0x0F, data: data.to_vec(), tuning })
            }
            _ => None,
        }
    }

    pub(super) fn take_answers(&mut self) -> Vec<Answer> {
        std::mem::take(&mut self.answers)
    }

    /// What was sent as an acknowledgement, unless it was cut off.
    fn answer(&self, sent: Transmission) -> Option<Answer> {
        let at = self.nanos(sent.start).saturating_sub(ANSWERS_AFTER);
        let is_answer = !sent.is_cut && sent.packet.address != BROADCAST;
        is_answer.then_some(Answer { at, data: sent.packet.payload })
    }

    pub(super) fn set_battery(&mut self, now: Nanos, volts: f32, charging: bool, usb: bool) {
        self.run(now);
        self.chip.set_analog(BATTERY.0, Volts(volts / BATTERY.1));
        self.chip.drive_pin(pin::CHARGES, charging.then_some(false));
        self.chip.drive_pin(pin::USB, usb.then_some(false));
    }

    pub(super) fn press(&mut self, now: Nanos) {
        self.run(now);
        self.chip.drive_pin(pin::BUTTON, Some(false));
        self.pressed_until = now + PRESS;
    }

    pub(super) fn disturb(&mut self, shares: Shares, seed: u64) {
        self.wire.disturb(shares, seed);
    }

    /// Resets the chip, beside a flight processor that runs on.
    pub(super) fn reset(&mut self, now: Nanos) {
        self.run(now);
        self.restarts = true;
        self.fault = self.chip.reset().err();
    }

    /// Sets the radio to another channel by a command from the air.
    pub(super) fn retune(&mut self, now: Nanos, channel: u8) {
        self.run(now);
        let what = What::Crtp(&[0xFF, 0x03, 0x01, channel]);
        self.hear(&Heard { at: now, rssi: 40, what });
    }
}
