//! One millisecond of flight: sensors → estimator → supervisor → control → motors.

use sensors::{pmw3901, vl53l1x};
use units::{
    Acceleration, AngularVelocity, Duration, Instant, Metres, MetresPerSecond, Radians, Setpoint,
};

use crate::accel::{Accel, AccelConfig};
use crate::airframe::{Airframe, GRAVITY};
use crate::battery::{BatteryConfig, Gauge};
use crate::calibration::{Calibration, CalibrationConfig, RestMean};
use crate::control::{BodyState, Control, ControlConfig, Goal, Horizontal, Vertical};
use crate::estimator::{Estimator, EstimatorConfig, InertialConfig, Verdict};
use crate::gyro::{Gyro, GyroConfig};
use crate::io::{Attitude, Command, Outputs, Sensed, Status};
use crate::lowpass::{LowPass, LowPassState};
use crate::mixer::{Mix, mix};
use crate::monitor::SensorMonitor;
use crate::supervisor::{Cause, Mode, Observed, Supervisor, SupervisorConfig};

/// The flight code's constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlightConfig {
    /// The machine.
    pub airframe: Airframe,
    /// Zeroing the gyroscope.
    pub calibration: CalibrationConfig,
    /// What is believed of the gyroscope.
    pub gyro: GyroConfig,
    /// What the rate loop hears of it.
    pub rate_filter: LowPass,
    /// What is believed of the accelerometer.
    pub accel: AccelConfig,
    /// The state estimator.
    pub estimator: EstimatorConfig,
    /// The cascade.
    pub control: ControlConfig,
    /// What may fly, and what ends a flight.
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

/// What the estimator made of the readings of one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Verdicts {
    /// Of the optic flow, where there was a reading.
    pub flow: Option<Verdict>,
    /// Of the ranger that looks down.
    pub down: Option<Verdict>,
}

/// Flow readings that are equal to the last bit, after which the sensor is frozen: 0.3 s of them.
const MOST_FLOW_REPEATS: u16 = 30;
/// The same of the ranger that looks down, whose every measurement has its own number: 0.2 s.
const MOST_DOWN_REPEATS: u16 = 8;
/// Below this height the flow sensor sees nothing sharply, m (PMW3901 data sheet: from 80 mm on),
/// and that it does not is no fault of it.
const TOO_LOW_TO_SEE: f32 = 0.1;
/// A height that is not older than this is being measured: four readings of the ranger.
const HEIGHT_IS_FRESH: Duration = Duration::from_millis(100);
/// The shortest and the longest step that the maths is done with, in microseconds. A longer one
/// is a processor that stood still.
const STEP_US: (u64, u64) = (200, 20_000);

/// Everything between the sensors and the motors of one drone.
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
    /// When velocity and height were last measured.
    measured: [Instant; 2],
    clearance: Option<f32>,
    verdicts: Verdicts,
    control: Control,
    mix: Mix,
    supervisor: Supervisor,
}

impl Flight {
    /// A drone that has just been switched on.
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
            verdicts: Verdicts { flow: None, down: None },
            control: Control::new(),
            mix: Mix::OFF,
            supervisor: Supervisor::new(),
        }
    }

    /// One millisecond. `now` must not run backwards; steps may be late, by chance or load.
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
        let load = self.mix.achieved.thrust / (config.airframe.mass * GRAVITY);
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
        let body = self.body(config);
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
                mix(&config.airframe, &wrench, self.gauge.volts())
            }
            None => Mix::OFF,
        };
        Outputs { duties: self.mix.duties, status: self.status(config, now, mode, &body) }
    }

    /// What the estimator made of the readings of the last step.
    #[must_use]
    pub const fn verdicts(&self) -> Verdicts {
        self.verdicts
    }

    /// What is estimated, for whoever compares it with the truth.
    #[must_use]
    pub const fn estimator(&self) -> &Estimator {
        &self.estimator
    }

    /// Gyroscope and accelerometer, zeroed and checked.
    fn inertial(&mut self, config: &FlightConfig, now: Instant, sensed: &Sensed, dt: f32) {
        let accel = sensed.accel.map(|Acceleration(force)| force);
        let push = self.mix.achieved.thrust / config.airframe.mass;
        self.accel.step(&config.accel, now, accel, push, config.gyro.motor_lag, dt);

        let gyro = sensed.gyro.map(|AngularVelocity(mut rates)| {
            let bias = self.rest_mean.map_or([0.0; 3], |rest_mean| rest_mean.gyro);
            for (rate, bias) in rates.iter_mut().zip(bias) {
                *rate -= bias;
            }
            rates
        });
        let torque = self.mix.achieved.torque;
        let sideways = self.accel.lateral_impact();
        let inertia = config.airframe.inertia;
        self.gyro.step(&config.gyro, now, gyro, sideways, torque, inertia, dt);
    }

    /// In the air: moves the estimate on, and corrects it.
    fn estimate(&mut self, config: &FlightConfig, now: Instant, sensed: &Sensed, dt: f32) {
        let force = self.accel.in_flight(&config.accel);
        let trust = if self.gyro.is_predicted() {
            let inertial =
                InertialConfig { gyro_density: BLIND_GYRO_DENSITY, ..config.estimator.inertial };
            &EstimatorConfig { inertial, ..config.estimator }
        } else {
            &config.estimator
        };
        self.estimator.predict(trust, dt, self.gyro.rates(), force);
        let [_, height_at] = self.measured;
        if now.since(height_at) < HEIGHT_IS_FRESH && self.accel.is_sound(&config.accel) {
            self.estimator.learn_gravity(trust, dt, force);
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
        if let Some(flow) = self.flow.accept(now, sensed.flow, MOST_FLOW_REPEATS) {
            let verdict = self.estimator.flow(&config.estimator, &flow);
            if verdict.is_used() || self.estimator.height() < TOO_LOW_TO_SEE {
                *velocity_at = now;
            }
            self.verdicts.flow = Some(verdict);
        }
        if !self.estimator.is_sound() {
            self.estimator = Estimator::new();
        }
    }

    /// On the ground: zeroes the gyroscope and keeps the estimate at rest.
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
        self.control = Control::new();
        self.rates = LowPassState::new();
    }

    fn observe(&self, config: &FlightConfig, now: Instant, command: &Command) -> Observed {
        let [velocity_at, height_at] = self.measured;
        let force = self.accel.reading().map(|[x, y, z]| libm::sqrtf(x * x + y * y + z * z));
        Observed {
            now,
            setpoint: command.setpoint,
            setpoint_age: now.since(command.given),
            zeroed: self.rest_mean.is_some(),
            blind_for: self.gyro.unsound_for(now),
            flow_silent: self.flow.age(now),
            down_silent: self.down.age(now),
            velocity_age: now.since(velocity_at),
            height_age: now.since(height_at),
            upright: self.estimator.tilt_cosine(),
            force,
            clearance: self.clearance,
            height: self.estimator.height(),
            battery_known: self.gauge.is_known(),
            battery_may_fly: self.gauge.may_fly(&config.battery),
            battery_critical: self.gauge.is_critical(&config.battery, now),
            thrust_short: self.mix.thrust_short,
            trim: self.control.trim(&config.control),
            wanted_climb: self.control.wanted_climb(),
            climb: self.estimator.climb(),
            unexplained: self.accel.vertical_residual(),
            blow: self.accel.lateral_impact(),
            blow_up: self.accel.vertical_excess(),
        }
    }

    /// What to reach; `None` is motors off.
    fn goal(
        &self,
        config: &FlightConfig,
        now: Instant,
        command: &Command,
        mode: Mode,
    ) -> Option<Goal> {
        let limits = &config.supervisor;
        let seen = now.since(self.measured[0]) < limits.lost_after;
        let still = if seen { Horizontal::Velocity([0.0; 2]) } else { Horizontal::Level };
        match mode {
            Mode::Grounded { .. } | Mode::Landed { .. } | Mode::Stopped { .. } => None,
            Mode::Landing { why, .. } => {
                let blind = why == Cause::NoImu;
                let descent = if blind { limits.blind_descent } else { limits.descent };
                Some(Goal { horizontal: still, yaw_rate: 0.0, vertical: Vertical::Climb(-descent) })
            }
            Mode::Flying { .. } => match command.setpoint {
                Setpoint::Fly { forward, lateral, yaw_rate, height } => {
                    let stale = now.since(command.given) >= limits.level_out_after;
                    let velocity = Horizontal::Velocity([forward.0, lateral.0]);
                    Some(Goal {
                        horizontal: if stale { still } else { velocity },
                        yaw_rate: if stale { 0.0 } else { yaw_rate.0 },
                        vertical: Vertical::Height(height.0),
                    })
                }
                Setpoint::Off | Setpoint::Stop => None,
            },
        }
    }

    fn body(&mut self, config: &FlightConfig) -> BodyState {
        let Attitude { roll, pitch, yaw } = self.estimator.attitude();
        BodyState {
            velocity: level(self.estimator.velocity(), self.estimator.up()),
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

/// How uncertain predicted body rates are, as a random walk of the attitude, rad/s/√Hz: wrong by
/// 0.3 rad/s, and that for 0.1 s.
const BLIND_GYRO_DENSITY: f32 = 0.1;

/// A velocity along the board's axes, as seen by somebody who stands level and looks the same
/// way: forward and to the left. `up` is where the vertical is, along the board's axes.
fn level([vx, vy, vz]: [f32; 3], [ux, uy, uz]: [f32; 3]) -> [f32; 2] {
    // up = (−sin θ, sin φ cos θ, cos φ cos θ) for roll φ and pitch θ.
    let cos_pitch = libm::sqrtf((uy * uy + uz * uz).max(1e-6));
    let (sin_roll, cos_roll) = (uy / cos_pitch, uz / cos_pitch);
    [cos_pitch * vx - ux * (sin_roll * vy + cos_roll * vz), cos_roll * vy - sin_roll * vz]
}
