//! Estimates the parameters of a radio model from recorded packets whose ends' distances are known.
//!
//! The model is the log-distance law of [`radio_model::LogDistance`] with a gain for each link,
//! spatially correlated shadowing and the white noise of packets:
//!
//! > rssi = −(L₁ + 10·n·log₁₀ d) + g + S + e
//!
//! n is the slope within the links, so that a link behind a wall does not count as a distant one;
//! L₁ is the mean over all packets, g what is left of each link's mean. What is left of each packet
//! is divided into S and e by its variogram over the displacement h of the moving end,
//!
//! > γ(h) = σₑ² + σₛ²·(1 − exp(−h/δ))
//!
//! The standard errors of L₁ and n are those of a bootstrap over blocks of time, those of the rest
//! of a bootstrap over links, since packets near each other in time and place are not independent.

mod law;
mod variogram;

use std::f64::consts::SQRT_2;
use std::fmt::{self, Write};
use std::ops::RangeInclusive;
use std::path::Path;

use input::InputError;
use radio_model::{Geometry, LogDistance, PathLoss};
use random::{Purpose, Stream};
use serde::Serialize;
use units::{Dbm, Metres};

pub(crate) use self::law::Law;
use self::variogram::Variogram;
use super::recording::{Recording, Sample};

/// A number and its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its standard error.
    pub error: f64,
}

/// A model that was fitted to recordings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RadioFit {
    /// The number of packets with a known distance.
    pub packets: usize,
    /// The number of their links.
    pub links: usize,
    /// The least and the largest distance, m.
    pub distances_m: [f64; 2],
    /// The loss L₁ over the first metre, dB.
    pub loss_at_1m_db: Estimate,
    /// The exponent n.
    pub exponent: Estimate,
    /// The standard deviation of the links' gains, dB: antennas, receivers, and what stands between
    /// their ends.
    pub gain_error_db: Estimate,
    /// The variance of the noise of one packet, dB².
    pub noise_variance_db2: Estimate,
    /// The standard deviation of shadowing, dB.
    pub shadowing_db: Estimate,
    /// Its decorrelation distance, m.
    pub decorrelation_m: Estimate,
    /// How well the law predicts packets that it was not fitted to.
    pub held_out: HeldOut,
}

/// The root mean square of the errors, in dB, of laws over the half of each recording that was not
/// used for the fit, for both halves together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HeldOut {
    /// Of the law that was fitted to the other half.
    pub fitted_db: f64,
    /// Of free space, the simulator's law in sight.
    pub default_db: f64,
}

/// One packet.
#[derive(Clone, Copy, Debug)]
struct Point {
    link: usize,
    /// Seconds since the beginning of its recording.
    time: f64,
    /// log₁₀ of the distance in metres.
    log_distance: f64,
    rssi: f64,
    /// Where the moving end was, m.
    at: [f64; 3],
    /// Whether it is of the first half of its recording.
    early: bool,
}

/// The number of bootstrap samples: the standard error of a standard error is 5 %.
const RESAMPLED: usize = 200;
/// The blocks of the bootstrap over time, s: at a walk, some decorrelation distances.
const BLOCK: f64 = 20.0;
/// The least number of packets of a fit.
const LEAST: usize = 50;

/// Fits a model to recordings.
///
/// # Errors
/// Where too few packets have a known distance, or all the same one.
pub fn fit<'a>(recordings: impl Iterator<Item = &'a Recording>) -> Result<RadioFit, InputError> {
    let points = points(recordings);
    let unfit = |wrong: &str| {
        let remedy = "give logs with distances: a TETAM track, a robot's, the trace of a run (CSV or MCAP), or \
                      a table with the column distance_m";
        InputError::new(wrong, remedy)
    };
    if points.len() < LEAST {
        let wrong = format!("{} packets have a known distance; a fit takes {LEAST}", points.len());
        return Err(unfit(&wrong));
    }
    let whole = Law::of(points.iter()).ok_or_else(|| {
        unfit("no link's distance changes enough to tell how the signal falls with it")
    })?;
    let mut random = Stream::new(0, Purpose::Fit);
    let laws = law::resampled(&points, BLOCK, RESAMPLED, &mut random);
    let residuals = whole.residuals(&points);
    let variogram = Variogram::of(&points, &residuals);
    let (best, others) = variogram.fitted(RESAMPLED, &mut random);
    let distance = |p: &Point| 10_f64.powf(p.log_distance);
    Ok(RadioFit {
        packets: points.len(),
        links: whole.gains.len(),
        distances_m: [
            points.iter().map(distance).fold(f64::INFINITY, f64::min),
            points.iter().map(distance).fold(0.0, f64::max),
        ],
        loss_at_1m_db: estimate(whole.loss_at_1m, laws.iter().map(|law| law.loss_at_1m)),
        exponent: estimate(whole.exponent, laws.iter().map(|law| law.exponent)),
        gain_error_db: estimate(whole.gain_error(), laws.iter().map(Law::gain_error)),
        noise_variance_db2: estimate(best.noise, others.iter().map(|other| other.noise)),
        shadowing_db: estimate(best.shadow.sqrt(), others.iter().map(|other| other.shadow.sqrt())),
        decorrelation_m: estimate(best.decorrelation, others.iter().map(|o| o.decorrelation)),
        held_out: held_out(&points).ok_or_else(|| {
            unfit("one half of the recording alone does not tell how the signal falls")
        })?,
    })
}

/// The standard error is half the width of the middle 68 % of the resampled values: where shadowing
/// is weak, some resampled decorrelation distances are as long as any that was tried.
fn estimate(value: f64, resampled: impl Iterator<Item = f64>) -> Estimate {
    let mut sorted: Vec<f64> = resampled.filter(|value| value.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let part = |part: f64| {
        let place = (part * sorted.len() as f64) as usize;
        sorted.get(place).copied().unwrap_or(value)
    };
    Estimate { value, error: 0.5 * (part(0.84) - part(0.16)) }
}

/// The packets of all recordings, each recording's links apart from another's of the same name.
fn points<'a>(recordings: impl Iterator<Item = &'a Recording>) -> Vec<Point> {
    let seconds = |sample: &Sample| sample.time.as_micros() as f64 * 1e-6;
    let mut points = Vec::new();
    let mut links = 0;
    for recording in recordings {
        let begin = recording.samples.first().map_or(0.0, seconds);
        let from = points.len();
        for sample in &recording.samples {
            let Some(ends) = sample.ends else { continue };
            points.push(Point {
                link: links + sample.link,
                time: seconds(sample) - begin,
                log_distance: log_distance(ends.distance),
                rssi: f64::from(sample.rssi.0),
                at: ends.moving,
                early: false,
            });
        }
        links += recording.links.len();
        let half = from + (points.len() - from) / 2;
        for point in &mut points[from..half] {
            point.early = true;
        }
    }
    points
}

/// The logarithm of a distance in metres, to the base 10.
fn log_distance(distance: Metres) -> f64 {
    f64::from(distance.0.max(NEAREST)).log10()
}

/// As in the model, two antennas are at least so far apart, m.
const NEAREST: f32 = 0.3;

fn held_out(points: &[Point]) -> Option<HeldOut> {
    let [mut fitted, mut default] = [0.0; 2];
    for early in [true, false] {
        let law = Law::of(points.iter().filter(|point| point.early == early))?;
        for point in points.iter().filter(|point| point.early != early) {
            fitted += (point.rssi - law.expected(point.log_distance)).powi(2);
            default += (point.rssi - free_space(point.log_distance)).powi(2);
        }
    }
    let root = |squares: f64| (squares / points.len() as f64).sqrt();
    Some(HeldOut { fitted_db: root(fitted), default_db: root(default) })
}

/// The strength that the simulator's law expects in sight, dBm.
fn free_space(log_distance: f64) -> f64 {
    let law = PathLoss::LogDistance(LogDistance::DEFAULT);
    let link = Geometry::in_sight(Metres(10_f64.powf(log_distance) as f32));
    f64::from(Dbm::after_loss(law.loss(link, 0.0)).0)
}

impl RadioFit {
    /// The model as sections of a scenario file.
    #[must_use]
    pub fn scenario(&self) -> String {
        let mut text = String::new();
        let _ = self.write_scenario(&mut text);
        text
    }

    /// The law as sections of a scenario file that play the packets of this log back in place of noise
    /// and shadows.
    #[must_use]
    pub fn trace_scenario(&self, log: &Path) -> String {
        let mut text = String::new();
        let log = toml::Value::from(log.display().to_string());
        let _ = self
            .write_law(&mut text, false)
            .and_then(|()| writeln!(text, "\n[radio.trace]\nlog = {log}"));
        text
    }

    fn write_scenario(&self, text: &mut String) -> fmt::Result {
        self.write_law(text, true)?;
        let deviation = "\n[radio.shadowing]\ndeviation_db";
        write_number(text, deviation, self.shadowing_db, 0.0..=30.0)?;
        write_number(text, "decorrelation_m", self.decorrelation_m, 0.1..=1000.0)
    }

    /// The law and the gains, with the noise of packets or without.
    fn write_law(&self, text: &mut String, with_noise: bool) -> fmt::Result {
        let [near, far] = self.distances_m;
        writeln!(
            text,
            "# Fitted to {} packets of {} links, {near:.1} to {far:.1} m long. Behind each number \
             stands its\n# standard error.",
            self.packets, self.links
        )?;
        // A link has the gains of two drones, which are independent.
        let Estimate { value, error } = self.gain_error_db;
        let of_a_drone = Estimate { value: value / SQRT_2, error: error / SQRT_2 };
        write_number(text, "[radio]\nloss_at_1m_db", self.loss_at_1m_db, 0.0..=100.0)?;
        if with_noise {
            write_number(text, "noise_variance_db2", self.noise_variance_db2, 0.0..=400.0)?;
        }
        write_number(text, "gain_error_db", of_a_drone, 0.0..=20.0)?;
        let exponent = "\n[radio.model]\nlaw = \"log-distance\"\nexponent";
        write_number(text, exponent, self.exponent, 1.0..=8.0)
    }
}

/// Writes a key with its number and the standard error, within what a scenario may have.
fn write_number(
    text: &mut String,
    key: &str,
    number: Estimate,
    range: RangeInclusive<f64>,
) -> fmt::Result {
    let value = number.value.clamp(*range.start(), *range.end());
    write!(text, "{key} = {value:.2} # {:.2}", number.error)?;
    if value != number.value {
        let found = number.value;
        write!(text, "; the fit found {found:.2}, beyond what a scenario may have")?;
    }
    writeln!(text)
}

impl fmt::Display for RadioFit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let HeldOut { fitted_db, default_db } = self.held_out;
        write!(f, "{}", self.scenario())?;
        writeln!(f, "\nheld-out halves: {fitted_db:.2} dB RMSE; free space: {default_db:.2} dB")
    }
}

#[cfg(test)]
mod tests;
