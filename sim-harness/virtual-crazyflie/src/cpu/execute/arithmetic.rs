//! Sums, logic and shifts, and what they do to the flags (DDI 0403, A2.2.1 and A7.4.2).

use crate::cpu::Cpu;
use crate::cpu::op::{Op, Shift, ToSp};

impl Cpu {
    #[inline(always)]
    pub(super) const fn set_nz(&mut self, result: u32) {
        self.flags.n = (result as i32) < 0;
        self.flags.z = result == 0;
    }

    /// The flags of `n + m`.
    #[inline(always)]
    pub(super) const fn compare_negative(&mut self, n: u32, m: u32) {
        let (result, carry) = n.overflowing_add(m);
        self.set_nz(result);
        self.flags.c = carry;
        self.flags.v = (((n ^ result) & (m ^ result)) as i32) < 0;
    }

    /// The flags of `n - m`.
    #[inline(always)]
    pub(super) const fn compare(&mut self, n: u32, m: u32) {
        let result = n.wrapping_sub(m);
        self.set_nz(result);
        self.flags.c = n >= m;
        self.flags.v = (((n ^ m) & (n ^ result)) as i32) < 0;
    }

    #[inline(always)]
    pub(super) const fn add_s(&mut self, d: u8, n: u32, m: u32) {
        self.compare_negative(n, m);
        self.set(d, n.wrapping_add(m));
    }

    #[inline(always)]
    pub(super) const fn sub_s(&mut self, d: u8, n: u32, m: u32) {
        self.compare(n, m);
        self.set(d, n.wrapping_sub(m));
    }

    #[inline(always)]
    pub(super) const fn adc(&mut self, d: u8, n: u32, m: u32) {
        self.set(d, n.wrapping_add(m).wrapping_add(self.flags.c as u32));
    }

    #[inline(always)]
    pub(super) const fn adc_s(&mut self, d: u8, n: u32, m: u32) {
        let exact = n as u64 + m as u64 + self.flags.c as u64;
        let result = exact as u32;
        self.set_nz(result);
        self.flags.c = exact >> 32 != 0;
        self.flags.v = (((n ^ result) & (m ^ result)) as i32) < 0;
        self.set(d, result);
    }

    #[inline(always)]
    pub(super) const fn logical(&mut self, d: u8, result: u32) {
        self.set_nz(result);
        self.set(d, result);
    }

    #[inline(always)]
    pub(super) const fn test_imm(&mut self, op: &Op, result: u32) {
        if op.a != 2 {
            self.flags.c = op.a != 0;
        }
        self.set_nz(result);
    }

    #[inline(always)]
    pub(super) const fn logical_imm(&mut self, op: &Op, result: u32) {
        self.test_imm(op, result);
        self.set(op.d, result);
    }

    /// Rm, shifted by an immediate, and the carry.
    #[inline(always)]
    pub(super) fn shifted(&self, op: &Op, by: Shift) -> (u32, bool) {
        let (value, amount) = (self.get(op.m), u32::from(op.a));
        shift(value, by, amount, self.flags.c)
    }

    #[inline(always)]
    pub(super) fn test_shifted(&mut self, result: u32, op: &Op, by: Shift) {
        self.flags.c = self.shifted(op, by).1;
        self.set_nz(result);
    }

    #[inline(always)]
    pub(super) fn logical_shifted(&mut self, op: &Op, by: Shift, f: impl Fn(u32, u32) -> u32) {
        let (m, carry) = self.shifted(op, by);
        let result = f(self.get(op.n), m);
        self.carrying(op.d, (result, carry));
    }

    #[inline(always)]
    pub(super) const fn carrying(&mut self, d: u8, (result, carry): (u32, bool)) {
        self.flags.c = carry;
        self.logical(d, result);
    }

    #[inline(always)]
    pub(super) fn lsl_s(&mut self, op: &Op) {
        self.carrying(op.d, self.shifted(op, Shift::Lsl));
    }

    #[inline(always)]
    pub(super) fn lsr_s(&mut self, op: &Op) {
        self.carrying(op.d, self.shifted(op, Shift::Lsr));
    }

    #[inline(always)]
    pub(super) fn asr_s(&mut self, op: &Op) {
        self.carrying(op.d, self.shifted(op, Shift::Asr));
    }

    pub(super) fn ror_s(&mut self, op: &Op) {
        self.carrying(op.d, self.shifted(op, Shift::Ror));
    }

    pub(super) fn rrx_s(&mut self, op: &Op) {
        self.carrying(op.d, self.shifted(op, Shift::Rrx));
    }

    /// Rn, shifted by the lowest byte of Rm.
    #[inline(always)]
    fn by_register(&self, op: &Op, by: Shift) -> (u32, bool) {
        shift(self.get(op.n), by, self.get(op.m) & 0xFF, self.flags.c)
    }

    #[inline(always)]
    pub(super) fn lsl_by_register(&self, op: &Op) -> (u32, bool) {
        self.by_register(op, Shift::Lsl)
    }

    #[inline(always)]
    pub(super) fn lsr_by_register(&self, op: &Op) -> (u32, bool) {
        self.by_register(op, Shift::Lsr)
    }

    #[inline(always)]
    pub(super) fn asr_by_register(&self, op: &Op) -> (u32, bool) {
        self.by_register(op, Shift::Asr)
    }

    #[inline(always)]
    pub(super) fn ror_by_register(&self, op: &Op) -> (u32, bool) {
        self.by_register(op, Shift::Ror)
    }

    /// The operands of a sum that goes to SP, the second one shifted.
    fn sp_operands(&self, op: &Op, how: ToSp) -> (u32, u32) {
        match how {
            ToSp::Mov => (0, self.get(op.m)),
            ToSp::Add | ToSp::Sub => (self.get(op.n), self.get(op.m) << (op.a & 31)),
            ToSp::AddImm | ToSp::SubImm => (self.get(op.n), op.imm),
        }
    }

    pub(super) fn sum_to_sp(&mut self, op: &Op, how: ToSp) {
        let (n, m) = self.sp_operands(op, how);
        let result = match how {
            ToSp::Mov | ToSp::Add | ToSp::AddImm => n.wrapping_add(m),
            ToSp::Sub | ToSp::SubImm => n.wrapping_sub(m),
        };
        self.r[13] = result & !3;
    }

    #[cold]
    pub(super) fn sum_to_sp_s(&mut self, op: &Op, how: ToSp) {
        let (n, m) = self.sp_operands(op, how);
        match how {
            ToSp::Mov | ToSp::Add | ToSp::AddImm => self.add_s(13, n, m),
            ToSp::Sub | ToSp::SubImm => self.sub_s(13, n, m),
        }
        self.r[13] &= !3;
    }
}

/// Shift_C (A7.4.2), by 0 to 255.
#[inline(always)]
fn shift(value: u32, by: Shift, amount: u32, carry: bool) -> (u32, bool) {
    if amount == 0 {
        return (value, carry);
    }
    let last = amount - 1;
    match by {
        Shift::Lsl => {
            let almost = value.checked_shl(last).unwrap_or(0);
            (almost << 1, (almost as i32) < 0)
        }
        Shift::Lsr => {
            let almost = value.checked_shr(last).unwrap_or(0);
            (almost >> 1, almost & 1 != 0)
        }
        Shift::Asr => {
            let almost = value as i32 >> last.min(31);
            ((almost >> 1) as u32, almost & 1 != 0)
        }
        Shift::Ror => {
            let result = value.rotate_right(amount & 31);
            (result, (result as i32) < 0)
        }
        Shift::Rrx => (u32::from(carry) << 31 | value >> 1, value & 1 != 0),
    }
}
