//! Prints the rows of the rules in caves as one JSON value: first seed, number of caves, and relays
//! in each. It ends with status 1 where a bound is missed.

use std::process::ExitCode;

use cave_worlds::{Row, measure};
use relay_placement::Rule;
use serde_json::{Value, json};

/// The least share of the best that our rule covers on average, and in the worst cave.
const LEAST_MEAN: f32 = 0.9;
const LEAST_WORST: f32 = 0.75;
/// The most time that the selections of one cave take, ms.
const MOST_MS: f32 = 20.0;

fn main() -> ExitCode {
    let mut numbers = std::env::args().skip(1).map(|word| word.parse::<u64>());
    let mut next = |usual| numbers.next().unwrap_or(Ok(usual));
    let (Ok(first), Ok(caves), Ok(nodes)) = (next(200_000), next(100), next(1)) else {
        eprintln!("an argument is no whole number; give FIRST-SEED CAVES NODES");
        return ExitCode::from(2);
    };
    let rows: Vec<Row> = (first..first.saturating_add(caves))
        .flat_map(|world| measure(world, usize::try_from(nodes).unwrap_or(usize::MAX)))
        .collect();
    println!("{:#}", rows.iter().map(value).collect::<Value>());
    let mut is_met = true;
    for rule in Rule::ALL {
        let own: Vec<_> = rows.iter().filter(|row| row.rule == rule).collect();
        let shares: Vec<f32> = own.iter().filter_map(|row| row.of_best).collect();
        let mean = shares.iter().sum::<f32>() / shares.len() as f32;
        let worst = shares.iter().copied().fold(f32::INFINITY, f32::min);
        let linked = own.iter().filter(|row| row.link_margin_db >= 0.0).count();
        let wide = own.iter().filter(|row| row.free_width_m >= 1.0).count();
        let slowest = own.iter().map(|row| row.ms).fold(0.0, f32::max);
        eprintln!(
            "{:10} mean {mean:.3} worst {worst:.3} of best, linked {linked}, 1 m free {wide}, of \
             {}; slowest {slowest:.1} ms",
            rule.name(),
            own.len()
        );
        is_met &= rule != Rule::Ours
            || mean >= LEAST_MEAN
                && worst >= LEAST_WORST
                && linked == own.len()
                && slowest <= MOST_MS;
    }
    if is_met { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn value(row: &Row) -> Value {
    json!({
        "world": row.world,
        "rule": row.rule.name(),
        "nodes": row.nodes,
        "covered_m2": row.covered_m2,
        "of_best": row.of_best,
        "link_margin_db": row.link_margin_db,
        "free_width_m": row.free_width_m,
        "ms": row.ms,
    })
}
