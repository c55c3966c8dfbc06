//! A simulated radio channel: nodes with clocks of their own, and packets that take time, destroy
//! each other where they overlap, and get lost.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use airlink::{Airlink, Event, Identity, LinkConfig, Schedule, Seal};
use units::{Dbm, Instant, Metres, Order, Role};
use wire::p2p::{Epoch, Kind, Telemetry};
use wire::radio::Datarate;
use wire::radio::timing::{RAMP_UP_US, ROUND_NS, handed_soonest_us, received_us};

use super::{Rng, report, telemetry};

/// The time between two rounds of the agent, in µs.
pub const ROUND: u64 = 200_000;

/// The properties of the channel and of all nodes.
#[derive(Clone, Debug)]
pub struct Setup {
    pub datarate: Datarate,
    pub config: LinkConfig,
    /// The distance, in positions of the row, up to which a node is heard.
    pub range: usize,
    /// The probability that a packet is lost, for each receiver by itself.
    pub loss: f64,
    /// The longest delay of a task in µs, once before the serial line to the radio and once after
    /// the serial line from it.
    pub late: u64,
    /// The probability that a radio chip sends, in place of a packet of its own, the one that it
    /// received seven packets before the last.
    pub ghosts: f64,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            datarate: Datarate::Mbit2,
            config: LinkConfig::DEFAULT,
            range: 1,
            loss: 0.0,
            late: 0,
            ghosts: 0.0,
        }
    }
}

/// A node of the simulated channel.
pub struct Node<S> {
    pub link: Airlink<S>,
    pub identity: Identity,
    pub epoch: u32,
    /// Its position in the row: the nodes within range hear it.
    pub position: usize,
    pub on: bool,
    /// The reading of its clock at the beginning, in µs.
    offset: u64,
    /// How much faster than true time its clock runs.
    ppm: i64,
    /// The packets in the slots of its radio chip, the oldest first.
    slots: VecDeque<Vec<u8>>,
    /// The number of its last [`Task::Due`]; earlier ones are void.
    agenda: u64,
}

impl<S> Node<S> {
    fn local(&self, t: u64) -> Instant {
        let run = t as i64 + t as i64 * self.ppm / 1_000_000;
        Instant::from_micros(self.offset + run as u64)
    }

    fn global(&self, local: Instant) -> u64 {
        let run = local.as_micros().saturating_sub(self.offset) as i64;
        (run - run * self.ppm / 1_000_000).max(0) as u64
    }
}

/// A packet that was sent, with its time on the air in µs.
#[derive(Clone, Debug)]
pub struct Sent {
    pub from: usize,
    pub start: u64,
    pub end: u64,
    pub bytes: Vec<u8>,
    /// Whether these are the bytes of another node's packet, sent once more.
    pub is_ghost: bool,
}

/// The strength at which packets are received, and that of packets that another node sends once more.
const STRENGTH: Dbm = Dbm(-60.0);
pub const GHOSTS_STRENGTH: Dbm = Dbm(-40.0);

/// Slots of a radio chip for received packets (crazyflie2-nrf-firmware, `esb.c`: `RXQ_LEN`).
const SLOTS: usize = 8;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Task {
    Due { node: usize, agenda: u64 },
    Round { node: usize },
    EndOnAir { sent: usize },
    Deliver { sent: usize, to: usize },
}

/// An event of the link of node `to`.
pub struct Received {
    pub at: u64,
    pub to: usize,
    pub event: Event,
}

/// A function that a test runs on a link and a packet.
type Probe<S> = fn(&mut Airlink<S>, Instant, &[u8]);

/// The simulated channel with its nodes, and a record of all packets and events.
pub struct Net<S> {
    pub setup: Setup,
    pub nodes: Vec<Node<S>>,
    pub now: u64,
    pub rng: Rng,
    pub sent: Vec<Sent>,
    pub received: Vec<Received>,
    /// Packets that were destroyed at a receiver by another packet, or by its own sending.
    pub collisions: u64,
    /// Packets that were still on the air when their sender's radio chip had the next one to send.
    pub cut: usize,
    /// The operator's order, given to the base in every round.
    pub stick: Option<Order>,
    /// Called on a link before a packet is given to it.
    pub probe: Option<Probe<S>>,
    queue: BinaryHeap<Reverse<(u64, u64, Task)>>,
    tasks: u64,
    make: fn(Identity) -> S,
}

impl<S: Seal> Net<S> {
    pub fn new(setup: Setup, seed: u64, make: fn(Identity) -> S) -> Self {
        Self {
            setup,
            nodes: Vec::new(),
            now: 0,
            rng: Rng(seed),
            sent: Vec::new(),
            received: Vec::new(),
            collisions: 0,
            cut: 0,
            stick: None,
            probe: None,
            queue: BinaryHeap::new(),
            tasks: 0,
            make,
        }
    }

    /// A row of `nodes`, switched on one after the other, the base last.
    pub fn row(setup: Setup, seed: u64, nodes: usize, make: fn(Identity) -> S) -> Self {
        let mut net = Self::new(setup, seed, make);
        for node in 0..nodes {
            net.add(super::identity(node, nodes), node, 1);
        }
        net
    }

    /// Switches on a node at `position` after a random delay, so that its frame, which begins when
    /// it is switched on, differs from those of the others.
    pub fn add(&mut self, identity: Identity, position: usize, epoch: u32) -> usize {
        let moment = self.rng.below(150_000);
        self.run(moment);
        let offset = self.rng.below(5_000_000_000);
        let ppm = self.rng.below(101) as i64 - 50;
        let index = self.nodes.len();
        let schedule = Schedule::new(self.setup.datarate, identity.node).unwrap();
        let local = offset as i64 + self.now as i64 + self.now as i64 * ppm / 1_000_000;
        let link = Airlink::new(
            self.setup.config,
            identity,
            (self.make)(identity),
            Epoch::new(epoch).unwrap(),
            schedule,
            Instant::from_micros(local as u64),
        );
        let slots = VecDeque::new();
        let node =
            Node { link, identity, epoch, position, on: true, offset, ppm, slots, agenda: 0 };
        self.nodes.push(node);
        let first = self.rng.below(ROUND);
        self.schedule(self.now + first, Task::Round { node: index });
        self.arm(index);
        index
    }

    /// Switches `node` off and on again.
    pub fn reboot(&mut self, node: usize) {
        let at = self.nodes[node].local(self.now);
        let target = &mut self.nodes[node];
        target.epoch += 1;
        target.on = true;
        target.link = Airlink::new(
            self.setup.config,
            target.identity,
            (self.make)(target.identity),
            Epoch::new(target.epoch).unwrap(),
            Schedule::new(self.setup.datarate, target.identity.node).unwrap(),
            at,
        );
        self.arm(node);
    }

    /// Gives the operator's order to the base, and returns whether it stands.
    pub fn order(&mut self, base: usize, order: Order) -> bool {
        let at = self.nodes[base].local(self.now);
        let stands = self.nodes[base].link.order(at, order);
        self.arm(base);
        stands
    }

    /// Lets `node` leave.
    pub fn leave(&mut self, node: usize) {
        self.nodes[node].link.leave();
        self.arm(node);
    }

    /// Gives `bytes` to node `to` as a received packet.
    pub fn inject(&mut self, to: usize, bytes: &[u8]) -> Option<Event> {
        let at = self.nodes[to].local(self.now);
        let event = self.nodes[to].link.receive(at, Dbm(-50.0), bytes);
        self.arm(to);
        event
    }

    /// Lets `span` µs pass.
    pub fn run(&mut self, span: u64) {
        let end = self.now + span;
        while let Some(Reverse((at, _, task))) = self.queue.peek().copied()
            && at <= end
        {
            self.queue.pop();
            self.now = at;
            self.step(task);
        }
        self.now = end;
    }

    fn schedule(&mut self, at: u64, task: Task) {
        self.tasks += 1;
        self.queue.push(Reverse((at, self.tasks, task)));
    }

    /// Schedules the next transmission of `node`.
    fn arm(&mut self, node: usize) {
        self.nodes[node].agenda += 1;
        let agenda = self.nodes[node].agenda;
        if let Some(due) = self.nodes[node].link.due() {
            // The clocks' conversions are rounded; the microsecond keeps it from coming early.
            let at = self.nodes[node].global(due).max(self.now) + 1;
            let late = self.rng.below(self.setup.late + 1);
            self.schedule(at + late, Task::Due { node, agenda });
        }
    }

    fn step(&mut self, task: Task) {
        match task {
            Task::Due { node, agenda } if self.nodes[node].agenda == agenda => {
                if self.nodes[node].on {
                    self.transmit(node);
                    self.arm(node);
                }
            }
            Task::Due { .. } => {}
            Task::Round { node } => {
                self.round(node);
                self.schedule(self.now + ROUND, Task::Round { node });
            }
            Task::EndOnAir { sent } => self.end_on_air(sent),
            Task::Deliver { sent, to } => {
                let bytes = self.sent[sent].bytes.clone();
                let at = self.nodes[to].local(self.now);
                if let Some(probe) = self.probe {
                    probe(&mut self.nodes[to].link, at, &bytes);
                }
                let is_ghost = self.sent[sent].is_ghost;
                let strength = if is_ghost { GHOSTS_STRENGTH } else { STRENGTH };
                if let Some(event) = self.nodes[to].link.receive(at, strength, &bytes) {
                    self.received.push(Received { at: self.now, to, event });
                }
                self.arm(to);
            }
        }
    }

    fn round(&mut self, index: usize) {
        let now = self.now;
        let node = &mut self.nodes[index];
        if !node.on {
            return;
        }
        node.link.report(report());
        // The odometer carries the time, so that a receiver can tell the age: 0.1 m are 0.1 s.
        node.link.telemeter(Telemetry { odometer: Metres(now as f32 * 1e-6), ..telemetry() });
        let at = node.local(now);
        if let (Role::Base, Some(order)) = (node.identity.role, self.stick) {
            node.link.order(at, order);
        }
        self.arm(index);
    }

    fn transmit(&mut self, index: usize) {
        let at = self.nodes[index].local(self.now);
        let mut out = [0; 60];
        let Some(length) = self.nodes[index].link.transmit(at, &mut out) else {
            let due = self.nodes[index].link.due();
            assert!(due.is_none_or(|due| due > at), "nothing to send, but due {due:?} at {at:?}");
            return;
        };
        let air = Schedule::new(self.setup.datarate, self.nodes[index].identity.node)
            .unwrap()
            .air_time(length)
            .as_micros();
        let handed = self.now + handed_soonest_us(length) + self.rng.below(ROUND_NS / 1_000);
        let start = handed + RAMP_UP_US;
        let ghost = self.nodes[index].slots.front().cloned();
        let ghost = ghost.filter(|_| self.nodes[index].slots.len() == SLOTS);
        let ghost = ghost.filter(|_| self.setup.ghosts > 0.0 && self.rng.hits(self.setup.ghosts));
        self.cut += self.sent.iter().filter(|sent| sent.from == index && sent.end > handed).count();
        let is_ghost = ghost.is_some();
        let bytes = ghost.unwrap_or_else(|| out[..length].to_vec());
        self.sent.push(Sent { from: index, start, end: start + air, bytes, is_ghost });
        self.schedule(start + air, Task::EndOnAir { sent: self.sent.len() - 1 });
    }

    /// Whether node `a` and node `b` hear each other.
    fn near(&self, a: usize, b: usize) -> bool {
        self.nodes[a].position.abs_diff(self.nodes[b].position) <= self.setup.range
    }

    fn end_on_air(&mut self, sent: usize) {
        let Sent { from, start, end, ref bytes, .. } = self.sent[sent];
        let (received, bytes) = (received_us(bytes.len()), bytes.clone());
        for to in 0..self.nodes.len() {
            if to == from || !self.nodes[to].on || !self.near(from, to) {
                continue;
            }
            // Packets older than the last 24 ended long ago.
            let destroyed = self.sent.iter().rev().take(24).any(|other| {
                !(other.from == from && other.start == start)
                    && other.start < end
                    && start < other.end
                    && (other.from == to || self.near(other.from, to))
            });
            if destroyed {
                self.collisions += 1;
            } else if !self.rng.hits(self.setup.loss) {
                let late = self.rng.below(self.setup.late + 1);
                let late = late + self.rng.below(ROUND_NS / 1_000);
                let slots = &mut self.nodes[to].slots;
                slots.push_back(bytes.clone());
                if slots.len() > SLOTS {
                    slots.pop_front();
                }
                self.schedule(end + received + late, Task::Deliver { sent, to });
            }
        }
    }

    /// The kind of a packet.
    pub fn kind(bytes: &[u8]) -> Kind {
        wire::p2p::Header::decode(bytes).unwrap().0.kind
    }
}
