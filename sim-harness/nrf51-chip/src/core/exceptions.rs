//! Entry to and return from exceptions (ARMv6-M Architecture Reference Manual, B1.5.6 to B1.5.8).

use super::nvic::SUPERVISOR_CALL;
use super::{Cause, Core, Fault, Flags, Memory, Width, cycles};

/// The addresses from which on a branch in a handler is a return.
pub(super) const EXCEPTION_RETURN: u32 = 0xF000_0000;
/// The returns: to a handler, to the program on the main stack, and on the process stack.
const HANDLER: u32 = 0xFFFF_FFF1;
const THREAD_MAIN: u32 = 0xFFFF_FFF9;
const THREAD_PROCESS: u32 = 0xFFFF_FFFD;

/// The words that are saved: R0 to R3, R12, LR, the return address, xPSR.
const SAVED: [usize; 6] = [0, 1, 2, 3, 12, 14];
const FRAME: u32 = 32;
/// xPSR: the code is Thumb code; the stack was aligned by a word.
const THUMB: u32 = 1 << 24;
const REALIGNED: u32 = 1 << 9;

impl Core {
    /// xPSR.
    pub(super) fn status(&self) -> u32 {
        let Flags { n, z, c, v } = self.flags;
        let flags = [(n, 31), (z, 30), (c, 29), (v, 28)];
        let flags = flags.iter().fold(0, |all, (is, bit)| all | u32::from(*is) << bit);
        flags | THUMB | u32::from(self.nvic.current())
    }

    pub(super) fn set_flags_of(&mut self, status: u32) {
        let is = |bit: u32| status >> bit & 1 != 0;
        self.flags = Flags { n: is(31), z: is(30), c: is(29), v: is(28) };
    }

    /// Whether the program runs on the process stack.
    pub(super) fn is_on_process_stack(&self) -> bool {
        self.process_stack && self.nvic.current() == 0
    }

    /// Enters the handler of the exception that is due.
    #[cold]
    pub(super) fn enter_due(&mut self, memory: &mut impl Memory) -> Result<u32, Fault> {
        let Some(exception) = self.nvic.ready() else { return Ok(0) };
        let status = self.status();
        let (link, to_main) = if self.nvic.current() != 0 {
            (HANDLER, false)
        } else if self.process_stack {
            (THREAD_PROCESS, true)
        } else {
            (THREAD_MAIN, false)
        };
        let realigned = self.registers[13] & 4 != 0;
        self.registers[13] = (self.registers[13] - FRAME) & !7;
        let frame = self.registers[13];
        let status = if realigned { status | REALIGNED } else { status };
        let words = SAVED.map(|it| self.registers[it]);
        let words = words.into_iter().chain([self.registers[15], status]);
        for (word, address) in words.zip((frame..).step_by(4)) {
            self.store(memory, address, Width::Word, word)?;
        }
        if to_main {
            std::mem::swap(&mut self.registers[13], &mut self.other_stack);
        }
        self.registers[14] = link;
        self.nvic.enter(exception);
        let vector = self.vectors + u32::from(exception) * 4;
        let handler = self.load(memory, vector, Width::Word)?;
        self.branch(handler)?;
        Ok(cycles::ENTRY)
    }

    /// Returns from a handler, to where `link` says.
    #[cold]
    pub(super) fn leave(&mut self, memory: &mut impl Memory, link: u32) -> Result<u32, Fault> {
        let to_process = link == THREAD_PROCESS;
        let fits = match link {
            HANDLER => self.nvic.is_nested(),
            THREAD_MAIN | THREAD_PROCESS => !self.nvic.is_nested(),
            _ => false,
        };
        if !fits {
            return Self::fault(self.registers[15], Cause::NotThumb(link));
        }
        self.nvic.leave();
        self.process_stack = if link == HANDLER { self.process_stack } else { to_process };
        if to_process {
            std::mem::swap(&mut self.registers[13], &mut self.other_stack);
        }
        let frame = self.registers[13];
        for (register, address) in SAVED.into_iter().zip((frame..).step_by(4)) {
            self.registers[register] = self.load(memory, address, Width::Word)?;
        }
        let back = self.load(memory, frame + 24, Width::Word)?;
        let status = self.load(memory, frame + 28, Width::Word)?;
        let realigned = if status & REALIGNED != 0 { 4 } else { 0 };
        self.registers[13] = frame + FRAME + realigned;
        self.registers[15] = back & !1;
        self.set_flags_of(status);
        Ok(cycles::RETURN)
    }

    /// SVC: its handler runs before the next instruction, or the core faults.
    pub(super) fn call_supervisor(&mut self, pc: u32) -> Result<(), Fault> {
        if self.masked || !self.nvic.call() {
            return Self::fault(pc, Cause::MaskedCall);
        }
        debug_assert_eq!(self.nvic.ready(), Some(SUPERVISOR_CALL));
        Ok(())
    }
}
