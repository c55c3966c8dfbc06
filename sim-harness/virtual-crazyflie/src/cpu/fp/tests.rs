//! Against rustc_apfloat, which shares no line with what is tested, and where that has nothing to
//! say against what the operation is by definition.

use proptest::prelude::*;
use rustc_apfloat::ieee::{Double, Half, Single};
use rustc_apfloat::{Float, FloatConvert, Round, Status, StatusAnd};

use super::*;

const MODES: [Rounding; 4] = [Rounding::Nearest, Rounding::Up, Rounding::Down, Rounding::Zero];

/// FPSCR for a mode, with flags that are set already.
fn fpscr(mode: Rounding, flush: bool, default_nan: bool, flags: u32) -> Fpscr {
    let mode = MODES.iter().position(|each| *each == mode).unwrap() as u32;
    Fpscr::from_bits(mode << 22 | u32::from(flush) << 24 | u32::from(default_nan) << 25 | flags)
}

const fn theirs(mode: Rounding) -> Round {
    match mode {
        Rounding::Nearest => Round::NearestTiesToEven,
        Rounding::Up => Round::TowardPositive,
        Rounding::Down => Round::TowardNegative,
        Rounding::Zero => Round::TowardZero,
    }
}

fn is_nan(bits: u32) -> bool {
    abs(bits) > INFINITY
}

fn is_denormal(bits: u32) -> bool {
    (1..SMALLEST_NORMAL).contains(&abs(bits))
}

fn single(bits: u32) -> Single {
    Single::from_bits(u128::from(bits))
}

/// Numbers of every kind, most of them near where something changes.
fn operand() -> impl Strategy<Value = u32> {
    let special = prop::sample::select(vec![
        0,
        1,
        2,
        0x007F_FFFE,
        0x007F_FFFF,
        0x0080_0000,
        0x0080_0001,
        0x00FF_FFFF,
        0x0100_0000,
        0x3300_0000,
        0x337F_FFFF,
        0x3380_0000,
        0x3F7F_FFFF,
        0x3F80_0000,
        0x3F80_0001,
        0x3FFF_FFFF,
        0x4000_0000,
        0x4B7F_FFFF,
        0x4B80_0000,
        0x4F00_0000,
        0x4F7F_FFFF,
        0x7F00_0000,
        0x7F7F_FFFE,
        0x7F7F_FFFF,
        0x7F80_0000,
        0x7F80_0001,
        0x7FBF_FFFF,
        0x7FC0_0000,
        0x7FC1_2345,
        0x7FFF_FFFF,
    ]);
    // Few bits set in the fraction, so that exact results and ties come up.
    let round = (0u32..256, 0u32..8, 0u32..23)
        .prop_map(|(exponent, bits, shift)| exponent << 23 | (bits << shift) & 0x007F_FFFF);
    let near_one = (0x3E00_0000u32..0x4200_0000).prop_map(|bits| bits);
    let tiny = 0u32..0x0100_0000;
    let any_sign = prop_oneof![special, round, near_one, tiny, any::<u32>()];
    (any_sign, any::<bool>()).prop_map(|(bits, negative)| if negative { neg(bits) } else { bits })
}

fn modes() -> impl Strategy<Value = Fpscr> {
    let flags = prop::sample::select(vec![0, Flag::Inexact as u32, 0x9F]);
    (0usize..4, any::<bool>(), any::<bool>(), flags, 0u32..8).prop_map(
        |(m, fz, dn, flags, plain)| {
            // Half of them in the default mode.
            if plain < 4 {
                fpscr(Rounding::Nearest, false, false, flags)
            } else {
                fpscr(MODES[m], fz, dn, flags)
            }
        },
    )
}

/// The operands of the operation after FZ was applied.
fn flushed(operands: &[u32], fpscr: &mut Fpscr) -> Vec<u32> {
    let flush = fpscr.fz();
    let mut each = |bits: &u32| {
        if flush && is_denormal(*bits) {
            fpscr.raise(Flag::InputDenormal);
            *bits & SIGN
        } else {
            *bits
        }
    };
    operands.iter().map(&mut each).collect()
}

/// What apfloat is asked for.
#[derive(Clone, Copy)]
enum Operation {
    Add,
    Sub,
    Mul,
    Div,
    /// The first, and the product of the others.
    Fused,
}

impl Operation {
    fn of<F: Float>(self, x: &[F], round: Round) -> StatusAnd<F> {
        match self {
            Self::Add => x[0].add_r(x[1], round),
            Self::Sub => x[0].sub_r(x[1], round),
            Self::Mul => x[0].mul_r(x[1], round),
            Self::Div => x[0].div_r(x[1], round),
            Self::Fused => x[1].mul_add_r(x[2], x[0], round),
        }
    }
}

/// Whether what a finite result stands for is beyond the largest number, whatever it became.
fn beyond(singles: &[Single], operation: Operation) -> bool {
    let doubles: Vec<Double> = singles.iter().map(|x| x.convert(&mut false).value).collect();
    let truncated = operation.of(&doubles, Round::TowardZero).value;
    f64::from_bits(truncated.to_bits() as u64).abs() >= 128f64.exp2()
}

/// The result that an operation must give, from those of apfloat in each mode.
fn expected(operands: &[u32], operation: Operation, mut fpscr: Fpscr) -> (u32, Fpscr) {
    let operands = flushed(operands, &mut fpscr);
    let singles: Vec<Single> = operands.iter().map(|bits| single(*bits)).collect();
    let result = operation.of(&singles, theirs(fpscr.rounding()));
    let truncated = operation.of(&singles, Round::TowardZero);
    let nans: Vec<u32> = operands.iter().copied().filter(|bits| is_nan(*bits)).collect();
    let signalling = nans.iter().find(|nan| **nan & 0x0040_0000 == 0);
    if signalling.is_some() || result.status.contains(Status::INVALID_OP) {
        fpscr.raise(Flag::InvalidOperation);
    }
    if result.value.is_nan() {
        let first = signalling.or(nans.first());
        // Infinity times zero is invalid whatever is added.
        let from_product = signalling.is_none()
            && operands.len() == 3
            && matches!((abs(operands[1]), abs(operands[2])), (0, INFINITY) | (INFINITY, 0));
        if from_product {
            fpscr.raise(Flag::InvalidOperation);
        }
        return match first {
            Some(nan) if !fpscr.dn() && !from_product => (nan | 0x0040_0000, fpscr),
            _ => (0x7FC0_0000, fpscr),
        };
    }
    // Tiny before it is rounded: that is what truncation leaves.
    let inexact = result.status.contains(Status::INEXACT);
    let tiny = abs(truncated.value.to_bits() as u32) < SMALLEST_NORMAL
        && (inexact || truncated.value.is_denormal());
    let bits = result.value.to_bits() as u32;
    if tiny && fpscr.fz() {
        fpscr.raise(Flag::Underflow);
        return (bits & SIGN, fpscr);
    }
    for (status, flag) in
        [(Status::DIV_BY_ZERO, Flag::DivisionByZero), (Status::INEXACT, Flag::Inexact)]
    {
        if result.status.contains(status) {
            fpscr.raise(flag);
        }
    }
    if inexact && (result.value.is_infinite() || beyond(&singles, operation)) {
        fpscr.raise(Flag::Overflow);
    }
    if tiny && inexact {
        fpscr.raise(Flag::Underflow);
    }
    (bits, fpscr)
}

/// Runs what is tested on a copy of FPSCR, and returns both.
fn ran(fpscr: Fpscr, operation: impl FnOnce(&mut Fpscr) -> u32) -> (u32, Fpscr) {
    let mut after = fpscr;
    (operation(&mut after), after)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn sums_and_differences_are_right(a in operand(), b in operand(), fpscr in modes()) {
        let wanted = expected(&[a, b], Operation::Add, fpscr);
        prop_assert_eq!(ran(fpscr, |f| add(a, b, f)), wanted);
        let wanted = expected(&[a, b], Operation::Sub, fpscr);
        prop_assert_eq!(ran(fpscr, |f| sub(a, b, f)), wanted);
    }

    #[test]
    fn numbers_that_nearly_cancel_are_subtracted_right(
        a in operand(), step in -3i32..4, fpscr in modes()
    ) {
        let b = a.wrapping_add_signed(step);
        let wanted = expected(&[a, b], Operation::Sub, fpscr);
        prop_assert_eq!(ran(fpscr, |f| sub(a, b, f)), wanted);
    }

    #[test]
    fn products_are_right(a in operand(), b in operand(), fpscr in modes()) {
        let wanted = expected(&[a, b], Operation::Mul, fpscr);
        prop_assert_eq!(ran(fpscr, |f| mul(a, b, f)), wanted);
        prop_assert_eq!(ran(fpscr, |f| nmul(a, b, f)), (neg(wanted.0), wanted.1));
    }

    #[test]
    fn quotients_are_right(a in operand(), b in operand(), fpscr in modes()) {
        let wanted = expected(&[a, b], Operation::Div, fpscr);
        prop_assert_eq!(ran(fpscr, |f| div(a, b, f)), wanted);
    }

    #[test]
    fn fused_sums_are_right(d in operand(), n in operand(), m in operand(), fpscr in modes()) {
        let fused = Operation::Fused;
        prop_assert_eq!(ran(fpscr, |f| fma(d, n, m, f)), expected(&[d, n, m], fused, fpscr));
        prop_assert_eq!(ran(fpscr, |f| fms(d, n, m, f)), expected(&[d, neg(n), m], fused, fpscr));
        let from = neg(d);
        prop_assert_eq!(ran(fpscr, |f| fnms(d, n, m, f)), expected(&[from, n, m], fused, fpscr));
        let wanted = expected(&[from, neg(n), m], fused, fpscr);
        prop_assert_eq!(ran(fpscr, |f| fnma(d, n, m, f)), wanted);
    }

    #[test]
    fn fused_sums_near_a_tie_are_right(
        n in 0x3F80_0000u32..0x4000_0000, m in 0x3F80_0000u32..0x4000_0000,
        away in 20u32..60, negative in any::<bool>(), fpscr in modes()
    ) {
        // An addend that is a bit near, or far below, the last place of the product.
        let d = (127 - away) << 23 | if negative { SIGN } else { 0 };
        let fused = Operation::Fused;
        prop_assert_eq!(ran(fpscr, |f| fma(d, n, m, f)), expected(&[d, n, m], fused, fpscr));
        // And a product that is one, against an addend that is large.
        let large = (127 + away) << 23 | m & 0x007F_FFFF;
        let wanted = expected(&[large, n, m], fused, fpscr);
        prop_assert_eq!(ran(fpscr, |f| fma(large, n, m, f)), wanted);
    }

    #[test]
    fn chained_sums_are_rounded_twice(
        d in operand(), n in operand(), m in operand(), fpscr in modes()
    ) {
        let (times, plus) = (Operation::Mul, Operation::Add);
        let (product, after) = expected(&[n, m], times, fpscr);
        prop_assert_eq!(ran(fpscr, |f| mla(d, n, m, f)), expected(&[d, product], plus, after));
        let wanted = expected(&[d, neg(product)], plus, after);
        prop_assert_eq!(ran(fpscr, |f| mls(d, n, m, f)), wanted);
        let wanted = expected(&[neg(d), neg(product)], plus, after);
        prop_assert_eq!(ran(fpscr, |f| nmla(d, n, m, f)), wanted);
        let wanted = expected(&[neg(d), product], plus, after);
        prop_assert_eq!(ran(fpscr, |f| nmls(d, n, m, f)), wanted);
    }

    /// A root is that number whose square is nearest, or next to, what it is the root of.
    #[test]
    fn roots_are_right(a in operand(), fpscr in modes()) {
        let (root, after) = ran(fpscr, |f| sqrt(a, f));
        let mut flags = fpscr;
        let a = flushed(&[a], &mut flags)[0];
        if is_nan(a) || a > SIGN {
            let quiet = is_nan(a) && a & 0x0040_0000 != 0;
            if !quiet {
                flags.raise(Flag::InvalidOperation);
            }
            let nan = if is_nan(a) && !fpscr.dn() { a | 0x0040_0000 } else { 0x7FC0_0000 };
            prop_assert_eq!((root, after), (nan, flags));
        } else if abs(a) == 0 || a == INFINITY {
            prop_assert_eq!((root, after), (a, flags));
        } else {
            // Squares of floats are exact in f64; so is the square of the middle between two.
            let exact = f64::from(f32::from_bits(a));
            let value = |bits: u32| f64::from(f32::from_bits(bits));
            let square = |x: f64| x * x;
            let below = square(value(root)) <= exact;
            let middle_below = (value(root - 1) + value(root)) / 2.0;
            let middle_above = (value(root) + value(root + 1)) / 2.0;
            let right = match fpscr.rounding() {
                Rounding::Nearest => square(middle_below) <= exact && exact <= square(middle_above),
                Rounding::Up => square(value(root - 1)) < exact && exact <= square(value(root)),
                _ => below && exact < square(value(root + 1)),
            };
            prop_assert!(right, "{a:08x} {root:08x}");
            if square(value(root)) != exact {
                flags.raise(Flag::Inexact);
            }
            prop_assert_eq!(after, flags);
        }
    }

    #[test]
    fn comparisons_are_right(a in operand(), b in operand(), e in any::<bool>(), fpscr in modes()) {
        let mut wanted = fpscr;
        let seen = flushed(&[a, b], &mut wanted);
        let (x, y) = (f32::from_bits(seen[0]), f32::from_bits(seen[1]));
        wanted.set_nzcv(if x < y { 8 } else if x > y { 2 } else if x == y { 6 } else { 3 });
        let signalling = [a, b].iter().any(|x| is_nan(*x) && x & 0x0040_0000 == 0);
        if signalling || e && (is_nan(a) || is_nan(b)) {
            wanted.raise(Flag::InvalidOperation);
        }
        let mut after = fpscr;
        compare(a, b, e, &mut after);
        prop_assert_eq!(after, wanted);
    }

    #[test]
    fn integers_come_of_floats(
        a in operand(), signed in any::<bool>(), to_zero in any::<bool>(), fpscr in modes()
    ) {
        let mut wanted = fpscr;
        let x = single(flushed(&[a], &mut wanted)[0]);
        let round = if to_zero { Round::TowardZero } else { theirs(fpscr.rounding()) };
        let (value, status) = if signed {
            let result = x.to_i128_r(32, round, &mut false);
            (result.value as u32, result.status)
        } else {
            let result = x.to_u128_r(32, round, &mut false);
            (result.value as u32, result.status)
        };
        if status.contains(Status::INVALID_OP) {
            wanted.raise(Flag::InvalidOperation);
        } else if status.contains(Status::INEXACT) {
            wanted.raise(Flag::Inexact);
        }
        prop_assert_eq!(ran(fpscr, |f| to_int(a, signed, to_zero, f)), (value, wanted));
    }

    #[test]
    fn floats_come_of_integers(
        value in prop_oneof![any::<u32>(), 0u32..0x0400_0000, 0x8000_0000u32..0x8400_0000],
        signed in any::<bool>(), fpscr in modes()
    ) {
        let round = theirs(fpscr.rounding());
        let result = if signed {
            Single::from_i128_r(i128::from(value as i32), round)
        } else {
            Single::from_u128_r(u128::from(value), round)
        };
        let mut wanted = fpscr;
        if result.status.contains(Status::INEXACT) {
            wanted.raise(Flag::Inexact);
        }
        let bits = result.value.to_bits() as u32;
        prop_assert_eq!(ran(fpscr, |f| from_int(value, signed, f)), (bits, wanted));
    }

    #[test]
    fn fixed_point_is_an_integer_that_is_scaled(
        a in operand(), value in any::<u32>(), wide in any::<bool>(), signed in any::<bool>(),
        fraction in 0u8..33, fpscr in modes()
    ) {
        let bits = if wide { 32 } else { 16 };
        let format = Fixed { bits, fraction: fraction.min(bits), signed };
        let scale = f64::from(format.fraction).exp2();

        // A float times a power of two is exact in f64, and so is every limit.
        let mut wanted = fpscr;
        let x = f64::from(f32::from_bits(flushed(&[a], &mut wanted)[0])) * scale;
        let width = f64::from(bits).exp2();
        let (least, end) = if signed { (-width / 2.0, width / 2.0) } else { (0.0, width) };
        let fitting = x.trunc().clamp(least, end - 1.0);
        if x.is_nan() || x.trunc() != fitting {
            wanted.raise(Flag::InvalidOperation);
        } else if x.trunc() != x {
            wanted.raise(Flag::Inexact);
        }
        let fixed = fitting as i64 as u32;
        prop_assert_eq!(ran(fpscr, |f| to_fixed(a, format, f)), (fixed, wanted));

        // So is an integer of 32 bits; it is rounded to nearest whatever the mode.
        let mut wanted = fpscr;
        let integer = match (wide, signed) {
            (true, true) => f64::from(value as i32),
            (true, false) => f64::from(value),
            (false, true) => f64::from(value as i16),
            (false, false) => f64::from(value as u16),
        };
        let float = (integer / scale) as f32;
        if f64::from(float) != integer / scale {
            wanted.raise(Flag::Inexact);
        }
        let result = ran(fpscr, |f| from_fixed(value, format, f));
        prop_assert_eq!(result, (float.to_bits(), wanted));
    }

    #[test]
    fn half_precision_comes_of_floats(a in operand(), near in 0x3300_0000u32..0x4800_0000, fpscr in modes()) {
        for a in [a, near, neg(near), near & 0xFFFF_F000, near & 0xFFFF_E000] {
            let mut wanted = fpscr;
            let x = single(flushed(&[a], &mut wanted)[0]);
            let to_half = |round| -> StatusAnd<Half> { x.convert_r(round, &mut false) };
            let result = to_half(theirs(fpscr.rounding()));
            let bits = if is_nan(a) {
                if a & 0x0040_0000 == 0 {
                    wanted.raise(Flag::InvalidOperation);
                }
                if fpscr.dn() { 0x7E00 } else { (a >> 16 & 0x8000 | 0x7E00 | a >> 13 & 0x1FF) as u16 }
            } else {
                let tiny = to_half(Round::TowardZero).value.to_bits() as u32 & 0x7FFF < 0x0400;
                if result.status.contains(Status::INEXACT) {
                    wanted.raise(Flag::Inexact);
                    if tiny {
                        wanted.raise(Flag::Underflow);
                    }
                }
                let finite = abs(a) < INFINITY;
                let beyond = f32::from_bits(a).abs() >= 65536.0;
                if finite && (beyond || result.value.is_infinite()) {
                    wanted.raise(Flag::Overflow);
                }
                result.value.to_bits() as u16
            };
            prop_assert_eq!(
                ran(fpscr, |f| u32::from(single_to_half(a, f))),
                (u32::from(bits), wanted),
                "{:08x}", a
            );
        }
    }
}

#[test]
fn every_half_becomes_a_float_and_the_same_half_again() {
    for ahp in [0, 1 << 26] {
        let fpscr = Fpscr::from_bits(ahp | 1 << 24);
        for half in 0..=u16::MAX {
            let (bits, after) = ran(fpscr, |f| half_to_single(half, f));
            let (exponent, fraction) = (i32::from(half >> 10 & 31), i32::from(half & 0x3FF));
            if exponent == 31 && fraction != 0 && ahp == 0 {
                assert!(is_nan(bits) && bits & 0x0040_0000 != 0);
                assert_eq!(after.has(Flag::InvalidOperation), half & 0x200 == 0);
                assert_eq!(half | 0x200, ran(fpscr, |f| single_to_half(bits, f).into()).0 as u16);
                continue;
            }
            let magnitude = match exponent {
                31 if ahp == 0 => f64::INFINITY,
                0 => f64::from(fraction) * (-24f64).exp2(),
                _ => f64::from(fraction + 1024) * f64::from(exponent - 25).exp2(),
            };
            let value = if half >= 0x8000 { -magnitude } else { magnitude };
            assert_eq!(bits, (value as f32).to_bits(), "{half:04x}");
            assert_eq!(after, fpscr);
            assert_eq!(ran(fpscr, |f| single_to_half(bits, f).into()), (u32::from(half), fpscr));
        }
    }
}

#[test]
fn the_alternative_half_precision_saturates_and_has_no_nans() {
    let fpscr = Fpscr::from_bits(1 << 26);
    let invalid = Fpscr::from_bits(1 << 26 | 1);
    let to_half = |a| ran(fpscr, |f| single_to_half(a, f).into());
    assert_eq!(to_half(0x47FF_E000), (0x7FFF, fpscr), "the greatest there is, 131008");
    assert_eq!(to_half(0x4800_0000), (0x7FFF, invalid), "131072");
    assert_eq!(to_half(0xFF80_0000), (0xFFFF, invalid), "minus infinity");
    assert_eq!(to_half(0xFFC0_0000), (0x8000, invalid), "a quiet NaN");
}

#[test]
fn flags_stay_set() {
    let mut fpscr = Fpscr::default();
    assert_eq!(div(0x3F80_0000, 0, &mut fpscr), INFINITY);
    add(0x3F80_0000, 0x3F80_0000, &mut fpscr);
    assert_eq!(fpscr.bits(), Flag::DivisionByZero as u32);
}

#[test]
fn what_is_rounded_up_to_the_smallest_normal_number_underflows() {
    let mut fpscr = Fpscr::from_bits(Flag::Inexact as u32);
    // 0x007FFFFF.8 by its exact value: tiny, but rounded no longer.
    let result = mul(0x00FF_FFFF, 0x3F00_0000, &mut fpscr);
    assert_eq!(result, SMALLEST_NORMAL);
    assert!(fpscr.has(Flag::Underflow));
}

#[test]
fn immediates_are_those_of_the_assembler() {
    for (imm8, value) in [(0x70, 1.0), (0x00, 2.0), (0xF0, -1.0), (0x3F, 31.0), (0x40, 0.125)] {
        assert_eq!(f32::from_bits(immediate(imm8)), value);
    }
}
