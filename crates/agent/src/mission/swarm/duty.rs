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
    /// The drone surveys its rows of an area, and those that lost drones have left to it.
    Surveying,
    /// The drone goes to its place in the formation before the passage, or waits there.
    Gathering,
    /// The drone goes through the passage, and makes room for the others behind it.
    Crossing,
    /// The drone was recalled, and comes back, through the passage where it is behind it, to where it took
    /// off.
    Returning,
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
            Self::Returning => "going-home",
        }
    }

    /// The duty's number on the air.
    pub(crate) const fn code(&self) -> u8 {
        match self {
            Self::Hovering { .. } => 15,
            Self::Surveying => 16,
            Self::Gathering => 17,
            Self::Crossing => 18,
            Self::Returning => 25,
        }
    }

    /// The duty after this round, or the landing that ends it. `task` is what the virtual forces have
    /// the drone do, which may have been recalled; there is none while it does not know its position.
    pub(crate) fn next(
        self,
        config: &SwarmConfig,
        round: &Round,
        task: Option<Task>,
        is_recalled: bool,
    ) -> Next<Self> {
        if matches!(round.order(), Some(Order::Land | Order::Perch)) {
            return Break(LandReason::Ordered);
        }
        match (task, self) {
            (Some(Task::Done), _) if is_recalled => Break(LandReason::Home),
            (Some(Task::Done), _) => Break(LandReason::Done),
            (Some(_), _) if is_recalled => Continue(Self::Returning),
            (Some(Task::Survey { .. }), _) => Continue(Self::Surveying),
            (Some(Task::Gather { .. }), _) => Continue(Self::Gathering),
            (Some(Task::Cross { .. }), _) => Continue(Self::Crossing),
            (Some(Task::Home), _) => Continue(Self::Returning),
            (None, Self::Hovering { since }) if round.now.since(since) > config.patience => {
                Break(LandReason::PositionLost)
            }
            (None, Self::Hovering { since }) => Continue(Self::Hovering { since }),
            (None, Self::Surveying | Self::Gathering | Self::Crossing | Self::Returning) => {
                Continue(Self::Hovering { since: round.now })
            }
        }
    }
}
