//! Numbers in the types that log variables and parameters have.

/// A number with its type.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Value {
    /// `uint8_t`
    U8(u8),
    /// `uint16_t`
    U16(u16),
    /// `uint32_t`
    U32(u32),
    /// `int8_t`
    I8(i8),
    /// `int16_t`
    I16(i16),
    /// `int32_t`
    I32(i32),
    /// `float`
    F32(f32),
}

/// A type in which a log variable can be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum LogType {
    /// `uint8_t`
    U8 = 1,
    /// `uint16_t`
    U16 = 2,
    /// `uint32_t`
    U32 = 3,
    /// `int8_t`
    I8 = 4,
    /// `int16_t`
    I16 = 5,
    /// `int32_t`
    I32 = 6,
    /// `float`
    F32 = 7,
    /// A half-precision `float` (IEEE 754 binary16).
    F16 = 8,
}

impl LogType {
    /// The type with this number (crazyflie-firmware, `log.h`).
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        match code {
            1 => Some(Self::U8),
            2 => Some(Self::U16),
            3 => Some(Self::U32),
            4 => Some(Self::I8),
            5 => Some(Self::I16),
            6 => Some(Self::I32),
            7 => Some(Self::F32),
            8 => Some(Self::F16),
            _ => None,
        }
    }

    /// The number of bytes of this type.
    #[must_use]
    pub const fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 | Self::F16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
        }
    }

    /// The name of the type, as clients know it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::U8 => "uint8_t",
            Self::U16 => "uint16_t",
            Self::U32 => "uint32_t",
            Self::I8 => "int8_t",
            Self::I16 => "int16_t",
            Self::I32 => "int32_t",
            Self::F32 => "float",
            Self::F16 => "FP16",
        }
    }
}

/// The type of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum ParamType {
    /// `uint8_t`
    U8 = 8,
    /// `uint16_t`
    U16 = 9,
    /// `uint32_t`
    U32 = 10,
    /// `int8_t`
    I8 = 0,
    /// `int16_t`
    I16 = 1,
    /// `int32_t`
    I32 = 2,
    /// `float`
    F32 = 6,
}

impl ParamType {
    /// The type with this number (crazyflie-firmware, `param.h`).
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        match code {
            8 => Some(Self::U8),
            9 => Some(Self::U16),
            10 => Some(Self::U32),
            0 => Some(Self::I8),
            1 => Some(Self::I16),
            2 => Some(Self::I32),
            6 => Some(Self::F32),
            _ => None,
        }
    }

    /// The name of the type, as clients know it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::U8 => "uint8_t",
            Self::U16 => "uint16_t",
            Self::U32 => "uint32_t",
            Self::I8 => "int8_t",
            Self::I16 => "int16_t",
            Self::I32 => "int32_t",
            Self::F32 => "float",
        }
    }

    /// The number of this type at the beginning of `bytes`. Bytes after it are ignored, as the
    /// vendor's firmware ignores them.
    #[must_use]
    pub fn read(self, bytes: &[u8]) -> Option<Value> {
        let two = || bytes.first_chunk::<2>().copied();
        let four = || bytes.first_chunk::<4>().copied();
        Some(match self {
            Self::U8 => Value::U8(*bytes.first()?),
            Self::U16 => Value::U16(u16::from_le_bytes(two()?)),
            Self::U32 => Value::U32(u32::from_le_bytes(four()?)),
            Self::I8 => Value::I8(i8::from_le_bytes(*bytes.first_chunk::<1>()?)),
            Self::I16 => Value::I16(i16::from_le_bytes(two()?)),
            Self::I32 => Value::I32(i32::from_le_bytes(four()?)),
            Self::F32 => Value::F32(f32::from_le_bytes(four()?)),
        })
    }
}

/// The bytes of a number: four, and the number of them that count.
pub(super) struct Bytes([u8; 4], usize);

impl Bytes {
    pub(super) fn as_slice(&self) -> &[u8] {
        self.0.get(..self.1).unwrap_or_default()
    }
}

impl Value {
    pub(super) fn bytes(self) -> Bytes {
        let one = |byte| Bytes([byte, 0, 0, 0], 1);
        let two = |[a, b]: [u8; 2]| Bytes([a, b, 0, 0], 2);
        match self {
            Self::U8(n) => one(n),
            Self::I8(n) => one(n.cast_unsigned()),
            Self::U16(n) => two(n.to_le_bytes()),
            Self::I16(n) => two(n.to_le_bytes()),
            Self::U32(n) => Bytes(n.to_le_bytes(), 4),
            Self::I32(n) => Bytes(n.to_le_bytes(), 4),
            Self::F32(x) => Bytes(x.to_le_bytes(), 4),
        }
    }

    /// The number as a `float`.
    const fn as_float(self) -> f32 {
        match self {
            Self::U8(n) => n as f32,
            Self::U16(n) => n as f32,
            Self::U32(n) => n as f32,
            Self::I8(n) => n as f32,
            Self::I16(n) => n as f32,
            Self::I32(n) => n as f32,
            Self::F32(x) => x,
        }
    }

    /// The number as a whole number from `least` to `most`. A fraction is cut off; NaN becomes
    /// zero.
    fn as_whole(self, least: i64, most: i64) -> i64 {
        let n = match self {
            Self::U8(n) => i64::from(n),
            Self::U16(n) => i64::from(n),
            Self::U32(n) => i64::from(n),
            Self::I8(n) => i64::from(n),
            Self::I16(n) => i64::from(n),
            Self::I32(n) => i64::from(n),
            // A `float` becomes a 64-bit integer through a slow routine on the Cortex-M4.
            Self::F32(x) if x < 0.0 => i64::from(x as i32),
            Self::F32(x) => i64::from(x as u32),
        };
        n.clamp(least, most)
    }

    /// The bytes of the number in the type `kind`. A number beyond the range of that type becomes
    /// the largest or smallest of it.
    pub(super) fn log_bytes(self, kind: LogType) -> Bytes {
        let whole = |least: i64, most: i64| {
            let [a, b, c, d, ..] = self.as_whole(least, most).to_le_bytes();
            Bytes([a, b, c, d], kind.size())
        };
        match kind {
            LogType::U8 => whole(0, u8::MAX.into()),
            LogType::U16 => whole(0, u16::MAX.into()),
            LogType::U32 => whole(0, u32::MAX.into()),
            LogType::I8 => whole(i8::MIN.into(), i8::MAX.into()),
            LogType::I16 => whole(i16::MIN.into(), i16::MAX.into()),
            LogType::I32 => whole(i32::MIN.into(), i32::MAX.into()),
            LogType::F32 => Bytes(self.as_float().to_le_bytes(), 4),
            LogType::F16 => {
                let [a, b] = half(self.as_float()).to_le_bytes();
                Bytes([a, b, 0, 0], 2)
            }
        }
    }
}

/// The nearest half-precision number (IEEE 754 binary16), ties to even; a number that is too large
/// becomes infinite.
fn half(x: f32) -> u16 {
    let bits = x.to_bits();
    let sign = (bits >> 16) & 0x8000;
    let magnitude = bits & 0x7FFF_FFFF;
    let half = if magnitude > 0x7F80_0000 {
        0x7E00
    } else if magnitude >= 0x4780_0000 {
        // 65,536 and more.
        0x7C00
    } else if magnitude >= 0x3880_0000 {
        // 2⁻¹⁴ and more: normal. A carry out of the fraction goes into the exponent, as it should.
        round(magnitude - 0x3800_0000, 13)
    } else {
        // The fraction with its leading one, in units of 2⁻²⁴.
        let exponent = magnitude >> 23;
        let shift = 126_u32.saturating_sub(exponent);
        if shift > 24 { 0 } else { round((magnitude & 0x007F_FFFF) | 0x0080_0000, shift) }
    };
    (sign | half) as u16
}

/// `n / 2^places`, rounded to the nearest, ties to even; `places` is 1 to 24.
const fn round(n: u32, places: u32) -> u32 {
    let below_half = (1 << (places - 1)) - 1;
    (n + below_half + ((n >> places) & 1)) >> places
}
