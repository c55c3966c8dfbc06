//! Defines the rows and the checksums of the tables of log variables and of parameters.

use wire::crtp::{LogType, Value};

/// How a row's value is read from an `S`; its type is that of the number read.
pub(crate) enum Get<S> {
    U8(fn(&S) -> u8),
    U16(fn(&S) -> u16),
    U32(fn(&S) -> u32),
    I8(fn(&S) -> i8),
    I16(fn(&S) -> i16),
    F32(fn(&S) -> f32),
}

impl<S> Get<S> {
    /// Not inlined, so that the table of the stack knows the one place of the calls through a pointer.
    #[inline(never)]
    pub(crate) fn value(&self, from: &S) -> Value {
        match self {
            Self::U8(get) => Value::U8(get(from)),
            Self::U16(get) => Value::U16(get(from)),
            Self::U32(get) => Value::U32(get(from)),
            Self::I8(get) => Value::I8(get(from)),
            Self::I16(get) => Value::I16(get(from)),
            Self::F32(get) => Value::F32(get(from)),
        }
    }

    pub(crate) const fn kind(&self) -> LogType {
        match self {
            Self::U8(_) => LogType::U8,
            Self::U16(_) => LogType::U16,
            Self::U32(_) => LogType::U32,
            Self::I8(_) => LogType::I8,
            Self::I16(_) => LogType::I16,
            Self::F32(_) => LogType::F32,
        }
    }
}

/// A row of the book's table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Documented {
    /// The group, the first half of the name.
    pub group: &'static str,
    /// The second half of the name.
    pub name: &'static str,
    /// The type, as clients name it.
    pub kind: &'static str,
    /// The access: `ro` or `rw`.
    pub access: &'static str,
    /// The unit; empty where there is none.
    pub unit: &'static str,
    /// The meaning.
    pub meaning: &'static str,
}

/// Continues a CRC-32, as in Ethernet and zip, over one more row.
pub(crate) const fn crc_of_row(crc: u32, kind: u8, group: &str, name: &str) -> u32 {
    let crc = crc_of(crc, &[kind]);
    let crc = crc_of(crc_of(crc, group.as_bytes()), &[0]);
    crc_of(crc_of(crc, name.as_bytes()), &[0])
}

const fn crc_of(crc: u32, mut bytes: &[u8]) -> u32 {
    let mut crc = !crc;
    while let [byte, rest @ ..] = bytes {
        crc ^= *byte as u32;
        let mut bit = 0;
        while bit < 8 {
            crc = (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg());
            bit += 1;
        }
        bytes = rest;
    }
    !crc
}

#[cfg(test)]
mod tests {
    use super::crc_of;

    #[test]
    fn the_crc_is_that_of_the_check_string_in_one_piece_and_in_two() {
        assert_eq!(crc_of(0, b"123456789"), 0xCBF4_3926);
        assert_eq!(crc_of(crc_of(0, b"1234"), b"56789"), 0xCBF4_3926);
    }
}
