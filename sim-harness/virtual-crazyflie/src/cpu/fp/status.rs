//! FPSCR: the modes and the flags of the floating-point instructions.

/// The floating-point status and control register (DDI 0403, A2.5.3). Reserved bits are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fpscr(u32);

/// A cumulative exception flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Flag {
    /// IOC.
    InvalidOperation = 1 << 0,
    /// DZC.
    DivisionByZero = 1 << 1,
    /// OFC.
    Overflow = 1 << 2,
    /// UFC.
    Underflow = 1 << 3,
    /// IXC.
    Inexact = 1 << 4,
    /// IDC.
    InputDenormal = 1 << 7,
}

/// The rounding of a result between two numbers: FPSCR.RMode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// To the nearest, and of two equally near numbers to the even one: RN.
    Nearest,
    /// Towards plus infinity: RP.
    Up,
    /// Towards minus infinity: RM.
    Down,
    /// Towards zero: RZ.
    Zero,
}

const AHP: u32 = 1 << 26;
const DN: u32 = 1 << 25;
const FZ: u32 = 1 << 24;
const RMODE: u32 = 3 << 22;
const IXC: u32 = Flag::Inexact as u32;

impl Fpscr {
    /// Which bits there are.
    pub const MASK: u32 = 0xF7C0_009F;
    /// Those that a new floating-point context takes from FPDSCR: AHP, DN, FZ and RMode.
    pub const CONTROL: u32 = AHP | DN | FZ | RMODE;

    /// The status by the bits of the register; reserved bits are dropped.
    #[inline]
    #[must_use]
    pub const fn from_bits(bits: u32) -> Self {
        Self(bits & Self::MASK)
    }

    /// The bits of the register.
    #[inline]
    #[must_use]
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// N, Z, C and V, as bits 3 to 0.
    #[inline]
    #[must_use]
    pub const fn nzcv(self) -> u8 {
        (self.0 >> 28) as u8
    }

    /// Sets N, Z, C and V from bits 3 to 0.
    #[inline]
    pub const fn set_nzcv(&mut self, nzcv: u8) {
        self.0 = self.0 & 0x0FFF_FFFF | (nzcv as u32) << 28;
    }

    /// Half precision is the alternative format, without infinities and NaNs.
    #[inline]
    #[must_use]
    pub const fn ahp(self) -> bool {
        self.0 & AHP != 0
    }

    /// Every NaN that results is the default NaN.
    #[inline]
    #[must_use]
    pub const fn dn(self) -> bool {
        self.0 & DN != 0
    }

    /// Denormal numbers are taken for zero.
    #[inline]
    #[must_use]
    pub const fn fz(self) -> bool {
        self.0 & FZ != 0
    }

    /// RMode.
    #[inline]
    #[must_use]
    pub const fn rounding(self) -> Rounding {
        match (self.0 & RMODE) >> 22 {
            0 => Rounding::Nearest,
            1 => Rounding::Up,
            2 => Rounding::Down,
            _ => Rounding::Zero,
        }
    }

    /// A cumulative flag is set, and stays set.
    #[inline]
    pub const fn raise(&mut self, flag: Flag) {
        self.0 |= flag as u32;
    }

    /// Whether a cumulative flag is set.
    #[inline]
    #[must_use]
    pub const fn has(self, flag: Flag) -> bool {
        self.0 & flag as u32 != 0
    }

    /// To nearest, no flushing, NaNs as they come: what the host's arithmetic does too. And
    /// one more inexact result changes nothing.
    #[inline]
    pub(super) const fn plain_and_inexact(self) -> bool {
        self.0 & (DN | FZ | RMODE | IXC) == IXC
    }
}
