//! Grades a link by the base's own limits.

use units::Dbm;

use crate::session::Facts;

/// How good a link is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grade {
    /// The link is at least as strong as the launch limit.
    Good,
    /// The link is weaker than the launch limit.
    Weak,
    /// The link is weaker than the retreat limit.
    TooWeak,
}

impl Grade {
    /// The grade of a link of this strength in the base's chain.
    #[must_use]
    pub fn of(rssi: Dbm, base: Facts) -> Self {
        match rssi {
            rssi if rssi < base.retreat_limit => Self::TooWeak,
            rssi if rssi < base.launch_limit => Self::Weak,
            _ => Self::Good,
        }
    }

    /// The grade in words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Weak => "weak",
            Self::TooWeak => "too weak",
        }
    }
}
