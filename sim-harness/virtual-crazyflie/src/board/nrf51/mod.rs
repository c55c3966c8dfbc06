//! The radio chip with the vendor's firmware, as the flight processor and the air see it.
//!
//! | module | what it holds |
//! |---|---|
//! | `frame` | the serial line's frames |
//! | `air` | packets from the air, on their way to the flight processor |
//! | `line` | its bytes and their times |
//! | `orders` | commands from the flight processor and from the air |
//! | `radio` | the radio's queues, acknowledgements and settings |
//! | `power` | the button, and power that goes |
//! | `start` | when its parts begin to work |
//! | `counters` | what it has counted |
//! | `battery` | the battery's voltage, as it is measured |
//! | `main_loop` | the steps of a round, and their times |
//!
//! This module is the chip's main loop (crazyflie2-nrf-firmware, `main.c`): in each round it passes
//! on one packet from the air, handles one frame from the line, reports the battery and the signal
//! when 10 ms have passed, and looks at the button. It waits for every byte that it sends. So a frame
//! that comes in meanwhile is handled when the sending is over, up to 0.9 ms later: that is the chip's
//! latency.
//!
//! Bytes from the flight processor go into the six of the peripheral and, by an interrupt, into the
//! 127 of the program (`uart.c`). The "wait" pin is the peripheral's RTS: it tells of the six only,
//! in the middle of a frame as well, and what the program has no room for is lost without a sign.
//! Interrupts are served at once, and take time of the main loop, except while
//! [`Fault::RadioBusy`](super::Fault::RadioBusy) says that the core has something else to do.

mod air;
mod battery;
mod counters;
mod frame;
mod line;
mod main_loop;
mod orders;
mod power;
mod radio;
mod start;

use std::collections::VecDeque;

pub use counters::Counters;
pub use main_loop::{COPYING, HANDLING, INTERRUPT, PARSING, PASSING_ON, ROUND};
use main_loop::{TUNING, passing_on};
pub use power::{OffCause, Power};
pub use radio::{Answer, Datarate, Tuning};

use super::deck_memory::DeckMemory;
use super::noise::Shares;
use crate::soc::{Level, Nanos, UartByte};
use battery::Battery;
use frame::{Found, Parser, frame, kind};
pub use line::BYTE;
use line::{Busy, Line};
use main_loop::{MainLoop, Step};
use power::{Shutdown, TICK, tick};
use radio::{Packet, Radio};
use start::Start;

/// Between two reports of the battery, and of the signal (`SYSLINK_SEND_PERIOD_MS`).
const REPORT: Nanos = 10 * TICK;
/// The most data of a packet between drones (crazyflie-firmware, `radiolink.h`).
const MAX_P2P: usize = 60;
/// From the moment at which the loop hands a packet to the radio to the first bit on the air
/// (zephyr, `radio_nrf51.h`: `HAL_RADIO_NRF51_TXEN_TXIDLE_TX_US`).
pub const RAMP_UP: Nanos = 140_000;
/// From the end of a packet that is acknowledged to the acknowledgement's first bit: the interrupt, and
/// the ramp-up.
pub const ANSWERS_AFTER: Nanos = 18_000 + RAMP_UP;
/// From the end of an acknowledgement, or of a packet for all drones, until the radio receives again:
/// the interrupt, and the ramp-up of the receiver (the same file, `..._RXEN_RXIDLE_RX_US`).
pub const LISTENS_AFTER: Nanos = 6_000 + RECEIVES_AFTER;
/// From the command to receive until the radio does.
const RECEIVES_AFTER: Nanos = 138_000;

/// A packet for all drones, handed to the radio. It is on the air [`RAMP_UP`] later, for as long as
/// its length and the data rate make it; while that lasts this drone hears nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sent {
    /// When: the main loop has read its frame.
    pub at: Nanos,
    /// The P2P port.
    pub port: u8,
    /// The packet's data, without port.
    pub data: Vec<u8>,
    /// The settings of the radio.
    pub tuning: Tuning,
}

/// The state that a reset clears.
#[derive(Debug)]
struct State {
    start: Start,
    main_loop: MainLoop,
    parser: Parser,
    /// The frame that is to be obeyed.
    frame: Option<(u8, Vec<u8>)>,
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
}

impl State {
    fn new(start: Start) -> Self {
        Self {
            start,
            main_loop: MainLoop::new(start.opens),
            parser: Parser::new(),
            frame: None,
            radio: Radio::new(start.listens),
            talks: false,
            reports: false,
            battery_due: start.reports,
            signal_due: start.reports,
            rssi: 0,
            bluetooth: true,
            shutdown: Shutdown::Idle,
            configured: [0; 3],
            counters: Counters::default(),
        }
    }

    /// When the chip's line is open, or was opened.
    const fn up_since(&self) -> Nanos {
        self.start.opens
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
    /// The flight processor alone was switched off: the chip goes on.
    goes_on: bool,
    battery: Battery,
    led: bool,
    /// Packets on the air, by the moment at which they end.
    flying: VecDeque<(Nanos, Packet)>,
    sent: Vec<Sent>,
    clock: Nanos,
    due: Nanos,
    /// The chip signals a full buffer, though it may have room.
    pub(super) stuck_full: bool,
    /// The chip sends an old packet in place of each of its own.
    pub(super) ghosts: bool,
}

impl Nrf51 {
    /// The chip of a drone that it has just given power: it is up already.
    pub(super) fn new(version: &str, memories: Vec<DeckMemory>) -> Self {
        let mut chip = Self {
            version: version.to_owned(),
            memories,
            line: Line::new(),
            state: State::new(Start::WITH_PROCESSOR),
            power: Power::On,
            goes_on: false,
            battery: Battery::new(),
            led: true,
            flying: VecDeque::new(),
            sent: Vec::new(),
            clock: 0,
            due: Nanos::MAX,
            stuck_full: false,
            ghosts: false,
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
        self.runs() && self.state.radio.listens(self.clock)
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

    /// Whether the chip itself runs.
    fn runs(&self) -> bool {
        self.power == Power::On || self.goes_on
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

    pub(super) fn set_battery(&mut self, now: Nanos, volts: f32, charging: bool, usb: bool) {
        self.battery.set(now, volts, charging, usb);
    }

    pub(super) fn press(&mut self, now: Nanos) {
        self.state.main_loop.idle_until(now);
        if self.state.shutdown == Shutdown::Idle {
            self.state.shutdown = Shutdown::Pressed;
        }
        self.run(now);
    }

    pub(super) fn disturb(&mut self, shares: Shares, seed: u64) {
        self.line.wire.disturb(shares, seed);
    }

    /// Resets the chip: its state is lost, and it neither receives nor sends while it boots.
    pub(super) fn reset(&mut self, now: Nanos) {
        self.line.fall_silent(now);
        self.line.losses = line::Losses::default();
        self.state = State::new(Start::at(now));
        self.led = true;
        self.run(now);
    }

    /// A byte from the flight processor, whose stop bit passes now.
    pub(super) fn take(&mut self, now: Nanos, byte: u8, bit: u32) {
        if self.power == Power::On && now >= self.state.up_since() {
            self.state.main_loop.idle_until(now);
            self.state.main_loop.interrupt(now);
            self.line.take(now, byte, bit);
            self.run(now);
        }
    }

    /// The byte that has begun by now.
    pub(super) fn give(&mut self, now: Nanos) -> Option<UartByte> {
        self.line.give(now)
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
        self.state.radio.set_channel(channel);
    }

    /// When the next thing happens.
    fn plan(&mut self) {
        self.line.read_fifo(self.clock);
        let landing = self.flying.front().map_or(Nanos::MAX, |(at, _)| *at);
        let work = self.state.main_loop.next(|step| self.ready(step));
        let work = if work == Nanos::MAX { work } else { self.line.free_at(work) };
        let work = work.min(self.line.reads_at(self.clock));
        // Its "wait" pin is driven from then on.
        let up = self.state.up_since();
        let up = if self.clock < up { up } else { Nanos::MAX };
        self.due = if self.runs() { landing.min(work).min(up) } else { landing };
    }

    /// From when on there is something to do in a step.
    fn ready(&self, step: Step) -> Nanos {
        let state = &self.state;
        let at_once = |is: bool| if is { 0 } else { Nanos::MAX };
        match step {
            Step::Air => at_once(state.radio.has_packet()),
            Step::Line => at_once(self.line.has_bytes()),
            Step::Frame => at_once(state.frame.is_some()),
            Step::Battery if state.reports => state.battery_due,
            Step::Signal if state.reports => state.signal_due,
            Step::Battery | Step::Signal => Nanos::MAX,
            Step::Power => state.shutdown.due(),
        }
    }

    fn turn(&mut self) {
        let now = self.clock;
        while let Some((_, packet)) = self.flying.pop_front_if(|(at, _)| *at <= now) {
            self.state.main_loop.idle_until(now);
            self.state.main_loop.land(now);
            self.land(now, packet);
        }
        let mut main_loop = self.state.main_loop;
        let ready = |step| self.ready(step);
        if !self.runs() || main_loop.next(ready) > now || self.line.is_busy(now) {
            return;
        }
        let step = main_loop.take(now, ready);
        self.state.main_loop = main_loop;
        if let Some(step) = step {
            self.do_step(step);
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
            Step::Frame => {
                if let Some((kind, data)) = self.state.frame.take() {
                    self.handle(kind, &data);
                }
            }
            Step::Battery => {
                self.state.battery_due = tick(now) + REPORT;
                let data = self.battery.report(now);
                self.say(kind::BATTERY, &data);
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

    /// Reads a byte that came in. Where it ends a frame, the frame is obeyed before any other byte is
    /// read.
    fn read_line(&mut self) {
        let State { main_loop, counters, parser, frame, talks, .. } = &mut self.state;
        let Some(byte) = self.line.next() else { return };
        main_loop.work(PARSING);
        match parser.take(byte) {
            None => {}
            Some(Found::BadFirstSum) => counters.bad_first_sums += 1,
            Some(Found::BadSecondSum) => counters.bad_second_sums += 1,
            Some(Found::TooLong) => counters.too_long += 1,
            Some(Found::Frame { kind, data }) => {
                counters.good += 1;
                *talks = true;
                main_loop.work(HANDLING + COPYING * data.len() as Nanos);
                main_loop.leave_line();
                *frame = Some((kind, data));
            }
        }
    }

    /// Sends a frame, and does nothing else meanwhile.
    fn say(&mut self, kind: u8, data: &[u8]) {
        if self.state.talks {
            let sent = self.line.send(self.state.main_loop.at(), &frame(kind, data));
            self.state.main_loop.wait_until(sent);
        }
    }

    fn switch_off(&mut self, cause: OffCause) {
        self.line.fall_silent(self.clock);
        self.power = Power::Off { since: self.clock, cause };
        self.goes_on = false;
    }

    /// The flight processor loses its power; the chip goes on receiving and acknowledging.
    fn switch_processor_off(&mut self) {
        self.switch_off(OffCause::Agreed);
        self.goes_on = true;
        (self.state.talks, self.state.reports) = (false, false);
    }
}
