//! Describes what an instruction does to control flow, to the stack pointer and to values that can
//! be known before it runs: what an analysis of a program needs that does not execute it.

use crate::bus::Width;

use super::decode::decode;
use super::op::{Kind, Mode, Multiple, Op, ToSp};
use super::program::advanced;

#[cfg(test)]
mod tests;

const SP: u8 = 13;
const PC: u8 = 15;

/// One instruction of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Instruction {
    /// The address.
    pub address: u32,
    /// The length in bytes: 2 or 4.
    pub size: u32,
    /// The effect may also be none, and execution falls through: a branch on a condition, or an
    /// instruction of an IT block.
    pub conditional: bool,
    /// The effect.
    pub effect: Effect,
}

/// The effect of an instruction. Unless said otherwise, execution falls through to the next one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Execution continues at this address.
    Jump(u32),
    /// Execution continues at the address that a register holds; with LR this is a return.
    JumpRegister(u8),
    /// Execution continues at one of these addresses, which a table behind the instruction holds.
    /// Padding of the table can look like a target outside the function.
    JumpTable(Vec<u32>),
    /// The function at this address is called.
    Call(u32),
    /// The function whose address a register holds is called.
    CallRegister(u8),
    /// Execution ends here: the encoding is undefined and faults.
    Fault,
    /// The stack pointer moves, and registers are loaded from the stack. A load of PC is a return.
    Stack {
        /// Bytes that the stack pointer moves up by; negative where it takes stack.
        by: i32,
        /// The registers that are loaded, one bit each.
        loaded: u16,
    },
    /// A register gets a value.
    Set {
        /// Which; never PC.
        register: u8,
        /// Its value.
        value: Value,
    },
    /// The main stack pointer becomes what this register holds.
    SetMainStack(u8),
    /// A store that may fail (STREX, STREXB, STREXH) to the address that `base` holds; the register
    /// `status` tells whether it did.
    StoreExclusive {
        /// The register with the address.
        base: u8,
        /// The register that gets the status.
        status: u8,
        /// Whether it stores one byte.
        byte: bool,
    },
    /// Registers, one bit each, get values that are not described; neither SP nor PC is among them.
    Clobbers(u16),
    /// The instruction changes SP or PC in a way that is not described.
    Opaque(&'static str),
}

/// The value that a register gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Value {
    /// A number.
    Constant(u32),
    /// A register plus a number, which wraps.
    Offset(u8, u32),
    /// One register plus another.
    Sum(u8, u8),
    /// One register minus another.
    Difference(u8, u8),
    /// The lower half of a register under a new upper half.
    UpperHalf(u8, u32),
    /// The bits of a register that are set in a mask.
    Masked(u8, u32),
}

/// The surroundings of an instruction in its program.
pub(crate) struct Surroundings<'a> {
    /// The halfword at an address.
    pub(crate) half: &'a dyn Fn(u32) -> Option<u16>,
    /// The beginning of the next instruction, which ends a branch table.
    pub(crate) next: u32,
}

/// Reads instructions in the order in which they lie in memory, and keeps track of IT blocks.
#[derive(Default)]
pub(crate) struct Decoder {
    /// ITSTATE of the next instruction.
    it: u8,
}

impl Decoder {
    /// The instruction with these halfwords; the second counts only if there is one.
    pub(crate) fn next(
        &mut self,
        address: u32,
        (first, second): (u16, u16),
        around: &Surroundings<'_>,
    ) -> Instruction {
        const ALWAYS: u8 = 0b1110;
        let op = decode(address, first, second);
        let in_block = self.it != 0 && self.it >> 4 != ALWAYS;
        self.it = if op.kind == Kind::It { op.imm as u8 } else { advanced(self.it) };
        Instruction {
            address,
            size: op.len.into(),
            conditional: in_block || has_condition(&op),
            effect: effect(&op, around),
        }
    }
}

const fn has_condition(op: &Op) -> bool {
    op.kind.condition().is_some() || matches!(op.kind, Kind::Cbz | Kind::Cbnz)
}

fn effect(op: &Op, around: &Surroundings<'_>) -> Effect {
    control(op, around).or_else(|| stack(op)).or_else(|| system(op)).unwrap_or_else(|| {
        match computed(op, around) {
            Some((PC, _)) => Effect::Opaque("a computed jump"),
            Some((register, value)) => Effect::Set { register, value },
            None => clobbers(op),
        }
    })
}

/// Branches, calls and returns.
fn control(op: &Op, around: &Surroundings<'_>) -> Option<Effect> {
    Some(match op.kind {
        Kind::Bl => Effect::Call(op.imm),
        kind if kind.branches() => Effect::Jump(op.imm),
        Kind::Blx => Effect::CallRegister(op.m),
        Kind::Bx | Kind::MovPc => Effect::JumpRegister(op.m),
        Kind::Tbb => table(op, around, 1),
        Kind::Tbh => table(op, around, 2),
        Kind::AddPc => Effect::Opaque("a computed jump"),
        Kind::Undefined | Kind::NoCoprocessor => Effect::Fault,
        Kind::Unpredictable => Effect::Opaque("the manual leaves open what this does"),
        _ => return None,
    })
}

fn table(op: &Op, around: &Surroundings<'_>, width: u32) -> Effect {
    if op.n != PC {
        return Effect::Opaque("a branch table that does not follow its branch");
    }
    let start = op.imm;
    let entries = around.next.saturating_sub(start) / width;
    let target = |entry: u32| {
        let at = start + entry * width;
        let half = (around.half)(at & !1)?;
        let distance = match (width, at & 1) {
            (2, _) => half,
            (_, 0) => half & 0xFF,
            _ => half >> 8,
        };
        Some(start + 2 * u32::from(distance))
    };
    match (0..entries).map(target).collect::<Option<Vec<u32>>>() {
        Some(mut targets) => {
            targets.sort_unstable();
            targets.dedup();
            Effect::JumpTable(targets)
        }
        None => Effect::Opaque("a branch table outside the program"),
    }
}

/// Pushes and pops, under whatever name.
fn stack(op: &Op) -> Option<Effect> {
    let registers = op.imm as u16;
    let words = |count: u32| 4 * count as i32;
    let (by, loaded) = match op.kind {
        Kind::Push => (-words(op.imm.count_ones()), 0),
        Kind::Pop | Kind::PopPc => (words(op.imm.count_ones()), registers),
        _ if op.n != SP => return None,
        Kind::StorePre(_) | Kind::StorePost(_) => (op.imm as i32, 0),
        Kind::Strd(Mode::Pre | Mode::Post) => (op.imm as i32, 0),
        Kind::LoadPre(_) | Kind::LoadPost(_) => (op.imm as i32, 1 << op.d),
        Kind::LoadPc(Mode::Pre | Mode::Post) => (op.imm as i32, 1 << PC),
        Kind::Ldrd(Mode::Pre | Mode::Post) => (op.imm as i32, 1 << op.d | 1 << op.a),
        Kind::Vldm(how) | Kind::Vstm(how) => match how {
            Multiple::From => return None,
            Multiple::FromAndUpdate => (words(op.a.into()), 0),
            Multiple::UpToAndUpdate => (-words(op.a.into()), 0),
        },
        Kind::LdmIa | Kind::LdmDb | Kind::StmIa | Kind::StmDb if op.a != 0 => {
            return Some(Effect::Opaque("a list that moves the stack pointer the other way"));
        }
        _ => return None,
    };
    Some(Effect::Stack { by, loaded })
}

/// Special registers, and exclusive stores.
fn system(op: &Op) -> Option<Effect> {
    const MSP: u32 = 8;
    const PSP: u32 = 9;
    const CONTROL: u32 = 20;
    Some(match (op.kind, op.imm) {
        (Kind::Msr, MSP) => Effect::SetMainStack(op.n),
        (Kind::Msr, PSP | CONTROL) => Effect::Opaque("the process stack"),
        (Kind::Strex, _) => Effect::StoreExclusive { base: op.n, status: op.d, byte: false },
        (Kind::StrexNarrow(width), _) => {
            let byte = width == Width::Byte;
            Effect::StoreExclusive { base: op.n, status: op.d, byte }
        }
        _ => return None,
    })
}

/// The register that gets a value that is described, and the value.
fn computed(op: &Op, around: &Surroundings<'_>) -> Option<(u8, Value)> {
    let minus = op.imm.wrapping_neg();
    let value = match op.kind {
        Kind::AddImm | Kind::AddImmS => Value::Offset(op.n, op.imm),
        Kind::SubImm | Kind::SubImmS => Value::Offset(op.n, minus),
        Kind::ToSp(to) | Kind::ToSpS(to) => match to {
            ToSp::Mov => Value::Offset(op.m, 0),
            ToSp::AddImm => Value::Offset(op.n, op.imm),
            ToSp::SubImm => Value::Offset(op.n, minus),
            ToSp::Add if op.a == 0 => Value::Sum(op.n, op.m),
            ToSp::Sub if op.a == 0 => Value::Difference(op.n, op.m),
            ToSp::Add | ToSp::Sub => return None,
        },
        Kind::AddReg | Kind::AddRegS => Value::Sum(op.n, op.m),
        Kind::SubReg | Kind::SubRegS => Value::Difference(op.n, op.m),
        Kind::MovReg | Kind::MovRegS => Value::Offset(op.m, 0),
        Kind::MovImm | Kind::MovImmS => Value::Constant(op.imm),
        Kind::Movt => Value::UpperHalf(op.d, op.imm),
        Kind::AndImm | Kind::AndImmS => Value::Masked(op.n, op.imm),
        Kind::Bfc => Value::Masked(op.d, !(op.imm << op.a)),
        Kind::LdrLiteral => {
            let (low, high) = ((around.half)(op.imm)?, (around.half)(op.imm.wrapping_add(2))?);
            Value::Constant(u32::from(high) << 16 | u32::from(low))
        }
        _ => return None,
    };
    Some((op.d, value))
}

/// The registers that an instruction writes without their values being described.
fn clobbers(op: &Op) -> Effect {
    let written = written(op);
    if written & 1 << PC != 0 {
        Effect::Opaque("a jump through memory")
    } else if written & 1 << SP != 0 {
        Effect::Opaque("the stack pointer gets a value that is not known")
    } else {
        Effect::Clobbers(written)
    }
}

fn written(op: &Op) -> u16 {
    // Of a floating-point instruction a field can have the number of a register beyond R15.
    let bit = |field: u8| 1_u16 << (field & 15);
    let (d, n, a) = (bit(op.d), bit(op.n), bit(op.a));
    match op.kind {
        kind if writes_nothing(kind) => 0,
        Kind::Vmrs if op.d == PC => 0,
        Kind::Ldrd(Mode::Pre | Mode::Post) => d | a | n,
        Kind::Long(_) | Kind::VmovToCores | Kind::Ldrd(_) => d | a,
        Kind::LoadPre(_) | Kind::LoadPost(_) => d | n,
        Kind::LoadPc(Mode::Pre | Mode::Post) | Kind::LoadSp(Mode::Pre | Mode::Post) => d | n,
        Kind::StorePre(_) | Kind::StorePost(_) | Kind::Strd(Mode::Pre | Mode::Post) => n,
        Kind::LdmIa | Kind::LdmDb => op.imm as u16 | if op.a != 0 { n } else { 0 },
        Kind::StmIa | Kind::StmDb if op.a != 0 => n,
        Kind::StmIa | Kind::StmDb => 0,
        Kind::Vldm(Multiple::From) | Kind::Vstm(Multiple::From) => 0,
        Kind::Vldm(_) | Kind::Vstm(_) => n,
        _ => d,
    }
}

/// Whether no core register is written.
const fn writes_nothing(kind: Kind) -> bool {
    compares(kind) || stores(kind) || is_floating(kind) || is_hint(kind)
}

const fn compares(kind: Kind) -> bool {
    matches!(
        kind,
        Kind::CmpImm
            | Kind::CmnImm
            | Kind::TstImm
            | Kind::TeqImm
            | Kind::CmpReg
            | Kind::CmnReg
            | Kind::TstReg
            | Kind::TeqReg
            | Kind::CmpShifted(_)
            | Kind::CmnShifted(_)
            | Kind::TstShifted(_)
            | Kind::TeqShifted(_)
    )
}

const fn stores(kind: Kind) -> bool {
    matches!(
        kind,
        Kind::StrImm
            | Kind::StrReg
            | Kind::StrbImm
            | Kind::StrbReg
            | Kind::StrhImm
            | Kind::StrhReg
            | Kind::StoreUnprivileged(_)
            | Kind::Strd(Mode::Offset | Mode::Register | Mode::Literal)
    )
}

/// Whether only floating-point registers are written.
const fn is_floating(kind: Kind) -> bool {
    matches!(
        kind,
        Kind::Vadd
            | Kind::Vsub
            | Kind::Vmul
            | Kind::Vnmul
            | Kind::Vdiv
            | Kind::Vmla
            | Kind::Vmls
            | Kind::Accumulate(_)
            | Kind::Vsqrt
            | Kind::Vabs
            | Kind::Vneg
            | Kind::Vmov
            | Kind::VmovImm
            | Kind::Vcmp(_)
            | Kind::VcmpZero(_)
            | Kind::VcvtToInt(..)
            | Kind::VcvtFromInt(_)
            | Kind::VcvtToFixed(_)
            | Kind::VcvtFromFixed(_)
            | Kind::VcvtFromHalf(_)
            | Kind::VcvtToHalf(_)
            | Kind::VmovFromCore
            | Kind::VmovFromCores
            | Kind::Vmsr
            | Kind::Vldr
            | Kind::Vstr
            | Kind::VldrLiteral
            | Kind::VldrDouble
            | Kind::VstrDouble
            | Kind::VldrDoubleLiteral
    )
}

const fn is_hint(kind: Kind) -> bool {
    matches!(
        kind,
        Kind::Nop
            | Kind::Barrier
            | Kind::Wfe
            | Kind::Wfi
            | Kind::Sev
            | Kind::Svc
            | Kind::Bkpt
            | Kind::Msr
            | Kind::Cps(_)
            | Kind::Clrex
            | Kind::It
    )
}
