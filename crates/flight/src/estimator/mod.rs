//! Estimates position, velocity and attitude: an error-state Kalman filter over gyroscope,
//! accelerometer, optic flow and the ranger that looks down.
//!
//! [`Estimator::predict`] propagates the state once a millisecond with the readings of the inertial
//! sensors. [`Estimator::flow`] and [`Estimator::down`] correct it by a reading and return a
//! [`Verdict`] on that reading. On the ground with the motors off, [`Estimator::rest`] keeps
//! velocity and height at zero.
//!
//! The state is the position, velocity and attitude of the body in a level world frame whose x
//! pointed forward when the drone was switched on. x, y and yaw are integrated from there and never
//! corrected; the height is over the floor directly below.
//!
//! All values stay finite for any finite input: the covariance is bounded by [`covariance`], and
//! [`Estimator::is_sound`] tells whether the state is within its bounds.

mod config;
mod covariance;
mod down;
mod flow;
mod rejections;
#[cfg(test)]
mod tests;
mod verdict;

pub use config::{DownConfig, EstimatorConfig, FlowConfig, InertialConfig, RestConfig};
pub use verdict::{Nis, Reseated, Unusable, Verdict};

use sensors::{pmw3901, vl53l1x};
use units::{Metres, Radians};

use self::covariance::{Covariance, ErrorState, MeasurementRow, ProcessNoise};
use self::flow::{Decorrelated, FlowIntegral};
use self::rejections::Rejections;
use crate::airframe::GRAVITY;
use crate::attitude::{Quaternion, Rotation, Vector, add, cross, dot, scaled};
use crate::calibration::CalibrationConfig;
use crate::io::Attitude;

/// The longest step of [`Estimator::predict`], s. A longer gap is a stall, and is cut to this.
const LONGEST_STEP: f32 = 0.02;
/// Range of the BMI088, ±2000 °/s and ±24 g (data sheet), rounded up: rad/s and m/s².
const MAX_GYRO: f32 = 35.0;
const MAX_ACCEL: f32 = 240.0;
/// Bounds of a Crazyflie's speed and horizontal position, m/s and m. 10 m/s is crazyflie-firmware's
/// bound as well (`kalman_supervisor.c`); its 100 m are too few for a tunnel.
const MAX_SPEED: f32 = 10.0;
const MAX_DISTANCE: f32 = 1_000.0;
/// Bound of the height, m; the ranger reaches 4 m.
const MAX_HEIGHT: f32 = 20.0;
/// A specific force whose magnitude differs from gravity by more than this fraction does not show
/// the vertical.
const GRAVITY_TOLERANCE: f32 = 0.2;
/// Bound of the accelerometer's scale error and z offset together, as a fraction of gravity: that
/// within which the calibration accepts a drone at rest. The BMI088's data sheet says 0.5 % and
/// 20 mg, of which some drones exceed either.
const MAX_SCALE_ERROR: f32 = CalibrationConfig::DEFAULT.most_scale;

/// An error-state Kalman filter of the drone's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimator {
    /// Position in the world frame, m.
    position: Vector,
    /// Velocity in the world frame, m/s.
    velocity: Vector,
    quaternion: Quaternion,
    /// The attitude of `quaternion` as a matrix.
    rotation: Rotation,
    covariance: Covariance,
    /// Gravity as this accelerometer measures it, m/s².
    gravity: f32,
    flow_integral: FlowIntegral,
    flow_rejections: Rejections,
    /// Whether the flow sensor has asked for a velocity that the drone cannot have, since it last
    /// stood on the ground.
    flow_is_disbelieved: bool,
    /// Time since the last reading of the ranger, s.
    since_down: f32,
    down_rejections: Rejections,
}

impl Estimator {
    /// The estimate before any reading: level, at rest, and uncertain.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            position: [0.0; 3],
            velocity: [0.0; 3],
            quaternion: Quaternion::IDENTITY,
            rotation: Rotation::IDENTITY,
            covariance: Covariance::diagonal([0.0; 3], [1.0; 3], [0.1, 0.1, 0.0]),
            gravity: GRAVITY,
            flow_integral: FlowIntegral::ZERO,
            flow_rejections: Rejections::none(),
            flow_is_disbelieved: false,
            since_down: 0.0,
            down_rejections: Rejections::none(),
        }
    }

    /// Initialises the estimate of a drone at rest: the tilt follows from gravity, height and
    /// velocity are zero, and x, y and yaw are kept. `accel` is the specific force in m/s², best a
    /// mean of many readings.
    pub fn settle(&mut self, config: &EstimatorConfig, accel: [f32; 3]) {
        if !self.is_sound() {
            *self = Self::new();
        }
        let [x, y, _] = self.rotation.x;
        let tilt = Quaternion::from_vertical(accel).unwrap_or(Quaternion::IDENTITY);
        self.turn_to(Quaternion::from_heading([x, y]).times(tilt));
        self.gravity = plausible_gravity(libm::sqrtf(dot(accel, accel)));
        self.reset_at_rest(&config.rest);
    }

    /// Propagates the estimate by `dt` seconds. `gyro` is the angular velocity in rad/s without its
    /// bias and `accel` the specific force in m/s², both along the board's axes and averaged over
    /// the step.
    ///
    /// In the air the x and y of `accel` are best set to zero. A multicopter pushes along z only,
    /// the filter models the drag along x and y itself, and the accelerometer's offset of 20 mg is
    /// larger than the drag. The error of the velocity is then less than half of that with the
    /// measured force (`drag_by_formula_beats_an_accelerometer_with_an_offset`).
    pub fn predict(&mut self, config: &EstimatorConfig, dt: f32, gyro: [f32; 3], accel: [f32; 3]) {
        if dt.is_nan() || dt <= 0.0 {
            return;
        }
        let dt = dt.min(LONGEST_STEP);
        let turn = scaled(limited(gyro, MAX_GYRO), dt);
        let [ahead, left, _] = self.velocity();
        let drag = scaled([ahead, left, 0.0], -config.inertial.drag);
        let accel = add(limited(accel, MAX_ACCEL), drag);
        self.integrate_flow(&config.flow, turn, dt);
        self.covariance.propagate(
            self.velocity,
            self.gravity,
            dt,
            &self.process_noise(&config.inertial, dt),
        );
        // Uses the attitude in the middle of the step, so that the force of a turning drone does
        // not lag.
        let force = add(accel, scaled(cross(turn, accel), 0.5));
        let [x, y, z] = self.rotation.to_world(force);
        self.position = limited(add(self.position, scaled(self.velocity, dt)), 2.0 * MAX_DISTANCE);
        self.velocity =
            limited(add(self.velocity, scaled([x, y, z - self.gravity], dt)), 2.0 * MAX_SPEED);
        self.turn_to(self.quaternion.times(Quaternion::from_rotation_vector(turn)));
    }

    /// Learns gravity as this accelerometer measures it, once per step of `dt` seconds in the air
    /// while the height is measured. A drone that keeps its height measures gravity on average; the
    /// learnt value keeps the climb rate right once the ranger fails. `accel` is the specific force
    /// in m/s².
    pub fn learn_gravity(&mut self, config: &EstimatorConfig, dt: f32, accel: [f32; 3]) {
        let [_, _, up] = self.rotation.to_world(limited(accel, MAX_ACCEL));
        let part = (dt / config.inertial.gravity_time_constant).max(0.0).min(1.0);
        let learnt = self.gravity + part * (up - self.gravity);
        let most = MAX_SCALE_ERROR * GRAVITY;
        self.gravity = learnt.max(GRAVITY - most).min(GRAVITY + most);
    }

    /// Keeps the estimate at rest, once per step of 1 ms on the ground with the motors off:
    /// velocity and height are zero, and the specific force `accel` in m/s² shows the vertical. x,
    /// y and yaw are kept.
    pub fn rest(&mut self, config: &EstimatorConfig, accel: [f32; 3]) {
        if let Some((length, [x, y, _])) = self.vertical(accel) {
            let gain = config.rest.gain;
            self.gravity = plausible_gravity(self.gravity + gain * (length - self.gravity));
            self.turn_to(
                Quaternion::from_rotation_vector([gain * y, -gain * x, 0.0]).times(self.quaternion),
            );
        }
        self.reset_at_rest(&config.rest);
    }

    /// Corrects the estimate by a reading of the flow sensor. The reading covers the time since the
    /// last one, whether that was used or not.
    pub fn flow(&mut self, config: &EstimatorConfig, motion: &pmw3901::Motion) -> Verdict {
        let config = &config.flow;
        let flow_integral = core::mem::replace(&mut self.flow_integral, FlowIntegral::ZERO);
        let (cosine, height) = (self.rotation.tilt_cosine(), self.height());
        if let Some(why) = flow::fault(config, motion, &flow_integral, height / cosine, cosine) {
            return Verdict::Unusable(why);
        }
        if self.flow_is_disbelieved {
            return Verdict::Unusable(Unusable::Implausible);
        }
        let counts = flow::measurement(config, motion, &flow_integral, height, &self.rotation);
        let decorrelated = Decorrelated::new(&self.covariance, &counts);
        if decorrelated.within(config.gate) {
            self.flow_rejections = Rejections::none();
            return Verdict::Used(self.apply_flow(&decorrelated));
        }
        let [x, y] = counts.variance;
        let agreement = config.gate * libm::sqrtf(x + y);
        let lasted = self.flow_rejections.add(counts.innovation, flow_integral.time, agreement);
        if lasted < config.reset_after {
            return Verdict::Rejected(decorrelated.nis());
        }
        if counts.velocity_squared() > config.most_reset * config.most_reset {
            self.flow_is_disbelieved = true;
            return Verdict::Unusable(Unusable::Implausible);
        }
        self.flow_rejections = Rejections::none();
        self.covariance.inflate_velocity(counts.velocity_squared());
        self.apply_flow(&Decorrelated::new(&self.covariance, &counts));
        Verdict::Reseated(Reseated::Velocity)
    }

    /// Corrects the estimate by a reading of the ranger that looks down.
    pub fn down(&mut self, config: &EstimatorConfig, reading: &vl53l1x::Reading) -> Verdict {
        let config = &config.down;
        let elapsed = core::mem::replace(&mut self.since_down, 0.0);
        let cosine = self.rotation.tilt_cosine();
        if let Some(why) = down::fault(config, reading, cosine) {
            return Verdict::Unusable(why);
        }
        let range = down::measurement(config, reading, self.height(), &self.rotation);
        let innovation = range.innovation;
        let (p_ht, variance) = self.project(&range.row, range.variance);
        let nis = Nis { value: innovation * innovation / variance, degrees: 1 };
        if nis.value <= config.gate * config.gate {
            self.down_rejections = Rejections::none();
            self.apply(&p_ht, variance, innovation);
            return Verdict::Used(nis);
        }
        let lasted = self.down_rejections.add([innovation, 0.0], elapsed, config.agreement);
        if lasted < config.reset_after {
            return Verdict::Rejected(nis);
        }
        self.down_rejections = Rejections::none();
        self.covariance.inflate_height(innovation * innovation);
        let before = self.height();
        let (p_ht, variance) = self.project(&range.row, range.variance);
        self.apply(&p_ht, variance, innovation);
        Verdict::Reseated(Reseated::Height(Metres(self.height() - before)))
    }

    /// The velocity along the board's axes, m/s.
    #[must_use]
    pub fn velocity(&self) -> [f32; 3] {
        self.rotation.to_body(self.velocity)
    }

    /// Standard deviation of the velocity along the board's x or y, the larger of the two, m/s.
    #[must_use]
    pub fn velocity_sd(&self) -> f32 {
        let along_x = self.covariance.velocity_along(self.rotation.x);
        let along_y = self.covariance.velocity_along(self.rotation.y);
        libm::sqrtf(along_x.max(along_y).max(0.0))
    }

    /// The height over ground, m.
    #[must_use]
    pub const fn height(&self) -> f32 {
        let [_, _, z] = self.position;
        z
    }

    /// Standard deviation of the height, m.
    #[must_use]
    pub fn height_sd(&self) -> f32 {
        let [_, _, z, ..] = self.covariance.variances();
        libm::sqrtf(z)
    }

    /// The climb rate, m/s.
    #[must_use]
    pub const fn climb(&self) -> f32 {
        let [_, _, z] = self.velocity;
        z
    }

    /// Standard deviation of the tilt about the world's x or y, the larger of the two, rad.
    #[must_use]
    pub fn tilt_sd(&self) -> f32 {
        let [.., x, y, _] = self.covariance.variances();
        libm::sqrtf(x.max(y))
    }

    /// The position in m: x forward and y left of where the drone was switched on, in the axes of
    /// that moment; z is the height over the floor directly below.
    #[must_use]
    pub const fn position(&self) -> [f32; 3] {
        self.position
    }

    /// The roll, pitch and yaw.
    #[must_use]
    pub fn attitude(&self) -> Attitude {
        let [roll, pitch, yaw] = self.rotation.angles().map(Radians);
        Attitude { roll, pitch, yaw }
    }

    /// The attitude as the unit quaternion (w, x, y, z) that rotates body axes into world axes.
    #[must_use]
    pub const fn quaternion(&self) -> [f32; 4] {
        let Quaternion { w, x, y, z } = self.quaternion;
        [w, x, y, z]
    }

    /// The vertical as a unit vector along the board's axes.
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

    /// The covariance of the errors of position, velocity and attitude, along the world's axes, for
    /// logs and tests.
    #[must_use]
    pub fn covariance(&self) -> [[f32; 9]; 9] {
        self.covariance.dense()
    }

    /// Whether the state is one that a Crazyflie can have. If not, only [`Estimator::settle`] or a
    /// new estimator recovers.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let [x, y, z] = self.position;
        let Quaternion { w, .. } = self.quaternion;
        dot(self.velocity, self.velocity) < MAX_SPEED * MAX_SPEED
            && x * x + y * y < MAX_DISTANCE * MAX_DISTANCE
            && z.abs() < MAX_HEIGHT
            && w.is_finite()
            && self.covariance.variances().iter().all(|v| v.is_finite())
    }

    /// Adds one step to the image motion that the next flow reading is compared with.
    fn integrate_flow(&mut self, config: &FlowConfig, turn: Vector, dt: f32) {
        let distance = self.height() / self.rotation.tilt_cosine().max(config.least_tilt_cosine);
        self.flow_integral.add(self.velocity(), distance.max(config.nearest), turn, dt);
        self.since_down += dt;
    }

    /// The variances that `dt` seconds add. The rotation of the velocity by the gyroscope's noise
    /// is neglected: at 1 m/s it is a hundredth of the propellers' vibration.
    fn process_noise(&self, config: &InertialConfig, dt: f32) -> ProcessNoise {
        let bias_density = |error: f32, memory: f32| error * error * memory;
        let gyro = config.gyro_density * config.gyro_density
            + bias_density(config.gyro_residual, config.tilt_time_constant);
        let accel = config.accel_density * config.accel_density;
        let [x, y, _] = self.velocity;
        let drag_sd = config.drag * config.drag_uncertainty;
        let drag = drag_sd * drag_sd * (x * x + y * y) * config.velocity_time_constant;
        ProcessNoise {
            velocity: dt * (accel + drag),
            climb: dt * (accel + bias_density(config.accel_residual, config.climb_time_constant)),
            tilt: dt * gyro,
            yaw: dt * gyro,
        }
    }

    /// Magnitude of a specific force and its direction in the estimated world; `None` if it is too
    /// far from gravity to show the vertical.
    fn vertical(&self, accel: Vector) -> Option<(f32, Vector)> {
        let length = libm::sqrtf(dot(accel, accel));
        let still = (length - self.gravity).abs() < GRAVITY_TOLERANCE * self.gravity;
        still.then(|| (length, scaled(self.rotation.to_world(accel), 1.0 / length)))
    }

    fn reset_at_rest(&mut self, config: &RestConfig) {
        let [x, y, _] = self.position;
        self.position = [x, y, 0.0];
        self.velocity = [0.0; 3];
        self.flow_integral = FlowIntegral::ZERO;
        self.flow_rejections = Rejections::none();
        self.flow_is_disbelieved = false;
        self.since_down = 0.0;
        self.down_rejections = Rejections::none();
        self.covariance.reset_at_rest(
            config.height * config.height,
            config.velocity * config.velocity,
            config.tilt * config.tilt,
        );
    }

    fn turn_to(&mut self, quaternion: Quaternion) {
        self.quaternion = quaternion.normalised();
        self.rotation = self.quaternion.rotation();
    }

    /// Adds an estimated error to the state.
    fn correct(&mut self, errors: &ErrorState) {
        let turn = Quaternion::from_rotation_vector(errors.turn).normalised();
        self.position = add(self.position, errors.position);
        self.velocity = turn.rotation().to_world(add(self.velocity, errors.velocity));
        self.turn_to(turn.times(self.quaternion));
    }

    fn apply_flow(&mut self, decorrelated: &Decorrelated) -> Nis {
        let Decorrelated {
            p_ht: [p_ht_x, p_ht_y],
            variance: [x, y],
            innovation: [innovation_x, innovation_y],
        } = decorrelated;
        self.covariance.update(p_ht_x, *x);
        self.covariance.update(p_ht_y, *y);
        self.correct(
            &ErrorState::NONE
                .plus_scaled(p_ht_x, innovation_x / x)
                .plus_scaled(p_ht_y, innovation_y / y),
        );
        decorrelated.nis()
    }

    /// Returns P·Hᵀ and the variance of the innovation, for a measurement with the variance
    /// `noise`.
    fn project(&self, row: &MeasurementRow, noise: f32) -> (ErrorState, f32) {
        let p_ht = self.covariance.p_h_transpose(row);
        (p_ht, row.times(&p_ht) + noise)
    }

    fn apply(&mut self, p_ht: &ErrorState, variance: f32, innovation: f32) {
        self.covariance.update(p_ht, variance);
        self.correct(&ErrorState::NONE.plus_scaled(p_ht, innovation / variance));
    }
}

impl Default for Estimator {
    fn default() -> Self {
        Self::new()
    }
}

/// Limits each component to ±`most`; NaN becomes zero.
fn limited(vector: Vector, most: f32) -> Vector {
    vector.map(|component| if component.is_nan() { 0.0 } else { component.max(-most).min(most) })
}

/// The measured gravity if it is plausible, else standard gravity.
fn plausible_gravity(measured: f32) -> f32 {
    if (measured - GRAVITY).abs() <= MAX_SCALE_ERROR * GRAVITY { measured } else { GRAVITY }
}
