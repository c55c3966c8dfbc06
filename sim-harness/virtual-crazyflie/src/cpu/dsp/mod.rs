//! The arithmetic of the DSP and saturating instructions, as plain functions.
//!
//! A function that may set the Q flag returns `(value, saturated)`.

#[cfg(test)]
mod tests;

/// The treatment of each lane of a parallel addition or subtraction: the instruction's prefix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Prefix {
    /// S: wraps, and sets GE where the sum is not negative.
    Signed,
    /// Q: saturates.
    Saturating,
    /// SH: half of it.
    SignedHalving,
    /// U: wraps, and sets GE by the carry.
    Unsigned,
    /// UQ: saturates.
    UnsignedSaturating,
    /// UH: half of it.
    UnsignedHalving,
}

/// Which lanes are added to which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Lanes {
    /// Bytes, added.
    Add8,
    /// Halfwords, added.
    Add16,
    /// Halves of the second operand exchanged; the low ones subtracted, the high ones added.
    Asx,
    /// Halves of the second operand exchanged; the low ones added, the high ones subtracted.
    Sax,
    /// Bytes, subtracted.
    Sub8,
    /// Halfwords, subtracted.
    Sub16,
}

/// One lane of a parallel instruction: the bits of the result, and whether GE is set. `bits` is 8
/// or 16.
#[inline]
fn lane(prefix: Prefix, bits: u32, n: u32, m: u32, subtract: bool) -> (u32, bool) {
    let mask = (1 << bits) - 1;
    let extend = |x: u32| match prefix {
        Prefix::Signed | Prefix::Saturating | Prefix::SignedHalving => sign_extend(x, bits),
        _ => (x & mask) as i32,
    };
    let exact = if subtract { extend(n) - extend(m) } else { extend(n) + extend(m) };
    let ge = match prefix {
        Prefix::Unsigned if !subtract => exact > mask as i32,
        _ => exact >= 0,
    };
    let value = match prefix {
        Prefix::Signed | Prefix::Unsigned => exact,
        Prefix::SignedHalving | Prefix::UnsignedHalving => exact >> 1,
        Prefix::Saturating => exact.clamp(-(1 << (bits - 1)), (1 << (bits - 1)) - 1),
        Prefix::UnsignedSaturating => exact.clamp(0, mask as i32),
    };
    (value as u32 & mask, ge)
}

#[inline]
const fn sign_extend(value: u32, bits: u32) -> i32 {
    (value << (32 - bits)) as i32 >> (32 - bits)
}

/// SADD8 and its 35 relatives: the result, and the four GE bits, which only [`Prefix::Signed`] and
/// [`Prefix::Unsigned`] write to APSR.
#[inline]
#[must_use]
pub fn parallel(prefix: Prefix, lanes: Lanes, n: u32, m: u32) -> (u32, u8) {
    let halves = |m: u32, low_subtracts: bool, high_subtracts: bool| {
        let (low, low_ge) = lane(prefix, 16, n, m, low_subtracts);
        let (high, high_ge) = lane(prefix, 16, n >> 16, m >> 16, high_subtracts);
        (high << 16 | low, if low_ge { 0b0011 } else { 0 } | if high_ge { 0b1100 } else { 0 })
    };
    let bytes = |subtract: bool| {
        (0..4).fold((0, 0), |(value, ges), byte| {
            let (part, ge) = lane(prefix, 8, n >> (8 * byte), m >> (8 * byte), subtract);
            (value | part << (8 * byte), ges | u8::from(ge) << byte)
        })
    };
    match lanes {
        Lanes::Add8 => bytes(false),
        Lanes::Sub8 => bytes(true),
        Lanes::Add16 => halves(m, false, false),
        Lanes::Sub16 => halves(m, true, true),
        Lanes::Asx => halves(m.rotate_left(16), true, false),
        Lanes::Sax => halves(m.rotate_left(16), false, true),
    }
}

impl Prefix {
    /// Whether instructions with this prefix write the GE bits.
    #[inline]
    #[must_use]
    pub const fn sets_ge(self) -> bool {
        matches!(self, Self::Signed | Self::Unsigned)
    }
}

/// SEL: bytes of `n` where GE is set, of `m` where it is not.
#[inline]
#[must_use]
pub const fn sel(n: u32, m: u32, ge: u8) -> u32 {
    let mut mask = 0;
    let mut byte = 0;
    while byte < 4 {
        if ge >> byte & 1 != 0 {
            mask |= 0xFF << (8 * byte);
        }
        byte += 1;
    }
    n & mask | m & !mask
}

/// USAD8 (`a` zero) and USADA8: the sum of the differences' magnitudes.
#[inline]
#[must_use]
pub fn usada8(n: u32, m: u32, a: u32) -> u32 {
    let (n, m) = (n.to_le_bytes(), m.to_le_bytes());
    (0..4).fold(a, |sum, byte| sum.wrapping_add(u32::from(n[byte].abs_diff(m[byte]))))
}

#[inline]
const fn saturate(value: i64, bits: u32) -> (i32, bool) {
    let limit = 1i64 << (bits - 1);
    if value >= limit {
        ((limit - 1) as i32, true)
    } else if value < -limit {
        (-limit as i32, true)
    } else {
        (value as i32, false)
    }
}

/// SSAT of a value that is already shifted, to so many bits (1 to 32).
#[inline]
#[must_use]
pub const fn ssat(value: u32, bits: u32) -> (u32, bool) {
    let (value, q) = saturate(value as i32 as i64, bits);
    (value as u32, q)
}

/// USAT of a value that is already shifted, to so many bits (0 to 31).
#[inline]
#[must_use]
pub const fn usat(value: u32, bits: u32) -> (u32, bool) {
    let limit = (1u32 << bits) - 1;
    if (value as i32) < 0 {
        (0, true)
    } else if value > limit {
        (limit, true)
    } else {
        (value, false)
    }
}

/// SSAT16: both halves, to so many bits (1 to 16).
#[inline]
#[must_use]
pub const fn ssat16(n: u32, bits: u32) -> (u32, bool) {
    let (low, low_q) = saturate(low(n) as i64, bits);
    let (high, high_q) = saturate(high(n) as i64, bits);
    ((high as u32) << 16 | low as u32 & 0xFFFF, low_q || high_q)
}

/// USAT16: both halves, to so many bits (0 to 15).
#[inline]
#[must_use]
pub const fn usat16(n: u32, bits: u32) -> (u32, bool) {
    let (low, low_q) = usat(low(n) as u32, bits);
    let (high, high_q) = usat(high(n) as u32, bits);
    (high << 16 | low, low_q || high_q)
}

/// QADD: `m + n`.
#[inline]
#[must_use]
pub const fn qadd(m: u32, n: u32) -> (u32, bool) {
    let (value, q) = saturate(m as i32 as i64 + n as i32 as i64, 32);
    (value as u32, q)
}

/// QSUB: `m - n`.
#[inline]
#[must_use]
pub const fn qsub(m: u32, n: u32) -> (u32, bool) {
    let (value, q) = saturate(m as i32 as i64 - n as i32 as i64, 32);
    (value as u32, q)
}

/// QDADD: `m + 2 n`, each step saturating.
#[inline]
#[must_use]
pub const fn qdadd(m: u32, n: u32) -> (u32, bool) {
    let (double, doubling) = qadd(n, n);
    let (value, adding) = qadd(m, double);
    (value, doubling || adding)
}

/// QDSUB: `m - 2 n`, each step saturating.
#[inline]
#[must_use]
pub const fn qdsub(m: u32, n: u32) -> (u32, bool) {
    let (double, doubling) = qadd(n, n);
    let (value, subtracting) = qsub(m, double);
    (value, doubling || subtracting)
}

#[inline]
const fn low(value: u32) -> i32 {
    value as i16 as i32
}

#[inline]
const fn high(value: u32) -> i32 {
    value as i32 >> 16
}

#[inline]
const fn half(value: u32, top: bool) -> i32 {
    if top { high(value) } else { low(value) }
}

/// A sum that wraps, and whether it did: the Q flag of the multiplications that accumulate.
#[inline]
const fn wrapped(exact: i64) -> (u32, bool) {
    (exact as u32, exact != exact as i32 as i64)
}

/// SMULxy: a half of each.
#[inline]
#[must_use]
pub const fn smulxy(n: u32, m: u32, n_top: bool, m_top: bool) -> u32 {
    (half(n, n_top) * half(m, m_top)) as u32
}

/// SMLAxy.
#[inline]
#[must_use]
pub const fn smlaxy(n: u32, m: u32, a: u32, n_top: bool, m_top: bool) -> (u32, bool) {
    wrapped(half(n, n_top) as i64 * half(m, m_top) as i64 + a as i32 as i64)
}

/// SMULWy: the upper 32 of the product's 48 bits.
#[inline]
#[must_use]
pub const fn smulwy(n: u32, m: u32, m_top: bool) -> u32 {
    ((n as i32 as i64 * half(m, m_top) as i64) >> 16) as u32
}

/// SMLAWy.
#[inline]
#[must_use]
pub const fn smlawy(n: u32, m: u32, a: u32, m_top: bool) -> (u32, bool) {
    wrapped(((n as i32 as i64 * half(m, m_top) as i64) >> 16) + a as i32 as i64)
}

/// SMLALxy, on RdHi:RdLo.
#[inline]
#[must_use]
pub const fn smlalxy(n: u32, m: u32, a: u64, n_top: bool, m_top: bool) -> u64 {
    a.wrapping_add_signed(half(n, n_top) as i64 * half(m, m_top) as i64)
}

/// Both products of halves, the second added or subtracted; with `swap` (X) `m`'s are exchanged.
#[inline]
const fn dual(n: u32, m: u32, swap: bool, subtract: bool) -> i64 {
    let m = if swap { m.rotate_left(16) } else { m };
    let first = low(n) as i64 * low(m) as i64;
    let second = high(n) as i64 * high(m) as i64;
    if subtract { first - second } else { first + second }
}

/// SMUAD (`a` zero), SMLAD, and with X.
#[inline]
#[must_use]
pub const fn smlad(n: u32, m: u32, a: u32, swap: bool) -> (u32, bool) {
    wrapped(dual(n, m, swap, false) + a as i32 as i64)
}

/// SMUSD (`a` zero), SMLSD, and with X.
#[inline]
#[must_use]
pub const fn smlsd(n: u32, m: u32, a: u32, swap: bool) -> (u32, bool) {
    wrapped(dual(n, m, swap, true) + a as i32 as i64)
}

/// SMLALD, on RdHi:RdLo, and with X.
#[inline]
#[must_use]
pub const fn smlald(n: u32, m: u32, a: u64, swap: bool) -> u64 {
    a.wrapping_add_signed(dual(n, m, swap, false))
}

/// SMLSLD, on RdHi:RdLo, and with X.
#[inline]
#[must_use]
pub const fn smlsld(n: u32, m: u32, a: u64, swap: bool) -> u64 {
    a.wrapping_add_signed(dual(n, m, swap, true))
}

/// The upper word, with `round` (R) to nearest.
#[inline]
const fn most_significant(value: i64, round: bool) -> u32 {
    (value.wrapping_add(if round { 0x8000_0000 } else { 0 }) >> 32) as u32
}

/// SMMUL (`a` zero) and SMMLA, and with R.
#[inline]
#[must_use]
pub const fn smmla(n: u32, m: u32, a: u32, round: bool) -> u32 {
    let a = (a as i32 as i64) << 32;
    most_significant(a.wrapping_add(n as i32 as i64 * m as i32 as i64), round)
}

/// SMMLS, and with R.
#[inline]
#[must_use]
pub const fn smmls(n: u32, m: u32, a: u32, round: bool) -> u32 {
    let a = (a as i32 as i64) << 32;
    most_significant(a.wrapping_sub(n as i32 as i64 * m as i32 as i64), round)
}

/// UMAAL: `n * m + high + low`, 64 bits.
#[inline]
#[must_use]
pub const fn umaal(n: u32, m: u32, high: u32, low: u32) -> u64 {
    n as u64 * m as u64 + high as u64 + low as u64
}

/// PKHBT (`m` shifted left): the low half of `n`, the high half of `m`.
#[inline]
#[must_use]
pub const fn pkhbt(n: u32, m: u32) -> u32 {
    n & 0xFFFF | m & 0xFFFF_0000
}

/// PKHTB (`m` shifted right): the high half of `n`, the low half of `m`.
#[inline]
#[must_use]
pub const fn pkhtb(n: u32, m: u32) -> u32 {
    n & 0xFFFF_0000 | m & 0xFFFF
}

/// SXTB16 (`n` zero) and SXTAB16, of an `m` already rotated.
#[inline]
#[must_use]
pub const fn sxtab16(n: u32, m: u32) -> u32 {
    let low = n.wrapping_add(m as i8 as u32) & 0xFFFF;
    let high = (n >> 16).wrapping_add((m >> 16) as i8 as u32);
    high << 16 | low
}

/// UXTB16 (`n` zero) and UXTAB16, of an `m` already rotated.
#[inline]
#[must_use]
pub const fn uxtab16(n: u32, m: u32) -> u32 {
    let low = n.wrapping_add(m & 0xFF) & 0xFFFF;
    let high = (n >> 16).wrapping_add(m >> 16 & 0xFF);
    high << 16 | low
}
