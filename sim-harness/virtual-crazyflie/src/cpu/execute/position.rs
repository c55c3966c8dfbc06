//! Where the core is in its program, while instructions are executed.

use crate::cpu::{Cpu, Program};

/// What an instruction asks of whoever executes it.
pub(in crate::cpu) trait Position {
    /// The address of the instruction behind this one.
    fn next(&self, program: &Program) -> u32;
    /// On at an address.
    fn go(&mut self, cpu: &mut Cpu, program: &Program, target: u32);
    /// On where R15 says.
    fn resume(&mut self, cpu: &mut Cpu, program: &Program);
    /// Back at this instruction, and R15 says where that is.
    fn retreat(&mut self, cpu: &mut Cpu, program: &Program);
    /// On at a place in the program.
    fn follow(&mut self, place: u32);
}

/// One instruction is executed, at R15.
pub(in crate::cpu) struct Alone {
    pub(in crate::cpu) next: u32,
}

impl Position for Alone {
    fn next(&self, _: &Program) -> u32 {
        self.next
    }

    fn go(&mut self, _: &mut Cpu, _: &Program, target: u32) {
        self.next = target;
    }

    fn resume(&mut self, cpu: &mut Cpu, _: &Program) {
        self.next = cpu.r[15];
    }

    // What is outside the program, or only a place in it, is not executed alone.
    fn retreat(&mut self, _: &mut Cpu, _: &Program) {}
    fn follow(&mut self, _: u32) {}
}

/// One instruction is executed after the other.
#[derive(Clone, Copy)]
pub(in crate::cpu) struct Following {
    /// That of the next one. Where it is outside the program, R15 says where.
    pub(in crate::cpu) place: usize,
}

impl Following {
    pub(in crate::cpu) fn at(address: u32, program: &Program) -> Self {
        Self { place: program.place(address) }
    }

    /// R15 says where it is.
    #[inline(always)]
    pub(in crate::cpu) fn leave(self, cpu: &mut Cpu, program: &Program) {
        if self.place != Program::OUTSIDE {
            cpu.r[15] = program.address(self.place);
        }
    }
}

impl Position for Following {
    #[inline(always)]
    fn next(&self, program: &Program) -> u32 {
        program.address(self.place)
    }

    #[inline(always)]
    fn go(&mut self, cpu: &mut Cpu, program: &Program, target: u32) {
        self.place = program.place(target);
        if self.place == Program::OUTSIDE {
            cpu.r[15] = target;
        }
    }

    #[inline(always)]
    fn resume(&mut self, cpu: &mut Cpu, program: &Program) {
        self.place = program.place(cpu.r[15]);
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
}
