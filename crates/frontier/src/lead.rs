//! What the leader of a cluster does: it collects, assigns, and stops the robots in the end.

use grid_map::Frame;
use heapless::Vec;
use units::{Duration, Instant, Metres, Point2};

use crate::assignment::{Distances, Place, assign, take};
use crate::cluster::RobotSet;
use crate::overlap::{Shape, is_overlapped};
use crate::packet::{Activity, Order, Task};
use crate::rule::{Distance, Overlap, Pace, Rule};
use crate::team::{Member, Team};
use crate::tile::Tile;

/// The leader waits so long for the bids of other robots that have no goal either.
const GATHER: Duration = Duration::from_millis(600);
/// The marks of all robots need so long to arrive at the beginning.
const FIRST_ROUND: Duration = Duration::from_millis(2_500);
/// An order that was not carried out is given again, and rounds follow each other, after so long.
const AGAIN: Duration = Duration::from_millis(1_000);
/// A robot for which there was no candidate is thought of again after so long.
const RETRY: Duration = Duration::from_millis(5_000);
/// All robots must have been idle for so long: two statuses of each.
const ALL_IDLE: Duration = Duration::from_millis(2_000);
/// A leader waits so long for the others to stop before it stops itself.
const STOPPING: Duration = Duration::from_millis(10_000);

#[derive(Clone, Copy, Debug)]
struct Given {
    tile: Tile,
    at: Instant,
}

/// A leader's memory. A robot that does not lead keeps it empty.
#[derive(Clone, Debug)]
pub(crate) struct Leader<const ROBOTS: usize> {
    began: Option<Instant>,
    round: Option<Instant>,
    given: [Option<Given>; ROBOTS],
    idle_since: Option<Instant>,
    stopping: Option<Stopping>,
}

#[derive(Clone, Copy, Debug)]
struct Stopping {
    since: Instant,
    told: Instant,
}

type Orders<const ROBOTS: usize> = Vec<Order, ROBOTS>;

impl<const ROBOTS: usize> Leader<ROBOTS> {
    pub(crate) const fn new() -> Self {
        Self { began: None, round: None, given: [None; ROBOTS], idle_since: None, stopping: None }
    }

    /// The orders that are to be sent now.
    pub(crate) fn step<const RECORDS: usize>(
        &mut self,
        now: Instant,
        rule: &Rule,
        team: &Team<ROBOTS, RECORDS>,
        members: RobotSet,
        frame: &Frame,
    ) -> Orders<ROBOTS> {
        let began = *self.began.get_or_insert(now);
        if let Some(stopping) = self.stopping {
            return self.stop(now, stopping, team, members);
        }
        let round = Round { now, rule, team, members, frame };
        let are_idle = self.are_idle(&round);
        if now.since(began) < FIRST_ROUND {
            return Orders::new();
        }
        if are_idle {
            return self.stop(now, Stopping { since: now, told: now - AGAIN }, team, members);
        }
        match rule.distance {
            Distance::Path => self.answer_bids(&round),
            Distance::Straight => self.lead_straight(&round),
        }
    }

    /// Whether no robot can reach a candidate, as far as the rule asks.
    fn are_idle<const RECORDS: usize>(&mut self, round: &Round<'_, ROBOTS, RECORDS>) -> bool {
        let is_idle =
            |member: &Member| matches!(member.activity, Activity::Idle | Activity::Stopped);
        let all = match round.rule {
            Rule { confirmed_stop: true, .. } => {
                !round.team.misses_a_robot(round.now) && round.members().all(|(_, m)| is_idle(m))
            }
            Rule { distance: Distance::Path, .. } => {
                round.members().next().is_some_and(|(_, leader)| is_idle(leader))
            }
            Rule { distance: Distance::Straight, .. } => false,
        };
        if !all {
            self.idle_since = None;
            return false;
        }
        round.now.since(*self.idle_since.get_or_insert(round.now)) >= ALL_IDLE
    }

    /// Orders all to stop, and at last itself.
    fn stop<const RECORDS: usize>(
        &mut self,
        now: Instant,
        stopping: Stopping,
        team: &Team<ROBOTS, RECORDS>,
        members: RobotSet,
    ) -> Orders<ROBOTS> {
        let Some(own) = team.leader(members) else { return Orders::new() };
        let is_on = |&robot: &u8| {
            robot != own && team.member(robot).is_some_and(|m| m.activity != Activity::Stopped)
        };
        let others: RobotSet = members.iter().filter(is_on).collect();
        self.stopping = Some(stopping);
        let is_last = others.is_empty() || now.since(stopping.since) >= STOPPING;
        if !is_last && now.since(stopping.told) < AGAIN {
            return Orders::new();
        }
        self.stopping = Some(Stopping { told: now, ..stopping });
        let to = if is_last { others.with(own) } else { others };
        to.iter().map(|robot| Order { robot, task: Task::Stop }).collect()
    }

    /// Assigns by the bids of robots that have no goal.
    fn answer_bids<const RECORDS: usize>(
        &mut self,
        round: &Round<'_, ROBOTS, RECORDS>,
    ) -> Orders<ROBOTS> {
        let Round { now, rule, team, .. } = *round;
        let has_asked = |robot: u8, m: &Member| {
            let given = self.given_at(robot);
            let is_new = m.bids_at.is_some_and(|at| given.is_none_or(|given| at > given));
            m.activity == Activity::Waiting && is_new && !m.bids.is_empty()
        };
        let waiting = round.members().filter(|(_, m)| m.activity == Activity::Waiting);
        let (asking, late): (RobotSet, RobotSet) =
            waiting.fold(Default::default(), |sets, (n, m)| {
                let (asking, late) = sets;
                if has_asked(n, m) { (asking.with(n), late) } else { (asking, late.with(n)) }
            });
        let first = asking.iter().filter_map(|n| team.member(n)?.bids_at).min();
        let Some(first) = first else { return Orders::new() };
        let is_due = match rule.pace {
            Pace::OnEvent => late.is_empty() || now.since(first) >= GATHER,
            Pace::Every(period) => self.round.is_none_or(|last| now.since(last) >= period),
        };
        if !is_due {
            return Orders::new();
        }
        let bidders = Bidders::<ROBOTS, RECORDS>::gather(round, asking);
        self.assign(round, bidders.places(), &bidders, &bidders.robots, &bidders.tiles)
    }

    /// Assigns by straight distances among all candidates.
    fn lead_straight<const RECORDS: usize>(
        &mut self,
        round: &Round<'_, ROBOTS, RECORDS>,
    ) -> Orders<ROBOTS> {
        let again = self.unheeded(round);
        let since = self.round.map(|last| round.now.since(last));
        let waiting = || round.members().filter(|(_, m)| m.activity == Activity::Waiting);
        let has_come_back = waiting().any(|(robot, m)| {
            let given = self.given.get(usize::from(robot)).copied().flatten();
            given.is_some_and(|given| m.goal == given.tile && m.heard > Some(given.at))
        });
        let is_due = match (round.rule.pace, since) {
            (_, None) => true,
            (Pace::Every(period), Some(since)) => since >= period,
            (Pace::OnEvent, Some(since)) => {
                since >= AGAIN && has_come_back || since >= RETRY && waiting().next().is_some()
            }
        };
        if !is_due {
            return again;
        }
        let askers = Askers::<ROBOTS, RECORDS>::gather(round);
        if askers.is_over() && !round.rule.confirmed_stop {
            let stopping = Stopping { since: round.now, told: round.now - AGAIN };
            return self.stop(round.now, stopping, round.team, round.members);
        }
        let places = askers.candidates.iter().map(|open| open.place).collect();
        let tiles: Vec<Tile, RECORDS> = askers.candidates.iter().map(|open| open.tile).collect();
        self.assign(round, places, &askers, &askers.robots, &tiles)
    }

    /// Orders that their robots have not taken, to be given again.
    fn unheeded<const RECORDS: usize>(
        &mut self,
        round: &Round<'_, ROBOTS, RECORDS>,
    ) -> Orders<ROBOTS> {
        let mut orders = Orders::new();
        for (robot, member) in round.members() {
            let Some(Some(given)) = self.given.get_mut(usize::from(robot)) else { continue };
            let has_not_heard = member.activity == Activity::Waiting
                && member.goal != given.tile
                && round.now.since(given.at) >= AGAIN;
            if has_not_heard {
                given.at = round.now;
                let _ = orders.push(Order { robot, task: Task::Go(given.tile) });
            }
        }
        orders
    }

    fn assign<const RECORDS: usize>(
        &mut self,
        round: &Round<'_, ROBOTS, RECORDS>,
        mut places: Vec<Place, RECORDS>,
        distances: &impl Distances,
        robots: &[u8],
        tiles: &[Tile],
    ) -> Orders<ROBOTS> {
        self.round = Some(round.now);
        for (robot, member) in round.members().filter(|(robot, _)| !robots.contains(robot)) {
            if let Some(goal) = self.goal_of(round.now, robot, member) {
                take(round.rule, &mut places, goal.centre(round.frame));
            }
        }
        let assigned = assign::<ROBOTS>(round.rule, &mut places, distances);
        let mut orders = Orders::new();
        for one in assigned {
            let at = (robots.get(one.robot), tiles.get(one.place));
            let (Some(&robot), Some(&tile)) = at else { continue };
            if let Some(given) = self.given.get_mut(usize::from(robot)) {
                *given = Some(Given { tile, at: round.now });
            }
            let _ = orders.push(Order { robot, task: Task::Go(tile) });
        }
        orders
    }

    /// Where a robot goes that keeps its goal, by its status or by an order that is newer.
    fn goal_of(&self, now: Instant, robot: u8, member: &Member) -> Option<Tile> {
        if member.activity == Activity::Going {
            return Some(member.goal);
        }
        let given = self.given.get(usize::from(robot)).copied().flatten()?;
        (now.since(given.at) < AGAIN).then_some(given.tile)
    }

    fn given_at(&self, robot: u8) -> Option<Instant> {
        self.given.get(usize::from(robot)).copied().flatten().map(|given| given.at)
    }
}

/// What a leader looks at in one round.
#[derive(Clone, Copy)]
struct Round<'a, const ROBOTS: usize, const RECORDS: usize> {
    now: Instant,
    rule: &'a Rule,
    team: &'a Team<ROBOTS, RECORDS>,
    members: RobotSet,
    frame: &'a Frame,
}

impl<'a, const ROBOTS: usize, const RECORDS: usize> Round<'a, ROBOTS, RECORDS> {
    /// The robots of the cluster that have not stopped; the leader is the first.
    fn members(&self) -> impl Iterator<Item = (u8, &'a Member)> + use<'a, ROBOTS, RECORDS> {
        let team = self.team;
        let all = self.members.iter().filter_map(move |n| Some((n, team.member(n)?)));
        all.filter(|(_, member)| member.activity != Activity::Stopped)
    }
}

/// Robots that bid, and the tiles for which they do.
struct Bidders<'a, const ROBOTS: usize, const RECORDS: usize> {
    team: &'a Team<ROBOTS, RECORDS>,
    frame: &'a Frame,
    robots: Vec<u8, ROBOTS>,
    tiles: Vec<Tile, RECORDS>,
    gains: Vec<f32, RECORDS>,
}

impl<'a, const ROBOTS: usize, const RECORDS: usize> Bidders<'a, ROBOTS, RECORDS> {
    fn gather(round: &Round<'a, ROBOTS, RECORDS>, asking: RobotSet) -> Self {
        let (mut tiles, mut gains) = (Vec::new(), Vec::new());
        for member in asking.iter().filter_map(|robot| round.team.member(robot)) {
            for bid in &member.bids {
                let at = tiles.binary_search(&bid.tile);
                // What has no room is bid for again.
                if let Err(at) = at
                    && tiles.insert(at, bid.tile).is_ok()
                {
                    let _ = gains.insert(at, bid.gain.cells());
                }
            }
        }
        let robots = asking.iter().take(ROBOTS).collect();
        Self { team: round.team, frame: round.frame, robots, tiles, gains }
    }

    fn places(&self) -> Vec<Place, RECORDS> {
        let all = self.tiles.iter().zip(&self.gains);
        all.map(|(tile, &gain)| Place { position: tile.centre(self.frame), gain }).collect()
    }
}

impl<const ROBOTS: usize, const RECORDS: usize> Distances for Bidders<'_, ROBOTS, RECORDS> {
    fn robots(&self) -> usize {
        self.robots.len()
    }

    fn distance(&self, robot: usize, place: usize) -> Option<Metres> {
        let member = self.team.member(*self.robots.get(robot)?)?;
        let tile = self.tiles.get(place)?;
        member.bids.iter().find(|bid| bid.tile == *tile).map(|bid| bid.distance)
    }
}

/// A candidate, as the leader sees it.
#[derive(Clone, Copy)]
struct Open {
    tile: Tile,
    place: Place,
    unreachable: RobotSet,
}

/// Robots among which all candidates are shared out by straight distance.
struct Askers<const ROBOTS: usize, const RECORDS: usize> {
    robots: Vec<u8, ROBOTS>,
    positions: Vec<Point2, ROBOTS>,
    candidates: Vec<Open, RECORDS>,
}

impl<const ROBOTS: usize, const RECORDS: usize> Askers<ROBOTS, RECORDS> {
    fn gather(round: &Round<'_, ROBOTS, RECORDS>) -> Self {
        let rule = round.rule;
        let is_asker = |m: &Member| !rule.keeps_goals || m.activity == Activity::Waiting;
        let (mut robots, mut positions) = (Vec::new(), Vec::new());
        for (robot, member) in round.members().filter(|(_, m)| is_asker(m)).take(ROBOTS) {
            let _ = robots.push(robot);
            let _ = positions.push(member.position);
        }
        let mut candidates = Vec::new();
        for open in round.team.board.candidates() {
            let position = open.tile.centre(round.frame);
            let is_left = match rule.overlap {
                Overlap::Points(shape) => is_left(round, open.open, position, shape),
                Overlap::Asked | Overlap::Alone => true,
            };
            let unreachable = if rule.reachability { open.unreachable } else { RobotSet::EMPTY };
            if is_left {
                let place = Place { position, gain: open.gain.cells() };
                let _ = candidates.push(Open { tile: open.tile, place, unreachable });
            }
        }
        Self { robots, positions, candidates }
    }

    /// Whether no robot can be sent anywhere.
    fn is_over(&self) -> bool {
        let all: RobotSet = self.robots.iter().copied().collect();
        self.candidates.iter().all(|open| all.minus(open.unreachable).is_empty())
    }
}

/// Whether a frontier of one of the finders lies in no other robot's area.
fn is_left<const ROBOTS: usize, const RECORDS: usize>(
    round: &Round<'_, ROBOTS, RECORDS>,
    finders: RobotSet,
    point: Point2,
    shape: Shape,
) -> bool {
    let board = &round.team.board;
    let is_seen_by = |other: u8| {
        let edge = board.edge(other).map(|tile| tile.centre(round.frame));
        is_overlapped(point, edge, shape)
    };
    let mut finders = finders.iter();
    finders.any(|finder| !round.members().any(|(other, _)| other != finder && is_seen_by(other)))
}

impl<const ROBOTS: usize, const RECORDS: usize> Distances for Askers<ROBOTS, RECORDS> {
    fn robots(&self) -> usize {
        self.robots.len()
    }

    fn distance(&self, robot: usize, place: usize) -> Option<Metres> {
        let open = self.candidates.get(place)?;
        let is_kept = open.unreachable.contains(*self.robots.get(robot)?);
        let way = self.positions.get(robot)?.distance(open.place.position);
        (!is_kept).then_some(way)
    }
}
