//! `uchain bench forces`: the table of swarms by virtual forces.

use std::fmt::Write;

use serde_json::Value;
use swarms::bench::{CLEAR, CONNECTED_IN_E, CROSSING, Row, SURVEY, cases, missed};
use swarms::{Phase, TooMany};

use super::super::progress::Progress;
use super::super::{Trouble, runs};
use super::BenchArgs;
use crate::input_error::InputError;
use crate::measure::bench::forces::{fly, json, speeds};

/// Flights of a row where the command line does not say.
const RUNS: usize = 100;

/// Bounds that were not met are added to `unmet`.
pub(super) fn bench(args: &BenchArgs, unmet: &mut Vec<String>) -> Result<(String, Value), Trouble> {
    let count = runs(args.runs.unwrap_or(RUNS))?;
    let cases = cases();
    let progress = Progress::new(cases.len() as u64, args.common.quiet);
    progress.say("cases");
    let seed = args.common.seed;
    let rows = fly(&cases, count, seed, || progress.step()).map_err(refused)?;
    drop(progress);
    let speeds = {
        let _progress = Progress::busy("speed", args.common.quiet);
        speeds().map_err(refused)?
    };
    unmet.extend(missed(&rows));
    unmet.extend(speeds.iter().filter_map(|speed| speed.missed()));
    let mut table = format!(
        "forces: {count} flights a row, a tenth with more than six drones, seeds from {seed}\n  \
         bounds on ours: drones at least {CLEAR} safety distances apart, always connected in a to \
         d and {CONNECTED_IN_E} in e,\n  six drones cross in {CROSSING} of the paper's rounds, \
         surveys in {} of them, that of five drones in {}\n",
        SURVEY.0, SURVEY.1,
    );
    for phase in Phase::ALL {
        table.push_str(&block(phase, &rows));
    }
    table.push('\n');
    for speed in &speeds {
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:>12.0} drone-rounds/s of a survey with {:2} drones by {:5} on one core; bound {:.0}",
            speed.drone_rounds_per_s, speed.drones, speed.rule, speed.bound
        );
    }
    let mut value: Vec<Value> = rows.iter().map(|row| json(row, &rows)).collect();
    value.extend(speeds.iter().map(|speed| speed.json()));
    Ok((table, Value::Array(value)))
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
