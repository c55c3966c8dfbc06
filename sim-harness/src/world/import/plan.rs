//! The horizontal plan of a route.

use units::Point2;

use super::graph::Graph;
use crate::world::layout::{GeometryError, LEAST_WIDTH, Passage};
use crate::world::{Gallery, Tunnel};

/// Stations of a plan nearer to each other than this become one, m: what is left of a climb.
const NEAREST: f32 = 0.3;

/// A route on the floor.
pub(super) struct Plan {
    /// The middle of the passage, and half of its width there, m.
    stations: Vec<(Point2, f32)>,
}

/// The plan of a way, and at how many of its nodes the width is assumed.
pub(super) fn plan(graph: &Graph<'_>, way: &[usize]) -> (Plan, usize) {
    let flat: Vec<[f64; 2]> =
        way.iter().map(|&node| graph.at(node)).map(|[x, y, _]| [x, y]).collect();
    let origin = flat.first().copied().unwrap_or_default();
    let mut assumed = 0;
    let mut stations: Vec<(Point2, f32)> = Vec::new();
    for (n, (&node, at)) in way.iter().zip(&flat).enumerate() {
        let [x, y] = direction(&flat, n);
        let sides = graph.sides(node, [x, y]);
        assumed += usize::from(sides.is_assumed);
        let half = (0.5 * (sides.left + sides.right)) as f32;
        let shift = 0.5 * (sides.left - sides.right);
        // Left of the direction is (−y, x).
        let middle = [at[0] - origin[0] - y * shift, at[1] - origin[1] + x * shift];
        let middle = Point2::new(middle[0] as f32, middle[1] as f32);
        let half = half.max(0.5 * LEAST_WIDTH);
        match stations.last_mut() {
            Some((last, width)) if last.distance(middle).0 < NEAREST => *width = width.max(half),
            _ => stations.push((middle, half)),
        }
    }
    (Plan { stations }, assumed)
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

impl Plan {
    /// The tunnel.
    pub(super) fn dig(&self) -> Result<Tunnel, GeometryError> {
        let mut widths: Vec<f32> = self.stations.iter().map(|(_, half)| 2.0 * half).collect();
        widths.sort_by(f32::total_cmp);
        let width = widths.get(widths.len() / 2).copied().unwrap_or(LEAST_WIDTH);
        let centre_line: Vec<Point2> = self.stations.iter().map(|(at, _)| *at).collect();
        if centre_line.len() < 2 {
            return Err(GeometryError::TooShort);
        }
        let gallery = Gallery { name: "main".into(), centre_line, width };
        Tunnel::surveyed(&[gallery], &[Passage { stations: self.stations.clone() }])
    }
}
