//! Branches whose target is not in the instruction (DDI 0403, A2.3.1).

use crate::bus::Bus;
use crate::cpu::Cpu;
use crate::cpu::op::{Load, Op};
use crate::cpu::timing::REFILL_REGISTER;
use crate::memory::Memory;

impl Cpu {
    /// BLXWritePC: bit 0 is what becomes of EPSR.T.
    #[inline(always)]
    const fn branch_to(&mut self, target: u32) {
        self.r[15] = target & !1;
        if target & 1 == 0 {
            self.thumb = false;
            self.deadline = 0;
        }
    }

    /// BXWritePC, which in handler mode may be the return from an exception.
    #[inline(always)]
    pub(super) fn branch_exchange(&mut self, memory: &mut Memory, target: u32, refill: u64) {
        if target >= 0xF000_0000 && self.special.ipsr != 0 {
            self.exception_return(memory, target);
            self.deadline = 0;
        } else {
            self.cycles += refill;
            self.branch_to(target);
        }
    }

    /// BLX.
    #[inline(always)]
    pub(super) const fn branch_link_exchange(&mut self, target: u32) {
        self.r[14] = self.r[15] | 1;
        self.cycles += REFILL_REGISTER;
        self.branch_to(target);
    }

    /// BranchWritePC: bit 0 does not matter.
    pub(super) const fn branch_plain(&mut self, target: u32) {
        self.r[15] = target & !1;
        self.cycles += REFILL_REGISTER;
    }

    pub(super) fn table_branch<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        load: Load,
    ) {
        let table = if op.n == 15 { op.imm } else { self.get(op.n) };
        let index = self.get(op.m) << u32::from(load == Load::Half);
        let Some(distance) = self.load(op, memory, bus, table.wrapping_add(index), load) else {
            return;
        };
        self.r[15] = self.r[15].wrapping_add(2 * distance);
        self.cycles += REFILL_REGISTER;
    }
}
