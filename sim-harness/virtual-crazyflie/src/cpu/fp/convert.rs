//! Conversions: integers, fixed point, half precision.

use super::exact::{
    ALTERNATIVE_HALF, Class, HALF, Number, SINGLE, round_to, signals, signed, unpack,
};
use super::{Flag, Fpscr, INFINITY, Rounding, SIGN};

/// A fixed-point format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fixed {
    /// Its bits: 16 or 32.
    pub bits: u8,
    /// The number of bits behind the point.
    pub fraction: u8,
    /// Two's complement.
    pub signed: bool,
}

impl Fixed {
    const fn integer(signed: bool) -> Self {
        Self { bits: 32, fraction: 0, signed }
    }

    /// The least and the greatest, in units of the last bit.
    const fn range(self) -> (i128, i128) {
        if self.signed {
            (-(1 << (self.bits - 1)), (1 << (self.bits - 1)) - 1)
        } else {
            (0, (1 << self.bits) - 1)
        }
    }

    /// The value of the bits in a register, in units of the last bit.
    const fn value(self, bits: u32) -> i64 {
        let unused = 32 - self.bits as u32;
        if self.signed {
            ((bits << unused) as i32 >> unused) as i64
        } else {
            (bits << unused >> unused) as i64
        }
    }
}

/// VCVT and VCVTR to an integer: towards zero, or as FPSCR says.
#[inline]
pub fn to_int(a: u32, signed: bool, towards_zero: bool, fpscr: &mut Fpscr) -> u32 {
    let x = f32::from_bits(a);
    if signed && towards_zero && !fpscr.fz() && x.abs() < 2_147_483_648.0 {
        #[expect(clippy::cast_possible_truncation, reason = "as the instruction does")]
        let integer = x as i32;
        // Where the integer has more bits than a float, the float was one.
        #[expect(clippy::cast_precision_loss, reason = "as the instruction does")]
        if integer as f32 != x {
            fpscr.raise(Flag::Inexact);
        }
        return integer as u32;
    }
    let rounding = if towards_zero { Rounding::Zero } else { fpscr.rounding() };
    to_fixed_rounded(a, Fixed::integer(signed), rounding, fpscr)
}

/// VCVT from an integer, rounded as FPSCR says.
#[inline]
pub fn from_int(value: u32, signed: bool, fpscr: &mut Fpscr) -> u32 {
    let format = Fixed::integer(signed);
    if format.value(value).unsigned_abs() <= 1 << 24 {
        #[expect(clippy::cast_precision_loss, reason = "nothing is lost below 2^24")]
        return (format.value(value) as f32).to_bits();
    }
    let rounding = fpscr.rounding();
    from_fixed_rounded(value, format, rounding, fpscr)
}

/// VCVT to fixed point, towards zero: the whole destination register, extended.
#[inline]
pub fn to_fixed(a: u32, format: Fixed, fpscr: &mut Fpscr) -> u32 {
    to_fixed_rounded(a, format, Rounding::Zero, fpscr)
}

/// VCVT from fixed point, to nearest. Of a 16-bit format only the low half of `value` counts.
#[inline]
pub fn from_fixed(value: u32, format: Fixed, fpscr: &mut Fpscr) -> u32 {
    from_fixed_rounded(value, format, Rounding::Nearest, fpscr)
}

/// FPToFixed. A NaN becomes zero, and what is out of range the nearest that is not.
fn to_fixed_rounded(a: u32, format: Fixed, rounding: Rounding, fpscr: &mut Fpscr) -> u32 {
    let (least, greatest) = format.range();
    let (exact, inexact) = match unpack(a, fpscr) {
        Class::Zero => return 0,
        Class::Nan => {
            fpscr.raise(Flag::InvalidOperation);
            return 0;
        }
        Class::Infinity => (if a & SIGN == 0 { i128::MAX } else { i128::MIN }, false),
        Class::Number(x) => {
            let (magnitude, inexact) = x.scaled(i32::from(format.fraction)).to_integer(rounding);
            let magnitude = magnitude as i128;
            (if x.negative { -magnitude } else { magnitude }, inexact)
        }
    };
    let fitting = exact.clamp(least, greatest);
    if fitting != exact {
        fpscr.raise(Flag::InvalidOperation);
    } else if inexact {
        fpscr.raise(Flag::Inexact);
    }
    fitting as u32
}

/// FixedToFP. Zero is positive.
fn from_fixed_rounded(value: u32, format: Fixed, rounding: Rounding, fpscr: &mut Fpscr) -> u32 {
    let value = format.value(value);
    if value == 0 {
        return 0;
    }
    let magnitude = u128::from(value.unsigned_abs());
    let x = Number::new(value < 0, magnitude, -i32::from(format.fraction));
    signed(x.negative, round_to(x, &SINGLE, rounding, fpscr))
}

/// VCVTB and VCVTT from half precision. It is exact; FZ does not concern half precision.
#[inline]
pub fn half_to_single(half: u16, fpscr: &mut Fpscr) -> u32 {
    let half = u32::from(half);
    let sign = (half & 0x8000) << 16;
    let fraction = half & 0x03FF;
    let to_single = |negative_exponent: i32| {
        let x = Number::new(false, u128::from(fraction), negative_exponent);
        round_to(x, &SINGLE, Rounding::Nearest, &mut Fpscr::default())
    };
    sign | match half >> 10 & 0x1F {
        0 if fraction == 0 => 0,
        0 => to_single(-24),
        31 if !fpscr.ahp() && fraction == 0 => INFINITY,
        31 if !fpscr.ahp() => {
            if fraction & 0x0200 == 0 {
                fpscr.raise(Flag::InvalidOperation);
            }
            if fpscr.dn() {
                return 0x7FC0_0000;
            }
            0x7FC0_0000 | fraction << 13
        }
        exponent => (exponent + 112) << 23 | fraction << 13,
    }
}

/// VCVTB and VCVTT to half precision, rounded as FPSCR says.
#[inline]
pub fn single_to_half(a: u32, fpscr: &mut Fpscr) -> u16 {
    let sign = a >> 16 & 0x8000;
    let magnitude = match unpack(a, fpscr) {
        Class::Zero => 0,
        Class::Nan => {
            if fpscr.ahp() || signals(a) {
                fpscr.raise(Flag::InvalidOperation);
            }
            if fpscr.ahp() {
                0
            } else if fpscr.dn() {
                return 0x7E00;
            } else {
                0x7E00 | a >> 13 & 0x01FF
            }
        }
        Class::Infinity if fpscr.ahp() => {
            fpscr.raise(Flag::InvalidOperation);
            0x7FFF
        }
        Class::Infinity => HALF_INFINITY,
        Class::Number(x) => {
            let format = if fpscr.ahp() { &ALTERNATIVE_HALF } else { &HALF };
            round_to(x, format, fpscr.rounding(), fpscr)
        }
    };
    (sign | magnitude) as u16
}

const HALF_INFINITY: u32 = 0x7C00;

/// The constant of VMOV (immediate): VFPExpandImm.
#[inline]
#[must_use]
pub const fn immediate(imm8: u8) -> u32 {
    let sign = (imm8 as u32 & 0x80) << 24;
    let exponent = if imm8 & 0x40 != 0 { 0x1F << 25 } else { 1 << 30 };
    sign | exponent | (imm8 as u32 & 0x3F) << 19
}
