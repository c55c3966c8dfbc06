//! Finds the mean of places on a skeleton.

use super::{Skeleton, SkeletonPlace};

/// A stretch of an edge that counts in a mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mass {
    /// The edge's number.
    pub(crate) edge: u16,
    /// The middle of the stretch, as a length along the edge, m.
    pub(crate) along: f64,
    /// The weight.
    pub(crate) mass: f64,
}

impl Mass {
    /// The stretches of one edge as one; `None` where they weigh nothing.
    pub(crate) fn joined(parts: &[Self]) -> Option<Self> {
        let edge = parts.first()?.edge;
        let mass: f64 = parts.iter().map(|part| part.mass).sum();
        let moment: f64 = parts.iter().map(|part| part.mass * part.along).sum();
        (mass > 0.0).then(|| Self { edge, along: moment / mass, mass })
    }
}

/// A mass seen from an edge: it lies at `near` on it, and `beyond` behind that on another edge, m.
struct Pull {
    near: f64,
    beyond: f64,
    mass: f64,
}

impl Skeleton {
    /// How far from a junction a point leaves the gallery that was there first, m: more than a drone
    /// deviates from the middle of a gallery where it passes the entrance of another.
    pub const LOYALTY_M: f32 = 0.3;

    /// The mean of these stretches: the place from which the sum of the squares of their geodesic
    /// distances, each with its weight, is the least. On galleries without a loop there is one, and it
    /// moves by no more than the stretches do.
    pub(crate) fn middle(&self, masses: &[Mass]) -> SkeletonPlace {
        let mut edges: Vec<u16> = masses.iter().map(|mass| mass.edge).collect();
        edges.sort_unstable();
        edges.dedup();
        let found = edges.into_iter().map(|edge| self.middle_on(edge, masses));
        let best = found.min_by(|a, b| a.1.total_cmp(&b.1));
        best.map_or_else(SkeletonPlace::default, |(place, _)| place)
    }

    /// The best place on one edge, and its sum of squares.
    fn middle_on(&self, edge: u16, masses: &[Mass]) -> (SkeletonPlace, f64) {
        let own: Vec<Mass> = masses.iter().filter(|mass| mass.edge == edge).copied().collect();
        let length = f64::from(self.edge(edge).line.length());
        let mean = Mass::joined(&own).map_or(0.0, |mass| mass.along).clamp(0.0, length);
        let pulls: Vec<Pull> =
            masses.iter().filter_map(|mass| self.pull(edge, mean, mass)).collect();
        let along = if own.len() == masses.len() { mean } else { balance(&pulls, length) };
        let square = |pull: &Pull| {
            let distance = (along - pull.near).abs() + pull.beyond;
            pull.mass * distance * distance
        };
        let place = SkeletonPlace { edge, along: along as f32 };
        (place, pulls.iter().map(square).sum())
    }

    /// A mass as it is seen from an edge, from about `along` on it; `None` where nothing joins them.
    fn pull(&self, edge: u16, along: f64, mass: &Mass) -> Option<Pull> {
        if mass.edge == edge {
            return Some(Pull { near: mass.along, beyond: 0.0, mass: mass.mass });
        }
        let ways = self.crossings_between(edge, mass.edge).iter().map(|way| {
            let behind = way.between + (mass.along as f32 - way.enter.along).abs();
            ((along as f32 - way.leave.along).abs() + behind, way.leave.along, behind)
        });
        let (_, near, beyond) = ways.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Pull { near: near.into(), beyond: beyond.into(), mass: mass.mass })
    }

    /// The place of a point whose centre-lines have their mean here: beside a junction it stays on the
    /// gallery that was there first, and then catches up.
    pub(crate) fn settled(&self, place: SkeletonPlace) -> SkeletonPlace {
        let edge = self.edge(place.edge);
        for (n, joint) in edge.joints.iter().enumerate() {
            let others = [n.wrapping_sub(1), n + 1].map(|other| edge.joints.get(other));
            let gap = others.into_iter().flatten().map(|other| (other.along - joint.along).abs());
            let loyal = gap.fold(6.0 * Self::LOYALTY_M, f32::min) / 6.0;
            let past = place.along - joint.along;
            if past.abs() >= 3.0 * loyal {
                continue;
            }
            let Some((first, along)) = self.others_at(joint.node, place.edge).next() else {
                continue;
            };
            if first > place.edge {
                continue;
            }
            return match past.abs() < loyal {
                true => SkeletonPlace { edge: first, along },
                false => {
                    let past = past.signum() * 1.5 * (past.abs() - loyal);
                    SkeletonPlace { along: joint.along + past, ..place }
                }
            };
        }
        place
    }

    /// Whether an edge's beginning and its end are joined to no other.
    pub(crate) fn free_ends(&self, edge: usize) -> [bool; 2] {
        let Some(joints) = self.edges.get(edge).map(|edge| &edge.joints) else { return [true; 2] };
        let is_free = |joint: Option<&super::Joint>| {
            joint.is_none_or(|joint| self.others_at(joint.node, edge as u16).next().is_none())
        };
        [is_free(joints.first()), is_free(joints.last())]
    }
}

/// The length from 0 to `length` at which the pulls hold one another.
fn balance(pulls: &[Pull], length: f64) -> f64 {
    // The slope of the sum of squares rises all along the edge.
    let slope = |x: f64| -> f64 {
        let of = |pull: &Pull| {
            let side = if x >= pull.near { pull.beyond } else { -pull.beyond };
            pull.mass * (x - pull.near + side)
        };
        pulls.iter().map(of).sum()
    };
    let (mut low, mut high) = (0.0, length);
    // To a hundredth of a millimetre on the longest edge.
    for _ in 0..26 {
        let middle = 0.5 * (low + high);
        if slope(middle) > 0.0 { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}
