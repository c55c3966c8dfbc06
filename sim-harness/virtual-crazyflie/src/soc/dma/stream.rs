//! One stream: its configuration, its progress, and what one transfer does.
//!
//! Data goes through the stream's FIFO of four words in both modes. In direct mode it never holds
//! more than one item. Towards a peripheral it is filled from memory as far ahead as the mode
//! allows, but not beyond the end of a round: what the chip fetches of the next round before this
//! one is over is not modelled.

use super::ports::{self, Failed};
use super::requests::{DMA1, request};
use crate::bus::{Refused, Width};
use crate::memory::Memory;
use crate::soc::context::{Reach, Request};

/// DMA_SxCR.
mod cr {
    pub(super) const EN: u32 = 1 << 0;
    pub(super) const DMEIE: u32 = 1 << 1;
    pub(super) const TEIE: u32 = 1 << 2;
    pub(super) const HTIE: u32 = 1 << 3;
    pub(super) const TCIE: u32 = 1 << 4;
    pub(super) const PFCTRL: u32 = 1 << 5;
    pub(super) const CIRC: u32 = 1 << 8;
    pub(super) const PINC: u32 = 1 << 9;
    pub(super) const MINC: u32 = 1 << 10;
    pub(super) const PINCOS: u32 = 1 << 15;
    pub(super) const DBM: u32 = 1 << 18;
    pub(super) const CT: u32 = 1 << 19;
    pub(super) const PBURST: u32 = 3 << 21;
    pub(super) const ALL: u32 = 0x0FEF_FFFF;
    /// The bits that can be written while EN is set; the others keep their values.
    pub(super) const FREE: u32 = DMEIE | TEIE | HTIE | TCIE | CIRC;
}

/// DMA_SxFCR.
mod fcr {
    pub(super) const FTH: u32 = 3;
    pub(super) const DMDIS: u32 = 1 << 2;
    pub(super) const FEIE: u32 = 1 << 7;
    pub(super) const ALL: u32 = FTH | DMDIS | FEIE;
    /// The FIFO after a reset: threshold at a half.
    pub(super) const RESET: u32 = 1;
}

/// A stream's bits in LISR and HISR, from its first on.
mod flag {
    pub(super) const FEIF: u8 = 1 << 0;
    /// Memory that is not granted in time: it always is here, so this never goes up.
    pub(super) const DMEIF: u8 = 1 << 2;
    pub(super) const TEIF: u8 = 1 << 3;
    pub(super) const HTIF: u8 = 1 << 4;
    pub(super) const TCIF: u8 = 1 << 5;
}

/// DMA_SxCR, DIR.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    FromPeripheral,
    ToPeripheral,
    Copy,
}

/// Four words.
const FIFO: usize = 16;

#[derive(Clone, Copy, Debug)]
struct Fifo {
    bytes: [u8; FIFO],
    level: usize,
}

impl Fifo {
    const EMPTY: Self = Self { bytes: [0; FIFO], level: 0 };

    fn push(&mut self, value: u32, width: Width) {
        let count = width.bytes() as usize;
        self.bytes[self.level..self.level + count].copy_from_slice(&value.to_le_bytes()[..count]);
        self.level += count;
    }

    fn pop(&mut self, width: Width) -> u32 {
        let count = width.bytes() as usize;
        let mut value = [0; 4];
        value[..count].copy_from_slice(&self.bytes[..count]);
        self.bytes.copy_within(count..self.level, 0);
        self.level -= count;
        u32::from_le_bytes(value)
    }
}

/// One of a controller's eight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stream {
    controller: usize,
    cr: u32,
    par: u32,
    m0ar: u32,
    m1ar: u32,
    fcr: u32,
    pub(super) flags: u8,
    /// The length of a round: the value that software wrote to NDTR.
    items: u16,
    /// The value that NDTR reads.
    left: u16,
    /// The request that it serves; none when it copies.
    request: Option<Request>,
    /// The addresses of the next item at either port.
    peripheral: u32,
    memory: u32,
    /// Bytes of this round that memory has still to deliver.
    unfetched: u32,
    fifo: Fifo,
    /// EN has been cleared, and falls when what has begun is over.
    closing: bool,
}

impl Stream {
    pub(super) const fn new(controller: usize) -> Self {
        Self {
            controller,
            cr: 0,
            par: 0,
            m0ar: 0,
            m1ar: 0,
            fcr: fcr::RESET,
            flags: 0,
            items: 0,
            left: 0,
            request: None,
            peripheral: 0,
            memory: 0,
            unfetched: 0,
            fifo: Fifo::EMPTY,
            closing: false,
        }
    }

    pub(super) const fn is_enabled(&self) -> bool {
        self.cr & cr::EN != 0
    }

    pub(super) const fn is_closing(&self) -> bool {
        self.closing
    }

    /// Higher comes first.
    pub(super) const fn priority(&self) -> u32 {
        self.cr >> 16 & 3
    }

    /// Whether there is something to move now.
    pub(super) fn requests(&self, reach: &impl Reach) -> bool {
        self.is_enabled()
            && !self.closing
            && self.left > 0
            && self.request.is_none_or(|request| reach.requests(request))
    }

    /// Its interrupt.
    pub(super) const fn line(&self) -> bool {
        const fn both(enable: bool, flags: u8, flag: u8) -> bool {
            enable && flags & flag != 0
        }
        both(self.cr & cr::DMEIE != 0, self.flags, flag::DMEIF)
            || both(self.cr & cr::TEIE != 0, self.flags, flag::TEIF)
            || both(self.cr & cr::HTIE != 0, self.flags, flag::HTIF)
            || both(self.cr & cr::TCIE != 0, self.flags, flag::TCIF)
            || both(self.fcr & fcr::FEIE != 0, self.flags, flag::FEIF)
    }

    pub(super) const fn load(&self, register: u32) -> u32 {
        match register {
            0x00 => self.cr,
            0x04 => self.left as u32,
            0x08 => self.par,
            0x0C => self.m0ar,
            0x10 => self.m1ar,
            _ => self.fcr | self.fill_level() << 3,
        }
    }

    /// DMA_SxFCR, FS.
    const fn fill_level(&self) -> u32 {
        match self.fifo.level {
            0 => 0b100,
            1..4 => 0b000,
            4..8 => 0b001,
            8..12 => 0b010,
            12..16 => 0b011,
            _ => 0b101,
        }
    }

    pub(super) fn store(
        &mut self,
        number: usize,
        register: u32,
        value: u32,
    ) -> Result<(), Refused> {
        let runs = self.is_enabled();
        match register {
            0x00 if runs => {
                self.cr = self.cr & !cr::FREE | value & cr::FREE;
                self.closing |= value & cr::EN == 0;
            }
            0x00 => {
                self.cr = value & cr::ALL & !cr::EN;
                if value & cr::EN != 0 {
                    self.start(number)?;
                }
            }
            #[expect(clippy::cast_possible_truncation, reason = "the register has 16 bits")]
            0x04 if !runs || self.is_untouched() => {
                self.items = value as u16;
                self.left = self.items;
                self.restart();
            }
            0x08 if !runs || self.is_untouched() => {
                self.par = value;
                self.restart();
            }
            0x0C if self.is_untouched() => {
                self.m0ar = value;
                self.restart();
            }
            0x0C if !runs || self.is_spare(false) => self.m0ar = value,
            0x10 if !runs || self.is_spare(true) => self.m1ar = value,
            // "A write access to the memory address register of the current target" (TEIF).
            0x0C | 0x10 if self.cr & cr::DBM != 0 => self.fail(),
            0x14 if !runs => self.fcr = value & fcr::ALL,
            0x14 => self.fcr = self.fcr & !fcr::FEIE | value & fcr::FEIE,
            // Write-protected while EN is set.
            _ => {}
        }
        Ok(())
    }

    /// Whether it is enabled and has not moved anything: a read for which a device did not answer
    /// leaves a stream so. The manual forbids to write NDTR and the addresses then. The vendor's
    /// I²C driver does it after every such read, and reads on, so the chip takes them.
    const fn is_untouched(&self) -> bool {
        self.is_enabled()
            && !self.closing
            && self.left == self.items
            && self.fifo.level == 0
            && self.cr & (cr::CIRC | cr::DBM) == 0
    }

    /// An enabled stream goes on from its registers.
    fn restart(&mut self) {
        if self.is_enabled() {
            self.begin_round();
        }
    }

    /// With two buffers, whether memory `second` is the one that is not in use.
    const fn is_spare(&self, second: bool) -> bool {
        self.cr & cr::DBM != 0 && (self.cr & cr::CT != 0) != second
    }

    fn direction(&self) -> Option<Direction> {
        match self.cr >> 6 & 3 {
            0 => Some(Direction::FromPeripheral),
            1 => Some(Direction::ToPeripheral),
            2 => Some(Direction::Copy),
            _ => None,
        }
    }

    /// FIFO mode: chosen, or forced when copying.
    fn is_buffered(&self) -> bool {
        self.fcr & fcr::DMDIS != 0 || self.direction() == Some(Direction::Copy)
    }

    fn peripheral_width(&self) -> Width {
        width(self.cr >> 11)
    }

    /// In direct mode, where nothing is packed, MSIZE counts for nothing.
    fn memory_width(&self) -> Width {
        if self.is_buffered() { width(self.cr >> 13) } else { self.peripheral_width() }
    }

    /// The FIFO's threshold in bytes.
    const fn threshold(&self) -> usize {
        ((self.fcr & fcr::FTH) as usize + 1) * 4
    }

    /// EN is set.
    fn start(&mut self, number: usize) -> Result<(), Refused> {
        let direction = self.check(number)?;
        if self.cr & cr::DBM != 0 {
            self.cr |= cr::CIRC;
        }
        let bursts = match self.cr >> 23 & 3 {
            0 => 1,
            beats => 2 << beats,
        };
        let burst = bursts * self.memory_width().bytes() as usize;
        if self.is_buffered() && !self.threshold().is_multiple_of(burst) {
            // A burst that the threshold does not serve (RM0090, "FIFO threshold and burst
            // configuration").
            self.flags |= flag::FEIF;
            return Ok(());
        }
        self.request = match direction {
            Direction::Copy => None,
            _ => request(self.controller, number, self.cr >> 25 & 7),
        };
        self.cr |= cr::EN;
        self.closing = false;
        self.peripheral = self.par;
        self.fifo = Fifo::EMPTY;
        self.begin_round();
        Ok(())
    }

    fn check(&self, number: usize) -> Result<Direction, Refused> {
        let refuse = |what| Err(Refused::Unmodelled { what });
        let Some(direction) = self.direction() else {
            return refuse("DMA_SxCR: the reserved direction");
        };
        let copies = direction == Direction::Copy;
        if self.cr & cr::PFCTRL != 0 {
            return refuse("DMA_SxCR: the peripheral as flow controller");
        }
        if self.cr >> 11 & 3 == 3 || self.cr >> 13 & 3 == 3 {
            return refuse("DMA_SxCR: the reserved size");
        }
        if self.cr & cr::PBURST != 0 {
            return refuse("DMA_SxCR: bursts of the peripheral");
        }
        if copies && (self.controller == DMA1 || self.cr & (cr::CIRC | cr::DBM) != 0) {
            return refuse("DMA_SxCR: a copy by DMA1, or one that repeats");
        }
        if !copies && request(self.controller, number, self.cr >> 25 & 7).is_none() {
            return refuse("DMA_SxCR: a channel of a peripheral that is not modelled");
        }
        if self.flags & (flag::TCIF | flag::TEIF) != 0 {
            return refuse("DMA_SxCR: enabled while flags of the last transfer are set");
        }
        let (peripheral, memory) = (self.peripheral_width().bytes(), self.memory_width().bytes());
        let target = if self.cr & cr::DBM != 0 { self.m0ar | self.m1ar } else { self.m0ar };
        if !self.par.is_multiple_of(peripheral) || !target.is_multiple_of(memory) {
            return refuse("DMA: an address that is not aligned to its size");
        }
        if !(u32::from(self.items) * peripheral).is_multiple_of(memory) {
            return refuse("DMA_SxNDTR: not a whole number of items of memory");
        }
        Ok(direction)
    }

    fn begin_round(&mut self) {
        self.left = self.items;
        self.unfetched = u32::from(self.items) * self.peripheral_width().bytes();
        self.peripheral = self.par;
        self.memory = if self.cr & cr::CT != 0 { self.m1ar } else { self.m0ar };
    }

    const fn fail(&mut self) {
        self.flags |= flag::TEIF;
        self.cr &= !cr::EN;
        self.closing = false;
    }

    /// EN was cleared and nothing of it is under way: what is in the FIFO for memory still gets
    /// there, and TCIF tells that it is over (RM0090, "DMA transfer suspension").
    pub(super) fn close(&mut self, memory: &mut Memory, reach: &mut impl Reach) {
        let drained = match self.direction() {
            Some(Direction::ToPeripheral) | None => Ok(()),
            Some(_) => self.drain(memory, reach),
        };
        if drained.is_err() {
            return self.fail();
        }
        self.cr &= !cr::EN;
        self.closing = false;
        self.flags |= flag::TCIF;
    }

    /// Fills the FIFO ahead of a round's first request.
    pub(super) fn preload(&mut self, memory: &Memory) {
        let sends = self.is_enabled() && self.direction() == Some(Direction::ToPeripheral);
        if sends && self.fetch(memory).is_err() {
            self.fail();
        }
    }

    /// One item of the peripheral's, either way.
    pub(super) fn transfer(&mut self, memory: &mut Memory, reach: &mut impl Reach) {
        let moved = match self.direction() {
            Some(Direction::ToPeripheral) => self.send(memory, reach),
            Some(Direction::FromPeripheral | Direction::Copy) => self.take(memory, reach),
            None => Err(Failed),
        };
        if moved.is_err() {
            return self.fail();
        }
        if self.left == 1
            && let Some(request) = self.request
        {
            reach.one_left(request);
        }
        if self.left == self.items / 2 {
            self.flags |= flag::HTIF;
        }
        if self.left == 0 {
            self.end_round(memory);
        }
    }

    fn end_round(&mut self, memory: &Memory) {
        self.flags |= flag::TCIF;
        if self.cr & cr::CIRC == 0 {
            self.cr &= !cr::EN;
            self.closing = false;
            return;
        }
        if self.cr & cr::DBM != 0 {
            self.cr ^= cr::CT;
        }
        self.begin_round();
        self.preload(memory);
    }

    fn send(&mut self, memory: &Memory, reach: &mut impl Reach) -> Result<(), Failed> {
        self.fetch(memory)?;
        let width = self.peripheral_width();
        let value = self.fifo.pop(width);
        let address = self.next_peripheral();
        ports::store_peripheral(self.controller, address, width, value, reach)?;
        self.left -= 1;
        self.fetch(memory)
    }

    fn take(&mut self, memory: &mut Memory, reach: &mut impl Reach) -> Result<(), Failed> {
        let width = self.peripheral_width();
        let address = self.next_peripheral();
        let value = ports::load_peripheral(self.controller, address, width, memory, reach)?;
        self.fifo.push(value, width);
        self.left -= 1;
        let is_due = !self.is_buffered() || self.fifo.level >= self.threshold() || self.left == 0;
        if is_due { self.drain(memory, reach) } else { Ok(()) }
    }

    /// From memory, as much as there is room for.
    fn fetch(&mut self, memory: &Memory) -> Result<(), Failed> {
        let width = self.memory_width();
        let size = width.bytes();
        let room = if self.is_buffered() { FIFO } else { size as usize };
        while self.unfetched >= size && self.fifo.level + size as usize <= room {
            let address = self.next_memory(size);
            let value = ports::load_memory(address, width, memory)?;
            self.fifo.push(value, width);
            self.unfetched -= size;
        }
        Ok(())
    }

    /// To memory, everything that is there. What is left of an item when a stream is closed in the
    /// middle goes byte by byte.
    fn drain(&mut self, memory: &mut Memory, reach: &mut impl Reach) -> Result<(), Failed> {
        while self.fifo.level > 0 {
            let whole = self.memory_width();
            let width = if self.fifo.level < whole.bytes() as usize { Width::Byte } else { whole };
            let address = self.next_memory(width.bytes());
            let value = self.fifo.pop(width);
            ports::store_memory(address, width, value, memory, reach)?;
        }
        Ok(())
    }

    fn next_peripheral(&mut self) -> u32 {
        let address = self.peripheral;
        if self.cr & cr::PINC != 0 {
            let fixed = self.cr & cr::PINCOS != 0;
            let step = if fixed { 4 } else { self.peripheral_width().bytes() };
            self.peripheral = self.peripheral.wrapping_add(step);
        }
        address
    }

    fn next_memory(&mut self, size: u32) -> u32 {
        let address = self.memory;
        if self.cr & cr::MINC != 0 {
            self.memory = self.memory.wrapping_add(size);
        }
        address
    }
}

const fn width(bits: u32) -> Width {
    match bits & 3 {
        0 => Width::Byte,
        1 => Width::Half,
        _ => Width::Word,
    }
}
