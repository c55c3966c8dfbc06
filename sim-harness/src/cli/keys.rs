//! `uchain keys`: the keys of a fleet.

use std::fmt::Write;
use std::path::PathBuf;

use chain::policy::{NAMES, Policy};
use clap::builder::PossibleValuesParser;
use clap::{Args, Subcommand, ValueEnum};
use fleet_keys::{Fleet, FleetEntry, Provisioned, Request};
use input::InputError;
use serde_json::{Value, json};
use storage::keys::PageMission;
use storage::settings::SwarmPlan;
use units::{Dbm, MissionKind, NodeId, Role};

use super::{Trouble, Verdict, put};
use scenario::Scenario;

/// The names of the missions.
const MISSIONS: [&str; 3] = ["chain", "swarm", "explore"];

#[derive(Args)]
pub(super) struct KeysArgs {
    #[command(subcommand)]
    verb: KeysVerb,
}

#[derive(Subcommand)]
enum KeysVerb {
    /// Make a key file with a new secret, from which all keys of the fleet follow
    New(NewArgs),
    /// Make the page of flash memory that gives one drone its number and its keys
    Provision(ProvisionArgs),
    /// Show what a key file holds, except the keys
    Show(ShowArgs),
    /// Begin the next generation of keys, which shuts out a drone that is lost or stolen
    Rekey(RekeyArgs),
}

#[derive(Args)]
struct NewArgs {
    /// The key file to make
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Number of the first generation of keys, 1 to 255
    #[arg(long, allow_negative_numbers = true, default_value_t = 1, value_name = "N")]
    generation: u8,
    #[command(flatten)]
    print: Print,
}

#[derive(Args)]
struct ProvisionArgs {
    /// The key file
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The drone's number, 0 to 15
    #[arg(long, allow_negative_numbers = true, value_name = "N")]
    node: u8,
    /// The drone's role; where left out, 0 is the head, 15 the base, and any other a relay
    #[arg(long, value_enum)]
    role: Option<RoleArg>,
    /// Let cfclient fly the head through this drone, which must be the base
    #[arg(long)]
    allow_cfclient: bool,
    /// The movement policy that the drone is to fly from now on; where left out, it keeps the one
    /// that it has
    #[arg(long, value_parser = PossibleValuesParser::new(NAMES), value_name = "NAME")]
    policy: Option<String>,
    /// The limits that the drone is to fly with from now on, in dBm; where left out, it keeps those
    /// that it has. All drones of a chain need the same
    #[arg(
        long,
        allow_hyphen_values = true,
        value_name = "LAUNCH,RETREAT",
        value_parser = limits
    )]
    limits: Option<[Dbm; 2]>,
    /// The mission that the drone is to fly from now on; where left out, it keeps the one that it has
    #[arg(long, value_parser = PossibleValuesParser::new(MISSIONS), value_name = "NAME")]
    mission: Option<String>,
    /// The scenario whose area, passage and number of drones are the plan of `--mission swarm`: the
    /// name of a built-in one, or a file
    #[arg(long, value_name = "SCENARIO")]
    plan: Option<String>,
    /// The drones are fetched after the mission: this one keeps no charge for its way home. All drones
    /// of a fleet need the same
    #[arg(long, requires = "mission")]
    fetched: bool,
    /// The file to write the page to
    #[arg(long, value_name = "FILE.bin")]
    out: PathBuf,
    #[command(flatten)]
    print: Print,
}

#[derive(Args)]
struct ShowArgs {
    /// The key file
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    print: Print,
}

#[derive(Args)]
struct RekeyArgs {
    /// The key file
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Number of a drone that gets no new keys; may be given several times
    #[arg(long, allow_negative_numbers = true, value_name = "N")]
    without: Vec<u8>,
    #[command(flatten)]
    print: Print,
}

/// Prints the result as it was asked for.
#[derive(Args)]
struct Print {
    /// Print nothing; errors still go to standard error
    #[arg(long)]
    quiet: bool,
    /// Print the result as one JSON value on standard output
    #[arg(long)]
    json: bool,
}

impl Print {
    fn print(&self, text: &str, value: &Value) -> Result<Verdict, Trouble> {
        if self.json {
            put(&format!("{value:#}\n"))?;
        } else if !self.quiet {
            put(text)?;
        }
        Ok(Verdict::Good)
    }
}

/// A drone's role in the chain.
#[derive(Clone, Copy, ValueEnum)]
enum RoleArg {
    /// The explorer at the far end of the chain
    Head,
    /// A drone between the head and the base
    Relay,
    /// The operator's end of the chain
    Base,
}

impl From<RoleArg> for Role {
    fn from(role: RoleArg) -> Self {
        match role {
            RoleArg::Head => Self::Head,
            RoleArg::Relay => Self::Relay,
            RoleArg::Base => Self::Base,
        }
    }
}

pub(super) fn run(args: &KeysArgs) -> Result<Verdict, Trouble> {
    match &args.verb {
        KeysVerb::New(args) => new(args),
        KeysVerb::Provision(args) => provision(args),
        KeysVerb::Show(args) => show(args),
        KeysVerb::Rekey(args) => rekey(args),
    }
}

fn new(args: &NewArgs) -> Result<Verdict, Trouble> {
    let fleet = fleet_keys::create(&args.file, args.generation)?;
    let text = format!(
        "fleet {}: generation {}, no drone yet\nwrote {}; keep it secret: with it anyone can fly the fleet\n",
        fleet.name(),
        fleet.generation(),
        args.file.display()
    );
    args.print.print(&text, &fleet_json(&fleet))
}

fn provision(args: &ProvisionArgs) -> Result<Verdict, Trouble> {
    let request = Request {
        node: NodeId(args.node),
        role: args.role.map(Role::from),
        may_fly: args.allow_cfclient,
        policy: args.policy.as_deref().and_then(Policy::named),
        limits: args.limits,
        mission: mission(args.mission.as_deref(), args.plan.as_deref(), args.fetched)?,
    };
    let made = fleet_keys::provision(&args.file, &request, &args.out)?;
    args.print.print(&provisioned_text(&made, args.limits), &provisioned_json(&made))
}

/// Reads two limits with a comma between them.
fn limits(text: &str) -> Result<[Dbm; 2], String> {
    let limit = |text: &str| text.trim().parse().ok().map(Dbm);
    let pair =
        text.split_once(',').and_then(|(launch, retreat)| Some([limit(launch)?, limit(retreat)?]));
    pair.ok_or_else(|| "give two numbers with a comma between them, such as -67,-72".to_owned())
}

/// The mission of this name, with the plan of a scenario, whose drones may be fetched after it.
fn mission(
    name: Option<&str>,
    plan: Option<&str>,
    fetched: bool,
) -> Result<Option<PageMission>, InputError> {
    match (name.and_then(MissionKind::named), plan) {
        (Some(MissionKind::Swarm), Some(plan)) => {
            let swarm = Some(swarm_plan(plan)?);
            Ok(Some(PageMission { kind: MissionKind::Swarm, swarm, fetched }))
        }
        (Some(MissionKind::Swarm), None) => Err(InputError::new(
            "--mission swarm needs a plan",
            "give --plan with a scenario of a swarm, such as swarm-c",
        )),
        (_, Some(_)) => Err(InputError::new(
            "--plan is for swarms alone",
            "leave it out, or give --mission swarm",
        )),
        (kind, None) => Ok(kind.map(|kind| PageMission { kind, swarm: None, fetched })),
    }
}

/// The plan of the swarm of a scenario.
fn swarm_plan(scenario: &str) -> Result<SwarmPlan, InputError> {
    let Scenario { mission, agent, .. } = Scenario::open(scenario)?;
    let refused =
        |what: String, mend| Err(InputError::new(format!("--plan {scenario}: {what}"), mend));
    if mission != MissionKind::Swarm {
        let other = mission.name();
        return refused(
            format!("its mission is {other}"),
            "give a scenario with mission = \"swarm\"",
        );
    }
    fleet_keys::stored_plan(&agent.swarm).map_or_else(
        || {
            refused(
                "no drone can store this plan".to_owned(),
                "leave out speed_mps, and give lengths in whole centimetres",
            )
        },
        Ok,
    )
}

fn mission_text(mission: &PageMission) -> String {
    let name = mission.kind.name();
    let fetched = if mission.fetched { ", fetched after it" } else { "" };
    let Some(SwarmPlan { drones, corner, area, entrance, width, direction, length, both }) =
        mission.swarm
    else {
        return format!("mission {name}{fetched}\n");
    };
    let both = if both { ", and the second area" } else { "" };
    format!(
        "mission {name}: {drones} drones, area {} m by {} m from ({}, {}) m, passage {} m wide at \
         ({}, {}) m, {} m long, at {:.0}°{both}{fetched}\n",
        area.0.0,
        area.1.0,
        corner.x,
        corner.y,
        width.0,
        entrance.x,
        entrance.y,
        length.0,
        direction.0.to_degrees(),
    )
}

fn provisioned_text(made: &Provisioned, limits: Option<[Dbm; 2]>) -> String {
    let FleetEntry { role, may_fly, generation, issue, policy } = made.drone;
    let policy = policy.map_or_else(String::new, |policy| format!(", policy {}", policy.name));
    let limits = limits.map_or_else(String::new, |[launch, retreat]| {
        format!("launch limit {} dBm, retreat limit {} dBm\n", launch.0, retreat.0)
    });
    let mission = made.mission.as_ref().map_or_else(String::new, mission_text);
    let [probe, usb] = made.commands();
    let cfclient = if may_fly { ", cfclient may fly the head through it" } else { "" };
    let replaces = if made.replaces {
        "If another drone had this number, keep that one switched off until it has keys of its \
         own.\n"
    } else {
        ""
    };
    format!(
        "fleet {}: node {}, {}, generation {generation}, issue {issue}{policy}{cfclient}\n{limits}{mission}\
         wrote {}; load it into one drone, once, by cable, and delete it\n\n\
         With a probe:\n  {probe}\n\
         By USB, the drone in DFU mode (battery unplugged; hold the button while you plug the cable \
         in, for\n5 s, until the blue light blinks once a second):\n  {usb}\n\
         Then switch it off and on, with its battery in: it stores its keys and wipes the page.\n{replaces}",
        made.fleet.name(),
        made.node.0,
        role.name(),
        made.page.display(),
    )
}

fn provisioned_json(made: &Provisioned) -> Value {
    let [probe, usb] = made.commands();
    let mut value = json!({ "fleet": made.fleet.name() });
    if let (Some(value), Value::Object(drone)) =
        (value.as_object_mut(), drone_json(&made.fleet, made.node.0, &made.drone))
    {
        value.extend(drone);
        value.insert("replaces".into(), json!(made.replaces));
        value.insert("mission".into(), json!(made.mission.map(|mission| mission.kind.name())));
        value.insert("fetched".into(), json!(made.mission.map(|mission| mission.fetched)));
        value.insert("page".into(), json!(made.page.display().to_string()));
        value.insert("load".into(), json!({ "probe": probe, "usb": usb }));
    }
    value
}

fn show(args: &ShowArgs) -> Result<Verdict, Trouble> {
    let fleet = fleet_keys::open(&args.file)?;
    args.print.print(&fleet_text(&fleet), &fleet_json(&fleet))
}

fn fleet_text(fleet: &Fleet) -> String {
    let mut text = format!(
        "fleet {}: generation {}, {} of {} issues given out\n",
        fleet.name(),
        fleet.generation(),
        fleet.issued(),
        fleet_keys::issues()
    );
    if fleet.drones().is_empty() {
        return text + "  no drone yet\n";
    }
    text += "  node  role   cfclient  generation  issue\n";
    for (node, drone) in fleet.drones() {
        let FleetEntry { role, may_fly, generation, issue, policy } = drone;
        let policy = policy.map_or_else(String::new, |policy| format!("  policy {}", policy.name));
        let may_fly = if *may_fly { "yes" } else { "no" };
        let stale = if *generation == fleet.generation() { "" } else { "  provision it anew" };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  {node:>4}  {:5}  {may_fly:8}  {generation:>10}  {:>5}{policy}{stale}",
            role.name(),
            issue.get()
        );
    }
    text
}

fn fleet_json(fleet: &Fleet) -> Value {
    let drones: Vec<_> =
        fleet.drones().iter().map(|(node, drone)| drone_json(fleet, *node, drone)).collect();
    json!({
        "fleet": fleet.name(),
        "generation": fleet.generation(),
        "issued": fleet.issued(),
        "issues": fleet_keys::issues(),
        "drones": drones,
    })
}

fn drone_json(fleet: &Fleet, node: u8, drone: &FleetEntry) -> Value {
    json!({
        "node": node,
        "role": drone.role.name(),
        "cfclient": drone.may_fly,
        "generation": drone.generation,
        "issue": drone.issue.get(),
        "policy": drone.policy.map(|policy| policy.name),
        "stale": drone.generation != fleet.generation(),
    })
}

fn rekey(args: &RekeyArgs) -> Result<Verdict, Trouble> {
    let without: Vec<_> = args.without.iter().copied().map(NodeId).collect();
    let fleet = fleet_keys::rekey(&args.file, &without)?;
    let stale: Vec<_> = fleet.stale().iter().map(u8::to_string).collect();
    let anew = if stale.is_empty() {
        "no drone has keys yet\n".to_owned()
    } else {
        format!(
            "provision anew: {}; drones with old keys and drones with new keys do not hear each other\n",
            stale.join(", ")
        )
    };
    let text = format!("fleet {}: generation {}\n{anew}", fleet.name(), fleet.generation());
    let mut value = fleet_json(&fleet);
    if let Some(value) = value.as_object_mut() {
        value.insert("provision_anew".into(), json!(fleet.stale()));
    }
    args.print.print(&text, &value)
}
