//! The firmware's ELF, on emulated Crazyflies, in the simulated tunnel.
//!
//! These tests fly the file that `cargo fw` makes, or the one that `UCHAIN_ELF` names:
//! `cargo test --test suite virtual_drones -- --ignored`.

use std::path::PathBuf;
use std::sync::OnceLock;
use world::Spot;

use agent::{Agent, AgentConfig, Duty, Exploration, ExploreDuty, State};
use onboard::Snapshot;
use onboard::probe::Round;
use rayon::ThreadPoolBuilder;
use sim_harness::bodies::emulated::{Emulated, Firmware, unfit};
use sim_harness::measure::metrics::{Reference, RunMetrics, Watch};
use sim_harness::mission::Mission;
use sim_harness::scenario::{Fidelity, Scenario};
use sim_harness::serve::{Live, World as _};
use units::{Metres, MissionKind, NodeId, Payload, Point2, Role};
use world::SkeletonPlace;

/// The ELF, read once.
pub(crate) fn firmware() -> &'static Firmware {
    static FIRMWARE: OnceLock<Firmware> = OnceLock::new();
    FIRMWARE.get_or_init(|| {
        let built = PathBuf::from(env!("CARGO_TARGET_TMPDIR"))
            .join("../thumbv7em-none-eabihf/firmware/uchain-firmware");
        let path = std::env::var_os("UCHAIN_ELF").map_or(built, PathBuf::from);
        Firmware::open(&path).unwrap_or_else(|why| panic!("{why}"))
    })
}

pub(crate) fn scenario() -> Scenario {
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

/// The seed of the missions that are flown once.
const SEED: u64 = 1;

fn fly(scenario: &Scenario, firmware: Option<&Firmware>, threads: usize) -> Flown {
    fly_seed(scenario, firmware, threads, SEED)
}

fn fly_seed(scenario: &Scenario, firmware: Option<&Firmware>, threads: usize, seed: u64) -> Flown {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let world = scenario.world();
    let reference = Reference::of(scenario, &world);
    let nodes = (0..=scenario.drones.relays as u8).map(NodeId);
    let mut drones = Vec::new();
    for (node, firmware) in nodes.filter_map(|node| Some((node, firmware?))) {
        let mut drone = Emulated::new(scenario, firmware, node, seed);
        drone.record_decisions();
        drones.push(drone);
    }
    pool.install(|| {
        let mut mission = match firmware {
            None => Mission::new(scenario, &world, seed),
            Some(_) => Mission::emulated(scenario, &world, seed, drones),
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
        let mut agent = Agent::new(NodeId(node as u8), role, units::MissionKind::Chain);
        let mut heard = 0;
        for (n, Round { now, inputs, outputs: there }) in decisions.iter().enumerate() {
            let here = agent.step(&config, *now, &inputs.borrow());
            assert_eq!(
                format!("{here:?}"),
                format!("{there:?}"),
                "drone {node}, step {n}: {inputs:?}"
            );
            heard += inputs.heard.len();
        }
        // Five times a second but for the boot; and a drone that hears no other decides nothing.
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

/// A client's emergency stop, and an empty packet by which a client asks for the answer.
const EMERGENCY_STOP: [u8; 2] = [0x9D, 3];
const FEED_WATCHDOG: [u8; 2] = [0x9D, 4];
const ECHO: [u8; 2] = [0xFC, 1];

fn hover(forward: f32) -> Vec<u8> {
    let mut packet = vec![0x7C, 10];
    for value in [forward, 0.0, 0.0, 0.3] {
        packet.extend(value.to_le_bytes());
    }
    packet
}

/// Stops of clients, as `crates/onboard/tests/suite/stop.rs` gives them to the same code on the
/// host: at which node, by which packet, and which drones are then owed a stop.
const STOPS: [(usize, [u8; 2], &[usize]); 3] = [
    // At the base, for all.
    (2, EMERGENCY_STOP, &[0, 1]),
    // At the relay's own radio chip, for the relay.
    (1, EMERGENCY_STOP, &[1]),
    // At the head's, by a client that feeds the watchdog once and vanishes.
    (0, FEED_WATCHDOG, &[0]),
];

/// In mid-flight a client stops a drone or all; then clients at every node go on sending set-points,
/// and the scenario's pilot goes on, too.
#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn no_emulated_drone_that_is_owed_a_stop_flies() {
    /// The relay has been a link of the chain for a second by then.
    const STOPS_AT_US: u64 = 19_000_000;
    /// For the watchdog, and for the order's way.
    const WITHIN_US: u64 = 2_500_000;
    let scenario = scenario();
    let world = scenario.world();
    let emulated = |node| Emulated::new(&scenario, firmware(), NodeId(node), 1);
    for (at, packet, owed) in STOPS {
        let drones = vec![emulated(0), emulated(1)];
        let mut mission = Mission::emulated(&scenario, &world, 1, drones);
        mission.advance(STOPS_AT_US);
        // Its motors are in the emulator: a drone flies where its body is off the floor.
        let flies = |mission: &Mission<'_>, n: usize| mission.view(n).unwrap().body.height() > 0.05;
        assert!(flies(&mission, 0) && flies(&mission, 1), "both fly at first");
        mission.client(at, &packet);
        mission.advance(WITHIN_US);
        for _ in 0..40 {
            for n in owed {
                assert!(!flies(&mission, *n), "drone {n} flies after a stop at node {at}");
            }
            for node in (0..3).filter(|node| packet != FEED_WATCHDOG || *node != at) {
                mission.client(node, &hover(0.2));
            }
            mission.advance(100_000);
        }
        let states: Vec<_> = mission.states().map(|state| state.name()).collect();
        assert!(owed.iter().all(|n| states[*n] == "stopped"), "stop at {at}: {states:?}");
        if owed.len() == 1 {
            let other = 1 - owed[0];
            assert_ne!(states[other], "stopped", "a drone stops itself alone");
        }
    }
}

/// What a client asks of a drone in an emulator comes back from its firmware.
#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn a_client_of_an_emulated_drone_is_answered() {
    let scenario = scenario();
    let world = scenario.world();
    let drone = Emulated::new(&scenario, firmware(), NodeId(1), 1);
    let mut mission = Mission::emulated(&scenario, &world, 1, vec![drone]);
    mission.advance(3_000_000);
    let mut answers = Vec::new();
    for packet in [&EMERGENCY_STOP[..], &ECHO, &ECHO, &ECHO] {
        mission.client(1, packet);
        mission.advance(20_000);
        mission.poll_client(1, &Snapshot::DEFAULT, |answer| answers.push(answer.to_vec()));
    }
    let done = |answer: &&Vec<u8>| answer.get(1..) == Some(&[0x83, 1, 0]);
    assert!(answers.iter().find(done).is_some(), "{answers:?}");
}

/// Clients of a served chain reach the firmware of its drones as through a Crazyradio, and the base
/// takes their orders.
#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn served_virtual_drones_answer_their_clients_and_fly_by_their_orders() {
    /// Asks for the kind of device; on the air the bits 2 and 3 of the header count packets.
    const DEVICE: [u8; 2] = [0xFD, 0];
    let scenario = scenario();
    let world = scenario.world();
    let reference = Reference::of(&scenario, &world);
    let drones = [0, 1].map(|node| Emulated::new(&scenario, firmware(), NodeId(node), 1));
    let mut live = Live::emulated(&scenario, &world, &reference, 1, false, drones.into());
    let base = live.nodes().len() - 1;
    let mut answers = Vec::new();
    for step in 0..1_500 {
        if step == 300 {
            live.client(0, &DEVICE);
        }
        if step % 10 == 0 {
            live.client(base, &hover(0.2));
        }
        live.advance();
        live.poll_client(0, &mut |packet| answers.push(packet.to_vec()));
    }
    assert!(!live.is_halted());
    let named = |answer: &Vec<u8>| answer.get(1..19) == Some(b"Bitcraze Crazyflie");
    assert!(answers.iter().any(named), "{answers:?}");
    let state = live.state(0).map(|state| state.name());
    assert_eq!(state, Some("leading"), "the head flies by the order of a client");
}

/// A scenario of three drones, one row each, and passage b; everything is near the entrance.
fn small_swarm() -> Scenario {
    let mut scenario = Scenario::open("swarm-b").unwrap_or_else(|why| panic!("{why}"));
    let world = scenario.world();
    let base = SkeletonPlace { along: 6.0, ..scenario.drones.base.on };
    scenario.drones.base = Spot::on(world.skeleton(), base);
    scenario.agent.swarm.corner = Point2::new(-3.0, -1.5);
    scenario.agent.swarm.area = (Metres(2.25), Metres(3.0));
    scenario.duration_us = 100_000_000;
    scenario.fidelity = Fidelity::Virtual;
    scenario
}

/// A drone of a swarm takes off only where it knows its place in the room: the fixes of the
/// scenario's positioning system reach the agent in the ELF through radio chip, serial line and
/// CRTP server.
#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn a_virtual_drone_of_a_swarm_takes_off_by_fixes_alone() {
    let states = |fixes: bool| {
        let mut scenario = small_swarm();
        scenario.vehicle.position_noise = scenario.vehicle.position_noise.filter(|_| fixes);
        let world = scenario.world();
        let drones = (0..3).map(|node| Emulated::new(&scenario, firmware(), NodeId(node), 1));
        let mut mission = Mission::emulated(&scenario, &world, 1, drones.collect());
        mission.advance(6_000_000);
        assert_eq!(mission.halted(), None);
        let bodies = mission.bodies().zip(mission.states()).take(3);
        bodies.map(|(body, state)| (state.name(), body.height() > 0.2)).collect::<Vec<_>>()
    };
    assert_eq!(states(true), [("surveying", true); 3]);
    assert_eq!(states(false), [("idle", false); 3]);
}

/// Two drones whose firmware runs on emulated Crazyflies explore a room, and each of their decisions is
/// that of the agent on the host with the same inputs. What they tell each other is in the inputs, so
/// that a message of the chip is the host's, too.
#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn two_virtual_drones_explore_a_room_and_decide_as_the_host_does() {
    let room = Scenario::open("explore-room").unwrap_or_else(|why| panic!("{why}"));
    let fidelity = Fidelity::Virtual;
    let scenario = Scenario { duration_us: 60_000_000, fidelity, ..room };
    let flown = fly(&scenario, Some(firmware()), 2);
    let explore = flown.metrics.explore.expect("the metrics of an exploration");
    assert!(explore.explored > 0.95, "{explore:?}");
    let touches = (flown.metrics.wall_contacts, flown.metrics.drone_contacts);
    assert_eq!(touches, (0, 0));
    let mut told: Vec<Vec<Payload>> = Vec::new();
    let mut heard: Vec<Vec<Payload>> = Vec::new();
    for (node, decisions) in flown.decisions.iter().enumerate() {
        let id = NodeId(node as u8);
        let mut agent = Agent::new(id, Role::usual_of(id), MissionKind::Explore);
        let mut exploration = Box::new(Exploration::NEW);
        let (mut says, mut hears) = (Vec::new(), Vec::new());
        let mut goals = 0;
        for (n, Round { now, inputs, outputs: there }) in decisions.iter().enumerate() {
            let config = &AgentConfig::DEFAULT;
            let memory = Some(&mut *exploration);
            let here = agent.step_exploring(config, *now, &inputs.borrow(), memory);
            assert_eq!(
                format!("{here:?}"),
                format!("{there:?}"),
                "drone {node}, step {n}: {inputs:?}"
            );
            let duty = here.status.state;
            goals += u32::from(matches!(
                duty,
                State::OnMission(Duty::Explore(ExploreDuty::Exploring { .. }))
            ));
            says.extend_from_slice(agent.messages());
            hears.extend(inputs.told.iter().map(|told| told.payload));
        }
        assert!(goals > 50, "drone {node} had a goal in {goals} rounds");
        told.push(says);
        heard.push(hears);
    }
    for (node, hears) in heard.iter().enumerate() {
        let others = &told[1 - node];
        assert!(hears.len() > 50, "drone {node} heard {} messages", hears.len());
        assert!(
            hears.iter().all(|one| others.contains(one)),
            "drone {node} heard the host's alone"
        );
    }
}

/// How many missions of the swarm are flown on the host beside the emulated one: of 150, most need 64 to 72 s, and
/// five 77 to 81 s.
const HOSTED_SWARMS: u64 = 64;

/// Survey, formation, passage: as the same crates fly them on the host, by the plan in the drones'
/// EEPROMs.
#[test]
#[ignore = "needs the firmware's ELF: `cargo fw` makes it"]
fn three_virtual_drones_survey_gather_and_cross() {
    let scenario = small_swarm();
    assert_eq!(unfit(&scenario), None);
    let emulated = fly(&scenario, Some(firmware()), 2);
    assert_eq!(emulated.states, ["landed", "landed", "landed", "idle"]);
    let is = &emulated.metrics;
    assert_eq!((is.wall_contacts, is.drone_contacts), (0, 0));
    let is = is.swarm.unwrap();
    assert_eq!(is.unfinished, 0);
    assert!(is.closest_drones_m > 0.2, "{is:?}");
    // Clocks that are not in step, and every change of the code that shifts the chip's rounds, draw other
    // random numbers, so that one mission is compared with what chance makes of the host's.
    let mut across = Vec::new();
    for seed in 1..=HOSTED_SWARMS {
        let hosted = fly_seed(&scenario, None, 1, seed);
        assert_eq!(hosted.states, emulated.states, "seed {seed}");
        across.push(hosted.metrics.swarm.unwrap().across_s);
    }
    let (quickest, slowest) =
        across.iter().fold((f32::MAX, 0.0_f32), |(low, high), &one| (low.min(one), high.max(one)));
    let usual = quickest - 5.0..=slowest + 5.0;
    assert!(usual.contains(&is.across_s), "{is:?}, on the host across at {across:?}");
}
