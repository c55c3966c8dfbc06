//! 32-bit loads and stores (DDI 0403, A5.3.5 to A5.3.10).

use super::{UNDEFINED, UNPREDICTABLE, bad, bit, field, literal_base, offset, pc, reg, when};
use crate::bus::Width;
use crate::cpu::op::{Kind, Load, Mode, Op};

fn plain(kind: Kind) -> Op {
    Op::new(kind, 4)
}

/// LDM, STM, PUSH, POP (A5.3.5).
pub(super) fn multiple(first: u32, second: u32) -> Op {
    let (n, list) = (reg(first, 0), second);
    let (load, update) = (bit(first, 4), bit(first, 5));
    let down = match field(first, 7, 2) {
        1 => false,
        2 => true,
        _ => return UNDEFINED,
    };
    let forbidden = if load { 1 << 13 } else { 1 << 13 | 1 << 15 };
    if n == 15
        || list.count_ones() < 2
        || list & forbidden != 0
        || list >> 14 == 3
        || update && list & 1 << n != 0
    {
        return UNPREDICTABLE;
    }
    let kind = match (load, down, update && n == 13) {
        (true, false, true) => when(bit(list, 15), Kind::PopPc, Kind::Pop),
        (true, false, false) => Kind::LdmIa,
        (true, true, _) => Kind::LdmDb,
        (false, false, _) => Kind::StmIa,
        (false, true, true) => Kind::Push,
        (false, true, false) => Kind::StmDb,
    };
    Op { n, a: u8::from(update), imm: list, ..plain(kind) }
}

/// LDRD, STRD, exclusives, TBB (A5.3.6).
pub(super) fn dual_or_exclusive(address: u32, first: u32, second: u32) -> Op {
    let (n, t, t2) = (reg(first, 0), reg(second, 12), reg(second, 8));
    let (index, add, update, load) = (bit(first, 8), bit(first, 7), bit(first, 5), bit(first, 4));
    let imm = (second & 0xFF) << 2;
    let op = |kind| Op { d: t, a: t2, n, imm, ..plain(kind) };
    if !index && !update {
        return if add { narrow_exclusive(address, first, second) } else { exclusive(op, load) };
    }
    if bad(t) || bad(t2) || load && t == t2 || update && (n == 15 || n == t || n == t2) {
        return UNPREDICTABLE;
    }
    let mode = match (n, index, update) {
        (15, ..) if !load => return UNPREDICTABLE,
        (15, ..) => Mode::Literal,
        (_, true, false) => Mode::Offset,
        (_, true, true) => Mode::Pre,
        (_, false, _) => Mode::Post,
    };
    let base = if mode == Mode::Literal { literal_base(address) } else { 0 };
    let imm = offset(base, imm, add);
    Op { imm, ..op(if load { Kind::Ldrd(mode) } else { Kind::Strd(mode) }) }
}

/// LDREX and STREX.
fn exclusive(op: impl Fn(Kind) -> Op, load: bool) -> Op {
    // STREX: the status is in what is Ra elsewhere.
    let Op { d: t, a: status, n, imm, .. } = op(Kind::Ldrex);
    if n == 15 || bad(t) {
        return UNPREDICTABLE;
    }
    match load {
        true if status != 15 => UNPREDICTABLE,
        true => Op { d: t, n, imm, ..plain(Kind::Ldrex) },
        false if bad(status) || status == n || status == t => UNPREDICTABLE,
        false => Op { d: status, a: t, n, imm, ..plain(Kind::Strex) },
    }
}

fn narrow_exclusive(address: u32, first: u32, second: u32) -> Op {
    let (n, t, m) = (reg(first, 0), reg(second, 12), reg(second, 0));
    let width = if bit(second, 4) { Width::Half } else { Width::Byte };
    match (bit(first, 4), field(second, 4, 4)) {
        (true, 0 | 1) => {
            if n == 13 || bad(m) || second & 0xFF00 != 0xF000 {
                return UNPREDICTABLE;
            }
            Op { n, m, imm: pc(address), ..plain(when(bit(second, 4), Kind::Tbh, Kind::Tbb)) }
        }
        (true, 4 | 5) => {
            if n == 15 || bad(t) || second & 0x0F0F != 0x0F0F {
                return UNPREDICTABLE;
            }
            Op { d: t, n, ..plain(Kind::LdrexNarrow(width)) }
        }
        (false, 4 | 5) => {
            if n == 15 || bad(t) || bad(m) || m == n || m == t || second & 0x0F00 != 0x0F00 {
                return UNPREDICTABLE;
            }
            Op { d: m, a: t, n, ..plain(Kind::StrexNarrow(width)) }
        }
        _ => UNDEFINED,
    }
}

/// The use of the base by an instruction with an immediate of eight bits.
enum Base {
    Offset,
    Pre,
    Post,
    Unprivileged,
}

/// P, U and W, and the offset with its sign.
fn base(second: u32) -> Option<(Base, u32)> {
    let (index, add, update) = (bit(second, 10), bit(second, 9), bit(second, 8));
    let base = match (index, add, update) {
        (true, true, false) => Base::Unprivileged,
        (true, false, false) => Base::Offset,
        (true, _, true) => Base::Pre,
        (false, _, true) => Base::Post,
        (false, _, false) => return None,
    };
    Some((base, offset(0, second & 0xFF, add)))
}

/// A5.3.10.
pub(super) fn store(first: u32, second: u32) -> Op {
    let (n, d, m) = (reg(first, 0), reg(second, 12), reg(second, 0));
    let (width, by_imm, by_reg) = match field(first, 5, 2) {
        0 => (Width::Byte, Kind::StrbImm, Kind::StrbReg),
        1 => (Width::Half, Kind::StrhImm, Kind::StrhReg),
        2 => (Width::Word, Kind::StrImm, Kind::StrReg),
        _ => return UNDEFINED,
    };
    if n == 15 {
        return UNDEFINED;
    }
    let wrong = d == 15 || d == 13 && width != Width::Word;
    if bit(first, 7) {
        let op = Op { d, n, imm: second & 0xFFF, ..plain(by_imm) };
        return if wrong { UNPREDICTABLE } else { op };
    }
    if !bit(second, 11) {
        return match (field(second, 6, 5), wrong || bad(m)) {
            (1.., _) => UNDEFINED,
            (0, true) => UNPREDICTABLE,
            (0, false) => Op { d, n, m, a: field(second, 4, 2) as u8, ..plain(by_reg) },
        };
    }
    let Some((base, imm)) = base(second) else { return UNDEFINED };
    let kind = match base {
        _ if wrong => return UNPREDICTABLE,
        Base::Pre | Base::Post if n == d => return UNPREDICTABLE,
        Base::Unprivileged if bad(d) => return UNPREDICTABLE,
        Base::Offset => by_imm,
        Base::Pre => Kind::StorePre(width),
        Base::Post => Kind::StorePost(width),
        Base::Unprivileged => Kind::StoreUnprivileged(width),
    };
    Op { d, n, imm, ..plain(kind) }
}

/// A5.3.7 to A5.3.9.
pub(super) fn load(address: u32, first: u32, second: u32) -> Op {
    let (n, d, m) = (reg(first, 0), reg(second, 12), reg(second, 0));
    let (load, by_imm, by_reg) = match (field(first, 5, 2), bit(first, 8)) {
        (0, false) => (Load::Byte, Kind::LdrbImm, Kind::LdrbReg),
        (0, true) => (Load::SignedByte, Kind::LdrsbImm, Kind::LdrsbReg),
        (1, false) => (Load::Half, Kind::LdrhImm, Kind::LdrhReg),
        (1, true) => (Load::SignedHalf, Kind::LdrshImm, Kind::LdrshReg),
        (2, false) => (Load::Word, Kind::LdrImm, Kind::LdrReg),
        _ => return UNDEFINED,
    };
    let word = load == Load::Word;
    // Of bytes and halfwords, what would go to PC is only a hint.
    let hint = d == 15 && !word;
    let wrong = d == 13 && !word;
    let to = |kind, mode| match d {
        15 => Kind::LoadPc(mode),
        13 => Kind::LoadSp(mode),
        _ => kind,
    };
    if n == 15 {
        let imm = offset(literal_base(address), second & 0xFFF, bit(first, 7));
        let literal = if word { Kind::LdrLiteral } else { Kind::LoadLiteral(load) };
        return match (hint, wrong) {
            (true, _) => plain(Kind::Nop),
            (_, true) => UNPREDICTABLE,
            _ => Op { d, imm, ..plain(to(literal, Mode::Literal)) },
        };
    }
    if bit(first, 7) {
        return match (hint, wrong) {
            (true, _) => plain(Kind::Nop),
            (_, true) => UNPREDICTABLE,
            _ => Op { d, n, imm: second & 0xFFF, ..plain(to(by_imm, Mode::Offset)) },
        };
    }
    if !bit(second, 11) {
        return match (field(second, 6, 5), hint, wrong || bad(m)) {
            (1.., ..) => UNDEFINED,
            (0, _, true) => UNPREDICTABLE,
            (0, true, _) => plain(Kind::Nop),
            _ => {
                let a = field(second, 4, 2) as u8;
                Op { d, n, m, a, ..plain(to(by_reg, Mode::Register)) }
            }
        };
    }
    let Some((base, imm)) = base(second) else { return UNDEFINED };
    let kind = match base {
        Base::Offset if hint => return plain(Kind::Nop),
        _ if hint || wrong => return UNPREDICTABLE,
        Base::Pre | Base::Post if n == d => return UNPREDICTABLE,
        Base::Unprivileged if bad(d) => return UNPREDICTABLE,
        Base::Offset => to(by_imm, Mode::Offset),
        Base::Pre => to(Kind::LoadPre(load), Mode::Pre),
        Base::Post => to(Kind::LoadPost(load), Mode::Post),
        Base::Unprivileged => Kind::LoadUnprivileged(load),
    };
    Op { d, n, imm, ..plain(kind) }
}
