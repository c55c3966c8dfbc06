//! Finds shortest ways in graphs of nodes that are numbers.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

/// A distance that can be ordered, m.
#[derive(Clone, Copy, PartialEq)]
struct Distance(f64);

impl Eq for Distance {}

impl PartialOrd for Distance {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Distance {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Shortest ways from one node, or from the nearest of several.
pub(super) struct Spread {
    /// The distance of each node that is reached, and the node before it.
    reached: HashMap<usize, (f64, usize)>,
    /// The nodes in the order of their distances.
    pub(super) order: Vec<usize>,
}

impl Spread {
    /// Dijkstra's shortest ways from the nodes `starts`, no farther than `most`, over the
    /// neighbours that `next` gives with their distances.
    pub(super) fn from<I: IntoIterator<Item = (usize, f64)>>(
        starts: &[usize],
        most: f64,
        next: impl Fn(usize) -> I,
    ) -> Self {
        let mut spread = Self { reached: HashMap::new(), order: Vec::new() };
        let starts = starts.iter().map(|&start| Reverse((Distance(0.0), start, start)));
        let mut queue: BinaryHeap<_> = starts.collect();
        while let Some(Reverse((distance, node, before))) = queue.pop() {
            if spread.reached.contains_key(&node) {
                continue;
            }
            spread.reached.insert(node, (distance.0, before));
            spread.order.push(node);
            for (to, length) in next(node) {
                let distance = distance.0 + length;
                if distance <= most && !spread.reached.contains_key(&to) {
                    queue.push(Reverse((Distance(distance), to, node)));
                }
            }
        }
        spread
    }

    /// Whether the node is reached.
    pub(super) fn reaches(&self, node: usize) -> bool {
        self.reached.contains_key(&node)
    }

    /// The distance of a node, m; 0 for one that is not reached.
    pub(super) fn distance(&self, to: usize) -> f64 {
        self.reached.get(&to).map_or(0.0, |(distance, _)| *distance)
    }

    /// The node that is farthest away; of several, the one reached first.
    pub(super) fn farthest(&self, from: usize) -> usize {
        let longer = |best: usize, &node: &usize| {
            if self.distance(node) > self.distance(best) { node } else { best }
        };
        self.order.iter().fold(from, longer)
    }

    /// The nodes of the way to one.
    pub(super) fn way(&self, to: usize) -> Option<Vec<usize>> {
        let mut way = vec![to];
        let mut node = to;
        loop {
            let (_, before) = *self.reached.get(&node)?;
            if before == node {
                way.reverse();
                return Some(way);
            }
            way.push(before);
            node = before;
        }
    }
}
