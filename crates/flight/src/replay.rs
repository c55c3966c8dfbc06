//! Runs the checks of the flight code over the log of a flight that other code flew.
//!
//! In such a flight the motors obey another controller, so [`Flight`](crate::Flight) cannot be run
//! over its log: it would compute duties that the log's body never felt. A [`Watch`] therefore runs
//! what judges the flight (the checks of the accelerometer and of the gyroscope, the battery gauge
//! and the supervisor) with the thrusts that the log says. It is the same code that
//! [`Flight`](crate::Flight) runs. The firmware has none of this module.
//!
//! What a log does not hold counts as sound: a log without a gyroscope has no suspicion about one.

use units::{
    AngularVelocity, Duration, Instant, Metres, MetresPerSecond, RadiansPerSecond, Setpoint,
};

use crate::accel::{Accel, MAX_THRUST_SCALE, MIN_THRUST_SCALE};
use crate::airframe::Airframe;
use crate::battery::Gauge;
use crate::calibration::{Calibration, RestMean};
use crate::estimator::Estimator;
use crate::flight::FlightConfig;
use crate::gyro::{Gyro, RateSource};
use crate::io::Sensed;
use crate::mixer::Wrench;
use crate::supervisor::{Cause, Mode, Observed, StopCause, Supervisor};

mod nose;

pub use nose::{NoseSwing, nose_swing};

/// The least and the largest ratio of true to commanded thrust that the flight code learns.
pub const THRUST_SCALES: [f32; 2] = [MIN_THRUST_SCALE, MAX_THRUST_SCALE];
/// Time constant of the torques that count as steady, s: longer than the motors' lag and the turns of
/// a drone that keeps its place, shorter than a battery's flight.
const STEADY_WITHIN: f32 = 1.0;

/// A set-point to fly: only that there is one matters here.
const FLY: Setpoint = Setpoint::Fly {
    forward: MetresPerSecond(0.0),
    lateral: MetresPerSecond(0.0),
    yaw_rate: RadiansPerSecond(0.0),
    height: Metres(0.0),
};

/// One moment of a recorded flight.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// The readings since the moment before.
    pub sensed: Sensed,
    /// The thrust in N that each motor was asked for, by the airframe's curve; `None` where the log
    /// has no motors.
    pub thrusts: Option<[f32; 4]>,
    /// Whether a motor is at its full duty.
    pub at_full_duty: bool,
    /// Whether the drone is in the air.
    pub airborne: bool,
    /// Whether it is more than 5 cm above the floor.
    pub lifted: bool,
    /// The height over the floor, m; `None` where it is not known.
    pub height: Option<f32>,
    /// The climb rate, m/s; `None` where it is not known.
    pub climb: Option<f32>,
    /// The cosine of the tilt; where the log does not have it, that of the estimator, which then knows
    /// gyroscope and accelerometer alone.
    pub tilt_cosine: Option<f32>,
    /// The climb rate that the drone is taken to be asked for, m/s.
    pub wanted_climb: f32,
}

/// What the flight code knows at one moment of a recorded flight.
#[derive(Clone, Copy, Debug)]
pub struct Finding {
    /// Horizontal specific force beyond its mean, m/s²: large on an impact.
    pub lateral_impact: f32,
    /// Horizontal specific force, smoothed over 0.1 s, m/s².
    pub lateral_residual: f32,
    /// Vertical specific force that the motors do not explain, m/s²: large on a blow from below.
    pub vertical_excess: f32,
    /// The same, smoothed over 0.1 s, m/s².
    pub vertical_residual: f32,
    /// Whether the accelerometer counts as sound.
    pub accel_is_sound: bool,
    /// The learnt ratio of true to commanded thrust.
    pub thrust_scale: f32,
    /// Where the body rates come from.
    pub rate_source: Rates,
    /// Whether the gyroscope's bias has been measured.
    pub calibrated: bool,
    /// The torque about x, y and z by the airframe's curve, smoothed over 1 s, N m.
    pub steady_torque: [f32; 3],
    /// The fraction of the roll and pitch rate loops' integral limit that this torque takes: these
    /// loops ask for torques in truth, and the mixer divides them by the learnt ratio.
    pub trim: f32,
    /// The battery, `None` where it is not known.
    pub battery: Option<BatteryFinding>,
    /// The flight that the supervisor ends at this moment, if it does.
    pub ends: Option<End>,
}

/// Where the body rates come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rates {
    /// The reading is used.
    Measured,
    /// The reading jumped, and whether the drone was hit is not known yet.
    Suspect,
    /// The reading is used without an offset that appeared at once.
    Offset,
    /// There is no reading.
    Missing,
}

/// The thrust in N and the torques in N m of motors with these thrusts in N.
#[must_use]
pub fn wrench(airframe: &Airframe, thrusts: [f32; 4]) -> (f32, [f32; 3]) {
    let Wrench { thrust, torque } = Wrench::of(airframe, thrusts);
    (thrust, torque)
}

/// What the battery gauge knows.
#[derive(Clone, Copy, Debug)]
pub struct BatteryFinding {
    /// The smoothed voltage under load, V.
    pub volts: f32,
    /// The estimated voltage without load, V.
    pub rest_volts: f32,
    /// Internal resistance, Ω; `None` until it has been measured.
    pub resistance: Option<f32>,
    /// Whether the charge suffices to begin a flight.
    pub may_fly: bool,
    /// Whether the drone has to land at once.
    pub is_critical: bool,
}

/// Why the supervisor would have ended a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum End {
    /// It would have landed.
    Lands(Cause),
    /// It would have switched the motors off where the drone met a floor.
    OnFloor(Cause),
    /// It would have stopped the motors for good.
    Stops(StopCause),
}

/// The checks of the flight code over one log.
#[derive(Clone, Debug)]
pub struct Watch {
    last: Option<Instant>,
    calibration: Calibration,
    rest_mean: Option<RestMean>,
    accel: Accel,
    gyro: Gyro,
    gauge: Gauge,
    supervisor: Supervisor,
    estimator: Estimator,
    has_gyro: bool,
    has_battery: bool,
    torque: [f32; 3],
}

impl Watch {
    /// The state before the first moment.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            last: None,
            calibration: Calibration::new(),
            rest_mean: None,
            accel: Accel::new(),
            gyro: Gyro::new(),
            gauge: Gauge::new(),
            supervisor: Supervisor::new(),
            estimator: Estimator::new(),
            has_gyro: false,
            has_battery: false,
            torque: [0.0; 3],
        }
    }

    /// Advances to the next moment of the log. A moment of the same time, or of an earlier one, counts
    /// as a millisecond later.
    pub fn step(&mut self, config: &FlightConfig, now: Instant, moment: &Moment) -> Finding {
        let gap = self.last.map_or(Duration::ZERO, |last| now.since(last)).as_secs_f32();
        let dt = if gap > 0.0 { gap.min(0.02) } else { 1e-3 };
        self.last = Some(now);
        let sensed = &moment.sensed;
        self.has_gyro |= sensed.gyro.is_some();
        self.has_battery |= sensed.battery.is_some();

        let asked = Wrench::of(&config.airframe, moment.thrusts.unwrap_or([0.0; 4]));
        self.inertial(config, now, moment, &asked, dt);
        let load = asked.thrust / config.airframe.weight();
        self.gauge.step(&config.battery, now, sensed.battery, load, dt);
        if moment.airborne {
            let force = self.accel.in_flight(&config.accel);
            self.estimator.predict(&config.estimator, dt, self.gyro.rates(), force);
            let part = (dt / STEADY_WITHIN).min(1.0);
            for (steady, torque) in self.torque.iter_mut().zip(asked.torque) {
                *steady += part * (torque - *steady);
            }
        } else {
            self.rest(config, sensed);
        }
        let ends = self.supervise(config, now, moment, asked.thrust);
        self.finding(config, now, ends)
    }

    fn inertial(
        &mut self,
        config: &FlightConfig,
        now: Instant,
        moment: &Moment,
        asked: &Wrench,
        dt: f32,
    ) {
        let force = moment.sensed.accel.map(|force| force.0);
        let specific_thrust = asked.thrust / config.airframe.mass;
        let lag = config.gyro.motor_lag;
        let lifted = moment.airborne && moment.lifted;
        self.accel.step(&config.accel, now, force, specific_thrust, lag, lifted, dt);
        let bias = self.rest_mean.map_or([0.0; 3], |mean| mean.gyro);
        let rates = moment.sensed.gyro.map(|AngularVelocity(mut rates)| {
            for (rate, bias) in rates.iter_mut().zip(bias) {
                *rate -= bias;
            }
            rates
        });
        let torque = asked.times(self.accel.thrust_scale()).torque;
        let (impact, inertia) = (self.accel.lateral_impact(), config.airframe.inertia);
        self.gyro.step(&config.gyro, now, rates, impact, torque, inertia, dt);
    }

    /// What is done on the ground: the gyroscope is calibrated, and the checks begin anew.
    fn rest(&mut self, config: &FlightConfig, sensed: &Sensed) {
        self.accel.rest();
        self.gyro.rest();
        self.torque = [0.0; 3];
        if let (Some(gyro), Some(accel)) = (sensed.gyro, sensed.accel)
            && let Some(mean) = self.calibration.step(&config.calibration, gyro.0, accel.0)
        {
            if self.rest_mean.is_none() {
                self.estimator.settle(&config.estimator, mean.accel);
            }
            self.rest_mean = Some(mean);
        }
        if let Some(force) = self.accel.reading() {
            self.estimator.rest(&config.estimator, force);
        }
    }

    /// Runs the supervisor. Where it ends the flight it begins anew, to see what follows.
    fn supervise(
        &mut self,
        config: &FlightConfig,
        now: Instant,
        moment: &Moment,
        asked: f32,
    ) -> Option<End> {
        let observed = self.observe(config, now, moment, asked);
        let mode = self.supervisor.step(&config.supervisor, &observed);
        let ends = match mode {
            Mode::Grounded { .. } | Mode::Flying { .. } => return None,
            Mode::Landing { why, .. } => End::Lands(why),
            Mode::Landed { why } => End::OnFloor(why),
            Mode::Stopped { why } => End::Stops(why),
        };
        self.supervisor = Supervisor::new();
        Some(ends)
    }

    fn observe(
        &self,
        config: &FlightConfig,
        now: Instant,
        moment: &Moment,
        asked: f32,
    ) -> Observed {
        let rates_unsound_for =
            if self.has_gyro { self.gyro.unsound_for(now) } else { Duration::ZERO };
        Observed {
            now,
            setpoint: if moment.airborne { FLY } else { Setpoint::Off },
            setpoint_age: Duration::ZERO,
            calibrated: true,
            rates_unsound_for,
            flow_silent: Duration::ZERO,
            down_silent: Duration::ZERO,
            velocity_age: Duration::ZERO,
            height_age: Duration::ZERO,
            tilt_cosine: self.tilt_cosine(moment),
            specific_force: self.accel.magnitude(),
            clearance: moment.height,
            height: moment.height.unwrap_or(f32::INFINITY),
            battery_known: true,
            battery_may_fly: true,
            battery_critical: self.has_battery && self.gauge.is_critical(&config.battery, now),
            thrust_short: moment.at_full_duty,
            trim: self.trim(config),
            wanted_climb: moment.wanted_climb,
            climb: moment.climb.unwrap_or(0.0),
            lift: self.accel.thrust_scale() * asked / config.airframe.weight(),
            vertical_residual: self.accel.vertical_residual(&config.accel),
            lateral_residual: self.accel.lateral_residual(),
            velocity_error: 0.0,
            lateral_impact: self.accel.lateral_impact(),
            vertical_impact: self.accel.vertical_excess(),
        }
    }

    fn tilt_cosine(&self, moment: &Moment) -> f32 {
        let estimated = if self.has_gyro { self.estimator.tilt_cosine() } else { 1.0 };
        moment.tilt_cosine.unwrap_or(estimated)
    }

    fn trim(&self, config: &FlightConfig) -> f32 {
        let [x, y, _] = self.torque;
        self.accel.thrust_scale() * x.abs().max(y.abs()) / config.control.tilt_rate.integral_limit
    }

    fn finding(&self, config: &FlightConfig, now: Instant, ends: Option<End>) -> Finding {
        Finding {
            lateral_impact: self.accel.lateral_impact(),
            lateral_residual: self.accel.lateral_residual(),
            vertical_excess: self.accel.vertical_excess(),
            vertical_residual: self.accel.vertical_residual(&config.accel),
            accel_is_sound: self.accel.is_sound(&config.accel),
            thrust_scale: self.accel.thrust_scale(),
            rate_source: match self.gyro.source() {
                RateSource::Measured => Rates::Measured,
                RateSource::Suspect { .. } => Rates::Suspect,
                RateSource::Offset { .. } => Rates::Offset,
                RateSource::Missing { .. } => Rates::Missing,
            },
            calibrated: self.rest_mean.is_some(),
            steady_torque: self.torque,
            trim: self.trim(config),
            battery: self.battery(config, now),
            ends,
        }
    }

    fn battery(&self, config: &FlightConfig, now: Instant) -> Option<BatteryFinding> {
        let known = self.has_battery && self.gauge.is_known();
        known.then(|| BatteryFinding {
            volts: self.gauge.volts(),
            rest_volts: self.gauge.rest_volts(),
            resistance: self.gauge.resistance(),
            may_fly: self.gauge.may_fly(&config.battery),
            is_critical: self.gauge.is_critical(&config.battery, now),
        })
    }
}

impl Default for Watch {
    fn default() -> Self {
        Self::new()
    }
}
