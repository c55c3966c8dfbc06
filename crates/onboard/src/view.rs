//! Gives read access to the state of a drone.

use agent::{State, SwarmTarget};
use airlink::{Airlink, Counters, Identity, Seal, Status};
use chain::filter::LinkEstimate;
use crtp::Node;
use units::NodeId;
use wire::p2p::Counter;

use crate::{Config, Drone, LinkHealth, Operator};

impl<S: Seal> Drone<S> {
    /// The drone's constants, with the policy that a client may have chosen.
    #[must_use]
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// The drone's number and role.
    #[must_use]
    pub const fn identity(&self) -> Identity {
        self.identity
    }

    /// The state of the agent.
    #[must_use]
    pub const fn state(&self) -> State {
        self.agent.state()
    }

    /// Where a drone of a swarm is to be, for observers; see [`Agent::target`](agent::Agent::target).
    #[must_use]
    pub fn target(&self) -> Option<SwarmTarget> {
        self.agent.target()
    }

    /// The outputs of the agent's last round; `None` before the first.
    #[must_use]
    pub const fn outputs(&self) -> Option<&agent::Outputs> {
        self.outputs.as_ref()
    }

    /// The estimates of the links to all drones that were heard, lost or not.
    pub fn estimates(&self) -> impl Iterator<Item = (NodeId, LinkEstimate)> {
        self.agent.estimates()
    }

    /// The operator's orders, as far as this node has received them.
    #[must_use]
    pub const fn operator(&self) -> Operator {
        self.orders.operator
    }

    /// Whether a stop is valid: the motors must be off, and the caller must store the stop so that
    /// it survives a restart.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.orders.operator == Operator::Stopped
            || self.mailbox.stops()
            || self.agent.state() == State::Stopped
    }

    /// Whether the drone is part of a chain, or could be.
    #[must_use]
    pub fn link_health(&self) -> LinkHealth {
        self.link.health()
    }

    /// The status of the drone's link; `None` while the link is shut.
    #[must_use]
    pub fn link_status(&self) -> Option<Status> {
        self.link.open().map(Airlink::status)
    }

    /// The counters of the link; `None` while the link is shut.
    #[must_use]
    pub fn link_counters(&self) -> Option<Counters> {
        self.link.open().map(Airlink::counters)
    }

    /// The number of the last order that was received over the link.
    #[must_use]
    pub const fn last_order(&self) -> Option<Counter> {
        self.heeded.last
    }

    /// The last telemetry of a node, at the base.
    #[must_use]
    pub fn node(&self, node: NodeId) -> Option<Node> {
        self.nodes.get(usize::from(node.0)).copied().flatten()
    }

    /// The number of reports that were dropped because the mailbox was full.
    #[must_use]
    pub const fn dropped_reports(&self) -> u32 {
        self.mailbox.dropped()
    }
}
