//! The faults of a drone, and their times.
//!
//! | sensor | lost | frozen | lying |
//! |---|---|---|---|
//! | gyroscope | no sample | the last sample again and again | +1 rad/s about one axis |
//! | accelerometer | no sample | the last sample again and again | +2 m/s² along one axis |
//! | IMU | both of these | both of these | both of these |
//! | flow | no reading | its last reading | counts doubled, or 10 counts more along one axis: 0.6 m/s at 0.3 m |
//! | down ranger | no reading | its last reading, stream count and all | 1 m too far, or half |
//! | Flow deck | both of these | both of these | both of these |
//! | side rangers | no reading | their last readings | 1 m too far, or half |
//! | battery | no reading | its last reading | 4.2 V |
//!
//! The seed decides the axis, the motor, and which of two wrong readings is given.

use random::Stream;
use sensors::pmw3901::Motion;
use sensors::vl53l1x::Reading;
use units::{Acceleration, AngularVelocity, Metres, Volts};

use super::body::Vector;

/// A sensor, or one half of the IMU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensor {
    /// Gyroscope and accelerometer together.
    Imu,
    /// The gyroscope alone.
    Gyro,
    /// The accelerometer alone.
    Accel,
    /// The optic flow.
    Flow,
    /// The ranger that looks down.
    Down,
    /// The Flow deck: optic flow and the ranger that looks down.
    FlowDeck,
    /// One of the side rangers.
    OneSide,
    /// All four, and so the Multi-ranger deck.
    AllSides,
    /// The voltage at the battery.
    Battery,
}

impl Sensor {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Imu,
        Self::Gyro,
        Self::Accel,
        Self::Flow,
        Self::Down,
        Self::FlowDeck,
        Self::OneSide,
        Self::AllSides,
        Self::Battery,
    ];

    /// The name in the table.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Imu => "imu",
            Self::Gyro => "gyro",
            Self::Accel => "accel",
            Self::Flow => "flow",
            Self::Down => "down-ranger",
            Self::FlowDeck => "flow-deck",
            Self::OneSide => "side-ranger",
            Self::AllSides => "side-rangers",
            Self::Battery => "battery-reading",
        }
    }
}

/// How a sensor fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Manner {
    /// The sensor gives no readings.
    Lost,
    /// The sensor repeats its last reading.
    Frozen,
    /// The sensor gives wrong readings.
    Lying,
}

impl Manner {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Lost, Self::Frozen, Self::Lying];

    /// The name in the table.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lost => "lost",
            Self::Frozen => "frozen",
            Self::Lying => "lying",
        }
    }
}

/// A kind of fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// A sensor fails.
    Sensor(Sensor, Manner),
    /// One motor gives this part of its thrust from now on.
    WeakMotor(f32),
    /// The battery has this part of its charge left.
    LowBattery(f32),
    /// The air moves at this speed, m/s.
    Gust(f32),
    /// The lights go out.
    DarkGround,
    /// The drone neither hears nor is heard. The caller that gives set-points must hold them back.
    RadioSilence,
    /// Steps of the flight code come 0.2 to 5 ms late.
    TickJitter,
}

/// A fault and its time, in milliseconds since the drone was switched on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Failing {
    /// The kind of fault.
    pub fault: Fault,
    /// When the fault begins.
    pub from_ms: u64,
    /// When it ends.
    pub until_ms: u64,
}

impl Failing {
    /// Whether the fault is active now.
    #[must_use]
    pub const fn is_on(&self, now_ms: u64) -> bool {
        self.from_ms <= now_ms && now_ms < self.until_ms
    }
}

/// The fault of one drone, with the choices of the seed.
#[derive(Clone, Debug)]
pub struct Saboteur {
    failing: Failing,
    /// The axis, side or motor.
    pub(super) which: usize,
    /// Which of two wrong readings is given.
    second: bool,
    gyro: Option<AngularVelocity>,
    accel: Option<Acceleration>,
    flow: Option<Motion>,
    down: Option<Reading>,
    sides: [Option<Reading>; 4],
    battery: Option<Volts>,
    struck: bool,
}

impl Saboteur {
    /// Draws the choices.
    #[must_use]
    pub fn new(failing: Failing, random: &mut Stream) -> Self {
        Self {
            failing,
            which: (random.uniform() * 4.0) as usize,
            second: random.uniform() < 0.5,
            gyro: None,
            accel: None,
            flow: None,
            down: None,
            sides: [None; 4],
            battery: None,
            struck: false,
        }
    }

    /// Returns true once.
    pub(super) const fn strikes_now(&mut self) -> bool {
        !std::mem::replace(&mut self.struck, true)
    }

    /// The active fault, if there is one.
    pub(super) fn fault(&self, now_ms: u64) -> Option<Fault> {
        self.failing.is_on(now_ms).then_some(self.failing.fault)
    }

    fn on(&self, now_ms: u64, sensors: &[Sensor]) -> Option<(Sensor, Manner)> {
        match self.fault(now_ms)? {
            Fault::Sensor(sensor, manner) if sensors.contains(&sensor) => Some((sensor, manner)),
            _ => None,
        }
    }

    pub(super) fn gyro(&mut self, now_ms: u64, rates: AngularVelocity) -> Option<AngularVelocity> {
        let fails = self.on(now_ms, &[Sensor::Imu, Sensor::Gyro]);
        let mut lie = rates;
        add(&mut lie.0, self.which, 1.0);
        said(fails, &mut self.gyro, rates, lie)
    }

    pub(super) fn accel(&mut self, now_ms: u64, force: Acceleration) -> Option<Acceleration> {
        let fails = self.on(now_ms, &[Sensor::Imu, Sensor::Accel]);
        let mut lie = force;
        add(&mut lie.0, self.which, 2.0);
        said(fails, &mut self.accel, force, lie)
    }

    pub(super) fn flow(&mut self, now_ms: u64, reading: Motion) -> Option<Motion> {
        let fails = self.on(now_ms, &[Sensor::Flow, Sensor::FlowDeck]);
        let (x, y) = match (self.second, self.which % 2) {
            (true, _) => (reading.x.saturating_mul(2), reading.y.saturating_mul(2)),
            (false, 0) => (reading.x.saturating_add(10), reading.y),
            (false, _) => (reading.x, reading.y.saturating_add(10)),
        };
        let moved = (x, y) != (0, 0);
        let lie = Motion { x, y, moved, flags: if moved { 0xB0 } else { 0x30 }, ..reading };
        said(fails, &mut self.flow, reading, lie)
    }

    pub(super) fn down(&mut self, now_ms: u64, reading: Reading) -> Option<Reading> {
        let fails = self.on(now_ms, &[Sensor::Down, Sensor::FlowDeck]);
        let lie = self.wrong_range(reading);
        said(fails, &mut self.down, reading, lie)
    }

    pub(super) fn side(&mut self, now_ms: u64, side: usize, reading: Reading) -> Option<Reading> {
        let fails = self
            .on(now_ms, &[Sensor::OneSide, Sensor::AllSides])
            .filter(|(sensor, _)| *sensor == Sensor::AllSides || side == self.which);
        let lie = self.wrong_range(reading);
        let Some(last) = self.sides.get_mut(side) else { return Some(reading) };
        said(fails, last, reading, lie)
    }

    pub(super) fn battery(&mut self, now_ms: u64, volts: Volts) -> Option<Volts> {
        let fails = self.on(now_ms, &[Sensor::Battery]);
        said(fails, &mut self.battery, volts, Volts(4.2))
    }

    fn wrong_range(&self, reading: Reading) -> Reading {
        let is = reading.distance.0;
        let distance = Metres(if self.second { 0.5 * is } else { is + 1.0 });
        Reading { distance, ..reading }
    }
}

/// The readings of a sensor, and the last one for when it freezes.
fn said<T: Copy>(
    fails: Option<(Sensor, Manner)>,
    last: &mut Option<T>,
    truth: T,
    lie: T,
) -> Option<T> {
    match fails.map(|(_, manner)| manner) {
        None => {
            *last = Some(truth);
            Some(truth)
        }
        Some(Manner::Lost) => None,
        Some(Manner::Frozen) => *last,
        Some(Manner::Lying) => Some(lie),
    }
}

fn add(to: &mut Vector, axis: usize, amount: f32) {
    if let Some(value) = to.get_mut(axis % 3) {
        *value += amount;
    }
}
