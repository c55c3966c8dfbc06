//! `uchain figures --paper forces`: the readings of the paper on swarms beside its tables 2 and 3 and what
//! it says of its figures 12 and 14.

use std::fmt::Write;

use benchmarks::forces::figures::{self, Reading, TABLE_2, TABLE_3, cases};
use input::{InputError, counted};
use measure::claim::{Answer, Claim};
use report::Folder;
use report::pictures::{BoxChart, RunGroup, RunValues, SurvivalChart, box_plots, survival};
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
        put_pictures(folder, &readings)?;
    }
    Ok(Figured { table: table(&readings, count, seed), summary, seeds: seeds(seed, count) })
}

/// The readings that are printed in full, with their names in pictures.
fn printed(readings: &[Reading]) -> impl Iterator<Item = (&Reading, &'static str)> {
    PRINTED.into_iter().filter_map(|(name, words)| {
        Some((readings.iter().find(|reading| reading.rule.name == name)?, words))
    })
}

/// Puts the pictures of both tables and both figures, for the readings that are printed in full.
fn put_pictures(folder: &mut Folder, readings: &[Reading]) -> Result<(), Trouble> {
    let drawn: Vec<(&Reading, &str)> = printed(readings).collect();
    report::put_picture(folder, "table-2", &survival(&surveys(&drawn))?)?;
    report::put_picture(folder, "table-3", &box_plots(&links_lost(&drawn))?)?;
    for (reading, words) in drawn {
        for (n, phase, what) in
            [(12, Phase::Setup, "set-up before"), (14, Phase::Crossing, "crossing of")]
        {
            let title = format!("Figure {n} again: {what} passages a to e, by {words}");
            let name = format!("figure-{n}-{}", reading.rule.name);
            report::put_picture(folder, &name, &survival(&durations(reading, title, phase))?)?;
        }
    }
    Ok(())
}

/// Draws table 2, the rounds of surveys, with a chart for each number of drones.
fn surveys(drawn: &[(&Reading, &str)]) -> SurvivalChart {
    let groups = groups(drawn, &TABLE_2, Reading::survey_rounds);
    SurvivalChart {
        title: "Table 2 again: the survey of 1 to 6 drones".into(),
        pending: "whose survey has not ended yet".into(),
        time_name: "Rounds".into(),
        until: SurvivalChart::end_of(&groups),
        groups,
    }
}

/// Draws table 3, the links lost in surveys that end.
fn links_lost(drawn: &[(&Reading, &str)]) -> BoxChart {
    BoxChart {
        title: "Table 3 again: links lost in a survey that ends".into(),
        value_name: "Links lost".into(),
        infinite_name: "stuck".into(),
        is_logarithmic: false,
        groups: groups(drawn, &TABLE_3, Reading::survey_links_lost),
    }
}

/// A group for each number of drones up to the paper's most of which the paper gives a mean, with a series
/// for each reading.
fn groups(
    drawn: &[(&Reading, &str)],
    told: &[f32],
    of: fn(&Reading, u16) -> Vec<f32>,
) -> Vec<RunGroup> {
    let first = PAPER_MOST + 1 - told.len() as u16;
    let series = |drones| {
        let values = |(it, _): &(&Reading, _)| RunValues {
            name: it.rule.name.into(),
            values: of(it, drones),
        };
        drawn.iter().map(values).collect()
    };
    let group = |(drones, told): (u16, &f32)| RunGroup {
        label: counted(usize::from(drones), "drone"),
        series: series(drones),
        told: Some(*told),
    };
    (first..).zip(told).map(group).collect()
}

/// Draws figure 12 or 14, the durations of a phase, with a chart for each passage.
fn durations(reading: &Reading, title: String, phase: Phase) -> SurvivalChart {
    let of = |place, drones| RunValues {
        name: counted(usize::from(drones), "drone"),
        values: reading.leg_ratios(phase, place, drones),
    };
    let group = |place: Place| RunGroup {
        label: format!("Passage {}", place.name()),
        series: (1..=PAPER_MOST).map(|drones| of(place, drones)).collect(),
        told: None,
    };
    let groups: Vec<RunGroup> = Place::ALL.into_iter().map(group).collect();
    SurvivalChart {
        title,
        pending: "that have not come to the end of it yet".into(),
        time_name: "Duration in ideal durations".into(),
        until: SurvivalChart::end_of(&groups),
        groups,
    }
}

fn refused(error: TooMany) -> InputError {
    InputError::new(error.to_string(), "choose a size of swarm in that range")
}

fn table(readings: &[Reading], count: usize, seed: u64) -> String {
    let mut text = format!(
        "Swarms by virtual forces: {count} flights a row, seeds from {seed}\n\n  table 2, mean rounds of \
         the surveys that end; table 3, mean number of links lost\n\n{}{}",
        heading("drones", 17, (1, 5), (2, 5)),
        line("paper", &TABLE_2, &TABLE_3),
    );
    for reading in readings {
        text.push_str(&tables(reading));
    }
    text.push_str(
        "\n  figure 12, set-up, and figure 14, crossing: means in ideal durations of the flights that end\n",
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

/// The numbers of drones above two blocks of columns: of each block the first number, and how wide a column is.
fn heading(name: &str, wide: usize, left: (u16, usize), right: (u16, usize)) -> String {
    let block = |(first, wide): (u16, usize)| {
        (first..=PAPER_MOST).map(|drones| format!(" {drones:>wide$}")).collect::<String>()
    };
    format!("  {name:wide$}{}  |{}\n", block(left), block(right))
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
    let name = reading.rule.name;
    let mut text = format!("\n  by {name}\n{}", heading("drones", 6, (1, 6), (1, 6)));
    for place in Place::ALL {
        // Writing to a string cannot fail.
        let _ = write!(text, "  {:6}", place.name());
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
