//! `uchain run`: one mission.

use std::fmt::Write;

use agent::{LandReason, State};
use clap::Args;
use serde_json::{Value, json};
use units::{Order, Role};

use super::emulated::{Aftermath, Fleet};
use super::progress::Progress;
use super::{
    Common, FidelityArg, Trouble, Verdict, VirtualArgs, builtin_scenarios, complain, interrupt,
    scenario,
};
use crate::craft::record::FlightMetrics;
use crate::input_error::InputError;
use crate::metrics::{HoldMetrics, Reference, RunMetrics, Watch};
use crate::mission::{Mission, ROUND_US, RadioMetrics, World};
use crate::output;
use crate::scenario::{Fidelity, Scenario, builtin};
use crate::trace::{Node, Trace};

#[derive(Args)]
#[command(after_help = builtin_scenarios())]
pub(super) struct RunArgs {
    /// Name of a built-in scenario (listed below), or a scenario file
    #[arg(default_value = builtin::DEMONSTRATION)]
    scenario: String,
    /// Movement policy, instead of the scenario's: t0, t5, k, authors or default
    #[arg(long, value_name = "NAME")]
    policy: Option<String>,
    /// How closely the drones are simulated
    #[arg(long, value_enum)]
    fidelity: Option<FidelityArg>,
    /// The former option for virtual drones, refused with a line that names the present one
    #[arg(long, hide = true, value_name = "NAME")]
    vehicle: Option<String>,
    #[command(flatten)]
    emulated: VirtualArgs,
    /// Port at which GDB connects to a virtual drone: the first one, or number NODE. The mission
    /// waits for GDB
    #[arg(long, value_name = "[NODE:]PORT")]
    gdb: Option<String>,
    /// Print the log messages of virtual drones on standard error
    #[arg(long)]
    log: bool,
    /// Print the file of the built-in scenario, as a start for your own, and fly nothing
    #[arg(long)]
    show: bool,
    #[command(flatten)]
    common: Common,
}

impl RunArgs {
    /// The virtual drones of the mission, if it has any.
    fn fleet(&self, scenario: &Scenario) -> Result<Option<Fleet>, InputError> {
        if scenario.fidelity == Fidelity::Virtual {
            let gdb = self.gdb.as_deref();
            return Fleet::of(&self.emulated, gdb, self.log, scenario).map(Some);
        }
        if self.emulated.are_given() || self.gdb.is_some() || self.log {
            let wrong = "--elf, --gdb, --log and --virtual-drones are for virtual drones";
            return Err(InputError::new(wrong, "add --fidelity virtual"));
        }
        Ok(None)
    }
}

pub(super) fn run(args: &RunArgs) -> Result<Verdict, Trouble> {
    if args.show {
        return show(&args.scenario);
    }
    if args.vehicle.is_some() {
        let wrong = "--vehicle is now a part of --fidelity";
        return Err(InputError::new(wrong, "give --fidelity virtual, or flight").into());
    }
    let scenario = scenario(&args.scenario, args.policy.as_deref(), args.fidelity)?;
    let fleet = args.fleet(&scenario)?;
    interrupt::ends();
    let mut folder = args.common.folder()?;
    let seed = args.common.seed;
    let (trace, metrics, aftermath) = fly(&scenario, seed, args.common.quiet, fleet.as_ref())?;
    let mut failures = failures(&scenario, &trace, &metrics);
    failures.extend(aftermath.failures());
    let mut summary = summary(&scenario, seed, &trace, &metrics, &failures);
    if let (Some(summary), false) = (summary.as_object_mut(), aftermath.is_empty()) {
        summary.insert("virtual".into(), aftermath.json());
    }
    if let Some(folder) = &mut folder {
        output::write_all(folder, &trace, &summary)?;
        aftermath.write(folder)?;
    }
    let table = table(&scenario, seed, &trace, &metrics, &failures) + &aftermath.table();
    args.common.finish(folder, &table, &summary)?;
    // The table has them already.
    for failure in failures.iter().filter(|_| !args.common.prints_table()) {
        complain(format_args!("{}, seed {seed}: {failure}", scenario.name));
    }
    Ok(if failures.is_empty() { Verdict::Good } else { Verdict::Failed })
}

fn show(name: &str) -> Result<Verdict, Trouble> {
    if let Some(text) = builtin::text(name) {
        super::put(text)?;
        return Ok(Verdict::Good);
    }
    // Says which names there are.
    Scenario::open(name)?;
    Err(InputError::new(
        format!("\"{name}\" is not a built-in scenario"),
        "--show prints built-in ones",
    )
    .into())
}

/// Flies a mission with its record and its figures.
fn fly(
    scenario: &Scenario,
    seed: u64,
    quiet: bool,
    fleet: Option<&Fleet>,
) -> Result<(Trace, RunMetrics, Aftermath), InputError> {
    let world = World::of(scenario);
    let reference = Reference::of(scenario, &world);
    let progress = Progress::new(scenario.duration_us / ROUND_US, quiet);
    progress.say("rounds");
    let mut mission = match fleet {
        None => Mission::new(scenario, &world, seed),
        Some(fleet) => Mission::emulated(scenario, &world, seed, fleet.drones(scenario, seed)?),
    };
    let mut watch = Watch::new(scenario, &world, &reference);
    let mut trace = mission.begin_trace(seed);
    while !mission.is_over() {
        mission.round();
        watch.look(&mission);
        trace.frames.push(mission.frame());
        if let Some(fleet) = fleet {
            fleet.say(&mut mission, |line| progress.aside(line));
        }
        progress.step();
    }
    let metrics = watch.verdict(&mission);
    Ok((trace, metrics, Aftermath::of(&mission)))
}

/// The reasons why the mission failed; empty for one that succeeded.
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
    for criterion in criteria(scenario, metrics).iter().filter(|criterion| !criterion.met()) {
        failures.push(criterion.complaint());
    }
    for (node, state) in last_states(trace) {
        let called_home = matches!(ordered, Some(Order::Return | Order::Land));
        let lost = match state {
            state if called_home && state.is_airborne() => {
                Some("still flew when the mission ended, although it was ordered down")
            }
            State::Landing { why, .. } | State::Landed { why } => match why {
                LandReason::LinkLost => Some("landed because it lost the base"),
                LandReason::TakeOffFailed => Some("landed because it never reached its height"),
                LandReason::Unfit(_) => Some("was brought down by a fault"),
                LandReason::Restarted => Some("restarted by itself and stays down"),
                LandReason::Ordered | LandReason::Home => None,
            },
            State::Reconnecting { .. } => Some("heard no drone in front at the end"),
            _ => None,
        };
        if let Some(what) = lost {
            failures.push(format!("{} {what}", named(node)));
        }
    }
    failures
}

/// A bound that the scenario sets, and the value that the mission reached.
struct Criterion {
    name: &'static str,
    /// The texts before and after the value.
    words: [&'static str; 2],
    /// Whether the bound is the most, and not the least.
    most: bool,
    bound: f32,
    value: f32,
}

impl Criterion {
    /// NaN meets no bound.
    fn met(&self) -> bool {
        if self.most { self.value <= self.bound } else { self.value >= self.bound }
    }

    /// The value that was found, and the bound.
    fn complaint(&self) -> String {
        let which = if self.most { "most" } else { "least" };
        let [before, after] = self.words;
        let found = match self.value.is_nan() {
            true => format!("{} could not be measured", self.name),
            false => format!("{before} {}{after}", self.value),
        };
        format!("{found}; at {which} {} asked", self.bound)
    }

    fn json(&self) -> Value {
        let which = if self.most { "most" } else { "least" };
        json!({ which: number(self.bound), "value": number(self.value), "met": self.met() })
    }
}

fn criteria(scenario: &Scenario, metrics: &RunMetrics) -> Vec<Criterion> {
    let asked = &scenario.criteria;
    let tilt = metrics.flight.as_ref().map(|flight| flight.max_tilt_deg);
    // A point does not tilt.
    let tilt_asked = asked.tilt_deg.filter(|_| tilt.is_some());
    let rows = [
        (
            "hold_spread_db",
            ["at the end of the hold the links differed by", " dB"],
            true,
            asked.hold_spread_db,
            metrics.held(|hold| hold.spread_db),
        ),
        (
            "swing_p95_db",
            ["at the end of the hold the links swung by", " dB"],
            true,
            asked.swing_p95_db,
            metrics.held(|hold| hold.swing_p95_db),
        ),
        ("max_tilt_deg", ["a drone tilted to", "°"], true, tilt_asked, tilt.unwrap_or(f32::NAN)),
        (
            "launched",
            ["launched", " relays"],
            false,
            asked.launched.map(|n| n as f32),
            metrics.launched,
        ),
    ];
    rows.into_iter()
        .filter_map(|(name, words, most, bound, value)| {
            Some(Criterion { name, words, most, bound: bound?, value })
        })
        .collect()
}

fn last_states(trace: &Trace) -> impl Iterator<Item = (Node, State)> {
    let last = trace.frames.last().into_iter().flat_map(|frame| &frame.drones);
    trace.nodes.iter().zip(last).map(|(node, drone)| (*node, drone.state))
}

/// A drone as people call it: `head`, `relay 2`, `base`.
pub(super) fn named(node: Node) -> String {
    match node.role {
        Role::Head => "head".to_owned(),
        Role::Relay => format!("relay {}", node.id.0),
        Role::Base => "base".to_owned(),
    }
}

fn summary(
    scenario: &Scenario,
    seed: u64,
    trace: &Trace,
    metrics: &RunMetrics,
    failures: &[String],
) -> Value {
    let drones: Vec<_> = last_states(trace)
        .map(|(node, state)| json!({ "id": node.id.0, "state": state.name() }))
        .collect();
    let criteria: serde_json::Map<_, _> = criteria(scenario, metrics)
        .iter()
        .map(|criterion| (criterion.name.to_owned(), criterion.json()))
        .collect();
    let mut summary = json!({
        "scenario": scenario.name,
        "title": scenario.title,
        "seed": seed,
        "version": env!("CARGO_PKG_VERSION"),
        "fidelity": scenario.fidelity.name(),
        "policy": scenario.policy,
        "duration_s": scenario.duration_s(),
        "success": failures.is_empty(),
        "failures": failures,
        "metrics": metrics_json(metrics),
        "radio": radio_json(&metrics.radio),
        "drones": drones,
    });
    if let Some(summary) = summary.as_object_mut() {
        if !criteria.is_empty() {
            summary.insert("criteria".into(), Value::Object(criteria));
        }
        if let Some(flight) = &metrics.flight {
            summary.insert("flight".into(), flight_json(flight));
        }
    }
    summary
}

/// The figures of the radio.
fn radio_json(radio: &RadioMetrics) -> Value {
    let packets = &radio.packets;
    json!({
        "sealed": radio.sealed,
        "air_time": number(radio.air_time),
        "packets_sent": packets.sent,
        "packets_heard": packets.heard,
        "packets_lost": {
            "weak": packets.weak,
            "chance": packets.chance,
            "collision": packets.collisions,
            "deaf": packets.deaf,
            "cut": packets.cut,
        },
        "orders_heard": radio.orders,
        "pilot_delay_p50_s": number(radio.pilot_delay_p50_s),
        "pilot_delay_p95_s": number(radio.pilot_delay_p95_s),
    })
}

/// The figures of the flights.
fn flight_json(flight: &FlightMetrics) -> Value {
    let ends: serde_json::Map<_, _> =
        flight.ends().map(|(name, count)| (name.to_owned(), json!(count))).collect();
    json!({
        "max_tilt_deg": number(flight.max_tilt_deg),
        "max_rate_dps": number(flight.max_rate_dps),
        "velocity_error_mps": number(flight.velocity_error_mps),
        "min_battery_v": number(flight.min_battery_v),
        "take_offs": flight.take_offs,
        "landings": flight.landings,
        "ends": ends,
    })
}

/// Converts through text, so that 0.1 stays 0.1 and does not become the double nearest to a float;
/// a value that is not finite is `null`.
fn number(value: f32) -> Value {
    if !value.is_finite() {
        return Value::Null;
    }
    serde_json::from_str(&format!("{value}")).unwrap_or(Value::Null)
}

/// Every metric by name; `null` for one that was never reached or does not apply.
pub(super) fn metrics_json(m: &RunMetrics) -> Value {
    let held = |of: fn(&HoldMetrics) -> f32| number(m.held(of));
    json!({
        "hold_from_s": held(|hold| hold.from_s),
        "hold_until_s": held(|hold| hold.until_s),
        "no_hold": m.hold.as_ref().err().map(ToString::to_string),
        "t3_s": held(|hold| hold.t3_s),
        "t1_s": held(|hold| hold.t1_s),
        "t_gap1_s": held(|hold| hold.t_gap1_s),
        "gap_db": held(|hold| hold.gap_db),
        "difference_db": held(|hold| hold.difference_db),
        "hold_spread_db": held(|hold| hold.spread_db),
        "swing_p95_db": held(|hold| hold.swing_p95_db),
        "position_sd_m": held(|hold| hold.position_sd_m),
        "path_m": held(|hold| hold.path_m),
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

fn table(
    scenario: &Scenario,
    seed: u64,
    trace: &Trace,
    m: &RunMetrics,
    failures: &[String],
) -> String {
    let mut text = match failures {
        [] => "success\n".to_owned(),
        failures => failures.iter().map(|failure| format!("failure: {failure}\n")).collect(),
    };
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
            "  relays flown          {} ({} in an optimal chain)",
            m.launched, m.needed
        );
    }
    hold_lines(&mut text, m);
    if m.violation.is_finite() {
        let _ = writeln!(text, "  link below limit      {:.1} % of the time", 100.0 * m.violation);
    }
    let _ = writeln!(
        text,
        "  touches               {} of walls, {} of drones",
        m.wall_contacts, m.drone_contacts
    );
    if let Some(flight) = &m.flight {
        let _ = writeln!(
            text,
            "  flight                {} take-offs, {} landings; tilt to {:.0}°, velocity known to \
             {:.3} m/s, battery down to {:.2} V",
            flight.take_offs,
            flight.landings,
            flight.max_tilt_deg,
            flight.velocity_error_mps,
            flight.min_battery_v
        );
    }
    let states: Vec<_> = last_states(trace)
        .map(|(node, state)| format!("{} {}", named(node), state.name()))
        .collect();
    let _ = writeln!(text, "  at the end            {}", states.join(", "));
    text
}

/// The lines about the hold.
fn hold_lines(text: &mut String, m: &RunMetrics) {
    let hold = match &m.hold {
        Ok(hold) => hold,
        Err(why) => {
            let _ = writeln!(text, "  hold                  n/a: {why}");
            return;
        }
    };
    let _ = writeln!(text, "  hold                  {:.0} s to {:.0} s", hold.from_s, hold.until_s);
    let _ = match hold.t3_s.is_finite() {
        true => writeln!(text, "  links within 3 dB     from {:.1} s of the hold on", hold.t3_s),
        false => writeln!(text, "  links                 never stayed within 3 dB"),
    };
    let _ = writeln!(text, "  end of the hold       links differ by {:.2} dB,", hold.difference_db);
    let _ = writeln!(
        text,
        "                        the weakest is {:.2} dB below the optimum,",
        hold.gap_db
    );
    let _ = writeln!(
        text,
        "                        95 % swing by less than {:.2} dB",
        hold.swing_p95_db
    );
}
