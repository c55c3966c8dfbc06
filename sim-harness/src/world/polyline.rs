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
pub(super) struct Foot {
    /// The arc length from the line's first point, m.
    pub(super) along: f32,
    /// The square of the distance to the other point, m².
    pub(super) off_squared: f32,
}

impl Polyline {
    /// Half the length of the stretch of a line in which a moving point is looked for around its
    /// last place, m: more than a drone flies in one round, less than the rock between two
    /// parallel galleries is thick.
    pub(super) const WINDOW_M: f32 = 1.5;

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
    pub(super) fn nearest(&self, point: Point2) -> Foot {
        self.nearest_within(point, 0.0, f32::INFINITY)
    }

    /// The arc length of the point of the line nearest to `point`, of those from this length on and
    /// not much farther, m.
    pub(super) fn nearest_from(&self, point: Point2, from: f32) -> f32 {
        /// Half of the stretch that is searched: more than the longest leg of most surveys.
        const WINDOW: f32 = 15.0;
        self.nearest_within(point, from + WINDOW, WINDOW).along.clamp(from, self.length())
    }

    /// The foot of `point` on the line, within [`WINDOW_M`](Self::WINDOW_M) of `near`, for a gallery
    /// of this `width`.
    ///
    /// It is the nearest point of the line, but on the inside of a corner. There a point has a foot
    /// on either piece, and the nearer one changes across the corner's diagonal, by 0.6 m of length
    /// for a point that is 0.3 m from both. A link that jumped so would be no link of a gallery, so
    /// the length passes from one foot to the other over the inside of the corner.
    pub(super) fn follow(&self, point: Point2, near: f32, width: f32) -> Foot {
        let nearest = self.nearest_within(point, near, Self::WINDOW_M);
        let after = self.lengths.partition_point(|&a| a <= nearest.along);
        let corners = [after.saturating_sub(1), after];
        let inside = corners.into_iter().find_map(|corner| self.inside(corner, point, width));
        inside.map_or(nearest, |along| Foot { along, ..nearest })
    }

    /// The length that belongs to `point` on the inside of this corner; `None` elsewhere.
    ///
    /// Its feet are `a` before the corner and `b` behind it, and the length there is the mean of both
    /// with weights that make it that of one foot where the other comes to the corner, and where
    /// the other is as far from the corner as the gallery is wide.
    fn inside(&self, corner: usize, point: Point2, width: f32) -> Option<f32> {
        let piece = |n: usize| Some((*self.points.get(n)?, *self.points.get(n + 1)?));
        let length = |(a, b): (Point2, Point2)| a.distance(b).0;
        let (before, behind) = (piece(corner.checked_sub(1)?)?, piece(corner)?);
        let at = behind.0;
        let along = |(from, to): (Point2, Point2)| {
            let (x, y) = (to.x - from.x, to.y - from.y);
            ((point.x - at.x) * x + (point.y - at.y) * y) / length((from, to))
        };
        let (a, b) = (-along(before), along(behind));
        // Two corners do not share a part of the piece between them.
        let reach = width.min(0.5 * length(before)).min(0.5 * length(behind));
        Some(self.lengths.get(corner)? + corner_length(a, b, reach)?)
    }

    /// The direction from this arc length to the line's last point, for a `sign` of 1, or to its first
    /// one, for −1, and the length of the straight piece there; `None` at that end of the line.
    pub(super) fn piece_from(&self, along: f32, sign: f32) -> Option<([f32; 2], f32)> {
        /// A shorter piece is rounding, m.
        const LEAST: f32 = 0.01;
        let next = match sign > 0.0 {
            true => self.lengths.iter().find(|&&length| length > along + LEAST)?,
            false => self.lengths.iter().rev().find(|&&length| length < along - LEAST)?,
        };
        let (_, [x, y]) = self.at(0.5 * (along + next));
        Some(([sign * x, sign * y], (next - along).abs()))
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

/// The length, counted from a corner, that belongs to a point on the inside of it: the point has its
/// feet `a` before the corner and `b` behind it. `None` for a point that is not on the inside.
pub(super) fn corner_length(a: f32, b: f32, reach: f32) -> Option<f32> {
    if a <= 0.0 || b <= 0.0 || a >= reach || b >= reach {
        return None;
    }
    let (ahead, back) = (b * (reach - a), a * (reach - b));
    Some((b * ahead - a * back) / (ahead + back))
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
