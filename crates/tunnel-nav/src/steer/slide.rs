//! Turns a drone that slides along a gallery at an angle, on its way home.
//!
//! A drone whose nose is 45° off a gallery sees each wall with one beam, and along the gallery with the
//! other two. No side has a wall for it then, and nothing turns it: it is pushed off the wall ahead and
//! slides along it at a third of its speed. But how it has moved, by optic flow, tells how the gallery
//! leads.

use units::{Metres, MetresPerSecond};

use super::{BLOCKED, HOVERING, Navigator, OneWay, ROUND, Walls};
use crate::plane::distance;

/// The part of a new velocity in the mean: the mean of 2 s.
const WEIGHT: f32 = 0.1;
/// A drone that is slower in the mean has no direction, m/s.
const SLOW: f32 = 0.04;
/// It slides where it moves at more than this angle to the end that leads, rad. These four are our own
/// numbers; of drawn places only whether the drone turns at all was tried.
const AT: f32 = 0.35;
/// The gain of the turn, 1/s.
const GAIN: f32 = 0.5;

/// The mean velocity of a drone, forward and to the left, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Slide([f32; 2]);

impl Slide {
    /// A drone that has not moved.
    pub(super) const fn new() -> Self {
        Self([0.0; 2])
    }

    /// Takes in how a drone that is to fly at `speed` has moved, and returns the yaw rate that turns its
    /// leading end to where it slides.
    pub(super) fn step(&mut self, moved: [Metres; 2], speed: MetresPerSecond) -> f32 {
        for (mean, moved) in self.0.iter_mut().zip(moved) {
            *mean += WEIGHT * (moved.0 / ROUND - *mean);
        }
        let [forward, left] = self.0;
        let moves = forward * speed.0 > 0.0 && distance(self.0, [0.0; 2]) > SLOW;
        let angle = libm::atan2f(left * forward.signum(), forward.abs());
        if speed.0.abs() > HOVERING && moves && angle.abs() > AT { GAIN * angle } else { 0.0 }
    }
}

impl Navigator {
    /// The yaw rate that turns a drone on its way home to where it slides along walls that it does not see
    /// at its sides.
    pub(super) fn slide_turn(
        &mut self,
        moved: [Metres; 2],
        speed: MetresPerSecond,
        leading: &OneWay,
    ) -> f32 {
        let turn = self.slide.step(moved, speed);
        let slides = leading.walls == Walls::Neither && leading.nearness > BLOCKED;
        if slides && self.fork.is_homing() { turn } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The yaw rate of a drone that has moved so, m/s, for 5 s.
    fn turn(velocity: [f32; 2], speed: f32) -> f32 {
        let mut slide = Slide::new();
        let moved = velocity.map(|velocity| Metres(ROUND * velocity));
        let rates = (0..25).map(|_| slide.step(moved, MetresPerSecond(speed)));
        rates.last().expect("there are 25")
    }

    #[test]
    fn the_leading_end_turns_to_where_the_drone_slides() {
        assert!(turn([0.06, 0.06], 0.2) > 0.3, "nose first, to the left");
        assert!(turn([0.06, -0.06], 0.2) < -0.3);
        // Tail first a slide to the right of the nose is one to the left of the tail.
        assert!(turn([-0.06, -0.06], -0.2) > 0.3);
        assert!(turn([-0.06, 0.06], -0.2) < -0.3);
    }

    #[test]
    fn a_drone_that_flies_straight_stands_or_flies_the_other_way_is_not_turned() {
        for (velocity, speed) in
            [([0.2, 0.05], 0.2), ([0.0, 0.02], 0.2), ([0.06, 0.06], 0.0), ([0.06, 0.06], -0.2)]
        {
            assert!(turn(velocity, speed).abs() < 1e-6, "{velocity:?} {speed}");
        }
    }
}
