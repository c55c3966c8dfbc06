//! Every case, in integers: the pseudo-code of DDI 0403 for numbers, NaNs, flags and modes.
//!
//! An operand is taken apart (FPUnpack), the operation is done exactly or with a last bit that
//! stands for all that is smaller, and what comes out is rounded once (FPRound).

use std::cmp::Ordering;

use super::{Flag, Fpscr, INFINITY, MAGNITUDE, Rounding, SIGN, SMALLEST_NORMAL, neg};

/// The default NaN.
const DEFAULT_NAN: u32 = 0x7FC0_0000;
/// Set in a quiet NaN.
const QUIET: u32 = 0x0040_0000;

/// A number other than zero: `mantissa * 2^exponent`, with [`TOP`] the mantissa's highest bit.
///
/// The lowest bit may stand for a rest that does not fit. That is far enough below whatever is
/// rounded that nothing else can be confused with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Number {
    pub(super) negative: bool,
    mantissa: u128,
    exponent: i32,
}

/// So high that the sum of two mantissas still fits, and a product of 48 bits leaves room below
/// for an addend of 24.
const TOP: u32 = 125;

/// An operand taken apart.
#[derive(Clone, Copy, Debug)]
pub(super) enum Class {
    Zero,
    Number(Number),
    Infinity,
    Nan,
}

/// A floating-point format.
pub(super) struct Format {
    /// Bits of the fraction.
    fraction: u32,
    /// The exponent of the smallest normal number.
    smallest: i32,
    /// The first bits, without the sign, that are too large to be a number.
    end: u32,
}

pub(super) const SINGLE: Format = Format { fraction: 23, smallest: -126, end: INFINITY };
pub(super) const HALF: Format = Format { fraction: 10, smallest: -14, end: 0x7C00 };
/// The alternative half precision has numbers where the other has infinities and NaNs.
pub(super) const ALTERNATIVE_HALF: Format = Format { fraction: 10, smallest: -14, end: 0x8000 };

impl Number {
    /// The exponent of any mantissa but zero.
    pub(super) const fn new(negative: bool, mantissa: u128, exponent: i32) -> Self {
        let up = mantissa.leading_zeros() as i32 - (127 - TOP as i32);
        if up < 0 {
            // One bit too many, as a sum may have.
            let mantissa = mantissa >> 1 | mantissa & 1;
            return Self { negative, mantissa, exponent: exponent + 1 };
        }
        Self { negative, mantissa: mantissa << up, exponent: exponent - up }
    }

    /// Multiplied by a power of two.
    pub(super) const fn scaled(self, power: i32) -> Self {
        Self { exponent: self.exponent + power, ..self }
    }

    /// A mantissa and a bit for the rest.
    const fn with_rest(negative: bool, mantissa: u128, rest: bool, exponent: i32) -> Self {
        Self::new(negative, mantissa << 1 | rest as u128, exponent - 1)
    }

    /// The sum; `None` for zero.
    fn plus(self, other: Self) -> Option<Self> {
        let larger_first = |x: &Self| (x.exponent, x.mantissa);
        let (large, small) =
            if larger_first(&self) >= larger_first(&other) { (self, other) } else { (other, self) };
        let distance = large.exponent.abs_diff(small.exponent).min(127);
        let rest = small.mantissa & ((1 << distance) - 1) != 0;
        let aligned = small.mantissa >> distance | u128::from(rest);
        let mantissa = if large.negative == small.negative {
            large.mantissa + aligned
        } else {
            large.mantissa - aligned
        };
        (mantissa != 0).then(|| Self::new(large.negative, mantissa, large.exponent))
    }

    fn times(self, other: Self) -> Self {
        // Of an operand only the upper 24 bits are not zero.
        let mantissa = (self.mantissa >> 64) * (other.mantissa >> 64);
        let exponent = self.exponent + other.exponent + 128;
        Self::new(self.negative != other.negative, mantissa, exponent)
    }

    fn over(self, divisor: Self) -> Self {
        let by = divisor.mantissa >> 64;
        let exponent = self.exponent - divisor.exponent - 64;
        let rest = !self.mantissa.is_multiple_of(by);
        Self::with_rest(self.negative != divisor.negative, self.mantissa / by, rest, exponent)
    }

    fn square_root(self) -> Self {
        let odd = self.exponent & 1;
        let square = self.mantissa >> odd;
        let root = square.isqrt();
        Self::with_rest(false, root, root * root != square, (self.exponent + odd) / 2)
    }

    /// Drops so many bits, rounded; returns whether that lost anything.
    fn without(self, bits: u32, rounding: Rounding) -> (u128, bool) {
        // No mantissa is half as much as the 127th bit.
        let bits = bits.min(127);
        let kept = self.mantissa >> bits;
        let rest = self.mantissa & ((1 << bits) - 1);
        let half = (1 << bits) >> 1;
        let up = match rounding {
            Rounding::Nearest => match rest.cmp(&half) {
                Ordering::Less => false,
                Ordering::Equal => kept & 1 == 1,
                Ordering::Greater => true,
            },
            Rounding::Up => rest != 0 && !self.negative,
            Rounding::Down => rest != 0 && self.negative,
            Rounding::Zero => false,
        };
        (kept + u128::from(up), rest != 0)
    }

    /// The magnitude as an integer, and whether it is not exactly that. What has more than 64 bits
    /// is cut to that which has.
    pub(super) fn to_integer(self, rounding: Rounding) -> (u128, bool) {
        match u32::try_from(-self.exponent) {
            Ok(below) if below >= TOP - 64 => self.without(below, rounding),
            _ => (1 << 65, false),
        }
    }
}

/// A sign for a format with the sign in bit 31.
pub(super) const fn signed(negative: bool, magnitude: u32) -> u32 {
    magnitude | if negative { SIGN } else { 0 }
}

/// FPUnpack: an operand taken apart.
pub(super) fn unpack(bits: u32, fpscr: &mut Fpscr) -> Class {
    let magnitude = bits & MAGNITUDE;
    let fraction = u128::from(magnitude & (SMALLEST_NORMAL - 1));
    let negative = bits != magnitude;
    match magnitude {
        0 => Class::Zero,
        1..SMALLEST_NORMAL if fpscr.fz() => {
            fpscr.raise(Flag::InputDenormal);
            Class::Zero
        }
        1..SMALLEST_NORMAL => Class::Number(Number::new(negative, fraction, -149)),
        SMALLEST_NORMAL..INFINITY => {
            let exponent = (magnitude >> 23) as i32 - 150;
            Class::Number(Number::new(negative, fraction | 1 << 23, exponent))
        }
        INFINITY => Class::Infinity,
        _ => Class::Nan,
    }
}

/// FPRound: the bits of a number in a format, without its sign.
pub(super) fn round_to(x: Number, to: &Format, rounding: Rounding, fpscr: &mut Fpscr) -> u32 {
    let exponent = x.exponent + TOP as i32;
    // How far it is below what is normal, before it is rounded.
    let tiny = u32::try_from(to.smallest - exponent).unwrap_or(0);
    let biased = u32::try_from(exponent - to.smallest).map_or(0, |above| above + 1);
    let (mantissa, inexact) = x.without(TOP - to.fraction + tiny, rounding);
    // The mantissa's highest bit counts as one in the exponent, and so does a carry.
    let bits = (biased.saturating_sub(1) << to.fraction) + mantissa as u32;
    if tiny > 0 && inexact {
        fpscr.raise(Flag::Underflow);
    }
    if bits >= to.end {
        return overflow(x.negative, to, rounding, fpscr);
    }
    if inexact {
        fpscr.raise(Flag::Inexact);
    }
    bits
}

fn overflow(negative: bool, to: &Format, rounding: Rounding, fpscr: &mut Fpscr) -> u32 {
    if to.end == ALTERNATIVE_HALF.end {
        fpscr.raise(Flag::InvalidOperation);
        return to.end - 1;
    }
    fpscr.raise(Flag::Overflow);
    fpscr.raise(Flag::Inexact);
    match rounding {
        Rounding::Nearest => to.end,
        Rounding::Up if !negative => to.end,
        Rounding::Down if negative => to.end,
        _ => to.end - 1,
    }
}

/// A result in single precision, flushed to zero if FPSCR says so: that is told by underflow
/// alone.
fn round(x: Number, fpscr: &mut Fpscr) -> u32 {
    if fpscr.fz() && x.exponent + (TOP as i32) < SINGLE.smallest {
        fpscr.raise(Flag::Underflow);
        return signed(x.negative, 0);
    }
    signed(x.negative, round_to(x, &SINGLE, fpscr.rounding(), fpscr))
}

const fn is_negative(bits: u32) -> bool {
    bits & SIGN != 0
}

/// Whether a NaN is a signalling one.
pub(super) const fn signals(nan: u32) -> bool {
    nan & QUIET == 0
}

const fn is_nan(bits: u32) -> bool {
    bits & MAGNITUDE > INFINITY
}

fn invalid(fpscr: &mut Fpscr) -> u32 {
    fpscr.raise(Flag::InvalidOperation);
    DEFAULT_NAN
}

/// FPProcessNaNs: which NaN comes of operands of which one at least is a NaN. The first that
/// signals goes before the first that is quiet.
fn process_nans(operands: &[u32], fpscr: &mut Fpscr) -> u32 {
    let nans = || operands.iter().copied().filter(|bits| is_nan(*bits));
    let signalling = nans().find(|nan| signals(*nan));
    if signalling.is_some() {
        fpscr.raise(Flag::InvalidOperation);
    }
    match signalling.or_else(|| nans().next()) {
        Some(nan) if !fpscr.dn() => nan | QUIET,
        _ => DEFAULT_NAN,
    }
}

/// The zero of a sum or product whose parts are not zero: negative if rounding goes down.
fn cancelled(fpscr: Fpscr) -> u32 {
    signed(fpscr.rounding() == Rounding::Down, 0)
}

/// FPAdd.
#[cold]
pub(super) fn add(a: u32, b: u32, fpscr: &mut Fpscr) -> u32 {
    sum(a, b, [a, b], fpscr)
}

/// FPSub. A NaN keeps its sign.
#[cold]
pub(super) fn sub(a: u32, b: u32, fpscr: &mut Fpscr) -> u32 {
    sum(a, neg(b), [a, b], fpscr)
}

fn sum(a: u32, b: u32, operands: [u32; 2], fpscr: &mut Fpscr) -> u32 {
    let same_sign = is_negative(a) == is_negative(b);
    match (unpack(a, fpscr), unpack(b, fpscr)) {
        (Class::Nan, _) | (_, Class::Nan) => process_nans(&operands, fpscr),
        (Class::Infinity, Class::Infinity) if !same_sign => invalid(fpscr),
        (Class::Infinity, _) => a,
        (_, Class::Infinity) => b,
        (Class::Zero, Class::Zero) if same_sign => a & SIGN,
        (Class::Zero, Class::Zero) => cancelled(*fpscr),
        (Class::Number(x), Class::Zero) | (Class::Zero, Class::Number(x)) => round(x, fpscr),
        (Class::Number(x), Class::Number(y)) => match x.plus(y) {
            Some(sum) => round(sum, fpscr),
            None => cancelled(*fpscr),
        },
    }
}

/// FPMul.
#[cold]
pub(super) fn mul(a: u32, b: u32, fpscr: &mut Fpscr) -> u32 {
    let negative = is_negative(a ^ b);
    match (unpack(a, fpscr), unpack(b, fpscr)) {
        (Class::Nan, _) | (_, Class::Nan) => process_nans(&[a, b], fpscr),
        (Class::Infinity, Class::Zero) | (Class::Zero, Class::Infinity) => invalid(fpscr),
        (Class::Infinity, _) | (_, Class::Infinity) => signed(negative, INFINITY),
        (Class::Zero, _) | (_, Class::Zero) => signed(negative, 0),
        (Class::Number(x), Class::Number(y)) => round(x.times(y), fpscr),
    }
}

/// FPDiv.
#[cold]
pub(super) fn div(a: u32, b: u32, fpscr: &mut Fpscr) -> u32 {
    let negative = is_negative(a ^ b);
    match (unpack(a, fpscr), unpack(b, fpscr)) {
        (Class::Nan, _) | (_, Class::Nan) => process_nans(&[a, b], fpscr),
        (Class::Infinity, Class::Infinity) | (Class::Zero, Class::Zero) => invalid(fpscr),
        (Class::Infinity, _) => signed(negative, INFINITY),
        (_, Class::Zero) => {
            fpscr.raise(Flag::DivisionByZero);
            signed(negative, INFINITY)
        }
        (Class::Zero, _) | (_, Class::Infinity) => signed(negative, 0),
        (Class::Number(x), Class::Number(y)) => round(x.over(y), fpscr),
    }
}

/// FPSqrt.
#[cold]
pub(super) fn sqrt(a: u32, fpscr: &mut Fpscr) -> u32 {
    match unpack(a, fpscr) {
        Class::Nan => process_nans(&[a], fpscr),
        Class::Zero => a & SIGN,
        Class::Infinity | Class::Number(_) if is_negative(a) => invalid(fpscr),
        Class::Infinity => a,
        Class::Number(x) => round(x.square_root(), fpscr),
    }
}

/// FPMulAdd: `d + n * m`. Infinity times zero is invalid even where a quiet NaN is added.
#[cold]
pub(super) fn fma(d: u32, n: u32, m: u32, fpscr: &mut Fpscr) -> u32 {
    let addend = unpack(d, fpscr);
    let (first, second) = (unpack(n, fpscr), unpack(m, fpscr));
    let negative = is_negative(n ^ m);
    let product = match (first, second) {
        (Class::Infinity, Class::Zero) | (Class::Zero, Class::Infinity) => {
            return if is_nan(d) && signals(d) {
                process_nans(&[d], fpscr)
            } else {
                invalid(fpscr)
            };
        }
        (Class::Nan, _) | (_, Class::Nan) => Class::Nan,
        (Class::Infinity, _) | (_, Class::Infinity) => Class::Infinity,
        (Class::Zero, _) | (_, Class::Zero) => Class::Zero,
        (Class::Number(x), Class::Number(y)) => Class::Number(x.times(y)),
    };
    let same_sign = is_negative(d) == negative;
    match (addend, product) {
        (Class::Nan, _) | (_, Class::Nan) => process_nans(&[d, n, m], fpscr),
        (Class::Infinity, Class::Infinity) if !same_sign => invalid(fpscr),
        (Class::Infinity, _) => d,
        (_, Class::Infinity) => signed(negative, INFINITY),
        (Class::Zero, Class::Zero) if same_sign => signed(negative, 0),
        (Class::Zero, Class::Zero) => cancelled(*fpscr),
        (Class::Number(x), Class::Zero) | (Class::Zero, Class::Number(x)) => round(x, fpscr),
        (Class::Number(x), Class::Number(y)) => match x.plus(y) {
            Some(sum) => round(sum, fpscr),
            None => cancelled(*fpscr),
        },
    }
}

/// FPCompare.
#[cold]
pub(super) fn compare(a: u32, b: u32, signalling: bool, fpscr: &mut Fpscr) {
    let (x, y) = (unpack(a, fpscr), unpack(b, fpscr));
    if is_nan(a) || is_nan(b) {
        if signalling || [a, b].iter().any(|bits| is_nan(*bits) && signals(*bits)) {
            fpscr.raise(Flag::InvalidOperation);
        }
        return fpscr.set_nzcv(0b0011);
    }
    // Of what is left, bits of the same sign are in the order of the numbers.
    let ordered = |bits: u32, class| match class {
        Class::Zero => 0,
        _ if is_negative(bits) => -i64::from(bits & MAGNITUDE),
        _ => i64::from(bits),
    };
    fpscr.set_nzcv(match ordered(a, x).cmp(&ordered(b, y)) {
        Ordering::Equal => 0b0110,
        Ordering::Less => 0b1000,
        Ordering::Greater => 0b0010,
    });
}
