//! Decides whether a frontier lies in an area that another robot has seen, from that robot's points
//! alone: its frontiers and its occupied cells (thesis, algorithms 3 and 4).

use units::{Metres, Point2};

/// Two coordinates that differ by less count as equal (thesis, algorithm 4).
pub const NEAR: Metres = Metres(0.5);

/// The shape that another robot's area is taken to have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Algorithm 3: the area is the bounding box of its points. As printed, its second pass asks for
    /// x again; here it asks for y, without which there would be no box.
    Box,
    /// Algorithm 4: on the point's own row, within [`NEAR`], the area has a point to the west and
    /// one to the east, or one that is equal. Its first pass follows from this, and is left out.
    Concave,
}

/// Whether a point lies in the area that has these points on its edge.
#[must_use]
pub fn is_overlapped(
    point: Point2,
    edge: impl Iterator<Item = Point2> + Clone,
    shape: Shape,
) -> bool {
    match shape {
        Shape::Box => {
            is_between(point.x, edge.clone().map(|other| other.x), 0.0)
                && is_between(point.y, edge.map(|other| other.y), 0.0)
        }
        Shape::Concave => {
            let row = edge.filter(|other| (other.y - point.y).abs() < NEAR.0);
            is_between(point.x, row.map(|other| other.x), NEAR.0)
        }
    }
}

/// Whether there are values below and above, or one that is within `near`.
fn is_between(value: f32, others: impl Iterator<Item = f32>, near: f32) -> bool {
    let (mut has_below, mut has_above, mut has_equal) = (false, false, false);
    for other in others {
        has_below |= other < value - near;
        has_above |= other > value + near;
        has_equal |= (other - value).abs() <= near;
    }
    has_below && has_above || has_equal
}
