//! A drone whose true motion is known, and sensors with exactly the errors that
//! [`EstimatorConfig::DEFAULT`] describes.
//!
//! The path is a formula of time. Attitude, body rates and specific force follow from it as for any
//! multicopter, which pushes along its own z and has drag.

use flight::{Estimator, EstimatorConfig, GRAVITY, Verdict};
use sensors::pmw3901::Motion;
use sensors::vl53l1x::{CountRate, RangeStatus, Reading};
use units::Metres;

pub(crate) type Vector = [f64; 3];

const G: f64 = GRAVITY as f64;
/// The time step, s.
pub(crate) const DT: f64 = 1e-3;

/// A random number generator with the same numbers on every machine (SplitMix64, Box and Muller).
#[derive(Clone)]
pub(crate) struct Rng(pub u64);

impl Rng {
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }

    pub(crate) fn vector(&mut self, sd: f64) -> Vector {
        [(); 3].map(|()| sd * self.normal())
    }
}

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: Vector) -> Vector {
    let length = dot(a, a).sqrt();
    a.map(|part| part / length)
}

/// The body's axes in the world, as rows.
pub(crate) type Axes = [Vector; 3];

pub(crate) fn to_body(axes: &Axes, world: Vector) -> Vector {
    [dot(axes[0], world), dot(axes[1], world), dot(axes[2], world)]
}

/// The path of a drone: it takes off in the first two seconds, then follows its waves.
#[derive(Clone, Copy)]
pub(crate) struct Path {
    pub(crate) height: f64,
    /// Amplitude (m), frequency (rad/s) and phase of x, y, z and yaw (rad).
    pub(crate) waves: [[f64; 3]; 4],
}

impl Path {
    pub(crate) const HOVER: Self = Self { height: 0.3, waves: [[0.0; 3]; 4] };

    /// Random waves: up to 0.5 m/s horizontally, 0.2 m up and down, and up to 1 rad/s of yaw.
    pub(crate) fn wandering(rng: &mut Rng) -> Self {
        let mut wave = |speed: f64, slow: f64, fast: f64| {
            let frequency = slow + (fast - slow) * rng.uniform();
            [speed / frequency, frequency, std::f64::consts::TAU * rng.uniform()]
        };
        let waves =
            [wave(0.5, 0.4, 2.0), wave(0.5, 0.4, 2.0), wave(0.1, 0.5, 1.0), wave(1.0, 0.2, 1.0)];
        Self { height: 0.5, waves }
    }

    fn wave(&self, which: usize, t: f64) -> f64 {
        let [amplitude, frequency, phase] = self.waves[which];
        // The waves are blended in from 2 s to 4 s.
        let part = ((t - 2.0) / 2.0).clamp(0.0, 1.0);
        let blend = part * part * part * (10.0 + part * (6.0 * part - 15.0));
        blend * amplitude * ((frequency * t + phase).sin() - phase.sin())
    }

    pub(crate) fn position(&self, t: f64) -> Vector {
        let part = (t / 2.0).clamp(0.0, 1.0);
        let rise = part * part * part * (10.0 + part * (6.0 * part - 15.0));
        [self.wave(0, t), self.wave(1, t), self.height * rise + self.wave(2, t)]
    }

    fn difference(&self, t: f64) -> (Vector, Vector) {
        let h = 1e-3;
        let (before, here, after) = (self.position(t - h), self.position(t), self.position(t + h));
        let mut velocity = [0.0; 3];
        let mut acceleration = [0.0; 3];
        for i in 0..3 {
            velocity[i] = (after[i] - before[i]) / (2.0 * h);
            acceleration[i] = (after[i] - 2.0 * here[i] + before[i]) / (h * h);
        }
        (velocity, acceleration)
    }

    fn at(&self, t: f64, drag: f64) -> Truth {
        let (velocity, acceleration) = self.difference(t);
        let push = [
            acceleration[0] + drag * velocity[0],
            acceleration[1] + drag * velocity[1],
            acceleration[2] + G,
        ];
        let up = unit(push);
        let yaw = self.wave(3, t);
        let ahead = [yaw.cos(), yaw.sin(), 0.0];
        let left = unit(cross(up, ahead));
        let axes = [cross(left, up), left, up];
        let [x, y, z] = acceleration;
        Truth { height: self.position(t)[2], velocity, axes, force: to_body(&axes, [x, y, z + G]) }
    }
}

/// The small rotation from one attitude to the next, in body axes, rad.
fn turn(from: &Axes, to: &Axes) -> Vector {
    let mut turn = [0.0; 3];
    for (before, after) in from.iter().zip(to) {
        for (sum, part) in turn.iter_mut().zip(to_body(from, cross(*before, *after))) {
            *sum += 0.5 * part;
        }
    }
    turn
}

/// The true motion at one time.
#[derive(Clone, Copy)]
pub(crate) struct Truth {
    pub(crate) height: f64,
    /// Velocity in the world, m/s.
    pub(crate) velocity: Vector,
    pub(crate) axes: Axes,
    /// Specific force in body axes, m/s².
    pub(crate) force: Vector,
}

/// The errors of one drone's sensors.
#[derive(Clone, Copy)]
pub(crate) struct SensorErrors {
    /// Standard deviation of one sample, rad/s.
    pub(crate) gyro: f64,
    pub(crate) gyro_bias: Vector,
    pub(crate) accel: f64,
    pub(crate) accel_bias: Vector,
    /// Standard deviation of one reading, counts.
    pub(crate) flow: f64,
    pub(crate) flow_scale: f64,
    pub(crate) down: f64,
    pub(crate) drag: f64,
}

impl SensorErrors {
    /// Draws the errors of one drone.
    pub(crate) fn drawn(config: &EstimatorConfig, rng: &mut Rng) -> Self {
        let inertial = &config.inertial;
        let per_sample = (1.0 / DT).sqrt();
        let [x, y, _] = rng.vector(0.2);
        let z = f64::from(inertial.accel_residual) * rng.normal();
        Self {
            gyro: f64::from(inertial.gyro_density) * per_sample,
            gyro_bias: rng.vector(f64::from(inertial.gyro_residual)),
            accel: f64::from(inertial.accel_density) * per_sample,
            accel_bias: [x, y, z],
            flow: f64::from(config.flow.noise + config.flow.noise_per_shutter * f32::from(SHUTTER)),
            flow_scale: f64::from(config.flow.scale_noise),
            down: f64::from(config.down.noise),
            drag: f64::from(inertial.drag)
                * (1.0 + f64::from(inertial.drag_uncertainty) * rng.normal()).max(0.0),
        }
    }
}

/// Exposure over a well lit floor, cycles.
pub(crate) const SHUTTER: u16 = 500;

pub(crate) fn motion(x: i16, y: i16) -> Motion {
    Motion {
        x,
        y,
        moved: x != 0 || y != 0,
        flags: if x != 0 || y != 0 { 0xB0 } else { 0x30 },
        squal: 80,
        shutter: SHUTTER,
        raw_sum: 100,
        raw_max: 200,
        raw_min: 20,
    }
}

pub(crate) fn reading(distance: f64) -> Reading {
    Reading {
        distance: Metres(distance as f32),
        sigma: Metres(0.001),
        status: RangeStatus::Valid,
        signal: CountRate(5.0),
        ambient: CountRate(0.1),
        stream: 1,
    }
}

/// The part of the accelerometer's reading that the estimator gets.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum AccelInput {
    /// Only z; x and y are zero.
    AlongZ,
    Full,
}

/// A drone in flight, with its true motion, its sensors and its estimator.
#[derive(Clone)]
pub(crate) struct SimulatedFlight {
    pub(crate) path: Path,
    pub(crate) errors: SensorErrors,
    pub(crate) rng: Rng,
    pub(crate) force: AccelInput,
    pub(crate) config: EstimatorConfig,
    pub(crate) estimator: Estimator,
    pub(crate) t: f64,
    now: Truth,
    /// Image motion since the flow sensor was last read, rad.
    flow_angle: [f64; 2],
    /// Height of the floor under the drone, m.
    pub(crate) floor: f64,
    steps: u64,
}

/// The verdicts of one step.
#[derive(Default)]
pub(crate) struct Verdicts {
    pub(crate) flow: Option<Verdict>,
    pub(crate) down: Option<Verdict>,
}

impl SimulatedFlight {
    /// A drone that stands on the ground, with a settled estimator.
    pub(crate) fn new(path: Path, errors: SensorErrors, rng: Rng) -> Self {
        let config = EstimatorConfig::DEFAULT;
        let mut estimator = Estimator::new();
        let [x, y, _] = errors.accel_bias;
        estimator.settle(&config, [x, y, G].map(|part| part as f32));
        Self {
            path,
            errors,
            rng,
            force: AccelInput::AlongZ,
            config,
            estimator,
            t: 0.0,
            now: path.at(0.0, errors.drag),
            flow_angle: [0.0; 2],
            floor: 0.0,
            steps: 0,
        }
    }

    /// Advances the truth by `dt` seconds and passes the inertial readings to the estimator.
    pub(crate) fn advance(&mut self, dt: f64) {
        let errors = self.errors;
        let next = self.path.at(self.t + dt, errors.drag);
        let middle = self.path.at(self.t + 0.5 * dt, errors.drag);
        let turn = turn(&self.now.axes, &next.axes);
        let velocity = to_body(&middle.axes, middle.velocity);
        let distance = (middle.height - self.floor).max(0.01) / middle.axes[2][2];
        self.flow_angle[0] += velocity[0] * dt / distance - turn[1];
        self.flow_angle[1] += velocity[1] * dt / distance + turn[0];
        let noise = (DT / dt).sqrt();
        let (about, along) =
            (self.rng.vector(errors.gyro * noise), self.rng.vector(errors.accel * noise));
        let mut gyro = [0.0; 3];
        let mut accel = [0.0; 3];
        for i in 0..3 {
            gyro[i] = (turn[i] / dt + errors.gyro_bias[i] + about[i]) as f32;
            accel[i] = (middle.force[i] + errors.accel_bias[i] + along[i]) as f32;
        }
        if self.force == AccelInput::AlongZ {
            accel = [0.0, 0.0, accel[2]];
        }
        self.estimator.predict(&self.config, dt as f32, gyro, accel);
        self.t += dt;
        self.now = next;
    }

    /// Reads the flow sensor.
    pub(crate) fn read_flow(&mut self) -> Motion {
        let scale = f64::from(self.config.flow.counts_per_radian);
        let [x, y] = std::mem::take(&mut self.flow_angle).map(|seen| {
            let relief = 1.0 + self.errors.flow_scale * self.rng.normal();
            (scale * seen * relief + self.errors.flow * self.rng.normal()).round() as i16
        });
        motion(x, y)
    }

    /// Reads the ranger that looks down.
    pub(crate) fn read_range(&mut self) -> Reading {
        let distance = (self.now.height - self.floor) / self.now.axes[2][2];
        reading((distance + self.errors.down * self.rng.normal()).max(0.0))
    }

    /// Advances by one millisecond; reads the flow sensor every 10 ms and the ranger every 25 ms.
    pub(crate) fn step(&mut self) -> Verdicts {
        self.advance(DT);
        self.steps += 1;
        let mut verdicts = Verdicts::default();
        if self.steps.is_multiple_of(25) {
            let reading = self.read_range();
            verdicts.down = Some(self.estimator.down(&self.config, &reading));
        }
        if self.steps.is_multiple_of(10) {
            let motion = self.read_flow();
            verdicts.flow = Some(self.estimator.flow(&self.config, &motion));
        }
        verdicts
    }

    pub(crate) fn fly(&mut self, seconds: f64) {
        let end = self.t + seconds - 0.5 * DT;
        while self.t < end {
            self.step();
        }
    }

    /// Error of the velocity along the board's x and y, m/s.
    pub(crate) fn velocity_error(&self) -> [f64; 2] {
        let [true_x, true_y, _] = to_body(&self.now.axes, self.now.velocity);
        let [x, y, _] = self.estimator.velocity().map(f64::from);
        [x - true_x, y - true_y]
    }

    /// Error of the height over the floor, m.
    pub(crate) fn height_error(&self) -> f64 {
        f64::from(self.estimator.height()) - (self.now.height - self.floor)
    }

    /// Error of the climb rate, m/s.
    pub(crate) fn climb_error(&self) -> f64 {
        f64::from(self.estimator.climb()) - self.now.velocity[2]
    }

    /// The angle between the true vertical and the estimated one, rad.
    pub(crate) fn tilt_error(&self) -> f64 {
        let up = to_body(&self.now.axes, [0.0, 0.0, 1.0]);
        let off = cross(up, self.estimator.up().map(f64::from));
        dot(off, off).sqrt().asin()
    }
}
