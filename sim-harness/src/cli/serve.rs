//! `uchain serve`: drones that cflib and cfclient connect to.

use std::fmt::Write as _;
use std::io::Write as _;
use std::net::Ipv4Addr;

use bridge::{FIRST_PORT, Ports};
use clap::Args;
use input::InputError;
use serde_json::{Value, json};
use units::{Duration, Instant};

use super::emulated::{Aftermath, Base, Fleet, stock};
use super::{
    Common, Trouble, Verdict, VirtualArgs, builtin_scenarios, complain, interrupt, scenario,
    with_link,
};
use measure::metrics::{Reference, RunMetrics};
use report::{Folder, Origin, TraceFiles, metrics_json};
use scenario::{Fidelity, Scenario, builtin};
use serve::{self, Event, Live, Tally};
use terminal::FidelityArg;

#[derive(Args)]
#[command(after_help = builtin_scenarios())]
pub(super) struct ServeArgs {
    /// Name of a built-in scenario (listed below), or a scenario file; the clients give the orders,
    /// not the scenario's pilot
    #[arg(default_value = builtin::DEMONSTRATION)]
    scenario: String,
    /// Simulated seconds per real second
    #[arg(long, allow_negative_numbers = true, default_value_t = 1.0, value_name = "FACTOR")]
    speed: f64,
    /// UDP port of the head; relays and base have the ports after it. 0 takes any free ports
    #[arg(long, allow_negative_numbers = true, default_value_t = FIRST_PORT, value_name = "N")]
    port: u16,
    /// IPv4 address to listen on; 0.0.0.0 listens on all addresses of this machine
    #[arg(long, default_value_t = Ipv4Addr::LOCALHOST, value_name = "ADDRESS")]
    host: Ipv4Addr,
    /// End after this many simulated seconds; where left out, at Ctrl-C
    #[arg(long, allow_negative_numbers = true, value_name = "SECONDS")]
    duration: Option<f64>,
    /// Movement policy, instead of the scenario's: t0, t5, k, authors, k-tuned or chain
    #[arg(long, value_name = "NAME")]
    policy: Option<String>,
    /// How closely the drones are simulated
    #[arg(long, value_enum)]
    fidelity: Option<FidelityArg>,
    /// Publish the mission to ROS 2 as well, in this domain, where left out in that of ROS_DOMAIN_ID or
    /// 0; the head follows /cmd_vel, the team /order. For `cargo sim-ros2`
    #[arg(long, value_name = "DOMAIN", num_args = 0..=1, require_equals = true)]
    ros2: Option<Option<String>>,
    #[command(flatten)]
    emulated: VirtualArgs,
    #[command(flatten)]
    common: Common,
}

impl ServeArgs {
    /// The virtual drones that are served, if any are.
    fn fleet(&self, scenario: &Scenario) -> Result<Option<Fleet>, InputError> {
        if scenario.fidelity == Fidelity::Virtual {
            return Fleet::of(&self.emulated, None, false, scenario, Base::MayBeVirtual).map(Some);
        }
        if self.emulated.are_given() {
            let wrong = "--elf, --radio-elf and --virtual-drones are for virtual drones";
            return Err(InputError::new(wrong, "add --fidelity virtual"));
        }
        Ok(None)
    }
}

pub(super) fn run(args: &ServeArgs) -> Result<Verdict, Trouble> {
    let scenario = scenario(&args.scenario, args.policy.as_deref(), args.fidelity)?;
    let scenario = with_link(scenario, None)?;
    let is_virtual = scenario.fidelity == Fidelity::Virtual;
    let stock = stock::firmware(&args.emulated, is_virtual)?;
    let fleet = if stock.is_some() { None } else { args.fleet(&scenario)? };
    let speed = within("--speed", args.speed, 0.01, 1_000.0)?;
    let duration = match args.duration {
        None => None,
        Some(seconds) => Some(within("--duration", seconds, 0.01, 1e6)?),
    };
    let duration = duration.map(|seconds| Duration::from_micros((seconds * 1e6) as u64));
    let asked = interrupt::asks("Ctrl-C: the drones are no longer served");
    if let Some(firmware) = stock {
        if args.ros2.is_some() {
            let wrong = "--ros2 is for missions, and the vendor's firmware flies none";
            return Err(InputError::new(wrong, "leave --ros2 or --elf out").into());
        }
        let ports = Ports::open(args.host, args.port, 1)?;
        return stock::serve(&firmware, &args.common, ports, (speed, duration), asked);
    }
    let node = args.ros2.as_ref().map(|domain| ros2_node::open(domain.as_deref())).transpose()?;
    let folder = args.common.folder()?;
    let ports = Ports::open(args.host, args.port, scenario.drones.members())?;
    let world = scenario.world();
    let reference = Reference::of(&scenario, &world);
    let seed = args.common.seed;
    let live = match fleet {
        None => Live::new(&scenario, &world, &reference, seed, false),
        Some(fleet) => {
            let drones = fleet.drones(&scenario, seed)?;
            Live::emulated(&scenario, &world, &reference, seed, false, drones)
        }
    };
    let live = match folder {
        None => live,
        Some(folder) => live.with_files(folder)?,
    };
    let live = match node {
        None => live,
        Some(node) => ros2_node::beside(live, node, &scenario)?,
    };
    announce(&args.common, &scenario, &ports)?;
    let tell = |now: Instant, event: Event| {
        if !args.common.quiet || event == Event::Late {
            complain(format_args!("{:8.2} s  {event}", now.as_micros() as f64 * 1e-6));
        }
    };
    let (mut live, tally) = serve::serve(live, ports, speed, duration, asked, tell);
    let files = live.take_files()?;
    finish(args, files, &scenario, &live, tally)
}

fn within(option: &str, value: f64, least: f64, most: f64) -> Result<f64, InputError> {
    if (least..=most).contains(&value) {
        return Ok(value);
    }
    Err(InputError::new(
        format!("{option} {value} is out of range"),
        format!("give {least} to {most}"),
    ))
}

/// Prints one line with the addresses, once clients can connect.
fn announce(common: &Common, scenario: &Scenario, ports: &Ports) -> Result<(), Trouble> {
    let mut line = format!("serving {}: ", scenario.name);
    let last = ports.addresses().len().saturating_sub(1);
    for (n, address) in ports.addresses().iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = match n {
            0 => write!(line, "udp://{address} (head)"),
            n if n == last => write!(line, ", :{} (base)", address.port()),
            _ => write!(line, ", :{}", address.port()),
        };
    }
    line.push_str("; Ctrl-C ends it");
    line.push('\n');
    match (common.json, common.quiet) {
        (true, _) => {
            // Where standard error is closed, the line is lost.
            let _ = std::io::stderr().write_all(line.as_bytes());
            Ok(())
        }
        (false, true) => Ok(()),
        (false, false) => super::put(&line),
    }
}

/// Writes and prints the results.
fn finish(
    args: &ServeArgs,
    files: Option<(Folder, TraceFiles)>,
    scenario: &Scenario,
    live: &Live<'_>,
    tally: Tally,
) -> Result<Verdict, Trouble> {
    if let Some(lost) = live.lost().filter(|lost| *lost > 0) {
        complain(format_args!("{lost} messages of ROS 2 were not sent: the DDS did not take them"));
    }
    let metrics = live.metrics();
    let aftermath = Aftermath::of(live.mission());
    let mut summary = summary(args, scenario, live, &metrics, tally);
    if let (Some(summary), false) = (summary.as_object_mut(), aftermath.is_empty()) {
        summary.insert("virtual".into(), aftermath.json());
    }
    let mut folder = None;
    if let Some((mut kept, files)) = files {
        files.finish(&mut kept, live.trace(), &summary)?;
        aftermath.write(&mut kept)?;
        Origin::of("serve", scenario, args.common.seed).write(&mut kept, scenario)?;
        folder = Some(kept);
    }
    let table = table(scenario, live, &metrics, tally) + &aftermath.table();
    args.common.finish(folder, &table, &summary)?;
    let failures: Vec<_> = aftermath.failures().collect();
    failures.iter().for_each(|failure| complain(format_args!("{}: {failure}", scenario.name)));
    Ok(if failures.is_empty() { Verdict::Good } else { Verdict::Failed })
}

fn seconds(live: &Live<'_>) -> f64 {
    live.time_us() as f64 / 1e6
}

fn summary(
    args: &ServeArgs,
    scenario: &Scenario,
    live: &Live<'_>,
    metrics: &RunMetrics,
    tally: Tally,
) -> Value {
    let drones: Vec<_> =
        live.states().map(|(id, state)| json!({ "id": id.0, "state": state.name() })).collect();
    json!({
        "scenario": scenario.name,
        "title": scenario.title,
        "seed": args.common.seed,
        "version": env!("CARGO_PKG_VERSION"),
        "fidelity": scenario.fidelity.name(),
        "policy": scenario.policy,
        "duration_s": seconds(live),
        "served": {
            "received": tally.received,
            "sent": tally.sent,
            "orders": tally.orders,
        },
        "metrics": metrics_json(metrics),
        "drones": drones,
    })
}

fn table(scenario: &Scenario, live: &Live<'_>, m: &RunMetrics, tally: Tally) -> String {
    let Tally { received, sent, orders } = tally;
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{}: {}", scenario.name, scenario.title);
    let _ = writeln!(text, "  served for            {:.1} s of simulated time", seconds(live));
    let _ = writeln!(text, "  packets               {received} received, {sent} sent");
    let _ = writeln!(text, "  orders                {orders}");
    let _ = writeln!(text, "  head reached          {:.1} m", m.farthest_m);
    let _ = writeln!(
        text,
        "  touches               {} of walls, {} of drones",
        m.wall_contacts, m.drone_contacts
    );
    let states: Vec<_> = live
        .trace()
        .nodes
        .iter()
        .zip(live.states())
        .map(|(node, (_, state))| format!("{node} {}", state.name()))
        .collect();
    let _ = writeln!(text, "  at the end            {}", states.join(", "));
    text
}

/// The node of ROS 2 beside the mission.
#[cfg(feature = "ros2")]
mod ros2_node {
    use input::InputError;
    use ros2::Companion;
    use ros2_topics::{Commands, Domain, Node};
    use scenario::Scenario;
    use serve::Live;

    /// Joins a domain, which is given as a number, or not at all.
    pub(super) fn open(domain: Option<&str>) -> Result<(Node, Commands), InputError> {
        let mut node = Node::open(Domain::of_option(domain)?, "uchain")?;
        let commands = node.follow()?;
        Ok((node, commands))
    }

    /// The mission with the node beside its clients.
    pub(super) fn beside<'a>(
        live: Live<'a>,
        (node, commands): (Node, Commands),
        scenario: &Scenario,
    ) -> Result<Live<'a>, InputError> {
        let companion =
            Companion::new(node, commands, scenario, live.trace()).map_err(|error| {
                let wrong = format!("--ros2: the topics cannot be published: {error}");
                InputError::new(wrong, "give another domain, or look whether the network is up")
            })?;
        Ok(live.with_companion(Box::new(companion)))
    }
}

/// The stand-in in a build without it.
#[cfg(not(feature = "ros2"))]
mod ros2_node {
    use input::InputError;
    use scenario::Scenario;
    use serve::Live;

    pub(super) enum Node {}

    pub(super) fn open(_: Option<&str>) -> Result<Node, InputError> {
        let wrong = "--ros2: this uchain was built without ROS 2";
        Err(InputError::new(wrong, "use `cargo sim-ros2` in place of `cargo sim`"))
    }

    pub(super) fn beside<'a>(
        _: Live<'a>,
        node: Node,
        _: &Scenario,
    ) -> Result<Live<'a>, InputError> {
        match node {}
    }
}
