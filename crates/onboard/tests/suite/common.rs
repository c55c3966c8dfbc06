//! A small lossy network of whole drones, with clients at any of them.
#![allow(unreachable_pub, reason = "a module of the tests")]

use std::collections::BTreeMap;

use agent::Fitness;
use airlink::{LinkConfig, Schedule, Scope, Seal};
use onboard::{Config, Drone, Keys, Sensed, Setup, Start};
use units::{Dbm, Duration, Instant, Metres, NodeId, Role, Setpoint};
use wire::p2p::{Epoch, TAG};
use wire::radio::Datarate;
use wire::syslink::MAX_P2P;

/// Sealing that does not seal: the tag is of zeros.
#[derive(Clone, Copy, Debug)]
pub struct Clear;

impl Seal for Clear {
    fn seal(&self, _: Scope, _: &[u8; 16], _: &[u8], _: &mut [u8]) -> [u8; TAG] {
        [0; TAG]
    }

    fn open(&self, _: Scope, _: &[u8; 16], _: &[u8], _: &mut [u8], tag: &[u8; TAG]) -> bool {
        *tag == [0; TAG]
    }
}

/// SplitMix64 (Steele, Lea, Flood 2014).
#[derive(Clone, Debug)]
pub struct Chance(pub u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    /// Of 0 to `n` − 1.
    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    /// True in `percent` of 100 cases.
    fn hits(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }
}

/// A drone in the network, and what it has done.
pub struct Node {
    pub drone: Drone<Clear>,
    node: NodeId,
    role: Role,
    epoch: u32,
    offset: u64,
    next_round: u64,
    /// When it last wanted to fly, by the network's clock.
    pub flew: Option<u64>,
    /// Since when the motors are ordered to stand until the next boot.
    pub stopped: Option<u64>,
    /// It has flown after it was stopped, without a boot in between.
    pub broke_out: bool,
}

impl Node {
    fn at(&self, now: u64) -> Instant {
        Instant::from_micros(now + self.offset)
    }

    fn due(&mut self, now: u64) -> Option<u64> {
        let due = self.drone.due()?.as_micros();
        Some(due.saturating_sub(self.offset).max(now))
    }
}

/// How a drone is switched off and on again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reboot {
    /// By a fault: what is to outlive a restart does.
    Fault,
    /// By its button: nothing does.
    Button,
}

/// Nodes in a row, the head first and the base last, each in earshot of the next two.
pub struct Net {
    pub nodes: Vec<Node>,
    pub now: u64,
    /// How much later every packet comes, µs.
    pub held: u64,
    loss: u64,
    chance: Chance,
    /// Packets on their way, by the moment of their arrival and a number.
    air: BTreeMap<(u64, u64), (usize, Vec<u8>)>,
    sent: u64,
}

const ROUND: u64 = 200_000;
const EARSHOT: usize = 2;

impl Net {
    /// A network that loses so many percent of all packets at each receiver. All drones but the base
    /// begin in the air.
    pub fn new(count: usize, loss: u64, seed: u64) -> Self {
        let mut chance = Chance(seed);
        let nodes = (0..count)
            .map(|n| {
                let role = match n {
                    0 => Role::Head,
                    n if n + 1 == count => Role::Base,
                    _ => Role::Relay,
                };
                let offset = chance.below(3_600_000_000);
                let start = match role {
                    Role::Base => Start::OnGround,
                    _ => Start::InAir { at: Instant::from_micros(offset), flown: Metres::ZERO },
                };
                let (node, next_round) = (NodeId(n as u8), chance.below(ROUND));
                let drone = with_keys(node, role, start, false, 1, Instant::from_micros(offset));
                let (flew, stopped, broke_out) = (None, None, false);
                Node { drone, node, role, epoch: 1, offset, next_round, flew, stopped, broke_out }
            })
            .collect();
        Self { nodes, now: 0, held: 0, loss, chance, air: BTreeMap::new(), sent: 0 }
    }

    pub fn base(&self) -> usize {
        self.nodes.len() - 1
    }

    /// A client's packet comes to a node; what the node answers.
    pub fn client(&mut self, to: usize, packet: &[u8]) -> Vec<Vec<u8>> {
        let node = &mut self.nodes[to];
        let now = node.at(self.now);
        node.drone.client(now, packet);
        let snapshot = node.drone.snapshot(now, &crtp::Snapshot::DEFAULT);
        std::iter::from_fn(|| node.drone.poll_client(now, &snapshot))
            .take(100)
            .map(|packet| packet.bytes().to_vec())
            .collect()
    }

    /// Switches a node off and on again.
    pub fn reboot(&mut self, which: usize, how: Reboot) {
        let node = &mut self.nodes[which];
        node.epoch += 1;
        let stopped = how == Reboot::Fault && node.drone.is_stopped();
        let start = match how {
            Reboot::Fault => Start::AfterFault,
            Reboot::Button => Start::OnGround,
        };
        let now = node.at(self.now);
        node.drone = with_keys(node.node, node.role, start, stopped, node.epoch, now);
        (node.stopped, node.broke_out) = (None, node.broke_out);
    }

    pub fn run(&mut self, span: Duration) {
        let end = self.now + span.as_micros();
        loop {
            let arrival = self.air.keys().next().map(|(at, _)| *at).unwrap_or(u64::MAX);
            let now = self.now;
            let (speaker, due) = (0..self.nodes.len())
                .map(|n| (n, self.nodes[n].due(now).unwrap_or(u64::MAX)))
                .min_by_key(|(_, due)| *due)
                .unwrap();
            let (thinker, round) = (0..self.nodes.len())
                .map(|n| (n, self.nodes[n].next_round))
                .min_by_key(|(_, round)| *round)
                .unwrap();
            let next = arrival.min(due).min(round);
            if next > end {
                break;
            }
            self.now = next;
            if arrival == next {
                self.arrive();
            } else if round == next {
                self.round(thinker);
            } else {
                self.transmit(speaker);
            }
        }
        self.now = end;
    }

    fn round(&mut self, which: usize) {
        let now = self.now;
        let node = &mut self.nodes[which];
        node.next_round = now + ROUND;
        let airborne = node.drone.state().is_airborne();
        let sensed = Sensed {
            height: Some(Metres(if airborne { 0.3 } else { 0.0 })),
            fitness: Fitness::Fit,
            ..Sensed::NONE
        };
        match node.drone.step(node.at(now), &sensed).setpoint {
            Setpoint::Fly { .. } => {
                node.flew = Some(now);
                node.broke_out |= node.stopped.is_some();
            }
            Setpoint::Stop => {
                node.stopped.get_or_insert(now);
            }
            // A base has no motors.
            Setpoint::Off if node.drone.is_stopped() => {
                node.stopped.get_or_insert(now);
            }
            Setpoint::Off => node.broke_out |= node.stopped.is_some(),
        }
    }

    fn transmit(&mut self, from: usize) {
        let mut out = [0; MAX_P2P];
        let now = self.now;
        let node = &mut self.nodes[from];
        let Some(length) = node.drone.transmit(node.at(now), &mut out) else {
            // Its turn is over, or has moved: it is asked again a moment later.
            self.now += 1;
            return;
        };
        let schedule = Schedule::new(Datarate::Mbit2, node.node).unwrap();
        let line = 10 * (15 + 2 * length as u64) + 140;
        let arrives = now + line + schedule.air_time(length).as_micros() + self.held;
        self.sent += 1;
        self.air.insert((arrives, self.sent), (from, out[..length].to_vec()));
    }

    fn arrive(&mut self) {
        let Some((_, (from, packet))) = self.air.pop_first() else { return };
        for to in 0..self.nodes.len() {
            if to == from || to.abs_diff(from) > EARSHOT || self.chance.hits(self.loss) {
                continue;
            }
            let node = &mut self.nodes[to];
            let now = node.at(self.now);
            node.drone.receive(now, Dbm(-50.0), &packet);
        }
    }
}

/// A drone with keys that stands on the ground.
pub fn drone(node: NodeId, role: Role) -> Drone<Clear> {
    with_keys(node, role, Start::OnGround, false, 1, Instant::ZERO)
}

/// A relay that was switched on, with keys.
pub fn relay() -> Drone<Clear> {
    drone(NodeId(1), Role::Relay)
}

fn with_keys(
    node: NodeId,
    role: Role,
    start: Start,
    stopped: bool,
    epoch: u32,
    now: Instant,
) -> Drone<Clear> {
    let config = Config { link: LinkConfig::DEFAULT, ..Config::DEFAULT };
    let mut drone = Drone::new(config, &Setup { start, stopped, ..Setup::new(node, role) });
    let schedule = Schedule::new(Datarate::Mbit2, node).unwrap();
    let epoch = Epoch::new(epoch).unwrap();
    drone.open_link(now, Keys::Held { seal: Clear, epoch, schedule, may_fly: true });
    drone
}

/// Packets of clients, by the headers that they have on the air.
pub mod packets {
    use crtp::ParameterId;

    pub fn hover(forward: f32) -> Vec<u8> {
        let mut packet = vec![0x7C, 10];
        for value in [forward, 0.0, 0.0, 0.3] {
            packet.extend(value.to_le_bytes());
        }
        packet
    }

    pub fn set(id: ParameterId, value: &[u8]) -> Vec<u8> {
        [&[0x2E], &id.row().to_le_bytes()[..], value].concat()
    }

    pub fn read(row: u16) -> Vec<u8> {
        [&[0x2D], &row.to_le_bytes()[..]].concat()
    }

    pub fn task(code: u8) -> Vec<u8> {
        set(ParameterId::TASK, &[code])
    }

    pub const EMERGENCY_STOP: [u8; 2] = [0x9D, 3];
    pub const WATCHDOG: [u8; 2] = [0x9D, 4];
    pub const OLD_EMERGENCY_STOP: [u8; 2] = [0x6D, 3];
    pub const TAKE_OFF: [u8; 3] = [0x8C, 7, 0];
    pub const LAND: [u8; 3] = [0x8C, 8, 0];
    pub const SUPERVISOR_INFO: [u8; 2] = [0x9C, 12];
    pub const DISARM: [u8; 3] = [0x9D, 1, 0];
    pub const ECHO: [u8; 2] = [0xFC, 1];
}
