//! `uchain bench chain`: the table of how the chain holds.

use std::fmt::Write;

use serde_json::Value;

use super::super::emulated::{Base, Fleet};
use super::super::progress::Progress;
use super::super::{FidelityArg, Trouble, VirtualArgs, runs};
use super::BenchArgs;
use crate::measure::bench::chain::cases::Bound;
use crate::measure::bench::chain::{
    Choice, MakeDrones, Row, count, count_ablation, run, run_ablation,
};
use crate::mission::medium::RadioPreset;
use crate::scenario::{Fidelity, Scenario};

/// Missions of a row where the command line does not say.
const fn default_runs(fidelity: Fidelity) -> usize {
    match fidelity {
        Fidelity::Point => 40,
        Fidelity::Flight => 30,
        Fidelity::Virtual => 3,
    }
}

pub(super) fn bench(args: &BenchArgs) -> Result<(String, Value), Trouble> {
    let fidelity = args.fidelity.map_or(Ok(Fidelity::Point), FidelityArg::fidelity)?;
    let choice = Choice {
        fidelity,
        scenarios: args.scenario.clone(),
        policies: args.policy.clone(),
        runs: runs(args.runs.unwrap_or(default_runs(fidelity)))?,
        seed: args.common.seed,
        radio: args.radio.as_deref().and_then(RadioPreset::named),
    };
    let total = if args.ablation { count_ablation(&choice)? } else { count(&choice)? };
    let progress = Progress::new(total as u64, args.common.quiet);
    progress.say("missions");
    let step = || progress.step();
    let make = |scenario: &Scenario, seed| {
        let drones = VirtualArgs { elf: Some(args.elf.clone()), virtual_drones: Vec::new() };
        Fleet::of(&drones, None, false, scenario, Base::OnHost)?.drones(scenario, seed)
    };
    let make: Option<&MakeDrones<'_>> = (fidelity == Fidelity::Virtual).then_some(&make);
    let rows = if args.ablation { run_ablation(&choice, step)? } else { run(&choice, make, step)? };
    drop(progress);
    let what = if args.ablation { "without" } else { "policy" };
    Ok((table(&choice, what, &rows), rows.iter().map(Row::json).collect()))
}

/// One block for each scenario: its figures, their bounds and targets, and a row for each policy.
fn table(choice: &Choice, what: &str, rows: &[Row]) -> String {
    let last = choice.seed.wrapping_add(choice.runs as u64).wrapping_sub(1);
    let mut text = format!(
        "chain: {} missions a row, level {}, seeds {} to {last}{}; \
         ! marks a figure that misses its target\n",
        choice.runs,
        choice.fidelity.name(),
        choice.seed,
        choice.radio.map_or_else(String::new, |radio| format!(", radio: {}", radio.line))
    );
    for block in rows.chunk_by(|one, next| one.scenario == next.scenario) {
        let Some(first) = block.first() else { continue };
        // Writing to a string cannot fail.
        let _ = write!(text, "\n  {}\n    {what:26}", first.scenario);
        for (name, _) in &first.figures {
            let _ = write!(text, " {:>w$} ", name, w = width(name));
        }
        line(&mut text, "bound", first, |name| bound(first, name));
        if let Some(unknown) = first.unknown {
            let gap =
                |value: f64| move |name: &str| (name == "gap_db").then(|| format!("{value:.2}"));
            line(&mut text, "best in the local mean", first, gap(unknown.local_mean_db));
            line(&mut text, "best by the law alone", first, gap(unknown.law_db));
        }
        line(&mut text, "target", first, |name| first.target(name).map(told));
        for row in block {
            let _ = write!(text, "\n    {:26}", row.policy);
            for (name, value) in &row.figures {
                let mark = if row.misses(name, *value) { '!' } else { ' ' };
                let value = value.map_or_else(|| "never".to_owned(), |value| format!("{value:.3}"));
                let _ = write!(text, " {value:>w$}{mark}", w = width(name));
            }
        }
        text.push('\n');
    }
    text
}

fn line(text: &mut String, heading: &str, row: &Row, of: impl Fn(&str) -> Option<String>) {
    // Writing to a string cannot fail.
    let _ = write!(text, "\n    {heading:26}");
    for (name, _) in &row.figures {
        let cell = of(name).unwrap_or_default();
        let _ = write!(text, " {cell:>w$} ", w = width(name));
    }
}

/// What no policy can beat.
fn bound(row: &Row, figure: &str) -> Option<String> {
    match figure {
        "t3_median_s" | "t_gap1_median_s" => row.bound_s.map(|bound| format!("{bound:.1}")),
        "t_gap1_over_bound" => Some("1".to_owned()),
        "gap_db" | "cruise_gap_db" => Some("0".to_owned()),
        _ => None,
    }
}

fn told(bound: Bound) -> String {
    match bound {
        Bound::Most(most) => format!("<= {most}"),
        Bound::Least(least) => format!(">= {least}"),
    }
}

fn width(name: &str) -> usize {
    name.len().max(7)
}
