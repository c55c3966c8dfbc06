//! The floating-point unit as the system sees it (DDI 0403, B3.2.20 to B3.2.25), and what comes
//! before a floating-point instruction.

use super::{Store, unmodelled};
use crate::bus::Refused;
use crate::cpu::Cpu;
use crate::cpu::Fault;
use crate::cpu::exceptions::{FP_WORDS, Ready};
use crate::cpu::fp::Fpscr;
use crate::memory::Memory;

const CPACR: u32 = 0xE000_ED88;
const FPCCR: u32 = 0xE000_EF34;
const FPCAR: u32 = 0xE000_EF38;
const FPDSCR: u32 = 0xE000_EF3C;
const MVFR0: u32 = 0xE000_EF40;

const ASPEN: u32 = 1 << 31;
const LSPEN: u32 = 1 << 30;
const MONRDY: u32 = 1 << 8;
const BFRDY: u32 = 1 << 6;
const MMRDY: u32 = 1 << 5;
const HFRDY: u32 = 1 << 4;
const THREAD: u32 = 1 << 3;
const USER: u32 = 1 << 1;
const LSPACT: u32 = 1;
const CONTEXT: u32 = MONRDY | BFRDY | MMRDY | HFRDY | THREAD | USER;

/// CPACR, FPCCR, FPCAR and FPDSCR.
#[derive(Clone, Debug)]
pub(in crate::cpu) struct FpControl {
    cpacr: u32,
    fpccr: u32,
    fpcar: u32,
    fpdscr: u32,
}

impl Default for FpControl {
    fn default() -> Self {
        Self { cpacr: 0, fpccr: ASPEN | LSPEN, fpcar: 0, fpdscr: 0 }
    }
}

impl FpControl {
    /// CheckVFPEnabled().
    pub(in crate::cpu) const fn allowed(&self, privileged: bool) -> bool {
        match self.cpacr >> 20 & 3 {
            1 => privileged,
            3 => true,
            _ => false,
        }
    }

    /// FPCCR.LSPEN.
    pub(in crate::cpu) const fn saves_lazily(&self) -> bool {
        self.fpccr & LSPEN != 0
    }

    /// FPCCR.LSPACT: the state of another context is still in the registers.
    pub(in crate::cpu) const fn saving(&self) -> bool {
        self.fpccr & LSPACT != 0
    }

    /// Cancels the lazy save: the state stays in the registers.
    pub(in crate::cpu) fn forget_save(&mut self) {
        self.fpccr &= !LSPACT;
    }

    /// Room has been left at `address`.
    pub(in crate::cpu) fn defer(&mut self, address: u32, ready: Ready, thread: bool, user: bool) {
        let context = [
            (ready.monitor, MONRDY),
            (ready.bus_fault, BFRDY),
            (ready.mem_manage, MMRDY),
            (ready.hard_fault, HFRDY),
            (thread, THREAD),
            (user, USER),
        ];
        let context = context.iter().filter(|(set, _)| *set).fold(0, |sum, (_, bit)| sum | bit);
        self.fpcar = address & !7;
        self.fpccr = self.fpccr & !CONTEXT | context | LSPACT;
    }

    /// Whether a save that fails may raise BusFault, and whether HardFault.
    pub(in crate::cpu) const fn save_may_raise(&self) -> (bool, bool) {
        (self.fpccr & BFRDY != 0, self.fpccr & HFRDY != 0)
    }

    const fn creates_contexts(&self) -> bool {
        self.fpccr & ASPEN != 0
    }
}

impl Cpu {
    /// Whether the present mode may use the floating-point unit.
    pub(in crate::cpu) const fn fpu_allowed(&self) -> bool {
        self.control.fp.allowed(self.special.privileged())
    }

    /// Keeps `fpu.ready` what it says.
    pub(in crate::cpu) fn weigh_fpu(&mut self) {
        let fp = &self.control.fp;
        self.fpu.ready =
            self.fpu_allowed() && !fp.saving() && (self.special.fpca || !fp.creates_contexts());
    }

    /// Gives every mode access to the floating-point unit: CP10 and CP11 in CPACR.
    pub(in crate::cpu) fn enable_coprocessors(&mut self) {
        self.control.fp.cpacr = 0xF << 20;
    }

    /// Makes the checks before a floating-point instruction where `fpu.ready` is false: whether the unit
    /// is enabled, a lazy save is outstanding, or a new context begins (ExecuteFPCheck()).
    pub(crate) fn prepare_fp(&mut self, memory: &mut Memory) -> Result<(), Fault> {
        if !self.fpu_allowed() {
            return Err(Fault::NoCoprocessor);
        }
        if self.control.fp.saving() {
            self.cycles += FP_WORDS;
            self.control.fp.forget_save();
            let stored = self.store_fp(memory, self.control.fp.fpcar);
            if !stored {
                self.weigh_fpu();
                return Err(Fault::LazySave);
            }
        }
        if self.control.fp.creates_contexts() && !self.special.fpca {
            let old = self.fpu.fpscr.bits() & !Fpscr::CONTROL;
            self.fpu.fpscr = Fpscr::from_bits(old | self.control.fp.fpdscr);
            self.special.fpca = true;
        }
        self.weigh_fpu();
        Ok(())
    }

    pub(super) fn load_fpu(&self, address: u32) -> Result<u32, Refused> {
        let fp = &self.control.fp;
        Ok(match address {
            CPACR => fp.cpacr,
            FPCCR => fp.fpccr,
            FPCAR => fp.fpcar,
            FPDSCR => fp.fpdscr,
            // Cortex-M4 TRM, "FP register summary".
            MVFR0 => 0x1011_0021,
            _ => 0x1100_0011,
        })
    }

    pub(super) fn store_fpu(&mut self, store: Store) -> Result<(), Refused> {
        let fp = &mut self.control.fp;
        match store.address {
            CPACR => {
                // There are no other coprocessors, and these two are one.
                let (cp10, cp11) = (store.value >> 20 & 3, store.value >> 22 & 3);
                if cp10 != cp11 || cp10 == 2 {
                    return unmodelled("CPACR: CP10 and CP11 apart, or a reserved right");
                }
                fp.cpacr = store.value & 0x00F0_0000;
            }
            FPCCR => fp.fpccr = store.value & (ASPEN | LSPEN | CONTEXT | LSPACT),
            FPCAR => fp.fpcar = store.value & !7,
            FPDSCR => fp.fpdscr = store.value & Fpscr::CONTROL,
            _ => return unmodelled("a store to a read-only register"),
        }
        self.weigh_fpu();
        Ok(())
    }
}
