//! Handles a drone's clients: the values that cfclient and cflib may read and set, and the orders
//! that they may give.
//!
//! | the drone | may be read | may be set | may give orders | may be stopped |
//! |---|---|---|---|---|
//! | the base, provisioned for it | yes | yes | yes | with all others |
//! | any other base | yes | no | no | with all others |
//! | any other with keys | yes | no | no | itself |
//! | one without keys, which does not fly | yes | yes | no, since no drone would hear it | itself |
//!
//! CRTP has no authentication: every Crazyradio can send its packets. So no drone is controlled by
//! CRTP directly. The base turns a client's requests into orders, which are sealed for the drones.
//! Every node obeys an emergency stop from any client.

use agent::{Agent, AgentConfig, LandReason, State};
use airlink::{Identity, Seal};
use chain::policy::Policy;
use crtp::{
    Access, Event, Node, Notice, Outcome, Packet, ParameterId, Parameters, Radio, Server, Setpoint,
    Snapshot, Variance,
};
use units::{
    Branch, Course, Dbm, Duration, Instant, Metres, MetresPerSecond, MissionKind, Order, Point2,
    PolicyCode, Role,
};
use wire::crtp::Port;
use wire::syslink::Release;

use crate::hardware::HardwareFault;
use crate::link::{Link, LinkHealth};
use crate::operator::{CLIENT_GONE, Operator, Request, Watchdog};
use crate::{Drone, Fix, mounting};

/// A hover set-point whose height differs from the drone's by more asks for another height.
const OTHER_HEIGHT: Metres = Metres(0.1);

/// A head that is on the ground by what it says so long after the order to explore stays there. It
/// is longer than an order and its answer take over a chain; our own number.
const TAKES_OFF: Duration = Duration::from_secs(3);

/// The variance of the height over ground, m²: that of one reading of the ranger that looks down.
const OF_HEIGHT: f32 = flight::DownConfig::VL53L1X.noise * flight::DownConfig::VL53L1X.noise;

/// Settings that a client has changed and the drone must store.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unsaved {
    /// The flying height.
    pub height: Option<Metres>,
    /// The limits at which a relay is launched and at which a drone backs up.
    pub limits: Option<[Dbm; 2]>,
    /// The movement policy.
    pub policy: Option<PolicyCode>,
}

impl Unsaved {
    /// The value when no client has changed a setting.
    pub const NONE: Self = Self { height: None, limits: None, policy: None };
}

/// The server for clients, and its state between requests.
#[derive(Debug)]
pub(crate) struct Client {
    server: Server,
    pub(crate) parameters: Parameters,
    /// When the client was last heard.
    heard: Option<Instant>,
    packets: u32,
    /// The agent's state that the console has printed last.
    told_state: Option<u8>,
}

impl Client {
    pub(crate) const fn new(parameters: Parameters) -> Self {
        Self { server: Server::new(), parameters, heard: None, packets: 0, told_state: None }
    }

    fn is_there(&self, now: Instant) -> bool {
        self.heard.is_some_and(|at| now.since(at) < CLIENT_GONE)
    }
}

/// The orders of the operator, at any node.
#[derive(Debug)]
pub(crate) struct Orders {
    pub(crate) operator: Operator,
    /// The pilot's choice for the junctions that the head comes to.
    branch: Option<Branch>,
    watchdog: Watchdog,
    unsaved: Unsaved,
    /// Since when the operator wants the head to fly; `None` where the newest order is another.
    flies_since: Option<Instant>,
}

impl Orders {
    pub(crate) const fn new(operator: Operator) -> Self {
        Self {
            operator,
            branch: None,
            watchdog: Watchdog::UNFED,
            unsaved: Unsaved::NONE,
            flies_since: None,
        }
    }

    /// Follows a request of a client.
    fn act<S: Seal>(
        &mut self,
        now: Instant,
        event: Event,
        parameters: &mut Parameters,
        identity: Identity,
        link: &mut Link<S>,
    ) -> Outcome {
        let explores = matches!(self.operator, Operator::Explore(_));
        let mut ask = |request| self.ask(now, request, identity, link);
        let outcome = match event {
            Event::EmergencyStop => ask(Request::Order(Order::Stop)),
            Event::EmergencyStopWatchdog => {
                self.watchdog.feed(now);
                Outcome::Done
            }
            Event::Setpoint(Setpoint::Stop) | Event::Land => ask(Request::Order(Order::Land)),
            Event::TakeOff => ask(Request::Setpoint(MetresPerSecond::ZERO)),
            Event::Setpoint(Setpoint::Hover { forward, lateral, yaw_rate, height }) => {
                let other = (height - parameters.height).0.abs() > OTHER_HEIGHT.0;
                match ask(Request::Setpoint(forward)) {
                    Outcome::Done if other || lateral.0 != 0.0 || yaw_rate.0 != 0.0 => {
                        Outcome::DoneBut(Notice::OnlyForward)
                    }
                    outcome => outcome,
                }
            }
            Event::ParameterSet(ParameterId::TASK) => ask(Request::Order(parameters.order())),
            Event::ParameterSet(ParameterId::BRANCH) => ask(Request::Branch(parameters.branch)),
            Event::ParameterSet(ParameterId::SPEED) if explores => {
                ask(Request::Speed(parameters.speed))
            }
            Event::ParameterSet(ParameterId::HEIGHT) => {
                self.unsaved.height = Some(parameters.height);
                Outcome::DoneBut(Notice::NextBoot)
            }
            Event::ParameterSet(ParameterId::LAUNCH_LIMIT | ParameterId::RETREAT_LIMIT) => {
                self.unsaved.limits = Some([parameters.launch_limit, parameters.retreat_limit]);
                Outcome::DoneBut(Notice::NextBoot)
            }
            // A speed is taken up by the next order to explore. Positions are no orders.
            Event::ParameterSet(_) | Event::Position(_) | Event::ResetEstimate => Outcome::Done,
        };
        if let Some(order) = self.order() {
            parameters.show(order);
        }
        outcome
    }

    /// The order that the base gives; `None` while the operator has not asked for anything.
    pub(crate) fn order(&self) -> Option<Order> {
        with_branch(self.operator, self.branch)
    }

    /// Whether the head, by its telemetry, stays on the ground although it was ordered to fly.
    fn head_stands(&mut self, now: Instant, head: Option<Node>) -> bool {
        if !matches!(self.order(), Some(Order::Explore(_))) {
            self.flies_since = None;
            return false;
        }
        let since = *self.flies_since.get_or_insert(now);
        let Some(Node { telemetry, heard }) = head else { return false };
        let [idle, landed] = [State::Idle, State::Landed { why: LandReason::Ordered }];
        let is_out = [landed.code(), State::Stopped.code()].contains(&telemetry.state);
        let is_unfit = telemetry.state == idle.code() && telemetry.fault != 0;
        (is_out || is_unfit) && heard.since(since) > TAKES_OFF
    }

    /// Gives a drone on the ground another movement policy, and notes it for storing.
    fn choose(
        &mut self,
        code: Option<PolicyCode>,
        agent: &Agent,
        config: &mut AgentConfig,
    ) -> Outcome {
        let Some(policy) = code.and_then(Policy::with_code) else {
            return Outcome::Refused(Notice::NoSuchPolicy);
        };
        if agent.state().is_airborne() {
            return Outcome::Refused(Notice::Airborne);
        }
        config.policy = policy.config;
        self.unsaved.policy = code;
        Outcome::Done
    }

    /// Takes a request, and gives the order that follows from it. A stop is taken in any case: by
    /// a drone for itself, by the base for all.
    pub(crate) fn ask<S: Seal>(
        &mut self,
        now: Instant,
        request: Request,
        identity: Identity,
        link: &mut Link<S>,
    ) -> Outcome {
        let stops = request == Request::Order(Order::Stop);
        if self.operator == Operator::Stopped && !stops {
            return Outcome::Refused(Notice::StopStands);
        }
        if identity.role != Role::Base {
            if !stops {
                return Outcome::Refused(Notice::NotHeard);
            }
            self.operator = Operator::Stopped;
            return Outcome::Done;
        }
        let next = self.operator.after(now, request);
        let branch = request.branch().unwrap_or(self.branch);
        let order = with_branch(next, branch);
        let stands = order.is_none_or(|order| link.order(now, order));
        if stands || stops {
            (self.operator, self.branch) = (next, branch);
        }
        if stands { Outcome::Done } else { Outcome::Refused(Notice::NotHeard) }
    }
}

/// The order of this operator, with this choice for junctions.
fn with_branch(operator: Operator, branch: Option<Branch>) -> Option<Order> {
    operator.order().map(|order| match order {
        Order::Explore(course) => Order::Explore(Course { branch, ..course }),
        Order::Wait | Order::Return | Order::Land | Order::Perch | Order::Stop => order,
    })
}

impl<S: Seal> Drone<S> {
    /// Processes a packet of a client, which consists of header and data.
    pub fn client(&mut self, now: Instant, packet: &[u8]) {
        let access = self.access();
        self.client.parameters.about.takes_orders = self.takes_orders();
        // A positioning system sends on when the client is gone, and reads no console.
        if !is_of_positions(packet) {
            if !self.client.is_there(now) {
                self.client.told_state = None;
                self.client.server.say(greeting(self.link.health()));
                self.say_hardware();
            }
            self.client.heard = Some(now);
        }
        let Self { client, orders, link, identity, agent, config, localisation, .. } = self;
        client.packets = client.packets.wrapping_add(1);
        let mission = agent.mission();
        client.server.receive(now, packet, access, &mut client.parameters, |event, parameters| {
            if let Event::Position(fix) = event {
                if mission != MissionKind::Chain {
                    localisation.fix(now, by_client(fix));
                }
                return Outcome::Done;
            }
            if event == Event::ResetEstimate {
                if agent.state().is_airborne() {
                    return Outcome::Refused(Notice::EstimateFlies);
                }
                localisation.forget();
                return Outcome::Done;
            }
            if event == Event::ParameterSet(ParameterId::POLICY) {
                return orders.choose(parameters.policy, agent, &mut config.agent);
            }
            orders.act(now, event, parameters, *identity, link)
        });
    }

    /// Returns the next packet to the client, if there is one. `snapshot` comes from
    /// [`Drone::snapshot`].
    pub fn poll_client(&mut self, now: Instant, snapshot: &Snapshot) -> Option<Packet> {
        self.client.server.poll(now, snapshot, &self.client.parameters)
    }

    /// The time at which the next log block of the client is due.
    #[must_use]
    pub fn client_due(&self) -> Option<Instant> {
        self.client.server.due()
    }

    /// Prints a line on the client's console.
    pub fn say(&mut self, line: &str) {
        self.client.server.say(line);
    }

    /// Notes the fault of the hardware that keeps the drone on the ground, or that there is none. A
    /// new one is printed on the client's console.
    pub fn note_hardware(&mut self, fault: Option<HardwareFault>) {
        if fault != self.hardware {
            self.hardware = fault;
            self.say_hardware();
        }
    }

    /// Notes the release of the radio chip's firmware, for clients to read.
    pub const fn note_radio(&mut self, release: Option<Release>) {
        self.client.parameters.about.radio = release;
    }

    fn say_hardware(&mut self) {
        if let Some(fault) = self.hardware {
            self.client.server.say(fault.words());
        }
    }

    /// The fault of the hardware that keeps the drone on the ground, if there is one.
    #[must_use]
    pub const fn hardware(&self) -> Option<HardwareFault> {
        self.hardware
    }

    /// The values of all log variables. `measured` holds the caller's measurements, for example by
    /// [`observed`], and the radio's state; the drone adds the other values.
    #[must_use]
    pub fn snapshot(&self, now: Instant, measured: &Snapshot) -> Snapshot {
        let mut snapshot = Snapshot { taken: now, ..*measured };
        if let Some(outputs) = &self.outputs {
            snapshot.state = Some(outputs.status.state);
            snapshot.front = outputs.status.front;
            snapshot.back = outputs.status.back;
            snapshot.odometer = outputs.status.here.odometer;
            snapshot.position = outputs.status.here.pose.at;
            snapshot.along = outputs.report.velocity;
            snapshot.recalled = outputs.report.recall;
        }
        snapshot.variance = self.variance(snapshot.odometer, snapshot.height);
        if let Some((place, _)) = self.localisation.place() {
            snapshot.position = place;
        }
        if self.takes_orders() {
            // Clients that want to fly ask the base whether it can, and mean its chain.
            snapshot.mode = None;
        }
        snapshot.radio = Radio {
            connected: self.client.is_there(now),
            unicasts: self.client.packets,
            ..measured.radio
        };
        snapshot.link = self.link.told(self.heeded.count);
        snapshot.nodes = self.nodes;
        snapshot
    }

    /// How well the drone knows where it is. A drone of a chain reckons from its take-off, and the
    /// base does not move.
    fn variance(&self, odometer: Metres, height: Option<Metres>) -> Variance {
        if self.identity.role == Role::Base {
            return Variance::ORIGIN;
        }
        let place = match (self.agent.mission(), self.localisation.place()) {
            (_, Some((_, variance))) => variance,
            (MissionKind::Chain, None) => {
                let deviation = agent::odometer_deviation(odometer).0;
                deviation * deviation
            }
            (MissionKind::Swarm | MissionKind::Explore, None) => f32::INFINITY,
        };
        let is_known = height.is_some() || !self.agent.state().is_airborne();
        Variance { place, height: if is_known { OF_HEIGHT } else { f32::INFINITY } }
    }

    /// The parameters.
    #[must_use]
    pub const fn parameters(&self) -> &Parameters {
        &self.client.parameters
    }

    /// Records which decks are present, for clients to read.
    pub const fn note_decks(&mut self, flow: bool, rangers: bool) {
        let about = &mut self.client.parameters.about;
        about.has_flow = flow;
        about.has_rangers = rangers;
        about.selftest_passed = flow && rangers;
    }

    /// Takes the settings that clients have changed since the last call, for the caller to store.
    pub fn take_unsaved(&mut self) -> Unsaved {
        core::mem::replace(&mut self.orders.unsaved, Unsaved::NONE)
    }

    /// Takes an operator's order that does not come by CRTP. An order to explore counts as a
    /// reading of the pilot's stick, which must be repeated; every other order is valid until the
    /// next. Returns whether the order is accepted: only the base accepts orders, and none after a
    /// stop.
    pub fn order(&mut self, now: Instant, order: Order) -> bool {
        let request = match order {
            Order::Explore(Course { speed, branch }) => Request::Stick { speed, branch },
            Order::Wait | Order::Return | Order::Land | Order::Perch | Order::Stop => {
                Request::Order(order)
            }
        };
        self.orders.ask(now, request, self.identity, &mut self.link) == Outcome::Done
    }

    /// Ends set-points that are too old and orders of clients that are gone, and stops the motors
    /// when the emergency stop's watchdog was not fed. The caller should call it often;
    /// [`Drone::step`] calls it, too.
    pub fn attend(&mut self, now: Instant) {
        let has_client = self.client.is_there(now);
        let Self { orders, link, identity, client, nodes, agent, .. } = self;
        if orders.watchdog.is_starved(now) {
            orders.watchdog = Watchdog::UNFED;
            orders.ask(now, Request::Order(Order::Stop), *identity, link);
            client.parameters.show(Order::Stop);
        }
        let next = orders.operator.at(now, has_client);
        if next != orders.operator {
            orders.operator = next;
            if let Some(order) = orders.order() {
                link.order(now, order);
            }
        }
        let is_of_chain = agent.mission() == MissionKind::Chain && identity.role == Role::Base;
        let head = nodes.first().copied().flatten();
        if is_of_chain && orders.head_stands(now, head) && has_client {
            client.server.notice(Notice::HeadStands);
        }
        if has_client && agent.is_blind() {
            client.server.notice(Notice::Reckoned);
        }
        let state = agent.state();
        if has_client && client.told_state != Some(state.code()) {
            client.told_state = Some(state.code());
            client.server.say(state.name());
        }
    }

    /// Whether the drone is a base that turns the requests of clients into orders.
    fn takes_orders(&self) -> bool {
        let has_keys = !matches!(self.link.health(), LinkHealth::NoKeys);
        has_keys && self.may_fly && self.identity.role == Role::Base
    }

    /// The access of a client.
    fn access(&self) -> Access {
        match self.link.health() {
            LinkHealth::NoKeys => Access::Full,
            _ if self.takes_orders() => Access::Full,
            LinkHealth::Fine | LinkHealth::Shut | LinkHealth::Out => Access::Read,
        }
    }
}

/// The position that a client sends, in the axes of the nose.
fn by_client(fix: wire::crtp::Fix) -> Fix {
    let [x, y, _] = fix.at;
    let yaw = fix.yaw.map(mounting::heading);
    Fix { at: Point2::new(x.0, y.0), yaw, deviation: Fix::BY_CLIENT }
}

/// Whether a packet is on the port of positions.
fn is_of_positions(packet: &[u8]) -> bool {
    Packet::from_bytes(packet).is_ok_and(|packet| packet.port() == Ok(Port::Localization))
}

/// The first line on the console.
const fn greeting(health: LinkHealth) -> &'static str {
    match health {
        LinkHealth::Fine => "The link of the chain is open.",
        LinkHealth::NoKeys => "This drone has no keys: it does not fly.",
        LinkHealth::Shut => "This drone cannot use its keys: it does not fly.",
        LinkHealth::Out => "The chain has refused this drone: it does not fly.",
    }
}

/// Returns the log variables that follow from the status of a board's flight code.
#[must_use]
pub fn observed(status: &flight::Status) -> Snapshot {
    Snapshot {
        mode: Some(status.mode),
        attitude: status.attitude,
        velocity: status.velocity.map(mounting::from_board),
        height: status.height,
        volts: Some(status.battery.volts),
        endurance: status.battery.endurance,
        ..Snapshot::DEFAULT
    }
}
