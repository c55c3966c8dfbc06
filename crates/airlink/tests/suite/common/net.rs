//! A small air: nodes with clocks of their own, packets that take their time, destroy each other
//! where they overlap, and get lost.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use airlink::{Airlink, Event, Identity, LinkConfig, Schedule, Seal};
use units::{Dbm, Instant, Metres, Order, Role};
use wire::p2p::{Epoch, Kind, Telemetry};
use wire::radio::Datarate;

use super::{Chance, report, telemetry};

/// The agent's round.
pub const ROUND: u64 = 200_000;

#[derive(Clone, Debug)]
pub struct Setup {
    pub datarate: Datarate,
    pub config: LinkConfig,
    /// How many places away one is still heard.
    pub earshot: usize,
    /// Of each packet at each receiver.
    pub loss: f64,
    /// The most that a task is late at the serial line and, again, at what comes out of it, in µs.
    pub late: u64,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            datarate: Datarate::Mbit2,
            config: LinkConfig::DEFAULT,
            earshot: 1,
            loss: 0.0,
            late: 0,
        }
    }
}

/// One node.
pub struct Node<S> {
    pub link: Airlink<S>,
    pub identity: Identity,
    pub epoch: u32,
    /// Where it stands in the row: who stands near hears it.
    pub place: usize,
    pub on: bool,
    /// Its clock: what it shows at the beginning, and how much faster than true time it runs.
    offset: u64,
    ppm: i64,
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

/// A packet on the air.
#[derive(Clone, Debug)]
pub struct Sent {
    pub from: usize,
    pub start: u64,
    pub end: u64,
    pub bytes: Vec<u8>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Act {
    Due { node: usize, agenda: u64 },
    Round { node: usize },
    Arrive { sent: usize },
    Deliver { sent: usize, to: usize },
}

/// What somebody's link has said.
pub struct Said {
    pub at: u64,
    pub to: usize,
    pub event: Event,
}

type Probe<S> = fn(&mut Airlink<S>, Instant, &[u8]);

pub struct Net<S> {
    pub setup: Setup,
    pub nodes: Vec<Node<S>>,
    pub now: u64,
    pub chance: Chance,
    pub sent: Vec<Sent>,
    pub said: Vec<Said>,
    /// Packets that were destroyed at a receiver by another, or by its own sending.
    pub collisions: u64,
    /// The base's stick: said in every round of the base.
    pub stick: Option<Order>,
    /// Done to a link before a packet is given to it.
    pub probe: Option<Probe<S>>,
    queue: BinaryHeap<Reverse<(u64, u64, Act)>>,
    acts: u64,
    make: fn(Identity) -> S,
}

impl<S: Seal> Net<S> {
    pub fn new(setup: Setup, seed: u64, make: fn(Identity) -> S) -> Self {
        Self {
            setup,
            nodes: Vec::new(),
            now: 0,
            chance: Chance(seed),
            sent: Vec::new(),
            said: Vec::new(),
            collisions: 0,
            stick: None,
            probe: None,
            queue: BinaryHeap::new(),
            acts: 0,
            make,
        }
    }

    /// A row of `nodes`, all switched on one after the other, the base last.
    pub fn row(setup: Setup, seed: u64, nodes: usize, make: fn(Identity) -> S) -> Self {
        let mut net = Self::new(setup, seed, make);
        for node in 0..nodes {
            net.add(super::identity(node, nodes), node, 1);
        }
        net
    }

    /// Switches on somebody who stands at `place`, a moment later: a node's frames begin when it is
    /// switched on, until it follows another.
    pub fn add(&mut self, identity: Identity, place: usize, epoch: u32) -> usize {
        let moment = self.chance.below(150_000);
        self.run(moment);
        let offset = self.chance.below(5_000_000_000);
        let ppm = self.chance.below(101) as i64 - 50;
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
        let node = Node { link, identity, epoch, place, on: true, offset, ppm, agenda: 0 };
        self.nodes.push(node);
        let first = self.chance.below(ROUND);
        self.act(self.now + first, Act::Round { node: index });
        self.arm(index);
        index
    }

    /// Switches `node` off and on again.
    pub fn reboot(&mut self, node: usize) {
        let at = self.nodes[node].local(self.now);
        let node_ = &mut self.nodes[node];
        node_.epoch += 1;
        node_.on = true;
        node_.link = Airlink::new(
            self.setup.config,
            node_.identity,
            (self.make)(node_.identity),
            Epoch::new(node_.epoch).unwrap(),
            Schedule::new(self.setup.datarate, node_.identity.node).unwrap(),
            at,
        );
        self.arm(node);
    }

    /// The operator's order at the base, and whether it stands.
    pub fn order(&mut self, base: usize, task: Order) -> bool {
        let at = self.nodes[base].local(self.now);
        let stands = self.nodes[base].link.order(at, task);
        self.arm(base);
        stands
    }

    pub fn leave(&mut self, node: usize) {
        self.nodes[node].link.leave();
        self.arm(node);
    }

    pub fn inject(&mut self, to: usize, bytes: &[u8]) -> Option<Event> {
        let at = self.nodes[to].local(self.now);
        let event = self.nodes[to].link.receive(at, Dbm(-50.0), bytes);
        self.arm(to);
        event
    }

    pub fn run(&mut self, span: u64) {
        let end = self.now + span;
        while let Some(Reverse((at, _, act))) = self.queue.peek().copied()
            && at <= end
        {
            self.queue.pop();
            self.now = at;
            self.step(act);
        }
        self.now = end;
    }

    fn act(&mut self, at: u64, act: Act) {
        self.acts += 1;
        self.queue.push(Reverse((at, self.acts, act)));
    }

    fn arm(&mut self, node: usize) {
        self.nodes[node].agenda += 1;
        let agenda = self.nodes[node].agenda;
        if let Some(due) = self.nodes[node].link.due() {
            // Clocks do not divide evenly: never before it is due.
            let at = self.nodes[node].global(due).max(self.now) + 1;
            let late = self.chance.below(self.setup.late + 1);
            self.act(at + late, Act::Due { node, agenda });
        }
    }

    fn step(&mut self, act: Act) {
        match act {
            Act::Due { node, agenda } if self.nodes[node].agenda == agenda => {
                if self.nodes[node].on {
                    self.transmit(node);
                    self.arm(node);
                }
            }
            Act::Due { .. } => {}
            Act::Round { node } => {
                self.round(node);
                self.act(self.now + ROUND, Act::Round { node });
            }
            Act::Arrive { sent } => self.arrive(sent),
            Act::Deliver { sent, to } => {
                let bytes = self.sent[sent].bytes.clone();
                let at = self.nodes[to].local(self.now);
                if let Some(probe) = self.probe {
                    probe(&mut self.nodes[to].link, at, &bytes);
                }
                if let Some(event) = self.nodes[to].link.receive(at, Dbm(-60.0), &bytes) {
                    self.said.push(Said { at: self.now, to, event });
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
        // Its age, for whoever hears it: 0.1 m are 0.1 s.
        node.link.telemeter(Telemetry { odometer: Metres(now as f32 * 1e-6), ..telemetry() });
        let at = node.local(now);
        if let (Role::Base, Some(task)) = (node.identity.role, self.stick) {
            node.link.order(at, task);
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
        let start = self.now + 10 * (7 + length as u64) + 140;
        self.sent.push(Sent {
            from: index,
            start,
            end: start + air,
            bytes: out[..length].to_vec(),
        });
        self.act(start + air, Act::Arrive { sent: self.sent.len() - 1 });
    }

    fn near(&self, a: usize, b: usize) -> bool {
        self.nodes[a].place.abs_diff(self.nodes[b].place) <= self.setup.earshot
    }

    fn arrive(&mut self, sent: usize) {
        let Sent { from, start, end, ref bytes } = self.sent[sent];
        let serial = 10 * (8 + bytes.len() as u64);
        for to in 0..self.nodes.len() {
            if to == from || !self.nodes[to].on || !self.near(from, to) {
                continue;
            }
            // What is older than a few packets is over.
            let destroyed = self.sent.iter().rev().take(24).any(|other| {
                !(other.from == from && other.start == start)
                    && other.start < end
                    && start < other.end
                    && (other.from == to || self.near(other.from, to))
            });
            if destroyed {
                self.collisions += 1;
            } else if !self.chance.hits(self.setup.loss) {
                let late = self.chance.below(self.setup.late + 1);
                self.act(end + serial + late, Act::Deliver { sent, to });
            }
        }
    }

    /// The kind of a packet.
    pub fn kind(bytes: &[u8]) -> Kind {
        wire::p2p::Header::decode(bytes).unwrap().0.kind
    }
}
