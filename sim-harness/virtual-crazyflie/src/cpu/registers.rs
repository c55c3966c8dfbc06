//! The core as a debugger or a test sees it: registers, flags, counts.

use super::control::Control;
use super::exceptions::Exceptions;
use super::fp::Fpscr;
use super::special::Special;
use super::timing::{FlashTiming, Timing};
use super::{Cpu, Flags, Fpu};

impl Cpu {
    /// A core that has been switched on and has not yet read its vector table.
    #[must_use]
    pub fn new() -> Self {
        Self {
            r: [0; 16],
            other_sp: 0,
            flags: Flags::default(),
            it: 0,
            fpu: Fpu { s: [0; 32], fpscr: Fpscr::default(), ready: false },
            special: Special::default(),
            exceptions: Exceptions::new(),
            control: Control::new(),
            thumb: true,
            abort: None,
            abandoned: false,
            timing: Timing::default(),
            exclusive: None,
            event: false,
            asleep: None,
            cycles: 0,
            slept: 0,
            instructions: 0,
            deadline: 0,
        }
    }

    /// R0 to R15. R15 is the address of the instruction that is executed next.
    #[must_use]
    pub const fn register(&self, n: usize) -> u32 {
        self.r[n & 15]
    }

    /// Sets R0 to R15, for the instruction that is executed next.
    pub const fn set_register(&mut self, n: usize, value: u32) {
        self.r[n & 15] = match n & 15 {
            13 => value & !3,
            15 => value & !1,
            _ => value,
        };
        self.deadline = 0;
    }

    /// S0 to S31, as bits.
    #[must_use]
    pub const fn s(&self, n: usize) -> u32 {
        self.fpu.s[n & 31]
    }

    /// Sets S0 to S31.
    pub const fn set_s(&mut self, n: usize, bits: u32) {
        self.fpu.s[n & 31] = bits;
    }

    /// The condition flags, Q and GE.
    #[must_use]
    pub const fn flags(&self) -> Flags {
        self.flags
    }

    /// Sets them.
    pub const fn set_flags(&mut self, flags: Flags) {
        self.flags = Flags { ge: flags.ge & 15, ..flags };
    }

    /// ITSTATE of the instruction that is executed next: zero outside an IT block.
    #[must_use]
    pub const fn itstate(&self) -> u8 {
        self.it
    }

    /// Sets it.
    pub const fn set_itstate(&mut self, it: u8) {
        self.it = it;
        self.deadline = 0;
    }

    /// Whether the core executes Thumb code: EPSR.T. Without it the next instruction faults.
    #[must_use]
    pub const fn is_thumb(&self) -> bool {
        self.thumb
    }

    /// Enables the floating-point unit and marks the current context as using it, as a program
    /// does with CPACR and CONTROL.FPCA.
    pub fn enable_fpu(&mut self) {
        self.enable_coprocessors();
        self.special.fpca = true;
        self.weigh_fpu();
    }

    /// The floating-point status and control register.
    #[must_use]
    pub const fn fpscr(&self) -> Fpscr {
        self.fpu.fpscr
    }

    /// Sets it.
    pub const fn set_fpscr(&mut self, fpscr: Fpscr) {
        self.fpu.fpscr = fpscr;
    }

    /// The address of the instruction that is executed next.
    #[must_use]
    pub const fn pc(&self) -> u32 {
        self.r[15]
    }

    /// Cycles since power-up, sleep included.
    #[must_use]
    pub const fn cycles(&self) -> u64 {
        self.cycles
    }

    /// The part of these cycles that the core slept.
    #[must_use]
    pub const fn slept(&self) -> u64 {
        self.slept
    }

    /// Instructions executed, those that failed their condition included.
    #[must_use]
    pub const fn instructions(&self) -> u64 {
        self.instructions
    }

    /// Whether it sleeps in WFE or WFI.
    #[must_use]
    pub const fn is_asleep(&self) -> bool {
        self.asleep.is_some()
    }

    /// The cost of a fetch from flash, until the bus reports other wait states.
    pub fn set_flash_timing(&mut self, timing: FlashTiming, wait_states: u8) {
        self.timing.set_flash(timing, wait_states);
    }
}

impl Default for Cpu {
    fn default() -> Self {
        Self::new()
    }
}
