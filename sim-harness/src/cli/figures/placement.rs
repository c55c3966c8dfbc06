//! `uchain figures --paper placement`: the situations of the paper's figure 4 in many caves, with what
//! the paper's sentences are worth.

use std::fmt::Write;

use planning::situations::{self, Figures, Situation, Trial};
use report::Folder;
use report::pictures::{BoxChart, RunGroup, RunValues, box_plots, node_maps, node_situations};
use terminal::Progress;

use super::super::Trouble;
use super::{Figured, FiguresArgs, put_claims};

pub(super) fn make(
    args: &FiguresArgs,
    count: usize,
    folder: &mut Option<Folder>,
) -> Result<Figured, Trouble> {
    let seed = args.common.seed;
    let progress = Progress::new((Situation::ALL.len() * count) as u64, args.common.quiet);
    progress.say("caves");
    let figures = situations::make(count, seed, || progress.step());
    drop(progress);
    let summary = figures.json(seed);
    if let Some(folder) = folder {
        folder.put_json("summary.json", &summary)?;
        report::put_picture(folder, "new-area", &box_plots(&chart(&figures))?)?;
        report::put_picture(folder, "figure-4", &node_situations(&figures.scenes)?)?;
        let at_transition =
            figures.scenes.iter().find(|it| it.trial.situation == Situation::Transition);
        if let Some(scene) = at_transition.or(figures.scenes.first()) {
            report::put_picture(folder, "figures-2-and-3", &node_maps(scene)?)?;
        }
    }
    Ok(Figured { table: table(&figures), summary, seeds: format!("from {seed}") })
}

/// The new areas of all trials as box plots.
fn chart(figures: &Figures) -> BoxChart {
    let names = Trial::RULES;
    let group = |situation: Situation| RunGroup {
        label: situation.name().into(),
        series: names
            .iter()
            .enumerate()
            .map(|(n, name)| RunValues {
                name: (*name).into(),
                values: figures.of(situation).map(|trial| area(trial, n)).collect(),
            })
            .collect(),
        told: None,
    };
    BoxChart {
        title: "Figure 4 again: what the new node covers and the network does not".into(),
        value_name: "New area, m\u{b2}".into(),
        infinite_name: "no place".into(),
        is_logarithmic: false,
        groups: Situation::ALL.into_iter().map(group).collect(),
    }
}

/// The new area of a place; infinite where there is no place, which the chart counts.
fn area(trial: &Trial, n: usize) -> f32 {
    trial.places()[n].map_or(f32::INFINITY, |dropped| dropped.gain_m2)
}

fn table(figures: &Figures) -> String {
    let caves = figures.caves;
    let mut text = format!(
        "Placing communication nodes, figure 4: {caves} caves for each situation, the base alone in the \
         network\n\n  {:11} {:8} {:>6} {:>12} {:>6} {:>10} {:>7} {:>11} {:>12}\n",
        "situation",
        "place",
        "places",
        "new area, m²",
        "linked",
        "margin, dB",
        "by wall",
        "1 m free",
        "from goal, m",
    );
    for situation in Situation::ALL {
        for n in 0..Trial::RULES.len() {
            row(&mut text, figures, situation, n);
        }
    }
    let of = " for each situation; a run is one cave";
    put_claims(&mut text, ("paper's", of), &figures.claims());
    text
}

/// One situation with one rule.
fn row(text: &mut String, figures: &Figures, situation: Situation, n: usize) {
    let own: Vec<_> = figures.of(situation).filter_map(|trial| trial.places()[n]).collect();
    let middle = |of: fn(&planning::situations::Dropped) -> f32| {
        let mut values: Vec<f32> = own.iter().map(of).collect();
        values.sort_by(f32::total_cmp);
        values.get(values.len() / 2).map_or_else(|| "–".to_owned(), |value| format!("{value:.1}"))
    };
    let count =
        |of: fn(&planning::situations::Dropped) -> bool| own.iter().filter(|it| of(it)).count();
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "  {:11} {:8} {:>6} {:>12} {:>6} {:>10} {:>7} {:>11} {:>12}",
        situation.name(),
        Trial::RULES[n],
        own.len(),
        middle(|it| it.gain_m2),
        count(|it| it.is_linked()),
        middle(|it| it.margin_db),
        count(|it| it.is_beside_wall),
        count(|it| it.free_width_m >= 1.0),
        middle(|it| it.off_goal_m),
    );
}
