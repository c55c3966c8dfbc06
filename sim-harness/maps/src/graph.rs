//! The graph of a survey: which legs can be flown, and ways along them.

use std::collections::{HashMap, HashSet};

use cave_survey::{StationId, Survey, Vector};
use world::layout::LEAST_WIDTH;

use super::hindrance::{Hindrance, HindranceKind};
use super::network::{Network, Station};
use super::plan::{middles, plan};
use super::spread::Spread;
use super::widths::{Sides, Widths};
use super::{RouteError, named};

/// The lowest passage, m: the flying height, and the distance to a wall that counts as dangerous.
const LOWEST: f64 = 0.5;

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
                Some(_) if leg.flags.dived => Some(HindranceKind::Water),
                Some(_) => hindrance(vector, &widths, [from, to], leg.flags.squeeze),
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

    /// The place of a node, m.
    pub(super) fn position(&self, node: usize) -> Vector {
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
        let reached = self.reached(from);
        let hindered = way.windows(2).filter_map(|pair| self.hindered(pair[0], pair[1], &reached));
        Err(RouteError::Hindered(begin, end, hindered.collect()))
    }

    /// What hinders the easiest leg from one node to another, where drones come to `reached`.
    fn hindered(&self, from: usize, to: usize, reached: &[bool]) -> Option<Hindrance> {
        let mut kinds = self.edges[from].iter().filter(|it| it.to == to).map(|it| it.hindrance);
        let first = kinds.next()?;
        if kinds.any(|kind| kind.is_none()) {
            return None;
        }
        let beyond_m = self.beyond(to, reached);
        first.map(|kind| Hindrance { from: self.name(from), to: self.name(to), kind, beyond_m })
    }

    /// Which nodes can be flown to from one.
    fn reached(&self, from: usize) -> Vec<bool> {
        let mut reached = vec![false; self.nodes.len()];
        for node in self.spread(from, |edge| edge.hindrance.is_none()).order {
            reached[node] = true;
        }
        reached
    }

    /// The length of the legs that lead on from a node that is not `reached`, m.
    fn beyond(&self, node: usize, reached: &[bool]) -> f64 {
        let mut seen = reached.to_vec();
        let (mut open, mut doubled) = (vec![node], 0.0);
        if std::mem::replace(&mut seen[node], true) {
            return 0.0;
        }
        while let Some(node) = open.pop() {
            for edge in self.edges[node].iter().filter(|edge| !reached[edge.to]) {
                doubled += edge.length;
                if !std::mem::replace(&mut seen[edge.to], true) {
                    open.push(edge.to);
                }
            }
        }
        // Each leg was met from both of its ends.
        0.5 * doubled
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
        let height = |node: Option<&usize>| node.map_or(0.0, |&node| self.position(node)[2]);
        let is_lower = height(best.first()) < height(best.last());
        if last < first || (last == first && is_lower) {
            best.reverse();
        }
        best
    }

    /// The distance to the nearest entrance as the crow flies; infinite where none is marked.
    fn distance_to_entrance(&self, node: usize) -> f64 {
        let here = self.position(node);
        let entrances = self.survey.stations.iter().filter(|station| station.is_entrance);
        let away = |there: Vector| {
            cave_survey::norm([here[0] - there[0], here[1] - there[1], here[2] - there[2]])
        };
        entrances.map(|station| away(station.position)).fold(f64::INFINITY, f64::min)
    }

    /// The hindrances of legs that begin at stations of the route, those with the most beyond first; those
    /// of the whole cave where there is no route.
    pub(super) fn hindrances_beside(&self, route: &[usize]) -> Vec<Hindrance> {
        let all: Vec<usize> = (0..self.nodes.len()).collect();
        let (nodes, mut reached) = match route.first() {
            Some(&first) => (route, self.reached(first)),
            None => (&*all, vec![false; self.nodes.len()]),
        };
        let mut met = HashSet::new();
        let mut found = Vec::new();
        for &node in nodes {
            let was_reached = std::mem::replace(&mut reached[node], true);
            for to in self.edges[node].iter().map(|edge| edge.to) {
                if !route.contains(&to) && met.insert([node.min(to), node.max(to)]) {
                    found.extend(self.hindered(node, to, &reached));
                }
            }
            reached[node] = was_reached;
        }
        // Of a cave that cannot be flown at all, the first legs of the survey tell the most.
        if !route.is_empty() {
            found.sort_by(|a, b| b.beyond_m.total_cmp(&a.beyond_m));
        }
        found
    }

    /// The shortest ways from a node along the edges that are `allowed`.
    fn spread(&self, from: usize, allowed: impl Fn(&Edge) -> bool) -> Spread {
        let next = |node: usize| {
            let edges = self.edges[node].iter().filter(|edge| allowed(edge));
            edges.map(|edge| (edge.to, edge.length)).collect::<Vec<_>>()
        };
        Spread::from(&[from], f64::INFINITY, next)
    }
}

impl Network for Graph<'_> {
    fn neighbours(&self, node: usize) -> Vec<(usize, f64)> {
        let flown = self.edges[node].iter().filter(|edge| edge.hindrance.is_none());
        flown.map(|edge| (edge.to, edge.length)).collect()
    }

    fn at(&self, node: usize) -> Vector {
        self.position(node)
    }

    fn halves(&self, way: &[usize]) -> Vec<f64> {
        middles(self, way).iter().map(|(station, _)| f64::from(station.half_m)).collect()
    }

    fn plan(&self, way: &[usize]) -> Vec<Station> {
        plan(self, way).0
    }
}

/// What keeps a drone from flying along a vector, whose ends are these nodes.
fn hindrance(
    vector: Vector,
    widths: &Widths,
    ends: [usize; 2],
    is_squeeze: bool,
) -> Option<HindranceKind> {
    let flat = vector[0].hypot(vector[1]);
    let slope_deg = vector[2].abs().atan2(flat).to_degrees();
    if let Some(kind) = HindranceKind::of_rise(slope_deg, vector[2].abs()) {
        return Some(kind);
    }
    let direction = if flat > 0.0 { [vector[0] / flat, vector[1] / flat] } else { [0.0, 1.0] };
    let sides = ends.map(|end| widths.at(end, direction));
    let narrowest = sides.iter().map(|it| it.left + it.right).fold(f64::INFINITY, f64::min);
    if narrowest < f64::from(LEAST_WIDTH) {
        return Some(HindranceKind::Squeeze { width_m: narrowest });
    }
    if is_squeeze && sides.iter().any(|it| it.is_assumed) {
        return Some(HindranceKind::NamedSqueeze);
    }
    let lowest = sides.iter().filter_map(|it| it.height).fold(f64::INFINITY, f64::min);
    (lowest < LOWEST).then_some(HindranceKind::Low { height_m: lowest })
}
