//! What one time-of-flight beam can say.

use units::Metres;

/// One beam.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Range {
    /// Something at this distance.
    At(Metres),
    /// Nothing as far as the sensor sees.
    Clear,
    /// No measurement: the sensor failed, or its range status says not to believe it.
    #[default]
    Invalid,
}

impl Range {
    /// Checks a distance as a sensor or a simulator gives it: not a number or not positive is
    /// [`Invalid`](Self::Invalid), infinite or beyond `reach` is [`Clear`](Self::Clear).
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
    /// The distance to something, in metres; `None` where nothing is seen, or the number given is
    /// none that a distance can be.
    pub(crate) fn length(self) -> Option<f32> {
        match self {
            Self::At(distance) if distance.0 > 0.0 && distance.0.is_finite() => Some(distance.0),
            Self::At(_) | Self::Clear | Self::Invalid => None,
        }
    }
}

/// The four beams, named by where they look with the nose to the north.
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
    /// The same surroundings as a drone sees them that flies tail first: front and rear swapped.
    #[must_use]
    pub(crate) const fn seen_backwards(&self) -> Self {
        Self { nw: self.sw, ne: self.se, sw: self.nw, se: self.ne }
    }
}
