//! Flies a swarm through its mission, and measures each phase.

use std::fmt;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use units::{Metres, Point2};
use virtual_forces::{Config, Heard, Member, Obstacles, Plan, Survey, Task, Wait};

use crate::swarm::{MOST_DRONES, Swarm};
use crate::{Leg, Phase, Place, Trouble};

/// The shortest way of a drone in one round (section 6.2 of the paper).
const SHORTEST_STEP: f32 = 0.05;
/// Rounds after which a survey counts as stuck, eight times the paper's 1210 for one drone,
const SURVEY_PATIENCE: u32 = 10_000;
/// and after which another phase does: fifty times the way of one drone through a passage.
const PATIENCE: u32 = 3_000;

/// A mission of one swarm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mission {
    /// The rule of its drones.
    pub config: Config,
    /// Their number.
    pub drones: u16,
    /// Where they fly.
    pub place: Place,
    /// The last phase that is flown.
    pub until: Phase,
    /// What goes wrong.
    pub trouble: Trouble,
}

/// There are no drones, or more than [`MOST_DRONES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooMany(pub u16);

impl fmt::Display for TooMany {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} drones: a swarm has 1 to {MOST_DRONES}", self.0)
    }
}

impl std::error::Error for TooMany {}

/// What a flight came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    /// The phases that were flown; the last one may have got stuck.
    pub legs: Vec<Leg>,
    /// The rounds that were flown, times the drones that flew in each.
    pub drone_rounds: u64,
}

/// Flies a mission, in which every drone starts on its first goal. The same `seed` gives the same
/// flight.
///
/// # Errors
/// Where the number of drones is none or too large.
pub fn fly(mission: &Mission, seed: u64) -> Result<Flight, TooMany> {
    if mission.drones == 0 || mission.drones > MOST_DRONES {
        return Err(TooMany(mission.drones));
    }
    let mut air = Air::new(mission, seed);
    let mut flight = Flight { legs: Vec::new(), drone_rounds: 0 };
    for phase in Phase::ALL.into_iter().filter(|phase| *phase <= mission.until) {
        let leg = air.leg(phase, &mut flight.drone_rounds);
        flight.legs.push(leg);
        if leg.rounds.is_none() {
            break;
        }
    }
    Ok(flight)
}

/// A swarm on its flight.
struct Air<'a> {
    mission: &'a Mission,
    plan: Plan,
    walls: Vec<(Point2, Point2)>,
    members: Vec<Member<{ MOST_DRONES as usize }>>,
    swarm: Swarm,
    /// The progress of each drone,
    progress: Vec<u16>,
    /// and what it tells of it.
    told: Vec<u16>,
    /// The errors of the positions in this round.
    errors: Vec<Point2>,
    /// The drones of which each one's packets arrive in this round.
    arrives: Vec<u64>,
    heard: Vec<Heard>,
    random: ChaCha8Rng,
    trouble: ChaCha8Rng,
    /// When each drone entered and left the passage, in rounds of the phase.
    passed: Vec<(Option<u32>, Option<u32>)>,
}

impl<'a> Air<'a> {
    fn new(mission: &'a Mission, seed: u64) -> Self {
        let (config, drones) = (mission.config, mission.drones);
        let (corner, area) = Place::area(drones);
        let survey = Survey::new(&config, corner, area, drones);
        let second = Survey::new(&config, corner, (Metres(0.0), Metres(0.0)), drones);
        let plan = Plan { drones, surveys: [survey, second], passage: mission.place.passage() };
        let starts = (0..drones).map(|number| survey.goal(number, 0).unwrap_or(corner)).collect();
        let count = usize::from(drones);
        // The draws for what goes wrong are a stream of their own, so that a rule flies the same
        // steps with trouble and without.
        let mut trouble = ChaCha8Rng::seed_from_u64(seed);
        trouble.set_stream(1);
        Self {
            mission,
            plan,
            walls: mission.place.walls(),
            members: (0..drones).map(|number| Member::new(config, plan, number)).collect(),
            swarm: Swarm::new(starts, config.radio_range),
            progress: vec![1; count],
            told: vec![1; count],
            errors: vec![Point2::default(); count],
            arrives: vec![u64::MAX; count],
            heard: Vec::with_capacity(count),
            random: ChaCha8Rng::seed_from_u64(seed),
            trouble,
            passed: vec![(None, None); count],
        }
    }

    /// Flies one phase.
    fn leg(&mut self, phase: Phase, drone_rounds: &mut u64) -> Leg {
        let mut leg = Leg::new(phase, self.ideal(phase));
        let mut links = self.swarm.links.clone();
        let patience = if phase == Phase::Survey { SURVEY_PATIENCE } else { PATIENCE };
        for round in 0..patience {
            if self.over(phase) {
                leg.rounds = Some(self.lasted(phase, round));
                leg.own_rounds = self.own_rounds();
                break;
            }
            self.fail(phase, round);
            self.disturb();
            self.told.copy_from_slice(&self.progress);
            for drone in 0..self.members.len() {
                if self.swarm.flying & (1 << drone) != 0 && !self.stands(phase, round, drone) {
                    self.step(drone, round, &mut leg);
                    *drone_rounds += 1;
                }
            }
            for (was, is) in links.iter_mut().zip(&self.swarm.links) {
                leg.links_lost += (*was & !is & self.swarm.flying).count_ones();
                leg.links_made += (is & !*was).count_ones();
                *was = *is;
            }
            leg.connected &= self.swarm.connected();
        }
        // Each link is counted at both ends.
        leg.links_lost /= 2;
        leg.links_made /= 2;
        leg.closest_drones = Metres(libm::sqrtf(leg.closest_drones.0));
        leg
    }

    /// Moves one drone by one round. The closest distance is kept squared.
    fn step(&mut self, drone: usize, round: u32, leg: &mut Leg) {
        let uniform = self.random.next_u32() as f32 / u32::MAX as f32;
        let config = &self.mission.config;
        let length = SHORTEST_STEP + uniform * (config.longest_step.0 - SHORTEST_STEP);
        let hops = if config.wait == Wait::Neighbours { 2 } else { u16::MAX };
        let (positions, errors, told) = (&self.swarm.positions, &self.errors, &self.told);
        let says = |other: usize| (shifted(positions[other], errors[other]), told[other]);
        let noise = self.mission.trouble.noise;
        self.swarm.hear(drone, hops, &self.arrives, noise, says, &mut self.heard);
        let (truly, error) = (self.swarm.positions[drone], self.errors[drone]);
        let here = shifted(truly, error);
        let surveys = matches!(self.members[drone].task(), Task::Survey { .. });
        let obstacles = if surveys {
            Obstacles::default()
        } else {
            // The sensor sees walls from where the drone is, and the drone from where it thinks to be.
            let walls = self.walls.iter().map(|(a, b)| (shifted(*a, error), shifted(*b, error)));
            Obstacles::seen(here, config.obstacle_range, walls)
        };
        let member = &mut self.members[drone];
        let heard = self.heard.iter().copied();
        let end = member.step(here, noise, heard, &obstacles, Metres(length));
        self.progress[drone] = member.progress();
        if !self.mission.trouble.late_news {
            self.told[drone] = self.progress[drone];
        }
        let end = Point2::new(truly.x + end.x - here.x, truly.y + end.y - here.y);
        let nearest = self.swarm.place(drone, end);
        leg.closest_drones.0 = leg.closest_drones.0.min(nearest);
        if !surveys {
            leg.closest_wall.0 = leg.closest_wall.0.min(self.wall_distance(end));
        }
        if leg.phase == Phase::Crossing {
            let (entered, left) = &mut self.passed[drone];
            if end.x > 0.0 {
                entered.get_or_insert(round);
            }
            if end.x > self.plan.passage.length.0 {
                left.get_or_insert(round);
            }
        }
    }

    fn wall_distance(&self, point: Point2) -> f32 {
        let range = Metres(f32::INFINITY);
        Obstacles::seen(point, range, self.walls.iter().copied()).clearance(point).0
    }

    fn flying(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.members.len()).filter(|drone| self.swarm.flying & (1 << drone) != 0)
    }

    /// Says whether a phase is over.
    fn over(&self, phase: Phase) -> bool {
        let goals = self.plan.surveys[0].goals();
        match phase {
            Phase::Survey => self.flying().all(|drone| self.progress[drone] >= goals),
            Phase::Setup => {
                let crosses = |drone: usize| {
                    matches!(self.members[drone].task(), Task::Cross { .. } | Task::Done)
                };
                self.flying().any(crosses)
                    || self.flying().all(|drone| self.progress[drone] > goals)
            }
            Phase::Crossing => self.flying().all(|drone| self.passed[drone].1.is_some()),
        }
    }

    /// Returns the rounds of a phase that is over after `round` rounds.
    fn lasted(&self, phase: Phase, round: u32) -> u32 {
        match phase {
            Phase::Survey | Phase::Setup => round,
            Phase::Crossing => {
                let first = self.passed.iter().filter_map(|(entered, _)| *entered).min();
                round - first.unwrap_or(0)
            }
        }
    }

    fn own_rounds(&self) -> f32 {
        let own = self.flying().filter_map(|drone| match self.passed[drone] {
            (Some(entered), Some(left)) => Some((left - entered) as f32),
            _ => None,
        });
        own.sum::<f32>() / self.flying().count().max(1) as f32
    }

    fn ideal(&self, phase: Phase) -> f32 {
        let longest = self.mission.config.longest_step.0;
        let mean = 0.5 * (SHORTEST_STEP + longest);
        match phase {
            Phase::Survey => self.plan.surveys[0].way().0 / mean,
            Phase::Setup => {
                let entrance = self.plan.passage.entrance;
                let ways =
                    self.flying().map(|drone| self.swarm.positions[drone].distance(entrance).0);
                ways.fold(0.0, f32::max) / mean
            }
            Phase::Crossing => self.mission.place.path().0 / longest,
        }
    }

    /// Lets the drone fall that falls in this round.
    fn fail(&mut self, phase: Phase, round: u32) {
        let failure = self.mission.trouble.failure.filter(|failure| {
            failure.phase == phase && failure.after == round && failure.stands == 0
        });
        if let Some(failure) = failure {
            self.swarm.drop_out(usize::from(failure.drone));
        }
    }

    /// Says whether a drone stands still in this round.
    fn stands(&self, phase: Phase, round: u32, drone: usize) -> bool {
        self.mission.trouble.failure.is_some_and(|failure| {
            let since = round.checked_sub(failure.after);
            failure.phase == phase
                && usize::from(failure.drone) == drone
                && since.is_some_and(|since| since < failure.stands)
        })
    }

    /// Draws the errors and the lost packets of a round.
    fn disturb(&mut self) {
        let Trouble { noise, loss, .. } = self.mission.trouble;
        let mut uniform = || (self.trouble.next_u32() >> 8) as f32 / 16_777_216.0;
        if noise.0 > 0.0 {
            for error in &mut self.errors {
                let radius = noise.0 * libm::sqrtf(uniform());
                let (sin, cos) = libm::sincosf(core::f32::consts::TAU * uniform());
                *error = Point2::new(radius * cos, radius * sin);
            }
        }
        if loss > 0.0 {
            for arrives in &mut self.arrives {
                *arrives = (0..64).fold(0, |bits, n| bits | u64::from(uniform() >= loss) << n);
            }
        }
    }
}

fn shifted(point: Point2, by: Point2) -> Point2 {
    Point2::new(point.x + by.x, point.y + by.y)
}
