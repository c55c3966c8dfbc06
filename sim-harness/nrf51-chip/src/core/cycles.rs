//! The cycles that an instruction takes: ARM's Cortex-M0 Technical Reference Manual (r0p0), table 3-1,
//! with memory that adds no wait state.
//!
//! | instruction | cycles |
//! |---|---|
//! | arithmetic, logic, shifts, extensions | 1 |
//! | MULS | 1 (the manual's fast multiplier) |
//! | ADD, MOV to PC | 3 |
//! | LDR, STR of every width | 2 |
//! | LDM, STM, PUSH, POP of N registers | 1 + N; POP to PC 4 + N, with PC among the N |
//! | branch, taken | 3 |
//! | branch, not taken | 1 |
//! | BL | 4 |
//! | BX, BLX | 3 |
//! | MRS, MSR, barriers | 4 |
//! | WFI, WFE | 2 |
//! | an exception's entry | 16 (the manual's interrupt latency) |
//!
//! The manual gives no cycles for the return from an exception. This model counts those of the BX or
//! POP that returns, one for each of the eight words that come from the stack, and nothing else.
//! Real flash and forwarded interrupts can only be slower.

use super::op::Op;

/// Cycles of DMB, DSB and ISB.
pub(super) const BARRIER: u8 = 4;
/// Cycles from an interrupt to its handler's first instruction.
pub(super) const ENTRY: u32 = 16;
/// Cycles of a return from an exception besides its BX or POP.
pub(super) const RETURN: u32 = 8;
/// Cycles that a taken branch takes besides its own one.
pub(super) const TAKEN: u32 = 2;

/// Cycles of an instruction; a branch with a condition is not taken.
pub(super) const fn of(op: Op) -> u32 {
    match op {
        Op::AddAny { d: 15, .. } | Op::MovAny { d: 15, .. } => 3,
        Op::LoadLiteral { .. } | Op::AccessRegister { .. } | Op::AccessConstant { .. } => 2,
        Op::Push { list } => 1 + list.count_ones(),
        Op::Pop { list } if list & 1 << 15 == 0 => 1 + list.count_ones(),
        Op::Pop { list } => 4 + list.count_ones(),
        Op::StoreMany { list, .. } | Op::LoadMany { list, .. } => 1 + list.count_ones(),
        Op::BranchExchange { .. } | Op::CallExchange { .. } | Op::Branch { .. } => 3,
        Op::Call { .. } | Op::ReadSpecial { .. } | Op::WriteSpecial { .. } => 4,
        Op::Wait => 2,
        Op::Nothing { cycles } => cycles as u32,
        _ => 1,
    }
}
