//! The special registers: the parts of XPSR, and MRS, MSR and CPS (DDI 0403, B1.4 and B5.2).
//!
//! PRIMASK, FAULTMASK and BASEPRI live with the priorities that they mask, in
//! [`Priorities`](super::exceptions::Priorities).

use super::Cpu;

const N: u32 = 1 << 31;
const Z: u32 = 1 << 30;
const C: u32 = 1 << 29;
const V: u32 = 1 << 28;
const Q: u32 = 1 << 27;
const T: u32 = 1 << 24;
const IPSR: u32 = 0x1FF;

/// Which mode it is in, and CONTROL.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Special {
    /// The number of the exception that is handled; zero in thread mode.
    pub(crate) ipsr: u16,
    /// CONTROL.nPRIV: thread mode has no privileges.
    pub(crate) unprivileged: bool,
    /// CONTROL.SPSEL: the stack in use is the process stack. Never so in handler mode.
    pub(crate) process_stack: bool,
    /// CONTROL.FPCA: the current context has floating-point state.
    pub(crate) fpca: bool,
}

impl Special {
    /// CurrentModeIsPrivileged().
    #[inline]
    pub(crate) const fn privileged(self) -> bool {
        self.ipsr != 0 || !self.unprivileged
    }

    const fn control(self) -> u32 {
        self.unprivileged as u32 | (self.process_stack as u32) << 1 | (self.fpca as u32) << 2
    }
}

impl Cpu {
    /// The special register that MRS knows by this number (DDI 0403, B5.1.1), as the current mode
    /// reads it. Unprivileged code reads zero where only privileged code may read, and a number
    /// that stands for no register reads zero.
    #[must_use]
    pub fn mrs(&self, sysm: u8) -> u32 {
        let privileged = self.special.privileged();
        match sysm {
            // EPSR reads as zero.
            0..=7 => {
                let apsr = if sysm & 4 == 0 { self.apsr() } else { 0 };
                apsr | if sysm & 1 == 1 { u32::from(self.special.ipsr) } else { 0 }
            }
            8 if privileged => self.main_sp(),
            9 if privileged => self.process_sp(),
            16 if privileged => u32::from(self.exceptions.priorities.primask()),
            17 | 18 if privileged => u32::from(self.exceptions.priorities.basepri()),
            19 if privileged => u32::from(self.exceptions.priorities.faultmask()),
            20 => self.special.control(),
            _ => 0,
        }
    }

    /// MSR. `mask` is the instruction's: bit 1 for NZCVQ, bit 0 for GE.
    pub(crate) fn msr(&mut self, sysm: u8, mask: u8, value: u32) {
        let privileged = self.special.privileged();
        match sysm {
            0..=3 => {
                let keep = if mask & 2 == 0 { N | Z | C | V | Q } else { 0 }
                    | if mask & 1 == 0 { 0xF << 16 } else { 0 };
                self.set_apsr(self.apsr() & keep | value & !keep);
            }
            8 if privileged => *self.main_sp_mut() = value & !3,
            9 if privileged => *self.process_sp_mut() = value & !3,
            16 if privileged => self.set_primask(value & 1 != 0),
            17 if privileged => self.set_basepri(value as u8),
            18 if privileged => {
                let (now, wanted) = (self.exceptions.priorities.basepri(), value as u8 & 0xF0);
                if wanted != 0 && (wanted < now || now == 0) {
                    self.set_basepri(wanted);
                }
            }
            19 if privileged => self.set_faultmask(value & 1 != 0),
            20 if privileged => {
                self.special.unprivileged = value & 1 != 0;
                self.special.fpca = value & 4 != 0;
                if self.special.ipsr == 0 {
                    self.select_stack(value & 2 != 0);
                }
                self.weigh_fpu();
            }
            _ => {}
        }
    }

    /// CPSIE and CPSID.
    pub(crate) fn cps(&mut self, enable: bool, i: bool, f: bool) {
        if !self.special.privileged() {
            return;
        }
        if i {
            self.set_primask(!enable);
        }
        if f {
            self.set_faultmask(!enable);
        }
    }

    fn set_primask(&mut self, on: bool) {
        self.exceptions.priorities.set_primask(on);
        self.reconsider();
    }

    fn set_basepri(&mut self, value: u8) {
        self.exceptions.priorities.set_basepri(value);
        self.reconsider();
    }

    /// Sets FAULTMASK, but not in HardFault and NMI, where it would change nothing.
    fn set_faultmask(&mut self, on: bool) {
        if !on || self.exceptions.priorities.execution() > -1 {
            self.exceptions.priorities.set_faultmask(on);
            self.reconsider();
        }
    }

    /// To be called when a pending exception may have become eligible.
    #[inline]
    pub(super) fn reconsider(&mut self) {
        if self.exceptions.wants_in() {
            self.deadline = 0;
        }
    }

    /// APSR.
    pub(crate) fn apsr(&self) -> u32 {
        let flags = self.flags;
        [(flags.n, N), (flags.z, Z), (flags.c, C), (flags.v, V), (flags.q, Q)]
            .into_iter()
            .fold(u32::from(flags.ge) << 16, |sum, (set, bit)| if set { sum | bit } else { sum })
    }

    /// Sets APSR.
    pub(crate) fn set_apsr(&mut self, value: u32) {
        self.flags = super::Flags {
            n: value & N != 0,
            z: value & Z != 0,
            c: value & C != 0,
            v: value & V != 0,
            q: value & Q != 0,
            ge: (value >> 16) as u8 & 0xF,
        };
    }

    /// APSR, IPSR and EPSR in one word, as a frame on the stack holds them.
    #[must_use]
    pub fn xpsr(&self) -> u32 {
        let it = u32::from(self.it);
        self.apsr()
            | (it & 3) << 25
            | (it >> 2) << 10
            | if self.thumb { T } else { 0 }
            | u32::from(self.special.ipsr)
    }

    /// Sets APSR, IPSR and EPSR. An interrupted LDM or STM that a frame tells of (ICI) is executed
    /// from its beginning, as B1.5.10 leaves a processor free to do.
    pub(crate) fn set_xpsr(&mut self, value: u32) {
        self.set_apsr(value);
        let it = (value >> 25 & 3 | value >> 8 & 0xFC) as u8;
        self.it = if it & 0xF == 0 { 0 } else { it };
        self.thumb = value & T != 0;
        self.special.ipsr = (value & IPSR) as u16;
        self.deadline = 0;
    }

    /// SP_main.
    fn main_sp(&self) -> u32 {
        if self.special.process_stack { self.other_sp } else { self.r[13] }
    }

    /// SP_process.
    fn process_sp(&self) -> u32 {
        if self.special.process_stack { self.r[13] } else { self.other_sp }
    }

    fn main_sp_mut(&mut self) -> &mut u32 {
        if self.special.process_stack { &mut self.other_sp } else { &mut self.r[13] }
    }

    pub(super) fn process_sp_mut(&mut self) -> &mut u32 {
        if self.special.process_stack { &mut self.r[13] } else { &mut self.other_sp }
    }

    /// CONTROL.SPSEL.
    pub(super) fn select_stack(&mut self, process: bool) {
        if self.special.process_stack != process {
            std::mem::swap(&mut self.r[13], &mut self.other_sp);
            self.special.process_stack = process;
        }
    }
}

#[cfg(test)]
mod tests;
