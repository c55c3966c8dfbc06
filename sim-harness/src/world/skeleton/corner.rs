//! Finds the places of points on the inside of a corner of a wide junction.
//!
//! A drone that turns from one wide gallery into another flies round the corner between them, far from
//! the junction of their centre-lines. There it has a foot on either, and the nearer one changes by
//! metres of length where it passes the corner's diagonal: so would the strengths of its links. As in
//! the bend of one gallery, the place therefore passes from one foot to the other over the inside of
//! the corner.

use units::Point2;

use super::{Joint, Polyline, Skeleton, SkeletonPlace, corner_length};

/// A stretch of an edge that begins at a junction.
#[derive(Clone, Copy)]
struct Arm {
    edge: u16,
    joint: Joint,
    /// 1 towards the edge's end, −1 towards its beginning.
    sign: f32,
    /// How far along it, from the junction, the foot of the point is, m.
    foot: f32,
    /// From the junction to the next bend or end, m.
    length: f32,
    width: f32,
}

impl Arm {
    /// The place this far from the junction, m.
    fn place(&self, way: f32) -> SkeletonPlace {
        SkeletonPlace { edge: self.edge, along: self.joint.along + self.sign * way }
    }
}

impl Skeleton {
    /// The place of a point that was at `last` a moment before and is on the inside of the corner
    /// between two galleries of which one is wide; `None` elsewhere.
    pub(super) fn inside_corner(
        &self,
        point: Point2,
        last: SkeletonPlace,
    ) -> Option<SkeletonPlace> {
        let edge = self.edge(last.edge);
        edge.joints.iter().find_map(|joint| {
            let own = self.arm(last.edge, *joint, point)?;
            let others = self.others_at(joint.node, last.edge);
            others.into_iter().find_map(|(other, along)| {
                let there = self.arm(other, Joint { along, ..*joint }, point)?;
                between(&own, &there)
            })
        })
    }

    /// The arm of an edge at this joint on which the point has its foot; `None` where it has none, or
    /// where the foot is on the next piece of the edge.
    fn arm(&self, edge: u16, joint: Joint, point: Point2) -> Option<Arm> {
        let here = self.edge(edge);
        let at = self.nodes.get(joint.node)?.at;
        [1.0, -1.0].into_iter().find_map(|sign| {
            let (direction, length) = here.line.piece_from(joint.along, sign)?;
            let foot = (point.x - at.x) * direction[0] + (point.y - at.y) * direction[1];
            (foot > 0.0).then_some(Arm { edge, joint, sign, foot, length, width: here.width })
        })
    }
}

/// The place of the point that has its feet on both arms.
fn between(one: &Arm, other: &Arm) -> Option<SkeletonPlace> {
    let width = one.width.max(other.width);
    if width <= 2.0 * Polyline::WINDOW_M {
        return None;
    }
    let reach = width.min(0.5 * one.length).min(0.5 * other.length);
    let way = corner_length(one.foot, other.foot, reach)?;
    Some(if way > 0.0 { other.place(way) } else { one.place(-way) })
}
