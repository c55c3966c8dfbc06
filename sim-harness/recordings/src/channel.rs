//! Reads a log as the channel of a simulated mission.

use std::path::Path;

use input::InputError;
use units::{Db, Duration, Instant};

use super::fit::Law;
use super::formats::{self, Format};
use super::recording::{Recording, Sample};
use crate::recorded::{RecordedChannel, Residual};

/// The time that counts for a silence in which the log or its clock began anew: a round of the
/// chain's loop.
const ANEW: Duration = Duration::from_millis(200);

/// Reads a log, in the format given or the one that its content shows, and takes from each packet
/// what it is stronger than the law that fits the log. Without distances it is what the packet is
/// stronger than the mean of its link.
///
/// # Errors
/// A file that cannot be read or is not a log, or in which no link has enough packets.
pub fn recorded_channel(
    file: &Path,
    format: Option<Format>,
) -> Result<RecordedChannel, InputError> {
    let (_, recording) = formats::read(file, format)?;
    let law = Law::of_recording(&recording);
    let links = 0..recording.links.len();
    RecordedChannel::of(links.map(|link| residuals(&recording, law.as_ref(), link))).ok_or_else(
        || {
            let wrong = format!("none of its {} links has 20 packets", recording.links.len());
            InputError::new(wrong, "give a longer log").in_file(file)
        },
    )
}

fn residuals(recording: &Recording, law: Option<&Law>, link: usize) -> Vec<Residual> {
    let of_link =
        |sample: &&Sample| sample.link == link && (law.is_none() || sample.ends.is_some());
    let samples: Vec<&Sample> = recording.samples.iter().filter(of_link).collect();
    let sum: f32 = samples.iter().map(|sample| sample.rssi.0).sum();
    let mean = sum / samples.len() as f32;
    let mut at_us = 0;
    let mut before: Option<Instant> = None;
    let residual = |sample: &Sample| {
        let passed = before.map_or(Duration::ZERO, |before| match sample.restarts {
            true => ANEW,
            false => sample.time.since(before),
        });
        before = Some(sample.time);
        at_us += passed.as_micros();
        let law = law.zip(sample.ends);
        Residual {
            at_us,
            distance: law.map(|(_, ends)| ends.distance),
            residual: Db(law.map_or(sample.rssi.0 - mean, |(law, ends)| {
                law.residual(link, ends.distance, sample.rssi)
            })),
        }
    };
    samples.into_iter().map(residual).collect()
}
