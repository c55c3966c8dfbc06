//! How a robot flies back to where it began: to wait for robots that are out of range when it has nothing
//! left to explore, or to stop there when it is recalled.

use core::ops::ControlFlow;

use grid_map::Cell;
use units::{Instant, Point2, Pose2};

use crate::atlas::Ground;
use crate::explorer::{Explorer, Search, State, is_due};
use crate::flight::{Motion, Progress, fly, fly_to};
use crate::going::Standing;
use crate::team::TRUST;
use crate::tile::Tile;

/// A recalled robot that comes no farther looks for its way back anew so many times. Our own number: it
/// stands for 6 s each time at 0.5 rad/s, and a drone keeps charge for 20 s and half of its way.
const MOST_TRIES: u8 = 3;

/// A recalled robot stops this near to where it began, m: two of those that stand 0.35 m apart then do not stand in each
/// other's place. Our own number.
const AT_HOME: f32 = 0.04;

/// A robot is at the row in which robots stood within this of where it began, m: six of them, 0.35 m apart, are at it
/// to the last.
const ROW: f32 = 1.8;

/// Where a robot waits, and since when.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    /// Where the robot began.
    pub(crate) start: Option<Point2>,
    /// When the robot last looked for the way there.
    planned: Option<Instant>,
    /// Since when the robot waits there, or where its way ended.
    pub(crate) since: Option<Instant>,
    standing: Standing,
    /// How often a recalled robot has come no farther and has looked for its way anew.
    tries: u8,
}

impl Meeting {
    pub(crate) const fn new() -> Self {
        Self { start: None, planned: None, since: None, standing: Standing::NEW, tries: 0 }
    }

    /// Notes where the robot comes back to, before it has flown.
    pub(crate) fn begin(&mut self, pose: Pose2, ahead: f32) {
        let (sin, cos) = pose.yaw.sin_cos();
        let at = || Point2::new(pose.at.x + ahead * cos, pose.at.y + ahead * sin);
        self.start.get_or_insert_with(at);
    }

    /// Whether a place lies where robots stood in a row before they took off.
    pub(crate) fn is_near(&self, at: Point2) -> bool {
        self.start.is_some_and(|start| start.distance(at).0 < ROW)
    }

    /// Looks for the way there anew.
    pub(crate) const fn look_again(&mut self) {
        self.planned = None;
    }

    /// Forgets that the robot waited there.
    pub(crate) const fn wait_again(&mut self) {
        (self.since, self.standing) = (None, Standing::NEW);
    }
}

impl<G: Ground, const ROBOTS: usize, const RECORDS: usize> Explorer<G, ROBOTS, RECORDS> {
    /// Flies to where the robot began, or as near as it comes. There it stops, if it is recalled, or waits
    /// for robots that are out of range: what they have seen need not be explored anew. A robot that makes
    /// way for another one flies so, too, until it has a goal.
    pub(crate) fn meet(&mut self, now: Instant, pose: Pose2) -> Motion {
        if self.meeting.since.is_some() {
            return Motion::default();
        }
        let end = self.meeting.start.and_then(|start| self.ground.frame().cell_at(start));
        let Some(way) = end.and_then(|end| Some((end, Tile::of(end)?))) else {
            return self.end_way_back(now);
        };
        if !self.find_way_back(now, pose.at, way.0) {
            return Motion::default();
        }
        let limits = self.config.limits;
        let stands = self.meeting.standing.stands(now, pose.at, limits);
        match fly(&self.ground, pose, way, limits, self.config.rule.facing) {
            Progress::Arrived => self.come_down(now, pose, stands),
            Progress::Flying(_) | Progress::Blocked if stands => self.try_again(now, pose.at),
            Progress::Flying(motion) => motion,
            // What lies on the way was seen just now: there may be another one.
            Progress::Blocked => {
                self.meeting.look_again();
                Motion::default()
            }
        }
    }

    /// Flies the last stretch to the very point, where a robot is recalled to stop there.
    fn come_down(&mut self, now: Instant, pose: Pose2, stands: bool) -> Motion {
        match self.meeting.start {
            Some(start) if self.is_recalled && !stands && pose.at.distance(start).0 > AT_HOME => {
                fly_to(pose, start, self.config.limits)
            }
            _ => self.end_way_back(now),
        }
    }

    /// Looks for the way back anew, for a robot that is recalled and has come no farther, about a robot that
    /// is in its way; after some tries, or where the robot only waits for others, its way ends here.
    fn try_again(&mut self, now: Instant, at: Point2) -> Motion {
        if !self.is_recalled || self.meeting.tries >= MOST_TRIES {
            return self.end_way_back(now);
        }
        self.meeting.tries += 1;
        // Where there is no other way, the search finds none, and the robot waits here.
        let _ = self.note_blockade(now, at);
        self.meeting.wait_again();
        self.meeting.look_again();
        Motion::default()
    }

    fn end_way_back(&mut self, now: Instant) -> Motion {
        self.meeting.since = Some(now);
        if self.is_recalled {
            self.state = State::Stopped;
        }
        Motion::default()
    }

    /// Looks for the way back once a period, over several steps where it must; says whether no search
    /// is under way, which would have forgotten the way.
    fn find_way_back(&mut self, now: Instant, from: Point2, end: Cell) -> bool {
        match self.search {
            Search::None if is_due(self.meeting.planned, now) => {
                self.meeting.planned = Some(now);
                self.begin_search(now, from);
            }
            Search::None => return true,
            Search::Meeting => {}
            Search::Bids | Search::Way | Search::Homeward => return false,
        }
        let (is_over, _) = self.search_to(end);
        self.search = if is_over { Search::None } else { Search::Meeting };
        is_over
    }

    /// Goes on with the search of the way to a cell; says whether it is over, and the cost of the way where it
    /// was found. It is not inlined, since a search takes much of the program.
    #[inline(never)]
    pub(crate) fn search_to(&mut self, end: Cell) -> (bool, Option<u32>) {
        let mut found = None;
        let is_over = self.ground.search(self.config.most_cells(), |_, visit| {
            if visit.cell == end {
                found = Some(visit.cost);
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        });
        (is_over, found)
    }

    /// Forgets robots that were silent for long, where this one has waited for them in vain; an access
    /// point does nothing but wait.
    pub(crate) fn forget_silent(&mut self, now: Instant) {
        let has_waited = self.meeting.since.is_some_and(|since| now.since(since) >= TRUST);
        if has_waited || self.config.stands {
            self.team.forget_silent(now);
        }
    }
}
