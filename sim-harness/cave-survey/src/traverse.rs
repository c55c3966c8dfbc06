//! Computes the positions of a network's points by least squares.
//!
//! The network is reduced first: branches that end nowhere follow the rest, and a *traverse*, a row
//! of legs without junctions, counts as one leg whose covariance is the sum of theirs. Its
//! misclosure is shared among them in the same proportion.

use crate::adjust::Network;
use crate::elimination::NormalEquations;
use crate::matrix::{self, Matrix, Vector};

/// A row of legs between two anchors.
struct Traverse {
    ends: [usize; 2],
    /// The links with the point that each begins at.
    links: Vec<(usize, usize)>,
    vector: Vector,
    covariance: Matrix,
}

/// The positions of all points; of those that nothing joins, the origin.
/// `None` where there are too many loops to solve for.
pub(crate) fn positions(network: &Network) -> Option<Vec<Vector>> {
    let mut degree: Vec<usize> = network.at.iter().map(Vec::len).collect();
    let mut gone = vec![false; network.links.len()];
    // Links to itself, which two equated stations can have, place nothing.
    for (number, link) in network.links.iter().enumerate() {
        if link.ends[0] == link.ends[1] {
            gone[number] = true;
            degree[link.ends[0]] -= 2;
        }
    }
    let branches = strip(network, &mut degree, &mut gone);
    let is_anchor = |point: usize| network.fixed[point].is_some() || degree[point] > 2;
    let traverses = traverses(network, &mut gone, is_anchor);
    let mut found: Vec<Option<Vector>> = network.fixed.clone();
    solve(&traverses, &mut found)?;
    for traverse in &traverses {
        spread(network, traverse, &mut found);
    }
    for &(link, leaf, stem) in branches.iter().rev() {
        let from = found[stem].unwrap_or_default();
        found[leaf] = Some(matrix::add(from, network.links[link].vector_from(stem)));
    }
    Some(found.into_iter().map(Option::unwrap_or_default).collect())
}

/// Takes branches off from their ends; returns their links, each with its outer and inner point.
fn strip(network: &Network, degree: &mut [usize], gone: &mut [bool]) -> Vec<(usize, usize, usize)> {
    let loose =
        |point: usize, degree: &[usize]| degree[point] == 1 && network.fixed[point].is_none();
    let mut queue: Vec<usize> = (0..network.at.len()).filter(|&n| loose(n, degree)).collect();
    let mut branches = Vec::new();
    while let Some(leaf) = queue.pop() {
        let Some(&link) = network.at[leaf].iter().find(|&&link| !gone[link]) else { continue };
        let stem = network.links[link].other(leaf);
        gone[link] = true;
        degree[leaf] -= 1;
        degree[stem] -= 1;
        branches.push((link, leaf, stem));
        if loose(stem, degree) {
            queue.push(stem);
        }
    }
    branches
}

fn traverses(
    network: &Network,
    gone: &mut [bool],
    is_anchor: impl Fn(usize) -> bool,
) -> Vec<Traverse> {
    let mut all = Vec::new();
    for anchor in (0..network.at.len()).filter(|&point| is_anchor(point)) {
        for &first in &network.at[anchor] {
            if gone[first] {
                continue;
            }
            let mut traverse = Traverse {
                ends: [anchor, anchor],
                links: Vec::new(),
                vector: [0.0; 3],
                covariance: matrix::ZERO,
            };
            let (mut point, mut next) = (anchor, Some(first));
            while let Some(link) = next {
                gone[link] = true;
                traverse.links.push((link, point));
                let it = &network.links[link];
                traverse.vector = matrix::add(traverse.vector, it.vector_from(point));
                traverse.covariance = matrix::sum(&traverse.covariance, &it.covariance);
                point = it.other(point);
                let on = network.at[point].iter().copied().find(|&link| !gone[link]);
                next = on.filter(|_| !is_anchor(point));
            }
            traverse.ends[1] = point;
            all.push(traverse);
        }
    }
    all
}

/// Gives the anchors that are not fixed their positions.
fn solve(traverses: &[Traverse], found: &mut [Option<Vector>]) -> Option<()> {
    let mut numbers = vec![None; found.len()];
    let mut unknown = Vec::new();
    for &end in traverses.iter().flat_map(|traverse| &traverse.ends) {
        if found[end].is_none() && numbers[end].is_none() {
            numbers[end] = Some(unknown.len());
            unknown.push(end);
        }
    }
    // Positions are computed as differences from one of the fixed ones, so that coordinates of a
    // country's grid cost no digits.
    let origin = traverses.iter().flat_map(|t| t.ends).find_map(|end| found[end]);
    let origin = origin.unwrap_or_default();
    let mut equations = NormalEquations::new(unknown.len());
    for traverse in traverses.iter().filter(|traverse| traverse.ends[0] != traverse.ends[1]) {
        let weight = matrix::inverse(&traverse.covariance);
        let end = |n: usize| {
            let point = traverse.ends[n];
            numbers[point].ok_or_else(|| matrix::sub(found[point].unwrap_or_default(), origin))
        };
        equations.observe(end(0), end(1), traverse.vector, &weight);
    }
    for (point, at) in unknown.into_iter().zip(equations.solve()?) {
        found[point] = Some(matrix::add(at, origin));
    }
    Some(())
}

/// Places the points of a traverse between its ends, its misclosure shared by covariances.
fn spread(network: &Network, traverse: &Traverse, found: &mut [Option<Vector>]) {
    let begin = found[traverse.ends[0]].unwrap_or_default();
    let end = found[traverse.ends[1]].unwrap_or_default();
    let error = matrix::sub(matrix::sub(end, begin), traverse.vector);
    let shares = matrix::times(&matrix::inverse(&traverse.covariance), error);
    let mut at = begin;
    let inner = traverse.links.len().saturating_sub(1);
    for &(link, point) in &traverse.links[..inner] {
        let link = &network.links[link];
        let share = matrix::times(&link.covariance, shares);
        at = matrix::add(matrix::add(at, link.vector_from(point)), share);
        found[link.other(point)] = Some(at);
    }
}
