//! `uchain map`: surveys of caves.

use std::path::{Path, PathBuf};

use cave_survey::{Files, Folder, Refusal, Survey};
use clap::{Args, Subcommand};
use serde_json::json;

use super::{Trouble, Verdict, complain, put};
use crate::input_error::InputError;

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
}

/// The options that name a survey.
#[derive(Args)]
pub(super) struct SurveyArgs {
    /// Read the files that the survey includes from this folder and those below it; where left
    /// out, from the survey's own folder
    #[arg(long, value_name = "DIR")]
    within: Option<PathBuf>,
}

#[derive(Args)]
struct InfoArgs {
    /// The survey: Survex (.svx, .3d) or Compass (.dat, .mak)
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    survey: SurveyArgs,
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
    }
}

impl SurveyArgs {
    /// Reads the survey `file`.
    pub(super) fn open(&self, file: &Path) -> Result<Survey, InputError> {
        let lost = |error: std::io::Error| {
            InputError::new(format!("cannot be read: {error}"), "give a survey file").in_file(file)
        };
        let real = file.canonicalize().map_err(lost)?;
        let beside = file.parent().filter(|folder| !folder.as_os_str().is_empty());
        let root = self.within.as_deref().or(beside).unwrap_or(Path::new("."));
        let unusable = |error: std::io::Error| {
            let wrong = format!("the folder cannot be read: {error}");
            InputError::new(wrong, "give another to --within").in_file(root)
        };
        let folder = Folder::new(root).map_err(unusable)?;
        let whole = root.canonicalize().map_err(unusable)?;
        // A file that is named on the command line is read wherever a link leads.
        let entry = real.strip_prefix(&whole).ok().and_then(Path::to_str);
        match entry {
            Some(entry) => read(&folder, &entry.replace('\\', "/")),
            None if self.within.is_none() => {
                let name = file.file_name().and_then(|name| name.to_str()).unwrap_or_default();
                let bytes = std::fs::read(&real).map_err(lost)?;
                read(&Named { folder, name, path: file, bytes }, name)
            }
            None => Err(InputError::new(
                format!("it does not lie within {}", root.display()),
                "give the folder that holds all of the survey to --within",
            )
            .in_file(file)),
        }
    }
}

fn read(files: &dyn Files, entry: &str) -> Result<Survey, InputError> {
    cave_survey::read(files, entry).map_err(refused)
}

/// A file of the command line, and the folder of what it includes.
struct Named<'a> {
    folder: Folder,
    name: &'a str,
    path: &'a Path,
    bytes: Vec<u8>,
}

impl Files for Named<'_> {
    fn open(&self, path: &str) -> Result<cave_survey::Opened, cave_survey::FileError> {
        if path == self.name {
            let path = self.path.to_string_lossy().into_owned();
            return Ok(cave_survey::Opened { path, bytes: self.bytes.clone() });
        }
        self.folder.open(path)
    }
}

/// The error of a survey that cannot be used.
fn refused(refusal: Refusal) -> InputError {
    let error = InputError::new(refusal.wrong, refusal.remedy);
    match refusal.place {
        Some(place) if place.line > 0 => {
            error.at_line(Path::new(&*place.file), place.line as usize)
        }
        Some(place) => error.in_file(Path::new(&*place.file)),
        None => error,
    }
}

fn info(args: &InfoArgs) -> Result<Verdict, Trouble> {
    let survey = args.survey.open(&args.file)?;
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
