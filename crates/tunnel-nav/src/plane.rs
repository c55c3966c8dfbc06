//! Points and ways in the plane of the floor by dead reckoning, in metres, and headings in radians.
//!
//! Where dead reckoning begins is up to the caller.

use units::Radians;

/// A point, or a way from one to another.
pub(crate) type Vec2 = [f32; 2];

/// The way from `b` to `a`.
pub(crate) fn minus(a: Vec2, b: Vec2) -> Vec2 {
    [a[0] - b[0], a[1] - b[1]]
}

/// The point that lies `scale` times `b` from `a`.
pub(crate) fn plus(a: Vec2, b: Vec2, scale: f32) -> Vec2 {
    [a[0] + scale * b[0], a[1] + scale * b[1]]
}

/// The scalar product.
pub(crate) fn dot(a: Vec2, b: Vec2) -> f32 {
    a[0] * b[0] + a[1] * b[1]
}

/// The unit vectors forward and to the left of a nose with this heading.
pub(crate) fn axes(heading: f32) -> [Vec2; 2] {
    let (sin, cos) = Radians(heading).sin_cos();
    [[cos, sin], [-sin, cos]]
}

/// The same angle within half a turn, for angles within one and a half turns of zero, such as the
/// difference of two headings. By comparison: a remainder would link 2 kB of library code.
pub(crate) fn wrapped(angle: f32) -> f32 {
    use core::f32::consts::{PI, TAU};
    if angle > PI {
        angle - TAU
    } else if angle < -PI {
        angle + TAU
    } else {
        angle
    }
}

/// The distance between two points, m.
pub(crate) fn distance(a: Vec2, b: Vec2) -> f32 {
    let way = minus(a, b);
    libm::sqrtf(dot(way, way))
}

/// A way, turned counter-clockwise by this angle.
pub(crate) fn turned([x, y]: Vec2, by: Radians) -> Vec2 {
    let (sin, cos) = by.sin_cos();
    [x * cos - y * sin, x * sin + y * cos]
}
