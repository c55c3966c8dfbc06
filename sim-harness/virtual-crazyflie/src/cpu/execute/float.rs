//! Executes floating-point instructions with the plain functions of [`fp`].
//!
//! Each checks first whether the unit is ready: it may be disabled, or the state of a context that
//! was interrupted may have to be saved before (DDI 0403, B1.5.7, ExecuteFPCheck).

use crate::bus::{Bus, Width};
use crate::cpu::Cpu;
use crate::cpu::abort::Abort;
use crate::cpu::fp::{self, Fixed, Fpscr};
use crate::cpu::op::{Accumulate, Load, Multiple, Op};
use crate::memory::Memory;

/// Operations of Sn and Sm, and of Sm alone.
macro_rules! operations {
    ($($name:ident: $f:path, $($operand:ident),+;)*) => {$(
        #[inline(always)]
        pub(super) fn $name(&mut self, op: &Op, memory: &mut Memory) {
            if self.floats(op, memory) {
                let result = $f($(self.float(op.$operand),)+ &mut self.fpu.fpscr);
                self.set_float(op.d, result);
            }
        }
    )*};
}

impl Cpu {
    /// Whether a floating-point instruction may go ahead.
    #[inline(always)]
    fn floats(&mut self, op: &Op, memory: &mut Memory) -> bool {
        self.fpu.ready || self.prepare_floats(op, memory)
    }

    #[cold]
    fn prepare_floats(&mut self, op: &Op, memory: &mut Memory) -> bool {
        match self.prepare_fp(memory) {
            Ok(()) => true,
            Err(fault) => {
                self.refuse(op, Abort::Fault(fault));
                false
            }
        }
    }

    #[inline(always)]
    const fn float(&self, register: u8) -> u32 {
        self.fpu.s[(register & 31) as usize]
    }

    #[inline(always)]
    const fn set_float(&mut self, register: u8, bits: u32) {
        self.fpu.s[(register & 31) as usize] = bits;
    }

    /// Sets Sd to a result, if the floating-point unit may be used.
    #[inline(always)]
    fn set_result(&mut self, op: &Op, memory: &mut Memory, result: impl FnOnce(&mut Self) -> u32) {
        if self.floats(op, memory) {
            let bits = result(self);
            self.set_float(op.d, bits);
        }
    }

    operations! {
        vadd: fp::add, n, m;
        vsub: fp::sub, n, m;
        vmul: fp::mul, n, m;
        vnmul: fp::nmul, n, m;
        vdiv: fp::div, n, m;
        vmla: fp::mla, d, n, m;
        vmls: fp::mls, d, n, m;
        vsqrt: fp::sqrt, m;
    }

    /// Multiplications that are rarer.
    pub(super) fn accumulate(&mut self, op: &Op, memory: &mut Memory, how: Accumulate) {
        if !self.floats(op, memory) {
            return;
        }
        let function = match how {
            Accumulate::Nmla => fp::nmla,
            Accumulate::Nmls => fp::nmls,
            Accumulate::Fma => fp::fma,
            Accumulate::Fms => fp::fms,
            Accumulate::Fnma => fp::fnma,
            Accumulate::Fnms => fp::fnms,
        };
        let (d, n, m) = (self.float(op.d), self.float(op.n), self.float(op.m));
        let result = function(d, n, m, &mut self.fpu.fpscr);
        self.set_float(op.d, result);
    }

    #[inline(always)]
    pub(super) fn vabs(&mut self, op: &Op, memory: &mut Memory) {
        self.set_result(op, memory, |cpu| fp::abs(cpu.float(op.m)));
    }

    #[inline(always)]
    pub(super) fn vneg(&mut self, op: &Op, memory: &mut Memory) {
        self.set_result(op, memory, |cpu| fp::neg(cpu.float(op.m)));
    }

    #[inline(always)]
    pub(super) fn vmov(&mut self, op: &Op, memory: &mut Memory) {
        self.set_result(op, memory, |cpu| cpu.float(op.m));
    }

    #[inline(always)]
    pub(super) fn vmov_imm(&mut self, op: &Op, memory: &mut Memory) {
        self.set_result(op, memory, |_| op.imm);
    }

    #[inline(always)]
    pub(super) fn vcmp(&mut self, op: &Op, memory: &mut Memory, signalling: bool) {
        if self.floats(op, memory) {
            let (d, m) = (self.float(op.d), self.float(op.m));
            fp::compare(d, m, signalling, &mut self.fpu.fpscr);
        }
    }

    #[inline(always)]
    pub(super) fn vcmp_zero(&mut self, op: &Op, memory: &mut Memory, signalling: bool) {
        if self.floats(op, memory) {
            fp::compare(self.float(op.d), 0, signalling, &mut self.fpu.fpscr);
        }
    }

    #[inline(always)]
    pub(super) fn vcvt_to_int(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        signed: bool,
        towards_zero: bool,
    ) {
        self.set_result(op, memory, |cpu| {
            fp::to_int(cpu.float(op.m), signed, towards_zero, &mut cpu.fpu.fpscr)
        });
    }

    #[inline(always)]
    pub(super) fn vcvt_from_int(&mut self, op: &Op, memory: &mut Memory, signed: bool) {
        self.set_result(op, memory, |cpu| {
            fp::from_int(cpu.float(op.m), signed, &mut cpu.fpu.fpscr)
        });
    }

    pub(super) fn vcvt_to_fixed(&mut self, op: &Op, memory: &mut Memory, signed: bool) {
        let format = Fixed { bits: op.imm as u8, fraction: op.a, signed };
        self.set_result(op, memory, |cpu| {
            fp::to_fixed(cpu.float(op.d), format, &mut cpu.fpu.fpscr)
        });
    }

    pub(super) fn vcvt_from_fixed(&mut self, op: &Op, memory: &mut Memory, signed: bool) {
        let format = Fixed { bits: op.imm as u8, fraction: op.a, signed };
        self.set_result(op, memory, |cpu| {
            fp::from_fixed(cpu.float(op.d), format, &mut cpu.fpu.fpscr)
        });
    }

    pub(super) fn vcvt_from_half(&mut self, op: &Op, memory: &mut Memory, top: bool) {
        self.set_result(op, memory, |cpu| {
            let half = (cpu.float(op.m) >> (16 * u32::from(top))) as u16;
            fp::half_to_single(half, &mut cpu.fpu.fpscr)
        });
    }

    pub(super) fn vcvt_to_half(&mut self, op: &Op, memory: &mut Memory, top: bool) {
        self.set_result(op, memory, |cpu| {
            let half = u32::from(fp::single_to_half(cpu.float(op.m), &mut cpu.fpu.fpscr));
            let at = 16 * u32::from(top);
            cpu.float(op.d) & !(0xFFFF << at) | half << at
        });
    }

    #[inline(always)]
    pub(super) fn vmov_to_core(&mut self, op: &Op, memory: &mut Memory) {
        if self.floats(op, memory) {
            self.set(op.d, self.float(op.n));
        }
    }

    #[inline(always)]
    pub(super) fn vmov_from_core(&mut self, op: &Op, memory: &mut Memory) {
        if self.floats(op, memory) {
            self.set_float(op.n, self.get(op.d));
        }
    }

    #[inline(always)]
    pub(super) fn vmov_to_cores(&mut self, op: &Op, memory: &mut Memory) {
        if self.floats(op, memory) {
            self.set(op.d, self.float(op.m));
            self.set(op.a, self.float(op.m + 1));
        }
    }

    #[inline(always)]
    pub(super) fn vmov_from_cores(&mut self, op: &Op, memory: &mut Memory) {
        if self.floats(op, memory) {
            self.set_float(op.m, self.get(op.d));
            self.set_float(op.m + 1, self.get(op.a));
        }
    }

    #[inline(always)]
    pub(super) fn vmrs(&mut self, op: &Op, memory: &mut Memory) {
        if !self.floats(op, memory) {
            return;
        }
        if op.d == 15 {
            let nzcv = self.fpu.fpscr.nzcv();
            self.flags.n = nzcv & 8 != 0;
            self.flags.z = nzcv & 4 != 0;
            self.flags.c = nzcv & 2 != 0;
            self.flags.v = nzcv & 1 != 0;
        } else {
            self.set(op.d, self.fpu.fpscr.bits());
        }
    }

    pub(super) fn vmsr(&mut self, op: &Op, memory: &mut Memory) {
        if self.floats(op, memory) {
            self.fpu.fpscr = Fpscr::from_bits(self.get(op.d));
        }
    }

    #[inline(always)]
    pub(super) fn vldr<B: Bus>(&mut self, op: &Op, memory: &mut Memory, bus: &mut B, address: u32) {
        if !self.floats(op, memory) || !self.aligned(op, address) {
            return;
        }
        if let Some(bits) = self.load(op, memory, bus, address, Load::Word) {
            self.set_float(op.d, bits);
        }
    }

    #[inline(always)]
    pub(super) fn vstr<B: Bus>(&mut self, op: &Op, memory: &mut Memory, bus: &mut B, address: u32) {
        if self.floats(op, memory) && self.aligned(op, address) {
            self.store(op, memory, bus, address, Width::Word, self.float(op.d));
        }
    }

    /// Several registers from Sd on. False if the instruction was abandoned.
    pub(super) fn load_floats<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        address: u32,
        count: u8,
    ) -> bool {
        if !self.floats(op, memory) || !self.aligned(op, address) {
            return false;
        }
        let mut loaded = [0; 32];
        let first = usize::from(op.d);
        let loaded = &mut loaded[..usize::from(count)];
        for (bits, address) in loaded.iter_mut().zip((0..).map(|n| address.wrapping_add(4 * n))) {
            let Some(word) = self.load(op, memory, bus, address, Load::Word) else { return false };
            *bits = word;
        }
        self.fpu.s[first..first + loaded.len()].copy_from_slice(loaded);
        true
    }

    /// Several registers from Sd on. False if the instruction was abandoned.
    pub(super) fn store_floats<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        address: u32,
        count: u8,
    ) -> bool {
        if !self.floats(op, memory) || !self.aligned(op, address) {
            return false;
        }
        (0..count).all(|n| {
            let address = address.wrapping_add(4 * u32::from(n));
            self.store(op, memory, bus, address, Width::Word, self.float(op.d + n))
        })
    }

    /// The first address of VLDM and VSTM, and the new value of their base.
    const fn stretch(&self, op: &Op, how: Multiple) -> (u32, u32) {
        let base = self.get(op.n);
        let size = 4 * op.a as u32;
        match how {
            Multiple::From => (base, base),
            Multiple::FromAndUpdate => (base, base.wrapping_add(size)),
            Multiple::UpToAndUpdate => (base.wrapping_sub(size), base.wrapping_sub(size)),
        }
    }

    pub(super) fn vldm<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        how: Multiple,
    ) {
        let (address, base) = self.stretch(op, how);
        if self.load_floats(op, memory, bus, address, op.a) {
            self.set(op.n, base);
        }
    }

    pub(super) fn vstm<B: Bus>(
        &mut self,
        op: &Op,
        memory: &mut Memory,
        bus: &mut B,
        how: Multiple,
    ) {
        let (address, base) = self.stretch(op, how);
        if self.store_floats(op, memory, bus, address, op.a) {
            self.set(op.n, base);
        }
    }
}
