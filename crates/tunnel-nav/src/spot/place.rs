//! The places that a drone passes while it looks for a spot.

use units::Metres;

use super::SpotConfig;

/// A stretch of the way beside the wall whose floor is even.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Stretch {
    /// The way at which it began.
    pub(super) from: Metres,
    /// The lowest and the highest reading of the height.
    pub(super) heights: [Metres; 2],
    /// Whether the free width is left.
    pub(super) is_wide: bool,
    /// By how much the weaker link was stronger than it has to be, dB, where it was weakest.
    pub(super) weaker: f32,
}

impl Stretch {
    /// Whether places of both stretches are of the same kind.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        self.is_wide == other.is_wide && (self.weaker >= 0.0) == (other.weaker >= 0.0)
    }

    /// The stretch with another reading; one that has just `begun` where the floor is not even.
    pub(super) fn and(self, config: &SpotConfig, begun: Self) -> Self {
        let ([low, high], [height, _]) = (self.heights, begun.heights);
        let heights = [Metres(low.0.min(height.0)), Metres(high.0.max(height.0))];
        let [low, high] = heights;
        let weaker = self.weaker.min(begun.weaker);
        let is_even = high - low < config.unevenness;
        if is_even { Self { heights, weaker, ..self } } else { begun }
    }
}

/// The kind of a place at which to land where there is no better one, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum Kind {
    /// It is not beside a wall.
    Open,
    /// It is beside a wall.
    Beside,
    /// The floor is even as well.
    Even,
    /// The free width is left as well.
    Spot,
}

/// A place at which to land where there is no better one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Spare {
    pub(super) way: Metres,
    pub(super) kind: Kind,
    /// By how much the weaker link was stronger there than it has to be, dB.
    pub(super) weaker: f32,
}

impl Spare {
    /// Whether this place is to be taken rather than another: a place with links before one without,
    /// then by its kind. Of two without links it is the one whose weaker link is stronger.
    pub(super) fn is_better_than(&self, other: &Self) -> bool {
        let rank = |spare: &Self| (spare.weaker >= 0.0, spare.kind);
        let is_beside = |spare: &Self| spare.kind != Kind::Open;
        match (self.weaker >= 0.0, other.weaker >= 0.0) {
            (false, false) if is_beside(self) == is_beside(other) => self.weaker > other.weaker,
            _ => rank(self) > rank(other),
        }
    }
}
