//! Makes a skeleton of galleries whose junctions are known and need not be found in the plan.

use std::collections::BTreeMap;

use super::{Edge, Gallery, Joint, Node, NodeKind, Polyline, Skeleton};

/// A place of a gallery that it shares with others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// The number of the place, which is the same on all galleries that meet there.
    pub number: usize,
    /// The length along the gallery, m.
    pub along: f32,
}

impl Skeleton {
    /// The skeleton of these galleries, each with its knots in the order of their lengths. The first
    /// gallery is the main one; its first knot is the mouth.
    #[must_use]
    pub fn knotted(galleries: &[Gallery], knots: &[Vec<Knot>]) -> Self {
        let mut nodes = Vec::new();
        let mut numbers: BTreeMap<usize, usize> = BTreeMap::new();
        let mut edges: Vec<Edge> = Vec::new();
        for (gallery, knots) in galleries.iter().zip(knots) {
            let line = Polyline::new(gallery.centre_line.clone());
            let mut joints = Vec::new();
            for knot in knots {
                let is_inner = knot.along > 0.0 && knot.along < line.length();
                let kind = match nodes.is_empty() {
                    true => NodeKind::Mouth,
                    false if is_inner => NodeKind::Junction,
                    false => NodeKind::End,
                };
                let node = *numbers.entry(knot.number).or_insert_with(|| {
                    nodes.push(Node { at: line.at(knot.along).0, kind });
                    nodes.len() - 1
                });
                if nodes[node].kind == NodeKind::End && !edges.is_empty() {
                    let is_shared =
                        edges.iter().any(|edge| edge.joints.iter().any(|it| it.node == node));
                    if is_shared {
                        nodes[node].kind = NodeKind::Junction;
                    }
                }
                joints.push(Joint { node, along: knot.along });
            }
            edges.push(Edge {
                name: gallery.name.clone(),
                line,
                width: gallery.width,
                joints,
                has_shortcut: false,
            });
        }
        Self::finished(edges, nodes)
    }
}
