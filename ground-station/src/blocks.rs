//! Asks the base for log blocks, one for each drone and one for the base, and reads them.
//!
//! A Crazyflie sends at most 128 variables in 16 blocks (`crtp`, `blocks.rs`): a chain of 16 nodes
//! leaves eight for each of them.

use std::collections::VecDeque;

use units::{Dbm, Duration, Instant, Metres, NODES, NodeId, Volts};
use wire::crtp::{LogType, MAX_DATA, Packet, Port};

use crate::table::Rows;

/// The period of a drone's block, in the protocol's units of 10 ms. A drone sends telemetry once or
/// twice a second, and 15 such blocks with the base's must fit into the 100 packets that a
/// Crazyradio polls in a second.
const DRONE_PERIOD: u8 = 25;
/// The period of the base's block, likewise.
const BASE_PERIOD: u8 = 20;

/// The time after which a request without an answer is sent again.
const AGAIN: Duration = Duration::from_millis(300);

/// The variables of a drone, in the order of [`DroneReport::decode`].
const DRONE: [(&str, LogType); 8] = [
    ("state", LogType::U8),
    ("fault", LogType::U8),
    ("age", LogType::F32),
    ("vbat", LogType::F32),
    ("endurance", LogType::F32),
    ("backPeer", LogType::U8),
    ("backRssi", LogType::F32),
    ("odometer", LogType::F32),
];

/// The variables of the base, in the order of [`BaseReport::decode`].
const BASE: [(&str, LogType); 3] = [
    ("uchain.linkStatus", LogType::U8),
    ("uchain.recalled", LogType::U8),
    ("uchain.refused", LogType::U32),
];

/// What a drone said last, as the base knows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DroneReport {
    /// The code of what the drone is doing; see [`words::state`](crate::words::state).
    pub state: u8,
    /// The code of what is wrong with the drone, 0 for nothing.
    pub fault: u8,
    /// The time since the drone said this.
    pub age: Duration,
    /// The battery's voltage.
    pub battery: Option<Volts>,
    /// The time for which the battery still carries the drone.
    pub endurance: Option<Duration>,
    /// The neighbour towards the base, and the filtered strength of the link to it.
    pub back: Option<(NodeId, Dbm)>,
    /// The way along the tunnel since take-off.
    pub odometer: Metres,
}

impl DroneReport {
    /// Reads the values of a drone's block; `None` for a drone that has never said anything.
    fn decode(values: &[u8]) -> Option<Self> {
        let mut values = Values(values);
        let (state, fault, age) = (values.byte()?, values.byte()?, values.float()?);
        let (volts, endurance) = (values.float()?, values.float()?);
        let (peer, rssi, odometer) = (values.byte()?, values.float()?, values.float()?);
        let is_heard = age >= 0.0 && state != 255;
        is_heard.then(|| Self {
            state,
            fault,
            age: seconds(age),
            battery: (volts > 0.0).then_some(Volts(volts)),
            endurance: (endurance >= 0.0).then(|| seconds(endurance)),
            back: (rssi < 0.0 && usize::from(peer) < NODES).then_some((NodeId(peer), Dbm(rssi))),
            odometer: Metres(odometer),
        })
    }
}

/// What the base says about itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BaseReport {
    /// The state of the base's radio link: 0 off, 1 listening, 2 member, 3 refused, 4 exhausted.
    pub link: u8,
    /// Whether a drone of the chain must come home.
    pub recalled: bool,
    /// The number of packets of the chain that the base refused.
    pub refused: u32,
}

impl BaseReport {
    fn decode(values: &[u8]) -> Option<Self> {
        let mut values = Values(values);
        let (link, recalled) = (values.byte()?, values.byte()? != 0);
        Some(Self { link, recalled, refused: values.word()? })
    }
}

fn seconds(span: f32) -> Duration {
    Duration::from_micros((span.max(0.0) * 1e6) as u64)
}

/// The values of a block that have not been read yet.
struct Values<'a>(&'a [u8]);

impl Values<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (byte, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*byte)
    }

    fn word(&mut self) -> Option<u32> {
        let (word, rest) = self.0.split_first_chunk::<4>()?;
        self.0 = rest;
        Some(u32::from_le_bytes(*word))
    }

    fn float(&mut self) -> Option<f32> {
        self.word().map(f32::from_bits).filter(|x| x.is_finite())
    }
}

/// A block of the log that has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Block {
    /// What a drone said last.
    Drone(NodeId, DroneReport),
    /// What the base says about itself.
    Base(BaseReport),
}

impl Block {
    /// Reads a block from a packet; `None` for other packets, and for a drone that has said
    /// nothing yet. The number of a block is that of the node; `base` has the base's own values.
    #[must_use]
    pub fn decode(packet: &Packet, base: NodeId) -> Option<Self> {
        if packet.port() != Ok(Port::Log) || packet.channel() != 2 {
            return None;
        }
        match packet.data() {
            [block, _, _, _, values @ ..] if *block == base.0 => {
                BaseReport::decode(values).map(Self::Base)
            }
            [block, _, _, _, values @ ..] if usize::from(*block) < NODES => {
                Some(Self::Drone(NodeId(*block), DroneReport::decode(values)?))
            }
            _ => None,
        }
    }
}

/// The requests that create and start the blocks, sent one after the other.
#[derive(Debug)]
pub struct BlockSetup {
    left: VecDeque<Packet>,
    sent: Option<Instant>,
}

impl BlockSetup {
    /// The setup for a base with this number and this table of log variables.
    ///
    /// # Errors
    /// The name of the variable that the base does not have.
    pub fn new(base: NodeId, rows: &Rows) -> Result<Self, String> {
        let mut left = VecDeque::new();
        left.extend(control(&[5]));
        for node in (0..NODES as u8).map(NodeId) {
            let is_base = node == base;
            let variables: Vec<(String, LogType)> = if is_base {
                BASE.iter().map(|(name, kind)| ((*name).to_owned(), *kind)).collect()
            } else {
                DRONE.iter().map(|(name, kind)| (format!("node{node}.{name}"), *kind)).collect()
            };
            let mut create = vec![6, node.0];
            for (name, kind) in variables {
                let row = rows.get(&name).ok_or(name)?;
                create.push(kind as u8);
                create.extend(row.to_le_bytes());
            }
            left.extend(control(&create));
            left.extend(control(&[3, node.0, if is_base { BASE_PERIOD } else { DRONE_PERIOD }]));
        }
        Ok(Self { left, sent: None })
    }

    /// The setup of a single block, with these variables, for any drone.
    ///
    /// # Errors
    /// The name of the variable that the drone does not have.
    pub fn of_one(block: u8, variables: &[(&str, LogType)], rows: &Rows) -> Result<Self, String> {
        let mut left = VecDeque::new();
        left.extend(control(&[5]));
        let mut create = vec![6, block];
        for (name, kind) in variables {
            let row = rows.get(*name).ok_or_else(|| (*name).to_owned())?;
            create.push(*kind as u8);
            create.extend(row.to_le_bytes());
        }
        left.extend(control(&create));
        left.extend(control(&[3, block, BASE_PERIOD]));
        Ok(Self { left, sent: None })
    }

    /// Whether every block was created and started.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.left.is_empty()
    }

    /// The next request to be sent, if one is due.
    pub fn poll(&mut self, now: Instant) -> Option<Packet> {
        if self.sent.is_some_and(|sent| now.since(sent) < AGAIN) {
            return None;
        }
        self.sent = Some(now);
        self.left.front().copied()
    }

    /// Takes a packet of the base: an answer ends its request. A request that was repeated because
    /// its answer was lost is answered with an error, and has been carried out all the same.
    pub fn receive(&mut self, packet: &Packet) {
        let is_control = packet.port() == Ok(Port::Log) && packet.channel() == 1;
        let Some(asked) = self.left.front().filter(|_| is_control) else { return };
        let command = |packet: &Packet| packet.data().first().copied();
        let block = |packet: &Packet| packet.data().get(1).copied().unwrap_or_default();
        if command(asked) == command(packet) && block(asked) == block(packet) {
            self.left.pop_front();
            self.sent = None;
        }
    }
}

/// A control request to the log; none of them is longer than a packet.
fn control(data: &[u8]) -> Option<Packet> {
    const { assert!(2 + 3 * DRONE.len() <= MAX_DATA) };
    Packet::new(Port::Log, 1, data).ok()
}

#[cfg(test)]
mod tests {
    use wire::crtp::{Reply, Value};

    use super::*;

    const BASE_NODE: NodeId = NodeId(4);

    fn drone(age: f32, rssi: f32) -> Packet {
        Reply::log_data(2, Instant::ZERO)
            .with(Value::U8(4), LogType::U8)
            .with(Value::U8(0), LogType::U8)
            .with(Value::F32(age), LogType::F32)
            .with(Value::F32(3.9), LogType::F32)
            .with(Value::F32(-1.0), LogType::F32)
            .with(Value::U8(3), LogType::U8)
            .with(Value::F32(rssi), LogType::F32)
            .with(Value::F32(12.5), LogType::F32)
            .packet()
    }

    #[test]
    fn a_drone_is_read_as_it_was_sent() {
        let report = DroneReport {
            state: 4,
            fault: 0,
            age: Duration::from_millis(500),
            battery: Some(Volts(3.9)),
            endurance: None,
            back: Some((NodeId(3), Dbm(-61.0))),
            odometer: Metres(12.5),
        };
        let wanted = Block::Drone(NodeId(2), report);
        assert_eq!(Block::decode(&drone(0.5, -61.0), BASE_NODE), Some(wanted));
    }

    #[test]
    fn a_drone_that_never_spoke_is_no_drone() {
        assert_eq!(Block::decode(&drone(-1.0, 0.0), BASE_NODE), None);
    }

    #[test]
    fn a_missing_variable_is_named() {
        let missing = BlockSetup::new(BASE_NODE, &Rows::new()).unwrap_err();
        assert_eq!(missing, "node0.state");
    }
}
