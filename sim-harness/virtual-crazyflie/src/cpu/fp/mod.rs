//! The arithmetic of FPv4-SP, on bits.
//!
//! The host's own `f32` computes what it computes alike: results to nearest that are ordinary
//! numbers, once the inexact flag is set and need not be found. Everything else (`exact`) is
//! computed with integers, by the pseudo-code of DDI 0403 (D6.7.4): so the same bits come out on
//! every host. Of the host nothing is used but the operations that IEEE 754 fixes to the last
//! bit, and never a NaN that it made.

mod convert;
mod exact;
mod status;
#[cfg(test)]
mod tests;

pub use convert::{
    Fixed, from_fixed, from_int, half_to_single, immediate, single_to_half, to_fixed, to_int,
};
pub use status::{Flag, Fpscr, Rounding};

const SIGN: u32 = 0x8000_0000;
const MAGNITUDE: u32 = 0x7FFF_FFFF;
const INFINITY: u32 = 0x7F80_0000;
const SMALLEST_NORMAL: u32 = 0x0080_0000;

/// VNEG. The sign of a NaN changes too.
#[inline]
#[must_use]
pub const fn neg(a: u32) -> u32 {
    a ^ SIGN
}

/// VABS.
#[inline]
#[must_use]
pub const fn abs(a: u32) -> u32 {
    a & MAGNITUDE
}

/// Neither an infinity nor a NaN.
#[inline]
const fn finite(bits: u32) -> bool {
    bits & MAGNITUDE < INFINITY
}

/// Certainly finite, and not tiny before it was rounded either.
#[inline]
const fn ordinary(bits: u32) -> bool {
    (bits & MAGNITUDE).wrapping_sub(SMALLEST_NORMAL + 1) < INFINITY - SMALLEST_NORMAL - 1
}

/// VADD.
#[inline]
pub fn add(a: u32, b: u32, fpscr: &mut Fpscr) -> u32 {
    if fpscr.plain_and_inexact() {
        // A sum that is tiny is exact, so it does not underflow.
        let sum = (f32::from_bits(a) + f32::from_bits(b)).to_bits();
        if finite(sum) {
            return sum;
        }
    }
    exact::add(a, b, fpscr)
}

/// VSUB.
#[inline]
pub fn sub(a: u32, b: u32, fpscr: &mut Fpscr) -> u32 {
    if fpscr.plain_and_inexact() {
        let difference = (f32::from_bits(a) - f32::from_bits(b)).to_bits();
        if finite(difference) {
            return difference;
        }
    }
    exact::sub(a, b, fpscr)
}

/// VMUL.
#[inline]
pub fn mul(a: u32, b: u32, fpscr: &mut Fpscr) -> u32 {
    if fpscr.plain_and_inexact() {
        let product = (f32::from_bits(a) * f32::from_bits(b)).to_bits();
        let zero = abs(product) == 0 && (abs(a) == 0 || abs(b) == 0);
        if ordinary(product) || zero {
            return product;
        }
    }
    exact::mul(a, b, fpscr)
}

/// VNMUL.
#[inline]
pub fn nmul(a: u32, b: u32, fpscr: &mut Fpscr) -> u32 {
    neg(mul(a, b, fpscr))
}

/// VDIV.
#[inline]
pub fn div(a: u32, b: u32, fpscr: &mut Fpscr) -> u32 {
    if fpscr.plain_and_inexact() {
        let quotient = (f32::from_bits(a) / f32::from_bits(b)).to_bits();
        if ordinary(quotient) || abs(quotient) == 0 && abs(a) == 0 {
            return quotient;
        }
    }
    exact::div(a, b, fpscr)
}

/// VSQRT.
#[inline]
pub fn sqrt(a: u32, fpscr: &mut Fpscr) -> u32 {
    if fpscr.plain_and_inexact() && (SMALLEST_NORMAL..INFINITY).contains(&a) {
        return f32::from_bits(a).sqrt().to_bits();
    }
    exact::sqrt(a, fpscr)
}

/// VMLA: `d + n * m`, rounded twice.
#[inline]
pub fn mla(d: u32, n: u32, m: u32, fpscr: &mut Fpscr) -> u32 {
    let product = mul(n, m, fpscr);
    add(d, product, fpscr)
}

/// VMLS: `d - n * m`, rounded twice.
#[inline]
pub fn mls(d: u32, n: u32, m: u32, fpscr: &mut Fpscr) -> u32 {
    let product = mul(n, m, fpscr);
    add(d, neg(product), fpscr)
}

/// VNMLA: `-d - n * m`, rounded twice.
#[inline]
pub fn nmla(d: u32, n: u32, m: u32, fpscr: &mut Fpscr) -> u32 {
    let product = mul(n, m, fpscr);
    add(neg(d), neg(product), fpscr)
}

/// VNMLS: `-d + n * m`, rounded twice.
#[inline]
pub fn nmls(d: u32, n: u32, m: u32, fpscr: &mut Fpscr) -> u32 {
    let product = mul(n, m, fpscr);
    add(neg(d), product, fpscr)
}

/// VFMA: `d + n * m`, rounded once.
#[inline]
pub fn fma(d: u32, n: u32, m: u32, fpscr: &mut Fpscr) -> u32 {
    if fpscr.plain_and_inexact() {
        // In f64 the product is exact and the sum is rounded. Rounded again it is right, unless
        // the first rounding has led to the middle between two f32: there the way to go is lost.
        let product = f64::from(f32::from_bits(n)) * f64::from(f32::from_bits(m));
        let sum = product + f64::from(f32::from_bits(d));
        #[expect(clippy::cast_possible_truncation, reason = "this is the second rounding")]
        let result = (sum as f32).to_bits();
        if ordinary(result) && sum.to_bits() & 0x1FFF_FFFF != 0x1000_0000 {
            return result;
        }
    }
    exact::fma(d, n, m, fpscr)
}

/// VFMS: `d - n * m`, rounded once.
#[inline]
pub fn fms(d: u32, n: u32, m: u32, fpscr: &mut Fpscr) -> u32 {
    fma(d, neg(n), m, fpscr)
}

/// VFNMA: `-d - n * m`, rounded once.
#[inline]
pub fn fnma(d: u32, n: u32, m: u32, fpscr: &mut Fpscr) -> u32 {
    fma(neg(d), neg(n), m, fpscr)
}

/// VFNMS: `-d + n * m`, rounded once.
#[inline]
pub fn fnms(d: u32, n: u32, m: u32, fpscr: &mut Fpscr) -> u32 {
    fma(neg(d), n, m, fpscr)
}

/// VCMP, and with `signalling` VCMPE, which takes offence at quiet NaNs too. The outcome is in
/// FPSCR.NZCV.
#[inline]
pub fn compare(a: u32, b: u32, signalling: bool, fpscr: &mut Fpscr) {
    let (x, y) = (f32::from_bits(a), f32::from_bits(b));
    match x.partial_cmp(&y) {
        Some(order) if !fpscr.fz() => fpscr.set_nzcv(match order {
            std::cmp::Ordering::Equal => 0b0110,
            std::cmp::Ordering::Less => 0b1000,
            std::cmp::Ordering::Greater => 0b0010,
        }),
        _ => exact::compare(a, b, signalling, fpscr),
    }
}
