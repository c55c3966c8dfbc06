//! Bugs of the floating-point unit.

use super::{DZC, IDC, IOC, IXC, Mutant, OFC, UFC, V};

const ARITHMETIC: &[&str] = &["VADD", "VSUB", "VMUL", "VDIV", "VMLA", "VFMA", "VFNMS", "VNMLA"];

fn is_nan(bits: u32) -> bool {
    bits & 0x7FFF_FFFF > 0x7F80_0000
}

fn is_signalling(bits: u32) -> bool {
    is_nan(bits) && bits & 1 << 22 == 0
}

/// All of them.
pub(super) const MUTANTS: &[Mutant] = &[
    Mutant {
        name: "nothing is inexact",
        forms: ARITHMETIC,
        alter: |b| {
            b.after.fpscr &= !IXC | b.before.fpscr;
        },
    },
    Mutant {
        name: "nothing underflows",
        forms: ARITHMETIC,
        alter: |b| {
            b.after.fpscr &= !UFC | b.before.fpscr;
        },
    },
    Mutant {
        name: "nothing overflows",
        forms: ARITHMETIC,
        alter: |b| {
            b.after.fpscr &= !OFC | b.before.fpscr;
        },
    },
    Mutant {
        name: "no input is denormal",
        forms: ARITHMETIC,
        alter: |b| {
            b.after.fpscr &= !IDC | b.before.fpscr;
        },
    },
    Mutant {
        name: "nothing is invalid",
        forms: ARITHMETIC,
        alter: |b| {
            b.after.fpscr &= !IOC | b.before.fpscr;
        },
    },
    Mutant {
        name: "what is tiny is so after it is rounded",
        forms: ARITHMETIC,
        alter: |b| {
            if b.raised(UFC) && *b.result() & 0x7FFF_FFFF == 0x0080_0000 {
                b.after.fpscr &= !UFC;
            }
        },
    },
    Mutant {
        name: "where nothing but IXC is to be known, overflow is not noticed",
        forms: ARITHMETIC,
        alter: |b| {
            if b.takes_the_short_way() {
                b.after.fpscr &= !OFC | b.before.fpscr;
            }
        },
    },
    Mutant {
        name: "there, underflow is not noticed",
        forms: ARITHMETIC,
        alter: |b| {
            if b.takes_the_short_way() {
                b.after.fpscr &= !UFC | b.before.fpscr;
            }
        },
    },
    Mutant {
        name: "there, what is invalid is not noticed",
        forms: ARITHMETIC,
        alter: |b| {
            if b.takes_the_short_way() {
                b.after.fpscr &= !IOC | b.before.fpscr;
            }
        },
    },
    Mutant {
        name: "there, the default NaN is the host's",
        forms: ARITHMETIC,
        alter: |b| {
            if b.takes_the_short_way() && *b.result() == 0x7FC0_0000 {
                *b.result() = 0xFFC0_0000;
            }
        },
    },
    Mutant {
        name: "there, the fused product is rounded",
        forms: &["VFMA", "VFMS", "VFNMA", "VFNMS"],
        alter: |b| {
            let (d, n) = (b.before.s[b.fd()], b.sn());
            let (flip_d, flip_n) = match b.form.name.as_str() {
                "VFMA" => (0, 0),
                "VFMS" => (0, 1 << 31),
                "VFNMA" => (1 << 31, 1 << 31),
                _ => (1 << 31, 0),
            };
            let product = f32::from_bits(n ^ flip_n) * f32::from_bits(b.sm());
            let twice = product + f32::from_bits(d ^ flip_d);
            if b.takes_the_short_way() && twice.is_normal() {
                *b.result() = twice.to_bits();
            }
        },
    },
    Mutant {
        name: "sticky flags are not",
        forms: ARITHMETIC,
        alter: |b| b.after.fpscr &= !(b.before.fpscr & 0x9F),
    },
    Mutant {
        name: "rounding up is rounding to nearest",
        forms: &["VADD", "VSUB", "VMUL"],
        alter: |b| {
            if b.mode() == 1 << 22 {
                let (n, m) = (f32::from_bits(b.sn()), f32::from_bits(b.sm()));
                let nearest = match b.form.name.as_str() {
                    "VADD" => n + m,
                    "VSUB" => n - m,
                    _ => n * m,
                };
                if !nearest.is_nan() {
                    *b.result() = nearest.to_bits();
                }
            }
        },
    },
    Mutant {
        name: "rounding down is rounding towards zero",
        forms: &["VADD", "VSUB", "VMUL", "VDIV"],
        alter: |b| {
            if b.mode() == 2 << 22 && b.raised(IXC) && *b.result() >> 31 == 1 {
                *b.result() -= 1;
            }
        },
    },
    Mutant {
        name: "what is flushed to zero loses its sign",
        forms: ARITHMETIC,
        alter: |b| {
            if b.mode() & 1 << 24 != 0 && b.raised(UFC) && *b.result() == 1 << 31 {
                *b.result() = 0;
            }
        },
    },
    Mutant {
        name: "the default NaN is negative",
        forms: ARITHMETIC,
        alter: |b| {
            if *b.result() == 0x7FC0_0000 {
                *b.result() = 0xFFC0_0000;
            }
        },
    },
    Mutant {
        name: "the second NaN is taken",
        forms: &["VADD", "VSUB", "VMUL", "VDIV"],
        alter: |b| {
            let (n, m) = (b.sn(), b.sm());
            if is_nan(n) && is_nan(m) && b.mode() & 1 << 25 == 0 && !is_signalling(n) {
                *b.result() = m | 1 << 22;
            }
        },
    },
    Mutant {
        name: "a signalling NaN has no precedence",
        forms: &["VADD", "VSUB", "VMUL", "VDIV"],
        alter: |b| {
            let (n, m) = (b.sn(), b.sm());
            if is_nan(n) && !is_signalling(n) && is_signalling(m) && b.mode() & 1 << 25 == 0 {
                *b.result() = n;
            }
        },
    },
    Mutant {
        name: "a NaN stays signalling",
        forms: &["VADD", "VMUL"],
        alter: |b| {
            if is_signalling(b.sn()) && b.mode() & 1 << 25 == 0 {
                *b.result() = b.sn();
            }
        },
    },
    Mutant {
        name: "division by zero is not noticed",
        forms: &["VDIV"],
        alter: |b| {
            b.after.fpscr &= !DZC | b.before.fpscr;
        },
    },
    Mutant {
        name: "the root of minus zero is zero",
        forms: &["VSQRT"],
        alter: |b| {
            if b.sm() == 1 << 31 {
                *b.result() = 0;
            }
        },
    },
    Mutant {
        name: "VFMA rounds twice",
        forms: &["VFMA"],
        alter: |b| {
            let d = f32::from_bits(b.before.s[b.fd()]);
            let twice = f32::from_bits(b.sn()) * f32::from_bits(b.sm()) + d;
            if b.mode() == 0 && twice.is_normal() {
                *b.result() = twice.to_bits();
            }
        },
    },
    Mutant {
        name: "VMLA rounds once",
        forms: &["VMLA"],
        alter: |b| {
            let d = f32::from_bits(b.before.s[b.fd()]);
            let once = f32::from_bits(b.sn()).mul_add(f32::from_bits(b.sm()), d);
            if b.mode() == 0 && once.is_normal() {
                *b.result() = once.to_bits();
            }
        },
    },
    Mutant {
        name: "VCMP minds a quiet NaN",
        forms: &["VCMP"],
        alter: |b| {
            if b.after.fpscr >> 28 == 3 {
                b.after.fpscr |= IOC;
            }
        },
    },
    Mutant {
        name: "VCMPE does not mind a quiet NaN",
        forms: &["VCMP", "VCMP zero"],
        alter: |b| {
            if b.f(b'x') == 1 && !is_signalling(b.sm()) && !is_signalling(b.before.s[b.fd()]) {
                b.after.fpscr &= !IOC | b.before.fpscr;
            }
        },
    },
    Mutant {
        name: "a conversion saturates in silence",
        forms: &["VCVT to signed", "VCVT to unsigned"],
        alter: |b| b.after.fpscr &= !IOC | b.before.fpscr,
    },
    Mutant {
        name: "VCVT rounds to nearest",
        forms: &["VCVT to signed"],
        alter: |b| {
            let value = f32::from_bits(b.sm());
            if b.f(b'x') == 1 && value.abs() < 1e6 && b.mode() == 0 {
                *b.result() = value.round_ties_even() as i32 as u32;
            }
        },
    },
    Mutant {
        name: "VCVTR ignores the mode",
        forms: &["VCVT to signed"],
        alter: |b| {
            let value = f32::from_bits(b.sm());
            if b.f(b'x') == 0 && value.is_normal() && value.abs() < 1e6 {
                *b.result() = value.round_ties_even() as i32 as u32;
            }
        },
    },
    Mutant {
        name: "a negative number converts to an unsigned one that has wrapped",
        forms: &["VCVT to unsigned"],
        alter: |b| {
            let value = f32::from_bits(b.sm());
            if value <= -1.0 && value > -2e9 {
                *b.result() = value as i32 as u32;
            }
        },
    },
    Mutant {
        name: "an unsigned integer converts as a signed one",
        forms: &["VCVT from int"],
        alter: |b| {
            let value = b.sm() as i32;
            if b.f(b'x') == 0 && b.mode() == 0 {
                *b.result() = (value as f32).to_bits();
            }
        },
    },
    Mutant {
        name: "a fraction has a bit more",
        forms: &["VCVT from fixed"],
        alter: |b| {
            if *b.result() & 0x7FFF_FFFF != 0 {
                *b.result() -= 1 << 23;
            }
        },
    },
    Mutant {
        name: "the alternative half is an ordinary one",
        forms: &["VCVT from half"],
        alter: |b| {
            if b.mode() & 1 << 26 != 0 && *b.result() & 0x7FFF_FFFF >= 0x4780_0000 {
                *b.result() |= 0x7F80_0000;
            }
        },
    },
    Mutant {
        name: "a half overflows to the largest",
        forms: &["VCVT to half"],
        alter: |b| {
            if b.raised(OFC) && b.mode() == 0 {
                let shift = 16 * (b.encoding >> 7 & 1);
                *b.result() -= 1 << shift;
            }
        },
    },
    Mutant {
        name: "VCVTT clears the other half",
        forms: &["VCVT to half"],
        alter: |b| {
            if b.encoding >> 7 & 1 == 1 {
                *b.result() &= 0xFFFF_0000;
            }
        },
    },
    Mutant { name: "VNEG is VABS", forms: &["VNEG"], alter: |b| *b.result() &= !(1 << 31) },
    Mutant { name: "VMRS takes no V", forms: &["VMRS flags"], alter: |b| b.after.apsr &= !V },
    Mutant {
        name: "VMSR writes reserved bits",
        forms: &["VMSR"],
        alter: |b| b.after.fpscr = b.reg(b't'),
    },
];
