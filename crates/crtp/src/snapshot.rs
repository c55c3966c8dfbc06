//! What can be looked at, at one moment.

use agent::{BodyVelocity, LinkView};
use flight::{Attitude, Duties, Mode, StopCause};
use sensors::pmw3901::Motion;
use units::{
    Acceleration, AngularVelocity, Dbm, Duration, Instant, Metres, MetresPerSecond, NODES, NodeId,
    Volts,
};
use wire::p2p::Telemetry;

/// What a drone knows of itself and, at the base, of the others. What nobody fills in stays as in
/// [`Snapshot::DEFAULT`] and shows as nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snapshot {
    /// When it was taken.
    pub taken: Instant,
    /// What the drone's mind is doing.
    pub state: Option<agent::State>,
    /// The link towards the head.
    pub front: Option<LinkView>,
    /// The link towards the base.
    pub back: Option<LinkView>,
    /// Its way along the tunnel since take-off.
    pub odometer: Metres,
    /// Its velocity along the tunnel, positive towards the head.
    pub along: MetresPerSecond,
    /// Somebody in the chain must come home.
    pub recalled: bool,
    /// What the flight code is doing.
    pub mode: Option<Mode>,
    /// How the board is turned.
    pub attitude: Attitude,
    /// Velocity over ground, along the nose and to its left.
    pub velocity: Option<BodyVelocity>,
    /// Height over ground.
    pub height: Option<Metres>,
    /// How the motors are driven.
    pub duties: Duties,
    /// Angular velocity about the board's axes.
    pub gyro: AngularVelocity,
    /// Specific force along the board's axes.
    pub accel: Acceleration,
    /// What the rangers see.
    pub ranges: Ranges,
    /// What the optic flow sensor said last.
    pub flow: Option<Motion>,
    /// At the battery's terminals.
    pub volts: Option<Volts>,
    /// What the battery is doing.
    pub power: Power,
    /// How long the battery still carries the drone.
    pub endurance: Option<Duration>,
    /// The radio.
    pub radio: Radio,
    /// The chain's link.
    pub link: Link,
    /// What the others have told; filled at the base only.
    pub nodes: [Option<Node>; NODES],
}

impl Snapshot {
    /// Of nothing.
    pub const DEFAULT: Self = Self {
        taken: Instant::ZERO,
        state: None,
        front: None,
        back: None,
        odometer: Metres::ZERO,
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

    /// What the supervisor sees, by the bits of `supervisor.info` (crazyflie-firmware,
    /// `supervisor.c`). Nobody arms these drones: they are armed whenever they would fly.
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

/// What the rangers see, by where they look from the board; `None` where nothing was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ranges {
    /// Along x.
    pub front: Option<Metres>,
    /// Against x.
    pub back: Option<Metres>,
    /// Along y.
    pub left: Option<Metres>,
    /// Against y.
    pub right: Option<Metres>,
    /// At the ceiling.
    pub up: Option<Metres>,
    /// At the ground.
    pub down: Option<Metres>,
}

impl Ranges {
    /// Nothing.
    pub const NONE: Self =
        Self { front: None, back: None, left: None, right: None, up: None, down: None };
}

/// What the battery is doing, by the numbers of `pm.state` (crazyflie-firmware, `pm.h`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(i8)]
pub enum Power {
    /// It is drawn on.
    #[default]
    Battery = 0,
    /// It is filled.
    Charging = 1,
    /// It is full, and at a charger.
    Charged = 2,
    /// It is nearly empty.
    Low = 3,
    /// The drone is being switched off.
    ShuttingDown = 4,
}

/// The radio.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Radio {
    /// How strongly the last packet of a client came in.
    pub rssi: Option<Dbm>,
    /// Whether a client is there.
    pub connected: bool,
    /// Packets that came to all.
    pub broadcasts: u32,
    /// Packets that came to this drone alone.
    pub unicasts: u32,
}

impl Radio {
    /// Nothing came in.
    pub const SILENT: Self = Self { rssi: None, connected: false, broadcasts: 0, unicasts: 0 };
}

/// The chain's link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Link {
    /// Whether the drone speaks, and if not, why.
    pub state: LinkState,
    /// Packets of others that were taken in.
    pub accepted: u32,
    /// Packets that were refused, for whatever reason.
    pub refused: u32,
    /// Packets that were sent.
    pub sent: u32,
    /// Orders that came in.
    pub orders: u32,
}

impl Link {
    /// Nothing was said.
    pub const SILENT: Self =
        Self { state: LinkState::Off, accepted: 0, refused: 0, sent: 0, orders: 0 };
}

/// Whether a drone takes part in the chain's link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum LinkState {
    /// It has no keys, or no radio.
    #[default]
    Off = 0,
    /// It listens before it speaks.
    Listening = 1,
    /// It takes part.
    Member = 2,
    /// It may not take part: its number is another's, or has no slot.
    Refused = 3,
    /// It has said all that it may until the next boot.
    Exhausted = 4,
}

/// What another drone has told the base of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// What it told.
    pub telemetry: Telemetry,
    /// When that came in.
    pub heard: Instant,
}

/// The number of a neighbour that is not there.
pub(crate) const NOBODY: NodeId = NodeId(255);
