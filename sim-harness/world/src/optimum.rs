//! Computes the best chain: equation (1) of the paper, solved with full knowledge of the world and
//! the radio.
//!
//! The relays of the best chain stand on the shortest way from the base to the head. (Off that
//! way, in a side gallery, a relay has longer links, by the model's distance along the tunnel; it
//! might have less rock in the way. Such places are not tried.) The weakest link of a chain of n
//! links is made as strong as can be by dynamic programming over the places of the way, which is
//! exact up to the grid for any radio, continuous or not, monotone or not. The solution is then
//! refined ten times, each time on a grid a fifth as wide around the last.

use std::sync::{Arc, PoisonError, RwLock};

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

/// The best chains along a way, for head positions 0, 0.1, 0.2 … m: those that were asked for, and
/// all before them. The best chain to a place does not depend on what lies beyond.
pub struct BestChains {
    radio: Arc<Radio>,
    way: Path,
    /// The head positions, m along the way.
    places: Vec<f32>,
    /// The loss of the weakest link, by links − 1, then by place.
    rows: RwLock<Vec<Vec<Db>>>,
}

impl BestChains {
    /// How many places more than needed are solved at once: 5 m.
    const AHEAD: usize = 50;

    /// The best chains along `way`, of 1 to `most` links.
    #[must_use]
    pub fn along(radio: &Arc<Radio>, way: Path, most: usize) -> Self {
        let places = grid(0.0, way.length(), COARSE);
        Self { radio: Arc::clone(radio), way, places, rows: RwLock::new(vec![Vec::new(); most]) }
    }

    /// The way.
    #[must_use]
    pub const fn way(&self) -> &Path {
        &self.way
    }

    /// The number of the last head position.
    #[must_use]
    pub const fn last(&self) -> usize {
        self.places.len() - 1
    }

    /// The loss of the weakest link of the best chain of so many links to a head position; infinite
    /// for a number of links beyond the most.
    #[must_use]
    pub fn worst(&self, links: usize, place: usize) -> Db {
        let place = place.min(self.last());
        let known = |rows: &Vec<Vec<Db>>| {
            let row = links.checked_sub(1).and_then(|n| rows.get(n));
            row.map_or(Some(Db(f32::INFINITY)), |row| row.get(place).copied())
        };
        let found = known(&self.rows.read().unwrap_or_else(PoisonError::into_inner));
        found.unwrap_or_else(|| {
            let mut rows = self.rows.write().unwrap_or_else(PoisonError::into_inner);
            self.solve_to(place + Self::AHEAD, &mut rows);
            known(&rows).unwrap_or(Db(f32::INFINITY))
        })
    }

    /// The losses for all head positions, by links − 1, then by place.
    #[must_use]
    pub fn all(&self) -> Vec<Vec<Db>> {
        let mut rows = self.rows.write().unwrap_or_else(PoisonError::into_inner);
        self.solve_to(self.last(), &mut rows);
        rows.clone()
    }

    /// Solves up to a head position, by dynamic programming over the last relay's place.
    fn solve_to(&self, place: usize, rows: &mut [Vec<Db>]) {
        let solved = rows.first().map_or(0, Vec::len);
        for n in solved..=place.min(self.last()) {
            let here = self.radio.survey_place(self.way.at(self.places[n]));
            let loss = |y: &f32| {
                let there = self.radio.survey_place(self.way.at(*y));
                self.radio.strength_at(&there, &here).loss().0
            };
            let losses: Vec<f32> = self.places[..=n].iter().map(loss).collect();
            let mut through: Vec<f32> = Vec::new();
            for row in rows.iter_mut() {
                let worst = match through.is_empty() {
                    true => losses[0],
                    false => {
                        let worst = losses.iter().zip(&through).map(|(loss, to)| to.max(*loss));
                        worst.fold(f32::INFINITY, f32::min)
                    }
                };
                row.push(Db(worst));
                through = row.iter().map(|db| db.0).collect();
            }
        }
    }
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
