//! `uchain figures --paper exploration`: what the thesis' figures say of one to three robots, by its rule
//! and by ours.

use std::fmt::Write;

use benchmarks::explore::figures::{self, Figures, ROBOTS, explorations, growth, time_s, way_m};
use explorers::Outcome;
use input::InputError;
use measure::campaign::quantile_of;
use measure::claim::Claim;
use report::Folder;
use report::pictures::{
    BoxChart, Curve, GrowthChart, Growths, RunGroup, RunValues, SurvivalChart, box_plots, growths,
    survival,
};
use terminal::Progress;

use super::super::Trouble;
use super::{Figured, FiguresArgs, put_claims, seeds, watched};

/// The rules that the pictures show, with their names there.
pub(super) const RULES: [(&str, &str); 2] = [("thesis", "The thesis' rule"), ("ours", "Our rule")];

/// The claims with so many runs from a seed on.
pub(super) fn claims(count: usize, seed: u64) -> Result<Vec<Claim>, InputError> {
    Ok(figures::make(count, seed, || ())?.claims())
}

pub(super) fn make(
    args: &FiguresArgs,
    count: usize,
    folder: &mut Option<Folder>,
) -> Result<Figured, Trouble> {
    let seed = args.common.seed;
    let progress = Progress::new(explorations(count) as u64, args.common.quiet);
    progress.say("explorations");
    let figures = figures::make(count, seed, || progress.step())?;
    drop(progress);
    let summary = figures.json(seed);
    if let Some(folder) = folder {
        folder.put_json("summary.json", &summary)?;
        let overlaps = "Thesis, figure 3.18 again: known to several";
        report::put_picture(folder, "figure-3-18", &box_plots(&boxed(&figures, overlaps))?)?;
        for (name, title, time_name, of) in [
            (
                "figure-3-21",
                "Thesis, figure 3.21 again: the way of a robot to 99 %",
                "Way of a robot, m",
                way_m as fn(&Outcome) -> f32,
            ),
            ("figure-3-22", "Thesis, figure 3.22 again: the time to 99 %", "Time, s", time_s),
        ] {
            let chart = curves(&figures, title, time_name, of);
            report::put_picture(folder, name, &survival(&chart)?)?;
        }
        report::put_picture(folder, "figure-3-19", &growths(&grown(&figures))?)?;
        watched::put(folder, &figures)?;
    }
    Ok(Figured { table: table(&figures), summary, seeds: seeds(seed, count) })
}

/// The part of what is known that several robots know, by rule and number of robots.
fn boxed(figures: &Figures, title: &str) -> BoxChart {
    BoxChart {
        title: title.into(),
        value_name: "Part of the known".into(),
        infinite_name: "never".into(),
        is_logarithmic: false,
        // One robot knows nothing together with another.
        groups: groups(figures, 1, |run| run.overlap),
    }
}

/// What a robot needs to know 99 % of the room, of all runs by rule and number of robots: also of those that
/// never know so much.
fn curves(
    figures: &Figures,
    title: &str,
    time_name: &str,
    of: fn(&Outcome) -> f32,
) -> SurvivalChart {
    let groups = groups(figures, 0, of);
    SurvivalChart {
        title: title.into(),
        pending: "that do not know 99 % yet".into(),
        time_name: time_name.into(),
        until: SurvivalChart::end_of(&groups),
        groups,
    }
}

/// A quantity of all runs: a group for each rule, with a series for each number of robots but for the first
/// so many.
fn groups(figures: &Figures, left_out: usize, of: fn(&Outcome) -> f32) -> Vec<RunGroup> {
    let series = |rule: &str| {
        let rows = ROBOTS.iter().skip(left_out).filter_map(|robots| figures.row(rule, *robots));
        rows.map(|row| RunValues {
            name: named(row.robots),
            values: row.runs.iter().map(of).collect(),
        })
        .collect()
    };
    let group = |(rule, label): &(&str, &str)| RunGroup {
        label: (*label).into(),
        series: series(rule),
        told: None,
    };
    RULES.iter().map(group).collect()
}

/// What is known over time.
fn grown(figures: &Figures) -> GrowthChart {
    let curves = |rule: &str| {
        let rows = ROBOTS.iter().filter_map(|robots| figures.row(rule, *robots));
        rows.map(|row| Curve::of(named(row.robots), growth(row))).collect()
    };
    GrowthChart {
        title: "Thesis, figures 3.13 and 3.19 again".into(),
        subtitle: format!("The room of 8 by 8 m, mean of {} runs each", figures.runs),
        value_name: "Part of the room that is known".into(),
        most: 1.03,
        groups: RULES
            .iter()
            .map(|(rule, label)| Growths { label: (*label).into(), curves: curves(rule) })
            .collect(),
    }
}

pub(super) fn named(robots: usize) -> String {
    if robots == 1 { "1 robot".to_owned() } else { format!("{robots} robots") }
}

fn table(figures: &Figures) -> String {
    let mut text = format!(
        "Coordinated exploration, figures 3.11 to 3.24: the thesis' room, {} runs a row; medians, over \
         all runs\n\n  {:16} {:>6} {:>6} {:>7} {:>6} {:>8} {:>8}\n",
        figures.runs, "rule", "robots", "99 %", "time, s", "way, m", "overlap", "early",
    );
    for row in &figures.rows {
        let middle = |of: fn(&Outcome) -> f32| {
            let value = quantile_of(&row.runs, 0.5, of).value;
            if value.is_finite() { format!("{value:.2}") } else { "never".to_owned() }
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  {:16} {:>6} {:>6} {:>7} {:>6} {:>8} {:>8}",
            row.rule,
            row.robots,
            row.count(|run| run.t99_s.is_some()),
            middle(time_s),
            middle(way_m),
            if row.robots > 1 { middle(|run| run.overlap) } else { "–".to_owned() },
            row.count(|run| run.premature_stop),
        );
    }
    put_claims(&mut text, ("thesis'", ""), &figures.claims());
    text
}
