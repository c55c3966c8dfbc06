//! Finds the way that the operator's choices at junctions lead to, and the branches that a head took.
//!
//! Left is the gallery farthest to the left as seen from the base, right the one farthest to the
//! right, as the operator means it (the book's chapter "Navigation").

use units::Branch;
use world::{Joint, Leg, Path, Skeleton, SkeletonPlace};

/// A head has passed a junction when it is so far behind it, m: a place changes to another gallery
/// late by as much ([`Skeleton::LOYALTY_M`]).
const BEYOND: f32 = Skeleton::LOYALTY_M;
/// The direction of a gallery at a junction is that of its first metre.
const DIRECTION: f32 = 1.0;
/// A gallery goes straight on where it turns by less, rad: 30°. Ours.
const STRAIGHT: f32 = core::f32::consts::FRAC_PI_6;

/// A direction along an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Heading {
    pub(super) edge: u16,
    /// Whether towards larger lengths along it.
    pub(super) is_forth: bool,
}

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
    let mut found = Vec::new();
    let (mut before, whole) = (0.0, way.length());
    for (n, leg) in way.legs().iter().enumerate() {
        let heading = Heading { edge: leg.edge, is_forth: leg.to >= leg.from };
        let mut joints: Vec<Joint> = on(skeleton, leg).collect();
        joints.sort_by(|a, b| distance(leg, a).total_cmp(&distance(leg, b)));
        for joint in joints {
            let at_m = before + distance(leg, &joint);
            let is_last = (joint.along - leg.to).abs() < SAME;
            let to = match way.legs().get(n + 1) {
                Some(next) if is_last => {
                    Heading { edge: next.edge, is_forth: next.to >= next.from }
                }
                _ => heading,
            };
            let from = (heading, joint.along);
            let has_choice = Junction::at(skeleton, joint.node, from).exits.len() > 1;
            if has_choice && whole - at_m > BEYOND {
                found.push(Passing { node: joint.node, from, to, at_m, ordered: None });
            }
        }
        before += (leg.to - leg.from).abs();
    }
    found
}

/// Joints nearer than this are the same, m.
const SAME: f32 = 1e-2;

fn distance(leg: &Leg, joint: &Joint) -> f32 {
    (joint.along - leg.from).abs()
}

/// The joints that a leg comes to, without that where it begins.
fn on(skeleton: &Skeleton, leg: &Leg) -> impl Iterator<Item = Joint> {
    let (low, high) = (leg.from.min(leg.to) - SAME, leg.from.max(leg.to) + SAME);
    let from = leg.from;
    let joints = skeleton.edge(leg.edge).joints().iter().copied();
    joints.filter(move |joint| {
        (low..=high).contains(&joint.along) && (joint.along - from).abs() > SAME
    })
}

/// A junction as a drone sees it that comes to it from the base.
struct Junction {
    /// The ways on, with the angle by which each turns to the left, rad.
    exits: Vec<(Heading, f32)>,
    from: Heading,
}

impl Junction {
    fn at(skeleton: &Skeleton, node: usize, (from, along): (Heading, f32)) -> Self {
        let back = Heading { edge: from.edge, is_forth: !from.is_forth };
        let [bx, by] = direction(skeleton, back, along);
        let (hx, hy) = (-bx, -by);
        let mut exits = Vec::new();
        for (number, edge) in skeleton.edges().iter().enumerate() {
            let length = edge.line().length();
            for joint in edge.joints().iter().filter(|joint| joint.node == node) {
                for is_forth in [true, false] {
                    let heading = Heading { edge: number as u16, is_forth };
                    let room = if is_forth { length - joint.along } else { joint.along };
                    if room <= SAME || heading == back {
                        continue;
                    }
                    let [x, y] = direction(skeleton, heading, joint.along);
                    exits.push((heading, libm::atan2f(hx * y - hy * x, hx * x + hy * y)));
                }
            }
        }
        Self { exits, from }
    }

    /// The way on that a choice means; `None` where it decides nothing.
    fn chosen(&self, branch: Branch) -> Option<Heading> {
        let by = |key: fn(f32) -> f32| {
            self.exits.iter().copied().max_by(|a, b| key(a.1).total_cmp(&key(b.1)))
        };
        let exit = match branch {
            Branch::Left => by(|angle| angle),
            Branch::Right => by(|angle| -angle),
            Branch::Straight => by(|angle| -angle.abs()).filter(|exit| exit.1.abs() <= STRAIGHT),
        };
        exit.map(|(heading, _)| heading)
    }

    /// The way on without a choice: along the same gallery, or as straight as can be.
    fn onward(&self) -> Option<Heading> {
        let same = self.exits.iter().find(|(heading, _)| *heading == self.from);
        let straightest = || self.exits.iter().min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        same.or_else(straightest).map(|(heading, _)| *heading)
    }
}

/// The unit vector from a place of an edge along it.
fn direction(skeleton: &Skeleton, heading: Heading, along: f32) -> [f32; 2] {
    let line = skeleton.edge(heading.edge).line();
    let there = if heading.is_forth { along + DIRECTION } else { along - DIRECTION };
    let (from, to) = (line.at(along).0, line.at(there.clamp(0.0, line.length())).0);
    let (x, y) = (to.x - from.x, to.y - from.y);
    let length = libm::hypotf(x, y).max(f32::MIN_POSITIVE);
    [x / length, y / length]
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
        let next =
            on(skeleton, &whole).min_by(|a, b| distance(&whole, a).total_cmp(&distance(&whole, b)));
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
