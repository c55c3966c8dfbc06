//! `uchain bench places`: a chain in every cave, map and world of a folder, from the entrance to each
//! depth and home.
//!
//! | module | holds |
//! |---|---|
//! | `found` | the files of a folder that are places |
//! | `site` | the routes of a place, or why it has none |
//! | `invariants` | what every route and every refusal must keep, without a mission |
//! | `depth` | the mission to one depth of a route, with its relays and its oracle |
//! | `pilot` | the pilot, who goes by the odometer |
//! | `flown` | one mission |
//! | `row` | the missions to one depth as a row |
//! | `table` | rows, totals and causes as text |

mod depth;
mod flown;
mod found;
pub mod invariants;
mod pilot;
mod row;
mod site;
mod table;
#[cfg(test)]
mod tests;

use std::path::PathBuf;

use clap::Args;
use input::InputError;
use rayon::prelude::*;
use serde_json::{Value, json};

use super::{Benchmark, Needs, Outcome, Session};
use depth::Target;
use flown::Flight;
use row::{Row, Totals};
use scenario::{DEPTHS, Fidelity};
use terminal::{FidelityArg, runs};

/// Missions of a row where the command line does not say.
const fn default_runs(fidelity: Fidelity) -> usize {
    if matches!(fidelity, Fidelity::Point) { 10 } else { 2 }
}

/// The arguments of the benchmark.
#[derive(Args)]
pub(crate) struct PlacesBench {
    /// The folder whose caves, maps and worlds are flown, with all folders below it
    #[arg(long, value_name = "DIR")]
    data: PathBuf,
    /// How far from the base the head is to come, m of way, each in missions of its own
    #[arg(long, value_name = "METRES", value_delimiter = ',', default_value = "20,40,60,100")]
    #[arg(allow_negative_numbers = true)]
    depths: Vec<f32>,
    /// Number of missions for each row; where left out, 10 of points and 2 of rigid bodies
    #[arg(long, allow_negative_numbers = true, value_name = "N")]
    runs: Option<usize>,
    /// How closely the drones are simulated; where left out, as points
    #[arg(long, value_enum)]
    fidelity: Option<FidelityArg>,
    /// Print a line for each mission
    #[arg(long)]
    each: bool,
}

impl Benchmark for PlacesBench {
    const NAME: &'static str = "places";
    const ABOUT: &'static str =
        "How a chain does in every cave, map and world of a folder, at each depth";
    const PAGE: &'static str = "benchmarks.md";
    const NEEDS: Needs = Needs::Data;

    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError> {
        let fidelity = self.fidelity.map_or(Ok(Fidelity::Point), FidelityArg::of_the_host)?;
        let runs = runs(self.runs.unwrap_or(default_runs(fidelity)))?;
        let sites = site::all(&found::places(&self.data)?);
        let depths = self.depths()?;
        let targets: Vec<Target<'_>> = sites
            .par_iter()
            .flat_map_iter(|site| depth::targets(site, &depths, fidelity))
            .collect();
        let flown = targets.iter().filter(|target| target.mission.is_ok()).count();
        let progress = session.progress(flown * runs, "missions");
        let seeds: Vec<u64> = (0..runs as u64).map(|n| session.seed.wrapping_add(n)).collect();
        let pairs = targets.iter().flat_map(|target| seeds.iter().map(move |seed| (target, *seed)));
        let flights: Vec<Option<Flight>> = pairs
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|(target, seed)| {
                let flight = target.mission.as_ref().ok()?.fly(seed);
                progress.step();
                Some(flight)
            })
            .collect();
        drop(progress);
        let rows: Vec<Row> = targets
            .iter()
            .zip(flights.chunks(runs))
            .map(|(target, flights)| Row::of(target, fidelity, flights.iter().flatten().cloned()))
            .collect();
        if let Some(folder) = &mut session.folder {
            for (row, stem) in rows.iter().zip(row::stems(&rows)) {
                for (seed, text) in row.failed() {
                    folder.put_text(&format!("{stem}-seed-{seed}.toml"), text)?;
                }
            }
        }
        let broken: Vec<String> = sites.iter().flat_map(|site| site.broken.clone()).collect();
        let checked = sites.iter().filter(|site| site.is_survey).count();
        let seeds = super::seeds(session.seed, runs);
        Ok(self.outcome(fidelity, seeds, &rows, &broken, checked))
    }
}

impl PlacesBench {
    /// The depths, in order.
    fn depths(&self) -> Result<Vec<f32>, InputError> {
        let mut depths = self.depths.clone();
        depths.sort_by(f32::total_cmp);
        depths.dedup();
        match depths.iter().find(|depth| !DEPTHS.contains(depth)) {
            None => Ok(depths),
            Some(wrong) => {
                let remedy = format!("give numbers from {} to {}", DEPTHS.start(), DEPTHS.end());
                Err(InputError::new(format!("--depths {wrong} is out of range"), remedy))
            }
        }
    }

    fn outcome(
        &self,
        fidelity: Fidelity,
        seeds: String,
        rows: &[Row],
        broken: &[String],
        checked: usize,
    ) -> Outcome {
        let totals = Totals::of(rows);
        let table = table::text(rows, &totals, self.each, broken, checked);
        let missions = || rows.iter().flat_map(Row::missions_json).collect::<Vec<_>>();
        let json = json!({
            "rows": rows.iter().map(Row::json).collect::<Vec<_>>(),
            "totals": totals.json(),
            "invariants": { "routes": checked, "broken": broken },
            "missions": if self.each { json!(missions()) } else { Value::Null },
        });
        let missed = totals.missed(fidelity).into_iter().chain(broken.iter().cloned()).collect();
        Outcome { table, json, missed, seeds }
    }
}
