//! What each instruction does (ARMv6-M Architecture Reference Manual, A6.7).

use super::op::{Access, Op, Register};
use super::{Cause, Core, EXCEPTION_RETURN, Fault, Flags, Memory, Width, alu, cycles};

const SP: usize = 13;
const LR: usize = 14;
const PC: usize = 15;

/// The special registers of MRS and MSR (B5.2.3).
mod special {
    /// APSR, IPSR and their combinations: the lowest three bits choose the parts.
    pub(super) const LAST_STATUS: u8 = 7;
    pub(super) const MAIN_STACK: u8 = 8;
    pub(super) const PROCESS_STACK: u8 = 9;
    pub(super) const PRIMASK: u8 = 16;
    pub(super) const CONTROL: u8 = 20;
}

/// Whether a condition holds (A6.3).
const fn holds(condition: u8, Flags { n, z, c, v }: Flags) -> bool {
    let base = match condition >> 1 {
        0 => z,
        1 => c,
        2 => n,
        3 => v,
        4 => c && !z,
        5 => n == v,
        6 => n == v && !z,
        _ => true,
    };
    base != (condition & 1 != 0)
}

/// The value of a word after an offset that may be negative.
const fn moved(address: u32, offset: i32) -> u32 {
    address.wrapping_add_signed(offset)
}

impl Core {
    #[inline]
    fn get(&self, register: Register) -> u32 {
        self.registers[usize::from(register)]
    }

    /// A register as an operand: PC is the instruction's address plus 4.
    fn operand(&self, register: Register, pc: u32) -> u32 {
        if usize::from(register) == PC { pc.wrapping_add(4) } else { self.get(register) }
    }

    /// Executes an instruction at PC, and returns its cycles. PC stays at an instruction that fails.
    #[inline]
    pub(super) fn execute(&mut self, memory: &mut impl Memory, op: Op) -> Result<u32, Fault> {
        let pc = self.registers[PC];
        let next = pc.wrapping_add(op.size());
        let cost = cycles::of(op);
        match op {
            Op::BranchIf { condition, offset } => {
                let taken = holds(condition, self.flags);
                let target = moved(pc.wrapping_add(4), offset.into());
                self.registers[PC] = if taken { target } else { next };
                return Ok(if taken { cost + cycles::TAKEN } else { cost });
            }
            Op::AccessConstant { access, t, n, offset } => {
                let address = self.get(n).wrapping_add(offset.into());
                self.access(memory, access, t, address)?;
            }
            Op::AccessRegister { access, t, n, m } => {
                let address = self.get(n).wrapping_add(self.get(m));
                self.access(memory, access, t, address)?;
            }
            Op::LoadLiteral { t, offset } => {
                let address = (pc.wrapping_add(4) & !3).wrapping_add(offset.into());
                self.access(memory, Access::Ldr, t, address)?;
            }
            Op::Push { .. } | Op::StoreMany { .. } | Op::LoadMany { .. } => {
                self.many(memory, op)?;
            }
            Op::Pop { list } => {
                let target = self.pop(memory, list)?;
                if let Some(target) = target {
                    return Ok(cost + self.exchange(memory, target)?);
                }
            }
            Op::BranchExchange { m } => {
                let target = self.operand(m, pc);
                return Ok(cost + self.exchange(memory, target)?);
            }
            Op::CallExchange { .. }
            | Op::Branch { .. }
            | Op::Call { .. }
            | Op::AddAny { d: 15, .. }
            | Op::MovAny { d: 15, .. } => {
                self.jump(op, pc)?;
                return Ok(cost);
            }
            Op::WriteSpecial { .. }
            | Op::ReadSpecial { .. }
            | Op::Mask { .. }
            | Op::SupervisorCall
            | Op::Undefined
            | Op::Wait
            | Op::Nothing { .. } => self.special(op, pc)?,
            _ => self.data(op, pc),
        }
        self.registers[PC] = next;
        Ok(cost)
    }

    /// Instructions between registers.
    #[inline]
    fn data(&mut self, op: Op, pc: u32) {
        match op {
            Op::Shift { shift, d, m, by } => self.shift(shift, d, self.get(m), by.into()),
            Op::Add { d, n, m } => self.sum(d, self.get(n), self.get(m), false),
            Op::Sub { d, n, m } => self.sum(d, self.get(n), !self.get(m), true),
            Op::AddConstant { d, n, constant } => self.sum(d, self.get(n), constant.into(), false),
            Op::SubConstant { d, n, constant } => {
                self.sum(d, self.get(n), !u32::from(constant), true);
            }
            Op::MovConstant { d, constant } => self.set(d, constant.into()),
            Op::CmpConstant { n, constant } => self.compare(self.get(n), constant.into()),
            Op::Alu { alu, d, m } => self.alu(alu, d, m),
            Op::AddAny { d, m } => {
                let sum = self.get(d).wrapping_add(self.operand(m, pc));
                self.put(d, sum);
            }
            Op::CmpAny { n, m } => self.compare(self.operand(n, pc), self.operand(m, pc)),
            Op::MovAny { d, m } => self.put(d, self.operand(m, pc)),
            Op::Adr { d, offset } => {
                self.put(d, (pc.wrapping_add(4) & !3).wrapping_add(offset.into()));
            }
            Op::AddSp { d, offset } => self.put(d, self.registers[SP].wrapping_add(offset.into())),
            Op::MoveSp { offset } => {
                self.registers[SP] = moved(self.registers[SP], offset.into());
            }
            Op::Change { change, d, m } => self.put(d, alu::change(change, self.get(m))),
            _ => unreachable!("every other instruction is executed elsewhere"),
        }
    }

    /// Sets a register other than PC; SP is a multiple of four.
    fn put(&mut self, d: Register, value: u32) {
        let d = usize::from(d);
        self.registers[d] = if d == SP { value & !3 } else { value };
    }

    #[inline]
    fn access(
        &mut self,
        memory: &mut impl Memory,
        access: Access,
        t: Register,
        address: u32,
    ) -> Result<(), Fault> {
        let value = self.get(t);
        let loaded = match access {
            Access::Str => return self.store(memory, address, Width::Word, value),
            Access::Strh => return self.store(memory, address, Width::Half, value),
            Access::Strb => return self.store(memory, address, Width::Byte, value),
            Access::Ldr => self.load(memory, address, Width::Word)?,
            Access::Ldrh => self.load(memory, address, Width::Half)?,
            Access::Ldrb => self.load(memory, address, Width::Byte)?,
            Access::Ldrsh => {
                let half = self.load(memory, address, Width::Half)?;
                alu::change(super::Change::Sxth, half)
            }
            Access::Ldrsb => {
                let byte = self.load(memory, address, Width::Byte)?;
                alu::change(super::Change::Sxtb, byte)
            }
        };
        self.registers[usize::from(t)] = loaded;
        Ok(())
    }

    /// PUSH, STM and LDM.
    fn many(&mut self, memory: &mut impl Memory, op: Op) -> Result<(), Fault> {
        let (n, list, loads) = match op {
            Op::Push { list } => (SP, list, false),
            Op::StoreMany { n, list } => (usize::from(n), list.into(), false),
            Op::LoadMany { n, list } => (usize::from(n), list.into(), true),
            _ => return Ok(()),
        };
        let base = self.registers[n];
        let size = list.count_ones() * 4;
        let start = if n == SP { base.wrapping_sub(size) } else { base };
        let mut address = start;
        for register in (0..16).filter(|it| list >> it & 1 != 0) {
            if loads {
                self.registers[register] = self.load(memory, address, Width::Word)?;
            } else {
                self.store(memory, address, Width::Word, self.registers[register])?;
            }
            address = address.wrapping_add(4);
        }
        // LDM leaves a base that it loads.
        if n == SP {
            self.registers[SP] = start;
        } else if !loads || list >> n & 1 == 0 {
            self.registers[n] = address;
        }
        Ok(())
    }

    /// POP. Returns what goes to PC.
    fn pop(&mut self, memory: &mut impl Memory, list: u16) -> Result<Option<u32>, Fault> {
        let mut address = self.registers[SP];
        let mut target = None;
        for register in (0..16).filter(|it| list >> it & 1 != 0) {
            let value = self.load(memory, address, Width::Word)?;
            address = address.wrapping_add(4);
            if register == PC {
                target = Some(value);
            } else {
                self.registers[register] = value;
            }
        }
        self.registers[SP] = address;
        Ok(target)
    }

    /// A branch by BX or POP, which in a handler may be its return. Returns the cycles of the return.
    fn exchange(&mut self, memory: &mut impl Memory, target: u32) -> Result<u32, Fault> {
        if target >= EXCEPTION_RETURN && self.nvic.current() != 0 {
            return self.leave(memory, target);
        }
        self.branch(target)?;
        Ok(0)
    }

    /// Branches whose target is not on the stack and that are no return.
    fn jump(&mut self, op: Op, pc: u32) -> Result<(), Fault> {
        let base = pc.wrapping_add(4);
        match op {
            Op::Branch { offset } => self.registers[PC] = moved(base, offset.into()),
            Op::Call { offset } => {
                self.registers[LR] = base | 1;
                self.registers[PC] = moved(base, offset);
            }
            Op::CallExchange { m } => {
                let target = self.get(m);
                self.registers[LR] = pc.wrapping_add(2) | 1;
                self.branch(target)?;
            }
            Op::AddAny { m, .. } => {
                self.registers[PC] = base.wrapping_add(self.operand(m, pc)) & !1
            }
            Op::MovAny { m, .. } => self.registers[PC] = self.operand(m, pc) & !1,
            _ => {}
        }
        Ok(())
    }

    /// Instructions on the core's state.
    fn special(&mut self, op: Op, pc: u32) -> Result<(), Fault> {
        match op {
            Op::Undefined => return Self::fault(pc, Cause::Undefined),
            Op::SupervisorCall => return self.call_supervisor(pc),
            Op::Mask { masked } => self.masked = masked,
            Op::ReadSpecial { d, special } => {
                let value = self.read_special(special);
                self.put(d, value);
            }
            Op::WriteSpecial { n, special } => self.write_special(special, self.get(n)),
            _ => {}
        }
        Ok(())
    }

    fn read_special(&self, special: u8) -> u32 {
        let on_process = self.is_on_process_stack();
        match special {
            0..=special::LAST_STATUS => {
                let status = self.status();
                let flags = if special & 4 == 0 { status & 0xF000_0000 } else { 0 };
                let exception = if special & 1 != 0 { status & 0x3F } else { 0 };
                flags | exception
            }
            special::MAIN_STACK if on_process => self.other_stack,
            special::PROCESS_STACK if !on_process => self.other_stack,
            special::MAIN_STACK | special::PROCESS_STACK => self.registers[SP],
            special::PRIMASK => self.masked.into(),
            special::CONTROL => u32::from(self.process_stack) << 1,
            _ => 0,
        }
    }

    fn write_special(&mut self, special: u8, value: u32) {
        let on_process = self.is_on_process_stack();
        match special {
            0..=special::LAST_STATUS if special & 4 == 0 => self.set_flags_of(value),
            special::MAIN_STACK if on_process => self.other_stack = value & !3,
            special::PROCESS_STACK if !on_process => self.other_stack = value & !3,
            special::MAIN_STACK | special::PROCESS_STACK => self.registers[SP] = value & !3,
            special::PRIMASK => self.masked = value & 1 != 0,
            // A handler always uses the main stack.
            special::CONTROL if self.nvic.current() == 0 => {
                let process = value & 2 != 0;
                if process != self.process_stack {
                    std::mem::swap(&mut self.registers[SP], &mut self.other_stack);
                }
                self.process_stack = process;
            }
            _ => {}
        }
    }
}
