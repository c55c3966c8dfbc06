//! Defines the `uchain` command.
//!
//! Results go to standard output, progress and error messages to standard error. The exit status is
//!
//! | status | when |
//! |---|---|
//! | 0 | all went well |
//! | 1 | the mission failed, a criterion was missed, or a chip differs from the host or went away |
//! | 2 | the input cannot be used, or the output cannot be written; one line says what, where, and how to correct it |
//! | 101 | `uchain` panicked, which is a defect |
//! | 130 | Ctrl-C ended the command |
//! | 141 | the program that read standard output ended early, as `head` does |

mod bench;
mod bridge;
mod campaign;
#[cfg_attr(not(feature = "virtual"), path = "emulated/absent.rs")]
mod emulated;
mod figures;
mod interrupt;
mod keys;
mod map;
pub mod plan;
mod record;
mod replay;
mod run;
mod serve;
mod usage;

use std::ffi::OsString;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use chain::policy::NAMES;
use clap::{Args, Parser, Subcommand, ValueEnum};
use input::{InputError, suggest};

use report::{Folder, OutputError};
use scenario::{Fidelity, LinkModel, Scenario, Setting, builtin};
use terminal::FidelityArg;

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
    /// Fly a scenario many times, each time with another seed, on all cores
    Campaign(campaign::CampaignArgs),
    /// Make a paper's figures as tables and pictures, and say which of its claims hold
    Figures(figures::FiguresArgs),
    /// Run recorded signal strengths (RSSI), or real flights, through the on-board code
    Replay(replay::ReplayArgs),
    /// Simulate drones that cfclient and cflib connect to over UDP
    Serve(serve::ServeArgs),
    /// Give cfclient a real drone at a UDP port, through a Crazyradio with a limit on its polls
    Bridge(bridge::BridgeArgs),
    /// Make the keys of a fleet, and give them to its drones
    Keys(keys::KeysArgs),
    /// Look at cave surveys
    Map(map::MapArgs),
    /// Plan a mission on paper: the relays that a way needs
    Plan(plan::PlanArgs),
    /// Run one of the benchmarks, or all of them
    Bench(bench::BenchArgs),
}

/// The options of every verb that flies or computes.
#[derive(Args)]
struct Common {
    /// Seed of all random numbers; a campaign uses this one and those after it
    #[arg(long, allow_negative_numbers = true, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// Write all results into this directory; it must be new, empty, or written by uchain before
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print no table and no progress bar; errors still go to standard error
    #[arg(long)]
    quiet: bool,
    /// Print the summary as one JSON value on standard output, instead of the table
    #[arg(long)]
    json: bool,
}

impl Common {
    /// Whether the result is printed as a table.
    const fn prints_table(&self) -> bool {
        !self.json && !self.quiet
    }

    /// The directory that `--out` names, made sure of before anything is flown for it.
    fn folder(&self) -> Result<Option<Folder>, InputError> {
        let folder = self.out.as_deref().map(Folder::open).transpose()?;
        if let Some(folder) = &folder {
            interrupt::discards(folder.staging());
        }
        Ok(folder)
    }

    /// Puts what was written in place, and prints the result the way it was asked for.
    fn finish(
        &self,
        folder: Option<Folder>,
        table: &str,
        summary: &serde_json::Value,
    ) -> Result<(), Trouble> {
        let files = folder.map_or_else(|| Ok(Vec::new()), Folder::finish)?;
        if self.json {
            return put(&format!("{summary:#}\n"));
        }
        if self.quiet {
            return Ok(());
        }
        let mut text = table.to_owned();
        if !files.is_empty() {
            text.push('\n');
        }
        for file in files {
            text += &format!("wrote {}\n", file.display());
        }
        put(&text)
    }
}

/// The option that changes single keys of a scenario.
#[derive(Args)]
struct SetArgs {
    /// Give a key of the scenario another value, such as radio.packet_loss=0.3; may be repeated.
    /// The book's chapter "Scenarios" lists all keys
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

impl SetArgs {
    /// The settings, read but not yet compared with a scenario.
    fn settings(&self) -> Result<Vec<Setting>, InputError> {
        self.set.iter().map(|text| Setting::parse(text)).collect()
    }
}

/// The options that name the virtual drones of a mission.
#[derive(Args)]
struct VirtualArgs {
    /// The firmware's ELF file, for virtual drones; where left out, the one that `cargo fw` builds
    #[arg(long, value_name = "FILE")]
    elf: Option<PathBuf>,
    /// The radio chip's own firmware, crazyflie2-nrf-firmware built with BLE=0 (ELF, Intel hex, image or
    /// the vendor's archive with it); where left out, the radio chip is a model
    #[arg(long, value_name = "FILE")]
    radio_elf: Option<PathBuf>,
    /// Numbers of the virtual drones, separated by commas; where left out, all that fly. 0 is the head
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_delimiter = ',')]
    virtual_drones: Vec<u8>,
}

impl VirtualArgs {
    /// Whether one of them was given.
    const fn are_given(&self) -> bool {
        self.elf.is_some() || self.radio_elf.is_some() || !self.virtual_drones.is_empty()
    }
}

/// Writes to standard output.
fn put(text: &str) -> Result<(), Trouble> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(Trouble::Output)
}

/// Says something on standard error, in one line.
fn complain(what: impl std::fmt::Display) {
    // Where standard error is closed, the line is lost.
    let _ = writeln!(io::stderr(), "uchain: {what}");
}

/// The end of a verb.
enum Verdict {
    /// The verb has done its work.
    Good,
    /// The mission failed, or a criterion was missed.
    Failed,
    /// Ctrl-C ended it before all was done that was asked.
    Interrupted,
}

/// Why a verb could not do its work.
enum Trouble {
    /// The input cannot be used.
    Input(InputError),
    /// Standard output cannot be written.
    Output(io::Error),
    /// The chip of a replay went away.
    Chip(String),
    /// A defect of this program.
    Internal(String),
}

impl From<InputError> for Trouble {
    fn from(error: InputError) -> Self {
        Self::Input(error)
    }
}

impl From<::replay::chip::Error> for Trouble {
    fn from(error: ::replay::chip::Error) -> Self {
        match error {
            ::replay::chip::Error::Input(error) => Self::Input(error),
            ::replay::chip::Error::Lost(what) => Self::Chip(what),
        }
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

impl From<report::pictures::PictureError> for Trouble {
    fn from(error: report::pictures::PictureError) -> Self {
        Self::Internal(error.to_string())
    }
}

/// The whole program.
#[must_use]
pub fn main() -> ExitCode {
    ExitCode::from(main_with(std::env::args_os()))
}

/// Carries out a command line, whose first argument is the program's name; returns the exit status.
pub fn main_with(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let line: Vec<OsString> = arguments.into_iter().collect();
    let command = match Command::try_parse_from(&line) {
        Ok(command) => command,
        Err(error) => return usage::told(&error),
    };
    let done = match command.verb {
        Verb::Run(args) => run::run(&args),
        Verb::Campaign(args) => campaign::run(&args),
        Verb::Figures(args) => figures::run(&args, &line),
        Verb::Replay(args) => replay::run(&args, &line),
        Verb::Serve(args) => serve::run(&args),
        Verb::Bridge(args) => bridge::run(&args),
        Verb::Keys(args) => keys::run(&args),
        Verb::Map(args) => map::run(&args),
        Verb::Plan(args) => plan::run(&args),
        Verb::Bench(args) => bench::run(&args, &line),
    };
    match done {
        Ok(Verdict::Good) => 0,
        Ok(Verdict::Failed) => 1,
        Ok(Verdict::Interrupted) => interrupt::STATUS,
        Err(trouble) => trouble.told(),
    }
}

impl Trouble {
    /// Tells of it, and returns the exit status.
    fn told(&self) -> u8 {
        match self {
            Self::Input(error) => {
                complain(error);
                2
            }
            // As shells say it of a program that a closed pipe has ended: 128 and the signal's
            // number. The reader knows that it went away.
            Self::Output(error) if error.kind() == io::ErrorKind::BrokenPipe => 141,
            Self::Output(error) => {
                complain(format_args!(
                    "standard output cannot be written: {error}; send it where there is room"
                ));
                2
            }
            Self::Chip(what) => {
                complain(what);
                1
            }
            Self::Internal(what) => {
                complain(format_args!("{what}; this is a defect of uchain, please report it"));
                101
            }
        }
    }
}

/// How reports and orders get from drone to drone.
#[derive(Clone, Copy, ValueEnum)]
enum LinkArg {
    /// In packets, byte by byte, in turns
    Exact,
    /// Reports and orders alone, with a loss and a delay from a table; for points only
    Ideal,
}

impl LinkArg {
    const fn link(self) -> LinkModel {
        match self {
            Self::Exact => LinkModel::Exact,
            Self::Ideal => LinkModel::Ideal,
        }
    }
}

/// The scenario with this link, or the link that it has.
fn with_link(scenario: Scenario, link: Option<LinkArg>) -> Result<Scenario, InputError> {
    let link = link.map_or(scenario.link, LinkArg::link);
    if !link.suits(scenario.fidelity) {
        let fidelity = scenario.fidelity.name();
        let wrong = format!("the link \"ideal\" is not for the fidelity \"{fidelity}\"");
        return Err(InputError::new(wrong, "give --link exact, or --fidelity point"));
    }
    Ok(Scenario { link, ..scenario })
}

/// The scenario, unless it flies virtual drones.
fn on_the_host(scenario: Scenario) -> Result<Scenario, InputError> {
    if scenario.fidelity == Fidelity::Virtual {
        let wrong = "virtual drones fly with `uchain run` and `uchain serve` only";
        return Err(InputError::new(wrong, "give --fidelity flight"));
    }
    Ok(scenario)
}

/// A scenario, with another policy and another fidelity where they were asked for.
fn scenario(
    name: &str,
    policy: Option<&str>,
    fidelity: Option<FidelityArg>,
) -> Result<Scenario, InputError> {
    adapted(Scenario::open(name)?, policy, fidelity)
}

/// The scenario, with another policy and another fidelity where they were asked for.
fn adapted(
    mut scenario: Scenario,
    policy: Option<&str>,
    fidelity: Option<FidelityArg>,
) -> Result<Scenario, InputError> {
    if let Some(asked) = fidelity {
        scenario.fidelity = asked.fidelity()?;
    }
    match policy {
        None => Ok(scenario),
        Some(policy) => scenario.with_policy(policy).ok_or_else(|| {
            InputError::new(
                format!("there is no policy \"{policy}\""),
                suggest::one_of(policy, &NAMES),
            )
        }),
    }
}

/// The built-in scenarios with their titles, for the end of a verb's help.
fn builtin_scenarios() -> String {
    let width = builtin::names().map(str::len).max().unwrap_or(0);
    let lines = builtin::titles().map(|(name, title)| format!("  {name:width$}  {title}\n"));
    format!("Built-in scenarios:\n{}", lines.collect::<String>())
}
