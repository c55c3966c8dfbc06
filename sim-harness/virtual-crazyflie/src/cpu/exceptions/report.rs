//! The report of a fault that the machine keeps for its caller.

use std::fmt;

use super::super::Cpu;
use super::fault::{Fault, cfsr, hfsr};
use super::priorities::number::HARD_FAULT;
use crate::bus::Width;
use crate::memory::Memory;

/// The number of faults that are kept: the first ones, as later faults often follow from them.
const KEPT: usize = 16;

/// A fault that happened: what, where, and what the registers say of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaultReport {
    /// The fault.
    pub fault: Fault,
    /// The number of the exception that it made pending: its own, or HardFault's. None where
    /// nothing could be done, and the core is locked up.
    pub exception: Option<u16>,
    /// The program counter: the instruction that failed, or the one that came next where none did.
    pub pc: u32,
    /// The word there, its first halfword lowest, if there is memory.
    pub code: Option<u32>,
    /// The link register.
    pub lr: u32,
    /// The stack pointer in use.
    pub sp: u32,
    /// XPSR.
    pub xpsr: u32,
    /// CFSR, this fault's bits among others that were not cleared.
    pub cfsr: u32,
    /// HFSR, likewise.
    pub hfsr: u32,
    /// BFAR, where CFSR.BFARVALID says that it holds an address.
    pub bfar: Option<u32>,
    /// When.
    pub cycle: u64,
}

/// The first so many, and how many there were.
#[derive(Clone, Debug, Default)]
pub(super) struct Reports {
    kept: Vec<FaultReport>,
    seen: u64,
}

impl Cpu {
    /// The first faults since power-up, in their order.
    #[must_use]
    pub fn faults(&self) -> &[FaultReport] {
        &self.exceptions.reports.kept
    }

    /// The number of faults, those included that are not kept.
    #[must_use]
    pub const fn fault_count(&self) -> u64 {
        self.exceptions.reports.seen
    }

    pub(super) fn report(&mut self, memory: &Memory, fault: Fault, exception: Option<u16>) {
        let status = &self.control.faults;
        let report = FaultReport {
            fault,
            exception,
            pc: self.r[15],
            code: memory.load(self.r[15], Width::Word),
            lr: self.r[14],
            sp: self.r[13],
            xpsr: self.xpsr(),
            cfsr: status.cfsr,
            hfsr: status.hfsr,
            bfar: (status.cfsr & cfsr::BFARVALID != 0).then_some(status.bfar),
            cycle: self.cycles,
        };
        let reports = &mut self.exceptions.reports;
        reports.seen += 1;
        if reports.kept.len() < KEPT {
            reports.kept.push(report);
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Undefined => f.write_str("UsageFault: an undefined instruction"),
            Self::InvalidState => f.write_str("UsageFault: execution without the Thumb bit"),
            Self::InvalidReturn { exc_return } => {
                write!(f, "UsageFault: an exception return that does not fit, {exc_return:#010x}")
            }
            Self::NoCoprocessor => {
                f.write_str("UsageFault: the FPU is not enabled, or no such coprocessor")
            }
            Self::Unaligned { address } => {
                write!(f, "UsageFault: an unaligned access at {address:#010x}")
            }
            Self::DivideByZero => f.write_str("UsageFault: a division by zero"),
            Self::ExecuteNever { address } => {
                write!(f, "MemManage: execution at {address:#010x}, which is execute-never")
            }
            Self::FetchBus { address } => {
                write!(f, "BusFault: execution at {address:#010x}, where nothing is")
            }
            Self::DataBus { address } => {
                write!(f, "BusFault: an access at {address:#010x}, where nothing is")
            }
            Self::Stacking => f.write_str("BusFault: no room on the stack for an exception"),
            Self::Unstacking => f.write_str("BusFault: a return from a stack that is not there"),
            Self::LazySave => {
                f.write_str("BusFault: no room for floating-point state that is saved late")
            }
            Self::VectorTable { exception } => {
                write!(f, "the vector of exception {exception} cannot be read")
            }
            Self::Supervisor { number } => {
                write!(f, "SVC {number} where SVCall may not come in")
            }
            Self::Breakpoint => f.write_str("BKPT without a debugger"),
        }
    }
}

impl fmt::Display for FaultReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let outcome = match self.exception {
            Some(HARD_FAULT) => " (taken as HardFault)",
            Some(_) => "",
            None => " (lockup)",
        };
        writeln!(f, "{}{outcome}", self.fault)?;
        write!(f, "  PC {:#010x}", self.pc)?;
        match self.code {
            Some(code) => write!(f, " [{:04x} {:04x}]", code & 0xFFFF, code >> 16)?,
            None => write!(f, " [no memory]")?,
        }
        let Self { lr, sp, xpsr, cycle, .. } = self;
        writeln!(f, "  LR {lr:#010x}  SP {sp:#010x}  XPSR {xpsr:#010x}  cycle {cycle}")?;
        write!(f, "  CFSR {:#010x}{}", self.cfsr, Named(self.cfsr, &CFSR))?;
        write!(f, "  HFSR {:#010x}{}", self.hfsr, Named(self.hfsr, &HFSR))?;
        match self.bfar {
            Some(address) => write!(f, "  BFAR {address:#010x}"),
            None => Ok(()),
        }
    }
}

/// The names of the bits that are set.
struct Named<'a>(u32, &'a [(u32, &'static str)]);

impl fmt::Display for Named<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let set = self.1.iter().filter(|(bit, _)| self.0 & bit != 0);
        set.into_iter().try_for_each(|(_, name)| write!(f, " {name}"))
    }
}

const CFSR: [(u32, &str); 13] = [
    (cfsr::IACCVIOL, "IACCVIOL"),
    (cfsr::IBUSERR, "IBUSERR"),
    (cfsr::PRECISERR, "PRECISERR"),
    (cfsr::UNSTKERR, "UNSTKERR"),
    (cfsr::STKERR, "STKERR"),
    (cfsr::LSPERR, "LSPERR"),
    (cfsr::BFARVALID, "BFARVALID"),
    (cfsr::UNDEFINSTR, "UNDEFINSTR"),
    (cfsr::INVSTATE, "INVSTATE"),
    (cfsr::INVPC, "INVPC"),
    (cfsr::NOCP, "NOCP"),
    (cfsr::UNALIGNED, "UNALIGNED"),
    (cfsr::DIVBYZERO, "DIVBYZERO"),
];

const HFSR: [(u32, &str); 3] =
    [(hfsr::VECTTBL, "VECTTBL"), (hfsr::FORCED, "FORCED"), (hfsr::DEBUGEVT, "DEBUGEVT")];
