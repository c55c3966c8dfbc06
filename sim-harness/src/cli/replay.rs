//! `uchain replay`: recorded RSSI, and recorded flights.

use std::ffi::OsString;
use std::path::PathBuf;

use chain::policy::{NAMES, Policy};
use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};

use input::InputError;

use super::record::{Made, RecordArgs, Source};
use super::{Common, Trouble, Verdict, complain, emulated, interrupt};
use replay::chip::{self, ChipOptions, ChipSummary, Pace};
use replay::flights::replay_flights;
use replay::{Format, ReplayOptions, StationRecord, replay, station_record};
use report::Folder;
use terminal::Progress;

#[derive(Args)]
pub(super) struct ReplayArgs {
    /// The recordings
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Format of the recordings; where left out, each is recognized by its content
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Movement policy to run over recorded flights; where left out, all of them. On a chip, the
    /// policy of every recording; where left out, chain, and k-tuned for a flight
    #[arg(long, value_parser = PossibleValuesParser::new(NAMES))]
    policy: Option<String>,
    /// Fit a radio model to the packets, and write it as sections of a scenario file,
    /// radio.toml; of one log also trace.toml, which plays its packets back
    #[arg(long, conflicts_with = "on")]
    fit: bool,
    /// Compare filters with the motion and without it, from the packet before and from packets one
    /// and two seconds old
    #[arg(long, conflicts_with = "on")]
    predict: bool,
    /// Run the checks of the flight code over logs of real flights, which the µSD card deck wrote
    #[arg(long, conflicts_with_all = ["on", "fit", "predict", "policy", "format"])]
    flight: bool,
    /// Fit the simulated craft to the flights of each drone, and write it as sections of scenario
    /// files, plant.toml
    #[arg(long, requires = "flight")]
    fit_plant: bool,
    /// Replay on the chip too, and compare its answers with the host's
    #[arg(long, value_enum)]
    on: Option<Chip>,
    /// Pace of the steps on the chip
    #[arg(long, value_enum, default_value_t, requires = "on")]
    pace: Pace,
    /// The firmware's ELF file, for a replay on the chip; where left out, the one that `cargo fw`
    /// builds
    #[arg(long, value_name = "FILE", requires = "on")]
    elf: Option<PathBuf>,
    #[command(flatten)]
    record: RecordArgs,
    #[command(flatten)]
    common: Common,
}

/// The chip of a replay.
#[derive(Clone, Copy, ValueEnum)]
enum Chip {
    /// An emulated Crazyflie
    Virtual,
    /// A board at a debug probe, without propellers
    Probe,
}

pub(super) fn run(args: &ReplayArgs, line: &[OsString]) -> Result<Verdict, Trouble> {
    if args.record.is_given() && !args.flight {
        let wrong = "--record keeps the table of --flight";
        return Err(InputError::new(wrong, "give --flight as well, or leave --record out").into());
    }
    match args.on {
        None if args.flight => over_flights(args, line),
        None => on_host(args),
        Some(chip) => on_chip(args, chip),
    }
}

fn on_host(args: &ReplayArgs) -> Result<Verdict, Trouble> {
    let policy = args.policy.as_deref().and_then(Policy::named);
    let options = ReplayOptions {
        format: args.format,
        policy,
        fit: args.fit,
        predict: args.predict,
        ..ReplayOptions::default()
    };
    interrupt::ends();
    let mut folder = args.common.folder()?;
    let progress = Progress::busy("replay", args.common.quiet);
    let summary = replay(&args.logs, &options)?;
    drop(progress);
    for report in &summary.files {
        if let Some(note) = &report.note {
            complain(format_args!("{}: {note}", report.file));
        }
    }
    let value = serde_json::to_value(&summary)
        .map_err(|error| Trouble::Internal(format!("the summary cannot be written ({error})")))?;
    if let Some(folder) = &mut folder {
        folder.put_json("summary.json", &value)?;
        folder.put("trace.csv", |out| summary.write_series(out))?;
        put_station_report(folder, &args.logs)?;
        if let Some(fit) = &summary.fit {
            folder.put_text("radio.toml", &fit.scenario())?;
            if let [log] = args.logs.as_slice() {
                // The scenario may stand in another folder.
                let log = std::path::absolute(log).unwrap_or_else(|_| log.clone());
                folder.put_text("trace.toml", &fit.trace_scenario(&log))?;
            }
        }
    }
    args.common.finish(folder, &summary.to_string(), &value)?;
    Ok(Verdict::Good)
}

/// Runs the checks of the flight code over real flights. Logs that hold nothing to replay are told
/// at the end, so that they do not hide the others.
fn over_flights(args: &ReplayArgs, line: &[OsString]) -> Result<Verdict, Trouble> {
    interrupt::ends();
    let mut folder = args.common.folder()?;
    let progress = Progress::busy("replay", args.common.quiet);
    let record = args.record.open(Source {
        command: "replay --flight".to_owned(),
        file: "replay-flights",
        about: "The checks of the flight code over logs of real flights",
        page: "replay.md",
    })?;
    let mut summary = replay_flights(&args.logs)?;
    if args.fit_plant {
        summary.fit_plant();
    }
    drop(progress);
    for (file, note) in summary.notes() {
        complain(format_args!("{file}: {note}"));
    }
    let value = serde_json::to_value(&summary)
        .map_err(|error| Trouble::Internal(format!("the summary cannot be written ({error})")))?;
    if let Some(folder) = &mut folder {
        folder.put_json("summary.json", &value)?;
        folder.put("course.csv", |out| summary.write_course(out))?;
        if let Some(plant) = &summary.plant {
            folder.put_text("plant.toml", &plant.scenario())?;
            for drone in &plant.drones {
                folder.put_text(&format!("plant-{}.toml", drone.file_name()), &drone.scenario())?;
            }
        }
    }
    let table = summary.to_string();
    if let Some(record) = record {
        record.write(line, &Made { seeds: None, table: &table, missed: &[] })?;
    }
    args.common.finish(folder, &table, &value)?;
    let mut refused = summary.refused;
    let last = refused.pop();
    refused.iter().for_each(complain);
    last.map_or(Ok(Verdict::Good), |error| Err(error.into()))
}

/// Writes the report of a flight, where the only log is a recording of the ground station.
fn put_station_report(folder: &mut Folder, logs: &[PathBuf]) -> Result<(), Trouble> {
    let [log] = logs else { return Ok(()) };
    if let Some(StationRecord { trace, summary }) = station_record(log)? {
        report::write_report(folder, &trace, &summary)?;
    }
    Ok(())
}

fn on_chip(args: &ReplayArgs, chip: Chip) -> Result<Verdict, Trouble> {
    let policy = args.policy.as_deref().and_then(Policy::named);
    let options = ChipOptions { format: args.format, policy, pace: args.pace };
    interrupt::ends();
    let mut folder = args.common.folder()?;
    let progress = Progress::busy("steps", args.common.quiet);
    let elf = args.elf.as_deref();
    let summary = match chip {
        Chip::Virtual => emulated::replay::run(&args.logs, &options, elf, || progress.step())?,
        Chip::Probe => on_probe(&args.logs, &options, elf, || progress.step())?,
    };
    drop(progress);
    let value = value_of(&summary)
        .map_err(|error| Trouble::Internal(format!("the summary cannot be written ({error})")))?;
    if let Some(folder) = &mut folder {
        folder.put_json("summary.json", &value)?;
        folder.put("steps.csv", |out| summary.write_steps(out))?;
    }
    args.common.finish(folder, &summary.to_string(), &value)?;
    Ok(if summary.is_equal() { Verdict::Good } else { Verdict::Failed })
}

/// The summary of one log is that log's; that of several has the sums, and each log in `logs`.
fn value_of(summary: &ChipSummary) -> serde_json::Result<serde_json::Value> {
    match summary.logs.as_slice() {
        [log] => serde_json::to_value(log),
        _ => serde_json::to_value(summary),
    }
}

#[cfg(feature = "probe")]
fn on_probe(
    logs: &[PathBuf],
    options: &ChipOptions,
    elf: Option<&std::path::Path>,
    stepped: impl FnMut(),
) -> Result<ChipSummary, chip::Error> {
    chip::replay(logs, options, || chip::probe::ProbeTarget::attach(elf), stepped)
}

#[cfg(not(feature = "probe"))]
fn on_probe(
    _: &[PathBuf],
    _: &ChipOptions,
    _: Option<&std::path::Path>,
    _: impl FnMut(),
) -> Result<ChipSummary, chip::Error> {
    let wrong = "replay --on probe: this uchain was built without probe-rs";
    let remedy = "use `cargo sim-probe` in place of `cargo sim`";
    Err(InputError::new(wrong, remedy).into())
}
