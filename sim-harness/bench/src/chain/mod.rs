//! `uchain bench chain`: the table of how the chain holds.

pub mod ablation;
pub mod cases;
mod contender;
pub mod drawn;
pub mod measure;
mod unknown;

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;
use input::InputError;

use self::cases::Bound;
pub use self::contender::{Contender, MakeLaw};
use self::measure::{Choice, MakeDrones, Row};
use super::{Benchmark, Outcome, Session};
use bodies::emulated::Firmware;
use scenario::{Fidelity, Scenario};
use scenario::{PRESETS, RadioPreset};
use terminal::{FidelityArg, runs};

/// Missions of a row where the command line does not say.
const fn default_runs(fidelity: Fidelity) -> usize {
    match fidelity {
        Fidelity::Point => 40,
        Fidelity::Flight => 30,
        Fidelity::Virtual => 3,
    }
}

/// The arguments of the benchmark.
#[derive(Args)]
pub(crate) struct ChainBench {
    /// Number of missions for each row; where left out, 40 of points, 30 of rigid bodies and 3 of virtual
    /// drones
    #[arg(long, allow_negative_numbers = true, value_name = "N")]
    runs: Option<usize>,
    /// Run only this scenario; may be given more than once
    #[arg(long, value_name = "NAME")]
    scenario: Vec<String>,
    /// Fly only this policy; may be given more than once
    #[arg(long, value_name = "NAME")]
    policy: Vec<String>,
    /// Fly the policy `chain` without each of its ingredients instead
    #[arg(long, conflicts_with_all = ["fidelity", "policy"])]
    ablation: bool,
    /// Fly in N places that the seeds draw instead, beside an oracle; --out keeps the scenario of each
    /// that fails
    #[arg(long, value_name = "N", allow_negative_numbers = true,
        conflicts_with_all = ["ablation", "scenario", "runs", "radio"])]
    drawn: Option<usize>,
    /// With --drawn, print a line for each mission, and keep the scenario of each
    #[arg(long, requires = "drawn")]
    each: bool,
    /// Fly through this radio in place of the scenarios' own
    #[arg(long, value_parser = PossibleValuesParser::new(PRESETS.map(|preset| preset.name)))]
    radio: Option<String>,
    /// How closely the drones are simulated; where left out, as points
    #[arg(long, value_enum)]
    fidelity: Option<FidelityArg>,
    /// The firmware's ELF file, for virtual drones; where left out, the one that `cargo fw` builds
    #[arg(long, value_name = "FILE")]
    elf: Option<PathBuf>,
    /// The radio chip's own firmware; where left out, the radio chip is a model
    #[arg(long, value_name = "FILE")]
    radio_elf: Option<PathBuf>,
}

impl Benchmark for ChainBench {
    const NAME: &'static str = "chain";
    const ABOUT: &'static str =
        "How well the chain holds, grows, heals and comes home under each movement policy";
    const PAGE: &'static str = "benchmarks.md";

    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError> {
        let fidelity = self.fidelity.map_or(Ok(Fidelity::Point), FidelityArg::fidelity)?;
        if (self.elf.is_some() || self.radio_elf.is_some()) && fidelity != Fidelity::Virtual {
            let wrong = "--elf and --radio-elf name the firmware of virtual drones";
            return Err(InputError::new(wrong, "give --fidelity virtual with it"));
        }
        match self.drawn {
            Some(places) => drawn::bench(self, places, fidelity, session),
            None => self.fly(fidelity, session),
        }
    }
}

impl ChainBench {
    /// Flies the scenarios.
    fn fly(&self, fidelity: Fidelity, session: &Session<'_>) -> Result<Outcome, InputError> {
        let choice = Choice {
            fidelity,
            scenarios: self.scenario.clone(),
            policies: Contender::all(&self.policy)?,
            runs: runs(self.runs.unwrap_or(default_runs(fidelity)))?,
            seed: session.seed,
            radio: self.radio.as_deref().and_then(RadioPreset::named),
        };
        let total = if self.ablation {
            measure::count_ablation(&choice)?
        } else {
            measure::count(&choice)?
        };
        let firmware = self.firmware(fidelity)?;
        let make = firmware
            .as_ref()
            .map(|firmware| |scenario: &Scenario, seed| firmware.fleet(scenario, seed));
        let make = make.as_ref().map(|make| make as &MakeDrones<'_>);
        let progress = session.progress(total, "missions");
        let step = || {
            progress.step();
            Ok(())
        };
        let rows = if self.ablation {
            measure::run_ablation(&choice, step)?
        } else {
            measure::run(&choice, make, step)?
        };
        drop(progress);
        let what = if self.ablation { "without" } else { "policy" };
        let table = table(&choice, what, &rows);
        let json = rows.iter().map(Row::json).collect();
        let seeds = super::seeds(choice.seed, choice.runs);
        Ok(Outcome { table, json, missed: Vec::new(), seeds })
    }

    /// The firmware of the drones, where they are virtual.
    fn firmware(&self, fidelity: Fidelity) -> Result<Option<Firmware>, InputError> {
        let elf = self.elf.as_deref().unwrap_or(Firmware::DEFAULT.as_ref());
        let open = || Firmware::open(elf)?.with_radio(self.radio_elf.as_deref());
        (fidelity == Fidelity::Virtual).then(open).transpose()
    }
}

/// One block for each scenario: its figures, their bounds and targets, and a row for each policy.
fn table(choice: &Choice, what: &str, rows: &[Row]) -> String {
    let last = choice.seed.wrapping_add(choice.runs as u64).wrapping_sub(1);
    let mut text = format!(
        "chain: {} missions a row, level {}, seeds {} to {last}{}; \
         ! marks a figure that misses its target\n",
        choice.runs,
        choice.fidelity.name(),
        choice.seed,
        choice.radio.map_or_else(String::new, |radio| format!(", radio: {}", radio.line))
    );
    for block in rows.chunk_by(|one, next| one.scenario == next.scenario) {
        let Some(first) = block.first() else { continue };
        // Writing to a string cannot fail.
        let _ = write!(text, "\n  {}\n    {what:26}", first.scenario);
        for (name, _) in &first.figures {
            let _ = write!(text, " {:>w$} ", name, w = width(name));
        }
        line(&mut text, "bound", first, |name| bound(first, name));
        if let Some(unknown) = first.unknown {
            let gap =
                |value: f64| move |name: &str| (name == "gap_db").then(|| format!("{value:.2}"));
            line(&mut text, "best in the local mean", first, gap(unknown.local_mean_db));
            line(&mut text, "best by the law alone", first, gap(unknown.law_db));
        }
        line(&mut text, "target", first, |name| first.target(name).map(told));
        for row in block {
            let _ = write!(text, "\n    {:26}", row.policy);
            for (name, value) in &row.figures {
                let mark = if row.misses(name, *value) { '!' } else { ' ' };
                let value = value.map_or_else(|| "never".to_owned(), |value| format!("{value:.3}"));
                let _ = write!(text, " {value:>w$}{mark}", w = width(name));
            }
        }
        text.push('\n');
    }
    text
}

fn line(text: &mut String, heading: &str, row: &Row, of: impl Fn(&str) -> Option<String>) {
    // Writing to a string cannot fail.
    let _ = write!(text, "\n    {heading:26}");
    for (name, _) in &row.figures {
        let cell = of(name).unwrap_or_default();
        let _ = write!(text, " {cell:>w$} ", w = width(name));
    }
}

/// What no policy can beat.
fn bound(row: &Row, figure: &str) -> Option<String> {
    match figure {
        "t3_median_s" | "t_gap1_median_s" => row.bound_s.map(|bound| format!("{bound:.1}")),
        "t_gap1_over_bound" => Some("1".to_owned()),
        "gap_db" | "cruise_gap_db" => Some("0".to_owned()),
        _ => None,
    }
}

fn told(bound: Bound) -> String {
    match bound {
        Bound::Most(most) => format!("<= {most}"),
        Bound::Least(least) => format!(">= {least}"),
    }
}

fn width(name: &str) -> usize {
    name.len().max(7)
}
