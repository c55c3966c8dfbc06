//! Detects the events that a served chain prints: clients that connect and disconnect, orders,
//! take-offs, landings and stops.

use std::fmt;
use std::net::SocketAddr;
use std::time::{Duration, Instant};

use agent::{LandReason, State};
use units::{Course, Order};

use mission::trace::{Node, order_words};

/// An event that is printed at the terminal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// Simulated time goes slower than requested, because the machine cannot keep up.
    Late,
    /// A client has connected to a drone.
    Connected(Node, SocketAddr),
    /// Two clients speak to one drone.
    Shared(Node, SocketAddr, SocketAddr),
    /// A client speaks to a drone that has newer ones, and is not served.
    Displaced(Node, SocketAddr),
    /// A drone has received nothing from its client for a while.
    Gone(Node, SocketAddr),
    /// The chain was given another order.
    Ordered(Order),
    /// A drone takes off.
    TakesOff(Node),
    /// A drone comes down where it is.
    Lands(Node, LandReason),
    /// A drone stands on the ground again.
    Landed(Node),
    /// A drone's motors were stopped.
    Stopped(Node),
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Late => f.write_str("this machine cannot keep up with --speed; time goes slower"),
            Self::Connected(drone, client) => write!(f, "{drone}: client {client} connected"),
            Self::Shared(drone, one, other) => write!(
                f,
                "{drone}: two clients are at one port, {one} and {other}; each gets its own answers \
                 and log rows, and of orders the newest counts"
            ),
            Self::Displaced(drone, client) => write!(
                f,
                "{drone}: two clients are at one port; the newer one is served, {client} is not until \
                 the other has gone"
            ),
            Self::Gone(drone, client) => {
                write!(f, "{drone}: client {client} gone, silent for {} s", SILENCE.as_secs())
            }
            Self::Ordered(order) => write!(f, "order: {}", order_words(*order)),
            Self::TakesOff(drone) => write!(f, "{drone}: takes off"),
            Self::Lands(drone, why) => match why {
                LandReason::Ordered => write!(f, "{drone}: lands, as ordered"),
                LandReason::Perched => write!(f, "{drone}: lands to relay from the ground"),
                LandReason::Done => write!(f, "{drone}: lands, its mission is done"),
                LandReason::Home => write!(f, "{drone}: lands at home"),
                LandReason::Retired => write!(f, "{drone}: lands at home, not needed for now"),
                LandReason::TakeOffFailed => write!(f, "{drone}: lands, its take-off failed"),
                LandReason::LinkLost => write!(f, "{drone}: lands, its link to the base is lost"),
                LandReason::Unfit(cause) => write!(f, "{drone}: lands, unfit to fly ({cause:?})"),
                LandReason::Restarted => write!(f, "{drone}: lands, it restarted in the air"),
                LandReason::PositionLost => write!(f, "{drone}: lands, its position is lost"),
            },
            Self::Landed(drone) => write!(f, "{drone}: landed"),
            Self::Stopped(drone) => write!(f, "{drone}: motors stopped"),
        }
    }
}

/// A client that is silent for so long is gone: UDP does not say so. cflib pings ten times a
/// second (cflib 0.1.34, link_statistics.py).
const SILENCE: Duration = Duration::from_secs(3);

/// A client of a drone.
#[derive(Clone, Copy, Debug)]
struct Client {
    address: SocketAddr,
    /// When the drone last heard it.
    heard: Instant,
    /// Whether it was told that the client is beside an older one, or there is no older one.
    is_told: bool,
}

/// Compares the chain with what it was before, and makes the events.
pub(super) struct Journal {
    nodes: Vec<Node>,
    /// For each drone the clients that speak to it, in the order in which they came.
    clients: Vec<Vec<Client>>,
    states: Vec<Option<State>>,
    ordered: Option<Order>,
}

impl Journal {
    pub(super) fn new(nodes: Vec<Node>) -> Self {
        let count = nodes.len();
        Self { nodes, clients: vec![Vec::new(); count], states: vec![None; count], ordered: None }
    }

    /// A drone has heard its client.
    ///
    /// That two clients are there shows when the older one speaks after the newer one has come: a
    /// script that is started again comes from another address, and the old one is silent.
    pub(super) fn heard(&mut self, place: usize, from: SocketAddr, now: Instant) -> Option<Event> {
        let drone = *self.nodes.get(place)?;
        let clients = self.clients.get_mut(place)?;
        let Some(known) = clients.iter().position(|client| client.address == from) else {
            clients.push(Client { address: from, heard: now, is_told: clients.is_empty() });
            return Some(Event::Connected(drone, from));
        };
        let (_, later) = clients.split_at_mut(known);
        let (client, later) = later.split_first_mut()?;
        client.heard = now;
        let newer = later.iter_mut().find(|newer| !newer.is_told)?;
        newer.is_told = true;
        Some(Event::Shared(drone, from, newer.address))
    }

    /// A client speaks whose place a newer one has.
    pub(super) fn displaced(&mut self, place: usize, from: SocketAddr) -> Option<Event> {
        let clients = self.clients.get_mut(place)?;
        clients.retain(|client| client.address != from);
        if let Some(first) = clients.first_mut() {
            first.is_told = true;
        }
        Some(Event::Displaced(*self.nodes.get(place)?, from))
    }

    /// The place and the drone of a client that has been silent for too long, if there is one.
    pub(super) fn gone(&mut self, now: Instant) -> Option<(usize, Node, SocketAddr)> {
        let is_silent = |client: &Client| now.saturating_duration_since(client.heard) > SILENCE;
        let (place, which) = self
            .clients
            .iter()
            .enumerate()
            .find_map(|(place, clients)| Some((place, clients.iter().position(is_silent)?)))?;
        let clients = self.clients.get_mut(place)?;
        let Client { address, .. } = clients.remove(which);
        if let Some(first) = clients.first_mut() {
            first.is_told = true;
        }
        Some((place, *self.nodes.get(place)?, address))
    }

    /// Takes the order that stands now. A change of speed alone is not an event: a stick moves all
    /// the time.
    pub(super) fn ordered(&mut self, order: Option<Order>) -> Option<Event> {
        let order = order?;
        let before = self.ordered.replace(order);
        before.is_none_or(|before| kind(before) != kind(order)).then_some(Event::Ordered(order))
    }

    /// Takes the state of a drone.
    pub(super) fn doing(&mut self, place: usize, state: State) -> Option<Event> {
        let before = self.states.get_mut(place)?.replace(state)?;
        let drone = *self.nodes.get(place)?;
        let is_new = before.name() != state.name();
        match state {
            _ if !is_new => None,
            State::TakingOff { .. } | State::Rising { .. } => Some(Event::TakesOff(drone)),
            State::Landing { why, .. } => Some(Event::Lands(drone, why)),
            State::Landed { .. } | State::Perched => Some(Event::Landed(drone)),
            State::Stopped => Some(Event::Stopped(drone)),
            State::Idle | State::Armed { .. } | State::OnMission(_) => None,
        }
    }
}

/// The order without its speed, but with its direction.
fn kind(order: Order) -> (core::mem::Discriminant<Order>, i8) {
    let way = match order {
        Order::Explore(Course { speed, .. }) if speed.0 > 0.0 => 1,
        Order::Explore(Course { speed, .. }) if speed.0 < 0.0 => -1,
        _ => 0,
    };
    (core::mem::discriminant(&order), way)
}

#[cfg(test)]
mod tests {
    use units::{MetresPerSecond, MissionKind, NodeId, Role};

    use super::*;

    const HEAD: Node = Node { id: NodeId(0), role: Role::Head, mission: MissionKind::Chain };
    const RELAY: Node = Node { id: NodeId(1), role: Role::Relay, mission: MissionKind::Chain };
    const BASE: Node = Node { id: NodeId(2), role: Role::Base, mission: MissionKind::Chain };

    fn journal() -> Journal {
        Journal::new(vec![HEAD, RELAY, BASE])
    }

    fn client(port: u16) -> SocketAddr {
        ([127, 0, 0, 1], port).into()
    }

    #[test]
    fn a_client_is_told_when_it_comes_and_when_it_has_gone() {
        let (mut journal, start) = (journal(), Instant::now());
        let at = |ms| start + Duration::from_millis(ms);
        let connected = |port| Some(Event::Connected(HEAD, client(port)));
        assert_eq!(journal.heard(0, client(1), at(0)), connected(1));
        assert_eq!(journal.heard(0, client(1), at(2_000)), None);
        assert_eq!(journal.gone(at(5_000)), None);
        assert_eq!(journal.gone(at(5_001)), Some((0, HEAD, client(1))));
        assert_eq!(journal.gone(at(9_000)), None);
        assert_eq!(journal.heard(0, client(2), at(9_000)), connected(2));
        assert_eq!(journal.heard(7, client(2), at(9_000)), None);
    }

    /// Also when they speak in turn for long, and when a third one comes.
    #[test]
    fn two_clients_at_one_port_are_told_once() {
        let (mut journal, start) = (journal(), Instant::now());
        let mut told = Vec::new();
        for n in 0..200 {
            let at = start + Duration::from_millis(50 * n);
            for port in [1, 2, 3] {
                if port < 3 || n > 100 {
                    told.extend(journal.heard(0, client(port), at));
                }
            }
            assert_eq!(journal.gone(at), None);
        }
        let connected = |port| Event::Connected(HEAD, client(port));
        let shared = |port| Event::Shared(HEAD, client(1), client(port));
        assert_eq!(told, [connected(1), connected(2), shared(2), connected(3), shared(3)]);
    }

    #[test]
    fn a_script_that_is_started_again_at_once_is_not_told_as_two_clients() {
        let (mut journal, start) = (journal(), Instant::now());
        let at = |ms| start + Duration::from_millis(ms);
        journal.heard(0, client(1), at(0));
        assert_eq!(journal.heard(0, client(2), at(100)), Some(Event::Connected(HEAD, client(2))));
        assert_eq!(journal.heard(0, client(2), at(3_001)), None);
        assert_eq!(journal.gone(at(3_001)), Some((0, HEAD, client(1))));
        assert_eq!(journal.heard(0, client(2), at(3_100)), None);
        assert_eq!(journal.gone(at(3_100)), None);
    }

    #[test]
    fn a_stick_that_moves_a_little_is_not_told() {
        let mut journal = journal();
        let explore = |speed| Order::explore(MetresPerSecond(speed));
        let orders = [0.2, 0.3, 0.0, -0.1].map(explore);
        let told = orders.map(|order| journal.ordered(Some(order)).is_some());
        assert_eq!(told, [true, false, true, true]);
        assert_eq!(journal.ordered(Some(Order::Stop)), Some(Event::Ordered(Order::Stop)));
        assert_eq!(journal.ordered(None), None);
    }

    #[test]
    fn a_flight_is_told_from_take_off_to_landing() {
        let mut journal = journal();
        let since = units::Instant::ZERO;
        let why = LandReason::Ordered;
        let states = [
            State::Idle,
            State::TakingOff { since },
            State::Landing { since, why },
            State::Landed { why },
            State::Landed { why },
        ];
        let told: Vec<_> = states.into_iter().filter_map(|state| journal.doing(0, state)).collect();
        let lands = Event::Lands(HEAD, why);
        assert_eq!(told, [Event::TakesOff(HEAD), lands, Event::Landed(HEAD)]);
    }
}
