//! One whole drone without its chip: the agent, the radio link, the server for clients, the
//! operator's orders, the gates before a take-off, and the mounting of the board.
//!
//! The firmware's tasks and the simulator's members both run exactly this type. [`Drone`] is
//! sans-I/O: it owns no clock and no line, never allocates and never panics. The caller passes the
//! time, received packets and sensor values, and takes packets and set-points from it:
//!
//! ```text
//!                     receive ┌───────────────────────────────┐ transmit
//!   packets of the chain ────▶│ airlink ──▶ mailbox ──▶ agent │────────▶ packets of the chain
//!                      client │    ▲                          │ poll_client
//!   packets of a client ─────▶│ server ──▶ orders             │────────▶ packets to the client
//!                        step │                               │
//!   sensor values ───────────▶│ gates, mounting               │────────▶ set-point
//!                             └───────────────────────────────┘
//! ```
//!
//! # Stopping wins
//! Every node takes an emergency stop from any client: a drone for itself, the base for the whole
//! mission. A stop is latched in the operator's orders, in the link and in the agent, and nothing
//! replaces it but switching the drone off. The caller stores [`Drone::is_stopped`] where it outlives
//! a restart by a fault, and passes it to the next drone as [`Setup::stopped`].
//!
//! | module | holds |
//! |---|---|
//! | `operator` | the state machine of the operator's orders |
//! | `client` | the access of cfclient and cflib: reading, setting, orders |
//! | `link` | the end of the radio link, shut or open |
//! | `mailbox` | reports and orders between link and agent |
//! | `sensed` | the sensor values of a round |
//! | [`mounting`] | the rotation between board and nose |
//! | [`air`] | conversions between the agent's types and the messages on the air |
//! | [`probe`] | a static in which a firmware shows its drone's decisions to an emulator |
#![no_std]
#![deny(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::unreachable,
    clippy::indexing_slicing,
    clippy::string_slice
)]
#![cfg_attr(
    test,
    allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

#[cfg(test)]
extern crate std;

pub mod air;
mod client;
mod link;
mod mailbox;
pub mod mounting;
mod operator;
pub mod probe;
mod sensed;

use agent::{Agent, AgentConfig, ConfigError, Fitness};
use airlink::{Airlink, Counters, Event, Identity, LinkConfig, Opened, Schedule, Seal, Status};
use chain::neighbours::Heard;
use chain::policy::{Policy, PolicyConfig, REGISTRY};
use crtp::{About, Node, Parameters};
use storage::settings::{Limits, Settings};
use units::{Dbm, Duration, Instant, NODES, NodeId, Order, PolicyCode, Role, Setpoint};
use wire::p2p::{Beacon, Counter, Epoch, Kind};
use wire::syslink::MAX_P2P;

use client::{Client, Orders};
use link::{Heeded, Link};
use mailbox::Mailbox;

pub use agent::{ChainDuty, Duty, State};
pub use client::{Unsaved, observed};
pub use crtp::Snapshot;
pub use link::LinkHealth;
pub use operator::Operator;
pub use sensed::Sensed;

/// A drone's constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// The agent's.
    pub agent: AgentConfig,
    /// The radio link's.
    pub link: LinkConfig,
    /// For how long reports and orders lie in the mailbox before the agent may take them. It is zero
    /// on board; the simulator studies delays with it.
    pub mailbox_delay: Duration,
}

impl Config {
    /// The constants that are flashed unless others are chosen.
    pub const DEFAULT: Self = Self {
        agent: AgentConfig::DEFAULT,
        link: LinkConfig::DEFAULT,
        mailbox_delay: Duration::ZERO,
    };

    /// The same with the settings that the drone has stored. `complain` is called for each setting
    /// that cannot be used; in its place the constants hold.
    #[must_use]
    pub fn with_settings(
        mut self,
        settings: &Settings,
        mut complain: impl FnMut(Unusable),
    ) -> Self {
        if let Some(height) = settings.height {
            self.agent.flight.height = height;
        }
        match settings.policy.map(|code| (code, Policy::with_code(code))) {
            None => {}
            Some((_, Some(policy))) => self.agent.policy = policy.config,
            Some((code, None)) => complain(Unusable::Policy(code)),
        }
        let Limits { launch, retreat } = settings.limits;
        let limited = self.agent.with_limits(launch, retreat);
        match limited.check() {
            Ok(()) => self.agent = limited,
            Err(why) => complain(Unusable::Limits(why)),
        }
        self
    }
}

/// A setting that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Unusable {
    /// The limits contradict each other.
    Limits(ConfigError),
    /// There is no movement policy of this code.
    Policy(PolicyCode),
}

impl Default for Config {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// How a drone begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    /// The drone's number and role.
    pub identity: Identity,
    /// Whether the drone starts on the ground, after a fault, or in the air.
    pub start: Start,
    /// Whether a stop stood when the last run ended and the drone was not switched off since.
    pub stopped: bool,
    /// The read-only parameters of the drone.
    pub about: About,
}

impl Setup {
    /// A drone of this number and role that was switched on, on the ground.
    #[must_use]
    pub const fn new(node: NodeId, role: Role) -> Self {
        Self {
            identity: Identity { node, role },
            start: Start::OnGround,
            stopped: false,
            about: About { node, role, ..Parameters::DEFAULT.about },
        }
    }
}

/// How and where a drone starts a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// On the ground, switched on.
    OnGround,
    /// On the ground, as far as it knows, after a run that ended by a fault or in the air.
    AfterFault,
    /// In the air, at its place in the chain, at this moment: for studies.
    InAir(Instant),
}

/// The keys that a drone has, for its link.
#[derive(Debug)]
pub enum Keys<S> {
    /// It was never provisioned.
    Missing,
    /// It has keys that it must not use.
    Unusable,
    /// It has keys, and an epoch to use them in.
    Held {
        /// Seals packets with the keys.
        seal: S,
        /// The epoch of this run, which was never used before with these keys.
        epoch: Epoch,
        /// The turns of the drone's number.
        schedule: Schedule,
        /// Whether clients may give orders through it, if it is the base.
        may_fly: bool,
    },
}

/// The result of a round of the mission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outputs {
    /// The set-point in the axes of the nose.
    pub setpoint: Setpoint,
    /// The outputs of the agent.
    pub agent: agent::Outputs,
}

impl Outputs {
    /// The set-point in the axes of the board.
    #[must_use]
    pub fn board_setpoint(&self) -> Setpoint {
        mounting::to_board(self.setpoint)
    }
}

/// One whole drone without its chip. `S` seals its packets.
#[derive(Debug)]
pub struct Drone<S> {
    config: Config,
    identity: Identity,
    agent: Agent,
    link: Link<S>,
    mailbox: Mailbox,
    orders: Orders,
    client: Client,
    heeded: Heeded,
    /// Whether clients may give orders through this drone, if it is the base.
    may_fly: bool,
    /// The last telemetry of each node, at the base.
    nodes: [Option<Node>; NODES],
    /// The outputs of the agent's last round.
    outputs: Option<agent::Outputs>,
}

/// The agent at the start of a run.
fn agent(setup: &Setup) -> Agent {
    let Identity { node, role } = setup.identity;
    match setup.start {
        Start::OnGround => Agent::new(node, role),
        Start::AfterFault => Agent::restarted(node, role),
        Start::InAir(now) => Agent::new_linked(node, role, now),
    }
}

/// The operator's orders at the start of a run.
const fn operator(setup: &Setup) -> Operator {
    if setup.stopped { Operator::Stopped } else { Operator::Silent }
}

/// The parameters at the start of a run.
fn parameters(config: &Config, setup: &Setup) -> Parameters {
    Parameters {
        height: config.agent.flight.height,
        launch_limit: config.agent.launch.limit,
        retreat_limit: config.agent.retreat.limit,
        policy: code_of(&config.agent.policy),
        about: setup.about,
        ..Parameters::DEFAULT
    }
}

/// The code of a movement policy; `None` for one that is not in the registry.
fn code_of(config: &PolicyConfig) -> Option<PolicyCode> {
    REGISTRY.iter().find(|policy| policy.config == *config).map(|policy| policy.code)
}

/// Replaces a part of a drone. It is a function of its own, so that of all new parts only one at a
/// time is on the stack.
#[inline(never)]
fn replace<T>(part: &mut T, new: impl FnOnce() -> T) {
    *part = new();
}

impl<S> Drone<S> {
    /// A drone that is switched off: on the ground, with the default settings and without a link.
    ///
    /// It is a constant for a static: a drone is too large for a small stack, so a firmware does not
    /// move one, but lets [`begin`](Self::begin) change the static where it is.
    #[must_use]
    pub const fn switched_off() -> Self {
        let Settings { node, role, .. } = Settings::DEFAULT;
        Self {
            config: Config::DEFAULT,
            identity: Identity { node, role },
            agent: Agent::new(node, role),
            link: Link::NoKeys,
            mailbox: Mailbox::new(),
            orders: Orders::new(Operator::Silent),
            client: Client::new(Parameters::DEFAULT),
            heeded: Heeded::NONE,
            may_fly: false,
            nodes: [None; NODES],
            outputs: None,
        }
    }
}

impl<S: Seal> Drone<S> {
    /// A drone at the beginning of a run, without a link, before its first round.
    #[must_use]
    pub fn new(config: Config, setup: &Setup) -> Self {
        let mut drone = Self::switched_off();
        drone.begin(config, setup);
        drone
    }

    /// Begins a run: the drone is then as [`new`](Self::new) makes it, whatever it was before.
    pub fn begin(&mut self, config: Config, setup: &Setup) {
        replace(&mut self.config, || config);
        replace(&mut self.identity, || setup.identity);
        replace(&mut self.agent, || agent(setup));
        replace(&mut self.link, || Link::NoKeys);
        replace(&mut self.mailbox, Mailbox::new);
        replace(&mut self.orders, || Orders::new(operator(setup)));
        replace(&mut self.client, || Client::new(parameters(&config, setup)));
        replace(&mut self.heeded, || Heeded::NONE);
        replace(&mut self.may_fly, || false);
        replace(&mut self.nodes, || [None; NODES]);
        replace(&mut self.outputs, || None);
    }

    /// Gives the drone its keys, once. With usable ones its link opens: it listens, then transmits.
    pub fn open_link(&mut self, now: Instant, keys: Keys<S>) {
        match keys {
            Keys::Missing => self.link = Link::NoKeys,
            Keys::Unusable => self.link = Link::Shut,
            Keys::Held { seal, epoch, schedule, may_fly } => {
                self.may_fly = may_fly;
                let (config, identity) = (self.config.link, self.identity);
                let link = Airlink::new(config, identity, seal, epoch, schedule, now);
                self.link = Link::Open(link);
                self.repeat_order(now);
            }
        }
    }

    /// Takes a P2P packet of the chain the moment that it has come in. Returns the kind of message
    /// that it has brought for this drone, if any.
    pub fn receive(&mut self, now: Instant, rssi: Dbm, packet: &[u8]) -> Option<Kind> {
        let opened = self.open(packet)?;
        self.receive_opened(now, rssi, &opened)
    }

    /// Reads a P2P packet of the chain with the fleet's key; `None` while the link is shut. All
    /// drones of a fleet read the same.
    #[must_use]
    pub fn open(&self, packet: &[u8]) -> Option<Opened> {
        Some(self.link.open()?.open(packet))
    }

    /// Takes an opened packet as [`Drone::receive`] takes its bytes.
    pub fn receive_opened(&mut self, now: Instant, rssi: Dbm, packet: &Opened) -> Option<Kind> {
        Some(match self.link.open_mut()?.receive_opened(now, rssi, packet)? {
            Event::Report { from, counter, report, rssi } => {
                let me = self.identity.node;
                self.hear(now, air::report_from_air(me, from, counter, &report, rssi));
                Kind::Report
            }
            Event::Order { task, counter } => {
                self.heeded.last = Some(counter);
                self.heed(now, task);
                Kind::Command
            }
            Event::Telemetry { from, telemetry, .. } => {
                if let Some(place) = self.nodes.get_mut(usize::from(from.0)) {
                    *place = Some(Node { telemetry, heard: now });
                }
                Kind::Telemetry
            }
            Event::Beacon { .. } => Kind::Beacon,
            Event::Membership { .. } => Kind::Membership,
        })
    }

    /// Takes another node's report, however it has come: out of a packet, or without one in a
    /// simulation of an ideal link.
    pub fn hear(&mut self, now: Instant, report: Heard) {
        self.mailbox.report(now, report);
    }

    /// Takes an order of the base, however it has come.
    pub fn heed(&mut self, now: Instant, order: Order) {
        self.heeded.count = self.heeded.count.wrapping_add(1);
        self.mailbox.order(now, order);
    }

    /// When to call [`Drone::transmit`] next; ask again after every other call.
    #[must_use]
    pub fn due(&mut self) -> Option<Instant> {
        self.link.open_mut()?.due()
    }

    /// Writes the packet of the chain that is to be sent now, if there is one, and returns its
    /// length. The packet must be given to the serial line at once.
    pub fn transmit(&mut self, now: Instant, out: &mut [u8; MAX_P2P]) -> Option<usize> {
        self.link.open_mut()?.transmit(now, out)
    }

    /// Leaves the chain in the drone's next turn, if its link is open. Returns whether it is.
    pub fn leave(&mut self) -> bool {
        self.link.open_mut().map(Airlink::leave).is_some()
    }

    /// Runs one round of the mission, 5 times a second.
    pub fn step(&mut self, now: Instant, sensed: &Sensed) -> Outputs {
        self.step_shown(now, sensed, |_, _| {})
    }

    /// The same; `show` is called with the inputs and the outputs of the agent.
    pub fn step_shown(
        &mut self,
        now: Instant,
        sensed: &Sensed,
        show: impl FnOnce(&agent::Inputs<'_>, &agent::Outputs),
    ) -> Outputs {
        self.attend(now);
        self.repeat_order(now);
        let sensed = Sensed { fitness: self.fitness(sensed.fitness), ..*sensed };
        let order = self.order_of_round(now);
        let delay = self.config.mailbox_delay;
        let heard = self.mailbox.due(now, delay);
        let count = heard.len();
        let inputs = agent::Inputs {
            ranges: sensed.ranges,
            velocity: sensed.velocity,
            heading: sensed.heading,
            height: sensed.height,
            heard,
            order,
            fitness: sensed.fitness,
            endurance: sensed.endurance,
        };
        let outputs = self.agent.step(&self.config.agent, now, &inputs);
        show(&inputs, &outputs);
        self.mailbox.forget(count);
        self.publish(&outputs, &sensed);
        self.outputs = Some(outputs);
        let setpoint = match self.identity.role {
            Role::Base => Setpoint::Off,
            Role::Head | Role::Relay => outputs.setpoint,
        };
        Outputs { setpoint, agent: outputs }
    }

    /// Gives the operator's order to the whole mission again: the link tells the head of an order to
    /// explore once for each time.
    fn repeat_order(&mut self, now: Instant) {
        if let Some(order) = self.orders.operator.order() {
            self.link.order(now, order);
        }
    }

    /// The order that the agent is given in this round.
    fn order_of_round(&mut self, now: Instant) -> Option<Order> {
        match (self.identity.role, self.orders.operator) {
            (_, Operator::Stopped) => Some(Order::Stop),
            (Role::Base, operator) => operator.order(),
            (Role::Head | Role::Relay, _) => {
                self.mailbox.take_order(now, self.config.mailbox_delay)
            }
        }
    }

    /// A drone whose link is shut, or that was refused by the chain, does not take off: no order to
    /// land would reach it.
    fn fitness(&self, machine: Fitness) -> Fitness {
        match machine {
            Fitness::Fit
                if !self.agent.state().is_airborne() && self.link_health() != LinkHealth::Fine =>
            {
                Fitness::Unfit
            }
            machine => machine,
        }
    }

    /// Hands report and telemetry to the link.
    fn publish(&mut self, outputs: &agent::Outputs, sensed: &Sensed) {
        let role = self.identity.role;
        let Some(link) = self.link.open_mut() else { return };
        link.report(air::report_to_air(outputs));
        let state = outputs.status.state.code();
        link.beacon(Beacon { role, state, battery: sensed.battery });
        if role != Role::Base {
            link.telemeter(air::telemetry(outputs, sensed));
        }
    }

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

    /// The outputs of the agent's last round; `None` before the first.
    #[must_use]
    pub const fn outputs(&self) -> Option<&agent::Outputs> {
        self.outputs.as_ref()
    }

    /// The operator's orders, as this node has them.
    #[must_use]
    pub const fn operator(&self) -> Operator {
        self.orders.operator
    }

    /// Whether a stop stands: the motors must be off, and the caller must store the stop over a
    /// restart.
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

    /// How the drone stands with the others; `None` while its link is shut.
    #[must_use]
    pub fn link_status(&self) -> Option<Status> {
        self.link.open().map(Airlink::status)
    }

    /// The counters of the link; `None` while it is shut.
    #[must_use]
    pub fn link_counters(&self) -> Option<Counters> {
        self.link.open().map(Airlink::counters)
    }

    /// The number of the last order that has come over the link.
    #[must_use]
    pub const fn last_order(&self) -> Option<Counter> {
        self.heeded.last
    }

    /// The last telemetry of a node, at the base.
    #[must_use]
    pub fn node(&self, node: NodeId) -> Option<Node> {
        self.nodes.get(usize::from(node.0)).copied().flatten()
    }

    /// Reports that were dropped because the mailbox was full.
    #[must_use]
    pub const fn dropped_reports(&self) -> u32 {
        self.mailbox.dropped()
    }
}
