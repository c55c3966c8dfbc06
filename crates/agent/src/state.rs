//! The states of a drone, and the one function that moves it from one state to the next.

use core::ops::ControlFlow::{Break, Continue};

use flight::Cause;
use units::{Instant, Metres, Order, Role};

use crate::mission::{Call, Duty, Mission, Round};
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
    /// The drone is in the air, at its height, and does its part in the mission.
    OnMission(Duty),
    /// The drone comes down where it is.
    Landing {
        /// When it began to come down.
        since: Instant,
        /// The reason for it.
        why: LandReason,
    },
    /// The drone is on the ground at its place in the mission, and goes on relaying.
    Perched,
    /// The drone climbs from its perch back to its height.
    Rising {
        /// When it began to climb.
        since: Instant,
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
    /// The operator ordered it to relay from the ground.
    Perched,
    /// The drone was called home and is where it took off.
    Home,
    /// The mission no longer needs the drone, which waits for its next turn.
    Retired,
    /// The drone never reached its height.
    TakeOffFailed,
    /// The base's side stayed silent over the whole of a retreat.
    LinkLost,
    /// The mission is over, and the drone's part in it done.
    Done,
    /// The drone did not know its position for too long, which its mission needs.
    PositionLost,
    /// The flight code brought the drone down.
    Unfit(Cause),
    /// The drone's last run ended by a fault or in the air, which the operator does not know.
    Restarted,
}

/// What the shell's transitions depend on besides the round.
pub(crate) struct Situation {
    /// Whether the drone would take off: on its perch, whether its battery would carry it home.
    pub(crate) fit: bool,
    pub(crate) fitness: Fitness,
    pub(crate) height: Option<Metres>,
}

impl State {
    /// Whether the motors turn.
    #[must_use]
    pub const fn is_airborne(&self) -> bool {
        match self {
            Self::TakingOff { .. }
            | Self::OnMission(_)
            | Self::Rising { .. }
            | Self::Landing { .. } => true,
            Self::Idle
            | Self::Armed { .. }
            | Self::Perched
            | Self::Landed { .. }
            | Self::Stopped => false,
        }
    }

    /// The state's name, without its data.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Armed { .. } => "armed",
            Self::TakingOff { .. } => "taking-off",
            Self::OnMission(duty) => duty.name(),
            Self::Perched => "perched",
            Self::Rising { .. } => "rising",
            Self::Landing { .. } => "landing",
            Self::Landed { .. } => "landed",
            Self::Stopped => "stopped",
        }
    }

    /// The state's number on the air, without its data. The numbers between are the duties'.
    #[must_use]
    pub const fn code(&self) -> u8 {
        match self {
            Self::Idle => 0,
            Self::Armed { .. } => 1,
            Self::TakingOff { .. } => 2,
            Self::OnMission(duty) => duty.code(),
            Self::Landing { .. } => 7,
            Self::Landed { .. } => 8,
            Self::Stopped => 9,
            Self::Perched => 13,
            Self::Rising { .. } => 14,
        }
    }

    /// The transition function. An order to stop comes first; then each state has its own arm.
    // A part of its own in the program, so that no table of the step lies far from its branch.
    #[inline(never)]
    pub(crate) fn next(
        self,
        config: &AgentConfig,
        mission: &mut Mission,
        round: &Round,
        at: &Situation,
    ) -> Self {
        let order = round.order();
        if order == Some(Order::Stop) || at.fitness == Fitness::Stopped {
            return Self::Stopped;
        }
        if round.role == Role::Base && self != Self::Stopped {
            return Self::Idle;
        }
        if let Some(down) = self.brought_down(round.now, at) {
            return down;
        }
        match self {
            Self::Idle => idle(&mission.call(config, round, None), round, at),
            Self::Armed { since } => {
                armed(since, &mission.call(config, round, Some(since)), round, at)
            }
            // The chain has landed meanwhile: above the base the relay would hold no link until its
            // battery is empty.
            Self::TakingOff { .. }
                if order != Some(Order::Land) && mission.calls_off(config, round) =>
            {
                Self::Landing { since: round.now, why: LandReason::Retired }
            }
            Self::TakingOff { since } | Self::Rising { since } => {
                climbed(since, config, mission, round, at).unwrap_or(self)
            }
            Self::OnMission(duty) => match mission.next_duty(config, round, duty) {
                Continue(duty) => Self::OnMission(duty),
                Break(why) => Self::Landing { since: round.now, why },
            },
            Self::Perched => perched(round, at),
            Self::Landing { since, why } => landing(since, why, config, round, at),
            Self::Landed { why: LandReason::Retired } => Self::Idle,
            Self::Landed { why } => match order {
                Some(Order::Wait) => Self::Idle,
                _ => Self::Landed { why },
            },
            Self::Stopped => Self::Stopped,
        }
    }

    /// The state that the flight code has forced on the drone, if it has.
    fn brought_down(self, now: Instant, at: &Situation) -> Option<Self> {
        match at.fitness {
            Fitness::Landed(why) if self.is_airborne() => {
                Some(Self::Landed { why: LandReason::Unfit(why) })
            }
            Fitness::Landing(why)
                if self.is_airborne() && !matches!(self, Self::Landing { .. }) =>
            {
                Some(Self::Landing { since: now, why: LandReason::Unfit(why) })
            }
            _ => None,
        }
    }
}

fn idle(call: &Call, round: &Round, at: &Situation) -> State {
    if round.explores() && call.arms && at.fit {
        State::Armed { since: round.now }
    } else {
        State::Idle
    }
}

fn armed(since: Instant, call: &Call, round: &Round, at: &Situation) -> State {
    if !round.explores() || !at.fit || !call.stays_armed {
        State::Idle
    } else if call.takes_off {
        State::TakingOff { since: round.now }
    } else {
        State::Armed { since }
    }
}

/// What ends a climb, once something does.
fn climbed(
    since: Instant,
    config: &AgentConfig,
    mission: &Mission,
    round: &Round,
    at: &Situation,
) -> Option<State> {
    let flight = &config.flight;
    let elapsed = round.now.since(since);
    let climb_time = flight.height.0 / flight.climb.0;
    let settled = elapsed.as_secs_f32() >= climb_time + flight.settle.as_secs_f32();
    if round.order() == Some(Order::Land) {
        Some(State::Landing { since: round.now, why: LandReason::Ordered })
    } else if settled && flight.is_up(at.height) {
        Some(State::OnMission(mission.first_duty(round.role, round.now)))
    } else if elapsed > flight.patience {
        Some(State::Landing { since: round.now, why: LandReason::TakeOffFailed })
    } else {
        None
    }
}

/// A drone that could not fly home stays on its perch, as a link of the chain.
fn perched(round: &Round, at: &Situation) -> State {
    match round.order() {
        Some(Order::Land) => State::Landed { why: LandReason::Ordered },
        Some(Order::Explore(..) | Order::Return) if at.fit => State::Rising { since: round.now },
        _ => State::Perched,
    }
}

fn landing(
    since: Instant,
    why: LandReason,
    config: &AgentConfig,
    round: &Round,
    at: &Situation,
) -> State {
    let down = at.height.is_some_and(|h| h <= FlightConfig::GROUND);
    let is_over = down || round.now.since(since) > config.flight.patience;
    if is_over && why == LandReason::Perched {
        State::Perched
    } else if is_over {
        State::Landed { why }
    } else {
        State::Landing { since, why }
    }
}
