//! What a drone is doing, and the one function that moves it from one state to the next.

use flight::Cause;
use units::{Dbm, Instant, Metres, Order};

use crate::{AgentConfig, Fitness, FlightConfig, Role};

/// What a drone is doing. The base stays [`Idle`](Self::Idle): its part is to speak and listen.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum State {
    /// On the ground, not asked for.
    Idle,
    /// On the ground, next to fly.
    Armed {
        /// Since when.
        since: Instant,
    },
    /// Climbing to its height and settling there.
    TakingOff {
        /// Since when.
        since: Instant,
    },
    /// The head: flies as the pilot says.
    Leading {
        /// Until then it bears a weak or missing link.
        patient_until: Instant,
    },
    /// A relay: makes its two links equal.
    Relaying {
        /// Until then it bears a weak or missing link.
        patient_until: Instant,
    },
    /// A relay that no longer hears anyone in front.
    Reconnecting {
        /// Since when.
        since: Instant,
        /// The odometer then.
        from: Metres,
    },
    /// Flying back towards a neighbour that it hears too weakly, or not at all.
    BackingUp {
        /// Since when.
        since: Instant,
        /// The odometer then.
        from: Metres,
    },
    /// Coming down where it is.
    Landing {
        /// Since when.
        since: Instant,
        /// Why.
        why: LandReason,
    },
    /// On the ground, out of the mission until told to wait for the next.
    Landed {
        /// Why.
        why: LandReason,
    },
    /// Motors off for good.
    Stopped,
}

/// Why a drone came down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum LandReason {
    /// The operator said so.
    Ordered,
    /// It is where it took off, and was called home.
    Home,
    /// It never reached its height.
    TakeOffFailed,
    /// The base's side stayed silent over the whole of a retreat.
    LinkLost,
    /// The flight code brought it down.
    Unfit(Cause),
    /// Its last run ended by a fault or in the air: however it came down, nobody who orders flight
    /// knows of it.
    Restarted,
}

/// All that a transition depends on.
pub(crate) struct Situation {
    pub(crate) now: Instant,
    pub(crate) task: Option<Order>,
    /// It would take off.
    pub(crate) fit: bool,
    pub(crate) fitness: Fitness,
    /// The filtered strength of the front link, if there is one.
    pub(crate) front: Option<Dbm>,
    /// The filtered strength of the back link, if there is one.
    pub(crate) back: Option<Dbm>,
    /// The same, where the base is that neighbour.
    pub(crate) base: Option<Dbm>,
    /// The strength of the base where the drone took off.
    pub(crate) home_rssi: Option<Dbm>,
    pub(crate) height: Option<Metres>,
    pub(crate) odometer: Metres,
    /// No smaller number is still waiting or climbing.
    pub(crate) my_turn: bool,
    /// A smaller number is a flying link of the chain.
    pub(crate) chain_flies: bool,
    /// The launch policy calls for a relay.
    pub(crate) launch: bool,
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
        match self {
            Self::Stopped => Self::Stopped,
            Self::Idle => idle(role, at),
            Self::Armed { since } => armed(since, role, at),
            Self::TakingOff { since } => taking_off(since, config, role, at),
            Self::Leading { patient_until } => leading(patient_until, config, at),
            Self::Relaying { patient_until } => relaying(patient_until, config, at),
            Self::Reconnecting { since, from } => reconnecting(since, from, config, at),
            Self::BackingUp { since, from } => backing_up(since, from, config, role, at),
            Self::Landing { since, why } => landing(since, why, config, at),
            Self::Landed { why } => match at.task {
                Some(Order::Wait) => Self::Idle,
                _ => Self::Landed { why },
            },
        }
    }
}

impl State {
    /// What the flight code has decided over the agent's head.
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

fn idle(role: Role, at: &Situation) -> State {
    let called = match role {
        Role::Head => true,
        Role::Relay => at.my_turn && at.chain_flies,
        Role::Base => false,
    };
    if explores(at) && called && at.fit { State::Armed { since: at.now } } else { State::Idle }
}

fn armed(since: Instant, role: Role, at: &Situation) -> State {
    let launch = role == Role::Head || at.launch;
    if !explores(at) || !at.fit || (role == Role::Relay && !at.my_turn) {
        State::Idle
    } else if launch {
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

/// Head or relay at its work, bearing with its links until `patient_until`.
fn on_duty(role: Role, patient_until: Instant) -> State {
    match role {
        Role::Head => State::Leading { patient_until },
        Role::Relay | Role::Base => State::Relaying { patient_until },
    }
}

/// What ends every duty: an order to land, or having come home when called.
fn dismissed(config: &AgentConfig, at: &Situation) -> Option<State> {
    let why = match at.task {
        Some(Order::Land) => LandReason::Ordered,
        Some(Order::Return) if is_home(config, at) => LandReason::Home,
        _ => return None,
    };
    Some(State::Landing { since: at.now, why })
}

/// Next to the base, and where it took off by odometer or by signal: ways flown round bends
/// differ out and back, and the base is nowhere stronger than at home.
fn is_home(config: &AgentConfig, at: &Situation) -> bool {
    let Some(base) = at.base else { return false };
    at.odometer <= config.flight.home || at.home_rssi.is_some_and(|home| base >= home)
}

fn leading(patient_until: Instant, config: &AgentConfig, at: &Situation) -> State {
    if let Some(landing) = dismissed(config, at) {
        landing
    } else if at.now >= patient_until && config.retreat.wanted(at.front, at.back, false) {
        State::BackingUp { since: at.now, from: at.odometer }
    } else {
        State::Leading { patient_until }
    }
}

fn relaying(patient_until: Instant, config: &AgentConfig, at: &Situation) -> State {
    if let Some(landing) = dismissed(config, at) {
        landing
    } else if at.now >= patient_until && config.retreat.wanted(at.front, at.back, false) {
        State::BackingUp { since: at.now, from: at.odometer }
    } else if at.now >= patient_until && at.front.is_none() && at.task != Some(Order::Return) {
        State::Reconnecting { since: at.now, from: at.odometer }
    } else {
        State::Relaying { patient_until }
    }
}

fn reconnecting(since: Instant, from: Metres, config: &AgentConfig, at: &Situation) -> State {
    if let Some(landing) = dismissed(config, at) {
        landing
    } else if config.retreat.wanted(at.front, at.back, false) {
        State::BackingUp { since: at.now, from: at.odometer }
    } else if at.front.is_some() || at.task == Some(Order::Return) {
        State::Relaying { patient_until: at.now }
    } else {
        State::Reconnecting { since, from }
    }
}

fn backing_up(
    since: Instant,
    from: Metres,
    config: &AgentConfig,
    role: Role,
    at: &Situation,
) -> State {
    let retreat = &config.retreat;
    let spent =
        at.now.since(since) >= retreat.max_time || (from - at.odometer) >= retreat.max_distance;
    if let Some(landing) = dismissed(config, at) {
        landing
    } else if !retreat.wanted(at.front, at.back, true) {
        on_duty(role, at.now)
    } else if !spent {
        State::BackingUp { since, from }
    } else if at.back.is_some() {
        on_duty(role, at.now + retreat.rest)
    } else {
        State::Landing { since: at.now, why: LandReason::LinkLost }
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
