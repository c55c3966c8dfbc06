//! The estimator's verdict on a sensor reading.

use units::Metres;

/// The estimator's verdict on a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Verdict {
    /// The reading corrected the estimate.
    Used(Nis),
    /// The reading carries no information, so it was not compared with the estimate.
    Unusable(Unusable),
    /// The innovation was too large. The estimate did not change.
    Rejected(Nis),
    /// The estimate was reset to the reading, because rejected readings kept agreeing with each
    /// other: the floor has a step, or the drone was pushed.
    Reseated(Reseated),
}

impl Verdict {
    /// Whether the reading changed the estimate.
    #[must_use]
    pub const fn is_used(self) -> bool {
        matches!(self, Self::Used(_) | Self::Reseated(_))
    }
}

/// The normalised innovation squared. While the filter is consistent it follows a χ² distribution
/// of `degrees` degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Nis {
    /// The value νᵀ·S⁻¹·ν for the innovation ν and its covariance S.
    pub value: f32,
    /// Number of components of the reading.
    pub degrees: u8,
}

/// The reason why a reading cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Unusable {
    /// The sensor marked the reading as invalid.
    Invalid,
    /// The flow sensor is at its longest exposure: it is dark.
    Dark,
    /// The flow sensor sees too little texture to follow.
    Featureless,
    /// The value is outside the sensor's range.
    OutOfRange,
    /// The flow sensor is too near to the floor to be in focus.
    TooLow,
    /// The drone is tilted so far that the sensor does not see the floor directly below.
    Tilted,
    /// The flow sensor insists, or has insisted since the drone last stood on the ground, on a
    /// velocity that the drone cannot have.
    Implausible,
    /// The reading covers too long a time, or none.
    Stale,
}

/// The part of the state that was reset.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reseated {
    /// The height over ground changed by this much.
    Height(Metres),
    /// The velocity over ground was reset.
    Velocity,
}
