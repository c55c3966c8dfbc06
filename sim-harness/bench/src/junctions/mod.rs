//! `uchain bench junctions`: whether every relay takes the branch that the pilot chose, and a misled
//! one comes back.

pub mod measure;

use std::fmt::Write;

use clap::Args;
use input::InputError;

use self::measure::{BOUND, Row};
use super::{Benchmark, Outcome, Session};
use scenario::Fidelity;
use terminal::{FidelityArg, runs};

/// The arguments of the benchmark.
#[derive(Args)]
pub(crate) struct JunctionsBench {
    /// Number of missions for each row; where left out, 100 of points and 20 of rigid bodies
    #[arg(long, allow_negative_numbers = true, value_name = "N")]
    runs: Option<usize>,
    /// Run only this scenario; may be given more than once
    #[arg(long, value_name = "NAME")]
    scenario: Vec<String>,
    /// How the drones are simulated, as points or as rigid bodies; where left out, as both
    #[arg(long, value_enum)]
    fidelity: Option<FidelityArg>,
}

impl JunctionsBench {
    /// The missions of a row.
    fn seeds(&self, level: Fidelity) -> Result<usize, InputError> {
        runs(self.runs.unwrap_or(if level == Fidelity::Point { 100 } else { 20 }))
    }
}

impl Benchmark for JunctionsBench {
    const NAME: &'static str = "junctions";
    const ABOUT: &'static str =
        "Whether every relay takes the branch that the pilot chose, and a misled one comes back";
    const PAGE: &'static str = "benchmarks.md";

    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError> {
        let levels = match self.fidelity {
            Some(fidelity) => vec![fidelity.of_the_host()?],
            None => vec![Fidelity::Point, Fidelity::Flight],
        };
        let cases = measure::cases_of(&self.scenario)?;
        let mut count = 0;
        for level in &levels {
            count += self.seeds(*level)? * cases.len();
        }
        let progress = session.progress(count, "missions");
        let (mut rows, mut seeds) = (Vec::new(), Vec::new());
        for level in levels {
            let step = || progress.step();
            let count = self.seeds(level)?;
            rows.extend(measure::run(&cases, level, count, session.seed, step)?);
            seeds.push(format!("{} at {} level", super::seeds(session.seed, count), level.name()));
        }
        drop(progress);
        let json = rows.iter().map(Row::json).collect();
        let missed = rows.iter().filter_map(Row::missed).collect();
        Ok(Outcome { table: table(&rows), json, missed, seeds: seeds.join(", ") })
    }
}

fn table(rows: &[Row]) -> String {
    let mut table = format!(
        "junctions: at least {BOUND} of all missions right\n\n  {:14} {:8} {:>5} {:>5} {:>7} {:>6} \
         {:>8} {:>8}  wrong\n",
        "scenario", "fidelity", "seeds", "right", "arrived", "misled", "returned", "troubled",
    );
    for row in rows {
        let wrong: Vec<_> = row.wrong.iter().map(u64::to_string).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:14} {:8} {:>5} {:>5} {:>7} {:>6} {:>8} {:>8}  {}",
            row.scenario,
            row.fidelity.name(),
            row.seeds,
            row.right,
            row.arrived,
            row.misled,
            row.misled_returned,
            row.troubled.len(),
            wrong.join(" ")
        );
    }
    table
}
