//! How good a chain was, by numbers with exact definitions (the book's chapter "Metrics").
//!
//! All of them are taken on the *true* large-scale losses L_j of the links, five times a second:
//! what a drone believes does not count.

use units::NodeId;

use crate::mission::{Mission, ROUND_US, World};
use crate::scenario::{Scenario, Start};
use crate::world::{Optimum, best_chain, best_chains};

/// Seconds in a round.
const ROUND_S: f32 = ROUND_US as f32 * 1e-6;
/// A quantity has converged when this part of all later samples is within the threshold,
const SUSTAINED: f32 = 0.95;
/// and at least this much time is left to show it.
const LEAST_REST_S: f32 = 10.0;
/// Steady-state figures are taken over the end of a mission, s.
const STEADY_S: f32 = 60.0;

/// What the best chain could do in a scenario, solved once for all its runs.
pub struct Reference {
    /// The optimum for the scenario's own number of links with the head where it starts, for
    /// scenarios that begin in the air.
    fixed: Option<Optimum>,
    /// Loss of the weakest link of the best chain, by links − 1 and head position in 0.1 m.
    table: Vec<Vec<units::Db>>,
}

impl Reference {
    /// Solves the scenario.
    #[must_use]
    pub fn of(scenario: &Scenario, world: &World) -> Self {
        let links = scenario.relays + 1;
        let head = match &scenario.start {
            Start::Mouth => None,
            Start::Random { head } => Some(*head),
            Start::Placed(places) => places.first().copied(),
        };
        let length = world.tunnel.centre_line().length();
        Self {
            fixed: head.map(|head| best_chain(&world.radio, links, head)),
            table: best_chains(&world.radio, links, length),
        }
    }

    /// Loss in dB of the weakest link of the best chain of `links` links to a head at `head`.
    #[must_use]
    pub fn worst(&self, links: usize, head: f32) -> f32 {
        let Some(row) = links.checked_sub(1).and_then(|n| self.table.get(n)) else {
            return f32::INFINITY;
        };
        let place = (head.max(0.0) / 0.1 + 0.5) as usize;
        row.get(place.min(row.len().saturating_sub(1))).map_or(f32::INFINITY, |db| db.0)
    }

    /// The least number of links whose best chain to a head at `head` has no link weaker than
    /// `limit` (a loss in dB); one more than there are drones for, where none will do.
    #[must_use]
    pub fn least_links(&self, limit: f32, head: f32) -> usize {
        let enough = |links: &usize| self.worst(*links, head) <= limit;
        (1..=self.table.len()).find(enough).unwrap_or(self.table.len() + 1)
    }
}

/// One sample of the chain.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// D: the largest difference between adjacent links, dB.
    difference: f32,
    /// The loss of the weakest link, dB.
    worst: f32,
    /// Weakest link over the best chain's, dB.
    gap: f32,
}

/// Watches one mission.
pub struct Watch<'a> {
    scenario: &'a Scenario,
    world: &'a World,
    reference: &'a Reference,
    samples: Vec<Sample>,
    /// The abscissae of all members, sample-major.
    positions: Vec<f32>,
    members: usize,
    chain: Vec<(NodeId, f32)>,
    order_lost: u32,
    most_links: usize,
    needed_links: usize,
    farthest: f32,
}

impl<'a> Watch<'a> {
    /// Nothing seen yet.
    #[must_use]
    pub fn new(scenario: &'a Scenario, world: &'a World, reference: &'a Reference) -> Self {
        Self {
            scenario,
            world,
            reference,
            samples: Vec::new(),
            positions: Vec::new(),
            members: scenario.relays + 2,
            chain: Vec::new(),
            order_lost: 0,
            most_links: 0,
            needed_links: 0,
            farthest: 0.0,
        }
    }

    /// Takes one sample, at the end of a round.
    pub fn look(&mut self, mission: &Mission<'_>) {
        let mut chain = std::mem::take(&mut self.chain);
        mission.chain(&mut chain);
        self.positions.extend(mission.bodies().map(|body| body.abscissa()));
        if chain.windows(2).any(|pair| pair[1].1 < pair[0].1) {
            self.order_lost += 1;
        }
        let sample = self.sample(&chain);
        self.samples.push(sample);
        self.chain = chain;
    }

    fn sample(&mut self, chain: &[(NodeId, f32)]) -> Sample {
        let mut sample = Sample { difference: 0.0, worst: f32::NEG_INFINITY, gap: 0.0 };
        let mut last: Option<f32> = None;
        for pair in chain.windows(2) {
            let loss = self.world.radio.strength(pair[0].1, pair[1].1).loss().0;
            sample.worst = sample.worst.max(loss);
            if let Some(last) = last {
                sample.difference = sample.difference.max((loss - last).abs());
            }
            last = Some(loss);
        }
        let links = chain.len().saturating_sub(1);
        if let Some(&(NodeId::HEAD, head)) = chain.last()
            && links > 0
        {
            let best = match &self.reference.fixed {
                Some(fixed) if links == self.scenario.relays + 1 => fixed.worst.0,
                _ => self.reference.worst(links, head),
            };
            sample.gap = sample.worst - best;
            self.most_links = self.most_links.max(links);
            self.farthest = self.farthest.max(head);
            let limit = self.scenario.agent.launch.limit.loss().0;
            let needed = self.reference.least_links(limit, head);
            self.needed_links = self.needed_links.max(needed);
        }
        sample
    }

    /// The verdict.
    #[must_use]
    pub fn verdict(&self, mission: &Mission<'_>) -> RunMetrics {
        let limit = self.scenario.agent.launch.limit.loss().0;
        let converged = |value: fn(&Sample) -> f32, threshold| {
            converged_at(self.samples.iter().map(value), threshold)
        };
        let steady = self.steady();
        let over = self.samples.iter().filter(|s| s.worst > limit + 0.5).count();
        RunMetrics {
            t3_s: converged(|s| s.difference, 3.0),
            t1_s: converged(|s| s.difference, 1.0),
            t_gap1_s: converged(|s| s.gap, 1.0),
            gap_db: mean(steady.iter().map(|s| s.gap)),
            difference_db: mean(steady.iter().map(|s| s.difference * s.difference)).sqrt(),
            position_sd_m: self.position_sd(),
            path_m: self.path(),
            bound_s: self.bound(),
            launched: self.most_links.saturating_sub(1),
            needed: self.needed_links.saturating_sub(1),
            violation: over as f32 / self.samples.len().max(1) as f32,
            peak_excess_db: self
                .samples
                .iter()
                .map(|s| s.worst - limit)
                .fold(f32::NEG_INFINITY, f32::max),
            farthest_m: self.farthest,
            order_lost: self.order_lost,
            wall_contacts: mission.wall_contacts(),
            drone_contacts: mission.drone_contacts(),
        }
    }

    fn steady(&self) -> &[Sample] {
        let count = (STEADY_S / ROUND_S) as usize;
        &self.samples[self.samples.len().saturating_sub(count)..]
    }

    /// Relays move between the head, which is first, and the base, which is last.
    fn relays(&self) -> std::ops::Range<usize> {
        1..self.members.saturating_sub(1)
    }

    /// Standard deviation of each relay's position about its own mean, pooled.
    fn position_sd(&self) -> f32 {
        let rounds = self.positions.len() / self.members;
        let steady = rounds.min((STEADY_S / ROUND_S) as usize);
        let from = rounds - steady;
        let variance = |relay: usize| {
            let at = |round: usize| self.positions[round * self.members + relay];
            let middle = mean((from..rounds).map(at));
            mean((from..rounds).map(|round| (at(round) - middle).powi(2)))
        };
        mean(self.relays().map(variance)).sqrt()
    }

    /// Way flown per relay along the tunnel.
    fn path(&self) -> f32 {
        let rounds = self.positions.len() / self.members;
        let way = |relay: usize| -> f32 {
            let at = |round: usize| self.positions[round * self.members + relay];
            (1..rounds).map(|round| (at(round) - at(round - 1)).abs()).sum()
        };
        mean(self.relays().map(way))
    }

    /// The least time in which any policy could bring every relay to its best place.
    fn bound(&self) -> f32 {
        let Some(fixed) = &self.reference.fixed else { return f32::NAN };
        let speed = self.scenario.agent.policy.max_speed.0;
        // The optimum lists the base first, a frame lists it last.
        let best = fixed.positions.iter().rev();
        let first = self.positions.iter().take(self.members);
        best.zip(first).map(|(best, first)| (best - first).abs() / speed).fold(0.0, f32::max)
    }
}

/// One run's figures. Times that never came are infinite; figures that a scenario does not have
/// are not numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunMetrics {
    /// When the largest difference between adjacent links came below 3 dB to stay, s.
    pub t3_s: f32,
    /// The same for 1 dB.
    pub t1_s: f32,
    /// When the weakest link came within 1 dB of the best chain's to stay, s.
    pub t_gap1_s: f32,
    /// Weakest link over the best chain's, mean of the last 60 s.
    pub gap_db: f32,
    /// Largest difference between adjacent links, root mean square of the last 60 s.
    pub difference_db: f32,
    /// Standard deviation of the relays' positions over the last 60 s.
    pub position_sd_m: f32,
    /// Way flown per relay.
    pub path_m: f32,
    /// The time that no policy can beat.
    pub bound_s: f32,
    /// The most relays that flew at once.
    pub launched: usize,
    /// The most that were needed at once.
    pub needed: usize,
    /// The part of the time in which a link was over 0.5 dB weaker than the launch limit.
    pub violation: f32,
    /// The weakest link there was, over the launch limit.
    pub peak_excess_db: f32,
    /// How far the head came.
    pub farthest_m: f32,
    /// Samples in which two drones had changed places.
    pub order_lost: u32,
    /// Touches of a wall.
    pub wall_contacts: u32,
    /// Touches between flying drones.
    pub drone_contacts: u32,
}

/// The first moment from which on 95 % of all samples are within the threshold, in seconds from
/// the start; infinite if there is none with at least 10 s to follow.
pub(crate) fn converged_at(values: impl DoubleEndedIterator<Item = f32>, threshold: f32) -> f32 {
    let least = (LEAST_REST_S / ROUND_S) as usize;
    let (mut within, mut seen) = (0_usize, 0_usize);
    let mut first = None;
    for value in values.rev() {
        seen += 1;
        let is_within = value <= threshold;
        within += usize::from(is_within);
        if is_within && seen >= least && within as f32 >= SUSTAINED * seen as f32 {
            first = Some(seen);
        }
    }
    first.map_or(f32::INFINITY, |from_end| (seen - from_end) as f32 * ROUND_S)
}

fn mean(values: impl Iterator<Item = f32>) -> f32 {
    let (sum, count) = values.fold((0.0_f64, 0_u32), |(s, n), v| (s + f64::from(v), n + 1));
    if count == 0 { f32::NAN } else { (sum / f64::from(count)) as f32 }
}

/// Flies a whole mission without keeping more of it than its figures.
#[must_use]
pub fn measure(scenario: &Scenario, world: &World, reference: &Reference, seed: u64) -> RunMetrics {
    let mut mission = Mission::new(scenario, world, seed);
    let mut watch = Watch::new(scenario, world, reference);
    while !mission.is_over() {
        mission.round();
        watch.look(&mission);
    }
    watch.verdict(&mission)
}
