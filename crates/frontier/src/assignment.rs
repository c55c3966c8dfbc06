//! Assigns to each robot of a cluster one of the cluster's candidates.

use heapless::Vec;
use units::{Metres, Point2};

use crate::candidate::Candidate;
use crate::cluster::ROBOTS;
use crate::rule::{Order, Rule};

/// Below this sum of distances the term of the others in the utility no longer grows (m). Our own
/// number: the thesis divides by a sum that can be zero.
const LEAST_SUM: f32 = 1.0;

/// A robot that waits for a candidate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explorer {
    /// The robot's number.
    pub number: u8,
    /// The robot's place.
    pub position: Point2,
}

/// What one robot is to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assignment {
    /// The robot's number.
    pub number: u8,
    /// The candidate's place in the list that was given.
    pub candidate: usize,
}

/// Assigns at most one candidate to each robot, and none to two robots. `distance` says how far the
/// candidate with that place in the list is from a robot, by the measure that the rule asks for;
/// `None` keeps the candidate from the robot. Candidates beyond `N` are not looked at.
///
/// The utility is U = I·exp(−λ·(d + (n−1)/D)), with the gain I, the distance d, the number n of
/// robots, and the sum D of the distances of the other robots (thesis, equation of the utility; its
/// text has n/D). Once assigned, a candidate discounts the gain of each other one at distance r by
/// 1 − exp(−r²/2σ²).
pub fn assign<const N: usize>(
    rule: &Rule,
    explorers: &[Explorer],
    candidates: &[Candidate],
    distance: impl Fn(&Explorer, usize) -> Option<Metres>,
) -> Vec<Assignment, ROBOTS> {
    let mut gains: Vec<f32, N> = candidates.iter().take(N).map(|c| f32::from(c.gain)).collect();
    let mut waiting: Vec<Explorer, ROBOTS> = explorers.iter().take(ROBOTS).copied().collect();
    let mut assigned = Vec::new();
    while let Some(choice) = best(rule, &waiting, explorers, &gains, &distance) {
        waiting.retain(|explorer| explorer.number != choice.number);
        discount(rule, candidates, &mut gains, choice.candidate);
        // There is room for as many as can wait.
        let _ = assigned.push(choice);
    }
    assigned
}

/// The next robot and its candidate; `None` where no robot that waits can be given one.
fn best(
    rule: &Rule,
    waiting: &[Explorer],
    all: &[Explorer],
    gains: &[f32],
    distance: &impl Fn(&Explorer, usize) -> Option<Metres>,
) -> Option<Assignment> {
    let mut best: Option<(f32, Assignment)> = None;
    for explorer in waiting {
        for (candidate, &gain) in gains.iter().enumerate().filter(|(_, gain)| **gain >= 0.0) {
            let Some(way) = distance(explorer, candidate) else { continue };
            let others = all.iter().filter(|other| other.number != explorer.number);
            let sum: f32 = others.filter_map(|o| distance(o, candidate)).map(|m| m.0).sum();
            let utility = utility(rule, gain, way, all.len(), sum);
            if best.is_none_or(|(most, _)| utility > most) {
                best = Some((utility, Assignment { number: explorer.number, candidate }));
            }
        }
        if rule.order == Order::ByNumber && best.is_some() {
            break;
        }
    }
    best.map(|(_, assignment)| assignment)
}

fn utility(rule: &Rule, gain: f32, way: Metres, robots: usize, sum: f32) -> f32 {
    if rule.lambda.is_infinite() {
        return -way.0;
    }
    let crowd = robots.saturating_sub(1) as f32 / sum.max(LEAST_SUM);
    gain * libm::expf(-rule.lambda * (way.0 + crowd))
}

/// Takes the candidate away, which is marked by a negative gain, and discounts those around it.
fn discount(rule: &Rule, candidates: &[Candidate], gains: &mut [f32], taken: usize) {
    let Some(at) = candidates.get(taken) else { return };
    for (n, (gain, other)) in gains.iter_mut().zip(candidates).enumerate() {
        if n == taken {
            *gain = -1.0;
        } else if rule.discount && *gain >= 0.0 {
            let ratio = other.position.distance(at.position).0 / rule.sigma.0;
            *gain *= 1.0 - libm::expf(-0.5 * ratio * ratio);
        }
    }
}
