//! Outlines of sets of cells, and lines with fewer points.

use std::collections::BTreeMap;

use super::mask::Mask;

/// The outlines of a set: closed loops with the set on their left, in cells of the map from its lower
/// left corner, simplified within half a cell.
pub(super) fn rings(mask: &Mask) -> Vec<Vec<[f64; 2]>> {
    // The corner at the lower left of a cell has the cell's number.
    let mut edges: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for cell in (0..mask.cells.len()).filter(|cell| mask.cells[*cell]) {
        let corners = [cell, cell + 1, cell + 1 + mask.width, cell + mask.width];
        let [east, north, west, south] = mask.beside(cell).map(|other| mask.cells[other]);
        for (n, is_open) in [south, east, north, west].into_iter().enumerate() {
            if !is_open {
                edges.entry(corners[n]).or_default().push(corners[(n + 1) % 4]);
            }
        }
    }
    let mut found = Vec::new();
    while let Some((&start, _)) = edges.first_key_value() {
        let mut ring = vec![start];
        let mut before = start;
        let mut at = step(&mut edges, start, None, mask.width);
        while at != start {
            ring.push(at);
            let next = step(&mut edges, at, Some(before), mask.width);
            (before, at) = (at, next);
        }
        let point = |corner: &usize| {
            [(corner % mask.width) as f64 - 1.0, (corner / mask.width) as f64 - 1.0]
        };
        let points: Vec<[f64; 2]> = ring.iter().map(point).collect();
        let ring = closed(&points);
        if ring.len() >= 3 {
            found.push(ring);
        }
    }
    found
}

/// Takes the edge that leads on from a corner. Where two do, it is the one to the left, so that cells
/// that touch at a corner alone stay apart.
fn step(
    edges: &mut BTreeMap<usize, Vec<usize>>,
    at: usize,
    before: Option<usize>,
    width: usize,
) -> usize {
    let Some(next) = edges.get_mut(&at) else { return at };
    let left = before.map(|before| {
        let point = |corner: usize| ((corner % width) as i64, (corner / width) as i64);
        let ((x, y), (bx, by)) = (point(at), point(before));
        let (dx, dy) = (x - bx, y - by);
        // A quarter turn to the left of (dx, dy) is (−dy, dx).
        ((y + dx) * width as i64 + x - dy) as usize
    });
    let choice = left.and_then(|left| next.iter().position(|to| *to == left)).unwrap_or(0);
    let to = next.swap_remove(choice);
    if next.is_empty() {
        edges.remove(&at);
    }
    to
}

/// A closed loop with fewer points, within half a cell.
fn closed(ring: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let Some(&first) = ring.first() else { return Vec::new() };
    let away = |n: &usize| (ring[*n][0] - first[0]).hypot(ring[*n][1] - first[1]);
    let farthest = (0..ring.len()).max_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(0);
    let mut back: Vec<[f64; 2]> = ring[farthest..].to_vec();
    back.push(first);
    let halves = [&ring[..=farthest], &back];
    let kept = halves.into_iter().flat_map(|half| {
        let mut kept = simplified(half, 0.5);
        kept.pop();
        kept.into_iter().map(|n| half[n])
    });
    kept.collect()
}

/// The points of a line that are kept where none may be farther than this from what is left: the rule
/// of Ramer, Douglas and Peucker. The ends are kept.
pub(super) fn simplified(line: &[[f64; 2]], within: f64) -> Vec<usize> {
    let mut kept = vec![false; line.len()];
    let last = line.len().saturating_sub(1);
    for end in [0, last] {
        if let Some(kept) = kept.get_mut(end) {
            *kept = true;
        }
    }
    let mut stretches = vec![(0, last)];
    while let Some((from, to)) = stretches.pop() {
        let off = |n: &usize| distance_to(line[*n], line[from], line[to]);
        let farthest = (from + 1..to).max_by(|a, b| off(a).total_cmp(&off(b)));
        if let Some(middle) = farthest.filter(|n| off(n) > within + 1e-9) {
            kept[middle] = true;
            stretches.extend([(from, middle), (middle, to)]);
        }
    }
    (0..line.len()).filter(|n| kept[*n]).collect()
}

/// The distance from a point to a piece of a line.
fn distance_to(point: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let (px, py) = (point[0] - a[0], point[1] - a[1]);
    let length = dx * dx + dy * dy;
    let along = if length > 0.0 { ((px * dx + py * dy) / length).clamp(0.0, 1.0) } else { 0.0 };
    (px - along * dx).hypot(py - along * dy)
}
