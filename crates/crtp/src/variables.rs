//! Defines the table of log variables.

use core::f32::consts::PI;

use agent::LinkView;
use flight::{Duties, GRAVITY};
use units::{Dbm, Duration, Metres, NODES, NodeId, Radians, Volts};
use wire::crtp::{LogType, Value};
use wire::p2p::Telemetry;

use crate::snapshot::{NO_NEIGHBOUR, Node, Snapshot};
use crate::table::{Documented, Get, crc_of_row};

/// A log variable.
#[derive(Clone, Copy)]
pub(crate) enum Variable {
    Own(&'static Own),
    OfNode(usize, &'static NodeRow),
}

/// A variable of the drone itself.
pub(crate) struct Own {
    group: &'static str,
    name: &'static str,
    get: Get<Snapshot>,
}

/// A variable of each node's telemetry at the base.
pub(crate) struct NodeRow {
    name: &'static str,
    get: Get<NodeState>,
}

/// The telemetry of a node, and its age in seconds.
struct NodeState {
    telemetry: Telemetry,
    age: f32,
}

impl Variable {
    pub(crate) fn group(self) -> &'static str {
        match self {
            Self::Own(row) => row.group,
            Self::OfNode(node, _) => NODE_GROUPS.get(node).copied().unwrap_or_default(),
        }
    }

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Own(row) => row.name,
            Self::OfNode(_, row) => row.name,
        }
    }

    pub(crate) const fn kind(self) -> LogType {
        match self {
            Self::Own(row) => row.get.kind(),
            Self::OfNode(_, row) => row.get.kind(),
        }
    }

    pub(crate) fn value(self, snapshot: &Snapshot) -> Value {
        match self {
            Self::Own(row) => row.get.value(snapshot),
            Self::OfNode(node, row) => {
                let node = snapshot.nodes.get(node).copied().flatten();
                row.get.value(&NodeState::of(node, snapshot))
            }
        }
    }
}

impl NodeState {
    fn of(node: Option<Node>, snapshot: &Snapshot) -> Self {
        match node {
            Some(Node { telemetry, heard }) => {
                Self { telemetry, age: snapshot.taken.since(heard).as_secs_f32() }
            }
            None => Self { telemetry: NOTHING, age: -1.0 },
        }
    }
}

/// The telemetry of a node that has never sent any.
const NOTHING: Telemetry = Telemetry {
    state: 255,
    fault: 0,
    battery: None,
    endurance: None,
    front: None,
    back: None,
    odometer: Metres::ZERO,
    velocity: units::MetresPerSecond::ZERO,
    height: None,
    heeded: 0,
};

/// The variable in a row.
pub(crate) fn row(id: u16) -> Option<Variable> {
    let id = usize::from(id);
    if let Some(own) = OWN.get(id) {
        return Some(Variable::Own(own));
    }
    let of_node = id - OWN.len();
    let (node, field) = (of_node / NODE_ROWS.len(), of_node % NODE_ROWS.len());
    if node >= NODES {
        return None;
    }
    Some(Variable::OfNode(node, NODE_ROWS.get(field)?))
}

/// Rows.
pub(crate) const COUNT: u16 = (OWN.len() + NODES * NODE_ROWS.len()) as u16;

/// Changes whenever the table does.
pub(crate) const CRC: u32 = {
    let mut crc = 0;
    let mut own: &[Own] = &OWN;
    while let [row, rest @ ..] = own {
        crc = crc_of_row(crc, row.get.kind() as u8, row.group, row.name);
        own = rest;
    }
    let mut groups: &[&str] = &NODE_GROUPS;
    while let [group, other_groups @ ..] = groups {
        let mut rows: &[NodeRow] = &NODE_ROWS;
        while let [row, rest @ ..] = rows {
            crc = crc_of_row(crc, row.get.kind() as u8, group, row.name);
            rows = rest;
        }
        groups = other_groups;
    }
    crc
};

/// Returns all log variables as rows of the book's table, with the groups of the nodes only once,
/// as `nodeN`.
pub fn variables() -> impl Iterator<Item = Documented> {
    let own = OWN.iter().zip(OWN_NOTES).map(|(row, (unit, meaning))| Documented {
        group: row.group,
        name: row.name,
        kind: row.get.kind().name(),
        access: "ro",
        unit,
        meaning,
    });
    let of_nodes = NODE_ROWS.iter().zip(NODE_NOTES).map(|(row, (unit, meaning))| Documented {
        group: "nodeN",
        name: row.name,
        kind: row.get.kind().name(),
        access: "ro",
        unit,
        meaning,
    });
    own.chain(of_nodes)
}

/// One group for each node of a chain.
const NODE_GROUPS: [&str; NODES] = [
    "node0", "node1", "node2", "node3", "node4", "node5", "node6", "node7", "node8", "node9",
    "node10", "node11", "node12", "node13", "node14", "node15",
];

/// Rows of `name: type "unit" "meaning" => getter;` by groups, split into the table and the texts
/// for the book, which are not linked into a firmware.
macro_rules! own {
    ($($group:literal {
        $($name:literal: $kind:ident $unit:literal $meaning:literal => $get:expr;)*
    })*) => {
        static OWN: [Own; [$($($name),*),*].len()] = [
            $($(Own { group: $group, name: $name, get: Get::$kind($get) }),*),*
        ];
        static OWN_NOTES: [(&str, &str); OWN.len()] = [$($(($unit, $meaning)),*),*];
    };
}

/// The same for the group that each node has.
macro_rules! node_rows {
    ($($name:literal: $kind:ident $unit:literal $meaning:literal => $get:expr;)*) => {
        static NODE_ROWS: [NodeRow; [$($name),*].len()] = [
            $(NodeRow { name: $name, get: Get::$kind($get) }),*
        ];
        static NODE_NOTES: [(&str, &str); NODE_ROWS.len()] = [$(($unit, $meaning)),*];
    };
}

own! {
    "stabilizer" {
        "roll": F32 "°" "roll of the board, positive to the right" => |s| degrees(s.attitude.roll);
        "pitch": F32 "°" "pitch of the board, positive with its front up"
            => |s| -degrees(s.attitude.pitch);
        "yaw": F32 "°" "heading of the board, positive to the left; drifts"
            => |s| degrees(s.attitude.yaw);
        "thrust": F32 "1/65535" "mean of the four motors" => |s| thrust(s.duties);
    }
    "stateEstimate" {
        "x": F32 "m" "place: along the nose as it pointed at take-off, by dead reckoning; along the room's x where the drone is told positions"
            => |s| s.position.x;
        "y": F32 "m" "place: to the left of that" => |s| s.position.y;
        "z": F32 "m" "height over ground" => |s| metres(s.height);
        "vx": F32 "m/s" "velocity over ground along the nose"
            => |s| s.velocity.map_or(0.0, |v| v.forward.0);
        "vy": F32 "m/s" "velocity over ground to the left of the nose"
            => |s| s.velocity.map_or(0.0, |v| v.lateral.0);
        "roll": F32 "°" "as stabilizer.roll" => |s| degrees(s.attitude.roll);
        "pitch": F32 "°" "as stabilizer.pitch" => |s| -degrees(s.attitude.pitch);
        "yaw": F32 "°" "as stabilizer.yaw" => |s| degrees(s.attitude.yaw);
    }
    "kalman" {
        "stateX": F32 "m" "as stateEstimate.x" => |s| s.position.x;
        "stateY": F32 "m" "as stateEstimate.y" => |s| s.position.y;
        "stateZ": F32 "m" "as stateEstimate.z" => |s| metres(s.height);
        "varPX": F32 "m²" "variance of stateEstimate.x; infinite while it is not known"
            => |s| s.variance.place;
        "varPY": F32 "m²" "the same of stateEstimate.y" => |s| s.variance.place;
        "varPZ": F32 "m²" "the same of stateEstimate.z" => |s| s.variance.height;
    }
    "gyro" {
        "x": F32 "°/s" "angular velocity about the board's x" => |s| turn(s.gyro.0[0]);
        "y": F32 "°/s" "about its y" => |s| turn(s.gyro.0[1]);
        "z": F32 "°/s" "about its z" => |s| turn(s.gyro.0[2]);
    }
    "acc" {
        "x": F32 "g" "specific force along the board's x" => |s| s.accel.0[0] / GRAVITY;
        "y": F32 "g" "along its y" => |s| s.accel.0[1] / GRAVITY;
        "z": F32 "g" "along its z, 1 at rest" => |s| s.accel.0[2] / GRAVITY;
    }
    "range" {
        "front": U16 "mm" "ranger along the board's x, which looks front left of the way; 32767 when it measures nothing"
            => |s| millimetres(s.ranges.front);
        "back": U16 "mm" "the one that looks rear right" => |s| millimetres(s.ranges.back);
        "left": U16 "mm" "the one that looks rear left" => |s| millimetres(s.ranges.left);
        "right": U16 "mm" "the one that looks front right" => |s| millimetres(s.ranges.right);
        "up": U16 "mm" "the one that looks at the ceiling" => |s| millimetres(s.ranges.up);
        "zrange": U16 "mm" "the one that looks at the ground" => |s| millimetres(s.ranges.down);
    }
    "motion" {
        "motion": U8 "" "the optic flow sensor's motion byte; 176 when its counts count"
            => |s| s.flow.map_or(0, |m| m.flags);
        "deltaX": I16 "counts" "along the chip's x" => |s| s.flow.map_or(0, |m| m.y.saturating_neg());
        "deltaY": I16 "counts" "along the chip's y" => |s| s.flow.map_or(0, |m| m.x.saturating_neg());
        "shutter": U16 "cycles" "exposure" => |s| s.flow.map_or(0, |m| m.shutter);
        "maxRaw": U8 "" "brightest pixel" => |s| s.flow.map_or(0, |m| m.raw_max);
        "minRaw": U8 "" "darkest pixel" => |s| s.flow.map_or(0, |m| m.raw_min);
        "Rawsum": U8 "" "mean brightness" => |s| s.flow.map_or(0, |m| m.raw_sum);
        "squal": U8 "" "a quarter of the features seen" => |s| s.flow.map_or(0, |m| m.squal);
    }
    "pm" {
        "vbat": F32 "V" "battery, under load; 0 while unknown" => |s| s.volts.map_or(0.0, |v| v.0);
        "vbatMV": U16 "mV" "the same" => |s| (s.volts.map_or(0.0, |v| v.0) * 1e3) as u16;
        "state": I8 "" "0 battery, 1 charging, 2 charged, 3 low, 4 shutting down"
            => |s| s.power as i8;
        "batteryLevel": U8 "%" "by voltage, in tens" => |s| level(s.volts);
    }
    "radio" {
        "rssi": U8 "-dBm" "strength of the last packet of a client" => |s| loss(s.radio.rssi);
        "isConnected": U8 "" "1 while a client is there" => |s| s.radio.connected.into();
        "numRxBc": U16 "" "packets that came to all; begins again at 0"
            => |s| s.radio.broadcasts as u16;
        "numRxUc": U16 "" "packets that came to this drone; begins again at 0"
            => |s| s.radio.unicasts as u16;
    }
    "motor" {
        "m1": U16 "1/65535" "front right of the board" => |s| duty(s.duties.0[0]);
        "m2": U16 "1/65535" "rear right" => |s| duty(s.duties.0[1]);
        "m3": U16 "1/65535" "rear left" => |s| duty(s.duties.0[2]);
        "m4": U16 "1/65535" "front left" => |s| duty(s.duties.0[3]);
    }
    "supervisor" {
        "info": U16 "bits" "1 armed, 2 arms itself, 3 can fly, 4 flies, 5 tumbled, 6 locked, 7 crashed"
            => |s| s.supervisor();
    }
    "sys" {
        "canfly": U8 "" "bit 3 of supervisor.info" => |s| bit(s, 3);
        "isFlying": U8 "" "bit 4 of it" => |s| bit(s, 4);
        "isTumbled": U8 "" "bit 5 of it" => |s| bit(s, 5);
        "armed": U8 "" "bit 1 of it" => |s| bit(s, 1);
    }
    "uchain" {
        "state": U8 "" "what the drone is doing, see below; 255 while unknown"
            => |s| s.state.map_or(255, |state| state.code());
        "frontPeer": U8 "" "number of the neighbour towards the head; 255 for none"
            => |s| peer(s.front).0;
        "frontRssi": F32 "dBm" "the link to it, filtered; 0 for none" => |s| rssi(s.front);
        "frontRaw": F32 "dBm" "its last packet; 0 for none" => |s| raw(s.front);
        "backPeer": U8 "" "number of the neighbour towards the base; 255 for none"
            => |s| peer(s.back).0;
        "backRssi": F32 "dBm" "the link to it, filtered; 0 for none" => |s| rssi(s.back);
        "backRaw": F32 "dBm" "its last packet; 0 for none" => |s| raw(s.back);
        "odometer": F32 "m" "way along the tunnel since take-off" => |s| s.odometer.0;
        "forward": F32 "m/s" "velocity along the tunnel, positive towards the head"
            => |s| s.along.0;
        "endurance": F32 "s" "for which the battery still carries it; -1 while unknown"
            => |s| seconds(s.endurance);
        "recalled": U8 "" "1 when a drone of the chain must come home" => |s| s.recalled.into();
        "orders": U16 "" "orders that came in; begins again at 0" => |s| s.link.orders as u16;
        "linkStatus": U8 "" "0 off, 1 listening, 2 member, 3 refused, 4 exhausted"
            => |s| s.link.state as u8;
        "accepted": U32 "" "packets of others taken in" => |s| s.link.accepted;
        "refused": U32 "" "packets refused" => |s| s.link.refused;
        "sent": U32 "" "packets sent" => |s| s.link.sent;
    }
}

node_rows! {
    "state": U8 "" "at the base: what node N last said it is doing; 255 when it never did"
        => |t| t.telemetry.state;
    "fault": U8 "" "what is wrong with it; 0 for nothing" => |t| t.telemetry.fault;
    "age": F32 "s" "since it last said anything; -1 when it never did" => |t| t.age;
    "vbat": F32 "V" "its battery; 0 while unknown"
        => |t| t.telemetry.battery.map_or(0.0, |v| v.0);
    "endurance": F32 "s" "for which its battery still carries it; -1 while unknown"
        => |t| seconds(t.telemetry.endurance);
    "frontPeer": U8 "" "its neighbour towards the head; 255 for none"
        => |t| t.telemetry.front.map_or(NO_NEIGHBOUR, |(peer, _)| peer).0;
    "frontRssi": F32 "dBm" "the link to it; 0 for none"
        => |t| t.telemetry.front.map_or(0.0, |(_, rssi)| rssi.0);
    "backPeer": U8 "" "its neighbour towards the base; 255 for none"
        => |t| t.telemetry.back.map_or(NO_NEIGHBOUR, |(peer, _)| peer).0;
    "backRssi": F32 "dBm" "the link to it; 0 for none"
        => |t| t.telemetry.back.map_or(0.0, |(_, rssi)| rssi.0);
    "odometer": F32 "m" "its way along the tunnel since take-off" => |t| t.telemetry.odometer.0;
    "odometerSd": F32 "m" "how far this may be off, as one standard deviation"
        => |t| agent::odometer_deviation(t.telemetry.odometer).0;
    "forward": F32 "m/s" "its velocity along the tunnel" => |t| t.telemetry.velocity.0;
    "height": F32 "m" "its height over ground; 0 while unknown" => |t| metres(t.telemetry.height);
    "heeded": U16 "" "the last 16 bits of the number of the order that it obeyed last"
        => |t| t.telemetry.heeded;
}

fn degrees(angle: Radians) -> f32 {
    turn(angle.0)
}

fn turn(radians: f32) -> f32 {
    radians * (180.0 / PI)
}

fn metres(length: Option<Metres>) -> f32 {
    length.map_or(0.0, |length| length.0)
}

fn seconds(span: Option<Duration>) -> f32 {
    span.map_or(-1.0, Duration::as_secs_f32)
}

/// The vendor's value for "nothing measured" (`range.h`).
const OUT_OF_RANGE: u16 = 32_767;

fn millimetres(range: Option<Metres>) -> u16 {
    range.map_or(OUT_OF_RANGE, |range| ((range.0 * 1e3 + 0.5) as u16).min(OUT_OF_RANGE))
}

fn duty(duty: f32) -> u16 {
    (duty * 65_535.0) as u16
}

fn thrust(Duties([a, b, c, d]): Duties) -> f32 {
    (a + b + c + d) * (65_535.0 / 4.0)
}

/// Volts at which a tenth of the charge more is left (crazyflie-firmware, `pm_stm32f4.c`).
const TENTHS: [f32; 9] = [3.78, 3.83, 3.87, 3.89, 3.92, 3.96, 4.00, 4.04, 4.10];

/// As the vendor's firmware counts, with all of it at 4.2 V.
fn level(volts: Option<Volts>) -> u8 {
    let Some(Volts(volts)) = volts else { return 0 };
    if volts >= 4.2 {
        100
    } else {
        10 * TENTHS.iter().filter(|least| volts > **least).count() as u8
    }
}

fn loss(rssi: Option<Dbm>) -> u8 {
    rssi.map_or(0, |rssi| -rssi.0 as u8)
}

fn peer(link: Option<LinkView>) -> NodeId {
    link.map_or(NO_NEIGHBOUR, |link| link.peer)
}

fn rssi(link: Option<LinkView>) -> f32 {
    link.map_or(0.0, |link| link.rssi.0)
}

fn raw(link: Option<LinkView>) -> f32 {
    link.map_or(0.0, |link| link.raw.0)
}

fn bit(of: &Snapshot, bit: u16) -> u8 {
    (of.supervisor() >> bit) as u8 & 1
}
