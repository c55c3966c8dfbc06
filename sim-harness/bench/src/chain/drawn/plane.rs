//! Distances between straight pieces and rectangles of a floor plan that is being drawn.
//!
//! It uses only sums, products and square roots, so that a seed draws the same place on every machine.

/// A point of the plan, m.
pub(super) type Point = [f32; 2];

/// A straight piece.
pub(super) type Segment = [Point; 2];

pub(super) fn along([x, y]: Point, [dx, dy]: Point, length: f32) -> Point {
    [x + length * dx, y + length * dy]
}

pub(super) fn minus([ax, ay]: Point, [bx, by]: Point) -> Point {
    [ax - bx, ay - by]
}

pub(super) fn dot([ax, ay]: Point, [bx, by]: Point) -> f32 {
    ax * bx + ay * by
}

pub(super) fn distance(a: Point, b: Point) -> f32 {
    let by = minus(a, b);
    dot(by, by).sqrt()
}

/// A unit vector, turned to the left by an angle with this sine and cosine.
pub(super) fn turned([x, y]: Point, (sin, cos): (f32, f32)) -> Point {
    let [x, y] = [x * cos - y * sin, x * sin + y * cos];
    let length = (x * x + y * y).sqrt().max(1e-6);
    [x / length, y / length]
}

fn to_point([a, b]: Segment, point: Point) -> f32 {
    let (way, off) = (minus(b, a), minus(point, a));
    let part = (dot(way, off) / dot(way, way).max(1e-9)).clamp(0.0, 1.0);
    distance(point, along(a, way, part))
}

fn cross([ax, ay]: Point, [bx, by]: Point) -> f32 {
    ax * by - ay * bx
}

fn do_cross([a, b]: Segment, [c, d]: Segment) -> bool {
    let side = |p: Point, q: Point, r: Point| cross(minus(q, p), minus(r, p));
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

/// The least distance between two pieces.
pub(super) fn apart(one: Segment, other: Segment) -> f32 {
    if do_cross(one, other) {
        return 0.0;
    }
    let [a, b] = [to_point(other, one[0]), to_point(other, one[1])];
    let [c, d] = [to_point(one, other[0]), to_point(one, other[1])];
    a.min(b).min(c).min(d)
}

/// A rectangle with sides along x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rectangle {
    pub(super) centre: Point,
    pub(super) size: Point,
}

impl Rectangle {
    /// How deep a point is in it, m; negative outside.
    pub(super) fn depth(&self, [x, y]: Point) -> f32 {
        let inside = |at: f32, middle: f32, size: f32| 0.5 * size - (at - middle).abs();
        inside(x, self.centre[0], self.size[0]).min(inside(y, self.centre[1], self.size[1]))
    }

    /// The least distance to a piece; 0 where the piece is within or crosses it.
    pub(super) fn apart(&self, piece: Segment) -> f32 {
        if piece.iter().any(|end| self.depth(*end) > 0.0) {
            return 0.0;
        }
        let ([x, y], [w, h]) = (self.centre, [0.5 * self.size[0], 0.5 * self.size[1]]);
        let corners = [[x - w, y - h], [x + w, y - h], [x + w, y + h], [x - w, y + h]];
        let sides = [[0, 1], [1, 2], [2, 3], [3, 0]].map(|[a, b]| [corners[a], corners[b]]);
        sides.map(|side| apart(side, piece)).into_iter().fold(f32::INFINITY, f32::min)
    }
}
