//! Finds the loops of a network and by how much they fail to close.
//!
//! A tree of legs from each fixed point reaches every other point, by as few legs as possible; each
//! leg beside the tree closes one loop. Fixed points are taken for joined to each other, so that a
//! traverse from one to another counts as a loop here, though `cavern` does not count it.

use std::collections::VecDeque;

use crate::adjust::Network;
use crate::matrix::{self, Vector};
use crate::survey::Misclosure;

/// The loop that closes worst.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Worst {
    error: f64,
    length: f64,
    point: usize,
}

impl Worst {
    /// The loop, with the name of the station at which it closes.
    pub(crate) fn named(self, name: impl Fn(usize) -> String) -> Misclosure {
        Misclosure { error: self.error, length: self.length, station: name(self.point) }
    }
}

/// A point's place in the tree.
#[derive(Clone, Copy)]
struct Twig {
    at: Vector,
    parent: usize,
    depth: u32,
    /// The length of the way from the root, m.
    way: f64,
}

/// Finds the loop that closes worst.
pub(crate) fn worst(network: &Network) -> Option<Worst> {
    let count = network.at.len();
    let mut twigs: Vec<Option<Twig>> = vec![None; count];
    let mut in_tree = vec![false; network.links.len()];
    let mut queue: VecDeque<usize> = VecDeque::new();
    for (point, fixed) in network.fixed.iter().enumerate() {
        if let Some(at) = *fixed {
            twigs[point] = Some(Twig { at, parent: point, depth: 0, way: 0.0 });
            queue.push_back(point);
        }
    }
    while let Some(point) = queue.pop_front() {
        let Some(twig) = twigs[point] else { continue };
        for &number in &network.at[point] {
            let link = &network.links[number];
            let other = link.other(point);
            if twigs[other].is_some() {
                continue;
            }
            in_tree[number] = true;
            let sign = if link.ends[0] == point { 1.0 } else { -1.0 };
            twigs[other] = Some(Twig {
                at: matrix::add(twig.at, matrix::scaled(link.vector, sign)),
                parent: point,
                depth: twig.depth + 1,
                way: twig.way + link.length.abs(),
            });
            queue.push_back(other);
        }
    }
    let mut worst: Option<Worst> = None;
    for (link, _) in network.links.iter().zip(&in_tree).filter(|(_, in_tree)| !**in_tree) {
        let [Some(a), Some(b)] = link.ends.map(|end| twigs[end]) else { continue };
        let error = matrix::norm(matrix::sub(matrix::add(a.at, link.vector), b.at));
        if worst.is_none_or(|worst| error > worst.error) {
            let shared = common_way(&twigs, link.ends);
            let length = a.way + b.way - 2.0 * shared + link.length.abs();
            worst = Some(Worst { error, length, point: link.ends[1] });
        }
    }
    worst
}

/// The length that the ways from the root to two points share.
fn common_way(twigs: &[Option<Twig>], [mut a, mut b]: [usize; 2]) -> f64 {
    while a != b {
        let (Some(twig_a), Some(twig_b)) = (twigs[a], twigs[b]) else { return 0.0 };
        if twig_a.depth == 0 && twig_b.depth == 0 {
            return 0.0;
        }
        if twig_a.depth >= twig_b.depth {
            a = twig_a.parent;
        } else {
            b = twig_b.parent;
        }
    }
    twigs[a].map_or(0.0, |twig| twig.way)
}
