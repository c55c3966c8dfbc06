//! The record of a flight, by the truth: extremes, take-offs, landings and their causes.

use flight::{Cause, Mode, Status, StopCause};

use super::body::RigidBody;

/// One drone's flight so far.
#[derive(Clone, Debug)]
pub struct Record {
    airborne: bool,
    /// Cosine of the largest tilt in the air.
    least_upright: f32,
    /// Square of the largest angular velocity in the air, (rad/s)².
    most_rate2: f32,
    least_volts: f32,
    take_offs: u32,
    ends: Vec<End>,
    mode: Option<Mode>,
    velocity_error2: f64,
    velocity_samples: u32,
    touchdown: Option<Touchdown>,
    /// The speed of the fall before the body touched the floor.
    sinking: f32,
}

/// How the flight code ended a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The flight code switched the motors off by order, on the ground.
    Told,
    /// The flight code landed of its own accord.
    Landed(Cause),
    /// The flight code stopped the motors for good.
    Stopped(StopCause),
}

impl End {
    /// All of them.
    pub const ALL: [Self; 12] = [
        Self::Told,
        Self::Landed(Cause::NoSetpoint),
        Self::Landed(Cause::NoImu),
        Self::Landed(Cause::NoFlow),
        Self::Landed(Cause::NoHeight),
        Self::Landed(Cause::Battery),
        Self::Landed(Cause::Overload),
        Self::Landed(Cause::Blocked),
        Self::Stopped(StopCause::Ordered),
        Self::Stopped(StopCause::Tumbled),
        Self::Stopped(StopCause::FreeFall),
        Self::Stopped(StopCause::PropellerStuck),
    ];

    /// The name in the table.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Told => "told",
            Self::Landed(Cause::NoSetpoint) => "no-setpoint",
            Self::Landed(Cause::NoImu) => "no-imu",
            Self::Landed(Cause::NoFlow) => "no-flow",
            Self::Landed(Cause::NoHeight) => "no-height",
            Self::Landed(Cause::Battery) => "battery",
            Self::Landed(Cause::Overload) => "overload",
            Self::Landed(Cause::Blocked) => "blocked",
            Self::Stopped(StopCause::Ordered) => "ordered",
            Self::Stopped(StopCause::Tumbled) => "tumbled",
            Self::Stopped(StopCause::FreeFall) => "free-fall",
            Self::Stopped(StopCause::PropellerStuck) => "propeller-stuck",
        }
    }
}

/// How a body met the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touchdown {
    /// When, in milliseconds since it was switched on.
    pub at_ms: u64,
    /// The speed of the descent, m/s.
    pub speed: f32,
    /// Cosine of its tilt.
    pub upright: f32,
}

/// The flights of all drones of a mission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlightMetrics {
    /// The largest tilt in the air, degrees.
    pub max_tilt_deg: f32,
    /// The largest angular velocity in the air, degrees a second.
    pub max_rate_dps: f32,
    /// Root mean square of the error of the estimated velocity over ground, m/s.
    pub velocity_error_mps: f32,
    /// The lowest voltage of any battery under load.
    pub min_battery_v: f32,
    /// The number of take-offs.
    pub take_offs: u32,
    /// The number of landings on the feet, by order or by itself.
    pub landings: u32,
    /// How flights ended, counted in the order of [`End::ALL`].
    pub ends: [u32; End::ALL.len()],
}

impl FlightMetrics {
    /// The sum over these drones; `None` where there are none.
    pub fn of<'a>(records: impl Iterator<Item = &'a Record>) -> Option<Self> {
        let mut all = Self {
            max_tilt_deg: 0.0,
            max_rate_dps: 0.0,
            velocity_error_mps: f32::NAN,
            min_battery_v: f32::INFINITY,
            take_offs: 0,
            landings: 0,
            ends: [0; End::ALL.len()],
        };
        let (mut drones, mut error2, mut samples) = (0, 0.0, 0);
        for record in records {
            drones += 1;
            all.max_tilt_deg = all.max_tilt_deg.max(record.most_tilt_deg());
            all.max_rate_dps = all.max_rate_dps.max(record.most_rate_dps());
            all.min_battery_v = all.min_battery_v.min(record.least_volts);
            all.take_offs += record.take_offs;
            for end in &record.ends {
                all.landings += u32::from(!matches!(end, End::Stopped(_)));
                let places = End::ALL.iter().zip(&mut all.ends);
                places.filter(|(known, _)| *known == end).for_each(|(_, count)| *count += 1);
            }
            error2 += record.velocity_error2;
            samples += record.velocity_samples;
        }
        if samples > 0 {
            all.velocity_error_mps = libm::sqrt(error2 / f64::from(samples)) as f32;
        }
        (drones > 0).then_some(all)
    }

    /// The endings of flights, by name, without those that never happened.
    pub fn ends(&self) -> impl Iterator<Item = (&'static str, u32)> {
        End::ALL.iter().zip(self.ends).filter(|(_, n)| *n > 0).map(|(end, n)| (end.name(), n))
    }
}

/// A body above this height has left the floor, m.
const ABOVE_FLOOR: f32 = 0.03;
/// Velocities are compared this often, ms.
const COMPARE_EVERY: u64 = 10;

impl Record {
    /// The record of a drone that stands.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            airborne: false,
            least_upright: 1.0,
            most_rate2: 0.0,
            least_volts: f32::INFINITY,
            take_offs: 0,
            ends: Vec::new(),
            mode: None,
            velocity_error2: 0.0,
            velocity_samples: 0,
            touchdown: None,
            sinking: 0.0,
        }
    }

    /// The record of a drone that flies already.
    pub(super) fn begun_flying(mode: Mode) -> Self {
        Self { airborne: true, mode: Some(mode), ..Self::new() }
    }

    /// Takes one sample.
    pub(super) fn look(&mut self, now_ms: u64, body: &RigidBody, status: &Status, volts: f32) {
        self.least_volts = self.least_volts.min(volts);
        if body.is_on_floor() {
            if self.airborne {
                self.airborne = false;
                let touchdown =
                    Touchdown { at_ms: now_ms, speed: self.sinking, upright: body.uprightness() };
                self.touchdown = Some(touchdown);
            }
        } else if body.height() > ABOVE_FLOOR {
            self.airborne = true;
        }
        self.sinking = -body.velocity()[2];
        if self.airborne {
            self.least_upright = self.least_upright.min(body.uprightness());
            let [p, q, r] = body.rates();
            self.most_rate2 = self.most_rate2.max(p * p + q * q + r * r);
        }
        self.compare(now_ms, body, status);
        self.follow(status.mode);
    }

    /// Compares the flight code's estimate of the velocity, over ground along its heading, with the
    /// truth.
    fn compare(&mut self, now_ms: u64, body: &RigidBody, status: &Status) {
        let Some([x, y]) = status.velocity else { return };
        if !self.airborne || !now_ms.is_multiple_of(COMPARE_EVERY) {
            return;
        }
        let truth = body.velocity_ahead();
        let (dx, dy) = (x.0 - truth[0], y.0 - truth[1]);
        self.velocity_error2 += f64::from(dx * dx + dy * dy);
        self.velocity_samples += 1;
    }

    /// Notes the changes of the flight code's mode.
    fn follow(&mut self, mode: Mode) {
        let before = self.mode.replace(mode);
        let flew = before.is_some_and(|mode| mode.is_airborne());
        let end = match mode {
            Mode::Flying { .. } if !flew => {
                self.take_offs += 1;
                return;
            }
            Mode::Landing { why, .. } if !matches!(before, Some(Mode::Landing { .. })) => {
                End::Landed(why)
            }
            Mode::Stopped { why } if !matches!(before, Some(Mode::Stopped { .. })) => {
                End::Stopped(why)
            }
            Mode::Landed { why } if matches!(before, Some(Mode::Flying { .. })) => End::Landed(why),
            Mode::Grounded { .. } if matches!(before, Some(Mode::Flying { .. })) => End::Told,
            _ => return,
        };
        self.ends.push(end);
    }

    /// Whether it has left the floor.
    #[must_use]
    pub const fn is_airborne(&self) -> bool {
        self.airborne
    }

    /// Cosine of the largest tilt in the air.
    #[must_use]
    pub const fn least_upright(&self) -> f32 {
        self.least_upright
    }

    /// The largest tilt in the air, in degrees.
    #[must_use]
    pub fn most_tilt_deg(&self) -> f32 {
        libm::acosf(self.least_upright.clamp(-1.0, 1.0)).to_degrees()
    }

    /// The largest angular velocity in the air, in degrees a second.
    #[must_use]
    pub fn most_rate_dps(&self) -> f32 {
        libm::sqrtf(self.most_rate2).to_degrees()
    }

    /// The lowest voltage at the battery's terminals.
    #[must_use]
    pub const fn least_volts(&self) -> f32 {
        self.least_volts
    }

    /// The number of take-offs.
    #[must_use]
    pub const fn take_offs(&self) -> u32 {
        self.take_offs
    }

    /// The endings of its flights, in order.
    #[must_use]
    pub fn ends(&self) -> &[End] {
        &self.ends
    }

    /// The sum of the squares of the velocity's errors, and their number.
    #[must_use]
    pub const fn velocity_error2(&self) -> (f64, u32) {
        (self.velocity_error2, self.velocity_samples)
    }

    /// How it last met the floor.
    #[must_use]
    pub const fn touchdown(&self) -> Option<Touchdown> {
        self.touchdown
    }
}

impl Default for Record {
    fn default() -> Self {
        Self::new()
    }
}
