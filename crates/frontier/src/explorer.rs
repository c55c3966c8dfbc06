//! One robot that explores: its map, its marks, its goal, and its part in the team.

use core::ops::ControlFlow;

use grid_map::{Cell, CellState, Frame, RayEnd, TooManyCells};
use heapless::{Deque, Vec};
use units::{Duration, Instant, Point2, Pose2};

use crate::atlas::{Ground, Sight, is_large, length};
use crate::barred::Bars;
use crate::bidding::Targets;
use crate::cluster::RobotSet;
use crate::flight::{Gaze, Limits, Motion, Progress, fly, look};
use crate::lead::Leader;
use crate::ledger::Ledger;
use crate::list::filled;
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
/// The most tiles that a robot looks up, or looks for ways to, at a time.
pub(crate) const MOST_TARGETS: usize = 256;
/// A frontier whose gain has changed by fewer classes is not told anew. Our own number: it halves
/// the bytes.
const TOLD_CLASSES: u8 = 3;
/// When its goal is seen, a robot goes on to a frontier that is at most so many tiles beside it. Our
/// own number.
const FOLLOWED: u16 = 5;
/// The cells behind a hit that count as a part of the obstacle: walls are not thinner. Our own number.
const BEHIND: u8 = 2;
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
    /// Frontiers with a smaller gain are none, in cells: where a wall lies between two cells, noise makes
    /// one of them unknown now and then.
    pub least_gain: u8,
    /// Over how many steps the robot spreads the comparison of its marks with its map, at least 1. A
    /// drone's processor has not the time for all of it at once.
    pub refresh_steps: u8,
    /// A search of ways that visits more cells goes on in the next step, and the robot waits meanwhile; 0
    /// for no bound.
    pub search_cells: u16,
}

impl Config {
    /// A robot with a computer that compares its marks and searches its ways in one step, and for which
    /// every frontier that the rule counts is one.
    #[must_use]
    pub const fn unbounded(number: u8, rule: Rule, limits: Limits) -> Self {
        Self { number, rule, limits, least_gain: 0, refresh_steps: 1, search_cells: 0 }
    }

    /// The cells that a search visits in a step.
    pub(crate) fn most_cells(&self) -> usize {
        match self.search_cells {
            0 => usize::MAX,
            cells => cells.into(),
        }
    }
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

/// What a search of ways is for that goes on in the next step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Search {
    /// None is under way.
    None,
    /// The robot's bids.
    Bids,
    /// The way to its goal.
    Way,
    /// The way to where it waits for robots that are out of range.
    Meeting,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Goal {
    tile: Tile,
    /// The cell at the end of the way, where one was found.
    end: Option<Cell>,
    planned: Instant,
    /// When the robot gives the goal up.
    until: Option<Instant>,
    /// When it came to the end of the way.
    arrived: Option<Instant>,
}

impl Goal {
    /// A goal whose way was last looked for at `planned`, and not found.
    const fn new(tile: Tile, planned: Instant) -> Self {
        Self { tile, end: None, planned, until: None, arrived: None }
    }
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
    pub(crate) barred: Bars,
    /// The candidates to which ways are looked for, which would take a fifth of a drone's stack.
    pub(crate) targets: Targets,
    pub(crate) search: Search,
    pub(crate) meeting: Meeting,
    sequence: u8,
    /// The packets that are still to be sent, the oldest first.
    outbox: Deque<Vec<u8, MOST_BYTES>, MOST_WAITING>,
    refreshed: Option<Instant>,
    /// The row of tiles with which the comparison of marks goes on, while one is under way.
    next_row: Option<u16>,
    pub(crate) bid: Option<Instant>,
    /// The last status: when, and of which activity.
    told: Option<(Instant, Activity)>,
    /// The version up to which changes were sent, and when the last were.
    sent: (u16, Instant),
}

impl<G: Ground, const ROBOTS: usize, const RECORDS: usize> Explorer<G, ROBOTS, RECORDS> {
    /// A robot that begins on that ground, which may hold what is known already.
    pub const fn new(config: Config, ground: G) -> Self {
        let start = Instant::ZERO;
        Self {
            config,
            ground,
            team: Team::new(config.number),
            ledger: Ledger::new(),
            leader: Leader::new(),
            state: State::Waiting { since: start },
            last_goal: Tile::FIRST,
            coast: None,
            barred: Bars::new(),
            targets: Targets::new(),
            search: Search::None,
            meeting: Meeting::new(),
            sequence: 0,
            outbox: Deque::new(),
            refreshed: None,
            next_row: None,
            bid: None,
            told: None,
            sent: (0, start),
        }
    }

    /// Begins anew, in the memory that it has, as a robot that knows nothing of that frame.
    ///
    /// # Errors
    /// [`TooManyCells`] where the frame has more cells than the ground has room for; the robot stays as
    /// it was.
    pub fn begin(&mut self, config: Config, frame: Frame) -> Result<(), TooManyCells> {
        self.ground.begin(frame)?;
        let Self {
            config: its_config,
            ground: _,
            team,
            ledger,
            leader,
            state,
            last_goal,
            coast,
            meeting,
            barred,
            targets,
            search,
            sequence,
            outbox,
            refreshed,
            next_row,
            bid,
            told,
            sent,
        } = self;
        *its_config = config;
        team.begin(config.number);
        ledger.clear();
        *leader = Leader::new();
        *state = State::Waiting { since: Instant::ZERO };
        *last_goal = Tile::FIRST;
        *coast = None;
        *meeting = Meeting::new();
        barred.clear();
        targets.clear();
        *search = Search::None;
        *sequence = 0;
        outbox.clear();
        *refreshed = None;
        *next_row = None;
        *bid = None;
        *told = None;
        *sent = (0, Instant::ZERO);
        Ok(())
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

    /// The numbers and the last places of the other robots that were heard of in the last seconds.
    pub fn others(&self, now: Instant) -> impl Iterator<Item = (u8, Point2)> {
        self.team.others(now)
    }

    /// One step. It is to be called some five times a second.
    pub fn step(&mut self, now: Instant, inputs: &Inputs<'_>) -> Outputs {
        let mut out = Outputs::default();
        for beam in inputs.beams {
            self.ground.trace(inputs.pose.at, beam.to, beam.end);
            if self.config.limits.gaze == Gaze::Around && beam.end == RayEnd::Obstacle {
                self.thicken(inputs.pose.at, beam.to);
            }
        }
        for bytes in inputs.packets {
            self.hear(now, bytes);
        }
        if is_due(self.refreshed, now) {
            self.refreshed = Some(now);
            self.meeting.start.get_or_insert(inputs.pose.at);
            self.forget_silent(now);
            self.next_row = Some(0);
        }
        if let Some(row) = self.next_row {
            self.next_row = self.refresh(now, row);
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

    /// Takes the unknown cells behind a hit for a part of the obstacle. Four narrow beams leave gaps
    /// in a wall that a robot would look at one by one.
    fn thicken(&mut self, from: Point2, hit: Point2) {
        let frame = *self.ground.frame();
        let (distance, side) = (from.distance(hit).0, frame.resolution().0);
        if distance < side {
            return;
        }
        for cells in 1..=BEHIND {
            let by = f32::from(cells) * side / distance;
            let behind = Point2::new(hit.x + by * (hit.x - from.x), hit.y + by * (hit.y - from.y));
            if let Some(cell) = frame.cell_at(behind)
                && self.ground.state(cell) == CellState::Unknown
            {
                self.ground.set(cell, CellState::Occupied);
            }
        }
    }

    /// Bids, leads, and tells.
    #[inline(never)]
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

    #[inline(never)]
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
                self.search = Search::None;
                let planned = now - PERIOD;
                self.state = State::Going(Goal::new(tile, planned));
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
            self.send(Body::Orders(filled(some.iter().copied())));
        }
    }

    /// Compares marks with the map from a row of tiles on, and, after the last one, answers what others
    /// ask; returns the row with which it goes on.
    #[inline(never)]
    fn refresh(&mut self, now: Instant, row: u16) -> Option<u16> {
        let frame = *self.ground.frame();
        let rows = Tile::rows(&frame);
        let end = row + rows.div_ceil(u16::from(self.config.refresh_steps.max(1)));
        for tile in Tile::in_rows(&frame, row..end.min(rows)) {
            let mark = self.mark_of(tile, now);
            self.mark(tile, mark);
        }
        if end < rows {
            return Some(end);
        }
        if self.config.rule.overlap == Overlap::Asked {
            let asked: Vec<Tile, MOST_TARGETS> =
                filled(self.team.board.to_look_up(self.config.number));
            for tile in asked {
                if self.is_known(tile) {
                    self.mark(tile, Mark::Settled);
                }
            }
        }
        self.ledger.forget_gone(self.team.known_to_all(self.ledger.version()));
        None
    }

    /// What the robot has to say of a tile by its map.
    fn mark_of(&self, tile: Tile, now: Instant) -> Mark {
        let rule = &self.config.rule;
        let frame = *self.ground.frame();
        let was = self.ledger.mark(tile);
        if was == Mark::Settled {
            return was;
        }
        if let Some(most) = self.gains(tile).max() {
            let gain = Gain::of_cells(most);
            let is_told = rule.reachability && rule.distance == Distance::Straight;
            return match was {
                _ if is_told && self.barred.holds(tile, now) => Mark::Unreachable,
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
        tile.cells(&frame).any(is_free) && !self.has_frontier(tile)
    }

    /// The gains of those cells of a tile that are frontiers which count.
    fn gains(&self, tile: Tile) -> impl Iterator<Item = u8> {
        let Config { least_gain, rule, .. } = self.config;
        let cells = tile.cells(self.ground.frame()).filter(|&cell| self.ground.is_frontier(cell));
        let large = cells.filter(move |&cell| is_large(&self.ground, cell, rule.least_frontier));
        large.map(|cell| self.ground.gain(cell)).filter(move |gain| *gain >= least_gain)
    }

    fn has_frontier(&self, tile: Tile) -> bool {
        self.gains(tile).next().is_some()
    }

    /// Flies on to the goal.
    #[inline(never)]
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
            self.search = Search::None;
            goal = Goal::new(next, now - PERIOD);
        }
        if goal.until.is_some_and(|until| now >= until) {
            return self.give_up(now, goal.tile);
        }
        let is_due = goal.end.is_none() || now.since(goal.planned) >= PERIOD;
        if is_due || self.search == Search::Way {
            let Some(planned) = self.plan(now, pose, goal) else {
                self.state = State::Going(goal);
                return self.turn_on_the_spot();
            };
            goal = planned;
            self.state = State::Going(goal);
        }
        let Some(end) = goal.end else { return self.give_up(now, goal.tile) };
        let limits = self.config.limits;
        let mut progress = fly(&self.ground, pose, (end, goal.tile), limits, rule.facing);
        if progress == Progress::Arrived {
            let since = *goal.arrived.get_or_insert(now);
            self.state = State::Going(goal);
            progress = look(&self.ground, pose, goal.tile, limits, now.since(since));
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
                    self.barred.bar(now, goal.tile, rule.blacklist);
                }
                self.wait(now)
            }
        }
    }

    /// Flies on to where the last goal was seen from, until there is another, and looks around there.
    fn fly_on(&mut self, now: Instant, pose: Pose2) -> Motion {
        let Config { limits, rule, .. } = self.config;
        if matches!(self.state, State::Idle { .. }) && self.team.misses_a_robot(now) {
            return self.meet(now, pose);
        }
        if self.search == Search::Meeting {
            self.search = Search::None;
        }
        match self.state {
            State::Waiting { .. } => self.meeting.since = None,
            State::Idle { .. } | State::Going(_) | State::Stopped => return Motion::default(),
        }
        // A search that is under way has forgotten the way.
        if let Some(end) = self.coast.filter(|_| self.search == Search::None) {
            match fly(&self.ground, pose, (end, self.last_goal), limits, rule.facing) {
                Progress::Flying(motion) => return motion,
                Progress::Arrived | Progress::Blocked => self.coast = None,
            }
        }
        self.turn_on_the_spot()
    }

    /// Looks around, where the rule has robots look at what they fly for.
    const fn turn_on_the_spot(&self) -> Motion {
        match self.config.rule.facing {
            Facing::Way => Motion { velocity: [0.0; 2], yaw_rate: 0.0 },
            Facing::Goal => Motion { velocity: [0.0; 2], yaw_rate: self.config.limits.turn },
        }
    }

    /// Whether there is still something to see at a tile.
    fn is_open(&self, tile: Tile) -> bool {
        let here = self.has_frontier(tile);
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

    /// Finds the way to the goal in the map as it is now; `None` while the search goes on.
    fn plan(&mut self, now: Instant, pose: Pose2, goal: Goal) -> Option<Goal> {
        if self.search != Search::Way {
            self.ground.begin_search(pose.at);
        }
        let mut found = None;
        let is_over = self.ground.search(self.config.most_cells(), |map, visit| {
            if map.is_beside(visit.cell, goal.tile) {
                found = Some(visit);
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        });
        self.search = if is_over { Search::None } else { Search::Way };
        if !is_over {
            return None;
        }
        let frame = self.ground.frame();
        let seconds = found.map(|at| 2.0 * length(at.cost, frame).0 / self.config.limits.speed);
        let patience = seconds.map(|s| PATIENCE + Duration::from_millis((s * 1000.0) as u64));
        Some(Goal {
            end: found.map(|at| at.cell),
            planned: now,
            until: goal.until.or_else(|| patience.map(|patience| now + patience)),
            ..goal
        })
    }

    fn give_up(&mut self, now: Instant, tile: Tile) -> Motion {
        if self.config.rule.reachability {
            self.barred.bar(now, tile, self.config.rule.blacklist);
        }
        self.wait(now)
    }

    /// Waits for a goal, and asks for one at once.
    fn wait(&mut self, now: Instant) -> Motion {
        self.search = Search::None;
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
