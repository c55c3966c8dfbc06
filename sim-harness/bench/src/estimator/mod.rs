//! `uchain bench estimator`: whether the errors of the state estimator are as large as it claims.

pub mod measure;

use std::fmt::Write;

use clap::Args;
use input::InputError;

use self::measure::Report;
use super::{Benchmark, Outcome, Session};
use terminal::runs;

/// The arguments of the benchmark.
#[derive(Args)]
pub(crate) struct EstimatorBench {
    /// Number of flights
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 1_000)]
    runs: usize,
}

impl Benchmark for EstimatorBench {
    const NAME: &'static str = "estimator";
    const ABOUT: &'static str =
        "Whether the errors of the state estimator are as large as it claims";
    const PAGE: &'static str = "benchmarks.md";

    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError> {
        let count = runs(self.runs)?;
        let progress = session.progress(count, "flights");
        let report = measure::run(count, session.seed, || progress.step());
        drop(progress);
        let seeds = super::seeds(session.seed, count);
        Ok(Outcome { table: table(&report), json: report.json(), missed: Vec::new(), seeds })
    }
}

fn table(report: &Report) -> String {
    let mut table = format!("estimator: {} flights of 10 s\n\n", report.runs);
    for s in &report.sensors {
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:8} mean NIS {:.3} (of {} {:.3} to {:.3}); {:.1} % of instants within, {:.1} % of \
             readings below the 95 % quantile; {} rejected, {} unusable of {}",
            s.sensor,
            s.mean_nis,
            s.degrees,
            s.interval.0,
            s.interval.1,
            100.0 * s.instants_within,
            100.0 * s.below_95,
            s.rejected,
            s.unusable,
            s.readings + s.unusable,
        );
    }
    let _ = writeln!(
        table,
        "  errors   velocity {:.4} m/s, height {:.4} m, tilt {:.3}°",
        report.velocity_mps, report.height_m, report.tilt_deg
    );
    table
}
