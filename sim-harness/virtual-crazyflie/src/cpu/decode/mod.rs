//! Decodes instructions (DDI 0403, chapter A5).
//!
//! Decoding depends on the bits and the address only: whether an instruction stands in an IT block
//! matters when it is executed. What the manual leaves open is [`Kind::Unpredictable`] and stops the
//! machine; what it reserves is [`Kind::Undefined`] and is a fault.

mod float;
mod memory;
mod narrow;
#[cfg(test)]
mod tests;
mod wide;

use super::op::{Kind, Op, Shift};
use super::timing;

/// Whether an instruction whose first halfword is this one has a second halfword (DDI 0403, A5.1).
#[must_use]
pub const fn is_wide(first: u16) -> bool {
    first >= 0xE800
}

/// The instruction at an address. `second` counts only if the first half begins a 32-bit instruction.
pub(super) fn decode(address: u32, first: u16, second: u16) -> Op {
    let mut op = if is_wide(first) {
        Op { len: 4, ..wide::decode(address, u32::from(first), u32::from(second)) }
    } else {
        Op { len: 2, ..narrow::decode(address, u32::from(first)) }
    };
    op.cycles = timing::cycles(&op);
    op
}

const UNDEFINED: Op = Op::new(Kind::Undefined, 4);
const UNPREDICTABLE: Op = Op::new(Kind::Unpredictable, 4);

/// A field of an instruction that begins at a bit and has so many.
const fn field(bits: u32, at: u32, count: u32) -> u32 {
    bits >> at & ((1 << count) - 1)
}

const fn bit(bits: u32, at: u32) -> bool {
    bits >> at & 1 != 0
}

/// The number of a register that begins at a bit.
const fn reg(bits: u32, at: u32) -> u8 {
    field(bits, at, 4) as u8
}

/// SP or PC: what many instructions do not take.
const fn bad(register: u8) -> bool {
    register == 13 || register == 15
}

/// `bits` bits, the highest of which is the sign.
const fn signed(value: u32, bits: u32) -> u32 {
    ((value << (32 - bits)) as i32 >> (32 - bits)) as u32
}

/// The program counter as the operand of a literal, an ADR or a table: four ahead.
const fn pc(address: u32) -> u32 {
    address.wrapping_add(4)
}

/// The same, aligned.
const fn literal_base(address: u32) -> u32 {
    pc(address) & !3
}

/// `base` plus `offset`, or minus it.
const fn offset(base: u32, offset: u32, add: bool) -> u32 {
    if add { base.wrapping_add(offset) } else { base.wrapping_sub(offset) }
}

/// DecodeImmShift (A7.4.2): what is shifted, and how far.
const fn immediate_shift(kind: u32, amount: u32) -> (Shift, u8) {
    match (kind, amount) {
        (0, _) => (Shift::Lsl, amount as u8),
        (1, 0) => (Shift::Lsr, 32),
        (1, _) => (Shift::Lsr, amount as u8),
        (2, 0) => (Shift::Asr, 32),
        (2, _) => (Shift::Asr, amount as u8),
        (_, 0) => (Shift::Rrx, 1),
        _ => (Shift::Ror, amount as u8),
    }
}

const fn when(condition: bool, yes: Kind, no: Kind) -> Kind {
    if condition { yes } else { no }
}

/// B with a condition; `None` for "always" and what is no condition.
const fn conditional(condition: u32) -> Option<Kind> {
    Some(match condition {
        0 => Kind::Beq,
        1 => Kind::Bne,
        2 => Kind::Bcs,
        3 => Kind::Bcc,
        4 => Kind::Bmi,
        5 => Kind::Bpl,
        6 => Kind::Bvs,
        7 => Kind::Bvc,
        8 => Kind::Bhi,
        9 => Kind::Bls,
        10 => Kind::Bge,
        11 => Kind::Blt,
        12 => Kind::Bgt,
        13 => Kind::Ble,
        _ => return None,
    })
}

/// A hint by number. Those that are not allocated do nothing.
const fn hint(number: u32) -> Kind {
    match number {
        2 => Kind::Wfe,
        3 => Kind::Wfi,
        4 => Kind::Sev,
        _ => Kind::Nop,
    }
}
