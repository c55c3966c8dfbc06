//! The client's side of a drone: what cfclient and cflib may look at, set and order, and what
//! becomes of it.
//!
//! | the drone | may be read | may be set | may give orders | may be stopped |
//! |---|---|---|---|---|
//! | the base, provisioned for it | yes | yes | yes | with all others |
//! | any other base | yes | no | no | with all others |
//! | any other with keys | yes | no | no | itself |
//! | one without keys, which does not fly | yes | yes | no drone hears it | itself |
//!
//! CRTP has no authentication: anybody with a Crazyradio may say what he likes. So no drone is
//! steered by it. The base makes orders of what a client asks for, and these go to the drones
//! sealed. An emergency stop is taken from every client by every node.

use airlink::{Identity, Seal};
use crtp::{
    Access, Event, Notice, Outcome, Packet, ParameterId, Parameters, Radio, Server, Setpoint,
    Snapshot,
};
use units::{Dbm, Instant, Metres, MetresPerSecond, Order, Role};

use crate::link::{Link, LinkHealth};
use crate::operator::{CLIENT_GONE, Operator, Request, Watchdog};
use crate::{Drone, mounting};

/// A hover set-point that names a height as far off the drone's own asks for another.
const OTHER_HEIGHT: Metres = Metres(0.1);

/// What a client has set that the drone is to remember while it is switched off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Unsaved {
    /// The flying height.
    pub height: Option<Metres>,
    /// The limits at which a relay is launched and at which a drone backs up.
    pub limits: Option<[Dbm; 2]>,
}

/// A client, and what it has been told.
#[derive(Debug)]
pub(crate) struct Client {
    server: Server,
    pub(crate) parameters: Parameters,
    /// When the client was last heard.
    heard: Option<Instant>,
    packets: u32,
    /// The agent's state that the console has told last.
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
    watchdog: Watchdog,
    unsaved: Unsaved,
}

impl Orders {
    pub(crate) fn new(operator: Operator) -> Self {
        Self { operator, watchdog: Watchdog::default(), unsaved: Unsaved::default() }
    }

    /// Does what a client asks for.
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
            // A speed is taken up by the next order to explore.
            Event::ParameterSet(_) => Outcome::Done,
        };
        if let Some(order) = self.operator.order() {
            parameters.show(order);
        }
        outcome
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
        let stands = next.order().is_none_or(|order| link.order(now, order));
        if stands || stops {
            self.operator = next;
        }
        if stands { Outcome::Done } else { Outcome::Refused(Notice::NotHeard) }
    }
}

impl<S: Seal> Drone<S> {
    /// Takes a packet of a client: header and data.
    pub fn client(&mut self, now: Instant, packet: &[u8]) {
        let access = self.access();
        if !self.client.is_there(now) {
            self.client.told_state = None;
            self.client.server.say(greeting(self.link.health()));
        }
        let Self { client, orders, link, identity, .. } = self;
        client.packets = client.packets.wrapping_add(1);
        client.heard = Some(now);
        client.server.receive(now, packet, access, &mut client.parameters, |event, parameters| {
            orders.act(now, event, parameters, *identity, link)
        });
    }

    /// The packet that is sent to the client next, if there is one. `snapshot` comes from
    /// [`Drone::snapshot`].
    pub fn poll_client(&mut self, now: Instant, snapshot: &Snapshot) -> Option<Packet> {
        self.client.server.poll(now, snapshot, &self.client.parameters)
    }

    /// When the next log block of the client is due.
    #[must_use]
    pub fn client_due(&self) -> Option<Instant> {
        self.client.server.due()
    }

    /// Tells the client something on its console.
    pub fn say(&mut self, line: &str) {
        self.client.server.say(line);
    }

    /// What there is to look at. The caller fills in what it has measured, such as by
    /// [`observed`], and how the radio heard the client; the drone adds the rest.
    #[must_use]
    pub fn snapshot(&self, now: Instant, measured: &Snapshot) -> Snapshot {
        let mut snapshot = Snapshot { taken: now, ..*measured };
        if let Some(outputs) = &self.outputs {
            snapshot.state = Some(outputs.status.state);
            snapshot.front = outputs.status.front;
            snapshot.back = outputs.status.back;
            snapshot.odometer = outputs.status.odometer;
            snapshot.along = outputs.report.velocity;
            snapshot.recalled = outputs.report.recall;
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

    /// What clients may look at and set.
    #[must_use]
    pub const fn parameters(&self) -> &Parameters {
        &self.client.parameters
    }

    /// Tells clients which decks are there.
    pub const fn note_decks(&mut self, flow: bool, rangers: bool) {
        let about = &mut self.client.parameters.about;
        about.has_flow = flow;
        about.has_rangers = rangers;
        about.selftest_passed = flow && rangers;
    }

    /// What clients have set since this was last asked, for the drone to remember.
    pub fn take_unsaved(&mut self) -> Unsaved {
        core::mem::take(&mut self.orders.unsaved)
    }

    /// Takes an order of an operator who speaks by something else than CRTP. An order to explore is
    /// a pilot's stick, which must say it again and again; every other order holds until the next.
    /// Returns whether the order stands: it does at the base alone, unless a stop stands there.
    pub fn order(&mut self, now: Instant, order: Order) -> bool {
        let request = match order {
            Order::Explore(speed) => Request::Setpoint(speed),
            Order::Wait | Order::Return | Order::Land | Order::Stop => Request::Order(order),
        };
        self.orders.ask(now, request, self.identity, &mut self.link) == Outcome::Done
    }

    /// Does what passing time brings: set-points grow old, clients vanish, a watchdog starves. To
    /// be called often; [`Drone::step`] does it too.
    pub fn attend(&mut self, now: Instant) {
        let has_client = self.client.is_there(now);
        let Self { orders, link, identity, client, .. } = self;
        if orders.watchdog.is_starved(now) {
            orders.watchdog = Watchdog::default();
            orders.ask(now, Request::Order(Order::Stop), *identity, link);
            client.parameters.show(Order::Stop);
        }
        let next = orders.operator.at(now, has_client);
        if next != orders.operator {
            orders.operator = next;
            if let Some(order) = next.order() {
                link.order(now, order);
            }
        }
        let state = self.agent.state();
        if has_client && client.told_state != Some(state.code()) {
            client.told_state = Some(state.code());
            client.server.say(state.name());
        }
    }

    /// What a client may do.
    fn access(&self) -> Access {
        match self.link.health() {
            LinkHealth::NoKeys => Access::Full,
            _ if self.may_fly && self.identity.role == Role::Base => Access::Full,
            LinkHealth::Fine | LinkHealth::Shut | LinkHealth::Out => Access::Read,
        }
    }
}

/// What a client is told first.
const fn greeting(health: LinkHealth) -> &'static str {
    match health {
        LinkHealth::Fine => "The link of the chain is open.",
        LinkHealth::NoKeys => "This drone has no keys: it does not fly.",
        LinkHealth::Shut => "This drone cannot use its keys: it does not fly.",
        LinkHealth::Out => "The chain has refused this drone: it does not fly.",
    }
}

/// What there is to look at of a board's flight code.
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
