//! Makes the virtual drones that the command line asks for, and prints what they logged.

pub(super) mod replay;
pub(super) mod stock;

use std::fmt::Write;
use std::net::TcpListener;
use std::path::Path;
use std::sync::Arc;

use input::InputError;
use serde_json::{Value, json};
use units::NodeId;
use virtual_crazyflie::board::nrf51::Power;
use virtual_crazyflie::log::{LogLine, Messages};
use virtual_crazyflie::profile::{Durations, Report};

use super::{VirtualArgs, complain};
use bodies::emulated::{self, Emulated, Firmware};
use mission::Mission;
use report::Folder;
use scenario::Scenario;

/// Whether the base may be virtual.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Base {
    /// The base is given its orders by a scenario, and is on the host.
    OnHost,
    /// The base is given its orders by clients.
    MayBeVirtual,
}

/// The virtual drones of a mission.
pub(super) struct Fleet {
    firmware: Firmware,
    /// `None` where the firmware logs nothing that could be read.
    messages: Option<Arc<Messages>>,
    nodes: Vec<NodeId>,
    /// The drone to which GDB connects, and the port.
    gdb: Option<(NodeId, u16)>,
    /// Whether their log messages are printed.
    prints_log: bool,
}

impl Fleet {
    /// The virtual drones of a scenario, whose base may be one of them where clients give its orders.
    /// `port` is the value of `--gdb`.
    pub(super) fn of(
        args: &VirtualArgs,
        port: Option<&str>,
        prints_log: bool,
        scenario: &Scenario,
        base: Base,
    ) -> Result<Self, InputError> {
        if let Some(what) = emulated::unfit(scenario) {
            let wrong = format!("the scenario has what the firmware does not fly with: {what}");
            return Err(InputError::new(wrong, "fly it with --fidelity flight"));
        }
        let nodes = nodes(&args.virtual_drones, scenario, base)?;
        let gdb = port.map(|text| gdb(text, &nodes)).transpose()?;
        let elf = args.elf.as_deref().unwrap_or(Path::new(Firmware::DEFAULT));
        let firmware = Firmware::open(elf)?.with_radio(args.radio_elf.as_deref())?;
        let messages = Messages::of(firmware.image()).ok().map(Arc::new);
        if prints_log && messages.is_none() {
            let wrong = "the firmware logs nothing that could be read";
            return Err(InputError::new(wrong, "leave --log out").in_file(elf));
        }
        Ok(Self { firmware, messages, nodes, gdb, prints_log })
    }

    /// Makes the drones.
    pub(super) fn drones(
        &self,
        scenario: &Scenario,
        seed: u64,
    ) -> Result<Vec<Emulated>, InputError> {
        self.nodes.iter().map(|node| self.drone(scenario, *node, seed)).collect()
    }

    fn drone(&self, scenario: &Scenario, node: NodeId, seed: u64) -> Result<Emulated, InputError> {
        let mut drone = Emulated::new(scenario, &self.firmware, node, seed);
        if let Some(messages) = &self.messages {
            drone.read_log(messages);
        }
        let Some((_, port)) = self.gdb.filter(|(held, _)| *held == node) else {
            drone.profile();
            return Ok(drone);
        };
        let failed =
            |why| InputError::new(format!("--gdb {port}: {why}"), "give a port that is free");
        let listener = TcpListener::bind(("127.0.0.1", port)).map_err(failed)?;
        complain(format_args!("drone {} waits for `target remote :{port}`", node.0));
        drone.debug(listener).map_err(failed)
    }

    /// Prints the log messages since the last call, if they are to be printed.
    pub(super) fn say(&self, mission: &mut Mission<'_>, mut print: impl FnMut(&str)) {
        if !self.prints_log {
            return;
        }
        for node in &self.nodes {
            let Some(drone) = mission.emulated_drone_mut(node.0.into()) else { continue };
            for line in drone.new_lines() {
                print(&said(*node, line));
            }
        }
    }
}

fn said(node: NodeId, line: &LogLine) -> String {
    format!("{} {line}", node.0)
}

/// All drones of the scenario that fly, or those that were named.
fn nodes(named: &[u8], scenario: &Scenario, base: Base) -> Result<Vec<NodeId>, InputError> {
    let flying = scenario.drones.relays as u8;
    let (last, name) = match base {
        Base::OnHost => (flying, "the last relay"),
        Base::MayBeVirtual => (flying + 1, "the base"),
    };
    if let Some(wrong) = named.iter().find(|node| **node > last) {
        let wrong = format!("--virtual-drones {wrong}: there is no such drone");
        let remedy = format!("give numbers from 0, the head, to {last}, {name}");
        return Err(InputError::new(wrong, remedy));
    }
    let all: Vec<u8> = (0..=flying).collect();
    let chosen = if named.is_empty() { &all } else { named };
    Ok(chosen.iter().copied().map(NodeId).collect())
}

/// The drone to which GDB connects, and the port.
fn gdb(text: &str, nodes: &[NodeId]) -> Result<(NodeId, u16), InputError> {
    let (node, port) = match text.split_once(':') {
        Some((node, port)) => (node.parse().ok().map(NodeId), port),
        None => (nodes.first().copied(), text),
    };
    match (node.filter(|node| nodes.contains(node)), port.parse()) {
        (Some(node), Ok(port)) => Ok((node, port)),
        (None, Ok(_)) => {
            let wrong = format!("--gdb {text}: there is no such virtual drone");
            Err(InputError::new(wrong, "name one that is virtual"))
        }
        (_, Err(_)) => {
            let wrong = format!("--gdb {text}: {port} is not a port");
            Err(InputError::new(wrong, "give a number from 1 to 65535"))
        }
    }
}

/// The state of the virtual drones at the end.
pub(super) struct Aftermath {
    drones: Vec<DroneEnd>,
    failures: Vec<String>,
}

/// The state of one virtual drone at the end.
struct DroneEnd {
    node: NodeId,
    account: Option<Report>,
    log: Vec<String>,
    /// The packets that it has sent, as a table.
    packets: String,
    state_hash: u64,
}

impl Aftermath {
    pub(super) fn of(mission: &Mission<'_>) -> Self {
        let mut failures: Vec<_> = mission.halted().map(ToString::to_string).into_iter().collect();
        let mut drones = Vec::new();
        for member in 0..mission.count() {
            let Some(drone) = mission.emulated_drone(member) else { continue };
            let machine = drone.machine();
            for reset in machine.resets().iter().skip(1) {
                let (at, cause) = (reset.at as f64 * 1e-9, reset.cause);
                failures.push(format!("virtual drone {member} was reset at {at:.3} s: {cause}"));
            }
            for report in machine.fault_reports() {
                failures.push(format!("virtual drone {member}: {report}"));
            }
            if let Power::Off { since, cause } = machine.board().power() {
                let at = since as f64 * 1e-9;
                failures.push(format!("virtual drone {member} went off at {at:.3} s: {cause}"));
            }
            let node = NodeId(member as u8);
            drones.push(DroneEnd {
                node,
                account: drone.account(),
                log: drone.log().iter().map(|line| said(node, line)).collect(),
                packets: packets(drone),
                state_hash: machine.state_hash(),
            });
        }
        Self { drones, failures }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.drones.is_empty()
    }

    /// The reasons why the mission failed.
    pub(super) fn failures(&self) -> impl Iterator<Item = String> {
        self.failures.iter().cloned()
    }

    /// A table of each processor's load.
    pub(super) fn table(&self) -> String {
        let mut text = String::new();
        for drone in &self.drones {
            // Writing to a string cannot fail.
            let _ =
                write!(text, "\nvirtual drone {}, state {:016x}", drone.node.0, drone.state_hash);
            if let Some(account) = &drone.account {
                let _ = write!(text, ": {account}");
            }
            text.push('\n');
        }
        text
    }

    pub(super) fn json(&self) -> Value {
        self.drones.iter().map(DroneEnd::json).collect()
    }

    /// Each drone's log and its packets, as files.
    pub(super) fn write(&self, folder: &mut Folder) -> Result<(), InputError> {
        for drone in &self.drones {
            folder.put_text(&format!("packets-{}.csv", drone.node.0), &drone.packets)?;
        }
        for drone in self.drones.iter().filter(|drone| !drone.log.is_empty()) {
            let name = format!("firmware-{}.log", drone.node.0);
            folder.put_text(&name, &(drone.log.join("\n") + "\n"))?;
        }
        Ok(())
    }
}

/// When each packet of a drone was on the air, and its size.
fn packets(drone: &Emulated) -> String {
    let mut text = String::from("on_air_us,bytes\n");
    for packet in drone.packets() {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{},{}", packet.on_air_us, packet.bytes);
    }
    text
}

impl DroneEnd {
    fn json(&self) -> Value {
        let mut drone = json!({
            "id": self.node.0,
            "state_hash": format!("{:016x}", self.state_hash),
        });
        if let (Some(drone), Some(account)) = (drone.as_object_mut(), &self.account) {
            drone.insert("cpu_load".into(), json!(rounded(account.load, 4)));
            let stack = account.stack.and_then(|stack| stack.by_paint);
            drone.insert("stack_high_water_bytes".into(), json!(stack));
            drone.insert("tasks".into(), account.tasks.iter().map(task_json).collect());
        }
        drone
    }
}

fn task_json(task: &virtual_crazyflie::profile::TaskLoad) -> Value {
    json!({
        "name": task.name,
        "polls": task.own.count,
        "cpu_load": rounded(task.share, 5),
        "poll_us_p50": rounded(task.whole.p50, 1),
        "poll_us_max": rounded(task.whole.max, 1),
        "latency_us_max": task.latency.map(|Durations { max, .. }| rounded(max, 1)),
    })
}

/// Rounds a value to this many digits after the point.
fn rounded(value: f64, digits: i32) -> f64 {
    let scale = 10_f64.powi(digits);
    (value * scale).round() / scale
}
