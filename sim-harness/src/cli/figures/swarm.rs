//! `uchain figures --paper forces`: the readings of the paper on swarms beside its tables 2 and 3 and what
//! it says of its figures 12 and 14.

use std::fmt::Write;

use benchmarks::forces::figures::{self, Reading, TABLE_2, TABLE_3, cases};
use input::{InputError, counted};
use measure::claim::{Answer, Claim};
use report::Folder;
use report::pictures::{BoxChart, RunGroup, RunValues, box_plots};
use serde_json::{Value, json};
use swarms::bench::PAPER_MOST;
use swarms::{Phase, Place, TooMany};
use terminal::Progress;

use super::super::Trouble;
use super::{Figured, FiguresArgs, put_claims, seeds};

/// The file that holds the rows of all readings.
const FILE: &str = "swarm.json";
/// The readings whose claims are printed in full and which the pictures show, with their names there.
const PRINTED: [(&str, &str); 2] =
    [("literal", "the paper's rule to the letter"), ("ours", "our rule")];

/// The claims of all readings with so many flights from a seed on.
pub(super) fn claims(count: usize, seed: u64) -> Result<Vec<(&'static str, Claim)>, InputError> {
    let readings = figures::make(count, seed, || ()).map_err(refused)?;
    let of = |reading: &Reading| {
        let name = reading.rule.name;
        reading.claims().into_iter().map(move |claim| (name, claim))
    };
    Ok(readings.iter().flat_map(of).collect())
}

pub(super) fn make(
    args: &FiguresArgs,
    count: usize,
    folder: &mut Option<Folder>,
) -> Result<Figured, Trouble> {
    let seed = args.common.seed;
    let progress = Progress::new(cases() as u64, args.common.quiet);
    progress.say("cases");
    let readings = figures::make(count, seed, || progress.step()).map_err(refused)?;
    drop(progress);
    let values: Vec<Value> = readings.iter().map(Reading::json).collect();
    let summary = json!({
        "runs": count,
        "seed": seed,
        "paper": { "table_2_rounds": TABLE_2, "table_3_links_lost": TABLE_3 },
        "readings": values,
    });
    if let Some(folder) = folder {
        folder.put_json(FILE, &summary)?;
        for (name, chart) in charts(&readings) {
            report::put_picture(folder, &name, &box_plots(&chart)?)?;
        }
    }
    Ok(Figured { table: table(&readings, count, seed), summary, seeds: seeds(seed, count) })
}

/// The readings that are printed in full, with their names in pictures.
fn printed(readings: &[Reading]) -> impl Iterator<Item = (&Reading, &'static str)> {
    PRINTED.into_iter().filter_map(|(name, words)| {
        Some((readings.iter().find(|reading| reading.rule.name == name)?, words))
    })
}

/// The pictures of both tables and both figures, by name, for the readings that are printed in full.
fn charts(readings: &[Reading]) -> Vec<(String, BoxChart)> {
    let drawn: Vec<(&Reading, &str)> = printed(readings).collect();
    let table =
        |n: u8, title: &str, value_name: &str, told: &[f32], of: fn(&Reading, u16) -> Vec<f32>| {
            let values = |it: &Reading, drones| RunValues {
                name: it.rule.name.into(),
                values: of(it, drones),
            };
            let series = |drones| drawn.iter().map(|(it, _)| values(it, drones)).collect();
            (format!("table-{n}"), chart(title, value_name, told, series))
        };
    let mut charts = vec![
        table(2, "Table 2 again: rounds of a survey", "Rounds", &TABLE_2, Reading::survey_rounds),
        table(
            3,
            "Table 3 again: links lost in a survey",
            "Links lost",
            &TABLE_3,
            Reading::survey_links_lost,
        ),
    ];
    for (n, phase, what) in
        [(12, Phase::Setup, "set-up before"), (14, Phase::Crossing, "crossing of")]
    {
        for (reading, words) in &drawn {
            let name = reading.rule.name;
            let title = format!("Figure {n} again: {what} passages a to e, by {words}");
            let values = |place, drones| reading.leg_ratios(phase, place, drones);
            let of = |place: Place, drones| RunValues {
                name: place.name().into(),
                values: values(place, drones),
            };
            let series = |drones| Place::ALL.map(|place| of(place, drones)).into();
            let value_name = "Duration in ideal durations";
            charts.push((format!("figure-{n}-{name}"), chart(&title, value_name, &[], series)));
        }
    }
    charts
}

/// A group for each number of drones up to the paper's most, of which the last have a mean in the paper. Without
/// means all numbers of drones are shown.
fn chart(
    title: &str,
    value_name: &str,
    told: &[f32],
    series: impl Fn(u16) -> Vec<RunValues>,
) -> BoxChart {
    let first = if told.is_empty() { 1 } else { PAPER_MOST + 1 - told.len() as u16 };
    let group = |drones: u16| RunGroup {
        label: counted(usize::from(drones), "drone"),
        series: series(drones),
        told: told.get(usize::from(drones - first)).copied(),
    };
    BoxChart {
        title: title.into(),
        value_name: value_name.into(),
        infinite_name: "stuck".into(),
        is_logarithmic: false,
        groups: (first..=PAPER_MOST).map(group).collect(),
    }
}

fn refused(error: TooMany) -> InputError {
    InputError::new(error.to_string(), "choose a size of swarm in that range")
}

fn table(readings: &[Reading], count: usize, seed: u64) -> String {
    let mut text = format!(
        "Swarms by virtual forces: {count} flights a row, seeds from {seed}\n\n  table 2, mean rounds of a \
         survey with 1 to 6 drones; table 3, mean links lost with 2 to 6\n\n{}",
        line("paper", &TABLE_2, &TABLE_3),
    );
    for reading in readings {
        text.push_str(&tables(reading));
    }
    text.push_str(
        "\n  figure 12, set-up, and figure 14, crossing: means in ideal durations, 1 to 6 drones\n",
    );
    for reading in readings {
        text.push_str(&trends(reading));
    }
    text.push_str(&verdicts(readings));
    for (reading, _) in printed(readings) {
        let _ = write!(text, "\nBy {}:", reading.rule.name);
        put_claims(&mut text, ("paper's", ""), &reading.claims());
    }
    text
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
fn tables(reading: &Reading) -> String {
    let surveys = || (1..=PAPER_MOST).filter_map(|drones| reading.survey(drones));
    let rounds: Vec<f32> = surveys().map(|row| row.steps.unwrap_or(f32::NAN)).collect();
    let lost: Vec<f32> = surveys().skip(1).map(|row| row.links_lost).collect();
    let mut text = line(reading.rule.name, &rounds, &lost);
    let stuck: usize = surveys().map(|row| row.stuck).sum();
    if stuck > 0 {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {:17} {stuck} surveys got stuck", "");
    }
    text
}

/// A block for each reading: the ratios of both figures.
fn trends(reading: &Reading) -> String {
    let mut text = format!("\n  {}\n", reading.rule.name);
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
    text
}

/// A line for each claim, with the verdict on each reading.
fn verdicts(readings: &[Reading]) -> String {
    let mut text = "\nThe paper's claims: + holds, − does not hold, ? cannot be told from so many \
                    flights. The columns are the readings in the order above\n\n"
        .to_owned();
    let all: Vec<Vec<Claim>> = readings.iter().map(Reading::claims).collect();
    for (n, first) in all.first().into_iter().flatten().enumerate() {
        text.push(' ');
        for claim in all.iter().filter_map(|claims| claims.get(n)) {
            text.push_str(match claim.answer() {
                Answer::Holds => " +",
                Answer::DoesNotHold => " −",
                Answer::CannotBeTold => " ?",
            });
        }
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {}: {}", first.source, first.claim);
    }
    text
}
