//! Holds the ranges of the four time-of-flight beams, and fills in missing ones.

use units::Metres;

use crate::Side;

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
    /// The beam to the front left.
    pub nw: Range,
    /// The beam to the front right.
    pub ne: Range,
    /// The beam to the rear left.
    pub sw: Range,
    /// The beam to the rear right.
    pub se: Range,
}

impl Diagonals {
    /// The front beam and the rear beam of a side.
    pub(crate) const fn beams(&self, side: Side) -> (Range, Range) {
        match side {
            Side::Left => (self.nw, self.sw),
            Side::Right => (self.ne, self.se),
        }
    }

    /// No beam was measured.
    pub const UNKNOWN: Self =
        Self { nw: Range::Invalid, ne: Range::Invalid, sw: Range::Invalid, se: Range::Invalid };

    /// The same surroundings in a mirror.
    pub(crate) const fn mirrored(&self) -> Self {
        Self { nw: self.ne, ne: self.nw, sw: self.se, se: self.sw }
    }

    /// The same surroundings as a drone that flies tail first sees them: front and rear swapped.
    #[must_use]
    pub(crate) const fn seen_backwards(&self) -> Self {
        Self { nw: self.sw, ne: self.se, sw: self.nw, se: self.ne }
    }
}

/// The number of rounds for which the last range of a beam stands in for missing ones: at 0.3 m/s
/// the drone flies 0.2 m in them.
const BRIDGED: u8 = 3;

/// The latest range of each beam. Without it a single missing return ends a wall, and in a bend the
/// drone takes up the wrong one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Bridge {
    latest: Diagonals,
    /// For how many rounds each of them has stood in.
    age: [u8; 4],
}

impl Bridge {
    pub(crate) const fn new() -> Self {
        let none = Range::Invalid;
        Self { latest: Diagonals { nw: none, ne: none, sw: none, se: none }, age: [0; 4] }
    }

    /// The ranges of the last round.
    pub(crate) const fn latest(&self) -> &Diagonals {
        &self.latest
    }

    /// The ranges of this round, with those that are missing since a moment filled in.
    pub(crate) fn fill(&mut self, ranges: &Diagonals) -> Diagonals {
        let latest = &mut self.latest;
        let beams = [
            (&mut latest.nw, ranges.nw),
            (&mut latest.ne, ranges.ne),
            (&mut latest.sw, ranges.sw),
            (&mut latest.se, ranges.se),
        ];
        for ((kept, measured), age) in beams.into_iter().zip(&mut self.age) {
            if measured != Range::Invalid || *age >= BRIDGED {
                (*kept, *age) = (measured, 0);
            } else {
                *age += 1;
            }
        }
        *latest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_beam_stands_in_for_three_missing_ones() {
        let mut bridge = Bridge::new();
        let seen = Diagonals { nw: Range::At(Metres(0.7)), ..Diagonals::default() };
        assert_eq!(bridge.fill(&seen), seen);
        for _ in 0..3 {
            assert_eq!(bridge.fill(&Diagonals::default()), seen);
        }
        assert_eq!(bridge.fill(&Diagonals::default()), Diagonals::default());
    }
}
