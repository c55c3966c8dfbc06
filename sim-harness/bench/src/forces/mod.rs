//! `uchain bench forces`: the table of swarms by virtual forces.

pub mod figures;
pub mod measure;

use std::fmt::Write;

use clap::Args;
use input::InputError;
use serde_json::Value;
use swarms::bench::{CLEAR, CONNECTED_IN_E, CROSSING, Row, SURVEY, cases, missed};
use swarms::{Phase, TooMany};

use self::measure::Speed;
use super::{Benchmark, Outcome, Session};
use terminal::runs;

/// The arguments of the benchmark.
#[derive(Args)]
pub(crate) struct ForcesBench {
    /// Number of flights for each row with up to six drones; a tenth of them with more
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 100)]
    runs: usize,
}

impl Benchmark for ForcesBench {
    const NAME: &'static str = "forces";
    const ABOUT: &'static str =
        "Whether swarms by virtual forces keep clear and connected, and how fast they are";
    const PAGE: &'static str = "swarms.md";

    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError> {
        let count = runs(self.runs)?;
        let cases = cases();
        let progress = session.progress(cases.len(), "cases");
        let rows =
            measure::fly(&cases, count, session.seed, || progress.step()).map_err(refused)?;
        drop(progress);
        let progress = session.busy();
        let speeds = measure::speeds().map_err(refused)?;
        drop(progress);
        let mut missed = missed(&rows);
        missed.extend(speeds.iter().filter_map(Speed::missed));
        let mut json: Vec<Value> = rows.iter().map(|row| measure::json(row, &rows)).collect();
        json.extend(speeds.iter().map(Speed::json));
        let table = table(count, session.seed, &rows, &speeds);
        let seeds = super::seeds(session.seed, count);
        Ok(Outcome { table, json: Value::Array(json), missed, seeds })
    }
}

fn table(count: usize, seed: u64, rows: &[Row], speeds: &[Speed]) -> String {
    let mut table = format!(
        "forces: {count} flights a row, a tenth with more than six drones, seeds from {seed}\n  \
         bounds on ours: drones at least {CLEAR} safety distances apart, always connected in a to \
         d and {CONNECTED_IN_E} in e,\n  six drones cross in {CROSSING} of the paper's rounds, \
         surveys in {} of them, that of five drones in {}\n",
        SURVEY.0, SURVEY.1,
    );
    for phase in Phase::ALL {
        table.push_str(&block(phase, rows));
    }
    table.push('\n');
    for speed in speeds {
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:>12.0} drone-rounds/s of a survey with {:2} drones by {:5} on one core; bound {:.0}",
            speed.drone_rounds_per_s, speed.drones, speed.rule, speed.bound
        );
    }
    table
}

fn refused(error: TooMany) -> InputError {
    InputError::new(error.to_string(), "choose a size of swarm in that range")
}

fn block(phase: Phase, rows: &[Row]) -> String {
    let mut text = format!(
        "\n  {:8} {:>5} {:>6} {:>6} {:>8} {:>8} {:>6} {:>7} {:>6} {:>10} {:>9} {:>6}\n",
        phase.name(),
        "place",
        "drones",
        "rule",
        "rounds",
        "of ideal",
        "of p.",
        "drones",
        "walls",
        "links lost",
        "connected",
        "stuck",
    );
    for row in rows.iter().filter(|row| row.phase == phase) {
        let place = if phase == Phase::Survey { "area" } else { row.place.name() };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  {:8} {place:>5} {:>6} {:>6} {:>8} {:>8} {:>6} {:>7} {:>6} {:>10.2} {:>9.3} {:>6}",
            "",
            row.drones,
            row.rule,
            told(row.steps, 0),
            told(row.ratio_to_ideal, 2),
            told(row.over_paper(rows), 2),
            told(row.min_drone_drone_dsafe, 2),
            told(row.min_drone_wall_dsafe, 2),
            row.links_lost,
            row.connected,
            row.stuck,
        );
    }
    text
}

fn told(value: Option<f32>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
}
