//! Flies many seeded missions on all cores, and estimates their figures with confidence intervals.
//!
//! Seeds are consecutive from the first one on; results are collected in the order of the seeds,
//! so a campaign's figures do not depend on the number of threads.

mod estimate;
mod figures;
pub mod grid;
mod quantiles;
mod rows;
mod verdicts;

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use world::World;

use rayon::prelude::*;

use crate::metrics::{Reference, RunMetrics};
use crate::verdict::{Judgement, judged, judged_of};
use mission::Mission;
use scenario::Scenario;

pub use estimate::{Estimate, fraction, mean, quantile_of};
pub use figures::{Figure, Figures, excess, figures, json};
pub use rows::{COLUMNS, Cell, Column, Kind, Outcome, Row};
pub use verdicts::{Tally, Verdicts};

/// Flies every run, and returns the figures in the order of the seeds.
#[must_use]
pub fn fly(
    scenario: &Scenario,
    world: &World,
    reference: &Reference,
    first_seed: u64,
    runs: usize,
    after_each: impl Fn() + Sync,
) -> Vec<RunMetrics> {
    let never = AtomicBool::new(false);
    let flown = fly_until(&never, scenario, world, reference, first_seed, runs, after_each);
    flown.into_iter().map(|run| run.metrics).collect()
}

/// One run of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The seed.
    pub seed: u64,
    /// The figures.
    pub metrics: RunMetrics,
    /// The verdict.
    pub judgement: Judgement,
}

/// Flies the runs until `stop` is set, and returns each that had begun by then, in the order of the
/// seeds.
#[must_use]
pub fn fly_until(
    stop: &AtomicBool,
    scenario: &Scenario,
    world: &World,
    reference: &Reference,
    first_seed: u64,
    runs: usize,
    after_each: impl Fn() + Sync,
) -> Vec<Run> {
    (0..runs as u64)
        .into_par_iter()
        .filter(|_| !stop.load(Ordering::Relaxed))
        .map(|n| {
            let seed = first_seed.wrapping_add(n);
            let (metrics, judgement) = judged(scenario, world, reference, seed);
            after_each();
            Run { seed, metrics, judgement }
        })
        .collect()
}

/// Missions after which their rows are handed on, so that no more rows than these wait in memory. It is
/// large enough that all cores are busy but for the last missions of a chunk.
pub const CHUNK: usize = 4096;

/// One place of a campaign's grid, with what its missions share.
pub struct Place<'a> {
    scenario: &'a Scenario,
    number: usize,
    ground: OnceLock<(World, Reference)>,
}

impl<'a> Place<'a> {
    /// The place of this number, whose missions are of this scenario.
    #[must_use]
    pub const fn new(scenario: &'a Scenario, number: usize) -> Self {
        Self { scenario, number, ground: OnceLock::new() }
    }

    /// Flies the missions of these seeds until `stop` is set. Returns the rows of those that had begun
    /// by then, in the order of the seeds.
    #[must_use]
    pub fn fly(
        &self,
        stop: &AtomicBool,
        seeds: &[u64],
        after_each: impl Fn(&Row) + Sync,
    ) -> Vec<Row> {
        self.fly_with(|mission, _| mission, stop, seeds, after_each)
    }

    /// The same missions, each prepared before its first round: for a scenario
    /// [with a called law](mission::with_called_law) by [`Mission::by_law`].
    #[must_use]
    pub fn fly_with(
        &self,
        begin: impl for<'m> Fn(Mission<'m>, u64) -> Mission<'m> + Sync,
        stop: &AtomicBool,
        seeds: &[u64],
        after_each: impl Fn(&Row) + Sync,
    ) -> Vec<Row> {
        let scenario = self.scenario;
        let (world, reference) = self.ground.get_or_init(|| {
            let world = scenario.world();
            let reference = Reference::of(scenario, &world);
            (world, reference)
        });
        let flown = seeds.par_iter().filter(|_| !stop.load(Ordering::Relaxed)).map(|&seed| {
            let mission = begin(Mission::new(scenario, world, seed), seed);
            let (metrics, judgement) = judged_of(scenario, world, reference, mission);
            let row = Row::of(self.number, &Run { seed, metrics, judgement });
            after_each(&row);
            row
        });
        flown.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::{Scenario, builtin};

    #[test]
    fn a_campaign_that_is_stopped_keeps_the_runs_that_had_begun() {
        let scenario =
            Scenario { duration_us: 200_000, ..Scenario::open(builtin::DEMONSTRATION).unwrap() };
        let world = scenario.world();
        let reference = Reference::of(&scenario, &world);
        let stop = AtomicBool::new(false);
        let fly = || {
            fly_until(&stop, &scenario, &world, &reference, 7, 1_000, || {
                stop.store(true, Ordering::Relaxed);
            })
        };
        let flown = fly();
        assert!((1..1_000).contains(&flown.len()), "{}", flown.len());
        assert!(flown.is_sorted_by(|one, next| one.seed < next.seed));
        assert!(fly().is_empty(), "none begins after the stop");
    }
}
