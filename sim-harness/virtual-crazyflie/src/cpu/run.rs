//! The run loop: advances what is due, takes exceptions, sleeps or executes.
//!
//! Instructions are executed until a deadline in cycles and nothing else is asked in between.
//! A change to what may be pending sets the deadline to zero, so that the loop looks at once.

use super::abort::Abort;
use super::decode::{decode, is_wide};
use super::exceptions::Fault;
use super::execute::{Alone, Following};
use super::op::{Kind, Op};
use super::program::advanced;
use super::{Cpu, Program, Sleep};
use crate::bus::{Bus, Refused, Width};
use crate::memory::Memory;

/// Why the core stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The cycle has come, or has just passed.
    Until,
    /// The next instruction has a trap on it. [`Cpu::step`] goes past it.
    Trap,
    /// A reset is requested: the core (AIRCR.SYSRESETREQ) or the bus.
    Reset,
    /// The next instruction is a BKPT.
    Breakpoint,
    /// A fault while a fault was dealt with: it will never execute anything again.
    Lockup,
    /// The next instruction accesses something that is not modelled.
    Refused {
        /// The address.
        address: u32,
        /// Whether it is a store.
        store: bool,
        /// The size of the access.
        width: Width,
        /// The name of the part that is not modelled.
        why: Refused,
    },
    /// The manual does not say what the next instruction does (UNPREDICTABLE).
    Unpredictable {
        /// Its bits; of 32 the first half is the upper one.
        encoding: u32,
    },
}

impl Cpu {
    /// Executes up to the cycle `until` or a little beyond: an instruction is finished.
    pub fn run<B: Bus>(
        &mut self,
        program: &Program,
        memory: &mut Memory,
        bus: &mut B,
        until: u64,
    ) -> Stop {
        loop {
            if let Some(stop) = self.attend(memory, bus, until) {
                return stop;
            }
            if self.it != 0 {
                self.execute_it_block(program, memory, bus);
            }
            if self.timing.is_ideal() {
                self.execute_program::<B, false>(program, memory, bus);
            } else {
                self.execute_program::<B, true>(program, memory, bus);
            }
            if let Some(stop) = self.settle(memory) {
                return stop;
            }
        }
    }

    /// Executes one instruction, whether or not a trap is on it; before it, whatever is due
    /// happens and what is pending comes in. [`Stop::Until`] says that nothing was in the way.
    /// While the core sleeps, it only sleeps, and at most to `until`.
    pub fn step<B: Bus>(
        &mut self,
        program: &Program,
        memory: &mut Memory,
        bus: &mut B,
        until: u64,
    ) -> Stop {
        let here = self.r[15];
        if let Some(stop) = self.attend(memory, bus, until) {
            return stop;
        }
        // A handler that has just been entered begins with an instruction that no trap has reported
        // yet.
        if self.r[15] != here && program.is_trapped(self.r[15]) {
            return Stop::Trap;
        }
        let op = program.alone(program.real_op(program.place(self.r[15])));
        self.execute_alone(op, program, memory, bus);
        self.settle(memory).unwrap_or(Stop::Until)
    }

    /// Everything that is asked between stretches of instructions. Afterwards the core is awake and
    /// has a deadline.
    fn attend<B: Bus>(&mut self, memory: &mut Memory, bus: &mut B, until: u64) -> Option<Stop> {
        loop {
            if bus.due() <= self.cycles {
                bus.advance(memory, self.cycles);
            }
            if self.system_due() <= self.cycles {
                self.system_advance();
            }
            self.set_lines(bus.lines());
            if self.wants_reset() || bus.resets() {
                return Some(Stop::Reset);
            }
            if self.exceptions.locked_up() {
                return Some(Stop::Lockup);
            }
            if self.cycles >= until {
                return Some(Stop::Until);
            }
            let next = until.min(bus.due()).min(self.system_due());
            if let Some(sleep) = self.asleep {
                if !self.wakes(sleep) {
                    let next = next.max(self.cycles + 1);
                    self.slept += next - self.cycles;
                    self.cycles = next;
                    continue;
                }
                self.asleep = None;
            }
            if self.exceptions.wants_in() {
                self.take_exception(memory);
                continue;
            }
            if !self.thumb {
                self.fault(memory, Fault::InvalidState);
                continue;
            }
            self.timing.set_wait_states(bus.flash_wait_states());
            self.deadline = next;
            return None;
        }
    }

    /// DDI 0403, B1.5.18 and B1.5.19.
    fn wakes(&mut self, sleep: Sleep) -> bool {
        match sleep {
            Sleep::Interrupt => self.wakes_wfi(),
            Sleep::Event => {
                let event = std::mem::take(&mut self.event);
                event || self.exceptions.wants_in()
            }
        }
    }

    /// Acts on the event that has interrupted an instruction.
    fn settle(&mut self, memory: &mut Memory) -> Option<Stop> {
        match self.abort.take()? {
            Abort::Fault(fault) => {
                self.fault(memory, fault);
                None
            }
            Abort::Trap => Some(Stop::Trap),
            Abort::Breakpoint => Some(Stop::Breakpoint),
            Abort::Refused { address, store, width, why } => {
                Some(Stop::Refused { address, store, width, why })
            }
            Abort::Unpredictable => {
                let half = |address| memory.load(address, Width::Half).unwrap_or(0);
                let first = half(self.r[15]);
                let encoding = if is_wide(first as u16) {
                    first << 16 | half(self.r[15].wrapping_add(2))
                } else {
                    first
                };
                Some(Stop::Unpredictable { encoding })
            }
        }
    }

    fn execute_program<B: Bus, const FLASH: bool>(
        &mut self,
        program: &Program,
        memory: &mut Memory,
        bus: &mut B,
    ) {
        let mut position = Following::at(self.r[15], program);
        let mut last = position;
        let mut executed = 0;
        while self.cycles < self.deadline {
            let op = program.op(position.place);
            if FLASH {
                self.fetch_line(op.line);
            }
            last = position;
            position.advance();
            executed += 1;
            self.execute(op, &mut position, program, memory, bus);
        }
        self.instructions = self.instructions.wrapping_add(executed);
        if std::mem::take(&mut self.abandoned) {
            position = last;
        }
        position.leave(self, program);
    }

    /// The core waits for the line that the next instruction lies in, unless the last one lay there.
    #[inline(always)]
    fn fetch_line(&mut self, line: u16) {
        if line != self.timing.line() {
            self.cycles += self.timing.fetch(line, self.cycles);
        }
    }

    /// The rest of an IT block, or as much of it as there is time for.
    #[inline(never)]
    pub(super) fn execute_it_block<B: Bus>(
        &mut self,
        program: &Program,
        memory: &mut Memory,
        bus: &mut B,
    ) {
        while self.it != 0 && self.cycles < self.deadline {
            let op = program.alone(program.op(program.place(self.r[15])));
            self.execute_alone(op, program, memory, bus);
        }
    }

    /// One instruction, in an IT block or not.
    #[inline]
    fn execute_alone<B: Bus>(
        &mut self,
        op: Op,
        program: &Program,
        memory: &mut Memory,
        bus: &mut B,
    ) {
        self.fetch_line(op.line);
        let it = self.it;
        match op.kind {
            Kind::Outside => self.execute_outside(program, memory, bus),
            Kind::It | Kind::Block if it != 0 => self.abort(Abort::Unpredictable),
            Kind::It => {
                self.it = op.imm as u8;
                self.skip(&op);
            }
            Kind::Block => {
                self.it = op.d;
                self.skip(&op);
            }
            _ if it == 0 || op.kind == Kind::Trap => {
                self.execute_once(&op, program, memory, bus);
            }
            // A7.3.3. What returns from an exception sets ITSTATE, so it is moved on before.
            _ => {
                self.it = advanced(it);
                if !self.passes(it >> 4) {
                    self.skip(&op);
                } else if !self.execute_once(&op.in_it(), program, memory, bus) {
                    self.it = it;
                }
            }
        }
    }

    /// An instruction takes its cycle and does nothing.
    fn skip(&mut self, op: &Op) {
        self.r[15] = self.r[15].wrapping_add(u32::from(op.len));
        self.cycles += 1;
        self.instructions = self.instructions.wrapping_add(1);
    }

    /// ConditionPassed (A7.3.1).
    #[inline(always)]
    pub(super) const fn passes(&self, condition: u8) -> bool {
        let flags = &self.flags;
        let nzcv =
            (flags.n as u8) << 3 | (flags.z as u8) << 2 | (flags.c as u8) << 1 | flags.v as u8;
        PASSES[(condition & 15) as usize] >> nzcv & 1 != 0
    }

    /// The instruction at the program counter, which is not part of the program: in RAM, say.
    #[cold]
    #[inline(never)]
    pub(super) fn execute_outside<B: Bus>(
        &mut self,
        program: &Program,
        memory: &mut Memory,
        bus: &mut B,
    ) {
        let address = self.r[15];
        let fetched = fetch(memory, address).and_then(|first| {
            let second = if is_wide(first) { fetch(memory, address.wrapping_add(2))? } else { 0 };
            Ok((first, second))
        });
        match fetched {
            Ok((first, second)) => {
                self.execute_alone(decode(address, first, second), program, memory, bus);
            }
            Err(fault) => self.abort(Abort::Fault(fault)),
        }
    }

    /// Abandons the instruction at the program counter.
    #[cold]
    pub(super) fn abort(&mut self, abort: Abort) {
        self.abort = Some(abort);
        self.deadline = 0;
    }

    /// Executes one instruction; false if it was abandoned.
    #[inline(never)]
    fn execute_once<B: Bus>(
        &mut self,
        op: &Op,
        program: &Program,
        memory: &mut Memory,
        bus: &mut B,
    ) -> bool {
        let address = self.r[15];
        let mut position = Alone { next: address.wrapping_add(u32::from(op.len)) };
        self.instructions = self.instructions.wrapping_add(1);
        self.execute(op, &mut position, program, memory, bus);
        let abandoned = std::mem::take(&mut self.abandoned);
        self.r[15] = if abandoned { address } else { position.next };
        !abandoned
    }
}

/// Half an instruction. Peripherals and the system's own space are not executed (B3.1).
fn fetch(memory: &Memory, address: u32) -> Result<u16, Fault> {
    match memory.load(address, Width::Half) {
        Some(half) => Ok(half as u16),
        None if matches!(address >> 29, 0b010 | 0b101..) => Err(Fault::ExecuteNever { address }),
        None => Err(Fault::FetchBus { address }),
    }
}

/// The states of N, Z, C and V that pass each condition, as a set of sixteen bits.
const PASSES: [u16; 16] = {
    let mut passes = [0; 16];
    let mut state = 0;
    while state < 16 {
        let (n, z) = (state & 8 != 0, state & 4 != 0);
        let (c, v) = (state & 2 != 0, state & 1 != 0);
        let positive = [z, c, n, v, c && !z, n == v, n == v && !z];
        let mut condition = 0;
        while condition < 14 {
            if positive[condition / 2] != (condition & 1 != 0) {
                passes[condition] |= 1 << state;
            }
            condition += 1;
        }
        passes[14] |= 1 << state;
        passes[15] |= 1 << state;
        state += 1;
    }
    passes
};
