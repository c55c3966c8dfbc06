//! One exploration: robots, their radio, and what came of it.

use frontier::{
    Activity, Atlas160, Atlas256, Atlas512, Atlas1024, Config, Gaze, Ground, Limits, Rule,
};
use grid_map::{CellState, Frame, TooManyCells};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use robot_maps::Occupancy;
use units::{Instant, Metres, Point2, Pose2, Radians};

use crate::access_point::AccessPoint;
use crate::air::{Air, Network, uniform};
use crate::drawn::merged;
use crate::drift::Drift;
use crate::robot::{Robot, Senses};
use crate::world::{REACH, World};

/// The most robots of a run.
pub const ROBOTS: usize = 8;
/// The tiles on which each robot remembers marks: so many that memory does not decide between rules, of
/// which the thesis' tells walls as well. Our own number.
pub(crate) const RECORDS: usize = 8192;
/// Five steps a second, as the mission loop of the drones.
pub(crate) const STEPS_PER_SECOND: u64 = 5;
/// The part of the visible cells that counts as explored.
const DONE: f32 = 0.99;
/// Fastest flight and turn (thesis, table 3.1).
pub const LIMITS: Limits = Limits { speed: 0.3, turn: 0.3, reach: REACH.0, gaze: Gaze::Ahead };
/// The spread of starts about those of the world (m).
const SPREAD: f32 = 0.4;

/// What is flown.
#[derive(Clone, Copy, Debug)]
pub struct Setup<'a> {
    /// The place.
    pub world: &'a World,
    /// The rule of exploration.
    pub rule: Rule,
    /// The number of robots, 1 to [`ROBOTS`].
    pub robots: usize,
    /// The seed of starts and packet losses.
    pub seed: u64,
    /// The radio.
    pub air: Air,
    /// What the robots perceive.
    pub senses: Senses,
    /// Half the width of a robot with its guards, by which it touches walls and other robots.
    pub radius: Metres,
    /// When the last robot fails, in seconds.
    pub death_s: Option<f32>,
    /// From when to when robot 0 is out of the others' range, in seconds.
    pub apart_s: Option<[f32; 2]>,
    /// When the run ends, in seconds.
    pub longest_s: f32,
}

/// What came of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// The part of the visible cells that at least one robot knows which has not failed.
    pub explored: f32,
    /// When 99 % were known, in seconds.
    pub t99_s: Option<f32>,
    /// When the last robot stopped, in seconds.
    pub stopped_s: Option<f32>,
    /// The way of a robot, on average, until 99 % were known, in metres; to the end where they never
    /// were.
    pub path_m: f32,
    /// The part of the known cells that two robots or more know, when 99 % were known, or at the end
    /// where they never were.
    pub overlap: f32,
    /// Whether the robots stopped before 99 % were known.
    pub premature_stop: bool,
    /// What was sent until the end, in kilobytes.
    pub kb_on_air: f32,
    /// The least distance of two robots after the start, in metres; `None` for one robot.
    pub closest_m: Option<f32>,
    /// The distance at the end between where a robot is and where it takes itself to be, on average,
    /// in metres.
    pub error_m: f32,
    /// How often a robot's body began to touch a wall.
    pub touches: u32,
    /// How often a robot's middle would have flown into a wall, where it stops.
    pub into_walls: u32,
    /// How often two robots' bodies began to touch.
    pub robot_touches: u32,
    /// Each second: the part of the visible cells that each robot knows, and that any does.
    pub curve: Vec<Vec<f32>>,
}

/// What all robots are and know at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Glance {
    /// The time since the start, s.
    pub at_s: f32,
    /// Where each robot truly is.
    pub poses: Vec<Pose2>,
    /// The way that each has flown, m.
    pub flown_m: Vec<f32>,
    /// What each knows of the world's cells, in their order.
    pub maps: Vec<Vec<CellState>>,
}

/// Flies one exploration; returns what came of it and the map that all robots have drawn together.
///
/// # Panics
/// Where the world has more cells than [`Atlas1024`], which [`World::of_map`] refuses.
#[must_use]
pub fn run(setup: &Setup<'_>) -> (Outcome, Occupancy) {
    flown(setup, None)
}

/// Flies one exploration as [`run()`] does, and calls `see` after each second.
///
/// # Panics
/// Where [`run()`] does.
pub fn watch(setup: &Setup<'_>, see: &mut dyn FnMut(Glance)) -> Outcome {
    flown(setup, Some(see)).0
}

/// Called after each second of a run that is watched.
type Watcher<'a> = Option<&'a mut dyn FnMut(Glance)>;

fn flown(setup: &Setup<'_>, see: Watcher<'_>) -> (Outcome, Occupancy) {
    let frame = *setup.world.frame();
    let large = "at most 1024 by 1024 cells";
    match frame.cell_count() {
        0..=25_600 => explore(setup, see, Atlas160::new).expect(large),
        25_601..=65_536 => explore(setup, see, Atlas256::new).expect(large),
        65_537..=262_144 => explore(setup, see, Atlas512::new).expect(large),
        _ => explore(setup, see, Atlas1024::new).expect(large),
    }
}

/// Flies an exploration with maps of one size. It is never inlined: the stack of [`run()`] would have
/// room for the largest map, whatever the size of the world.
#[inline(never)]
fn explore<G: Ground>(
    setup: &Setup<'_>,
    see: Watcher<'_>,
    ground: impl Fn(Frame) -> Result<G, TooManyCells>,
) -> Result<(Outcome, Occupancy), TooManyCells> {
    Ok(Run::new(*setup, ground)?.fly(see))
}

struct Run<'a, G> {
    setup: Setup<'a>,
    robots: Vec<Robot<G>>,
    access_point: Option<AccessPoint<G>>,
    luck: Vec<ChaCha8Rng>,
    bytes: usize,
    steps: u64,
    /// The pairs of robots that touch now.
    touching: Vec<(usize, usize)>,
    outcome: Outcome,
}

impl<'a, G: Ground> Run<'a, G> {
    fn new(
        setup: Setup<'a>,
        ground: impl Fn(Frame) -> Result<G, TooManyCells>,
    ) -> Result<Self, TooManyCells> {
        let stream = |purpose: usize| {
            let mut generator = ChaCha8Rng::seed_from_u64(setup.seed);
            generator.set_stream(purpose as u64);
            generator
        };
        let world = setup.world;
        let network = setup.air.network;
        let has_point = network == Network::AccessPoint;
        let access_point = match has_point {
            true => Some(AccessPoint::new(&setup, ground(*world.frame())?)),
            false => None,
        };
        let mut robots = Vec::new();
        for (n, &start) in world.starts().iter().take(setup.robots.min(ROBOTS)).enumerate() {
            let Senses { sensor, drifts } = setup.senses;
            let number = n as u8 + u8::from(has_point);
            let config = Config::unbounded(number, setup.rule, sensor.limits());
            let config = Config { forwards: network == Network::Mesh, ..config };
            let drift = drifts.then(|| Drift::new(stream(200 + n)));
            let pose = start_pose(world, start, &mut stream(100 + n));
            let ground = ground(*world.frame())?;
            robots.push(Robot::new(config, (sensor, drift), ground, world, pose));
        }
        Ok(Self {
            luck: (0..=robots.len()).map(stream).collect(),
            robots,
            access_point,
            bytes: 0,
            steps: 0,
            touching: Vec::new(),
            outcome: Outcome::default(),
            setup,
        })
    }

    /// Flies to the end.
    fn fly(mut self, mut see: Watcher<'_>) -> (Outcome, Occupancy) {
        let visible = self.setup.world.visible_cells().max(1) as f32;
        while self.seconds() < self.setup.longest_s && self.outcome.stopped_s.is_none() {
            self.step();
            self.steps += 1;
            if !self.steps.is_multiple_of(STEPS_PER_SECOND) {
                continue;
            }
            if let Some(see) = &mut see {
                see(self.glance());
            }
            let known = self.known();
            self.outcome.curve.push(known.iter().map(|&cells| cells as f32 / visible).collect());
            self.outcome.explored = known.last().map_or(0.0, |&cells| cells as f32 / visible);
            if self.outcome.t99_s.is_none() {
                self.outcome.path_m = self.path();
                if self.outcome.explored >= DONE {
                    self.outcome.t99_s = Some(self.seconds());
                    self.outcome.overlap = self.overlap();
                }
            }
            let is_done = |(n, robot): (usize, &Robot<G>)| {
                robot.mind.activity() == Activity::Stopped || !self.is_alive(n)
            };
            if self.robots.iter().enumerate().all(is_done) {
                self.outcome.stopped_s = Some(self.seconds());
            }
        }
        self.conclude()
    }

    fn conclude(mut self) -> (Outcome, Occupancy) {
        if self.outcome.t99_s.is_none() {
            self.outcome.overlap = self.overlap();
        }
        let outcome = &mut self.outcome;
        outcome.premature_stop = outcome.stopped_s.is_some() && outcome.t99_s.is_none();
        outcome.kb_on_air = self.bytes as f32 / 1000.0;
        outcome.touches = self.robots.iter().map(|robot| robot.touches).sum();
        outcome.into_walls = self.robots.iter().map(|robot| robot.into_walls).sum();
        let errors = self.robots.iter().map(|robot| robot.error()).map(|[x, y]| x.hypot(y));
        self.outcome.error_m = errors.sum::<f32>() / self.robots.len() as f32;
        let map = self.merged();
        (self.outcome, map)
    }

    fn glance(&self) -> Glance {
        let cells = || self.setup.world.frame().cells();
        let map = |robot: &Robot<G>| cells().map(|cell| robot.mind.ground().state(cell)).collect();
        Glance {
            at_s: self.seconds(),
            poses: self.robots.iter().map(|robot| robot.pose).collect(),
            flown_m: self.robots.iter().map(|robot| robot.flown).collect(),
            maps: self.robots.iter().map(map).collect(),
        }
    }

    fn seconds(&self) -> f32 {
        self.steps as f32 / STEPS_PER_SECOND as f32
    }

    fn is_alive(&self, n: usize) -> bool {
        n + 1 < self.robots.len() || self.setup.death_s.is_none_or(|death| self.seconds() < death)
    }

    fn path(&self) -> f32 {
        self.robots.iter().map(|robot| robot.flown).sum::<f32>() / self.robots.len() as f32
    }

    fn step(&mut self) {
        let now = Instant::from_micros(self.steps * 1_000_000 / STEPS_PER_SECOND);
        let mut sent = Vec::new();
        for n in (0..self.robots.len()).filter(|&n| self.is_alive(n)).collect::<Vec<_>>() {
            let robot = &mut self.robots[n];
            let outputs = robot.step(now, self.setup.world);
            robot.fly(self.setup.world, 1.0 / STEPS_PER_SECOND as f32);
            sent.extend(outputs.packets.into_iter().map(|packet| (n, packet)));
        }
        self.note_touches();
        let closest = [self.outcome.closest_m, self.closest_m()].into_iter().flatten();
        self.outcome.closest_m = closest.min_by(f32::total_cmp);
        for (from, packet) in sent {
            self.transmit(from, &packet);
        }
        let own = self.access_point.as_mut().map(|point| point.step(now));
        for packet in own.into_iter().flatten() {
            self.repeat(None, &packet);
        }
    }

    /// Counts the touches that have begun.
    fn note_touches(&mut self) {
        let Setup { world, radius, .. } = self.setup;
        for n in 0..self.robots.len() {
            if self.is_alive(n) {
                self.robots[n].note_wall(world, radius);
            }
        }
        let touching: Vec<_> = self
            .distances()
            .filter(|(_, distance)| *distance < 2.0 * radius.0)
            .map(|(pair, _)| pair)
            .collect();
        let begun = touching.iter().filter(|pair| !self.touching.contains(pair)).count();
        self.outcome.robot_touches += begun as u32;
        self.touching = touching;
    }

    /// The least distance of two robots that have not failed.
    fn closest_m(&self) -> Option<f32> {
        self.distances().map(|(_, distance)| distance).min_by(f32::total_cmp)
    }

    /// The distances of all pairs of robots of which the one with the higher number has not failed: the last
    /// robot is the one that fails.
    fn distances(&self) -> impl Iterator<Item = ((usize, usize), f32)> {
        let alive = (0..self.robots.len()).filter(|&n| self.is_alive(n));
        let pairs = alive.flat_map(|n| (0..n).map(move |other| (n, other)));
        let at = |n: usize| self.robots[n].pose.at;
        pairs.map(move |(n, other)| ((n, other), at(n).distance(at(other)).0))
    }

    fn transmit(&mut self, from: usize, packet: &[u8]) {
        let Some(at) = self.access_point.as_ref().map(|point| point.at) else {
            return self.send_to_all(from, packet);
        };
        self.bytes += packet.len();
        let (air, world) = (self.setup.air, self.setup.world);
        let strength = air.strength(world, self.robots[from].pose.at, at);
        // The access point's own draws come after those of the robots.
        let luck = self.luck.last_mut();
        let is_heard = luck.is_some_and(|luck| air.is_received(strength, packet.len(), luck));
        if !is_heard || self.is_away(from) {
            return;
        }
        if let Some(point) = &mut self.access_point {
            point.inbox.push(packet.to_vec());
        }
        self.repeat(Some(from), packet);
    }

    /// Sends a robot's packet to all others directly.
    fn send_to_all(&mut self, from: usize, packet: &[u8]) {
        self.bytes += packet.len();
        let at = self.robots[from].pose.at;
        for to in (0..self.robots.len()).filter(|&to| to != from) {
            if self.is_away(from) == self.is_away(to) {
                self.deliver(at, to, packet);
            }
        }
    }

    /// Sends a packet from the access point to all robots but the one from which it came.
    fn repeat(&mut self, from: Option<usize>, packet: &[u8]) {
        let Some(at) = self.access_point.as_ref().map(|point| point.at) else { return };
        self.bytes += packet.len();
        for to in (0..self.robots.len()).filter(|&to| Some(to) != from) {
            if !self.is_away(to) {
                self.deliver(at, to, packet);
            }
        }
    }

    /// Whether a robot is out of the range of all others and of the access point.
    fn is_away(&self, robot: usize) -> bool {
        let is_apart = self.setup.apart_s.is_some_and(|[a, b]| (a..b).contains(&self.seconds()));
        is_apart && robot == 0
    }

    /// Puts a packet that was sent at a place into a robot's inbox, if the robot receives it.
    fn deliver(&mut self, from: Point2, to: usize, packet: &[u8]) {
        if !self.is_alive(to) {
            return;
        }
        let (air, world) = (self.setup.air, self.setup.world);
        let strength = air.strength(world, from, self.robots[to].pose.at);
        if air.is_received(strength, packet.len(), &mut self.luck[to]) {
            self.robots[to].inbox.push(packet.to_vec());
        }
    }

    /// How many visible cells each robot knows, and, last, how many any does.
    fn known(&self) -> Vec<usize> {
        let world = self.setup.world;
        let mut counts = vec![0; self.robots.len() + 1];
        for cell in world.frame().cells().filter(|&cell| world.is_visible(cell)) {
            let mut is_known = false;
            for (n, robot) in self.robots.iter().enumerate() {
                let knows = robot.mind.ground().state(cell) != CellState::Unknown;
                counts[n] += usize::from(knows);
                is_known |= knows && self.is_alive(n);
            }
            counts[self.robots.len()] += usize::from(is_known);
        }
        counts
    }

    fn overlap(&self) -> f32 {
        self.count(2) as f32 / self.count(1).max(1) as f32
    }

    /// How many visible cells at least so many robots know.
    fn count(&self, robots: usize) -> usize {
        let world = self.setup.world;
        let knows = |cell| {
            let knows = |robot: &&Robot<G>| robot.mind.ground().state(cell) != CellState::Unknown;
            self.robots.iter().filter(knows).count() >= robots
        };
        world.frame().cells().filter(|&cell| world.is_visible(cell) && knows(cell)).count()
    }

    /// The map of all robots.
    fn merged(&self) -> Occupancy {
        let frame = self.setup.world.frame();
        let minds = || self.robots.iter().map(|robot| robot.mind.ground());
        merged(frame, |cell| minds().map(move |ground| ground.state(cell)))
    }
}

/// A start near that of the world, where a robot has room, in any direction.
fn start_pose(world: &World, start: Point2, draws: &mut ChaCha8Rng) -> Pose2 {
    let mut spread = || uniform(draws) - 0.5;
    let yaw = Radians(std::f32::consts::TAU * spread());
    let near = (0..100).map(|_| {
        let (x, y) = (SPREAD * spread(), SPREAD * spread());
        Point2::new(start.x + x, start.y + y)
    });
    let has_room = |at: &Point2| world.frame().cell_at(*at).is_some_and(|c| world.has_room(c));
    Pose2 { at: { near }.find(has_room).unwrap_or(start), yaw }
}
