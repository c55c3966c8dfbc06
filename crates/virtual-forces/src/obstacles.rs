//! Holds the obstacles that a drone sees, and answers what the forces ask of them.

use units::{Metres, Point2};

use crate::geometry::{along, left_of, moved, squared};

/// The most straight pieces of obstacles that a drone heeds at a time. Four walls and four corners
/// are within half a metre of a drone where a narrow passage bends.
const MOST: usize = 16;

/// The straight pieces of obstacles within a drone's range.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Obstacles {
    pieces: [Piece; MOST],
    count: usize,
}

/// A straight piece of an obstacle. A point is a piece whose ends are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Piece {
    from: Point2,
    to: Point2,
    /// The vector from one end to the other,
    vector: Point2,
    /// and the square of its length.
    squared_length: f32,
}

impl Piece {
    fn between((from, to): (Point2, Point2)) -> Self {
        let vector = Point2::new(to.x - from.x, to.y - from.y);
        Self { from, to, vector, squared_length: squared(from, to) }
    }

    /// Returns the point of the piece that is nearest to `point`.
    fn nearest(&self, point: Point2) -> Point2 {
        let along = along(self.vector, self.from, point);
        // Most pieces are short and nearest at an end: those need no division.
        let part = if along >= self.squared_length {
            1.0
        } else if along > 0.0 {
            along / self.squared_length
        } else {
            0.0
        };
        moved(self.from, self.vector, part)
    }

    /// Returns the part of the piece that is within `range` of `here`.
    fn clipped(self, here: Point2, range: f32) -> Option<Self> {
        if squared(self.nearest(here), here) > range * range {
            return None;
        }
        if self.squared_length == 0.0 {
            return Some(self);
        }
        let middle = along(self.vector, self.from, here) / self.squared_length;
        let foot = moved(self.from, self.vector, middle);
        let left = (range * range - squared(foot, here)).max(0.0);
        let half = libm::sqrtf(left / self.squared_length);
        let at = |part: f32| moved(self.from, self.vector, part.clamp(0.0, 1.0));
        Some(Self::between((at(middle - half), at(middle + half))))
    }
}

impl Obstacles {
    /// Returns the parts of `walls` that are within `range` of `here`. A point is a wall whose ends
    /// are the same. Pieces after the sixteenth are left out.
    #[must_use]
    pub fn seen(
        here: Point2,
        range: Metres,
        walls: impl IntoIterator<Item = (Point2, Point2)>,
    ) -> Self {
        let mut seen = Self::default();
        let pieces = walls.into_iter();
        let pieces = pieces.filter_map(|wall| Piece::between(wall).clipped(here, range.0));
        for (piece, slot) in pieces.zip(&mut seen.pieces) {
            *slot = piece;
            seen.count += 1;
        }
        seen
    }

    fn pieces(&self) -> impl Iterator<Item = &Piece> {
        self.pieces.iter().take(self.count)
    }

    /// Returns the distance from `point` to the nearest piece; infinite where none is seen.
    #[must_use]
    pub fn clearance(&self, point: Point2) -> Metres {
        Metres(libm::sqrtf(self.squared_clearance(point)))
    }

    /// Returns the square of the distance from `point` to the nearest piece.
    pub(crate) fn squared_clearance(&self, point: Point2) -> f32 {
        self.squared_clearance_from(point, 0.0).unwrap_or_default()
    }

    /// Returns the square of the distance from `point` to the nearest piece, unless that is less than
    /// `least`.
    pub(crate) fn squared_clearance_from(&self, point: Point2, least: f32) -> Option<f32> {
        self.pieces().try_fold(f32::INFINITY, |nearest, piece| {
            let distance = squared(point, piece.nearest(point));
            // `f32::min` would be a call on the chip, which has no instruction for it.
            let nearest = if distance < nearest { distance } else { nearest };
            (nearest >= least).then_some(nearest)
        })
    }

    /// Returns the nearest obstacle ahead of `here`, to its left, behind it and to its right, each
    /// in a quarter of the circle around a drone that goes along `way` (section 4.3 of the paper).
    #[must_use]
    pub fn nearest_by_quadrant(&self, here: Point2, way: Point2) -> [Option<Point2>; 4] {
        let mut nearest: [Option<Point2>; 4] = [None; 4];
        for point in self.pieces().map(|piece| piece.nearest(here)) {
            let (ahead, left) = (along(way, here, point), along(left_of(way), here, point));
            let [front, on_left, behind, on_right] = &mut nearest;
            let slot = if ahead.abs() >= left.abs() {
                if ahead >= 0.0 { front } else { behind }
            } else if left > 0.0 {
                on_left
            } else {
                on_right
            };
            if slot.is_none_or(|other| squared(here, point) < squared(here, other)) {
                *slot = Some(point);
            }
        }
        nearest
    }

    /// Says whether an obstacle lies on the straight line between two points.
    #[must_use]
    pub fn block(&self, from: Point2, to: Point2) -> bool {
        self.pieces().any(|piece| {
            let apart = side(from, to, piece.from) * side(from, to, piece.to) > 0.0;
            !apart && side(piece.from, piece.to, from) * side(piece.from, piece.to, to) <= 0.0
        })
    }
}

/// Returns twice the area of a triangle, positive where `point` is to the left of the line.
fn side(from: Point2, to: Point2, point: Point2) -> f32 {
    (to.x - from.x) * (point.y - from.y) - (to.y - from.y) * (point.x - from.x)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: Point2 = Point2::new(0.0, 0.0);
    const EAST: Point2 = Point2::new(1.0, 0.0);

    fn wall(from: (f32, f32), to: (f32, f32)) -> (Point2, Point2) {
        (Point2::new(from.0, from.1), Point2::new(to.0, to.1))
    }

    #[test]
    fn a_wall_is_seen_as_far_as_the_sensor_reaches() {
        let seen = Obstacles::seen(HERE, Metres(0.5), [wall((-9.0, 0.3), (9.0, 0.3))]);
        let Piece { from, to, .. } = seen.pieces().next().expect("the wall is in range");
        assert!((from.x + 0.4).abs() < 1e-4 && (to.x - 0.4).abs() < 1e-4, "{from:?} {to:?}");
        assert!(seen.block(HERE, Point2::new(0.0, 1.0)));
        assert!(!seen.block(HERE, Point2::new(1.0, 0.2)));
        let none = Obstacles::seen(HERE, Metres(0.5), [wall((-9.0, 0.6), (9.0, 0.6))]);
        assert_eq!(none.clearance(HERE), Metres(f32::INFINITY));
    }

    #[test]
    fn each_quarter_has_its_nearest_obstacle() {
        let walls = [
            wall((-9.0, 0.4), (9.0, 0.4)),
            wall((-9.0, 0.3), (0.0, 0.3)),
            wall((0.45, -0.1), (0.45, 0.1)),
        ];
        let nearest = Obstacles::seen(HERE, Metres(0.5), walls).nearest_by_quadrant(HERE, EAST);
        let [Some(ahead), Some(left), None, None] = nearest else { panic!("{nearest:?}") };
        assert!((ahead.x - 0.45).abs() < 1e-5 && ahead.y.abs() < 1e-5);
        assert!((left.y - 0.3).abs() < 1e-5);
    }
}
