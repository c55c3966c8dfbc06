//! Runs recorded RSSI, and recorded flights, through the on-board code.
//!
//! Simulated noise is white and its distribution is known; recorded noise is neither. A replay
//! gives the packets of a log to the on-board [`LinkFilter`](chain::filter::LinkFilter), and
//! measures how well the filter predicts the next packet, with and without the motion that the log
//! records. The flights of the U-Chain authors hold no raw packets; for those a replay computes the
//! commands of the movement and launch policies.
//!
//! | file | holds |
//! |---|---|
//! | `prediction` | the six predictors and their scores |
//! | `flight` | the policies over a recorded flight |
//! | [`mod@flights`] | the checks of the flight code over logs of real flights |
//! | `plan` | what a whole drone is told in the replay of a log |
//! | `agents` | the whole drone of each relay over a recorded flight |
//! | [`chip`] | the same on a chip, compared with the host |
//! | `horizons` | filters with and without the motion, from packets of any age |
//! | `station` | a recording of the ground station as the record of a mission |
//! | `summary` | the results as a table, as JSON and as a CSV of every sample |
//!
//! The book's chapter "Replay" defines every number.

mod agents;
pub mod chip;
mod flight;
pub mod flights;
mod horizons;
mod plan;
mod prediction;
mod station;
mod summary;

use std::path::{Path, PathBuf};

use chain::filter::Kalman;
use chain::policy::{Policy, REGISTRY};

pub use agents::AgentReport;
pub use flight::{Commands, Equality};
pub use horizons::{Gain, Horizon, Horizons, Interval, LinkHorizons, LogHorizons, PredictorScore};
pub use prediction::{Prediction, REAL_LINK, Score};
pub use recordings::Format;
pub use recordings::fit::{Estimate, HeldOut, RadioFit};
pub use recordings::recording::{Anomalies, Anomaly};
pub use station::{StationRecord, station_record};
pub use summary::{FileReport, LinkReport, ReplaySummary};

use input::InputError;
use recordings::recording::Recording;
use recordings::{fit, formats};

/// The options of a replay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReplayOptions {
    /// The format of all logs; with `None` each is recognized by its content.
    pub format: Option<Format>,
    /// The movement policy to run over flights; `None` runs them all.
    pub policy: Option<&'static Policy>,
    /// The constants of the filters.
    pub kalman: Kalman,
    /// Whether a radio model is fitted to the packets.
    pub fit: bool,
    /// Whether filters with and without the motion are compared.
    pub predict: bool,
}

impl Default for ReplayOptions {
    fn default() -> Self {
        Self { format: None, policy: None, kalman: REAL_LINK, fit: false, predict: false }
    }
}

/// Replays every file.
///
/// # Errors
/// A file that cannot be read, or is not a log of the kind that it should be. Single rows that are
/// wrong are no error: the summary counts them.
pub fn replay(files: &[PathBuf], options: &ReplayOptions) -> Result<ReplaySummary, InputError> {
    if files.is_empty() {
        return Err(InputError::new("no log was given", "name at least one: uchain replay LOG…"));
    }
    let policies = options.policy.map_or_else(|| REGISTRY.iter().collect(), |policy| vec![policy]);
    let mut summary = ReplaySummary::default();
    let mut recordings: Vec<(&Path, Recording)> = Vec::new();
    for file in files {
        let (format, recording) = formats::read(file, options.format)?;
        if options.fit || options.predict {
            recordings.push((file, recording.clone()));
        }
        summary.add(match format {
            Format::UchainFlight => {
                let flight = flight::analyse(&recording, &policies);
                let agents = agents::agents(&recording);
                FileReport::of_flight(file, recording, flight, agents)
            }
            _ => {
                let foresights = prediction::foresee_all(&recording, options.kalman);
                FileReport::of_packets(file, format, recording, foresights)
            }
        });
    }
    if options.predict {
        summary.horizons = Some(horizons::compare(&recordings));
    }
    if options.fit {
        summary.fit = Some(fit::fit(recordings.iter().map(|(_, recording)| recording))?);
    }
    Ok(summary)
}
