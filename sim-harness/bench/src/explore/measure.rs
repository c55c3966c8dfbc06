//! Measures how several robots explore a place together, by rule and number of robots.

use std::collections::BTreeMap;

use explorers::{Air, Outcome, Senses, Setup, World};
use frontier::{Distance, Facing, Overlap, Pace, RULES, RobotOrder, Rule, RuleEntry, Utility};
use input::InputError;
use rayon::prelude::*;
use serde_json::{Value, json};
use units::{Duration, Metres};

use scenario::VehicleSpec;

/// A run ends after so long, s: the flight time of a Crazyflie with two spare batteries.
pub const LONGEST_S: f32 = 900.0;
/// The part of all packets that is lost whatever the signal.
pub const LOSS: f32 = 0.1;
/// The stack of a thread, bytes: robots with large maps are built on it, and a thread that waits for
/// another begins a further exploration on the same stack.
pub(super) const STACK: usize = 64 << 20;
/// The rule that is measured, and the one that it must beat.
pub(super) const OURS: &str = "ours";
pub(super) const THESIS: &str = "thesis";
/// The bounds of `ours` over `thesis`, in seeds in which both have come to 99 %: time, way and bytes.
pub const BOUNDS: [(&str, f64); 3] = [("time", 0.6), ("way", 0.8), ("bytes", 2.0)];

/// A rule under a name.
pub type Named = (&'static str, Rule);

/// The rules of these names, or all where none is given.
#[must_use]
pub fn rules(names: &[String]) -> Vec<Named> {
    let is_wanted = |name: &str| names.is_empty() || names.iter().any(|wanted| wanted == name);
    let all = RULES.iter().map(|entry| (entry.name, entry.rule));
    all.filter(|(name, _)| is_wanted(name)).collect()
}

/// `ours`, and `ours` without each of its ingredients.
#[must_use]
pub fn ablation() -> Vec<Named> {
    let rule = |name| RuleEntry::named(name).unwrap_or(&RULES[0]).rule;
    let (ours, thesis) = (rule(OURS), rule(THESIS));
    let every_20_s = Pace::Every(Duration::from_secs(20));
    vec![
        (OURS, ours),
        ("every 20 s", Rule { pace: every_20_s, ..ours }),
        ("robots by number", Rule { order: RobotOrder::ByNumber, ..ours }),
        ("straight distance", Rule { distance: Distance::Straight, ..ours }),
        ("overlap by points", Rule { overlap: thesis.overlap, ..ours }),
        ("gain not weighed", Rule { utility: Utility::Nearest, ..ours }),
        ("no discount", Rule { discount: None, ..ours }),
        ("small frontiers", Rule { least_frontier: 1, ..ours }),
        ("nose first", Rule { facing: Facing::Way, ..ours }),
        ("goals kept to the end", Rule { ends_when_seen: false, ..ours }),
        ("no look from afar", Rule { looks_from_afar: false, ..ours }),
        ("no reachability", Rule { reachability: false, blacklist: Duration::ZERO, ..ours }),
        ("stop not confirmed", Rule { confirmed_stop: false, ..ours }),
        ("each for itself", Rule { overlap: Overlap::Alone, confirmed_stop: false, ..ours }),
    ]
}

/// All runs of one rule with one number of robots in one place.
#[derive(Clone, Debug)]
pub struct Row {
    /// The name of the place.
    pub world: String,
    /// The name of the rule.
    pub rule: &'static str,
    /// The number of robots.
    pub robots: usize,
    /// The runs, in the order of their seeds.
    pub runs: Vec<Outcome>,
}

impl Row {
    /// The mean of a figure over all runs.
    #[must_use]
    pub fn mean(&self, figure: impl Fn(&Outcome) -> f32) -> f64 {
        self.runs.iter().map(|run| f64::from(figure(run))).sum::<f64>()
            / self.runs.len().max(1) as f64
    }

    /// The mean time until 99 % were known, over the runs that came so far.
    #[must_use]
    pub fn t99_s(&self) -> Option<f64> {
        let times: Vec<f64> = self.runs.iter().filter_map(|run| run.t99_s).map(f64::from).collect();
        (!times.is_empty()).then(|| times.iter().sum::<f64>() / times.len() as f64)
    }

    /// The least distance of two robots in all runs.
    #[must_use]
    pub fn closest_m(&self) -> Option<f64> {
        let closest = self.runs.iter().filter_map(|run| run.closest_m);
        closest.min_by(f32::total_cmp).map(f64::from)
    }

    /// The number of runs of which something is true.
    #[must_use]
    pub fn count(&self, is: impl Fn(&Outcome) -> bool) -> usize {
        self.runs.iter().filter(|run| is(run)).count()
    }

    /// The row as one JSON object.
    #[must_use]
    pub fn json(&self) -> Value {
        json!({
            "world": self.world,
            "rule": self.rule,
            "robots": self.robots,
            "runs": self.runs.len(),
            "explored": self.mean(|run| run.explored),
            "reached_99": self.count(|run| run.t99_s.is_some()),
            "t99_s": self.t99_s(),
            "stopped": self.count(|run| run.stopped_s.is_some()),
            "path_m": self.mean(|run| run.path_m),
            "overlap": self.mean(|run| run.overlap),
            "premature_stop": self.count(|run| run.premature_stop),
            "kB_on_air": self.mean(|run| run.kb_on_air),
            "wall_touches": self.count(|run| run.touches > 0),
            "into_walls": self.count(|run| run.into_walls > 0),
            "robot_touches": self.count(|run| run.robot_touches > 0),
            "closest_m": self.closest_m(),
            "error_m": self.mean(|run| run.error_m),
        })
    }
}

/// Explores each place by each rule with each number of robots that have these senses and this radio,
/// with so many seeds from the first on.
///
/// # Errors
/// [`InputError`] where the machine has no memory for the threads.
pub fn run(
    worlds: &[World],
    rules: &[Named],
    robots: &[usize],
    (senses, air): (Senses, Air),
    (seeds, first): (usize, u64),
    after_each: impl Fn() + Sync,
) -> Result<Vec<Row>, InputError> {
    let mut rows = Vec::new();
    for world in worlds {
        for &(name, rule) in rules {
            for &robots in robots {
                let setup = Setup { senses, air, ..setup(world, rule, robots, first) };
                let runs = each_seed(&setup, seeds, |setup| {
                    let outcome = explorers::run(setup).0;
                    after_each();
                    outcome
                })?;
                rows.push(Row { world: world.name.clone(), rule: name, robots, runs });
            }
        }
    }
    Ok(rows)
}

/// Explores with so many seeds from that of the setup on, on all cores.
pub(super) fn each_seed<T: Send>(
    setup: &Setup<'_>,
    seeds: usize,
    explore: impl Fn(&Setup<'_>) -> T + Sync,
) -> Result<Vec<T>, InputError> {
    let pool = rayon::ThreadPoolBuilder::new().stack_size(STACK).build().map_err(no_threads)?;
    let one = |n: u64| explore(&Setup { seed: setup.seed.wrapping_add(n), ..*setup });
    Ok(pool.install(|| (0..seeds as u64).into_par_iter().map(one).collect()))
}

pub(super) fn no_threads(error: impl std::fmt::Display) -> InputError {
    InputError::new(format!("no threads could be started: {error}"), "free some memory")
}

/// One exploration through the benchmark's radio, with cameras and exact positions.
#[must_use]
pub fn setup(world: &World, rule: Rule, robots: usize, seed: u64) -> Setup<'_> {
    let air = Air::losing(LOSS);
    let longest_s = LONGEST_S;
    let senses = Senses::default();
    let radius = Metres(VehicleSpec::DEFAULT.radius);
    let (death_s, apart_s) = (None, None);
    Setup { world, rule, robots, seed, air, senses, radius, death_s, apart_s, longest_s }
}

/// `ours` over `thesis` for a number of robots, over all places: time, way and bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// The number of robots.
    pub robots: usize,
    /// The pairs of runs of the same place and seed in which both came to 99 %.
    pub pairs: usize,
    /// The quotients, in the order of [`BOUNDS`].
    pub quotients: [f64; 3],
    /// Runs of `ours` that stopped too early.
    pub premature: usize,
}

impl Comparison {
    /// What is to be complained of.
    pub fn missed(&self) -> Vec<String> {
        let all = BOUNDS.iter().zip(self.quotients).filter(|((_, bound), q)| q > bound);
        let robots = self.robots;
        let mut missed: Vec<String> = all
            .map(|((what, bound), q)| {
                format!("explore: {robots} robots, {what}: {q:.2} of thesis, must be {bound}")
            })
            .collect();
        if self.premature > 0 {
            let count = self.premature;
            missed.push(format!("explore: {robots} robots: {count} early stops, must be 0"));
        }
        missed
    }
}

/// Compares `ours` with `thesis` where both were run with two or three robots.
#[must_use]
pub fn compare(rows: &[Row]) -> Vec<Comparison> {
    let mut found: BTreeMap<usize, (usize, [[f64; 2]; 3], usize)> = BTreeMap::new();
    for ours in rows.iter().filter(|row| row.rule == OURS && (2..=3).contains(&row.robots)) {
        let is_same =
            |row: &&Row| row.rule == THESIS && row.robots == ours.robots && row.world == ours.world;
        let Some(thesis) = rows.iter().find(is_same) else { continue };
        let (pairs, sums, premature) = found.entry(ours.robots).or_default();
        *premature += ours.count(|run| run.premature_stop);
        for (a, b) in ours.runs.iter().zip(&thesis.runs) {
            let (Some(time), Some(of)) = (a.t99_s, b.t99_s) else { continue };
            *pairs += 1;
            let figures = [[time, of], [a.path_m, b.path_m], [a.kb_on_air, b.kb_on_air]];
            for (sum, [ours, thesis]) in sums.iter_mut().zip(figures) {
                *sum = [sum[0] + f64::from(ours), sum[1] + f64::from(thesis)];
            }
        }
    }
    let all = found.into_iter().map(|(robots, (pairs, sums, premature))| {
        let quotients = sums.map(|[ours, thesis]| ours / thesis);
        Comparison { robots, pairs, quotients, premature }
    });
    all.collect()
}
