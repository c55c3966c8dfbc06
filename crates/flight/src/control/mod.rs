//! The cascade of controllers: from velocity and height to the force and torque of the propellers.
//!
//! ```text
//! height ─▶ climb rate ─▶ thrust ────────────────────────────▶ force
//! way ─▶ velocity ─▶ roll, pitch ─▶ roll and pitch rate ─▶ torque x, y
//! yaw rate ─▶ yaw ─▶ yaw rate ────────────────────▶ torque z
//! ```
//!
//! A velocity loop alone lets a hovering drone drift by any error of its velocity that stands. So a
//! place moves along with the velocity that is asked for, and the drone is drawn to it.

mod config;

use core::f32::consts::PI;

use units::Radians;

use crate::airframe::Airframe;
use crate::mixer::{Mix, Wrench};
use crate::pid::{Actuator, Pid};

pub use config::{ControlConfig, ParameterGains};

/// The goal of the cascade.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Goal {
    pub(crate) horizontal: Horizontal,
    /// Yaw rate, rad/s.
    pub(crate) yaw_rate: f32,
    pub(crate) vertical: Vertical,
}

/// The goal of the horizontal motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Horizontal {
    /// Velocity over ground along the nose and to its left, m/s.
    Velocity([f32; 2]),
    /// Zero roll and pitch: the drone drifts.
    Level,
}

/// The goal of the vertical motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Vertical {
    /// Height over ground, m.
    Height(f32),
    /// Climb rate, m/s; negative descends.
    Climb(f32),
}

/// The state of the body that the cascade reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BodyState {
    /// Velocity over ground along the nose and to its left, in the level frame, m/s.
    pub(crate) velocity: [f32; 2],
    /// Position over ground in the world's axes, m.
    pub(crate) position: [f32; 2],
    /// Vertical speed, m/s.
    pub(crate) climb: f32,
    /// Height over ground, m.
    pub(crate) height: f32,
    /// Roll, pitch, yaw, rad.
    pub(crate) attitude: [f32; 3],
    /// Body rates, rad/s.
    pub(crate) rates: [f32; 3],
    /// Cosine of the tilt.
    pub(crate) tilt_cosine: f32,
}

/// The state of the cascade between steps.
#[derive(Clone, Debug)]
pub(crate) struct Control {
    height: Pid,
    climb: Pid,
    /// The place, in the world's axes, at which a drone would be that has flown at the velocities
    /// it was asked for; `None` while the drone drifts.
    place: Option<[f32; 2]>,
    velocity: [Pid; 2],
    attitude: [Pid; 3],
    rates: [Pid; 3],
    /// Roll and pitch in rad that the slow loops asked for last.
    wanted_tilt: [f32; 2],
    /// The velocity that was last missing, m/s.
    velocity_error: [f32; 2],
    thrust: f32,
    wanted_climb: f32,
    wanted_yaw: Option<f32>,
    /// Time since the slow loops last ran, s.
    since_slow_loops: f32,
    /// For how long the drone has been off the floor, s.
    lifted_for: f32,
}

/// Largest lead of the yaw set-point over the drone's yaw, rad: a drone that was held does not spin
/// up when it is released. 0.5 rad is half of what the yaw loop can turn in a second.
const YAW_LEAD: f32 = 0.5;

/// On the floor the integral of the climb loop grows by this factor faster, so that motors that give
/// 70 % of their thrust lift the drone within half a second.
const LIFT_OFF_HASTE: f32 = 3.0;

/// Height below which a drone may still stand on the floor, m.
const ON_FLOOR_BELOW: f32 = 0.02;

impl Control {
    pub(crate) const fn new() -> Self {
        Self {
            height: Pid::new(),
            climb: Pid::new(),
            place: None,
            velocity: [Pid::new(); 2],
            attitude: [Pid::new(); 3],
            rates: [Pid::new(); 3],
            wanted_tilt: [0.0; 2],
            velocity_error: [0.0; 2],
            thrust: 0.0,
            wanted_climb: 0.0,
            wanted_yaw: None,
            since_slow_loops: f32::INFINITY,
            lifted_for: 0.0,
        }
    }

    /// The cascade at the beginning of the next flight. The torque that held the nose in the last one
    /// is kept: it is the propellers'.
    pub(crate) const fn again(&self) -> Self {
        let [_, _, yaw] = &self.rates;
        Self { rates: [Pid::new(), Pid::new(), yaw.resumed()], ..Self::new() }
    }

    /// Advances by `dt` seconds; `last` is the mixer's result of the step before.
    pub(crate) fn step(
        &mut self,
        config: &ControlConfig,
        airframe: &Airframe,
        goal: &Goal,
        body: &BodyState,
        last: &Mix,
        dt: f32,
    ) -> Wrench {
        self.since_slow_loops += dt;
        if self.since_slow_loops >= config.slow_period {
            let period =
                if self.since_slow_loops.is_finite() { self.since_slow_loops } else { 0.0 };
            self.since_slow_loops = 0.0;
            self.tilt_for(config, goal, body, period);
            self.thrust_for(config, airframe, goal, body, last, period);
        }
        if body.height >= ON_FLOOR_BELOW {
            self.lifted_for += dt;
        }
        let rates = self.rates_for(config, goal, body, dt);
        let yaw_dt = if self.learns_yaw(config, goal) { config.yaw_haste * dt } else { dt };
        let [x, y, z] = self.torque_for(config, &rates, body, last, [dt, dt, yaw_dt]);
        // Propellers twist the drone in proportion to their thrust.
        let [_, _, yaw] = &self.rates;
        let twist = yaw.integral() * (self.thrust / airframe.weight() - 1.0);
        Wrench { thrust: self.thrust, torque: [x, y, z + twist] }
    }

    /// Runs the loop of the way: the velocity that keeps the drone at the place that moves at the
    /// velocity `asked`, along the nose and to its left.
    fn velocity_for(
        &mut self,
        config: &ControlConfig,
        asked: [f32; 2],
        body: &BodyState,
        dt: f32,
    ) -> [f32; 2] {
        let [_, _, yaw] = body.attitude;
        let (sin, cos) = Radians(yaw).sin_cos();
        let [forward, left] = asked;
        let [x, y] = body.position;
        let [place_x, place_y] = self.place.unwrap_or(body.position);
        let lag_x = place_x + (cos * forward - sin * left) * dt - x;
        let lag_y = place_y + (sin * forward + cos * left) * dt - y;
        let length = libm::sqrtf(lag_x * lag_x + lag_y * lag_y);
        let kept = if length > config.most_lag { config.most_lag / length } else { 1.0 };
        let (lag_x, lag_y) = (kept * lag_x, kept * lag_y);
        self.place = Some([x + lag_x, y + lag_y]);
        [
            forward + config.way * (cos * lag_x + sin * lag_y),
            left + config.way * (cos * lag_y - sin * lag_x),
        ]
    }

    /// Runs the velocity loop: horizontal velocity → roll and pitch.
    fn tilt_for(&mut self, config: &ControlConfig, goal: &Goal, body: &BodyState, dt: f32) {
        let at_limit = self.wanted_tilt.map(|tilt| tilt.abs() >= config.most_tilt);
        let Horizontal::Velocity(asked) = goal.horizontal else {
            self.wanted_tilt = [0.0; 2];
            self.velocity_error = [0.0; 2];
            self.place = None;
            return;
        };
        let [goal_x, goal_y] = self.velocity_for(config, asked, body, dt);
        let [forward, lateral] = &mut self.velocity;
        let [vx, vy] = body.velocity;
        self.velocity_error = [goal_x - vx, goal_y - vy];
        let gains = &config.velocity;
        let pitch = forward.step(gains, goal_x - vx, vx, dt, actuator(at_limit[1]));
        let left = lateral.step(gains, goal_y - vy, vy, dt, actuator(at_limit[0]));
        self.wanted_tilt =
            [-left, pitch].map(|tilt| tilt.max(-config.most_tilt).min(config.most_tilt));
    }

    /// Runs the height and climb loops: height → climb rate → thrust.
    fn thrust_for(
        &mut self,
        config: &ControlConfig,
        airframe: &Airframe,
        goal: &Goal,
        body: &BodyState,
        last: &Mix,
        dt: f32,
    ) {
        let climb = match goal.vertical {
            Vertical::Climb(climb) => climb,
            Vertical::Height(height) => {
                let error = height - body.height;
                self.height.step(&config.height, error, body.height, dt, Actuator::Free)
            }
        };
        let climb = climb.max(-config.most_descent).min(config.most_climb);
        self.wanted_climb = climb;
        // On the floor the drone cannot sink, so that error must not wind up the integral. But one
        // that is to rise and does not needs more thrust than its constants say.
        let error = climb - body.climb;
        let on_floor = body.height < ON_FLOOR_BELOW;
        let short =
            on_floor && error < 0.0 || last.thrust_short || self.thrust <= config.least_thrust;
        let waits = if on_floor { LIFT_OFF_HASTE } else { 1.0 };
        let correction =
            self.climb.step(&config.climb, error, body.climb, waits * dt, actuator(short));
        // The thrust makes up for the lift lost to the tilt, up to 60°: beyond that no thrust would
        // be left for control.
        let tilt_cosine = body.tilt_cosine.max(0.5);
        let thrust = (airframe.weight() + correction) / tilt_cosine;
        self.thrust = thrust.max(config.least_thrust).min(4.0 * airframe.most_thrust);
    }

    /// Runs the attitude loop: attitude → body rates.
    fn rates_for(
        &mut self,
        config: &ControlConfig,
        goal: &Goal,
        body: &BodyState,
        dt: f32,
    ) -> [f32; 3] {
        let [roll, pitch, yaw] = body.attitude;
        let ahead = wrap(self.wanted_yaw.unwrap_or(yaw) + goal.yaw_rate * dt - yaw);
        let lead = ahead.max(-YAW_LEAD).min(YAW_LEAD);
        self.wanted_yaw = Some(wrap(yaw + lead));

        let [wanted_roll, wanted_pitch] = self.wanted_tilt;
        let [on_roll, on_pitch, on_yaw] = &mut self.attitude;
        let free = Actuator::Free;
        let limit = config.most_tilt_rate;
        let roll_rate = on_roll.step(&config.tilt, wanted_roll - roll, roll, dt, free);
        let pitch_rate = on_pitch.step(&config.tilt, wanted_pitch - pitch, pitch, dt, free);
        // The derivative acts on the measured turn rate, which unlike a difference of angles never
        // wraps.
        let yaw_rate = on_yaw.step(&config.yaw, lead, 0.0, dt, free)
            - config.yaw.kd * (body.rates[2] - goal.yaw_rate)
            + goal.yaw_rate;
        [
            roll_rate.max(-limit).min(limit),
            pitch_rate.max(-limit).min(limit),
            yaw_rate.max(-limit).min(limit),
        ]
    }

    /// Whether the torque that holds the nose is learnt quickly: from the take-off on until the drone has
    /// been off the floor for some time. On the floor, which holds the nose as well, there is nothing
    /// to learn; a drone that is to turn there would learn something wrong.
    fn learns_yaw(&self, config: &ControlConfig, goal: &Goal) -> bool {
        let turns = goal.yaw_rate.abs() > 1e-3;
        self.lifted_for < config.yaw_learnt_for && (self.lifted_for > 0.0 || !turns)
    }

    /// Runs the rate loop, with a time step for each axis: body rates → torques. The yaw rate's loop
    /// has no derivative, which a longer step would change.
    fn torque_for(
        &mut self,
        config: &ControlConfig,
        wanted: &[f32; 3],
        body: &BodyState,
        last: &Mix,
        dt: [f32; 3],
    ) -> [f32; 3] {
        let [x, y, z] = &mut self.rates;
        let tilt = actuator(last.tilt_short);
        let [dt_x, dt_y, dt_z] = dt;
        let torque = |pid: &mut Pid, gains, axis: usize, dt: f32, limit| {
            let (wanted, is) = match (wanted.get(axis), body.rates.get(axis)) {
                (Some(wanted), Some(is)) => (*wanted, *is),
                _ => (0.0, 0.0),
            };
            pid.step(gains, wanted - is, is, dt, limit)
        };
        [
            torque(x, &config.tilt_rate, 0, dt_x, tilt),
            torque(y, &config.tilt_rate, 1, dt_y, tilt),
            torque(z, &config.yaw_rate, 2, dt_z, actuator(last.yaw_short)),
        ]
    }

    /// Takes out of the climb loop's integral what it had made up for until the thrust was known to be
    /// `by` newtons more (or less, if negative) than commanded.
    pub(crate) fn thrust_learnt(&mut self, by: f32) {
        self.climb.relieve(by);
    }

    /// The difference between the horizontal velocity that was last asked for and the estimated one,
    /// m/s.
    pub(crate) fn velocity_error(&self) -> f32 {
        let [x, y] = self.velocity_error;
        libm::sqrtf(x * x + y * y)
    }

    /// The climb rate that the height loop asked for last, m/s.
    pub(crate) const fn wanted_climb(&self) -> f32 {
        self.wanted_climb
    }

    /// The used fraction, 0 to 1, of the larger integral of the roll and pitch rate loops. It is
    /// high when a motor is weak.
    pub(crate) fn trim(&self, config: &ControlConfig) -> f32 {
        let [x, y, _] = &self.rates;
        x.integral_use(&config.tilt_rate).max(y.integral_use(&config.tilt_rate))
    }
}

const fn actuator(at_limit: bool) -> Actuator {
    if at_limit { Actuator::AtLimit } else { Actuator::Free }
}

/// Wraps an angle in ±3π into ±π.
fn wrap(angle: f32) -> f32 {
    if angle > PI {
        angle - 2.0 * PI
    } else if angle < -PI {
        angle + 2.0 * PI
    } else {
        angle
    }
}
