//! The decoder of ARMv6-M (Architecture Reference Manual, A5).

use super::op::{Access, Alu, Change, Op, Register, Shift};

/// Whether a halfword is the first of a 32-bit instruction.
#[must_use]
pub const fn is_wide(first: u16) -> bool {
    matches!(first >> 11, 0b11101..=0b11111)
}

/// The instruction that a halfword begins; the second halfword counts only where the first
/// [is wide](is_wide).
#[must_use]
pub fn decode(first: u16, second: u16) -> Op {
    if is_wide(first) {
        return wide(first, second);
    }
    match first >> 12 {
        0b0000 | 0b0001 => shift_or_add(first),
        0b0010 | 0b0011 => constant(first),
        0b0100 => registers(first),
        0b0101 => {
            let access = ACCESSES[usize::from(first >> 9 & 7)];
            Op::AccessRegister { access, t: low(first, 0), n: low(first, 3), m: low(first, 6) }
        }
        0b0110 => at_constant(first, Access::Ldr, Access::Str, 4),
        0b0111 => at_constant(first, Access::Ldrb, Access::Strb, 1),
        0b1000 => at_constant(first, Access::Ldrh, Access::Strh, 2),
        0b1001 => {
            let access = if first & 1 << 11 == 0 { Access::Str } else { Access::Ldr };
            Op::AccessConstant { access, t: low(first, 8), n: 13, offset: (first & 0xFF) * 4 }
        }
        0b1010 if first & 1 << 11 == 0 => Op::Adr { d: low(first, 8), offset: (first & 0xFF) * 4 },
        0b1010 => Op::AddSp { d: low(first, 8), offset: (first & 0xFF) * 4 },
        0b1011 => miscellaneous(first),
        0b1100 if first & 1 << 11 == 0 => Op::StoreMany { n: low(first, 8), list: first as u8 },
        0b1100 => Op::LoadMany { n: low(first, 8), list: first as u8 },
        0b1101 => match first >> 8 & 15 {
            14 => Op::Undefined,
            15 => Op::SupervisorCall,
            condition => Op::BranchIf {
                condition: condition as u8,
                offset: i16::from(first.to_le_bytes()[0].cast_signed()) * 2,
            },
        },
        _ => Op::Branch { offset: (first << 5).cast_signed() >> 4 },
    }
}

/// The accesses with a register as the offset, by their three bits.
const ACCESSES: [Access; 8] = [
    Access::Str,
    Access::Strh,
    Access::Strb,
    Access::Ldrsb,
    Access::Ldr,
    Access::Ldrh,
    Access::Ldrb,
    Access::Ldrsh,
];

/// The operations of two registers, by their four bits.
const ALU: [Alu; 16] = [
    Alu::And,
    Alu::Eor,
    Alu::Lsl,
    Alu::Lsr,
    Alu::Asr,
    Alu::Adc,
    Alu::Sbc,
    Alu::Ror,
    Alu::Tst,
    Alu::Rsb,
    Alu::Cmp,
    Alu::Cmn,
    Alu::Orr,
    Alu::Mul,
    Alu::Bic,
    Alu::Mvn,
];

/// The low register whose three bits begin at a bit.
const fn low(first: u16, bit: u32) -> Register {
    (first >> bit & 7) as Register
}

fn shift_or_add(first: u16) -> Op {
    let (d, n, by) = (low(first, 0), low(first, 3), (first >> 6 & 31) as u8);
    let third = low(first, 6);
    match first >> 9 {
        0b01100 => Op::Add { d, n, m: third },
        0b01101 => Op::Sub { d, n, m: third },
        0b01110 => Op::AddConstant { d, n, constant: third },
        0b01111 => Op::SubConstant { d, n, constant: third },
        0b00000..=0b00011 => Op::Shift { shift: Shift::Lsl, d, m: n, by },
        // A shift to the right by 0 stands for one by 32.
        0b00100..=0b00111 => {
            Op::Shift { shift: Shift::Lsr, d, m: n, by: if by == 0 { 32 } else { by } }
        }
        _ => Op::Shift { shift: Shift::Asr, d, m: n, by: if by == 0 { 32 } else { by } },
    }
}

fn constant(first: u16) -> Op {
    let (d, constant) = (low(first, 8), first.to_le_bytes()[0]);
    match first >> 11 & 3 {
        0 => Op::MovConstant { d, constant },
        1 => Op::CmpConstant { n: d, constant },
        2 => Op::AddConstant { d, n: d, constant },
        _ => Op::SubConstant { d, n: d, constant },
    }
}

fn registers(first: u16) -> Op {
    if first & 1 << 11 != 0 {
        return Op::LoadLiteral { t: low(first, 8), offset: (first & 0xFF) * 4 };
    }
    if first & 1 << 10 == 0 {
        let alu = ALU[usize::from(first >> 6 & 15)];
        return Op::Alu { alu, d: low(first, 0), m: low(first, 3) };
    }
    let (d, m) = (low(first, 0) | (first >> 4 & 8) as Register, (first >> 3 & 15) as Register);
    match first >> 8 & 3 {
        0 => Op::AddAny { d, m },
        1 => Op::CmpAny { n: d, m },
        2 => Op::MovAny { d, m },
        _ if first & 1 << 7 == 0 => Op::BranchExchange { m },
        _ => Op::CallExchange { m },
    }
}

fn at_constant(first: u16, load: Access, store: Access, size: u16) -> Op {
    let access = if first & 1 << 11 == 0 { store } else { load };
    let offset = (first >> 6 & 31) * size;
    Op::AccessConstant { access, t: low(first, 0), n: low(first, 3), offset }
}

fn miscellaneous(first: u16) -> Op {
    let changed = |change| Op::Change { change, d: low(first, 0), m: low(first, 3) };
    match first >> 6 & 63 {
        0b000000 | 0b000001 => Op::MoveSp { offset: ((first & 0x7F) * 4).cast_signed() },
        0b000010 | 0b000011 => Op::MoveSp { offset: -((first & 0x7F) * 4).cast_signed() },
        0b001000 => changed(Change::Sxth),
        0b001001 => changed(Change::Sxtb),
        0b001010 => changed(Change::Uxth),
        0b001011 => changed(Change::Uxtb),
        0b010000..=0b010111 => Op::Push { list: first & 0xFF | (first & 1 << 8) << 6 },
        0b011001 if first & 0xFFEF == 0xB662 => Op::Mask { masked: first & 1 << 4 != 0 },
        0b101000 => changed(Change::Rev),
        0b101001 => changed(Change::Rev16),
        0b101011 => changed(Change::Revsh),
        0b110000..=0b110111 => Op::Pop { list: first & 0xFF | (first & 1 << 8) << 7 },
        0b111100..=0b111111 => match first & 0xFF {
            0x20 | 0x30 => Op::Wait,
            hint if hint & 15 == 0 => Op::Nothing { cycles: 1 },
            _ => Op::Undefined,
        },
        _ => Op::Undefined,
    }
}

/// The seven instructions of 32 bits: BL, MSR, MRS, DSB, DMB, ISB and UDF.
fn wide(first: u16, second: u16) -> Op {
    if first & 0xF800 == 0xF000 && second & 0xD000 == 0xD000 {
        return Op::Call { offset: call_offset(first, second) };
    }
    match (first, second) {
        (0xF3EF, _) if second & 0xF000 == 0x8000 => {
            Op::ReadSpecial { d: (second >> 8 & 15) as Register, special: second.to_le_bytes()[0] }
        }
        (_, _) if first & 0xFFF0 == 0xF380 && second & 0xFF00 == 0x8800 => {
            Op::WriteSpecial { n: (first & 15) as Register, special: second.to_le_bytes()[0] }
        }
        (0xF3BF, 0x8F40..=0x8F6F) => Op::Nothing { cycles: super::cycles::BARRIER },
        _ => Op::Undefined,
    }
}

/// The offset of BL, of which two bits are folded with the sign (A6.7.13).
fn call_offset(first: u16, second: u16) -> i32 {
    let (first, second) = (u32::from(first), u32::from(second));
    let sign = first >> 10 & 1;
    let one = !(second >> 13 ^ sign) & 1;
    let two = !(second >> 11 ^ sign) & 1;
    let bits = sign << 24 | one << 23 | two << 22 | (first & 0x3FF) << 12 | (second & 0x7FF) << 1;
    (bits << 7).cast_signed() >> 7
}
