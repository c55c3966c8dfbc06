//! `uchain bench explore`: the table of the explorers, and of their bounds.

use std::fmt::Write;

use explorers::{PLANS, ROBOTS, World};
use serde_json::{Value, json};

use super::BenchArgs;
use crate::cli::progress::Progress;
use crate::cli::{Trouble, runs};
use crate::input_error::InputError;
use crate::measure::bench::explore::{self, Comparison, LONGEST_S, LOSS, Named, Row};
use crate::world::import::explored;

/// The numbers of robots where none is named.
const MOST_BY_DEFAULT: usize = 6;

/// Bounds that were missed are added to `missed`.
pub(super) fn bench(
    args: &BenchArgs,
    missed: &mut Vec<String>,
) -> Result<(String, Value), Trouble> {
    let worlds = worlds(args)?;
    let rules = rules(args)?;
    let robots = robots(args)?;
    let count = runs(args.runs.unwrap_or(10))?;
    let total = worlds.len() * rules.len() * robots.len() * count;
    let progress = Progress::new(total as u64, args.common.quiet);
    progress.say("explorations");
    let rows = explore::run(&worlds, &rules, &robots, count, args.common.seed, || progress.step())?;
    drop(progress);
    let compared = explore::compare(&rows);
    missed.extend(compared.iter().flat_map(Comparison::missed));
    let mut value: Vec<Value> = rows.iter().map(Row::json).collect();
    value.extend(compared.iter().map(|one| json!({ "ours_of_thesis": one.json() })));
    Ok((table(&rows, &compared, count), Value::Array(value)))
}

fn worlds(args: &BenchArgs) -> Result<Vec<World>, Trouble> {
    if args.map.is_empty() {
        return Ok(PLANS.iter().filter_map(|(name, _)| World::plan(name)).collect());
    }
    Ok(args.map.iter().map(|file| explored(file, None)).collect::<Result<_, _>>()?)
}

fn rules(args: &BenchArgs) -> Result<Vec<Named>, Trouble> {
    if args.ablation {
        return Ok(explore::ablation());
    }
    let all = explore::rules(&[]);
    if let Some(unknown) = args.rule.iter().find(|rule| all.iter().all(|(name, _)| name != rule)) {
        let names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
        let remedy = format!("the rules are {}", names.join(", "));
        return Err(InputError::new(format!("there is no rule \"{unknown}\""), remedy).into());
    }
    Ok(explore::rules(&args.rule))
}

fn robots(args: &BenchArgs) -> Result<Vec<usize>, Trouble> {
    if args.robots.is_empty() {
        return Ok((1..=MOST_BY_DEFAULT).collect());
    }
    if let Some(wrong) = args.robots.iter().find(|count| !(1..=ROBOTS).contains(count)) {
        let remedy = format!("give a number from 1 to {ROBOTS}");
        return Err(InputError::new(format!("--robots {wrong} is out of range"), remedy).into());
    }
    Ok(args.robots.clone())
}

fn table(rows: &[Row], compared: &[Comparison], count: usize) -> String {
    let mut text = format!(
        "explore: {count} runs a row, at most {LONGEST_S} s, {:.0} % of packets lost; time, way and \
         overlap until 99 % are known\n\n  {:16} {:21} {:>6} {:>8} {:>6} {:>6} {:>6} {:>7} {:>5} \
         {:>7} {:>7}\n",
        100.0 * LOSS,
        "world",
        "rule",
        "robots",
        "explored",
        "99 %",
        "t99 s",
        "way m",
        "overlap",
        "early",
        "stopped",
        "kB",
    );
    for row in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  {:16} {:21} {:>6} {:>8.4} {:>6} {:>6} {:>6.1} {:>7.2} {:>5} {:>7} {:>7.1}",
            row.world,
            row.rule,
            row.robots,
            row.mean(|run| run.explored),
            row.count(|run| run.t99_s.is_some()),
            row.t99_s().map_or_else(|| "-".to_owned(), |time| format!("{time:.0}")),
            row.mean(|run| run.path_m),
            row.mean(|run| run.overlap),
            row.count(|run| run.premature_stop),
            row.count(|run| run.stopped_s.is_some()),
            row.mean(|run| run.kb_on_air),
        );
    }
    for Comparison { robots, pairs, quotients: [time, way, bytes], .. } in compared {
        let _ = writeln!(
            text,
            "  ours of thesis, {robots} robots, {pairs} pairs of runs: time {time:.2}, way {way:.2}, \
             bytes {bytes:.2}",
        );
    }
    text
}
