//! Does the plane geometry that forces, formations and obstacles share.

use units::Point2;

/// Returns the point `length` metres from `from` along `way`.
pub(crate) fn moved(from: Point2, way: Point2, length: f32) -> Point2 {
    Point2::new(from.x + length * way.x, from.y + length * way.y)
}

/// Returns the scalar product of `way` and the vector from `from` to `to`.
pub(crate) fn along(way: Point2, from: Point2, to: Point2) -> f32 {
    way.x * (to.x - from.x) + way.y * (to.y - from.y)
}

/// Returns `way` turned counter-clockwise by a right angle.
pub(crate) fn left_of(way: Point2) -> Point2 {
    Point2::new(-way.y, way.x)
}

/// Returns `way` turned counter-clockwise by the angle with this cosine and sine.
pub(crate) fn turned(way: Point2, (cos, sin): (f32, f32)) -> Point2 {
    Point2::new(way.x * cos - way.y * sin, way.x * sin + way.y * cos)
}

/// Returns the squared distance of two points, in square metres.
pub(crate) fn squared(a: Point2, b: Point2) -> f32 {
    let (x, y) = (b.x - a.x, b.y - a.y);
    x * x + y * y
}
