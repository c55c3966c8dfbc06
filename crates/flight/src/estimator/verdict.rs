//! What became of a sensor's reading.

use units::Metres;

/// What the estimator made of a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Verdict {
    /// It went into the estimate.
    Used(Nis),
    /// It says nothing: no question of how far off it is.
    Unusable(Unusable),
    /// Too far from what was expected to be true. The estimate did not change.
    Rejected(Nis),
    /// Readings kept contradicting the estimate and agreeing with each other, and were believed:
    /// the floor has a step here, or the drone was pushed.
    Reseated(Reseated),
}

impl Verdict {
    /// Whether the reading changed the estimate.
    #[must_use]
    pub const fn is_used(self) -> bool {
        matches!(self, Self::Used(_) | Self::Reseated(_))
    }
}

/// The normalised innovation squared: how far a reading was from what was expected, in variances.
/// Distributed as χ² with as many degrees of freedom while the estimator knows itself.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Nis {
    /// νᵀ·S⁻¹·ν.
    pub value: f32,
    /// How many numbers the reading had.
    pub degrees: u8,
}

/// Why a reading says nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Unusable {
    /// The sensor itself says so.
    Invalid,
    /// The flow sensor exposes as long as it can: it sees nothing.
    Dark,
    /// The flow sensor sees too little that it could follow.
    Featureless,
    /// More than the sensor can measure.
    OutOfRange,
    /// The flow sensor is too near to the floor to see it sharply.
    TooLow,
    /// The drone leans so far that the floor beneath it is not what is seen.
    Tilted,
    /// It covers too long a time, or it is the first one.
    Stale,
}

/// What a re-seating changed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reseated {
    /// The height over ground, by so much.
    Height(Metres),
    /// The velocity over ground.
    Velocity,
}
