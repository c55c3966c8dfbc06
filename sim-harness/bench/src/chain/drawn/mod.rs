//! `uchain bench chain --drawn`: the chain in places that each seed draws.
//!
//! | module | holds |
//! |---|---|
//! | `plane` | distances on the plan |
//! | `place` | the galleries, their widths, dead ends, forks and halls |
//! | `radio` | the law, what packets suffer, and the limits |
//! | `pilot` | how the stick is moved |
//! | [`drawing`] | all of it as a scenario's text, beside its oracle |
//! | [`flown`] | one mission, looked at from outside |
//! | [`measure`] | every policy in every place |
//! | [`mod@totals`] | many missions, and the bounds beside them |

pub mod drawing;
pub mod flown;
pub mod measure;
mod pilot;
mod place;
mod plane;
mod radio;
pub mod totals;

use std::fmt::Write;

use input::InputError;
use serde_json::{Value, json};

use self::flown::{Cause, Flown, QUICK};
use self::measure::{Choice, Row};
use self::totals::{Total, Totals};
use super::{ChainBench, Contender};
use crate::{Outcome, Session};
use report::Folder;
use scenario::Fidelity;
use terminal::counted;

/// Seeds of a cause that are told.
const SHOWN: usize = 12;

/// Flies in so many places.
pub(super) fn bench(
    args: &ChainBench,
    places: usize,
    fidelity: Fidelity,
    session: &mut Session<'_>,
) -> Result<Outcome, InputError> {
    if fidelity == Fidelity::Virtual {
        let wrong = "drawn places have no virtual drones".to_owned();
        return Err(InputError::new(wrong, "give --fidelity point or flight"));
    }
    let policies = match args.policy.as_slice() {
        [] => vec![Contender::BuiltIn("chain")],
        names => Contender::all(names)?,
    };
    let choice =
        Choice { places: counted("--drawn", places)?, seed: session.seed, fidelity, policies };
    let progress = session.progress(choice.places * choice.policies.len(), "missions");
    let rows = measure::run(&choice, || {
        progress.step();
        Ok(())
    })?;
    drop(progress);
    if let Some(folder) = &mut session.folder {
        keep(folder, &rows, args.each)?;
    }
    let totals = totals(&choice, &rows);
    let mut table = heading(&choice);
    if args.each {
        put_each(&mut table, &rows);
    }
    put_totals(&mut table, &totals);
    let seeds = crate::seeds(choice.seed, choice.places);
    Ok(Outcome { table, json: json(&choice, &totals, &rows), missed: Vec::new(), seeds })
}

/// Keeps the scenarios in which something went wrong, or all of them.
fn keep(folder: &mut Folder, rows: &[Row], keeps_all: bool) -> Result<(), InputError> {
    let fails = |row: &&Row| keeps_all || row.flown.iter().any(|flown| !flown.wrong.is_empty());
    for row in rows.iter().filter(fails) {
        folder.put_text(&format!("drawn-{}.toml", row.seed), &row.text)?;
    }
    Ok(())
}

/// The totals of each policy.
#[must_use]
pub fn totals(choice: &Choice, rows: &[Row]) -> Vec<Totals> {
    let of = |(n, policy): (usize, &Contender)| {
        let flown: Vec<_> = rows.iter().filter_map(|row| row.flown.get(n)).collect();
        Totals::of(policy.name(), &flown)
    };
    choice.policies.iter().enumerate().map(of).collect()
}

fn json(choice: &Choice, totals: &[Totals], rows: &[Row]) -> Value {
    let flown = rows.iter().flat_map(|row| &row.flown).map(Flown::json);
    json!({
        "places": choice.places,
        "seed": choice.seed,
        "fidelity": choice.fidelity.name(),
        "totals": totals.iter().map(Totals::json).collect::<Vec<_>>(),
        "missions": flown.collect::<Vec<_>>(),
    })
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
        let bound = figure.bound.map_or_else(String::new, super::told);
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
