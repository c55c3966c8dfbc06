//! Where the drone is, how fast, and how it leans: an error-state Kalman filter over gyroscope,
//! accelerometer, optic flow and the ranger that looks down.
//!
//! [`Estimator::predict`] carries the state forward once a millisecond with what the inertial
//! sensors say; [`Estimator::flow`] and [`Estimator::down`] mend it when a reading comes in, and
//! tell what they made of it. On the ground, motors off, [`Estimator::rest`] says that nothing
//! moves.
//!
//! The state is the position, velocity and attitude of the body in a level world whose x was
//! forward when the drone was switched on. x, y and yaw are counted on from there and nothing
//! mends them; height is over the floor beneath, wherever that is.
//!
//! What is known is bounded: |P| by [`covariance`], the state by [`Estimator::is_sound`], and no
//! finite input makes any of it not a number.

mod config;
mod covariance;
mod doubt;
mod down;
mod flow;
#[cfg(test)]
mod tests;
mod verdict;

pub use config::{DownConfig, EstimatorConfig, FlowConfig, InertialConfig, RestConfig};
pub use verdict::{Nis, Reseated, Unusable, Verdict};

use sensors::{pmw3901, vl53l1x};
use units::{Metres, Radians};

use self::covariance::{Covariance, Errors, Growth, Sight};
use self::doubt::Doubt;
use self::flow::{Passed, Weighed};
use crate::airframe::GRAVITY;
use crate::attitude::{Quaternion, Rotation, Vector, add, cross, dot, scaled};
use crate::io::Attitude;

/// The longest step of [`Estimator::predict`], s: more is a stall, not a step.
const LONGEST_STEP: f32 = 0.02;
/// What the BMI088 measures at most, ±2000 °/s and ±24 g (data sheet), rounded up: rad/s, m/s².
const MOST_GYRO: f32 = 35.0;
const MOST_ACCEL: f32 = 240.0;
/// Out of these a Crazyflie is not, m/s and m; 10 m/s is crazyflie-firmware's bound as well
/// (`kalman_supervisor.c`), and its 100 m are not enough for a tunnel.
const MOST_SPEED: f32 = 10.0;
const MOST_DISTANCE: f32 = 1_000.0;
/// The ranger reaches 4 m.
const MOST_HEIGHT: f32 = 20.0;
/// A specific force this far from gravity, as a part of it, is not gravity's alone.
const STILL: f32 = 0.2;
/// The error of an accelerometer's scale and of its z axis together is less (BMI088 data sheet:
/// 0.5 % and 20 mg), as a part of gravity.
const MOST_SCALE_ERROR: f32 = 0.03;

/// What is known of the drone's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimator {
    /// In the world, m.
    position: Vector,
    /// In the world, m/s.
    velocity: Vector,
    quaternion: Quaternion,
    /// The same as the quaternion.
    rotation: Rotation,
    covariance: Covariance,
    /// As the accelerometer measures it at rest, m/s².
    gravity: f32,
    passed: Passed,
    flow_doubt: Doubt,
    /// Seconds since the last reading of the ranger.
    since_down: f32,
    down_doubt: Doubt,
}

impl Estimator {
    /// A drone that stands level, for all that is known.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            position: [0.0; 3],
            velocity: [0.0; 3],
            quaternion: Quaternion::LEVEL,
            rotation: Rotation::NONE,
            covariance: Covariance::diagonal([0.0; 3], [1.0; 3], [0.1, 0.1, 0.0]),
            gravity: GRAVITY,
            passed: Passed::NOTHING,
            flow_doubt: Doubt::none(),
            since_down: 0.0,
            down_doubt: Doubt::none(),
        }
    }

    /// At rest here: tilt from gravity, height and velocity zero. x, y and yaw stay. `accel` is
    /// the specific force, m/s², best a mean.
    pub fn settle(&mut self, config: &EstimatorConfig, accel: [f32; 3]) {
        if !self.is_sound() {
            *self = Self::new();
        }
        let [x, y, _] = self.rotation.x;
        let tilt = Quaternion::from_vertical(accel).unwrap_or(Quaternion::LEVEL);
        self.turn_to(Quaternion::from_heading([x, y]).times(tilt));
        self.gravity = plausible_gravity(libm::sqrtf(dot(accel, accel)));
        self.stand(&config.rest);
    }

    /// On by `dt` seconds, with the angular velocity in rad/s, its bias already removed, and the
    /// specific force in m/s², both along the board's axes and averages over the time.
    ///
    /// In the air the force along x and y is best given as zero: a multicopter pushes along z and
    /// nowhere else, its drag is reckoned here, and the accelerometer's offset of 20 mg is more
    /// than that. The velocity is less than half as wrong so as with the measured force
    /// (`drag_by_formula_beats_an_accelerometer_with_an_offset`).
    pub fn predict(&mut self, config: &EstimatorConfig, dt: f32, gyro: [f32; 3], accel: [f32; 3]) {
        if dt.is_nan() || dt <= 0.0 {
            return;
        }
        let dt = dt.min(LONGEST_STEP);
        let turn = scaled(limited(gyro, MOST_GYRO), dt);
        let [ahead, left, _] = self.velocity();
        let dragged = scaled([ahead, left, 0.0], -config.inertial.drag);
        let accel = add(limited(accel, MOST_ACCEL), dragged);
        self.pass(&config.flow, turn, dt);
        self.covariance.propagate(
            self.velocity,
            self.gravity,
            dt,
            &self.growth(&config.inertial, dt),
        );
        // The attitude of the middle of the step, so that a turning drone's force is not late.
        let force = add(accel, scaled(cross(turn, accel), 0.5));
        let [x, y, z] = self.rotation.to_world(force);
        self.position = limited(add(self.position, scaled(self.velocity, dt)), 2.0 * MOST_DISTANCE);
        self.velocity =
            limited(add(self.velocity, scaled([x, y, z - self.gravity], dt)), 2.0 * MOST_SPEED);
        self.turn_to(self.quaternion.times(Quaternion::from_turn(turn)));
    }

    /// In the air while the height is measured, once per step of `dt` seconds: a drone that neither
    /// rises nor falls for good feels gravity on the average, so that what its accelerometer makes
    /// of it is learnt, for the time when nothing else tells rising from falling. `accel` is the
    /// specific force in m/s².
    pub fn weigh_gravity(&mut self, config: &EstimatorConfig, dt: f32, accel: [f32; 3]) {
        let [_, _, up] = self.rotation.to_world(limited(accel, MOST_ACCEL));
        let part = (dt / config.inertial.gravity_time).max(0.0).min(1.0);
        self.gravity = plausible_gravity(self.gravity + part * (up - self.gravity));
    }

    /// On the ground with the motors off, once per step of 1 ms: nothing moves, the height is
    /// zero, and the specific force shows the vertical. x, y and yaw stay.
    pub fn rest(&mut self, config: &EstimatorConfig, accel: [f32; 3]) {
        if let Some((length, [x, y, _])) = self.vertical(accel) {
            let gain = config.rest.gain;
            self.gravity = plausible_gravity(self.gravity + gain * (length - self.gravity));
            self.turn_to(Quaternion::from_turn([gain * y, -gain * x, 0.0]).times(self.quaternion));
        }
        self.stand(&config.rest);
    }

    /// A reading of the flow sensor. It covers the time since the last one, used or not.
    pub fn flow(&mut self, config: &EstimatorConfig, motion: &pmw3901::Motion) -> Verdict {
        let config = &config.flow;
        let passed = core::mem::replace(&mut self.passed, Passed::NOTHING);
        let (cosine, height) = (self.rotation.tilt_cosine(), self.height());
        if let Some(why) = flow::fault(config, motion, &passed, height / cosine, cosine) {
            return Verdict::Unusable(why);
        }
        let counts = flow::counts(config, motion, &passed, height, &self.rotation);
        let weighed = Weighed::new(&self.covariance, &counts);
        if weighed.within(config.gate) {
            self.flow_doubt = Doubt::none();
            return Verdict::Used(self.take(&weighed));
        }
        let [x, y] = counts.variance;
        let agreement = config.gate * libm::sqrtf(x + y);
        let doubted = self.flow_doubt.grow(counts.innovation, passed.time, agreement);
        if doubted < config.patience {
            return Verdict::Rejected(weighed.nis());
        }
        self.flow_doubt = Doubt::none();
        self.covariance.doubt_velocity(counts.velocity_squared());
        self.take(&Weighed::new(&self.covariance, &counts));
        Verdict::Reseated(Reseated::Velocity)
    }

    /// A reading of the ranger that looks down.
    pub fn down(&mut self, config: &EstimatorConfig, reading: &vl53l1x::Reading) -> Verdict {
        let config = &config.down;
        let elapsed = core::mem::replace(&mut self.since_down, 0.0);
        let cosine = self.rotation.tilt_cosine();
        if let Some(why) = down::fault(config, reading, cosine) {
            return Verdict::Unusable(why);
        }
        let range = down::range(config, reading, self.height(), &self.rotation);
        let off = range.innovation;
        let (seen, variance) = self.weigh(&range.sight, range.variance);
        let nis = Nis { value: off * off / variance, degrees: 1 };
        if nis.value <= config.gate * config.gate {
            self.down_doubt = Doubt::none();
            self.learn(&seen, variance, off);
            return Verdict::Used(nis);
        }
        let doubted = self.down_doubt.grow([off, 0.0], elapsed, config.agreement);
        if doubted < config.patience {
            return Verdict::Rejected(nis);
        }
        self.down_doubt = Doubt::none();
        self.covariance.doubt_height(off * off);
        let before = self.height();
        let (seen, variance) = self.weigh(&range.sight, range.variance);
        self.learn(&seen, variance, off);
        Verdict::Reseated(Reseated::Height(Metres(self.height() - before)))
    }

    /// Along the board's axes, m/s.
    #[must_use]
    pub fn velocity(&self) -> [f32; 3] {
        self.rotation.to_body(self.velocity)
    }

    /// Of the velocity along the board's x or y, whichever is less sure, m/s.
    #[must_use]
    pub fn velocity_sd(&self) -> f32 {
        let along_x = self.covariance.velocity_along(self.rotation.x);
        let along_y = self.covariance.velocity_along(self.rotation.y);
        libm::sqrtf(along_x.max(along_y).max(0.0))
    }

    /// Over ground, m.
    #[must_use]
    pub const fn height(&self) -> f32 {
        let [_, _, z] = self.position;
        z
    }

    /// Of the height, m.
    #[must_use]
    pub fn height_sd(&self) -> f32 {
        let [_, _, z, ..] = self.covariance.variances();
        libm::sqrtf(z)
    }

    /// Upwards, m/s.
    #[must_use]
    pub const fn climb(&self) -> f32 {
        let [_, _, z] = self.velocity;
        z
    }

    /// Of the tilt about the world's x or y, whichever is less sure, rad.
    #[must_use]
    pub fn tilt_sd(&self) -> f32 {
        let [.., x, y, _] = self.covariance.variances();
        libm::sqrtf(x.max(y))
    }

    /// From where the drone was switched on, x forward and y left as they were then, z over the
    /// floor beneath, m.
    #[must_use]
    pub const fn position(&self) -> [f32; 3] {
        self.position
    }

    /// Roll, pitch and yaw.
    #[must_use]
    pub fn attitude(&self) -> Attitude {
        let [roll, pitch, yaw] = self.rotation.angles().map(Radians);
        Attitude { roll, pitch, yaw }
    }

    /// The attitude as the unit quaternion w, x, y, z that turns body axes into the world's.
    #[must_use]
    pub const fn quaternion(&self) -> [f32; 4] {
        let Quaternion { w, x, y, z } = self.quaternion;
        [w, x, y, z]
    }

    /// Where the vertical is, along the board's axes: a unit vector.
    #[must_use]
    pub const fn up(&self) -> [f32; 3] {
        let Rotation { x: [_, _, x], y: [_, _, y], z: [_, _, z] } = self.rotation;
        [x, y, z]
    }

    /// The cosine of the tilt: 1 when level, 0 on the side, −1 upside down.
    #[must_use]
    pub const fn tilt_cosine(&self) -> f32 {
        self.rotation.tilt_cosine()
    }

    /// The covariance of the errors of position, velocity and attitude, all along the world's
    /// axes, for logs and tests.
    #[must_use]
    pub fn covariance(&self) -> [[f32; 9]; 9] {
        self.covariance.dense()
    }

    /// Whether this can be a Crazyflie. If not, [`Estimator::settle`] is all that helps.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let [x, y, z] = self.position;
        let Quaternion { w, .. } = self.quaternion;
        dot(self.velocity, self.velocity) < MOST_SPEED * MOST_SPEED
            && x * x + y * y < MOST_DISTANCE * MOST_DISTANCE
            && z.abs() < MOST_HEIGHT
            && w.is_finite()
            && self.covariance.variances().iter().all(|v| v.is_finite())
    }

    /// Keeps account of what the flow sensor sees.
    fn pass(&mut self, config: &FlowConfig, turn: Vector, dt: f32) {
        let distance = self.height() / self.rotation.tilt_cosine().max(config.least_tilt_cosine);
        self.passed.pass(self.velocity(), distance.max(config.nearest), turn, dt);
        self.since_down += dt;
    }

    /// What `dt` seconds add to the variances. That the gyroscope's noise also turns the velocity
    /// is left out: at 1 m/s it is a hundredth of what the propellers shake.
    fn growth(&self, config: &InertialConfig, dt: f32) -> Growth {
        let lasting = |error: f32, memory: f32| error * error * memory;
        let turning = config.gyro_density * config.gyro_density
            + lasting(config.gyro_residual, config.tilt_memory);
        let shaking = config.accel_density * config.accel_density;
        let [x, y, _] = self.velocity;
        let unsure = config.drag * config.drag_doubt;
        let dragging = unsure * unsure * (x * x + y * y) * config.velocity_memory;
        Growth {
            velocity: dt * (shaking + dragging),
            climb: dt * (shaking + lasting(config.accel_residual, config.climb_memory)),
            tilt: dt * turning,
            yaw: dt * turning,
        }
    }

    /// How large a specific force is and where in the estimated world it points, if it can be
    /// gravity's.
    fn vertical(&self, accel: Vector) -> Option<(f32, Vector)> {
        let length = libm::sqrtf(dot(accel, accel));
        let still = (length - self.gravity).abs() < STILL * self.gravity;
        still.then(|| (length, scaled(self.rotation.to_world(accel), 1.0 / length)))
    }

    fn stand(&mut self, config: &RestConfig) {
        let [x, y, _] = self.position;
        self.position = [x, y, 0.0];
        self.velocity = [0.0; 3];
        self.passed = Passed::NOTHING;
        self.flow_doubt = Doubt::none();
        self.since_down = 0.0;
        self.down_doubt = Doubt::none();
        self.covariance.stand(
            config.height * config.height,
            config.velocity * config.velocity,
            config.tilt * config.tilt,
        );
    }

    fn turn_to(&mut self, quaternion: Quaternion) {
        self.quaternion = quaternion.normalised();
        self.rotation = self.quaternion.rotation();
    }

    /// Takes an estimated error out of the state.
    fn mend(&mut self, errors: &Errors) {
        let turn = Quaternion::from_turn(errors.turn).normalised();
        self.position = add(self.position, errors.position);
        self.velocity = turn.rotation().to_world(add(self.velocity, errors.velocity));
        self.turn_to(turn.times(self.quaternion));
    }

    fn take(&mut self, weighed: &Weighed) -> Nis {
        let Weighed { seen: [seen_x, seen_y], variance: [x, y], innovation: [off_x, off_y] } =
            weighed;
        self.covariance.know(seen_x, *x);
        self.covariance.know(seen_y, *y);
        self.mend(&Errors::NONE.plus(seen_x, off_x / x).plus(seen_y, off_y / y));
        weighed.nis()
    }

    /// P·Hᵀ and the variance of the innovation, where the measurement's own is `noise`.
    fn weigh(&self, sight: &Sight, noise: f32) -> (Errors, f32) {
        let seen = self.covariance.seen_by(sight);
        (seen, sight.of(&seen) + noise)
    }

    fn learn(&mut self, seen: &Errors, variance: f32, innovation: f32) {
        self.covariance.know(seen, variance);
        self.mend(&Errors::NONE.plus(seen, innovation / variance));
    }
}

impl Default for Estimator {
    fn default() -> Self {
        Self::new()
    }
}

/// Each component no larger than `most` either way; what is not a number becomes zero.
fn limited(vector: Vector, most: f32) -> Vector {
    vector.map(|component| if component.is_nan() { 0.0 } else { component.max(-most).min(most) })
}

/// What was measured, if it can be gravity.
fn plausible_gravity(measured: f32) -> f32 {
    if (measured - GRAVITY).abs() <= MOST_SCALE_ERROR * GRAVITY { measured } else { GRAVITY }
}
