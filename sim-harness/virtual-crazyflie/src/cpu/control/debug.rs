//! Debug and trace, as software on the core sees them (DDI 0403, C1).
//!
//! The cycle counter does not count while the core sleeps. The manual leaves it to the chip; on an
//! STM32F405 the core's HCLK, which clocks it, is off in sleep mode unless DBGMCU_CR.DBG_SLEEP is
//! set (RM0090, "Debug support for low-power modes"): [`Cpu::set_counts_in_sleep`].

use super::{Store, unmodelled};
use crate::bus::Refused;
use crate::cpu::Cpu;
use crate::cpu::exceptions::priorities::{bit, number};

/// The stimulus ports of the instrumentation trace, ITM_STIM0 to ITM_STIM31.
pub(super) const STIMULUS: u32 = 0xE000_0000;
pub(super) const STIMULUS_END: u32 = 0xE000_0080;
const DWT_CTRL: u32 = 0xE000_1000;
const DWT_CYCCNT: u32 = 0xE000_1004;
/// The lock that Cortex-M4 has not got. Software that also runs on a Cortex-M7 opens it.
const DWT_LAR: u32 = 0xE000_1FB0;
const DWT_LSR: u32 = 0xE000_1FB4;
const DHCSR: u32 = 0xE000_EDF0;
const DEMCR: u32 = 0xE000_EDFC;

/// Four comparators, and nothing left out.
const DWT_CTRL_RESET: u32 = 4 << 28;
const CYCCNTENA: u32 = 1;

const TRCENA: u32 = 1 << 24;
const MON_REQ: u32 = 1 << 19;
const MON_STEP: u32 = 1 << 18;
const MON_PEND: u32 = 1 << 17;
const MON_EN: u32 = 1 << 16;
/// Vector catch: it needs a debugger to do anything.
const VECTOR_CATCH: u32 = 0x07F1;

/// S_RETIRE_ST and S_REGRDY.
const DHCSR_READS: u32 = 1 << 24 | 1 << 16;

/// C_DEBUGEN: a debugger is attached.
const C_DEBUGEN: u32 = 1;

/// DEMCR and the cycle counter.
#[derive(Clone, Debug, Default)]
pub(super) struct Debug {
    /// DEMCR, but for MON_EN and MON_PEND, which are kept where exceptions are.
    demcr: u32,
    counts: bool,
    /// CYCCNT at `since`.
    cyccnt: u32,
    /// On the clock that it counts.
    since: u64,
    /// Its clock goes on in sleep.
    in_sleep: bool,
    /// A debugger is attached.
    debugger: bool,
}

/// A stimulus port of a trace that is disabled has no room (C1.7.3, FIFOREADY). Stores to it are
/// ignored, which firmware that is sometimes traced relies on.
pub(super) const fn load_stimulus() -> u32 {
    0
}

impl Debug {
    /// CYCCNT at a cycle of its clock.
    const fn count(&self, clock: u64) -> u32 {
        let passed = if self.counts { clock.wrapping_sub(self.since) as u32 } else { 0 };
        self.cyccnt.wrapping_add(passed)
    }

    /// Begins anew from a value.
    const fn restart(&mut self, value: u32, counts: bool, clock: u64) {
        self.cyccnt = value;
        self.counts = counts;
        self.since = clock;
    }

    pub(super) fn after_reset(&self) -> Self {
        Self { in_sleep: self.in_sleep, debugger: self.debugger, ..Self::default() }
    }
}

impl Cpu {
    /// Attaches a debugger, or detaches it: DHCSR.C_DEBUGEN, which outlasts resets.
    pub const fn set_debugger(&mut self, is_attached: bool) {
        self.control.debug.debugger = is_attached;
    }

    /// Whether the cycle counter goes on while the core sleeps: DBGMCU_CR.DBG_SLEEP.
    pub const fn set_counts_in_sleep(&mut self, on: bool) {
        let before = self.control.debug.count(self.trace_clock());
        self.control.debug.in_sleep = on;
        let clock = self.trace_clock();
        let debug = &mut self.control.debug;
        debug.restart(before, debug.counts, clock);
    }

    const fn trace_clock(&self) -> u64 {
        if self.control.debug.in_sleep { self.cycles } else { self.cycles.wrapping_sub(self.slept) }
    }

    /// Without TRCENA its registers read as anything, and take nothing (C1.6.5).
    fn dwt_enabled(&self) -> Result<(), Refused> {
        if self.control.debug.demcr & TRCENA == 0 {
            return unmodelled("DWT, without DEMCR.TRCENA");
        }
        Ok(())
    }

    pub(super) fn load_dwt(&self, address: u32) -> Result<u32, Refused> {
        if address == DWT_LSR {
            return Ok(0);
        }
        self.dwt_enabled()?;
        let debug = &self.control.debug;
        match address {
            DWT_CTRL => Ok(DWT_CTRL_RESET | u32::from(debug.counts)),
            DWT_CYCCNT => Ok(debug.count(self.trace_clock())),
            // They cannot be set.
            0xE000_1020..=0xE000_105C => Ok(0),
            _ => unmodelled("DWT: a register other than DWT_CTRL and DWT_CYCCNT"),
        }
    }

    pub(super) fn store_dwt(&mut self, store: Store) -> Result<(), Refused> {
        if store.address == DWT_LAR {
            return Ok(());
        }
        self.dwt_enabled()?;
        let clock = self.trace_clock();
        let debug = &mut self.control.debug;
        match store.address {
            DWT_CTRL if store.value & !DWT_CTRL_RESET & !CYCCNTENA == 0 => {
                debug.restart(debug.count(clock), store.value & CYCCNTENA != 0, clock);
                Ok(())
            }
            DWT_CTRL => unmodelled("DWT_CTRL: a bit other than CYCCNTENA"),
            DWT_CYCCNT => {
                debug.restart(store.value, debug.counts, clock);
                Ok(())
            }
            0xE000_1020..=0xE000_105C if store.value == 0 => Ok(()),
            0xE000_1020..=0xE000_105C => unmodelled("DWT: a comparator"),
            _ => unmodelled("DWT: a register other than DWT_CTRL and DWT_CYCCNT"),
        }
    }

    pub(super) fn load_debug(&self, address: u32) -> Result<u32, Refused> {
        match address {
            DHCSR if self.control.debug.debugger => Ok(DHCSR_READS | C_DEBUGEN),
            DHCSR => Ok(DHCSR_READS),
            DEMCR => Ok(self.demcr()),
            _ => unmodelled("DCRSR or DCRDR, a debugger's registers"),
        }
    }

    fn demcr(&self) -> u32 {
        let priorities = &self.exceptions.priorities;
        let when = |set: u128, flag| {
            if set & bit(number::DEBUG_MONITOR) == 0 { 0 } else { flag }
        };
        self.control.debug.demcr
            | when(priorities.enabled(), MON_EN)
            | when(priorities.pending(), MON_PEND)
    }

    pub(super) fn store_debug(&mut self, store: Store) -> Result<(), Refused> {
        match store.address {
            // Software on the core cannot do what a debugger can (C1.6.2).
            DHCSR => Ok(()),
            DEMCR if store.value & MON_STEP != 0 => unmodelled("DEMCR.MON_STEP"),
            DEMCR => {
                let monitor = bit(number::DEBUG_MONITOR);
                let traced = store.value & TRCENA != 0;
                if !traced && self.control.debug.counts {
                    return unmodelled("DEMCR.TRCENA cleared while DWT_CYCCNT counts");
                }
                self.control.debug.demcr = store.value & (TRCENA | MON_REQ | VECTOR_CATCH);
                self.exceptions.priorities.set_enabled(monitor, store.value & MON_EN != 0);
                if store.value & MON_PEND != 0 {
                    self.pend(monitor);
                } else {
                    self.exceptions.priorities.unpend(monitor);
                }
                Ok(())
            }
            _ => unmodelled("DCRSR or DCRDR, a debugger's registers"),
        }
    }
}
