//! `uchain run`: one mission.

use std::fmt::Write;

use agent::{LandReason, State};
use chain::report::Task;
use clap::{Args, ValueEnum};
use serde_json::{Value, json};

use super::progress::Progress;
use super::{Common, Trouble, Verdict, scenario};
use crate::metrics::{Reference, RunMetrics, Watch};
use crate::mission::{Mission, ROUND_US, World};
use crate::output;
use crate::scenario::{Scenario, builtin};
use crate::trace::Trace;

#[derive(Args)]
pub(super) struct RunArgs {
    /// A built-in scenario's name or a scenario file
    #[arg(default_value = builtin::DEMONSTRATION)]
    scenario: String,
    /// Fly with this movement policy instead of the scenario's: t0, t5, k, authors or default
    #[arg(long, value_name = "NAME")]
    policy: Option<String>,
    /// How closely the vehicle is simulated
    #[arg(long, value_enum)]
    fidelity: Option<FidelityArg>,
    /// Print the built-in scenario's file, to begin one's own with, and fly nothing
    #[arg(long)]
    show: bool,
    #[command(flatten)]
    common: Common,
}

#[derive(Clone, Copy, ValueEnum)]
enum FidelityArg {
    /// A velocity-limited first-order point on the floor plan
    Policy,
}

pub(super) fn run(args: &RunArgs) -> Result<Verdict, Trouble> {
    if args.show {
        return show(&args.scenario);
    }
    // The one fidelity there is needs no choice; the option is checked by `clap`.
    let (None | Some(FidelityArg::Policy)) = args.fidelity;
    let scenario = scenario(&args.scenario, args.policy.as_deref())?;
    let seed = args.common.seed;
    let (trace, metrics) = fly(&scenario, seed, args.common.quiet);
    let failures = failures(&scenario, &trace, &metrics);
    let summary = summary(&scenario, seed, &trace, &metrics, &failures);
    args.common.print(&table(&scenario, seed, &trace, &metrics), &summary);
    for failure in &failures {
        eprintln!("uchain: {}, seed {seed}: {failure}", scenario.name);
    }
    if let Some(dir) = &args.common.out {
        args.common.wrote(&output::write_all(dir, &trace, &summary)?);
    }
    Ok(if failures.is_empty() { Verdict::Good } else { Verdict::Failed })
}

fn show(name: &str) -> Result<Verdict, Trouble> {
    if let Some(text) = builtin::text(name) {
        super::put(text);
        return Ok(Verdict::Good);
    }
    // Says which names there are.
    Scenario::open(name)?;
    Err(crate::input_error::InputError::new(
        format!("\"{name}\" is not a built-in scenario"),
        "--show prints built-in ones",
    )
    .into())
}

/// Flies a mission with its record and its figures.
pub(super) fn fly(scenario: &Scenario, seed: u64, quiet: bool) -> (Trace, RunMetrics) {
    let world = World::of(scenario);
    let reference = Reference::of(scenario, &world);
    let progress = Progress::new(scenario.duration_us / ROUND_US, quiet);
    progress.say("rounds");
    let mut mission = Mission::new(scenario, &world, seed);
    let mut watch = Watch::new(scenario, &world, &reference);
    let mut trace = mission.begin_trace(seed);
    while !mission.is_over() {
        mission.round();
        watch.look(&mission);
        trace.frames.push(mission.frame());
        progress.step();
    }
    (trace, watch.verdict(&mission))
}

/// What went wrong, in words; nothing for a mission that succeeded.
fn failures(scenario: &Scenario, trace: &Trace, metrics: &RunMetrics) -> Vec<String> {
    let ordered = scenario.pilot.last().map(|step| step.task);
    let mut failures = Vec::new();
    let mut count = |n: u32, what: &str| {
        if n > 0 {
            failures.push(format!("{n} {what}"));
        }
    };
    count(metrics.wall_contacts, "touches of a wall");
    count(metrics.drone_contacts, "touches between drones");
    count(metrics.order_lost, "rounds in which the order of the chain was lost");
    for (node, state) in last_states(trace) {
        let called_home = matches!(ordered, Some(Task::Return | Task::Land));
        let lost = match state {
            state if called_home && state.is_airborne() => Some("was called down and still flies"),
            State::Landing { why, .. } | State::Landed { why } => match why {
                LandReason::LinkLost => Some("landed because it lost the base"),
                LandReason::TakeOffFailed => Some("landed because it never reached its height"),
                LandReason::Ordered | LandReason::Home => None,
            },
            State::Reconnecting { .. } => Some("hears nobody in front at the end"),
            _ => None,
        };
        if let Some(what) = lost {
            failures.push(format!("drone {node} {what}"));
        }
    }
    failures
}

fn last_states(trace: &Trace) -> impl Iterator<Item = (u8, State)> {
    let last = trace.frames.last().into_iter().flat_map(|frame| &frame.drones);
    trace.nodes.iter().zip(last).map(|(node, drone)| (node.id.0, drone.state))
}

fn summary(
    scenario: &Scenario,
    seed: u64,
    trace: &Trace,
    metrics: &RunMetrics,
    failures: &[String],
) -> Value {
    let drones: Vec<_> =
        last_states(trace).map(|(id, state)| json!({ "id": id, "state": state.name() })).collect();
    json!({
        "scenario": scenario.name,
        "title": scenario.title,
        "seed": seed,
        "version": env!("CARGO_PKG_VERSION"),
        "fidelity": "policy",
        "policy": scenario.policy,
        "duration_s": scenario.duration_s(),
        "success": failures.is_empty(),
        "failures": failures,
        "metrics": metrics_json(metrics),
        "drones": drones,
    })
}

/// Every metric by name; what never came or does not apply is `null`.
pub(super) fn metrics_json(m: &RunMetrics) -> Value {
    // Through text, so that 0.1 stays 0.1 and not the double nearest to a float.
    let number = |value: f32| -> Value {
        if !value.is_finite() {
            return Value::Null;
        }
        serde_json::from_str(&format!("{value}")).unwrap_or(Value::Null)
    };
    json!({
        "t3_s": number(m.t3_s),
        "t1_s": number(m.t1_s),
        "t_gap1_s": number(m.t_gap1_s),
        "gap_db": number(m.gap_db),
        "difference_db": number(m.difference_db),
        "position_sd_m": number(m.position_sd_m),
        "path_m": number(m.path_m),
        "bound_s": number(m.bound_s),
        "launched": number(m.launched),
        "needed": number(m.needed),
        "violation": number(m.violation),
        "peak_excess_db": number(m.peak_excess_db),
        "farthest_m": number(m.farthest_m),
        "order_lost": m.order_lost,
        "wall_contacts": m.wall_contacts,
        "drone_contacts": m.drone_contacts,
    })
}

fn table(scenario: &Scenario, seed: u64, trace: &Trace, m: &RunMetrics) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{}: {}", scenario.name, scenario.title);
    let _ = writeln!(
        text,
        "  {:.0} s, seed {seed}, policy {}, head reached {:.1} m\n",
        scenario.duration_s(),
        scenario.policy,
        m.farthest_m
    );
    if m.launched.is_finite() {
        let _ = writeln!(
            text,
            "  relays flown          {} ({} needed by the best chain)",
            m.launched, m.needed
        );
    }
    let _ = writeln!(text, "  links equal to 3 dB   {}", since(m.t3_s));
    let _ = writeln!(text, "  last minute: links differ by {:.2} dB at most,", m.difference_db);
    let _ = writeln!(text, "               weakest {:.2} dB below the best chain's", m.gap_db);
    if m.violation.is_finite() {
        let _ = writeln!(text, "  link below limit      {:.1} % of the time", 100.0 * m.violation);
    }
    let _ = writeln!(
        text,
        "  touches               {} of walls, {} of drones",
        m.wall_contacts, m.drone_contacts
    );
    let states: Vec<_> =
        last_states(trace).map(|(id, state)| format!("{id} {}", state.name())).collect();
    let _ = writeln!(text, "  at the end            {}", states.join(", "));
    text
}

fn since(time: f32) -> String {
    if time.is_finite() { format!("from {time:.1} s on") } else { "never for good".to_owned() }
}
