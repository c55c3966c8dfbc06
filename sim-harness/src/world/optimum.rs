//! Computes the best chain: equation (1) of the paper, solved with full knowledge of the world and
//! the radio.
//!
//! The relays of the best chain stand on the shortest way from the base to the head. (Off that
//! way, in a side gallery, a relay has longer links, by the model's distance along the tunnel; it
//! might have less rock in the way. Such places are not tried.) The weakest link of a chain of n
//! links is made as strong as can be by dynamic programming over the places of the way, which is
//! exact up to the grid for any radio, continuous or not, monotone or not. The solution is then
//! refined ten times, each time on a grid a fifth as wide around the last.

use units::Db;

use super::{Known, Path, Radio};

/// An optimal chain.
#[derive(Clone, Debug, PartialEq)]
pub struct Optimum {
    /// The lengths along the way at which base, relays and head stand, base first, m.
    pub positions: Vec<f32>,
    /// The loss of the weakest link.
    pub worst: Db,
}

/// Grid of the first pass, in metres.
const COARSE: f32 = 0.1;

/// The best chain of `links` links from the base, where `way` begins, to a head at its end.
#[must_use]
pub fn best_chain(radio: &Radio, way: &Path, links: usize) -> Optimum {
    best_chain_known(radio, Known::All, way, links)
}

/// The chain that is the best for all that is `known` of the radio.
#[must_use]
pub fn best_chain_known(radio: &Radio, known: Known, way: &Path, links: usize) -> Optimum {
    let loss = |a: f32, b: f32| radio.known_strength(way.at(a), way.at(b), known).loss().0;
    let head = way.length();
    let everywhere: Vec<f32> = grid(0.0, head, COARSE);
    let mut places = vec![vec![0.0]];
    places.extend(std::iter::repeat_n(everywhere, links.saturating_sub(1)));
    places.push(vec![head]);
    let mut best = solve(&loss, &places);
    let mut step = COARSE;
    for _ in 0..10 {
        let reach = step;
        step /= 5.0;
        let inner = best.positions.iter().skip(1).take(links.saturating_sub(1));
        let around = |&x: &f32| grid((x - reach).max(0.0), (x + reach).min(head), step);
        let refined: Vec<_> = std::iter::once(vec![0.0])
            .chain(inner.map(around))
            .chain(std::iter::once(vec![head]))
            .collect();
        let candidate = solve(&loss, &refined);
        if candidate.worst < best.worst {
            best = candidate;
        }
    }
    best
}

/// Returns the loss of the weakest link of the best chain, for every head position 0, 0.1, 0.2 … m
/// along `way` and every number of links from 1 to `most`. The result is indexed by links − 1, then
/// by place.
#[must_use]
pub fn best_chains(radio: &Radio, way: &Path, most: usize) -> Vec<Vec<Db>> {
    let places = grid(0.0, way.length(), COARSE);
    let loss = |a: f32, b: f32| radio.strength(way.at(a), way.at(b)).loss().0;
    let mut rows: Vec<Vec<Db>> = vec![places.iter().map(|&x| Db(loss(0.0, x))).collect()];
    while rows.len() < most {
        let Some(shorter) = rows.last() else { break };
        let next = places
            .iter()
            .enumerate()
            .map(|(n, &x)| {
                let through = places.iter().zip(shorter).take(n + 1);
                let worst = through.map(|(&y, before)| before.0.max(loss(y, x)));
                Db(worst.fold(f32::INFINITY, f32::min))
            })
            .collect();
        rows.push(next);
    }
    rows
}

/// The points from `from` to `to` in equal steps of at most `step`, ends included.
fn grid(from: f32, to: f32, step: f32) -> Vec<f32> {
    let count = ((to - from) / step).ceil().max(1.0) as usize;
    (0..=count).map(|n| from + (to - from) * n as f32 / count as f32).collect()
}

/// Minimax over one list of places per node, each node at least as far out as the one before.
fn solve(loss: &impl Fn(f32, f32) -> f32, places: &[Vec<f32>]) -> Optimum {
    let mut worst: Vec<f32> = places.first().map_or_else(Vec::new, |base| vec![0.0; base.len()]);
    worst.iter_mut().for_each(|w| *w = f32::NEG_INFINITY);
    let mut came_from: Vec<Vec<usize>> = Vec::new();
    for pair in places.windows(2) {
        let (nearer, farther) = (&pair[0], &pair[1]);
        let step = |&x: &f32| {
            let via = nearer.iter().zip(&worst).enumerate().filter(|(_, (y, _))| **y <= x);
            via.map(|(n, (&y, &before))| (n, before.max(loss(y, x))))
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap_or((0, f32::INFINITY))
        };
        let (from, next): (Vec<usize>, Vec<f32>) = farther.iter().map(step).unzip();
        came_from.push(from);
        worst = next;
    }
    let mut at = 0;
    let mut positions = Vec::with_capacity(places.len());
    for (node, from) in came_from.iter().enumerate().rev() {
        positions.push(places[node + 1][at]);
        at = from[at];
    }
    positions.push(places[0][at]);
    positions.reverse();
    Optimum { positions, worst: Db(worst.first().copied().unwrap_or(f32::INFINITY)) }
}
