//! Leads by straight distances: all candidates are shared out at once, as the thesis has it.

use heapless::Vec;
use units::{Duration, Metres, Point2};

use super::{AGAIN, Leader, Orders, Round, Stopping};
use crate::assignment::{Distances, Place};
use crate::cluster::RobotSet;
use crate::overlap::{Shape, is_overlapped};
use crate::packet::{Activity, Order, Task};
use crate::rule::{Overlap, Pace};
use crate::team::Member;
use crate::tile::Tile;

/// A robot for which there was no candidate is thought of again after so long.
const RETRY: Duration = Duration::from_millis(5_000);

impl<const ROBOTS: usize> Leader<ROBOTS> {
    /// Assigns by straight distances among all candidates.
    pub(super) fn lead_straight<const RECORDS: usize>(
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
        let mut places: Vec<Place, RECORDS> =
            askers.candidates.iter().map(|open| open.place).collect();
        let tiles: Vec<Tile, RECORDS> = askers.candidates.iter().map(|open| open.tile).collect();
        self.assign(round, &mut places, &askers, &askers.robots, &tiles)
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
