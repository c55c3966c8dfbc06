//! Advances the peripherals, and notes when each is due next and which interrupt lines are high.

use super::{Context, Plan, Slot, Units};
use crate::soc::clocks::Clocks;
use crate::soc::context::{Peripheral, Request};
use crate::soc::gpio::Mode;
use crate::soc::map::{self, TIMERS, Unit};
use crate::soc::timer::Output;
use crate::soc::{Board, Level, Nanos, Pin, PinOutput};

/// A moment, and its cycle as the core is clocked now. The conversion is a division, and most of
/// what happens does not change what it would come to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    nanos: Nanos,
    cycle: u64,
}

impl Moment {
    pub(super) const NEVER: Self = Self { nanos: Nanos::MAX, cycle: u64::MAX };

    fn set(&mut self, nanos: Nanos, clocks: &Clocks) -> u64 {
        if nanos != self.nanos {
            *self = Self { nanos, cycle: clocks.cycle(nanos) };
        }
        self.cycle
    }
}

impl<B: Board> Units<B> {
    /// The board is brought to `now`, stopping wherever it changes a pin, so that no edge is lost.
    pub(super) fn catch_up(&mut self, now: u64) {
        self.last_cycle = now;
        if self.caught_up == Some(now) {
            return;
        }
        self.caught_up = Some(now);
        let nanos = self.clocks.nanos(now);
        if !self.pins_dirty && self.board.due() > nanos {
            self.board.advance(nanos);
            return;
        }
        self.pins_dirty = false;
        loop {
            let due = self.board.due();
            if due >= nanos {
                break;
            }
            self.board.advance(due);
            self.watch_pins();
            if self.board.due() <= due {
                break;
            }
        }
        self.board.advance(nanos);
        self.watch_pins();
        self.note_board();
    }

    /// The board is brought to the last moment at which it may have been looked at, which nothing
    /// there is due before: a caller from outside finds it there.
    pub(in crate::soc) fn follow(&mut self) {
        if self.caught_up != Some(self.last_cycle) {
            self.caught_up = Some(self.last_cycle);
            self.board.advance(self.clocks.nanos(self.last_cycle));
        }
    }

    /// The board has been changed from outside.
    pub(in crate::soc) fn touch(&mut self, now: u64) {
        self.caught_up = None;
        self.pins_dirty = true;
        self.catch_up(now);
        self.note_board();
    }

    /// Edges of the pins that EXTI watches.
    pub(super) fn watch_pins(&mut self) {
        let mut watched = self.exti.watched();
        let mut levels = 0;
        while watched != 0 {
            let line = watched.trailing_zeros() as usize;
            watched &= watched - 1;
            let pin = self.syscfg.pin(line);
            levels |= u32::from(self.pins.is_high(pin, &self.board)) << line;
        }
        self.exti.sample(levels);
    }

    /// Everything happens that is due at `now`.
    pub(in crate::soc) fn advance(&mut self, now: u64) {
        self.last_cycle = now;
        let board_is_due = self.plan.due(Slot::Board) <= now;
        if self.pins_dirty || board_is_due {
            // The access just made may have made something due at once.
            self.caught_up = None;
            self.catch_up(now);
        }
        for index in 0..TIMERS.len() {
            if self.plan.due(Slot::Timer(index)) <= now {
                self.timers[index].advance(now);
                self.note_timer(index);
            }
        }
        for index in 0..self.i2c.len() {
            if self.plan.due(Slot::I2c(index)) <= now {
                self.catch_up(now);
                with!(self, now, advance(self.i2c[index]));
                self.met_board(Unit::I2c(index));
            }
        }
        if self.plan.due(Slot::Spi1) <= now {
            self.catch_up(now);
            with!(self, now, advance(self.spi1));
            self.met_board(Unit::Spi1);
        }
        // What comes in over the line is due at the board.
        if board_is_due || self.plan.due(Slot::Usart6) <= now {
            self.catch_up(now);
            with!(self, now, advance(self.usart6));
            self.met_board(Unit::Usart6);
        }
        if self.plan.due(Slot::Own) <= now {
            self.advance_own(now);
        }
    }

    /// A serial bus has had to do with the board.
    fn met_board(&mut self, unit: Unit) {
        self.pins_dirty = true;
        self.note_serial(unit);
        self.note_board();
    }

    fn advance_own(&mut self, now: u64) {
        let nanos = self.clocks.nanos(now);
        self.flash.settle(nanos);
        if self.rcc.settle(nanos) {
            self.clock(now);
        }
        self.usb.settle(nanos);
        self.watchdog_fired |= self.iwdg.fired(nanos);
        self.note_own();
    }

    pub(in crate::soc) const fn counts_in_sleep(&self) -> bool {
        self.dbgmcu.counts_in_sleep()
    }

    pub(in crate::soc) fn watchdog_due(&self) -> Option<Nanos> {
        self.iwdg.is_started().then(|| self.iwdg.bites_at())
    }

    /// A timer may be due at another cycle than before, or interrupt.
    pub(super) fn note_timer(&mut self, index: usize) {
        let timer = &self.timers[index];
        self.plan.note(Slot::Timer(index), timer.due(), timer.lines());
    }

    /// The same of a serial bus. What it asks DMA for may be new too.
    pub(super) fn note_serial(&mut self, unit: Unit) {
        let (shift, receive, transmit) = match unit {
            Unit::I2c(index) => {
                let i2c = &self.i2c[index];
                note::<B>(&mut self.plan, Slot::I2c(index), i2c);
                (2 * index, i2c.wants_receive(), i2c.wants_transmit())
            }
            Unit::Spi1 => {
                note::<B>(&mut self.plan, Slot::Spi1, &self.spi1);
                (6, self.spi1.wants_receive(), self.spi1.wants_transmit())
            }
            _ => {
                note::<B>(&mut self.plan, Slot::Usart6, &self.usart6);
                (8, self.usart6.wants_receive(), self.usart6.wants_transmit())
            }
        };
        let wants = (u16::from(receive) | u16::from(transmit) << 1) << shift;
        // A request that was not served so far is served once a stream is enabled for it, not before.
        self.dma_pending |= wants & !self.wants != 0;
        self.wants = self.wants & !(3 << shift) | wants;
    }

    /// Notes the due times of the board and of EXTI.
    pub(super) fn note_board(&mut self) {
        let due = self.board_moment.set(self.board.due(), &self.clocks);
        self.plan.note(Slot::Board, due, self.exti.lines());
    }

    /// Notes the due times of RCC, flash, the watchdog and USB.
    pub(super) fn note_own(&mut self) {
        let due = self.rcc.due().min(self.flash.due()).min(self.iwdg.due()).min(self.usb.due());
        let due = self.own_moment.set(due, &self.clocks);
        self.plan.note(Slot::Own, due, self.flash.lines() | self.usb.lines());
    }

    /// Notes the due times of all peripherals but DMA.
    pub(super) fn note_all(&mut self) {
        for index in 0..TIMERS.len() {
            self.note_timer(index);
        }
        for index in 0..self.i2c.len() {
            self.note_serial(Unit::I2c(index));
        }
        self.note_serial(Unit::Spi1);
        self.note_serial(Unit::Usart6);
        self.note_board();
        self.note_own();
    }

    pub(in crate::soc) fn requests(&self, request: Request) -> bool {
        match request {
            Request::I2cReceive(index) => self.i2c[index].wants_receive(),
            Request::I2cTransmit(index) => self.i2c[index].wants_transmit(),
            Request::Spi1Receive => self.spi1.wants_receive(),
            Request::Spi1Transmit => self.spi1.wants_transmit(),
            Request::Usart6Receive => self.usart6.wants_receive(),
            Request::Usart6Transmit => self.usart6.wants_transmit(),
        }
    }

    pub(in crate::soc) fn one_left(&mut self, request: Request) {
        if let Request::I2cReceive(index) | Request::I2cTransmit(index) = request {
            self.i2c[index].one_left();
        }
    }

    pub(in crate::soc) fn output(&self, pin: Pin, now: u64) -> PinOutput {
        let function = match self.pins.mode(pin) {
            Mode::Input | Mode::Analog => return PinOutput::Input,
            Mode::Output => {
                return match self.pins.drives(pin) {
                    Level::Low => PinOutput::Low,
                    Level::High => PinOutput::High,
                    Level::Released => PinOutput::Input,
                };
            }
            Mode::Alternate(function) => function,
        };
        let Some((timer, channel)) = map::timer_of(pin.port(), pin.number(), function) else {
            return PinOutput::Alternate(function);
        };
        match self.timers[timer].output(channel, now) {
            Output::Off => PinOutput::Input,
            Output::Low => PinOutput::Low,
            Output::High => PinOutput::High,
            #[expect(
                clippy::cast_precision_loss,
                clippy::cast_possible_truncation,
                reason = "for the world"
            )]
            Output::Pwm { duty, period } => {
                PinOutput::Pwm { duty, hz: (self.clocks.hclk().as_f64() / period as f64) as f32 }
            }
        }
    }

    pub(in crate::soc) fn words(&self, now: u64) -> Vec<u32> {
        let nanos = self.clocks.nanos(now);
        let mut words = Vec::with_capacity(320);
        words.extend(self.rcc.words(nanos));
        words.extend(self.flash.words(nanos));
        words.extend(self.iwdg.words());
        words.extend(self.rtc.words());
        words.extend(self.pins.words());
        words.extend(self.exti.words());
        words.extend(self.syscfg.words());
        for timer in &self.timers {
            words.extend(timer.words(now));
        }
        words
    }
}

#[inline]
fn note<B: Board>(plan: &mut Plan, slot: Slot, unit: &impl Peripheral<B>) {
    plan.note(slot, unit.due(), unit.lines());
}
