//! Runs one control step of 1 ms: sensors → estimator → supervisor → control → motors.

use sensors::{pmw3901, vl53l1x};
use units::{
    Acceleration, AngularVelocity, Duration, Instant, Metres, MetresPerSecond, Radians, Setpoint,
};

use crate::accel::{Accel, AccelConfig};
use crate::airframe::Airframe;
use crate::battery::{BatteryConfig, Gauge};
use crate::calibration::{Calibration, CalibrationConfig, RestMean};
use crate::control::{BodyState, Control, ControlConfig, Goal, Horizontal, Vertical};
use crate::drift::Drift;
use crate::estimator::{Estimator, EstimatorConfig, InertialConfig, Verdict};
use crate::gyro::{Gyro, GyroConfig};
use crate::io::{Attitude, Command, Outputs, Sensed, Status};
use crate::lowpass::{LowPass, LowPassState};
use crate::mixer::{Mix, mix};
use crate::monitor::SensorMonitor;
use crate::supervisor::{Cause, Mode, Observed, Supervisor, SupervisorConfig};

/// The constants of the flight code, grouped by the module that reads them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlightConfig {
    /// The mass, inertia and propellers of the drone.
    pub airframe: Airframe,
    /// The gyroscope calibration on the ground.
    pub calibration: CalibrationConfig,
    /// Checks of the gyroscope.
    pub gyro: GyroConfig,
    /// The low-pass filter between the gyroscope and the rate controllers.
    pub rate_filter: LowPass,
    /// Checks of the accelerometer.
    pub accel: AccelConfig,
    /// The state estimator.
    pub estimator: EstimatorConfig,
    /// The cascade of controllers.
    pub control: ControlConfig,
    /// Conditions of take-off, of landing and of stopping the motors.
    pub supervisor: SupervisorConfig,
    /// The battery.
    pub battery: BatteryConfig,
}

impl FlightConfig {
    /// A Crazyflie 2.1 with its first propellers.
    pub const CRAZYFLIE_2_1: Self = Self {
        airframe: Airframe::CRAZYFLIE_2_1,
        calibration: CalibrationConfig::DEFAULT,
        gyro: GyroConfig::DEFAULT,
        rate_filter: LowPass::HZ_80,
        accel: AccelConfig::DEFAULT,
        estimator: EstimatorConfig::DEFAULT,
        control: ControlConfig::DEFAULT,
        supervisor: SupervisorConfig::DEFAULT,
        battery: BatteryConfig::DEFAULT,
    };

    /// A Crazyflie 2.1+.
    pub const CRAZYFLIE_2_1_PLUS: Self =
        Self { airframe: Airframe::CRAZYFLIE_2_1_PLUS, ..Self::CRAZYFLIE_2_1 };
}

/// The estimator's verdicts on the readings of one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Verdicts {
    /// The verdict on the optic flow; `None` if this step had no reading.
    pub flow: Option<Verdict>,
    /// The verdict on the ranger that looks down; `None` if this step had no reading.
    pub down: Option<Verdict>,
}

/// After this many bit-identical readings the flow sensor counts as frozen: 0.3 s.
const MOST_FLOW_REPEATS: u16 = 30;
/// After this many bit-identical readings the ranger that looks down counts as frozen: 0.2 s. A
/// live one never repeats itself, since it numbers its measurements.
const MOST_DOWN_REPEATS: u16 = 8;
/// Below this height, in m, a flow reading that cannot be used is no fault: the sensor's image is
/// out of focus there (PMW3901 data sheet: sharp from 80 mm on).
const FLOW_LEAST_HEIGHT: f32 = 0.1;
/// A drone that is estimated to be higher than this has left the floor, m.
const LIFTED_FROM: f32 = 0.05;
/// The height counts as measured while the last used range is no older than this: four readings of
/// the ranger.
const HEIGHT_FRESH_FOR: Duration = Duration::from_millis(100);
/// The shortest and the longest time step that the maths is done with, µs. A longer gap between two
/// steps means that the processor was stalled, and counts as the longest step.
const STEP_US: (u64, u64) = (200, 20_000);

/// The flight code of one drone, from its sensor readings to its motor duties.
#[derive(Clone, Debug)]
pub struct Flight {
    last_step: Option<Instant>,
    calibration: Calibration,
    rest_mean: Option<RestMean>,
    gyro: Gyro,
    rates: LowPassState,
    accel: Accel,
    flow: SensorMonitor<pmw3901::Motion>,
    down: SensorMonitor<vl53l1x::Reading>,
    gauge: Gauge,
    estimator: Estimator,
    /// When the velocity and the height were last measured.
    measured: [Instant; 2],
    clearance: Option<f32>,
    drift: Drift,
    verdicts: Verdicts,
    control: Control,
    mix: Mix,
    supervisor: Supervisor,
}

impl Flight {
    /// The state of a drone that has just been switched on.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            last_step: None,
            calibration: Calibration::new(),
            rest_mean: None,
            gyro: Gyro::new(),
            rates: LowPassState::new(),
            accel: Accel::new(),
            flow: SensorMonitor::new(),
            down: SensorMonitor::new(),
            gauge: Gauge::new(),
            estimator: Estimator::new(),
            measured: [Instant::ZERO; 2],
            clearance: None,
            drift: Drift::new(),
            verdicts: Verdicts { flow: None, down: None },
            control: Control::new(),
            mix: Mix::OFF,
            supervisor: Supervisor::new(),
        }
    }

    /// Runs one step of nominally 1 ms. `now` must not run backwards; a step may be late.
    pub fn step(
        &mut self,
        config: &FlightConfig,
        now: Instant,
        sensed: &Sensed,
        command: &Command,
    ) -> Outputs {
        let (least, most) = STEP_US;
        let gap = self.last_step.map_or(1_000, |last| now.since(last).as_micros());
        let dt = Duration::from_micros(gap.max(least).min(most)).as_secs_f32();
        self.last_step = Some(now);

        self.inertial(config, now, sensed, dt);
        let load = self.mix.achieved.thrust / config.airframe.weight();
        self.gauge.step(&config.battery, now, sensed.battery, load, dt);
        if self.supervisor.mode().is_airborne() {
            self.estimate(config, now, sensed, dt);
        } else {
            self.rest(config, now, sensed);
        }

        let before = self.supervisor.mode();
        let mode = self.supervisor.step(&config.supervisor, &self.observe(config, now, command));
        if mode.is_airborne() && !before.is_airborne() {
            self.take_off(now);
        }
        let body = self.body(config, dt);
        self.mix = match self.goal(config, now, command, mode) {
            Some(goal) => {
                let wrench = self.control.step(
                    &config.control,
                    &config.airframe,
                    &goal,
                    &body,
                    &self.mix,
                    dt,
                );
                // The motors are asked for what by their constants gives the wanted thrust in truth.
                let asked = wrench.times(1.0 / self.accel.thrust_scale());
                mix(&config.airframe, &asked, self.gauge.volts())
            }
            None => Mix::OFF,
        };
        Outputs { duties: self.mix.duties, status: self.status(config, now, mode, &body) }
    }

    /// The estimator's verdicts on the readings of the last step.
    #[must_use]
    pub const fn verdicts(&self) -> Verdicts {
        self.verdicts
    }

    /// The estimator, so that tests and benchmarks can compare its estimate with the truth.
    #[must_use]
    pub const fn estimator(&self) -> &Estimator {
        &self.estimator
    }

    /// Checks the gyroscope and the accelerometer, and subtracts the gyroscope's bias.
    fn inertial(&mut self, config: &FlightConfig, now: Instant, sensed: &Sensed, dt: f32) {
        let accel = sensed.accel.map(|Acceleration(force)| force);
        let specific_thrust = self.mix.achieved.thrust / config.airframe.mass;
        let lag = config.gyro.motor_lag;
        let lifted = self.supervisor.mode().is_airborne() && self.estimator.height() > LIFTED_FROM;
        let before = self.accel.thrust_scale();
        self.accel.step(&config.accel, now, accel, specific_thrust, lag, lifted, dt);
        let weight = config.airframe.weight();
        let scale = self.accel.thrust_scale();
        self.control.thrust_learnt(weight * (scale - before) / scale);

        let gyro = sensed.gyro.map(|AngularVelocity(mut rates)| {
            let bias = self.rest_mean.map_or([0.0; 3], |rest_mean| rest_mean.gyro);
            for (rate, bias) in rates.iter_mut().zip(bias) {
                *rate -= bias;
            }
            rates
        });
        let torque = self.mix.achieved.times(scale).torque;
        let lateral_impact = self.accel.lateral_impact();
        let inertia = config.airframe.inertia;
        self.gyro.step(&config.gyro, now, gyro, lateral_impact, torque, inertia, dt);
    }

    /// Predicts and corrects the estimate while the drone is in the air.
    fn estimate(&mut self, config: &FlightConfig, now: Instant, sensed: &Sensed, dt: f32) {
        let force = self.accel.in_flight(&config.accel);
        let estimator_config = if self.gyro.is_predicted() {
            let inertial = InertialConfig {
                gyro_density: PREDICTED_GYRO_DENSITY,
                ..config.estimator.inertial
            };
            &EstimatorConfig { inertial, ..config.estimator }
        } else {
            &config.estimator
        };
        self.estimator.predict(estimator_config, dt, self.gyro.rates(), force);
        let [_, height_at] = self.measured;
        if now.since(height_at) < HEIGHT_FRESH_FOR && self.accel.is_sound(&config.accel) {
            self.estimator.learn_gravity(estimator_config, dt, force);
        }

        self.verdicts = Verdicts::default();
        let [velocity_at, height_at] = &mut self.measured;
        if let Some(down) = self.down.accept(now, sensed.down, MOST_DOWN_REPEATS) {
            let verdict = self.estimator.down(&config.estimator, &down);
            if verdict.is_used() {
                *height_at = now;
            }
            self.clearance = down.range().map(|range| range.0);
            self.verdicts.down = Some(verdict);
        }
        let blocked = matches!(self.supervisor.mode(), Mode::Landing { why: Cause::Blocked, .. });
        let flow = self.flow.accept(now, sensed.flow, MOST_FLOW_REPEATS).filter(|_| !blocked);
        if let Some(flow) = flow {
            let verdict = self.estimator.flow(&config.estimator, &flow);
            if verdict.is_used() || self.estimator.height() < FLOW_LEAST_HEIGHT {
                *velocity_at = now;
            }
            self.verdicts.flow = Some(verdict);
        }
        if !self.estimator.is_sound() {
            self.estimator = Estimator::new();
            self.drift = Drift::new();
        }
    }

    /// Calibrates the gyroscope and keeps the estimate at rest while the drone is on the ground.
    fn rest(&mut self, config: &FlightConfig, now: Instant, sensed: &Sensed) {
        self.verdicts = Verdicts::default();
        self.down.accept(now, sensed.down, u16::MAX);
        self.flow.accept(now, sensed.flow, u16::MAX);
        self.accel.rest();
        self.gyro.rest();
        if let (Some(AngularVelocity(gyro)), Some(Acceleration(accel))) =
            (sensed.gyro, sensed.accel)
            && let Some(rest_mean) = self.calibration.step(&config.calibration, gyro, accel)
        {
            if self.rest_mean.is_none() {
                self.estimator.settle(&config.estimator, rest_mean.accel);
            }
            self.rest_mean = Some(rest_mean);
        }
        if let Some(force) = self.accel.reading() {
            self.estimator.rest(&config.estimator, force);
        }
    }

    fn take_off(&mut self, now: Instant) {
        self.measured = [now; 2];
        self.drift = Drift::new();
        self.control = self.control.again();
        self.rates = LowPassState::new();
    }

    fn observe(&self, config: &FlightConfig, now: Instant, command: &Command) -> Observed {
        let [velocity_at, height_at] = self.measured;
        let weight = config.airframe.weight();
        Observed {
            now,
            setpoint: command.setpoint,
            setpoint_age: now.since(command.given),
            calibrated: self.rest_mean.is_some(),
            rates_unsound_for: self.gyro.unsound_for(now),
            flow_silent: self.flow.age(now),
            down_silent: self.down.age(now),
            velocity_age: now.since(velocity_at),
            height_age: now.since(height_at),
            tilt_cosine: self.estimator.tilt_cosine(),
            specific_force: self.accel.magnitude(),
            clearance: self.clearance,
            height: self.estimator.height(),
            battery_known: self.gauge.is_known(),
            battery_may_fly: self.gauge.may_fly(&config.battery),
            battery_critical: self.gauge.is_critical(&config.battery, now),
            thrust_short: self.mix.thrust_short,
            trim: self.control.trim(&config.control),
            wanted_climb: self.control.wanted_climb(),
            climb: self.estimator.climb(),
            lift: self.accel.thrust_scale() * self.mix.achieved.thrust / weight,
            vertical_residual: self.accel.vertical_residual(&config.accel),
            lateral_residual: self.accel.lateral_residual(),
            velocity_error: self.control.velocity_error(),
            lateral_impact: self.accel.lateral_impact(),
            vertical_impact: self.accel.vertical_excess(),
        }
    }

    /// The goal of the controllers in this mode; `None` switches the motors off.
    fn goal(
        &self,
        config: &FlightConfig,
        now: Instant,
        command: &Command,
        mode: Mode,
    ) -> Option<Goal> {
        let limits = &config.supervisor;
        let velocity_known = now.since(self.measured[0]) < limits.lost_after;
        let hold = if velocity_known { Horizontal::Velocity([0.0; 2]) } else { Horizontal::Level };
        match mode {
            Mode::Grounded { .. } | Mode::Landed { .. } | Mode::Stopped { .. } => None,
            Mode::Landing { why, .. } => {
                // What hit an obstacle that its rangers do not show may have a wrong velocity.
                let hold = if why == Cause::Blocked { Horizontal::Level } else { hold };
                let without_rates = why == Cause::NoImu;
                let descent =
                    if without_rates { limits.descent_without_rates } else { limits.descent };
                Some(Goal { horizontal: hold, yaw_rate: 0.0, vertical: Vertical::Climb(-descent) })
            }
            Mode::Flying { .. } => match command.setpoint {
                Setpoint::Fly { forward, lateral, yaw_rate, height } => {
                    let stale = now.since(command.given) >= limits.level_out_after;
                    let velocity = Horizontal::Velocity([forward.0, lateral.0]);
                    Some(Goal {
                        horizontal: if stale { hold } else { velocity },
                        yaw_rate: if stale { 0.0 } else { yaw_rate.0 },
                        vertical: Vertical::Height(height.0),
                    })
                }
                Setpoint::Off | Setpoint::Stop => None,
            },
        }
    }

    fn body(&mut self, config: &FlightConfig, dt: f32) -> BodyState {
        let Attitude { roll, pitch, yaw } = self.estimator.attitude();
        let velocity = level(self.estimator.velocity(), self.estimator.up());
        let [x, y, _] = self.estimator.position();
        let position = [x, y];
        BodyState {
            velocity: self.drift.corrected(velocity, position, yaw.0, dt),
            position,
            climb: self.estimator.climb(),
            height: self.estimator.height(),
            attitude: [roll.0, pitch.0, yaw.0],
            rates: self.rates.step(&config.rate_filter, self.gyro.rates()),
            tilt_cosine: self.estimator.tilt_cosine(),
        }
    }

    fn status(&self, config: &FlightConfig, now: Instant, mode: Mode, body: &BodyState) -> Status {
        let [roll, pitch, yaw] = body.attitude.map(Radians);
        let limits = &config.supervisor;
        let fresh = |at: Instant, silent: Duration| match mode.is_airborne() {
            true => now.since(at) < limits.lost_after,
            false => silent < limits.silent_after,
        };
        let [velocity_at, height_at] = self.measured;
        let velocity =
            fresh(velocity_at, self.flow.age(now)).then(|| body.velocity.map(MetresPerSecond));
        let height = fresh(height_at, self.down.age(now)).then_some(Metres(body.height));
        Status {
            mode,
            attitude: Attitude { roll, pitch, yaw },
            velocity,
            height,
            battery: self.gauge.status(&config.battery),
        }
    }
}

impl Default for Flight {
    fn default() -> Self {
        Self::new()
    }
}

/// Noise density of predicted body rates, as a random walk of the attitude, rad/s/√Hz: an error of
/// 0.3 rad/s that lasts for 0.1 s.
const PREDICTED_GYRO_DENSITY: f32 = 0.1;

/// Turns a velocity along the board's axes into the level frame with the same heading, as forward
/// and left. `up` is the vertical along the board's axes.
fn level([vx, vy, vz]: [f32; 3], [ux, uy, uz]: [f32; 3]) -> [f32; 2] {
    // up = (−sin θ, sin φ cos θ, cos φ cos θ) for roll φ and pitch θ.
    let cos_pitch = libm::sqrtf((uy * uy + uz * uz).max(1e-6));
    let (sin_roll, cos_roll) = (uy / cos_pitch, uz / cos_pitch);
    [cos_pitch * vx - ux * (sin_roll * vy + cos_roll * vz), cos_roll * vy - sin_roll * vz]
}
