//! The curve C of section III-A: positions along the tunnel.

use crate::trace::Point;

/// A polyline with its arc length.
#[derive(Clone, Debug)]
pub struct CentreLine {
    points: Vec<Point>,
    /// The abscissa of each point.
    abscissae: Vec<f32>,
}

/// How far along the line a moving point is looked for around where it was last: more than a
/// drone moves between two looks, less than the rock between two parallel galleries is thick.
const WINDOW_M: f32 = 1.5;

impl CentreLine {
    /// A line through `points`, which must be at least two, no two successive ones equal
    /// ([`layout::outlines`](super::layout::outlines) checks it).
    #[must_use]
    pub fn new(points: Vec<Point>) -> Self {
        let mut abscissae = Vec::with_capacity(points.len());
        let mut length = 0.0;
        let mut previous = None;
        for &point in &points {
            if let Some(before) = previous {
                length += distance(before, point);
            }
            abscissae.push(length);
            previous = Some(point);
        }
        Self { points, abscissae }
    }

    /// The whole length in metres.
    #[must_use]
    pub fn length(&self) -> f32 {
        self.abscissae.last().copied().unwrap_or(0.0)
    }

    /// The line's points.
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The point at this abscissa and the unit vector towards the far end; beyond either end, the
    /// end.
    #[must_use]
    pub fn at(&self, abscissa: f32) -> (Point, [f32; 2]) {
        let last = self.points.len().saturating_sub(2);
        let piece = self.abscissae.partition_point(|&a| a <= abscissa).saturating_sub(1).min(last);
        let (a, b) = (self.points[piece], self.points[piece + 1]);
        let length = self.abscissae[piece + 1] - self.abscissae[piece];
        let direction = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
        let along = (abscissa - self.abscissae[piece]).clamp(0.0, length);
        ([a[0] + along * direction[0], a[1] + along * direction[1]], direction)
    }

    /// The abscissa of the point of the line nearest to `point`, within 1.5 m of `near`.
    #[must_use]
    pub fn project(&self, point: Point, near: f32) -> f32 {
        let first = self.abscissae.partition_point(|&a| a < near - WINDOW_M).saturating_sub(1);
        let mut best = (f32::INFINITY, near);
        for piece in first..self.points.len() - 1 {
            if self.abscissae[piece] > near + WINDOW_M {
                break;
            }
            let (a, b) = (self.points[piece], self.points[piece + 1]);
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let (px, py) = (point[0] - a[0], point[1] - a[1]);
            let along = ((px * dx + py * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
            let (ex, ey) = (px - along * dx, py - along * dy);
            let off = ex * ex + ey * ey;
            if off < best.0 {
                let length = self.abscissae[piece + 1] - self.abscissae[piece];
                best = (off, self.abscissae[piece] + along * length);
            }
        }
        best.1
    }
}

/// The distance between two points of the floor plan.
pub(crate) fn distance(a: Point, b: Point) -> f32 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    (dx * dx + dy * dy).sqrt()
}
