//! Makes a tunnel of a route through a network of passages, with the galleries that lead away from
//! it.
//!
//! The route becomes the main gallery. A *side gallery* is a stretch between two nodes at which
//! more or fewer than two passages meet, or at which it leaves the route. How far from the route
//! passages are still dug is a number of the choice of a map: beyond it they end in a wall, so that a
//! mission in a large cave takes no more than one in a small one.

use std::collections::BTreeSet;

use units::Point2;
use world::layout::{LEAST_WIDTH, Passage};
use world::{Gallery, Knot, Polyline, Skeleton};

use super::corners::Corners;
use super::levels::{self, Levels, Place};
use super::spread::Spread;

/// The most that all side galleries have together, m. The nearest to the route are dug first.
const MOST_SIDE_M: f64 = 2_000.0;
/// The most side galleries: the ways between all pairs of galleries are kept.
const MOST_SIDES: usize = 150;
/// Nodes nearer to each other than this in plan are one, m.
const SAME: f64 = 0.05;

/// The middle of a passage at one of its stations, and half of its width there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Station {
    /// The place in the plan, m, in the axes of the map.
    pub(super) at: [f64; 2],
    /// Half of the width, m.
    pub(super) half_m: f32,
}

/// A network of passages that can be flown.
pub(super) trait Network {
    /// The nodes that a passage leads to from this one, with its length in metres.
    fn neighbours(&self, node: usize) -> Vec<(usize, f64)>;
    /// The place of a node, m.
    fn at(&self, node: usize) -> [f64; 3];
    /// Half of the width at each node of a way, m.
    fn halves(&self, way: &[usize]) -> Vec<f64>;
    /// The stations along a way; none are in the same place.
    fn plan(&self, way: &[usize]) -> Vec<Station>;
}

/// The distance of two places, m.
pub(super) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The shortest way between two nodes.
pub(super) fn way(network: &impl Network, from: usize, to: usize) -> Option<Vec<usize>> {
    Spread::from(&[from], f64::INFINITY, |node| network.neighbours(node)).way(to)
}

/// The longest way from a node without detours.
pub(super) fn farthest_from(network: &impl Network, from: usize) -> Vec<usize> {
    let spread = Spread::from(&[from], f64::INFINITY, |node| network.neighbours(node));
    spread.way(spread.farthest(from)).unwrap_or_default()
}

/// The length of a way, m.
pub(super) fn length(network: &impl Network, way: &[usize]) -> f64 {
    way.windows(2).map(|pair| between(network, pair[0], pair[1])).sum()
}

fn between(network: &impl Network, from: usize, to: usize) -> f64 {
    let passages = network.neighbours(from).into_iter().filter(|(node, _)| *node == to);
    passages.map(|(_, length)| length).fold(f64::INFINITY, f64::min)
}

/// The part of a way that is not longer than this, and whether it is a part.
pub(super) fn cut(network: &impl Network, mut way: Vec<usize>, longest: f64) -> (Vec<usize>, bool) {
    let (mut length, mut count) = (0.0, 1);
    for pair in way.windows(2) {
        length += between(network, pair[0], pair[1]);
        if length > longest {
            break;
        }
        count += 1;
    }
    let is_cut = count < way.len();
    way.truncate(count);
    (way, is_cut)
}

/// The galleries of a route and around it.
#[derive(Debug, Default)]
pub(super) struct Galleries {
    /// The galleries, the route first.
    pub(super) galleries: Vec<Gallery>,
    /// The passages of the galleries.
    pub(super) passages: Vec<Passage>,
    /// The knots on each gallery.
    pub(super) knots: Vec<Vec<Knot>>,
    /// The place of the map that is the origin of the floor plan: the beginning of the route.
    pub(super) origin: [f64; 2],
    /// How far each node of the route is along the line of the main gallery, m.
    pub(super) along: Vec<f32>,
    /// How many side galleries were left out because they pass above or below others.
    pub(super) above_or_below: usize,
}

impl Galleries {
    /// The galleries of a route, and those within `around_m` of it; none where the route is a point.
    pub(super) fn of(network: &impl Network, route: &[usize], around_m: f64) -> Self {
        let stations = network.plan(route);
        let mut found = Self { origin: network_origin(network, route), ..Self::default() };
        let line = found.line(&stations);
        if line.len() < 2 {
            return found;
        }
        let main = Polyline::new(line.clone());
        let mut corners = Corners::new(network, route, &main, found.origin);
        found.along = corners.along_route(route);
        let mut levels = Levels::new();
        let heights: Vec<_> = route.iter().map(|&node| network.at(node)).collect();
        levels.add(&heights, &found.halves(&stations, heights.len()));
        let sides = sides(network, route, around_m);
        let mut knots = vec![Knot { number: route[0], along: 0.0 }];
        if let Some(&last) = route.last() {
            knots.push(Knot { number: last, along: main.length() });
        }
        found.push(MAIN, &stations, line, Vec::new());
        let mut dug_m = 0.0;
        for side in sides {
            dug_m += length(network, &side);
            if found.galleries.len() > MOST_SIDES || dug_m > MOST_SIDE_M {
                break;
            }
            let heights: Vec<_> = side.iter().map(|&node| network.at(node)).collect();
            let planned = network.plan(&side);
            let halves = found.halves(&planned, heights.len());
            if levels.clash(&heights, &halves) || is_above_itself(network, &side) {
                found.above_or_below += 1;
                continue;
            }
            levels.add(&heights, &halves);
            found.side(&side, planned, &mut corners);
        }
        knots.extend(corners.on_route());
        knots.sort_by(|a, b| a.along.total_cmp(&b.along));
        found.knots[0] = knots;
        found
    }

    /// The skeleton.
    pub(super) fn skeleton(&self) -> Skeleton {
        Skeleton::knotted(&self.galleries, &self.knots)
    }

    /// Adds a side gallery.
    fn side(
        &mut self,
        side: &[usize],
        mut stations: Vec<Station>,
        corners: &mut Corners<'_, impl Network>,
    ) {
        let (Some(&first), Some(&last)) = (side.first(), side.last()) else { return };
        let half_m = stations.first().map_or(0.5 * LEAST_WIDTH, |station| station.half_m);
        let [from, to] = [first, last].map(|node| corners.place(node));
        if side.len() == 2 && distance(from, to) < SAME {
            corners.unite(first, last);
            return;
        }
        // Its ends are where the other galleries of its nodes end, and not in its own middle.
        let inner = side.len() > 2;
        let ends = [stations.first().copied(), stations.last().copied()];
        let end_half = |n: usize| ends[n].map_or(half_m, |station| station.half_m);
        if inner {
            stations.retain(|it| distance(it.at, from) > 0.3 && distance(it.at, to) > 0.3);
            if stations.first().map(|it| it.at) == ends[0].map(|it| it.at) {
                stations.remove(0);
            }
            if stations.last().map(|it| it.at) == ends[1].map(|it| it.at) {
                stations.pop();
            }
        } else {
            stations.clear();
        }
        stations.insert(0, Station { at: from, half_m: end_half(0) });
        if distance(from, to) > SAME || stations.len() > 1 {
            stations.push(Station { at: to, half_m: end_half(1) });
        }
        let line = self.line(&stations);
        if line.len() < 2 {
            return;
        }
        let length = Polyline::new(line.clone()).length();
        let knots = vec![
            Knot { number: corners.root(first), along: 0.0 },
            Knot { number: corners.root(last), along: length },
        ];
        corners.mention(first);
        corners.mention(last);
        let name = format!("side-{}", self.galleries.len());
        self.push(&name, &stations, line, knots);
    }

    fn push(&mut self, name: &str, stations: &[Station], line: Vec<Point2>, knots: Vec<Knot>) {
        let mut widths: Vec<f32> = stations.iter().map(|it| 2.0 * it.half_m).collect();
        widths.sort_by(f32::total_cmp);
        let width = widths.get(widths.len() / 2).copied().unwrap_or(LEAST_WIDTH);
        self.galleries.push(Gallery { name: name.to_owned(), centre_line: line, width });
        let point = |it: &Station| (self.point(it.at), it.half_m);
        self.passages.push(Passage { stations: stations.iter().map(point).collect() });
        self.knots.push(knots);
    }

    /// The points of a centre-line, no two successive ones of which are the same.
    fn line(&self, stations: &[Station]) -> Vec<Point2> {
        let mut line: Vec<Point2> = stations.iter().map(|it| self.point(it.at)).collect();
        line.dedup_by(|a, b| a.distance(*b).0 < 1e-3);
        line
    }

    fn point(&self, at: [f64; 2]) -> Point2 {
        Point2::new((at[0] - self.origin[0]) as f32, (at[1] - self.origin[1]) as f32)
    }

    /// Half widths for so many places: the widest of the stations for each.
    fn halves(&self, stations: &[Station], count: usize) -> Vec<f64> {
        let widest = stations.iter().map(|it| f64::from(it.half_m)).fold(0.0, f64::max);
        vec![widest; count]
    }
}

/// Whether a way passes above or below itself.
fn is_above_itself(network: &impl Network, way: &[usize]) -> bool {
    let halves = network.halves(way);
    let places = way.iter().zip(halves).map(|(&node, half)| Place { at: network.at(node), half });
    levels::beginning(&places.collect::<Vec<_>>()).overlap.is_some()
}

/// The name of the main gallery.
const MAIN: &str = "main";

fn network_origin(network: &impl Network, route: &[usize]) -> [f64; 2] {
    route.first().map_or([0.0; 2], |&node| {
        let [x, y, _] = network.at(node);
        [x, y]
    })
}

/// The side galleries within this distance of a route, the nearest first.
fn sides(network: &impl Network, route: &[usize], around_m: f64) -> Vec<Vec<usize>> {
    if around_m <= 0.0 {
        return Vec::new();
    }
    let spread = Spread::from(route, around_m, |node| network.neighbours(node));
    let on_route: BTreeSet<usize> = route.iter().copied().collect();
    let flown: BTreeSet<[usize; 2]> =
        route.windows(2).flat_map(|pair| [[pair[0], pair[1]], [pair[1], pair[0]]]).collect();
    let next = |node: usize| {
        let reached = network.neighbours(node).into_iter().map(|(to, _)| to);
        let reached = reached.filter(|to| spread.reaches(*to) && !flown.contains(&[node, *to]));
        reached.collect::<BTreeSet<usize>>()
    };
    let is_end = |node: usize| on_route.contains(&node) || next(node).len() != 2;
    let mut seen: BTreeSet<[usize; 2]> = BTreeSet::new();
    let mut found = Vec::new();
    for &start in spread.order.iter().filter(|node| is_end(**node)) {
        for first in next(start) {
            if seen.contains(&[start, first]) {
                continue;
            }
            let mut side = vec![start, first];
            let (mut before, mut node) = (start, first);
            while !is_end(node) {
                let Some(on) = next(node).into_iter().find(|on| *on != before) else { break };
                side.push(on);
                (before, node) = (node, on);
            }
            for pair in side.windows(2) {
                seen.insert([pair[0], pair[1]]);
                seen.insert([pair[1], pair[0]]);
            }
            found.extend(opened(side));
        }
    }
    found
}

/// A side gallery that ends where it began, as two.
fn opened(side: Vec<usize>) -> Vec<Vec<usize>> {
    let is_loop = side.first() == side.last();
    match side.len() {
        // There and back on two legs between the same nodes is one way.
        0..4 if is_loop => Vec::new(),
        count if is_loop => vec![side[..=count / 2].to_vec(), side[count / 2..].to_vec()],
        _ => vec![side],
    }
}
