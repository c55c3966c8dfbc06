//! Flies the missions of a row of a benchmark, and counts why they failed.

use std::collections::BTreeMap;
use std::fmt::Write;

use measure::metrics::{Reference, RunMetrics};
use measure::verdict::{Judgement, judged};
use rayon::prelude::*;
use scenario::Scenario;

/// One mission, with its figures and its verdict.
pub(crate) struct Mission {
    pub(crate) seed: u64,
    pub(crate) metrics: RunMetrics,
    pub(crate) judgement: Judgement,
}

/// Flies so many missions of a scenario on all cores, with seeds from the first on, and calls `after_each`
/// after each one.
pub(crate) fn fly(
    scenario: &Scenario,
    (count, first): (usize, u64),
    after_each: impl Fn() + Sync,
) -> Vec<Mission> {
    let world = scenario.world();
    let reference = Reference::of(scenario, &world);
    let mission = |n: u64| {
        let seed = first.wrapping_add(n);
        let (metrics, judgement) = judged(scenario, &world, &reference, seed);
        after_each();
        Mission { seed, metrics, judgement }
    };
    (0..count as u64).into_par_iter().map(mission).collect()
}

/// How often each name occurs, as a cell of a table.
pub(crate) fn tally<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut counts = BTreeMap::<&str, usize>::new();
    for name in names {
        *counts.entry(name).or_default() += 1;
    }
    let told: Vec<String> = counts.iter().map(|(name, count)| format!("{name} {count}")).collect();
    told.join(", ")
}

/// The mean of the values, if there are any.
pub(crate) fn mean(values: impl Iterator<Item = f32>) -> Option<f64> {
    let values: Vec<f64> = values.map(f64::from).collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// A value without decimals, or a dash, as a cell of a table.
pub(crate) fn shown(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.0}"))
}

/// Writes a room of a scenario, by its western, southern, eastern and northern side, m.
pub(crate) fn write_room(text: &mut String, [west, south, east, north]: &[f32; 4]) {
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "[[tunnel.room]]\ncentre_m = [{:.3}, {:.3}]\nsize_m = [{:.3}, {:.3}]\n\n",
        0.5 * (west + east),
        0.5 * (south + north),
        east - west,
        north - south
    );
}
