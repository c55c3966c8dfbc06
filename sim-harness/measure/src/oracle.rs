//! Computes how far along the commanded way a head can get with its relays, by when, and how many
//! relays that takes, for one who knows the world, the radio and the pilot.
//!
//! No link of the oracle's chain is ever weaker than the launch limit. It knows the law of the path
//! loss, the shadows and the gains of the radios; fades, which are centimetres or seconds long, no pilot
//! can fly by. Its relays take off one after the other from the first order on, ahead of need, each
//! after the climb and the arm delay of the one before, fly at the policy's largest speed, keep their
//! order and 0.4 m of clearance. Its head flies as the pilot's stick says, wherever its chain
//! lets it be.
//!
//! For every place of a drone, on a grid, it computes the earliest time at which the
//! drone can be there with those behind it at places that bear it. That is exact for a chain that
//! stands, and optimistic for one that moves, since the drones behind might not be able to change
//! their places without a weak link on the way. So the oracle is a bound: no policy gets farther or is
//! there earlier, up to the grid, without a link below the limit.

mod links;

use units::Order;
use world::World;

use mission::ROUND_US;
use scenario::{Scenario, Start};

use links::Links;
use world::{Path, SkeletonPlace};

/// The distance between the places that are tried, m, as of the [best chains](world::BestChains).
const STEP_M: f32 = 0.1;
/// Two drones come no nearer to each other, m: the wake and the guards of both.
const APART_M: f32 = 0.4;
/// A head stands no nearer to the wall that ends its gallery, m: there its beams slow it down
/// (`NavConfig::DEFAULT`).
const BEFORE_WALL_M: f32 = 0.45;
/// How far a gallery may go on beyond the end of its centre-line, m.
const BEYOND_END_M: f32 = 26.0;

/// The way that the pilot's orders lead along.
#[derive(Clone, Debug)]
pub struct Commanded {
    /// The shortest way from the base to the end that the orders lead to.
    pub way: Path,
    /// Where the pilot first looks into a dead end, if so.
    pub detour: Option<Detour>,
    /// How long a full battery carries the head, s, where it turns back with what carries it home.
    pub endurance_s: Option<f32>,
}

/// A dead end into which the pilot looks before the chain goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detour {
    /// The junction's place along the way, m.
    pub at_m: f32,
    /// The length of the dead end, m.
    pub length_m: f32,
    /// The moment from which on the orders lead along the way.
    pub until_us: u64,
}

impl Commanded {
    /// The way to the end of the main gallery.
    #[must_use]
    pub fn along_main(world: &World) -> Self {
        let along = world.skeleton().edge(0).line().length();
        Self {
            way: world.path_to(SkeletonPlace { edge: 0, along }),
            detour: None,
            endurance_s: None,
        }
    }

    /// How far along the way a place is; beside the way, where its gallery leaves it.
    #[must_use]
    pub fn along(&self, world: &World, place: SkeletonPlace) -> f32 {
        let length = self.way.length();
        let to_end = world.skeleton().distance(place, self.way.at(length)).0;
        (0.5 * (world.way(place) + length - to_end)).clamp(0.0, length)
    }
}

/// Why the oracle's head got no farther.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The pilot ordered no more, or the head's battery called it home.
    Pilot,
    /// The gallery ends.
    Gallery,
    /// More relays would be needed.
    Relays,
    /// No drone anywhere behind could bear it.
    Radio,
}

impl Ended {
    /// The name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pilot => "pilot",
            Self::Gallery => "gallery",
            Self::Relays => "relays",
            Self::Radio => "radio",
        }
    }
}

/// What a head can reach.
#[derive(Clone, Debug)]
pub struct Oracle {
    /// How far along the way radio, relays and walls let a head be, m.
    pub reach_m: f32,
    /// How far it comes by the pilot's orders, m.
    pub depth_m: f32,
    /// When it first is there, s since the start.
    pub at_s: f32,
    /// The least number of relays with which it gets there.
    pub least_relays: usize,
    /// Why it gets no farther.
    pub ended: Ended,
    /// When the head first is at each place of the grid, s; as far as it comes.
    times: Vec<f32>,
    /// How far a head could be with 0, 1, 2 … relays, m.
    reaches: Vec<f32>,
}

impl Oracle {
    /// Computes what the head of this scenario can reach in the mission of this seed, which has the
    /// gains of its radios from it.
    #[must_use]
    pub fn of(scenario: &Scenario, world: &World, commanded: &Commanded, seed: u64) -> Self {
        let last = (end(world, &commanded.way) / STEP_M + 1e-3) as usize;
        let links = Links::of(scenario, world, &commanded.way, seed, last);
        let timing = Timing::of(scenario);
        let relays = scenario.drones.relays;
        let earliest: Vec<_> = (0..=relays).map(|relays| timing.earliest(&links, relays)).collect();
        let reaches: Vec<_> = earliest.iter().map(|head| reach(head)).collect();
        let head = &earliest[relays];
        let reached = reaches[relays];
        let times = timing.piloted(scenario, commanded, head);
        let depth = times.len().saturating_sub(1);
        let ended = match () {
            () if depth < reached => Ended::Pilot,
            () if reached == last => Ended::Gallery,
            () if links.is_out_of_all_reach(reached + 1) => Ended::Radio,
            () => Ended::Relays,
        };
        Self {
            reach_m: reached as f32 * STEP_M,
            depth_m: depth as f32 * STEP_M,
            at_s: times.last().copied().unwrap_or(f32::NAN),
            least_relays: reaches.iter().position(|reach| *reach >= depth).unwrap_or(relays),
            ended,
            times,
            reaches: reaches.iter().map(|reach| *reach as f32 * STEP_M).collect(),
        }
    }

    /// When the head first is this far, s since the start; infinite beyond its depth.
    #[must_use]
    pub fn time_to(&self, way_m: f32) -> f32 {
        let place = (way_m / STEP_M - 1e-3).ceil().max(0.0) as usize;
        self.times.get(place).copied().unwrap_or(f32::INFINITY)
    }

    /// The least number of relays with which a head can be this far, m; all of them beyond its reach.
    #[must_use]
    pub fn least_relays_at(&self, way_m: f32) -> usize {
        let enough = |reach: &f32| way_m <= reach + STEP_M;
        self.reaches.iter().position(enough).unwrap_or(self.reaches.len() - 1)
    }
}

/// The last place of the way at which a head can stand, m.
fn end(world: &World, way: &Path) -> f32 {
    let length = way.length();
    let Some(last) = way.legs().last() else { return length };
    let (at, [x, y]) = world.skeleton().at(way.at(length));
    let ahead = if last.to >= last.from { [x, y] } else { [-x, -y] };
    let wall = world.tunnel.range(at, ahead, BEYOND_END_M);
    (length + (wall - BEFORE_WALL_M).min(0.0)).max(0.0)
}

/// The farthest place without a gap before it.
fn reach(earliest: &[f32]) -> usize {
    earliest.iter().take_while(|time| time.is_finite()).count().saturating_sub(1)
}

/// When the drones of a mission can be where, as far as their own flight goes.
struct Timing {
    /// When each drone is at its height, head first, s.
    ready: Vec<f32>,
    /// Where each takes off, m along the way.
    rows: Vec<f32>,
    speed: f32,
}

impl Timing {
    fn of(scenario: &Scenario) -> Self {
        let agent = &scenario.agent;
        let flying = scenario.drones.flying();
        let explores = |task: &Order| matches!(task, Order::Explore(_));
        let first = scenario.pilot.iter().find(|step| explores(&step.task));
        let begins = first.map_or(f32::INFINITY, |step| seconds(step.at_us));
        let climb = agent.flight.height.0 / agent.flight.climb.0;
        let up = climb + agent.flight.settle.as_secs_f32();
        let each = up + agent.launch.arm_delay.as_secs_f32();
        Self {
            ready: (0..flying).map(|n| begins + up + each * n as f32).collect(),
            rows: (0..flying).map(|n| Start::SPACING * (flying - n) as f32).collect(),
            speed: agent.policy.max_speed.0,
        }
    }

    /// The earliest times at which the head can be at each place where so many relays take part:
    /// never earlier than at a place before, which it has to pass.
    fn earliest(&self, links: &Links, relays: usize) -> Vec<f32> {
        let mut behind: Option<Vec<f32>> = None;
        for drone in (0..=relays).rev() {
            let row = (self.rows[drone] / STEP_M) as usize;
            let mut latest = self.ready[drone];
            let times = (0..=links.last()).map(|place| {
                if place > row {
                    let flown = (place as f32 * STEP_M - self.rows[drone]).max(0.0) / self.speed;
                    let borne = match (links.bears_from_base(drone, place), &behind) {
                        (true, _) => 0.0,
                        (false, None) => f32::INFINITY,
                        (false, Some(behind)) => links
                            .first_that_bears(drone, place)
                            .map_or(f32::INFINITY, |at| behind[at]),
                    };
                    latest = latest.max(self.ready[drone] + flown).max(borne);
                }
                latest
            });
            behind = Some(times.collect());
        }
        behind.unwrap_or_default()
    }

    /// When the head first is at each place, by the pilot's stick, which stops it at the depth that the
    /// scenario has, and as far as its battery lets it fly on.
    fn piloted(&self, scenario: &Scenario, commanded: &Commanded, allowed: &[f32]) -> Vec<f32> {
        let round = seconds(ROUND_US);
        let mut head = self.rows.first().copied().unwrap_or(0.0);
        let begins = self.ready.first().copied().unwrap_or(f32::INFINITY);
        let mut times = vec![begins; (head / STEP_M) as usize + 1];
        let mut free = times.len() - 1;
        let mut aside = 0.0_f32;
        let mut steps = scenario.pilot.iter().peekable();
        let mut speed = 0.0;
        let rounds = scenario.duration_us / ROUND_US;
        let deepest = scenario.depth_m.unwrap_or(f32::INFINITY);
        let battery = Battery::of(scenario, commanded, begins);
        for now_us in (0..rounds).map(|n| n * ROUND_US) {
            while let Some(step) = steps.next_if(|step| step.at_us <= now_us) {
                match step.task {
                    Order::Explore(course) => speed = course.speed.0,
                    Order::Wait => speed = 0.0,
                    _ => return times,
                }
            }
            let now = seconds(now_us + ROUND_US);
            if now <= begins {
                continue;
            }
            if battery.as_ref().is_some_and(|battery| battery.calls_home(now, head)) {
                return times;
            }
            while allowed.get(free + 1).is_some_and(|time| *time <= now) {
                free += 1;
            }
            let flown = speed.clamp(-self.speed, self.speed) * round;
            let detour = commanded.detour.filter(|detour| now_us < detour.until_us);
            (head, aside) = moved(head, aside, flown, detour);
            head = head.clamp(0.0, (free as f32 * STEP_M + 1e-3).min(deepest + 1e-3));
            while times.len() as f32 * STEP_M <= head + 1e-3 {
                times.push(now);
            }
        }
        times
    }
}

/// The battery of a head that turns back with what carries it home.
struct Battery<'a> {
    flight: &'a agent::FlightConfig,
    /// When it would be at its reserve, s since the start.
    empty_s: f32,
}

impl<'a> Battery<'a> {
    /// The battery of a head that is at its height at this moment.
    fn of(scenario: &'a Scenario, commanded: &Commanded, up_s: f32) -> Option<Self> {
        let flight = &scenario.agent.flight;
        let empty = |endurance_s| up_s - flight.rise_s() + endurance_s;
        commanded.endurance_s.map(|endurance_s| Self { flight, empty_s: empty(endurance_s) })
    }

    /// Whether it calls a head home that is so far from the base, m.
    fn calls_home(&self, now_s: f32, head_m: f32) -> bool {
        let home_s = head_m / self.flight.return_speed.0;
        self.empty_s - now_s < self.flight.turns_back_below(home_s)
    }
}

/// The head's place along the way, and in the dead end beside it, after it has flown so far.
fn moved(head: f32, aside: f32, flown: f32, detour: Option<Detour>) -> (f32, f32) {
    let Some(Detour { at_m, length_m, .. }) = detour else { return (head + flown, 0.0) };
    let whole = (head + aside + flown).min(at_m + length_m);
    if whole > at_m { (at_m, whole - at_m) } else { (whole, 0.0) }
}

fn seconds(us: u64) -> f32 {
    (us as f64 * 1e-6) as f32
}

#[cfg(test)]
mod tests;
