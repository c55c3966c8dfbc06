//! The floor plan and the network of an occupancy map.
//!
//! The free space is the free cells that are joined side by side, without specks: what stands in it
//! and is smaller than a drone is noise of the laser that made the map, and so are the streaks and
//! notches into which no drone fits: they are walls, as unknown cells are. Its outlines are the edges
//! of its cells, simplified within half a cell. Its network is the medial axis: the free space thinned
//! to lines of one cell, without the spurs to its corners, with the distance to the nearest wall as
//! half of the width. Where that leaves no way, as in a square hall, or ends far from a place that was
//! asked for, lines lead to the ends, too. What is narrower than the narrowest passage that a drone
//! flies through is left out of the network.

mod distance;
mod mask;
mod outline;
mod thin;

use robot_maps::{Cell, Occupancy};
use units::Point2;
use world::layout::{FARTHEST, LEAST_WIDTH};
use world::{GeometryError, Tunnel};

use super::network::{self, Galleries, Network, Station};
use super::{Ends, LONGEST_ROUTE, Route, RouteEnd, RouteError, SHORTEST_ROUTE};
use mask::Mask;

/// Half of the widest passage that counts, m, as in a survey.
const WIDEST_HALF_M: f32 = 8.0;
/// The stretch at an end of a route on which drones stand before they take off, m.
const START_M: f64 = 2.0;
/// Half of a drone's width with its guards, m, as in `VehicleSpec`.
const DRONE_RADIUS_M: f32 = 0.08;
/// An end of a route is no farther from where a drone can fly than this, m.
const NEAR_M: f64 = 1.0;
/// A centre-line deviates from the medial axis by no more than this, m, or by a cell.
const SMOOTH_M: f64 = 0.1;

/// Which lines of the medial axis belong to a network.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Axis {
    /// Those that are no spurs into corners: of a square or round hall that is hardly more than its
    /// middle.
    Pruned,
    /// Those, and lines to the ends that were asked for, or in their place to cells far away.
    ToEnds,
}

/// The free space of a map around one of its points.
struct Grid<'a> {
    map: &'a Occupancy,
    free: Mask,
    /// The part of it that is wide enough.
    flown: Mask,
    /// The cells of the medial axis.
    nodes: Vec<usize>,
    /// The neighbours of each node, with their distances in metres.
    edges: Vec<Vec<(usize, f64)>>,
    /// The distance from each node to the nearest wall, m.
    halves: Vec<f32>,
}

impl<'a> Grid<'a> {
    /// Makes the network of the free space in which the first of these places lies, or of the largest
    /// one; `None` where there is none. The network reaches these places where `axis` says so.
    fn of(map: &'a Occupancy, places: &[[f64; 2]], axis: Axis) -> Option<Self> {
        let cells = |metres: f32| metres / map.resolution_m as f32;
        let free = Mask::free(map);
        let squares = distance::squares(&free);
        let flown = free.opened(&squares, cells(0.5 * LEAST_WIDTH));
        let free = free.opened(&squares, cells(DRONE_RADIUS_M));
        let near = |mask: &Mask, place| mask.nearest(map.grid(place), NEAR_M / map.resolution_m);
        let inside = match places.first() {
            Some(&place) => near(&flown, place)?,
            None => flown.in_largest()?,
        };
        let (flown, free) = (flown.around(inside), free.around(inside));
        let squares = distance::squares(&free);
        let radius = |cell: usize| squares[cell].sqrt();
        let ends = match axis {
            Axis::Pruned => Vec::new(),
            Axis::ToEnds => {
                let given: Vec<_> =
                    places.iter().filter_map(|&place| near(&flown, place)).collect();
                let is_roomy = |cell: usize| radius(cell) >= cells(0.5 * LEAST_WIDTH);
                flown.with_far_ends(given, inside, is_roomy)
            }
        };
        let (nodes, edges) = thin::medial_axis(&flown, radius, &ends);
        let metres = |cell: &usize| (radius(*cell) * map.resolution_m as f32).min(WIDEST_HALF_M);
        let halves = nodes.iter().map(metres).collect();
        let scaled = |edges: Vec<(usize, f64)>| {
            edges.into_iter().map(|(to, length)| (to, length * map.resolution_m)).collect()
        };
        let edges = edges.into_iter().map(scaled).collect();
        Some(Self { map, free, flown, nodes, edges, halves })
    }

    /// The place of a node, m.
    fn place(&self, node: usize) -> [f64; 2] {
        let (column, row) = self.free.cell(self.nodes[node]);
        self.map.place(column as f64 + 0.5, row as f64 + 0.5)
    }

    /// Whether a drone can fly near a place.
    fn is_near(&self, place: [f64; 2]) -> bool {
        self.flown.nearest(self.map.grid(place), NEAR_M / self.map.resolution_m).is_some()
    }

    /// The node nearest to a place.
    fn nearest(&self, place: [f64; 2]) -> Option<usize> {
        let away = |node: &usize| network::distance(self.place(*node), place);
        (0..self.nodes.len()).min_by(|a, b| away(a).total_cmp(&away(b)))
    }

    /// Whether the network comes near a place, or no drone can fly near that.
    fn reaches(&self, place: [f64; 2]) -> bool {
        let node = self.nearest(place).map(|node| self.place(node));
        !self.is_near(place) || node.is_some_and(|at| network::distance(at, place) <= NEAR_M)
    }

    /// The way between two places, from one of them to the farthest place from it, or the longest
    /// way; whether it was cut at [`LONGEST_ROUTE`], and its length in metres.
    fn way(
        &self,
        from: Option<[f64; 2]>,
        to: Option<[f64; 2]>,
        ends: &Ends,
    ) -> Result<(Vec<usize>, bool, f64), RouteError> {
        let node = |place: Option<[f64; 2]>| place.and_then(|place| self.nearest(place));
        let way = match (node(from), node(to)) {
            (Some(begin), Some(end)) => {
                let shown = |text: &Option<String>| text.clone().unwrap_or_default();
                let apart = || RouteError::NoWay(shown(&ends.from), shown(&ends.to));
                let way =
                    network::way(self, begin, end).filter(|_| to.is_none_or(|to| self.is_near(to)));
                way.ok_or_else(apart)?
            }
            (Some(from), None) => network::farthest_from(self, from),
            (None, Some(to)) => network::farthest_from(self, to).into_iter().rev().collect(),
            (None, None) => self.begun_at_narrower_end(self.longest()),
        };
        let (way, is_cut) = network::cut(self, way, f64::from(LONGEST_ROUTE));
        let length_m = network::length(self, &way);
        if length_m < f64::from(SHORTEST_ROUTE) {
            return Err(RouteError::TooShort(Box::default()));
        }
        Ok((way, is_cut, length_m))
    }

    /// The outlines of the free space, from an origin.
    fn outlines(&self, origin: [f64; 2]) -> Result<Vec<Vec<Point2>>, GeometryError> {
        let point = |[column, row]: [f64; 2]| {
            let [x, y] = self.map.place(column, row);
            let point = Point2::new((x - origin[0]) as f32, (y - origin[1]) as f32);
            let is_near = point.x.abs() <= FARTHEST && point.y.abs() <= FARTHEST;
            is_near.then_some(point).ok_or(GeometryError::TooLarge)
        };
        let rings = outline::rings(&self.free).into_iter();
        rings.map(|ring| ring.into_iter().map(point).collect()).collect()
    }

    /// The way, from that of its ends at which the passage is narrower: drones that take off there
    /// see both walls.
    fn begun_at_narrower_end(&self, mut way: Vec<usize>) -> Vec<usize> {
        let count = (START_M / self.map.resolution_m) as usize;
        let width = |nodes: &mut dyn Iterator<Item = &usize>| -> f32 {
            nodes.take(count).map(|&node| self.halves[node]).sum()
        };
        if width(&mut way.iter().rev()) < width(&mut way.iter()) {
            way.reverse();
        }
        way
    }

    /// The way between the two nodes that are farthest from each other.
    fn longest(&self) -> Vec<usize> {
        let mut best: Vec<usize> = Vec::new();
        let mut seen = vec![false; self.nodes.len()];
        for start in 0..self.nodes.len() {
            if seen[start] {
                continue;
            }
            let first =
                super::spread::Spread::from(&[start], f64::INFINITY, |it| self.neighbours(it));
            first.order.iter().for_each(|&node| seen[node] = true);
            let way = network::farthest_from(self, first.farthest(start));
            if best.is_empty() || network::length(self, &way) > network::length(self, &best) {
                best = way;
            }
        }
        best
    }
}

impl Network for Grid<'_> {
    fn neighbours(&self, node: usize) -> Vec<(usize, f64)> {
        self.edges[node].clone()
    }

    fn at(&self, node: usize) -> [f64; 3] {
        let [x, y] = self.place(node);
        [x, y, 0.0]
    }

    fn halves(&self, way: &[usize]) -> Vec<f64> {
        way.iter().map(|&node| f64::from(self.halves[node])).collect()
    }

    fn plan(&self, way: &[usize]) -> Vec<Station> {
        let points: Vec<[f64; 2]> = way.iter().map(|&node| self.place(node)).collect();
        let kept = outline::simplified(&points, SMOOTH_M.max(self.map.resolution_m));
        let station = |n: usize| Station {
            at: points[n],
            half_m: self.halves[way[n]].max(0.5 * LEAST_WIDTH),
        };
        kept.into_iter().map(station).collect()
    }
}

/// The map with its specks freed, as a route's tunnel has them.
pub(super) fn without_specks(map: Occupancy) -> Occupancy {
    let free = Mask::free(&map);
    let mut cells = map.cells().to_vec();
    for (cell, _) in free.cells.iter().enumerate().filter(|(_, is_free)| **is_free) {
        let (column, row) = free.cell(cell);
        if let Some(state) = cells.get_mut(row * map.columns() + column) {
            *state = Cell::Free;
        }
    }
    let mut cleaned = Occupancy::new(map.columns(), cells, map.resolution_m, map.origin);
    cleaned.warnings = map.warnings;
    cleaned
}

/// Finds a route through a map and makes its tunnel. The ends are points; where one is left open, the
/// route leads to the farthest place from the other; where both are, it is the longest of the largest
/// free space.
pub(super) fn find(map: &Occupancy, ends: &Ends) -> Result<(Route, Tunnel), RouteError> {
    let place = |text: &Option<String>| text.as_ref().map(|text| point(text)).transpose();
    let (from, to) = (place(&ends.from)?, place(&ends.to)?);
    let places: Vec<[f64; 2]> = from.into_iter().chain(to).collect();
    let Some(grid) = Grid::of(map, &places, Axis::Pruned) else {
        let named = ends.from.as_ref().or(ends.to.as_ref());
        let nowhere = || RouteError::TooShort(Box::default());
        return Err(named.cloned().map_or_else(nowhere, RouteError::NoPoint));
    };
    let reaches_all = places.iter().all(|&place| grid.reaches(place));
    let (grid, (way, is_cut, length_m)) = match grid.way(from, to, ends) {
        Ok(found) if reaches_all => (grid, found),
        Err(error @ RouteError::NoWay(..)) => return Err(error),
        // In a hall the pruned axis may end far from the places that were asked for, or be too short.
        Ok(_) | Err(_) => {
            let grid = Grid::of(map, &places, Axis::ToEnds).unwrap_or(grid);
            let found = grid.way(from, to, ends)?;
            (grid, found)
        }
    };
    let found = Galleries::of(&grid, &way, f64::from(ends.around_m.unwrap_or(f32::INFINITY)));
    let outlines = grid.outlines(found.origin).map_err(RouteError::Geometry)?;
    let tunnel = Tunnel::within(outlines, found.skeleton());
    let shown = |node: Option<&usize>| {
        node.map_or_else(String::new, |&node| {
            let [x, y] = grid.place(node);
            format!("{x:.2},{y:.2}")
        })
    };
    let median_width_m = found.galleries.first().map_or(0.0, |main| main.width);
    let route = Route {
        from: shown(way.first()),
        to: shown(way.last()),
        stations: found.galleries.first().map_or(0, |main| main.centre_line.len()),
        length_m,
        is_cut,
        ended: RouteEnd::of(is_cut, ends.to.is_some(), None, &[], ""),
        side_galleries: found.galleries.len().saturating_sub(1),
        median_width_m,
        long_reach_m: super::long_reach(median_width_m),
        warnings: map.warnings.clone(),
        ..Route::default()
    };
    Ok((route, tunnel))
}

/// The point that a text such as `1.5,-2` names.
fn point(text: &str) -> Result<[f64; 2], RouteError> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|it| it.is_finite());
    let pair = text.split_once(',').and_then(|(x, y)| Some([number(x)?, number(y)?]));
    pair.ok_or_else(|| RouteError::NoPoint(text.to_owned()))
}

/// The remedy for a route that is not in a map.
pub(super) fn remedy(error: &RouteError) -> String {
    match error {
        RouteError::NoPoint(_) => "give x,y in metres, such as 1.5,-2, in free space".into(),
        RouteError::NoWay(..) => "give two points of one free space".into(),
        RouteError::Geometry(_) => "give a smaller map".into(),
        _ => "give a larger map, or another point".into(),
    }
}
