//! Assigns candidates to robots: one to each robot that waits, and none to two robots.

use heapless::Vec;
use units::{Metres, Point2};

use crate::list::filled;
use crate::rule::{Order, Rule, Utility};

/// Below this sum of distances the term of the others in the utility no longer grows (m). Our own
/// number: the thesis divides by a sum that can be zero.
const LEAST_SUM: f32 = 1.0;
/// Two places that are nearer to each other are one: half a tile.
const SAME: Metres = Metres(0.15);
/// The area of one cell of 0.1 m, square metres.
const CELL_AREA: f32 = 0.01;

/// A place that a robot may be sent to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The point of the floor plan.
    pub position: Point2,
    /// How many cells around it nothing is known of; what others go to discounts it.
    pub gain: f32,
}

/// What one robot is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Assignment {
    /// The robot's place in the list of those that wait.
    pub robot: usize,
    /// The candidate's place in the list of places.
    pub place: usize,
}

/// The robots that wait: how far each place is from each of them.
pub trait Distances {
    /// How many robots wait.
    fn robots(&self) -> usize;
    /// How far a place is from a robot; `None` keeps the place from the robot.
    fn distance(&self, robot: usize, place: usize) -> Option<Metres>;
}

/// Assigns at most one place to each of the first `ROBOTS` robots that wait.
///
/// The best pair is found without comparing all pairs anew each time: gains only fall, so that a
/// robot's utility from an earlier round is a bound above the present one (Minoux, "Accelerated
/// greedy algorithms for maximizing submodular set functions", 1978). With r robots and c places it
/// takes r·c steps where no bound fails, and r²·c at most.
pub fn assign<const ROBOTS: usize>(
    rule: &Rule,
    places: &mut [Place],
    robots: &impl Distances,
) -> Vec<Assignment, ROBOTS> {
    let all = (0..robots.robots()).map(|robot| Waiting { robot, bound: f32::INFINITY });
    let mut waiting: Vec<Waiting, ROBOTS> = filled(all);
    let mut assigned = Vec::new();
    while !waiting.is_empty() {
        let next = match rule.order {
            Order::ByNumber => 0,
            Order::BestPair => highest(&waiting),
        };
        let Some(asker) = waiting.get(next).copied() else { break };
        let Some((utility, place)) = best_of(rule, places, robots, asker.robot) else {
            waiting.retain(|one| one.robot != asker.robot);
            continue;
        };
        if let Some(asker) = waiting.get_mut(next) {
            asker.bound = utility;
        }
        if rule.order == Order::ByNumber || highest(&waiting) == next {
            waiting.retain(|one| one.robot != asker.robot);
            if let Some(at) = places.get(place).map(|place| place.position) {
                take(rule, places, at);
            }
            // There is room for as many as can wait.
            let _ = assigned.push(Assignment { robot: asker.robot, place });
        }
    }
    assigned
}

/// Takes away the places at a point to which a robot is going, which a negative gain marks, and
/// discounts the gains of those around it.
pub fn take(rule: &Rule, places: &mut [Place], at: Point2) {
    for place in places.iter_mut().filter(|place| place.gain >= 0.0) {
        let off = place.position.distance(at);
        if off < SAME {
            place.gain = -1.0;
        } else if let Some(sigma) = rule.discount {
            let ratio = off.0 / sigma.0;
            place.gain *= 1.0 - libm::expf(-0.5 * ratio * ratio);
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Waiting {
    robot: usize,
    /// The robot's utility is not above this.
    bound: f32,
}

/// The first robot with the highest bound.
fn highest(waiting: &[Waiting]) -> usize {
    let mut best = (0, f32::NEG_INFINITY);
    for (n, one) in waiting.iter().enumerate() {
        if one.bound > best.1 {
            best = (n, one.bound);
        }
    }
    best.0
}

/// The place of the largest utility for a robot, with that utility.
fn best_of(
    rule: &Rule,
    places: &[Place],
    robots: &impl Distances,
    robot: usize,
) -> Option<(f32, usize)> {
    let mut best: Option<(f32, usize)> = None;
    for (n, place) in places.iter().enumerate().filter(|(_, place)| place.gain >= 0.0) {
        let Some(way) = robots.distance(robot, n) else { continue };
        let utility = utility(rule, place.gain, way, || crowd(robots, robot, n));
        if best.is_none_or(|(most, _)| utility > most) {
            best = Some((utility, n));
        }
    }
    best
}

/// (n − 1)/D for a robot and a place.
fn crowd(robots: &impl Distances, robot: usize, place: usize) -> f32 {
    let others = (0..robots.robots()).filter(|&other| other != robot);
    let sum: f32 = others.filter_map(|o| robots.distance(o, place)).map(|m| m.0).sum();
    robots.robots().saturating_sub(1) as f32 / sum.max(LEAST_SUM)
}

pub(crate) fn utility(rule: &Rule, gain: f32, way: Metres, crowd: impl FnOnce() -> f32) -> f32 {
    match rule.utility {
        Utility::Exponential { lambda, crowd: counts } => {
            let others = if counts { crowd() } else { 0.0 };
            gain * libm::expf(-lambda * (way.0 + others))
        }
        Utility::Nearest => -way.0,
        Utility::Linear { weight } => weight * gain * CELL_AREA - way.0,
    }
}
