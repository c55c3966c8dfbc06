//! Replays a log on a chip and on the host, by the same requests, and compares the answers bit for
//! bit.
//!
//! | file | holds |
//! |---|---|
//! | `host` | the drone on the host |
//! | `target` | the door to a chip with a debug probe: two channels of bytes |
//! | `link` | requests and answers over a target |
//! | `emulated` | the target of an emulated Crazyflie, with the feature `virtual` |
//! | `probe` | the target of a board at a debug probe, with the feature `probe` |
//! | `report` | the results as a table, as JSON and as a CSV of every step |

#[cfg(feature = "virtual")]
pub mod emulated;
mod host;
mod link;
#[cfg(feature = "probe")]
pub mod probe;
mod report;
mod target;

use std::path::{Path, PathBuf};

use chain::policy::Policy;
use input::InputError;
use onboard::replay::Answer;
use units::Duration;

use super::plan::{self, Run};
use recordings::formats::{self, Format};

pub(super) use host::Host;
pub use link::{Error, Link};
pub use report::{ChipReport, ChipSummary, Difference, Row};
pub use target::{Lost, Target};

/// The pace of the steps on the chip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Pace {
    /// As fast as the chip answers
    #[default]
    Fast,
    /// Five steps a second by the chip's clock, as in flight
    #[value(name = "5hz")]
    FiveHertz,
}

/// The period of the steps at 5 Hz.
const ROUND: Duration = Duration::from_millis(200);

/// The options of a replay on a chip.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChipOptions {
    /// The format of all logs; with `None` each is recognized by its content.
    pub format: Option<Format>,
    /// The movement policy; with `None` it is `chain`, and `k-tuned` for a flight, whose strengths
    /// were filtered when they were logged.
    pub policy: Option<&'static Policy>,
    /// The pace of the steps.
    pub pace: Pace,
}

/// A log that is planned: what its drones are told.
struct Planned {
    file: PathBuf,
    policy: &'static str,
    links_left_out: usize,
    runs: Vec<Run>,
}

/// Reads and plans all logs, so that none is found to be wrong after others were replayed.
fn plan(files: &[PathBuf], options: &ChipOptions) -> Result<Vec<Planned>, InputError> {
    files.iter().map(|file| plan_one(file, options)).collect()
}

fn plan_one(file: &Path, options: &ChipOptions) -> Result<Planned, InputError> {
    let (format, recording) = formats::read(file, options.format)?;
    let usual = if format == Format::UchainFlight { "k-tuned" } else { "chain" };
    let policy = options.policy.or_else(|| Policy::named(usual));
    let policy = policy.expect("the registry has both");
    let (runs, heard) = match format {
        Format::UchainFlight => (plan::of_flight(&recording, policy), recording.links.len()),
        _ => (plan::of_packets(&recording, policy), plan::chosen_links(&recording).len()),
    };
    if runs.iter().all(|run| run.steps.is_empty()) {
        let wrong = "a flight of one link has no relay that could be replayed";
        return Err(InputError::new(wrong, "give a flight of two links or more").in_file(file));
    }
    let links_left_out = recording.links.len() - heard;
    Ok(Planned { file: file.to_owned(), policy: policy.name, links_left_out, runs })
}

/// Replays every file on the chip behind `target`, and on the host.
///
/// # Errors
/// A file that is no log, and a chip that cannot replay, or goes away.
pub fn replay<T: Target>(
    files: &[PathBuf],
    options: &ChipOptions,
    target: impl FnOnce() -> Result<T, InputError>,
    mut stepped: impl FnMut(),
) -> Result<ChipSummary, Error> {
    let planned = plan(files, options)?;
    let mut link = Link::new(target()?)?;
    let reports = planned.iter().map(|log| compare(log, options.pace, &mut link, &mut stepped));
    Ok(ChipSummary::of(T::NAME, reports.collect::<Result<_, _>>()?))
}

fn compare<T: Target>(
    log: &Planned,
    pace: Pace,
    link: &mut Link<T>,
    stepped: &mut impl FnMut(),
) -> Result<ChipReport, Error> {
    let file = log.file.display().to_string();
    let mut report = ChipReport::new(file, T::NAME, log.policy, log.links_left_out);
    for run in &log.runs {
        let mut host = Host::new();
        let (mine, chip) = (host.begin(run), link.begin(run.begin)?);
        if mine != chip {
            return Err(link.unexpected(&chip));
        }
        for step in &run.steps {
            let due = link.now() + ROUND;
            let chip = match link.step(step.clone())? {
                Answer::Stepped(chip) => chip,
                other => return Err(link.unexpected(&other)),
            };
            let Some(mine) = host.step(step) else { return Err(link.unexpected(&Answer::Begun)) };
            report.add(run.begin.node, step.now, mine, chip);
            stepped();
            if pace == Pace::FiveHertz {
                link.wait_until(due)?;
            }
        }
    }
    Ok(report)
}
