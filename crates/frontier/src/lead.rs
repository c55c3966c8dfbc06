//! What the leader of a cluster does: it collects, assigns, and stops the robots in the end.
//!
//! A leader that measures straight distances looks at all candidates at once, for which a drone's
//! stack has no room: the module `straight`, with the feature of that name.

#[cfg(feature = "straight")]
mod straight;

use grid_map::Frame;
use heapless::Vec;
use units::{Duration, Instant, Metres};

use crate::assignment::{Distances, Place, assign, take};
use crate::cluster::RobotSet;
use crate::list::{filled, insert};
use crate::packet::{Activity, MOST_BIDS, Order, Task};
use crate::rule::{Distance, Pace, Rule};
use crate::team::{Member, Team};
use crate::tile::Tile;

/// The leader waits so long for the bids of other robots that have no goal either.
const GATHER: Duration = Duration::from_millis(600);
/// The marks of all robots need so long to arrive at the beginning.
const FIRST_ROUND: Duration = Duration::from_millis(2_500);
/// An order that was not carried out is given again, and rounds follow each other, after so long.
const AGAIN: Duration = Duration::from_millis(1_000);
/// All robots must have been idle for so long: two statuses of each.
const ALL_IDLE: Duration = Duration::from_millis(2_000);
/// The places for which robots bid in one round: all bids of eight robots. A drone's stack has no room
/// for many more.
const MOST_PLACES: usize = 8 * MOST_BIDS;
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
            #[cfg(feature = "straight")]
            Distance::Straight => self.lead_straight(&round),
            #[cfg(not(feature = "straight"))]
            Distance::Straight => Orders::new(),
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
        filled(to.iter().map(|robot| Order { robot, task: Task::Stop }))
    }

    /// Assigns by the bids of robots that have no goal. It is not inlined, since its lists are large and
    /// need no stack while the robot computes its own bids.
    #[inline(never)]
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
        self.assign(round, &mut bidders.places(), &bidders, &bidders.robots, &bidders.tiles)
    }

    fn assign<const RECORDS: usize>(
        &mut self,
        round: &Round<'_, ROBOTS, RECORDS>,
        places: &mut [Place],
        distances: &impl Distances,
        robots: &[u8],
        tiles: &[Tile],
    ) -> Orders<ROBOTS> {
        self.round = Some(round.now);
        for (robot, member) in round.members().filter(|(robot, _)| !robots.contains(robot)) {
            if let Some(goal) = self.goal_of(round.now, robot, member) {
                take(round.rule, places, goal.centre(round.frame));
            }
        }
        let assigned = assign::<ROBOTS>(round.rule, places, distances);
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
    tiles: Vec<Tile, MOST_PLACES>,
    gains: Vec<f32, MOST_PLACES>,
}

impl<'a, const ROBOTS: usize, const RECORDS: usize> Bidders<'a, ROBOTS, RECORDS> {
    fn gather(round: &Round<'a, ROBOTS, RECORDS>, asking: RobotSet) -> Self {
        let (mut tiles, mut gains) = (Vec::new(), Vec::new());
        for member in asking.iter().filter_map(|robot| round.team.member(robot)) {
            for bid in &member.bids {
                let at = tiles.binary_search(&bid.tile);
                // What has no room is bid for again.
                if let Err(at) = at
                    && insert(&mut tiles, at, bid.tile)
                {
                    insert(&mut gains, at, bid.gain.cells());
                }
            }
        }
        let robots = filled(asking.iter());
        Self { team: round.team, frame: round.frame, robots, tiles, gains }
    }

    fn places(&self) -> Vec<Place, MOST_PLACES> {
        let all = self.tiles.iter().zip(&self.gains);
        filled(all.map(|(tile, &gain)| Place { position: tile.centre(self.frame), gain }))
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
