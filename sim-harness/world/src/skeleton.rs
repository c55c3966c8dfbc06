//! Holds the skeleton of a floor plan, which is a graph of centre-lines with their widths, and
//! computes places, distances and shortest ways on it.
//!
//! An *edge* is the centre-line of one gallery. A *node* is a place where edges end or meet: the
//! mouth, a junction, a dead end. Junctions may lie anywhere along an edge, so that the lengths
//! along a gallery are those that its scenario or survey gives. A [`SkeletonPlace`] is an edge
//! and the length along it; the *geodesic distance* of two places is the length of the shortest
//! way between them on the skeleton. A single corridor is a skeleton with one edge.

pub mod forks;
mod hops;
mod join;
mod knots;
mod middle;
mod path;
mod straight;
#[cfg(test)]
mod tests;

use units::{Metres, Point2};

use super::Polyline;
use hops::{Hop, shortest_hops};
pub use knots::Knot;
pub(super) use middle::Mass;
pub use path::{Leg, Path};

/// A gallery from which a skeleton is made.
#[derive(Clone, Debug, PartialEq)]
pub struct Gallery {
    /// The name by which a scenario refers to it.
    pub name: String,
    /// The points of the centre-line: at least two, no two successive ones equal.
    pub centre_line: Vec<Point2>,
    /// The width from wall to wall, m.
    pub width: f32,
}

/// The kind of a node of the skeleton.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeKind {
    /// The beginning of the first gallery.
    Mouth,
    /// Two galleries or more meet here.
    Junction,
    /// A gallery ends here.
    End,
}

/// A place where galleries end or meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// The point.
    pub at: Point2,
    /// The kind.
    pub kind: NodeKind,
}

/// The place of a node on an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// The node's number.
    pub node: usize,
    /// The length along the edge, m.
    pub along: f32,
}

/// The centre-line of one gallery.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    name: String,
    line: Polyline,
    width: f32,
    /// The edge's nodes in the order of their lengths.
    joints: Vec<Joint>,
    /// Whether the way round by other edges is shorter between any two of its nodes.
    has_shortcut: bool,
}

impl Edge {
    /// The gallery's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The centre-line.
    #[must_use]
    pub fn line(&self) -> &Polyline {
        &self.line
    }

    /// The width from wall to wall.
    #[must_use]
    pub fn width(&self) -> Metres {
        Metres(self.width)
    }

    /// The nodes on it, from its beginning to its end.
    #[must_use]
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }
}

/// A place on the skeleton.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SkeletonPlace {
    /// The edge's number.
    pub edge: u16,
    /// The length along it from its beginning, m.
    pub along: f32,
}

impl SkeletonPlace {
    /// The place this far along the first edge, m.
    #[must_use]
    pub const fn main(along: f32) -> Self {
        Self { edge: 0, along }
    }
}

/// Two nodes through which the shortest way from one edge to another may lead.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    leave: Joint,
    enter: Joint,
    /// The length of the way between them, m.
    between: f32,
}

/// The graph of centre-lines.
#[derive(Clone, Debug)]
pub struct Skeleton {
    edges: Vec<Edge>,
    nodes: Vec<Node>,
    /// The next step on the shortest way from one node to another, node-major.
    hops: Vec<Hop>,
    /// The ways from each edge to each other, edge-major.
    crossings: Vec<Vec<Crossing>>,
}

impl Skeleton {
    /// The skeleton of these galleries. The first is the main one; each later one joins those
    /// before it where they cross, where one of its ends lies within half a width of them, or
    /// else, by a straight line, from its nearer end.
    #[must_use]
    pub fn of(galleries: &[Gallery]) -> Self {
        let (edges, nodes) = join::join(galleries);
        Self::finished(edges, nodes)
    }

    /// The skeleton of these edges and nodes, with the ways between them.
    fn finished(edges: Vec<Edge>, nodes: Vec<Node>) -> Self {
        let hops = shortest_hops(&edges, nodes.len());
        let mut skeleton = Self { edges, nodes, hops, crossings: Vec::new() };
        skeleton.find_shortcuts();
        skeleton.crossings = skeleton.all_crossings();
        skeleton
    }

    /// The edges; the first is the main gallery.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// The nodes.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The edge of that number; the main gallery where there is none.
    #[must_use]
    pub fn edge(&self, number: u16) -> &Edge {
        &self.edges[usize::from(number).min(self.edges.len() - 1)]
    }

    /// The number of the edge of that name.
    #[must_use]
    pub fn edge_named(&self, name: &str) -> Option<u16> {
        let found = self.edges.iter().position(|edge| edge.name == name)?;
        u16::try_from(found).ok()
    }

    /// The point of a place and the unit vector towards its edge's end.
    #[must_use]
    pub fn at(&self, place: SkeletonPlace) -> (Point2, [f32; 2]) {
        self.edge(place.edge).line.at(place.along)
    }

    /// The other edges at a node, with the node's place along each.
    fn others_at(&self, node: usize, but: u16) -> impl Iterator<Item = (u16, f32)> {
        let edges = self.edges.iter().enumerate().filter(move |(n, _)| *n != usize::from(but));
        edges.flat_map(move |(n, edge)| {
            let here = edge.joints.iter().filter(move |joint| joint.node == node);
            here.map(move |joint| (n as u16, joint.along))
        })
    }

    /// The geodesic distance: the length of the shortest way from `a` to `b`; infinite between
    /// galleries that nothing joins.
    #[must_use]
    pub fn distance(&self, a: SkeletonPlace, b: SkeletonPlace) -> Metres {
        let direct = if a.edge == b.edge { (a.along - b.along).abs() } else { f32::INFINITY };
        if a.edge == b.edge && !self.edge(a.edge).has_shortcut {
            return Metres(direct);
        }
        let through = |way: &Crossing| {
            (a.along - way.leave.along).abs() + way.between + (b.along - way.enter.along).abs()
        };
        let round = self.crossings_between(a.edge, b.edge).iter().map(through);
        Metres(round.fold(direct, f32::min))
    }

    /// Whether one of two places lies on the shortest way from `from` to the other, so that the two
    /// have an order.
    #[must_use]
    pub fn in_line(&self, from: SkeletonPlace, a: SkeletonPlace, b: SkeletonPlace) -> bool {
        /// Rounding of a sum of lengths, m.
        const SLACK: f32 = 1e-3;
        let apart = (self.distance(from, a).0 - self.distance(from, b).0).abs();
        a.edge == b.edge && from.edge == a.edge || self.distance(a, b).0 <= apart + SLACK
    }

    fn crossings_between(&self, a: u16, b: u16) -> &[Crossing] {
        let at = usize::from(a) * self.edges.len() + usize::from(b);
        self.crossings.get(at).map_or(&[], Vec::as_slice)
    }

    fn hop(&self, from: usize, to: usize) -> Hop {
        self.hops[from * self.nodes.len() + to]
    }

    fn find_shortcuts(&mut self) {
        let shorter = |a: &Joint, b: &Joint| {
            self.hop(a.node, b.node).distance < (a.along - b.along).abs() - 1e-3
        };
        let of =
            |edge: &Edge| edge.joints.iter().any(|a| edge.joints.iter().any(|b| shorter(a, b)));
        let found: Vec<bool> = self.edges.iter().map(of).collect();
        for (edge, has_shortcut) in self.edges.iter_mut().zip(found) {
            edge.has_shortcut = has_shortcut;
        }
    }

    /// For every pair of edges the pairs of nodes through which a shortest way may lead: those
    /// that no other node of either edge lies between.
    fn all_crossings(&self) -> Vec<Vec<Crossing>> {
        let pairs = self.edges.iter().flat_map(|a| self.edges.iter().map(move |b| (a, b)));
        pairs.map(|(from, to)| self.crossings_of(from, to)).collect()
    }

    fn crossings_of(&self, from: &Edge, to: &Edge) -> Vec<Crossing> {
        let way = |a: &Joint, b: &Joint| self.hop(a.node, b.node).distance;
        let all = from.joints.iter().flat_map(|a| to.joints.iter().map(move |b| (a, b)));
        let needed = |(a, b): &(&Joint, &Joint)| {
            let leads_on = |c: &&Joint| {
                c.node != a.node && (a.along - c.along).abs() + way(c, b) <= way(a, b) + 1e-4
            };
            let leads_in = |c: &&Joint| {
                c.node != b.node && way(a, c) + (b.along - c.along).abs() <= way(a, b) + 1e-4
            };
            !from.joints.iter().any(|c| leads_on(&c)) && !to.joints.iter().any(|c| leads_in(&c))
        };
        all.filter(|(a, b)| way(a, b).is_finite())
            .filter(needed)
            .map(|(a, b)| Crossing { leave: *a, enter: *b, between: way(a, b) })
            .collect()
    }
}
