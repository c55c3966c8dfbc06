//! The served chain without sockets and without a clock: a CRTP server for each drone, the
//! operator's desk, and the world that the drones fly in. The same datagrams at the same simulated
//! times make the same run.

use std::net::SocketAddr;

use agent::State;
use crtp::{Access, Event, OperatorTask, ParameterId, Parameters, Server, Setpoint};
use units::{Instant, MetresPerSecond, Order};

use super::World;
use super::desk::Desk;

/// The packets that one poll of a drone may send: more than a server's queues hold.
const BURST: usize = 64;

/// The null packet of CRTP: port 15, channel 3; bits 2 and 3 say nothing.
const NULL: u8 = 0xFF;
const NULL_MASK: u8 = 0xF3;

/// What was served.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Packets that came from clients.
    pub received: u64,
    /// Packets that went to clients.
    pub sent: u64,
    /// Orders that were given to the chain, each different from the one before.
    pub orders: u64,
}

/// Takes packets out: from which drone's port, to whom, and what.
pub(super) type Outbox<'a> = dyn FnMut(usize, SocketAddr, &[u8]) + 'a;

/// One drone's end of the radio link, kept as a Crazyflie keeps it while clients come and go.
struct Station {
    server: Server,
    parameters: Parameters,
    client: Option<SocketAddr>,
    /// The hints that the client was given already.
    said: Vec<Notice>,
}

/// A hint that a client is given once.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Notice {
    Sideways,
    Height,
    Limits,
}

impl Notice {
    const fn text(self) -> &'static str {
        match self {
            Self::Sideways => "Of a hover set-point only vx is flown: the chain steers itself.",
            Self::Height => "The height is kept, but the scenario's is flown.",
            Self::Limits => "The limits are kept, but the scenario's hold.",
        }
    }
}

/// A world with a CRTP server on every drone.
pub(super) struct Chain<W> {
    world: W,
    stations: Vec<Station>,
    desk: Desk,
    ordered: Option<Order>,
    tally: Tally,
}

impl<W: World> Chain<W> {
    pub(super) fn new(world: W) -> Self {
        let station = |member| Station {
            server: Server::new(),
            parameters: world.parameters(member),
            client: None,
            said: Vec::new(),
        };
        Self {
            stations: (0..world.members()).map(station).collect(),
            world,
            desk: Desk::default(),
            ordered: None,
            tally: Tally::default(),
        }
    }

    pub(super) fn now(&self) -> Instant {
        self.world.now()
    }

    pub(super) fn members(&self) -> usize {
        self.stations.len()
    }

    /// The client that a drone answers.
    pub(super) fn client(&self, member: usize) -> Option<SocketAddr> {
        self.stations.get(member)?.client
    }

    /// What the chain is ordered; `None` before the first order.
    pub(super) fn ordered(&self) -> Option<Order> {
        self.ordered
    }

    /// What each drone is doing, where it is known.
    pub(super) fn states(&self) -> impl Iterator<Item = (usize, State)> {
        let state = |member| Some((member, self.world.state(member)?));
        (0..self.stations.len()).filter_map(state)
    }

    pub(super) fn tally(&self) -> Tally {
        self.tally
    }

    pub(super) fn into_world(self) -> W {
        self.world
    }

    /// A datagram has arrived at a drone's port.
    pub(super) fn receive(
        &mut self,
        member: usize,
        from: SocketAddr,
        packet: &[u8],
        out: &mut Outbox<'_>,
    ) {
        let now = self.world.now();
        let (Some(station), Some(&header)) = (self.stations.get_mut(member), packet.first()) else {
            return;
        };
        self.tally.received += 1;
        // A scan does not take the drone from its client.
        if header & NULL_MASK == NULL & NULL_MASK {
            out(member, from, &[NULL]);
            self.tally.sent += 1;
            return;
        }
        if station.client.replace(from) != Some(from) {
            station.said.clear();
        }
        let event = station.server.receive(now, packet, Access::Full, &mut station.parameters);
        if let Some(event) = event {
            self.hear(member, now, event);
        }
        self.send(member, out);
    }

    /// One step of simulated time.
    pub(super) fn step(&mut self, out: &mut Outbox<'_>) {
        if let Some(task) = self.desk.task(self.world.now()) {
            self.tally.orders += u64::from(self.ordered != Some(task));
            self.ordered = Some(task);
            self.world.order(task);
        }
        self.world.advance();
        for member in 0..self.stations.len() {
            self.send(member, out);
        }
    }

    /// Acts on what a client wants.
    fn hear(&mut self, member: usize, now: Instant, event: Event) {
        match event {
            Event::Setpoint(Setpoint::Hover { forward, lateral, yaw_rate, .. }) => {
                self.desk.steer(now, forward);
                if lateral.0 != 0.0 || yaw_rate.0 != 0.0 {
                    self.notice(member, Notice::Sideways);
                }
            }
            Event::TakeOff => self.desk.steer(now, MetresPerSecond::ZERO),
            Event::Setpoint(Setpoint::Stop) | Event::Land => self.desk.order(Order::Land),
            Event::EmergencyStop => self.desk.order(Order::Stop),
            Event::EmergencyStopWatchdog => self.desk.feed_watchdog(now),
            // These drones are armed whenever they would fly, as the server has told the client.
            Event::Arm(_) => {}
            Event::ParameterSet(id) => self.parameter_set(member, id),
        }
    }

    fn parameter_set(&mut self, member: usize, id: ParameterId) {
        let Some(Station { parameters, .. }) = self.stations.get(member) else { return };
        let Parameters { task, speed, .. } = *parameters;
        let order = parameters.order();
        match id {
            ParameterId::TASK => self.desk.order(order),
            ParameterId::SPEED if task == OperatorTask::Explore => self.desk.change_speed(speed),
            ParameterId::HEIGHT => self.notice(member, Notice::Height),
            ParameterId::LAUNCH_LIMIT | ParameterId::RETREAT_LIMIT => {
                self.notice(member, Notice::Limits);
            }
            _ => {}
        }
        // There is one desk, whichever port it is looked at through.
        for Station { parameters, .. } in &mut self.stations {
            (parameters.task, parameters.speed) = (task, speed);
        }
    }

    fn notice(&mut self, member: usize, notice: Notice) {
        let Some(station) = self.stations.get_mut(member) else { return };
        if !station.said.contains(&notice) {
            station.said.push(notice);
            station.server.say(notice.text());
        }
    }

    /// Sends the packets of a drone to the client that spoke to it last.
    fn send(&mut self, member: usize, out: &mut Outbox<'_>) {
        let Some(station) = self.stations.get_mut(member) else { return };
        let Some(client) = station.client else { return };
        let now = self.world.now();
        let mut snapshot = self.world.snapshot(member);
        snapshot.radio.connected = true;
        for _ in 0..BURST {
            let Some(packet) = station.server.poll(now, &snapshot, &station.parameters) else {
                return;
            };
            out(member, client, packet.bytes());
            self.tally.sent += 1;
        }
    }
}
