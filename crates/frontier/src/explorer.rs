//! One robot that explores: its map, its marks, its goal, and its part in the team.

use core::ops::ControlFlow;

use grid_map::{Cell, CellState, RayEnd};
use heapless::{Deque, Vec};
use units::{Duration, Instant, Point2, Pose2};

use crate::atlas::{Ground, Sight, is_large, length};
use crate::cluster::RobotSet;
use crate::flight::{Limits, Motion, Progress, fly, look};
use crate::lead::Leader;
use crate::ledger::Ledger;
use crate::meeting::Meeting;
use crate::packet::{Activity, Body, MOST_BYTES, MOST_ORDERS, Order, Packet, Status, Task};
use crate::rule::{Distance, Facing, Overlap, Rule};
use crate::team::Team;
use crate::tile::{Gain, Mark, Tile};

/// How often a robot compares its marks with its map, plans its way anew, tells its status, and
/// repeats its bids.
const PERIOD: Duration = Duration::from_millis(1_000);
/// A packet that no robot acknowledges is sent again after so long: a status later, and half.
const RESEND: Duration = Duration::from_millis(1_500);
/// A robot gives a goal up after the time of twice its way, and so long: `progress_timeout` of
/// `explore_lite`.
const PATIENCE: Duration = Duration::from_millis(30_000);
/// A candidate is barred twice for a while, and the third time for good.
const MOST_BARS: u8 = 3;
/// The most tiles that a robot looks up, or looks for ways to, at a time.
pub(crate) const MOST_TARGETS: usize = 256;
/// The candidates that are barred at a time.
const MOST_BARRED: usize = 32;
/// A frontier whose gain has changed by fewer classes is not told anew. Our own number: it halves
/// the bytes.
const TOLD_CLASSES: u8 = 3;
/// When its goal is seen, a robot goes on to a frontier that is at most so many tiles beside it. Our
/// own number.
const FOLLOWED: u16 = 5;
/// The packets of changes of a step.
const CHANGES_A_STEP: usize = 2;
/// The packets of a step: a drone's link has room for so many in a fifth of a second.
const PACKETS_A_STEP: usize = 4;
/// The packets that wait to be sent.
const MOST_WAITING: usize = 8;

/// What a robot is given to begin with.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The robot's number, below the number of robots of its [`Explorer`].
    pub number: u8,
    /// The rule, the same for all robots.
    pub rule: Rule,
    /// The limits of its motion.
    pub limits: Limits,
}

/// A ray of a sensor, from the robot to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// The end.
    pub to: Point2,
    /// What is there.
    pub end: RayEnd,
}

/// What a robot perceives since its last step.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// Its pose on the floor plan that all robots share.
    pub pose: Pose2,
    /// What its sensors see.
    pub beams: &'a [Beam],
    /// The packets that its radio has received.
    pub packets: &'a [&'a [u8]],
}

/// What a robot does.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    /// Its motion.
    pub motion: Motion,
    /// The packets that its radio is to send to all that hear it.
    pub packets: Vec<Vec<u8, MOST_BYTES>, PACKETS_A_STEP>,
}

/// What a robot is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum State {
    /// It waits for a goal since then.
    Waiting { since: Instant },
    /// It can reach no candidate, since then.
    Idle { since: Instant },
    /// It is on its way.
    Going(Goal),
    /// It has stopped for good.
    Stopped,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Goal {
    tile: Tile,
    /// The cell at the end of the way, where one was found.
    end: Option<Cell>,
    planned: Instant,
    /// When the robot gives the goal up.
    until: Option<Instant>,
}

#[derive(Clone, Copy, Debug)]
struct Bar {
    tile: Tile,
    until: Instant,
    times: u8,
}

/// A robot of a team of at most `ROBOTS`, which remembers marks on at most `RECORDS` tiles.
#[derive(Clone, Debug)]
pub struct Explorer<G, const ROBOTS: usize, const RECORDS: usize> {
    pub(crate) config: Config,
    pub(crate) ground: G,
    pub(crate) team: Team<ROBOTS, RECORDS>,
    ledger: Ledger<RECORDS>,
    leader: Leader<ROBOTS>,
    pub(crate) state: State,
    last_goal: Tile,
    /// Where the robot flies while it waits for another goal.
    coast: Option<Cell>,
    pub(crate) meeting: Meeting,
    barred: Vec<Bar, MOST_BARRED>,
    sequence: u8,
    /// The packets that are still to be sent, the oldest first.
    outbox: Deque<Vec<u8, MOST_BYTES>, MOST_WAITING>,
    refreshed: Option<Instant>,
    pub(crate) bid: Option<Instant>,
    /// The last status: when, and of which activity.
    told: Option<(Instant, Activity)>,
    /// The version up to which changes were sent, and when the last were.
    sent: (u16, Instant),
}

impl<G: Ground, const ROBOTS: usize, const RECORDS: usize> Explorer<G, ROBOTS, RECORDS> {
    /// A robot that begins on that ground, which may hold what is known already.
    pub fn new(config: Config, ground: G) -> Self {
        let start = Instant::from_micros(0);
        Self {
            config,
            ground,
            team: Team::new(config.number),
            ledger: Ledger::new(),
            leader: Leader::new(),
            state: State::Waiting { since: start },
            last_goal: Tile::default(),
            coast: None,
            meeting: Meeting::new(),
            barred: Vec::new(),
            sequence: 0,
            outbox: Deque::new(),
            refreshed: None,
            bid: None,
            told: None,
            sent: (0, start),
        }
    }

    /// The robot's map.
    pub const fn ground(&self) -> &G {
        &self.ground
    }

    /// What the robot does.
    pub const fn activity(&self) -> Activity {
        match self.state {
            State::Waiting { .. } => Activity::Waiting,
            State::Idle { .. } => Activity::Idle,
            State::Going(_) => Activity::Going,
            State::Stopped => Activity::Stopped,
        }
    }

    /// The robot's goal on the floor plan, while it is on its way.
    pub fn goal(&self) -> Option<Point2> {
        match self.state {
            State::Going(goal) => Some(goal.tile.centre(self.ground.frame())),
            _ => None,
        }
    }

    /// One step. It is to be called some five times a second.
    pub fn step(&mut self, now: Instant, inputs: &Inputs<'_>) -> Outputs {
        let mut out = Outputs::default();
        for beam in inputs.beams {
            self.ground.trace(inputs.pose.at, beam.to, beam.end);
        }
        for bytes in inputs.packets {
            self.hear(now, bytes);
        }
        if is_due(self.refreshed, now) {
            self.refreshed = Some(now);
            self.meeting.start.get_or_insert(inputs.pose.at);
            self.forget_silent(now);
            self.refresh(now);
        }
        out.motion = self.go_on(now, inputs.pose);
        self.note_own(now, inputs.pose.at);
        if self.config.rule.overlap == Overlap::Alone {
            self.choose_alone(now, inputs.pose);
        } else {
            self.take_part(now, inputs.pose);
        }
        while !out.packets.is_full()
            && let Some(packet) = self.outbox.pop_front()
        {
            // There is room, by the loop's condition.
            let _ = out.packets.push(packet);
        }
        out
    }

    /// Bids, leads, and tells.
    fn take_part(&mut self, now: Instant, pose: Pose2) {
        let members = self.team.cluster(now);
        match self.config.rule.distance {
            Distance::Path => self.bid(now, pose, members),
            Distance::Straight => self.find_idle(now, members),
        }
        if self.team.leader(members) == Some(self.config.number) {
            let Self { leader, team, config, ground, .. } = self;
            let orders = leader.step(now, &config.rule, team, members, ground.frame());
            self.give(now, orders);
        }
        self.note_own(now, pose.at);
        self.tell(now, pose.at, members);
    }

    fn note_own(&mut self, now: Instant, position: Point2) {
        self.team.note_own(now, position, self.activity(), self.last_goal);
    }

    fn hear(&mut self, now: Instant, bytes: &[u8]) {
        let Ok(mut packet) = Packet::decode(bytes) else { return };
        let heard = self.team.hear(now, &packet);
        if heard.is_to_forward {
            packet.sender = self.config.number;
            self.put_out(&packet);
        }
        if heard.is_new
            && let Body::Orders(orders) = packet.body
        {
            self.obey(now, packet.origin, &orders);
        }
    }

    /// Carries out the orders of a robot that may lead.
    fn obey(&mut self, now: Instant, from: u8, orders: &[Order]) {
        let members = self.team.cluster(now);
        if self.team.leader(members).is_some_and(|leader| from > leader) {
            return;
        }
        let own = |order: &&Order| order.robot == self.config.number;
        if let Some(task) = orders.iter().find(own).map(|order| order.task) {
            self.take(now, task);
        }
    }

    pub(crate) fn take(&mut self, now: Instant, task: Task) {
        match (task, self.state) {
            (_, State::Stopped) => {}
            (Task::Stop, _) => self.state = State::Stopped,
            // The same order again is a repetition.
            (Task::Go(tile), State::Going(goal)) if goal.tile == tile => {}
            (Task::Go(tile), _) => {
                let planned = now - PERIOD;
                self.state = State::Going(Goal { tile, end: None, planned, until: None });
                self.last_goal = tile;
            }
        }
    }

    /// Sends orders to others, and carries out the robot's own.
    fn give(&mut self, now: Instant, mut orders: Vec<Order, ROBOTS>) {
        let number = self.config.number;
        if let Some(own) = orders.iter().find(|order| order.robot == number).copied() {
            self.take(now, own.task);
        }
        orders.retain(|order| order.robot != number);
        for some in orders.chunks(MOST_ORDERS) {
            self.send(Body::Orders(some.iter().copied().collect()));
        }
    }

    /// Compares marks with the map, and answers what others ask.
    fn refresh(&mut self, now: Instant) {
        let frame = *self.ground.frame();
        for tile in Tile::all(&frame) {
            let mark = self.mark_of(tile, now);
            self.mark(tile, mark);
        }
        if self.config.rule.overlap == Overlap::Asked {
            let asked: Vec<Tile, MOST_TARGETS> =
                self.team.board.to_look_up(self.config.number).take(MOST_TARGETS).collect();
            for tile in asked {
                if self.is_known(tile) {
                    self.mark(tile, Mark::Settled);
                }
            }
        }
        self.ledger.forget_gone(self.team.known_to_all(self.ledger.version()));
    }

    /// What the robot has to say of a tile by its map.
    fn mark_of(&self, tile: Tile, now: Instant) -> Mark {
        let rule = &self.config.rule;
        let frame = *self.ground.frame();
        let was = self.ledger.mark(tile);
        if was == Mark::Settled {
            return was;
        }
        let gains = self.frontiers_of(tile).map(|cell| self.ground.gain(cell));
        if let Some(most) = gains.max() {
            let gain = Gain::of_cells(most);
            let is_told = rule.reachability && rule.distance == Distance::Straight;
            return match was {
                _ if is_told && self.is_barred(tile, now) => Mark::Unreachable,
                Mark::Frontier(told) if told.classes_to(gain) < TOLD_CLASSES => was,
                _ => Mark::Frontier(gain),
            };
        }
        let has_walls = matches!(rule.overlap, Overlap::Points(_));
        let is_wall = |cell| self.ground.state(cell) == CellState::Occupied;
        if has_walls && tile.cells(&frame).any(is_wall) { Mark::Wall } else { Mark::Gone }
    }

    fn mark(&mut self, tile: Tile, mark: Mark) {
        if self.ledger.set(tile, mark) {
            self.team.board.apply(self.config.number, tile, mark);
        }
    }

    /// Whether the robot knows what lies beyond another's frontier: some of the tile is free in its
    /// own map, and none of it is a frontier.
    fn is_known(&self, tile: Tile) -> bool {
        let frame = *self.ground.frame();
        let is_free = |cell| self.ground.state(cell) == CellState::Free;
        tile.cells(&frame).any(is_free) && self.frontiers_of(tile).next().is_none()
    }

    /// The cells of a tile that are frontiers which count.
    fn frontiers_of(&self, tile: Tile) -> impl Iterator<Item = Cell> {
        let least = self.config.rule.least_frontier;
        let cells = tile.cells(self.ground.frame()).filter(|&cell| self.ground.is_frontier(cell));
        cells.filter(move |&cell| is_large(&self.ground, cell, least))
    }

    /// Flies on to the goal.
    fn go_on(&mut self, now: Instant, pose: Pose2) -> Motion {
        let State::Going(mut goal) = self.state else { return self.fly_on(now, pose) };
        let rule = self.config.rule;
        if rule.ends_when_seen && !self.is_open(goal.tile) {
            let Some(next) = self.open_beside(goal.tile) else {
                self.wait(now);
                self.coast = goal.end;
                return self.fly_on(now, pose);
            };
            self.last_goal = next;
            goal = Goal { tile: next, end: None, planned: now - PERIOD, until: None };
        }
        if goal.until.is_some_and(|until| now >= until) {
            return self.give_up(now, goal.tile);
        }
        if goal.end.is_none() || now.since(goal.planned) >= PERIOD {
            goal = self.plan(now, pose, goal);
            self.state = State::Going(goal);
        }
        let Some(end) = goal.end else { return self.give_up(now, goal.tile) };
        let limits = self.config.limits;
        let mut progress = fly(&self.ground, pose, (end, goal.tile), limits, rule.facing);
        if progress == Progress::Arrived {
            progress = look(&self.ground, pose, goal.tile, limits);
        }
        match progress {
            Progress::Flying(motion) => motion,
            Progress::Blocked => {
                goal.end = None;
                goal.planned = now - PERIOD;
                self.state = State::Going(goal);
                Motion::default()
            }
            Progress::Arrived => {
                // What is not seen from here cannot be seen.
                if rule.overlap == Overlap::Asked || rule.overlap == Overlap::Alone {
                    self.mark(goal.tile, Mark::Settled);
                } else if rule.reachability && self.is_open(goal.tile) {
                    self.bar(now, goal.tile);
                }
                self.wait(now)
            }
        }
    }

    /// Flies on to where the last goal was seen from, until there is another, and looks around there.
    fn fly_on(&mut self, now: Instant, pose: Pose2) -> Motion {
        let Config { limits, rule, .. } = self.config;
        match self.state {
            State::Waiting { .. } => self.meeting.since = None,
            State::Idle { .. } if self.team.misses_a_robot(now) => return self.meet(now, pose),
            State::Idle { .. } | State::Going(_) | State::Stopped => return Motion::default(),
        }
        if let Some(end) = self.coast {
            match fly(&self.ground, pose, (end, self.last_goal), limits, rule.facing) {
                Progress::Flying(motion) => return motion,
                Progress::Arrived | Progress::Blocked => self.coast = None,
            }
        }
        match rule.facing {
            Facing::Way => Motion::default(),
            Facing::Goal => Motion { velocity: [0.0; 2], yaw_rate: limits.turn },
        }
    }

    /// Whether there is still something to see at a tile.
    fn is_open(&self, tile: Tile) -> bool {
        let here = self.frontiers_of(tile).next().is_some();
        let own = self.ledger.mark(tile);
        if own == Mark::Settled {
            return false;
        }
        here || !self.is_known(tile)
            && (self.config.rule.overlap == Overlap::Alone || self.team.board.is_candidate(tile))
    }

    /// The frontier nearest to a tile that was seen, which no other robot goes to: what is left of the
    /// region for which the robot was sent.
    fn open_beside(&self, seen: Tile) -> Option<Tile> {
        let is_taken = |tile: Tile| self.team.goals().any(|goal| goal.steps_to(tile) <= FOLLOWED);
        let open = self.team.board.candidates().map(|candidate| candidate.tile);
        let near = open.filter(|tile| tile.steps_to(seen) <= FOLLOWED && self.is_open(*tile));
        near.filter(|&tile| !is_taken(tile)).min_by_key(|tile| tile.steps_to(seen))
    }

    /// Finds the way to the goal in the map as it is now.
    fn plan(&mut self, now: Instant, pose: Pose2, goal: Goal) -> Goal {
        let mut found = None;
        self.ground.search(pose.at, |map, visit| {
            if map.is_beside(visit.cell, goal.tile) {
                found = Some(visit);
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        });
        let frame = self.ground.frame();
        let seconds = found.map(|at| 2.0 * length(at.cost, frame).0 / self.config.limits.speed);
        let patience = seconds.map(|s| PATIENCE + Duration::from_millis((s * 1000.0) as u64));
        Goal {
            end: found.map(|at| at.cell),
            planned: now,
            until: goal.until.or_else(|| patience.map(|patience| now + patience)),
            ..goal
        }
    }

    fn give_up(&mut self, now: Instant, tile: Tile) -> Motion {
        if self.config.rule.reachability {
            self.bar(now, tile);
        }
        self.wait(now)
    }

    fn bar(&mut self, now: Instant, tile: Tile) {
        let until = now + self.config.rule.blacklist;
        if let Some(bar) = self.barred.iter_mut().find(|bar| bar.tile == tile) {
            bar.until = until;
            bar.times = bar.times.saturating_add(1);
        } else if self.barred.push(Bar { tile, until, times: 1 }).is_err() {
            // The oldest is tried again in the place of the newest.
            self.barred.remove(0);
            let _ = self.barred.push(Bar { tile, until, times: 1 });
        }
    }

    pub(crate) fn is_barred(&self, tile: Tile, now: Instant) -> bool {
        let bar = self.barred.iter().find(|bar| bar.tile == tile);
        bar.is_some_and(|bar| bar.times >= MOST_BARS || now < bar.until)
    }

    pub(crate) fn has_bars_to_come(&self, now: Instant) -> bool {
        let is_open = |bar: &Bar| bar.times < MOST_BARS && now < bar.until;
        self.barred.iter().any(|bar| is_open(bar) && self.team.board.is_candidate(bar.tile))
    }

    /// Waits for a goal, and asks for one at once.
    fn wait(&mut self, now: Instant) -> Motion {
        self.state = State::Waiting { since: now };
        self.bid = None;
        self.coast = None;
        Motion::default()
    }

    /// Tells what has changed, and how the robot is.
    fn tell(&mut self, now: Instant, position: Point2, members: RobotSet) {
        let activity = self.activity();
        let is_new = self.told.is_none_or(|(_, told)| told != activity);
        if is_new || is_due(self.told.map(|(at, _)| at), now) {
            self.told = Some((now, activity));
            let known = self.team.known(now);
            let (goal, version) = (self.last_goal, self.ledger.version());
            self.send(Body::Status(Status { position, activity, goal, version, known }));
        }
        if members.len() > 1 {
            self.tell_changes(now, members);
        }
    }

    fn tell_changes(&mut self, now: Instant, members: RobotSet) {
        let (sent, at) = self.sent;
        let had = self.team.least_acknowledged(members).unwrap_or(sent);
        if had < sent && now.since(at) >= RESEND {
            self.sent = (had, now);
        }
        for _ in 0..CHANGES_A_STEP {
            // Changes wait until the packets before them are out.
            if self.outbox.len() >= PACKETS_A_STEP {
                break;
            }
            let Some(changes) = self.ledger.changes_after(self.sent.0) else { break };
            self.sent = (changes.upto, now);
            self.send(Body::Changes(changes));
        }
    }

    /// Makes a packet, and sends it.
    pub(crate) fn send(&mut self, body: Body) {
        let number = self.config.number;
        self.sequence = self.sequence.wrapping_add(1);
        let packet = Packet { origin: number, sender: number, sequence: self.sequence, body };
        self.put_out(&packet);
    }

    /// Puts a packet behind those that wait to be sent; one for which there is no room is lost, as on
    /// the air.
    fn put_out(&mut self, packet: &Packet) {
        let _ = self.outbox.push_back(packet.encode());
    }
}

pub(crate) fn is_due(last: Option<Instant>, now: Instant) -> bool {
    last.is_none_or(|last| now.since(last) >= PERIOD)
}
