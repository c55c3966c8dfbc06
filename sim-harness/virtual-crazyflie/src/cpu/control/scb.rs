//! The system control block (DDI 0403, B3.2), with the MPU, which is there and cannot be enabled.

use super::{Store, unmodelled};
use crate::bus::Refused;
use crate::cpu::Cpu;
use crate::cpu::exceptions::priorities::{bit, number};
use crate::cpu::exceptions::{cfsr, hfsr};

/// Cortex-M4 r0p1.
const CPUID: u32 = 0x410F_C241;

/// CCR.
const NONBASETHRDENA: u32 = 1;
const USERSETMPEND: u32 = 1 << 1;
const UNALIGN_TRP: u32 = 1 << 3;
const DIV_0_TRP: u32 = 1 << 4;
pub(super) const STKALIGN: u32 = 1 << 9;
const CCR: u32 = NONBASETHRDENA | USERSETMPEND | UNALIGN_TRP | DIV_0_TRP | STKALIGN;

/// SCR.
const SLEEPONEXIT: u32 = 1 << 1;
const SLEEPDEEP: u32 = 1 << 2;
const SEVONPEND: u32 = 1 << 4;

/// AIRCR.
const VECTKEY: u32 = 0x05FA;
const VECTKEYSTAT: u32 = 0xFA05 << 16;
const SYSRESETREQ: u32 = 1 << 2;
const VECTCLRACTIVE_VECTRESET: u32 = 3;

/// VTOR: 98 vectors need a table that is aligned to 128 words.
const TBLOFF: u32 = 0xFFFF_FE00;

/// ACTLR: bits that change only how fast things go: DISMCYCINT, DISDEFWBUF, DISFOLD, DISOOFP.
const ACTLR: u32 = 1 | 1 << 1 | 1 << 2 | 1 << 9;

/// DFSR.
const DFSR: u32 = 0x1F;

/// Eight regions, all of them for data and instructions alike.
const MPU_TYPE: u32 = 8 << 8;

/// ICSR: bit to set pending, bit to clear it, and what.
const ICSR_PENDS: [(u32, u32, u16); 3] = [
    (1 << 31, 0, number::NMI),
    (1 << 28, 1 << 27, number::PEND_SV),
    (1 << 26, 1 << 25, number::SYS_TICK),
];

/// SHCSR: bits and their exceptions.
const SHCSR_ACTIVE: [(u32, u16); 7] = [
    (1, number::MEM_MANAGE),
    (1 << 1, number::BUS_FAULT),
    (1 << 3, number::USAGE_FAULT),
    (1 << 7, number::SV_CALL),
    (1 << 8, number::DEBUG_MONITOR),
    (1 << 10, number::PEND_SV),
    (1 << 11, number::SYS_TICK),
];
const SHCSR_PENDING: [(u32, u16); 4] = [
    (1 << 12, number::USAGE_FAULT),
    (1 << 13, number::MEM_MANAGE),
    (1 << 14, number::BUS_FAULT),
    (1 << 15, number::SV_CALL),
];
const SHCSR_ENABLED: [(u32, u16); 3] =
    [(1 << 16, number::MEM_MANAGE), (1 << 17, number::BUS_FAULT), (1 << 18, number::USAGE_FAULT)];

/// The registers by which a handler learns the cause of a fault.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::cpu) struct FaultStatus {
    pub(in crate::cpu) cfsr: u32,
    pub(in crate::cpu) hfsr: u32,
    pub(in crate::cpu) dfsr: u32,
    pub(in crate::cpu) mmfar: u32,
    pub(in crate::cpu) bfar: u32,
}

impl super::Control {
    /// CCR.DIV_0_TRP.
    #[inline]
    pub(crate) const fn traps_division(&self) -> bool {
        self.ccr & DIV_0_TRP != 0
    }

    /// CCR.UNALIGN_TRP.
    #[inline]
    pub(crate) const fn traps_unaligned(&self) -> bool {
        self.ccr & UNALIGN_TRP != 0
    }

    /// CCR.STKALIGN.
    pub(in crate::cpu) const fn aligns_stack(&self) -> bool {
        self.ccr & STKALIGN != 0
    }

    /// CCR.NONBASETHRDENA.
    pub(in crate::cpu) const fn returns_to_thread_from_any(&self) -> bool {
        self.ccr & NONBASETHRDENA != 0
    }

    /// CCR.USERSETMPEND.
    pub(super) const fn lets_users_pend(&self) -> bool {
        self.ccr & USERSETMPEND != 0
    }

    /// SCR.SEVONPEND.
    pub(in crate::cpu) const fn sends_event_on_pend(&self) -> bool {
        self.scr & SEVONPEND != 0
    }

    /// SCR.SLEEPONEXIT.
    pub(in crate::cpu) const fn sleeps_on_exit(&self) -> bool {
        self.scr & SLEEPONEXIT != 0
    }

    /// VTOR.
    pub(in crate::cpu) const fn vtor(&self) -> u32 {
        self.vtor
    }

    /// Sets VTOR, wherever it may point.
    pub(in crate::cpu) const fn set_vtor(&mut self, vtor: u32) {
        self.vtor = vtor;
    }
}

/// The bits of a table whose exceptions are in a set.
fn shown(table: &[(u32, u16)], set: u128) -> u32 {
    table.iter().filter(|(_, n)| set & bit(*n) != 0).fold(0, |word, (flag, _)| word | flag)
}

/// The exceptions whose bits in a table are set, and those whose are not.
fn split(table: &[(u32, u16)], word: u32) -> (u128, u128) {
    table.iter().fold((0, 0), |(on, off), (flag, n)| {
        if word & flag != 0 { (on | bit(*n), off) } else { (on, off | bit(*n)) }
    })
}

impl Cpu {
    /// Whether AIRCR.SYSRESETREQ was written.
    #[inline]
    pub(crate) const fn wants_reset(&self) -> bool {
        self.control.reset
    }

    pub(super) fn load_scb(&self, address: u32) -> Result<u32, Refused> {
        let control = &self.control;
        Ok(match address {
            0xE000_E008 => control.actlr,
            0xE000_ED00 => CPUID,
            0xE000_ED04 => self.icsr(),
            0xE000_ED08 => control.vtor,
            0xE000_ED0C => VECTKEYSTAT | u32::from(self.exceptions.priorities.grouping()) << 8,
            0xE000_ED10 => control.scr,
            0xE000_ED14 => control.ccr,
            0xE000_ED18..=0xE000_ED20 => self.shpr(address),
            0xE000_ED24 => self.shcsr(),
            0xE000_ED28 => control.faults.cfsr,
            0xE000_ED2C => control.faults.hfsr,
            0xE000_ED30 => control.faults.dfsr,
            0xE000_ED34 => control.faults.mmfar,
            0xE000_ED38 => control.faults.bfar,
            // AFSR: nothing outside the core reports anything by it.
            0xE000_ED3C => 0,
            0xE000_ED40..=0xE000_ED84 => return identification(address),
            0xE000_ED90 => MPU_TYPE,
            0xE000_ED94 => 0,
            0xE000_ED98..=0xE000_EDB8 => return unmodelled("a region of the MPU"),
            _ => return unmodelled("a reserved register of the system control block"),
        })
    }

    fn icsr(&self) -> u32 {
        let priorities = &self.exceptions.priorities;
        let pends = ICSR_PENDS.map(|(set, _, exception)| (set, exception));
        let interrupts = priorities.pending() >> number::FIRST_INTERRUPT != 0;
        let here = self.special.ipsr;
        let others = priorities.active() & !bit(here);
        shown(&pends, priorities.pending())
            | u32::from(interrupts) << 22
            | u32::from(priorities.vect_pending()) << 12
            | u32::from(others == 0) << 11
            | u32::from(here)
    }

    /// SHPR1 to SHPR3: exceptions 4 to 15, of which some are reserved.
    fn shpr(&self, address: u32) -> u32 {
        let first = 4 + address - 0xE000_ED18;
        (first..first + 4)
            .rev()
            .fold(0, |word, n| word << 8 | self.exceptions.priorities.priority(n as u16) as u32)
    }

    fn shcsr(&self) -> u32 {
        let priorities = &self.exceptions.priorities;
        shown(&SHCSR_ACTIVE, priorities.active())
            | shown(&SHCSR_PENDING, priorities.pending())
            | shown(&SHCSR_ENABLED, priorities.enabled())
    }

    pub(super) fn store_scb(&mut self, store: Store) -> Result<(), Refused> {
        let value = store.value;
        let faults = &mut self.control.faults;
        match store.address {
            0xE000_E008 if value & !ACTLR != 0 => return unmodelled("ACTLR: DISFPCA, or reserved"),
            0xE000_E008 => self.control.actlr = value,
            0xE000_ED04 => self.store_icsr(value),
            0xE000_ED08 if value & !TBLOFF != 0 => {
                return unmodelled("VTOR: a table that is not aligned to 512 bytes");
            }
            0xE000_ED08 => self.control.vtor = value,
            0xE000_ED0C => return self.store_aircr(value),
            0xE000_ED10 if value & SLEEPDEEP != 0 => return unmodelled("SCR.SLEEPDEEP"),
            0xE000_ED10 => self.control.scr = value & (SLEEPONEXIT | SEVONPEND),
            0xE000_ED14 if value & !CCR != 0 => {
                return unmodelled("CCR: BFHFNMIGN, or a reserved bit");
            }
            0xE000_ED14 => self.control.ccr = value,
            0xE000_ED18..=0xE000_ED20 => self.store_shpr(store),
            0xE000_ED24 => self.store_shcsr(value),
            // Write one to clear.
            0xE000_ED28 => faults.cfsr &= !(value & cfsr::MASK),
            0xE000_ED2C => faults.hfsr &= !(value & hfsr::MASK),
            0xE000_ED30 => faults.dfsr &= !(value & DFSR),
            0xE000_ED34 => faults.mmfar = value,
            0xE000_ED38 => faults.bfar = value,
            0xE000_ED3C => {}
            0xE000_ED00 | 0xE000_ED40..=0xE000_ED80 | 0xE000_ED90 => {
                return unmodelled("a store to a read-only register");
            }
            0xE000_ED84 => return unmodelled("CSSELR: there is no cache"),
            0xE000_ED94 if value == 0 => {}
            0xE000_ED94 => return unmodelled("MPU_CTRL: the MPU enabled"),
            0xE000_ED98..=0xE000_EDB8 => return unmodelled("a region of the MPU"),
            _ => return unmodelled("a reserved register of the system control block"),
        }
        Ok(())
    }

    fn store_icsr(&mut self, value: u32) {
        for (set, clear, exception) in ICSR_PENDS {
            if value & set != 0 {
                self.pend(bit(exception));
            } else if value & clear != 0 {
                self.exceptions.priorities.unpend(bit(exception));
            }
        }
    }

    fn store_aircr(&mut self, value: u32) -> Result<(), Refused> {
        if value >> 16 != VECTKEY {
            return Ok(());
        }
        if value & VECTCLRACTIVE_VECTRESET != 0 {
            return unmodelled("AIRCR: VECTCLRACTIVE or VECTRESET, a debugger's bits");
        }
        self.exceptions.priorities.set_grouping((value >> 8) as u8);
        self.control.reset |= value & SYSRESETREQ != 0;
        Ok(())
    }

    fn store_shpr(&mut self, store: Store) {
        for (address, byte) in store.bytes() {
            let exception = (4 + address - 0xE000_ED18) as u16;
            // The others are reserved.
            if matches!(exception, 4..=6 | 11 | 12 | 14 | 15) {
                self.exceptions.priorities.set_priority(exception, byte);
            }
        }
    }

    fn store_shcsr(&mut self, value: u32) {
        let (active, inactive) = split(&SHCSR_ACTIVE, value);
        let (pending, idle) = split(&SHCSR_PENDING, value);
        let (enabled, disabled) = split(&SHCSR_ENABLED, value);
        let priorities = &mut self.exceptions.priorities;
        priorities.set_active(active, true);
        priorities.set_active(inactive, false);
        priorities.set_enabled(enabled, true);
        priorities.set_enabled(disabled, false);
        priorities.unpend(idle);
        self.pend(pending);
    }
}

/// ID_PFR0 to ID_ISAR4 (Cortex-M4 TRM, "System control register summary"), and the registers of
/// caches that are not there.
const fn identification(address: u32) -> Result<u32, Refused> {
    Ok(match address {
        0xE000_ED40 => 0x0000_0030,
        0xE000_ED44 => 0x0000_0200,
        0xE000_ED48 => 0x0010_0000,
        0xE000_ED60 => 0x0110_1110,
        0xE000_ED64 => 0x0211_2000,
        0xE000_ED68 => 0x2023_2231,
        0xE000_ED6C => 0x0111_1131,
        0xE000_ED70 => 0x0131_0132,
        // ID_AFR0, ID_MMFR1, ID_MMFR3, CLIDR.
        0xE000_ED4C | 0xE000_ED54 | 0xE000_ED5C | 0xE000_ED78 => 0,
        0xE000_ED50 | 0xE000_ED58 => {
            return unmodelled("ID_MMFR0 or ID_MMFR2, on which sources disagree");
        }
        0xE000_ED7C => return unmodelled("CTR"),
        0xE000_ED80 => return unmodelled("CCSIDR: there is no cache"),
        0xE000_ED84 => return unmodelled("CSSELR: there is no cache"),
        _ => return unmodelled("a reserved register of the system control block"),
    })
}
