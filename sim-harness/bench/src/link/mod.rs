//! `uchain bench link`: how fast orders and telemetry get through a chain, and how many are lost.

pub mod measure;

use std::fmt::Write;

use clap::Args;
use input::InputError;

use self::measure::{AIM_HOPS, AIM_S, AIMS, Aim, LONGEST, POLLS_PER_S, POLLS_PER_S_LIMITED, Row};
use super::{Benchmark, Outcome, Session};
use terminal::runs;

/// The arguments of the benchmark.
#[derive(Args)]
pub(crate) struct LinkBench {
    /// Number of chains for each row, each of which flies for a minute
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 10)]
    runs: usize,
}

impl Benchmark for LinkBench {
    const NAME: &'static str = "link";
    const ABOUT: &'static str =
        "How fast orders and telemetry get through a chain, and how many are lost";
    const PAGE: &'static str = "link.md";

    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError> {
        let count = runs(self.runs)?;
        let progress = session.progress(measure::count() * count, "chains");
        let rows = measure::run(count, session.seed, || progress.step());
        drop(progress);
        let mut table = table(count, &rows);
        put_aims(&mut table, &rows);
        let json = rows.iter().map(Row::json).collect();
        let seeds = super::seeds(session.seed, count);
        Ok(Outcome { table, json, missed: measure::missed(&rows), seeds })
    }
}

fn table(count: usize, rows: &[Row]) -> String {
    let mut table = format!(
        "link: {count} times 60 s a row; aim: 95 of 100 orders through {AIM_HOPS} hops at 20 % loss \
         within {AIM_S} s\n\n  {:>6} {:>5} {:>7} {:>5} {:>10} {:>10} {:>9} {:>12} {:>7} {:>6}\n",
        "drones",
        "loss",
        "polls/s",
        "fades",
        "offered/s",
        "delivered",
        "pilot, s",
        "telemetry, s",
        "stop, s",
        "air",
    );
    for row in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:>6} {:>5.2} {:>7} {:>5} {:>10.1} {:>10.3} {:>9} {:>12} {:>7} {:>6.3}",
            row.drones,
            row.loss,
            row.polls_per_s,
            if row.fades { "yes" } else { "no" },
            row.offered_per_s,
            row.delivered,
            seconds(row.pilot_delay_p95_s),
            seconds(row.telemetry_delay_p95_s),
            seconds(row.stop_p95_s),
            row.air_time_fraction,
        );
    }
    table
}

fn put_aims(table: &mut String, rows: &[Row]) {
    // Writing to a string cannot fail.
    let _ = writeln!(table, "\n  aims with {LONGEST} drones, 95th percentiles");
    for aim in &AIMS {
        let at = |polls| seconds(aim.measured(rows, polls));
        let (often, seldom) = (at(POLLS_PER_S), at(POLLS_PER_S_LIMITED));
        let Aim { figure, loss, aim_s, .. } = aim;
        let _ = writeln!(
            table,
            "  {figure:12} at {loss:.2} {often:>7} s, and {seldom:>7} s at {POLLS_PER_S_LIMITED} \
             polls a second; aim {aim_s} s",
        );
    }
}

fn seconds(value: Option<f32>) -> String {
    value.map_or_else(|| "never".to_owned(), |value| format!("{value:.3}"))
}
