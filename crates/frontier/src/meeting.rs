//! How a robot that has nothing left to explore waits for robots that are out of range.

use core::ops::ControlFlow;

use grid_map::Cell;
use units::{Instant, Point2, Pose2};

use crate::atlas::Ground;
use crate::explorer::{Explorer, Search, is_due};
use crate::flight::{Motion, Progress, fly};
use crate::team::TRUST;
use crate::tile::Tile;

/// Where a robot waits, and since when.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    /// Where the robot began.
    pub(crate) start: Option<Point2>,
    /// When the robot last looked for the way there.
    planned: Option<Instant>,
    /// Since when the robot waits there, or where its way ended.
    pub(crate) since: Option<Instant>,
}

impl Meeting {
    pub(crate) const fn new() -> Self {
        Self { start: None, planned: None, since: None }
    }
}

impl<G: Ground, const ROBOTS: usize, const RECORDS: usize> Explorer<G, ROBOTS, RECORDS> {
    /// Flies to where the robot began, and waits there for robots that are out of range: what they have
    /// seen need not be explored anew.
    pub(crate) fn meet(&mut self, now: Instant, pose: Pose2) -> Motion {
        let end = self.meeting.start.and_then(|start| self.ground.frame().cell_at(start));
        let way = end.and_then(|end| Some((end, Tile::of(end)?)));
        let Some(way) = way.filter(|_| self.meeting.since.is_none()) else {
            return Motion::default();
        };
        if !self.find_way_back(now, pose.at, way.0) {
            return Motion::default();
        }
        match fly(&self.ground, pose, way, self.config.limits, self.config.rule.facing) {
            Progress::Flying(motion) => motion,
            Progress::Arrived | Progress::Blocked => {
                self.meeting.since = Some(now);
                Motion::default()
            }
        }
    }

    /// Looks for the way back once a period, over several steps where it must; says whether no search
    /// is under way, which would have forgotten the way.
    fn find_way_back(&mut self, now: Instant, from: Point2, end: Cell) -> bool {
        match self.search {
            Search::None if is_due(self.meeting.planned, now) => {
                self.meeting.planned = Some(now);
                self.ground.begin_search(from);
            }
            Search::None => return true,
            Search::Meeting => {}
            Search::Bids | Search::Way => return false,
        }
        let is_over = self.ground.search(self.config.most_cells(), |_, visit| {
            if visit.cell == end { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        self.search = if is_over { Search::None } else { Search::Meeting };
        is_over
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
