//! Instructions of coprocessors, of which there is one: FPv4-SP (DDI 0403, A5.3.18 and chapter A6).

use super::{UNDEFINED, UNPREDICTABLE, bad, bit, field, literal_base, offset, reg, when};
use crate::cpu::fp;
use crate::cpu::op::{Accumulate, Kind, Multiple, Op};

fn plain(kind: Kind) -> Op {
    Op::new(kind, 4)
}

/// A single register: four bits and the lowest one.
fn single(bits: u32, at: u32, low: bool) -> u8 {
    reg(bits, at) << 1 | u8::from(low)
}

/// The first half of a double register; `None` beyond the sixteenth.
fn double(bits: u32, at: u32, high: bool) -> Option<u8> {
    (!high).then(|| reg(bits, at) << 1)
}

pub(super) fn decode(address: u32, first: u32, second: u32) -> Op {
    let floating = field(second, 9, 3) == 0b101;
    match field(first, 8, 4) {
        // Advanced SIMD, which no core of this profile has.
        0b1111 => UNDEFINED,
        _ if !floating => plain(Kind::NoCoprocessor),
        _ if bit(first, 12) => UNDEFINED,
        0b1110 if bit(second, 4) => transfer(first, second),
        0b1110 => data_processing(first, second),
        0b1100 if field(first, 5, 3) == 0b010 => transfer_two(first, second),
        _ => load_store(address, first, second),
    }
}

/// A6.4.
fn data_processing(first: u32, second: u32) -> Op {
    let d = single(second, 12, bit(first, 6));
    let n = single(first, 0, bit(second, 7));
    let m = single(second, 0, bit(second, 5));
    let other = bit(second, 6);
    if bit(second, 8) {
        return UNDEFINED;
    }
    let kind = match field(first, 4, 4) & 0b1011 {
        0b0000 => when(other, Kind::Vmls, Kind::Vmla),
        0b0001 if other => Kind::Accumulate(Accumulate::Nmla),
        0b0001 => Kind::Accumulate(Accumulate::Nmls),
        0b0010 => when(other, Kind::Vnmul, Kind::Vmul),
        0b0011 => when(other, Kind::Vsub, Kind::Vadd),
        0b1000 if !other => Kind::Vdiv,
        0b1001 if other => Kind::Accumulate(Accumulate::Fnma),
        0b1001 => Kind::Accumulate(Accumulate::Fnms),
        0b1010 if other => Kind::Accumulate(Accumulate::Fms),
        0b1010 => Kind::Accumulate(Accumulate::Fma),
        0b1011 if other => return one_operand(d, m, first, second),
        0b1011 => {
            if second & 0xA0 != 0 {
                return UNPREDICTABLE;
            }
            let imm = fp::immediate((field(first, 0, 4) << 4 | field(second, 0, 4)) as u8);
            return Op { d, imm, ..plain(Kind::VmovImm) };
        }
        _ => return UNDEFINED,
    };
    Op { d, n, m, ..plain(kind) }
}

fn one_operand(d: u8, m: u8, first: u32, second: u32) -> Op {
    let high = bit(second, 7);
    let which = field(first, 0, 4);
    let kind = match which {
        0b0000 => when(high, Kind::Vabs, Kind::Vmov),
        0b0001 => when(high, Kind::Vsqrt, Kind::Vneg),
        0b0010 => Kind::VcvtFromHalf(high),
        0b0011 => Kind::VcvtToHalf(high),
        0b0100 => Kind::Vcmp(high),
        0b0101 if second & 0x2F != 0 => return UNPREDICTABLE,
        0b0101 => Kind::VcmpZero(high),
        0b1000 => Kind::VcvtFromInt(high),
        0b1100 | 0b1101 => Kind::VcvtToInt(which & 1 != 0, high),
        0b1010 | 0b1011 | 0b1110 | 0b1111 => return fixed_point(d, which, second),
        _ => return UNDEFINED,
    };
    Op { d, m, ..plain(kind) }
}

fn fixed_point(d: u8, which: u32, second: u32) -> Op {
    let size = if bit(second, 7) { 32 } else { 16 };
    let before = field(second, 0, 4) << 1 | field(second, 5, 1);
    let signed = which & 1 == 0;
    if before > size {
        return UNPREDICTABLE;
    }
    let kind = if which & 4 != 0 { Kind::VcvtToFixed(signed) } else { Kind::VcvtFromFixed(signed) };
    Op { d, a: (size - before) as u8, imm: size, ..plain(kind) }
}

/// A6.6.
fn transfer(first: u32, second: u32) -> Op {
    let d = reg(second, 12);
    let to_core = bit(first, 4);
    let (kind, scalar) = (field(first, 5, 3), bit(second, 8));
    match (kind, scalar) {
        (0b000, false) => {
            if bad(d) || second & 0x6F != 0 {
                return UNPREDICTABLE;
            }
            let n = single(first, 0, bit(second, 7));
            Op { d, n, ..plain(when(to_core, Kind::VmovToCore, Kind::VmovFromCore)) }
        }
        (0b111, false) => {
            if first & 15 != 1 {
                return UNDEFINED;
            }
            if d == 13 || d == 15 && !to_core || second & 0xEF != 0 {
                return UNPREDICTABLE;
            }
            Op { d, ..plain(when(to_core, Kind::Vmrs, Kind::Vmsr)) }
        }
        (0b000 | 0b001, true) => {
            let Some(n) = double(first, 0, bit(second, 7)) else { return UNDEFINED };
            match second & 0x6F {
                0 if bad(d) => UNPREDICTABLE,
                0 => Op {
                    d,
                    n: n | kind as u8,
                    ..plain(when(to_core, Kind::VmovToCore, Kind::VmovFromCore))
                },
                _ if second & 0x60 != 0 => UNDEFINED,
                _ => UNPREDICTABLE,
            }
        }
        _ => UNDEFINED,
    }
}

/// A6.7.
fn transfer_two(first: u32, second: u32) -> Op {
    let (d, a, to_core) = (reg(second, 12), reg(first, 0), bit(first, 4));
    if second & 0xD0 != 0x10 {
        return UNDEFINED;
    }
    let m = if bit(second, 8) {
        let Some(m) = double(second, 0, bit(second, 5)) else { return UNDEFINED };
        m
    } else {
        single(second, 0, bit(second, 5))
    };
    if bad(d) || bad(a) || m == 31 || to_core && d == a {
        return UNPREDICTABLE;
    }
    Op { d, a, m, ..plain(when(to_core, Kind::VmovToCores, Kind::VmovFromCores)) }
}

/// A6.5.
fn load_store(address: u32, first: u32, second: u32) -> Op {
    let n = reg(first, 0);
    let (index, add, update, load) = (bit(first, 8), bit(first, 7), bit(first, 5), bit(first, 4));
    let wide = bit(second, 8);
    let d = if wide {
        let Some(d) = double(second, 12, bit(first, 6)) else { return UNDEFINED };
        d
    } else {
        single(second, 12, bit(first, 6))
    };
    let words = second & 0xFF;
    let multiple = match (index, add, update) {
        (true, _, false) => {
            let base = if n == 15 { literal_base(address) } else { 0 };
            let imm = offset(base, words << 2, add);
            let kind = match (load, n, wide) {
                (true, 15, false) => Kind::VldrLiteral,
                (true, 15, true) => Kind::VldrDoubleLiteral,
                (true, _, false) => Kind::Vldr,
                (true, _, true) => Kind::VldrDouble,
                (false, 15, _) => return UNPREDICTABLE,
                (false, _, false) => Kind::Vstr,
                (false, _, true) => Kind::VstrDouble,
            };
            return Op { d, n, imm, ..plain(kind) };
        }
        (false, true, false) => Multiple::From,
        (false, true, true) => Multiple::FromAndUpdate,
        (true, false, true) => Multiple::UpToAndUpdate,
        (false, false, _) | (true, true, true) => return UNDEFINED,
    };
    // An odd count of words in doubles is FLDMX, which compilers no longer emit.
    if n == 15 || words == 0 || u32::from(d) + words > 32 || wide && words % 2 == 1 {
        return UNPREDICTABLE;
    }
    let kind = if load { Kind::Vldm(multiple) } else { Kind::Vstm(multiple) };
    Op { d, n, a: words as u8, ..plain(kind) }
}
