//! Time among the peripherals: who is due when, who interrupts, and how it all stands.

use super::{Context, Units};
use crate::soc::context::{Peripheral, Request};
use crate::soc::gpio::Mode;
use crate::soc::map::{self, TIMERS};
use crate::soc::timer::Output;
use crate::soc::{Board, Level, Nanos, Pin, PinOutput};

impl<B: Board> Units<B> {
    /// The board is brought to `now`, stopping wherever it changes a pin, so that no edge is lost.
    pub(in crate::soc) fn catch_up(&mut self, now: u64) {
        if self.caught_up == Some(now) {
            return;
        }
        self.caught_up = Some(now);
        let nanos = self.clocks.nanos(now);
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
    }

    /// The board has been changed from outside.
    pub(in crate::soc) fn touch(&mut self, now: u64) {
        self.caught_up = None;
        self.stale = true;
        self.catch_up(now);
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
        let nanos = self.clocks.nanos(now);
        // What it was just told may have made something due at once.
        self.touch(now);
        for index in 0..TIMERS.len() {
            if self.timers_due[index] <= now {
                self.timers[index].advance(now);
                self.note_timer(index);
            }
        }
        for i2c in &mut self.i2c {
            if Peripheral::<B>::due(i2c) <= now {
                with!(self, now, advance(i2c));
            }
        }
        if Peripheral::<B>::due(&self.spi1) <= now {
            with!(self, now, advance(self.spi1));
        }
        // What comes in over the line is due at the board.
        with!(self, now, advance(self.usart6));
        self.flash.settle(nanos);
        if self.rcc.settle(nanos) {
            self.clock(now);
        }
        self.bitten |= self.iwdg.bites(nanos);
    }

    pub(in crate::soc) const fn counts_in_sleep(&self) -> bool {
        self.dbgmcu.counts_in_sleep()
    }

    pub(in crate::soc) fn watchdog_due(&self) -> Option<Nanos> {
        self.iwdg.is_started().then(|| self.iwdg.bites_at())
    }

    /// The next of what happens in nanoseconds.
    fn absolute(&self) -> Nanos {
        self.rcc.due().min(self.flash.due()).min(self.iwdg.due()).min(self.board.due())
    }

    /// The next cycle at which something is due, and the interrupt lines.
    pub(in crate::soc) fn plan(&mut self) -> (u64, u128) {
        if std::mem::take(&mut self.stale) {
            self.others = self.plan_others();
        }
        let timers = self.timers_due.iter().copied().fold(u64::MAX, u64::min);
        let lines = self.timers_lines.iter().fold(0, |lines, timer| lines | timer);
        (timers.min(self.others.0), lines | self.others.1)
    }

    /// The same without timers.
    fn plan_others(&mut self) -> (u64, u128) {
        let absolute = self.absolute();
        // Most accesses change nothing about it, and the conversion is a division.
        if absolute != self.planned.0 {
            self.planned = (absolute, self.clocks.cycle(absolute));
        }
        let due = self
            .i2c
            .iter()
            .map(Peripheral::<B>::due)
            .fold(self.planned.1, u64::min)
            .min(Peripheral::<B>::due(&self.spi1))
            .min(Peripheral::<B>::due(&self.usart6));
        let lines = self.i2c.iter().fold(0, |lines, i2c| lines | Peripheral::<B>::lines(i2c))
            | Peripheral::<B>::lines(&self.spi1)
            | Peripheral::<B>::lines(&self.usart6)
            | self.exti.lines()
            | self.flash.lines();
        (due, lines)
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
        words.extend(self.flash.words());
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
