//! Holds the served chain without sockets and without a clock: the world of the drones, and the
//! client of each drone. The same datagrams at the same simulated times give the same run.

use std::net::SocketAddr;

use onboard::State;
use units::{Instant, Order};

use super::World;
use super::polled::{NULL, is_null};
use crate::measure::trace::Node;

/// The counts of packets and orders of a served chain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// The number of packets from clients.
    pub received: u64,
    /// The number of packets to clients.
    pub sent: u64,
    /// The number of orders that were given to the chain, each different from the one before.
    pub orders: u64,
}

/// Takes outgoing packets: the drone whose port sends it, the receiver, and the bytes.
pub(super) type Outbox<'a> = dyn FnMut(usize, SocketAddr, &[u8]) + 'a;

/// A world, and the clients of its drones.
pub(super) struct Chain<W: World> {
    world: W,
    clients: Vec<Option<SocketAddr>>,
    ordered: Option<Order>,
    tally: Tally,
}

impl<W: World> Chain<W> {
    pub(super) fn new(world: W) -> Self {
        let clients = vec![None; world.nodes().len()];
        Self { world, clients, ordered: None, tally: Tally::default() }
    }

    pub(super) fn now(&self) -> Instant {
        self.world.now()
    }

    pub(super) fn nodes(&self) -> Vec<Node> {
        self.world.nodes()
    }

    /// The client that a drone answers.
    pub(super) fn client(&self, member: usize) -> Option<SocketAddr> {
        self.clients.get(member).copied().flatten()
    }

    /// The order that the base gives; `None` before the first order.
    pub(super) fn ordered(&self) -> Option<Order> {
        self.ordered
    }

    /// The state of each drone, where it is known.
    pub(super) fn states(&self) -> impl Iterator<Item = (usize, State)> {
        let state = |member| Some((member, self.world.state(member)?));
        (0..self.clients.len()).filter_map(state)
    }

    /// Whether the world cannot go on.
    pub(super) fn is_halted(&self) -> bool {
        self.world.is_halted()
    }

    pub(super) fn tally(&self) -> Tally {
        self.tally
    }

    pub(super) fn into_world(self) -> W {
        self.world
    }

    /// Takes a datagram that has arrived at a drone's port.
    pub(super) fn receive(
        &mut self,
        member: usize,
        from: SocketAddr,
        packet: &[u8],
        out: &mut Outbox<'_>,
    ) {
        let Some(client) = self.clients.get_mut(member) else { return };
        self.tally.received += 1;
        // A scan does not take the drone from its client.
        if is_null(packet) {
            out(member, from, &[NULL]);
            self.tally.sent += 1;
            return;
        }
        *client = Some(from);
        self.world.client(member, packet);
        self.count_order();
        self.send(member, out);
    }

    /// One step of simulated time.
    pub(super) fn step(&mut self, out: &mut Outbox<'_>) {
        self.world.advance();
        for member in 0..self.clients.len() {
            self.send(member, out);
        }
        self.count_order();
    }

    fn count_order(&mut self) {
        let ordered = self.world.ordered();
        if self.ordered != ordered {
            self.ordered = ordered;
            self.tally.orders += 1;
        }
    }

    /// Sends the packets of a drone to the client that spoke to it last.
    fn send(&mut self, member: usize, out: &mut Outbox<'_>) {
        let Some(client) = self.clients.get(member).copied().flatten() else { return };
        let sent = &mut self.tally.sent;
        self.world.poll_client(member, &mut |packet| {
            out(member, client, packet);
            *sent += 1;
        });
    }
}
