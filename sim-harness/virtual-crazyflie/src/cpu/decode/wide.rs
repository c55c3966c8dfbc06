//! 32-bit instructions but those of memory and of the coprocessors (DDI 0403, A5.3).

use super::{
    UNDEFINED, UNPREDICTABLE, bad, bit, conditional, field, float, hint, immediate_shift,
    literal_base, memory, offset, pc, reg, signed, when,
};
use crate::cpu::dsp::{Lanes, Prefix};
use crate::cpu::op::{Extend, Kind, Long, Multiply, Op, Saturating, Shift, ToSp};

pub(super) fn decode(address: u32, first: u32, second: u32) -> Op {
    let kind = field(first, 4, 7);
    match field(first, 11, 2) {
        1 if kind & 0x64 == 0x00 => memory::multiple(first, second),
        1 if kind & 0x64 == 0x04 => memory::dual_or_exclusive(address, first, second),
        1 if kind & 0x60 == 0x20 => shifted_register(first, second),
        1 => float::decode(address, first, second),
        2 if bit(second, 15) => branch_or_control(address, first, second),
        2 if bit(first, 9) => plain_immediate(address, first, second),
        2 => modified_immediate(first, second),
        _ if kind & 0x71 == 0x00 => memory::store(first, second),
        _ if kind & 0x61 == 0x01 => memory::load(address, first, second),
        _ if kind & 0x70 == 0x20 => register(first, second),
        _ if kind & 0x78 == 0x30 => multiply(first, second),
        _ if kind & 0x78 == 0x38 => long_multiply(first, second),
        _ if kind & 0x40 == 0x40 => float::decode(address, first, second),
        _ => UNDEFINED,
    }
}

fn plain(kind: Kind) -> Op {
    Op::new(kind, 4)
}

/// imm3:imm2, a shift's amount or the lowest bit of a field.
fn amount(second: u32) -> u32 {
    field(second, 12, 3) << 2 | field(second, 6, 2)
}

/// The kinds of an operation: of a register and of a shifted one, without and with flags.
macro_rules! forms {
    ($shift:expr, $s:expr, $reg:ident, $reg_s:ident, $shifted:ident, $shifted_s:ident) => {
        match ($shift, $s) {
            (None, false) => Kind::$reg,
            (None, true) => Kind::$reg_s,
            (Some(shift), false) => Kind::$shifted(shift),
            (Some(shift), true) => Kind::$shifted_s(shift),
        }
    };
    ($shift:expr, $reg:ident, $shifted:ident) => {
        match $shift {
            None => Kind::$reg,
            Some(shift) => Kind::$shifted(shift),
        }
    };
}

/// A5.3.11.
fn shifted_register(first: u32, second: u32) -> Op {
    let (d, n, m, s) = (reg(second, 8), reg(first, 0), reg(second, 0), bit(first, 4));
    let (shift, a) = immediate_shift(field(second, 4, 2), amount(second));
    if bit(second, 15) {
        return UNPREDICTABLE;
    }
    let by = (shift != Shift::Lsl || a != 0).then_some(shift);
    let test = d == 15 && s;
    let op = |kind| Op { d, n, m, a, ..plain(kind) };
    let logical = |kind| if bad(d) || bad(n) || bad(m) { UNPREDICTABLE } else { op(kind) };
    let comparison = |kind, sp: bool| {
        if bad(m) || n == 15 || n == 13 && !sp { UNPREDICTABLE } else { op(kind) }
    };
    match field(first, 5, 4) {
        0 if test => comparison(forms!(by, TstReg, TstShifted), false),
        0 => logical(forms!(by, s, AndReg, AndRegS, AndShifted, AndShiftedS)),
        1 => logical(forms!(by, s, BicReg, BicRegS, BicShifted, BicShiftedS)),
        2 if n == 15 => move_register(op(Kind::MovReg), by, s),
        2 => logical(forms!(by, s, OrrReg, OrrRegS, OrrShifted, OrrShiftedS)),
        3 if n == 15 && (bad(d) || bad(m)) => UNPREDICTABLE,
        3 if n == 15 => op(forms!(by, s, MvnReg, MvnRegS, MvnShifted, MvnShiftedS)),
        3 => logical(forms!(by, s, OrnReg, OrnRegS, OrnShifted, OrnShiftedS)),
        4 if test => comparison(forms!(by, TeqReg, TeqShifted), false),
        4 => logical(forms!(by, s, EorReg, EorRegS, EorShifted, EorShiftedS)),
        6 => pack(first, second),
        8 if test => comparison(forms!(by, CmnReg, CmnShifted), true),
        8 if n == 13 => with_sp(op(Kind::AddReg), by, s, ToSp::Add, || {
            forms!(by, s, AddReg, AddRegS, AddShifted, AddShiftedS)
        }),
        8 => logical(forms!(by, s, AddReg, AddRegS, AddShifted, AddShiftedS)),
        10 => logical(forms!(by, s, AdcReg, AdcRegS, AdcShifted, AdcShiftedS)),
        11 => logical(forms!(by, s, SbcReg, SbcRegS, SbcShifted, SbcShiftedS)),
        13 if test => comparison(forms!(by, CmpReg, CmpShifted), true),
        13 if n == 13 => with_sp(op(Kind::SubReg), by, s, ToSp::Sub, || {
            forms!(by, s, SubReg, SubRegS, SubShifted, SubShiftedS)
        }),
        13 => logical(forms!(by, s, SubReg, SubRegS, SubShifted, SubShiftedS)),
        14 => logical(forms!(by, s, RsbReg, RsbRegS, RsbShifted, RsbShiftedS)),
        _ => UNDEFINED,
    }
}

/// MOV and shifts by an immediate (A5.3.11).
fn move_register(op: Op, by: Option<Shift>, s: bool) -> Op {
    let Op { d, m, .. } = op;
    let Some(shift) = by else {
        return match (d, m, s) {
            (15, ..) | (_, 15, _) | (13, 13, _) => UNPREDICTABLE,
            (13, _, true) | (_, 13, true) => UNPREDICTABLE,
            (13, ..) => op.as_kind(Kind::ToSp(ToSp::Mov)),
            _ => op.as_kind(when(s, Kind::MovRegS, Kind::MovReg)),
        };
    };
    if bad(d) || bad(m) {
        return UNPREDICTABLE;
    }
    op.as_kind(match shift {
        Shift::Lsl => when(s, Kind::LslImmS, Kind::LslImm),
        Shift::Lsr => when(s, Kind::LsrImmS, Kind::LsrImm),
        Shift::Asr => when(s, Kind::AsrImmS, Kind::AsrImm),
        Shift::Ror => when(s, Kind::RorImmS, Kind::RorImm),
        Shift::Rrx => when(s, Kind::RrxS, Kind::Rrx),
    })
}

/// ADD and SUB of SP and a register: into SP by so many bits only.
fn with_sp(op: Op, by: Option<Shift>, s: bool, to: ToSp, other: impl Fn() -> Kind) -> Op {
    let slight = matches!(by, None | Some(Shift::Lsl)) && op.a <= 3;
    match op.d {
        _ if bad(op.m) => UNPREDICTABLE,
        15 => UNPREDICTABLE,
        13 if !slight => UNPREDICTABLE,
        13 => op.as_kind(when(s, Kind::ToSpS(to), Kind::ToSp(to))),
        _ => op.as_kind(other()),
    }
}

fn pack(first: u32, second: u32) -> Op {
    let (d, n, m) = (reg(second, 8), reg(first, 0), reg(second, 0));
    if bit(first, 4) || bit(second, 4) {
        return UNDEFINED;
    }
    if bad(d) || bad(n) || bad(m) {
        return UNPREDICTABLE;
    }
    let bottom = !bit(second, 5);
    let a = match amount(second) as u8 {
        0 if !bottom => 32,
        amount => amount,
    };
    Op { d, n, m, a, ..plain(when(bottom, Kind::Pkhbt, Kind::Pkhtb)) }
}

/// ThumbExpandImm_C (A5.3.2): the value, and the carry where it is rotated (2 where it is not).
/// `None` where it is unpredictable.
fn expand(first: u32, second: u32) -> Option<(u32, u8)> {
    let byte = second & 0xFF;
    let code = field(first, 10, 1) << 4 | field(second, 12, 3) << 1 | byte >> 7;
    let pattern = match code >> 1 {
        0 => return Some((byte, 2)),
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte << 24 | byte << 16 | byte << 8 | byte,
        _ => {
            let value = (byte | 0x80).rotate_right(code);
            return Some((value, (value >> 31) as u8));
        }
    };
    (byte != 0).then_some((pattern, 2))
}

/// A5.3.1.
fn modified_immediate(first: u32, second: u32) -> Op {
    let (d, n, s) = (reg(second, 8), reg(first, 0), bit(first, 4));
    let Some((imm, a)) = expand(first, second) else { return UNPREDICTABLE };
    let test = d == 15 && s;
    let op = |kind| Op { d, n, a, imm, ..plain(kind) };
    let inverted = |kind| Op { imm: !imm, ..op(kind) };
    let strict = bad(d) || bad(n);
    match field(first, 5, 4) {
        0 | 4 if test && bad(n) => UNPREDICTABLE,
        0 if test => op(Kind::TstImm),
        4 if test => op(Kind::TeqImm),
        8 | 13 if test && n == 15 => UNPREDICTABLE,
        8 if test => op(Kind::CmnImm),
        13 if test => op(Kind::CmpImm),
        2 | 3 if n == 15 && bad(d) => UNPREDICTABLE,
        2 if n == 15 => op(when(s, Kind::MovImmS, Kind::MovImm)),
        3 if n == 15 => inverted(when(s, Kind::MovImmS, Kind::MovImm)),
        8 | 13 if n == 13 && d == 15 => UNPREDICTABLE,
        8 if n == 13 && d == 13 => to_sp(op(Kind::AddImm), s),
        13 if n == 13 && d == 13 => to_sp(op(Kind::SubImm), s),
        8 if n == 13 => op(when(s, Kind::AddImmS, Kind::AddImm)),
        13 if n == 13 => op(when(s, Kind::SubImmS, Kind::SubImm)),
        0..=4 | 8 | 10 | 11 | 13 | 14 if strict => UNPREDICTABLE,
        0 => op(when(s, Kind::AndImmS, Kind::AndImm)),
        1 => inverted(when(s, Kind::AndImmS, Kind::AndImm)),
        2 => op(when(s, Kind::OrrImmS, Kind::OrrImm)),
        3 => inverted(when(s, Kind::OrrImmS, Kind::OrrImm)),
        4 => op(when(s, Kind::EorImmS, Kind::EorImm)),
        8 => op(when(s, Kind::AddImmS, Kind::AddImm)),
        10 => op(when(s, Kind::AdcImmS, Kind::AdcImm)),
        11 => inverted(when(s, Kind::AdcImmS, Kind::AdcImm)),
        13 => op(when(s, Kind::SubImmS, Kind::SubImm)),
        14 => op(when(s, Kind::RsbImmS, Kind::RsbImm)),
        _ => UNDEFINED,
    }
}

/// ADD and SUB of an immediate from SP to SP. A multiple of four needs no care.
fn to_sp(op: Op, s: bool) -> Op {
    let to = if op.kind == Kind::AddImm { ToSp::AddImm } else { ToSp::SubImm };
    match (s, op.imm % 4) {
        (true, _) => op.as_kind(Kind::ToSpS(to)),
        (false, 0) => op,
        _ => op.as_kind(Kind::ToSp(to)),
    }
}

/// A5.3.3.
fn plain_immediate(address: u32, first: u32, second: u32) -> Op {
    let (d, n) = (reg(second, 8), reg(first, 0));
    let imm12 = field(first, 10, 1) << 11 | field(second, 12, 3) << 8 | second & 0xFF;
    let imm16 = field(first, 0, 4) << 12 | imm12;
    let kind = field(first, 4, 5);
    let op = |kind, imm| Op { d, n, imm, ..plain(kind) };
    match kind {
        0b00000 | 0b01010 => {
            let add = kind == 0;
            let sum = op(when(add, Kind::AddImm, Kind::SubImm), imm12);
            match (d, n) {
                (15, _) => UNPREDICTABLE,
                (13, 13) => to_sp(sum, false),
                (13, _) => UNPREDICTABLE,
                (_, 15) => op(Kind::MovImm, offset(literal_base(address), imm12, add)),
                _ => sum,
            }
        }
        0b00100 | 0b01100 if bad(d) => UNPREDICTABLE,
        0b00100 => op(Kind::MovImm, imm16),
        0b01100 => op(Kind::Movt, imm16 << 16),
        0b10000 | 0b10010 | 0b10100 | 0b10110 | 0b11000 | 0b11010 | 0b11100 => {
            bit_field(kind, first, second)
        }
        _ => UNDEFINED,
    }
}

fn bit_field(kind: u32, first: u32, second: u32) -> Op {
    let (d, n) = (reg(second, 8), reg(first, 0));
    let (low, last) = (amount(second), field(second, 0, 5));
    let op = |kind, imm| Op { d, n, a: low as u8, imm, ..plain(kind) };
    let shift = if bit(first, 5) { Shift::Asr } else { Shift::Lsl };
    let both = kind & 0b00010 != 0 && low == 0;
    let clears = kind == 0b10110 && n == 15;
    if bad(d) || bad(n) && !clears || bit(first, 10) || bit(second, 5) {
        return UNPREDICTABLE;
    }
    match kind {
        // A saturation to the right by nothing is one of both halves.
        0b10010 | 0b11010 if both && bit(second, 4) => UNPREDICTABLE,
        0b10010 if both => op(Kind::Ssat16, last + 1),
        0b11010 if both => op(Kind::Usat16, last),
        0b10000 | 0b10010 => op(Kind::Ssat(shift), last + 1),
        0b11000 | 0b11010 => op(Kind::Usat(shift), last),
        0b10110 if last < low => UNPREDICTABLE,
        0b10110 => op(when(clears, Kind::Bfc, Kind::Bfi), u32::MAX >> (31 - (last - low))),
        _ if low + last > 31 => UNPREDICTABLE,
        0b10100 => op(Kind::Sbfx, last + 1),
        _ => op(Kind::Ubfx, last + 1),
    }
}

/// A5.3.4.
fn branch_or_control(address: u32, first: u32, second: u32) -> Op {
    let (s, j1, j2) = (field(first, 10, 1), field(second, 13, 1), field(second, 11, 1));
    let low = field(second, 0, 11) << 1;
    let far = || {
        let (i1, i2) = (1 ^ j1 ^ s, 1 ^ j2 ^ s);
        signed(s << 24 | i1 << 23 | i2 << 22 | field(first, 0, 10) << 12 | low, 25)
    };
    let to = |kind, distance| Op { imm: pc(address).wrapping_add(distance), ..plain(kind) };
    match (bit(second, 14), bit(second, 12)) {
        (true, true) => return to(Kind::Bl, far()),
        (false, true) => return to(Kind::B, far()),
        (true, false) => return UNDEFINED,
        (false, false) => {}
    }
    if let Some(kind) = conditional(field(first, 6, 4)) {
        let near = s << 20 | j2 << 19 | j1 << 18 | field(first, 0, 6) << 12 | low;
        return to(kind, signed(near, 21));
    }
    control(first, second)
}

/// MSR, MRS, hints, barriers (A5.3.4 to A5.3.6).
fn control(first: u32, second: u32) -> Op {
    let special = second & 0xFF;
    match (field(first, 4, 7), field(second, 12, 3)) {
        (0x38, 0) => {
            let (n, a) = (reg(first, 0), field(second, 10, 2) as u8);
            if bad(n) || a == 0 || second & 0x300 != 0 {
                return UNPREDICTABLE;
            }
            Op { n, a, imm: special, ..plain(Kind::Msr) }
        }
        (0x3E, 0) => {
            let d = reg(second, 8);
            if bad(d) || reg(first, 0) != 15 {
                return UNPREDICTABLE;
            }
            Op { d, imm: special, ..plain(Kind::Mrs) }
        }
        (0x3A, 0) if second & 0x700 == 0 => {
            if first != 0xF3AF || bit(second, 11) {
                return UNPREDICTABLE;
            }
            plain(hint(special))
        }
        (0x3B, 0) => match (first, second >> 8, field(second, 4, 4), field(second, 0, 4)) {
            (0xF3BF, 0x8F, 2, 15) => plain(Kind::Clrex),
            (0xF3BF, 0x8F, 4..=6, _) => plain(Kind::Barrier),
            (_, _, 2 | 4..=6, _) => UNPREDICTABLE,
            _ => UNDEFINED,
        },
        (0x38 | 0x3A | 0x3B | 0x3E, 2) => UNPREDICTABLE,
        (0x39 | 0x3F, _) => UNPREDICTABLE,
        _ => UNDEFINED,
    }
}

/// A5.3.12.
fn register(first: u32, second: u32) -> Op {
    let (d, n, m) = (reg(second, 8), reg(first, 0), reg(second, 0));
    let (kind, which) = (field(first, 4, 4), field(second, 4, 4));
    if second >> 12 != 15 {
        return UNDEFINED;
    }
    let s = bit(first, 4);
    let op = |kind| {
        if bad(d) || bad(n) || bad(m) { UNPREDICTABLE } else { Op { d, n, m, ..plain(kind) } }
    };
    match (kind, which) {
        (0 | 1, 0) => op(when(s, Kind::LslRegS, Kind::LslReg)),
        (2 | 3, 0) => op(when(s, Kind::LsrRegS, Kind::LsrReg)),
        (4 | 5, 0) => op(when(s, Kind::AsrRegS, Kind::AsrReg)),
        (6 | 7, 0) => op(when(s, Kind::RorRegS, Kind::RorReg)),
        (0..=5, 8..) => extend(kind, d, n, m, second),
        (8.., 0..=7) => parallel(kind, which).map_or(UNDEFINED, op),
        (8, 8) => op(Kind::Saturating(Saturating::Add)),
        (8, 9) => op(Kind::Saturating(Saturating::DoubleAdd)),
        (8, 10) => op(Kind::Saturating(Saturating::Sub)),
        (8, 11) => op(Kind::Saturating(Saturating::DoubleSub)),
        (10, 8) => op(Kind::Sel),
        (9, 8..=11) | (11, 8) if n != m => UNPREDICTABLE,
        (9, 8) => op(Kind::Rev),
        (9, 9) => op(Kind::Rev16),
        (9, 10) => op(Kind::Rbit),
        (9, 11) => op(Kind::Revsh),
        (11, 8) => op(Kind::Clz),
        _ => UNDEFINED,
    }
}

fn extend(kind: u32, d: u8, n: u8, m: u8, second: u32) -> Op {
    if bad(d) || bad(m) || n == 13 || bit(second, 6) {
        return UNPREDICTABLE;
    }
    let a = (field(second, 4, 2) * 8) as u8;
    let kind = match (kind, n, a) {
        (0, 15, 0) => Kind::Sxth,
        (1, 15, 0) => Kind::Uxth,
        (4, 15, 0) => Kind::Sxtb,
        (5, 15, 0) => Kind::Uxtb,
        (0, ..) => Kind::Extend(Extend::SignedHalf),
        (1, ..) => Kind::Extend(Extend::UnsignedHalf),
        (2, ..) => Kind::Extend(Extend::SignedBytes16),
        (3, ..) => Kind::Extend(Extend::UnsignedBytes16),
        (4, ..) => Kind::Extend(Extend::SignedByte),
        _ => Kind::Extend(Extend::UnsignedByte),
    };
    Op { d, n, m, a, ..plain(kind) }
}

/// A5.3.13 and A5.3.14.
fn parallel(kind: u32, which: u32) -> Option<Kind> {
    let lanes = match kind & 7 {
        0 => Lanes::Add8,
        1 => Lanes::Add16,
        2 => Lanes::Asx,
        4 => Lanes::Sub8,
        5 => Lanes::Sub16,
        6 => Lanes::Sax,
        _ => return None,
    };
    let prefix = match which {
        0 => Prefix::Signed,
        1 => Prefix::Saturating,
        2 => Prefix::SignedHalving,
        4 => Prefix::Unsigned,
        5 => Prefix::UnsignedSaturating,
        6 => Prefix::UnsignedHalving,
        _ => return None,
    };
    Some(Kind::Parallel(prefix, lanes))
}

/// A5.3.16.
fn multiply(first: u32, second: u32) -> Op {
    let (d, n, m, a) = (reg(second, 8), reg(first, 0), reg(second, 0), reg(second, 12));
    let (x, y) = (bit(second, 5), bit(second, 4));
    let alone = a == 15;
    let kind = match (field(first, 4, 3), field(second, 4, 4)) {
        (0, 0) => when(alone, Kind::Mul, Kind::Mla),
        (0, 1) if alone => return UNPREDICTABLE,
        (0, 1) => Kind::Mls,
        (1, 0..=3) if alone => Kind::Multiply(Multiply::Halves(x, y)),
        (1, 0..=3) => Kind::Multiply(Multiply::AccumulateHalves(x, y)),
        (2, 0 | 1) => Kind::Multiply(Multiply::DualAdd(y)),
        (3, 0 | 1) if alone => Kind::Multiply(Multiply::Wide(y)),
        (3, 0 | 1) => Kind::Multiply(Multiply::AccumulateWide(y)),
        (4, 0 | 1) => Kind::Multiply(Multiply::DualSub(y)),
        (5, 0 | 1) => Kind::Multiply(Multiply::Most(y)),
        (6, 0 | 1) if alone => return UNPREDICTABLE,
        (6, 0 | 1) => Kind::Multiply(Multiply::MostSub(y)),
        (7, 0) => Kind::Multiply(Multiply::Differences),
        _ => return UNDEFINED,
    };
    if bad(d) || bad(n) || bad(m) || a == 13 {
        return UNPREDICTABLE;
    }
    Op { d, n, m, a, ..plain(kind) }
}

/// A5.3.17.
fn long_multiply(first: u32, second: u32) -> Op {
    let (low, high, n, m) = (reg(second, 12), reg(second, 8), reg(first, 0), reg(second, 0));
    let (x, y) = (bit(second, 5), bit(second, 4));
    let long = match (field(first, 4, 3), field(second, 4, 4)) {
        (1 | 3, 15) => {
            if low != 15 || bad(high) || bad(n) || bad(m) {
                return UNPREDICTABLE;
            }
            let kind = when(bit(first, 5), Kind::Udiv, Kind::Sdiv);
            return Op { d: high, n, m, ..plain(kind) };
        }
        (0, 0) => Long::Signed,
        (2, 0) => Long::Unsigned,
        (4, 0) => Long::AccumulateSigned,
        (4, 8..=11) => Long::Halves(x, y),
        (4, 12 | 13) => Long::DualAdd(y),
        (5, 12 | 13) => Long::DualSub(y),
        (6, 0) => Long::AccumulateUnsigned,
        (6, 6) => Long::AccumulateTwice,
        _ => return UNDEFINED,
    };
    if bad(low) || bad(high) || bad(n) || bad(m) || low == high {
        return UNPREDICTABLE;
    }
    Op { d: low, a: high, n, m, ..plain(Kind::Long(long)) }
}
