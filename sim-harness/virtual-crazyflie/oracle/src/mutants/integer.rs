//! Bugs of sums, shifts, products, conditions and flags.

use core_vectors::state::CODE;

use super::{C, GE, Mutant, N, Q, V, Z};

const ADDS: &[&str] = &["ADD reg.N", "ADD imm8.N", "CMN.N", "ADD imm3.N"];
const SUBS: &[&str] = &["SUB reg.N", "CMP.N", "SUB imm8.N", "CMP imm.N"];
const LANES: &[&str] = &["SADD8", "SADD16", "SSUB8", "SSUB16", "SASX", "SSAX"];
const UNSIGNED_LANES: &[&str] = &["UADD8", "UADD16", "USUB8", "USUB16", "UASX", "USAX"];

/// All of them.
pub(super) const MUTANTS: &[Mutant] = &[
    Mutant {
        name: "ADC forgets the carry",
        forms: &["ADC"],
        alter: |b| {
            if b.had(C) {
                *b.d() = b.d().wrapping_sub(1);
            }
        },
    },
    Mutant {
        name: "SBC takes no borrow",
        forms: &["SBC"],
        alter: |b| {
            if !b.had(C) {
                *b.d() = b.d().wrapping_add(1);
            }
        },
    },
    Mutant {
        name: "an addition that wraps to zero has no carry",
        forms: ADDS,
        alter: |b| {
            if b.has(Z) {
                b.after.apsr &= !C;
            }
        },
    },
    Mutant {
        name: "a difference of equals borrows",
        forms: SUBS,
        alter: |b| {
            if b.has(Z) {
                b.after.apsr &= !C;
            }
        },
    },
    Mutant { name: "an addition never overflows", forms: ADDS, alter: |b| b.after.apsr &= !V },
    Mutant { name: "a subtraction never overflows", forms: SUBS, alter: |b| b.after.apsr &= !V },
    Mutant {
        name: "RSB swaps its operands",
        forms: &["RSB", "RSB imm", "RSB reg"],
        alter: |b| *b.d() = b.d().wrapping_neg(),
    },
    Mutant {
        name: "LSL by 32 and more is taken modulo 32",
        forms: &["LSL.N"],
        alter: |b| {
            if b.reg(b'm') & 0xFF >= 32 {
                *b.d() = b.reg(b'd') << (b.reg(b'm') & 31);
            }
        },
    },
    Mutant {
        name: "LSR #32 is LSR #0",
        forms: &["LSR imm.N"],
        alter: |b| {
            if b.f(b'i') == 0 {
                *b.d() = b.reg(b'm');
            }
        },
    },
    Mutant {
        name: "ASR by 32 and more leaves no sign",
        forms: &["ASR.N"],
        alter: |b| {
            if b.reg(b'm') & 0xFF >= 32 {
                *b.d() = 0;
            }
        },
    },
    Mutant {
        name: "ROR by a multiple of 32 leaves the carry",
        forms: &["ROR.N"],
        alter: |b| {
            let by = b.reg(b'm') & 0xFF;
            if by != 0 && by & 31 == 0 {
                b.after.apsr = b.after.apsr & !C | b.before.apsr & C;
            }
        },
    },
    Mutant {
        name: "a shift by none clears the carry",
        forms: &["LSL.N", "LSR.N", "ASR.N"],
        alter: |b| {
            if b.reg(b'm') & 0xFF == 0 {
                b.after.apsr &= !C;
            }
        },
    },
    Mutant {
        name: "RRX shifts in a zero",
        forms: &["MOV reg"],
        alter: |b| {
            if b.f(b'k') == 3 && b.f(b'i') == 0 {
                *b.d() &= !(1 << 31);
            }
        },
    },
    Mutant { name: "MOVS clears the carry", forms: &["MOV imm.N"], alter: |b| b.after.apsr &= !C },
    Mutant {
        name: "a rotated constant leaves the carry",
        forms: &["AND imm", "ORR imm", "BIC imm", "TST imm", "TEQ imm", "MOV imm"],
        alter: |b| b.after.apsr = b.after.apsr & !C | b.before.apsr & C,
    },
    Mutant {
        name: "flags are set in a block",
        forms: &["ADD reg.N", "AND.N", "LSL imm.N", "MOV imm.N"],
        alter: |b| {
            if b.before.it != 0 && b.before.r[..] != b.after.r[..15] {
                b.after.apsr = b.after.apsr & !N | *b.d() & N;
            }
        },
    },
    Mutant {
        name: "LE in a block is LT",
        forms: &["ADD reg.N", "MOV imm.N", "ADD imm8.N"],
        alter: |b| {
            if b.before.it == 0xD8 && b.had(Z) && b.had(N) == b.had(V) {
                b.after.r[..15].copy_from_slice(&b.before.r);
            }
        },
    },
    Mutant {
        name: "HI does not look at Z",
        forms: &["B cond.N"],
        alter: |b| {
            if b.f(b'c') == 8 && b.had(C) && b.had(Z) {
                let by = ((b.encoding & 0xFF) as i8 as i32 * 2 + 4) as u32;
                b.after.r[15] = CODE.wrapping_add(by);
            }
        },
    },
    Mutant {
        name: "GE is GT",
        forms: &["B cond.N"],
        alter: |b| {
            if b.f(b'c') == 10 && b.had(Z) {
                b.after.r[15] = CODE + 2;
            }
        },
    },
    Mutant { name: "BL leaves LR even", forms: &["BL", "BLX"], alter: |b| b.after.r[14] &= !1 },
    Mutant { name: "BLX returns to itself", forms: &["BLX"], alter: |b| b.after.r[14] -= 2 },
    Mutant {
        name: "TBH does not double",
        forms: &["TBH", "TBH pc"],
        alter: |b| {
            let past = b.after.r[15].wrapping_sub(CODE + 4);
            b.after.r[15] = CODE + 4 + past / 2;
        },
    },
    Mutant {
        name: "saturation leaves no Q",
        forms: &["SSAT lsl", "SSAT asr", "USAT lsl", "USAT asr", "SSAT16", "USAT16"],
        alter: |b| b.after.apsr = b.after.apsr & !Q | b.before.apsr & Q,
    },
    Mutant {
        name: "SSAT saturates one too low",
        forms: &["SSAT lsl", "SSAT asr"],
        alter: |b| {
            if b.has(Q) && !b.had(Q) && *b.d() as i32 > 0 {
                *b.d() -= 1;
            }
        },
    },
    Mutant {
        name: "QADD leaves no Q",
        forms: &["QADD", "QSUB"],
        alter: |b| b.after.apsr = b.after.apsr & !Q | b.before.apsr & Q,
    },
    Mutant {
        name: "the doubling of QDADD leaves no Q",
        forms: &["QDADD", "QDSUB"],
        alter: |b| {
            let n = b.reg(b'n') as i32;
            let doubled = n.saturating_add(n);
            let m = b.reg(b'm') as i32;
            let sum = if b.form.name == "QDADD" {
                m.checked_add(doubled)
            } else {
                m.checked_sub(doubled)
            };
            if sum.is_some() {
                b.after.apsr = b.after.apsr & !Q | b.before.apsr & Q;
            }
        },
    },
    Mutant {
        name: "accumulation leaves no Q",
        forms: &["SMLAxy", "SMLAW", "SMLAD", "SMLSD"],
        alter: |b| b.after.apsr = b.after.apsr & !Q | b.before.apsr & Q,
    },
    Mutant {
        name: "SMUAD of four times 0x8000 leaves no Q",
        forms: &["SMUAD"],
        alter: |b| b.after.apsr = b.after.apsr & !Q | b.before.apsr & Q,
    },
    Mutant {
        name: "SMUSD swaps its products",
        forms: &["SMUSD"],
        alter: |b| *b.d() = b.d().wrapping_neg(),
    },
    Mutant {
        name: "SMMUL does not round",
        forms: &["SMMUL"],
        alter: |b| *b.d() = (b.wide_product() >> 32) as u32,
    },
    Mutant {
        name: "SMLAL loses the carry between its halves",
        forms: &["SMLAL"],
        alter: |b| {
            let (low, carry) = (b.wide_product() as u32).overflowing_add(b.reg(b'l'));
            let _ = low;
            if carry {
                let h = b.f(b'h') as usize;
                b.after.r[h] = b.after.r[h].wrapping_sub(1);
            }
        },
    },
    Mutant {
        name: "UMAAL adds one of the two",
        forms: &["UMAAL"],
        alter: |b| {
            let (l, h) = (b.f(b'l') as usize, b.f(b'h') as usize);
            let sum = u64::from(b.reg(b'n')) * u64::from(b.reg(b'm')) + u64::from(b.reg(b'l'));
            (b.after.r[l], b.after.r[h]) = (sum as u32, (sum >> 32) as u32);
        },
    },
    Mutant {
        name: "MLS adds",
        forms: &["MLS"],
        alter: |b| {
            let product = b.reg(b'n').wrapping_mul(b.reg(b'm'));
            *b.d() = b.reg(b'a').wrapping_add(product);
        },
    },
    Mutant {
        name: "the least integer by minus one is zero",
        forms: &["SDIV"],
        alter: |b| {
            if b.reg(b'n') == 1 << 31 && b.reg(b'm') == !0 {
                *b.d() = 0;
            }
        },
    },
    Mutant {
        name: "division by zero is all ones",
        forms: &["UDIV", "SDIV"],
        alter: |b| {
            if b.reg(b'm') == 0 {
                *b.d() = !0;
            }
        },
    },
    Mutant {
        name: "GE of a zero is clear",
        forms: LANES,
        alter: |b| {
            if *b.d() == 0 && b.after.apsr & GE == GE {
                b.after.apsr &= !GE;
            }
        },
    },
    Mutant {
        name: "GE is kept",
        forms: UNSIGNED_LANES,
        alter: |b| {
            b.after.apsr = b.after.apsr & !GE | b.before.apsr & GE;
        },
    },
    Mutant {
        name: "GE is written by a saturating one",
        forms: &["QADD8", "UQADD16", "SHADD16", "UHSUB8"],
        alter: |b| b.after.apsr &= !GE,
    },
    Mutant {
        name: "halving rounds up",
        forms: &["SHADD16", "UHADD16", "SHSUB16", "UHSUB16"],
        alter: |b| {
            if (b.reg(b'n') ^ b.reg(b'm')) & 1 == 1 {
                let low = *b.d() as u16;
                *b.d() = *b.d() & 0xFFFF_0000 | u32::from(low.wrapping_add(1));
            }
        },
    },
    Mutant {
        name: "UQSUB8 wraps in its lowest lane",
        forms: &["UQSUB8"],
        alter: |b| {
            let low = (b.reg(b'n') as u8).wrapping_sub(b.reg(b'm') as u8);
            *b.d() = *b.d() & !0xFF | u32::from(low);
        },
    },
    Mutant {
        name: "ASX and SAX exchange their halves",
        forms: &["SASX", "SSAX", "QASX", "UQSAX", "UHASX"],
        alter: |b| *b.d() = b.d().rotate_right(16),
    },
    Mutant {
        name: "SEL looks at one bit per half",
        forms: &["SEL"],
        alter: |b| {
            let (n, m) = (b.reg(b'n'), b.reg(b'm'));
            let lane = |at: u32| if b.before.apsr >> (16 + at / 8) & 1 == 1 { n } else { m };
            *b.d() = lane(0) & 0xFFFF | lane(16) & 0xFFFF_0000;
        },
    },
    Mutant {
        name: "USAD8 takes differences with their sign",
        forms: &["USAD8"],
        alter: |b| {
            let (n, m) = (b.reg(b'n').to_le_bytes(), b.reg(b'm').to_le_bytes());
            let sum: i32 = n.iter().zip(m).map(|(n, m)| i32::from(*n) - i32::from(m)).sum();
            *b.d() = sum as u32;
        },
    },
    Mutant {
        name: "an extension does not rotate",
        forms: &["UXTB16", "UXTB.W"],
        alter: |b| {
            let mask = if b.form.name == "UXTB16" { 0x00FF_00FF } else { 0xFF };
            *b.d() = b.reg(b'm') & mask;
        },
    },
    Mutant {
        name: "PKH takes the other half",
        forms: &["PKH"],
        alter: |b| *b.d() = b.d().rotate_left(16),
    },
    Mutant {
        name: "BFI inserts a bit less",
        forms: &["BFI"],
        alter: |b| {
            let top = 1 << b.f(b'k');
            *b.d() = *b.d() & !top | b.reg(b'd') & top;
        },
    },
    Mutant {
        name: "SBFX does not extend",
        forms: &["SBFX"],
        alter: |b| {
            let mask = u32::MAX >> (31 - b.f(b'k'));
            *b.d() &= mask;
        },
    },
    Mutant { name: "RBIT is REV", forms: &["RBIT"], alter: |b| *b.d() = b.reg(b'm').swap_bytes() },
    Mutant {
        name: "CLZ of zero is 31",
        forms: &["CLZ"],
        alter: |b| {
            if b.reg(b'm') == 0 {
                *b.d() = 31;
            }
        },
    },
    Mutant {
        name: "MSR writes GE with the flags",
        forms: &["MSR"],
        alter: |b| {
            if b.f(b'x') == 2 && b.f(b'y') < 4 {
                b.after.apsr = b.after.apsr & !GE | b.reg(b'n') & GE;
            }
        },
    },
];
