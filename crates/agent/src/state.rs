//! The states of a drone, and the one function that moves it from one state to the next.

use chain::search::Search;
use flight::Cause;
use units::{Instant, Metres, Order, Role};

use crate::mission::Call;
use crate::mission::chain::{Duty, Links, on_duty};
use crate::{AgentConfig, Fitness, FlightConfig};

/// What a drone is doing. The base stays [`Idle`](Self::Idle): its part is to speak and listen.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum State {
    /// The drone is on the ground and the mission does not call for it.
    Idle,
    /// The drone is on the ground and is the next to fly.
    Armed {
        /// When it became the next.
        since: Instant,
    },
    /// The drone climbs to its height and settles there.
    TakingOff {
        /// When it began to climb.
        since: Instant,
    },
    /// The head flies as the pilot says.
    Leading {
        /// Until then the head bears a weak or missing link.
        patient_until: Instant,
    },
    /// A relay makes its two links equal.
    Relaying {
        /// Until then the relay bears a weak or missing link.
        patient_until: Instant,
    },
    /// A relay that no longer hears a drone in front flies on to find one.
    Reconnecting {
        /// When the relay lost its front neighbour.
        since: Instant,
        /// The odometer at that moment.
        from: Metres,
    },
    /// A relay whose links are too weak looks for a better place.
    Searching {
        /// The search, with the part of it that is done.
        search: Search,
    },
    /// A relay that is no longer needed flies home.
    Retiring,
    /// The drone flies back towards a neighbour that it hears too weakly, or not at all.
    BackingUp {
        /// When it began to fly back.
        since: Instant,
        /// The odometer at that moment.
        from: Metres,
    },
    /// The drone comes down where it is.
    Landing {
        /// When it began to come down.
        since: Instant,
        /// The reason for it.
        why: LandReason,
    },
    /// The drone is on the ground and out of the mission, until it is told to wait for the next one.
    Landed {
        /// The reason for its landing.
        why: LandReason,
    },
    /// The motors are off for good.
    Stopped,
}

/// Why a drone came down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum LandReason {
    /// The operator ordered it.
    Ordered,
    /// The drone was called home and is where it took off.
    Home,
    /// The chain no longer needs the relay, which waits for its next turn.
    Retired,
    /// The drone never reached its height.
    TakeOffFailed,
    /// The base's side stayed silent over the whole of a retreat.
    LinkLost,
    /// The flight code brought the drone down.
    Unfit(Cause),
    /// The drone's last run ended by a fault or in the air, which the operator does not know.
    Restarted,
}

/// Everything that a transition depends on.
pub(crate) struct Situation {
    pub(crate) now: Instant,
    pub(crate) task: Option<Order>,
    /// Whether the drone would take off.
    pub(crate) fit: bool,
    pub(crate) fitness: Fitness,
    pub(crate) links: Links,
    pub(crate) height: Option<Metres>,
    pub(crate) odometer: Metres,
    pub(crate) call: Call,
    /// Whether a relay should look for a better place now.
    pub(crate) searches: bool,
    /// Whether the chain no longer needs a relay.
    pub(crate) retires: bool,
}

impl State {
    /// Whether the motors turn.
    #[must_use]
    pub const fn is_airborne(&self) -> bool {
        match self {
            Self::TakingOff { .. }
            | Self::Leading { .. }
            | Self::Relaying { .. }
            | Self::Reconnecting { .. }
            | Self::Searching { .. }
            | Self::Retiring
            | Self::BackingUp { .. }
            | Self::Landing { .. } => true,
            Self::Idle | Self::Armed { .. } | Self::Landed { .. } | Self::Stopped => false,
        }
    }

    /// The state's name, without its data.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Armed { .. } => "armed",
            Self::TakingOff { .. } => "taking-off",
            Self::Leading { .. } => "leading",
            Self::Relaying { .. } => "relaying",
            Self::Reconnecting { .. } => "reconnecting",
            Self::Searching { .. } => "searching",
            Self::Retiring => "retiring",
            Self::BackingUp { .. } => "backing-up",
            Self::Landing { .. } => "landing",
            Self::Landed { .. } => "landed",
            Self::Stopped => "stopped",
        }
    }

    /// The state's number on the air, without its data.
    #[must_use]
    pub const fn code(&self) -> u8 {
        match self {
            Self::Idle => 0,
            Self::Armed { .. } => 1,
            Self::TakingOff { .. } => 2,
            Self::Leading { .. } => 3,
            Self::Relaying { .. } => 4,
            Self::Reconnecting { .. } => 5,
            Self::BackingUp { .. } => 6,
            Self::Landing { .. } => 7,
            Self::Landed { .. } => 8,
            Self::Stopped => 9,
            Self::Searching { .. } => 10,
            Self::Retiring => 11,
        }
    }

    /// The transition function. An order to stop comes first; then each state has its own arm.
    pub(crate) fn next(self, config: &AgentConfig, role: Role, at: &Situation) -> Self {
        if at.task == Some(Order::Stop) || at.fitness == Fitness::Stopped || self == Self::Stopped {
            return Self::Stopped;
        }
        if role == Role::Base {
            return Self::Idle;
        }
        if let Some(down) = self.brought_down(at) {
            return down;
        }
        if let Some(duty) = Duty::of(self) {
            return duty.next(config, role, at);
        }
        match self {
            Self::Idle => idle(at),
            Self::Armed { since } => armed(since, at),
            Self::TakingOff { since } => taking_off(since, config, role, at),
            Self::Landing { since, why } => landing(since, why, config, at),
            Self::Landed { why: LandReason::Retired } => Self::Idle,
            Self::Landed { why } => match at.task {
                Some(Order::Wait) => Self::Idle,
                _ => Self::Landed { why },
            },
            // A duty has its own transitions.
            same @ (Self::Stopped
            | Self::Leading { .. }
            | Self::Relaying { .. }
            | Self::Reconnecting { .. }
            | Self::Searching { .. }
            | Self::Retiring
            | Self::BackingUp { .. }) => same,
        }
    }
}

impl State {
    /// The state that the flight code has forced on the drone, if it has.
    fn brought_down(self, at: &Situation) -> Option<Self> {
        match at.fitness {
            Fitness::Landed(why) if self.is_airborne() => {
                Some(Self::Landed { why: LandReason::Unfit(why) })
            }
            Fitness::Landing(why)
                if self.is_airborne() && !matches!(self, Self::Landing { .. }) =>
            {
                Some(Self::Landing { since: at.now, why: LandReason::Unfit(why) })
            }
            _ => None,
        }
    }
}

fn explores(at: &Situation) -> bool {
    matches!(at.task, Some(Order::Explore(_)))
}

fn idle(at: &Situation) -> State {
    if explores(at) && at.call.arms && at.fit {
        State::Armed { since: at.now }
    } else {
        State::Idle
    }
}

fn armed(since: Instant, at: &Situation) -> State {
    if !explores(at) || !at.fit || !at.call.stays_armed {
        State::Idle
    } else if at.call.takes_off {
        State::TakingOff { since: at.now }
    } else {
        State::Armed { since }
    }
}

fn taking_off(since: Instant, config: &AgentConfig, role: Role, at: &Situation) -> State {
    let flight = &config.flight;
    let elapsed = at.now.since(since);
    let climb_time = flight.height.0 / flight.climb.0;
    let settled = elapsed.as_secs_f32() >= climb_time + flight.settle.as_secs_f32();
    if at.task == Some(Order::Land) {
        State::Landing { since: at.now, why: LandReason::Ordered }
    } else if settled && flight.is_up(at.height) {
        on_duty(role, at.now)
    } else if elapsed > flight.patience {
        State::Landing { since: at.now, why: LandReason::TakeOffFailed }
    } else {
        State::TakingOff { since }
    }
}

fn landing(since: Instant, why: LandReason, config: &AgentConfig, at: &Situation) -> State {
    let down = at.height.is_some_and(|h| h <= FlightConfig::GROUND);
    if down || at.now.since(since) > config.flight.patience {
        State::Landed { why }
    } else {
        State::Landing { since, why }
    }
}
