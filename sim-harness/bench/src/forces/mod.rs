//! `uchain bench forces`: the tables of swarms by virtual forces.

pub mod figures;
pub mod measure;
mod missions;

use std::fmt::Write;

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use input::InputError;
use scenario::{Fidelity, MOST_DRONES};
use serde_json::Value;
use swarms::bench::{CLEAR, CONNECTED_IN_E, CROSSING, Row, SURVEY, cases, missed};
use swarms::{Phase, TooMany};

use self::measure::Speed;
use super::{Benchmark, Outcome, Session, belong_to};
use terminal::{FidelityArg, runs};

/// The numbers of drones of a mission where none is named: up to the paper's six, and twice as many.
const DRONES: [usize; 4] = [2, 4, 6, 12];
/// The fewest drones of a swarm.
const FEWEST: usize = 2;
/// The numbers of missions of a row, and of flights by the paper's model, where none is named.
const MISSIONS: usize = 10;
const FLIGHTS: usize = 100;

/// Which drones fly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Model {
    /// Missions of drones, each with the code that it has on board, four beams and a battery
    Drones,
    /// The paper's: points that step at once, one after the other, and know all walls near them
    Paper,
}

/// The arguments of the benchmark.
#[derive(Args)]
pub(crate) struct ForcesBench {
    /// Which drones fly; where left out, those of missions, with the code that they have on board
    #[arg(long, value_enum, default_value_t = Model::Drones)]
    model: Model,
    /// Number of missions for each row, 10 where left out; by the paper's model, of flights for each row with
    /// up to six drones, 100 where left out, and a tenth of them with more
    #[arg(long, allow_negative_numbers = true, value_name = "N")]
    runs: Option<usize>,
    /// Fly missions at this place only; may be given more than once
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(missions::names()))]
    place: Vec<String>,
    /// Fly missions of so many drones only; may be given more than once
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    drones: Vec<usize>,
    /// Take a drone from each mission after 40 s
    #[arg(long)]
    lose: bool,
    /// How closely the drones of missions are simulated; where left out, as points
    #[arg(long, value_enum)]
    fidelity: Option<FidelityArg>,
}

impl Benchmark for ForcesBench {
    const NAME: &'static str = "forces";
    const ABOUT: &'static str =
        "Whether swarms by virtual forces survey, cross, keep clear and connected, and how fast";
    const PAGE: &'static str = "swarms.md";

    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError> {
        match self.model {
            Model::Drones => missions::bench(&self.choice()?, session),
            Model::Paper => self.fly_points(session),
        }
    }
}

impl ForcesBench {
    fn choice(&self) -> Result<missions::Choice, InputError> {
        let is_possible = |drones: &&usize| (FEWEST..=MOST_DRONES).contains(*drones);
        if let Some(wrong) = self.drones.iter().find(|drones| !is_possible(drones)) {
            let remedy = format!("give a number from {FEWEST} to {MOST_DRONES}");
            return Err(InputError::new(format!("--drones {wrong} is out of range"), remedy));
        }
        let drones = if self.drones.is_empty() { DRONES.to_vec() } else { self.drones.clone() };
        Ok(missions::Choice {
            places: self.place.clone(),
            drones,
            loses_one: self.lose,
            fidelity: self.fidelity.map_or(Ok(Fidelity::Point), FidelityArg::of_the_host)?,
            runs: runs(self.runs.unwrap_or(MISSIONS))?,
        })
    }

    fn fly_points(&self, session: &Session<'_>) -> Result<Outcome, InputError> {
        let are_of_missions = [
            ("--place", !self.place.is_empty()),
            ("--drones", !self.drones.is_empty()),
            ("--lose", self.lose),
            ("--fidelity", self.fidelity.is_some()),
        ];
        belong_to("--model drones", &are_of_missions)?;
        let count = runs(self.runs.unwrap_or(FLIGHTS))?;
        let cases = cases();
        let progress = session.progress(cases.len(), "cases");
        let rows =
            measure::fly(&cases, count, session.seed, || progress.step()).map_err(refused)?;
        drop(progress);
        let progress = session.busy();
        let speeds = measure::speeds().map_err(refused)?;
        drop(progress);
        let mut missed = missed(&rows);
        missed.extend(speeds.iter().filter_map(Speed::missed));
        let mut json: Vec<Value> = rows.iter().map(|row| measure::json(row, &rows)).collect();
        json.extend(speeds.iter().map(Speed::json));
        let table = table(count, session.seed, &rows, &speeds);
        let seeds = super::seeds(session.seed, count);
        Ok(Outcome { table, json: Value::Array(json), missed, seeds })
    }
}

fn table(count: usize, seed: u64, rows: &[Row], speeds: &[Speed]) -> String {
    let mut table = format!(
        "forces: {count} flights a row, a tenth with more than six drones, seeds from {seed}\n  \
         bounds on ours: drones at least {CLEAR} safety distances apart, always connected in a to \
         d and {CONNECTED_IN_E} in e,\n  six drones cross in {CROSSING} of the paper's rounds, \
         surveys in {} of them, that of five drones in {}\n",
        SURVEY.0, SURVEY.1,
    );
    for phase in Phase::ALL {
        table.push_str(&block(phase, rows));
    }
    table.push('\n');
    for speed in speeds {
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:>12.0} drone-rounds/s of a survey with {:2} drones by {:5} on one core; bound {:.0}",
            speed.drone_rounds_per_s, speed.drones, speed.rule, speed.bound
        );
    }
    table
}

fn refused(error: TooMany) -> InputError {
    InputError::new(error.to_string(), "choose a size of swarm in that range")
}

fn block(phase: Phase, rows: &[Row]) -> String {
    let mut text = format!(
        "\n  {:8} {:>5} {:>6} {:>6} {:>8} {:>8} {:>6} {:>7} {:>6} {:>10} {:>9} {:>6}\n",
        phase.name(),
        "place",
        "drones",
        "rule",
        "rounds",
        "of ideal",
        "of p.",
        "drones",
        "walls",
        "links lost",
        "connected",
        "stuck",
    );
    for row in rows.iter().filter(|row| row.phase == phase) {
        let place = if phase == Phase::Survey { "area" } else { row.place.name() };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  {:8} {place:>5} {:>6} {:>6} {:>8} {:>8} {:>6} {:>7} {:>6} {:>10.2} {:>9.3} {:>6}",
            "",
            row.drones,
            row.rule,
            told(row.steps, 0),
            told(row.ratio_to_ideal, 2),
            told(row.over_paper(rows), 2),
            told(row.min_drone_drone_dsafe, 2),
            told(row.min_drone_wall_dsafe, 2),
            row.links_lost,
            row.connected,
            row.stuck,
        );
    }
    text
}

fn told(value: Option<f32>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
}
