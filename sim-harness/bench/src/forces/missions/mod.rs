//! Missions of swarms: each drone flies the code that it has on board, surveys an area, crosses a passage,
//! and surveys the area behind it.
//!
//! | module | holds |
//! |---|---|
//! | `places` | the passages, and the scenario of a swarm at one |
//! | `measure` | the missions of one case, and what came of them |

mod measure;
mod places;

use std::fmt::Write;

use input::InputError;
use scenario::Fidelity;

use self::measure::{Case, Row};
use self::places::{PLACES, Place};
use crate::missions::shown;
use crate::{Outcome, Session};

/// The names of all places.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    PLACES.iter().map(|place| place.name)
}

/// What is flown.
pub(super) struct Choice {
    /// The names of the places; all of them where it is empty.
    pub(super) places: Vec<String>,
    pub(super) drones: Vec<usize>,
    /// Whether each mission loses a drone during the first survey.
    pub(super) loses_one: bool,
    pub(super) fidelity: Fidelity,
    /// The number of missions of a row.
    pub(super) runs: usize,
}

impl Choice {
    fn places(&self) -> impl Iterator<Item = &'static Place> {
        let is_flown = |place: &&Place| {
            self.places.is_empty() || self.places.iter().any(|name| name == place.name)
        };
        PLACES.iter().filter(is_flown)
    }

    /// The part of a row's missions that must succeed: all as points, and all but one in a hundred as rigid
    /// bodies.
    fn least_good(&self) -> f64 {
        match self.fidelity {
            Fidelity::Point => 1.0,
            Fidelity::Flight | Fidelity::Virtual => 0.99,
        }
    }

    fn missed(&self, rows: &[Row]) -> Vec<String> {
        let least = self.least_good();
        let missed = |row: &Row| {
            let (good, flown) = (row.good(), row.flown.len());
            let Case { place, drones, .. } = &row.case;
            ((good as f64) < least * flown as f64).then(|| {
                format!(
                    "forces: {drones} drones at {place}: {good} of {flown} succeeded, bound {least}"
                )
            })
        };
        rows.iter().filter_map(missed).collect()
    }
}

/// Flies the missions.
pub(super) fn bench(choice: &Choice, session: &mut Session<'_>) -> Result<Outcome, InputError> {
    let mut cases = Vec::new();
    for place in choice.places() {
        for &drones in &choice.drones {
            cases.push(Case::of(place, drones, choice.loses_one, choice.fidelity)?);
        }
    }
    let progress = session.progress(cases.len() * choice.runs, "missions");
    let seeds = (choice.runs, session.seed);
    let rows: Vec<Row> =
        cases.into_iter().map(|case| measure::fly(case, seeds, || progress.step())).collect();
    drop(progress);
    if let Some(folder) = &mut session.folder {
        for Row { case, .. } in &rows {
            folder.put_text(&format!("{}-{}.toml", case.place, case.drones), &case.text)?;
        }
    }
    Ok(Outcome {
        table: table(choice, &rows),
        json: rows.iter().map(Row::json).collect(),
        missed: choice.missed(&rows),
        seeds: crate::seeds(session.seed, choice.runs),
    })
}

fn table(choice: &Choice, rows: &[Row]) -> String {
    let mut text = format!(
        "forces: missions of drones, {} a row, level {}{}; good: 99 % of both areas covered, no touch, all \
         landed where they should; bound {}\n\n  {:7} {:>6} {:>5} {:>5} {:>8} {:>7} {:>10} {:>8} \
         {:>9}  {}\n",
        choice.runs,
        choice.fidelity.name(),
        if choice.loses_one { ", a drone is lost after 40 s" } else { "" },
        choice.least_good(),
        "place",
        "drones",
        "runs",
        "good",
        "covered",
        "touched",
        "surveyed s",
        "landed s",
        "closest m",
        "what was wrong",
    );
    for row in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  {:7} {:>6} {:>5} {:>5} {:>8.4} {:>7} {:>10} {:>8} {:>9.2}  {}",
            row.case.place,
            row.case.drones,
            row.flown.len(),
            row.good(),
            row.covered(),
            row.touched(),
            shown(row.mean_s(|swarm| swarm.surveyed_s)),
            shown(row.mean_s(|swarm| swarm.across_s)),
            row.closest_m(),
            row.wrong(),
        );
    }
    text.push('\n');
    for Place { name, about, .. } in choice.places() {
        let _ = writeln!(text, "  {name}: {about}");
    }
    text
}
