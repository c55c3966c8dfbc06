//! The release of the radio chip's firmware, in the text by which the chip names it.

/// A release of the vendor's firmwares: they are named after year and month, as in `2022.01`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Release {
    /// The year.
    pub year: u16,
    /// The month, 1 to 12.
    pub month: u8,
}

impl Release {
    /// The release that a text begins with: `2025.02 (CF21)`, `2022.01.1`, and `2021.06-12-g1a2b3c4*`
    /// for a build of a later state. `None` for a text that begins otherwise, as that of a build
    /// outside of the vendor's repository does.
    #[must_use]
    pub const fn parse(text: &[u8]) -> Option<Self> {
        let [a @ b'0'..=b'9', b @ b'0'..=b'9', c @ b'0'..=b'9', d @ b'0'..=b'9', rest @ ..] = text
        else {
            return None;
        };
        let [b'.', e @ b'0'..=b'9', f @ b'0'..=b'9', rest @ ..] = rest else { return None };
        let year = 100 * number(*a, *b) as u16 + number(*c, *d) as u16;
        let month = number(*e, *f);
        match (month, rest) {
            (1..=12, [] | [b' ' | b'.' | b'-' | b'*', ..]) => Some(Self { year, month }),
            _ => None,
        }
    }
}

/// The number of two decimal digits.
const fn number(tens: u8, ones: u8) -> u8 {
    10 * (tens - b'0') + (ones - b'0')
}
