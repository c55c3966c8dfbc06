//! The graph of a survey: which legs can be flown, and ways along them.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::fmt;

use cave_survey::{StationId, Survey, Vector};

use super::widths::{Sides, Widths};
use super::{RouteError, named};
use crate::world::layout::LEAST_WIDTH;

/// The steepest leg that is flown, degrees from the horizontal.
///
/// A drone flies 0.3 m above the floor (`AgentConfig::DEFAULT`), and takes for a wall what its
/// beams, at 45° to its course, meet within 0.45 m (`Steering`'s `slow_below`): a floor that rises
/// by more than 0.3 m on 0.45 m · cos 45°.
pub const STEEPEST_DEG: f64 = 43.3;

/// The height of a step that is climbed at any slope, m: that at which drones fly.
const STEP: f64 = 0.3;

/// The lowest passage, m: the flying height, and the distance to a wall that counts as dangerous.
const LOWEST: f64 = 0.5;

/// What keeps a drone from flying along a leg.
#[derive(Clone, Debug, PartialEq)]
pub struct Hindrance {
    /// The name of the leg's first station.
    pub from: String,
    /// The name of the leg's second station.
    pub to: String,
    /// The reason.
    pub kind: HindranceKind,
}

/// The reason why a leg cannot be flown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HindranceKind {
    /// It is too steep.
    Shaft {
        /// The angle from the horizontal, degrees.
        slope_deg: f64,
        /// The difference in height, m.
        height_m: f64,
    },
    /// The passage is too narrow.
    Squeeze {
        /// The width, m.
        width_m: f64,
    },
    /// The passage is too low.
    Low {
        /// The height from floor to ceiling, m.
        height_m: f64,
    },
    /// Nothing was measured along it.
    Unmeasured,
}

impl fmt::Display for Hindrance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { from, to, kind } = self;
        match kind {
            HindranceKind::Shaft { slope_deg, height_m } => {
                write!(f, "{from} to {to} is a shaft of {height_m:.1} m at {slope_deg:.0}°")
            }
            HindranceKind::Squeeze { width_m } => {
                write!(f, "{from} to {to} is a squeeze of {width_m:.2} m")
            }
            HindranceKind::Low { height_m } => {
                write!(f, "{from} to {to} is only {height_m:.2} m high")
            }
            HindranceKind::Unmeasured => write!(f, "{from} to {to} was never measured"),
        }
    }
}

/// A leg as seen from one of its nodes.
#[derive(Clone, Copy, Debug)]
struct Edge {
    to: usize,
    length: f64,
    hindrance: Option<HindranceKind>,
}

/// The graph.
pub(super) struct Graph<'a> {
    survey: &'a Survey,
    nodes: Vec<Vec<StationId>>,
    of_point: HashMap<usize, usize>,
    edges: Vec<Vec<Edge>>,
    widths: Widths,
}

impl<'a> Graph<'a> {
    /// The graph of the legs under ground.
    pub(super) fn of(survey: &'a Survey) -> Self {
        let mut nodes: Vec<Vec<StationId>> = Vec::new();
        let mut of_point = HashMap::new();
        for (id, station) in survey.stations.iter().enumerate() {
            let node = *of_point.entry(station.point).or_insert_with(|| {
                nodes.push(Vec::new());
                nodes.len() - 1
            });
            nodes[node].push(id);
        }
        let node = |id: StationId| of_point[&survey.stations[id].point];
        let widths = Widths::of(survey, nodes.len(), node);
        let mut edges = vec![Vec::new(); nodes.len()];
        for leg in survey.legs.iter().filter(|leg| !leg.flags.splay && !leg.flags.surface) {
            let (from, to) = (node(leg.from), node(leg.to));
            let vector = survey.vector(leg);
            let length = cave_survey::norm(vector);
            let hindrance = match leg.length {
                None => Some(HindranceKind::Unmeasured),
                Some(_) => hindrance(vector, &widths, [from, to]),
            };
            edges[from].push(Edge { to, length, hindrance });
            edges[to].push(Edge { to: from, length, hindrance });
        }
        Self { survey, nodes, of_point, edges, widths }
    }

    /// The node of a station, if a leg leads to it.
    pub(super) fn node_of(&self, station: StationId) -> Option<usize> {
        let node = *self.of_point.get(&self.survey.stations[station].point)?;
        (!self.edges[node].is_empty()).then_some(node)
    }

    pub(super) fn name(&self, node: usize) -> String {
        named(self.survey, &self.nodes[node])
    }

    pub(super) fn at(&self, node: usize) -> Vector {
        self.nodes[node].first().map_or([0.0; 3], |&id| self.survey.stations[id].position)
    }

    /// The sides of the passage at a node, seen along a horizontal direction.
    pub(super) fn sides(&self, node: usize, direction: [f64; 2]) -> Sides {
        self.widths.at(node, direction)
    }

    /// The shortest way between two nodes that can be flown.
    pub(super) fn way(&self, from: usize, to: usize) -> Result<Vec<usize>, RouteError> {
        let flown = self.spread(from, |edge| edge.hindrance.is_none());
        if let Some(way) = flown.way(to) {
            return Ok(way);
        }
        let (begin, end) = (self.name(from), self.name(to));
        let Some(way) = self.spread(from, |_| true).way(to) else {
            return Err(RouteError::Apart(begin, end));
        };
        let hindered = way.windows(2).filter_map(|pair| self.hindered(pair[0], pair[1]));
        Err(RouteError::Hindered(begin, end, hindered.collect()))
    }

    /// What hinders the easiest leg from one node to another.
    fn hindered(&self, from: usize, to: usize) -> Option<Hindrance> {
        let mut kinds = self.edges[from].iter().filter(|it| it.to == to).map(|it| it.hindrance);
        let first = kinds.next()?;
        if kinds.any(|kind| kind.is_none()) {
            return None;
        }
        first.map(|kind| Hindrance { from: self.name(from), to: self.name(to), kind })
    }

    /// The longest way from a node that can be flown without detours.
    pub(super) fn farthest_from(&self, from: usize) -> Vec<usize> {
        let spread = self.spread(from, |edge| edge.hindrance.is_none());
        spread.way(spread.farthest(from)).unwrap_or_default()
    }

    /// The longest way of the cave that can be flown without detours: exactly in passages without
    /// loops, and nearly so with them.
    pub(super) fn longest(&self) -> Vec<usize> {
        let mut seen = vec![false; self.nodes.len()];
        let (mut best, mut longest) = (Vec::new(), 0.0);
        for start in 0..self.nodes.len() {
            if seen[start] || self.edges[start].is_empty() {
                continue;
            }
            let spread = self.spread(start, |edge| edge.hindrance.is_none());
            for &node in &spread.order {
                seen[node] = true;
            }
            let end = spread.farthest(start);
            let back = self.spread(end, |edge| edge.hindrance.is_none());
            let other = back.farthest(end);
            if back.distance(other) > longest {
                longest = back.distance(other);
                best = back.way(other).unwrap_or_default();
            }
        }
        let distance = |node: Option<&usize>| {
            node.map_or(f64::INFINITY, |&node| self.distance_to_entrance(node))
        };
        let (first, last) = (distance(best.first()), distance(best.last()));
        let height = |node: Option<&usize>| node.map_or(0.0, |&node| self.at(node)[2]);
        let is_lower = height(best.first()) < height(best.last());
        if last < first || (last == first && is_lower) {
            best.reverse();
        }
        best
    }

    /// The distance to the nearest entrance as the crow flies; infinite where none is marked.
    fn distance_to_entrance(&self, node: usize) -> f64 {
        let here = self.at(node);
        let entrances = self.survey.stations.iter().filter(|station| station.is_entrance);
        let away = |there: Vector| {
            cave_survey::norm([here[0] - there[0], here[1] - there[1], here[2] - there[2]])
        };
        entrances.map(|station| away(station.position)).fold(f64::INFINITY, f64::min)
    }

    /// The length of a way, m.
    pub(super) fn length(&self, way: &[usize]) -> f64 {
        way.windows(2).map(|pair| self.between(pair[0], pair[1])).sum()
    }

    fn between(&self, from: usize, to: usize) -> f64 {
        let legs = self.edges[from].iter().filter(|edge| edge.to == to);
        legs.map(|edge| edge.length).fold(f64::INFINITY, f64::min)
    }

    /// The part of a way that is not longer than this, and whether it is a part.
    pub(super) fn cut(&self, mut way: Vec<usize>, longest: f32) -> (Vec<usize>, bool) {
        let (mut length, mut count) = (0.0, 1);
        for pair in way.windows(2) {
            length += self.between(pair[0], pair[1]);
            if length > f64::from(longest) {
                break;
            }
            count += 1;
        }
        let is_cut = count < way.len();
        way.truncate(count);
        (way, is_cut)
    }

    /// The hindrances of legs that begin at stations of the route.
    pub(super) fn hindrances_beside(&self, route: &[usize]) -> Vec<Hindrance> {
        let at = |&node: &usize| {
            let edges = self.edges[node].iter().filter(|edge| !route.contains(&edge.to));
            edges.filter_map(move |edge| {
                let (from, to) = (self.name(node), self.name(edge.to));
                edge.hindrance.map(|kind| Hindrance { from, to, kind })
            })
        };
        route.iter().flat_map(at).collect()
    }

    /// Dijkstra's shortest ways from a node along the edges that are `allowed`.
    fn spread(&self, from: usize, allowed: impl Fn(&Edge) -> bool) -> Spread {
        let mut spread = Spread { reached: HashMap::new(), order: Vec::new() };
        let mut queue = BinaryHeap::from([Reverse((Distance(0.0), from, from))]);
        while let Some(Reverse((distance, node, before))) = queue.pop() {
            if spread.reached.contains_key(&node) {
                continue;
            }
            spread.reached.insert(node, (distance.0, before));
            spread.order.push(node);
            for edge in self.edges[node].iter().filter(|edge| allowed(edge)) {
                queue.push(Reverse((Distance(distance.0 + edge.length), edge.to, node)));
            }
        }
        spread
    }
}

/// What keeps a drone from flying along a vector, whose ends are these nodes.
fn hindrance(vector: Vector, widths: &Widths, ends: [usize; 2]) -> Option<HindranceKind> {
    let flat = vector[0].hypot(vector[1]);
    let slope_deg = vector[2].abs().atan2(flat).to_degrees();
    if slope_deg > STEEPEST_DEG && vector[2].abs() > STEP {
        return Some(HindranceKind::Shaft { slope_deg, height_m: vector[2].abs() });
    }
    let direction = if flat > 0.0 { [vector[0] / flat, vector[1] / flat] } else { [0.0, 1.0] };
    let sides = ends.map(|end| widths.at(end, direction));
    let narrowest = sides.iter().map(|it| it.left + it.right).fold(f64::INFINITY, f64::min);
    if narrowest < f64::from(LEAST_WIDTH) {
        return Some(HindranceKind::Squeeze { width_m: narrowest });
    }
    let lowest = sides.iter().filter_map(|it| it.height).fold(f64::INFINITY, f64::min);
    (lowest < LOWEST).then_some(HindranceKind::Low { height_m: lowest })
}

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

/// Shortest ways from one node.
struct Spread {
    /// The distance of each node that is reached, and the node before it.
    reached: HashMap<usize, (f64, usize)>,
    /// The nodes in the order of their distances.
    order: Vec<usize>,
}

impl Spread {
    fn distance(&self, to: usize) -> f64 {
        self.reached.get(&to).map_or(0.0, |(distance, _)| *distance)
    }

    /// The node that is farthest away; of several, the one reached first.
    fn farthest(&self, from: usize) -> usize {
        let longer = |best: usize, &node: &usize| {
            if self.distance(node) > self.distance(best) { node } else { best }
        };
        self.order.iter().fold(from, longer)
    }

    fn way(&self, to: usize) -> Option<Vec<usize>> {
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
