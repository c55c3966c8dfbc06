//! Holds the centre-line of a gallery: a line of straight pieces with its arc length.

use units::Point2;

/// A line through at least two points.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    points: Vec<Point2>,
    /// The arc length from the first point to each point, m.
    lengths: Vec<f32>,
}

/// A point of a line that is nearest to some other point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// The arc length from the line's first point, m.
    pub along: f32,
    /// The square of the distance to the other point, m².
    pub off_squared: f32,
}

impl Polyline {
    /// A line through `points`, of which no two successive ones are equal
    /// ([`layout::outlines`](super::layout::outlines) checks it).
    #[must_use]
    pub fn new(points: Vec<Point2>) -> Self {
        let mut lengths = Vec::with_capacity(points.len());
        let mut length = 0.0;
        let mut previous: Option<Point2> = None;
        for &point in &points {
            if let Some(before) = previous {
                length += before.distance(point).0;
            }
            lengths.push(length);
            previous = Some(point);
        }
        Self { points, lengths }
    }

    /// The whole length, m.
    #[must_use]
    pub fn length(&self) -> f32 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// The arc length from the first point to the point of this number, m.
    pub(super) fn length_at(&self, point: usize) -> f32 {
        self.lengths.get(point).copied().unwrap_or_else(|| self.length())
    }

    /// The line's points.
    #[must_use]
    pub fn points(&self) -> &[Point2] {
        &self.points
    }

    /// The point at this arc length and the unit vector towards the line's last point; beyond
    /// either end, the end.
    #[must_use]
    pub fn at(&self, along: f32) -> (Point2, [f32; 2]) {
        let last = self.points.len().saturating_sub(2);
        let piece = self.lengths.partition_point(|&a| a <= along).saturating_sub(1).min(last);
        let (a, b) = (self.points[piece], self.points[piece + 1]);
        let length = self.lengths[piece + 1] - self.lengths[piece];
        let direction = [(b.x - a.x) / length, (b.y - a.y) / length];
        let rest = (along - self.lengths[piece]).clamp(0.0, length);
        (Point2::new(a.x + rest * direction[0], a.y + rest * direction[1]), direction)
    }

    /// The point of the line nearest to `point`.
    #[must_use]
    pub fn nearest(&self, point: Point2) -> Foot {
        self.nearest_within(point, 0.0, f32::INFINITY)
    }

    /// The arc length of the point of the line nearest to `point`, of those from this length on and
    /// not much farther, m.
    #[must_use]
    pub fn nearest_from(&self, point: Point2, from: f32) -> f32 {
        /// Half of the stretch that is searched: more than the longest leg of most surveys.
        const WINDOW: f32 = 15.0;
        self.nearest_within(point, from + WINDOW, WINDOW).along.clamp(from, self.length())
    }

    fn nearest_within(&self, point: Point2, near: f32, window: f32) -> Foot {
        let first = self.lengths.partition_point(|&a| a < near - window).saturating_sub(1);
        let mut best = Foot { along: near, off_squared: f32::INFINITY };
        for piece in first..self.points.len() - 1 {
            if self.lengths[piece] > near + window {
                break;
            }
            let (a, b) = (self.points[piece], self.points[piece + 1]);
            let (dx, dy) = (b.x - a.x, b.y - a.y);
            let (px, py) = (point.x - a.x, point.y - a.y);
            let along = ((px * dx + py * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
            let (ex, ey) = (px - along * dx, py - along * dy);
            let off_squared = ex * ex + ey * ey;
            if off_squared < best.off_squared {
                let length = self.lengths[piece + 1] - self.lengths[piece];
                best = Foot { along: self.lengths[piece] + along * length, off_squared };
            }
        }
        best
    }

    /// The crossings of this line and `other`: the arc lengths on both.
    pub(super) fn crossings(&self, other: &Self) -> Vec<(f32, f32)> {
        let mut found = Vec::new();
        for (n, mine) in self.points.windows(2).enumerate() {
            for (m, theirs) in other.points.windows(2).enumerate() {
                if let Some((s, t)) = crossing([mine[0], mine[1]], [theirs[0], theirs[1]]) {
                    let mine = self.lengths[n] + s * (self.lengths[n + 1] - self.lengths[n]);
                    let theirs = other.lengths[m] + t * (other.lengths[m + 1] - other.lengths[m]);
                    found.push((mine, theirs));
                }
            }
        }
        found
    }

    /// The line with `point` before its first point.
    pub(super) fn prepended(&self, point: Point2) -> Self {
        Self::new([point].into_iter().chain(self.points.iter().copied()).collect())
    }

    /// The line with `point` after its last point.
    pub(super) fn appended(&self, point: Point2) -> Self {
        Self::new(self.points.iter().copied().chain([point]).collect())
    }
}

/// The fractions of two segments at which they cross; `None` for segments that do not, or that
/// are parallel.
fn crossing([a, b]: [Point2; 2], [c, d]: [Point2; 2]) -> Option<(f32, f32)> {
    let (rx, ry) = (b.x - a.x, b.y - a.y);
    let (sx, sy) = (d.x - c.x, d.y - c.y);
    let cross = rx * sy - ry * sx;
    if cross.abs() < 1e-9 {
        return None;
    }
    let (qx, qy) = (c.x - a.x, c.y - a.y);
    let (t, u) = ((qx * sy - qy * sx) / cross, (qx * ry - qy * rx) / cross);
    let within = |f: f32| (0.0..=1.0).contains(&f);
    (within(t) && within(u)).then_some((t, u))
}
