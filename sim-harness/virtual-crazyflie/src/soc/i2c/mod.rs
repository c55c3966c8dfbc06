//! I²C as master, as it stands in the STM32F405: three of them on APB1 (RM0090, "Inter-integrated
//! circuit (I2C) interface").
//!
//! This file is the registers: what a load or a store does, and how flags are cleared. What goes
//! over the lines, and when, is [`transfer`]. The peripheral is alone on its bus, so being
//! addressed as a slave, SMBus, ten-bit addresses and packet error checking are refused.

mod transfer;

use crate::bus::Refused;
use crate::soc::context::{Context, Peripheral};
use crate::soc::wiring::{Board, I2cBus, Pin};
use transfer::Phase;

const fn unmodelled(what: &'static str) -> Refused {
    Refused::Unmodelled { what }
}

/// I2C_CR1.
mod cr1 {
    pub(super) const PE: u32 = 1 << 0;
    pub(super) const NOSTRETCH: u32 = 1 << 7;
    pub(super) const START: u32 = 1 << 8;
    pub(super) const STOP: u32 = 1 << 9;
    pub(super) const ACK: u32 = 1 << 10;
    pub(super) const POS: u32 = 1 << 11;
    pub(super) const SWRST: u32 = 1 << 15;
    /// SMBUS, SMBTYPE, ENARP, ENPEC, ENGC, PEC, ALERT.
    pub(super) const REFUSED: u32 = 0x307A;
    /// The bits that are cleared with PE.
    pub(super) const FALL: u32 = START | STOP | ACK | POS;
}

/// I2C_CR2.
mod cr2 {
    pub(super) const FREQ: u32 = 0x3F;
    pub(super) const ITERREN: u32 = 1 << 8;
    pub(super) const ITEVTEN: u32 = 1 << 9;
    pub(super) const ITBUFEN: u32 = 1 << 10;
    pub(super) const DMAEN: u32 = 1 << 11;
    pub(super) const LAST: u32 = 1 << 12;
}

/// I2C_SR1.
mod sr1 {
    pub(super) const SB: u32 = 1 << 0;
    pub(super) const ADDR: u32 = 1 << 1;
    pub(super) const BTF: u32 = 1 << 2;
    pub(super) const RXNE: u32 = 1 << 6;
    pub(super) const TXE: u32 = 1 << 7;
    pub(super) const BERR: u32 = 1 << 8;
    pub(super) const ARLO: u32 = 1 << 9;
    pub(super) const AF: u32 = 1 << 10;
    /// SMBALERT, TIMEOUT, PECERR, OVR, AF, ARLO, BERR: cleared by writing zero.
    pub(super) const ERRORS: u32 = 0xDF00;
}

/// I2C_SR2.
mod sr2 {
    pub(super) const MSL: u32 = 1 << 0;
    pub(super) const BUSY: u32 = 1 << 1;
    pub(super) const TRA: u32 = 1 << 2;
}

/// I2C_CCR.
mod ccr {
    pub(super) const CCR: u32 = 0xFFF;
    pub(super) const DUTY: u32 = 1 << 14;
    pub(super) const FS: u32 = 1 << 15;
}

/// TRISE after a reset.
const TRISE: u32 = 0x02;

/// Which pins can be its lines, all by alternate function 4 (STM32F405 data sheet, "Alternate
/// function mapping").
struct Pins {
    clock: &'static [Pin],
    data: &'static [Pin],
}

const ALTERNATE: u8 = 4;

static PINS: [Pins; 3] = [
    Pins {
        clock: &[Pin::new('B', 6), Pin::new('B', 8)],
        data: &[Pin::new('B', 7), Pin::new('B', 9)],
    },
    Pins {
        clock: &[Pin::new('B', 10), Pin::new('F', 1), Pin::new('H', 4)],
        data: &[Pin::new('B', 11), Pin::new('F', 0), Pin::new('H', 5)],
    },
    Pins {
        clock: &[Pin::new('A', 8), Pin::new('H', 7)],
        data: &[Pin::new('C', 9), Pin::new('H', 8)],
    },
];

fn pins(bus: I2cBus) -> &'static Pins {
    match bus {
        I2cBus::I2c1 => &PINS[0],
        I2cBus::I2c2 => &PINS[1],
        I2cBus::I2c3 => &PINS[2],
    }
}

/// The acknowledge bit of CR1, with what it was: the bus samples it earlier than this model looks.
#[derive(Clone, Copy, Default)]
struct Acknowledge {
    now: bool,
    before: bool,
    since: u64,
}

impl Acknowledge {
    fn set(&mut self, value: bool, at: u64) {
        if value != self.now {
            *self = Self { now: value, before: self.now, since: at };
        }
    }

    /// The value at that cycle, of which no more than one change has passed.
    const fn at(self, cycle: u64) -> bool {
        if self.since > cycle { self.before } else { self.now }
    }
}

/// One of the three.
pub(crate) struct I2c {
    bus: I2cBus,
    /// Without what [`Self::acknowledge`] holds.
    cr1: u32,
    cr2: u32,
    oar1: u32,
    oar2: u32,
    ccr: u32,
    trise: u32,
    acknowledge: Acknowledge,
    /// SR1 but for TXE.
    flags: u32,
    /// The bits of these that the last load of SR1 has shown: half of a clearing sequence.
    seen: u32,
    /// SR2.TRA.
    transmitter: bool,
    /// A byte that was stored to DR and has not begun to go out.
    out: Option<u8>,
    /// The value that DR reads.
    data: u8,
    /// A byte that has come in while DR was full.
    shift: Option<u8>,
    phase: Phase,
    /// Whether the lines were the board's when the present transfer began.
    joined: bool,
    /// For the byte that comes in next when CR1.POS is set: what is answered to it.
    latched: bool,
    /// DMA has one byte left to take and LAST is set: the byte that comes in next is refused.
    last: bool,
}

impl I2c {
    pub(crate) const fn new(bus: I2cBus) -> Self {
        Self {
            bus,
            cr1: 0,
            cr2: 0,
            oar1: 0,
            oar2: 0,
            ccr: 0,
            trise: TRISE,
            acknowledge: Acknowledge { now: false, before: false, since: 0 },
            flags: 0,
            seen: 0,
            transmitter: false,
            out: None,
            data: 0,
            shift: None,
            phase: Phase::Idle,
            joined: false,
            latched: false,
            last: false,
        }
    }

    /// Its request for DMA to take a byte from DR.
    pub(crate) const fn wants_receive(&self) -> bool {
        self.cr2 & cr2::DMAEN != 0 && self.flags & sr1::RXNE != 0
    }

    /// Its request for DMA to bring a byte to DR.
    pub(crate) const fn wants_transmit(&self) -> bool {
        self.cr2 & cr2::DMAEN != 0 && self.transmit_empty()
    }

    /// DMA has taken the last byte but one (RM0090, "Requests using DMA": EOT_1).
    pub(crate) const fn one_left(&mut self) {
        const ARMED: u32 = cr2::DMAEN | cr2::LAST;
        if self.cr2 & ARMED == ARMED {
            self.last = true;
        }
    }

    /// SR1.TXE: not during the address, nor while the address waits to be seen.
    const fn transmit_empty(&self) -> bool {
        self.transmitter
            && self.out.is_none()
            && matches!(self.phase, Phase::Sending { .. } | Phase::Sent | Phase::Over)
    }

    const fn status(&self) -> u32 {
        self.flags | if self.transmit_empty() { sr1::TXE } else { 0 }
    }

    /// A flag goes up: what was seen before does not count for it.
    const fn raise(&mut self, flag: u32) {
        self.flags |= flag;
        self.seen &= !flag;
    }

    const fn is_on(&self, bit: u32) -> bool {
        self.cr1 & bit != 0
    }

    fn load_cr1(&self) -> u32 {
        self.cr1 | if self.acknowledge.now { cr1::ACK } else { 0 }
    }

    fn store_cr1<B: Board>(
        &mut self,
        value: u32,
        context: &mut Context<'_, B>,
    ) -> Result<(), Refused> {
        if value & cr1::REFUSED != 0 {
            return Err(unmodelled("I2C_CR1: SMBus, PEC or general call"));
        }
        if value & cr1::SWRST != 0 {
            *self = Self { cr1: cr1::SWRST, ..Self::new(self.bus) };
            return Ok(());
        }
        let enables = value & cr1::PE != 0 && !self.is_on(cr1::PE);
        if enables {
            self.check_timing(context)?;
        }
        // START and STOP are asked for, or taken back before they have begun.
        self.cr1 = value & (cr1::PE | cr1::NOSTRETCH | cr1::START | cr1::STOP | cr1::POS);
        self.acknowledge.set(value & cr1::ACK != 0, context.now);
        let enabled = self.is_on(cr1::PE);
        if !enabled {
            self.disable();
        }
        if enabled || self.phase.is_master() {
            self.go_on(context);
        }
        Ok(())
    }

    /// PE is zero: nothing new begins, and when the bus is quiet the flags fall (I2C_CR1, PE).
    const fn disable(&mut self) {
        if matches!(self.phase, Phase::Wanting { .. }) {
            self.phase = Phase::Idle;
        }
        if matches!(self.phase, Phase::Idle) {
            self.cr1 &= !cr1::FALL;
            self.acknowledge = Acknowledge { now: false, before: false, since: 0 };
            self.flags = 0;
            self.seen = 0;
            self.transmitter = false;
            self.out = None;
            self.shift = None;
            self.last = false;
        } else {
            self.cr1 &= !cr1::START;
        }
    }

    /// Refuses a value other than the one that the manual demands.
    fn check_timing<B: Board>(&self, context: &Context<'_, B>) -> Result<(), Refused> {
        let clocks = context.clocks;
        let bus = clocks.hclk().floor() / clocks.apb1() / 1_000_000;
        let said = u64::from(self.cr2 & cr2::FREQ);
        let least = if self.ccr & ccr::FS == 0 { 2 } else { 4 };
        if said != bus {
            return Err(unmodelled("I2C_CR2: FREQ is not the frequency of APB1"));
        }
        if !(least..=50).contains(&said) {
            return Err(unmodelled("I2C_CR2: FREQ is out of range"));
        }
        // At least 4, in fast mode with DUTY at least 1 (I2C_CCR); what ST's and others' drivers
        // allow in fast mode without DUTY is 1 too.
        let least = if self.ccr & ccr::FS == 0 { 4 } else { 1 };
        if self.ccr & ccr::CCR < least {
            return Err(unmodelled("I2C_CCR: CCR is too small"));
        }
        Ok(())
    }

    fn load_dr<B: Board>(&mut self, context: &mut Context<'_, B>) -> u32 {
        let data = self.data;
        if self.flags & sr1::RXNE != 0 {
            match self.shift.take() {
                Some(byte) => self.data = byte,
                None => self.flags &= !sr1::RXNE,
            }
        }
        self.clear_btf();
        self.go_on(context);
        data.into()
    }

    fn store_dr<B: Board>(
        &mut self,
        value: u8,
        context: &mut Context<'_, B>,
    ) -> Result<(), Refused> {
        match self.phase {
            Phase::Started => {
                if self.seen & sr1::SB == 0 {
                    return Err(unmodelled("I2C_DR: an address, but SB has not been seen in SR1"));
                }
                if value >> 3 == 0b11110 {
                    return Err(unmodelled("I2C_DR: the head of a ten-bit address"));
                }
                self.flags &= !sr1::SB;
                self.address(value, context);
            }
            Phase::Addressed | Phase::Sending { .. } | Phase::Sent | Phase::Over
                if self.transmitter =>
            {
                self.out = Some(value);
                self.clear_btf();
                self.go_on(context);
            }
            // It is lost: there is no transmission that it could belong to.
            _ => self.flags &= !sr1::RXNE,
        }
        Ok(())
    }

    /// "Cleared by software reading SR1 followed by either a read or write in the DR register".
    /// That DMA, which reads no SR1, clears it too is an assumption: otherwise a transmission by
    /// DMA that was late once would seem to be over before it is.
    const fn clear_btf(&mut self) {
        if self.seen & sr1::BTF != 0 || self.cr2 & cr2::DMAEN != 0 {
            self.flags &= !sr1::BTF;
        }
    }

    fn load_sr2<B: Board>(&mut self, context: &mut Context<'_, B>) -> u32 {
        let (clock, data) = self.levels(context);
        let master = self.phase.is_master();
        let when = |is_set: bool, bit| if is_set { bit } else { 0 };
        let value = when(master, sr2::MSL)
            | when(master || !clock || !data, sr2::BUSY)
            | when(self.transmitter, sr2::TRA);
        if self.flags & self.seen & sr1::ADDR != 0 {
            self.flags &= !sr1::ADDR;
            self.addressed(context);
        }
        value
    }

    /// CCR and TRISE "must be configured only when the I2C is disabled".
    fn set_timing(&mut self, offset: u32, value: u32) -> Result<(), Refused> {
        let (register, what) = if offset == 0x1C {
            (&mut self.ccr, "I2C_CCR: changed while PE is set")
        } else {
            (&mut self.trise, "I2C_TRISE: changed while PE is set")
        };
        if self.cr1 & cr1::PE != 0 && *register != value {
            return Err(unmodelled(what));
        }
        *register = value;
        Ok(())
    }

    const fn event_line(&self) -> bool {
        const EVENTS: u32 = sr1::SB | sr1::ADDR | sr1::BTF;
        const BUFFER: u32 = sr1::RXNE | sr1::TXE;
        let status = self.status();
        let buffer = self.cr2 & cr2::ITBUFEN != 0 && status & BUFFER != 0;
        self.cr2 & cr2::ITEVTEN != 0 && (status & EVENTS != 0 || buffer)
    }

    const fn error_line(&self) -> bool {
        self.cr2 & cr2::ITERREN != 0 && self.flags & sr1::ERRORS != 0
    }
}

impl<B: Board> Peripheral<B> for I2c {
    fn read(&mut self, offset: u32, context: &mut Context<'_, B>) -> Result<u32, Refused> {
        Ok(match offset {
            0x00 => self.load_cr1(),
            0x04 => self.cr2,
            0x08 => self.oar1,
            0x0C => self.oar2,
            0x10 => self.load_dr(context),
            0x14 => {
                self.seen = self.status();
                self.seen
            }
            0x18 => self.load_sr2(context),
            0x1C => self.ccr,
            0x20 => self.trise,
            _ => return Err(unmodelled("I2C: a register that an STM32F405 has not")),
        })
    }

    fn write(
        &mut self,
        offset: u32,
        value: u32,
        context: &mut Context<'_, B>,
    ) -> Result<(), Refused> {
        let value = value & 0xFFFF;
        if offset != 0x00 && self.is_on(cr1::SWRST) {
            // Held in reset.
            return Ok(());
        }
        match offset {
            0x00 => self.store_cr1(value, context)?,
            0x04 => {
                self.cr2 = value & 0x1F3F;
                if self.cr2 & cr2::LAST == 0 {
                    self.last = false;
                }
            }
            // ADDMODE. Without it an own address is seven bits, to which no device of the bus
            // speaks: the peripheral is its only master.
            0x08 if value & 1 << 15 != 0 => {
                return Err(unmodelled("I2C_OAR1: an own address of ten bits"));
            }
            0x08 => self.oar1 = value & 0x43FF,
            0x0C if value == 0 => self.oar2 = value,
            0x0C => return Err(unmodelled("I2C_OAR2: a second address of its own")),
            #[expect(clippy::cast_possible_truncation, reason = "the register has eight bits")]
            0x10 => self.store_dr(value as u8, context)?,
            0x14 => self.flags &= value | !sr1::ERRORS,
            // SR2 is read-only.
            0x18 => {}
            0x1C => self.set_timing(offset, value & (ccr::FS | ccr::DUTY | ccr::CCR))?,
            0x20 => self.set_timing(offset, value & 0x3F)?,
            _ => return Err(unmodelled("I2C: a register that an STM32F405 has not")),
        }
        Ok(())
    }

    fn due(&self) -> u64 {
        self.phase.until()
    }

    fn advance(&mut self, context: &mut Context<'_, B>) {
        while self.phase.until() <= context.now {
            self.step(context);
        }
    }

    fn lines(&self) -> u128 {
        let (event, error) = match self.bus {
            I2cBus::I2c1 => (31, 32),
            I2cBus::I2c2 => (33, 34),
            I2cBus::I2c3 => (72, 73),
        };
        u128::from(self.event_line()) << event | u128::from(self.error_line()) << error
    }

    fn reset(&mut self) {
        *self = Self::new(self.bus);
    }
}
