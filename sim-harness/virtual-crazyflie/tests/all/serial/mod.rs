//! A chip without a core, and a board that follows a script: what the tests of the serial
//! peripherals drive register by register.

mod dma;
mod i2c;
mod spi;
mod usart;

use std::collections::VecDeque;

use virtual_crazyflie::bus::{Bus, Refused, Width};
use virtual_crazyflie::memory::Memory;
use virtual_crazyflie::soc::{
    Board, I2cBus, Level, Nanos, Pin, Soc, SocConfig, SpiBus, UartBus, UartByte,
};

/// What the board has seen on an I²C bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Seen {
    Start { address: u8, read: bool },
    Write(u8),
    Read(u8),
    Stop,
}

/// The board.
pub(crate) struct Script {
    now: Nanos,
    /// Everything on all I²C buses, and when.
    pub(crate) seen: Vec<Seen>,
    pub(crate) moments: Vec<Nanos>,
    /// The addresses that answer.
    pub(crate) present: Vec<u8>,
    /// How many bytes are acknowledged after a start.
    pub(crate) takes: usize,
    written: usize,
    /// What is read.
    pub(crate) gives: VecDeque<u8>,
    /// Until when a device holds the clock, and the data line.
    pub(crate) clock_held: Nanos,
    pub(crate) data_held: Nanos,
    /// What came over SPI, and what is answered: each byte inverted where there is nothing.
    pub(crate) spi: Vec<u8>,
    pub(crate) answers: VecDeque<u8>,
    /// What the chip sent, with its bit and when its stop bit was over.
    pub(crate) sent: Vec<(u8, u32, Nanos)>,
    /// What is sent to the chip.
    pub(crate) coming: VecDeque<UartByte>,
}

impl Script {
    fn new() -> Self {
        Self {
            now: 0,
            seen: Vec::new(),
            moments: Vec::new(),
            present: vec![0x29],
            takes: usize::MAX,
            written: 0,
            gives: VecDeque::new(),
            clock_held: 0,
            data_held: 0,
            spi: Vec::new(),
            answers: VecDeque::new(),
            sent: Vec::new(),
            coming: VecDeque::new(),
        }
    }

    fn see(&mut self, seen: Seen) {
        self.seen.push(seen);
        self.moments.push(self.now);
    }
}

impl Board for Script {
    fn advance(&mut self, now: Nanos) {
        assert!(now >= self.now, "time runs backwards");
        self.now = now;
    }

    fn due(&self) -> Nanos {
        self.coming.iter().map(|byte| byte.at).find(|at| *at > self.now).unwrap_or(Nanos::MAX)
    }

    fn i2c_start(&mut self, _bus: I2cBus, address: u8, read: bool) -> bool {
        self.see(Seen::Start { address, read });
        self.written = 0;
        self.present.contains(&address)
    }

    fn i2c_write(&mut self, _bus: I2cBus, byte: u8) -> bool {
        self.see(Seen::Write(byte));
        self.written += 1;
        self.written <= self.takes
    }

    fn i2c_read(&mut self, _bus: I2cBus) -> u8 {
        let byte = self.gives.pop_front().unwrap_or(0xEE);
        self.see(Seen::Read(byte));
        byte
    }

    fn i2c_stop(&mut self, _bus: I2cBus) {
        self.see(Seen::Stop);
    }

    fn i2c_lines(&self, _bus: I2cBus) -> (bool, bool) {
        (self.now >= self.clock_held, self.now >= self.data_held)
    }

    fn spi_exchange(&mut self, _bus: SpiBus, byte: u8) -> u8 {
        self.spi.push(byte);
        self.answers.pop_front().unwrap_or(!byte)
    }

    fn uart_take(&mut self, _bus: UartBus, byte: u8, bit: u32) {
        self.sent.push((byte, bit, self.now));
    }

    fn uart_give(&mut self, _bus: UartBus) -> Option<UartByte> {
        (self.coming.front()?.at <= self.now).then(|| self.coming.pop_front())?
    }

    fn drive(&mut self, _pin: Pin, _level: Level) {}

    fn level(&self, _pin: Pin) -> Level {
        Level::Released
    }
}

pub(crate) const RAM: u32 = 0x2000_0000;
pub(crate) const GPIOA: u32 = 0x4002_0000;
pub(crate) const GPIOB: u32 = 0x4002_0400;
pub(crate) const GPIOC: u32 = 0x4002_0800;
pub(crate) const DMA1: u32 = 0x4002_6000;
pub(crate) const DMA2: u32 = 0x4002_6400;
const RCC: u32 = 0x4002_3800;

/// HSI, which the chip runs on after a reset, without prescalers: cycles in a microsecond.
pub(crate) const MEGAHERTZ: u64 = 16;

/// The chip on that board, with the clocks of what is tested on and its pins connected.
pub(crate) struct Rig {
    pub(crate) soc: Soc<Script>,
    pub(crate) memory: Memory,
    pub(crate) now: u64,
}

impl Rig {
    pub(crate) fn new() -> Self {
        let soc = Soc::new(Script::new(), SocConfig::default());
        let mut rig = Self { soc, memory: Memory::new(), now: 0 };
        // GPIOA to GPIOC, both DMA controllers; I2C1 to I2C3; SPI1 and USART6.
        rig.modify(RCC + 0x30, 0, 0b111 | 3 << 21);
        rig.modify(RCC + 0x40, 0, 0b111 << 21);
        rig.modify(RCC + 0x44, 0, 1 << 12 | 1 << 5);
        for (port, pin, function) in [
            (GPIOA, 8, 4),
            (GPIOC, 9, 4),
            (GPIOB, 6, 4),
            (GPIOB, 7, 4),
            (GPIOA, 5, 5),
            (GPIOA, 6, 5),
            (GPIOA, 7, 5),
            (GPIOC, 6, 8),
            (GPIOC, 7, 8),
        ] {
            rig.connect(port, pin, function);
        }
        rig
    }

    /// The pin is in this alternate function.
    pub(crate) fn connect(&mut self, port: u32, pin: u32, function: u32) {
        let register = port + 0x20 + pin / 8 * 4;
        self.modify(register, 0xF << (pin % 8 * 4), function << (pin % 8 * 4));
        self.mode(port, pin, 2);
    }

    /// GPIO_MODER.
    pub(crate) fn mode(&mut self, port: u32, pin: u32, mode: u32) {
        self.modify(port, 3 << (2 * pin), mode << (2 * pin));
    }

    pub(crate) fn board(&mut self) -> &mut Script {
        self.soc.board_mut()
    }

    /// So many cycles pass.
    pub(crate) fn pass(&mut self, cycles: u64) {
        let end = self.now + cycles;
        while self.soc.due() <= end {
            self.now = self.now.max(self.soc.due());
            self.soc.advance(&mut self.memory, self.now);
        }
        self.now = end;
    }

    pub(crate) fn micros(&mut self, micros: u64) {
        self.pass(micros * MEGAHERTZ);
    }

    /// An instruction that loads takes a few cycles.
    pub(crate) fn try_load(&mut self, address: u32, width: Width) -> Result<u32, Refused> {
        self.pass(4);
        self.soc.load(&mut self.memory, self.now, address, width)
    }

    pub(crate) fn try_store(
        &mut self,
        address: u32,
        width: Width,
        value: u32,
    ) -> Result<(), Refused> {
        self.pass(4);
        self.soc.store(&mut self.memory, self.now, address, width, value)
    }

    #[track_caller]
    pub(crate) fn read(&mut self, address: u32) -> u32 {
        self.try_load(address, Width::Word).expect("it is modelled")
    }

    #[track_caller]
    pub(crate) fn write(&mut self, address: u32, value: u32) {
        self.try_store(address, Width::Word, value).expect("it is modelled");
    }

    #[track_caller]
    pub(crate) fn modify(&mut self, address: u32, clear: u32, set: u32) {
        let value = self.read(address) & !clear | set;
        self.write(address, value);
    }

    /// What a store is refused with.
    #[track_caller]
    pub(crate) fn refusal(&mut self, address: u32, value: u32) -> &'static str {
        match self.try_store(address, Width::Word, value) {
            Err(Refused::Unmodelled { what }) => what,
            other => panic!("not refused: {other:?}"),
        }
    }

    /// Polls a register until these bits are all set; panics when that takes longer than 100 ms.
    #[track_caller]
    pub(crate) fn wait(&mut self, address: u32, bits: u32) -> u32 {
        for _ in 0..200_000 {
            let value = self.read(address);
            if value & bits == bits {
                return value;
            }
            self.pass(4);
        }
        panic!("bits {bits:#x} of {address:#x} never come: {:#x}", self.read(address));
    }

    /// The NVIC's input of that number.
    pub(crate) fn line(&self, number: u32) -> bool {
        self.soc.lines() >> number & 1 != 0
    }

    /// Passes time until the input is high; panics when it takes longer than 100 ms.
    #[track_caller]
    pub(crate) fn wait_line(&mut self, number: u32) {
        for _ in 0..200_000 {
            if self.line(number) {
                return;
            }
            self.pass(8);
        }
        panic!("interrupt {number} never comes");
    }

    pub(crate) fn put(&mut self, address: u32, bytes: &[u8]) {
        for (at, byte) in (address..).zip(bytes) {
            assert!(self.memory.store(at, Width::Byte, (*byte).into()));
        }
    }

    pub(crate) fn bytes(&self, address: u32, count: u32) -> Vec<u8> {
        self.memory.bytes(address, count).expect("it is memory").to_vec()
    }
}

/// A stream of a DMA controller.
#[derive(Clone, Copy)]
pub(crate) struct Stream {
    pub(crate) controller: u32,
    pub(crate) number: u32,
}

impl Stream {
    pub(crate) const CR: u32 = 0;
    pub(crate) const NDTR: u32 = 4;
    pub(crate) const PAR: u32 = 8;
    pub(crate) const M0AR: u32 = 12;
    pub(crate) const M1AR: u32 = 16;
    pub(crate) const FCR: u32 = 20;

    pub(crate) const FEIF: u32 = 1;
    pub(crate) const TEIF: u32 = 1 << 3;
    pub(crate) const HTIF: u32 = 1 << 4;
    pub(crate) const TCIF: u32 = 1 << 5;

    pub(crate) const fn register(self, offset: u32) -> u32 {
        self.controller + 0x10 + 0x18 * self.number + offset
    }

    /// Its flags, with its first in bit 0.
    pub(crate) fn flags(self, rig: &mut Rig) -> u32 {
        let status = rig.read(self.controller + self.number / 4 * 4);
        status >> [0, 6, 16, 22][self.number as usize % 4] & 0x3D
    }

    pub(crate) fn clear(self, rig: &mut Rig, flags: u32) {
        let shift = [0, 6, 16, 22][self.number as usize % 4];
        rig.write(self.controller + 8 + self.number / 4 * 4, flags << shift);
    }

    pub(crate) fn left(self, rig: &mut Rig) -> u32 {
        rig.read(self.register(Self::NDTR))
    }

    pub(crate) fn is_enabled(self, rig: &mut Rig) -> bool {
        rig.read(self.register(Self::CR)) & 1 != 0
    }

    /// Addresses, number and configuration, then EN: as drivers do it.
    pub(crate) fn start(self, rig: &mut Rig, cr: u32, peripheral: u32, memory: u32, items: u32) {
        self.clear(rig, 0x3D);
        rig.write(self.register(Self::PAR), peripheral);
        rig.write(self.register(Self::M0AR), memory);
        rig.write(self.register(Self::NDTR), items);
        rig.write(self.register(Self::CR), cr);
        rig.write(self.register(Self::CR), cr | 1);
    }
}

/// DMA_SxCR.
pub(crate) mod cr {
    pub(crate) const TEIE: u32 = 1 << 2;
    pub(crate) const HTIE: u32 = 1 << 3;
    pub(crate) const TCIE: u32 = 1 << 4;
    pub(crate) const PFCTRL: u32 = 1 << 5;
    pub(crate) const TO_PERIPHERAL: u32 = 1 << 6;
    pub(crate) const COPY: u32 = 2 << 6;
    pub(crate) const CIRC: u32 = 1 << 8;
    pub(crate) const PINC: u32 = 1 << 9;
    pub(crate) const MINC: u32 = 1 << 10;
    pub(crate) const PSIZE_16: u32 = 1 << 11;
    pub(crate) const PSIZE_32: u32 = 2 << 11;
    pub(crate) const MSIZE_16: u32 = 1 << 13;
    pub(crate) const MSIZE_32: u32 = 2 << 13;
    pub(crate) const DBM: u32 = 1 << 18;
    pub(crate) const CT: u32 = 1 << 19;

    pub(crate) const fn channel(number: u32) -> u32 {
        number << 25
    }

    pub(crate) const fn priority(level: u32) -> u32 {
        level << 16
    }
}
