//! Exception return (DDI 0403, B1.5.8).
//!
//! Tail-chaining takes the 6 cycles that ARM gives for it. For a return ARM publishes no figure
//! for this core; 10 are eight loads and the refill of the pipeline. Floating-point state costs a
//! cycle a word, unless it was never saved.

use super::super::Cpu;
use super::entry::{BASIC, EXTENDED, FP_OFFSET, FP_WORDS};
use super::fault::Fault;
use super::priorities::bit;
use crate::bus::Width;
use crate::cpu::fp::Fpscr;
use crate::memory::Memory;

const RETURN: u64 = 10;
const TAIL_CHAIN: u64 = 6;

/// The target of an EXC_RETURN.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Target {
    Handler,
    ThreadOnMain,
    ThreadOnProcess,
}

impl Target {
    /// The target of an EXC_RETURN; `None` for the values that the manual reserves.
    const fn of(exc_return: u32) -> Option<Self> {
        match exc_return | 0x10 {
            0xFFFF_FFF1 => Some(Self::Handler),
            0xFFFF_FFF9 => Some(Self::ThreadOnMain),
            0xFFFF_FFFD => Some(Self::ThreadOnProcess),
            _ => None,
        }
    }
}

impl Cpu {
    /// Executes a branch to an EXC_RETURN in handler mode.
    pub(crate) fn exception_return(&mut self, memory: &mut Memory, exc_return: u32) {
        let target = self.target(exc_return);
        self.exceptions.priorities.deactivate(self.special.ipsr);
        let Some(target) = target else {
            return self.fail_return(memory, exc_return, Fault::InvalidReturn { exc_return });
        };
        if self.exceptions.wants_in() {
            return self.tail_chain(memory, exc_return);
        }
        if let Err(fault) = self.pop_stack(memory, target, exc_return) {
            return self.fail_return(memory, exc_return, fault);
        }
        self.cycles += RETURN;
        self.exclusive = None;
        self.event = true;
        self.deadline = 0;
        if target != Target::Handler && self.exceptions.priorities.active() == 0 {
            self.sleep_on_exit();
        }
    }

    /// The target, if it is allowed: the exception is active, and thread mode is reached from the
    /// last one only, unless CCR.NONBASETHRDENA says otherwise.
    fn target(&self, exc_return: u32) -> Option<Target> {
        let active = self.exceptions.priorities.active();
        if active & bit(self.special.ipsr) == 0 {
            return None;
        }
        Target::of(exc_return).filter(|target| {
            *target == Target::Handler
                || active.count_ones() == 1
                || self.control.returns_to_thread_from_any()
        })
    }

    /// The frame stays where it is, and the next exception begins.
    fn tail_chain(&mut self, memory: &mut Memory, exc_return: u32) {
        self.cycles += TAIL_CHAIN;
        self.r[14] = exc_return;
        self.enter(memory);
    }

    /// The return has gone wrong: its frame stays where it is.
    fn fail_return(&mut self, memory: &mut Memory, exc_return: u32, fault: Fault) {
        self.raise(memory, fault);
        self.tail_chain(memory, exc_return);
    }

    /// PopStack(), with the change of mode and the check of IPSR that go with it. Nothing has
    /// changed where it fails.
    fn pop_stack(&mut self, memory: &Memory, target: Target, exc_return: u32) -> Result<(), Fault> {
        let on_process = target == Target::ThreadOnProcess;
        let frame = if on_process { self.other_sp } else { self.r[13] };
        let mut words = [0; 8];
        read(memory, frame, &mut words).ok_or(Fault::Unstacking)?;
        let [r0, r1, r2, r3, r12, lr, pc, psr] = words;
        if (psr & 0x1FF == 0) == (target == Target::Handler) {
            return Err(Fault::InvalidReturn { exc_return });
        }
        let extended = exc_return & 0x10 == 0;
        if extended {
            self.pop_fp(memory, frame.wrapping_add(FP_OFFSET), target)?;
        }
        let (size, force) = match extended {
            true => (EXTENDED, true),
            false => (BASIC, self.control.aligns_stack()),
        };
        let realigned = if force { psr >> 7 & 4 } else { 0 };
        let top = frame.wrapping_add(size) | realigned;
        self.r[..4].copy_from_slice(&[r0, r1, r2, r3]);
        self.r[12] = r12;
        self.r[14] = lr;
        self.r[15] = pc & !1;
        self.set_xpsr(psr);
        self.special.fpca = extended;
        self.select_stack(on_process);
        self.r[13] = top;
        self.weigh_fpu();
        Ok(())
    }

    /// Floating-point state: what was never saved is still in the registers.
    fn pop_fp(&mut self, memory: &Memory, address: u32, target: Target) -> Result<(), Fault> {
        if self.control.fp.saving() {
            self.control.fp.forget_save();
            return Ok(());
        }
        let privileged = target == Target::Handler || !self.special.unprivileged;
        if !self.control.fp.allowed(privileged) {
            return Err(Fault::NoCoprocessor);
        }
        let mut words = [0; 17];
        read(memory, address, &mut words).ok_or(Fault::Unstacking)?;
        self.fpu.s[..16].copy_from_slice(&words[..16]);
        self.fpu.fpscr = Fpscr::from_bits(words[16]);
        self.cycles += FP_WORDS;
        Ok(())
    }
}

fn read(memory: &Memory, address: u32, words: &mut [u32]) -> Option<()> {
    for (word, address) in words.iter_mut().zip((address..).step_by(4)) {
        *word = memory.load(address, Width::Word)?;
    }
    Some(())
}
