//! How a robot flies to its goal, and when it gives the goal up.

use core::f32::consts::{FRAC_1_SQRT_2, PI, TAU};
use core::ops::ControlFlow;

use grid_map::{Cell, Visit};
use units::{Duration, Instant, Point2, Pose2};

use crate::atlas::{Ground, Sight, View, length};
use crate::explorer::{Config, Explorer, PERIOD, Search, State};
use crate::flight::{Gaze, Limits, Motion, Progress, fly, in_sight, look};
use crate::packet::Activity;
use crate::rule::{Facing, Overlap};
use crate::tile::{Mark, Tile};

/// A robot gives a goal up after the time of twice its way, and so long: `progress_timeout` of
/// `explore_lite`.
const PATIENCE: Duration = Duration::from_millis(30_000);
/// A robot that has come no farther than this stands, m: two cells, by which it sways while it hovers.
/// Our own number.
const STANDS: f32 = 0.2;
/// When its goal is seen, a robot goes on to a frontier that is at most so many tiles beside it. Our
/// own number.
const FOLLOWED: u16 = 5;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Goal {
    pub(crate) tile: Tile,
    view: View,
    /// The cell at the end of the way, where one was found.
    end: Option<Cell>,
    pub(crate) planned: Instant,
    /// When the robot gives the goal up.
    until: Option<Instant>,
    /// When it came to the end of the way.
    arrived: Option<Instant>,
    standing: Standing,
}

impl Goal {
    /// A goal whose way was last looked for at `planned`, and not found.
    pub(crate) const fn new(tile: Tile, planned: Instant) -> Self {
        let (view, standing) = (View::Beside, Standing::NEW);
        Self { tile, view, end: None, planned, until: None, arrived: None, standing }
    }
}

/// How long a robot has stood: where it was last farther than [`STANDS`] from where it was before, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Standing(Option<(Point2, Instant)>);

impl Standing {
    /// A robot that was nowhere yet.
    pub(crate) const NEW: Self = Self(None);

    /// Whether the robot has stood for twice the time in which it turns until it has looked everywhere: a
    /// quarter turn with rangers to four sides, half a turn with a camera.
    pub(crate) fn stands(&mut self, now: Instant, at: Point2, limits: Limits) -> bool {
        let (from, since) = *self.0.get_or_insert((at, now));
        if from.distance(at).0 > STANDS {
            self.0 = Some((at, now));
            return false;
        }
        let turns = match limits.gaze {
            Gaze::Around => PI,
            Gaze::Ahead => TAU,
        };
        now.since(since).as_secs_f32() * limits.turn > turns
    }
}

impl<G: Ground, const ROBOTS: usize, const RECORDS: usize> Explorer<G, ROBOTS, RECORDS> {
    /// Flies on to the goal.
    #[inline(never)]
    pub(crate) fn go_on(&mut self, now: Instant, pose: Pose2) -> Motion {
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
        let stands = goal.standing.stands(now, pose.at, self.config.limits);
        self.state = State::Going(goal);
        if stands {
            return self.leave(now, pose, goal.tile);
        }
        let is_due = goal.end.is_none() || now.since(goal.planned) >= PERIOD;
        if is_due || self.search == Search::Way {
            let Some(planned) = self.plan(now, pose, goal) else {
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
            Progress::Arrived => self.end(now, goal.tile),
        }
    }

    /// Ends a goal that the robot has looked at: what is not seen from here cannot be seen.
    fn end(&mut self, now: Instant, tile: Tile) -> Motion {
        let rule = self.config.rule;
        if rule.overlap == Overlap::Asked || rule.overlap == Overlap::Alone {
            self.mark(tile, Mark::Settled);
        } else if rule.reachability && self.is_open(tile) {
            self.barred.bar(now, tile, rule.blacklist);
        }
        self.wait(now)
    }

    /// Leaves a goal to which the robot comes no nearer. Where another robot is in the way it is put off,
    /// and where that one stays, the third time for good. Where none is, a robot that turns all the time has
    /// looked at a goal that is in sight and within its reach; one with a camera tries it again later.
    fn leave(&mut self, now: Instant, pose: Pose2, tile: Tile) -> Motion {
        let Config { limits, rule, .. } = self.config;
        if rule.reachability
            && let Some(other) = self.note_blockade(now, pose.at)
        {
            // One that stays where it is would be in the way for ever.
            let stays = self
                .team
                .member(other)
                .is_some_and(|other| matches!(other.activity, Activity::Idle | Activity::Stopped));
            self.set_aside(now, tile, stays);
            return self.wait(now);
        }
        let seen = in_sight(&self.ground, pose.at, tile);
        let is_near = seen.is_some_and(|at| at.distance(pose.at).0 <= limits.reach);
        match limits.gaze {
            Gaze::Around if is_near => return self.end(now, tile),
            Gaze::Around => return self.give_up(now, tile),
            Gaze::Ahead => self.set_aside(now, tile, false),
        }
        self.wait(now)
    }

    /// Flies on to where the last goal was seen from, until there is another, and looks around there; or flies
    /// back, to meet robots that are out of range, or to make way for one.
    pub(crate) fn fly_on(&mut self, now: Instant, pose: Pose2) -> Motion {
        let Config { limits, rule, .. } = self.config;
        let goes_back = match self.state {
            State::Idle { .. } => self.is_recalled || self.team.misses_a_robot(now),
            // It makes way for the robot that stands in its own.
            State::Waiting { .. } => self.avoided(now).is_some(),
            State::Going(_) | State::Stopped => false,
        };
        if goes_back {
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
        if own == Mark::Settled || self.ground.is_closed(tile) {
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

    /// Finds the way to the goal in the map as it is now; `None` while the search goes on. A robot that
    /// finds no way beside the goal looks for one from where it can look at it from afar.
    fn plan(&mut self, now: Instant, pose: Pose2, mut goal: Goal) -> Option<Goal> {
        if self.search != Search::Way {
            goal.view = View::Beside;
        }
        let (mut is_over, mut found) = self.search_way(now, pose, goal);
        while is_over
            && found.is_none()
            && let Some(view) = self.farther(now, goal.view)
        {
            goal.view = view;
            self.state = State::Going(goal);
            (is_over, found) = self.search_way(now, pose, goal);
        }
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

    /// Goes on with the search of a cell from which the goal is looked at, or begins it; says whether it is
    /// over, and what it has found.
    fn search_way(&mut self, now: Instant, pose: Pose2, goal: Goal) -> (bool, Option<Visit>) {
        if self.search != Search::Way {
            self.begin_search(now, pose.at);
        }
        let mut found = None;
        let is_over = self.ground.search(self.config.most_cells(), |map, visit| {
            if map.shows(visit.cell, goal.tile, goal.view) {
                found = Some(visit);
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        });
        self.search = if is_over { Search::None } else { Search::Way };
        (is_over, found)
    }

    /// The view after this one, for a robot that finds no way to a candidate with this one; `None` where there
    /// is none. While another robot is in its way it looks at nothing from afar: it would settle what it sees
    /// in part past that one, and could look at from beside later.
    pub(crate) fn farther(&self, now: Instant, view: View) -> Option<View> {
        let Config { rule, limits, .. } = self.config;
        let sees_far = rule.looks_from_afar && self.avoided(now).is_none();
        let reach = limits.reach * FRAC_1_SQRT_2 / self.ground.frame().resolution().0;
        // The corners of the square lie within the reach. The conversion clamps.
        (sees_far && view == View::Beside).then_some(View::Afar(reach as u16))
    }

    fn give_up(&mut self, now: Instant, tile: Tile) -> Motion {
        self.set_aside(now, tile, self.avoided(now).is_none());
        self.wait(now)
    }

    /// Does not try a goal for a while, where the rule knows of reachability; if it `counts`, the third time
    /// for good.
    fn set_aside(&mut self, now: Instant, tile: Tile, counts: bool) {
        let rule = self.config.rule;
        if rule.reachability && counts {
            self.barred.bar(now, tile, rule.blacklist);
        } else if rule.reachability {
            self.barred.put_off(now, tile, rule.blacklist);
        }
    }

    /// Waits for a goal, and asks for one at once.
    pub(crate) fn wait(&mut self, now: Instant) -> Motion {
        self.search = Search::None;
        self.state = State::Waiting { since: now };
        self.bid = None;
        self.targets_from = 0;
        self.coast = None;
        Motion::default()
    }
}
