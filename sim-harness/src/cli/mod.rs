//! The `uchain` command.
//!
//! Results go to standard output, progress and complaints to standard error. Exit status 0: all
//! went well; 1: the mission failed, or a criterion was missed; 2: bad input, told in one line
//! that says what, where, and how to mend it.

mod bench;
mod campaign;
mod emulated;
mod figures;
mod keys;
mod progress;
mod replay;
mod run;
mod serve;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::input_error::InputError;
use crate::output::OutputError;
use crate::scenario::{Fidelity, POLICIES, Scenario};

/// U-Chain: relay drones that keep a team connected underground, in simulation and replay.
#[derive(Parser)]
#[command(name = "uchain", version, max_term_width = 100)]
struct Command {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Fly one mission; without a scenario, the demonstration
    Run(run::RunArgs),
    /// Fly a scenario with many seeds on all cores, with confidence intervals
    Campaign(campaign::CampaignArgs),
    /// Make the paper's figure 3, A to F, as tables and pictures
    Figures(figures::FiguresArgs),
    /// Run recorded RSSI through the on-board code
    Replay(replay::ReplayArgs),
    /// Put every drone of a scenario on a UDP port, for cfclient and cflib
    Serve(serve::ServeArgs),
    /// Make the keys of a fleet and provision its drones with them
    Keys(keys::KeysArgs),
    /// Run the named benchmarks; without a name, all of them
    Bench(bench::BenchArgs),
}

/// What every verb takes.
#[derive(Args)]
struct Common {
    /// Seed of everything random; runs of a campaign take it and the numbers after it
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// Write everything there is to keep into this directory
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// No progress bar and no table; complaints go to standard error all the same
    #[arg(long)]
    quiet: bool,
    /// Print the summary as JSON on standard output
    #[arg(long)]
    json: bool,
}

impl Common {
    /// Prints the result the way it was asked for.
    fn print(&self, table: &str, summary: &serde_json::Value) {
        if self.json {
            put(&format!("{summary:#}\n"));
        } else if !self.quiet {
            put(table);
        }
    }

    /// Says what was written.
    fn wrote(&self, files: &[PathBuf]) {
        if !self.quiet && !self.json {
            put("\n");
            for file in files {
                put(&format!("wrote {}\n", file.display()));
            }
        }
    }
}

/// Writes to standard output; a reader who has gone away is no error of ours.
fn put(text: &str) {
    use std::io::Write;
    let _ = std::io::stdout().write_all(text.as_bytes());
}

/// How a verb ended.
enum Verdict {
    /// As it should.
    Good,
    /// The mission failed, or a criterion was missed.
    Failed,
}

/// Why a verb could not do its work.
enum Trouble {
    /// The user's to mend.
    Input(InputError),
    /// Ours.
    Internal(String),
}

impl From<InputError> for Trouble {
    fn from(error: InputError) -> Self {
        Self::Input(error)
    }
}

impl From<OutputError> for Trouble {
    fn from(error: OutputError) -> Self {
        match error {
            OutputError::Input(error) => Self::Input(error),
            OutputError::Picture(error) => Self::Internal(error.to_string()),
        }
    }
}

impl From<crate::output::pictures::PictureError> for Trouble {
    fn from(error: crate::output::pictures::PictureError) -> Self {
        Self::Internal(error.to_string())
    }
}

/// The whole program.
#[must_use]
pub fn main() -> ExitCode {
    let command = match Command::try_parse() {
        Ok(command) => command,
        Err(error) => return usage(&error),
    };
    let done = match command.verb {
        Verb::Run(args) => run::run(&args),
        Verb::Campaign(args) => campaign::run(&args),
        Verb::Figures(args) => figures::run(&args),
        Verb::Replay(args) => replay::run(&args),
        Verb::Serve(args) => serve::run(&args),
        Verb::Keys(args) => keys::run(&args),
        Verb::Bench(args) => bench::run(&args),
    };
    match done {
        Ok(Verdict::Good) => ExitCode::SUCCESS,
        Ok(Verdict::Failed) => ExitCode::from(1),
        Err(Trouble::Input(error)) => {
            eprintln!("uchain: {error}");
            ExitCode::from(2)
        }
        Err(Trouble::Internal(what)) => {
            eprintln!("uchain: {what}; this is a defect of uchain, please report it");
            ExitCode::from(101)
        }
    }
}

/// Help and version are answers; everything else that `clap` has to say is bad input, put in one
/// line.
fn usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    if error.kind() == clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        let _ = error.print();
        return ExitCode::from(2);
    }
    let text = error.to_string();
    let lines: Vec<_> = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:"))
        .filter(|line| !line.is_empty())
        .filter(|line| !line.starts_with("For more information") && !line.starts_with("tip:"))
        .collect();
    let what = lines.join(" ");
    eprintln!("uchain: {}; see uchain --help", what.trim_start_matches("error: "));
    ExitCode::from(2)
}

/// How closely the vehicle is simulated.
#[derive(Clone, Copy, ValueEnum)]
enum FidelityArg {
    /// A velocity-limited first-order point on the floor plan
    Policy,
    /// A rigid body with motors, battery and sensors, and the flight code in the loop
    Flight,
}

/// As it is printed: to so many digits behind the point.
fn rounded(value: f64, digits: i32) -> f64 {
    let scale = 10_f64.powi(digits);
    (value * scale).round() / scale
}

/// A scenario, with another policy and another fidelity where they were asked for.
fn scenario(
    name: &str,
    policy: Option<&str>,
    fidelity: Option<FidelityArg>,
) -> Result<Scenario, InputError> {
    let mut scenario = Scenario::open(name)?;
    match fidelity {
        None => {}
        Some(FidelityArg::Policy) => scenario.fidelity = Fidelity::Policy,
        Some(FidelityArg::Flight) => scenario.fidelity = Fidelity::Flight,
    }
    match policy {
        None => Ok(scenario),
        Some(policy) => scenario.with_policy(policy).ok_or_else(|| {
            InputError::new(
                format!("there is no policy \"{policy}\""),
                format!("give one of {}", POLICIES.join(", ")),
            )
        }),
    }
}

/// A number of runs that makes sense.
fn runs(count: usize) -> Result<usize, InputError> {
    if (1..=1_000_000).contains(&count) {
        return Ok(count);
    }
    Err(InputError::new(format!("--runs {count} is out of range"), "give 1 to 1000000"))
}
