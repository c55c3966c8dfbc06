//! What the two beams of a side see.

use crate::gallery::cosines;
use crate::{Diagonals, Range, Side};

/// The two beams of a wall agree to within this part of their mean: the ratio test of section IV-E.
const AGREE: f32 = 0.4;

/// The wall of one side, as its two beams see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Seen {
    /// A beam was not measured.
    Unknown,
    /// A wall along the way, at this distance, with the nose turned to it by this angle.
    Wall { distance: f32, skew: f32 },
    /// Neither beam sees anything.
    Nothing,
    /// The two beams see different things: a wall ends here, or turns.
    Other,
}

/// The beam to a side that leads in a direction.
pub(super) fn leading(ranges: &Diagonals, side: Side, direction: f32) -> Range {
    match (side, direction > 0.0) {
        (Side::Left, true) => ranges.nw,
        (Side::Left, false) => ranges.sw,
        (Side::Right, true) => ranges.ne,
        (Side::Right, false) => ranges.se,
    }
}

/// The side of the nearer wall, but for sides, left and right, that are open, and its distance.
pub(super) fn nearer_wall(ranges: &Diagonals, is_open: [bool; 2]) -> Option<(Side, f32)> {
    let wall = |(side, is_open): (Side, bool)| match look(ranges, side) {
        Seen::Wall { distance, .. } if !is_open => Some((side, distance)),
        _ => None,
    };
    let sides = [Side::Left, Side::Right].into_iter().zip(is_open).filter_map(wall);
    sides.min_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// What the two beams of a side see.
pub(super) fn look(ranges: &Diagonals, side: Side) -> Seen {
    let (front, rear) = ranges.beams(side);
    if front == Range::Invalid || rear == Range::Invalid {
        return Seen::Unknown;
    }
    match (front.length(), rear.length()) {
        (Some(front), Some(rear)) if (front - rear).abs() <= AGREE * 0.5 * (front + rear) => {
            let tan = (rear - front) / (rear + front);
            let (near, far) = cosines(tan);
            let skew = libm::atanf(tan);
            let skew = if side == Side::Left { skew } else { -skew };
            Seen::Wall { distance: 0.5 * (front * near + rear * far), skew }
        }
        (None, None) => Seen::Nothing,
        _ => Seen::Other,
    }
}
