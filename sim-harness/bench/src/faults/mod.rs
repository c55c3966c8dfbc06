//! `uchain bench faults`: what a simulated drone does when a sensor, a motor or the battery fails.

pub mod measure;

use std::fmt::Write;

use clap::Args;
use input::InputError;

use self::measure::{Case, Row, SAFE_IMPACT};
use super::{Benchmark, Outcome, Session};
use terminal::runs;

/// The arguments of the benchmark.
#[derive(Args)]
pub(crate) struct FaultsBench {
    /// Number of flights for each row
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 100)]
    runs: usize,
    /// Run only the faults that have this text in their names
    #[arg(long, value_name = "TEXT", default_value = "")]
    only: String,
}

impl Benchmark for FaultsBench {
    const NAME: &'static str = "faults";
    const ABOUT: &'static str =
        "What a simulated drone does when a sensor, a motor or the battery fails";
    const PAGE: &'static str = "faults.md";

    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError> {
        let count = runs(self.runs)?;
        let wanted = |case: &Case| case.name.contains(&self.only);
        let total = measure::cases().iter().filter(|case| wanted(case)).count() * count;
        if total == 0 {
            let wrong = format!("no fault has \"{}\" in its name", self.only);
            let remedy = "leave --only out to see all their names";
            return Err(InputError::new(wrong, remedy));
        }
        let progress = session.progress(total, "flights");
        let rows = measure::run(count, session.seed, wanted, || progress.step())?;
        drop(progress);
        let json = rows.iter().map(Row::json).collect();
        let seeds = super::seeds(session.seed, count);
        Ok(Outcome { table: table(count, &rows), json, missed: Vec::new(), seeds })
    }
}

fn table(count: usize, rows: &[Row]) -> String {
    let mut table = format!(
        "faults: {count} flights a row; a safe landing is slower than {SAFE_IMPACT} m/s\n\n  {:6} \
         {:30} {:>8} {:>6} {:>12} {:>6} {:>6} {:>6}  causes\n",
        "place", "fault", "survived", "landed", "uncontrolled", "walls", "m/s", "tilt",
    );
    for row in rows {
        let causes: Vec<_> =
            row.causes.iter().map(|(name, count)| format!("{count} {name}")).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:6} {:30} {:>8} {:>6} {:>12} {:>6} {:>6.2} {:>6.0}  {}",
            row.place.name(),
            row.fault,
            row.survived,
            row.landed_safely,
            row.uncontrolled,
            row.wall_contacts,
            row.max_impact_mps,
            row.max_tilt_deg,
            causes.join(", ")
        );
    }
    table
}
