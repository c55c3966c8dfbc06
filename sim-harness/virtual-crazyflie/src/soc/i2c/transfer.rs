//! Transfers of a master, byte by byte: start, address, data, stop, and the waits between them.
//!
//! Whenever the manual has the clock stretched until the software does something, the phase is one
//! without a moment, and [`I2c::go_on`] looks whether it can be left. A bit takes what CCR says;
//! the time in which the lines rise is not added. A byte takes nine bits, a start and a stop one
//! each. What the devices hold low they hold until the board says otherwise: it is looked at again
//! after every bit.

use super::{ALTERNATE, I2c, ccr, cr1, pins, sr1};
use crate::soc::context::Context;
use crate::soc::wiring::Board;

/// The state of a transfer.
#[derive(Clone, Copy, Debug)]
pub(super) enum Phase {
    /// The lines are let go.
    Idle,
    /// A start is asked for; the lines are looked at again then, or the stop before it is over.
    Wanting { until: u64 },
    /// A start, or a repeated one, is being made.
    Starting { until: u64 },
    /// SB: the clock is held until the address is there.
    Started,
    /// The address goes out.
    Addressing { byte: u8, until: u64 },
    /// ADDR: the clock is held until that has been seen.
    Addressed,
    /// A byte goes out.
    Sending { byte: u8, until: u64 },
    /// Everything that was given has gone out: the clock is held until there is more.
    Sent,
    /// A byte comes in.
    Receiving { until: u64 },
    /// Two bytes have come in and none was taken: the clock is held.
    Received,
    /// A byte was not acknowledged, by a device or by us: only a stop or a start can follow.
    Over,
    /// A stop is being made.
    Stopping { until: u64 },
}

impl Phase {
    /// When it ends by itself.
    pub(super) const fn until(self) -> u64 {
        match self {
            Self::Wanting { until }
            | Self::Starting { until }
            | Self::Addressing { until, .. }
            | Self::Sending { until, .. }
            | Self::Receiving { until }
            | Self::Stopping { until } => until,
            Self::Idle
            | Self::Started
            | Self::Addressed
            | Self::Sent
            | Self::Received
            | Self::Over => u64::MAX,
        }
    }

    /// SR2.MSL: from the start condition on.
    pub(super) const fn is_master(self) -> bool {
        !matches!(self, Self::Idle | Self::Wanting { .. })
    }
}

impl I2c {
    /// The time of a bit in cycles of the core (I2C_CCR): low and high for CCR clocks each, in fast
    /// mode low for twice as long, or nine to sixteen.
    fn bit<B: Board>(&self, context: &Context<'_, B>) -> u64 {
        let parts = match (self.ccr & ccr::FS != 0, self.ccr & ccr::DUTY != 0) {
            (false, _) => 2,
            (true, false) => 3,
            (true, true) => 25,
        };
        u64::from(self.ccr & ccr::CCR) * parts * context.clocks.apb1()
    }

    /// Whether both lines are the board's.
    fn connected<B: Board>(&self, context: &Context<'_, B>) -> bool {
        let pins = pins(self.bus);
        [pins.clock, pins.data]
            .iter()
            .all(|line| line.iter().any(|pin| context.connected(*pin, ALTERNATE)))
    }

    /// The levels to which the devices hold the clock and the data line. A line without a pin is
    /// high.
    pub(super) fn levels<B: Board>(&self, context: &Context<'_, B>) -> (bool, bool) {
        let pins = pins(self.bus);
        let has_pin = |line: &[_]| line.iter().any(|pin| context.connected(*pin, ALTERNATE));
        let (clock, data) = context.board.i2c_lines(self.bus);
        (clock || !has_pin(pins.clock), data || !has_pin(pins.data))
    }

    /// After the software has done something: whether what holds the clock holds it still.
    pub(super) fn go_on<B: Board>(&mut self, context: &mut Context<'_, B>) {
        self.leave(context.now, context);
    }

    /// Leaves a phase that has no end of its own, at this cycle, if there is reason to.
    fn leave<B: Board>(&mut self, at: u64, context: &mut Context<'_, B>) {
        let (start, stop) = (self.is_on(cr1::START), self.is_on(cr1::STOP));
        match self.phase {
            Phase::Idle if start => self.want(at, context),
            Phase::Wanting { .. } if !start => self.phase = Phase::Idle,
            Phase::Started if stop => {
                self.flags &= !sr1::SB;
                self.phase = Phase::Stopping { until: at + self.bit(context) };
            }
            Phase::Sent | Phase::Received | Phase::Over if stop => {
                self.phase = Phase::Stopping { until: at + self.bit(context) };
            }
            Phase::Sent | Phase::Received | Phase::Over if start => {
                self.phase = Phase::Starting { until: at + self.bit(context) };
            }
            Phase::Sent => {
                if let Some(byte) = self.out.take() {
                    self.phase = Phase::Sending { byte, until: at + 9 * self.bit(context) };
                }
            }
            Phase::Received if self.shift.is_none() => self.receive(at, context),
            Phase::Idle
            | Phase::Wanting { .. }
            | Phase::Starting { .. }
            | Phase::Started
            | Phase::Addressing { .. }
            | Phase::Addressed
            | Phase::Sending { .. }
            | Phase::Receiving { .. }
            | Phase::Received
            | Phase::Over
            | Phase::Stopping { .. } => {}
        }
    }

    /// A start from rest: begins when both lines are high.
    fn want<B: Board>(&mut self, at: u64, context: &mut Context<'_, B>) {
        let until = at + self.bit(context);
        self.phase = if self.levels(context) == (true, true) {
            Phase::Starting { until }
        } else {
            Phase::Wanting { until }
        };
    }

    /// The address was stored to DR.
    pub(super) fn address<B: Board>(&mut self, byte: u8, context: &mut Context<'_, B>) {
        self.phase = Phase::Addressing { byte, until: context.now + 9 * self.bit(context) };
    }

    /// ADDR has been cleared.
    pub(super) fn addressed<B: Board>(&mut self, context: &mut Context<'_, B>) {
        if self.transmitter {
            self.phase = Phase::Sent;
            self.go_on(context);
        } else {
            self.receive(context.now, context);
        }
    }

    fn receive<B: Board>(&mut self, at: u64, context: &Context<'_, B>) {
        self.phase = Phase::Receiving { until: at + 9 * self.bit(context) };
    }

    /// The phase with a moment ends.
    pub(super) fn step<B: Board>(&mut self, context: &mut Context<'_, B>) {
        let at = self.phase.until();
        let later = at + self.bit(context);
        let (clock, data) = self.levels(context);
        match &mut self.phase {
            Phase::Wanting { .. } => self.want(at, context),
            // A device holds the clock, or the data line where it must rise for a start or a stop.
            Phase::Starting { until } | Phase::Stopping { until } if !(clock && data) => {
                *until = later;
            }
            Phase::Addressing { until, .. }
            | Phase::Sending { until, .. }
            | Phase::Receiving { until }
                if !clock =>
            {
                *until = later;
            }
            Phase::Starting { .. } => self.started(context),
            Phase::Stopping { .. } => self.stopped(at, context),
            Phase::Addressing { byte, .. } | Phase::Sending { byte, .. } if !data && *byte != 0 => {
                self.lose();
            }
            Phase::Addressing { byte, .. } => {
                let byte = *byte;
                self.address_sent(byte, at, context);
            }
            Phase::Sending { byte, .. } => {
                let byte = *byte;
                self.byte_sent(byte, at, context);
            }
            Phase::Receiving { .. } => self.byte_received(data, at, context),
            Phase::Idle
            | Phase::Started
            | Phase::Addressed
            | Phase::Sent
            | Phase::Received
            | Phase::Over => {}
        }
    }

    fn started<B: Board>(&mut self, context: &mut Context<'_, B>) {
        self.joined = self.connected(context);
        self.cr1 &= !cr1::START;
        self.flags &= !sr1::BTF;
        self.out = None;
        self.transmitter = false;
        self.last = false;
        self.phase = Phase::Started;
        self.raise(sr1::SB);
        self.go_on(context);
    }

    fn stopped<B: Board>(&mut self, at: u64, context: &mut Context<'_, B>) {
        if self.connected(context) {
            context.board.i2c_stop(self.bus);
        }
        self.cr1 &= !cr1::STOP;
        self.flags &= !sr1::BTF;
        self.out = None;
        self.transmitter = false;
        self.last = false;
        self.phase = Phase::Idle;
        if !self.is_on(cr1::PE) {
            self.disable();
        } else if self.is_on(cr1::START) {
            // The lines stay free for as long as a stop takes (the bus free time of I²C).
            self.phase = Phase::Wanting { until: at + self.bit(context) };
        }
    }

    /// A one was sent and the data line stayed low: the bus is lost to another master.
    fn lose(&mut self) {
        self.transmitter = false;
        self.out = None;
        self.last = false;
        self.phase = Phase::Idle;
        self.raise(sr1::ARLO);
        if !self.is_on(cr1::PE) {
            self.disable();
        }
    }

    /// Whether the board sees and answers what goes over the lines. Pins that were taken away or
    /// given back in the middle look like a misplaced stop or start.
    fn joins<B: Board>(&mut self, context: &Context<'_, B>) -> bool {
        let connected = self.connected(context);
        if connected != self.joined {
            self.joined = connected;
            self.raise(sr1::BERR);
        }
        connected
    }

    fn address_sent<B: Board>(&mut self, byte: u8, at: u64, context: &mut Context<'_, B>) {
        let reads = byte & 1 != 0;
        let bus = self.bus;
        if self.joins(context) && context.board.i2c_start(bus, byte >> 1, reads) {
            self.transmitter = !reads;
            // With POS, ACK answers the byte after the one that comes in: what it was before any
            // came in answers the first.
            self.latched = self.acknowledge.now;
            self.phase = Phase::Addressed;
            self.raise(sr1::ADDR);
        } else {
            self.refused(at, context);
        }
    }

    fn refused<B: Board>(&mut self, at: u64, context: &mut Context<'_, B>) {
        self.phase = Phase::Over;
        self.raise(sr1::AF);
        self.leave(at, context);
    }

    fn byte_sent<B: Board>(&mut self, byte: u8, at: u64, context: &mut Context<'_, B>) {
        let bus = self.bus;
        if !(self.joins(context) && context.board.i2c_write(bus, byte)) {
            return self.refused(at, context);
        }
        if self.out.is_none() {
            self.raise(sr1::BTF);
        }
        self.phase = Phase::Sent;
        self.leave(at, context);
    }

    fn byte_received<B: Board>(&mut self, data: bool, at: u64, context: &mut Context<'_, B>) {
        let bus = self.bus;
        let byte = if self.joins(context) { context.board.i2c_read(bus) } else { 0xFF };
        // A line that is held low is all zeros.
        let byte = if data { byte } else { 0 };
        let acknowledges = self.answer(at - self.bit(context));
        if !acknowledges && !data {
            return self.lose();
        }
        if self.flags & sr1::RXNE == 0 {
            self.data = byte;
            self.raise(sr1::RXNE);
        } else {
            self.shift = Some(byte);
            self.raise(sr1::BTF);
        }
        if acknowledges {
            self.phase = Phase::Received;
        } else {
            self.phase = Phase::Over;
        }
        self.leave(at, context);
    }

    /// Whether the byte whose ninth bit begins at this cycle is acknowledged: by the value of ACK
    /// then, or with POS by that when the byte began; the last byte of a DMA is not acknowledged.
    fn answer(&mut self, ninth: u64) -> bool {
        let now = self.acknowledge.at(ninth);
        let answer = if self.is_on(cr1::POS) { self.latched } else { now };
        self.latched = now;
        let refuses = core::mem::take(&mut self.last);
        answer && !refuses
    }
}
