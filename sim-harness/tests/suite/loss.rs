//! Drones that a scenario takes from the chain (`[[loss]]`), one test for each way to lose one.
//!
//! Three relays stand equally between the base and a head at 16 m; relay 2, in the middle, is lost
//! at 10 s.

use agent::State;
use sim_harness::measure::metrics::{Reference, RunMetrics, Watch};
use sim_harness::mission::Mission;
use sim_harness::scenario::{LossKind, Scenario};
use units::{NodeId, Point2};

use crate::scenario_text;

/// The drone that is lost.
const LOST: usize = 2;

/// A mission in which relay 2 is lost in this way, with this link between the drones.
fn losing(how: LossKind, link: &str) -> Scenario {
    let text = "\
title = \"A relay is lost\"
duration_s = 60.0
link = \"exact\"
[tunnel]
width_m = 1.5
centre_line_m = [[0.0, 0.0], [16.0, 0.0]]
[drones]
relays = 3
start = \"placed\"
at_m = [16.0, 12.0, 8.0, 4.0]
[retreat]
limit_dbm = -300.0
[[pilot]]
at_s = 0.0
order = \"explore\"
speed_mps = 0.0
[[loss]]
at_s = 10.0
drone = 2
how = \"gone\"
";
    let name = format!("{how:?}").to_lowercase();
    let text = text.replace("gone", &name).replace("exact", link);
    scenario_text::read(&format!("loss/{name}-{link}"), &text)
}

/// What is seen of the lost drone.
#[derive(Clone, Copy, Debug)]
struct Seen {
    state: State,
    at: Point2,
    height: f32,
    /// When the base last heard of it, s.
    heard_s: f32,
    /// How many drones the chain has, base included.
    links: usize,
}

/// Flies the mission and returns what is seen at each whole second, and its figures.
fn fly(how: LossKind, link: &str) -> (Vec<Seen>, RunMetrics) {
    let scenario = losing(how, link);
    let world = scenario.world();
    let reference = Reference::of(&scenario, &world);
    let mut mission = Mission::new(&scenario, &world, 7);
    let mut watch = Watch::new(&scenario, &world, &reference);
    let (mut seen, mut chain) = (Vec::new(), Vec::new());
    while !mission.is_over() {
        if mission.time_us().is_multiple_of(1_000_000) {
            mission.chain(&mut chain);
            let body = mission.bodies().nth(LOST).unwrap();
            seen.push(Seen {
                state: mission.states().nth(LOST).unwrap(),
                at: body.position(),
                height: body.height(),
                heard_s: mission.told(LOST).map_or(0.0, |told| told.at_us as f32 * 1e-6),
                links: chain.len(),
            });
        }
        mission.round();
        watch.look(&mission);
        mission.chain(&mut chain);
        let is_link = chain.iter().any(|link| link.id == NodeId(LOST as u8));
        assert!(!is_link || mission.time_us() <= 10_200_000, "a lost drone is no link");
    }
    (seen, watch.verdict(&mission))
}

/// What every way has in common: the others close the gap, and only from the loss on.
fn is_repaired(seen: &[Seen], metrics: &RunMetrics) {
    assert_eq!((seen[9].links, seen[20].links), (5, 4));
    let repaired = metrics.held(|hold| hold.t_repair_s);
    assert!((1.0..40.0).contains(&repaired), "{repaired}");
    assert_eq!(metrics.drone_contacts, 0);
}

#[test]
fn a_drone_that_lands_says_so_and_stays_on_the_ground() {
    let (seen, metrics) = fly(LossKind::Lands, "exact");
    let end = seen[59];
    assert!(matches!(end.state, State::Landed { why: agent::LandReason::Unfit(_) }), "{end:?}");
    assert_eq!(end.height, 0.0);
    assert!(end.heard_s > 55.0, "its radio goes on: {end:?}");
    is_repaired(&seen, &metrics);
}

#[test]
fn a_silent_drone_flies_on_and_is_not_heard() {
    let (seen, metrics) = fly(LossKind::Silent, "exact");
    assert!(seen[13].height > 0.0, "{:?}", seen[13]);
    let end = seen[59];
    assert!((9.0..=10.5).contains(&end.heard_s), "{end:?}");
    // It hears nobody either: it flies back towards the base, and lands in the end.
    assert!(seen[14].state != end.state, "{end:?}");
    assert_eq!((seen[9].links, seen[20].links), (5, 4));
    assert!(metrics.held(|hold| hold.t_repair_s) > 1.0);
}

#[test]
fn a_drone_that_is_gone_lies_where_it_was() {
    for link in ["exact", "ideal"] {
        let (seen, metrics) = fly(LossKind::Gone, link);
        let (before, end) = (seen[10], seen[59]);
        assert_eq!(end.height, 0.0);
        assert!(before.at.distance(end.at).0 < 0.05, "{link}: {before:?} {end:?}");
        // The ideal link carries no telemetry.
        assert!(link == "ideal" || (9.0..=10.5).contains(&end.heard_s), "{end:?}");
        is_repaired(&seen, &metrics);
    }
}
