//! Holds the peripherals, and carries signals from one to another: RCC clocks and resets them, EXTI
//! watches pins, timers drive pins.

/// A peripheral, with the context of `self`.
macro_rules! with {
    ($self:ident, $now:expr, $method:ident($unit:expr $(, $argument:expr)*)) => {
        $unit.$method($($argument,)* &mut Context {
            now: $now,
            clocks: &$self.clocks,
            board: &mut $self.board,
            pins: &$self.pins,
        })
    };
}

mod plan;
mod time;

use crate::bus::{Refused, Width};
use crate::memory::Memory;
use crate::soc::adc::Adc;
use crate::soc::clocks::Clocks;
use crate::soc::context::{Context, Peripheral};
use crate::soc::dbgmcu::Dbgmcu;
use crate::soc::exti::{Exti, Syscfg};
use crate::soc::flash::Flash;
use crate::soc::gpio::Pins;
use crate::soc::i2c::I2c;
use crate::soc::iwdg::Iwdg;
use crate::soc::map::{self, Place, TIMERS, Unit};
use crate::soc::pwr::Pwr;
use crate::soc::rcc::{Domain, Oscillators, Rcc, ResetCause};
use crate::soc::rng::Rng;
use crate::soc::rtc::Rtc;
use crate::soc::spi::Spi;
use crate::soc::timer::{Shape, Timer};
use crate::soc::usart::Usart;
use crate::soc::usb::Usb;
use crate::soc::{Board, I2cBus, SocConfig, SpiBus, UartBus};
use plan::Plan;
pub(in crate::soc) use plan::Slot;
use time::Moment;

/// All but DMA.
pub(in crate::soc) struct Units<B> {
    pub(in crate::soc) board: B,
    pub(in crate::soc) clocks: Clocks,
    pub(in crate::soc) rcc: Rcc,
    pub(in crate::soc) flash: Flash,
    pub(in crate::soc) trouble: Option<&'static str>,
    /// The watchdog has fired.
    pub(in crate::soc) watchdog_fired: bool,
    /// Something has changed that the machine has to pass on to the core: see
    /// [`take_change`](crate::soc::Soc::take_change).
    pub(in crate::soc) changed: bool,
    /// Flash that must not change.
    pub(in crate::soc) code: std::ops::Range<u32>,
    config: SocConfig,
    pins: Pins,
    exti: Exti,
    syscfg: Syscfg,
    pwr: Pwr,
    iwdg: Iwdg,
    rtc: Rtc,
    dbgmcu: Dbgmcu,
    rng: Rng,
    timers: [Timer; TIMERS.len()],
    i2c: [I2c; 3],
    spi1: Spi,
    usart6: Usart,
    adc: Adc,
    usb: Usb,
    /// When each is due, and its interrupt lines. A unit notes its changes there.
    pub(in crate::soc) plan: Plan,
    /// The moments in nanoseconds at which the board and the chip's own units are due.
    board_moment: Moment,
    own_moment: Moment,
    /// A request for DMA may have come since it last served all that there were.
    pub(in crate::soc) dma_pending: bool,
    /// The requests that there are, two bits for each serial bus.
    wants: u16,
    /// The board has been accessed since its pins were last sampled.
    pub(in crate::soc) pins_dirty: bool,
    /// The last cycle at which the board could have been accessed, and the one up to which it has
    /// been advanced.
    last_cycle: u64,
    caught_up: Option<u64>,
}

impl<B: Board> Units<B> {
    pub(in crate::soc) fn new(board: B, config: SocConfig) -> Self {
        let rcc = Rcc::new(Oscillators { hsi: config.hsi_hz, hse: config.hse_hz });
        Self {
            board,
            clocks: Clocks::new(crate::soc::clocks::Frequency::hertz(config.hsi_hz)),
            rcc,
            flash: Flash::new(config.supply_millivolts, config.option_bytes),
            trouble: None,
            watchdog_fired: false,
            changed: false,
            code: 0..0,
            config,
            pins: Pins::new(),
            exti: Exti::default(),
            syscfg: Syscfg::default(),
            pwr: Pwr::new(),
            iwdg: Iwdg::new(config.lsi_hz),
            rtc: Rtc::default(),
            dbgmcu: Dbgmcu::default(),
            rng: Rng::new(config.unique_id),
            timers: std::array::from_fn(|index| {
                let map::TimerPlace { channels, bits, interrupt, .. } = TIMERS[index];
                Timer::new(Shape { channels, bits, interrupt })
            }),
            i2c: [I2cBus::I2c1, I2cBus::I2c2, I2cBus::I2c3].map(I2c::new),
            spi1: Spi::new(SpiBus::Spi1),
            usart6: Usart::new(UartBus::Usart6),
            adc: Adc::new(),
            usb: Usb::new(),
            plan: Plan::new(),
            board_moment: Moment::NEVER,
            own_moment: Moment::NEVER,
            dma_pending: true,
            wants: 0,
            pins_dirty: true,
            last_cycle: 0,
            caught_up: None,
        }
    }

    /// Everything but the backup domain and the debugger's registers begins anew.
    pub(in crate::soc) fn reset(&mut self, now: u64, cause: ResetCause) {
        self.rcc.reset(cause);
        self.pins.reset_all(&mut self.board);
        self.exti.reset();
        self.syscfg.reset();
        self.pwr = Pwr::new();
        self.rng.reset();
        self.flash.reset();
        self.iwdg.reset();
        if cause == ResetCause::PowerOn {
            self.rtc = Rtc::default();
            self.dbgmcu = Dbgmcu::default();
        }
        for timer in &mut self.timers {
            timer.reset(now);
        }
        for i2c in &mut self.i2c {
            Peripheral::<B>::reset(i2c);
        }
        Peripheral::<B>::reset(&mut self.spi1);
        Peripheral::<B>::reset(&mut self.usart6);
        self.adc = Adc::new();
        self.usb = Usb::new();
        (self.trouble, self.watchdog_fired) = (None, false);
        self.clock(now);
        self.note_all();
    }

    /// Whether a peripheral answers: its clock is on, and it is not held in reset. The chip would
    /// read zero and ignore what is stored, which no firmware means to do.
    pub(in crate::soc) fn is_reachable(&self, unit: Unit) -> Result<(), Refused> {
        let Some((domain, bit)) = unit.gate() else { return Ok(()) };
        if !self.rcc.is_clocked(domain, bit) {
            return Err(Refused::Unmodelled { what: unit.stopped() });
        }
        if self.rcc.is_held(domain, bit) {
            return Err(Refused::Unmodelled { what: unit.held() });
        }
        Ok(())
    }

    /// The peripheral at an address, if it answers.
    pub(in crate::soc) fn unit(&self, address: u32) -> Result<Unit, Refused> {
        match map::locate(address) {
            Place::Unit(unit) => self.is_reachable(unit).map(|()| unit),
            Place::Known(what) => Err(Refused::Unmodelled { what }),
            Place::Nothing => Err(Refused::Fault),
        }
    }

    pub(in crate::soc) fn load_timer(
        &mut self,
        index: usize,
        now: u64,
        address: u32,
        width: Width,
    ) -> Result<u32, Refused> {
        Ok(narrow(self.read_timer(index, address & 0x3FC, now)?, address, width))
    }

    /// A load of what [`Self::unit`] has found at an address.
    pub(in crate::soc) fn load_from(
        &mut self,
        found: Result<Unit, Refused>,
        now: u64,
        address: u32,
        width: Width,
    ) -> Result<u32, Refused> {
        match found {
            Ok(unit) => Ok(narrow(self.read(unit, unit.offset(address), now)?, address, width)),
            Err(_) if address >> 16 == 0x1FFF => self.engraved(address, width),
            Err(refused) => Err(refused),
        }
    }

    /// A store to what [`Self::unit`] has found at an address.
    pub(in crate::soc) fn store_to(
        &mut self,
        unit: Unit,
        now: u64,
        address: u32,
        width: Width,
        value: u32,
    ) -> Result<(), Refused> {
        let value = self.widen(unit, now, address, width, value)?;
        self.write(unit, unit.offset(address), value, now)
    }

    /// Widens a narrow store as the bus does.
    fn widen(
        &mut self,
        unit: Unit,
        now: u64,
        address: u32,
        width: Width,
        value: u32,
    ) -> Result<u32, Refused> {
        let (repeated, mask) = match width {
            Width::Word => return Ok(value),
            Width::Half => ((value & 0xFFFF) * 0x0001_0001, 0xFFFF << (8 * (address & 2))),
            Width::Byte => ((value & 0xFF) * 0x0101_0101, 0xFF << (8 * (address & 3))),
        };
        let offset = unit.offset(address);
        match unit {
            unit if unit.is_behind_bridge() => Ok(repeated),
            // Zeros do nothing in GPIO_BSRR.
            Unit::Gpio(_) if offset == 0x18 => Ok(repeated & mask),
            Unit::Gpio(_) if offset == 0x1C => {
                Err(Refused::Unmodelled { what: "GPIO_LCKR: a store of less than a word" })
            }
            unit => Ok(self.read(unit, offset, now)? & !mask | repeated & mask),
        }
    }

    /// The data that were written into the chip when it was made (RM0090, "Device electronic
    /// signature").
    fn engraved(&self, address: u32, width: Width) -> Result<u32, Refused> {
        let word = match address & !3 {
            0x1FFF_7800..0x1FFF_7820 => self.board_name(address & 0x1C),
            // The other one-time programmable bytes and the locks, never used.
            0x1FFF_7820..0x1FFF_7A10 => u32::MAX,
            0x1FFF_7A10 => self.config.unique_id[0],
            0x1FFF_7A14 => self.config.unique_id[1],
            0x1FFF_7A18 => self.config.unique_id[2],
            // The flash's size in KiB, in the upper half.
            0x1FFF_7A20 => 1024 << 16 | 0xFFFF,
            0x1FFF_C000 => self.flash.option_bytes()[0],
            0x1FFF_C008 => self.flash.option_bytes()[1],
            0x1FFF_7A1C..0x1FFF_8000 => {
                return Err(Refused::Unmodelled { what: "the factory's calibration values" });
            }
            0x1FFF_0000..0x1FFF_7800 => {
                return Err(Refused::Unmodelled { what: "ST's bootloader" });
            }
            _ => return Err(Refused::Fault),
        };
        Ok(narrow(word, address, width))
    }

    /// A word of the board's name, which zeros follow.
    fn board_name(&self, offset: u32) -> u32 {
        let byte = |at| self.config.board_name.as_bytes().get(at).copied().unwrap_or_default();
        let offset = offset as usize;
        u32::from_le_bytes([byte(offset), byte(offset + 1), byte(offset + 2), byte(offset + 3)])
    }

    fn read_timer(&mut self, index: usize, offset: u32, now: u64) -> Result<u32, Refused> {
        if self.timers[index].advance(now) {
            self.note_timer(index);
        }
        self.timers[index].read(offset)
    }

    fn read(&mut self, unit: Unit, offset: u32, now: u64) -> Result<u32, Refused> {
        if unit.sees_board() {
            self.catch_up(now);
        }
        match unit {
            Unit::Timer(index) => self.read_timer(index, offset, now),
            Unit::I2c(_) | Unit::Spi1 | Unit::Usart6 => {
                let value = match unit {
                    Unit::I2c(index) => with!(self, now, read(self.i2c[index], offset)),
                    Unit::Spi1 => with!(self, now, read(self.spi1, offset)),
                    _ => with!(self, now, read(self.usart6, offset)),
                };
                self.note_serial(unit);
                value
            }
            Unit::Gpio(port) => self.pins.read(port, offset, &self.board),
            Unit::Syscfg => self.syscfg.read(offset),
            Unit::Exti => self.exti.read(offset),
            Unit::Pwr => self.pwr.read(offset),
            Unit::Rcc | Unit::Flash | Unit::Iwdg | Unit::Usb => {
                let value = self.read_own(unit, offset, now);
                self.note_own();
                value
            }
            Unit::Rtc => self.rtc.read(offset),
            Unit::Adc => self.converters(offset)?.read(offset),
            Unit::Dbgmcu => self.dbgmcu.read(offset),
            Unit::Rng => self.rng.read(offset),
            Unit::Dma(_) => Err(Refused::Unmodelled { what: "DMA that reaches a DMA controller" }),
        }
    }

    /// Reads a register that changes by itself with time.
    fn read_own(&mut self, unit: Unit, offset: u32, now: u64) -> Result<u32, Refused> {
        let nanos = self.clocks.nanos(now);
        match unit {
            Unit::Flash => self.flash.read(offset, nanos),
            Unit::Iwdg => self.iwdg.read(offset, nanos),
            Unit::Usb => self.usb.read(offset, nanos),
            _ => {
                if self.rcc.settle(nanos) {
                    self.clock(now);
                }
                self.rcc.read(offset, nanos, self.iwdg.is_started())
            }
        }
    }

    fn write(&mut self, unit: Unit, offset: u32, value: u32, now: u64) -> Result<(), Refused> {
        if unit.sees_board() {
            self.catch_up(now);
        }
        match unit {
            Unit::Timer(index) => {
                let result = self.timers[index].write(offset, value, now);
                self.note_timer(index);
                return result;
            }
            Unit::I2c(_) | Unit::Spi1 | Unit::Usart6 => {
                let result = match unit {
                    Unit::I2c(index) => with!(self, now, write(self.i2c[index], offset, value)),
                    Unit::Spi1 => with!(self, now, write(self.spi1, offset, value)),
                    _ => with!(self, now, write(self.usart6, offset, value)),
                };
                self.note_serial(unit);
                return result;
            }
            Unit::Gpio(port) => {
                self.pins.write(port, offset, value, &mut self.board)?;
                self.watch_pins();
                self.note_board();
            }
            Unit::Syscfg => {
                self.syscfg.write(offset, value)?;
                self.watch_pins();
                self.note_board();
            }
            Unit::Exti => {
                self.write_exti(offset, value)?;
                self.note_board();
            }
            Unit::Pwr => self.pwr.write(offset, value, self.rcc.pll_is_on())?,
            Unit::Rcc => self.write_rcc(offset, value, now)?,
            Unit::Iwdg => {
                let result = self.iwdg.write(offset, value, self.clocks.nanos(now));
                self.note_own();
                return result;
            }
            Unit::Usb => {
                let result = self.usb.write(offset, value, self.clocks.nanos(now));
                self.note_own();
                return result;
            }
            Unit::Adc => self.converters(offset)?.write(offset, value)?,
            Unit::Rtc => self.rtc.write(offset, value, self.pwr.opens_backup())?,
            Unit::Rng => self.rng.write(offset, value)?,
            Unit::Dbgmcu => {
                self.dbgmcu.write(offset, value)?;
                self.changed = true;
            }
            Unit::Flash | Unit::Dma(_) => {
                return Err(Refused::Unmodelled {
                    what: "DMA that reaches FLASH or DMA registers",
                });
            }
        }
        Ok(())
    }

    /// The converters, if the one that an offset belongs to has its clock.
    fn converters(&mut self, offset: u32) -> Result<&mut Adc, Refused> {
        let runs = |converter| self.rcc.is_clocked(Domain::Apb2, 8 + converter);
        if Adc::converter(offset).is_none_or(runs) {
            Ok(&mut self.adc)
        } else {
            Err(Refused::Unmodelled { what: "an ADC whose clock is off (RCC_APB2ENR)" })
        }
    }

    fn write_exti(&mut self, offset: u32, value: u32) -> Result<(), Refused> {
        let before = self.exti.watched();
        self.exti.write(offset, value)?;
        let mut new = self.exti.watched() & !before;
        while new != 0 {
            let line = new.trailing_zeros();
            new &= new - 1;
            let pin = self.syscfg.pin(line as usize);
            self.exti.settle(line, self.pins.is_high(pin, &self.board));
        }
        Ok(())
    }

    fn write_rcc(&mut self, offset: u32, value: u32, now: u64) -> Result<(), Refused> {
        let nanos = self.clocks.nanos(now);
        self.rcc.write(offset, value, nanos, self.pwr.opens_backup())?;
        if self.rcc.backup_is_held() {
            self.rtc = Rtc::default();
        }
        if matches!(offset, 0x10..=0x24) {
            self.reset_held(now);
        }
        self.clock(now);
        self.dma_pending = true;
        self.note_all();
        Ok(())
    }

    /// Peripherals whose reset bit is set are as after a reset.
    fn reset_held(&mut self, now: u64) {
        let held =
            |unit: Unit| unit.gate().is_some_and(|(domain, bit)| self.rcc.is_held(domain, bit));
        let reset = |index: &usize| held(Unit::Timer(*index));
        for index in (0..TIMERS.len()).filter(reset).collect::<Vec<_>>() {
            self.timers[index].reset(now);
        }
        let held =
            |unit: Unit| unit.gate().is_some_and(|(domain, bit)| self.rcc.is_held(domain, bit));
        for (index, i2c) in self.i2c.iter_mut().enumerate() {
            if held(Unit::I2c(index)) {
                Peripheral::<B>::reset(i2c);
            }
        }
        if held(Unit::Spi1) {
            Peripheral::<B>::reset(&mut self.spi1);
        }
        if held(Unit::Usart6) {
            Peripheral::<B>::reset(&mut self.usart6);
        }
        for port in 0..9 {
            if held(Unit::Gpio(port)) {
                self.pins.reset(port, &mut self.board);
            }
        }
        if held(Unit::Syscfg) {
            self.syscfg.reset();
            self.exti.reset();
        }
        if self.rcc.is_held(Domain::Apb2, 8) {
            self.adc = Adc::new();
        }
        if held(Unit::Usb) {
            self.usb = Usb::new();
        }
        if held(Unit::Pwr) {
            self.pwr = Pwr::new();
        }
        self.watch_pins();
    }

    /// Applies the clocks that RCC selects.
    fn clock(&mut self, now: u64) {
        let tree = match self.rcc.tree() {
            Ok(tree) => tree,
            Err(what) => {
                self.trouble.get_or_insert(what);
                return;
            }
        };
        if tree.hclk != self.clocks.hclk() {
            self.follow();
            self.changed = true;
            // What is due in nanoseconds is due at another cycle.
            (self.board_moment, self.own_moment) = (Moment::NEVER, Moment::NEVER);
        }
        self.clocks.change(now, tree.hclk, tree.apb1, tree.apb2);
        self.note_board();
        self.note_own();
        if tree.hclk.above(self.pwr.highest() + self.pwr.highest() / 1000) {
            self.trouble.get_or_insert("PWR_CR: VOS is too low for this HCLK");
        }
        self.check_wait_states();
        for (index, place) in TIMERS.iter().enumerate() {
            let (domain, bit) = place.gate;
            let divider = match domain {
                Domain::Apb2 => self.clocks.timers2(),
                Domain::Ahb1 | Domain::Ahb2 | Domain::Apb1 => self.clocks.timers1(),
            };
            self.timers[index].clock(now, divider, self.rcc.is_clocked(domain, bit));
            self.note_timer(index);
        }
    }

    fn check_wait_states(&mut self) {
        if !self.flash.keeps_up(self.clocks.hclk()) {
            self.trouble.get_or_insert("FLASH_ACR: too few wait states for this HCLK");
        }
    }

    pub(in crate::soc) fn write_flash(
        &mut self,
        now: u64,
        address: u32,
        width: Width,
        value: u32,
        memory: &mut Memory,
    ) -> Result<(), Refused> {
        let value = self.widen(Unit::Flash, now, address, width, value)?;
        let offset = address & 0x3FC;
        if offset == 0x10
            && value & 1 << 16 != 0
            && !self.code.is_empty()
            && self.flash.erases(value, &self.code)
        {
            return Err(Refused::Unmodelled { what: "FLASH_CR: the running program erased" });
        }
        let accelerator = self.flash.accelerator();
        let result = self.flash.write(offset, value, self.clocks.nanos(now), memory);
        self.note_own();
        result?;
        self.changed |= accelerator != self.flash.accelerator();
        self.check_wait_states();
        Ok(())
    }

    pub(in crate::soc) fn store_flash(
        &mut self,
        now: u64,
        address: u32,
        width: Width,
        value: u32,
        memory: &mut Memory,
    ) -> Result<(), Refused> {
        let address = address | crate::memory::map::FLASH;
        if self.code.contains(&address) {
            return Err(Refused::Unmodelled { what: "flash: a store into the running program" });
        }
        let result = self.flash.store(address, width, value, self.clocks.nanos(now), memory);
        self.note_own();
        result
    }
}

/// The part of a register that a narrow load takes.
pub(in crate::soc) const fn narrow(word: u32, address: u32, width: Width) -> u32 {
    let shifted = word >> (8 * (address & 3));
    match width {
        Width::Byte => shifted & 0xFF,
        Width::Half => shifted & 0xFFFF,
        Width::Word => word,
    }
}
