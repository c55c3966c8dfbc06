//! `uchain map`: surveys of caves.

use std::path::PathBuf;

use cave_survey::Survey;
use clap::{Args, Subcommand};
use serde_json::json;

use super::{Trouble, Verdict, complain, interrupt, put};
use crate::output::{self, Folder};
use crate::world::import::open;

/// Look at cave surveys.
#[derive(Args)]
pub(super) struct MapArgs {
    #[command(subcommand)]
    verb: MapVerb,
}

#[derive(Subcommand)]
enum MapVerb {
    /// Print the figures of a survey: legs, length, stations, loops and how well they close
    Info(InfoArgs),
    /// Write the stations of a survey with their positions, its legs and its passages as tables
    Convert(ConvertArgs),
}

#[derive(Args)]
struct ConvertArgs {
    /// The survey: Survex (.svx, .3d) or Compass (.dat, .mak)
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Read the files that the survey includes from this folder and those below it; where left
    /// out, from the survey's own folder
    #[arg(long, value_name = "DIR")]
    within: Option<PathBuf>,
    /// Write the tables into this directory; it must be new, empty, or written by uchain before
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Do not say what was written; errors still go to standard error
    #[arg(long)]
    quiet: bool,
}

#[derive(Args)]
struct InfoArgs {
    /// The survey: Survex (.svx, .3d) or Compass (.dat, .mak)
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Read the files that the survey includes from this folder and those below it; where left
    /// out, from the survey's own folder
    #[arg(long, value_name = "DIR")]
    within: Option<PathBuf>,
    /// Print no table; errors still go to standard error
    #[arg(long)]
    quiet: bool,
    /// Print the figures as one JSON value on standard output, instead of the table
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &MapArgs) -> Result<Verdict, Trouble> {
    match &args.verb {
        MapVerb::Info(args) => info(args),
        MapVerb::Convert(args) => convert(args),
    }
}

fn info(args: &InfoArgs) -> Result<Verdict, Trouble> {
    let survey = open(&args.file, args.within.as_deref())?;
    if args.json {
        put(&format!("{:#}\n", figures(&survey)))?;
    } else if !args.quiet {
        put(&table(&survey))?;
    }
    if !args.json {
        for warning in &survey.warnings {
            complain(warning);
        }
    }
    Ok(Verdict::Good)
}

fn convert(args: &ConvertArgs) -> Result<Verdict, Trouble> {
    let survey = open(&args.file, args.within.as_deref())?;
    let mut folder = Folder::open(&args.out)?;
    interrupt::discards(folder.staging());
    output::survey::write(&mut folder, &survey)?;
    for warning in &survey.warnings {
        complain(warning);
    }
    let files = folder.finish()?;
    if !args.quiet {
        let lines = files.iter().map(|file| format!("wrote {}\n", file.display()));
        put(&lines.collect::<String>())?;
    }
    Ok(Verdict::Good)
}

fn figures(survey: &Survey) -> serde_json::Value {
    let it = survey.summary();
    let misclosure = survey.misclosure.as_ref().map_or(0.0, |it| it.error);
    let worst = survey.misclosure.as_ref().map(|it| {
        json!({ "misclosure_m": millimetres(it.error), "length_m": millimetres(it.length), "station": it.station })
    });
    let warnings: Vec<_> = survey.warnings.iter().map(ToString::to_string).collect();
    json!({
        "title": survey.title,
        "legs": it.legs,
        "length_m": millimetres(it.length_m),
        "measured_length_m": millimetres(it.measured_length_m),
        "splays": it.splays,
        "stations": it.stations,
        "with_dimensions": it.with_dimensions,
        "loops": it.loops,
        "misclosure_m": millimetres(misclosure),
        "worst_loop": worst,
        "warnings": warnings,
    })
}

/// The number with three decimals: a survey knows no more.
fn millimetres(metres: f64) -> f64 {
    (metres * 1000.0).round() / 1000.0
}

fn table(survey: &Survey) -> String {
    let it = survey.summary();
    let mut rows = Vec::new();
    if let Some(title) = &survey.title {
        rows.push(("title", title.clone()));
    }
    rows.push(("legs", format!("{}, and {} splays", it.legs, it.splays)));
    rows.push((
        "length",
        format!("{:.2} m, as measured {:.2} m", it.length_m, it.measured_length_m),
    ));
    rows.push(("stations", format!("{}", it.stations)));
    rows.push(("with dimensions", format!("{}", it.with_dimensions)));
    let closes = survey.misclosure.as_ref().map_or_else(String::new, |worst| {
        let at = if worst.station.is_empty() {
            String::new()
        } else {
            format!(", at {}", worst.station)
        };
        format!("; the worst misses by {:.2} m in {:.0} m{at}", worst.error, worst.length)
    });
    rows.push(("loops", format!("{}{closes}", it.loops)));
    if !survey.warnings.is_empty() {
        rows.push(("warnings", format!("{}", survey.warnings.len())));
    }
    rows.iter().map(|(name, value)| format!("{name:<17}{value}\n")).collect()
}
