//! Finds the shortest ways on the skeleton.

use super::{Crossing, Skeleton, SkeletonPlace};

/// A stretch of one edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// The edge's number.
    pub edge: u16,
    /// The length along the edge where the stretch begins, m.
    pub from: f32,
    /// The length along the edge where it ends, which may be less, m.
    pub to: f32,
}

impl Leg {
    fn length(&self) -> f32 {
        (self.to - self.from).abs()
    }
}

/// The shortest way from one place to another.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// The points of the path: at least one.
    legs: Vec<Leg>,
}

impl Path {
    /// The stretches of edges of which the way consists.
    #[must_use]
    pub fn legs(&self) -> &[Leg] {
        &self.legs
    }

    /// The whole length, m.
    #[must_use]
    pub fn length(&self) -> f32 {
        self.legs.iter().map(Leg::length).sum()
    }

    /// Returns the place at this distance along the way, m; beyond its end, the end of the way.
    #[must_use]
    pub fn at(&self, way: f32) -> SkeletonPlace {
        let mut rest = way.max(0.0);
        for (n, leg) in self.legs.iter().enumerate() {
            if rest <= leg.length() || n + 1 == self.legs.len() {
                let rest = rest.min(leg.length());
                let along = if leg.to >= leg.from { leg.from + rest } else { leg.from - rest };
                return SkeletonPlace { edge: leg.edge, along };
            }
            rest -= leg.length();
        }
        SkeletonPlace::default()
    }
}

impl Skeleton {
    /// The shortest way from `a` to `b`. Between galleries that nothing joins it is the place `b`
    /// alone.
    #[must_use]
    pub fn path(&self, a: SkeletonPlace, b: SkeletonPlace) -> Path {
        let direct = Leg { edge: a.edge, from: a.along, to: b.along };
        let along_edge = if a.edge == b.edge { direct.length() } else { f32::INFINITY };
        if a.edge == b.edge && !self.edge(a.edge).has_shortcut {
            return Path { legs: vec![direct] };
        }
        let length = |way: &Crossing| {
            (a.along - way.leave.along).abs() + way.between + (b.along - way.enter.along).abs()
        };
        let ways = self.crossings_between(a.edge, b.edge).iter().map(|way| (length(way), way));
        match ways.min_by(|one, other| one.0.total_cmp(&other.0)) {
            Some((length, way)) if length < along_edge => self.path_through(a, b, way),
            _ if a.edge == b.edge => Path { legs: vec![direct] },
            _ => Path { legs: vec![Leg { edge: b.edge, from: b.along, to: b.along }] },
        }
    }

    fn path_through(&self, a: SkeletonPlace, b: SkeletonPlace, way: &Crossing) -> Path {
        let mut legs = vec![Leg { edge: a.edge, from: a.along, to: way.leave.along }];
        let mut node = way.leave.node;
        while node != way.enter.node {
            let hop = self.hop(node, way.enter.node);
            let edge = &self.edges[hop.edge];
            let along = |wanted: usize| {
                edge.joints.iter().find(|j| j.node == wanted).map_or(0.0, |joint| joint.along)
            };
            legs.push(Leg { edge: hop.edge as u16, from: along(node), to: along(hop.to) });
            node = hop.to;
        }
        legs.push(Leg { edge: b.edge, from: way.enter.along, to: b.along });
        legs.retain(|leg| leg.length() > 0.0);
        if legs.is_empty() {
            legs.push(Leg { edge: b.edge, from: b.along, to: b.along });
        }
        Path { legs }
    }
}
