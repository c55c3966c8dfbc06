//! Learns by how much a turning drone flies beside the direction that it is told.

use units::{Point2, Radians};

/// The part of an error that is learnt in a round: it is learnt in some four seconds, and the noise of the
/// positions is averaged over as many. Ours.
const GAIN: f32 = 0.05;
/// The largest angle that is learnt: half a second of a swarm's turn.
const MOST: f32 = 0.4;
/// The shortest way in a round of which the direction is taken, m: a third of a whole step's.
const SHORTEST: f32 = 0.02;

/// The angle from where a drone is told to fly to where it flies, to the left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Drift {
    from: Option<Point2>,
    angle: f32,
}

impl Drift {
    pub(super) const fn new() -> Self {
        Self { from: None, angle: 0.0 }
    }

    /// Takes where a drone is that was told to fly to `goal` a round ago.
    pub(super) fn learn(&mut self, here: Point2, goal: Option<Point2>) {
        let from = self.from.replace(here);
        let (Some(from), Some(goal)) = (from, goal) else { return };
        let told = (goal.x - from.x, goal.y - from.y);
        let flown = (here.x - from.x, here.y - from.y);
        let aside = told.0 * flown.1 - told.1 * flown.0;
        let ahead = told.0 * flown.0 + told.1 * flown.1;
        // A drone that has just been told another direction still flies in the one of before.
        if from.distance(here).0 >= SHORTEST && aside.abs() < ahead {
            self.angle = (self.angle + GAIN * (aside / ahead)).clamp(-MOST, MOST);
        }
    }

    /// By how much more a drone must turn its direction to the right.
    pub(super) const fn angle(&self) -> Radians {
        Radians(self.angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Drones whose velocity loop had no lag flew up to 0.6 m beside their rows.
    #[test]
    fn a_drone_that_flies_to_one_side_learns_by_how_much() {
        for side in [-0.24_f32, 0.24] {
            let (mut drift, mut here) = (Drift::new(), Point2::new(0.0, 0.0));
            let mut goal = None;
            for _ in 0..200 {
                drift.learn(here, goal);
                let told = Point2::new(here.x + 0.1, here.y);
                let left = Radians(side - drift.angle().0);
                let (sin, cos) = left.sin_cos();
                here = Point2::new(here.x + 0.06 * cos, here.y + 0.06 * sin);
                goal = Some(told);
            }
            assert!((drift.angle().0 - side).abs() < 0.02, "{drift:?}");
        }
    }

    #[test]
    fn a_drone_that_turns_round_learns_nothing_of_it() {
        let mut drift = Drift::new();
        drift.learn(Point2::new(0.0, 0.0), None);
        drift.learn(Point2::new(-0.05, 0.05), Some(Point2::new(0.1, 0.0)));
        assert_eq!(drift.angle(), Radians(0.0));
    }
}
