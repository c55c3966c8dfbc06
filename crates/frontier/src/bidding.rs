//! How a robot finds out which candidates it would go to, and asks for one.

use core::ops::ControlFlow;

use grid_map::Cell;
use heapless::Vec;
use units::{Duration, Instant, Metres, Pose2};

use crate::assignment::utility;
use crate::atlas::{Ground, Sight, View, length};
use crate::board::Candidate;
use crate::cluster::RobotSet;
use crate::explorer::{Explorer, MOST_TARGETS, Search, State, is_due};
use crate::flight::{Gaze, first_turn};
use crate::packet::{Activity, Bid, Body, MOST_BIDS, Task};
use crate::rule::Facing;
use crate::tile::{Gain, Tile};

/// A robot that has bid for so long without an order chooses for itself.
const ALONE_AFTER: Duration = Duration::from_millis(4_000);
/// Two bids of a robot are at least so many tiles apart.
const BID_SPACING: u16 = 3;
/// A robot that can reach nothing stays so for so long before it stops by itself.
const STOP_AFTER: Duration = Duration::from_millis(2_000);

/// After so many cells a search of ways looks whether it has found the best bids already: a square of
/// 6.4 m at 0.1 m a cell. Our own number.
const CELLS_BETWEEN_LOOKS: usize = 4_096;

/// A candidate to which a way is looked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    tile: Tile,
    gain: Gain,
    /// The cell at the end of the way, with its cost, where one was found; a way of 1,300 m and more
    /// counts as that.
    found: Option<(Cell, u16)>,
}

impl Target {
    const fn new(open: Candidate) -> Self {
        Self { tile: open.tile, gain: open.gain, found: None }
    }
}

pub(crate) type Targets = Vec<Target, MOST_TARGETS>;

impl<G: Ground, const ROBOTS: usize, const RECORDS: usize> Explorer<G, ROBOTS, RECORDS> {
    /// Bids for a goal where the robot has none.
    pub(crate) fn bid(&mut self, now: Instant, pose: Pose2, members: RobotSet) {
        let Some(since) = self.without_goal_since() else { return };
        let Some(bids) = self.bids(now, pose) else { return };
        self.note_whether_idle(now, since, bids.is_empty() && self.team.is_up_to_date(members));
        if now.since(since) >= ALONE_AFTER
            && let Some(tile) = self.free_bid(&bids, members)
        {
            self.take(now, Task::Go(tile));
            return;
        }
        let leads = self.team.leader(members) == Some(self.config.number);
        if !leads && !bids.is_empty() {
            self.send(Body::Bids(bids.clone()));
        }
        if let Some(own) = self.team.member_mut(self.config.number) {
            own.bids = bids;
            own.bids_at = Some(now);
        }
    }

    /// Chooses a goal without the others, and stops where there is none.
    pub(crate) fn choose_alone(&mut self, now: Instant, pose: Pose2) {
        let Some(since) = self.without_goal_since() else { return };
        let Some(bids) = self.bids(now, pose) else { return };
        self.note_whether_idle(now, since, bids.is_empty());
        match (bids.first(), self.state) {
            (Some(best), _) => self.take(now, Task::Go(best.tile)),
            (None, State::Idle { since }) if now.since(since) >= STOP_AFTER => {
                self.take(now, Task::Stop);
            }
            _ => {}
        }
    }

    /// Where the leader measures straight distances, a robot is idle when it is barred for good from
    /// each candidate.
    pub(crate) fn find_idle(&mut self, now: Instant, members: RobotSet) {
        let Some(since) = self.without_goal_since() else { return };
        let is_barred = |candidate: Candidate| self.barred.holds(candidate.tile, now);
        let has_none = self.team.board.candidates().all(is_barred);
        self.note_whether_idle(now, since, has_none && self.team.is_up_to_date(members));
    }

    fn without_goal_since(&self) -> Option<Instant> {
        match self.state {
            _ if self.is_recalled => None,
            State::Waiting { since } | State::Idle { since } => Some(since),
            State::Going(_) | State::Stopped => None,
        }
    }

    fn note_whether_idle(&mut self, now: Instant, since: Instant, has_none: bool) {
        let is_idle = has_none
            && self.avoided(now).is_none()
            && !self.barred.has_to_come(now, |tile| self.team.board.is_candidate(tile));
        self.state = match self.state {
            State::Waiting { .. } if is_idle => State::Idle { since: now },
            State::Idle { .. } if !is_idle => State::Waiting { since: now },
            State::Idle { .. } => State::Idle { since },
            _ => State::Waiting { since },
        };
    }

    /// The best bid that is not another robot's goal.
    fn free_bid(&self, bids: &[Bid], members: RobotSet) -> Option<Tile> {
        let others = members.without(self.config.number);
        let is_taken = |tile: Tile| {
            let going = others.iter().filter_map(|robot| self.team.member(robot));
            let mut going = going.filter(|m| m.activity == Activity::Going);
            going.any(|m| m.goal.steps_to(tile) < BID_SPACING)
        };
        bids.iter().map(|bid| bid.tile).find(|&tile| !is_taken(tile))
    }

    /// The candidates that this robot would go to, best first; `None` while it is not yet time to bid
    /// again, or the search of ways goes on.
    fn bids(&mut self, now: Instant, pose: Pose2) -> Option<Vec<Bid, MOST_BIDS>> {
        if self.search != Search::Bids {
            let is_held = matches!(self.search, Search::Meeting | Search::Homeward);
            if is_held || !is_due(self.bid, now) {
                return None;
            }
            self.bid = Some(now);
            self.find_targets(now, pose);
            self.view = View::Beside;
            if !self.targets.is_empty() {
                self.begin_search(now, pose.at);
            }
        }
        let is_over = self.find_ways(now, pose);
        self.search = if is_over { Search::None } else { Search::Bids };
        if !is_over {
            return None;
        }
        let bids = self.best_bids(pose);
        let farther = self.left_out.filter(|_| bids.is_empty());
        self.targets_from = farther.unwrap_or(0);
        farther.is_none().then_some(bids)
    }

    /// Takes the nearest candidates for targets; where there is no room for all and no way leads to any of
    /// them, those beyond are taken the next time.
    fn find_targets(&mut self, now: Instant, pose: Pose2) {
        let Self { targets, team, barred, ground, targets_from, left_out, .. } = self;
        let (team, barred, from) = (&*team, &*barred, *targets_from);
        let own = ground.frame().cell_at(pose.at).and_then(Tile::of).unwrap_or(Tile::FIRST);
        let within = |end: u16| {
            let is_within = move |tile: Tile| (from..end).contains(&own.steps_to(tile));
            let open = team.board.candidates().filter(|open| !barred.holds(open.tile, now));
            open.filter(move |open| is_within(open.tile))
        };
        let has_room = |end: u16| within(end).nth(MOST_TARGETS).is_none();
        let (mut end, mut too_far) = (Tile::MOST, None);
        if !has_room(end) {
            let mut nearest = from + 1;
            while end - nearest > 1 {
                let middle = u16::midpoint(nearest, end);
                if has_room(middle) { nearest = middle } else { end = middle }
            }
            (end, too_far) = (nearest, Some(nearest));
        }
        *left_out = too_far;
        // In their place: a list of them on the stack would take a fifth of a drone's.
        targets.clear();
        targets.extend(within(end).take(MOST_TARGETS).map(Target::new));
    }

    /// Goes on with the search of ways to the targets; says whether it is over, which it is as well when
    /// no target that is farther away would be among the best. Where no way leads beside any of them, they
    /// are looked at from afar.
    fn find_ways(&mut self, now: Instant, pose: Pose2) -> bool {
        let mut left = self.config.most_cells();
        while left > 0 {
            let part = left.min(CELLS_BETWEEN_LOOKS);
            let (is_over, cost) = self.find_ways_in(part);
            left -= part;
            if !is_over && !self.has_the_best(pose, cost) {
                continue;
            }
            let has_found = self.targets.iter().any(|target| target.found.is_some());
            match self.farther(now, self.view) {
                Some(view) if !has_found && !self.targets.is_empty() => {
                    self.view = view;
                    self.begin_search(now, pose.at);
                }
                _ => return true,
            }
        }
        false
    }

    /// Goes on with the search for so many cells; says whether it is over, and the cost of the last cell.
    fn find_ways_in(&mut self, cells: usize) -> (bool, u32) {
        let Self { targets, ground, view, .. } = self;
        let view = *view;
        let mut left = targets.iter().filter(|target| target.found.is_none()).count();
        let mut last = 0;
        if left == 0 {
            return (true, last);
        }
        let is_over = ground.search(cells, |map, visit| {
            last = visit.cost;
            for target in around(targets, visit.cell, view) {
                if target.found.is_none() && map.shows(visit.cell, target.tile, view) {
                    let cost = u16::try_from(visit.cost).unwrap_or(u16::MAX);
                    target.found = Some((visit.cell, cost));
                    left -= 1;
                }
            }
            if left == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        (is_over, last)
    }

    /// Whether as many bids as a packet carries were found, and each is worth more than any target whose way
    /// costs `cost` or more.
    fn has_the_best(&self, pose: Pose2, cost: u32) -> bool {
        let unfound = self.targets.iter().filter(|target| target.found.is_none());
        let Some(gain) = unfound.map(|target| target.gain).max() else { return true };
        let found = self.targets.iter().filter(|target| target.found.is_some());
        if found.count() < MOST_BIDS {
            return false;
        }
        let bids = self.best_bids(pose);
        let worth = |gain: Gain, way| utility(&self.config.rule, gain.cells(), way, || 0.0);
        let farther = worth(gain, length(cost, self.ground.frame()));
        bids.is_full() && bids.last().is_some_and(|last| worth(last.gain, last.distance) > farther)
    }

    fn best_bids(&self, pose: Pose2) -> Vec<Bid, MOST_BIDS> {
        let mut bids: Vec<Bid, MOST_BIDS> = Vec::new();
        let found = |target: &Target| {
            let distance = self.distance(pose, target.found?);
            Some(Bid { tile: target.tile, gain: target.gain, distance })
        };
        while !bids.is_full() {
            let is_near = |bid: &Bid| bids.iter().any(|b| b.tile.steps_to(bid.tile) < BID_SPACING);
            let worth =
                |bid: &Bid| utility(&self.config.rule, bid.gain.cells(), bid.distance, || 0.0);
            let open = self.targets.iter().filter_map(found).filter(|bid| !is_near(bid));
            let Some(best) = open.max_by(|a, b| worth(a).total_cmp(&worth(b))) else { break };
            // There is room, by the loop's condition.
            let _ = bids.push(best);
        }
        bids
    }

    /// The length of a way, with the way that the robot would fly in the time of the turn at its
    /// beginning: the robot turns before it flies, or meanwhile.
    fn distance(&self, pose: Pose2, (end, cost): (Cell, u16)) -> Metres {
        let limits = self.config.limits;
        let way = length(cost.into(), self.ground.frame()).0;
        let turn = || first_turn(&self.ground, pose, end) * limits.speed / limits.turn;
        Metres(match (limits.gaze, self.config.rule.facing) {
            (Gaze::Ahead, Facing::Way) => way + turn(),
            (Gaze::Ahead, Facing::Goal) => way.max(turn()),
            (Gaze::Around, _) => way,
        })
    }
}

/// The targets of which the tile may be looked at from a cell, and perhaps some more.
fn around(targets: &mut [Target], cell: Cell, view: View) -> impl Iterator<Item = &mut Target> {
    let middle = Tile::of(cell);
    let rows = middle.map_or(0, Tile::row);
    let off = view.tiles();
    let key = |target: &Target| target.tile.row();
    let first = targets.partition_point(|target| key(target) + off < rows);
    let end = targets.partition_point(|target| key(target) <= rows + off);
    let near = targets.get_mut(first..end).unwrap_or_default();
    near.iter_mut()
        .filter(move |target| middle.is_some_and(|tile| tile.steps_to(target.tile) <= off))
}
