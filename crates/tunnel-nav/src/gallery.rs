//! Measures a straight gallery with the beams: the angle of the nose to it, and the drone's
//! distance from its middle.
//!
//! In a gallery of known width there are two unknowns and four beams, so that most other shapes can
//! be distinguished from it. Two beams suffice where the trail shows that the gallery is straight.

use core::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_4, SQRT_2};

use units::Radians;

use crate::Diagonals;

/// Two walls are parallel and as far apart as before where their distances agree to within this
/// part of the width.
const SAME_WIDTH: f32 = 0.12;
/// A single wall is nearer than this part of the width to where it is expected: a drone that rests
/// drifts by some decimetres.
const SAME_PLACE: f32 = 0.35;
/// The width over the length of the two beams of a diagonal, for a nose 8° to 45° off: a smaller
/// one is seen by all beams.
const OFF: core::ops::Range<f32> = 0.8..1.05;

/// A straight gallery.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gallery {
    /// The angle of the nose to the gallery, counter-clockwise positive.
    pub(crate) skew: Radians,
    /// The distance of the drone from the middle, to the left positive, m.
    pub(crate) offset: f32,
    /// Whether all four beams see it.
    pub(crate) whole: bool,
}

/// What is known of a gallery that the trail knows to be straight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Expected {
    /// How far the drone is to the left of the middle, m.
    pub(crate) aside: f32,
    /// Whether there are walls on the left and on the right.
    pub(crate) walls: [bool; 2],
}

impl Gallery {
    /// The gallery by all four beams; `usual` is the length of the beams in its middle, in metres.
    pub(crate) fn by_all(ranges: &Diagonals, usual: f32) -> Option<Self> {
        let (nw, ne) = (ranges.nw.length()?, ranges.ne.length()?);
        let (sw, se) = (ranges.sw.length()?, ranges.se.length()?);
        let (falling, rising) = (nw + se, ne + sw);
        let tan = (rising - falling) / (rising + falling);
        let (near, far) = cosines(tan);
        let width = SQRT_2 * usual;
        let agree = |a: f32, b: f32| (a - b).abs() < SAME_WIDTH * width;
        let (left, right) = (0.5 * (nw * near + sw * far), 0.5 * (se * near + ne * far));
        let parallel = agree(nw * near, sw * far) && agree(se * near, ne * far);
        (parallel && agree(left + right, width)).then(|| Self {
            skew: Radians(libm::atanf(tan)),
            offset: 0.5 * (right - left),
            whole: true,
        })
    }

    /// The gallery by two beams: those at one wall, or those of a diagonal.
    pub(crate) fn by_two(ranges: &Diagonals, usual: f32, expected: Expected) -> Option<Self> {
        let width = SQRT_2 * usual;
        let mirrored = &ranges.mirrored();
        let Expected { aside, walls: [on_left, on_right] } = expected;
        let left = Self::by_left_wall(ranges, width, aside).filter(|_| on_left);
        let right = Self::by_left_wall(mirrored, width, -aside).filter(|_| on_right);
        let off = |gallery: &Self| (gallery.offset - aside).abs();
        let wall = match (left, right.map(Self::mirrored)) {
            (Some(left), Some(right)) if off(&right) < off(&left) => Some(right),
            (left, right) => left.or(right),
        };
        wall.or_else(|| Self::by_diagonal(ranges, width))
            .or_else(|| Self::by_diagonal(mirrored, width).map(Self::mirrored))
    }

    /// Both beams on the left end at a wall that is where it is expected.
    fn by_left_wall(ranges: &Diagonals, width: f32, aside: f32) -> Option<Self> {
        let (nw, sw) = (ranges.nw.length()?, ranges.sw.length()?);
        let tan = (sw - nw) / (sw + nw);
        let (near, far) = cosines(tan);
        let offset = 0.5 * (width - nw * near - sw * far);
        let skew = Radians(libm::atanf(tan));
        ((offset - aside).abs() < SAME_PLACE * width).then_some(Self { skew, offset, whole: false })
    }

    /// The nose is so far to the left that only two beams reach the walls.
    fn by_diagonal(ranges: &Diagonals, width: f32) -> Option<Self> {
        let (nw, se) = (ranges.nw.length()?, ranges.se.length()?);
        let cos = width / (nw + se);
        let skew = Radians(FRAC_PI_4 - libm::acosf(cos.min(1.0)));
        OFF.contains(&cos).then_some(Self { skew, offset: 0.5 * (se - nw) * cos, whole: false })
    }

    fn mirrored(self) -> Self {
        Self { skew: Radians(-self.skew.0), offset: -self.offset, ..self }
    }
}

/// The cosines of the angles between the beams and the normals of the walls, for a nose that is to
/// the left by an angle with this tangent: of the front left and rear right beams, and of the
/// others.
pub(crate) fn cosines(tan: f32) -> (f32, f32) {
    let cos = FRAC_1_SQRT_2 / libm::sqrtf(1.0 + tan * tan);
    (cos * (1.0 + tan), cos * (1.0 - tan))
}

#[cfg(test)]
mod tests {
    use units::Metres;

    use super::*;
    use crate::Range;

    /// The beams of a drone in a straight gallery.
    fn gallery(width: f32, skew: f32, offset: f32, reach: f32) -> Diagonals {
        let beam = |angle: f32| {
            let sin = libm::sinf(angle + skew);
            let wall = if sin > 0.0 { 0.5 * width - offset } else { 0.5 * width + offset };
            Range::measured(Metres(wall / sin.abs()), Metres(reach))
        };
        let [nw, ne] = [beam(FRAC_PI_4), beam(-FRAC_PI_4)];
        Diagonals { nw, ne, sw: beam(3.0 * FRAC_PI_4), se: beam(-3.0 * FRAC_PI_4) }
    }

    const EXPECTED: Expected = Expected { aside: 0.0, walls: [true; 2] };

    #[test]
    fn a_straight_gallery_is_seen_as_it_is() {
        for skew in [-0.3, -0.1, 0.0, 0.2] {
            for offset in [-0.2, 0.0, 0.1] {
                let ranges = gallery(1.0, skew, offset, 4.0);
                let usual = FRAC_1_SQRT_2;
                for seen in [
                    Gallery::by_all(&ranges, usual).unwrap(),
                    Gallery::by_two(&ranges, usual, EXPECTED).unwrap(),
                ] {
                    assert!((seen.skew.0 - skew).abs() < 1e-3, "{skew} {offset}: {seen:?}");
                    assert!((seen.offset - offset).abs() < 1e-3, "{skew} {offset}: {seen:?}");
                }
            }
        }
    }

    #[test]
    fn two_beams_suffice_where_the_others_see_nothing() {
        let ranges = gallery(2.0, 0.5, 0.1, 2.0);
        assert_eq!(Gallery::by_all(&ranges, SQRT_2), None);
        let seen = Gallery::by_two(&ranges, SQRT_2, EXPECTED).unwrap();
        assert!((seen.skew.0 - 0.5).abs() < 1e-2 && (seen.offset - 0.1).abs() < 1e-2, "{seen:?}");
    }

    #[test]
    fn a_wider_place_is_not_this_gallery() {
        assert_eq!(Gallery::by_all(&gallery(1.4, 0.0, 0.0, 4.0), FRAC_1_SQRT_2), None);
    }
}
