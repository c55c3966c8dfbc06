//! The measurements of the time-of-flight beams.

use units::Metres;

/// The measurement of one beam.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Range {
    /// There is an obstacle at this distance.
    At(Metres),
    /// There is no obstacle within the sensor's reach.
    Clear,
    /// There is no measurement: the sensor failed, or its range status marks it as invalid.
    #[default]
    Invalid,
}

impl Range {
    /// Checks a distance as a sensor or a simulator gives it: NaN and anything not positive is
    /// [`Invalid`](Self::Invalid), infinity and anything beyond `reach` is [`Clear`](Self::Clear).
    #[must_use]
    pub fn measured(distance: Metres, reach: Metres) -> Self {
        if distance.0.is_nan() || distance.0 <= 0.0 {
            Self::Invalid
        } else if distance.0 > reach.0 {
            Self::Clear
        } else {
            Self::At(distance)
        }
    }
}

impl Range {
    /// The distance to the obstacle, in metres; `None` without an obstacle, or for a number that is
    /// no distance.
    pub(crate) fn length(self) -> Option<f32> {
        match self {
            Self::At(distance) if distance.0 > 0.0 && distance.0.is_finite() => Some(distance.0),
            Self::At(_) | Self::Clear | Self::Invalid => None,
        }
    }
}

/// The four beams, named by their directions with the nose to the north.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Diagonals {
    /// Front left.
    pub nw: Range,
    /// Front right.
    pub ne: Range,
    /// Rear left.
    pub sw: Range,
    /// Rear right.
    pub se: Range,
}

impl Diagonals {
    /// The same surroundings as a drone that flies tail first sees them: front and rear swapped.
    #[must_use]
    pub(crate) const fn seen_backwards(&self) -> Self {
        Self { nw: self.sw, ne: self.se, sw: self.nw, se: self.ne }
    }
}
