//! `uchain bench attacks`: which packets of an attacker without keys a chain accepts.

pub mod measure;
pub mod sieges;

use std::fmt::Write;

use clap::Args;
use input::InputError;
use serde_json::{Value, json};

use super::{Benchmark, Outcome, Session};
use terminal::runs;

/// The arguments of the benchmark.
#[derive(Args)]
pub(crate) struct AttacksBench {
    /// Number of missions for each row
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 10)]
    runs: usize,
}

impl Benchmark for AttacksBench {
    const NAME: &'static str = "attacks";
    const ABOUT: &'static str = "Which packets of an attacker without keys a chain accepts";
    const PAGE: &'static str = "link.md";

    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError> {
        let count = runs(self.runs)?;
        let progress = session.progress((measure::COUNT + sieges::COUNT) * count, "missions");
        let rows = measure::run(count, session.seed, || progress.step())?;
        let besieged = sieges::run(count, session.seed, || progress.step())?;
        drop(progress);
        let mut table = table(count, &rows);
        put_sieges(&mut table, count, &besieged);
        let missed = measure::missed(&rows);
        let rows: Vec<Value> = rows.iter().map(measure::Row::json).collect();
        let besieged: Vec<Value> = besieged.iter().map(sieges::Row::json).collect();
        let json = json!({ "attacks": rows, "sieges": besieged });
        Ok(Outcome { table, json, missed, seeds: super::seeds(session.seed, count) })
    }
}

fn table(count: usize, rows: &[measure::Row]) -> String {
    let mut table = format!(
        "attacks: {}, flight level, {count} missions a row\n\n  {:40} {:>8} {:>8} {:>5} {:>5}  \
         effect\n",
        measure::SCENARIO,
        "attack",
        "packets",
        "accepted",
        "dB",
        "m",
    );
    for row in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:40} {:>8} {:>8} {:>5.1} {:>5.1}  {}",
            row.attack, row.packets, row.accepted, row.link_error_db, row.displaced_m, row.effect
        );
    }
    table
}

fn put_sieges(table: &mut String, count: usize, rows: &[sieges::Row]) {
    // Writing to a string cannot fail.
    let _ = writeln!(
        table,
        "\nsieges: {}, point level, {count} missions a row\n\n  {:76} {:>8} {:>5} {:>12} {:>11} {:>13} \
         {:>6} {:>5} {:>7}",
        sieges::SCENARIO,
        "siege",
        "accepted",
        "dB",
        "m",
        "missed, s",
        "weakest, dBm",
        "holds",
        "home",
        "touches",
    );
    for row in rows {
        let [moved, most] = row.displaced_m;
        let [deaf, deafest] = row.deaf_s;
        let [weak, weakest] = row.weakest_dbm;
        let _ = writeln!(
            table,
            "  {:76} {:>8} {:>5.1} {moved:>5.1} {most:>6.1} {deaf:>5.1} {deafest:>5.1} {weak:>6.1} {weakest:>6.1} \
             {:>6} {:>5} {:>7}",
            row.siege, row.accepted, row.link_error_db, row.holds, row.home, row.touches,
        );
    }
}
