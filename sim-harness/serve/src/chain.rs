//! Holds the served chain without sockets and without a clock: the world of the drones, and the
//! client of each drone. The same datagrams at the same simulated times give the same run.

use std::net::SocketAddr;

use bridge::{NULL, is_null};
use onboard::State;
use units::{Instant, Order};

use super::World;
use super::clients::{Asker, Clients, IS_RESET, Renumbered, Step, Taken, delete, is_of_control};
use mission::trace::Node;

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
    clients: Vec<Clients>,
    ordered: Option<Order>,
    tally: Tally,
}

impl<W: World> Chain<W> {
    pub(super) fn new(world: W) -> Self {
        let members = 0..world.nodes().len();
        let clients = members.map(|member| Clients::new(world.most_clients(member))).collect();
        Self { world, clients, ordered: None, tally: Tally::default() }
    }

    pub(super) fn now(&self) -> Instant {
        self.world.now()
    }

    pub(super) fn nodes(&self) -> Vec<Node> {
        self.world.nodes()
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
    ) -> Taken {
        let Some(clients) = self.clients.get_mut(member) else { return Taken::NoClient };
        self.tally.received += 1;
        // A scan makes no client.
        if is_null(packet) {
            self.put(member, from, &[NULL], out);
            return Taken::NoClient;
        }
        let (taken, orphans) = clients.admit(from, packet);
        let step = match taken {
            Taken::Client => clients.step(packet),
            Taken::NoClient => Step::Give(packet.to_owned(), None),
            Taken::Displaced { .. } if Clients::is_open_to_all(packet) => {
                Step::Give(packet.to_owned(), None)
            }
            Taken::Displaced { .. } => return taken,
        };
        self.delete(member, &orphans, out);
        match step {
            Step::Give(bytes, block) => self.give(member, from, &bytes, block, out),
            Step::DeleteOwn(blocks) => {
                self.delete(member, &blocks, out);
                self.put(member, from, &IS_RESET, out);
            }
        }
        taken
    }

    /// Takes that a client of a drone is gone.
    pub(super) fn gone(&mut self, member: usize, from: SocketAddr, out: &mut Outbox<'_>) {
        let Some(clients) = self.clients.get_mut(member) else { return };
        let orphans = clients.gone(from);
        self.delete(member, &orphans, out);
    }

    /// One step of simulated time.
    pub(super) fn step(&mut self, out: &mut Outbox<'_>) {
        self.world.advance();
        for member in 0..self.clients.len() {
            self.send(member, Asker::Newest, out);
        }
        self.count_order();
    }

    /// Gives a drone a packet of a client, and sends what it answers.
    fn give(
        &mut self,
        member: usize,
        from: SocketAddr,
        packet: &[u8],
        block: Option<Renumbered>,
        out: &mut Outbox<'_>,
    ) {
        self.world.client(member, packet);
        self.count_order();
        let answer = self.send(member, Asker::One(from, block), out);
        if let (Some(block), Some(answer)) = (block, answer)
            && self.clients.get_mut(member).is_some_and(|clients| clients.note(&answer, block))
        {
            self.delete(member, &[block.at_drone], out);
        }
    }

    /// Has a drone delete log blocks that no client has any more.
    fn delete(&mut self, member: usize, blocks: &[u8], out: &mut Outbox<'_>) {
        for block in blocks {
            self.world.client(member, &delete(*block));
            self.send(member, Asker::Server, out);
        }
    }

    fn put(&mut self, member: usize, to: SocketAddr, packet: &[u8], out: &mut Outbox<'_>) {
        out(member, to, packet);
        self.tally.sent += 1;
    }

    fn count_order(&mut self) {
        let ordered = self.world.ordered();
        if self.ordered != ordered {
            self.ordered = ordered;
            self.tally.orders += 1;
        }
    }

    /// Sends the packets of a drone to its clients, and answers to the one that asked. Returns the
    /// answer about a log block, if there is one.
    fn send(&mut self, member: usize, asker: Asker, out: &mut Outbox<'_>) -> Option<Vec<u8>> {
        let Self { world, clients, tally, .. } = self;
        let clients = clients.get(member).filter(|clients| !clients.is_empty())?;
        let mut answer = None;
        world.poll_client(member, &mut |packet| {
            if is_of_control(packet) {
                answer = Some(packet.to_owned());
            }
            clients.route(packet, asker, &mut |to, bytes| {
                out(member, to, bytes);
                tally.sent += 1;
            });
        });
        answer
    }
}
