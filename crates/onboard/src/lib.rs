//! All code of one drone that does not depend on the chip: the agent, the radio link, the server
//! for clients, the operator's orders, the conditions of a take-off, and the mounting of the board.
//!
//! The firmware's tasks and the simulator's members both run exactly this type. [`Drone`] does no
//! I/O: it owns no clock and no bus, never allocates and never panics. The caller passes the time,
//! received packets and sensor values, and takes packets and set-points from it:
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
//! Every node obeys an emergency stop from any client: a drone stops itself, the base the whole
//! mission. A stop is stored in the operator's orders, in the link and in the agent, and is valid
//! until the drone is switched off. The caller stores [`Drone::is_stopped`] where it outlives a
//! restart by a fault, and passes it to the next drone as [`Setup::stopped`].
//!
//! | module | holds |
//! |---|---|
//! | `config`, `setup` | a drone's constants, and how it begins a run |
//! | `packets`, `view` | the packets of the chain, and what may be looked at |
//! | `operator` | the state machine of the operator's orders |
//! | `client` | the access of cfclient and cflib: reading, setting, orders |
//! | [`hardware`] | faults of board and radio chip that forbid a take-off |
//! | `link` | the end of the radio link, shut or open |
//! | `mailbox` | reports and orders between link and agent |
//! | `localisation` | the position in the room, by a positioning system and the flow |
//! | `sensed` | the sensor values of a round |
//! | [`mounting`] | the rotation between board and nose |
//! | [`air`] | conversions between the agent's types and the messages on the air |
//! | [`probe`] | a static in which a firmware shows its drone's decisions to an emulator |
//! | [`replay`] | recorded packets through a drone, step by step, on host and chip alike |
//! | `words` | the values of an agent as words, for `probe` and `replay` |
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
mod config;
pub mod hardware;
mod link;
mod localisation;
mod mailbox;
pub mod mounting;
mod operator;
mod packets;
pub mod probe;
pub mod replay;
mod sensed;
mod setup;
mod view;
mod words;

use agent::{Agent, Fitness};
use airlink::{Identity, Seal};
use crtp::{Node, Parameters};
use storage::settings::Settings;
use units::{Instant, MissionKind, NODES, Order, Role, Setpoint};
use wire::p2p::{Beacon, MissionMessage};

use client::{Client, Orders};
use hardware::HardwareFault;
use link::{Heeded, Link};
use localisation::Localisation;
use mailbox::Mailbox;

pub use agent::{ChainDuty, Duty, Exploration, ExploreDuty, State, SwarmDuty};
pub use client::{Unsaved, observed};
pub use config::{Config, Unusable};
pub use crtp::Snapshot;
pub use link::LinkHealth;
pub use localisation::Fix;
pub use operator::Operator;
pub use sensed::Sensed;
pub use setup::{Keys, Setup, Start};

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

/// All code of one drone that does not depend on the chip. `S` seals its packets.
#[derive(Debug)]
pub struct Drone<S> {
    config: Config,
    identity: Identity,
    agent: Agent,
    link: Link<S>,
    mailbox: Mailbox,
    localisation: Localisation,
    orders: Orders,
    client: Client,
    heeded: Heeded,
    /// The fault of the hardware that keeps the drone on the ground, if there is one.
    hardware: Option<HardwareFault>,
    /// Whether clients may give orders through this drone, if it is the base.
    may_fly: bool,
    /// The last telemetry of each node, at the base.
    nodes: [Option<Node>; NODES],
    /// The outputs of the agent's last round.
    outputs: Option<agent::Outputs>,
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
    /// The function is `const`, so that a static can hold the drone: it is too large for a small
    /// stack, so a firmware does not move it, but changes the static in place by
    /// [`begin`](Self::begin).
    #[must_use]
    pub const fn switched_off() -> Self {
        let Settings { node, role, mission, .. } = Settings::DEFAULT;
        Self {
            config: Config::DEFAULT,
            identity: Identity { node, role },
            agent: Agent::new(node, role, mission),
            link: Link::NoKeys,
            mailbox: Mailbox::new(),
            localisation: Localisation::new(),
            orders: Orders::new(Operator::Silent),
            client: Client::new(Parameters::DEFAULT),
            heeded: Heeded::NONE,
            hardware: None,
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
        setup.renew(&mut self.agent);
        replace(&mut self.link, || Link::NoKeys);
        replace(&mut self.mailbox, Mailbox::new);
        replace(&mut self.localisation, Localisation::new);
        replace(&mut self.orders, || Orders::new(setup.operator()));
        replace(&mut self.client, || Client::new(setup.parameters(&config)));
        replace(&mut self.heeded, || Heeded::NONE);
        replace(&mut self.hardware, || None);
        replace(&mut self.may_fly, || false);
        replace(&mut self.nodes, || [None; NODES]);
        replace(&mut self.outputs, || None);
    }

    /// Notes where the drone is by a positioning system, for the next round. A drone of a chain does
    /// not ask for its position.
    pub fn fix(&mut self, now: Instant, fix: Fix) {
        if self.agent.mission() != MissionKind::Chain {
            self.localisation.fix(now, fix);
        }
    }

    /// Runs one round of the mission, 5 times a second, of a drone that does not explore.
    pub fn step(&mut self, now: Instant, sensed: &Sensed) -> Outputs {
        self.step_shown(now, sensed, None, |_, _| {})
    }

    /// Runs one round of the mission as [`Drone::step`] does, with the memory of a drone that explores
    /// (see [`Agent::step_exploring`]), and calls `show` with the inputs and the outputs of the agent.
    pub fn step_shown(
        &mut self,
        now: Instant,
        sensed: &Sensed,
        exploration: Option<&mut Exploration>,
        show: impl FnOnce(&agent::Inputs<'_>, &agent::Outputs),
    ) -> Outputs {
        self.attend(now);
        self.repeat_order(now);
        let sensed = Sensed { fitness: self.fitness(sensed.fitness), ..*sensed };
        if let Some(fix) = sensed.fix {
            self.fix(now, fix);
        }
        let located = self.localisation.step(now, sensed.velocity, sensed.heading);
        let order = self.order_of_round(now);
        let delay = self.config.mailbox_delay;
        let heard = self.mailbox.due(now, delay);
        let count = heard.len();
        let told = self.mailbox.due_told(now, delay);
        let told_count = told.len();
        let inputs = agent::Inputs {
            ranges: sensed.ranges,
            velocity: sensed.velocity,
            heading: sensed.heading,
            height: sensed.height,
            located,
            heard,
            told,
            order,
            fitness: sensed.fitness,
            endurance: sensed.endurance,
        };
        let config = &self.config.agent;
        let outputs = self.agent.step_exploring(config, now, &inputs, exploration);
        show(&inputs, &outputs);
        self.mailbox.forget(count);
        self.mailbox.forget_told(told_count);
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
        if let Some(order) = self.orders.order() {
            self.link.order(now, order);
        }
    }

    /// The order that the agent is given in this round.
    fn order_of_round(&mut self, now: Instant) -> Option<Order> {
        match (self.identity.role, self.orders.operator) {
            (_, Operator::Stopped) => Some(Order::Stop),
            (Role::Base, _) => self.orders.order(),
            (Role::Head | Role::Relay, _) => {
                self.mailbox.take_order(now, self.config.mailbox_delay)
            }
        }
    }

    /// A drone whose link is shut, or that was refused by the chain, does not take off: no order to
    /// land would reach it. Nor does one with a fault of its hardware.
    fn fitness(&self, machine: Fitness) -> Fitness {
        let is_bound = self.link_health() == LinkHealth::Fine && self.hardware.is_none();
        match machine {
            Fitness::Fit if !self.agent.state().is_airborne() && !is_bound => Fitness::Unfit,
            machine => machine,
        }
    }

    /// Hands report, telemetry and the mission's messages to the link.
    fn publish(&mut self, outputs: &agent::Outputs, sensed: &Sensed) {
        let role = self.identity.role;
        let Some(link) = self.link.open_mut() else { return };
        link.report(air::report_to_air(outputs));
        let mission = self.agent.mission();
        for payload in self.agent.messages() {
            link.tell(MissionMessage { mission, payload: *payload });
        }
        let state = outputs.status.state.code();
        link.beacon(Beacon { role, state, battery: sensed.battery });
        if role != Role::Base {
            link.telemeter(air::telemetry(outputs, sensed));
        }
    }
}
