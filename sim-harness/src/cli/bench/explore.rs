//! `uchain bench explore`: the table of the explorers, and of their bounds.

use std::fmt::Write;

use explorers::{Air, PLANS, ROBOTS, Scale, Senses, Sensor, World};
use serde_json::Value;

use super::BenchArgs;
use crate::cli::progress::Progress;
use crate::cli::{NetworkArg, SensorArg, Trouble, runs};
use crate::input_error::InputError;
use crate::measure::bench::explore::{self, Comparison, LONGEST_S, LOSS, Named, Row, scale};
use crate::world::import::explored;

/// The numbers of robots where none is named.
const MOST_BY_DEFAULT: usize = 6;

/// Bounds that were missed are added to `missed`.
pub(super) fn bench(
    args: &BenchArgs,
    missed: &mut Vec<String>,
) -> Result<(String, Value), Trouble> {
    if args.scale {
        return scale_bench(args, missed);
    }
    let worlds = worlds(args)?;
    let rules = rules(args)?;
    let robots = robots(args)?;
    let count = runs(args.runs.unwrap_or(10))?;
    let total = worlds.len() * rules.len() * robots.len() * count;
    let progress = Progress::new(total as u64, args.common.quiet);
    progress.say("explorations");
    let senses = Senses {
        sensor: args.sensor.map_or(Sensor::Camera, SensorArg::sensor),
        drifts: args.drift,
    };
    let network = args.network.map(NetworkArg::network).unwrap_or_default();
    let air = Air { network, ..Air::losing(LOSS) };
    let seeds = (count, args.common.seed);
    let rows = explore::run(&worlds, &rules, &robots, (senses, air), seeds, || progress.step())?;
    drop(progress);
    let compared = explore::compare(&rows);
    missed.extend(compared.iter().flat_map(Comparison::missed));
    Ok((table(&rows, &compared, count), rows.iter().map(Row::json).collect()))
}

fn worlds(args: &BenchArgs) -> Result<Vec<World>, Trouble> {
    if args.map.is_empty() {
        return Ok(PLANS.iter().filter_map(|(name, _)| World::plan(name)).collect());
    }
    let world = |file: &std::path::PathBuf| explored(file, None).map(|(world, _)| world);
    Ok(args.map.iter().map(world).collect::<Result<_, _>>()?)
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
         {:>7} {:>7} {:>9}\n",
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
        "closest m",
    );
    for row in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  {:16} {:21} {:>6} {:>8.4} {:>6} {:>6} {:>6.1} {:>7.2} {:>5} {:>7} {:>7.1} {:>9}",
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
            row.closest_m().map_or_else(|| "-".to_owned(), |apart| format!("{apart:.2}")),
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

/// Rounds that took too long are added to `missed`.
fn scale_bench(args: &BenchArgs, missed: &mut Vec<String>) -> Result<(String, Value), Trouble> {
    let progress = Progress::new(scale::count() as u64, args.common.quiet);
    progress.say("cases");
    let rows = scale::run(|| progress.step())?;
    drop(progress);
    missed.extend(rows.iter().filter_map(scale::Row::missed));
    let mut table = format!(
        "explore: a leader's round and its step with the map of 100 by 100 m, processor time; a round of \
         ours takes at most {:.0} ms with {} robots\n\n  {:8} {:>6} {:>14} {:>8} {:>8} {:>8} {:>7}\n",
        scale::BOUND_MS,
        scale::BOUND_ROBOTS,
        "rule",
        "robots",
        "frontier cells",
        "assigned",
        "round ms",
        "bound ms",
        "map ms",
    );
    for row in &rows {
        let Scale { robots, frontier_cells, assigned, round_ms, map_ms } = row.scale;
        let bound = row.bound_ms().map_or_else(|| "-".to_owned(), |bound| format!("{bound:.0}"));
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:8} {robots:>6} {frontier_cells:>14} {assigned:>8} {round_ms:>8.3} {bound:>8} \
             {map_ms:>7.1}",
            row.rule,
        );
    }
    Ok((table, rows.iter().map(scale::Row::json).collect()))
}
