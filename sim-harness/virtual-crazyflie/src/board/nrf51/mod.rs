//! The radio chip with the vendor's firmware, as the flight processor and the air see it.
//!
//! | module | what it holds |
//! |---|---|
//! | `frame` | the serial line's frames |
//! | `line` | its bytes and their times |
//! | `orders` | commands from the flight processor and from the air |
//! | `radio` | the radio's queues, acknowledgements and settings |
//! | `power` | the button, and power that goes |
//!
//! This module is the chip's main loop (crazyflie2-nrf-firmware, `main.c`): in each round it passes
//! on one packet from the air, handles one frame from the line, reports the battery and the signal
//! when 10 ms have passed, and looks at the button. It waits for every byte that it sends, 10 µs
//! each. So a frame that comes in meanwhile is handled when the sending is over, up to 0.7 ms later:
//! that is the chip's latency. What its 16 MHz core takes for a round, a few µs, is left out.
//!
//! Bytes from the flight processor go into the six of the peripheral and, by an interrupt, into the
//! 127 of the program (`uart.c`). The "wait" pin is the peripheral's RTS: it tells of the six only,
//! in the middle of a frame as well, and what the program has no room for is lost without a sign.
//! Interrupts are served at once, except while [`Fault::RadioBusy`](super::Fault::RadioBusy) says
//! that the core has something else to do.

mod frame;
mod line;
mod orders;
mod power;
mod radio;

use std::collections::VecDeque;

pub use power::{OffCause, Power};
pub use radio::{Answer, Datarate, Tuning};

use super::deck_memory::DeckMemory;
use super::noise::{Noise, Shares};
use crate::soc::{Level, Nanos, UartByte};
use frame::{Found, MTU, Parser, frame, kind};
use line::{Busy, Line};
use power::{Shutdown, TICK, tick};
use radio::{Landed, Packet, Radio};

/// Between two reports of the battery, and of the signal (`SYSLINK_SEND_PERIOD_MS`).
const REPORT: Nanos = 10 * TICK;
/// From a reset to the main loop with its line open: 100 ms of "short boot delay" (`main.c`) and
/// five steps of power, the longest 350 ms (`pm.c`).
const BOOT: Nanos = 460 * TICK;
/// The most data of a packet between drones (crazyflie-firmware, `radiolink.h`).
const MAX_P2P: usize = 60;
/// The charger's current in the units of `pmGetISET`, which are amperes whatever its document says.
const CHARGE_AMPERES: f32 = 0.5;

/// From the moment at which the loop hands a packet to the radio to the first bit on the air
/// (zephyr, `radio_nrf51.h`: `HAL_RADIO_NRF51_TXEN_TXIDLE_TX_US`).
pub const RAMP_UP: Nanos = 140_000;

/// A packet for all drones, handed to the radio. It is on the air [`RAMP_UP`] later, for as long as
/// its length and the data rate make it; while that lasts this drone hears nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sent {
    /// When: its frame's last byte has come in, or the chip has finished what it was sending then.
    pub at: Nanos,
    /// The P2P port.
    pub port: u8,
    /// The packet's data, without port.
    pub data: Vec<u8>,
    /// The settings of the radio.
    pub tuning: Tuning,
}

/// Counts since the chip was last reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Good frames from the flight processor.
    pub good: u32,
    /// Frames whose first sum was wrong,
    pub bad_first_sums: u32,
    /// or their second.
    pub bad_second_sums: u32,
    /// Frames that said they were longer than any is.
    pub too_long: u32,
    /// Bytes for which there was no room.
    pub dropped_bytes: u32,
    /// Bytes that were none: sent at another speed, or without a stop bit.
    pub broken_bytes: u32,
    /// Frames of a type or with data that this model does not know what to do with. The chip may
    /// do something with some of them.
    pub not_understood: u32,
    /// The type of the latest of these.
    pub last_not_understood: Option<u8>,
    /// Packets that came off the air while the radio did not listen.
    pub deaf: u32,
    /// Packets that came off the air while the queue was full.
    pub overruns: u32,
    /// Packets to the ground for which there was no room.
    pub refused: u32,
    /// Commands from the air, to the radio or to the chip's loader, that this model does not know.
    pub commands: u32,
}

/// The battery as the chip measures it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Battery {
    volts: f32,
    charging: bool,
    usb: bool,
}

/// The steps of a round of the main loop, in its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Air,
    Line,
    Battery,
    Signal,
    Power,
}

impl Step {
    const ROUND: [Self; 5] = [Self::Air, Self::Line, Self::Battery, Self::Signal, Self::Power];
}

/// The state that a reset clears.
#[derive(Debug)]
struct State {
    parser: Parser,
    radio: Radio,
    /// A good frame has come in: it may send.
    talks: bool,
    /// The chip reports battery and signal.
    reports: bool,
    battery_due: Nanos,
    signal_due: Nanos,
    /// The signal of the packet that it passed on last, or zero.
    rssi: u8,
    bluetooth: bool,
    shutdown: Shutdown,
    /// How often the flight processor has set the channel, the data rate and the address.
    configured: [u8; 3],
    counters: Counters,
    /// The chip sends, or boots, until then.
    busy_until: Nanos,
    /// The position of the next round.
    next_step: usize,
}

impl State {
    fn new(since: Nanos) -> Self {
        Self {
            parser: Parser::new(),
            radio: Radio::new(since),
            talks: false,
            reports: false,
            battery_due: 0,
            signal_due: 0,
            rssi: 0,
            bluetooth: true,
            shutdown: Shutdown::Idle,
            configured: [0; 3],
            counters: Counters::default(),
            busy_until: since,
            next_step: 0,
        }
    }

    /// When the chip is up, or was.
    const fn up_since(&self) -> Nanos {
        self.radio.since()
    }
}

/// The chip.
#[derive(Debug)]
pub struct Nrf51 {
    /// The version that the chip reports for its firmware.
    version: String,
    memories: Vec<DeckMemory>,
    line: Line,
    state: State,
    power: Power,
    battery: Battery,
    led: bool,
    /// Packets on the air, by the moment at which they end.
    flying: VecDeque<(Nanos, Packet)>,
    sent: Vec<Sent>,
    clock: Nanos,
    due: Nanos,
    /// The chip signals a full buffer, though it may have room.
    pub(super) stuck_full: bool,
}

impl Nrf51 {
    /// The chip of a drone that it has just given power: it is up already.
    pub(super) fn new(version: &str, memories: Vec<DeckMemory>) -> Self {
        let mut chip = Self {
            version: version.to_owned(),
            memories,
            line: Line::new(),
            state: State::new(0),
            power: Power::On,
            battery: Battery { volts: 4.0, charging: false, usb: false },
            led: true,
            flying: VecDeque::new(),
            sent: Vec::new(),
            clock: 0,
            due: Nanos::MAX,
            stuck_full: false,
        };
        chip.plan();
        chip
    }

    /// The chip's counts.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        let mut counters = self.state.counters;
        counters.dropped_bytes = self.line.losses.dropped;
        counters.broken_bytes = self.line.losses.broken;
        counters
    }

    /// The settings of the radio.
    #[must_use]
    pub const fn tuning(&self) -> Tuning {
        self.state.radio.tuning
    }

    /// Whether its radio hears anything.
    #[must_use]
    pub fn listens(&self) -> bool {
        self.power == Power::On && self.state.radio.listens(self.clock)
    }

    /// Whether it is still in Bluetooth mode, in which it hears other drones only now and then, and
    /// survives only the settings that the vendor's firmware sends. The first packet that it passes on
    /// or sends ends this mode. This model hears in it as well as otherwise.
    #[must_use]
    pub const fn is_in_bluetooth(&self) -> bool {
        self.state.bluetooth
    }

    /// Whether the flight processor has power.
    #[must_use]
    pub const fn power(&self) -> Power {
        self.power
    }

    /// When it next does something by itself.
    pub(super) fn due(&self) -> Nanos {
        self.due.min(self.line.due())
    }

    pub(super) const fn led(&self) -> bool {
        self.led
    }

    /// The level of its "wait" pin. Until the chip has started, the pin is not driven.
    pub(super) fn wait(&self) -> Level {
        if self.stuck_full {
            Level::High
        } else if self.clock < self.state.up_since() {
            Level::Released
        } else if self.line.is_full() {
            Level::High
        } else {
            Level::Low
        }
    }

    pub(super) fn set_battery(&mut self, volts: f32, charging: bool, usb: bool) {
        self.battery = Battery { volts, charging, usb };
    }

    pub(super) fn press(&mut self, now: Nanos) {
        if self.state.shutdown == Shutdown::Idle {
            self.state.shutdown = Shutdown::Pressed;
        }
        self.run(now);
    }

    pub(super) fn disturb(&mut self, shares: Shares, seed: u64) {
        self.line.noise = (Noise::new(shares, seed), Noise::new(shares, !seed));
    }

    /// Resets the chip: its state is lost, and it neither receives nor sends while it boots.
    pub(super) fn reset(&mut self, now: Nanos) {
        self.line.fall_silent(now);
        self.line.losses = line::Losses::default();
        self.state = State::new(now + BOOT);
        self.led = true;
        self.run(now);
    }

    /// A byte from the flight processor, whose stop bit passes now.
    pub(super) fn take(&mut self, now: Nanos, byte: u8, bit: u32) {
        if self.power == Power::On && now >= self.state.up_since() {
            self.line.take(now, byte, bit);
            self.run(now);
        }
    }

    /// The byte that has begun by now.
    pub(super) fn give(&mut self, now: Nanos) -> Option<UartByte> {
        self.line.give(now)
    }

    /// A packet that has come off the air at a moment that is not past.
    fn hear(&mut self, now: Nanos, at: Nanos, packet: Packet) {
        let at = at.max(now);
        let behind = self.flying.partition_point(|(other, _)| *other <= at);
        self.flying.insert(behind, (at, packet));
        self.run(now);
    }

    pub(super) fn hear_p2p(
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

    pub(super) fn hear_crtp(&mut self, now: Nanos, at: Nanos, data: &[u8], rssi: u8) {
        let data = data[..data.len().min(MTU - 1)].to_vec();
        self.hear(now, at, Packet { data, broadcast: false, rssi });
    }

    pub(super) fn take_sent(&mut self) -> Vec<Sent> {
        std::mem::take(&mut self.sent)
    }

    pub(super) fn take_answers(&mut self) -> Vec<Answer> {
        self.state.radio.take_answers()
    }

    /// Everything happens that happens until now.
    pub(super) fn advance(&mut self, now: Nanos) {
        if self.due <= now {
            self.run(now);
        }
        self.clock = self.clock.max(now);
    }

    fn run(&mut self, now: Nanos) {
        self.plan();
        while self.due <= now {
            self.clock = self.clock.max(self.due);
            self.turn();
            self.plan();
        }
        self.clock = self.clock.max(now);
    }

    /// The chip's core, interrupts and all, is busy for a part of each `every` from now on; for none
    /// of it with zero.
    pub(super) fn keep_busy(&mut self, now: Nanos, every: Nanos, busy: Nanos) {
        self.line.busy = (busy > 0).then_some(Busy { since: now, every, busy });
        self.run(now);
    }

    /// Sets the radio to a channel as a command from the air does: the flight processor is not told.
    pub(super) const fn retune(&mut self, channel: u8) {
        self.state.radio.tuning.channel = channel;
    }

    /// When the next thing happens.
    fn plan(&mut self) {
        self.line.read_fifo(self.clock);
        let landing = self.flying.front().map_or(Nanos::MAX, |(at, _)| *at);
        let work = Step::ROUND.into_iter().map(|step| self.ready(step)).min();
        let work = work.unwrap_or(Nanos::MAX);
        let free = self.state.busy_until.max(self.line.free_at(self.clock));
        let work = if work == Nanos::MAX { work } else { work.max(free) };
        let work = work.min(self.line.reads_at(self.clock));
        // Its "wait" pin is driven from then on.
        let up = self.state.up_since();
        let up = if self.clock < up { up } else { Nanos::MAX };
        let off = self.power != Power::On;
        self.due = if off { landing } else { landing.min(work).min(up) };
    }

    /// From when on there is something to do in a step.
    fn ready(&self, step: Step) -> Nanos {
        let state = &self.state;
        let at_once = |is: bool| if is { 0 } else { Nanos::MAX };
        match step {
            Step::Air => at_once(state.radio.has_packet()),
            Step::Line => at_once(self.line.has_bytes()),
            Step::Battery if state.reports => state.battery_due,
            Step::Signal if state.reports => state.signal_due,
            Step::Battery | Step::Signal => Nanos::MAX,
            Step::Power => state.shutdown.due(),
        }
    }

    fn turn(&mut self) {
        let now = self.clock;
        while let Some((_, packet)) = self.flying.pop_front_if(|(at, _)| *at <= now) {
            self.land(now, packet);
        }
        if self.power != Power::On || self.state.busy_until > now || self.line.is_busy(now) {
            return;
        }
        let order = (self.state.next_step..).take(Step::ROUND.len());
        let next =
            order.map(|at| at % Step::ROUND.len()).find(|at| self.ready(Step::ROUND[*at]) <= now);
        if let Some(at) = next {
            self.state.next_step = (at + 1) % Step::ROUND.len();
            self.do_step(Step::ROUND[at]);
        }
    }

    fn do_step(&mut self, step: Step) {
        let now = self.clock;
        match step {
            Step::Air => {
                if let Some(packet) = self.state.radio.take() {
                    self.pass_on(packet);
                }
            }
            Step::Line => self.read_line(),
            Step::Battery => {
                self.state.battery_due = tick(now) + REPORT;
                self.report_battery();
            }
            Step::Signal => {
                self.state.signal_due = tick(now) + REPORT;
                self.say(kind::RSSI, &[self.state.rssi]);
            }
            Step::Power => match self.state.shutdown {
                Shutdown::Idle => {}
                Shutdown::Pressed => {
                    self.say(kind::SHUTDOWN_REQUEST, &[]);
                    self.state.shutdown = Shutdown::asked(now);
                }
                Shutdown::Asked { .. } => self.switch_off(OffCause::Unanswered),
            },
        }
    }

    fn land(&mut self, at: Nanos, packet: Packet) {
        let landed = match self.power {
            Power::On => self.state.radio.land(at, packet),
            Power::Off { .. } => Landed::Deaf,
        };
        match landed {
            Landed::Taken => {}
            Landed::Deaf => self.state.counters.deaf += 1,
            Landed::NoRoom => self.state.counters.overruns += 1,
        }
    }

    /// A packet from the air goes to whom it is for.
    fn pass_on(&mut self, packet: Packet) {
        self.state.rssi = packet.rssi;
        self.state.bluetooth = false;
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

    /// Looks at what came in, up to the end of a frame.
    fn read_line(&mut self) {
        while let Some(byte) = self.line.next() {
            let counters = &mut self.state.counters;
            match self.state.parser.take(byte) {
                None => {}
                Some(Found::BadFirstSum) => counters.bad_first_sums += 1,
                Some(Found::BadSecondSum) => counters.bad_second_sums += 1,
                Some(Found::TooLong) => counters.too_long += 1,
                Some(Found::Frame { kind, data }) => {
                    counters.good += 1;
                    self.state.talks = true;
                    self.handle(kind, &data);
                    return;
                }
            }
        }
    }

    fn report_battery(&mut self) {
        let Battery { volts, charging, usb } = self.battery;
        // The third flag: there is a charger. A Crazyflie has one, a Bolt has not.
        let mut data = vec![u8::from(charging) | u8::from(usb) << 1 | 1 << 2];
        data.extend_from_slice(&volts.to_le_bytes());
        let amperes = if charging { CHARGE_AMPERES } else { 0.0 };
        data.extend_from_slice(&amperes.to_le_bytes());
        self.say(kind::BATTERY, &data);
    }

    /// Sends a frame, and does nothing else meanwhile.
    fn say(&mut self, kind: u8, data: &[u8]) {
        if self.state.talks {
            let from = self.clock.max(self.state.busy_until);
            self.state.busy_until = self.line.send(from, &frame(kind, data));
        }
    }

    fn switch_off(&mut self, cause: OffCause) {
        self.line.fall_silent(self.clock);
        self.power = Power::Off { since: self.clock, cause };
    }
}
