//! `uchain bench throughput`: how fast the simulator is.

pub mod measure;

use std::fmt::Write;

use clap::Args;
use input::InputError;
use serde_json::{Map, Value, json};

use self::measure::{FLIGHT_AIM, LINKS, RIGID_AIM, SCENARIO, Steps, Throughput};
use super::{Benchmark, Outcome, Session};
use mission::Part;
use scenario::LinkModel;
use terminal::runs;

/// Missions whose parts are timed: enough for a share to a hundredth.
const PROFILED: usize = 20;

/// The arguments of the benchmark.
#[derive(Args)]
pub(crate) struct ThroughputBench {
    /// Number of missions for each thread of a measurement
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 200)]
    runs: usize,
}

/// The share of the time that each part of the simulation takes, with one link.
type Profile = (LinkModel, Vec<(Part, f64)>);

impl Benchmark for ThroughputBench {
    const NAME: &'static str = "throughput";
    const ABOUT: &'static str = "How fast the simulator is";
    const PAGE: &'static str = "benchmarks.md";
    // The same missions are timed always.
    const IS_SEEDED: bool = false;

    fn run(&self, session: &mut Session<'_>) -> Result<Outcome, InputError> {
        let progress = session.busy();
        let count = runs(self.runs)?;
        let rows = measure::run(count)?;
        let steps = measure::steps()?;
        let profile = |(link, _)| Ok((link, measure::profile(link, count.min(PROFILED))?));
        let profiles = LINKS.into_iter().map(profile).collect::<Result<Vec<_>, InputError>>()?;
        drop(progress);
        let table = table(&rows, &steps, &profiles);
        let json = json(&rows, &steps, &profiles);
        Ok(Outcome { table, json, missed: Vec::new(), seeds: "from 0 on".to_owned() })
    }
}

fn table(rows: &[Throughput], steps: &Steps, profiles: &[Profile]) -> String {
    let mut table = format!("throughput: {SCENARIO}, point level by link\n\n");
    for row in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:6} {} threads {:>12.0} drone-rounds/s, {:.2} of linear; aim {:.0} on one core",
            row.link.name(),
            row.threads,
            row.drone_rounds_per_s,
            row.scaling,
            row.aim,
        );
    }
    for (rate, what, aim) in [
        (steps.flight, "drone-steps/s at flight level", FLIGHT_AIM),
        (steps.rigid, "steps/s of the rigid body alone", RIGID_AIM),
    ] {
        let _ = writeln!(table, "  {:6} 1 threads {rate:>12.0} {what}; aim {aim:.0}", "");
    }
    table.push_str("\n  the time of one thread at point level, by part\n");
    for (link, shares) in profiles {
        let told = |(part, share): &(Part, f64)| format!("{} {:.0} %", part.name(), 100.0 * share);
        let shares: Vec<_> = shares.iter().map(told).collect();
        let _ = writeln!(table, "  {:6} {}", link.name(), shares.join(", "));
    }
    table
}

fn json(rows: &[Throughput], steps: &Steps, profiles: &[Profile]) -> Value {
    let rows = rows.iter().map(|row| {
        json!({
            "scenario": SCENARIO,
            "fidelity": "point",
            "link": row.link.name(),
            "threads": row.threads,
            "drone_rounds_per_s": row.drone_rounds_per_s.round(),
            "scaling": row.scaling,
            "aim_one_core": row.aim,
        })
    });
    let steps = [
        json!({
            "scenario": SCENARIO,
            "fidelity": "flight",
            "threads": 1,
            "drone_steps_per_s": steps.flight.round(),
            "aim_one_core": FLIGHT_AIM,
        }),
        json!({
            "what": "rigid body alone",
            "threads": 1,
            "steps_per_s": steps.rigid.round(),
            "aim_one_core": RIGID_AIM,
        }),
    ];
    let profiles = profiles.iter().map(|(link, shares)| {
        let shares: Map<_, _> =
            shares.iter().map(|(part, share)| (part.name().to_owned(), json!(share))).collect();
        json!({
            "scenario": SCENARIO,
            "fidelity": "point",
            "link": link.name(),
            "shares": shares,
        })
    });
    rows.chain(steps).chain(profiles).collect()
}
