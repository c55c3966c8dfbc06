//! Runs the checks of the flight code over logs of real flights, which other firmware flew.
//!
//! | file | holds |
//! |---|---|
//! | `track` | one signal over time |
//! | `signals` | the signals of a log, by the vendor's names |
//! | `airborne` | when the drone was in the air, and how each flight ended |
//! | `course` | the checks of the flight code, stepped over a log |
//! | `plant` | the simulated craft, fitted to the logs of each drone |
//! | `predicted` | how well such a fit predicts what it has not seen |
//! | `report` | what they said in one log |
//! | `sag` | the battery under load |
//! | `spread` | the distribution of a measure |
//! | `summary` | what all logs have in common |
//! | `table` | both as text |

mod airborne;
mod course;
mod plant;
mod predicted;
mod report;
mod sag;
mod signals;
mod spread;
mod summary;
mod table;
mod track;

use std::path::{Path, PathBuf};

use flight::FlightConfig;
use input::InputError;
use recordings::variables::Variables;

pub use airborne::Ending;
pub use course::Phase;
pub use plant::{DroneFit, PlantFit};
pub use predicted::{Errors, Prediction};
pub use report::{AccelReport, BatteryReport, EndReport, GyroReport, LogReport, TorqueReport};
pub use spread::Spread;
pub use summary::{FlightSummary, OverAll};

use course::Course;
use signals::{Force, Signals};

/// Replays every log. A log with nothing to replay is among [`refused`](FlightSummary::refused), and
/// the others are replayed none the less.
///
/// # Errors
/// The only log, or every log, has nothing to replay.
pub fn replay_flights(files: &[PathBuf]) -> Result<FlightSummary, InputError> {
    let config = FlightConfig::CRAZYFLIE_2_1;
    let mut summary = FlightSummary::default();
    for file in files {
        match replay_flight(&config, file) {
            Ok((report, course)) => summary.add(report, course),
            Err(error) => summary.refused.push(error),
        }
    }
    if summary.logs.is_empty()
        && let Some(error) = summary.refused.pop()
    {
        return Err(error);
    }
    summary.finish();
    Ok(summary)
}

fn replay_flight(config: &FlightConfig, file: &Path) -> Result<(LogReport, Course), InputError> {
    let log = Variables::read(file)?;
    let signals = Signals::of(&log, file)?;
    let flights = airborne::flights(&signals, &config.airframe);
    if flights.is_empty() {
        let wrong = "the drone does not fly in this log";
        let remedy = "give a log with a flight of more than a second, with motor.* or gyro.*";
        return Err(InputError::new(wrong, remedy).in_file(file));
    }
    let course = course::run(config, &signals, &flights);
    let weighs = signals.force.is_some() && signals.has_motors();
    let first = signals.timeline.first().copied().unwrap_or(0.0);
    let report = LogReport {
        file: file.display().to_string(),
        drone: drone_of(file),
        duration_s: signals.timeline.last().copied().unwrap_or(0.0) - first,
        period_ms: 1e3 * signals.period,
        flights: flights.len(),
        airborne_s: report::airborne_s(&flights),
        ended: flights.iter().map(|flight| flight.ending).collect(),
        ends: report::ends(config, &course),
        accel: weighs.then(|| report::accel(config, &course)).flatten(),
        gyro: signals.gyro.is_some().then(|| report::gyro(&course)),
        torque: report::torque(config, &course),
        battery: report::battery(&course),
        has_accelerometer: matches!(signals.force, Some(Force::Sensor(_))),
        missing: signals.missing(),
        note: log.note,
    };
    Ok((report, course))
}

/// The drone of a log: the folder, in which all flights have the same propellers and weights, and
/// the part of the file's name before `_log`, as in `normal/E8_log00`.
fn drone_of(file: &Path) -> String {
    let text = |part: &std::ffi::OsStr| part.to_string_lossy().into_owned();
    let name = file.file_stem().map(text).unwrap_or_default();
    let folder = file.parent().and_then(Path::file_name).map(text);
    match (folder, name.split_once("_log")) {
        (Some(folder), Some((drone, _))) if !drone.is_empty() => format!("{folder}/{drone}"),
        (None, Some((drone, _))) if !drone.is_empty() => drone.to_owned(),
        (Some(folder), _) => folder,
        (None, _) => name,
    }
}
