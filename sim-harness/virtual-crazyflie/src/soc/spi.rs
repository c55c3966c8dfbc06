//! SPI as master with full duplex (RM0090, "Serial peripheral interface (SPI)").
//!
//! The board is given bytes, so polarity and phase of the clock are stored and go unchecked. A byte
//! is exchanged at the end of its last bit, when both sides have all of it. What no full-duplex
//! master needs is refused: slave, one line for both ways, receive only, CRC, I²S, and NSS as an
//! input.

use crate::bus::Refused;
use crate::soc::context::{Context, Peripheral};
use crate::soc::wiring::{Board, Pin, SpiBus};

const fn unmodelled(what: &'static str) -> Refused {
    Refused::Unmodelled { what }
}

/// SPI_CR1.
mod cr1 {
    pub(super) const MSTR: u32 = 1 << 2;
    pub(super) const BR: u32 = 7 << 3;
    pub(super) const SPE: u32 = 1 << 6;
    pub(super) const LSBFIRST: u32 = 1 << 7;
    pub(super) const SSI: u32 = 1 << 8;
    pub(super) const SSM: u32 = 1 << 9;
    pub(super) const RXONLY: u32 = 1 << 10;
    pub(super) const DFF: u32 = 1 << 11;
    pub(super) const CRCEN: u32 = 1 << 13;
    pub(super) const BIDIMODE: u32 = 1 << 15;
    /// The bits that must not change while a frame is on its way.
    pub(super) const FRAME: u32 = BR | LSBFIRST | DFF | MSTR | 0b11;
}

/// SPI_CR2.
mod cr2 {
    pub(super) const RXDMAEN: u32 = 1 << 0;
    pub(super) const TXDMAEN: u32 = 1 << 1;
    pub(super) const SSOE: u32 = 1 << 2;
    pub(super) const FRF: u32 = 1 << 4;
    pub(super) const ERRIE: u32 = 1 << 5;
    pub(super) const RXNEIE: u32 = 1 << 6;
    pub(super) const TXEIE: u32 = 1 << 7;
}

/// SPI_SR.
mod sr {
    pub(super) const RXNE: u32 = 1 << 0;
    pub(super) const TXE: u32 = 1 << 1;
    pub(super) const MODF: u32 = 1 << 5;
    pub(super) const OVR: u32 = 1 << 6;
    pub(super) const BSY: u32 = 1 << 7;
}

/// Its pins, all by alternate function 5 (STM32F405 data sheet, "Alternate function mapping").
const ALTERNATE: u8 = 5;
const CLOCK: [Pin; 2] = [Pin::new('A', 5), Pin::new('B', 3)];
const INPUT: [Pin; 2] = [Pin::new('A', 6), Pin::new('B', 4)];
const OUTPUT: [Pin; 2] = [Pin::new('A', 7), Pin::new('B', 5)];

/// CRCPR and I2SPR after a reset.
const CRCPR: u32 = 7;
const I2SPR: u32 = 2;

/// The state of the shift register.
#[derive(Clone, Copy, Debug)]
enum Shift {
    Empty,
    /// A frame goes out, and another comes in, by `until`.
    Busy {
        frame: u16,
        until: u64,
    },
}

/// The sequences that clear a flag, halfway.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    /// DR has been read since OVR went up.
    data: bool,
    /// SR has been accessed since MODF went up.
    fault: bool,
}

/// An SPI peripheral.
pub(crate) struct Spi {
    bus: SpiBus,
    cr1: u32,
    cr2: u32,
    crcpr: u32,
    /// RXNE, MODF, OVR.
    flags: u32,
    seen: Seen,
    transmit: Option<u16>,
    received: u16,
    shift: Shift,
}

impl Spi {
    pub(crate) const fn new(bus: SpiBus) -> Self {
        Self {
            bus,
            cr1: 0,
            cr2: 0,
            crcpr: CRCPR,
            flags: 0,
            seen: Seen { data: false, fault: false },
            transmit: None,
            received: 0,
            shift: Shift::Empty,
        }
    }

    /// Whether it requests DMA to take a frame from DR.
    pub(crate) const fn wants_receive(&self) -> bool {
        self.cr2 & cr2::RXDMAEN != 0 && self.flags & sr::RXNE != 0
    }

    /// Whether it requests DMA to bring a frame to DR.
    pub(crate) const fn wants_transmit(&self) -> bool {
        self.cr2 & cr2::TXDMAEN != 0 && self.transmit.is_none()
    }

    const fn status(&self) -> u32 {
        let empty = if self.transmit.is_none() { sr::TXE } else { 0 };
        let busy = if matches!(self.shift, Shift::Busy { .. }) { sr::BSY } else { 0 };
        self.flags | empty | busy
    }

    const fn is_on(&self, bit: u32) -> bool {
        self.cr1 & bit != 0
    }

    fn store_cr1<B: Board>(&mut self, value: u32, context: &Context<'_, B>) -> Result<(), Refused> {
        if value & (cr1::CRCEN | (1 << 12)) != 0 {
            return Err(unmodelled("SPI_CR1: CRC"));
        }
        if value & (cr1::BIDIMODE | cr1::RXONLY) != 0 {
            return Err(unmodelled("SPI_CR1: one way at a time"));
        }
        if value & (cr1::SPE | cr1::MSTR) == cr1::SPE {
            return Err(unmodelled("SPI_CR1: slave"));
        }
        let stops = value & cr1::SPE == 0 || (value ^ self.cr1) & cr1::FRAME != 0;
        if matches!(self.shift, Shift::Busy { .. }) && stops {
            return Err(unmodelled("SPI_CR1: disabled or changed in the middle of a frame"));
        }
        if self.seen.fault {
            self.flags &= !sr::MODF;
            self.seen.fault = false;
        }
        self.cr1 = value;
        self.check_select()?;
        self.start(context.now, context);
        Ok(())
    }

    /// A master whose NSS is low has another master beside it (SPI_SR, MODF).
    fn check_select(&mut self) -> Result<(), Refused> {
        if !(self.is_on(cr1::SPE) && self.is_on(cr1::MSTR)) {
            return Ok(());
        }
        if self.is_on(cr1::SSM) {
            if !self.is_on(cr1::SSI) {
                self.flags |= sr::MODF;
                self.seen.fault = false;
                self.cr1 &= !(cr1::SPE | cr1::MSTR);
            }
        } else if self.cr2 & cr2::SSOE == 0 {
            return Err(unmodelled("SPI_CR1: NSS as an input"));
        }
        Ok(())
    }

    /// Takes the next frame to the shift register, if there is one and it is free.
    fn start<B: Board>(&mut self, at: u64, context: &Context<'_, B>) {
        let runs = self.is_on(cr1::SPE) && matches!(self.shift, Shift::Empty);
        if runs && let Some(frame) = self.transmit.take() {
            let bits = if self.is_on(cr1::DFF) { 16 } else { 8 };
            let bit = context.clocks.apb2() << (((self.cr1 & cr1::BR) >> 3) + 1);
            self.shift = Shift::Busy { frame, until: at + bits * bit };
        }
    }

    fn finish<B: Board>(&mut self, frame: u16, context: &mut Context<'_, B>) {
        let received = if self.is_on(cr1::DFF) {
            let [first, second] = if self.is_on(cr1::LSBFIRST) {
                frame.reverse_bits().to_be_bytes()
            } else {
                frame.to_be_bytes()
            };
            let word =
                u16::from_be_bytes([self.exchange(first, context), self.exchange(second, context)]);
            if self.is_on(cr1::LSBFIRST) { word.reverse_bits() } else { word }
        } else {
            #[expect(clippy::cast_possible_truncation, reason = "a frame of eight bits")]
            let byte = frame as u8;
            if self.is_on(cr1::LSBFIRST) {
                self.exchange(byte.reverse_bits(), context).reverse_bits().into()
            } else {
                self.exchange(byte, context).into()
            }
        };
        if self.flags & sr::RXNE == 0 {
            self.received = received;
            self.flags |= sr::RXNE;
        } else {
            // What was there stays, what came is lost.
            self.flags |= sr::OVR;
            self.seen.data = false;
        }
    }

    /// Without a clock pin the board sees nothing; a line without a pin is high.
    fn exchange<B: Board>(&self, byte: u8, context: &mut Context<'_, B>) -> u8 {
        let has_pin = |pins: [Pin; 2]| pins.iter().any(|pin| context.connected(*pin, ALTERNATE));
        if !has_pin(CLOCK) {
            return 0xFF;
        }
        let (sends, receives) = (has_pin(OUTPUT), has_pin(INPUT));
        let answer = context.board.spi_exchange(self.bus, if sends { byte } else { 0xFF });
        if receives { answer } else { 0xFF }
    }

    const fn line(&self) -> bool {
        let status = self.status();
        (self.cr2 & cr2::TXEIE != 0 && status & sr::TXE != 0)
            || (self.cr2 & cr2::RXNEIE != 0 && status & sr::RXNE != 0)
            || (self.cr2 & cr2::ERRIE != 0 && status & (sr::OVR | sr::MODF) != 0)
    }

    const fn load_dr(&mut self) -> u32 {
        self.flags &= !sr::RXNE;
        self.seen.data = self.flags & sr::OVR != 0;
        self.received as u32
    }

    /// OVR falls by a read of DR and then of SR, MODF by an access to SR and then a write to CR1.
    const fn load_sr(&mut self) -> u32 {
        let status = self.status();
        if self.seen.data {
            self.flags &= !sr::OVR;
            self.seen.data = false;
        }
        self.seen.fault = status & sr::MODF != 0;
        status
    }
}

impl<B: Board> Peripheral<B> for Spi {
    fn read(&mut self, offset: u32, _context: &mut Context<'_, B>) -> Result<u32, Refused> {
        Ok(match offset {
            0x00 => self.cr1,
            0x04 => self.cr2,
            0x08 => self.load_sr(),
            0x0C => self.load_dr(),
            0x10 => self.crcpr,
            // No CRC is calculated, and no I²S: as after a reset.
            0x14 | 0x18 | 0x1C => 0,
            0x20 => I2SPR,
            _ => return Err(unmodelled("SPI: a register that an STM32F405 has not")),
        })
    }

    fn write(
        &mut self,
        offset: u32,
        value: u32,
        context: &mut Context<'_, B>,
    ) -> Result<(), Refused> {
        let value = value & 0xFFFF;
        match offset {
            0x00 => self.store_cr1(value, context)?,
            0x04 if value & cr2::FRF != 0 => return Err(unmodelled("SPI_CR2: TI frame format")),
            0x04 => {
                self.cr2 = value & 0xF7;
                self.check_select()?;
            }
            // CRCERR is cleared here, and never set. A write is an access all the same.
            0x08 => self.seen.fault = self.flags & sr::MODF != 0,
            0x0C => {
                let frame = value as u16;
                self.transmit = Some(frame);
                self.start(context.now, context);
            }
            0x10 => self.crcpr = value,
            // RXCRCR and TXCRCR are read-only.
            0x14 | 0x18 => {}
            0x1C if value == 0 => {}
            0x20 if value == I2SPR => {}
            0x1C | 0x20 => return Err(unmodelled("SPI_I2SCFGR, SPI_I2SPR: I2S")),
            _ => return Err(unmodelled("SPI: a register that an STM32F405 has not")),
        }
        Ok(())
    }

    fn due(&self) -> u64 {
        match self.shift {
            Shift::Empty => u64::MAX,
            Shift::Busy { until, .. } => until,
        }
    }

    fn advance(&mut self, context: &mut Context<'_, B>) {
        while let Shift::Busy { frame, until } = self.shift
            && until <= context.now
        {
            self.finish(frame, context);
            self.shift = Shift::Empty;
            self.start(until, context);
        }
    }

    fn lines(&self) -> u128 {
        match self.bus {
            SpiBus::Spi1 => u128::from(self.line()) << 35,
        }
    }

    fn reset(&mut self) {
        *self = Self::new(self.bus);
    }
}
