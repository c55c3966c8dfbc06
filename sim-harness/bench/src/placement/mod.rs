//! `uchain bench placement`: how much relays cover that are put down by each rule.

pub mod measure;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use cave_worlds::{Dropped, DroppedTogether, Row, World};
use clap::Args;
use input::InputError;
use serde_json::json;

use self::measure::{
    LEAST_MEAN, LEAST_WORST, MOST_GEODESIC_MS, MOST_MS, Sum, TOGETHER, dropped_json, gather,
    gather_together, json as row_json, sum_of_drops, sum_of_together, sums, together_json,
};
use super::{Benchmark, Outcome, Session};
use planning::drops;
use terminal::runs;

/// The first seed of the caves, unless `--seed` is given: others than those on which the rule was
/// tuned.
const FIRST_CAVE: u64 = 200_000;

/// The arguments of the benchmark.
#[derive(Args)]
pub(crate) struct PlacementBench {
    /// Number of caves, which the seeds dig
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 100)]
    runs: usize,
    /// Measure what readings gain that a robot gathers around its goal, in each motion pattern, before
    /// it drops a relay
    #[arg(long)]
    gather: bool,
    /// Also put relays down in this map; may be given more than once
    #[arg(long, value_name = "FILE")]
    map: Vec<PathBuf>,
}

impl Benchmark for PlacementBench {
    const NAME: &'static str = "placement";
    const ABOUT: &'static str = "How much relays cover that are put down for good, by each rule";
    const PAGE: &'static str = "drops.md";

    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError> {
        let caves = runs(self.runs)? as u64;
        // `--seed` 1, the default, begins with the first cave.
        let first = FIRST_CAVE.wrapping_add(session.seed.wrapping_sub(1));
        if self.gather {
            self.gathered(session, caves, first)
        } else {
            self.put_down(session, caves, first)
        }
    }
}

impl PlacementBench {
    /// Puts relays down by each rule.
    fn put_down(
        &self,
        session: &Session<'_>,
        caves: u64,
        first: u64,
    ) -> Result<Outcome, InputError> {
        let mut rows = Vec::new();
        for file in &self.map {
            rows.extend(measure::run(&world(file)?, 0).ok_or_else(|| unusable(file))?);
        }
        let progress = session.progress(caves as usize, "caves");
        let cave = |n: u64| {
            let seed = first.wrapping_add(n);
            let rows = measure::run(&World::dig(seed), seed);
            progress.step();
            rows.unwrap_or_default()
        };
        // One after the other, because the times are those of one core.
        let dug: Vec<Vec<Row>> = (0..caves).map(cave).collect();
        drop(progress);
        rows.extend(dug.concat());
        let sums = sums(&rows);
        let bounds = json!({
            "rule": "ours",
            "of_best_mean": LEAST_MEAN,
            "of_best_worst": LEAST_WORST,
            "ms": MOST_MS,
            "geodesic_ms": MOST_GEODESIC_MS,
        });
        let rows: Vec<_> = rows.iter().map(row_json).collect();
        let json = json!({ "bounds": bounds, "rows": rows });
        let missed = sums.iter().flat_map(Sum::missed).collect();
        Ok(Outcome { table: table(&sums), json, missed, seeds: super::seeds(first, self.runs) })
    }

    /// Drops relays with and without readings.
    fn gathered(
        &self,
        session: &Session<'_>,
        caves: u64,
        first: u64,
    ) -> Result<Outcome, InputError> {
        let mut dropped: Vec<Dropped> = Vec::new();
        let mut together: Vec<DroppedTogether> = Vec::new();
        for file in &self.map {
            let world = world(file)?;
            dropped.extend(gather(&world, 0).ok_or_else(|| unusable(file))?);
            together.extend(gather_together(&world, 0).unwrap_or_default());
        }
        let progress = session.progress(caves as usize, "caves");
        for n in 0..caves {
            let seed = first.wrapping_add(n);
            let world = World::dig(seed);
            dropped.extend(gather(&world, seed).unwrap_or_default());
            together.extend(gather_together(&world, seed).unwrap_or_default());
            progress.step();
        }
        drop(progress);
        let mut table = table_of_drops(&dropped);
        table_of_together(&mut table, &together);
        let rows: Vec<_> = dropped.iter().map(dropped_json).collect();
        let planned: Vec<_> = together.iter().map(together_json).collect();
        let json = json!({ "dropped": rows, "dropped_together": planned });
        Ok(Outcome { table, json, missed: Vec::new(), seeds: super::seeds(first, self.runs) })
    }
}

fn world(file: &Path) -> Result<World, InputError> {
    drops::open(file, None).map(|(world, _)| world)
}

fn unusable(file: &Path) -> InputError {
    InputError::new("no robot can begin at its base", "give another map").in_file(file)
}

fn table_of_drops(dropped: &[Dropped]) -> String {
    let mut table = format!(
        "placement: one relay dropped by what the robot knows of the strength of the network\n\n  {:14} \
         {:10} {:>6} {:>6} {:>8} {:>10} {:>9} {:>6}\n",
        "knows", "chooses by", "worlds", "linked", "gain, m²", "margin, dB", "error, dB", "way, m"
    );
    for sum in sum_of_drops(dropped) {
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
    table
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
