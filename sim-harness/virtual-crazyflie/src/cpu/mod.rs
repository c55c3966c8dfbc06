//! An ARMv7E-M core with a single-precision FPU, as the Cortex-M4F of an STM32F405 is one.
//!
//! | module | what it holds |
//! |---|---|
//! | `op`, `decode` | instructions, and how bits are decoded into them |
//! | [`effect`] | what each does, as an analysis sees it that does not execute |
//! | `execute` | what each does to registers and memory |
//! | `timing` | how many cycles each takes |
//! | `program` | a stretch of code, decoded beforehand |
//! | `registers` | the core as a debugger or a test sees it |
//! | `run` | the loop: events, exceptions, sleep, instructions |
//! | [`dsp`], [`fp`] | the arithmetic of the DSP and floating-point instructions, as plain functions |
//! | `abort` | why an instruction was abandoned |
//! | `special` | MRS, MSR, CPS: the special registers |
//! | `exceptions` | entry, return, priorities, the NVIC, faults |
//! | `control` | the system control space: SCB, NVIC, SysTick, DWT, FPU registers |
//!
//! Names, numbers of sections and pseudo-code are those of the ARMv7-M Architecture Reference
//! Manual (ARM DDI 0403).

mod abort;
mod control;
mod decode;
pub mod dsp;
pub mod effect;
mod exceptions;
mod execute;
pub mod fp;
mod op;
mod program;
mod registers;
mod run;
mod special;
mod timing;

use fp::Fpscr;

use control::Control;
pub use decode::is_wide;
use exceptions::Exceptions;
pub use exceptions::{Fault, FaultReport};
pub use program::Program;
pub use run::Stop;
use special::Special;
pub use timing::FlashTiming;

/// The condition flags, saturation, and the DSP's GE bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    /// Negative.
    pub n: bool,
    /// Zero.
    pub z: bool,
    /// Carry.
    pub c: bool,
    /// Overflow.
    pub v: bool,
    /// Saturation, sticky.
    pub q: bool,
    /// Greater or equal, one bit per byte.
    pub ge: u8,
}

/// The floating-point registers.
#[derive(Clone, Copy, Debug)]
pub struct Fpu {
    /// S0 to S31, as bits.
    pub s: [u32; 32],
    /// Status and control.
    pub fpscr: Fpscr,
    /// A floating-point instruction may go ahead at once: the unit is enabled, the current context
    /// is marked as using it (CONTROL.FPCA), and no lazy save is outstanding (FPCCR.LSPACT).
    /// Otherwise [`Cpu::prepare_fp`] comes first. A change to one of the three keeps it up to date.
    pub(crate) ready: bool,
}

/// Why the core sleeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sleep {
    /// WFE.
    Event,
    /// WFI, or return from an exception with SLEEPONEXIT.
    Interrupt,
}

/// The core.
pub struct Cpu {
    /// R0 to R12, the stack pointer in use, LR, and the address of the instruction that is
    /// executed next.
    pub(crate) r: [u32; 16],
    /// The stack pointer that is not in use.
    pub(crate) other_sp: u32,
    pub(crate) flags: Flags,
    /// ITSTATE of the instruction that is executed next.
    pub(crate) it: u8,
    pub(crate) fpu: Fpu,
    pub(crate) special: Special,
    pub(crate) exceptions: Exceptions,
    pub(crate) control: Control,
    /// EPSR.T. Cleared, the next instruction is a UsageFault; clearing it sets the
    /// deadline to zero.
    pub(crate) thumb: bool,
    /// Why the instruction at R15 was abandoned, until the run loop has dealt with it.
    pub(crate) abort: Option<abort::Abort>,
    /// The instruction that was executed last was abandoned.
    pub(crate) abandoned: bool,
    pub(crate) timing: timing::Timing,
    /// The address that the exclusive monitor watches.
    pub(crate) exclusive: Option<u32>,
    /// The event register of WFE.
    pub(crate) event: bool,
    /// Whether the core sleeps in WFE or WFI.
    pub(crate) asleep: Option<Sleep>,
    /// Cycles since power-up, sleep included.
    pub(crate) cycles: u64,
    /// The part of these cycles that the core slept.
    pub(crate) slept: u64,
    /// Instructions executed.
    pub(crate) instructions: u64,
    /// The cycle at which the run loop has something else to do than to execute. Zero when that is
    /// at once: a change to what may be pending sets it so.
    pub(crate) deadline: u64,
}
