//! Faults of instructions, and the exceptions that they raise (DDI 0403, B1.5.14).

use super::super::Cpu;
use super::priorities::bit;
use super::priorities::number::{
    BUS_FAULT, DEBUG_MONITOR, HARD_FAULT, MEM_MANAGE, SV_CALL, USAGE_FAULT,
};
use crate::memory::Memory;

/// A fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// UsageFault, UNDEFINSTR.
    Undefined,
    /// UsageFault, INVSTATE: execution without the Thumb bit.
    InvalidState,
    /// UsageFault, INVPC: a return that does not fit.
    InvalidReturn {
        /// The value that was returned with.
        exc_return: u32,
    },
    /// UsageFault, NOCP: the FPU is not enabled, or there is no such coprocessor.
    NoCoprocessor,
    /// UsageFault, UNALIGNED.
    Unaligned {
        /// The address of the access.
        address: u32,
    },
    /// UsageFault, DIVBYZERO.
    DivideByZero,
    /// MemManage, IACCVIOL: execution where memory is execute-never.
    ExecuteNever {
        /// The address of the instruction.
        address: u32,
    },
    /// BusFault, IBUSERR: execution where nothing is.
    FetchBus {
        /// The address of the instruction.
        address: u32,
    },
    /// BusFault, PRECISERR.
    DataBus {
        /// The address of the access.
        address: u32,
    },
    /// BusFault, STKERR: the frame of an exception found no room.
    Stacking,
    /// BusFault, UNSTKERR: a frame cannot be read.
    Unstacking,
    /// BusFault, LSPERR: what was to be saved lazily found no room.
    LazySave,
    /// HardFault, VECTTBL: no vector can be read.
    VectorTable {
        /// The number of its exception.
        exception: u16,
    },
    /// HardFault, FORCED: SVC where its priority does not allow it.
    Supervisor {
        /// Its immediate.
        number: u8,
    },
    /// DebugMonitor, or HardFault with DEBUGEVT: BKPT without a debugger.
    Breakpoint,
}

/// Bits of CFSR (B3.2.15).
pub(crate) mod cfsr {
    pub(crate) const IACCVIOL: u32 = 1;
    pub(crate) const IBUSERR: u32 = 1 << 8;
    pub(crate) const PRECISERR: u32 = 1 << 9;
    pub(crate) const UNSTKERR: u32 = 1 << 11;
    pub(crate) const STKERR: u32 = 1 << 12;
    pub(crate) const LSPERR: u32 = 1 << 13;
    pub(crate) const BFARVALID: u32 = 1 << 15;
    pub(crate) const UNDEFINSTR: u32 = 1 << 16;
    pub(crate) const INVSTATE: u32 = 1 << 17;
    pub(crate) const INVPC: u32 = 1 << 18;
    pub(crate) const NOCP: u32 = 1 << 19;
    pub(crate) const UNALIGNED: u32 = 1 << 24;
    pub(crate) const DIVBYZERO: u32 = 1 << 25;
    /// All of them, those included that need an MPU or a write buffer.
    pub(crate) const MASK: u32 = 0x030F_BFBB;
}

/// Bits of HFSR (B3.2.16).
pub(crate) mod hfsr {
    pub(crate) const VECTTBL: u32 = 1 << 1;
    pub(crate) const FORCED: u32 = 1 << 30;
    pub(crate) const DEBUGEVT: u32 = 1 << 31;
    pub(crate) const MASK: u32 = VECTTBL | FORCED | DEBUGEVT;
}

/// DFSR.BKPT.
const DFSR_BKPT: u32 = 1 << 1;

impl Fault {
    /// The exception that it is before it escalates, and the bits that it sets in CFSR.
    const fn kind(self) -> (u16, u32) {
        match self {
            Self::Undefined => (USAGE_FAULT, cfsr::UNDEFINSTR),
            Self::InvalidState => (USAGE_FAULT, cfsr::INVSTATE),
            Self::InvalidReturn { .. } => (USAGE_FAULT, cfsr::INVPC),
            Self::NoCoprocessor => (USAGE_FAULT, cfsr::NOCP),
            Self::Unaligned { .. } => (USAGE_FAULT, cfsr::UNALIGNED),
            Self::DivideByZero => (USAGE_FAULT, cfsr::DIVBYZERO),
            Self::ExecuteNever { .. } => (MEM_MANAGE, cfsr::IACCVIOL),
            Self::FetchBus { .. } => (BUS_FAULT, cfsr::IBUSERR),
            Self::DataBus { .. } => (BUS_FAULT, cfsr::PRECISERR | cfsr::BFARVALID),
            Self::Stacking => (BUS_FAULT, cfsr::STKERR),
            Self::Unstacking => (BUS_FAULT, cfsr::UNSTKERR),
            Self::LazySave => (BUS_FAULT, cfsr::LSPERR),
            Self::VectorTable { .. } => (HARD_FAULT, 0),
            Self::Supervisor { .. } => (SV_CALL, 0),
            Self::Breakpoint => (DEBUG_MONITOR, 0),
        }
    }
}

impl Cpu {
    /// A fault of the instruction at the program counter, which has had no effect. It is pending
    /// afterwards, or the core is locked up.
    pub(crate) fn fault(&mut self, memory: &mut Memory, fault: Fault) {
        self.raise(memory, fault);
    }

    /// Sets the status registers and pends what becomes of it: the exception itself, or HardFault
    /// where that may not come in, or nothing any more where HardFault may not either.
    pub(super) fn raise(&mut self, memory: &Memory, fault: Fault) {
        let (exception, bits) = fault.kind();
        let status = &mut self.control.faults;
        status.cfsr |= bits;
        match fault {
            Fault::DataBus { address } => status.bfar = address,
            Fault::Breakpoint => status.dfsr |= DFSR_BKPT,
            _ => {}
        }
        let (allowed, hard_fault_allowed) = match fault {
            // Decided when the room was left, not now.
            Fault::LazySave => self.control.fp.save_may_raise(),
            Fault::VectorTable { .. } => (false, self.exceptions.priorities.execution() > -1),
            _ => (
                self.exceptions.priorities.may_enter(exception),
                self.exceptions.priorities.execution() > -1,
            ),
        };
        if allowed {
            self.report(memory, fault, Some(exception));
            self.pend(bit(exception));
        } else if hard_fault_allowed {
            self.control.faults.hfsr |= match fault {
                Fault::VectorTable { .. } => hfsr::VECTTBL,
                Fault::Breakpoint => hfsr::DEBUGEVT,
                _ => hfsr::FORCED,
            };
            self.report(memory, fault, Some(HARD_FAULT));
            self.pend(bit(HARD_FAULT));
        } else {
            self.lock_up(memory, fault);
        }
        self.deadline = 0;
    }
}
