//! `uchain bench chain --drawn`: the chain in places that each seed draws.

use std::fmt::Write;

use serde_json::{Value, json};

use super::super::progress::Progress;
use super::super::{FidelityArg, Trouble, counted};
use super::BenchArgs;
use crate::input_error::InputError;
use crate::measure::bench::chain::cases::Bound;
use crate::measure::bench::drawn::flown::QUICK;
use crate::measure::bench::drawn::totals::Total;
use crate::measure::bench::drawn::{Choice, Flown, Row, Totals, run};
use crate::output::Folder;
use crate::scenario::Fidelity;

/// Seeds of a cause that are told.
const SHOWN: usize = 12;

pub(super) fn bench(
    args: &BenchArgs,
    places: usize,
    folder: Option<&mut Folder>,
) -> Result<(String, Value), Trouble> {
    let fidelity = args.fidelity.map_or(Ok(Fidelity::Point), FidelityArg::fidelity)?;
    if fidelity == Fidelity::Virtual {
        let wrong = "drawn places have no virtual drones".to_owned();
        return Err(InputError::new(wrong, "give --fidelity point or flight").into());
    }
    let policies =
        if args.policy.is_empty() { vec!["chain".to_owned()] } else { args.policy.clone() };
    let choice =
        Choice { places: counted("--drawn", places)?, seed: args.common.seed, fidelity, policies };
    let progress = Progress::new((choice.places * choice.policies.len()) as u64, args.common.quiet);
    progress.say("missions");
    let rows = run(&choice, || progress.step())?;
    drop(progress);
    if let Some(folder) = folder {
        let fails = |row: &&Row| args.each || row.flown.iter().any(|flown| !flown.wrong.is_empty());
        for row in rows.iter().filter(fails) {
            folder.put_text(&format!("drawn-{}.toml", row.seed), &row.text)?;
        }
    }
    let totals: Vec<_> = choice
        .policies
        .iter()
        .enumerate()
        .map(|(n, policy)| {
            let flown: Vec<_> = rows.iter().filter_map(|row| row.flown.get(n)).collect();
            Totals::of(policy, &flown)
        })
        .collect();
    let mut text = heading(&choice);
    if args.each {
        put_each(&mut text, &rows);
    }
    put_totals(&mut text, &totals);
    let flown = rows.iter().flat_map(|row| &row.flown).map(Flown::json);
    let value = json!({
        "places": choice.places,
        "seed": choice.seed,
        "fidelity": fidelity.name(),
        "totals": totals.iter().map(Totals::json).collect::<Vec<_>>(),
        "missions": flown.collect::<Vec<_>>(),
    });
    Ok((text, value))
}

fn heading(choice: &Choice) -> String {
    let last = choice.seed.wrapping_add(choice.places as u64).wrapping_sub(1);
    format!(
        "chain: {} drawn places, level {}, seeds {} to {last}; ! marks a figure that misses its \
         bound\n",
        choice.places,
        choice.fidelity.name(),
        choice.seed,
    )
}

/// One line for each mission.
fn put_each(text: &mut String, rows: &[Row]) {
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "\n  {:>8} {:8} {:>6} {:>8} {:>8} {:>7} {:>7} {:>7} {:>6} {:>5}  wrong",
        "seed",
        "policy",
        "relays",
        "oracle_m",
        "depth_m",
        "t95/s",
        "bound/s",
        "stood",
        "weak",
        "home"
    );
    for flown in rows.iter().flat_map(|row| &row.flown) {
        let wrong: Vec<_> =
            flown.wrong.iter().map(|(at, what)| format!("{} at {at:.0} s", what.name())).collect();
        let left: Vec<_> = flown
            .left
            .iter()
            .map(|left| format!("{} at {:.1} m {}", left.drone, left.way_m, left.why))
            .collect();
        let home = if flown.is_home() { "yes" } else { "no" };
        let _ = writeln!(
            text,
            "  {:>8} {:8} {:>6} {:>8.1} {:>8.1} {:>7.0} {:>7.0} {:>7.0} {:>6.2} {home:>5}  {}{}{}",
            flown.seed,
            flown.policy,
            format!("{}/{}", flown.relays[1], flown.relays[0]),
            flown.oracle_m,
            flown.depth_m,
            flown.deep_s,
            QUICK * flown.oracle_s,
            flown.stood_s,
            flown.weak,
            if wrong.is_empty() { "nothing".to_owned() } else { wrong.join(", ") },
            if left.is_empty() { "" } else { "; left: " },
            left.join(", "),
        );
    }
}

fn put_totals(text: &mut String, all: &[Totals]) {
    let Some(first) = all.first() else { return };
    // Writing to a string cannot fail.
    let _ = write!(text, "\n  {:20}", "");
    for totals in all {
        let _ = write!(text, " {:>24} ", totals.policy);
    }
    let _ = writeln!(text, "  bound");
    for (n, figure) in first.figures.iter().enumerate() {
        let _ = write!(text, "  {:20}", figure.name);
        for total in all.iter().filter_map(|totals| totals.figures.get(n)) {
            let mark = if total.misses() { '!' } else { ' ' };
            let _ = write!(text, " {:>24}{mark}", told(total));
        }
        let bound = figure.bound.map_or_else(String::new, |bound| match bound {
            Bound::Most(most) => format!("<= {most}"),
            Bound::Least(least) => format!(">= {least}"),
        });
        let _ = writeln!(text, "  {bound}");
    }
    for totals in all {
        let _ =
            writeln!(text, "\n  {}: what went wrong first (and at all), with seeds", totals.policy);
        for first in &totals.causes {
            let seeds: Vec<_> = first.seeds.iter().take(SHOWN).map(u64::to_string).collect();
            let more = if first.seeds.len() > SHOWN { " …" } else { "" };
            let _ = writeln!(
                text,
                "    {:18} {:>5} ({:>5})  {}{more}",
                first.cause.name(),
                first.seeds.len(),
                first.at_all,
                seeds.join(" ")
            );
        }
    }
}

fn told(total: &Total) -> String {
    match total.estimate.interval {
        Some((low, high)) => format!("{:.4} [{low:.3}, {high:.3}]", total.estimate.value),
        None => format!("{:.4}", total.estimate.value),
    }
}
