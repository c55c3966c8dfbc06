//! 16-bit instructions (DDI 0403, A5.2).

use super::{
    UNDEFINED, UNPREDICTABLE, bit, conditional, field, hint, immediate_shift, literal_base, pc,
    reg, signed,
};
use crate::cpu::op::{Kind, Op, Shift, ToSp};

fn low(bits: u32, at: u32) -> u8 {
    field(bits, at, 3) as u8
}

/// The operation with flags outside an IT block, without them inside.
fn flags(kind: Kind) -> Op {
    Op { quiet_in_it: true, ..Op::new(kind, 2) }
}

pub(super) fn decode(address: u32, bits: u32) -> Op {
    let plain = |kind| Op::new(kind, 2);
    let (d, n) = (low(bits, 0), low(bits, 3));
    let wide_d = low(bits, 8);
    let imm8 = bits & 0xFF;
    let at = |kind, scale: u32| Op { d, n, imm: field(bits, 6, 5) << scale, ..plain(kind) };
    match bits >> 11 {
        0b00000..=0b00010 => shift_immediate(bits),
        0b00011 => {
            let (kind, kind_imm) = if bit(bits, 9) {
                (Kind::SubRegS, Kind::SubImmS)
            } else {
                (Kind::AddRegS, Kind::AddImmS)
            };
            let m = low(bits, 6);
            if bit(bits, 10) {
                Op { d, n, imm: u32::from(m), ..flags(kind_imm) }
            } else {
                Op { d, n, m, ..flags(kind) }
            }
        }
        0b00100 => Op { d: wide_d, a: 2, imm: imm8, ..flags(Kind::MovImmS) },
        0b00101 => Op { n: wide_d, imm: imm8, ..plain(Kind::CmpImm) },
        0b00110 => Op { d: wide_d, n: wide_d, imm: imm8, ..flags(Kind::AddImmS) },
        0b00111 => Op { d: wide_d, n: wide_d, imm: imm8, ..flags(Kind::SubImmS) },
        0b01000 if bit(bits, 10) => high_registers(address, bits),
        0b01000 => data_processing(bits),
        0b01001 => {
            let imm = literal_base(address).wrapping_add(imm8 << 2);
            Op { d: wide_d, imm, ..plain(Kind::LdrLiteral) }
        }
        0b01010 | 0b01011 => {
            let kind = match field(bits, 9, 3) {
                0 => Kind::StrReg,
                1 => Kind::StrhReg,
                2 => Kind::StrbReg,
                3 => Kind::LdrsbReg,
                4 => Kind::LdrReg,
                5 => Kind::LdrhReg,
                6 => Kind::LdrbReg,
                _ => Kind::LdrshReg,
            };
            Op { d, n, m: low(bits, 6), ..plain(kind) }
        }
        0b01100 => at(Kind::StrImm, 2),
        0b01101 => at(Kind::LdrImm, 2),
        0b01110 => at(Kind::StrbImm, 0),
        0b01111 => at(Kind::LdrbImm, 0),
        0b10000 => at(Kind::StrhImm, 1),
        0b10001 => at(Kind::LdrhImm, 1),
        0b10010 => Op { d: wide_d, n: 13, imm: imm8 << 2, ..plain(Kind::StrImm) },
        0b10011 => Op { d: wide_d, n: 13, imm: imm8 << 2, ..plain(Kind::LdrImm) },
        0b10100 => {
            let imm = literal_base(address).wrapping_add(imm8 << 2);
            Op { d: wide_d, imm, ..plain(Kind::MovImm) }
        }
        0b10101 => Op { d: wide_d, n: 13, imm: imm8 << 2, ..plain(Kind::AddImm) },
        0b10110 | 0b10111 => miscellaneous(address, bits),
        0b11000 => {
            let first = imm8 & imm8.wrapping_neg();
            let base = 1 << wide_d;
            if imm8 == 0 || imm8 & base != 0 && first != base {
                return UNPREDICTABLE;
            }
            Op { n: wide_d, a: 1, imm: imm8, ..plain(Kind::StmIa) }
        }
        0b11001 if imm8 == 0 => UNPREDICTABLE,
        0b11001 => {
            let a = u8::from(imm8 & 1 << wide_d == 0);
            Op { n: wide_d, a, imm: imm8, ..plain(Kind::LdmIa) }
        }
        0b11010 | 0b11011 => match (field(bits, 8, 4), conditional(field(bits, 8, 4))) {
            (_, Some(kind)) => {
                Op { imm: pc(address).wrapping_add(signed(imm8 << 1, 9)), ..plain(kind) }
            }
            (14, None) => plain(Kind::Undefined),
            _ => Op { imm: imm8, ..plain(Kind::Svc) },
        },
        0b11100 => {
            let distance = signed(field(bits, 0, 11) << 1, 12);
            Op { imm: pc(address).wrapping_add(distance), ..plain(Kind::B) }
        }
        _ => UNDEFINED,
    }
}

fn shift_immediate(bits: u32) -> Op {
    let (shift, a) = immediate_shift(field(bits, 11, 2), field(bits, 6, 5));
    let (d, m) = (low(bits, 0), low(bits, 3));
    let op = match shift {
        // MOVS has no form that leaves the flags alone.
        Shift::Lsl if a == 0 => Op::new(Kind::MovRegS, 2),
        Shift::Lsl => flags(Kind::LslImmS),
        Shift::Lsr => flags(Kind::LsrImmS),
        _ => flags(Kind::AsrImmS),
    };
    Op { d, m, a, ..op }
}

fn data_processing(bits: u32) -> Op {
    let (d, m) = (low(bits, 0), low(bits, 3));
    let op = match field(bits, 6, 4) {
        0 => flags(Kind::AndRegS),
        1 => flags(Kind::EorRegS),
        2 => flags(Kind::LslRegS),
        3 => flags(Kind::LsrRegS),
        4 => flags(Kind::AsrRegS),
        5 => flags(Kind::AdcRegS),
        6 => flags(Kind::SbcRegS),
        7 => flags(Kind::RorRegS),
        8 => Op::new(Kind::TstReg, 2),
        9 => return Op { d, n: m, ..flags(Kind::RsbImmS) },
        10 => Op::new(Kind::CmpReg, 2),
        11 => Op::new(Kind::CmnReg, 2),
        12 => flags(Kind::OrrRegS),
        13 => flags(Kind::MulS),
        14 => flags(Kind::BicRegS),
        _ => flags(Kind::MvnRegS),
    };
    Op { d, n: d, m, ..op }
}

/// ADD, CMP, MOV of all registers, BX and BLX (A5.2.3).
fn high_registers(address: u32, bits: u32) -> Op {
    let d = low(bits, 0) | (field(bits, 7, 1) << 3) as u8;
    let m = reg(bits, 3);
    let plain = |kind| Op { d, n: d, m, ..Op::new(kind, 2) };
    let constant = |kind, imm| Op { d, n: d, imm, ..Op::new(kind, 2) };
    match (field(bits, 8, 2), d, m) {
        (0, 15, 15) => UNPREDICTABLE,
        (0, 15, _) => Op { d, m, imm: pc(address), ..Op::new(Kind::AddPc, 2) },
        (0, 13, 15) => constant(Kind::ToSp(ToSp::AddImm), pc(address)),
        (0, 13, _) => plain(Kind::ToSp(ToSp::Add)),
        (0, _, 15) => constant(Kind::AddImm, pc(address)),
        (0, ..) => plain(Kind::AddReg),
        (1, 15, _) | (1, _, 15) | (1, 0..8, 0..8) => UNPREDICTABLE,
        (1, ..) => plain(Kind::CmpReg),
        (2, 15, 15) => UNPREDICTABLE,
        (2, 15, _) => plain(Kind::MovPc),
        (2, 13, 15) => UNPREDICTABLE,
        (2, 13, _) => plain(Kind::ToSp(ToSp::Mov)),
        (2, _, 15) => Op { d, imm: pc(address), ..Op::new(Kind::MovImm, 2) },
        (2, ..) => plain(Kind::MovReg),
        (_, _, 15) => UNPREDICTABLE,
        _ if field(bits, 0, 3) != 0 => UNPREDICTABLE,
        _ => Op { m, ..Op::new(if bit(bits, 7) { Kind::Blx } else { Kind::Bx }, 2) },
    }
}

fn miscellaneous(address: u32, bits: u32) -> Op {
    let plain = |kind| Op::new(kind, 2);
    let (d, m) = (low(bits, 0), low(bits, 3));
    let two = |kind| Op { d, m, ..plain(kind) };
    let list = bits & 0xFF;
    match field(bits, 8, 4) {
        0b0000 => {
            let kind = if bit(bits, 7) { Kind::SubImm } else { Kind::AddImm };
            Op { d: 13, n: 13, imm: field(bits, 0, 7) << 2, ..plain(kind) }
        }
        0b0001 | 0b0011 | 0b1001 | 0b1011 => {
            let distance = field(bits, 9, 1) << 6 | field(bits, 3, 5) << 1;
            let kind = if bit(bits, 11) { Kind::Cbnz } else { Kind::Cbz };
            Op { n: d, imm: pc(address).wrapping_add(distance), ..plain(kind) }
        }
        0b0010 => two([Kind::Sxth, Kind::Sxtb, Kind::Uxth, Kind::Uxtb][field(bits, 6, 2) as usize]),
        0b0100 if list != 0 => Op { n: 13, imm: list, ..plain(Kind::Push) },
        0b0101 => Op { n: 13, imm: list | 1 << 14, ..plain(Kind::Push) },
        0b0110 if bits & 0xE0 == 0x60 => {
            if bits & 0xC != 0 || bits & 3 == 0 {
                return UNPREDICTABLE;
            }
            Op { imm: bits & 3, ..plain(Kind::Cps(!bit(bits, 4))) }
        }
        0b1010 => match field(bits, 6, 2) {
            0 => two(Kind::Rev),
            1 => two(Kind::Rev16),
            3 => two(Kind::Revsh),
            _ => plain(Kind::Undefined),
        },
        0b1100 if list != 0 => Op { n: 13, imm: list, ..plain(Kind::Pop) },
        0b1101 => Op { n: 13, imm: list | 1 << 15, ..plain(Kind::PopPc) },
        0b0100 | 0b1100 => UNPREDICTABLE,
        0b1110 => Op { imm: list, ..plain(Kind::Bkpt) },
        0b1111 if list & 15 == 0 => plain(hint(list >> 4)),
        0b1111 => match (list >> 4, (list & 15).count_ones()) {
            (15, _) | (14, 2..) => UNPREDICTABLE,
            _ => Op { imm: list, ..plain(Kind::It) },
        },
        _ => plain(Kind::Undefined),
    }
}
