//! Computes the metrics of a chain, as the book's chapter "Metrics" defines them.
//!
//! The metrics of links are computed from the *true* losses L_j of the links, five times a second;
//! the drones' own estimates are not used. What is compared with the best chain or with other links
//! is the large-scale loss; what is compared with a limit is what a receiver gets.

mod chain;
mod cruise;
mod explore;
mod hold;
mod reference;
mod swarm;

use units::{MissionKind, NodeId, Order, Role};
use world::{SkeletonPlace, World};

use super::verdict::evidence::{EvidenceRecord, Seen};
use super::verdict::{Judgement, judge};
use bodies::craft::record::FlightMetrics;
use mission::{Linked, Mission, ROUND_US, RadioMetrics};
use scenario::{Scenario, Start};

use chain::Chain;
use cruise::CruiseRecord;
pub use explore::ExploreMetrics;
use explore::ExploreRecord;
pub(crate) use hold::converged_at;
pub use hold::{HoldMetrics, NoHold};
use hold::{HoldRecord, Sample};
pub use reference::Reference;
pub use swarm::SwarmMetrics;
use swarm::SwarmRecord;

/// Seconds in a round.
pub(super) const ROUND_S: f32 = ROUND_US as f32 * 1e-6;

/// Collects the metrics of one mission, round by round.
pub struct Watch<'a> {
    scenario: &'a Scenario,
    world: &'a World,
    reference: &'a Reference,
    hold: Result<HoldRecord, NoHold>,
    cruise: Option<CruiseRecord>,
    exploration: Exploration,
    /// The record of a swarm, which is no chain: it has none of the other samples.
    swarm: Option<SwarmRecord>,
    /// The record of an exploration, which is no chain either.
    explore: Option<ExploreRecord>,
    /// The places of all members at the end of the first round.
    start: Vec<SkeletonPlace>,
    chain: Vec<Linked>,
    order_lost: u32,
    most_relays: usize,
    needed_links: usize,
    farthest: f32,
    /// The last place that was farther by [`FARTHER`] than the one before it, m, and when an explorer
    /// came there, s.
    advance: (f32, f32),
    heard: Heard,
    evidence: EvidenceRecord,
}

/// A head that has come so near to its farthest place has come there, m.
const FARTHER: f32 = 0.5;
/// An explorer within this of its first place is still there, m.
const HOVERING: f32 = 0.5;
/// A link violates the limit when it is weaker by more than this, dB.
const VIOLATION: f32 = 0.5;

/// The base has lost the head when it has had no telemetry of it for longer, s. A packet or
/// two, of drones that lie on the ground after their batteries' ends, is no link.
const SILENCE: f32 = 10.0;

/// Until when the base has heard the head without a break, s.
#[derive(Default)]
struct Heard {
    until: Option<f32>,
}

impl Heard {
    fn take(&mut self, mission: &Mission<'_>) {
        let Some(told) = mission.told(usize::from(NodeId::HEAD.0)) else { return };
        let at = (told.at_us as f64 * 1e-6) as f32;
        if self.until.is_none_or(|until| at - until <= SILENCE) {
            self.until = Some(at);
        }
    }
}

/// The weakness of links while the operator has the head explore.
#[derive(Default)]
struct Exploration {
    samples: u32,
    /// Samples in which a link was more than 0.5 dB weaker than the limit.
    violations: u32,
    /// The largest loss of any link over the limit, dB.
    peak_excess: Option<f32>,
}

impl Exploration {
    fn take(&mut self, excess: f32) {
        self.samples += 1;
        self.violations += u32::from(excess > VIOLATION);
        self.peak_excess = Some(self.peak_excess.map_or(excess, |peak| peak.max(excess)));
    }

    fn violation(&self) -> f32 {
        self.violations as f32 / self.samples.max(1) as f32
    }
}

impl<'a> Watch<'a> {
    /// Makes a watch that has taken no sample yet.
    #[must_use]
    pub fn new(scenario: &'a Scenario, world: &'a World, reference: &'a Reference) -> Self {
        let members = scenario.drones.explorers + scenario.drones.relays + 1;
        let losses = || scenario.losses.iter().map(|loss| loss.at_us);
        let hold = scenario.hold().map(|span| HoldRecord::new(span, members, losses()));
        Self {
            scenario,
            world,
            reference,
            hold: hold.ok_or(NoHold::NeverStill),
            cruise: scenario.cruise().map(CruiseRecord::new),
            exploration: Exploration::default(),
            swarm: SwarmRecord::of(scenario),
            explore: ExploreRecord::of(scenario),
            start: Vec::new(),
            chain: Vec::new(),
            order_lost: 0,
            most_relays: 0,
            needed_links: 0,
            farthest: 0.0,
            advance: (0.0, 0.0),
            heard: Heard::default(),
            evidence: EvidenceRecord::new(scenario),
        }
    }

    /// Takes one sample, at the end of a round. While the head is not a link of the chain, before
    /// take-off and after landing, there is no chain to be sampled.
    pub fn look(&mut self, mission: &Mission<'_>) {
        self.evidence.look(self.scenario, mission);
        if let Some(swarm) = &mut self.swarm {
            return swarm.look(self.scenario, self.world, mission);
        }
        if let Some(explore) = &mut self.explore {
            return explore.look(self.scenario, self.world, mission);
        }
        self.heard.take(mission);
        let mut chain = std::mem::take(&mut self.chain);
        mission.chain(&mut chain);
        if self.start.is_empty() {
            self.start.extend(mission.places());
        }
        if mission.is_live() {
            self.hold = Err(NoHold::Live);
            self.cruise = None;
        }
        let (explorers, trunk): (Vec<Linked>, Vec<Linked>) =
            chain.iter().partition(|link| self.role(link) == Role::Head);
        let chains: Vec<Chain> =
            explorers.iter().map(|explorer| Chain::of(mission, &trunk, *explorer)).collect();
        let is_disordered = chains.iter().any(|chain| chain.is_out_of_order(self.world))
            || chains.is_empty() && Chain::is_disordered(self.world, &trunk);
        self.order_lost += u32::from(is_disordered);
        let of_head = |chain: &&Chain| chain.explorer().id == NodeId::HEAD;
        let own = chains.iter().find(of_head).filter(|chain| chain.members.len() > 1);
        let head = own.map(|chain| *chain.explorer());
        let surplus = head.map_or(f32::NAN, |_| self.sample(mission, &chains));
        let seen = Seen { head, is_disordered, surplus };
        self.evidence.look_at_chain(self.scenario, self.world, mission, &seen);
        self.chain = chain;
    }

    /// Takes a sample of chains, and returns the number of relays beyond need.
    fn sample(&mut self, mission: &Mission<'_>, chains: &[Chain]) -> f32 {
        let limit = self.scenario.agent.launch.limit.loss().0;
        let (mut worst, mut difference) = (f32::NEG_INFINITY, 0.0_f32);
        let mut gap = f32::NEG_INFINITY;
        let (mut farthest, mut needed_links, mut links) = (0.0_f32, 0, 0);
        for chain in chains {
            let explorer = chain.explorer();
            worst = worst.max(chain.received);
            difference = difference.max(chain.difference());
            gap = gap.max(chain.weakest() - self.best(chain.losses.len(), explorer));
            needed_links = needed_links.max(self.reference.least_links(limit, explorer));
            links = links.max(chain.losses.len());
            farthest = farthest.max(explorer.way);
        }
        self.needed_links = self.needed_links.max(needed_links);
        self.most_relays = self.most_relays.max(links - 1);
        let now_us = mission.time_us();
        self.note_farthest(farthest, now_us);
        let surplus = links as f32 - needed_links as f32;
        // On the way home nothing is explored or held, also where a drone has called for it.
        if mission.is_recalled() {
            return surplus;
        }
        if matches!(mission.task(), Order::Explore(..)) {
            self.exploration.take(worst - limit);
        }
        if let Some(cruise) = self.cruise.as_mut() {
            cruise.take(now_us, gap);
        }
        if let Ok(hold) = self.hold.as_mut()
            && hold.covers(now_us)
        {
            // The links between base and last relay are the same in every chain.
            let first = chains.iter().take(1).flat_map(Chain::links);
            let others = chains.iter().skip(1).filter_map(|chain| chain.links().last());
            let sample = Sample {
                time: hold.time(now_us),
                difference,
                gap,
                is_violated: worst - limit > VIOLATION,
                surplus,
            };
            hold.take(sample, first.chain(others), mission.ways());
        }
        surplus
    }

    fn note_farthest(&mut self, way: f32, now_us: u64) {
        self.farthest = self.farthest.max(way);
        if way > self.advance.0 + FARTHER {
            self.advance = (way, (now_us as f64 * 1e-6) as f32);
        }
    }

    fn role(&self, link: &Linked) -> Role {
        self.scenario.drones.role(usize::from(link.id.0))
    }

    /// The loss of the weakest link of the best chain of so many links to an explorer, dB.
    fn best(&self, links: usize, explorer: &Linked) -> f32 {
        match &self.reference.fixed {
            Some((path, fixed))
                if links == self.reference.links
                    && (path.length() - explorer.way).abs() < HOVERING =>
            {
                fixed.worst.0
            }
            _ => self.reference.worst(links, explorer),
        }
    }

    /// Returns the metrics of the mission.
    #[must_use]
    pub fn verdict(&self, mission: &Mission<'_>) -> RunMetrics {
        let drones = &self.scenario.drones;
        let relays = drones.explorers..drones.flying();
        let relays: Vec<_> = relays.filter(|relay| !mission.is_lost(*relay)).collect();
        let hold = self.hold.as_ref().map_err(|why| *why).and_then(|hold| hold.metrics(&relays));
        // Where the drones are in the air from the start, none is launched.
        let launches =
            matches!(drones.start, Start::Mouth) && self.scenario.mission == MissionKind::Chain;
        let of_launches = |value: f32| if launches { value } else { f32::NAN };
        let hold = hold.map(|hold| HoldMetrics {
            violation: of_launches(hold.violation),
            relays_beyond_need: of_launches(hold.relays_beyond_need),
            ..hold
        });
        RunMetrics {
            hold,
            bound_s: self.bound(),
            launched: of_launches(self.most_relays as f32),
            needed: of_launches(self.needed_links.saturating_sub(1) as f32),
            violation: of_launches(self.exploration.violation()),
            peak_excess_db: of_launches(self.exploration.peak_excess.unwrap_or(f32::NAN)),
            cruise_gap_db: self.cruise.as_ref().map_or(f32::NAN, CruiseRecord::gap),
            farthest_m: self.farthest,
            t_farthest_s: self.advance.1,
            head_heard_until_s: self.heard.until.unwrap_or(f32::NAN),
            still_flying: still_flying(self.scenario, mission),
            order_lost: self.order_lost,
            wall_contacts: mission.wall_contacts(),
            drone_contacts: mission.drone_contacts(),
            ground_contacts: mission.ground_contacts(),
            swarm: self.swarm.as_ref().map(SwarmRecord::metrics),
            explore: self.explore.as_ref().map(|explore| explore.metrics(mission)),
            radio: mission.radio(),
            flight: FlightMetrics::of(
                mission.bodies().filter_map(|body| Some(body.craft()?.record())),
            ),
        }
    }

    /// Returns the verdict of the mission that has these metrics.
    #[must_use]
    pub fn judgement(&self, mission: &Mission<'_>, metrics: &RunMetrics) -> Judgement {
        let evidence = self.evidence.evidence(self.scenario, mission);
        judge(self.scenario, self.world, self.reference, metrics, &evidence)
    }

    /// The least time in which any policy could bring every relay to its best place.
    fn bound(&self) -> f32 {
        let Some((path, fixed)) = &self.reference.fixed else { return f32::NAN };
        let speed = self.scenario.agent.policy.max_speed.0;
        // The optimum lists the base first, a frame lists it last.
        let best = fixed.positions.iter().rev();
        let others = 1..self.scenario.drones.explorers;
        let chain = self.start.iter().enumerate().filter(|(n, _)| !others.contains(n));
        let first = chain.map(|(_, place)| place);
        let way = |(best, first): (&f32, &SkeletonPlace)| {
            self.world.skeleton().distance(path.at(*best), *first).0 / speed
        };
        best.zip(first).map(way).fold(0.0, f32::max)
    }
}

/// The metrics of one mission. A metric that the scenario does not have is NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunMetrics {
    /// The metrics of the hold, or the reason why there are none.
    pub hold: Result<HoldMetrics, NoHold>,
    /// A lower bound on the time of full convergence under any policy, s.
    pub bound_s: f32,
    /// The largest number of relays that were in the chain at the same time.
    pub launched: f32,
    /// The largest number of relays that the best chain needed at any moment.
    pub needed: f32,
    /// The part of the time of exploration in which a link was over 0.5 dB weaker than the launch
    /// limit.
    pub violation: f32,
    /// The amount by which the weakest link of the exploration exceeded the launch limit, in loss.
    pub peak_excess_db: f32,
    /// The loss of the weakest link minus that of the best chain's while the operator lets the head
    /// fly in, mean over the second half of that time.
    pub cruise_gap_db: f32,
    /// The longest distance from the base, along the tunnel, that the head reached.
    pub farthest_m: f32,
    /// The time at which the head first came within 0.5 m of that distance, s since the start.
    pub t_farthest_s: f32,
    /// When the base last received the telemetry of the head before it went without for more than
    /// 10 s, s since the start.
    pub head_heard_until_s: f32,
    /// The number of drones that still flew at the end, although the last order was to return or to
    /// land.
    pub still_flying: f32,
    /// The number of samples in which two drones had changed places.
    pub order_lost: u32,
    /// The number of times that a drone touched a wall.
    pub wall_contacts: u32,
    /// The number of times that two flying drones touched.
    pub drone_contacts: u32,
    /// The number of times that a drone, flying or landed, touched one that stood on the ground.
    pub ground_contacts: u32,
    /// The metrics of a swarm; `None` on another mission.
    pub swarm: Option<SwarmMetrics>,
    /// The metrics of an exploration; `None` on another mission.
    pub explore: Option<ExploreMetrics>,
    /// The metrics of the radio.
    pub radio: RadioMetrics,
    /// The metrics of the flights, where drones are rigid bodies.
    pub flight: Option<FlightMetrics>,
}

impl RunMetrics {
    /// Returns a metric of the hold; NaN where there was no hold.
    #[must_use]
    pub fn held(&self, of: impl Fn(&HoldMetrics) -> f32) -> f32 {
        self.hold.as_ref().map_or(f32::NAN, of)
    }
}

/// How many drones fly that were called down; not a number where none was. A drone that the
/// scenario has let fall is on the ground, whatever its agent last did.
fn still_flying(scenario: &Scenario, mission: &Mission<'_>) -> f32 {
    if !matches!(scenario.pilot.last().map(|step| step.task), Some(Order::Return | Order::Land)) {
        return f32::NAN;
    }
    let drones = mission.bodies().zip(mission.states()).take(scenario.drones.flying());
    drones.filter(|(body, state)| body.height() > 0.0 && state.is_airborne()).count() as f32
}

fn mean(values: impl Iterator<Item = f32>) -> f32 {
    let (sum, count) = values.fold((0.0_f64, 0_u32), |(s, n), v| (s + f64::from(v), n + 1));
    if count == 0 { f32::NAN } else { (sum / f64::from(count)) as f32 }
}

/// The value that this part of all values does not exceed; not a number of none.
fn quantile(values: &mut [f32], part: f32) -> f32 {
    values.sort_by(f32::total_cmp);
    let at = (part * values.len() as f32).ceil() as usize;
    values.get(at.saturating_sub(1)).copied().unwrap_or(f32::NAN)
}

/// Flies a whole mission without keeping more of it than its figures.
#[must_use]
pub fn measure(scenario: &Scenario, world: &World, reference: &Reference, seed: u64) -> RunMetrics {
    watched(scenario, world, reference, &mut Mission::new(scenario, world, seed))
}

/// The same of a mission that has not begun.
#[must_use]
pub fn watched(
    scenario: &Scenario,
    world: &World,
    reference: &Reference,
    mission: &mut Mission<'_>,
) -> RunMetrics {
    let mut watch = Watch::new(scenario, world, reference);
    while !mission.is_over() {
        mission.round();
        watch.look(mission);
    }
    watch.verdict(mission)
}
