//! The flash interface: wait states, programming and erasing (RM0090, "Embedded Flash memory
//! interface"; times from the STM32F405 data sheet, "Flash memory").
//!
//! A program operation changes the array at once and is busy afterwards. On the chip the core stands
//! still when it fetches from flash meanwhile; here it does not, so code sees BSY where it would see
//! time missing. A store while BSY is set waits its turn.

use crate::bus::{Refused, Width};
use crate::memory::{Memory, map};
use crate::soc::clocks::Frequency;
use crate::soc::wiring::Nanos;

const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
const OPTION_KEYS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];

/// Bits of FLASH_SR.
mod sr {
    pub(super) const EOP: u32 = 1 << 0;
    pub(super) const OPERR: u32 = 1 << 1;
    pub(super) const WRPERR: u32 = 1 << 4;
    pub(super) const PGAERR: u32 = 1 << 5;
    pub(super) const PGPERR: u32 = 1 << 6;
    pub(super) const PGSERR: u32 = 1 << 7;
    pub(super) const BSY: u32 = 1 << 16;
    pub(super) const CLEARABLE: u32 = EOP | OPERR | WRPERR | PGAERR | PGPERR | PGSERR;
}

/// Bits of FLASH_CR.
mod cr {
    pub(super) const PG: u32 = 1 << 0;
    pub(super) const SER: u32 = 1 << 1;
    pub(super) const MER: u32 = 1 << 2;
    pub(super) const STRT: u32 = 1 << 16;
    pub(super) const EOPIE: u32 = 1 << 24;
    pub(super) const ERRIE: u32 = 1 << 25;
    pub(super) const LOCK: u32 = 1 << 31;
    pub(super) const KNOWN: u32 = PG | SER | MER | 15 << 3 | 3 << 8 | EOPIE | ERRIE;
}

/// Bits of FLASH_ACR.
mod acr {
    pub(super) const LATENCY: u32 = 7;
    pub(super) const ICEN: u32 = 1 << 9;
    pub(super) const DCEN: u32 = 1 << 10;
    pub(super) const ICRST: u32 = 1 << 11;
    pub(super) const DCRST: u32 = 1 << 12;
    pub(super) const KNOWN: u32 = LATENCY | 1 << 8 | ICEN | DCEN | ICRST | DCRST;
}

/// A lock with two keys (FLASH_KEYR, FLASH_OPTKEYR).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lock {
    Locked,
    /// The first key was right.
    Half,
    Open,
    /// A key was wrong: shut until the next reset.
    Shut,
}

impl Lock {
    fn turned(self, key: u32, keys: [u32; 2]) -> Self {
        match self {
            Self::Locked if key == keys[0] => Self::Half,
            Self::Half if key == keys[1] => Self::Open,
            Self::Open => Self::Open,
            Self::Locked | Self::Half | Self::Shut => Self::Shut,
        }
    }
}

/// The registers.
#[derive(Clone, Debug)]
pub(crate) struct Flash {
    /// The supply in mV, by which wait states and program widths are judged.
    supply: u32,
    acr: u32,
    sr: u32,
    cr: u32,
    lock: Lock,
    option_lock: Lock,
    /// The option bytes, as FLASH_OPTCR shows them.
    options: u32,
    busy_until: Nanos,
    is_busy: bool,
}

impl Flash {
    pub(crate) const fn new(supply: u32, options: u32) -> Self {
        Self {
            supply,
            acr: 0,
            sr: 0,
            cr: 0,
            lock: Lock::Locked,
            option_lock: Lock::Locked,
            options: options & 0x0FFF_FFEC,
            busy_until: 0,
            is_busy: false,
        }
    }

    pub(crate) fn reset(&mut self) {
        *self = Self::new(self.supply, self.options);
    }

    /// Wait states of a read.
    pub(crate) const fn wait_states(&self) -> u8 {
        (self.acr & acr::LATENCY) as u8
    }

    /// Prefetch, instruction cache, data cache.
    pub(crate) const fn accelerator(&self) -> (bool, bool, bool) {
        (self.acr & 1 << 8 != 0, self.acr & acr::ICEN != 0, self.acr & acr::DCEN != 0)
    }

    /// Whether the wait states are enough (RM0090, "Relation between CPU clock frequency and Flash
    /// memory read time").
    pub(crate) const fn keeps_up(&self, hclk: Frequency) -> bool {
        let per_state = match self.supply {
            2_700.. => 30_000_000,
            2_400.. => 24_000_000,
            2_100.. => 22_000_000,
            _ => 20_000_000,
        };
        // Oscillators are not exact: a thousandth.
        let limit = per_state * (self.wait_states() as u64 + 1);
        !hclk.above(limit + limit / 1000)
    }

    pub(crate) fn read(&mut self, offset: u32, now: Nanos) -> Result<u32, Refused> {
        self.settle(now);
        Ok(match offset {
            0x00 => self.acr,
            0x04 | 0x08 => 0,
            0x0C => self.sr | if self.is_busy { sr::BSY } else { 0 },
            0x10 => self.cr | if self.lock == Lock::Open { 0 } else { cr::LOCK },
            0x14 => self.options | u32::from(self.option_lock != Lock::Open),
            _ => return Err(Refused::Unmodelled { what: "FLASH: a reserved register" }),
        })
    }

    pub(crate) fn write(
        &mut self,
        offset: u32,
        value: u32,
        now: Nanos,
        memory: &mut Memory,
    ) -> Result<(), Refused> {
        self.settle(now);
        match offset {
            0x00 => {
                let resets_on = |reset, on| value & reset != 0 && value & on != 0;
                refuse(
                    resets_on(acr::ICRST, acr::ICEN) || resets_on(acr::DCRST, acr::DCEN),
                    "FLASH_ACR: a cache reset while it is on",
                )?;
                self.acr = value & acr::KNOWN;
            }
            0x04 => self.lock = self.lock.turned(value, KEYS),
            0x08 => self.option_lock = self.option_lock.turned(value, OPTION_KEYS),
            0x0C => self.sr &= !(value & sr::CLEARABLE),
            0x10 if self.lock == Lock::Open => self.set_cr(value, now, memory)?,
            // Locked: nothing happens.
            0x10 => {}
            0x14 if self.option_lock == Lock::Open => {
                refuse(value & !3 != self.options & !3, "FLASH_OPTCR: option bytes changed")?;
                refuse(value & 2 != 0, "FLASH_OPTCR: option bytes programmed")?;
                if value & 1 != 0 {
                    self.option_lock = Lock::Locked;
                }
            }
            0x14 => {}
            _ => return Err(Refused::Unmodelled { what: "FLASH: a reserved register" }),
        }
        Ok(())
    }

    fn set_cr(&mut self, value: u32, now: Nanos, memory: &mut Memory) -> Result<(), Refused> {
        refuse(self.is_busy, "FLASH_CR: written while busy, for which the bus would wait")?;
        self.cr = value & cr::KNOWN;
        if value & cr::LOCK != 0 {
            self.lock = Lock::Locked;
            return Ok(());
        }
        if value & cr::STRT == 0 {
            return Ok(());
        }
        match value & (cr::PG | cr::SER | cr::MER) {
            cr::SER => match sector(value >> 3 & 15) {
                Some((number, start, size)) => {
                    self.erase(number..number + 1, start, size, now, memory)
                }
                None => self.fail(sr::PGSERR),
            },
            cr::MER => self.erase(0..12, map::FLASH, map::FLASH_SIZE, now, memory),
            _ => self.fail(sr::PGSERR),
        }
        Ok(())
    }

    /// Whether this value of FLASH_CR would erase some of these addresses.
    pub(crate) const fn erases(&self, value: u32, code: &std::ops::Range<u32>) -> bool {
        if value & cr::MER != 0 {
            return true;
        }
        match sector(value >> 3 & 15) {
            Some((_, start, size)) => {
                value & cr::SER != 0 && start < code.end && code.start < start + size
            }
            None => false,
        }
    }

    fn erase(
        &mut self,
        sectors: std::ops::Range<u32>,
        start: u32,
        size: u32,
        now: Nanos,
        memory: &mut Memory,
    ) {
        if sectors.clone().any(|sector| self.protects(sector)) {
            return self.fail(sr::WRPERR);
        }
        memory.program(start, &vec![0xFF; size as usize]);
        let psize = (self.cr >> 8 & 3) as usize;
        // Typical times for 8, 16, 32 and 64 bits at once.
        let millis: [Nanos; 4] = match size {
            0x4000 => [400, 300, 250, 250],
            0x1_0000 => [1_200, 700, 550, 550],
            0x2_0000 => [2_000, 1_300, 1_000, 1_000],
            _ => [16_000, 11_000, 8_000, 8_000],
        };
        self.start(now, millis[psize] * 1_000_000);
    }

    /// Whether a sector is write-protected (FLASH_OPTCR, nWRP).
    const fn protects(&self, sector: u32) -> bool {
        self.options >> (16 + sector) & 1 == 0
    }

    /// A store to the flash array: only what the controller is ready for changes anything.
    pub(crate) fn store(
        &mut self,
        address: u32,
        width: Width,
        value: u32,
        now: Nanos,
        memory: &mut Memory,
    ) -> Result<(), Refused> {
        self.settle(now);
        if self.lock != Lock::Open || self.cr & (cr::PG | cr::SER | cr::MER) != cr::PG {
            self.fail(sr::PGSERR);
            return Ok(());
        }
        let bytes = width.bytes();
        match (self.cr >> 8 & 3, width) {
            (0, Width::Byte) | (1, Width::Half) => {}
            (2, Width::Word) => {
                refuse(self.supply < 2_700, "FLASH: 32 bits at once below 2.7 V")?;
            }
            (3, _) => return Err(Refused::Unmodelled { what: "FLASH: 64 bits at once, with VPP" }),
            _ => {
                self.fail(sr::PGPERR);
                return Ok(());
            }
        }
        // A write must not cross a 128-bit row.
        if address % 16 + bytes > 16 {
            self.fail(sr::PGAERR);
            return Ok(());
        }
        if self.protects(sector_of(address)) {
            self.fail(sr::WRPERR);
            return Ok(());
        }
        let Some(old) = memory.load(address, width) else { return Err(Refused::Fault) };
        // Bits go from one to zero, never back.
        let new = (old & value).to_le_bytes();
        memory.program(address, &new[..bytes as usize]);
        self.start(now, 16_000);
        Ok(())
    }

    fn fail(&mut self, error: u32) {
        self.sr |= error;
        if self.cr & cr::ERRIE != 0 {
            self.sr |= sr::OPERR;
        }
    }

    fn start(&mut self, now: Nanos, takes: Nanos) {
        self.busy_until = self.busy_until.max(now) + takes;
        self.is_busy = true;
    }

    /// Ends an operation whose time is over.
    pub(crate) fn settle(&mut self, now: Nanos) {
        if self.is_busy && self.busy_until <= now {
            self.is_busy = false;
            if self.cr & cr::EOPIE != 0 {
                self.sr |= sr::EOP;
            }
        }
    }

    /// When an interrupt is due; `Nanos::MAX` for never.
    pub(crate) const fn due(&self) -> Nanos {
        if self.is_busy && self.cr & cr::EOPIE != 0 { self.busy_until } else { Nanos::MAX }
    }

    /// The interrupt line: number 4.
    pub(crate) const fn lines(&self) -> u128 {
        let end = self.sr & sr::EOP != 0 && self.cr & cr::EOPIE != 0;
        let error = self.sr & sr::OPERR != 0 && self.cr & cr::ERRIE != 0;
        ((end || error) as u128) << 4
    }

    /// The option bytes as they lie in memory (RM0090, "Description of the option bytes").
    pub(crate) const fn option_bytes(&self) -> [u32; 2] {
        [self.options & 0xFFEC | 0xFFFF_0003, self.options >> 16 & 0xFFF | 0xFFFF_F000]
    }

    pub(crate) const fn words(&self, now: Nanos) -> [u32; 4] {
        let is_busy = self.is_busy && self.busy_until > now;
        [self.acr, self.sr | (is_busy as u32) << 16, self.cr, self.lock as u32]
    }
}

/// A sector's number, start and size (RM0090, "Flash module organization").
const fn sector(number: u32) -> Option<(u32, u32, u32)> {
    Some(match number {
        0..=3 => (number, map::FLASH + number * 0x4000, 0x4000),
        4 => (4, map::FLASH + 0x1_0000, 0x1_0000),
        5..=11 => (number, map::FLASH + (number - 4) * 0x2_0000, 0x2_0000),
        _ => return None,
    })
}

const fn sector_of(address: u32) -> u32 {
    match address % map::FLASH_SIZE {
        offset @ 0..0x1_0000 => offset / 0x4000,
        0x1_0000..0x2_0000 => 4,
        offset => 4 + offset / 0x2_0000,
    }
}

fn refuse(is_unknown: bool, what: &'static str) -> Result<(), Refused> {
    if is_unknown { Err(Refused::Unmodelled { what }) } else { Ok(()) }
}
