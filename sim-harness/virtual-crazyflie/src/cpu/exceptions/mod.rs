//! Exceptions (DDI 0403, B1.5).
//!
//! | module | what it holds |
//! |---|---|
//! | [`priorities`] | what is pending, active and enabled, and what may come in |
//! | [`entry`] | stacking and taking an exception |
//! | [`exit`] | returning from one |
//! | [`fault`] | what can go wrong, and what becomes of it |
//! | [`report`] | what is kept of it, in words |
//!
//! Exceptions are taken between instructions. A late arrival is the case in which something of
//! higher priority became pending in the same instruction: the highest is taken first, and the
//! other follows by tail-chaining.

mod entry;
mod exit;
mod fault;
pub(crate) mod priorities;
mod report;

pub(crate) use entry::FP_WORDS;
pub(in crate::cpu) use entry::Ready;
pub use fault::Fault;
pub(crate) use fault::{cfsr, hfsr};
pub(crate) use priorities::Priorities;
pub use report::FaultReport;

use super::Cpu;
use super::Sleep;
use crate::memory::Memory;
use priorities::number::{HARD_FAULT, SV_CALL};
use report::Reports;

/// Which exceptions are pending, active and enabled, and what has gone wrong so far.
#[derive(Clone, Debug)]
pub(crate) struct Exceptions {
    pub(crate) priorities: Priorities,
    reports: Reports,
    locked: bool,
}

impl Exceptions {
    /// The state after a reset, with no fault seen yet.
    pub(crate) fn new() -> Self {
        Self { priorities: Priorities::default(), reports: Reports::default(), locked: false }
    }

    /// Whether a pending exception has a higher priority than the running code.
    #[inline(always)]
    pub(crate) const fn wants_in(&self) -> bool {
        self.priorities.wants_in()
    }

    /// The core is locked up (B1.5.15): it executes nothing any more.
    #[inline(always)]
    pub(crate) const fn locked_up(&self) -> bool {
        self.locked
    }
}

impl Cpu {
    /// Makes exceptions pending: a set in which bit n stands for exception n.
    pub(super) fn pend(&mut self, set: u128) {
        let new = self.exceptions.priorities.pend(set);
        self.pended(new);
    }

    /// The levels of the interrupt lines, bit 0 for interrupt 0.
    #[inline]
    pub(crate) fn set_lines(&mut self, lines: u128) {
        if !self.exceptions.priorities.has_lines(lines) {
            let new = self.exceptions.priorities.set_lines(lines);
            self.pended(new);
        }
    }

    /// To be called when an exception has become pending, or is not any more.
    fn pended(&mut self, new: bool) {
        if new {
            self.event |= self.control.sends_event_on_pend();
            self.deadline = 0;
        }
    }

    /// SVC. The program counter is already behind the instruction.
    pub(crate) fn svc(&mut self, memory: &mut Memory, number: u8) {
        if self.exceptions.priorities.may_enter(SV_CALL) {
            self.pend(priorities::bit(SV_CALL));
        } else {
            // The return address of an escalated SVC is its own.
            self.r[15] = self.r[15].wrapping_sub(2);
            self.fault(memory, Fault::Supervisor { number });
        }
    }

    /// Whether something is pending that ends WFI: what would come in, PRIMASK left aside.
    pub(crate) fn wakes_wfi(&self) -> bool {
        self.exceptions.priorities.wakes()
    }

    /// Everything that a reset does to the core, but for its vector.
    fn reset_state(&mut self) {
        self.r = [0; 16];
        self.other_sp = 0;
        self.flags = super::Flags::default();
        self.it = 0;
        self.thumb = true;
        self.abort = None;
        self.fpu = super::Fpu { s: [0; 32], fpscr: super::Fpscr::default(), ready: false };
        self.special = super::Special::default();
        self.exceptions.priorities = Priorities::default();
        self.exceptions.locked = false;
        self.control.reset();
        self.exclusive = None;
        self.event = false;
        self.asleep = None;
        self.deadline = 0;
    }

    /// As a bootloader leaves the core when it jumps to an image: SP and PC from the vector table
    /// at `table`, VTOR still zero. Registers that a reset leaves unknown are zero. Where no table
    /// can be read, the core is locked up.
    pub fn reset_core(&mut self, memory: &Memory, table: u32) {
        self.reset_state();
        let word = |offset| memory.load(table.wrapping_add(offset), crate::bus::Width::Word);
        if let (Some(sp), Some(start)) = (word(0), word(4)) {
            self.r[13] = sp & !3;
            self.r[14] = u32::MAX;
            self.r[15] = start & !1;
            self.thumb = start & 1 != 0;
        } else {
            self.lock_up(memory, Fault::VectorTable { exception: 1 });
        }
    }

    /// Starts an image as the vendor's bootloader does after a reset: from the image's vector table,
    /// which it also sets as VTOR (crazyflie2-stm-bootloader, `main.c`: `NVIC_SetVectorTable`).
    pub fn boot(&mut self, memory: &Memory, table: u32) {
        self.reset_core(memory, table);
        self.control.set_vtor(table);
    }

    /// Sleep-on-exit (B1.5.19): as if WFI followed the return.
    fn sleep_on_exit(&mut self) {
        if self.control.sleeps_on_exit() {
            self.asleep = Some(Sleep::Interrupt);
            self.deadline = 0;
        }
    }

    /// The core is locked up and waits for a reset.
    fn lock_up(&mut self, memory: &Memory, fault: Fault) {
        self.report(memory, fault, None);
        self.exceptions.locked = true;
        self.deadline = 0;
    }

    /// The exception that is waiting, or HardFault where something has gone wrong with it.
    fn next_exception(&self) -> u16 {
        self.exceptions.priorities.best().unwrap_or(HARD_FAULT)
    }
}

#[cfg(test)]
mod tests;
