//! Thins a set of cells to its medial axis, after Zhang and Suen, "A fast parallel algorithm for
//! thinning digital patterns" (1984), and removes the spurs that lead to the set's corners.

use std::collections::{BTreeMap, BTreeSet};

use super::mask::Mask;

/// Nodes, and for each its neighbours with their distances in cells.
type Graph = (Vec<usize>, Vec<Vec<(usize, f64)>>);

/// A dead end counts as a spur up to this many times the distance of its beginning from the walls:
/// the spurs into the corners of a square end are √2 times as long.
const SPUR: f64 = 1.5;

/// The medial axis of a set, with lines to these ends. `radius` is the distance of a cell from the
/// walls, in cells.
pub(super) fn medial_axis(mask: &Mask, radius: impl Fn(usize) -> f32, ends: &[usize]) -> Graph {
    let mut axis = thinned(mask, ends);
    // A spur may have spurs, and a node that lost all but two of its lines is none.
    for _ in 0..4 {
        if !prune(&mut axis, &radius, ends) {
            break;
        }
    }
    let nodes: Vec<usize> = (0..axis.cells.len()).filter(|cell| axis.cells[*cell]).collect();
    let numbers: BTreeMap<usize, usize> = nodes.iter().enumerate().map(|(n, c)| (*c, n)).collect();
    let edges = nodes.iter().map(|cell| {
        let near = neighbours(&axis, *cell);
        near.filter_map(|(to, length)| Some((*numbers.get(&to)?, length))).collect()
    });
    let edges = edges.collect();
    (nodes, edges)
}

/// Thins a set to lines, which lead to these of its cells.
fn thinned(mask: &Mask, ends: &[usize]) -> Mask {
    let mut axis = mask.clone();
    let members = (0..axis.cells.len()).filter(|cell| axis.cells[*cell]);
    // Only cells at the edge of what is left can go.
    let mut edge: BTreeSet<usize> =
        members.filter(|cell| axis.ring(*cell).iter().any(|other| !axis.cells[*other])).collect();
    loop {
        let mut changed = false;
        for pass in [false, true] {
            let goes = |cell: &usize| !ends.contains(cell) && goes(&axis, *cell, pass);
            let gone: Vec<usize> = edge.iter().copied().filter(goes).collect();
            for &cell in &gone {
                axis.cells[cell] = false;
                edge.remove(&cell);
            }
            for &cell in &gone {
                edge.extend(axis.ring(cell).into_iter().filter(|other| axis.cells[*other]));
            }
            changed |= !gone.is_empty();
        }
        if !changed {
            return axis;
        }
    }
}

/// Whether a cell goes in this pass.
fn goes(axis: &Mask, cell: usize, second: bool) -> bool {
    let [e, ne, n, nw, w, sw, s, se] = axis.ring(cell).map(|other| axis.cells[other]);
    // In the order of the paper: P2 to P9 clockwise from the north.
    let around = [n, ne, e, se, s, sw, w, nw];
    let count = around.iter().filter(|member| **member).count();
    let begins = |n: usize| !around[n] && around[(n + 1) % 8];
    let is_open = match second {
        false => !(e && s && (n || w)),
        true => !(n && w && (e || s)),
    };
    (2..=6).contains(&count) && (0..8).filter(|n| begins(*n)).count() == 1 && is_open
}

/// The neighbours of a cell of an axis: those beside it, and those at its corners to which none
/// beside it leads.
fn neighbours(axis: &Mask, cell: usize) -> impl Iterator<Item = (usize, f64)> {
    let ring = axis.ring(cell);
    let members = ring.map(|other| axis.cells[other]);
    (0..8).filter_map(move |n| {
        let is_corner = n % 2 == 1;
        let leads = |m: usize| members[m % 8];
        if !members[n] || is_corner && (leads(n + 1) || leads(n + 7)) {
            return None;
        }
        Some((ring[n], if is_corner { core::f64::consts::SQRT_2 } else { 1.0 }))
    })
}

/// Removes the spurs of an axis that lead to none of these cells, and says whether there were any.
fn prune(axis: &mut Mask, radius: &impl Fn(usize) -> f32, kept: &[usize]) -> bool {
    let is_end = |cell: &usize| axis.cells[*cell] && neighbours(axis, *cell).count() == 1;
    let ends: Vec<usize> =
        (0..axis.cells.len()).filter(|cell| is_end(cell) && !kept.contains(cell)).collect();
    let mut spurs: Vec<(f64, Vec<usize>)> = Vec::new();
    for end in ends {
        let (mut line, mut length) = (vec![end], 0.0);
        let mut before = end;
        let mut at = end;
        loop {
            let mut on = neighbours(axis, at).filter(|(to, _)| *to != before);
            let (Some((to, step)), None) = (on.next(), on.next()) else { break };
            length += step;
            (before, at) = (at, to);
            if neighbours(axis, at).count() > 2 {
                if length <= SPUR * f64::from(radius(at)) + 2.0 {
                    spurs.push((length, line));
                }
                break;
            }
            line.push(at);
            // A loop would have no end, and an axis has no more cells than this.
            if line.len() > axis.cells.len() {
                break;
            }
        }
    }
    // Of several spurs at one node the shortest go first, and the rest is looked at again.
    spurs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let found = !spurs.is_empty();
    for (_, line) in spurs {
        line.into_iter().for_each(|cell| axis.cells[cell] = false);
    }
    found
}
