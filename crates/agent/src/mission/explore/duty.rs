//! The duties of a drone that explores, and the one function that moves it from one duty to the next.

use core::ops::ControlFlow::{Break, Continue};

use frontier::Activity;
use units::{Instant, Order, Point2};

use super::ExploreConfig;
use crate::LandReason;
use crate::mission::{Next, Round};

/// What a drone that explores does in the air.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ExploreDuty {
    /// The drone does not know its position, and hovers until it does or has waited for too long.
    Lost {
        /// When it began to hover.
        since: Instant,
    },
    /// The drone waits for a goal, and looks around meanwhile.
    Waiting,
    /// The drone is on its way to a frontier of the map.
    Exploring {
        /// The middle of the tile to which it flies.
        goal: Point2,
    },
    /// The drone flies back to where it took off, and lands there.
    Returning {
        /// Whether nothing is left to explore. If not, the drone was ordered to fly back, its battery has
        /// little more than the way takes, or its place has become too uncertain.
        has_seen_all: bool,
    },
}

/// What the exploration has a drone do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Doing {
    pub(super) activity: Activity,
    /// The goal of a drone that is on its way.
    pub(super) goal: Option<Point2>,
    /// Whether the drone is on its way home.
    pub(super) is_recalled: bool,
    /// Whether nothing is left to explore.
    pub(super) has_seen_all: bool,
}

impl Doing {
    /// What a drone does that has not begun.
    pub(super) const NONE: Self =
        Self { activity: Activity::Waiting, goal: None, is_recalled: false, has_seen_all: false };
}

impl ExploreDuty {
    /// The duty of a drone that has come to its height.
    pub(crate) const fn first() -> Self {
        Self::Waiting
    }

    /// The duty's name.
    pub(crate) const fn name(&self) -> &'static str {
        match self {
            Self::Lost { .. } => "lost",
            Self::Waiting => "waiting",
            Self::Exploring { .. } => "exploring",
            Self::Returning { .. } => "returning",
        }
    }

    /// The duty's number on the air.
    pub(crate) const fn code(&self) -> u8 {
        match self {
            Self::Lost { .. } => 19,
            Self::Waiting => 20,
            Self::Exploring { .. } => 21,
            Self::Returning { .. } => 23,
        }
    }

    /// The duty after this round, or the landing that ends it. `doing` is `None` while the drone does
    /// not know its position.
    pub(super) fn next(
        self,
        config: &ExploreConfig,
        round: &Round,
        doing: Option<Doing>,
    ) -> Next<Self> {
        if matches!(round.order(), Some(Order::Land | Order::Perch)) {
            return Break(LandReason::Ordered);
        }
        let returns = round.order() == Some(Order::Return);
        match (doing, self) {
            (Some(Doing { activity: Activity::Stopped, .. }), _) if returns => {
                Break(LandReason::Ordered)
            }
            (Some(Doing { activity: Activity::Stopped, has_seen_all: true, .. }), _) => {
                Break(LandReason::Done)
            }
            (Some(Doing { activity: Activity::Stopped, .. }), _) => Break(LandReason::Home),
            (Some(Doing { is_recalled: true, has_seen_all, .. }), _) => {
                Continue(Self::Returning { has_seen_all })
            }
            (Some(Doing { goal: Some(goal), .. }), _) => Continue(Self::Exploring { goal }),
            (Some(Doing { goal: None, .. }), _) => Continue(Self::Waiting),
            (None, Self::Lost { since }) if round.now.since(since) > config.patience => {
                Break(LandReason::PositionLost)
            }
            (None, Self::Lost { since }) => Continue(Self::Lost { since }),
            (None, Self::Waiting | Self::Exploring { .. } | Self::Returning { .. }) => {
                Continue(Self::Lost { since: round.now })
            }
        }
    }
}
