//! `uchain campaign`: one scenario, many seeds.

use std::fmt::Write;

use clap::Args;
use serde_json::json;

use super::progress::Progress;
use super::{Common, FidelityArg, Trouble, Verdict, runs, scenario};
use crate::campaign::{Figure, figures, fly, json as figures_json};
use crate::metrics::Reference;
use crate::mission::World;
use crate::output;

#[derive(Args)]
pub(super) struct CampaignArgs {
    /// A built-in scenario's name or a scenario file
    scenario: String,
    /// How many missions
    #[arg(long, default_value_t = 100, value_name = "N")]
    runs: usize,
    /// Fly with this movement policy instead of the scenario's: t0, t5, k, authors or default
    #[arg(long, value_name = "NAME")]
    policy: Option<String>,
    /// How closely the vehicle is simulated
    #[arg(long, value_enum)]
    fidelity: Option<FidelityArg>,
    #[command(flatten)]
    common: Common,
}

pub(super) fn run(args: &CampaignArgs) -> Result<Verdict, Trouble> {
    let scenario = scenario(&args.scenario, args.policy.as_deref(), args.fidelity)?;
    let count = runs(args.runs)?;
    let world = World::of(&scenario);
    let reference = Reference::of(&scenario, &world);
    let progress = Progress::new(count as u64, args.common.quiet);
    progress.say("missions");
    let seed = args.common.seed;
    let all = fly(&scenario, &world, &reference, seed, count, || progress.step());
    drop(progress);
    let figures = figures(&all);
    let summary = json!({
        "scenario": scenario.name,
        "policy": scenario.policy,
        "fidelity": scenario.fidelity.name(),
        "seed": seed,
        "runs": count,
        "version": env!("CARGO_PKG_VERSION"),
        "metrics": figures_json(&figures),
    });
    let heading = format!("{}: {count} missions, policy {}", scenario.name, scenario.policy);
    args.common.print(&table(&heading, &figures), &summary);
    if let Some(dir) = &args.common.out {
        let rows: Vec<_> = all.iter().map(super::run::metrics_json).collect();
        let written = [
            output::put_json(dir, "summary.json", &summary)?,
            output::put_json(dir, "runs.json", &json!(rows))?,
        ];
        args.common.wrote(&written);
    }
    let broken: Vec<_> = (0_u64..)
        .zip(&all)
        .filter(|(_, run)| run.wall_contacts + run.drone_contacts + run.order_lost > 0)
        .map(|(n, _)| seed.wrapping_add(n).to_string())
        .collect();
    if broken.is_empty() {
        return Ok(Verdict::Good);
    }
    let seeds = broken.iter().take(10).cloned().collect::<Vec<_>>().join(", ");
    eprintln!(
        "uchain: {}: {} of {count} missions touched something or lost their order, seeds {seeds}",
        scenario.name,
        broken.len()
    );
    Ok(Verdict::Failed)
}

fn table(heading: &str, figures: &[Figure]) -> String {
    let mut text = format!("{heading}\n\n  {:18} {:>10}   95 % interval\n", "", "");
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
