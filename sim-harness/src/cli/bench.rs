//! `uchain bench`: the named benchmarks.

mod chain;
mod drawn;
mod explore;
mod forces;
mod placement;

use std::fmt::Write;
use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use serde_json::{Map, Value, json};

use super::emulated::bench as emulated;
use super::progress::Progress;
use super::{
    Common, FidelityArg, NetworkArg, SensorArg, Trouble, Verdict, complain, interrupt, runs,
};
use crate::bodies::emulated::Firmware;
use crate::input_error::InputError;
use crate::measure::bench::attacks::sieges;
use crate::measure::bench::{attacks, estimator, faults, junctions, link, throughput};
use crate::mission::medium::PRESETS;
use crate::scenario::Fidelity;

/// Missions whose parts are timed: enough for a share to a hundredth.
const PROFILED: usize = 20;

#[derive(Args)]
pub(super) struct BenchArgs {
    /// The benchmark; where left out, all of them
    #[arg(value_enum)]
    name: Option<Name>,
    /// Number of missions, or flights, for each row of a benchmark
    #[arg(long, allow_negative_numbers = true, value_name = "N")]
    runs: Option<usize>,
    /// Run only the faults and mishaps that have this text in their names
    #[arg(long, value_name = "TEXT", default_value = "")]
    pub(super) only: String,
    /// Run only this scenario of the benchmark `chain` or `junctions`; may be given more than once
    #[arg(long, value_name = "NAME")]
    scenario: Vec<String>,
    /// Fly only this policy in the benchmark `chain`; may be given more than once
    #[arg(long, value_name = "NAME")]
    policy: Vec<String>,
    /// In the benchmark `chain`, fly the policy `chain` without each of its ingredients instead; in
    /// `explore`, the rule `ours`
    #[arg(long, conflicts_with = "fidelity")]
    ablation: bool,
    /// In the benchmark `chain`, fly in N places that the seeds draw instead, beside an oracle; --out
    /// keeps the scenario of each that fails
    #[arg(long, value_name = "N", allow_negative_numbers = true,
        conflicts_with_all = ["ablation", "scenario", "runs", "radio"])]
    drawn: Option<usize>,
    /// With --drawn, print a line for each mission, and keep the scenario of each
    #[arg(long, requires = "drawn")]
    each: bool,
    /// In the benchmark `placement`, measure what readings gain that a robot gathers around its goal, in
    /// each motion pattern, before it drops a relay
    #[arg(long)]
    gather: bool,
    /// Explore by this rule only in the benchmark `explore`; may be given more than once
    #[arg(long, value_name = "NAME", conflicts_with = "ablation")]
    rule: Vec<String>,
    /// Explore with so many robots only in the benchmark `explore`; may be given more than once
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    robots: Vec<usize>,
    /// In the benchmark `explore`, measure how long a leader's round takes with up to 64 robots instead
    #[arg(long, conflicts_with_all = ["ablation", "rule", "robots", "map", "runs", "sensor", "drift", "network"])]
    scale: bool,
    /// By which sensor the robots of the benchmark `explore` map; where left out, by a camera
    #[arg(long, value_enum)]
    sensor: Option<SensorArg>,
    /// How packets come from robot to robot in the benchmark `explore`; where left out, in a mesh
    #[arg(long, value_enum)]
    network: Option<NetworkArg>,
    /// In the benchmark `explore`, let the robots' positions drift as those by optic flow do
    #[arg(long)]
    drift: bool,
    /// Fly the benchmark `chain` through this radio in place of the scenarios' own
    #[arg(long, value_parser = PossibleValuesParser::new(PRESETS.map(|preset| preset.name)))]
    radio: Option<String>,
    /// How closely the drones of the benchmarks `chain` and `junctions` are simulated; where left out,
    /// as points, and in `junctions` as points and as rigid bodies
    #[arg(long, value_enum)]
    fidelity: Option<FidelityArg>,
    /// In the benchmark `placement`, also put relays down in this map; in `explore`, explore it in place
    /// of the built-in plans; may be given more than once
    #[arg(long, value_name = "FILE")]
    map: Vec<PathBuf>,
    /// The firmware's ELF file, for the benchmarks that measure it
    #[arg(long, value_name = "FILE", default_value = Firmware::DEFAULT)]
    pub(super) elf: PathBuf,
    /// A Python that has cflib, by which the benchmark `stock` flies a second time
    #[arg(long, value_name = "FILE")]
    pub(super) python: Option<PathBuf>,
    #[command(flatten)]
    pub(super) common: Common,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Name {
    /// How well the chain holds, grows, heals and comes home under each movement policy
    Chain,
    /// How fast the simulator is
    Throughput,
    /// What a simulated drone does when a sensor, a motor or the battery fails
    Faults,
    /// Whether the errors of the state estimator are as large as it claims
    Estimator,
    /// How fast orders and telemetry get through a chain, and how many are lost
    Link,
    /// Whether every relay takes the branch that the pilot chose, and a misled one comes back
    Junctions,
    /// How fast several robots explore a place together, by each rule
    Explore,
    /// Which packets of an attacker without keys a chain accepts
    Attacks,
    /// How much relays cover that are put down for good, by each rule
    Placement,
    /// Whether swarms by virtual forces keep clear and connected, and how fast they are
    Forces,
    /// How much of the processor and the memory the firmware uses, on the emulated chip
    Firmware,
    /// How fast the emulator is, and whether it computes what another emulator does
    Emulator,
    /// What the firmware does when its chip, its buses or its code fail, in the emulator
    Mishaps,
    /// How far the vendor's own firmware flies the emulated drone; --elf names its cf2.elf
    Stock,
}

impl Name {
    /// The benchmarks that this build has.
    fn all() -> Vec<Self> {
        let elf = [Self::Firmware, Self::Emulator, Self::Mishaps];
        let all = Self::value_variants().iter().copied();
        // The vendor's firmware is another file than the one of the other benchmarks.
        all.filter(|name| *name != Self::Stock)
            .filter(|name| emulated::PRESENT || !elf.contains(name))
            .collect()
    }

    const fn file(self) -> &'static str {
        match self {
            Self::Chain => "chain.json",
            Self::Throughput => "throughput.json",
            Self::Faults => "faults.json",
            Self::Estimator => "estimator.json",
            Self::Link => "link.json",
            Self::Junctions => "junctions.json",
            Self::Explore => "explore.json",
            Self::Attacks => "attacks.json",
            Self::Placement => "placement.json",
            Self::Forces => "forces.json",
            Self::Firmware => "firmware.json",
            Self::Emulator => "emulator.json",
            Self::Mishaps => "mishaps.json",
            Self::Stock => "stock.json",
        }
    }
}

pub(super) fn run(args: &BenchArgs) -> Result<Verdict, Trouble> {
    let names = args.name.map_or_else(Name::all, |name| vec![name]);
    interrupt::ends();
    let mut folder = args.common.folder()?;
    let mut values = Vec::new();
    let mut tables = String::new();
    let mut missed = Vec::new();
    for name in &names {
        let (table, value) = match (name, args.drawn) {
            (Name::Chain, Some(places)) => drawn::bench(args, places, folder.as_mut())?,
            (Name::Chain, None) => chain::bench(args)?,
            (Name::Throughput, _) => throughput_bench(args)?,
            (Name::Faults, _) => faults_bench(args)?,
            (Name::Estimator, _) => estimator_bench(args)?,
            (Name::Link, _) => link_bench(args, &mut missed)?,
            (Name::Junctions, _) => junctions_bench(args, &mut missed)?,
            (Name::Explore, _) => explore::bench(args, &mut missed)?,
            (Name::Attacks, _) => attacks_bench(args, &mut missed)?,
            (Name::Placement, _) => placement::bench(args, &mut missed)?,
            (Name::Forces, _) => forces::bench(args, &mut missed)?,
            (Name::Firmware, _) => emulated::firmware(args, &mut missed)?,
            (Name::Emulator, _) => emulated::emulator(args, &mut missed)?,
            (Name::Mishaps, _) => emulated::mishaps(args, &mut missed)?,
            (Name::Stock, _) => emulated::stock(args, &mut missed)?,
        };
        tables.push_str(&table);
        values.push(value);
    }
    let summary = match values.as_slice() {
        [one] => one.clone(),
        // Without a name: an object with one entry for each benchmark.
        many => names
            .iter()
            .zip(many)
            .map(|(name, value)| (name.file().trim_end_matches(".json").to_owned(), value.clone()))
            .collect(),
    };
    if let Some(folder) = &mut folder {
        for (name, value) in names.iter().zip(&values) {
            folder.put_json(name.file(), value)?;
        }
    }
    args.common.finish(folder, &tables, &summary)?;
    for what in &missed {
        complain(what);
    }
    Ok(if missed.is_empty() { Verdict::Good } else { Verdict::Failed })
}

fn throughput_bench(args: &BenchArgs) -> Result<(String, Value), Trouble> {
    let progress = Progress::busy("throughput", args.common.quiet);
    let count = runs(args.runs.unwrap_or(200))?;
    let rows = throughput::run(count)?;
    let steps = throughput::steps()?;
    let mut table = format!("throughput: {}, point level by link\n\n", throughput::SCENARIO);
    let mut value = Vec::new();
    for row in &rows {
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
        value.push(json!({
            "scenario": throughput::SCENARIO,
            "fidelity": "point",
            "link": row.link.name(),
            "threads": row.threads,
            "drone_rounds_per_s": row.drone_rounds_per_s.round(),
            "scaling": row.scaling,
            "aim_one_core": row.aim,
        }));
    }
    for (rate, what, aim) in [
        (steps.flight, "drone-steps/s at flight level", throughput::FLIGHT_AIM),
        (steps.rigid, "steps/s of the rigid body alone", throughput::RIGID_AIM),
    ] {
        let _ = writeln!(table, "  {:6} 1 threads {rate:>12.0} {what}; aim {aim:.0}", "");
    }
    table.push_str("\n  the time of one thread at point level, by part\n");
    let mut profiles = Vec::new();
    for (link, _) in throughput::LINKS {
        let shares = throughput::profile(link, count.min(PROFILED))?;
        let _ = write!(table, "  {:6}", link.name());
        for (part, share) in &shares {
            let _ = write!(table, " {} {:.0} %,", part.name(), 100.0 * share);
        }
        table.truncate(table.len() - 1);
        table.push('\n');
        let shares: Map<_, _> =
            shares.iter().map(|(part, share)| (part.name().to_owned(), json!(share))).collect();
        profiles.push(json!({
            "scenario": throughput::SCENARIO,
            "fidelity": "point",
            "link": link.name(),
            "shares": shares,
        }));
    }
    drop(progress);
    value.push(json!({
        "scenario": throughput::SCENARIO,
        "fidelity": "flight",
        "threads": 1,
        "drone_steps_per_s": steps.flight.round(),
        "aim_one_core": throughput::FLIGHT_AIM,
    }));
    value.push(json!({
        "what": "rigid body alone",
        "threads": 1,
        "steps_per_s": steps.rigid.round(),
        "aim_one_core": throughput::RIGID_AIM,
    }));
    value.extend(profiles);
    Ok((table, Value::Array(value)))
}

fn faults_bench(args: &BenchArgs) -> Result<(String, Value), Trouble> {
    let count = runs(args.runs.unwrap_or(100))?;
    let wanted = |case: &faults::Case| case.name.contains(&args.only);
    let total = faults::cases().iter().filter(|case| wanted(case)).count() * count;
    if total == 0 {
        let wrong = format!("no fault has \"{}\" in its name", args.only);
        let remedy = "leave --only out to see all their names";
        return Err(InputError::new(wrong, remedy).into());
    }
    let progress = Progress::new(total as u64, args.common.quiet);
    progress.say("flights");
    let rows = faults::run(count, args.common.seed, wanted, || progress.step())?;
    drop(progress);
    let mut table = format!(
        "faults: {count} flights a row; a safe landing is slower than {} m/s\n\n  {:6} {:30} \
         {:>8} {:>6} {:>12} {:>6} {:>6} {:>6}  causes\n",
        faults::SAFE_IMPACT,
        "place",
        "fault",
        "survived",
        "landed",
        "uncontrolled",
        "walls",
        "m/s",
        "tilt",
    );
    for row in &rows {
        let causes: Vec<_> =
            row.causes.iter().map(|(name, count)| format!("{count} {name}")).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:6} {:30} {:>8} {:>6} {:>12} {:>6} {:>6.2} {:>6.0}  {}",
            row.place.name(),
            row.fault,
            row.survived,
            row.landed_safely,
            row.uncontrolled,
            row.wall_contacts,
            row.max_impact_mps,
            row.max_tilt_deg,
            causes.join(", ")
        );
    }
    Ok((table, rows.iter().map(faults::Row::json).collect()))
}

fn estimator_bench(args: &BenchArgs) -> Result<(String, Value), Trouble> {
    let count = runs(args.runs.unwrap_or(1_000))?;
    let progress = Progress::new(count as u64, args.common.quiet);
    progress.say("flights");
    let report = estimator::run(count, args.common.seed, || progress.step());
    drop(progress);
    let mut table = format!("estimator: {count} flights of 10 s\n\n");
    for s in &report.sensors {
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:8} mean NIS {:.3} (of {} {:.3} to {:.3}); {:.1} % of instants within, {:.1} % of \
             readings below the 95 % quantile; {} rejected, {} unusable of {}",
            s.sensor,
            s.mean_nis,
            s.degrees,
            s.interval.0,
            s.interval.1,
            100.0 * s.instants_within,
            100.0 * s.below_95,
            s.rejected,
            s.unusable,
            s.readings + s.unusable,
        );
    }
    let _ = writeln!(
        table,
        "  errors   velocity {:.4} m/s, height {:.4} m, tilt {:.3}°",
        report.velocity_mps, report.height_m, report.tilt_deg
    );
    Ok((table, report.json()))
}

/// Aims that were not reached are added to `missed`.
fn link_bench(args: &BenchArgs, missed: &mut Vec<String>) -> Result<(String, Value), Trouble> {
    let count = runs(args.runs.unwrap_or(10))?;
    let total = link::count() * count;
    let progress = Progress::new(total as u64, args.common.quiet);
    progress.say("chains");
    let rows = link::run(count, args.common.seed, || progress.step());
    missed.extend(link::missed(&rows));
    drop(progress);
    let mut table = format!(
        "link: {count} times 60 s a row; aim: 95 of 100 orders through {} hops at 20 % loss within \
         {} s\n\n  {:>6} {:>5} {:>7} {:>5} {:>10} {:>10} {:>9} {:>12} {:>7} {:>6}\n",
        link::AIM_HOPS,
        link::AIM_S,
        "drones",
        "loss",
        "polls/s",
        "fades",
        "offered/s",
        "delivered",
        "pilot, s",
        "telemetry, s",
        "stop, s",
        "air",
    );
    let seconds = |value: Option<f32>| {
        value.map_or_else(|| "never".to_owned(), |value| format!("{value:.3}"))
    };
    for row in &rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:>6} {:>5.2} {:>7} {:>5} {:>10.1} {:>10.3} {:>9} {:>12} {:>7} {:>6.3}",
            row.drones,
            row.loss,
            row.polls_per_s,
            if row.fades { "yes" } else { "no" },
            row.offered_per_s,
            row.delivered,
            seconds(row.pilot_delay_p95_s),
            seconds(row.telemetry_delay_p95_s),
            seconds(row.stop_p95_s),
            row.air_time_fraction,
        );
    }
    let _ = writeln!(table, "\n  aims with {} drones, 95th percentiles", link::LONGEST);
    for aim in &link::AIMS {
        let at = |polls| seconds(aim.measured(&rows, polls));
        let (often, seldom) = (at(link::POLLS_PER_S), at(link::POLLS_PER_S_LIMITED));
        let link::Aim { figure, loss, aim_s, .. } = aim;
        let _ = writeln!(
            table,
            "  {figure:12} at {loss:.2} {often:>7} s, and {seldom:>7} s at {} polls a second; aim \
             {aim_s} s",
            link::POLLS_PER_S_LIMITED,
        );
    }
    Ok((table, rows.iter().map(link::Row::json).collect()))
}

/// Cases in which too few missions were right are added to `missed`.
fn junctions_bench(args: &BenchArgs, missed: &mut Vec<String>) -> Result<(String, Value), Trouble> {
    let levels = match args.fidelity {
        Some(fidelity) => vec![fidelity.fidelity()?],
        None => vec![Fidelity::Point, Fidelity::Flight],
    };
    let seeds = |level| args.runs.unwrap_or(if level == Fidelity::Point { 100 } else { 20 });
    let cases = junctions::cases_of(&args.scenario)?;
    let mut count = 0;
    for level in &levels {
        count += runs(seeds(*level))? * cases.len();
    }
    let progress = Progress::new(count as u64, args.common.quiet);
    progress.say("missions");
    let mut rows = Vec::new();
    for level in levels {
        let step = || progress.step();
        rows.extend(junctions::run(&cases, level, seeds(level), args.common.seed, step)?);
    }
    drop(progress);
    missed.extend(rows.iter().filter_map(junctions::Row::missed));
    let mut table = format!(
        "junctions: at least {} of all missions right\n\n  {:14} {:8} {:>5} {:>5} {:>7} {:>6} {:>8} \
         {:>8}  wrong\n",
        junctions::BOUND,
        "scenario",
        "fidelity",
        "seeds",
        "right",
        "arrived",
        "misled",
        "returned",
        "troubled",
    );
    for row in &rows {
        let wrong: Vec<_> = row.wrong.iter().map(u64::to_string).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:14} {:8} {:>5} {:>5} {:>7} {:>6} {:>8} {:>8}  {}",
            row.scenario,
            row.fidelity.name(),
            row.seeds,
            row.right,
            row.arrived,
            row.misled,
            row.misled_returned,
            row.troubled.len(),
            wrong.join(" ")
        );
    }
    Ok((table, rows.iter().map(junctions::Row::json).collect()))
}

/// Packets that a drone should have refused are added to `missed`.
fn attacks_bench(args: &BenchArgs, missed: &mut Vec<String>) -> Result<(String, Value), Trouble> {
    let count = runs(args.runs.unwrap_or(10))?;
    let total = (attacks::COUNT + sieges::COUNT) * count;
    let progress = Progress::new(total as u64, args.common.quiet);
    progress.say("missions");
    let rows = attacks::run(count, args.common.seed, || progress.step())?;
    missed.extend(attacks::missed(&rows));
    let besieged = sieges::run(count, args.common.seed, || progress.step())?;
    drop(progress);
    let mut table = format!(
        "attacks: {}, flight level, {count} missions a row\n\n  {:40} {:>8} {:>8} {:>5} {:>5}  \
         effect\n",
        attacks::SCENARIO,
        "attack",
        "packets",
        "accepted",
        "dB",
        "m",
    );
    for row in &rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "  {:40} {:>8} {:>8} {:>5.1} {:>5.1}  {}",
            row.attack, row.packets, row.accepted, row.link_error_db, row.displaced_m, row.effect
        );
    }
    let _ = writeln!(
        table,
        "\nsieges: {}, point level, {count} missions a row\n\n  {:76} {:>8} {:>5} {:>12} {:>11} {:>13} \
         {:>6} {:>5} {:>7}",
        sieges::SCENARIO,
        "siege",
        "accepted",
        "dB",
        "m",
        "missed, s",
        "weakest, dBm",
        "holds",
        "home",
        "touches",
    );
    for row in &besieged {
        let [moved, most] = row.displaced_m;
        let [deaf, deafest] = row.deaf_s;
        let [weak, weakest] = row.weakest_dbm;
        let _ = writeln!(
            table,
            "  {:76} {:>8} {:>5.1} {moved:>5.1} {most:>6.1} {deaf:>5.1} {deafest:>5.1} {weak:>6.1} {weakest:>6.1} \
             {:>6} {:>5} {:>7}",
            row.siege, row.accepted, row.link_error_db, row.holds, row.home, row.touches,
        );
    }
    let rows: Vec<Value> = rows.iter().map(attacks::Row::json).collect();
    let besieged: Vec<Value> = besieged.iter().map(sieges::Row::json).collect();
    Ok((table, json!({ "attacks": rows, "sieges": besieged })))
}
