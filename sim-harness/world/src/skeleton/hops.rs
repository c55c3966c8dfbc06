//! Finds the shortest ways between all nodes of a skeleton.

use super::Edge;

/// One step of a shortest way between two nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hop {
    /// The length of the whole way, m; infinite where there is none.
    pub(super) distance: f32,
    /// The node at the end of this step.
    pub(super) to: usize,
    /// The edge that leads there.
    pub(super) edge: usize,
}

/// Floyd and Warshall's shortest ways between all nodes.
pub(super) fn shortest_hops(edges: &[Edge], count: usize) -> Vec<Hop> {
    let mut hops: Vec<Hop> = (0..count * count)
        .map(|pair| {
            let here = pair / count == pair % count;
            let distance = if here { 0.0 } else { f32::INFINITY };
            Hop { distance, to: pair % count, edge: 0 }
        })
        .collect();
    for (number, edge) in edges.iter().enumerate() {
        for a in &edge.joints {
            for b in &edge.joints {
                let distance = (a.along - b.along).abs();
                let hop = &mut hops[a.node * count + b.node];
                if distance < hop.distance {
                    *hop = Hop { distance, to: b.node, edge: number };
                }
            }
        }
    }
    for via in 0..count {
        for from in 0..count {
            let first = hops[from * count + via];
            for to in 0..count {
                let distance = first.distance + hops[via * count + to].distance;
                // Sums of the same lengths in another order are no shorter way.
                if distance < hops[from * count + to].distance - 1e-4 {
                    hops[from * count + to] = Hop { distance, ..first };
                }
            }
        }
    }
    hops
}
