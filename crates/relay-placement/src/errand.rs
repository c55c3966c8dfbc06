//! The phases in which a robot puts down a relay: it goes to the goal, gathers readings around it in a
//! motion pattern, and drops the relay at the place that is chosen from them (sections 3.1 to 3.3 of
//! the paper).
//!
//! An [`Errand`] moves nothing itself: it is told where the robot is and says what to do next.

use grid_map::Cell;
use units::{Duration, Instant, Metres};

use crate::ground::Ground;
use crate::pattern::{Pattern, Tour};

/// The bounds of an errand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrandConfig {
    /// The farthest from the goal that readings are gathered: `d_p`, 10 m in the paper.
    pub within: Metres,
    /// The longest time for which they are gathered. The paper has "a predefined time threshold"; two
    /// minutes are a choice.
    pub gathering: Duration,
}

impl ErrandConfig {
    /// The paper's distance, and our time.
    pub const DEFAULT: Self = Self { within: Metres(10.0), gathering: Duration::from_secs(120) };
}

/// What the robot is to do next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// It drives to this cell.
    Drive(Cell),
    /// It chooses a place, and says so by [`Errand::choose`].
    Choose,
    /// It puts the relay down where it is.
    Drop,
}

/// The phase of an errand.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    /// The robot goes to the goal.
    Go,
    /// The robot gathers readings since this moment, on its way to this cell.
    Gather { since: Instant, to: Cell },
    /// The gathering is over, and no place is chosen yet.
    Choose,
    /// The robot goes to the place at which it drops the relay.
    Drop { to: Cell },
}

/// The way of one relay from the goal to its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errand {
    config: ErrandConfig,
    goal: Cell,
    tour: Tour,
    stage: Stage,
}

impl Errand {
    /// An errand to a goal that a robot can reach; `seed` is that of a random walk.
    #[must_use]
    pub fn new<const CELLS: usize>(
        config: ErrandConfig,
        ground: &Ground<CELLS>,
        goal: Cell,
        pattern: Pattern,
        seed: u64,
    ) -> Self {
        let tour = Tour::new(pattern, ground.frame().centre(goal), config.within, seed);
        Self { config, goal, tour, stage: Stage::Go }
    }

    /// What the robot, which is in the cell `at`, does next.
    pub fn step<const CELLS: usize>(
        &mut self,
        now: Instant,
        ground: &Ground<CELLS>,
        at: Cell,
    ) -> Act {
        self.stage = match self.stage {
            Stage::Go if at == self.goal => self.gather(now, now, ground, at),
            Stage::Gather { since, .. } if now.since(since) >= self.config.gathering => {
                Stage::Choose
            }
            Stage::Gather { since, to } if at == to => self.gather(now, since, ground, at),
            stage => stage,
        };
        match self.stage {
            Stage::Go => Act::Drive(self.goal),
            Stage::Gather { to, .. } => Act::Drive(to),
            Stage::Choose => Act::Choose,
            Stage::Drop { to } if at == to => Act::Drop,
            Stage::Drop { to } => Act::Drive(to),
        }
    }

    /// Sends the robot to the place that was chosen.
    pub const fn choose(&mut self, to: Cell) {
        self.stage = Stage::Drop { to };
    }

    /// Whether the robot gathers readings.
    #[must_use]
    pub const fn is_gathering(&self) -> bool {
        matches!(self.stage, Stage::Gather { .. })
    }

    fn gather<const CELLS: usize>(
        &mut self,
        now: Instant,
        since: Instant,
        ground: &Ground<CELLS>,
        at: Cell,
    ) -> Stage {
        let is_over = now.since(since) >= self.config.gathering;
        match self.tour.next(ground, at).filter(|_| !is_over) {
            Some(to) => Stage::Gather { since, to },
            None => Stage::Choose,
        }
    }
}
