//! Executes multiplication, division, saturation and packing with the plain functions of [`dsp`].

use crate::cpu::abort::Abort;
use crate::cpu::dsp::{self, Lanes, Prefix};
use crate::cpu::op::{Extend, Long, Multiply, Op, Saturating, Shift};
use crate::cpu::{Cpu, Fault, timing};

impl Cpu {
    pub(super) fn multiply_long(&mut self, op: &Op, long: Long) {
        let (n, m) = (self.get(op.n), self.get(op.m));
        let (high, low) = (self.get(op.a), self.get(op.d));
        let before = u64::from(high) << 32 | u64::from(low);
        let unsigned = u64::from(n) * u64::from(m);
        let signed = (i64::from(n as i32) * i64::from(m as i32)) as u64;
        let result = match long {
            Long::Unsigned => unsigned,
            Long::Signed => signed,
            Long::AccumulateUnsigned => before.wrapping_add(unsigned),
            Long::AccumulateSigned => before.wrapping_add(signed),
            Long::AccumulateTwice => dsp::umaal(n, m, high, low),
            Long::Halves(n_top, m_top) => dsp::smlalxy(n, m, before, n_top, m_top),
            Long::DualAdd(swap) => dsp::smlald(n, m, before, swap),
            Long::DualSub(swap) => dsp::smlsld(n, m, before, swap),
        };
        self.set(op.d, result as u32);
        self.set(op.a, (result >> 32) as u32);
    }

    pub(super) fn multiply(&mut self, op: &Op, multiply: Multiply) {
        let (n, m) = (self.get(op.n), self.get(op.m));
        let a = if op.a == 15 { 0 } else { self.get(op.a) };
        let (result, q) = match multiply {
            Multiply::Halves(x, y) => (dsp::smulxy(n, m, x, y), false),
            Multiply::AccumulateHalves(x, y) => dsp::smlaxy(n, m, a, x, y),
            Multiply::Wide(top) => (dsp::smulwy(n, m, top), false),
            Multiply::AccumulateWide(top) => dsp::smlawy(n, m, a, top),
            Multiply::DualAdd(swap) => dsp::smlad(n, m, a, swap),
            Multiply::DualSub(swap) => dsp::smlsd(n, m, a, swap),
            Multiply::Most(round) => (dsp::smmla(n, m, a, round), false),
            Multiply::MostSub(round) => (dsp::smmls(n, m, a, round), false),
            Multiply::Differences => (dsp::usada8(n, m, a), false),
        };
        self.saturated(op.d, (result, q));
    }

    /// A result, and whether the Q flag is set.
    fn saturated(&mut self, d: u8, (result, q): (u32, bool)) {
        self.flags.q |= q;
        self.set(d, result);
    }

    #[inline(always)]
    pub(super) fn sdiv(&mut self, op: &Op) {
        let (n, m) = (self.get(op.n), self.get(op.m));
        if m == 0 {
            return self.divide_by_zero(op);
        }
        self.cycles += timing::division((n as i32).unsigned_abs(), (m as i32).unsigned_abs());
        self.set(op.d, (n as i32).wrapping_div(m as i32) as u32);
    }

    #[inline(always)]
    pub(super) fn udiv(&mut self, op: &Op) {
        let (n, m) = (self.get(op.n), self.get(op.m));
        if m == 0 {
            return self.divide_by_zero(op);
        }
        self.cycles += timing::division(n, m);
        self.set(op.d, n / m);
    }

    #[cold]
    fn divide_by_zero(&mut self, op: &Op) {
        if self.control.traps_division() {
            self.refuse(op, Abort::Fault(Fault::DivideByZero));
        } else {
            self.set(op.d, 0);
        }
    }

    pub(super) fn extend(&mut self, op: &Op, extend: Extend) {
        let m = self.get(op.m).rotate_right(op.a.into());
        let n = if op.n == 15 { 0 } else { self.get(op.n) };
        let result = match extend {
            Extend::SignedByte => n.wrapping_add(m as i8 as u32),
            Extend::SignedHalf => n.wrapping_add(m as i16 as u32),
            Extend::UnsignedByte => n.wrapping_add(m & 0xFF),
            Extend::UnsignedHalf => n.wrapping_add(m & 0xFFFF),
            Extend::SignedBytes16 => dsp::sxtab16(n, m),
            Extend::UnsignedBytes16 => dsp::uxtab16(n, m),
        };
        self.set(op.d, result);
    }

    /// Rn, shifted by an immediate.
    fn saturand(&self, op: &Op, by: Shift) -> u32 {
        match by {
            Shift::Asr => (self.get(op.n) as i32 >> op.a.min(31)) as u32,
            _ => self.get(op.n) << (op.a & 31),
        }
    }

    pub(super) fn ssat(&mut self, op: &Op, by: Shift) {
        self.saturated(op.d, dsp::ssat(self.saturand(op, by), op.imm));
    }

    pub(super) fn usat(&mut self, op: &Op, by: Shift) {
        self.saturated(op.d, dsp::usat(self.saturand(op, by), op.imm));
    }

    pub(super) fn ssat16(&mut self, op: &Op) {
        self.saturated(op.d, dsp::ssat16(self.get(op.n), op.imm));
    }

    pub(super) fn usat16(&mut self, op: &Op) {
        self.saturated(op.d, dsp::usat16(self.get(op.n), op.imm));
    }

    pub(super) fn saturating(&mut self, op: &Op, how: Saturating) {
        let (m, n) = (self.get(op.m), self.get(op.n));
        let result = match how {
            Saturating::Add => dsp::qadd(m, n),
            Saturating::Sub => dsp::qsub(m, n),
            Saturating::DoubleAdd => dsp::qdadd(m, n),
            Saturating::DoubleSub => dsp::qdsub(m, n),
        };
        self.saturated(op.d, result);
    }

    pub(super) fn parallel(&mut self, op: &Op, prefix: Prefix, lanes: Lanes) {
        let (result, ge) = dsp::parallel(prefix, lanes, self.get(op.n), self.get(op.m));
        if prefix.sets_ge() {
            self.flags.ge = ge;
        }
        self.set(op.d, result);
    }

    pub(super) fn sel(&mut self, op: &Op) {
        self.set(op.d, dsp::sel(self.get(op.n), self.get(op.m), self.flags.ge));
    }

    pub(super) fn pkhbt(&mut self, op: &Op) {
        self.set(op.d, dsp::pkhbt(self.get(op.n), self.get(op.m) << (op.a & 31)));
    }

    pub(super) fn pkhtb(&mut self, op: &Op) {
        let m = (self.get(op.m) as i32 >> op.a.min(31)) as u32;
        self.set(op.d, dsp::pkhtb(self.get(op.n), m));
    }
}
