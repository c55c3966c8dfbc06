//! Exception entry (DDI 0403, B1.5.6 and B1.5.7).
//!
//! Its cycles are those of the Cortex-M4 TRM where there is no wait state: 12 for entry, and one
//! for each of the 17 words of floating-point state that are not saved lazily.

use super::super::Cpu;
use super::fault::Fault;
use super::priorities::number::{BUS_FAULT, DEBUG_MONITOR, HARD_FAULT, MEM_MANAGE};
use crate::bus::Width;
use crate::memory::Memory;

/// The cycles from the request to the first instruction of the handler.
const ENTRY: u64 = 12;
/// S0 to S15 and FPSCR.
pub(crate) const FP_WORDS: u64 = 17;
/// A frame without floating-point state, in bytes.
pub(super) const BASIC: u32 = 0x20;
/// A frame with it.
pub(super) const EXTENDED: u32 = 0x68;
/// The offset of that state in the frame.
pub(super) const FP_OFFSET: u32 = 0x20;

/// Which exceptions could have come in when room was left for floating-point state.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "they are four bits of a register")]
pub(in crate::cpu) struct Ready {
    pub(in crate::cpu) hard_fault: bool,
    pub(in crate::cpu) bus_fault: bool,
    pub(in crate::cpu) mem_manage: bool,
    pub(in crate::cpu) monitor: bool,
}

impl Cpu {
    /// Entry of the highest pending exception.
    pub(crate) fn take_exception(&mut self, memory: &mut Memory) {
        if self.exceptions.priorities.best().is_none() {
            return;
        }
        self.cycles += ENTRY;
        if let Err(fault) = self.push_stack(memory) {
            // A derived exception. It is taken instead, if it is the higher of the two; if not, it
            // waits. Compared with what is interrupted, it may have to escalate (B1.5.11).
            self.raise(memory, fault);
        }
        self.enter(memory);
    }

    /// PushStack(), and LR.
    fn push_stack(&mut self, memory: &mut Memory) -> Result<(), Fault> {
        let extended = self.special.fpca;
        let (size, force) = match extended {
            true => (EXTENDED, true),
            false => (BASIC, self.control.aligns_stack()),
        };
        let top = self.r[13];
        let realigned = force && top & 4 != 0;
        let frame = top.wrapping_sub(size) & if force { !4 } else { !0 };
        self.r[13] = frame;
        let words = [
            self.r[0],
            self.r[1],
            self.r[2],
            self.r[3],
            self.r[12],
            self.r[14],
            self.r[15],
            self.xpsr() & !0x200 | u32::from(realigned) << 9,
        ];
        self.r[14] = self.exc_return();
        let stored = words
            .into_iter()
            .zip((frame..).step_by(4))
            .all(|(word, address)| memory.store(address, Width::Word, word));
        if !stored {
            return Err(Fault::Stacking);
        }
        if extended && self.control.fp.saves_lazily() {
            self.defer_save(frame.wrapping_add(FP_OFFSET));
        } else if extended {
            if !self.fpu_allowed() {
                return Err(Fault::NoCoprocessor);
            }
            self.cycles += FP_WORDS;
            if !self.store_fp(memory, frame.wrapping_add(FP_OFFSET)) {
                return Err(Fault::Stacking);
            }
        }
        Ok(())
    }

    /// The EXC_RETURN to the present mode, stack and kind of frame.
    fn exc_return(&self) -> u32 {
        let frame = if self.special.fpca { 0xFFFF_FFE0 } else { 0xFFFF_FFF0 };
        frame
            | match (self.special.ipsr, self.special.process_stack) {
                (0, false) => 0x9,
                (0, true) => 0xD,
                _ => 0x1,
            }
    }

    /// UpdateFPCCR(): room is left for the floating-point state, and noted what a fault would
    /// become if it arose when the state is saved.
    fn defer_save(&mut self, address: u32) {
        let ready = |exception| self.exceptions.priorities.may_enter(exception);
        let ready = Ready {
            hard_fault: self.exceptions.priorities.execution() > -1,
            bus_fault: ready(BUS_FAULT),
            mem_manage: ready(MEM_MANAGE),
            monitor: ready(DEBUG_MONITOR),
        };
        let (thread, user) = (self.special.ipsr == 0, !self.special.privileged());
        self.control.fp.defer(address, ready, thread, user);
        self.weigh_fpu();
    }

    /// S0 to S15 and FPSCR, to where room is for them. False where there is none.
    pub(in crate::cpu) fn store_fp(&self, memory: &mut Memory, address: u32) -> bool {
        let low = self.fpu.s[..16].iter().copied();
        low.chain([self.fpu.fpscr.bits()])
            .zip((address..).step_by(4))
            .all(|(word, address)| memory.store(address, Width::Word, word))
    }

    /// ExceptionTaken() of what is pending and highest. The context is on the stack, LR is set.
    pub(super) fn enter(&mut self, memory: &mut Memory) {
        if self.exceptions.locked {
            return;
        }
        let wanted = self.next_exception();
        let (exception, vector) = match self.vector(memory, wanted) {
            Some(vector) => (wanted, vector),
            None if wanted > HARD_FAULT => {
                self.raise(memory, Fault::VectorTable { exception: wanted });
                match self.vector(memory, HARD_FAULT) {
                    Some(vector) => (HARD_FAULT, vector),
                    None => {
                        let fault = Fault::VectorTable { exception: HARD_FAULT };
                        return self.lock_up(memory, fault);
                    }
                }
            }
            None => return self.lock_up(memory, Fault::VectorTable { exception: wanted }),
        };
        self.exceptions.priorities.activate(exception);
        self.select_stack(false);
        self.special.ipsr = exception;
        self.special.fpca = false;
        self.weigh_fpu();
        self.it = 0;
        self.r[15] = vector & !1;
        self.thumb = vector & 1 != 0;
        self.exclusive = None;
        self.event = true;
        self.deadline = 0;
    }

    fn vector(&self, memory: &Memory, exception: u16) -> Option<u32> {
        memory.load(self.control.vtor().wrapping_add(4 * u32::from(exception)), Width::Word)
    }
}
