//! Steps the checks of the flight code over a log, and keeps what they found at each moment.

use std::io;

use flight::FlightConfig;
use flight::replay::{BatteryFinding, End, Finding, Moment, Rates, Watch, wrench};
use units::{Acceleration, AngularVelocity, Instant, Volts};

use super::airborne::Airborne;
use super::signals::Signals;

/// The climb rate that a drone is taken to be asked for, m/s. No log has it, and a drone is judged to
/// be held up, or to have met a floor, only while it is to sink; so it is taken to be asked for that
/// from the end of its take-off on.
const ASKED_TO_SINK: f32 = -0.2;
/// Within this time of its lift-off a drone takes off, and within this time of the end of its motors
/// it lands, s.
const TURNS_WITHIN: f64 = 1.0;
/// The clock of a log begins then, s: the flight code takes zero for "never".
const BEGINS_AT: f64 = 1.0;

/// The part of a flight to which a moment belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// Up to a second after lift-off.
    TakeOff,
    /// In between.
    Flight,
    /// The last second before the motors stopped.
    Landing,
}

/// One moment in the air.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) time: f64,
    pub(super) phase: Phase,
    pub(super) finding: Finding,
    /// The thrust of all motors by the airframe's curve, N.
    pub(super) thrust: Option<f32>,
    /// The torque by the airframe's curve, N m.
    pub(super) torque: Option<[f32; 3]>,
    /// The last voltage, as it was logged, V.
    pub(super) volts: Option<f32>,
    /// The largest difference of a body rate from the reading before, rad/s.
    pub(super) gyro_step: Option<f32>,
    pub(super) height: Option<f32>,
}

/// What was found in a log.
#[derive(Clone, Debug, Default)]
pub(super) struct Course {
    /// The moments in the air.
    pub(super) steps: Vec<Step>,
    /// When the supervisor would have ended a flight, and how.
    pub(super) ends: Vec<(f64, Phase, End)>,
    /// The battery at the last moment before the first take-off, and at the end.
    pub(super) battery_before: Option<BatteryFinding>,
    pub(super) battery_after: Option<BatteryFinding>,
    /// When the gauge lost the battery, s.
    pub(super) battery_lost: Option<f64>,
    /// When the battery was critical first, s.
    pub(super) battery_critical: Option<f64>,
    /// Whether the gyroscope was calibrated before the first take-off.
    pub(super) calibrated: bool,
    /// How often the gyroscope's reading was suspected in flight, and how often that ended in an
    /// offset.
    pub(super) suspicions: usize,
    pub(super) offsets: usize,
}

/// Steps the flight code's checks over a log.
pub(super) fn run(config: &FlightConfig, signals: &Signals, flights: &[Airborne]) -> Course {
    let mut watch = Watch::new();
    let mut course = Course::default();
    let (mut before, mut last_gyro, mut volts) = (f64::NEG_INFINITY, None, None);
    let mut last_rates = Rates::Missing;
    let mut flights = flights.iter().peekable();
    for &time in &signals.timeline {
        while flights.next_if(|flight| flight.until < time).is_some() {}
        let flight = flights.peek().filter(|flight| flight.from <= time);
        let moment = moment(config, signals, flight.copied(), before, time);
        let now = Instant::from_micros(((time + BEGINS_AT) * 1e6).round() as u64);
        let finding = watch.step(config, now, &moment);
        let gyro = moment.sensed.gyro.map(|AngularVelocity(rates)| rates);
        volts = moment.sensed.battery.map(|Volts(volts)| volts).or(volts);
        course.note_battery(time, &finding, flight.is_some());
        if let Some(flight) = flight {
            let phase = flight.phase(time);
            if let Some(end) = finding.ends {
                course.ends.push((time, phase, end));
            }
            course.note_rates(last_rates, finding.rate_source, phase);
            let (thrust, torque) = moment.thrusts.map(|all| wrench(&config.airframe, all)).unzip();
            let gyro_step = gyro.zip(last_gyro).map(|(now, last)| largest_step(now, last));
            let height = moment.height;
            course.steps.push(Step {
                time,
                phase,
                finding,
                thrust,
                torque,
                volts,
                gyro_step,
                height,
            });
        } else if course.steps.is_empty() {
            course.calibrated = finding.calibrated;
        }
        (before, last_gyro, last_rates) = (time, gyro, finding.rate_source);
    }
    course
}

fn moment(
    config: &FlightConfig,
    signals: &Signals,
    flight: Option<&Airborne>,
    before: f64,
    time: f64,
) -> Moment {
    let ground = flight.map_or(0.0, |flight| flight.ground);
    let mut moment = Moment {
        sensed: flight::Sensed::default(),
        thrusts: signals.thrusts(&config.airframe, time),
        at_full_duty: signals.at_full_duty(time),
        airborne: flight.is_some(),
        lifted: flight.is_some_and(|flight| flight.lifted <= time),
        height: signals.height.as_ref().and_then(|height| height.at(time)).map(|at| at - ground),
        climb: signals.climb.as_ref().and_then(|climb| climb.at(time)),
        tilt_cosine: signals.tilt_cosine(time),
        wanted_climb: match flight.map(|flight| flight.phase(time)) {
            Some(Phase::Flight | Phase::Landing) => ASKED_TO_SINK,
            Some(Phase::TakeOff) | None => 0.0,
        },
    };
    moment.sensed.gyro = signals.gyro_at(time).map(AngularVelocity);
    moment.sensed.accel = signals.force_at(time).map(Acceleration);
    let volts = signals.volts.as_ref().and_then(|volts| volts.news(before, time));
    moment.sensed.battery = volts.map(Volts);
    moment
}

impl Airborne {
    fn phase(&self, time: f64) -> Phase {
        let stops = self.ending != super::airborne::Ending::LogEnds;
        if time < self.lifted + TURNS_WITHIN {
            Phase::TakeOff
        } else if stops && time > self.until - TURNS_WITHIN {
            Phase::Landing
        } else {
            Phase::Flight
        }
    }
}

impl Course {
    fn note_battery(&mut self, time: f64, finding: &Finding, flies: bool) {
        if let Some(battery) = finding.battery {
            if !flies && self.steps.is_empty() {
                self.battery_before = Some(battery);
            }
            if battery.is_critical && flies {
                self.battery_critical = self.battery_critical.or(Some(time));
            }
            self.battery_after = Some(battery);
        } else if self.battery_after.is_some() {
            self.battery_lost = self.battery_lost.or(Some(time));
        }
    }

    fn note_rates(&mut self, last: Rates, now: Rates, phase: Phase) {
        if last == now || phase != Phase::Flight {
            return;
        }
        match now {
            Rates::Suspect => self.suspicions += 1,
            Rates::Offset => self.offsets += 1,
            Rates::Measured | Rates::Missing => {}
        }
    }

    /// Writes the rows of the time course.
    pub(super) fn write_rows(&self, file: &str, out: &mut dyn io::Write) -> io::Result<()> {
        let bins = self.steps.chunk_by(|a, b| (a.time * 100.0) as u64 == (b.time * 100.0) as u64);
        for bin in bins {
            let Some(Step { time, phase, finding, thrust, volts, height, .. }) = bin.last() else {
                continue;
            };
            let most = |of: fn(&Finding) -> f32| {
                bin.iter().map(|step| of(&step.finding)).fold(f32::NEG_INFINITY, f32::max)
            };
            let [roll, pitch, yaw] = finding.steady_torque;
            writeln!(
                out,
                "{},{time:.3},{},{},{},{:.4},{:.3},{:.3},{:.3},{:.3},{},{},{roll:.3e},{pitch:.3e},\
                 {yaw:.3e},{},{}",
                quoted(file),
                phase.name(),
                cell(*height),
                cell(*thrust),
                finding.thrust_scale,
                most(|finding| finding.lateral_impact),
                finding.lateral_residual,
                most(|finding| finding.vertical_excess),
                finding.vertical_residual,
                finding.accel_is_sound,
                rates_name(finding.rate_source),
                cell(*volts),
                cell(finding.battery.map(|battery| battery.rest_volts)),
            )?;
        }
        Ok(())
    }

    /// The moments between take-off and landing.
    pub(super) fn in_flight(&self) -> impl Iterator<Item = &Step> {
        self.steps.iter().filter(|step| step.phase == Phase::Flight)
    }

    /// The longest time without a break, s, for which this holds between take-off and landing.
    pub(super) fn longest(&self, holds: impl Fn(&Step) -> bool) -> f64 {
        let (mut longest, mut since) = (0.0_f64, None);
        for step in self.in_flight() {
            since = if holds(step) { since.or(Some(step.time)) } else { None };
            longest = longest.max(since.map_or(0.0, |since| step.time - since));
        }
        longest
    }
}

impl Phase {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::TakeOff => "take-off",
            Self::Flight => "flight",
            Self::Landing => "landing",
        }
    }
}

const fn rates_name(rates: Rates) -> &'static str {
    match rates {
        Rates::Measured => "measured",
        Rates::Suspect => "suspect",
        Rates::Offset => "offset",
        Rates::Missing => "missing",
    }
}

fn cell(value: Option<f32>) -> String {
    value.map(|value| format!("{value:.4}")).unwrap_or_default()
}

/// A field of a CSV.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

fn largest_step(now: [f32; 3], last: [f32; 3]) -> f32 {
    now.iter().zip(last).map(|(now, last)| (now - last).abs()).fold(0.0, f32::max)
}
