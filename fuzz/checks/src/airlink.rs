//! The radio link of a base and a relay with real keys: a packet of a sender without keys gives no
//! event, nor does a recording, after a reboot neither; and a thief with a relay's keys can forge
//! neither an order nor the telemetry of another node.

use std::collections::HashSet;

use airlink::keys::{self, FleetSecret, Key, Keys, Own};
use airlink::{Airlink, Event, Identity, LinkConfig, Schedule, Scope, Seal, Sealed};
use units::{Dbm, Duration, Instant, LinkSum, Metres, MetresPerSecond, NodeId, Order, Phase, Role};
use wire::p2p::{Counter, Epoch, HEADER, Report, Telemetry};
use wire::radio::Datarate;
use wire::syslink::MAX_P2P;

const RELAY: usize = 0;
const BASE: usize = 1;

/// The time from the serial line of the sender to that of the receiver, about.
const FLIGHT: Duration = Duration::from_micros(1500);

/// The bytes of the script that are left; zeros after its end.
struct Script<'a>(&'a [u8]);

impl<'a> Script<'a> {
    fn more(&self) -> bool {
        !self.0.is_empty()
    }

    fn byte(&mut self) -> u8 {
        let Some((&byte, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        byte
    }

    fn bytes(&mut self) -> &'a [u8] {
        let length = usize::from(self.byte() % 64);
        let (bytes, rest) = self.0.split_at(length.min(self.0.len()));
        self.0 = rest;
        bytes
    }
}

/// A packet that was sent.
struct Sent {
    by: usize,
    at: Instant,
    bytes: Vec<u8>,
    /// Whether it has given either node an event, in this life or one before.
    heard_by: [bool; 2],
}

struct Node {
    link: Airlink<Sealed>,
    epoch: Epoch,
    booted: Instant,
}

struct Air {
    nodes: [Node; 2],
    now: Instant,
    sent: Vec<Sent>,
    told: Vec<[u8; 12]>,
    ordered: Vec<Order>,
    obeyed: HashSet<Counter>,
    /// Whether a thief with a relay's keys has sent packets.
    stolen: bool,
}

fn secret() -> FleetSecret {
    FleetSecret::from_bytes(*b"a fleet's secret")
}

fn number(node: usize) -> NodeId {
    NodeId(node as u8 + 1)
}

fn boot(node: usize, epoch: Epoch, now: Instant) -> Airlink<Sealed> {
    let base = secret().base(1);
    let (role, own) = match node {
        RELAY => (Role::Relay, Own::Node(keys::node(&base, number(RELAY)))),
        _ => (Role::Base, Own::Base(base)),
    };
    let seal = Sealed::new(Keys { group: secret().group(1), own });
    let schedule = Schedule::new(Datarate::Mbit2, number(node)).unwrap();
    let identity = Identity { node: number(node), role };
    Airlink::new(LinkConfig::DEFAULT, identity, seal, epoch, schedule, now)
}

/// Runs the bytes as a script: each step is a byte that chooses what happens, and its arguments.
pub fn check(data: &[u8]) {
    let now = Instant::from_millis(1000);
    let node =
        |node| Node { link: boot(node, Epoch::FIRST, now), epoch: Epoch::FIRST, booted: now };
    let mut air = Air {
        nodes: [node(RELAY), node(BASE)],
        now,
        sent: Vec::new(),
        told: Vec::new(),
        ordered: Vec::new(),
        obeyed: HashSet::new(),
        stolen: false,
    };
    let mut script = Script(data);
    // A bound on the steps, so that a fuzzer runs many scripts.
    for _ in 0..200 {
        if !script.more() {
            break;
        }
        air.step(&mut script);
    }
}

impl Air {
    fn step(&mut self, script: &mut Script<'_>) {
        let step = script.byte();
        let who = usize::from(step >> 7);
        match step & 0b111 {
            0 => self.now = self.now + Duration::from_millis(4 * u64::from(script.byte())),
            1 => self.talk(4 * u64::from(script.byte()), step >> 3),
            2 => self.say(who, script),
            3 => self.nonsense(who, script.bytes()),
            4 => self.replay(who, script, None),
            5 => {
                let bit = script.byte();
                self.replay(who, script, Some(usize::from(bit)));
            }
            6 => self.reboot(who),
            _ => self.steal(who, script),
        }
    }

    /// Lets both nodes send for this time; each packet arrives unless it is lost.
    fn talk(&mut self, milliseconds: u64, lost: u8) {
        let end = self.now + Duration::from_millis(milliseconds);
        for turn in 0.. {
            assert!(turn < 1000, "there is no end to what is sent");
            let mut due = |node: usize| Some((self.nodes[node].link.due()?, node));
            let first = [due(RELAY), due(BASE)].into_iter().flatten().min();
            let Some((due, who)) = first.filter(|(due, _)| *due <= end) else { break };
            self.now = self.now.max(due);
            let mut out = [0; MAX_P2P];
            let Some(length) = self.nodes[who].link.transmit(self.now, &mut out) else {
                // It is too late for this turn. A firmware would also ask again a little later.
                self.now = self.now + Duration::from_millis(1);
                continue;
            };
            let bytes = out[..length].to_vec();
            self.sent.push(Sent { by: who, at: self.now, bytes, heard_by: [false; 2] });
            if lost >> (turn % 4) & 1 == 0 {
                self.deliver(self.sent.len() - 1, 1 - who, self.now + FLIGHT);
            }
        }
        self.now = self.now.max(end);
    }

    fn deliver(&mut self, index: usize, to: usize, at: Instant) {
        let packet = &mut self.sent[index];
        let node = &mut self.nodes[to];
        let event = node.link.receive(at, Dbm(-60.0), &packet.bytes);
        // A packet may be delayed and be an event late, but only once, and not after a reboot.
        let new = !packet.heard_by[to] && packet.by != to && packet.at >= node.booted;
        packet.heard_by[to] |= event.is_some();
        assert!(event.is_none() || new || self.stolen, "{event:?} of a recording");
        self.heard(to, event);
    }

    /// Checks an event, whichever packet caused it: orders and telemetry must be real.
    fn heard(&mut self, who: usize, event: Option<Event>) {
        match event {
            Some(Event::Order { task, counter }) => {
                assert_eq!(who, RELAY, "an order to the base");
                assert!(self.ordered.contains(&task), "{task:?} was never ordered");
                assert!(self.obeyed.insert(counter), "{counter:?} a second time");
            }
            Some(Event::Telemetry { from, telemetry, .. }) => {
                assert_eq!(who, BASE, "telemetry for a relay");
                assert_eq!(from, number(RELAY));
                assert!(self.told.contains(&without_heeded(&telemetry)), "{telemetry:?}");
            }
            _ => {}
        }
    }

    fn say(&mut self, who: usize, script: &mut Script<'_>) {
        let byte = script.byte();
        let value = f32::from(byte);
        self.nodes[who].link.report(Report {
            phase: Phase::Linked,
            recall: byte & 1 == 1,
            calls: byte & 2 == 2,
            is_uneven: byte & 4 == 4,
            velocity: MetresPerSecond(value / 1000.0),
            odometer: Metres(value),
            links: None,
            signpost: None,
            sums: [LinkSum::NONE; 2],
            waiting: 0,
            head_velocity: MetresPerSecond::ZERO,
            heard: heapless::Vec::new(),
        });
        let telemetry = Telemetry {
            state: byte,
            fault: 0,
            battery: None,
            endurance: None,
            front: None,
            back: None,
            odometer: Metres(value),
            velocity: MetresPerSecond(0.0),
            height: None,
            heeded: 0,
        };
        let all = [Order::Wait, Order::explore(MetresPerSecond(value / 1000.0)), Order::Return];
        let task = all[usize::from(byte) % all.len()];
        match who {
            RELAY => {
                self.told.push(without_heeded(&telemetry));
                self.nodes[RELAY].link.telemeter(telemetry);
            }
            _ => {
                self.ordered.push(wire::p2p::decode_order(&wire::p2p::encode_order(task)).unwrap());
                self.nodes[BASE].link.order(self.now, task);
            }
        }
    }

    fn nonsense(&mut self, to: usize, bytes: &[u8]) {
        let event = self.nodes[to].link.receive(self.now, Dbm(-60.0), bytes);
        assert_eq!(event, None);
    }

    /// Delivers an earlier packet once more, whole or with one bit flipped.
    fn replay(&mut self, to: usize, script: &mut Script<'_>, flip: Option<usize>) {
        let back = usize::from(script.byte());
        let Some(index) = self.sent.len().checked_sub(back + 1) else { return };
        let Some(bit) = flip else { return self.deliver(index, to, self.now) };
        let mut bytes = self.sent[index].bytes.clone();
        let bit = (bit * 2 + usize::from(to == BASE)) % (8 * bytes.len());
        bytes[bit / 8] ^= 1 << (bit % 8);
        self.nonsense(to, &bytes);
    }

    fn reboot(&mut self, who: usize) {
        let node = &mut self.nodes[who];
        node.epoch = node.epoch.next().unwrap();
        node.booted = self.now;
        node.link = boot(who, node.epoch, self.now);
    }

    /// Delivers a packet that a thief with the head's keys can make.
    fn steal(&mut self, to: usize, script: &mut Script<'_>) {
        self.stolen = true;
        let key: Key = keys::node(&secret().base(1), NodeId::HEAD);
        let thief = Sealed::new(Keys { group: secret().group(1), own: Own::Node(key) });
        let bytes = script.bytes();
        let Some((header, body)) = bytes.split_first_chunk::<HEADER>() else { return };
        let mut nonce = [0; 16];
        nonce[..HEADER].copy_from_slice(header);
        let mut body = body.to_vec();
        let tag = thief.seal(Scope::Fleet, &nonce, header, &mut body);
        let packet = [&header[..], &body, &tag].concat();
        let event = self.nodes[to].link.receive(self.now, Dbm(-60.0), &packet);
        self.heard(to, event);
    }
}

fn without_heeded(telemetry: &Telemetry) -> [u8; 12] {
    *telemetry.encode().first_chunk().unwrap()
}
