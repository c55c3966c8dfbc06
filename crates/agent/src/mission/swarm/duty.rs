//! The duties of a drone of a swarm, and the one function that moves it from one duty to the next.

use core::ops::ControlFlow::{Break, Continue};

use units::{Duration, Instant, Order};

use crate::LandReason;
use crate::mission::{Next, Round};

/// How long a drone hovers without its position before it lands.
const PATIENCE: Duration = Duration::from_secs(10);

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
        }
    }

    /// The duty's number on the air.
    pub(crate) const fn code(&self) -> u8 {
        match self {
            Self::Hovering { .. } => 15,
        }
    }

    /// The duty after this round, or the landing that ends it.
    pub(crate) fn next(self, round: &Round) -> Next<Self> {
        match (self, round.order()) {
            (_, Some(Order::Land | Order::Return | Order::Perch)) => Break(LandReason::Ordered),
            (Self::Hovering { since }, _) if round.now.since(since) > PATIENCE => {
                Break(LandReason::PositionLost)
            }
            (duty, _) => Continue(duty),
        }
    }
}
