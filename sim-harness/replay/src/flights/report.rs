//! What the flight code would have said in one log, beside what happened.

use flight::FlightConfig;
use flight::replay::{End, THRUST_SCALES, nose_swing};
use serde::Serialize;

use super::airborne::{Airborne, Ending};
use super::course::{Course, Phase, Step};
use super::spread::Spread;

/// The results of one log.
#[derive(Clone, Debug, Serialize)]
pub struct LogReport {
    /// The log, as it was named.
    pub file: String,
    /// The drone, by the names of the folder and of the file.
    pub drone: String,
    /// The length of the log, s.
    pub duration_s: f64,
    /// The median time between two events, ms.
    pub period_ms: f64,
    /// The number of flights.
    pub flights: usize,
    /// The time in the air, s.
    pub airborne_s: f64,
    /// How each flight ended, by the log alone.
    pub ended: Vec<Ending>,
    /// When the supervisor would have ended a flight.
    pub ends: Vec<EndReport>,
    /// What the accelerometer's checks said; `None` without accelerometer or motors.
    pub accel: Option<AccelReport>,
    /// What the gyroscope's checks said; `None` without a gyroscope.
    pub gyro: Option<GyroReport>,
    /// The steady torques; `None` without motors.
    pub torque: Option<TorqueReport>,
    /// The battery; `None` without its voltage.
    pub battery: Option<BatteryReport>,
    /// Whether the log has the accelerometer's readings, and not only the estimator's acceleration.
    #[serde(skip)]
    pub has_accelerometer: bool,
    /// What the log does not hold.
    pub missing: Vec<String>,
    /// What was wrong with the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// An end of a flight by the supervisor.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct EndReport {
    /// When, s since the beginning of the log.
    pub at_s: f64,
    /// In which part of the flight.
    pub phase: Phase,
    /// How.
    pub end: End,
    /// Whether within 0.2 s before the motors were asked for less than the flight code ever asks for
    /// in the air: then the log's pilot let the drone fall.
    pub under_least_thrust: bool,
}

/// The forces of a log between take-off and landing, m/s².
#[derive(Clone, Debug, Serialize)]
pub struct AccelReport {
    /// The low-frequency lateral noise: horizontal specific force beyond its mean of 0.1 s, behind
    /// the filter of 30 Hz.
    pub lateral_impact: Option<Spread>,
    /// The horizontal specific force, smoothed over 0.1 s.
    pub lateral_residual: Option<Spread>,
    /// The size of the vertical specific force that the motors do not explain, smoothed over 0.1 s.
    pub vertical_residual: Option<Spread>,
    /// The same without smoothing, upwards.
    pub vertical_excess: Option<Spread>,
    /// The largest lateral impact of the take-off and of the landing, m/s².
    pub impact_at_ends: f32,
    /// The time for which the lateral impact was above the supervisor's limit, ms.
    pub impact_ms: f64,
    /// The longest time for which the vertical residual said "held up", s.
    pub held_s: f64,
    /// The longest time for which the vertical excess said "floor", ms.
    pub floor_ms: f64,
    /// The part of the time for which the accelerometer was put aside.
    pub set_aside: f64,
    /// The learnt ratio of true to commanded thrust: its least, its last and its largest value.
    pub thrust_scale: [f32; 3],
    /// Whether it came to one of its limits.
    pub thrust_scale_at_limit: bool,
}

/// The gyroscope's checks.
#[derive(Clone, Debug, Serialize)]
pub struct GyroReport {
    /// The largest change of a body rate from reading to reading, rad/s.
    pub step: Option<Spread>,
    /// How often a reading was suspected in flight.
    pub suspicions: usize,
    /// How often a suspicion ended in an offset, and not in an impact.
    pub offsets: usize,
    /// Whether the bias was measured before the take-off.
    pub calibrated: bool,
}

/// The torques that the motors gave in the mean, by the airframe's curve.
#[derive(Clone, Debug, Serialize)]
pub struct TorqueReport {
    /// The mean thrust, N.
    pub thrust_n: f32,
    /// The mean torque about x, y and z, N m.
    pub mean_nm: [f32; 3],
    /// The part of the roll and pitch integrals' limit that the torques take at most, smoothed over
    /// 1 s.
    pub tilt_part: f32,
    /// The part of the yaw integral's limit that the mean torque takes.
    pub yaw_part: f32,
    /// How far the nose of such a drone swings in its first take-off, degrees.
    pub nose_swing_deg: f32,
    /// After which time it is back within 2°, s; `None` after more than 20 s.
    pub nose_back_s: Option<f32>,
}

/// The battery.
#[derive(Clone, Debug, Serialize)]
pub struct BatteryReport {
    /// Voltage before the take-off, V; `None` where the log begins in the air.
    pub before_v: Option<f32>,
    /// The least voltage in the air, V.
    pub least_v: f32,
    /// Whether the gauge would have let the drone take off; `None` where the log begins in the air.
    pub may_fly: Option<bool>,
    /// Internal resistance that the gauge measured at the take-off, Ω.
    pub resistance_ohm: Option<f32>,
    /// By how much the voltage falls for each newton of thrust, V/N.
    pub sag_v_per_n: Option<f32>,
    /// When the gauge called it critical, s.
    pub critical_at_s: Option<f64>,
    /// When the gauge lost it, s.
    pub lost_at_s: Option<f64>,
    /// The estimated voltage without load at the end, V.
    pub rest_v: f32,
}

impl LogReport {
    /// Whether the supervisor would have ended the flight between take-off and landing.
    #[must_use]
    pub fn ends_in_flight(&self) -> Option<&EndReport> {
        self.ends.iter().find(|end| end.phase == Phase::Flight)
    }
}

pub(super) fn airborne_s(flights: &[Airborne]) -> f64 {
    flights.iter().map(|flight| flight.until - flight.from).sum()
}

pub(super) fn ends(config: &FlightConfig, course: &Course) -> Vec<EndReport> {
    let least = config.control.least_thrust;
    let report = |&(at_s, phase, end): &(f64, Phase, End)| {
        let before = course.steps.iter().filter(|step| (at_s - 0.2..=at_s).contains(&step.time));
        let under_least_thrust =
            { before }.any(|step| step.thrust.is_some_and(|thrust| thrust < least));
        EndReport { at_s, phase, end, under_least_thrust }
    };
    course.ends.iter().map(report).collect()
}

pub(super) fn accel(config: &FlightConfig, course: &Course) -> Option<AccelReport> {
    let spread = |measure: &dyn Fn(&Step) -> f32| Spread::of(course.in_flight().map(measure));
    let limits = &config.supervisor;
    let scales = Spread::of(course.in_flight().map(|step| step.finding.thrust_scale))?;
    let last = course.in_flight().last()?.finding.thrust_scale;
    let at_ends = course.steps.iter().filter(|step| step.phase != Phase::Flight);
    let count = course.in_flight().count() as f64;
    let aside = course.in_flight().filter(|step| !step.finding.accel_is_sound).count() as f64;
    let [least, most] = THRUST_SCALES;
    let hit = course.steps.iter().any(|step| {
        let scale = step.finding.thrust_scale;
        scale <= least || scale >= most
    });
    let impacts =
        course.in_flight().filter(|step| step.finding.lateral_impact > limits.impact).count();
    let length = course.in_flight().last()?.time - course.in_flight().next()?.time;
    Some(AccelReport {
        lateral_impact: spread(&|step| step.finding.lateral_impact),
        lateral_residual: spread(&|step| step.finding.lateral_residual),
        vertical_residual: spread(&|step| step.finding.vertical_residual.abs()),
        vertical_excess: spread(&|step| step.finding.vertical_excess),
        impact_at_ends: at_ends.map(|step| step.finding.lateral_impact).fold(0.0, f32::max),
        impact_ms: impacts as f64 * 1e3 * length / count.max(1.0),
        held_s: course.longest(|step| step.finding.vertical_residual > limits.support_force),
        floor_ms: 1e3
            * course.longest(|step| {
                let finding = &step.finding;
                finding.vertical_excess > limits.floor_impact.max(finding.lateral_impact)
            }),
        set_aside: aside / count.max(1.0),
        thrust_scale: [scales.min, last, scales.max],
        thrust_scale_at_limit: hit,
    })
}

pub(super) fn gyro(course: &Course) -> GyroReport {
    GyroReport {
        step: Spread::of(course.in_flight().filter_map(|step| step.gyro_step)),
        suspicions: course.suspicions,
        offsets: course.offsets,
        calibrated: course.calibrated,
    }
}

pub(super) fn torque(config: &FlightConfig, course: &Course) -> Option<TorqueReport> {
    let mean = |of: &dyn Fn(&Step) -> Option<f32>| {
        let values: Vec<f32> = course.in_flight().filter_map(of).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f32>() / values.len() as f32)
    };
    let axis = |axis: usize| mean(&|step| step.torque?.get(axis).copied());
    let mean_nm = [axis(0)?, axis(1)?, axis(2)?];
    let [_, _, yaw] = mean_nm;
    let scale = course.in_flight().last()?.finding.thrust_scale;
    let swing = nose_swing(config, yaw.abs());
    Some(TorqueReport {
        thrust_n: mean(&|step| step.thrust)?,
        mean_nm,
        tilt_part: course.in_flight().map(|step| step.finding.trim).fold(0.0, f32::max),
        yaw_part: (scale * yaw).abs() / config.control.yaw_rate.integral_limit,
        nose_swing_deg: swing.peak.to_degrees(),
        nose_back_s: swing.settles_after,
    })
}

pub(super) fn battery(course: &Course) -> Option<BatteryReport> {
    let after = course.battery_after?;
    let volts = course.steps.iter().filter_map(|step| step.volts);
    Some(BatteryReport {
        before_v: course.battery_before.map(|battery| battery.volts),
        least_v: volts.fold(f32::INFINITY, f32::min),
        may_fly: course.battery_before.map(|battery| battery.may_fly),
        resistance_ohm: after.resistance,
        sag_v_per_n: super::sag::per_newton(course.in_flight()),
        critical_at_s: course.battery_critical,
        lost_at_s: course.battery_lost,
        rest_v: after.rest_volts,
    })
}
