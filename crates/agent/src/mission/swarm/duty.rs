//! The duties of a drone of a swarm, and the one function that moves it from one duty to the next.

use core::ops::ControlFlow::{Break, Continue};

use units::{Instant, Order};
use virtual_forces::Task;

use super::SwarmConfig;
use crate::LandReason;
use crate::mission::{Next, Round};

/// What a drone of a swarm does in the air.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SwarmDuty {
    /// The drone does not know its position, and hovers until it does or has waited for too long.
    Hovering {
        /// When it began to hover.
        since: Instant,
    },
    /// The drone surveys its rows of the first area.
    Surveying,
    /// The drone goes to its place in the formation before the passage, or waits there.
    Gathering,
    /// The drone goes through the passage, and makes room for the others behind it.
    Crossing,
}

impl SwarmDuty {
    /// The duty of a drone that has come to its height.
    pub(crate) const fn first(now: Instant) -> Self {
        Self::Hovering { since: now }
    }

    /// The duty's name.
    pub(crate) const fn name(&self) -> &'static str {
        match self {
            Self::Hovering { .. } => "hovering",
            Self::Surveying => "surveying",
            Self::Gathering => "gathering",
            Self::Crossing => "crossing",
        }
    }

    /// The duty's number on the air.
    pub(crate) const fn code(&self) -> u8 {
        match self {
            Self::Hovering { .. } => 15,
            Self::Surveying => 16,
            Self::Gathering => 17,
            Self::Crossing => 18,
        }
    }

    /// The duty after this round, or the landing that ends it. `task` is what the virtual forces have
    /// the drone do; there is none while it does not know its position.
    pub(crate) fn next(
        self,
        config: &SwarmConfig,
        round: &Round,
        task: Option<Task>,
    ) -> Next<Self> {
        if matches!(round.order(), Some(Order::Land | Order::Return | Order::Perch)) {
            return Break(LandReason::Ordered);
        }
        match (task, self) {
            (Some(Task::Survey { .. }), _) => Continue(Self::Surveying),
            (Some(Task::Gather { .. }), _) => Continue(Self::Gathering),
            (Some(Task::Cross { .. }), _) => Continue(Self::Crossing),
            (Some(Task::Done), _) => Break(LandReason::Done),
            (None, Self::Hovering { since }) if round.now.since(since) > config.patience => {
                Break(LandReason::PositionLost)
            }
            (None, Self::Hovering { since }) => Continue(Self::Hovering { since }),
            (None, Self::Surveying | Self::Gathering | Self::Crossing) => {
                Continue(Self::Hovering { since: round.now })
            }
        }
    }
}
