//! Asynchronous serial lines, eight bits and no parity (RM0090, "Universal synchronous asynchronous
//! receiver transmitter (USART)").
//!
//! This file is the registers, the interrupts and the transmitter; [`receiver`] samples a
//! byte that the other end sends at a rate of its own. Nine bits, parity, breaks to be sent,
//! hardware flow control, LIN, IrDA, smartcard, half duplex, synchronous mode and mute mode are
//! refused.

mod receiver;

use crate::bus::Refused;
use crate::soc::context::{Context, Peripheral};
use crate::soc::wiring::{Board, Pin, UartBus};
use receiver::Receiver;

const fn unmodelled(what: &'static str) -> Refused {
    Refused::Unmodelled { what }
}

/// USART_SR.
mod sr {
    pub(super) const PE: u32 = 1 << 0;
    pub(super) const FE: u32 = 1 << 1;
    pub(super) const NF: u32 = 1 << 2;
    pub(super) const ORE: u32 = 1 << 3;
    pub(super) const IDLE: u32 = 1 << 4;
    pub(super) const RXNE: u32 = 1 << 5;
    pub(super) const TC: u32 = 1 << 6;
    pub(super) const TXE: u32 = 1 << 7;
    /// The flags that a read of SR and then of DR clears.
    pub(super) const BY_READING: u32 = PE | FE | NF | ORE | IDLE;
    /// CTS, LBD, TC, RXNE: cleared by writing zero.
    pub(super) const BY_WRITING: u32 = 0x360;
}

/// USART_CR1.
mod cr1 {
    pub(super) const SBK: u32 = 1 << 0;
    pub(super) const RWU: u32 = 1 << 1;
    pub(super) const RE: u32 = 1 << 2;
    pub(super) const TE: u32 = 1 << 3;
    pub(super) const IDLEIE: u32 = 1 << 4;
    pub(super) const RXNEIE: u32 = 1 << 5;
    pub(super) const TCIE: u32 = 1 << 6;
    pub(super) const TXEIE: u32 = 1 << 7;
    pub(super) const PCE: u32 = 1 << 10;
    pub(super) const M: u32 = 1 << 12;
    pub(super) const UE: u32 = 1 << 13;
    pub(super) const OVER8: u32 = 1 << 15;
}

/// USART_CR2.
mod cr2 {
    pub(super) const STOP: u32 = 3 << 12;
    pub(super) const TWO_STOPS: u32 = 2 << 12;
    /// LBDIE, LBCL, CPHA, CPOL, CLKEN, LINEN.
    pub(super) const REFUSED: u32 = 0x4F40;
}

/// USART_CR3.
mod cr3 {
    pub(super) const EIE: u32 = 1 << 0;
    pub(super) const DMAR: u32 = 1 << 6;
    pub(super) const DMAT: u32 = 1 << 7;
    pub(super) const ONEBIT: u32 = 1 << 11;
    /// IREN, IRLP, HDSEL, NACK, SCEN, RTSE, CTSE, CTSIE.
    pub(super) const REFUSED: u32 = 0x073E;
}

/// A start bit and eight of data; stop bits come on top.
const FRAME: u64 = 9;

/// The interrupt line and the pins of one USART.
struct Place {
    line: u32,
    alternate: u8,
    transmits: &'static [Pin],
    receives: &'static [Pin],
}

static USART6: Place = Place {
    line: 71,
    alternate: 8,
    transmits: &[Pin::new('C', 6), Pin::new('G', 14)],
    receives: &[Pin::new('C', 7), Pin::new('G', 9)],
};

const fn place(bus: UartBus) -> &'static Place {
    match bus {
        UartBus::Usart6 => &USART6,
    }
}

/// The state of the transmitter's shift register.
#[derive(Clone, Copy, Debug)]
enum Shift {
    Empty,
    /// The idle frame that goes out first when TE is set.
    Preamble {
        until: u64,
    },
    /// A byte is on its way; its stop bit ends at `until`. The bit is so many ns long.
    Busy {
        byte: u8,
        until: u64,
        bit: u32,
    },
}

/// A USART.
pub(crate) struct Usart {
    bus: UartBus,
    cr1: u32,
    cr2: u32,
    cr3: u32,
    brr: u32,
    gtpr: u32,
    /// SR but for TXE.
    flags: u32,
    /// The flags that the last load of SR has shown: half of a clearing sequence.
    seen: u32,
    transmit: Option<u8>,
    received: u8,
    shift: Shift,
    receiver: Receiver,
}

impl Usart {
    pub(crate) const fn new(bus: UartBus) -> Self {
        Self {
            bus,
            cr1: 0,
            cr2: 0,
            cr3: 0,
            brr: 0,
            gtpr: 0,
            flags: sr::TC,
            seen: 0,
            transmit: None,
            received: 0,
            shift: Shift::Empty,
            receiver: Receiver::new(),
        }
    }

    /// Whether it requests DMA to take a byte from DR.
    pub(crate) const fn wants_receive(&self) -> bool {
        self.cr3 & cr3::DMAR != 0 && self.flags & sr::RXNE != 0
    }

    /// Whether it requests DMA to bring a byte to DR.
    pub(crate) const fn wants_transmit(&self) -> bool {
        self.cr3 & cr3::DMAT != 0 && self.transmits() && self.transmit.is_none()
    }

    const fn status(&self) -> u32 {
        self.flags | if self.transmit.is_none() { sr::TXE } else { 0 }
    }

    const fn raise(&mut self, flags: u32) {
        self.flags |= flags;
        self.seen &= !flags;
    }

    const fn is_on(&self, bits: u32) -> bool {
        self.cr1 & bits == bits
    }

    const fn transmits(&self) -> bool {
        self.is_on(cr1::UE | cr1::TE)
    }

    /// A bit in cycles of the core (RM0090, "Fractional baud rate generation"): in oversampling by
    /// 8 the fraction has three bits. USART1 and USART6 are APB2's.
    fn bit<B: Board>(&self, context: &Context<'_, B>) -> u64 {
        let divisor =
            if self.is_on(cr1::OVER8) { ((self.brr >> 4) << 3) + (self.brr & 7) } else { self.brr };
        match self.bus {
            UartBus::Usart6 => u64::from(divisor) * context.clocks.apb2(),
        }
    }

    fn frame(&self) -> u64 {
        FRAME + if self.cr2 & cr2::STOP == 0 { 1 } else { 2 }
    }

    fn has_pin<B: Board>(&self, context: &Context<'_, B>, pins: &[Pin]) -> bool {
        let function = place(self.bus).alternate;
        pins.iter().any(|pin| context.connected(*pin, function))
    }

    fn store_cr1<B: Board>(
        &mut self,
        value: u32,
        context: &mut Context<'_, B>,
    ) -> Result<(), Refused> {
        if value & (cr1::M | cr1::PCE) != 0 {
            return Err(unmodelled("USART_CR1: nine bits or parity"));
        }
        if value & cr1::SBK != 0 {
            return Err(unmodelled("USART_CR1: a break"));
        }
        if value & cr1::RWU != 0 {
            return Err(unmodelled("USART_CR1: mute mode"));
        }
        if value & cr1::UE != 0 && value & (cr1::TE | cr1::RE) != 0 {
            self.check_rate(value & cr1::OVER8 != 0)?;
        }
        let (sent, received) = (self.transmits(), self.is_on(cr1::UE | cr1::RE));
        self.cr1 = value;
        if self.transmits() && !sent && matches!(self.shift, Shift::Empty) {
            let until = context.now + self.frame() * self.bit(context);
            self.shift = Shift::Preamble { until };
        }
        if !self.is_on(cr1::UE) {
            // "The USART prescalers and outputs are stopped at the end of the current byte."
            self.transmit = None;
        }
        if !received && self.is_on(cr1::UE | cr1::RE) {
            self.listen(context);
        } else if received && !self.is_on(cr1::UE | cr1::RE) {
            self.receiver.stop();
        }
        self.send(context.now, context);
        Ok(())
    }

    /// The divisor is 1 at least.
    const fn check_rate(&self, by_eight: bool) -> Result<(), Refused> {
        if self.brr < 16 {
            return Err(unmodelled("USART_BRR: less than one"));
        }
        if by_eight && self.brr & 8 != 0 {
            return Err(unmodelled("USART_BRR: bit 3 must be clear with OVER8"));
        }
        Ok(())
    }

    /// Takes the next byte to the shift register, if there is one and it is free.
    fn send<B: Board>(&mut self, at: u64, context: &Context<'_, B>) {
        let runs = self.transmits() && matches!(self.shift, Shift::Empty);
        if runs && let Some(byte) = self.transmit.take() {
            let bit = self.bit(context);
            let until = at + self.frame() * bit;
            let span = context.clocks.nanos(at + 1000 * bit) - context.clocks.nanos(at);
            let bit = u32::try_from((span + 500) / 1000).unwrap_or(u32::MAX);
            self.shift = Shift::Busy { byte, until, bit };
        }
    }

    /// The shift register is empty again.
    fn sent<B: Board>(&mut self, at: u64, context: &mut Context<'_, B>) {
        if let Shift::Busy { byte, bit, .. } = self.shift {
            if self.has_pin(context, place(self.bus).transmits) {
                context.board.uart_take(self.bus, byte, bit);
            }
            if self.transmit.is_none() {
                self.raise(sr::TC);
            }
        }
        self.shift = Shift::Empty;
        self.send(at, context);
    }

    fn load_dr(&mut self) -> u32 {
        self.flags &= !(sr::RXNE | self.seen & sr::BY_READING);
        self.seen = 0;
        self.received.into()
    }

    fn store_dr<B: Board>(&mut self, byte: u8, context: &Context<'_, B>) {
        // "A read from the USART_SR register followed by a write to the USART_DR register."
        self.flags &= !(self.seen & sr::TC);
        self.seen = 0;
        self.transmit = Some(byte);
        self.send(context.now, context);
    }

    const fn line(&self) -> bool {
        let status = self.status();
        let errors = self.cr3 & cr3::EIE != 0 && self.cr3 & cr3::DMAR != 0;
        (self.is_on(cr1::TXEIE) && status & sr::TXE != 0)
            || (self.is_on(cr1::TCIE) && status & sr::TC != 0)
            || (self.is_on(cr1::RXNEIE) && status & (sr::RXNE | sr::ORE) != 0)
            || (self.is_on(cr1::IDLEIE) && status & sr::IDLE != 0)
            || (errors && status & (sr::FE | sr::NF | sr::ORE) != 0)
    }

    fn shift_due(&self) -> u64 {
        match self.shift {
            Shift::Empty => u64::MAX,
            Shift::Preamble { until } | Shift::Busy { until, .. } => until,
        }
    }
}

impl<B: Board> Peripheral<B> for Usart {
    fn read(&mut self, offset: u32, _context: &mut Context<'_, B>) -> Result<u32, Refused> {
        Ok(match offset {
            0x00 => {
                self.seen = self.status();
                self.seen
            }
            0x04 => self.load_dr(),
            0x08 => self.brr,
            0x0C => self.cr1,
            0x10 => self.cr2,
            0x14 => self.cr3,
            0x18 => self.gtpr,
            _ => return Err(unmodelled("USART: a register that an STM32F405 has not")),
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
            0x00 => self.flags &= value | !sr::BY_WRITING,
            #[expect(clippy::cast_possible_truncation, reason = "a frame of eight bits")]
            0x04 => self.store_dr(value as u8, context),
            0x08 if self.is_on(cr1::UE) && value != self.brr => {
                return Err(unmodelled("USART_BRR: changed while UE is set"));
            }
            0x08 => self.brr = value,
            0x0C => self.store_cr1(value, context)?,
            0x10 if value & cr2::REFUSED != 0 => {
                return Err(unmodelled("USART_CR2: LIN or a clock"));
            }
            0x10 if !matches!(value & cr2::STOP, 0 | cr2::TWO_STOPS) => {
                return Err(unmodelled("USART_CR2: half stop bits"));
            }
            0x10 => self.cr2 = value & 0x702F,
            0x14 if value & cr3::REFUSED != 0 => {
                return Err(unmodelled("USART_CR3: flow control, half duplex, IrDA or smartcard"));
            }
            0x14 => self.cr3 = value & (cr3::EIE | cr3::DMAR | cr3::DMAT | cr3::ONEBIT),
            0x18 => self.gtpr = value,
            _ => return Err(unmodelled("USART: a register that an STM32F405 has not")),
        }
        Ok(())
    }

    fn due(&self) -> u64 {
        self.shift_due().min(self.receiver.due())
    }

    fn advance(&mut self, context: &mut Context<'_, B>) {
        while self.shift_due() <= context.now {
            self.sent(self.shift_due(), context);
        }
        self.receive(context);
    }

    fn lines(&self) -> u128 {
        u128::from(self.line()) << place(self.bus).line
    }

    fn reset(&mut self) {
        *self = Self::new(self.bus);
    }
}
