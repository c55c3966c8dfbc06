//! The door between the shell that every mission shares and the mission that the drone is on.
//!
//! The shell sees to orders, take-off, fitness, the way home by battery, landing and stopping. It
//! tells the mission of each [`Round`], asks it whether it [`Call`]s for a drone on the ground, and
//! in the air asks for a [`Wish`].

pub(crate) mod chain;

use ::chain::neighbours::Heard;
use units::{Duration, Instant, LinkSpan, LinkSum, Metres, MetresPerSecond, NodeId, Order, Role};

use crate::{AgentConfig, LinkView, State};
use chain::{Chain, Duty, Links};

/// What a mission is told of a round.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Round {
    /// When it is.
    pub(crate) now: Instant,
    /// The drone's number.
    pub(crate) id: NodeId,
    /// The drone's part in the mission.
    pub(crate) role: Role,
    /// What is to be done.
    pub(crate) task: Option<Task>,
    /// The drone's way along the tunnel since take-off.
    pub(crate) way: Metres,
}

impl Round {
    pub(crate) fn order(&self) -> Option<Order> {
        self.task.map(|task| task.order)
    }
}

/// The order that a drone follows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Task {
    /// The order.
    pub(crate) order: Order,
    /// When the operator gave it last.
    pub(crate) given: Instant,
}

/// Whether a mission calls for a drone that is on the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Call {
    /// The drone is next to fly: it arms.
    pub(crate) arms: bool,
    /// The drone is still next to fly, once it is armed.
    pub(crate) stays_armed: bool,
    /// The mission needs the drone in the air.
    pub(crate) takes_off: bool,
}

/// How a drone is to fly, before the walls have their say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Wish {
    /// The motors are off.
    Rest,
    /// The motors are off for good.
    Stop,
    /// The drone flies along the tunnel at this speed and height, its nose along the way.
    Along { speed: MetresPerSecond, height: Metres },
}

/// What a drone's report passes on along the chain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PassedOn {
    /// The sums over the links towards the head, and over those towards the base.
    pub(crate) sums: [LinkSum; 2],
    /// How many relays wait on the ground.
    pub(crate) waiting: u8,
    /// The head's velocity.
    pub(crate) head_velocity: MetresPerSecond,
}

/// The mission that a drone is on.
#[derive(Clone, Debug)]
pub(crate) enum Mission {
    /// A chain of relays behind a head.
    Chain(Chain),
}

impl Mission {
    /// Takes in motion and reports.
    pub(crate) fn listen(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        dt: Duration,
        velocity: MetresPerSecond,
        heard: &[Heard],
    ) {
        match self {
            Self::Chain(chain) => chain.listen(config, round, dt, velocity, heard),
        }
    }

    /// Whether it calls for this drone, which is in `state` on the ground.
    pub(crate) fn call(&mut self, config: &AgentConfig, round: &Round, state: State) -> Call {
        match self {
            Self::Chain(chain) => chain.call(config, round, state),
        }
    }

    /// The drone's links to its neighbours.
    pub(crate) fn links(&self, config: &AgentConfig) -> Links {
        match self {
            Self::Chain(chain) => chain.links(config),
        }
    }

    /// The links to the neighbours in front and behind, as others may look at them.
    pub(crate) fn views(&self) -> [Option<LinkView>; 2] {
        match self {
            Self::Chain(chain) => [chain.front_view(), chain.back_view()],
        }
    }

    /// Whether a relay in `state` should look for a better place now.
    pub(crate) fn searches(&mut self, config: &AgentConfig, round: &Round, state: State) -> bool {
        match self {
            Self::Chain(chain) => chain.searches(config, round, state),
        }
    }

    /// Whether the mission no longer needs a drone in `state`.
    pub(crate) fn retires(&mut self, config: &AgentConfig, round: &Round, state: State) -> bool {
        match self {
            Self::Chain(chain) => chain.retires(config, round, state),
        }
    }

    /// Notes where the drone takes off.
    pub(crate) const fn note_home(&mut self, links: &Links) {
        match self {
            Self::Chain(chain) => chain.note_home(links),
        }
    }

    /// The span of links that the drone's report tells.
    pub(crate) fn span(&self, front: Option<LinkView>) -> Option<LinkSpan> {
        match self {
            Self::Chain(chain) => chain.span(front),
        }
    }

    /// What the drone's report passes on along the chain.
    pub(crate) fn passed_on(&self, config: &AgentConfig, round: &Round) -> PassedOn {
        match self {
            Self::Chain(chain) => chain.passed_on(config, round),
        }
    }

    /// How the drone is to fly at its duty.
    pub(crate) fn wish(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        duty: Duty,
        [front, back]: [Option<LinkView>; 2],
    ) -> Wish {
        match self {
            Self::Chain(chain) => Wish::Along {
                speed: chain.speed(config, round, duty, front, back),
                height: config.flight.height,
            },
        }
    }
}
