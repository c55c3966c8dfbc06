//! Turns the forces on one drone into the direction in which it goes.

use units::{Metres, Point2};

use crate::Weight;

/// The weighted average of the forces on one drone (section 3.6 of the paper), as far as they are
/// added.
#[derive(Clone, Copy, Debug)]
pub struct Resultant {
    weight: Weight,
    x: f32,
    y: f32,
}

impl Resultant {
    /// Returns the average of no forces.
    #[must_use]
    pub const fn new(weight: Weight) -> Self {
        Self { weight, x: 0.0, y: 0.0 }
    }

    /// Adds the force of `magnitude` that acts on a drone at `here` towards `source`, which is
    /// `distance` away, or away from it when `magnitude` is negative. A source at the drone's own
    /// place has no direction, and adds nothing.
    pub fn add(&mut self, here: Point2, source: Point2, distance: Metres, magnitude: f32) {
        let (x, y) = (source.x - here.x, source.y - here.y);
        let distance = distance.0;
        if distance > 0.0 {
            let weight = match self.weight {
                Weight::Absolute => libm::expf(libm::fabsf(magnitude)),
                Weight::Signed => libm::expf(magnitude),
            };
            self.x += weight * magnitude * x / distance;
            self.y += weight * magnitude * y / distance;
        }
    }

    /// Returns the direction of the average as a vector of 1 m, or nothing when the forces are in
    /// balance. The sum of the weights cancels here, so it is never kept.
    #[must_use]
    pub fn direction(self) -> Option<Point2> {
        let length = libm::sqrtf(self.x * self.x + self.y * self.y);
        (length > 1e-9).then(|| Point2::new(self.x / length, self.y / length))
    }
}
