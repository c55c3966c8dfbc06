//! The door between the shell that every mission shares and the mission that the drone is on.
//!
//! The shell sees to orders, take-off, fitness, the way home by battery, landing and stopping. It
//! tells the mission of each [`Round`], asks it whether it [`Call`]s for a drone on the ground, and
//! in the air asks for the next [`Duty`] and for a [`Wish`].

mod battery;
pub(crate) mod chain;
pub(crate) mod explore;
pub(crate) mod swarm;

use core::ops::ControlFlow;

use ::chain::filter::LinkEstimate;
use tunnel_nav::{Guide, NavCommand};
use units::{
    Duration, Instant, LinkSpan, LinkSum, Metres, MetresPerSecond, MissionKind, NodeId, Order,
    Payload, Phase, Radians, RadiansPerSecond, Role, Signpost,
};

use crate::{AgentConfig, Inputs, LandReason, LinkView, Reckoning};
use chain::{Chain, ChainDuty};
use explore::{Exploration, Explore, ExploreDuty};
use swarm::{Swarm, SwarmDuty};

/// What a drone does in the air for its mission.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Duty {
    /// A duty in a chain of relays behind a head.
    Chain(ChainDuty),
    /// A duty in a swarm.
    Swarm(SwarmDuty),
    /// A duty of a drone that explores.
    Explore(ExploreDuty),
}

impl Duty {
    /// The duty's name, without its data. No two states of a drone have the same.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Chain(duty) => duty.name(),
            Self::Swarm(duty) => duty.name(),
            Self::Explore(duty) => duty.name(),
        }
    }

    /// The duty's number on the air, without its data. No two states of a drone have the same.
    #[must_use]
    pub const fn code(&self) -> u8 {
        match self {
            Self::Chain(duty) => duty.code(),
            Self::Swarm(duty) => duty.code(),
            Self::Explore(duty) => duty.code(),
        }
    }

    /// What the other drones of the mission are told of the duty.
    pub(crate) const fn phase(&self) -> Phase {
        match self {
            Self::Chain(duty) => duty.phase(),
            Self::Swarm(_) | Self::Explore(_) => Phase::Linked,
        }
    }
}

/// What follows a round of a duty: the next duty, or the landing that ends it.
pub(crate) type Next<D> = ControlFlow<LandReason, D>;

/// What a mission is told of a round.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Round {
    /// When it is.
    pub(crate) now: Instant,
    /// The drone's number.
    pub(crate) id: NodeId,
    /// The drone's part in the mission.
    pub(crate) role: Role,
    /// The phase that the drone reports.
    pub(crate) phase: Phase,
    /// What is to be done.
    pub(crate) task: Option<Task>,
    /// Where the drone is by its own reckoning.
    pub(crate) here: Reckoning,
    /// The way at which the tunnel last opened to a side.
    pub(crate) junction: Option<Metres>,
}

impl Round {
    /// The order to follow, if there was any.
    pub(crate) fn order(&self) -> Option<Order> {
        self.task.map(|task| task.order)
    }

    /// The drone's way along the tunnel since take-off.
    pub(crate) const fn way(&self) -> Metres {
        self.here.odometer
    }

    /// Whether the order is to explore.
    pub(crate) fn explores(&self) -> bool {
        matches!(self.order(), Some(Order::Explore(..)))
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
    /// The drone flies along the tunnel at this speed and height, its nose along the way, and is guided
    /// at junctions.
    Along { speed: MetresPerSecond, height: Metres, guide: Guide },
    /// The drone flies by this command, for which the mission has looked at the walls.
    Beside { command: NavCommand, height: Metres },
    /// The drone flies over ground at this velocity, given in the axes of the world, in which its nose
    /// points to `yaw`; the mission itself keeps it off walls.
    Over {
        east: MetresPerSecond,
        north: MetresPerSecond,
        yaw: Radians,
        yaw_rate: RadiansPerSecond,
        height: Metres,
    },
}

/// What a drone's report passes on along the chain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PassedOn {
    /// The span of the links from the head down to the drone.
    pub(crate) links: Option<LinkSpan>,
    /// The sums over the links towards the head, and over those towards the base.
    pub(crate) sums: [LinkSum; 2],
    /// How many relays wait on the ground.
    pub(crate) waiting: u8,
    /// The head's velocity.
    pub(crate) head_velocity: MetresPerSecond,
    /// Whether the head calls for a relay.
    pub(crate) calls: bool,
    /// Whether the signal does not fall evenly along the tunnel.
    pub(crate) is_uneven: bool,
    /// One of the pilot's choices at junctions.
    pub(crate) signpost: Option<Signpost>,
}

impl PassedOn {
    /// The report of a drone that is on no chain: it passes on nothing.
    pub(crate) const NOTHING: Self = Self {
        links: None,
        sums: [LinkSum::NONE; 2],
        waiting: 0,
        head_velocity: MetresPerSecond::ZERO,
        calls: false,
        is_uneven: false,
        signpost: None,
    };
}

/// The most messages that a mission gives the link in one round: the link has room for so many.
pub(crate) const MESSAGES: usize = 4;

/// The messages of a mission that the link is to send, the oldest first.
pub(crate) type Outbox = heapless::Vec<Payload, MESSAGES>;

/// The mission that a drone is on.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one, for ever, and no heap")]
pub(crate) enum Mission {
    /// A chain of relays behind a head.
    Chain(Chain),
    /// A swarm that surveys, gathers and crosses a passage.
    Swarm(Swarm),
    /// Drones that explore a place together.
    Explore(Explore),
}

impl Mission {
    /// The mission of this kind, before it begins.
    // Not inlined, it would be made on the stack where a static is initialised with it.
    #[inline(always)]
    pub(crate) const fn new(kind: MissionKind) -> Self {
        match kind {
            MissionKind::Chain => Self::Chain(Chain::new()),
            MissionKind::Swarm => Self::Swarm(Swarm::new()),
            MissionKind::Explore => Self::Explore(Explore::new()),
        }
    }

    /// The kind of the mission.
    pub(crate) const fn kind(&self) -> MissionKind {
        match self {
            Self::Chain(_) => MissionKind::Chain,
            Self::Swarm(_) => MissionKind::Swarm,
            Self::Explore(_) => MissionKind::Explore,
        }
    }

    /// The duty of a drone that is at its place in the air, and bears with its links until
    /// `patient_until`.
    pub(crate) const fn first_duty(&self, role: Role, patient_until: Instant) -> Duty {
        match self {
            Self::Chain(_) => Duty::Chain(ChainDuty::at_place(role, patient_until)),
            Self::Swarm(_) => Duty::Swarm(SwarmDuty::first(patient_until)),
            Self::Explore(_) => Duty::Explore(ExploreDuty::first()),
        }
    }

    /// Takes in what was sensed and heard.
    pub(crate) fn listen(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        dt: Duration,
        velocity: MetresPerSecond,
        inputs: &Inputs<'_>,
        exploration: Option<&mut Exploration>,
    ) {
        match self {
            Self::Chain(chain) => chain.listen(config, round, dt, velocity, inputs),
            Self::Swarm(swarm) => swarm.listen(config, round, inputs),
            Self::Explore(explore) => explore.listen(config, round, inputs, exploration),
        }
    }

    /// Whether it calls for this drone, which is on the ground and was armed at `armed`, if it is.
    pub(crate) fn call(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        armed: Option<Instant>,
    ) -> Call {
        match self {
            Self::Chain(chain) => chain.call(config, round, armed),
            Self::Swarm(swarm) => {
                let knows = swarm.is_located();
                Call { arms: knows, stays_armed: knows, takes_off: knows }
            }
            Self::Explore(explore) => explore.call(),
        }
    }

    /// Whether the mission no longer calls for a drone that climbs towards it.
    pub(crate) fn calls_off(&self, config: &AgentConfig, round: &Round) -> bool {
        match self {
            Self::Chain(chain) => chain.has_chain_landed(config, round),
            Self::Swarm(_) | Self::Explore(_) => false,
        }
    }

    /// Notes where the drone takes off.
    pub(crate) fn note_home(&mut self) {
        match self {
            Self::Chain(chain) => chain.note_home(),
            Self::Swarm(_) | Self::Explore(_) => {}
        }
    }

    /// Where a drone is that lands for this reason, if it knows better than its odometer.
    pub(crate) fn settled(&self, round: &Round, why: LandReason) -> Option<Metres> {
        match self {
            Self::Chain(chain) => chain.settled(round, why),
            Self::Swarm(_) | Self::Explore(_) => None,
        }
    }

    /// Whether the battery has little more than the way home takes, for which this drone recalls all of
    /// the mission. Drones that explore decide that each for itself.
    pub(crate) fn must_turn_back(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        inputs: &Inputs<'_>,
    ) -> bool {
        match self {
            Self::Chain(_) => {
                let way = round.way().0.max(0.0) / config.flight.return_speed.0;
                let least = config.flight.turns_back_below(way);
                inputs.endurance.is_some_and(|left| left.as_secs_f32() < least)
            }
            Self::Swarm(swarm) => swarm.must_turn_back(config, round, inputs),
            Self::Explore(_) => false,
        }
    }

    /// What follows this round of a duty.
    pub(crate) fn next_duty(
        &mut self,
        config: &AgentConfig,
        round: &Round,
        duty: Duty,
    ) -> Next<Duty> {
        match (self, duty) {
            (Self::Chain(chain), Duty::Chain(duty)) => {
                chain.next_duty(config, round, duty).map_continue(Duty::Chain)
            }
            (Self::Swarm(swarm), Duty::Swarm(duty)) => {
                swarm.next_duty(config, round, duty).map_continue(Duty::Swarm)
            }
            (Self::Explore(explore), Duty::Explore(duty)) => {
                explore.next_duty(config, round, duty).map_continue(Duty::Explore)
            }
            // The drone was never on another mission than the one that it flies.
            (Self::Chain(_) | Self::Swarm(_) | Self::Explore(_), _) => {
                Next::Break(LandReason::Ordered)
            }
        }
    }

    /// How the drone is to fly at its duty.
    pub(crate) fn wish(&mut self, config: &AgentConfig, round: &Round, duty: Duty) -> Wish {
        match (self, duty) {
            (Self::Chain(chain), Duty::Chain(duty)) => chain.wish(config, round, duty),
            (Self::Swarm(swarm), Duty::Swarm(_)) => swarm.wish(config),
            (Self::Explore(explore), Duty::Explore(_)) => explore.wish(config),
            (Self::Chain(_) | Self::Swarm(_) | Self::Explore(_), _) => Wish::Along {
                speed: MetresPerSecond::ZERO,
                height: config.flight.height,
                guide: Guide::NONE,
            },
        }
    }

    /// The estimates of the links to all drones that were heard.
    pub(crate) fn estimates(&self) -> impl Iterator<Item = (NodeId, LinkEstimate)> {
        let chain = match self {
            Self::Chain(chain) => Some(chain),
            Self::Swarm(_) | Self::Explore(_) => None,
        };
        chain.into_iter().flat_map(Chain::estimates)
    }

    /// The links to the neighbours in front and behind, as others may look at them.
    pub(crate) fn views(&self) -> [Option<LinkView>; 2] {
        match self {
            Self::Chain(chain) => chain.views(),
            Self::Swarm(_) | Self::Explore(_) => [None; 2],
        }
    }

    /// Whether the strength of a link to a neighbour of the chain is only reckoned.
    pub(crate) fn is_blind(&self) -> bool {
        match self {
            Self::Chain(chain) => chain.is_blind(),
            Self::Swarm(_) | Self::Explore(_) => false,
        }
    }

    /// What the drone's report passes on along the chain.
    pub(crate) fn passed_on(&mut self, config: &AgentConfig, round: &Round) -> PassedOn {
        match self {
            Self::Chain(chain) => chain.passed_on(config, round),
            Self::Swarm(_) | Self::Explore(_) => PassedOn::NOTHING,
        }
    }

    /// Puts what the drone tells the others of the mission in this round into `outbox`.
    pub(crate) fn tell(&mut self, round: &Round, outbox: &mut Outbox) {
        match self {
            Self::Chain(_) => {}
            Self::Swarm(swarm) => swarm.tell(round, outbox),
            Self::Explore(explore) => explore.tell(outbox),
        }
    }
}
