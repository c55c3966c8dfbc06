//! The firmware's ELF, on emulated Crazyflies, in the simulated tunnel.
//!
//! These tests fly the file that `cargo fw` makes, or the one that `UCHAIN_ELF` names:
//! `cargo test --test suite virtual_drones -- --ignored`.

use std::path::PathBuf;
use std::sync::OnceLock;

use agent::{Agent, AgentConfig};
use onboard::probe::Round;
use rayon::ThreadPoolBuilder;
use sim_harness::emulated::{Emulated, Firmware};
use sim_harness::metrics::{Reference, RunMetrics, Watch};
use sim_harness::mission::{Mission, World};
use sim_harness::scenario::Scenario;
use units::{NodeId, Role};

/// The ELF, read once.
fn firmware() -> &'static Firmware {
    static FIRMWARE: OnceLock<Firmware> = OnceLock::new();
    FIRMWARE.get_or_init(|| {
        let built = PathBuf::from(env!("CARGO_TARGET_TMPDIR"))
            .join("../thumbv7em-none-eabihf/firmware/uchain-firmware");
        let path = std::env::var_os("UCHAIN_ELF").map_or(built, PathBuf::from);
        Firmware::open(&path).unwrap_or_else(|why| panic!("{why}"))
    })
}

fn scenario() -> Scenario {
    Scenario::open("short-hop").unwrap_or_else(|why| panic!("{why}"))
}

/// How a mission went.
struct Flown {
    metrics: RunMetrics,
    orders: u32,
    states: Vec<&'static str>,
    decisions: Vec<Vec<Round>>,
    hashes: Vec<u64>,
}

fn fly(scenario: &Scenario, firmware: Option<&Firmware>, threads: usize) -> Flown {
    const SEED: u64 = 1;
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let world = World::of(scenario);
    let reference = Reference::of(scenario, &world);
    let nodes = (0..=scenario.drones.relays as u8).map(NodeId);
    let mut drones = Vec::new();
    for (node, firmware) in nodes.filter_map(|node| Some((node, firmware?))) {
        let mut drone = Emulated::new(scenario, firmware, node, SEED);
        drone.record_decisions();
        drones.push(drone);
    }
    pool.install(|| {
        let mut mission = match firmware {
            None => Mission::new(scenario, &world, SEED),
            Some(_) => Mission::emulated(scenario, &world, SEED, drones),
        };
        let mut watch = Watch::new(scenario, &world, &reference);
        while !mission.is_over() {
            mission.round();
            watch.look(&mission);
        }
        if let Some(halted) = mission.halted() {
            panic!("{halted}");
        }
        let drones = || (0..mission.count()).filter_map(|n| mission.emulated_drone(n));
        Flown {
            metrics: watch.verdict(&mission),
            orders: mission.radio().orders,
            states: mission.states().map(|state| state.name()).collect(),
            decisions: drones()
                .map(|drone| drone.decisions().expect("no round was missed").to_vec())
                .collect(),
            hashes: drones().map(|drone| drone.machine().state_hash()).collect(),
        }
    })
}

/// The mission that most tests look at.
fn whole() -> &'static Flown {
    static FLOWN: OnceLock<Flown> = OnceLock::new();
    FLOWN.get_or_init(|| fly(&scenario(), Some(firmware()), 2))
}

/// Take off, relay, land: as the same crates do on the host, within what another stream of random
/// numbers and clocks that are not in step make of it.
#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn the_elf_flies_the_mission_that_the_host_flies() {
    let emulated = whole();
    let hosted = fly(&scenario(), None, 1);
    assert_eq!(emulated.states, hosted.states);
    let (heard, should) = (emulated.orders, hosted.orders);
    assert!(heard.abs_diff(should) <= should / 5, "{heard} orders heard, on the host {should}");
    let (is, should) = (&emulated.metrics, &hosted.metrics);
    assert_eq!((is.wall_contacts, is.drone_contacts, is.order_lost), (0, 0, 0));
    assert_eq!(is.launched, should.launched);
    let near = |name, is: f32, should: f32, by: f32| {
        assert!((is - should).abs() <= by, "{name}: {is}, on the host {should}");
    };
    near("way of the head, m", is.farthest_m, should.farthest_m, 0.5);
    let (is, should) = (is.flight.as_ref().unwrap(), should.flight.as_ref().unwrap());
    assert_eq!((is.take_offs, is.landings), (should.take_offs, should.landings));
    assert_eq!(is.ends, should.ends);
    near("tilt, degrees", is.max_tilt_deg, should.max_tilt_deg, 6.0);
    near("velocity's error, m/s", is.velocity_error_mps, should.velocity_error_mps, 0.03);
    near("battery, V", is.min_battery_v, should.min_battery_v, 0.05);
}

/// What the agent decides on the chip, the same agent on the host decides of the same inputs, to the
/// last bit of every number: the text of a float is exact.
#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn the_agent_on_the_chip_decides_what_the_agent_on_the_host_does() {
    let emulated = whole();
    let limits = scenario().agent;
    let config =
        AgentConfig::DEFAULT.with_limits(Some(limits.launch.limit), Some(limits.retreat.limit));
    for (node, decisions) in emulated.decisions.iter().enumerate() {
        let role = if node == 0 { Role::Head } else { Role::Relay };
        let mut agent = Agent::new(NodeId(node as u8), role);
        let mut heard = 0;
        for (n, Round { now, told, decided: there }) in decisions.iter().enumerate() {
            let here = agent.step(&config, *now, &told.inputs());
            assert_eq!(
                format!("{here:?}"),
                format!("{there:?}"),
                "drone {node}, step {n}: {told:?}"
            );
            heard += told.heard.len();
        }
        // Five times a second but for the boot; and who hears nobody decides nothing.
        assert!(decisions.len() > 200, "drone {node} decided {} times", decisions.len());
        assert!(heard > 200, "drone {node} heard {heard} reports");
    }
}

#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn any_number_of_threads_ends_in_the_same_state() {
    let scenario = Scenario { duration_us: 9_000_000, ..scenario() };
    let [one, two] = [1, 2].map(|threads| fly(&scenario, Some(firmware()), threads));
    assert_eq!(one.hashes.len(), 2);
    assert_eq!(one.hashes, two.hashes);
}
