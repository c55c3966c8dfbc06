//! `uchain campaign`: one scenario, many seeds.

use std::fmt::Write;
use std::sync::atomic::AtomicBool;

use clap::Args;
use serde_json::{Value, json};

use super::run::{MapArgs, metrics_json};
use super::{
    Common, LinkArg, Trouble, Verdict, builtin_scenarios, complain, host_scenario, interrupt,
    with_link,
};
use crate::args::{FidelityArg, runs};
use crate::input_error::InputError;
use crate::measure::campaign::{Figure, Run, Verdicts, figures, fly_until, json as figures_json};
use crate::measure::metrics::Reference;
use crate::mission::World;
use crate::progress::Progress;
use crate::scenario::Scenario;

#[derive(Args)]
#[command(after_help = builtin_scenarios())]
pub(super) struct CampaignArgs {
    /// Name of a built-in scenario (listed below), or a scenario file; with --map it may be left out
    #[arg(required_unless_present = "map")]
    scenario: Option<String>,
    #[command(flatten)]
    map: MapArgs,
    /// Number of relays, instead of the scenario's
    #[arg(long, allow_negative_numbers = true, value_name = "N")]
    relays: Option<usize>,
    /// Number of missions
    #[arg(long, allow_negative_numbers = true, default_value_t = 100, value_name = "N")]
    runs: usize,
    /// Movement policy, instead of the scenario's: t0, t5, k, authors, k-tuned or chain
    #[arg(long, value_name = "NAME")]
    policy: Option<String>,
    /// How closely the drones are simulated
    #[arg(long, value_enum)]
    fidelity: Option<FidelityArg>,
    /// How reports and orders get from drone to drone
    #[arg(long, value_enum)]
    link: Option<LinkArg>,
    #[command(flatten)]
    common: Common,
}

impl CampaignArgs {
    /// The scenario, along a map's route where one was given; says the map's remarks.
    fn open(&self) -> Result<Scenario, InputError> {
        let scenario = self.map.mission(self.scenario.as_deref(), self.relays)?;
        let scenario = host_scenario(scenario, self.policy.as_deref(), self.fidelity)?;
        if let Some(route) = &scenario.route {
            route.warnings.iter().for_each(complain);
        }
        with_link(scenario, self.link)
    }
}

pub(super) fn run(args: &CampaignArgs) -> Result<Verdict, Trouble> {
    let scenario = args.open()?;
    let asked = runs(args.runs)?;
    let stop = interrupt::asks(
        "Ctrl-C: the missions that have begun are flown to their ends; a second Ctrl-C drops all",
    );
    let mut folder = args.common.folder()?;
    let flown = fly_all(&scenario, args, asked, stop);
    if flown.is_empty() {
        complain("interrupted before a mission was flown; nothing was written");
        return Ok(Verdict::Interrupted);
    }
    let metrics: Vec<_> = flown.iter().map(|run| run.metrics).collect();
    let figures = figures(&metrics);
    let verdicts = Verdicts::of(&flown);
    let summary = json!({
        "scenario": scenario.name,
        "policy": scenario.policy,
        "fidelity": scenario.fidelity.name(),
        "link": scenario.link.name(),
        "seed": args.common.seed,
        "runs": flown.len(),
        "runs_asked": asked,
        "version": env!("CARGO_PKG_VERSION"),
        "verdict": verdicts.json(),
        "metrics": figures_json(&figures),
    });
    if let Some(folder) = &mut folder {
        let rows: Vec<_> = flown.iter().map(row).collect();
        folder.put_json("summary.json", &summary)?;
        folder.put_json("runs.json", &json!(rows))?;
    }
    let count = counted(flown.len(), asked);
    let heading = format!("{}: {count} missions, policy {}", scenario.name, scenario.policy);
    let table = table(&heading, &verdicts, &figures);
    args.common.finish(folder, &table, &summary)?;
    let failed = verdicts.failed();
    if failed > 0 {
        let count = flown.len();
        complain(format_args!("{}: {failed} of {count} missions failed", scenario.name));
    }
    if flown.len() < asked {
        complain(format_args!("interrupted; the figures are of {count} missions"));
        return Ok(Verdict::Interrupted);
    }
    Ok(if failed == 0 { Verdict::Good } else { Verdict::Failed })
}

fn fly_all(scenario: &Scenario, args: &CampaignArgs, count: usize, stop: &AtomicBool) -> Vec<Run> {
    let world = World::of(scenario);
    let reference = Reference::of(scenario, &world);
    let progress = Progress::new(count as u64, args.common.quiet);
    progress.say("missions");
    let seed = args.common.seed;
    fly_until(stop, scenario, &world, &reference, seed, count, || progress.step())
}

/// The number of missions that were flown, and of how many where that is fewer.
fn counted(flown: usize, asked: usize) -> String {
    if flown == asked { flown.to_string() } else { format!("{flown} of {asked}") }
}

/// A run as an entry of `runs.json`.
fn row(run: &Run) -> Value {
    let mut row = json!({ "seed": run.seed, "verdict": run.judgement.json() });
    if let (Some(row), Value::Object(metrics)) = (row.as_object_mut(), metrics_json(&run.metrics)) {
        row.extend(metrics);
    }
    row
}

fn table(heading: &str, verdicts: &Verdicts, figures: &[Figure]) -> String {
    let mut text =
        format!("{heading}\n\n{}\n  {:18} {:>10}   95 % interval\n", verdicts.table(), "", "");
    for Figure { name, estimate } in figures {
        // Writing to a string cannot fail.
        let _ = write!(text, "  {name:18} {:>10.3}", estimate.value);
        if let Some((low, high)) = estimate.interval {
            let _ = write!(text, "   {low:.3} to {high:.3}");
        }
        text.push('\n');
    }
    text
}
