//! Finds the junctions of a way, and what a pilot chooses at each to follow it.
//!
//! Left is the gallery farthest to the left as seen from the base, right the one farthest to the
//! right, as the operator means it (the book's chapter "Navigation").

use units::Branch;

use super::{Joint, Leg, Path, Skeleton};

/// The direction of a gallery at a junction is that of its first metre.
const DIRECTION: f32 = 1.0;
/// A gallery goes straight on where it turns by less, rad: 30°. Ours.
const STRAIGHT: f32 = core::f32::consts::FRAC_PI_6;

/// A direction along an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heading {
    /// The edge's number.
    pub edge: u16,
    /// Whether it leads towards larger lengths along it.
    pub is_forth: bool,
}

/// A junction with a choice that a way passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fork {
    /// The number of the junction's node.
    pub node: usize,
    /// The direction in which the way comes to it, and where the junction is along that edge, m.
    pub from: (Heading, f32),
    /// The direction in which the way leaves it.
    pub to: Heading,
    /// The junction's distance along the way, m.
    pub at_m: f32,
}

impl Fork {
    /// What a pilot chooses here to follow the way: straight on where that leads along it; `None`
    /// where no choice does.
    #[must_use]
    pub fn branch(&self, skeleton: &Skeleton) -> Option<Branch> {
        let junction = Junction::at(skeleton, self.node, self.from);
        let all = [Branch::Straight, Branch::Left, Branch::Right];
        all.into_iter().find(|branch| junction.chosen(*branch) == Some(self.to))
    }
}

/// The junctions with a choice that a way passes, in their order, but for those nearer to its end than
/// this, m.
#[must_use]
pub fn forks(skeleton: &Skeleton, way: &Path, beyond_m: f32) -> Vec<Fork> {
    let mut found = Vec::new();
    let (mut before, whole) = (0.0, way.length());
    for (n, leg) in way.legs().iter().enumerate() {
        let heading = Heading { edge: leg.edge, is_forth: leg.to >= leg.from };
        let mut joints: Vec<Joint> = joints_on(skeleton, leg).collect();
        joints.sort_by(|a, b| joint_distance(leg, a).total_cmp(&joint_distance(leg, b)));
        for joint in joints {
            let at_m = before + joint_distance(leg, &joint);
            let is_last = (joint.along - leg.to).abs() < SAME;
            let to = match way.legs().get(n + 1) {
                Some(next) if is_last => {
                    Heading { edge: next.edge, is_forth: next.to >= next.from }
                }
                _ => heading,
            };
            let from = (heading, joint.along);
            let has_choice = Junction::at(skeleton, joint.node, from).exits.len() > 1;
            if has_choice && whole - at_m > beyond_m {
                found.push(Fork { node: joint.node, from, to, at_m });
            }
        }
        before += (leg.to - leg.from).abs();
    }
    found
}

/// Joints nearer than this are the same, m.
const SAME: f32 = 1e-2;

/// How far along a leg a joint is, m.
#[must_use]
pub fn joint_distance(leg: &Leg, joint: &Joint) -> f32 {
    (joint.along - leg.from).abs()
}

/// The joints that a leg comes to, without that where it begins.
pub fn joints_on(skeleton: &Skeleton, leg: &Leg) -> impl Iterator<Item = Joint> {
    let (low, high) = (leg.from.min(leg.to) - SAME, leg.from.max(leg.to) + SAME);
    let from = leg.from;
    let joints = skeleton.edge(leg.edge).joints().iter().copied();
    joints.filter(move |joint| {
        (low..=high).contains(&joint.along) && (joint.along - from).abs() > SAME
    })
}

/// A junction as a drone sees it that comes to it from the base.
pub struct Junction {
    /// The ways on, with the angle by which each turns to the left, rad.
    exits: Vec<(Heading, f32)>,
    from: Heading,
}

impl Junction {
    /// The junction at a node as seen by one who comes to it in this direction, along this edge.
    #[must_use]
    pub fn at(skeleton: &Skeleton, node: usize, (from, along): (Heading, f32)) -> Self {
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
    #[must_use]
    pub fn chosen(&self, branch: Branch) -> Option<Heading> {
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
    #[must_use]
    pub fn onward(&self) -> Option<Heading> {
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

#[cfg(test)]
mod tests {
    use units::Point2;

    use super::*;
    use crate::{Gallery, SkeletonPlace};

    /// A gallery with a side passage to the left after 3 m, which ends in another after 6 m.
    fn tee() -> Skeleton {
        let gallery = |name: &str, points: &[(f32, f32)]| {
            let centre_line = points.iter().map(|&(x, y)| Point2::new(x, y)).collect();
            Gallery { name: name.into(), centre_line, width: 1.2 }
        };
        Skeleton::of(&[
            gallery("main", &[(0.0, 0.0), (6.0, 0.0)]),
            gallery("left", &[(6.0, 0.0), (6.0, 5.0)]),
            gallery("right", &[(6.0, 0.0), (6.0, -8.0)]),
            gallery("side", &[(3.0, 0.0), (3.0, 2.0)]),
        ])
    }

    #[test]
    fn a_way_tells_what_to_choose_at_its_junctions() {
        let skeleton = tee();
        let choices = |edge: u16| {
            let end = SkeletonPlace { edge, along: 2.0 };
            let way = skeleton.path(SkeletonPlace::main(0.0), end);
            let found = forks(&skeleton, &way, 0.0).into_iter();
            found.map(|fork| (fork.at_m, fork.branch(&skeleton))).collect::<Vec<_>>()
        };
        let past = (3.0, Some(Branch::Straight));
        assert_eq!(choices(1), [past, (6.0, Some(Branch::Left))]);
        assert_eq!(choices(2), [past, (6.0, Some(Branch::Right))]);
        assert_eq!(choices(3), [(3.0, Some(Branch::Left))]);
    }
}
