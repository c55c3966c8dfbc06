//! One exploration: robots, their radio, and the leader's rounds.

use frontier::{
    Candidate, Distance, Explorer, MOST_CHUNK_BYTES, POINTS, ROBOTS, Rule, Shape, assign,
    is_overlapped, leader,
};
use grid_map::CellState;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use units::{Metres, Point2};

use crate::robot::Robot;
use crate::world::World;

const STEP: f32 = 0.5;
const LONGEST: f32 = 600.0;
/// The part of the free cells that counts as explored.
const DONE: f32 = 0.99;
/// The most candidates of a cluster.
const CANDIDATES: usize = 384;
/// How often a chunk is sent before the round goes on without it.
const RESENDS: usize = 8;

/// What is flown.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// The plan.
    pub world: World,
    /// The rule of assignment.
    pub rule: Rule,
    /// The number of robots, 1 to 6.
    pub robots: usize,
    /// The seed of starts and packet losses.
    pub seed: u64,
    /// The part of all packets that is lost.
    pub loss: f32,
    /// When the last robot fails, in seconds.
    pub death_s: Option<f32>,
    /// From when to when robot 0 is out of the others' range, in seconds.
    pub apart_s: Option<[f32; 2]>,
}

/// What came of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// The part of the free cells that at least one robot knows.
    pub explored: f32,
    /// When 99 % were known, in seconds.
    pub t99_s: Option<f32>,
    /// When the robots stopped, in seconds.
    pub stopped_s: Option<f32>,
    /// The way of a robot, on average, until 99 % were known, in metres; to the end where they never
    /// were.
    pub path_m: f32,
    /// The part of the known free cells that two robots or more know.
    pub overlap: f32,
    /// Whether the robots stopped before 99 % were known.
    pub premature_stop: bool,
    /// What was sent, in kilobytes.
    pub kb_on_air: f32,
}

struct Run {
    setup: Setup,
    robots: Vec<Robot>,
    links: Vec<ChaCha8Rng>,
    bytes: usize,
    now: f32,
    is_stopped: Vec<bool>,
}

/// Flies one exploration.
#[must_use]
pub fn run(setup: &Setup) -> Outcome {
    let mut run = Run::new(*setup);
    let free = setup.world.free_cells() as f32;
    let mut outcome = Outcome::default();
    let mut next_round = 0.0;
    let mut is_due = true;
    while run.now < LONGEST && outcome.stopped_s.is_none() {
        is_due |= run.step();
        let is_event = setup.rule.on_event && is_due;
        if run.now >= next_round || is_event {
            is_due = false;
            next_round = run.now + setup.rule.period.as_secs_f32();
            run.round();
        }
        let known = run.known(1) as f32 / free;
        if known >= DONE {
            outcome.t99_s.get_or_insert(run.now);
        } else {
            outcome.path_m = run.path();
        }
        if (0..run.robots.len()).all(|n| run.is_stopped[n] || !run.is_alive(n)) {
            outcome.stopped_s = Some(run.now);
        }
        run.now += STEP;
    }
    outcome.explored = run.known(1) as f32 / free;
    outcome.premature_stop = outcome.stopped_s.is_some() && outcome.t99_s.is_none();
    outcome.overlap = run.known(2) as f32 / run.known(1).max(1) as f32;
    outcome.kb_on_air = run.bytes as f32 / 1000.0;
    outcome
}

impl Run {
    fn new(setup: Setup) -> Self {
        let stream = |purpose: usize| {
            let mut generator = ChaCha8Rng::seed_from_u64(setup.seed);
            generator.set_stream(purpose as u64);
            generator
        };
        // The thesis' starts for three, and three more.
        let starts = [[1.0, 1.0], [1.0, -1.0], [1.0, -3.0], [-0.5, 3.0], [-0.5, 1.0], [-0.5, -3.0]];
        let robots = starts.iter().take(setup.robots).enumerate().map(|(n, [x, y])| {
            let mut draws = stream(100 + n);
            let mut spread = || uniform(&mut draws) - 0.5;
            let at = Point2::new(x + 0.4 * spread(), y + 0.4 * spread());
            Robot::new(at, std::f32::consts::TAU * spread())
        });
        Self {
            robots: robots.collect(),
            links: (0..setup.robots).map(stream).collect(),
            bytes: 0,
            now: 0.0,
            is_stopped: vec![false; setup.robots],
            setup,
        }
    }

    fn is_alive(&self, n: usize) -> bool {
        n + 1 < self.robots.len() || self.setup.death_s.is_none_or(|death| self.now < death)
    }

    /// The way of a robot so far, on average.
    fn path(&self) -> f32 {
        self.robots.iter().map(|robot| robot.flown).sum::<f32>() / self.robots.len() as f32
    }

    /// Flies all on by one step; says whether a robot needs a goal.
    fn step(&mut self) -> bool {
        let mut is_due = false;
        for n in 0..self.robots.len() {
            if !self.is_alive(n) {
                continue;
            }
            let (now, rule) = (self.now, self.setup.rule);
            let robot = &mut self.robots[n];
            robot.sense(&self.setup.world);
            let Some(goal) = robot.goal else { continue };
            if robot.fly(STEP) {
                if robot.is_worth(goal.position) && rule.blacklist.as_secs_f32() > 0.0 {
                    robot.bar(goal.position, now + rule.blacklist.as_secs_f32());
                }
                robot.goal = None;
                is_due = true;
            }
        }
        // A robot without a goal asks again every five seconds.
        is_due || self.now % 5.0 == 0.0 && self.robots.iter().any(|r| r.goal.is_none())
    }

    /// A round of each cluster's leader.
    fn round(&mut self) {
        let links = self.radio();
        for head in 0..self.robots.len() {
            let is_member =
                |&n: &usize| self.is_alive(n) && usize::from(leader(&links, n as u8)) == head;
            let members: Vec<usize> = (0..self.robots.len()).filter(is_member).collect();
            if !members.is_empty() {
                self.lead(head, &members);
            }
        }
    }

    fn radio(&self) -> [u8; ROBOTS] {
        let is_apart = self.setup.apart_s.is_some_and(|[a, b]| (a..b).contains(&self.now));
        std::array::from_fn(|a| {
            let hears = |b: usize| !is_apart || (a == 0) == (b == 0);
            (0..self.robots.len())
                .filter(|&b| b != a && self.is_alive(a) && self.is_alive(b) && hears(b))
                .fold(0, |bits, b| bits | 1 << b)
        })
    }

    /// Collects, removes the overlap, assigns and sends.
    fn lead(&mut self, head: usize, members: &[usize]) {
        let mut told = Vec::new();
        for &n in members {
            self.robots[n].plan();
            let own = self.robots[n].candidates();
            let edge = self.edge(n);
            let is_heard = n == head || self.send(n, own.len() + edge.len());
            if is_heard {
                told.push((n, own, edge));
            }
        }
        let mut union: Vec<Candidate> = Vec::new();
        let mut dropped: Vec<(usize, Candidate)> = Vec::new();
        for (n, own, _) in &told {
            for candidate in own {
                let is_in = |(other, _, edge): &(usize, _, Vec<Point2>)| {
                    other != n && is_overlapped(candidate.position, edge, Shape::Concave)
                };
                if told.iter().any(is_in) {
                    dropped.push((*n, *candidate));
                } else {
                    union.push(*candidate);
                }
            }
        }
        let heard: Vec<usize> = told.iter().map(|(n, ..)| *n).collect();
        let is_done = |run: &Self, list: &[Candidate]| {
            !list.iter().any(|c| heard.iter().any(|&n| run.distance(n, *c).is_some()))
        };
        if self.setup.rule.confirmed_stop && is_done(self, &union) {
            // Each robot is asked which of the dropped candidates it knows the surroundings of.
            self.bytes += (dropped.len() * 5).div_ceil(MOST_CHUNK_BYTES) * MOST_CHUNK_BYTES;
            let is_known = |n: usize, at: Point2| {
                let robot: &Robot = &self.robots[n];
                let cell = World::frame().cell_at(at);
                cell.is_some_and(|c| {
                    robot.map.state(c) != CellState::Unknown && !robot.map.is_frontier(c)
                })
            };
            let open = dropped.iter().filter(|(n, c)| {
                !heard.iter().any(|other| other != n && is_known(*other, c.position))
            });
            union.extend(open.map(|(_, c)| *c));
        }
        let is_quiet = heard.len() == members.len() || !self.setup.rule.confirmed_stop;
        let is_barred = |c: &Candidate| {
            members.iter().any(|&n| {
                let until = self.robots[n].barred_until(c.position);
                until > self.now && until.is_finite()
            })
        };
        let is_open = self.setup.rule.confirmed_stop && union.iter().any(is_barred);
        let is_over = union.is_empty() || self.setup.rule.reachability && is_done(self, &union);
        if is_over && is_quiet && !is_open {
            for &n in members {
                self.is_stopped[n] = true;
            }
        } else {
            self.give(&heard, &union);
        }
    }

    fn give(&mut self, heard: &[usize], union: &[Candidate]) {
        let rule = self.setup.rule;
        let explorers: Vec<Explorer> = heard
            .iter()
            .map(|&n| Explorer { number: n as u8, position: self.robots[n].position })
            .collect();
        let distance =
            |explorer: &Explorer, n: usize| self.distance(usize::from(explorer.number), union[n]);
        for one in assign::<CANDIDATES>(&rule, &explorers, union, distance) {
            let n = usize::from(one.number);
            self.is_stopped[n] = false;
            if self.send(n, 1) && !self.robots[n].take(union[one.candidate]) {
                self.robots[n].goal = None;
            }
        }
    }

    fn distance(&self, n: usize, candidate: Candidate) -> Option<Metres> {
        let rule = self.setup.rule;
        let robot = &self.robots[n];
        if rule.blacklist.as_secs_f32() > 0.0 && robot.barred_until(candidate.position) > self.now {
            return None;
        }
        let way = robot.way_to(candidate.position).map(|(_, way)| way);
        if rule.reachability && way.is_none() {
            return None;
        }
        let straight = robot.position.distance(candidate.position);
        Some(if rule.distance == Distance::Path { way.unwrap_or(straight) } else { straight })
    }

    /// The points that a robot tells for the test of overlap: frontiers and occupied cells, thinned
    /// to the spacing of candidates.
    fn edge(&self, n: usize) -> Vec<Point2> {
        let (map, frame) = (&self.robots[n].map, World::frame());
        let mut edge: Vec<Point2> = Vec::new();
        let is_edge = |&c: &_| map.state(c) == CellState::Occupied || map.is_frontier(c);
        for cell in frame.cells().filter(is_edge) {
            let at = frame.centre(cell);
            if edge.iter().all(|other| other.distance(at).0 >= frontier::SPACING.0) {
                edge.push(at);
            }
        }
        edge
    }

    /// Sends points from or to a robot in chunks, each until it has arrived; says whether all have.
    fn send(&mut self, n: usize, points: usize) -> bool {
        for chunk in 0..points.div_ceil(POINTS).max(1) {
            let size = 4 + 5 * (points - chunk * POINTS).min(POINTS);
            let mut tries = 0;
            loop {
                tries += 1;
                self.bytes += size;
                if uniform(&mut self.links[n]) >= self.setup.loss {
                    break;
                }
                if tries == RESENDS {
                    return false;
                }
            }
        }
        true
    }

    /// How many free cells at least so many robots know.
    fn known(&self, robots: usize) -> usize {
        let knows = |cell| {
            self.robots.iter().filter(|r| r.map.state(cell) != CellState::Unknown).count() >= robots
        };
        World::frame().cells().filter(|&c| !self.setup.world.is_wall(c) && knows(c)).count()
    }
}

fn uniform(stream: &mut ChaCha8Rng) -> f32 {
    (stream.next_u32() >> 8) as f32 / 16_777_216.0
}
