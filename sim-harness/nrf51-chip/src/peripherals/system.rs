//! CLOCK, POWER and MPU, which share one block, and the factory and user information.

use super::interrupts::Events;
use crate::{Cycles, MICROSECOND, NEVER};

/// The offsets of the registers.
mod offset {
    pub(super) const HFCLKSTART: u32 = 0x000;
    pub(super) const HFCLKSTOP: u32 = 0x004;
    pub(super) const LFCLKSTART: u32 = 0x008;
    pub(super) const LFCLKSTOP: u32 = 0x00C;
    pub(super) const RESETREAS: u32 = 0x400;
    pub(super) const HFCLKSTAT: u32 = 0x40C;
    pub(super) const LFCLKSTAT: u32 = 0x418;
    pub(super) const SYSTEMOFF: u32 = 0x500;
    pub(super) const GPREGRET: u32 = 0x51C;
    pub(super) const RAMON: u32 = 0x524;
    pub(super) const LFCLKSRC: u32 = 0x518;
    pub(super) const DISABLEINDEBUG: u32 = 0x528;
    pub(super) const RAMONB: u32 = 0x554;
    pub(super) const DCDCEN: u32 = 0x578;
}

/// The events of the two clocks.
const HF_STARTED: u32 = 0;
const LF_STARTED: u32 = 1;
/// From the start of the crystal oscillator to its event. Real crystals differ, and stay below a
/// millisecond; the program only waits for it, once.
const CRYSTAL: Cycles = 400 * MICROSECOND;
/// The same for the low-frequency clock that is synthesised from it, which is left out.
const SYNTHESISED: Cycles = 0;

/// CLOCK and POWER.
#[derive(Clone, Debug)]
pub(super) struct System {
    events: Events,
    high: Option<Cycles>,
    low: Option<Cycles>,
    high_runs: bool,
    low_runs: bool,
    low_source: u32,
    /// A register that a reset leaves.
    pub(super) retained: u8,
    /// The program has switched the chip off.
    pub(super) off: bool,
    plain: [u32; 4],
    reset_reason: u32,
}

impl System {
    pub(super) const fn new(retained: u8) -> Self {
        Self {
            events: Events::new(3),
            high: None,
            low: None,
            high_runs: false,
            low_runs: false,
            low_source: 0,
            retained,
            off: false,
            // RAMON, RAMONB, DCDCEN, DISABLEINDEBUG.
            plain: [3, 3, 0, 1],
            reset_reason: 0,
        }
    }

    pub(super) const fn line(&self) -> bool {
        self.events.line()
    }

    pub(super) fn due(&self) -> Cycles {
        self.high.unwrap_or(NEVER).min(self.low.unwrap_or(NEVER))
    }

    pub(super) fn advance(&mut self, now: Cycles) {
        if self.high.take_if(|at| *at <= now).is_some() {
            self.high_runs = true;
            self.events.raise(HF_STARTED);
        }
        if self.low.take_if(|at| *at <= now).is_some() {
            self.low_runs = true;
            self.events.raise(LF_STARTED);
        }
    }

    const fn plain(offset: u32) -> Option<usize> {
        match offset {
            offset::RAMON => Some(0),
            offset::RAMONB => Some(1),
            offset::DCDCEN => Some(2),
            offset::DISABLEINDEBUG => Some(3),
            _ => None,
        }
    }

    pub(super) fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            offset::RESETREAS => self.reset_reason,
            offset::HFCLKSTAT => u32::from(self.high_runs) * 0x1_0001,
            offset::LFCLKSTAT => u32::from(self.low_runs) << 16 | self.low_source,
            offset::GPREGRET => self.retained.into(),
            offset::LFCLKSRC => self.low_source,
            _ => match Self::plain(offset) {
                Some(at) => self.plain[at],
                None => return self.events.read(offset),
            },
        })
    }

    pub(super) fn write(&mut self, now: Cycles, offset: u32, value: u32) -> Option<()> {
        match offset {
            offset::HFCLKSTART => self.high = Some(now + CRYSTAL),
            offset::HFCLKSTOP => (self.high, self.high_runs) = (None, false),
            offset::LFCLKSTART => self.low = Some(now + SYNTHESISED),
            offset::LFCLKSTOP => (self.low, self.low_runs) = (None, false),
            offset::RESETREAS => self.reset_reason &= !value,
            offset::SYSTEMOFF => self.off = value & 1 != 0,
            offset::GPREGRET => self.retained = value as u8,
            offset::LFCLKSRC => self.low_source = value & 3,
            _ => match Self::plain(offset) {
                Some(at) => self.plain[at] = value,
                None => return self.events.write(offset, value),
            },
        }
        Some(())
    }
}

/// The value of a word of the factory information; what is not listed is erased.
pub(super) fn factory(offset: u32, device_address: [u8; 6]) -> u32 {
    let [a, b, c, d, e, f] = device_address;
    match offset {
        // CODEPAGESIZE, CODESIZE, NUMRAMBLOCK and SIZERAMBLOCKS: 256 KB of flash, two blocks of 8 KB.
        0x010 => 1024,
        0x014 => 256,
        0x034 => 2,
        0x038..0x048 => 8192,
        // DEVICEADDRTYPE and DEVICEADDR.
        0x0A0 => 1,
        0x0A4 => u32::from_le_bytes([a, b, c, d]),
        0x0A8 => u32::from_le_bytes([e, f, 0xFF, 0xFF]),
        _ => u32::MAX,
    }
}

/// The identification of the hardware at 0xF0000FE0, by which Nordic's start-up code tells the
/// revisions apart (`system_nrf51.c`): one of the third revision, which needs no workaround.
pub(super) const fn identification(address: u32) -> u32 {
    match address & 0xFFF {
        0xFE0 => 1,
        0xFE8 => 0x70,
        _ => 0,
    }
}
