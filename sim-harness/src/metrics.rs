//! How good a chain was, by numbers with exact definitions (the book's chapter "Metrics").
//!
//! All of them are taken on the *true* large-scale losses L_j of the links, five times a second:
//! what a drone believes does not count.

use units::NodeId;

use crate::craft::record::FlightMetrics;
use crate::mission::{Mission, ROUND_US, RadioMetrics, World};
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
    /// Loss of the weakest link of the best chain, by links − 1 and by head position in equal
    /// steps from the base to the far end.
    table: Vec<Vec<units::Db>>,
    length: f32,
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
            length,
        }
    }

    /// Loss in dB of the weakest link of the best chain of `links` links to a head at `head`.
    #[must_use]
    pub fn worst(&self, links: usize, head: f32) -> f32 {
        let Some(row) = links.checked_sub(1).and_then(|n| self.table.get(n)) else {
            return f32::INFINITY;
        };
        let last = row.len().saturating_sub(1);
        let place = (head / self.length * last as f32).clamp(0.0, last as f32);
        let at = |n: usize| row.get(n.min(last)).map_or(f32::INFINITY, |db| db.0);
        let (near, far) = (at(place as usize), at(place as usize + 1));
        near + (place - place.floor()) * (far - near)
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
    /// When, s.
    time: f32,
    /// D: the largest difference between adjacent links, dB.
    difference: f32,
    /// The loss of the weakest link, dB.
    worst: f32,
    /// Weakest link over the best chain's, dB.
    gap: f32,
}

/// The part of a hold, at its end, over which links are averaged.
const HOLD_END: f64 = 0.3;

/// The links' losses at the end of the hold.
struct Hold {
    from_us: u64,
    until_us: u64,
    /// Sums over the samples, in the order of the chain.
    sums: Vec<f64>,
    samples: u32,
    /// The number of links changed.
    broken: bool,
}

impl Hold {
    fn of(scenario: &Scenario) -> Option<Self> {
        let (from, until) = scenario.hold()?;
        let end = ((until - from) as f64 * HOLD_END) as u64;
        let from_us = until - end;
        Some(Self { from_us, until_us: until, sums: Vec::new(), samples: 0, broken: false })
    }

    fn look(&mut self, now_us: u64, losses: impl Iterator<Item = f32>) {
        if now_us <= self.from_us || now_us > self.until_us {
            return;
        }
        let mut links = 0;
        for (n, loss) in losses.enumerate() {
            if self.samples == 0 {
                self.sums.push(0.0);
            }
            if let Some(sum) = self.sums.get_mut(n) {
                *sum += f64::from(loss);
            }
            links = n + 1;
        }
        self.broken |= links != self.sums.len();
        self.samples += 1;
    }

    /// The largest difference between the mean losses of any two links.
    fn spread(&self) -> f32 {
        if self.broken || self.samples == 0 {
            return f32::NAN;
        }
        let most = self.sums.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let least = self.sums.iter().copied().fold(f64::INFINITY, f64::min);
        ((most - least) / f64::from(self.samples)) as f32
    }
}

/// Watches one mission.
pub struct Watch<'a> {
    scenario: &'a Scenario,
    world: &'a World,
    reference: &'a Reference,
    samples: Vec<Sample>,
    /// The abscissae of all members at the end of the first round.
    start: Vec<f32>,
    /// The abscissae of all members, sample-major.
    positions: Vec<f32>,
    members: usize,
    chain: Vec<(NodeId, f32)>,
    order_lost: u32,
    most_links: usize,
    needed_links: usize,
    farthest: f32,
    hold: Option<Hold>,
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
            start: Vec::new(),
            positions: Vec::new(),
            members: scenario.relays + 2,
            chain: Vec::new(),
            order_lost: 0,
            most_links: 0,
            needed_links: 0,
            farthest: 0.0,
            hold: Hold::of(scenario),
        }
    }

    /// Takes one sample, at the end of a round. While the head is not a link of the chain, before
    /// take-off and after landing, there is no chain to be sampled.
    pub fn look(&mut self, mission: &Mission<'_>) {
        let mut chain = std::mem::take(&mut self.chain);
        mission.chain(&mut chain);
        if self.start.is_empty() {
            self.start.extend(mission.bodies().map(|body| body.abscissa()));
        }
        if chain.windows(2).any(|pair| pair[1].1 < pair[0].1) {
            self.order_lost += 1;
        }
        if let Some(&(NodeId::HEAD, head)) = chain.last()
            && chain.len() > 1
        {
            let sample = self.sample(mission, &chain, head);
            if let Some(hold) = &mut self.hold {
                let strength = |pair: &[(NodeId, f32)]| {
                    self.world.radio.strength(pair[0].1, pair[1].1).loss().0
                };
                hold.look(mission.time_us(), chain.windows(2).map(strength));
            }
            self.samples.push(sample);
            self.positions.extend(mission.bodies().map(|body| body.abscissa()));
        }
        self.chain = chain;
    }

    fn sample(&mut self, mission: &Mission<'_>, chain: &[(NodeId, f32)], head: f32) -> Sample {
        let losses =
            chain.windows(2).map(|pair| self.world.radio.strength(pair[0].1, pair[1].1).loss().0);
        let (mut worst, mut difference) = (f32::NEG_INFINITY, 0.0_f32);
        let mut before: Option<f32> = None;
        for loss in losses {
            worst = worst.max(loss);
            difference = difference.max(before.map_or(0.0, |before| (loss - before).abs()));
            before = Some(loss);
        }
        let links = chain.len() - 1;
        let best = match &self.reference.fixed {
            Some(fixed) if links == self.scenario.relays + 1 => fixed.worst.0,
            _ => self.reference.worst(links, head),
        };
        self.most_links = self.most_links.max(links);
        self.farthest = self.farthest.max(head);
        let limit = self.scenario.agent.launch.limit.loss().0;
        self.needed_links = self.needed_links.max(self.reference.least_links(limit, head));
        let time = (mission.time_us() as f64 * 1e-6) as f32;
        Sample { time, difference, worst, gap: worst - best }
    }

    /// The verdict.
    #[must_use]
    pub fn verdict(&self, mission: &Mission<'_>) -> RunMetrics {
        let limit = self.scenario.agent.launch.limit.loss().0;
        let converged = |value: fn(&Sample) -> f32, threshold| {
            converged_at(self.samples.iter().map(|sample| (sample.time, value(sample))), threshold)
        };
        let steady = self.steady();
        let over = self.samples.iter().filter(|s| s.worst > limit + 0.5).count();
        let excess = self.samples.iter().map(|s| s.worst - limit).fold(f32::NEG_INFINITY, f32::max);
        // Where everybody is in the air from the start, nobody is launched.
        let launches = matches!(self.scenario.start, Start::Mouth);
        let of_launches = |value: f32| if launches { value } else { f32::NAN };
        RunMetrics {
            t3_s: converged(|s| s.difference, 3.0),
            t1_s: converged(|s| s.difference, 1.0),
            t_gap1_s: converged(|s| s.gap, 1.0),
            gap_db: mean(steady.iter().map(|s| s.gap)),
            difference_db: mean(steady.iter().map(|s| s.difference * s.difference)).sqrt(),
            position_sd_m: self.position_sd(),
            path_m: self.path(),
            bound_s: self.bound(),
            launched: of_launches(self.most_links.saturating_sub(1) as f32),
            needed: of_launches(self.needed_links.saturating_sub(1) as f32),
            violation: of_launches(over as f32 / self.samples.len().max(1) as f32),
            peak_excess_db: of_launches(excess),
            farthest_m: self.farthest,
            order_lost: self.order_lost,
            wall_contacts: mission.wall_contacts(),
            drone_contacts: mission.drone_contacts(),
            hold_spread_db: self.hold.as_ref().map_or(f32::NAN, Hold::spread),
            radio: mission.radio(),
            flight: FlightMetrics::of(
                mission.bodies().filter_map(|body| Some(body.craft()?.record())),
            ),
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
        let first = self.start.iter();
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
    pub launched: f32,
    /// The most that were needed at once.
    pub needed: f32,
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
    /// The largest difference between any two links, each averaged over the last 30 % of the
    /// operator's longest hold, dB.
    pub hold_spread_db: f32,
    /// What the radio did.
    pub radio: RadioMetrics,
    /// What the flights were like; at flight level.
    pub flight: Option<FlightMetrics>,
}

/// The first moment from which on 95 % of all samples are within the threshold; infinite if there
/// is none with at least 10 s to follow. Samples are pairs of a time and a value.
pub(crate) fn converged_at(
    samples: impl DoubleEndedIterator<Item = (f32, f32)>,
    threshold: f32,
) -> f32 {
    let least = (LEAST_REST_S / ROUND_S) as usize;
    let (mut within, mut seen) = (0_usize, 0_usize);
    let mut first = f32::INFINITY;
    for (time, value) in samples.rev() {
        seen += 1;
        let is_within = value <= threshold;
        within += usize::from(is_within);
        if is_within && seen >= least && within as f32 >= SUSTAINED * seen as f32 {
            first = time;
        }
    }
    first
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
