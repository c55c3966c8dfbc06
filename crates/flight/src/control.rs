//! The cascade: from a velocity and a height to the force and torque that the propellers should
//! give.
//!
//! ```text
//! height ─▶ climb rate ─▶ thrust ────────────────────────────▶ force
//! velocity ─▶ roll, pitch ─▶ roll and pitch rate ─▶ torque x, y
//! yaw rate ─▶ yaw ─▶ yaw rate ────────────────────▶ torque z
//! ```
//!
//! The gains are the Crazyflie's (crazyflie-firmware, `platform_defaults_cf2.h`), turned from
//! degrees and 16-bit motor steps into SI units. A step of its thrust is 0.12 N / 65,535 per motor
//! (`THRUST_MAX`), its mixer gives half a roll or pitch step to each motor and a whole yaw step,
//! so with the lever l = 0.0325 m:
//!
//! | one step of | is |
//! |---|---|
//! | roll, pitch | 4 · ½ · 0.12/65,535 · l = 1.191e-7 N m |
//! | yaw | 4 · 0.12/65,535 · 0.005965 = 4.369e-8 N m |
//! | thrust | 4 · 0.12/65,535 = 7.324e-6 N |

use core::f32::consts::PI;

use crate::airframe::{Airframe, GRAVITY};
use crate::mixer::{Mix, Wrench};
use crate::pid::{Actuator, Gains, Pid};

const DEGREE: f32 = PI / 180.0;
/// N m per roll or pitch step of the Crazyflie's rate controller.
const TILT_STEP: f32 = 1.191e-7;
/// N m per yaw step.
const YAW_STEP: f32 = 4.369e-8;
/// N per thrust step.
const THRUST_STEP: f32 = 7.324e-6;

/// The cascade's constants, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlConfig {
    /// Roll and pitch rate → torque, N m per rad/s.
    pub tilt_rate: Gains,
    /// Yaw rate → torque, N m per rad/s.
    pub yaw_rate: Gains,
    /// Roll and pitch → rate, rad/s per rad.
    pub tilt: Gains,
    /// Yaw → rate, rad/s per rad.
    pub yaw: Gains,
    /// Horizontal velocity → tilt, rad per m/s.
    pub velocity: Gains,
    /// Climb rate → thrust, N per m/s.
    pub climb: Gains,
    /// Height → climb rate, m/s per m.
    pub height: Gains,
    /// The most that the drone is tilted, rad.
    pub most_tilt: f32,
    /// The fastest that it is turned about x and y, rad/s.
    pub most_tilt_rate: f32,
    /// The fastest that it climbs, m/s.
    pub most_climb: f32,
    /// The fastest that it descends, m/s: what a drone stands whose floor comes sooner than its
    /// ranger says.
    pub most_descent: f32,
    /// The least total thrust in the air, N.
    pub least_thrust: f32,
    /// How often the velocity and height loops run, s.
    pub slow_period: f32,
}

impl ControlConfig {
    /// The Crazyflie's.
    ///
    /// Its rates are limited nowhere but by the motors; 5 rad/s is what the attitude loop asks for
    /// at 45°. The integral of its climb loop has no limit that is ever met; here half the weight
    /// is one. Of its ±1 m/s of vertical speed a tunnel needs no more than half, downwards less.
    pub const DEFAULT: Self = Self {
        tilt_rate: Gains {
            kp: 250.0 * TILT_STEP / DEGREE,
            ki: 500.0 * TILT_STEP / DEGREE,
            kd: 2.5 * TILT_STEP / DEGREE,
            integral_limit: 33.3 * 500.0 * TILT_STEP,
        },
        yaw_rate: Gains {
            kp: 120.0 * YAW_STEP / DEGREE,
            ki: 16.7 * YAW_STEP / DEGREE,
            kd: 0.0,
            integral_limit: 166.7 * 16.7 * YAW_STEP,
        },
        tilt: Gains { kp: 6.0, ki: 3.0, kd: 0.0, integral_limit: 3.0 * 20.0 * DEGREE },
        yaw: Gains { kp: 6.0, ki: 1.0, kd: 0.35, integral_limit: 1.0 },
        velocity: Gains {
            kp: 25.0 * DEGREE,
            ki: 1.0 * DEGREE,
            kd: 0.0,
            integral_limit: 20.0 * DEGREE,
        },
        climb: Gains {
            kp: 25_000.0 * THRUST_STEP,
            ki: 15_000.0 * THRUST_STEP,
            kd: 0.0,
            integral_limit: 0.15,
        },
        height: Gains { kp: 2.0, ki: 0.5, kd: 0.0, integral_limit: 0.1 },
        most_tilt: 20.0 * DEGREE,
        most_tilt_rate: 5.0,
        most_climb: 0.5,
        most_descent: 0.4,
        least_thrust: 20_000.0 * THRUST_STEP,
        slow_period: 0.01,
    };
}

/// What the cascade is to reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Goal {
    pub(crate) horizontal: Horizontal,
    /// rad/s.
    pub(crate) yaw_rate: f32,
    pub(crate) vertical: Vertical,
}

/// What to do about horizontal motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Horizontal {
    /// Fly like this over ground, along the nose and to its left, m/s.
    Velocity([f32; 2]),
    /// Stay level, wherever that leads.
    Level,
}

/// What to do about height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Vertical {
    /// Hold this height, m.
    Height(f32),
    /// Climb at this rate, m/s: negative descends.
    Climb(f32),
}

/// What the cascade needs to know of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BodyState {
    /// Along the nose and to its left over ground, level, m/s.
    pub(crate) velocity: [f32; 2],
    /// Vertical speed, m/s.
    pub(crate) climb: f32,
    /// Over ground, m.
    pub(crate) height: f32,
    /// Roll, pitch, yaw, rad.
    pub(crate) attitude: [f32; 3],
    /// Body rates, rad/s.
    pub(crate) rates: [f32; 3],
    /// Cosine of the tilt.
    pub(crate) upright: f32,
}

/// The cascade's memory.
#[derive(Clone, Debug)]
pub(crate) struct Control {
    height: Pid,
    climb: Pid,
    velocity: [Pid; 2],
    attitude: [Pid; 3],
    rates: [Pid; 3],
    /// What the slow loops said last: roll and pitch in rad, and thrust in N.
    wanted_tilt: [f32; 2],
    thrust: f32,
    wanted_climb: f32,
    wanted_yaw: Option<f32>,
    /// Since the slow loops last ran, s.
    waited: f32,
}

/// The yaw set-point runs ahead of the drone by no more than this: a drone held fast does not
/// whirl round when let go. 0.5 rad is half of what the yaw loop can reach in a second.
const YAW_LEAD: f32 = 0.5;

/// Below this height a drone may still stand, m.
const FLOOR: f32 = 0.02;

impl Control {
    pub(crate) const fn new() -> Self {
        Self {
            height: Pid::new(),
            climb: Pid::new(),
            velocity: [Pid::new(); 2],
            attitude: [Pid::new(); 3],
            rates: [Pid::new(); 3],
            wanted_tilt: [0.0; 2],
            thrust: 0.0,
            wanted_climb: 0.0,
            wanted_yaw: None,
            waited: f32::INFINITY,
        }
    }

    /// One step of `dt` seconds after one that ended in `last`.
    pub(crate) fn step(
        &mut self,
        config: &ControlConfig,
        airframe: &Airframe,
        goal: &Goal,
        body: &BodyState,
        last: &Mix,
        dt: f32,
    ) -> Wrench {
        self.waited += dt;
        if self.waited >= config.slow_period {
            let period = if self.waited.is_finite() { self.waited } else { 0.0 };
            self.waited = 0.0;
            self.tilt_for(config, goal, body, period);
            self.thrust_for(config, airframe, goal, body, last, period);
        }
        let rates = self.rates_for(config, goal, body, dt);
        Wrench { thrust: self.thrust, torque: self.torque_for(config, &rates, body, last, dt) }
    }

    /// Horizontal velocity → roll and pitch.
    fn tilt_for(&mut self, config: &ControlConfig, goal: &Goal, body: &BodyState, dt: f32) {
        let at_limit = self.wanted_tilt.map(|tilt| tilt.abs() >= config.most_tilt);
        let Horizontal::Velocity([goal_x, goal_y]) = goal.horizontal else {
            self.wanted_tilt = [0.0; 2];
            return;
        };
        let [forward, lateral] = &mut self.velocity;
        let [vx, vy] = body.velocity;
        let gains = &config.velocity;
        let pitch = forward.step(gains, goal_x - vx, vx, dt, actuator(at_limit[1]));
        let left = lateral.step(gains, goal_y - vy, vy, dt, actuator(at_limit[0]));
        self.wanted_tilt =
            [-left, pitch].map(|tilt| tilt.max(-config.most_tilt).min(config.most_tilt));
    }

    /// Height → climb rate → thrust.
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
        // What the floor holds back is no error that could be learned from.
        let on_floor = body.height < FLOOR;
        let short = on_floor || last.thrust_short || self.thrust <= config.least_thrust;
        let push =
            self.climb.step(&config.climb, climb - body.climb, body.climb, dt, actuator(short));
        // What the tilt takes from the lift; beyond 60° nothing would be left to control with.
        let upright = body.upright.max(0.5);
        let thrust = (airframe.mass * GRAVITY + push) / upright;
        self.thrust = thrust.max(config.least_thrust).min(4.0 * airframe.most_thrust);
    }

    /// Attitude → body rates.
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
        // Against the turn rate itself, which unlike a difference of angles never wraps.
        let yaw_rate = on_yaw.step(&config.yaw, lead, 0.0, dt, free)
            - config.yaw.kd * (body.rates[2] - goal.yaw_rate)
            + goal.yaw_rate;
        [
            roll_rate.max(-limit).min(limit),
            pitch_rate.max(-limit).min(limit),
            yaw_rate.max(-limit).min(limit),
        ]
    }

    /// Body rates → torques.
    fn torque_for(
        &mut self,
        config: &ControlConfig,
        wanted: &[f32; 3],
        body: &BodyState,
        last: &Mix,
        dt: f32,
    ) -> [f32; 3] {
        let [x, y, z] = &mut self.rates;
        let tilt = actuator(last.tilt_short);
        let torque = |pid: &mut Pid, gains, axis: usize, limit| {
            let (wanted, is) = match (wanted.get(axis), body.rates.get(axis)) {
                (Some(wanted), Some(is)) => (*wanted, *is),
                _ => (0.0, 0.0),
            };
            pid.step(gains, wanted - is, is, dt, limit)
        };
        [
            torque(x, &config.tilt_rate, 0, tilt),
            torque(y, &config.tilt_rate, 1, tilt),
            torque(z, &config.yaw_rate, 2, actuator(last.yaw_short)),
        ]
    }

    /// What the height loop asked for last, m/s.
    pub(crate) const fn wanted_climb(&self) -> f32 {
        self.wanted_climb
    }

    /// How much of what the rate loops may hold against a constant torque is used up, 0 to 1: a
    /// weak motor shows here.
    pub(crate) fn trim(&self, config: &ControlConfig) -> f32 {
        let [x, y, _] = &self.rates;
        x.integral_use(&config.tilt_rate).max(y.integral_use(&config.tilt_rate))
    }
}

const fn actuator(at_limit: bool) -> Actuator {
    if at_limit { Actuator::AtLimit } else { Actuator::Free }
}

/// The same angle within half a turn either way, if it was within one and a half.
fn wrap(angle: f32) -> f32 {
    if angle > PI {
        angle - 2.0 * PI
    } else if angle < -PI {
        angle + 2.0 * PI
    } else {
        angle
    }
}
