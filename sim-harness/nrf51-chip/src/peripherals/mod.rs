//! What the core reads and writes: flash, RAM, the peripherals of an nRF51822.
//!
//! A register that is not modelled reads as zero, and the first access to each is kept in
//! [`Bus::unknown`].

mod analog;
mod gpio;
mod interrupts;
mod memory;
mod radio;
mod system;
mod timer;
mod uart;

use std::collections::VecDeque;
use std::sync::Arc;

use units::Volts;

use crate::air::{Incoming, Transmission, Upcoming};
use crate::core::{Memory, NoMemory, Op, Width};
use crate::image::Program;
use crate::{Config, Cycles, NEVER, Radio};
use analog::{Adc, Thermometer};
use gpio::Gpio;
pub use gpio::{PinChange, PinLevel};
use memory::Ram;
use system::System;
use timer::Timer;
pub use uart::SentByte;
use uart::Uart;

/// The peripherals, by the numbers of their interrupts, which are also the numbers of their blocks of
/// 4 KB.
mod block {
    pub(super) const SYSTEM: u32 = 0;
    pub(super) const RADIO: u32 = 1;
    pub(super) const UART0: u32 = 2;
    pub(super) const ADC: u32 = 7;
    pub(super) const TIMER0: u32 = 8;
    pub(super) const TIMER2: u32 = 10;
    pub(super) const TEMP: u32 = 12;
}

/// The addresses of the blocks.
const APB: u32 = 0x4000_0000;
const APB_END: u32 = 0x4002_0000;
const GPIO: u32 = 0x5000_0000;
const FACTORY: u32 = 0x1000_0000;
const USER: u32 = 0x1000_1000;
const IDENTIFICATION: u32 = 0xF000_0000;
const PAGE: u32 = 0x1000;

/// An access to a register that is not modelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// The register's address.
    pub address: u32,
    /// Whether it was written.
    pub is_write: bool,
}

/// A byte on its way to the UART.
#[derive(Clone, Copy, Debug)]
struct Arriving {
    at: Cycles,
    byte: Option<u8>,
}

/// The bus.
#[derive(Clone)]
pub(crate) struct Bus {
    /// The time.
    pub(crate) now: Cycles,
    /// When the next peripheral has something to do.
    pub(crate) due: Cycles,
    /// Whether an interrupt line may have changed.
    pub(crate) changed: bool,
    program: Arc<Program>,
    config: Config,
    ram: Ram,
    system: System,
    radio: radio::Radio,
    uart: Uart,
    timers: [Timer; 3],
    adc: Adc,
    thermometer: Thermometer,
    gpio: Gpio,
    arriving: VecDeque<Arriving>,
    unknown: Vec<Unknown>,
}

impl Bus {
    pub(crate) fn new(program: Arc<Program>, config: Config) -> Self {
        Self {
            now: 0,
            due: NEVER,
            changed: true,
            program,
            config,
            ram: Ram::new(),
            system: System::new(config.retained),
            radio: radio::Radio::new(),
            uart: Uart::new(),
            timers: [Timer::new(), Timer::new(), Timer::new()],
            adc: Adc::new(),
            thermometer: Thermometer::new(),
            gpio: Gpio::new(),
            arriving: VecDeque::new(),
            unknown: Vec::new(),
        }
    }

    /// A reset of the chip: what is outside of it stays, and so does GPREGRET.
    pub(crate) fn reset(&mut self) {
        let config = Config { retained: self.system.retained, ..self.config };
        let mut new = Self::new(Arc::clone(&self.program), config);
        new.now = self.now;
        new.adc.inputs = self.adc.inputs;
        new.thermometer.quarters = self.thermometer.quarters;
        std::mem::swap(&mut new.unknown, &mut self.unknown);
        *self = new;
    }

    pub(crate) const fn is_off(&self) -> bool {
        self.system.off
    }

    pub(crate) fn unknown(&self) -> &[Unknown] {
        &self.unknown
    }

    /// What happens until now in the peripherals happens.
    #[cold]
    pub(crate) fn advance(&mut self) {
        let now = self.now;
        while let Some(byte) = self.arriving.pop_front_if(|byte| byte.at <= now) {
            self.uart.receive(byte.byte);
        }
        self.system.advance(now);
        self.radio.advance(now, &mut self.ram);
        self.radio.announce(&self.ram);
        self.uart.advance(now);
        self.timers.iter_mut().for_each(|timer| timer.advance(now));
        self.adc.advance(now);
        self.thermometer.advance(now);
        self.settle();
    }

    fn settle(&mut self) {
        let arriving = self.arriving.front().map_or(NEVER, |byte| byte.at);
        let slow = [self.system.due(), self.adc.due(), self.thermometer.due(), arriving];
        let fast = [self.radio.due(), self.uart.due()];
        let timers = self.timers.each_ref().map(Timer::due);
        self.due = slow.into_iter().chain(fast).chain(timers).min().unwrap_or(NEVER);
        self.changed = true;
    }

    /// The interrupt lines.
    pub(crate) fn lines(&self) -> u32 {
        let timer = |number: usize| self.timers[number].line();
        let lines = [
            (block::SYSTEM, self.system.line()),
            (block::RADIO, self.radio.line()),
            (block::UART0, self.uart.line()),
            (block::ADC, self.adc.line()),
            (block::TIMER0, timer(0)),
            (block::TIMER0 + 1, timer(1)),
            (block::TIMER2, timer(2)),
            (block::TEMP, self.thermometer.line()),
        ];
        lines.iter().fold(0, |all, (number, is)| all | u32::from(*is) << number)
    }

    pub(crate) fn hear(&mut self, packet: Incoming) {
        self.radio.hear(packet);
        self.settle();
    }

    pub(crate) fn receive(&mut self, at: Cycles, byte: Option<u8>) {
        let behind = self.arriving.partition_point(|other| other.at <= at);
        self.arriving.insert(behind, Arriving { at, byte });
        self.settle();
    }

    pub(crate) const fn sent_bytes(&mut self) -> &mut VecDeque<SentByte> {
        self.uart.sent()
    }

    pub(crate) fn take_transmissions(&mut self) -> Vec<Transmission> {
        self.radio.take_sent()
    }

    pub(crate) fn take_upcoming(&mut self) -> Vec<Upcoming> {
        self.radio.take_upcoming()
    }

    pub(crate) fn take_pin_changes(&mut self) -> Vec<PinChange> {
        self.gpio.take_changes()
    }

    pub(crate) const fn pin(&self, pin: u8) -> PinLevel {
        self.gpio.level(pin)
    }

    pub(crate) const fn drive_pin(&mut self, pin: u8, level: Option<bool>) {
        self.gpio.drive(pin, level);
    }

    pub(crate) fn rts(&self) -> Option<bool> {
        self.uart.rts()
    }

    pub(crate) fn set_analog(&mut self, input: u8, volts: Volts) {
        self.adc.inputs[usize::from(input) % analog::INPUTS] = volts;
    }

    pub(crate) const fn set_temperature(&mut self, quarters: i32) {
        self.thermometer.quarters = quarters;
    }

    pub(crate) const fn radio(&self) -> Radio {
        Radio {
            channel: self.radio.channel(),
            rate: self.radio.rate(),
            address: self.radio.address(0),
            power: self.radio.power_level(),
            listens: self.radio.listens(),
            missed: self.radio.missed(),
        }
    }

    /// Keeps the first access to a register that is not modelled.
    #[cold]
    fn report(&mut self, address: u32, is_write: bool) {
        let unknown = Unknown { address, is_write };
        if !self.unknown.contains(&unknown) {
            self.unknown.push(unknown);
        }
    }

    /// Brings the peripherals up to date before an access.
    fn catch_up(&mut self) {
        if self.due <= self.now {
            self.advance();
        }
    }

    fn read_register(&mut self, address: u32) -> Option<u32> {
        let (number, offset) = ((address - APB) / PAGE, address % PAGE);
        match number {
            block::SYSTEM => self.system.read(offset),
            block::RADIO => self.radio.read(offset),
            block::UART0 => {
                let value = self.uart.read(offset);
                self.settle();
                value
            }
            block::ADC => self.adc.read(offset),
            block::TIMER0..=block::TIMER2 => {
                self.timers[(number - block::TIMER0) as usize].read(offset)
            }
            block::TEMP => self.thermometer.read(offset),
            _ => None,
        }
    }

    fn write_register(&mut self, address: u32, value: u32) -> Option<()> {
        let (number, offset, now) = ((address - APB) / PAGE, address % PAGE, self.now);
        let written = match number {
            block::SYSTEM => self.system.write(now, offset, value),
            block::RADIO => {
                let written = self.radio.write(now, offset, value, &self.ram);
                self.radio.announce(&self.ram);
                written
            }
            block::UART0 => self.uart.write(now, offset, value),
            block::ADC => self.adc.write(now, offset, value),
            block::TIMER0..=block::TIMER2 => {
                self.timers[(number - block::TIMER0) as usize].write(now, offset, value)
            }
            block::TEMP => self.thermometer.write(now, offset, value),
            _ => None,
        };
        // An event of zero duration is due at once.
        self.settle();
        written
    }

    #[inline(never)]
    fn read_peripheral(&mut self, address: u32) -> Result<u32, NoMemory> {
        self.catch_up();
        let value = match address {
            APB..APB_END => self.read_register(address),
            GPIO..0x5000_1000 => self.gpio.read(address - GPIO),
            FACTORY..USER => Some(system::factory(address - FACTORY, self.config.device_address)),
            USER..0x1000_2000 => Some(u32::MAX),
            IDENTIFICATION..0xF000_1000 => Some(system::identification(address)),
            _ => return Err(NoMemory),
        };
        Ok(value.unwrap_or_else(|| {
            self.report(address, false);
            0
        }))
    }

    #[inline(never)]
    fn write_peripheral(&mut self, address: u32, value: u32) -> Result<(), NoMemory> {
        self.catch_up();
        let written = match address {
            APB..APB_END => self.write_register(address, value),
            GPIO..0x5000_1000 => self.gpio.write(self.now, address - GPIO, value),
            _ => return Err(NoMemory),
        };
        if written.is_none() {
            self.report(address, true);
        }
        Ok(())
    }
}

impl Memory for Bus {
    #[inline]
    fn read(&mut self, address: u32, width: Width) -> Result<u32, NoMemory> {
        if let Some(value) = self.ram.read(address, width) {
            return Ok(value);
        }
        if let Some(value) = self.program.read(address, width) {
            return Ok(value);
        }
        // A narrow read takes its bytes from the word.
        let word = self.read_peripheral(address & !3)?;
        let value = word >> ((address & 3) * 8);
        Ok(match width {
            Width::Byte => value & 0xFF,
            Width::Half => value & 0xFFFF,
            Width::Word => value,
        })
    }

    #[inline]
    fn write(&mut self, address: u32, width: Width, value: u32) -> Result<(), NoMemory> {
        if self.ram.write(address, width, value).is_some() {
            return Ok(());
        }
        // Registers are written as words.
        if width == Width::Word { self.write_peripheral(address, value) } else { Err(NoMemory) }
    }

    #[inline]
    fn fetch(&mut self, address: u32) -> Result<Op, NoMemory> {
        if let Some(op) = self.program.op(address) {
            return Ok(op);
        }
        let first = self.ram.read(address, Width::Half).ok_or(NoMemory)?;
        let second = self.ram.read(address.wrapping_add(2), Width::Half).unwrap_or(0);
        Ok(crate::core::decode(first as u16, second as u16))
    }
}
