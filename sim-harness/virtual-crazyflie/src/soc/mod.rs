//! The peripherals of an STM32F405 that a Crazyflie's firmware uses.
//!
//! | module | what it holds |
//! |---|---|
//! | `wiring` | the interface to the board |
//! | `context` | the interface of a peripheral, and its context |
//! | `map` | which peripheral is at which address |
//! | `clocks` | cycles and nanoseconds |
//! | `rcc`, `pwr`, `flash`, `iwdg`, `rtc`, `dbgmcu` | clocks, resets and what keeps the chip going |
//! | `gpio`, `exti`, `timer` | pins, their edges, timers |
//! | `i2c`, `spi`, `usart`, `dma` | serial buses, and the DMA that serves them |
//! | `rng` | the random number generator |
//! | `adc`, `usb` | the converters and USB, of which nothing more is there than a drone in flight uses |
//! | `units` | the peripherals together, without DMA, which reaches them |
//!
//! [`Soc`] is what the core sees of all this: a [`Bus`].

mod adc;
mod clocks;
mod context;
mod dbgmcu;
mod dma;
mod exti;
mod flash;
mod gpio;
mod i2c;
mod iwdg;
mod map;
mod pwr;
mod rcc;
mod rng;
mod rtc;
mod spi;
mod timer;
mod units;
mod usart;
mod usb;
mod wiring;

use crate::bus::{Bus, Refused, Width};
use crate::memory::{Memory, map as memory_map};
use context::{Reach, Request, Transfers};
use dma::Dma;
use map::Unit;
pub use rcc::ResetCause;
use units::{Slot, Units};
pub use wiring::{Board, I2cBus, Level, Nanos, Pin, SpiBus, UartBus, UartByte};

/// The individual properties of a chip, which its firmware cannot change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SocConfig {
    /// The true frequency of the internal oscillator, in Hz: 16 MHz to within 1 % at room
    /// temperature.
    pub hsi_hz: u32,
    /// The crystal, in Hz; none when it is broken.
    pub hse_hz: Option<u32>,
    /// The frequency of the watchdog's oscillator, in Hz: 17 to 47 kHz.
    pub lsi_hz: u32,
    /// The supply, in mV.
    pub supply_millivolts: u32,
    /// The option bytes, as FLASH_OPTCR shows them.
    pub option_bytes: u32,
    /// The number that no other chip has.
    pub unique_id: [u32; 3],
    /// The text that was written into the first block of the one-time programmable bytes: by it
    /// the vendor's firmware knows the board (crazyflie-firmware, `platform_stm32f4.c`).
    pub board_name: &'static str,
}

impl Default for SocConfig {
    fn default() -> Self {
        Self {
            hsi_hz: 16_000_000,
            hse_hz: Some(8_000_000),
            lsi_hz: 32_000,
            supply_millivolts: 3_000,
            option_bytes: 0x0FFF_AAED,
            unique_id: [0x0031_0027, 0x3436_5102, 0x3832_3539],
            board_name: "0;CF21",
        }
    }
}

/// The output of a pin, as a motor or an LED sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PinOutput {
    /// The pin is not driven: an input, a released open drain, or a timer's channel that is not
    /// enabled.
    Input,
    /// Low.
    Low,
    /// High.
    High,
    /// High for a part of the time.
    Pwm {
        /// Which part, 0 to 1.
        duty: f32,
        /// The frequency in Hz.
        hz: f32,
    },
    /// Another peripheral's, by alternate function.
    Alternate(u8),
}

/// The chip without its core and memories.
pub struct Soc<B> {
    units: Units<B>,
    dma: [Dma; 2],
}

impl<B: Board> Soc<B> {
    /// The chip after power-up.
    pub fn new(board: B, config: SocConfig) -> Self {
        let mut soc = Self { units: Units::new(board, config), dma: [Dma::new(0), Dma::new(1)] };
        soc.reset(0, ResetCause::PowerOn);
        soc
    }

    /// The board.
    pub const fn board(&self) -> &B {
        &self.units.board
    }

    /// The board, to be changed. [`Self::touch`] must be called afterwards.
    pub const fn board_mut(&mut self) -> &mut B {
        self.units.pins_dirty = true;
        &mut self.units.board
    }

    /// The board may be another than before: what it does next, and its pins, are looked at again.
    pub fn touch(&mut self, now: u64) {
        self.units.touch(now);
    }

    /// Afterwards the board stands at the moment of the last event or access that it could have had
    /// to do with. Otherwise it is left behind as long as nothing happens there.
    pub fn follow(&mut self) {
        self.units.follow();
    }

    /// The moment of a cycle that is not before the last access.
    pub fn nanos(&self, cycle: u64) -> Nanos {
        self.units.clocks.nanos(cycle)
    }

    /// The first cycle that is not before a moment.
    pub fn cycle(&self, nanos: Nanos) -> u64 {
        self.units.clocks.cycle(nanos)
    }

    /// The core's clock, in Hz.
    pub fn core_hz(&self) -> f64 {
        self.units.clocks.hclk().as_f64()
    }

    /// Cycles of the core that one on each peripheral bus takes: APB1 and APB2.
    pub const fn bus_dividers(&self) -> (u64, u64) {
        (self.units.clocks.apb1(), self.units.clocks.apb2())
    }

    /// Takes a function that is not modelled and was needed without an access of the core.
    pub const fn trouble(&self) -> Option<&'static str> {
        self.units.trouble
    }

    /// Whether the watchdog has fired.
    pub const fn watchdog_bites(&self) -> bool {
        self.units.watchdog_fired
    }

    /// When the watchdog fires unless it is fed; none if it does not run.
    pub fn watchdog_due(&self) -> Option<Nanos> {
        self.units.watchdog_due()
    }

    /// Whether something has changed since this was last asked: the core's frequency, so that a
    /// moment is another cycle, what makes the flash faster, or whether the core counts in sleep.
    pub const fn take_change(&mut self) -> bool {
        std::mem::replace(&mut self.units.changed, false)
    }

    /// Whether the core's cycle counter goes on while it sleeps (DBGMCU_CR, DBG_SLEEP).
    pub const fn counts_in_sleep(&self) -> bool {
        self.units.counts_in_sleep()
    }

    /// Prefetch, instruction cache, data cache (FLASH_ACR).
    pub const fn flash_accelerator(&self) -> (bool, bool, bool) {
        self.units.flash.accelerator()
    }

    /// Stores to this stretch of flash are refused, because code that is known beforehand lies there.
    pub const fn protect(&mut self, code: std::ops::Range<u32>) {
        self.units.code = code;
    }

    /// The state of a pin at a cycle that is not before the last access.
    pub fn output(&self, pin: Pin, now: u64) -> PinOutput {
        self.units.output(pin, now)
    }

    /// The chip is reset at `now`; what outlives that stays.
    pub fn reset(&mut self, now: u64, cause: ResetCause) {
        for dma in &mut self.dma {
            dma.reset();
        }
        self.units.reset(now, cause);
        self.note_dma();
    }

    /// Everything that tells one state from another, as it is at `now`.
    pub fn words(&self, now: u64) -> Vec<u32> {
        self.units.words(now)
    }

    /// Bytes move, and what follows from their being moved happens.
    #[inline]
    fn transfer(&mut self, now: u64, memory: &mut Memory) {
        let plan = &self.units.plan;
        let is_due = plan.due(Slot::Dma(0)) <= now || plan.due(Slot::Dma(1)) <= now;
        // Without a new request, and while an item is still on its way, there is nothing to
        // arbitrate.
        if is_due || self.units.dma_pending {
            self.arbitrate(now, memory);
        }
    }

    fn arbitrate(&mut self, now: u64, memory: &mut Memory) {
        // A transfer may be what another waits for; each controller does what there is time for.
        while self.dma.iter_mut().enumerate().any(|(index, dma)| {
            let mut reach = DmaReach { units: &mut self.units, now };
            reach.units.rcc.is_clocked(rcc::Domain::Ahb1, 21 + index as u32)
                && dma.advance(now, memory, &mut reach)
        }) {}
        self.units.dma_pending = false;
        self.note_dma();
    }

    /// Controllers that are held in reset are as after one.
    fn reset_dma(&mut self) {
        for index in 0..2 {
            if self.units.rcc.is_held(rcc::Domain::Ahb1, 21 + index) {
                self.dma[index as usize].reset();
            }
        }
        self.note_dma();
    }

    /// The controllers may be due at other cycles than before.
    fn note_dma(&mut self) {
        for (index, dma) in self.dma.iter().enumerate() {
            self.units.plan.note(Slot::Dma(index), dma.due(), dma_lines(index, dma.lines()));
        }
    }
}

/// The interrupts of a controller's streams, by the NVIC's numbers.
const fn dma_lines(controller: usize, streams: u8) -> u128 {
    let streams = streams as u128;
    if controller == 0 {
        (streams & 0x7F) << 11 | (streams >> 7) << 47
    } else {
        (streams & 0x1F) << 56 | (streams >> 5) << 68
    }
}

/// The chip as DMA sees it.
struct DmaReach<'a, B> {
    units: &'a mut Units<B>,
    now: u64,
}

impl<B: Board> Reach for DmaReach<'_, B> {
    fn requests(&self, request: Request) -> bool {
        self.units.requests(request)
    }

    fn load(&mut self, address: u32, width: Width) -> Result<u32, Refused> {
        let found = self.units.unit(address);
        self.units.load_from(found, self.now, address, width)
    }

    fn store(&mut self, address: u32, width: Width, value: u32) -> Result<(), Refused> {
        let unit = self.units.unit(address)?;
        self.units.store_to(unit, self.now, address, width, value)
    }

    fn one_left(&mut self, request: Request) {
        self.units.one_left(request);
    }

    fn complain(&mut self, what: &'static str) {
        self.units.trouble.get_or_insert(what);
    }
}

impl<B: Board> Bus for Soc<B> {
    fn load(
        &mut self,
        memory: &mut Memory,
        now: u64,
        address: u32,
        width: Width,
    ) -> Result<u32, Refused> {
        let value = match self.units.unit(address) {
            Ok(Unit::Timer(index)) => {
                return self.units.load_timer(index, now, address, width);
            }
            Ok(Unit::Dma(index)) => {
                units::narrow(self.dma[index].read(address & 0x3FC, now)?, address, width)
            }
            found => self.units.load_from(found, now, address, width)?,
        };
        self.transfer(now, memory);
        Ok(value)
    }

    fn store(
        &mut self,
        memory: &mut Memory,
        now: u64,
        address: u32,
        width: Width,
        value: u32,
    ) -> Result<(), Refused> {
        if is_flash(address) {
            return self.units.store_flash(now, address, width, value, memory);
        }
        match self.units.unit(address)? {
            Unit::Dma(index) => {
                if width != Width::Word {
                    return Err(Refused::Unmodelled { what: "DMA: a store of less than a word" });
                }
                self.dma[index].write(address & 0x3FC, value, now)?;
                self.units.dma_pending = true;
            }
            Unit::Flash => self.units.write_flash(now, address, width, value, memory)?,
            unit => {
                self.units.store_to(unit, now, address, width, value)?;
                match unit {
                    Unit::Timer(_) => return Ok(()),
                    Unit::Rcc => self.reset_dma(),
                    _ => {}
                }
            }
        }
        self.transfer(now, memory);
        Ok(())
    }

    #[inline]
    fn due(&self) -> u64 {
        self.units.plan.next()
    }

    fn advance(&mut self, memory: &mut Memory, now: u64) {
        self.units.advance(now);
        self.transfer(now, memory);
    }

    #[inline]
    fn lines(&self) -> u128 {
        self.units.plan.lines()
    }

    fn flash_wait_states(&self) -> u8 {
        self.units.flash.wait_states()
    }

    /// The run loop also has to stop for trouble and for [`Self::take_change`].
    fn resets(&self) -> bool {
        self.units.watchdog_fired || self.units.trouble.is_some() || self.units.changed
    }
}

const fn is_flash(address: u32) -> bool {
    address < memory_map::FLASH_SIZE
        || address.wrapping_sub(memory_map::FLASH) < memory_map::FLASH_SIZE
}
