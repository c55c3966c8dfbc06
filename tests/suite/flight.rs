//! Missions at flight level: the very flight code, navigation and agents of the firmware, in
//! bodies that can fall.

use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use sim_harness::bench::faults::measure::{Places, cases};
use sim_harness::measure::metrics::{Reference, RunMetrics, Watch};
use sim_harness::mission::Mission;
use sim_harness::report::csv;
use sim_harness::scenario::{Fidelity, Scenario, builtin};

use crate::golden;

fn open(name: &str) -> Scenario {
    Scenario::open(name).unwrap_or_else(|error| panic!("{error}"))
}

fn fly(scenario: &Scenario, seed: u64) -> (RunMetrics, Vec<&'static str>) {
    let world = scenario.world();
    let reference = Reference::of(scenario, &world);
    let mut mission = Mission::new(scenario, &world, seed);
    let mut watch = Watch::new(scenario, &world, &reference);
    while !mission.is_over() {
        mission.round();
        watch.look(&mission);
    }
    let states = mission.states().map(|state| state.name()).collect();
    (watch.verdict(&mission), states)
}

/// The bytes of a short mission's trace.
fn trace(seed: u64) -> Vec<u8> {
    let scenario = open("relay-pair");
    let scenario = Scenario { duration_us: 3_000_000, ..scenario };
    let mut table = Vec::new();
    csv::write(&Mission::record(&scenario, &scenario.world(), seed), &mut table).unwrap();
    table
}

/// The committed table is of three seconds of `relay-pair` with seed 1: it changes with any change
/// to the flight code, the radio link or the physics, and debug and release builds must agree on it.
#[test]
fn a_flight_leaves_the_committed_bytes_on_any_number_of_threads() {
    let on = |threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| (1..=3_u64).into_par_iter().map(trace).collect::<Vec<_>>())
    };
    let (alone, together) = (on(1), on(2));
    assert!(alone == together, "one thread and two differ");
    assert!(alone[0] != alone[1], "the seed does nothing");
    golden::compare("flight.csv", &golden::rows_every(1, &alone[0]));
}

#[test]
fn every_built_in_scenario_flies_at_both_fidelities() {
    let names: Vec<_> = builtin::names().collect();
    names.into_par_iter().for_each(|name| {
        for fidelity in [Fidelity::Point, Fidelity::Flight] {
            let scenario = Scenario { duration_us: 400_000, ..open(name).at(fidelity) };
            // Long chains fly at point level alone: fifteen crafts take the suite a minute.
            if fidelity == Fidelity::Flight && scenario.drones.flying() > 6 {
                continue;
            }
            let world = scenario.world();
            let mut mission = Mission::new(&scenario, &world, 1);
            while !mission.is_over() {
                mission.round();
            }
            let crafts = mission.bodies().filter(|body| body.craft().is_some()).count();
            let flying = scenario.drones.explorers + scenario.drones.relays;
            let wanted = if fidelity == Fidelity::Flight { flying } else { 0 };
            assert_eq!(crafts, wanted, "{name}");
            assert!(mission.bodies().all(|body| body.position().x.is_finite()), "{name}");
        }
    });
}

/// The paper's experiment: all take off, relay, and land; nothing is touched, nothing tips over,
/// and the links are equal to within 3 dB at the end of the hold.
#[test]
fn three_drones_relay_through_the_paper_circuit_and_come_home() {
    let scenario = open("paper-circuit");
    let (metrics, states) = fly(&scenario, 1);
    let flight = metrics.flight.expect("it is flown at flight level");
    assert_eq!(states, ["landed", "landed", "landed", "idle"]);
    assert_eq!((flight.take_offs, flight.landings), (3, 3), "{flight:?}");
    assert_eq!(flight.ends().collect::<Vec<_>>(), [("told", 3)]);
    assert_eq!((metrics.wall_contacts, metrics.drone_contacts), (0, 0));
    assert!(flight.max_tilt_deg < 30.0, "{flight:?}");
    let spread = metrics.held(|hold| hold.spread_db);
    assert!(spread <= 3.0, "{spread}");
    assert_eq!(metrics.launched, 2.0);
}

/// One of each kind, in both places: nothing that goes wrong brings a drone down out of control.
#[test]
fn no_kind_of_fault_makes_a_drone_fall() {
    let places = Places::new().unwrap_or_else(|error| panic!("{error}"));
    let kinds = [
        "imu lost 0.2 s",
        "gyro lying 2 s",
        "accel frozen for good",
        "flow lying for good",
        "down-ranger lost for good",
        "side-rangers lost for good",
        "battery-reading lying for good",
        "dark floor for good",
        "radio silence for good",
        "tick jitter for good",
        "motor at 70 %",
        "battery at its end",
        "gust of 1 m/s for 2 s",
    ];
    let wanted: Vec<_> =
        cases().into_iter().filter(|case| kinds.contains(&case.name.as_str())).collect();
    assert_eq!(wanted.len(), 2 * kinds.len(), "a name has changed");
    wanted.into_par_iter().for_each(|case| {
        let row = places.run(&case, 1, 1, || ());
        assert_eq!(row.uncontrolled, 0, "{row:?}");
        assert_eq!(row.survived + row.landed_safely, 1, "{row:?}");
    });
}
