//! The horizontal plan of a route.

use world::layout::LEAST_WIDTH;

use super::graph::Graph;
use super::network::{Station, distance};

/// Stations of a plan nearer to each other than this become one, m: what is left of a climb.
const NEAREST: f64 = 0.3;

/// The plan of a way: the middle of the passage at its stations, in the axes of the survey, and at
/// how many of its nodes the width is assumed.
pub(super) fn plan(graph: &Graph<'_>, way: &[usize]) -> (Vec<Station>, usize) {
    let mut assumed = 0;
    let mut stations: Vec<Station> = Vec::new();
    for (station, is_assumed) in middles(graph, way) {
        assumed += usize::from(is_assumed);
        match stations.last_mut() {
            Some(last) if distance(last.at, station.at) < NEAREST => {
                last.half_m = last.half_m.max(station.half_m);
            }
            _ => stations.push(station),
        }
    }
    (stations, assumed)
}

/// The middle of the passage at each node of a way, and whether its width is assumed.
pub(super) fn middles(graph: &Graph<'_>, way: &[usize]) -> Vec<(Station, bool)> {
    let flat: Vec<[f64; 2]> =
        way.iter().map(|&node| graph.position(node)).map(|[x, y, _]| [x, y]).collect();
    let middle = |(n, (&node, at)): (usize, (&usize, &[f64; 2]))| {
        let [x, y] = direction(&flat, n);
        let sides = graph.sides(node, [x, y]);
        let half = (0.5 * (sides.left + sides.right)) as f32;
        let shift = 0.5 * (sides.left - sides.right);
        // Left of the direction is (−y, x).
        let middle = [at[0] - y * shift, at[1] + x * shift];
        (Station { at: middle, half_m: half.max(0.5 * LEAST_WIDTH) }, sides.is_assumed)
    };
    way.iter().zip(&flat).enumerate().map(middle).collect()
}

/// The horizontal direction of a way at one of its points: the mean of the legs before and behind.
fn direction(points: &[[f64; 2]], n: usize) -> [f64; 2] {
    let unit = |a: Option<&[f64; 2]>, b: Option<&[f64; 2]>| {
        let (a, b) = (a?, b?);
        let (x, y) = (b[0] - a[0], b[1] - a[1]);
        let length = x.hypot(y);
        (length > 1e-6).then(|| [x / length, y / length])
    };
    let before = n.checked_sub(1).and_then(|m| unit(points.get(m), points.get(n)));
    let behind = unit(points.get(n), points.get(n + 1));
    let both = match (before, behind) {
        (Some(a), Some(b)) => [a[0] + b[0], a[1] + b[1]],
        (Some(one), None) | (None, Some(one)) => one,
        (None, None) => [0.0, 1.0],
    };
    let length = both[0].hypot(both[1]);
    if length > 1e-3 { [both[0] / length, both[1] / length] } else { behind.unwrap_or([0.0, 1.0]) }
}
