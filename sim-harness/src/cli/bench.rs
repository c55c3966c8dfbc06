//! `uchain bench`: finds a benchmark in the registry, and prints what it measures.

use std::ffi::OsString;

use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, Subcommand, value_parser};
use serde_json::Value;

use super::record::{Made, RecordArgs, Source};
use super::{Common, Trouble, Verdict, complain, interrupt, put};
use benchmarks::{Entry, Outcome, REGISTRY, Ready, Session};

/// The sub-command that runs every benchmark.
const ALL: &str = "all";
const RUNS: &str = "runs";

#[derive(Args)]
#[command(subcommand_value_name = "BENCHMARK", subcommand_help_heading = "Benchmarks")]
pub(super) struct BenchArgs {
    #[command(subcommand)]
    chosen: Chosen,
}

/// The benchmarks that were asked for, with their arguments.
struct Chosen {
    benchmarks: Vec<(&'static Entry, Ready)>,
    is_all: bool,
    common: Common,
    /// The file of the one benchmark.
    record: RecordArgs,
}

impl Subcommand for Chosen {
    fn augment_subcommands(command: Command) -> Command {
        let single = REGISTRY.iter().map(sub_command);
        command.subcommands(single).subcommand(sub_command_all())
    }

    fn augment_subcommands_for_update(command: Command) -> Command {
        Self::augment_subcommands(command)
    }

    fn has_subcommand(name: &str) -> bool {
        name == ALL || REGISTRY.iter().any(|entry| entry.name == name)
    }
}

impl FromArgMatches for Chosen {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let (name, given) = matches
            .subcommand()
            .ok_or_else(|| clap::Error::new(ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand))?;
        let common = Common::from_arg_matches(given)?;
        let Some(entry) = REGISTRY.iter().find(|entry| entry.name == name) else {
            let record = RecordArgs::default();
            return Ok(Self { benchmarks: all(given)?, is_all: true, common, record });
        };
        if !entry.is_seeded && given.value_source("seed") == Some(ValueSource::CommandLine) {
            let wrong = "unexpected argument '--seed' found";
            return Err(sub_command(entry).error(ErrorKind::UnknownArgument, wrong));
        }
        let record = RecordArgs::from_arg_matches(given)?;
        Ok(Self { benchmarks: vec![(entry, entry.parse(given)?)], is_all: false, common, record })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// The sub-command of one benchmark: its own arguments, those of every verb, and the file of its table.
fn sub_command(entry: &Entry) -> Command {
    let page = format!("The book explains it in docs/src/{}.", entry.page);
    RecordArgs::augment_args(Common::augment_args(entry.command()))
        .about(entry.about)
        .long_about(None)
        .after_help(page)
        .mut_arg("seed", |seed| seed.hide(!entry.is_seeded))
}

fn sub_command_all() -> Command {
    let runs = Arg::new(RUNS)
        .long(RUNS)
        .value_name("N")
        .allow_negative_numbers(true)
        .value_parser(value_parser!(usize))
        .help("Number of missions, or flights, for each row, in the benchmarks that fly many");
    Common::augment_args(Command::new(ALL).arg(runs))
        .about("Every benchmark that this build has but `places` and `stock`, one after the other")
        .long_about(None)
}

/// Every benchmark that this build can run, with its defaults but for the number of runs.
fn all(given: &ArgMatches) -> Result<Vec<(&'static Entry, Ready)>, clap::Error> {
    let runs = given.get_one::<usize>(RUNS).map(usize::to_string);
    let ready = |entry: &'static Entry| {
        let command = sub_command(entry);
        let takes_runs = command.get_arguments().any(|argument| argument.get_id() == RUNS);
        let runs = runs.iter().filter(|_| takes_runs).map(|runs| format!("--{RUNS}={runs}"));
        let line = std::iter::once(entry.name.to_owned()).chain(runs);
        Ok((entry, entry.parse(&command.try_get_matches_from(line)?)?))
    };
    REGISTRY.iter().filter(|entry| entry.is_in_all()).map(ready).collect()
}

/// What the file of a benchmark says of it.
fn source(entry: &Entry) -> Source {
    let Entry { name, about, page, .. } = *entry;
    Source { command: format!("bench {name}"), file: name, about, page }
}

/// Runs what was chosen by this command line.
pub(super) fn run(args: &BenchArgs, line: &[OsString]) -> Result<Verdict, Trouble> {
    let Chosen { benchmarks, is_all, common, record } = &args.chosen;
    interrupt::ends();
    let record = match benchmarks.as_slice() {
        [(entry, _)] => record.open(source(entry))?,
        _ => None,
    };
    let mut folder = common.folder()?;
    let mut outcomes = Vec::new();
    for (entry, bench) in benchmarks {
        let Common { seed, quiet, .. } = *common;
        let outcome = bench(&mut Session::new(entry.name, seed, quiet, folder.as_mut()))?;
        outcomes.push((entry.name, outcome));
    }
    if let Some(folder) = &mut folder {
        for (name, outcome) in &outcomes {
            folder.put_json(&format!("{name}.json"), &outcome.json)?;
        }
    }
    let tables: String = outcomes.iter().map(|(_, outcome)| outcome.table.as_str()).collect();
    // What took an hour to measure is printed and kept, even where one of both cannot be done.
    let recorded = match (&record, outcomes.as_slice()) {
        (Some(record), [(_, outcome)]) => {
            let Outcome { seeds, table, missed, .. } = outcome;
            record.write(line, &Made { seeds: Some(seeds), table, missed })
        }
        _ => Ok(()),
    };
    common.finish(folder, &tables, &summary(&outcomes, *is_all))?;
    recorded?;
    if let Some(record) = record.filter(|_| common.prints_table()) {
        // The files of `--out` come after an empty line of their own.
        let gap = if common.out.is_some() { "" } else { "\n" };
        put(&format!("{gap}wrote {}\n", record.path().display()))?;
    }
    let missed: Vec<_> = outcomes.iter().flat_map(|(_, outcome)| &outcome.missed).collect();
    for what in &missed {
        complain(what);
    }
    Ok(if missed.is_empty() { Verdict::Good } else { Verdict::Failed })
}

/// The value of one benchmark, or of all of them an object with one entry for each.
fn summary(outcomes: &[(&str, Outcome)], is_all: bool) -> Value {
    match outcomes {
        [(_, one)] if !is_all => one.json.clone(),
        many => many.iter().map(|(name, it)| ((*name).to_owned(), it.json.clone())).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(line: &[&str]) -> Result<Chosen, clap::Error> {
        let command = Chosen::augment_subcommands(Command::new("bench"));
        let matches = command.try_get_matches_from([&["bench"], line].concat())?;
        Chosen::from_arg_matches(&matches)
    }

    #[test]
    fn every_benchmark_has_a_sound_sub_command() {
        for entry in REGISTRY {
            sub_command(entry).debug_assert();
        }
    }

    #[test]
    fn all_takes_every_benchmark_but_those_that_need_a_file_of_others() {
        for line in [&["all"] as &[&str], &["all", "--runs", "2", "--seed", "3"]] {
            let all = chosen(line).unwrap_or_else(|wrong| panic!("{wrong}"));
            assert!(all.is_all && all.benchmarks.len() > 9, "{}", all.benchmarks.len());
        }
    }
}
