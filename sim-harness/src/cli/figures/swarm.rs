//! `uchain figures --paper forces`: the readings of the paper on swarms beside its tables 2 and 3 and what
//! it says of its figures 12 and 14.

use std::fmt::Write;

use input::InputError;
use serde_json::{Value, json};
use swarms::bench::{PAPER_MOST, Row};
use swarms::figures::{Reading, TABLE_2, TABLE_3, cases, readings};
use swarms::{Phase, Place};

use super::super::{Trouble, Verdict, interrupt};
use super::FiguresArgs;
use benchmarks::forces::measure::{fly, json as row_json};
use terminal::Progress;
use terminal::runs;

/// The file that holds the rows of all readings.
const FILE: &str = "swarm.json";

pub(super) fn run(args: &FiguresArgs) -> Result<Verdict, Trouble> {
    let count = runs(args.runs)?;
    let seed = args.common.seed;
    interrupt::ends();
    let mut folder = args.common.folder()?;
    let cases = cases();
    let progress = Progress::new(cases.len() as u64, args.common.quiet);
    progress.say("cases");
    let rows = fly(&cases, count, seed, || progress.step()).map_err(|error| {
        InputError::new(error.to_string(), "choose a size of swarm in that range")
    })?;
    drop(progress);
    let mut text = format!(
        "Swarms by virtual forces: {count} flights a row, seeds from {seed}\n\n  table 2, rounds of a \
         survey with 1 to 6 drones; table 3, links lost with 2 to 6\n\n{}",
        line("paper", &TABLE_2, &TABLE_3),
    );
    let mut summary = Vec::new();
    for rule in readings() {
        let rows: Vec<Row> = rows.iter().filter(|row| row.rule == rule.name).cloned().collect();
        text.push_str(&tables(rule.name, &Reading(&rows)));
        summary.push(value(rule.name, &rows));
    }
    for rule in readings() {
        let rows: Vec<Row> = rows.iter().filter(|row| row.rule == rule.name).cloned().collect();
        text.push_str(&trends(rule.name, &Reading(&rows)));
    }
    let summary = json!({
        "runs": count,
        "seed": seed,
        "paper": { "table_2_rounds": TABLE_2, "table_3_links_lost": TABLE_3 },
        "readings": summary,
    });
    if let Some(folder) = &mut folder {
        folder.put_json(FILE, &summary)?;
    }
    args.common.finish(folder, &text, &summary)?;
    Ok(Verdict::Good)
}

fn line(name: &str, rounds: &[f32], lost: &[f32]) -> String {
    let mut text = format!("  {name:17}");
    for rounds in rounds {
        // Writing to a string cannot fail.
        let _ = write!(text, " {rounds:>5.0}");
    }
    text.push_str("  |");
    for lost in lost {
        let _ = write!(text, " {lost:>5.2}");
    }
    text.push('\n');
    text
}

/// One line: both tables.
fn tables(name: &str, reading: &Reading<'_>) -> String {
    let surveys = || (1..=PAPER_MOST).filter_map(|drones| reading.survey(drones));
    let rounds: Vec<f32> = surveys().map(|row| row.steps.unwrap_or(f32::NAN)).collect();
    let lost: Vec<f32> = surveys().skip(1).map(|row| row.links_lost).collect();
    let mut text = line(name, &rounds, &lost);
    let stuck: usize = surveys().map(|row| row.stuck).sum();
    if stuck > 0 {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {:17} {stuck} surveys got stuck", "");
    }
    text
}

/// A block for each reading: the ratios of both figures, and the paper's claims.
fn trends(name: &str, reading: &Reading<'_>) -> String {
    let mut text = format!(
        "\n{name}: figure 12, set-up, and figure 14, crossing, both in ideal durations, with 1 to 6 \
         drones\n\n"
    );
    for place in Place::ALL {
        // Writing to a string cannot fail.
        let _ = write!(text, "  {}", place.name());
        for phase in [Phase::Setup, Phase::Crossing] {
            for drones in 1..=PAPER_MOST {
                let ratio = reading.ratio(phase, place, drones);
                let _ = if ratio.is_finite() {
                    write!(text, " {ratio:>6.2}")
                } else {
                    write!(text, " {:>6}", "stuck")
                };
            }
            text.push_str(if phase == Phase::Setup { "  |" } else { "\n" });
        }
    }
    text.push('\n');
    for claim in reading.claims() {
        let verdict = if claim.holds { "holds" } else { "does not hold" };
        let _ =
            writeln!(text, "  {}: {}\n    {verdict}: {}", claim.source, claim.claim, claim.found);
    }
    text
}

fn value(name: &str, rows: &[Row]) -> Value {
    let claims: Vec<Value> = Reading(rows)
        .claims()
        .into_iter()
        .map(|claim| {
            json!({
                "source": claim.source,
                "claim": claim.claim,
                "holds": claim.holds,
                "found": claim.found,
            })
        })
        .collect();
    let rows: Vec<Value> = rows.iter().map(|row| row_json(row, rows)).collect();
    json!({ "reading": name, "claims": claims, "rows": rows })
}
