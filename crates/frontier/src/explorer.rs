//! One robot that explores: its map, its marks, its goal, and its part in the team.

use grid_map::{Area, Beam, Cell, CellState, Frame, RayEnd, TooManyCells};
use heapless::{Deque, Vec};
use units::{Duration, Instant, Metres, Point2, Pose2};

use crate::apart::Blockade;
use crate::atlas::{Ground, View};
use crate::barred::Bars;
use crate::bidding::Targets;
use crate::flight::{Gaze, Limits, Motion};
use crate::going::Goal;
use crate::homeward::Homeward;
use crate::lead::Leader;
use crate::ledger::Ledger;
use crate::list::filled;
use crate::meeting::Meeting;
use crate::packet::{Activity, Body, MOST_BYTES, MOST_ORDERS, Order, Packet, Task};
use crate::rule::{Distance, Overlap, Rule};
use crate::team::Team;
use crate::tile::Tile;

/// How often a robot compares its marks with its map, plans its way anew, tells its status, and
/// repeats its bids.
pub(crate) const PERIOD: Duration = Duration::from_millis(1_000);
/// The most tiles that a robot looks up, or looks for ways to, at a time.
pub(crate) const MOST_TARGETS: usize = 256;
/// The cells behind a hit that count as a part of the obstacle: walls are not thinner. Our own number.
const BEHIND: u8 = 2;
/// The packets of a step: a drone's link has room for so many in a fifth of a second.
pub(crate) const PACKETS_A_STEP: usize = 4;
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
    /// Frontiers with an obstacle within so many cells are none, to each side: a robot's body does not fit
    /// there, and an opening through which it fits has frontiers farther from its sides. 0 counts all.
    pub frontier_room: u8,
    /// How many marks a step compares with the map, in whole rows of the area that has changed and one row
    /// at least; 0 for all. A drone's processor has not the time for all of them at once.
    pub compared_tiles: u16,
    /// A search of ways that visits more cells goes on in the next step, and the robot waits meanwhile; 0
    /// for no bound.
    pub search_cells: u16,
    /// Whether the robot sends others' packets on where a neighbour does not hear their maker (a mesh).
    /// Without that a robot's cluster are those that it hears itself.
    pub forwards: bool,
    /// Whether a robot that is told to stop flies back to where it began first, and stops there.
    pub returns: bool,
    /// How far ahead of where it began, by its first heading, a robot that comes back stops (m): 0 for one that knows
    /// its place, and more for one whose place drifts and that might come down on what stands behind it.
    pub stops_ahead: f32,
    /// Whether it is no robot but an access point: it stands, has no goal, and leads where it has the
    /// lowest number.
    pub stands: bool,
}

impl Config {
    /// A robot of a mesh, with a computer that compares its marks and searches its ways in one step, and
    /// for which every frontier that the rule counts is one.
    #[must_use]
    pub const fn unbounded(number: u8, rule: Rule, limits: Limits) -> Self {
        Self {
            number,
            rule,
            limits,
            least_gain: 0,
            frontier_room: 0,
            compared_tiles: 0,
            search_cells: 0,
            forwards: true,
            returns: false,
            stops_ahead: 0.0,
            stands: false,
        }
    }

    /// The cells that a search visits in a step.
    pub(crate) fn most_cells(&self) -> usize {
        or_all(self.search_cells)
    }

    /// The marks that a step compares with the map.
    pub(crate) fn most_tiles(&self) -> usize {
        or_all(self.compared_tiles)
    }
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

impl State {
    /// That of a robot which begins, or of an access point.
    const fn first(stands: bool) -> Self {
        let since = Instant::ZERO;
        if stands { Self::Idle { since } } else { Self::Waiting { since } }
    }
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
    /// How long the way back is.
    Homeward,
}

/// A robot of a team of at most `ROBOTS`, which remembers marks on at most `RECORDS` tiles.
#[derive(Clone, Debug)]
pub struct Explorer<G, const ROBOTS: usize, const RECORDS: usize> {
    pub(crate) config: Config,
    pub(crate) ground: G,
    pub(crate) team: Team<ROBOTS, RECORDS>,
    pub(crate) ledger: Ledger<RECORDS>,
    leader: Leader<ROBOTS>,
    pub(crate) state: State,
    pub(crate) last_goal: Tile,
    /// Where the robot flies while it waits for another goal.
    pub(crate) coast: Option<Cell>,
    pub(crate) barred: Bars,
    pub(crate) blockade: Option<Blockade>,
    /// The distance that it kept from others in the last step.
    pub(crate) distance: Metres,
    /// The candidates to which ways are looked for, which would take a fifth of a drone's stack.
    pub(crate) targets: Targets,
    pub(crate) search: Search,
    /// From where the search of ways to the targets looks at them.
    pub(crate) view: View,
    pub(crate) meeting: Meeting,
    pub(crate) homeward: Homeward,
    /// Whether it is called back to where it began, and explores no more.
    pub(crate) is_recalled: bool,
    /// Whether it was told to stop, and is on its way back or has stopped there.
    has_seen_all: bool,
    pub(crate) sequence: u8,
    /// The packets that are still to be sent, the oldest first.
    pub(crate) outbox: Deque<Vec<u8, MOST_BYTES>, MOST_WAITING>,
    refreshed: Option<Instant>,
    /// Whether a comparison of marks with the map is under way, and where it goes on.
    pub(crate) is_comparing: bool,
    pub(crate) to_compare: Option<Area>,
    /// The tile with which the answers to others begin.
    pub(crate) look_up_from: Tile,
    /// How far from the robot the targets begin, and how far away candidates were left out that did not fit
    /// among them, in tiles.
    pub(crate) targets_from: u16,
    pub(crate) left_out: Option<u16>,
    pub(crate) bid: Option<Instant>,
    /// The last status: when, and of which activity.
    pub(crate) told: Option<(Instant, Activity)>,
    /// The version up to which changes were sent.
    pub(crate) sent: u16,
    /// The version that each robot of the cluster has of this one's marks, and since when that is so while later
    /// ones were sent.
    pub(crate) acknowledged: (u16, Instant),
}

impl<G: Ground, const ROBOTS: usize, const RECORDS: usize> Explorer<G, ROBOTS, RECORDS> {
    /// A robot that begins on that ground, which may hold what is known already.
    pub const fn new(config: Config, ground: G) -> Self {
        Self {
            config,
            ground,
            team: Team::new(config.number, config.forwards),
            ledger: Ledger::new(),
            leader: Leader::new(),
            state: State::first(config.stands),
            last_goal: Tile::FIRST,
            coast: None,
            barred: Bars::new(),
            blockade: None,
            distance: Metres(0.0),
            targets: Targets::new(),
            search: Search::None,
            view: View::Beside,
            meeting: Meeting::new(),
            homeward: Homeward::new(),
            is_recalled: false,
            has_seen_all: false,
            sequence: 0,
            outbox: Deque::new(),
            refreshed: None,
            is_comparing: false,
            to_compare: None,
            look_up_from: Tile::FIRST,
            targets_from: 0,
            left_out: None,
            bid: None,
            told: None,
            sent: 0,
            acknowledged: (0, Instant::ZERO),
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
            homeward,
            barred,
            blockade,
            distance,
            targets,
            search,
            view,
            is_recalled,
            has_seen_all,
            sequence,
            outbox,
            refreshed,
            is_comparing,
            to_compare,
            look_up_from,
            targets_from,
            left_out,
            bid,
            told,
            sent,
            acknowledged,
        } = self;
        *its_config = config;
        team.begin(config.number, config.forwards);
        ledger.clear();
        *leader = Leader::new();
        *state = State::first(config.stands);
        *last_goal = Tile::FIRST;
        *coast = None;
        *meeting = Meeting::new();
        *homeward = Homeward::new();
        barred.clear();
        *blockade = None;
        *distance = Metres(0.0);
        targets.clear();
        *search = Search::None;
        *view = View::Beside;
        (*is_recalled, *has_seen_all) = (false, false);
        *sequence = 0;
        outbox.clear();
        *refreshed = None;
        *is_comparing = false;
        *to_compare = None;
        *look_up_from = Tile::FIRST;
        *targets_from = 0;
        *left_out = None;
        *bid = None;
        *told = None;
        *sent = 0;
        *acknowledged = (0, Instant::ZERO);
        Ok(())
    }

    /// The robot's map.
    pub const fn ground(&self) -> &G {
        &self.ground
    }

    /// Calls the robot back to where it began, where it stops, or lets it explore again before it has.
    pub fn recall(&mut self, now: Instant, is_recalled: bool) {
        if self.is_recalled == is_recalled || self.has_seen_all || self.state == State::Stopped {
            return;
        }
        self.set_recalled(now, is_recalled);
    }

    fn set_recalled(&mut self, now: Instant, is_recalled: bool) {
        self.is_recalled = is_recalled;
        self.blockade = None;
        self.wait(now);
        self.meeting.wait_again();
        if is_recalled {
            self.state = State::Idle { since: now };
        }
    }

    /// Whether the robot is called back to where it began, and explores no more.
    pub const fn is_recalled(&self) -> bool {
        self.is_recalled
    }

    /// Whether the robot was told to stop since nothing is left to explore. It may be on its way back.
    pub const fn has_seen_all(&self) -> bool {
        self.has_seen_all
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
            self.ground.sense(inputs.pose.at, beam);
            let is_narrow = self.config.limits.gaze == Gaze::Around && beam.cone.is_none();
            if is_narrow && beam.end == RayEnd::Obstacle {
                self.thicken(inputs.pose.at, beam.to);
            }
        }
        for bytes in inputs.packets {
            self.hear(now, bytes);
        }
        if is_due(self.refreshed, now) {
            self.refreshed = Some(now);
            self.meeting.begin(inputs.pose, self.config.stops_ahead);
            self.forget_silent(now);
            self.begin_to_compare();
        }
        if self.is_comparing {
            self.compare(now);
        }
        if !self.config.stands && self.search != Search::Homeward {
            out.motion = self.go_on(now, inputs.pose);
        }
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

    /// Begins a search of ways.
    pub(crate) fn begin_search(&mut self, now: Instant, from: Point2) {
        let avoided = self.avoided(now);
        self.ground.begin_search(from, avoided);
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
            _ if self.config.stands => {}
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
        self.team.note_own(now, position, self.told_activity(), self.last_goal);
    }

    /// What the robot tells others that it does: one that was told to stop takes no part any more.
    pub(crate) const fn told_activity(&self) -> Activity {
        if self.has_seen_all { Activity::Stopped } else { self.activity() }
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
            // On its way back it stops by itself.
            _ if self.is_recalled => {}
            (Task::Stop, _) => {
                self.has_seen_all = true;
                match self.config.returns {
                    true => self.set_recalled(now, true),
                    false => self.state = State::Stopped,
                }
            }
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
}

/// A bound of which 0 stands for none.
fn or_all(most: u16) -> usize {
    if most == 0 { usize::MAX } else { most.into() }
}

pub(crate) fn is_due(last: Option<Instant>, now: Instant) -> bool {
    last.is_none_or(|last| now.since(last) >= PERIOD)
}
