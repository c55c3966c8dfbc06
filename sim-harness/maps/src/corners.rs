//! Places the nodes of a network in the plan: those of the route on its line, the others where they are.

use std::collections::{BTreeMap, BTreeSet};

use units::Point2;
use world::{Knot, Polyline};

use super::network::Network;

/// The places of nodes in the plan.
pub(super) struct Corners<'a, N> {
    network: &'a N,
    /// The places of the nodes of the route, along it.
    along: BTreeMap<usize, f32>,
    main: &'a Polyline,
    origin: [f64; 2],
    /// Nodes that are one with another.
    united: BTreeMap<usize, usize>,
    mentioned: BTreeSet<usize>,
}

impl<'a, N: Network> Corners<'a, N> {
    pub(super) fn new(
        network: &'a N,
        route: &[usize],
        main: &'a Polyline,
        origin: [f64; 2],
    ) -> Self {
        let mut along = BTreeMap::new();
        let mut last = 0.0;
        for &node in route {
            let [x, y, _] = network.at(node);
            let point = Point2::new((x - origin[0]) as f32, (y - origin[1]) as f32);
            last = main.nearest_from(point, last);
            along.insert(node, last);
        }
        if let (Some(&first), Some(&end)) = (route.first(), route.last()) {
            along.insert(end, main.length());
            along.insert(first, 0.0);
        }
        let (united, mentioned) = (BTreeMap::new(), BTreeSet::new());
        Self { network, along, main, origin, united, mentioned }
    }

    /// How far each node of the route is along its line, m.
    pub(super) fn along_route(&self, route: &[usize]) -> Vec<f32> {
        route.iter().map(|node| self.along.get(node).copied().unwrap_or(0.0)).collect()
    }

    pub(super) fn root(&self, node: usize) -> usize {
        let mut root = node;
        while let Some(&other) = self.united.get(&root) {
            root = other;
        }
        root
    }

    pub(super) fn unite(&mut self, one: usize, other: usize) {
        let [a, b] = [self.root(one), self.root(other)];
        if a == b {
            return;
        }
        // A node of the route keeps its place on it.
        let [kept, gone] = if self.along.contains_key(&b) { [b, a] } else { [a, b] };
        if !self.along.contains_key(&gone) {
            self.united.insert(gone, kept);
        }
    }

    pub(super) fn mention(&mut self, node: usize) {
        self.mentioned.insert(self.root(node));
    }

    /// The place of a node, in the axes of the map.
    pub(super) fn place(&self, node: usize) -> [f64; 2] {
        let node = self.root(node);
        match self.along.get(&node) {
            Some(&along) => {
                let Point2 { x, y } = self.main.at(along).0;
                [f64::from(x) + self.origin[0], f64::from(y) + self.origin[1]]
            }
            None => {
                let [x, y, _] = self.network.at(node);
                [x, y]
            }
        }
    }

    /// The knots on the route at which side galleries begin, but for its ends.
    pub(super) fn on_route(&self) -> Vec<Knot> {
        let inner = |along: f32| along > 0.0 && along < self.main.length();
        let mentioned = self
            .along
            .iter()
            .filter(|(node, along)| self.mentioned.contains(node) && inner(**along));
        mentioned.map(|(&number, &along)| Knot { number, along }).collect()
    }
}
