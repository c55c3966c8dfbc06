//! `uchain bench`: the named benchmarks.

use std::fmt::Write;

use clap::{Args, ValueEnum};
use serde_json::{Value, json};

use super::progress::Progress;
use super::{Common, Trouble, Verdict, runs};
use crate::bench::{chain, throughput};
use crate::output;
use crate::scenario::POLICIES;

#[derive(Args)]
pub(super) struct BenchArgs {
    /// Which
    #[arg(value_enum)]
    name: Option<Name>,
    /// Missions for each row of a benchmark
    #[arg(long, value_name = "N")]
    runs: Option<usize>,
    #[command(flatten)]
    common: Common,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Name {
    /// How well and how fast each movement policy makes links equal
    Chain,
    /// Drone-rounds per second on one core and on all
    Throughput,
}

impl Name {
    const fn file(self) -> &'static str {
        match self {
            Self::Chain => "chain.json",
            Self::Throughput => "throughput.json",
        }
    }
}

pub(super) fn run(args: &BenchArgs) -> Result<Verdict, Trouble> {
    let names = args.name.map_or_else(|| Name::value_variants().to_vec(), |name| vec![name]);
    let mut values = Vec::new();
    let mut tables = String::new();
    for name in &names {
        let (table, value) = match name {
            Name::Chain => chain_bench(args)?,
            Name::Throughput => throughput_bench(args)?,
        };
        tables.push_str(&table);
        values.push(value);
    }
    let summary = match values.as_slice() {
        [one] => one.clone(),
        // Without a name: an object with one entry for each benchmark.
        many => names
            .iter()
            .zip(many)
            .map(|(name, value)| (name.file().trim_end_matches(".json").to_owned(), value.clone()))
            .collect(),
    };
    args.common.print(&tables, &summary);
    if let Some(dir) = &args.common.out {
        let written = names.iter().zip(&values);
        let written: Result<Vec<_>, _> =
            written.map(|(name, value)| output::put_json(dir, name.file(), value)).collect();
        args.common.wrote(&written?);
    }
    Ok(Verdict::Good)
}

fn chain_bench(args: &BenchArgs) -> Result<(String, Value), Trouble> {
    let count = runs(args.runs.unwrap_or(100))?;
    let total = chain::SCENARIOS.len() * POLICIES.len() * count;
    let progress = Progress::new(total as u64, args.common.quiet);
    progress.say("missions");
    let rows = chain::run(count, args.common.seed, || progress.step())?;
    drop(progress);
    let mut table = format!(
        "chain: {count} missions a row; bound_s: the way to the best chain at full speed\n\n"
    );
    let mut heading = format!("  {:16} {:8}", "scenario", "policy");
    for name in chain::FIGURES {
        // Writing to a string cannot fail.
        let _ = write!(heading, " {name:>13}");
    }
    let _ = writeln!(table, "{heading}");
    for row in &rows {
        let _ = write!(table, "  {:16} {:8}", row.scenario, row.policy);
        for (_, value) in &row.figures {
            let _ = match value {
                Some(value) => write!(table, " {value:>13.3}"),
                None => write!(table, " {:>13}", "never"),
            };
        }
        table.push('\n');
    }
    Ok((table, rows.iter().map(chain::Row::json).collect()))
}

fn throughput_bench(args: &BenchArgs) -> Result<(String, Value), Trouble> {
    let rows = throughput::run(runs(args.runs.unwrap_or(200))?)?;
    let mut table = format!(
        "throughput: {}, aim {:.0} drone-rounds/s on one core\n\n",
        throughput::SCENARIO,
        throughput::AIM
    );
    for row in &rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {} threads {:>12.0} drone-rounds/s, {:.2} of linear",
            row.threads, row.drone_rounds_per_s, row.scaling
        );
    }
    let value = rows
        .iter()
        .map(|row| {
            json!({
                "scenario": throughput::SCENARIO,
                "fidelity": "policy",
                "threads": row.threads,
                "drone_rounds_per_s": row.drone_rounds_per_s.round(),
                "scaling": row.scaling,
                "aim_one_core": throughput::AIM,
            })
        })
        .collect();
    Ok((table, value))
}
