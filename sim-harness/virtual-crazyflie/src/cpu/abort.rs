//! Why an instruction was abandoned.

use super::exceptions::Fault;
use crate::bus::{Refused, Width};

/// Why an instruction was abandoned. The program counter is at it, and it has no effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Abort {
    Fault(Fault),
    Trap,
    Breakpoint,
    Refused { address: u32, store: bool, width: Width, why: Refused },
    Unpredictable,
}
