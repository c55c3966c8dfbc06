//! The core's position in its program, while instructions are executed.

use crate::cpu::op::Kind;
use crate::cpu::timing::REFILL;
use crate::cpu::{Cpu, Program};

/// The position of an instruction, for the instructions that need it.
pub(in crate::cpu) trait Position {
    /// The address of the instruction behind this one.
    fn next(&self, program: &Program) -> u32;
    /// Goes on at the fixed target of a branch.
    fn branch(&mut self, target: u32);
    /// Goes on at the address in R15.
    fn resume(&mut self, cpu: &mut Cpu, program: &Program);
    /// Goes back to this instruction, and sets R15 to its address.
    fn retreat(&mut self, cpu: &mut Cpu, program: &Program);
    /// Goes on at a place in the program.
    fn follow(&mut self, place: u32);
    /// Goes on after so many instructions.
    fn pass(&mut self, count: u8);
    /// The branch that stands here is executed, too, if there is time for it.
    fn then(&mut self, cpu: &mut Cpu, program: &Program);
}

/// One instruction is executed, at R15.
pub(in crate::cpu) struct Alone {
    pub(in crate::cpu) next: u32,
}

impl Position for Alone {
    fn next(&self, _: &Program) -> u32 {
        self.next
    }

    fn branch(&mut self, target: u32) {
        self.next = target;
    }

    fn resume(&mut self, cpu: &mut Cpu, _: &Program) {
        self.next = cpu.r[15];
    }

    // What is outside the program, or only a place in it, is not executed alone.
    fn retreat(&mut self, _: &mut Cpu, _: &Program) {}
    fn follow(&mut self, _: u32) {}
    fn pass(&mut self, _: u8) {}
    fn then(&mut self, _: &mut Cpu, _: &Program) {}
}

/// One instruction is executed after the other.
#[derive(Clone, Copy)]
pub(in crate::cpu) struct Following {
    /// That of the next one. Where it is outside the program, R15 says where.
    pub(in crate::cpu) place: usize,
}

impl Following {
    #[inline(always)]
    pub(in crate::cpu) fn at(address: u32, program: &Program) -> Self {
        Self { place: program.place(address) }
    }

    #[inline(always)]
    pub(in crate::cpu) const fn advance(&mut self) {
        self.place += 1;
    }

    /// R15, and ITSTATE within a block, say where it is.
    #[inline(always)]
    pub(in crate::cpu) fn leave(self, cpu: &mut Cpu, program: &Program) {
        if self.place != Program::OUTSIDE {
            cpu.r[15] = program.address(self.place);
            if let Some(it) = program.it_state(self.place) {
                cpu.it = it;
            }
        }
    }
}

impl Position for Following {
    #[inline(always)]
    fn next(&self, program: &Program) -> u32 {
        program.address(self.place)
    }

    #[inline(always)]
    fn branch(&mut self, target: u32) {
        self.follow(target);
    }

    #[inline(always)]
    fn resume(&mut self, cpu: &mut Cpu, program: &Program) {
        *self = Self::at(cpu.r[15], program);
    }

    #[inline(always)]
    fn retreat(&mut self, cpu: &mut Cpu, program: &Program) {
        self.place -= 1;
        self.leave(cpu, program);
    }

    #[inline(always)]
    fn follow(&mut self, place: u32) {
        self.place = place as usize;
    }

    #[inline(always)]
    fn pass(&mut self, count: u8) {
        self.place += usize::from(count);
    }

    #[inline(always)]
    fn then(&mut self, cpu: &mut Cpu, program: &Program) {
        let op = program.op(self.place);
        if cpu.cycles < cpu.deadline && op.kind != Kind::Trap {
            cpu.cycles += u64::from(op.cycles);
            cpu.instructions = cpu.instructions.wrapping_add(1);
            self.advance();
            if cpu.passes(op.d) {
                cpu.cycles += REFILL;
                self.branch(op.imm);
            }
        }
    }
}
