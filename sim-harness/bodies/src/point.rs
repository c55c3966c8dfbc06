//! A drone's body at point level: a disc on the floor plan that follows velocity commands with a
//! lag, measures its own motion with an error, and does not go through walls.

mod battery;

use agent::{BodyVelocity, Fitness};
use tunnel_nav::{Diagonals, Range};
use units::{Duration, Metres, MetresPerSecond, Point2, Setpoint, Volts};

use scenario::VehicleSpec;

use super::craft::{Surroundings, level_range};

use battery::PointBattery;
use random::Stream;
use world::Tunnel;

/// Time constant of the yaw-rate response, s: the attitude loop is faster than the velocity
/// loop.
const YAW_LAG: f32 = 0.1;
/// Fastest climb and descent, m/s.
const CLIMB: f32 = 0.4;

/// The length of a physics step in microseconds.
pub const STEP_US: u64 = 20_000;
const STEP_S: f32 = STEP_US as f32 * 1e-6;

/// The part of a first-order response that happens in one physics step.
#[derive(Clone, Copy, Debug)]
pub struct Response {
    velocity: f32,
    yaw: f32,
}

impl Response {
    /// The response of a vehicle.
    pub fn new(spec: &VehicleSpec) -> Self {
        let part = |lag: f32| if lag > 0.0 { -libm::expm1f(-STEP_S / lag) } else { 1.0 };
        Self { velocity: part(spec.lag), yaw: part(YAW_LAG) }
    }
}

/// One drone's body.
#[derive(Clone, Debug)]
pub struct PointBody {
    position: Point2,
    height: f32,
    /// Unit vector along the nose.
    nose: [f32; 2],
    /// The velocity in body axes: forward, left.
    velocity: [f32; 2],
    yaw_rate: f32,
    setpoint: Setpoint,
    /// The way in body axes since the flow was last read.
    moved: [f32; 2],
    flow_scale: f32,
    touching: bool,
    contacts: u32,
    /// How far the body can move before it may touch a wall, m.
    clear_way: f32,
    /// Its battery; `None` for a body that flies for as long as it is told to.
    battery: Option<PointBattery>,
}

impl PointBody {
    /// A body at rest at this point, its nose along the unit vector `nose`.
    pub fn at(
        position: Point2,
        nose: [f32; 2],
        height: f32,
        spec: &VehicleSpec,
        random: &mut Stream,
    ) -> Self {
        Self {
            position,
            height,
            nose,
            velocity: [0.0; 2],
            yaw_rate: 0.0,
            setpoint: Setpoint::Off,
            moved: [0.0; 2],
            flow_scale: 1.0 + spec.flow_scale_error * random.normal(),
            touching: false,
            contacts: 0,
            clear_way: f32::NEG_INFINITY,
            battery: None,
        }
    }

    /// The same body with a battery.
    pub fn with_battery(self, spec: &VehicleSpec) -> Self {
        Self { battery: Some(PointBattery::new(spec)), ..self }
    }

    /// The voltage of its battery, how long that still carries it, and whether it may fly with it.
    pub(crate) fn read_battery(&self) -> (Option<Volts>, Option<Duration>, Fitness) {
        let battery = self.battery.as_ref();
        (
            battery.map(PointBattery::volts),
            battery.map(PointBattery::endurance),
            battery.map_or(Fitness::Fit, |battery| battery.fitness(self.height)),
        )
    }

    /// The place on the floor plan.
    #[must_use]
    pub const fn position(&self) -> Point2 {
        self.position
    }

    /// The height above the ground, m.
    #[must_use]
    pub const fn height(&self) -> f32 {
        self.height
    }

    /// The heading, counter-clockwise from east.
    #[must_use]
    pub fn yaw(&self) -> f32 {
        libm::atan2f(self.nose[1], self.nose[0])
    }

    /// The number of times that it has touched a wall.
    #[must_use]
    pub const fn contacts(&self) -> u32 {
        self.contacts
    }

    /// The last set-point.
    #[must_use]
    pub const fn setpoint(&self) -> Setpoint {
        self.setpoint
    }

    /// Gives it a set-point in the axes of the nose.
    pub fn command(&mut self, setpoint: Setpoint) {
        self.setpoint = setpoint;
    }

    /// Simulates one physics step. The response to a command is first order and solved exactly; a
    /// command to stop the motors stops the body where it is, as a floor plan has no falling.
    pub(crate) fn advance(&mut self, tunnel: &Tunnel, spec: &VehicleSpec, response: Response) {
        if let Some(battery) = &mut self.battery {
            battery.advance(self.setpoint);
        }
        let (wanted, wanted_yaw, wanted_height) = match self.setpoint {
            Setpoint::Off | Setpoint::Stop => {
                self.velocity = [0.0; 2];
                self.yaw_rate = 0.0;
                self.height = 0.0;
                return;
            }
            Setpoint::Fly { forward, lateral, yaw_rate, height } => {
                ([forward.0, lateral.0], yaw_rate.0, height.0)
            }
        };
        let step = CLIMB * STEP_S;
        self.height += (wanted_height - self.height).clamp(-step, step);

        let before = self.velocity;
        for (is, wanted) in self.velocity.iter_mut().zip(wanted) {
            *is += response.velocity * (wanted - *is);
        }
        self.yaw_rate += response.yaw * (wanted_yaw - self.yaw_rate);
        let way = [0, 1].map(|axis| 0.5 * (before[axis] + self.velocity[axis]) * STEP_S);
        self.moved = [self.moved[0] + way[0], self.moved[1] + way[1]];

        let [nx, ny] = self.nose;
        self.position.x += nx * way[0] - ny * way[1];
        self.position.y += ny * way[0] + nx * way[1];
        self.turn(self.yaw_rate * STEP_S);
        self.clear_way -= way[0].abs() + way[1].abs();
        if self.clear_way < 0.0 {
            self.collide(tunnel, spec.radius);
        }
    }

    /// Turns the nose by a small angle, to second order. Its length drifts by 1e-8 a step at
    /// 1 rad/s; [`renew_nose`](Self::renew_nose) sets it right once a round.
    fn turn(&mut self, angle: f32) {
        let (cos, sin) = (1.0 - 0.5 * angle * angle, angle);
        let [x, y] = self.nose;
        self.nose = [x * cos - y * sin, x * sin + y * cos];
    }

    fn collide(&mut self, tunnel: &Tunnel, radius: f32) {
        /// More than what rounding adds up to on a way of half a metre, m.
        const ROUNDING: f32 = 1e-3;
        self.clear_way = tunnel.clearance(self.position) - radius - ROUNDING;
        if self.clear_way > 0.0 {
            self.touching = false;
            return;
        }
        match tunnel.bump(self.position, radius) {
            Some(free) => {
                self.position = free;
                self.contacts += u32::from(!self.touching);
                self.touching = true;
            }
            None => self.touching = false,
        }
    }

    /// Gives the nose's vector its length of one again.
    pub(crate) fn renew_nose(&mut self) {
        let [x, y] = self.nose;
        let scale = 1.0 / (x * x + y * y).sqrt();
        self.nose = [x * scale, y * scale];
    }

    /// Returns the reading of the optic flow: the mean velocity since the last reading, `elapsed`
    /// seconds ago.
    pub(crate) fn read_flow(
        &mut self,
        elapsed: f32,
        spec: &VehicleSpec,
        random: &mut Stream,
    ) -> BodyVelocity {
        let moved = std::mem::replace(&mut self.moved, [0.0; 2]);
        let mut axis = |way: f32| {
            MetresPerSecond(way / elapsed * self.flow_scale + spec.flow_noise * random.normal())
        };
        BodyVelocity { forward: axis(moved[0]), lateral: axis(moved[1]) }
    }

    /// The four side beams.
    pub(crate) fn read_ranges(&self, around: Surroundings<'_>, random: &mut Stream) -> Diagonals {
        let spec = around.vehicle;
        let [x, y] = self.nose;
        let half = core::f32::consts::FRAC_1_SQRT_2;
        let mut beam = |forward: f32, left: f32| {
            let direction = [(x * forward - y * left) * half, (y * forward + x * left) * half];
            let wall = if spec.sees_cones {
                level_range(around.tunnel, self.position, direction, spec.reach)
            } else {
                around.tunnel.range(self.position, direction, spec.reach)
            };
            let drone = around.others.seen(self.position, self.height, direction);
            let mut distance = drone.map_or(wall, |drone| wall.min(drone));
            if spec.range_noise > 0.0 {
                distance = (distance + spec.range_noise * random.normal()).max(0.01);
            }
            Range::measured(Metres(distance), Metres(spec.reach))
        };
        Diagonals {
            nw: beam(1.0, 1.0),
            ne: beam(1.0, -1.0),
            sw: beam(-1.0, 1.0),
            se: beam(-1.0, -1.0),
        }
    }
}
