//! A tunnel that forks, with drones in both branches (the built-in scenario `fork`).
//!
//! The main gallery is 8 m long, each branch 10 m. The head (0) is in the left branch, an explorer
//! (1) and a stray relay (2) are in the right one, relays 3 and 4 and the base (5) in the main
//! gallery.

use std::path::Path;
use world::{Spot, World};

use sim_harness::measure::metrics::{Reference, RunMetrics, Watch};
use sim_harness::mission::Mission;
use sim_harness::mission::trace::Trace;
use sim_harness::report::{Folder, TraceFiles};
use sim_harness::scenario::{Drones, Scenario, Start};
use units::{NodeId, Point2};
use world::{SkeletonPlace, best_chain};

fn open() -> (Scenario, World) {
    let scenario = Scenario::open("fork").unwrap();
    let world = scenario.world();
    (scenario, world)
}

fn place(world: &World, edge: &str, along: f32) -> SkeletonPlace {
    SkeletonPlace { edge: world.skeleton().edge_named(edge).unwrap(), along }
}

fn fly(scenario: &Scenario, world: &World, seed: u64) -> (Trace, RunMetrics) {
    let reference = Reference::of(scenario, world);
    let mut mission = Mission::new(scenario, world, seed);
    let mut watch = Watch::new(scenario, world, &reference);
    let mut trace = mission.begin_trace(seed);
    while !mission.is_over() {
        mission.round();
        watch.look(&mission);
        trace.frames.push(mission.frame());
    }
    (trace, watch.verdict(&mission))
}

#[test]
fn every_drone_starts_where_the_file_says() {
    let (scenario, world) = open();
    let mission = Mission::new(&scenario, &world, 1);
    let ways: Vec<f32> = mission.ways().collect();
    assert_eq!(ways, [13.0, 13.0, 10.0, 6.0, 3.0, 0.0]);
    let points: Vec<Point2> = mission.bodies().map(|body| body.position()).collect();
    // Each branch rises by 3 in 5.
    let near = |a: Point2, x: f32, y: f32| a.distance(Point2::new(x, y)).0 < 1e-4;
    assert!(near(points[0], 12.0, 3.0) && near(points[1], 12.0, -3.0), "{points:?}");
    assert!(near(points[2], 9.6, -1.2) && near(points[3], 6.0, 0.0), "{points:?}");
}

/// Equation (19) between the branches: the distance goes round by the fork, the rock is on the
/// straight line.
#[test]
fn a_link_between_the_branches_goes_by_the_fork() {
    let (_, world) = open();
    let (left, right) = (place(&world, "left", 5.0), place(&world, "right", 5.0));
    assert_eq!(world.skeleton().distance(left, right).0, 10.0);
    let obstruction = world.tunnel.obstruction(Point2::new(12.0, 3.0), Point2::new(12.0, -3.0));
    // Between the inner walls: 6 m less half a branch at each end, cut along the vertical.
    let rock = 6.0 - 2.0 * 0.6 / 0.8;
    assert!((obstruction.rock.0 - rock).abs() < 1e-3, "{obstruction:?}");
    let alpha = 2.0 + 4.0 * (1.0 - (-rock / 2.0).exp());
    let loss = world.radio.strength(left, right).loss().0;
    assert!((loss - (40.0 + 10.0 * alpha)).abs() < 0.05, "{loss} dB");
    // Along the main gallery nothing is in the way.
    let (near, far) = (place(&world, "main", 3.0), place(&world, "main", 6.0));
    let loss = world.radio.strength(near, far).loss().0;
    assert!((loss - (40.0 + 20.0 * 3.0_f32.log10())).abs() < 0.01, "{loss} dB");
    let by_points = world.radio.strength_between(Point2::new(12.0, 3.0), Point2::new(12.0, -3.0));
    assert!((by_points.0 - world.radio.strength(left, right).0).abs() < 0.01);
}

/// The best chain of two links to the head has its relay where both links are equal, on the way
/// to the head and not into the other branch.
#[test]
fn the_best_chain_stands_on_the_heads_own_way() {
    let (scenario, world) = open();
    let way = world.path_to(place(&world, "left", 5.0));
    assert_eq!(way.length(), 13.0);
    let best = best_chain(&world.radio, &way, 2);
    let relay = way.at(best.positions[1]);
    assert_ne!(relay.edge, world.skeleton().edge_named("right").unwrap());
    let loss = |a, b| world.radio.strength(a, b).loss().0;
    let (back, front) = (loss(way.at(0.0), relay), loss(relay, way.at(13.0)));
    assert!((back - front).abs() < 0.05, "{back} dB, {front} dB");
    let reference = Reference::of(&scenario, &world);
    let mirrored = |edge| {
        let link = sim_harness::mission::Linked {
            id: NodeId::HEAD,
            place: place(&world, edge, 5.0),
            way: 13.0,
        };
        reference.worst(2, &link)
    };
    assert!((mirrored("left") - mirrored("right")).abs() < 0.05, "the fork is symmetric");
    assert!((mirrored("left") - best.worst.0).abs() < 0.5);
}

#[test]
fn a_mission_in_both_branches_has_figures_that_make_sense() {
    let (scenario, world) = open();
    let (trace, metrics) = fly(&scenario, &world, 1);
    assert_eq!((metrics.wall_contacts, metrics.drone_contacts), (0, 0));
    // The stray relay is farther from the base than relays and head ever get out of order by, but
    // in another branch.
    assert_eq!(metrics.order_lost, 0);
    assert!((13.5..14.5).contains(&metrics.farthest_m), "{metrics:?}");
    let hold = metrics.hold.unwrap();
    assert_eq!((hold.from_s, hold.until_s), (10.0, 90.0));
    // A relay in the wrong branch costs many decibels.
    assert!(hold.gap_db > 10.0 && hold.gap_db.is_finite(), "{hold:?}");
    let last = trace.frames.last().unwrap();
    let edges: Vec<_> =
        last.drones.iter().map(|drone| trace.floor_plan.edge_name(drone.place)).collect();
    assert_eq!((edges[0], edges[1], edges[5]), ("left", "right", "main"));
    for drone in &last.drones {
        let found = world.way(world.tunnel.place(drone.pose.at, None));
        assert!((found - drone.way).abs() < 0.35, "{drone:?}");
    }
}

#[test]
fn the_gap_is_taken_from_each_explorers_own_best_chain() {
    let (scenario, world) = open();
    let spot = |edge, along| Spot::on(world.skeleton(), place(&world, edge, along));
    // No relay astray: two relays before the fork, where both explorers need them.
    let spots = [("left", 3.0), ("right", 3.0), ("main", 7.3), ("main", 3.7)];
    let start = Start::Placed(spots.iter().map(|(edge, along)| spot(*edge, *along)).collect());
    let drones = Drones { relays: 2, start, ..scenario.drones.clone() };
    let scenario = Scenario { drones, pilot: Vec::new(), ..scenario };
    let reference = Reference::of(&scenario, &world);
    let mut mission = Mission::new(&scenario, &world, 1);
    let mut watch = Watch::new(&scenario, &world, &reference);
    for _ in 0..3 {
        mission.round();
        watch.look(&mission);
    }
    let hold = watch.verdict(&mission).hold.unwrap();
    assert!((-0.1..2.0).contains(&hold.gap_db), "{hold:?}");
}

#[test]
fn table_map_and_report_show_both_branches() {
    let (scenario, world) = open();
    let scenario = Scenario { duration_us: 4_000_000, ..scenario };
    let (trace, _) = fly(&scenario, &world, 1);
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fork");
    // An older build may have left results without the mark of this one.
    let _ = std::fs::remove_dir_all(&target);
    let mut folder = Folder::open(&target).unwrap();
    let mut files = TraceFiles::begin(&folder, &trace).unwrap();
    trace.frames.iter().for_each(|frame| files.frame(&folder, &trace, frame).unwrap());
    files.finish(&mut folder, &trace, &serde_json::json!({})).unwrap();
    folder.finish().unwrap();
    let read = |name: &str| std::fs::read_to_string(target.join(name)).unwrap();
    let table = read("trace.csv");
    let header: Vec<_> = table.lines().next().unwrap().split(',').collect();
    let column = |name| header.iter().position(|field| *field == name).unwrap();
    let first: Vec<_> = table.lines().nth(1).unwrap().split(',').collect();
    assert_eq!(first[column("edge")], "left");
    assert!(first[column("way_m")].starts_with("13."), "{first:?}");
    assert_eq!(trace.floor_plan.centre_lines.len(), 3);
    // Outline and three centre-lines, and the way of every drone that moved.
    for name in ["map.svg", "report.html"] {
        assert!(read(name).len() > 1_000, "{name}");
    }
    assert!(read("report.html").contains("\"centres\":[["));
}
