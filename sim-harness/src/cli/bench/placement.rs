//! `uchain bench placement`: how much relays cover that are put down by each rule.

use std::fmt::Write;

use cave_worlds::{Dropped, DroppedTogether, Row, World};
use serde_json::{Value, json};

use super::BenchArgs;
use crate::cli::progress::Progress;
use crate::cli::{Trouble, runs};
use crate::input_error::InputError;
use crate::measure::bench::placement::{
    LEAST_MEAN, LEAST_WORST, MOST_GEODESIC_MS, MOST_MS, Sum, TOGETHER, dropped_json, gather,
    gather_together, json as row_json, run, sum_of_drops, sum_of_together, sums, together_json,
};
use crate::measure::drops;

/// The first seed of the caves, unless `--seed` is given: others than those on which the rule was
/// tuned.
const FIRST_CAVE: u64 = 200_000;

/// Bounds that are missed are added to `missed`.
pub(super) fn bench(
    args: &BenchArgs,
    missed: &mut Vec<String>,
) -> Result<(String, Value), Trouble> {
    let caves = runs(args.runs.unwrap_or(100))? as u64;
    // `--seed` 1, the default, begins with the first cave.
    let first = FIRST_CAVE.wrapping_add(args.common.seed.wrapping_sub(1));
    if args.gather {
        return gathered(args, caves, first);
    }
    let mut rows = Vec::new();
    for file in &args.map {
        let (world, _) = drops::open(file, None)?;
        rows.extend(run(&world, 0).ok_or_else(|| unusable().in_file(file))?);
    }
    let progress = Progress::new(caves, args.common.quiet);
    progress.say("caves");
    let cave = |n: u64| {
        let seed = first.wrapping_add(n);
        let rows = run(&World::dig(seed), seed);
        progress.step();
        rows.unwrap_or_default()
    };
    // One after the other, because the times are those of one core.
    let dug: Vec<Vec<Row>> = (0..caves).map(cave).collect();
    drop(progress);
    rows.extend(dug.concat());
    let sums = sums(&rows);
    missed.extend(sums.iter().flat_map(Sum::missed));
    let bounds = json!({
        "rule": "ours",
        "of_best_mean": LEAST_MEAN,
        "of_best_worst": LEAST_WORST,
        "ms": MOST_MS,
        "geodesic_ms": MOST_GEODESIC_MS,
    });
    let rows: Vec<_> = rows.iter().map(row_json).collect();
    Ok((table(&sums), json!({ "bounds": bounds, "rows": rows })))
}

/// The table of relays that are dropped with and without readings.
fn gathered(args: &BenchArgs, caves: u64, first: u64) -> Result<(String, Value), Trouble> {
    let mut dropped: Vec<Dropped> = Vec::new();
    let mut together: Vec<DroppedTogether> = Vec::new();
    for file in &args.map {
        let (world, _) = drops::open(file, None)?;
        dropped.extend(gather(&world, 0).ok_or_else(|| unusable().in_file(file))?);
        together.extend(gather_together(&world, 0).unwrap_or_default());
    }
    let progress = Progress::new(caves, args.common.quiet);
    progress.say("caves");
    for n in 0..caves {
        let seed = first.wrapping_add(n);
        let world = World::dig(seed);
        dropped.extend(gather(&world, seed).unwrap_or_default());
        together.extend(gather_together(&world, seed).unwrap_or_default());
        progress.step();
    }
    drop(progress);
    let mut table = format!(
        "placement: one relay dropped by what the robot knows of the strength of the network\n\n  {:14} \
         {:10} {:>6} {:>6} {:>8} {:>10} {:>9} {:>6}\n",
        "knows", "chooses by", "worlds", "linked", "gain, m²", "margin, dB", "error, dB", "way, m"
    );
    for sum in sum_of_drops(&dropped) {
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:14} {:10} {:>6} {:>6} {:>8.1} {:>10.1} {:>9.2} {:>6.1}",
            sum.knows.name(),
            sum.chooses.name(),
            sum.worlds,
            sum.linked,
            sum.gained_m2,
            sum.margin_db,
            sum.error_db,
            sum.way_m,
        );
    }
    table_of_together(&mut table, &together);
    let rows: Vec<_> = dropped.iter().map(dropped_json).collect();
    let planned: Vec<_> = together.iter().map(together_json).collect();
    Ok((table, json!({ "dropped": rows, "dropped_together": planned })))
}

fn table_of_together(table: &mut String, together: &[DroppedTogether]) {
    // Writing to a string cannot fail.
    let _ = writeln!(
        table,
        "\n{TOGETHER} relays, planned together\n\n  {:14} {:10} {:>6} {:>6} {:>6} {:>8} {:>5}",
        "knows", "chooses by", "worlds", "relays", "linked", "gain, m²", "±"
    );
    for sum in sum_of_together(together) {
        let [gained, error] = sum.gained_m2;
        let _ = writeln!(
            table,
            "  {:14} {:10} {:>6} {:>6} {:>6} {gained:>8.1} {error:>5.1}",
            sum.knows.name(),
            sum.chooses.name(),
            sum.worlds,
            sum.relays,
            sum.linked,
        );
    }
}

fn unusable() -> InputError {
    InputError::new("no robot can begin at its base", "give another map")
}

fn table(sums: &[Sum]) -> String {
    let mut table = format!(
        "placement: ours covers at least {LEAST_MEAN} of the best on average and {LEAST_WORST} in the \
         worst world, linked, in {MOST_MS} ms\n\n  {:>6} {:14} {:>6} {:>5} {:>5} {:>8} {:>10} {:>6} {:>8} {:>10}\n",
        "relays",
        "rule",
        "worlds",
        "mean",
        "worst",
        "of bound",
        "by way, m²",
        "linked",
        "1 m free",
        "slowest, ms",
    );
    for sum in sums {
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:>6} {:14} {:>6} {:>5.3} {:>5.3} {:>8.3} {:>10.1} {:>6} {:>8} {:>10.1}",
            sum.asked,
            sum.rule.name(),
            sum.worlds,
            sum.mean,
            sum.worst,
            sum.of_bound,
            sum.by_way_m2,
            sum.linked,
            sum.wide,
            sum.slowest_ms,
        );
    }
    table
}
