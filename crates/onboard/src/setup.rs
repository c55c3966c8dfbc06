//! Defines the conditions under which a drone begins a run.

use agent::Agent;
use airlink::{Identity, Schedule};
use chain::policy::REGISTRY;
use crtp::{About, Parameters};
use units::{Instant, Metres, MissionKind, NodeId, Role};
use wire::p2p::Epoch;

use crate::{Config, Operator};

/// The conditions under which a drone begins a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    /// The drone's number and role.
    pub identity: Identity,
    /// The mission that the drone flies.
    pub mission: MissionKind,
    /// Whether the drone starts on the ground, after a fault, or in the air.
    pub start: Start,
    /// Whether a stop was valid when the last run ended, and the drone was not switched off since.
    pub stopped: bool,
    /// The read-only parameters of the drone.
    pub about: About,
}

impl Setup {
    /// A drone of this number and role that was switched on, on the ground, on the mission chain.
    #[must_use]
    pub const fn new(node: NodeId, role: Role) -> Self {
        Self {
            identity: Identity { node, role },
            mission: MissionKind::Chain,
            start: Start::OnGround,
            stopped: false,
            about: About { node, role, ..Parameters::DEFAULT.about },
        }
    }

    /// Resets an agent to its state at the start of a run.
    pub(crate) fn renew(&self, agent: &mut Agent) {
        let Identity { node, role } = self.identity;
        agent.renew(node, role, self.mission);
        match self.start {
            Start::OnGround => {}
            Start::AfterFault => agent.note_restart(),
            Start::InAir { at, flown } => agent.place_in_air(at, flown),
        }
    }

    /// The operator's orders at the start of the run.
    pub(crate) const fn operator(&self) -> Operator {
        if self.stopped { Operator::Stopped } else { Operator::Silent }
    }

    /// The parameters at the start of the run.
    pub(crate) fn parameters(&self, config: &Config) -> Parameters {
        let policy = REGISTRY.iter().find(|policy| policy.config == config.agent.policy);
        Parameters {
            height: config.agent.flight.height,
            launch_limit: config.agent.launch.limit,
            retreat_limit: config.agent.retreat.limit,
            policy: policy.map(|policy| policy.code),
            about: self.about,
            ..Parameters::DEFAULT
        }
    }
}

/// The place and the circumstances in which a drone starts a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// The drone was switched on, on the ground.
    OnGround,
    /// The drone restarts after a run that ended by a fault or in the air, and is presumably on the
    /// ground.
    AfterFault,
    /// The drone starts in the air, at its place in the chain, as if it had flown there; only
    /// simulations use this.
    InAir {
        /// The moment of the start.
        at: Instant,
        /// The way that it has flown from the base, which its odometer shows.
        flown: Metres,
    },
}

/// The keys that a drone has, for its link.
#[derive(Debug)]
pub enum Keys<S> {
    /// The drone was never provisioned.
    Missing,
    /// The drone has keys that it must not use.
    Unusable,
    /// The drone has keys, and an epoch in which to use them.
    Held {
        /// The seal that encrypts packets with the keys.
        seal: S,
        /// The epoch of this run, which was never used before with these keys.
        epoch: Epoch,
        /// The turns of the drone's number.
        schedule: Schedule,
        /// Whether clients may give orders through this drone, if it is the base.
        may_fly: bool,
    },
}
