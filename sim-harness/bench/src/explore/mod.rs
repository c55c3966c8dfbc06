//! `uchain bench explore`: the table of the explorers, and of their bounds.

pub mod figures;
pub mod measure;
mod missions;
pub mod scale;

use std::fmt::Write;
use std::path::PathBuf;

use agent::MOST_EXPLORERS;
use clap::{Args, ValueEnum};
use explorers::{Air, PLANS, ROBOTS, Scale, Senses, Sensor, World};
use input::InputError;

use self::measure::{Comparison, LONGEST_S, LOSS, Named, Row};
use super::{Benchmark, Outcome, Session, belong_to};
use planning::explored::explored;
use scenario::Fidelity;
use terminal::{FidelityArg, NetworkArg, SensorArg, counted, runs};

/// The numbers of drones of a mission where none is named.
const DRONES: [usize; 4] = [1, 2, 4, 6];
/// The numbers of robots where none is named.
const MOST_BY_DEFAULT: usize = 6;

/// Which drones explore.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Model {
    /// Missions of drones, each with the code that it has on board, four beams and a battery
    Drones,
    /// Robots as points, with the thesis' camera, speed and reach
    Thesis,
}

/// The arguments of the benchmark.
#[derive(Args)]
pub(crate) struct ExploreBench {
    /// Which drones explore; where left out, those of missions, with the code that they have on board
    #[arg(long, value_enum, default_value_t = Model::Drones)]
    model: Model,
    /// Explore N floor plans that the seeds draw in place of the named ones
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    drawn: Option<usize>,
    /// How closely the drones are simulated; where left out, as points
    #[arg(long, value_enum)]
    fidelity: Option<FidelityArg>,
    /// Number of explorations for each row
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 10)]
    runs: usize,
    /// Explore by this rule only; may be given more than once
    #[arg(long, value_name = "NAME", conflicts_with = "ablation")]
    rule: Vec<String>,
    /// Explore by the rule `ours` without each of its ingredients instead
    #[arg(long)]
    ablation: bool,
    /// Explore with so many robots only; may be given more than once
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    robots: Vec<usize>,
    /// Explore this map in place of the built-in plans; may be given more than once
    #[arg(long, value_name = "FILE")]
    map: Vec<PathBuf>,
    /// By which sensor the robots map; where left out, by a camera
    #[arg(long, value_enum)]
    sensor: Option<SensorArg>,
    /// How packets come from robot to robot; where left out, in a mesh
    #[arg(long, value_enum)]
    network: Option<NetworkArg>,
    /// Let positions drift as those by optic flow do
    #[arg(long)]
    drift: bool,
    /// Measure how long a leader's round takes with up to 64 robots instead
    #[arg(long, conflicts_with_all = ["ablation", "rule", "robots", "map", "runs", "sensor", "drift", "network", "seed"])]
    scale: bool,
}

impl Benchmark for ExploreBench {
    const NAME: &'static str = "explore";
    const ABOUT: &'static str = "How fast several robots explore a place together, by each rule";
    const PAGE: &'static str = "explore.md";

    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError> {
        match self.model {
            _ if self.scale => time_rounds(session),
            Model::Thesis => self.explore(session),
            Model::Drones => missions::bench(&self.choice()?, session),
        }
    }
}

impl ExploreBench {
    /// The missions of drones.
    fn choice(&self) -> Result<missions::Choice, InputError> {
        let is_of_the_thesis = [
            ("--map", !self.map.is_empty()),
            ("--sensor", self.sensor.is_some()),
            ("--network", self.network.is_some()),
        ];
        belong_to("--model thesis", &is_of_the_thesis)?;
        let drones = match self.robots.as_slice() {
            [] => DRONES.to_vec(),
            _ => self.robots(MOST_EXPLORERS)?,
        };
        let rules = if self.ablation { self.rules()? } else { measure::rules(&self.named()) };
        Ok(missions::Choice {
            drawn: self.drawn.map(|count| counted("--drawn", count)).transpose()?,
            rules,
            drones,
            fidelity: self.fidelity.map_or(Ok(Fidelity::Point), FidelityArg::of_the_host)?,
            has_fixes: !self.drift,
            runs: runs(self.runs)?,
        })
    }

    fn named(&self) -> Vec<String> {
        if self.rule.is_empty() { vec!["ours".to_owned()] } else { self.rule.clone() }
    }

    fn explore(&self, session: &Session<'_>) -> Result<Outcome, InputError> {
        let are_of_drones =
            [("--drawn", self.drawn.is_some()), ("--fidelity", self.fidelity.is_some())];
        belong_to("--model drones", &are_of_drones)?;
        let (worlds, rules, robots) = (self.worlds()?, self.rules()?, self.robots(ROBOTS)?);
        let count = runs(self.runs)?;
        let total = worlds.len() * rules.len() * robots.len() * count;
        let progress = session.progress(total, "explorations");
        let senses = Senses {
            sensor: self.sensor.map_or(Sensor::Camera, SensorArg::sensor),
            drifts: self.drift,
        };
        let network = self.network.map(NetworkArg::network).unwrap_or_default();
        let air = Air { network, ..Air::losing(LOSS) };
        let (with, seeds) = ((senses, air), (count, session.seed));
        let rows = measure::run(&worlds, &rules, &robots, with, seeds, || progress.step())?;
        drop(progress);
        let compared = measure::compare(&rows);
        Ok(Outcome {
            table: table(&rows, &compared, count),
            json: rows.iter().map(Row::json).collect(),
            missed: compared.iter().flat_map(Comparison::missed).collect(),
            seeds: super::seeds(session.seed, count),
        })
    }

    fn worlds(&self) -> Result<Vec<World>, InputError> {
        if self.map.is_empty() {
            return Ok(PLANS.iter().filter_map(|(name, _)| World::plan(name)).collect());
        }
        self.map.iter().map(|file| explored(file, None).map(|(world, _)| world)).collect()
    }

    fn rules(&self) -> Result<Vec<Named>, InputError> {
        if self.ablation {
            return Ok(measure::ablation());
        }
        let all = measure::rules(&[]);
        let is_unknown = |rule: &&String| all.iter().all(|(name, _)| name != rule);
        if let Some(unknown) = self.rule.iter().find(is_unknown) {
            let names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
            let remedy = format!("the rules are {}", names.join(", "));
            return Err(InputError::new(format!("there is no rule \"{unknown}\""), remedy));
        }
        Ok(measure::rules(&self.rule))
    }

    fn robots(&self, most: usize) -> Result<Vec<usize>, InputError> {
        if self.robots.is_empty() {
            return Ok((1..=MOST_BY_DEFAULT).collect());
        }
        if let Some(wrong) = self.robots.iter().find(|count| !(1..=most).contains(*count)) {
            let remedy = format!("give a number from 1 to {most}");
            return Err(InputError::new(format!("--robots {wrong} is out of range"), remedy));
        }
        Ok(self.robots.clone())
    }
}

/// Times a leader's round.
fn time_rounds(session: &Session<'_>) -> Result<Outcome, InputError> {
    let progress = session.progress(scale::count(), "cases");
    let rows = scale::run(|| progress.step())?;
    drop(progress);
    Ok(Outcome {
        table: table_of_rounds(&rows),
        json: rows.iter().map(scale::Row::json).collect(),
        missed: rows.iter().filter_map(scale::Row::missed).collect(),
        seeds: "none".to_owned(),
    })
}

fn table(rows: &[Row], compared: &[Comparison], count: usize) -> String {
    let mut text = format!(
        "explore: {count} runs a row, at most {LONGEST_S} s, {:.0} % of packets lost; time, way and \
         overlap until 99 % are known\n\n  {:16} {:21} {:>6} {:>8} {:>6} {:>6} {:>6} {:>7} {:>5} \
         {:>7} {:>7} {:>9}\n",
        100.0 * LOSS,
        "world",
        "rule",
        "robots",
        "explored",
        "99 %",
        "t99 s",
        "way m",
        "overlap",
        "early",
        "stopped",
        "kB",
        "closest m",
    );
    for row in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  {:16} {:21} {:>6} {:>8.4} {:>6} {:>6} {:>6.1} {:>7.2} {:>5} {:>7} {:>7.1} {:>9}",
            row.world,
            row.rule,
            row.robots,
            row.mean(|run| run.explored),
            row.count(|run| run.t99_s.is_some()),
            row.t99_s().map_or_else(|| "-".to_owned(), |time| format!("{time:.0}")),
            row.mean(|run| run.path_m),
            row.mean(|run| run.overlap),
            row.count(|run| run.premature_stop),
            row.count(|run| run.stopped_s.is_some()),
            row.mean(|run| run.kb_on_air),
            row.closest_m().map_or_else(|| "-".to_owned(), |apart| format!("{apart:.2}")),
        );
    }
    for Comparison { robots, pairs, quotients: [time, way, bytes], .. } in compared {
        let _ = writeln!(
            text,
            "  ours of thesis, {robots} robots, {pairs} pairs of runs: time {time:.2}, way {way:.2}, \
             bytes {bytes:.2}",
        );
    }
    text
}

fn table_of_rounds(rows: &[scale::Row]) -> String {
    let mut table = format!(
        "explore: a leader's round and its step with the map of 100 by 100 m, processor time; a round of \
         ours takes at most {:.0} ms with {} robots\n\n  {:8} {:>6} {:>14} {:>8} {:>8} {:>8} {:>7}\n",
        scale::BOUND_MS,
        scale::BOUND_ROBOTS,
        "rule",
        "robots",
        "frontier cells",
        "assigned",
        "round ms",
        "bound ms",
        "map ms",
    );
    for row in rows {
        let Scale { robots, frontier_cells, assigned, round_ms, map_ms } = row.scale;
        let bound = row.bound_ms().map_or_else(|| "-".to_owned(), |bound| format!("{bound:.0}"));
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:8} {robots:>6} {frontier_cells:>14} {assigned:>8} {round_ms:>8.3} {bound:>8} \
             {map_ms:>7.1}",
            row.rule,
        );
    }
    table
}
