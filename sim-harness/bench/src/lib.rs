//! The benchmarks of `uchain bench`: one folder each, and the registry of all of them.
//!
//! A benchmark is a type that implements `Benchmark`. Its folder holds everything about it:
//! `mod.rs` has what a user meets (name, arguments, table, and the page of the book that explains
//! it), and `measure.rs` what is measured (cases, flights, bounds, and rows as JSON). One that flies
//! an ELF has its table in `table.rs`, which a build without the emulator leaves out. The command
//! finds the benchmark in `REGISTRY` and makes a sub-command of it that takes its own arguments and
//! those of every verb.

#[cfg(not(feature = "virtual"))]
mod absent;
pub mod attacks;
pub mod chain;
pub mod emulator;
pub mod estimator;
pub mod explore;
pub mod faults;
pub mod firmware;
pub mod forces;
pub mod junctions;
pub mod link;
pub mod mishaps;
mod missions;
mod net;
pub mod placement;
pub mod places;
pub mod stock;
pub mod throughput;

use clap::{ArgMatches, Args, Command};
use input::InputError;
use serde_json::Value;

use report::Folder;
use terminal::Progress;

/// All benchmarks, in the order in which `uchain bench all` runs them.
pub const REGISTRY: &[Entry] = &[
    Entry::of::<chain::ChainBench>(),
    Entry::of::<throughput::ThroughputBench>(),
    Entry::of::<faults::FaultsBench>(),
    Entry::of::<estimator::EstimatorBench>(),
    Entry::of::<link::LinkBench>(),
    Entry::of::<junctions::JunctionsBench>(),
    Entry::of::<places::PlacesBench>(),
    Entry::of::<explore::ExploreBench>(),
    Entry::of::<attacks::AttacksBench>(),
    Entry::of::<placement::PlacementBench>(),
    Entry::of::<forces::ForcesBench>(),
    Entry::of::<firmware::FirmwareBench>(),
    Entry::of::<emulator::EmulatorBench>(),
    Entry::of::<mishaps::MishapsBench>(),
    Entry::of::<stock::StockBench>(),
];

/// A benchmark: the struct holds its arguments, and this trait says the rest.
pub(crate) trait Benchmark: Args + 'static {
    /// Its name on the command line, and that of its JSON file.
    const NAME: &'static str;
    /// One line that says what it measures, for the help.
    const ABOUT: &'static str;
    /// The page of the book, in `docs/src`, that explains it; long tables are in `docs/results`.
    const PAGE: &'static str;
    /// The files that it needs beside this program.
    const NEEDS: Needs = Needs::Nothing;
    /// Whether its random numbers depend on `--seed`.
    const IS_SEEDED: bool = true;

    /// Measures.
    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError>;
}

/// The files that a benchmark needs beside this program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Needs {
    /// It needs none.
    Nothing,
    /// It flies the firmware's ELF in the emulator, which a build with the feature `virtual` has.
    Firmware,
    /// It flies in the places of a folder, which this repository does not have.
    Data,
    /// It flies the vendor's ELF, which no build of this repository makes, in the same emulator.
    VendorsFirmware,
}

/// What a benchmark is given beside its own arguments.
pub struct Session<'a> {
    name: &'static str,
    seed: u64,
    is_quiet: bool,
    folder: Option<&'a mut Folder>,
}

impl<'a> Session<'a> {
    /// What the benchmark of this name is given; `folder` is the one that the results go into, if there
    /// is one.
    pub const fn new(
        name: &'static str,
        seed: u64,
        is_quiet: bool,
        folder: Option<&'a mut Folder>,
    ) -> Self {
        Self { name, seed, is_quiet, folder }
    }

    /// The bar of a task of `total` steps, which are such `things`.
    fn progress(&self, total: usize, things: &str) -> Progress {
        let progress = Progress::new(total as u64, self.is_quiet);
        progress.say(things);
        progress
    }

    /// The bar of a task whose length is not known.
    fn busy(&self) -> Progress {
        Progress::busy(self.name, self.is_quiet)
    }
}

/// The result of a benchmark.
pub struct Outcome {
    /// The table that is printed.
    pub table: String,
    /// The same and more as JSON.
    pub json: Value,
    /// The bounds that were missed, one line each.
    pub missed: Vec<String>,
    /// The seeds that were flown with, in words.
    pub seeds: String,
}

/// The seeds of a row of `count` missions, the first of which has the seed `first`.
fn seeds(first: u64, count: usize) -> String {
    let last = first.wrapping_add(count as u64).wrapping_sub(1);
    if first == last { first.to_string() } else { format!("{first} to {last}") }
}

/// Refuses the first of these options that was given, since it belongs to another model of the benchmark.
fn belong_to(model: &str, given: &[(&str, bool)]) -> Result<(), InputError> {
    match given.iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) => {
            let wrong = format!("{option} belongs to {model}");
            Err(InputError::new(wrong, format!("give {model}, or leave {option} out")))
        }
        None => Ok(()),
    }
}

/// A benchmark with its arguments, ready to run.
pub type Ready = Box<dyn Fn(&mut Session<'_>) -> Result<Outcome, InputError>>;

/// A benchmark as the command sees it.
pub struct Entry {
    /// Its name on the command line.
    pub name: &'static str,
    /// One line that says what it measures.
    pub about: &'static str,
    /// The page of the book that explains it.
    pub page: &'static str,
    pub(crate) needs: Needs,
    /// Whether its random numbers depend on `--seed`.
    pub is_seeded: bool,
    augment: fn(Command) -> Command,
    parse: fn(&ArgMatches) -> Result<Ready, clap::Error>,
}

impl Entry {
    const fn of<B: Benchmark>() -> Self {
        Self {
            name: B::NAME,
            about: B::ABOUT,
            page: B::PAGE,
            needs: B::NEEDS,
            is_seeded: B::IS_SEEDED,
            augment: B::augment_args,
            parse: |matches| {
                let bench = B::from_arg_matches(matches)?;
                Ok(Box::new(move |session| bench.run(session)))
            },
        }
    }

    /// The sub-command, with the benchmark's own arguments.
    pub fn command(&self) -> Command {
        (self.augment)(Command::new(self.name))
    }

    /// The benchmark with the arguments that the sub-command was given.
    pub fn parse(&self, matches: &ArgMatches) -> Result<Ready, clap::Error> {
        (self.parse)(matches)
    }

    /// Whether `uchain bench all` runs it in this build.
    pub fn is_in_all(&self) -> bool {
        match self.needs {
            Needs::Nothing => true,
            Needs::Firmware => cfg!(feature = "virtual"),
            Needs::VendorsFirmware | Needs::Data => false,
        }
    }
}

/// Rounds a value to this many digits after the point.
#[cfg(feature = "virtual")]
fn rounded(value: f64, digits: i32) -> f64 {
    let scale = 10_f64.powi(digits);
    (value * scale).round() / scale
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fs;
    use std::path::Path;

    use super::*;

    #[test]
    fn every_name_is_taken_once() {
        let names: BTreeSet<_> = REGISTRY.iter().map(|entry| entry.name).collect();
        assert_eq!(names.len(), REGISTRY.len());
        assert!(!names.contains("all"), "`bench all` runs all of them");
    }

    /// The page that a benchmark belongs to shows the command that makes its figures.
    #[test]
    fn the_book_has_the_command_of_every_benchmark() {
        let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/src");
        for entry in REGISTRY {
            let page = fs::read_to_string(book.join(entry.page)).expect(entry.page);
            let command = format!("bench {}", entry.name);
            assert!(page.contains(&command), "{} does not mention `{command}`", entry.page);
        }
    }
}
