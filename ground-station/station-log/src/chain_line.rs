//! Holds the line along which the drones of a real chain are drawn: the operator knows how far each
//! has flown, and not where it is.

use units::{Point2, Pose2, Radians};
use world::{Polyline, ROW_SPACING_M};

use super::Plan;

/// The shortest straight line that is drawn, m.
const SHORTEST_M: f32 = 10.0;

/// The line that a chain flies along, and the base's place on it. At the start the drones stand in a
/// row before the base, the head the farthest from it, as in a simulated mission
/// that begins at the mouth.
#[derive(Clone, Debug)]
pub struct ChainLine {
    line: Polyline,
    base_m: f32,
}

impl ChainLine {
    /// The first centre-line of a plan; `None` for a plan that has none.
    #[must_use]
    pub fn of(plan: &Plan) -> Option<Self> {
        let mut points: Vec<Point2> =
            plan.lines.first()?.points.iter().map(|&[x, y]| Point2::new(x, y)).collect();
        points.dedup();
        (points.len() > 1 && points.iter().all(|point| point.is_finite()))
            .then(|| Self { line: Polyline::new(points), base_m: plan.base_m })
    }

    /// A straight line from the base to where the farthest of so many drones, or the longest row of
    /// them, ends.
    #[must_use]
    pub fn straight(drones: usize, farthest_m: f32) -> Self {
        let length = SHORTEST_M.max(row(0, drones) + farthest_m);
        let line = Polyline::new(vec![Point2::new(0.0, 0.0), Point2::new(length, 0.0)]);
        Self { line, base_m: 0.0 }
    }

    /// The points of the line.
    #[must_use]
    pub fn points(&self) -> &[Point2] {
        self.line.points()
    }

    /// How far from the base a drone is along the line, m, after this way since its take-off. Of
    /// `drones` drones it is the one of this rank, counted from the head.
    #[must_use]
    pub fn way(&self, rank: usize, drones: usize, odometer_m: f32) -> f32 {
        row(rank, drones) + odometer_m
    }

    /// The place so far from the base, with the direction of the line.
    #[must_use]
    pub fn at(&self, way_m: f32) -> Pose2 {
        let (at, [east, north]) = self.line.at(self.base_m + way_m);
        Pose2 { at, yaw: Radians(libm::atan2f(north, east)) }
    }

    /// The base's place.
    #[must_use]
    pub fn base(&self) -> Pose2 {
        self.at(0.0)
    }
}

/// How far from the base the drone of this rank stands in the row, m.
fn row(rank: usize, drones: usize) -> f32 {
    ROW_SPACING_M * drones.saturating_sub(rank) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PlanLine;

    #[test]
    fn the_head_stands_farthest_from_the_base_and_flies_on_from_there() {
        let line = ChainLine::straight(4, 30.0);
        assert!((line.at(line.way(0, 4, 20.0)).at.x - 21.4).abs() < 1e-4);
        assert!((line.at(line.way(3, 4, 0.0)).at.x - 0.35).abs() < 1e-4);
    }

    #[test]
    fn a_plan_whose_line_cannot_be_drawn_has_none() {
        let of = |points: Vec<[f32; 2]>| {
            let lines = vec![PlanLine { name: String::new(), points }];
            ChainLine::of(&Plan { lines, ..Plan::default() }).is_some()
        };
        assert!(!of(vec![]) && !of(vec![[1.0, 1.0], [1.0, 1.0]]) && !of(vec![[0.0, f32::NAN]; 3]));
        assert!(of(vec![[0.0, 0.0], [1.0, 0.0]]));
        assert!(ChainLine::of(&Plan::default()).is_none());
    }
}
