//! Tells a robot how long the way back to where it began is on its own map, so that it can turn back while
//! its battery suffices for that way.

use units::{Duration, Instant, Metres, Point2};

use crate::atlas::{Ground, length};
use crate::explorer::{Explorer, PERIOD, Search, State};

/// The longest time for a search of the way back; after it the robot takes the way that it flew for the
/// way back. A search of the largest map is over within a second. Our own number.
const LONGEST_LOOK: Duration = Duration::from_millis(5_000);

/// What a robot knows of its way back.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Homeward {
    /// Where the robot was last.
    at: Option<Point2>,
    /// The way back is no longer than this: the one that was last found, and what was flown since.
    way: Metres,
    /// Since when the robot has looked for a shorter one.
    since: Option<Instant>,
}

impl Homeward {
    pub(crate) const fn new() -> Self {
        Self { at: None, way: Metres(0.0), since: None }
    }
}

impl<G: Ground, const ROBOTS: usize, const RECORDS: usize> Explorer<G, ROBOTS, RECORDS> {
    /// Whether the way from `here` back to where the robot began is no longer than `most`, by what it has
    /// flown or by its map, in which it looks for a shorter way where it must. While it does that, over
    /// several steps, it hovers, and the answer is yes. No way is within a negative length. It is to be
    /// called before each step.
    pub fn is_within(&mut self, now: Instant, here: Point2, most: Metres) -> bool {
        let flown = self.homeward.at.replace(here).map_or(0.0, |last| last.distance(here).0);
        self.homeward.way.0 += flown;
        if self.homeward.way <= most {
            if self.search == Search::Homeward {
                self.end_look_homeward(now);
            }
            return true;
        }
        let since = *self.homeward.since.get_or_insert(now);
        if most < Metres(0.0) || now.since(since) > LONGEST_LOOK {
            // A search that is not gone on with would keep the robot where it hovers.
            if self.search == Search::Homeward {
                self.end_look_homeward(now);
            }
            return false;
        }
        match self.search {
            Search::None => {
                self.begin_search(now, here);
                self.search = Search::Homeward;
            }
            Search::Homeward => {}
            // Another search is over in a step or two.
            Search::Bids | Search::Way | Search::Meeting => return true,
        }
        if !self.look_homeward() {
            return true;
        }
        self.end_look_homeward(now);
        self.homeward.way <= most
    }

    /// Goes on with the search of the way back; says whether it is over.
    fn look_homeward(&mut self) -> bool {
        let frame = *self.ground.frame();
        let Some(end) = self.meeting.start.and_then(|start| frame.cell_at(start)) else {
            return true;
        };
        let (is_over, found) = self.search_to(end);
        if let Some(cost) = found {
            self.homeward.way = Metres(length(cost, &frame).0.min(self.homeward.way.0));
        }
        is_over
    }

    /// Ends the search of the way back. The ground has forgotten the way that the robot flew.
    fn end_look_homeward(&mut self, now: Instant) {
        self.search = Search::None;
        self.homeward.since = None;
        self.coast = None;
        self.meeting.look_again();
        if let State::Going(goal) = &mut self.state {
            goal.planned = now - PERIOD;
        }
    }
}
