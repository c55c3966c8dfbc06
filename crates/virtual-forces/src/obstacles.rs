//! Holds the obstacles that a drone sees, and answers what the forces ask of them.

use units::{Metres, Point2};

use crate::geometry::{along, left_of, moved, squared};

/// The most straight pieces of obstacles that a drone heeds at a time. Four walls and four corners
/// are within half a metre of a drone where a narrow passage bends.
const MOST: usize = 16;

/// The straight pieces of obstacles within a drone's range.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Obstacles {
    pieces: [(Point2, Point2); MOST],
    count: usize,
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
        let pieces = walls.into_iter().filter_map(|wall| clipped(here, range.0, wall));
        for (piece, slot) in pieces.zip(&mut seen.pieces) {
            *slot = piece;
            seen.count += 1;
        }
        seen
    }

    fn pieces(&self) -> impl Iterator<Item = (Point2, Point2)> {
        self.pieces.iter().copied().take(self.count)
    }

    /// Returns the distance from `point` to the nearest piece; infinite where none is seen.
    #[must_use]
    pub fn clearance(&self, point: Point2) -> Metres {
        let nearest = |wall| squared(point, nearest_of(wall, point));
        Metres(libm::sqrtf(self.pieces().map(nearest).fold(f32::INFINITY, f32::min)))
    }

    /// Returns the nearest obstacle ahead of `here`, to its left, behind it and to its right, each
    /// in a quarter of the circle around a drone that goes along `way` (section 4.3 of the paper).
    #[must_use]
    pub fn nearest_by_quadrant(&self, here: Point2, way: Point2) -> [Option<Point2>; 4] {
        let mut nearest: [Option<Point2>; 4] = [None; 4];
        for point in self.pieces().map(|wall| nearest_of(wall, here)) {
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
        self.pieces().any(|(a, b)| {
            side(from, to, a) * side(from, to, b) <= 0.0 && side(a, b, from) * side(a, b, to) <= 0.0
        })
    }
}

/// Returns twice the area of a triangle, positive where `point` is to the left of the line.
fn side(from: Point2, to: Point2, point: Point2) -> f32 {
    (to.x - from.x) * (point.y - from.y) - (to.y - from.y) * (point.x - from.x)
}

/// Returns the point of a wall that is nearest to `point`.
fn nearest_of((a, b): (Point2, Point2), point: Point2) -> Point2 {
    let wall = Point2::new(b.x - a.x, b.y - a.y);
    let length = squared(a, b);
    let part = if length > 0.0 { along(wall, a, point) / length } else { 0.0 };
    moved(a, wall, part.clamp(0.0, 1.0))
}

/// Returns the part of a wall that is within `range` of `here`.
fn clipped(here: Point2, range: f32, (a, b): (Point2, Point2)) -> Option<(Point2, Point2)> {
    let nearest = nearest_of((a, b), here);
    if squared(nearest, here) > range * range {
        return None;
    }
    let wall = Point2::new(b.x - a.x, b.y - a.y);
    let length = squared(a, b);
    if length == 0.0 {
        return Some((a, b));
    }
    let middle = along(wall, a, here) / length;
    let foot = moved(a, wall, middle);
    let half = libm::sqrtf((range * range - squared(foot, here)).max(0.0) / length);
    let at = |part: f32| moved(a, wall, part.clamp(0.0, 1.0));
    Some((at(middle - half), at(middle + half)))
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
        let (a, b) = seen.pieces().next().expect("the wall is in range");
        assert!((a.x + 0.4).abs() < 1e-4 && (b.x - 0.4).abs() < 1e-4, "{a:?} {b:?}");
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
