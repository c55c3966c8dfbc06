//! The reasons for which bytes are no record.

use core::fmt;

/// Why bytes are no record, or a value cannot become one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error {
    /// There are fewer bytes than a record of its version has.
    Short,
    /// The memory was never written: every bit is set.
    Blank,
    /// The bytes do not begin with the record's magic number.
    Magic,
    /// The record has a version that this code does not know.
    Version(u8),
    /// The checksum is wrong: the record was not written to its end, or was damaged later.
    Checksum,
    /// A value is out of its range.
    Value,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Short => f.write_str("too few bytes for a record"),
            Self::Blank => f.write_str("memory that was never written"),
            Self::Magic => f.write_str("no record"),
            Self::Version(version) => write!(f, "a record of the unknown version {version}"),
            Self::Checksum => f.write_str("a record whose checksum is wrong"),
            Self::Value => f.write_str("a record with a value out of its range"),
        }
    }
}

impl core::error::Error for Error {}
