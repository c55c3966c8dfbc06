//! Makes the figures of the thesis on coordinated exploration again (chapter 3): how much is explored over
//! time, the overlap, the way of a robot and the time, with one to three robots in the thesis' room, and
//! what its sentences about them are worth.
//!
//! All are flown by the thesis' rule and by ours, and figures 3.11 and 3.12 by the thesis' rule with other
//! values of λ and of the loop rate. Runs with the same seed lose the same packets and begin alike.

mod claims;
mod spread;
pub mod watched;

use explorers::{Air, Outcome, Senses, World};
use frontier::{Pace, Rule, Utility};
use input::InputError;
use serde_json::{Value, json};
use units::Duration;

use super::measure::{self, LOSS, Named, OURS, Row, THESIS};
use watched::WatchedRow;

/// The numbers of robots of the thesis' figures.
pub const ROBOTS: [usize; 3] = [1, 2, 3];
/// The robots of the runs with other values of λ and of the loop rate.
const PAIR: usize = 2;

/// The thesis' rule with one constant changed: the name, λ, and the loop rate, s.
const VARIANTS: [(&str, f32, u64); 4] =
    [("λ 0.05", 0.05, 20), ("λ 0.8", 0.8, 20), ("every 10 s", 0.2, 10), ("every 40 s", 0.2, 40)];

/// The thesis' rule and ours, with positions that drift, for figure 3.24.
const DRIFTING: [(&str, &str); 2] = [(THESIS, DRIFTS), (OURS, OURS_DRIFTS)];
/// The names of their rows.
pub const DRIFTS: &str = "thesis, drifting";
/// The name of the rows of our rule with positions that drift.
pub const OURS_DRIFTS: &str = "ours, drifting";
/// The robots of figure 3.24.
const LOCALISED: [usize; 2] = [1, 2];

/// The explorations of all figures.
pub struct Figures {
    /// The rows: the thesis' rule and ours with one to three robots, then the variants with two, then both
    /// rules with positions that drift.
    pub rows: Vec<Row>,
    /// What was watched in the first of these.
    pub watched: Vec<WatchedRow>,
    /// The runs of each row.
    pub runs: usize,
}

/// The number of explorations that [`make`] flies.
#[must_use]
pub const fn explorations(runs: usize) -> usize {
    runs * (2 * ROBOTS.len() + VARIANTS.len() + DRIFTING.len() * LOCALISED.len())
}

/// Flies all explorations, with so many seeds from the first on.
///
/// # Errors
/// [`InputError`] where the machine has no memory for the threads.
pub fn make(runs: usize, first: u64, after_each: impl Fn() + Sync) -> Result<Figures, InputError> {
    let room: Vec<World> = World::plan("room").into_iter().collect();
    let rules = measure::rules(&[THESIS.to_owned(), OURS.to_owned()]);
    let with = (Senses::default(), Air::losing(LOSS));
    let (mut rows, watched) = fly_watched(&room, &rules, (runs, first), &after_each)?;
    let variants = variants(&rules);
    rows.extend(measure::run(&room, &variants, &[PAIR], with, (runs, first), &after_each)?);
    let drifts = Senses { drifts: true, ..Senses::default() };
    let named = |(name, rule): Named| {
        let own = DRIFTING.iter().find(|(known, _)| *known == name)?;
        Some((own.1, rule))
    };
    let drifting: Vec<Named> = rules.iter().copied().filter_map(named).collect();
    let with = (drifts, Air::losing(LOSS));
    rows.extend(measure::run(&room, &drifting, &LOCALISED, with, (runs, first), &after_each)?);
    Ok(Figures { rows, watched, runs })
}

/// The rows of both rules with one to three robots, which are watched.
fn fly_watched(
    room: &[World],
    rules: &[Named],
    (runs, first): (usize, u64),
    after_each: &(impl Fn() + Sync),
) -> Result<(Vec<Row>, Vec<WatchedRow>), InputError> {
    let (mut rows, mut watched) = (Vec::new(), Vec::new());
    for world in room {
        for &(rule, constants) in rules {
            for robots in ROBOTS {
                let setup = measure::setup(world, constants, robots, first);
                let (outcomes, seen) = watched::fly_all(rule, &setup, runs, after_each)?;
                rows.push(Row { world: world.name.clone(), rule, robots, runs: outcomes });
                watched.push(seen);
            }
        }
    }
    Ok((rows, watched))
}

/// The thesis' rule with other constants.
fn variants(rules: &[Named]) -> Vec<Named> {
    let thesis = rules.iter().find(|(name, _)| *name == THESIS).map(|(_, rule)| *rule);
    let variant = |(name, lambda, every_s): (&'static str, f32, u64)| {
        let utility = Utility::Exponential { lambda, crowd: true };
        let pace = Pace::Every(Duration::from_secs(every_s));
        thesis.map(|rule| (name, Rule { utility, pace, ..rule }))
    };
    VARIANTS.into_iter().filter_map(variant).collect()
}

impl Figures {
    /// The row of a rule with so many robots.
    #[must_use]
    pub fn row(&self, rule: &str, robots: usize) -> Option<&Row> {
        self.rows.iter().find(|row| row.rule == rule && row.robots == robots)
    }

    /// All rows and claims as JSON.
    #[must_use]
    pub fn json(&self, seed: u64) -> Value {
        let rows: Vec<_> = self.rows.iter().map(Row::json).collect();
        let claims: Vec<_> = self.claims().iter().map(::measure::claim::Claim::json).collect();
        json!({
            "figures": "3.11 to 3.24",
            "runs": self.runs,
            "seed": seed,
            "version": env!("CARGO_PKG_VERSION"),
            "rows": rows,
            "claims": claims,
        })
    }
}

/// When 99 % were known, s; infinite where they never were.
#[must_use]
pub fn time_s(run: &Outcome) -> f32 {
    run.t99_s.unwrap_or(f32::INFINITY)
}

/// The way of a robot until 99 % were known, m; infinite where they never were.
#[must_use]
pub fn way_m(run: &Outcome) -> f32 {
    if run.t99_s.is_some() { run.path_m } else { f32::INFINITY }
}

/// The part of the place that is known at each second, on average over the runs of a row; a run that has
/// ended keeps what it knew.
#[must_use]
pub fn growth(row: &Row) -> Vec<f32> {
    let longest = row.runs.iter().map(|run| run.curve.len()).max().unwrap_or(0);
    let known = |run: &Outcome, second: usize| {
        let at = run.curve.get(second).or(run.curve.last());
        at.and_then(|known| known.last()).copied().unwrap_or(0.0)
    };
    let mean = |second| row.mean(|run| known(run, second)) as f32;
    (0..longest).map(mean).collect()
}

#[cfg(test)]
mod tests;
