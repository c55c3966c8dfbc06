//! RADIO: the states, the shortcuts between events and tasks, packets from and to memory.
//!
//! A packet that is on the air is received where the radio has listened on its channel, at its rate
//! and for its address, from before the first bit to the last; reception has no other error than
//! the one that the world asks for. READY, ADDRESS, PAYLOAD and END of a reception all happen at the
//! packet's end. RXCRC reads as zero. Whitening, static lengths and the device match are left out.

mod registers;

use std::collections::VecDeque;

use super::interrupts::Events;
use super::memory::Ram;
use crate::air::{Incoming, OnAir, Rate, Transmission, Upcoming};
use crate::{Cycles, MICROSECOND, NEVER};
use registers::{event, offset, short};

/// From TXEN to the first bit, and from RXEN to reception (zephyr, `radio_nrf51.h`).
const TX_RAMP_UP: Cycles = 140 * MICROSECOND;
const RX_RAMP_UP: Cycles = 138 * MICROSECOND;
/// From DISABLE to DISABLED: 6 µs where the radio sends; a receiver is disabled at once.
const TX_DISABLE: Cycles = 6 * MICROSECOND;

/// The registers that only keep their value: 0x504 to 0x544.
const FIRST_PLAIN: u32 = offset::PACKETPTR;
const PLAIN: usize = ((offset::TIFS - FIRST_PLAIN) / 4 + 1) as usize;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    Receive,
    Transmit,
}

#[derive(Clone, Debug)]
enum State {
    Disabled,
    RampUp {
        to: Direction,
        until: Cycles,
    },
    Idle(Direction),
    Receive {
        since: Cycles,
        pointer: u32,
    },
    Transmit(Transmission),
    /// The transmitter is being disabled.
    Disabling {
        until: Cycles,
    },
}

/// The radio.
#[derive(Clone, Debug)]
pub(super) struct Radio {
    events: Events,
    state: State,
    powered: bool,
    shorts: u32,
    plain: [u32; PLAIN],
    crc_is_good: bool,
    matched: u32,
    rssi: u8,
    /// Packets that are on the air, or will be, by the moment at which they end.
    incoming: VecDeque<Incoming>,
    sent: Vec<Transmission>,
    /// Packets for which the transmitter ramps up, or has done so since they were last taken.
    upcoming: Vec<Upcoming>,
    /// The first bit of the packet that was announced last.
    announced: Cycles,
    /// Packets that ended while the radio did not receive them.
    missed: u64,
}

impl Radio {
    pub(super) const fn new() -> Self {
        let mut plain = [0; PLAIN];
        plain[index(offset::FREQUENCY)] = 2;
        Self {
            events: Events::new(event::ALL),
            state: State::Disabled,
            powered: true,
            shorts: 0,
            plain,
            crc_is_good: false,
            matched: 0,
            rssi: 127,
            incoming: VecDeque::new(),
            sent: Vec::new(),
            upcoming: Vec::new(),
            announced: NEVER,
            missed: 0,
        }
    }

    pub(super) const fn line(&self) -> bool {
        self.events.line()
    }

    pub(super) fn due(&self) -> Cycles {
        let own = match &self.state {
            State::RampUp { until, .. } | State::Disabling { until } => *until,
            State::Transmit(packet) => packet.end,
            State::Disabled | State::Idle(_) | State::Receive { .. } => NEVER,
        };
        own.min(self.incoming.front().map_or(NEVER, |packet| packet.end))
    }

    /// Packets whose sending has ended or was cut off, since this was last called.
    pub(super) fn take_sent(&mut self) -> Vec<Transmission> {
        std::mem::take(&mut self.sent)
    }

    /// Packets for which the transmitter began to ramp up since this was last called. One whose ramp-up
    /// was broken off meanwhile is not among them.
    pub(super) fn take_upcoming(&mut self) -> Vec<Upcoming> {
        std::mem::take(&mut self.upcoming)
    }

    /// Announces the packet for which the transmitter ramps up.
    pub(super) fn announce(&mut self, ram: &Ram) {
        let State::RampUp { to: Direction::Transmit, until } = self.state else { return };
        if self.announced != until && self.shorts & short::READY_START != 0 {
            self.announced = until;
            let packet = self.packet_at(self.get(offset::PACKETPTR), ram);
            self.upcoming.push(Upcoming { start: until, packet });
        }
    }

    /// Whether it receives at this moment.
    pub(super) const fn listens(&self) -> bool {
        matches!(self.state, State::Receive { .. })
    }

    pub(super) const fn missed(&self) -> u64 {
        self.missed
    }

    /// A packet will be on the air, or is.
    pub(super) fn hear(&mut self, packet: Incoming) {
        let behind = self.incoming.partition_point(|other| other.end <= packet.end);
        self.incoming.insert(behind, packet);
    }

    const fn get(&self, offset: u32) -> u32 {
        self.plain[index(offset)]
    }

    pub(super) const fn rate(&self) -> Rate {
        match self.get(offset::MODE) {
            1 => Rate::M2,
            2 => Rate::K250,
            _ => Rate::M1,
        }
    }

    pub(super) const fn channel(&self) -> u8 {
        self.get(offset::FREQUENCY) as u8
    }

    /// TXPOWER, in dBm.
    pub(super) const fn power_level(&self) -> i8 {
        (self.get(offset::TXPOWER) as u8).cast_signed()
    }

    /// One of the eight addresses, as another maker's radio has it: the first byte on the air first,
    /// and in each byte the first bit highest.
    pub(super) const fn address(&self, number: u32) -> [u8; 5] {
        let prefixes = self.get(offset::PREFIX0 + number / 4 * 4);
        let prefix = (prefixes >> (number % 4 * 8)) as u8;
        let base = self.get(if number == 0 { offset::BASE0 } else { offset::BASE1 });
        let [a, b, c, d] = base.to_be_bytes();
        [
            prefix.reverse_bits(),
            a.reverse_bits(),
            b.reverse_bits(),
            c.reverse_bits(),
            d.reverse_bits(),
        ]
    }

    /// Everything happens that happens until now.
    pub(super) fn advance(&mut self, now: Cycles, ram: &mut Ram) {
        while self.due() <= now {
            let at = self.due();
            while let Some(packet) = self.incoming.pop_front_if(|packet| packet.end <= at) {
                self.land(&packet, ram);
            }
            match &self.state {
                State::RampUp { to, until } if *until <= at => {
                    self.state = State::Idle(*to);
                    self.events.raise(event::READY);
                    if self.shorts & short::READY_START != 0 {
                        self.start(at, ram);
                    }
                }
                State::Disabling { until } if *until <= at => self.disabled(at),
                State::Transmit(packet) if packet.end <= at => {
                    let packet = packet.clone();
                    self.sent.push(packet);
                    self.finish(Direction::Transmit, at, ram);
                }
                _ => {}
            }
        }
    }

    /// A packet has ended: END, and its shortcuts.
    fn finish(&mut self, direction: Direction, at: Cycles, ram: &mut Ram) {
        self.state = State::Idle(direction);
        self.events.raise(event::ADDRESS);
        self.events.raise(event::PAYLOAD);
        self.events.raise(event::END);
        if self.shorts & short::END_DISABLE != 0 {
            self.disable(at);
        } else if self.shorts & short::END_START != 0 {
            self.start(at, ram);
        }
    }

    /// The START task.
    fn start(&mut self, now: Cycles, ram: &Ram) {
        let pointer = self.get(offset::PACKETPTR);
        match self.state {
            State::Idle(Direction::Receive) => {
                self.state = State::Receive { since: now, pointer };
            }
            State::Idle(Direction::Transmit) => {
                let packet = self.packet_at(pointer, ram);
                let end = now + packet.duration();
                let transmission = Transmission { start: now, end, is_cut: false, packet };
                self.state = State::Transmit(transmission);
            }
            _ => {}
        }
    }

    /// The sizes of the packet's fields in memory: S0, length and S1, in bytes.
    const fn header(&self) -> (u32, u32, u32) {
        let pcnf0 = self.get(offset::PCNF0);
        let (length, s0, s1) = (pcnf0 & 15, pcnf0 >> 8 & 1, pcnf0 >> 16 & 15);
        (s0, (length != 0) as u32, (s1 != 0) as u32)
    }

    /// The longest payload: what the length field can say, and MAXLEN.
    const fn longest(&self) -> u32 {
        let bits = self.get(offset::PCNF0) & 15;
        let most = (1 << bits) - 1;
        let limit = self.get(offset::PCNF1) & 0xFF;
        if most < limit { most } else { limit }
    }

    /// The bits of a packet on the air besides its payload: preamble, address, S0, length, S1, CRC.
    const fn overhead(&self) -> u32 {
        let (pcnf0, pcnf1) = (self.get(offset::PCNF0), self.get(offset::PCNF1));
        let address = (pcnf1 >> 16 & 7) + 1;
        let fields = (pcnf0 >> 8 & 1) * 8 + (pcnf0 & 15) + (pcnf0 >> 16 & 15);
        8 + address * 8 + fields + (self.get(offset::CRCCNF) & 3) * 8
    }

    /// The packet in memory, as it goes on the air.
    fn packet_at(&self, pointer: u32, ram: &Ram) -> OnAir {
        let (s0, length, s1) = self.header();
        let bits = self.get(offset::PCNF0) & 15;
        let said = u32::from(ram.byte(pointer + s0)) & ((1 << bits) - 1);
        let size = said.min(self.longest());
        let data = pointer + s0 + length + s1;
        OnAir {
            channel: self.channel(),
            rate: self.rate(),
            address: self.address(self.get(offset::TXADDRESS) & 7),
            power: self.power_level(),
            s1: if s1 == 0 { 0 } else { ram.byte(pointer + s0 + length) & 7 },
            payload: (data..data + size).map(|at| ram.byte(at)).collect(),
            overhead: self.overhead(),
        }
    }

    /// A packet has come off the air: it is received where the radio has listened to all of it.
    fn land(&mut self, incoming: &Incoming, ram: &mut Ram) {
        let State::Receive { since, pointer } = self.state else {
            self.missed += 1;
            return;
        };
        let packet = &incoming.packet;
        let fits = packet.channel == self.channel() && packet.rate == self.rate();
        let enabled = self.get(offset::RXADDRESSES);
        let number =
            (0..8).find(|it| enabled & 1 << it != 0 && self.address(*it) == packet.address);
        let (Some(number), true) = (number, fits && since <= incoming.start) else {
            self.missed += 1;
            return;
        };
        let (s0, length, s1) = self.header();
        let data = &packet.payload[..packet.payload.len().min(self.longest() as usize)];
        ram.set_byte(pointer + s0, data.len() as u8);
        if s1 != 0 {
            ram.set_byte(pointer + s0 + length, packet.s1);
        }
        for (byte, at) in data.iter().zip(pointer + s0 + length + s1..) {
            ram.set_byte(at, *byte);
        }
        (self.matched, self.crc_is_good) = (number, incoming.is_intact);
        if self.shorts & short::ADDRESS_RSSISTART != 0 {
            self.sample(incoming.rssi);
        }
        self.finish(Direction::Receive, incoming.end, ram);
    }

    const fn sample(&mut self, rssi: u8) {
        self.rssi = rssi & 0x7F;
        self.events.raise(event::RSSIEND);
    }

    fn enable(&mut self, to: Direction, now: Cycles) {
        if let State::Disabled = self.state {
            let time = match to {
                Direction::Receive => RX_RAMP_UP,
                Direction::Transmit => TX_RAMP_UP,
            };
            self.state = State::RampUp { to, until: now + time };
        }
    }

    /// The DISABLE task. In a radio that is disabled already it raises DISABLED all the same.
    fn disable(&mut self, now: Cycles) {
        self.cut(now);
        match self.state {
            State::Disabling { .. } => {}
            State::RampUp { to: Direction::Transmit, .. }
            | State::Idle(Direction::Transmit)
            | State::Transmit(_) => self.state = State::Disabling { until: now + TX_DISABLE },
            _ => self.disabled(now),
        }
    }

    /// A packet that is being sent ends here, and one for which the transmitter ramps up is never sent.
    fn cut(&mut self, now: Cycles) {
        if let State::RampUp { to: Direction::Transmit, until } = self.state {
            self.upcoming.retain(|packet| packet.start != until);
        }
        if let State::Transmit(packet) = &self.state {
            let packet = Transmission { end: now, is_cut: true, ..packet.clone() };
            self.sent.push(packet);
        }
    }

    fn disabled(&mut self, now: Cycles) {
        self.state = State::Disabled;
        self.events.raise(event::DISABLED);
        if self.shorts & short::DISABLED_TXEN != 0 {
            self.enable(Direction::Transmit, now);
        } else if self.shorts & short::DISABLED_RXEN != 0 {
            self.enable(Direction::Receive, now);
        }
    }

    /// POWER: off is a reset of the whole peripheral.
    fn power(&mut self, now: Cycles, on: bool) {
        if !on {
            self.cut(now);
            let incoming = std::mem::take(&mut self.incoming);
            let (sent, upcoming) = (std::mem::take(&mut self.sent), self.take_upcoming());
            *self = Self { incoming, sent, upcoming, missed: self.missed, ..Self::new() };
        }
        self.powered = on;
    }

    const fn state_number(&self) -> u32 {
        match self.state {
            State::Disabled => 0,
            State::RampUp { to: Direction::Receive, .. } => 1,
            State::Idle(Direction::Receive) => 2,
            State::Receive { .. } => 3,
            State::RampUp { to: Direction::Transmit, .. } => 9,
            State::Idle(Direction::Transmit) => 10,
            State::Transmit(_) => 11,
            State::Disabling { .. } => 12,
        }
    }

    pub(super) fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            offset::SHORTS => self.shorts,
            offset::CRCSTATUS => self.crc_is_good.into(),
            offset::RXMATCH => self.matched,
            offset::RXCRC => 0,
            offset::PACKETPTR..=offset::TIFS => self.get(offset),
            offset::RSSISAMPLE => self.rssi.into(),
            offset::STATE => self.state_number(),
            offset::POWER => self.powered.into(),
            _ => return self.events.read(offset),
        })
    }

    pub(super) fn write(&mut self, now: Cycles, offset: u32, value: u32, ram: &Ram) -> Option<()> {
        match offset {
            // A task is triggered by a 1.
            offset::TXEN..=offset::RSSISTOP if value & 1 == 0 => {}
            offset::TXEN => self.enable(Direction::Transmit, now),
            offset::RXEN => self.enable(Direction::Receive, now),
            offset::START => self.start(now, ram),
            offset::STOP => {
                self.cut(now);
                self.state = match self.state {
                    State::Receive { .. } => State::Idle(Direction::Receive),
                    State::Transmit(_) => State::Idle(Direction::Transmit),
                    _ => return Some(()),
                };
            }
            offset::DISABLE => self.disable(now),
            offset::RSSISTART | offset::RSSISTOP => {}
            offset::SHORTS => self.shorts = value,
            offset::PACKETPTR..=offset::TIFS => self.plain[index(offset)] = value,
            offset::POWER => self.power(now, value & 1 != 0),
            _ => self.events.write(offset, value)?,
        }
        Some(())
    }
}

/// The place of a register that only keeps its value.
const fn index(offset: u32) -> usize {
    ((offset - FIRST_PLAIN) / 4) as usize
}
