//! Finds the way that the operator's choices at junctions lead to, and the branches that a head took.

use units::Branch;
use world::forks::{Fork, Heading, Junction, forks, joint_distance, joints_on};
use world::{Leg, Path, Skeleton, SkeletonPlace};

/// A head has passed a junction when it is so far behind it, m: a place changes to another gallery
/// late by as much ([`Skeleton::LOYALTY_M`]).
const BEYOND: f32 = Skeleton::LOYALTY_M;

/// A junction that a head has passed on its way from the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passing {
    node: usize,
    /// The direction in which the head came to it, and where the junction is along that edge, m.
    from: (Heading, f32),
    /// The direction in which the head left it.
    pub(super) to: Heading,
    /// The junction's distance from the base, m.
    pub(super) at_m: f32,
    /// The choice that stood when the head passed it; `None` where there was none, or it had just
    /// changed.
    pub(super) ordered: Option<Branch>,
}

impl Passing {
    /// The same junction, left by the same gallery.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        (self.node, self.to) == (other.node, other.to)
    }

    /// The same under this choice.
    pub(super) const fn under(self, ordered: Option<Branch>) -> Self {
        Self { ordered, ..self }
    }

    /// The choice that was ordered here, where the head did not follow it.
    pub(super) fn missed(&self, skeleton: &Skeleton) -> Option<Branch> {
        let branch = self.ordered?;
        let wanted = Junction::at(skeleton, self.node, self.from).chosen(branch)?;
        (wanted != self.to).then_some(branch)
    }
}

/// The junctions with a choice that a way from the base passes, in their order.
pub(super) fn passed(skeleton: &Skeleton, way: &Path) -> Vec<Passing> {
    let found = forks(skeleton, way, BEYOND).into_iter();
    let passing = |Fork { node, from, to, at_m }| Passing { node, from, to, at_m, ordered: None };
    found.map(passing).collect()
}

/// The way from the base that the choices lead to, to where its last gallery ends: at the junctions
/// that the head has passed by the choice that stood there or, without one, as the head flew; at all
/// others by the `last` choice. A way that comes back to a junction ends there.
pub(super) fn ordered_way(
    skeleton: &Skeleton,
    base: SkeletonPlace,
    passed: &[Passing],
    last: Option<Branch>,
) -> Vec<Leg> {
    let mut legs = Vec::new();
    let (mut heading, mut along) = (Heading { edge: base.edge, is_forth: true }, base.along);
    let mut seen = Vec::new();
    loop {
        let edge = skeleton.edge(heading.edge);
        let end = if heading.is_forth { edge.line().length() } else { 0.0 };
        let whole = Leg { edge: heading.edge, from: along, to: end };
        let next = joints_on(skeleton, &whole)
            .min_by(|a, b| joint_distance(&whole, a).total_cmp(&joint_distance(&whole, b)));
        let Some(joint) = next.filter(|joint| !seen.contains(&joint.node)) else {
            legs.push(whole);
            return legs;
        };
        legs.push(Leg { to: joint.along, ..whole });
        seen.push(joint.node);
        let junction = Junction::at(skeleton, joint.node, (heading, joint.along));
        let passing = passed.iter().find(|passing| passing.node == joint.node);
        let branch = passing.map_or(last, |passing| passing.ordered);
        let chosen = branch.and_then(|branch| junction.chosen(branch));
        let taken = || passing.map(|passing| passing.to);
        let Some(onward) = chosen.or_else(taken).or_else(|| junction.onward()) else {
            return legs;
        };
        let joints = skeleton.edge(onward.edge).joints();
        let entry = joints.iter().find(|there| there.node == joint.node);
        along = entry.map_or(0.0, |there| there.along);
        heading = onward;
    }
}

#[cfg(test)]
mod tests {
    use units::Point2;

    use super::*;
    use world::Gallery;

    fn gallery(name: &str, points: &[(f32, f32)]) -> Gallery {
        let centre_line = points.iter().map(|&(x, y)| Point2::new(x, y)).collect();
        Gallery { name: name.into(), centre_line, width: 1.2 }
    }

    /// A gallery that ends in another after 6 m: 5 m to the left, 8 m to the right, and half way to
    /// it a side passage to the left.
    fn tee() -> Skeleton {
        Skeleton::of(&[
            gallery("main", &[(0.0, 0.0), (6.0, 0.0)]),
            gallery("left", &[(6.0, 0.0), (6.0, 5.0)]),
            gallery("right", &[(6.0, 0.0), (6.0, -8.0)]),
            gallery("side", &[(3.0, 0.0), (3.0, 2.0)]),
        ])
    }

    fn base() -> SkeletonPlace {
        SkeletonPlace::main(0.0)
    }

    /// The length of the ordered way, and the name of the gallery in which it ends.
    fn ordered(passed: &[Passing], last: Option<Branch>) -> (f32, String) {
        let skeleton = tee();
        let way = ordered_way(&skeleton, base(), passed, last);
        let length = way.iter().map(|leg| (leg.to - leg.from).abs()).sum();
        (length, skeleton.edge(way.last().unwrap().edge).name().into())
    }

    #[test]
    fn the_choice_leads_into_its_gallery() {
        assert_eq!(ordered(&[], Some(Branch::Right)), (14.0, "right".into()));
        assert_eq!(ordered(&[], Some(Branch::Left)), (5.0, "side".into()));
        assert_eq!(ordered(&[], None).1, "left", "as straight as any, and the first");
    }

    #[test]
    fn a_head_in_another_branch_than_the_ordered_one_has_missed_it() {
        let skeleton = tee();
        let left = SkeletonPlace { edge: 1, along: 4.0 };
        let way = passed(&skeleton, &skeleton.path(base(), left));
        assert_eq!(way.iter().map(|passing| passing.at_m).collect::<Vec<_>>(), [3.0, 6.0]);
        let missed = |n: usize, ordered| Passing { ordered, ..way[n] }.missed(&skeleton);
        assert_eq!(
            missed(0, Some(Branch::Right)),
            None,
            "straight on is right of the side passage"
        );
        assert_eq!(missed(0, Some(Branch::Left)), Some(Branch::Left), "the side passage");
        assert_eq!(missed(1, Some(Branch::Right)), Some(Branch::Right));
        assert_eq!(missed(1, Some(Branch::Left)), None);
        assert_eq!(missed(1, Some(Branch::Straight)), None, "which decides nothing here");
        assert_eq!(missed(1, None), None);
    }

    #[test]
    fn the_ordered_way_follows_the_head_where_nothing_was_ordered() {
        let skeleton = tee();
        let right = SkeletonPlace { edge: 2, along: 4.0 };
        let passed = passed(&skeleton, &skeleton.path(base(), right));
        assert_eq!(ordered(&passed, None), (14.0, "right".into()));
        let changed: Vec<_> =
            passed.iter().map(|p| Passing { ordered: Some(Branch::Right), ..*p }).collect();
        assert_eq!(ordered(&changed, Some(Branch::Left)), (14.0, "right".into()));
    }
}
