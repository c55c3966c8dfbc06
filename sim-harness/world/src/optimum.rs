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

use super::{Known, Path, Radio, SurveyedPlace};

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
    let mut best = match links {
        0 | 1 => solve(&loss, &[vec![0.0], vec![head]]),
        _ => {
            let mut places = grid(0.0, head, COARSE);
            // On a way of no length both ends are one place.
            places.dedup();
            let surveyed: Vec<_> = places.iter().map(|x| radio.survey_place(way.at(*x))).collect();
            let between = |y: usize, x: usize| {
                radio.known_strength_at(&surveyed[y], &surveyed[x], known).loss().0
            };
            solve_on_one_list(&between, (&loss, head), &places, links)
        }
    };
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
    solved: RwLock<Solved>,
}

/// The head positions that are solved.
struct Solved {
    /// Their places.
    places: Vec<SurveyedPlace>,
    /// The loss of the weakest link, by links − 1, then by place.
    rows: Vec<Vec<Db>>,
}

impl Solved {
    /// The loss of the weakest link; infinite for a number of links beyond the most, and `None` for a
    /// place that is not solved.
    fn worst(&self, links: usize, place: usize) -> Option<Db> {
        let row = links.checked_sub(1).and_then(|n| self.rows.get(n));
        row.map_or(Some(Db(f32::INFINITY)), |row| row.get(place).copied())
    }
}

impl BestChains {
    /// How many places more than needed are solved at once: 5 m.
    const AHEAD: usize = 50;

    /// The best chains along `way`, of 1 to `most` links.
    #[must_use]
    pub fn along(radio: &Arc<Radio>, way: Path, most: usize) -> Self {
        let places = grid(0.0, way.length(), COARSE);
        let solved = Solved { places: Vec::new(), rows: vec![Vec::new(); most] };
        Self { radio: Arc::clone(radio), way, places, solved: RwLock::new(solved) }
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
        let found = self.solved.read().unwrap_or_else(PoisonError::into_inner).worst(links, place);
        found.unwrap_or_else(|| {
            let mut solved = self.solved.write().unwrap_or_else(PoisonError::into_inner);
            self.solve_to(place + Self::AHEAD, &mut solved);
            solved.worst(links, place).unwrap_or(Db(f32::INFINITY))
        })
    }

    /// For each number of links, one first, the first head position of whose best chain the weakest
    /// link `is_weak`; `None` where there is none on the way.
    ///
    /// Of a long way only the part is solved that some number of links reaches.
    #[must_use]
    pub fn first_weak(&self, is_weak: impl Fn(Db) -> bool) -> Vec<Option<usize>> {
        let mut solved = self.solved.write().unwrap_or_else(PoisonError::into_inner);
        let mut first = vec![None; solved.rows.len()];
        for place in 0..=self.last() {
            if first.iter().all(Option::is_some) {
                break;
            }
            self.solve_to(place, &mut solved);
            for (first, row) in first.iter_mut().zip(&solved.rows) {
                let weak = row.get(place).is_some_and(|loss| is_weak(*loss));
                *first = first.or(weak.then_some(place));
            }
        }
        first
    }

    /// Solves up to a head position, by dynamic programming over the last relay's place.
    fn solve_to(&self, place: usize, Solved { places, rows }: &mut Solved) {
        for n in places.len()..=place.min(self.last()) {
            let here = self.radio.survey_place(self.way.at(self.places[n]));
            places.push(here);
            let loss = |there| self.radio.strength_at(there, &here).loss().0;
            let losses: Vec<f32> = places.iter().map(loss).collect();
            let mut before: Option<&[Db]> = None;
            for row in rows.iter_mut() {
                let worst = match before {
                    None => losses[0],
                    Some(through) => {
                        let worst = losses.iter().zip(through).map(|(loss, to)| to.0.max(*loss));
                        worst.fold(f32::INFINITY, f32::min)
                    }
                };
                row.push(Db(worst));
                before = Some(row);
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
            strongest(via.map(|(n, (&y, &before))| (n, before.max(loss(y, x)))))
        };
        let (from, next): (Vec<usize>, Vec<f32>) = farther.iter().map(step).unzip();
        came_from.push(from);
        worst = next;
    }
    let place = |node: usize, at: usize| places[node][at];
    traced(place, &came_from, worst.first().copied())
}

/// The same where the relays of two links or more may stand anywhere on one list of places, which
/// ascends from the base: the losses to a place are computed once for all links. The loss `between`
/// two places goes by their numbers, that to the head, which need not be of the list, by lengths.
fn solve_on_one_list(
    between: &impl Fn(usize, usize) -> f32,
    (to_head, head): (&impl Fn(f32, f32) -> f32, f32),
    places: &[f32],
    links: usize,
) -> Optimum {
    let mut worst: Vec<Vec<f32>> = vec![Vec::with_capacity(places.len()); links - 1];
    let mut came_from: Vec<Vec<usize>> = vec![Vec::with_capacity(places.len()); links - 1];
    for x in 0..places.len() {
        let losses: Vec<f32> = (0..=x).map(|y| between(y, x)).collect();
        for link in 0..links - 1 {
            let (from, weakest) = match link.checked_sub(1).map(|before| &worst[before]) {
                None => (0, losses[0]),
                Some(before) => {
                    let via = before.iter().zip(&losses).map(|(before, loss)| before.max(*loss));
                    strongest(via.enumerate())
                }
            };
            worst[link].push(weakest);
            came_from[link].push(from);
        }
    }
    let last = worst.last().into_iter().flatten();
    let via = places.iter().zip(last).enumerate().filter(|(_, (y, _))| **y <= head);
    let (from, weakest) =
        strongest(via.map(|(n, (&y, &before))| (n, before.max(to_head(y, head)))));
    came_from.push(vec![from]);
    let place = |node: usize, at: usize| match node {
        0 => 0.0,
        node if node == links => head,
        _ => places[at],
    };
    traced(place, &came_from, Some(weakest))
}

/// The number of the place over which the weakest link is the strongest, with its loss.
fn strongest(via: impl Iterator<Item = (usize, f32)>) -> (usize, f32) {
    via.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f32::INFINITY))
}

/// The chain that ends at the first place of the last node, traced back to the base: where a node's
/// place lies, and for each place of each node but the base the number of that before it.
fn traced(
    place: impl Fn(usize, usize) -> f32,
    came_from: &[Vec<usize>],
    worst: Option<f32>,
) -> Optimum {
    let mut at = 0;
    let mut positions = Vec::with_capacity(came_from.len() + 1);
    for (node, from) in came_from.iter().enumerate().rev() {
        positions.push(place(node + 1, at));
        at = from[at];
    }
    positions.push(place(0, at));
    positions.reverse();
    Optimum { positions, worst: Db(worst.unwrap_or(f32::INFINITY)) }
}

#[cfg(test)]
mod tests;
