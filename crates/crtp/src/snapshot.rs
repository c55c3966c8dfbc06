//! Holds the values of all log variables at one moment.

use agent::{BodyVelocity, LinkView};
use flight::{Attitude, Duties, Mode, StopCause};
use sensors::pmw3901::Motion;
use units::{
    Acceleration, AngularVelocity, Dbm, Duration, Instant, Metres, MetresPerSecond, NODES, NodeId,
    Point2, Volts,
};
use wire::p2p::Telemetry;

/// The state of a drone and, at the base, of the others. A field that is not filled in keeps its
/// value of [`Snapshot::DEFAULT`], "unknown" or zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snapshot {
    /// The time at which the snapshot was taken.
    pub taken: Instant,
    /// The state of the agent.
    pub state: Option<agent::State>,
    /// The link towards the head.
    pub front: Option<LinkView>,
    /// The link towards the base.
    pub back: Option<LinkView>,
    /// The distance along the tunnel that the drone has flown since take-off.
    pub odometer: Metres,
    /// The drone's place in the frame of its take-off, or in the room where the drone knows that.
    pub position: Point2,
    /// How well the drone knows its place and its height.
    pub variance: Variance,
    /// The drone's velocity along the tunnel, positive towards the head.
    pub along: MetresPerSecond,
    /// Whether a drone of the chain must come home.
    pub recalled: bool,
    /// The mode of the flight code.
    pub mode: Option<Mode>,
    /// The attitude of the board.
    pub attitude: Attitude,
    /// The velocity over ground, along the nose and to its left.
    pub velocity: Option<BodyVelocity>,
    /// The height over ground.
    pub height: Option<Metres>,
    /// The duties of the motors.
    pub duties: Duties,
    /// The angular velocity about the board's axes.
    pub gyro: AngularVelocity,
    /// The specific force along the board's axes.
    pub accel: Acceleration,
    /// The readings of the rangers.
    pub ranges: Ranges,
    /// The last reading of the optic flow sensor.
    pub flow: Option<Motion>,
    /// The voltage at the battery's terminals.
    pub volts: Option<Volts>,
    /// Whether the battery is used, charging or full.
    pub power: Power,
    /// The time for which the battery still carries the drone.
    pub endurance: Option<Duration>,
    /// The radio.
    pub radio: Radio,
    /// The chain's link.
    pub link: Link,
    /// The telemetry of the other drones; filled at the base only.
    pub nodes: [Option<Node>; NODES],
}

impl Snapshot {
    /// A snapshot in which every value is unknown.
    pub const DEFAULT: Self = Self {
        taken: Instant::ZERO,
        state: None,
        front: None,
        back: None,
        odometer: Metres::ZERO,
        position: Point2::new(0.0, 0.0),
        variance: Variance::UNKNOWN,
        along: MetresPerSecond::ZERO,
        recalled: false,
        mode: None,
        attitude: Attitude {
            roll: units::Radians::ZERO,
            pitch: units::Radians::ZERO,
            yaw: units::Radians::ZERO,
        },
        velocity: None,
        height: None,
        duties: Duties::OFF,
        gyro: AngularVelocity([0.0; 3]),
        accel: Acceleration([0.0; 3]),
        ranges: Ranges::NONE,
        flow: None,
        volts: None,
        power: Power::Battery,
        endurance: None,
        radio: Radio::SILENT,
        link: Link::SILENT,
        nodes: [None; NODES],
    };

    /// The bits of `supervisor.info` (crazyflie-firmware, `supervisor.c`). These drones need no
    /// arming: they are armed whenever they are ready to fly.
    pub(crate) fn supervisor(&self) -> u16 {
        const ARMED: u16 = 1 << 1;
        const ARMS_ITSELF: u16 = 1 << 2;
        const CAN_FLY: u16 = 1 << 3;
        const FLIES: u16 = 1 << 4;
        const TUMBLED: u16 = 1 << 5;
        const LOCKED: u16 = 1 << 6;
        const CRASHED: u16 = 1 << 7;
        let ready = ARMED | ARMS_ITSELF | CAN_FLY;
        match self.mode {
            Some(Mode::Grounded { waits_for: None }) => ready,
            Some(Mode::Flying { .. } | Mode::Landing { .. }) => ready | FLIES,
            Some(Mode::Grounded { waits_for: Some(_) } | Mode::Landed { .. }) => ARMS_ITSELF,
            Some(Mode::Stopped { why: StopCause::Tumbled }) => LOCKED | CRASHED | TUMBLED,
            Some(Mode::Stopped { why: StopCause::Ordered }) => LOCKED,
            Some(Mode::Stopped { .. }) => LOCKED | CRASHED,
            // A drone without a body, as the simulator has them.
            None => match self.state {
                Some(state) if state.is_airborne() => ready | FLIES,
                Some(agent::State::Stopped) => LOCKED,
                Some(_) => ready,
                None => 0,
            },
        }
    }
}

impl Default for Snapshot {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The variances of a drone's estimate of where it is, m²; infinite where it has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variance {
    /// The variance of the place along each of its two axes.
    pub place: f32,
    /// The variance of the height over ground.
    pub height: f32,
}

impl Variance {
    /// The variances of a drone that does not know where it is.
    pub const UNKNOWN: Self = Self { place: f32::INFINITY, height: f32::INFINITY };
    /// The variances of a node that stands where its coordinates begin.
    pub const ORIGIN: Self = Self { place: 0.0, height: 0.0 };
}

/// The readings of the rangers, by their direction from the board; `None` where there is none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ranges {
    /// The ranger along x.
    pub front: Option<Metres>,
    /// The ranger against x.
    pub back: Option<Metres>,
    /// The ranger along y.
    pub left: Option<Metres>,
    /// The ranger against y.
    pub right: Option<Metres>,
    /// The ranger that looks up.
    pub up: Option<Metres>,
    /// The ranger that looks down.
    pub down: Option<Metres>,
}

impl Ranges {
    /// The readings before any ranger has measured.
    pub const NONE: Self =
        Self { front: None, back: None, left: None, right: None, up: None, down: None };
}

/// The state of battery and charger, by the numbers of `pm.state` (crazyflie-firmware, `pm.h`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(i8)]
pub enum Power {
    /// The battery supplies the drone.
    #[default]
    Battery = 0,
    /// The battery is charging.
    Charging = 1,
    /// The battery is full, and at a charger.
    Charged = 2,
    /// The battery is nearly empty.
    Low = 3,
    /// The drone is being switched off.
    ShuttingDown = 4,
}

/// The radio.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Radio {
    /// The strength of the last packet of a client.
    pub rssi: Option<Dbm>,
    /// Whether a client is connected.
    pub connected: bool,
    /// The number of packets received that were sent to all drones.
    pub broadcasts: u32,
    /// The number of packets received that were sent to this drone alone.
    pub unicasts: u32,
}

impl Radio {
    /// The state of a radio that has received nothing.
    pub const SILENT: Self = Self { rssi: None, connected: false, broadcasts: 0, unicasts: 0 };
}

/// The chain's link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Link {
    /// Whether the drone takes part in the chain, and if not, why.
    pub state: LinkState,
    /// The number of packets of other nodes that were accepted.
    pub accepted: u32,
    /// The number of packets that were refused, for any reason.
    pub refused: u32,
    /// The number of packets that were sent.
    pub sent: u32,
    /// The number of orders that were received.
    pub orders: u32,
}

impl Link {
    /// The state of a link that is off.
    pub const SILENT: Self =
        Self { state: LinkState::Off, accepted: 0, refused: 0, sent: 0, orders: 0 };
}

/// Whether a drone takes part in the chain's link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum LinkState {
    /// The drone has no keys, or no radio.
    #[default]
    Off = 0,
    /// The drone listens before it transmits.
    Listening = 1,
    /// The drone takes part.
    Member = 2,
    /// The drone may not take part: another drone has its number, or the number has no turn to
    /// transmit.
    Refused = 3,
    /// The drone has used all packet numbers of this boot.
    Exhausted = 4,
}

/// The telemetry of another drone at the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// The last telemetry that was received.
    pub telemetry: Telemetry,
    /// The time at which it was received.
    pub heard: Instant,
}

/// The number that stands for no neighbour.
pub(crate) const NO_NEIGHBOUR: NodeId = NodeId(255);
