//! Points and poses on a floor plan: x east, y north, yaw counter-clockwise seen from above.

use crate::{Metres, Radians};

/// A point of a floor plan, in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Point2 {
    /// Metres east of the origin.
    pub x: f32,
    /// Metres north of the origin.
    pub y: f32,
}

impl Point2 {
    /// The point `x` metres east and `y` metres north of the origin.
    #[must_use]
    pub const fn new(x: f32, y: f32) -> Self {
        Self { x, y }
    }

    /// The length of the straight line to `other`.
    #[must_use]
    pub fn distance(self, other: Self) -> Metres {
        let (dx, dy) = (other.x - self.x, other.y - self.y);
        Metres(libm::sqrtf(dx * dx + dy * dy))
    }

    /// Whether both coordinates are finite.
    #[must_use]
    pub const fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite()
    }
}

/// A point of a floor plan and the direction in which a drone's nose points there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pose2 {
    /// The point.
    pub at: Point2,
    /// The nose's direction, counter-clockwise from east.
    pub yaw: Radians,
}
