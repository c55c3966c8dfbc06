//! Explorations with rigid bodies end, and touch nothing; the record shows the maps that the drones draw.
//!
//! None ended within 240 s while a ranger that sees no wall at a slant showed the cells behind it to be
//! free, and drones without fixes touched each other.

use grid_map::CellState;
use sim_harness::measure::campaign;
use sim_harness::measure::metrics::Reference;
use sim_harness::mission::Mission;
use sim_harness::mission::trace::Ground;
use sim_harness::scenario::{Fidelity, Scenario};

fn all_end(name: &str) {
    let scenario = Scenario::open(name).unwrap().at(Fidelity::Flight);
    let world = scenario.world();
    let reference = Reference::of(&scenario, &world);
    for (seed, run) in (1..).zip(campaign::fly(&scenario, &world, &reference, 1, 8, || ())) {
        let explore = run.explore.as_ref().unwrap();
        assert_eq!(explore.unfinished, 0, "{name}, seed {seed}: a drone still flies");
        assert!(explore.explored > 0.97, "{name}, seed {seed}: {} known", explore.explored);
        assert_eq!(run.wall_contacts, 0, "{name}, seed {seed}: a wall is touched");
        assert_eq!(run.drone_contacts, 0, "{name}, seed {seed}: two drones touch");
    }
}

#[test]
fn explorations_by_fixes_end_and_touch_nothing() {
    all_end("explore-room");
}

#[test]
fn explorations_by_flow_alone_end_and_touch_nothing() {
    all_end("explore-flow");
}

/// The changes that the record keeps come to what the drones' maps say together at the end, and a drone that explores
/// and moves has a goal.
#[test]
fn the_record_shows_the_map_that_the_drones_have_drawn() {
    let scenario = Scenario::open("explore-room").unwrap();
    let world = scenario.world();
    let mut mission = Mission::new(&scenario, &world, 3);
    let mut trace = mission.begin_trace(3);
    while !mission.is_over() {
        mission.round();
        trace.team_map.look(&mission);
        trace.frames.push(mission.frame());
    }
    let maps: Vec<_> = mission.explorations().collect();
    let frame = *maps[0].frame();
    let mut shown = vec![Ground::Unknown; frame.cell_count()];
    for change in trace.team_map.changes() {
        shown[change.cell] = change.ground;
    }
    for cell in frame.cells() {
        let state = maps.iter().map(|map| map.state(cell)).fold(CellState::Unknown, CellState::or);
        let as_state = match shown[frame.number(cell)] {
            Ground::Unknown => CellState::Unknown,
            Ground::Free | Ground::Frontier => CellState::Free,
            Ground::Wall => CellState::Occupied,
        };
        assert_eq!(as_state, state, "{cell:?}");
    }
    assert!(shown.contains(&Ground::Free) && shown.contains(&Ground::Wall));
    let goals = trace.frames.iter().filter(|frame| frame.drones[0].goal.is_some()).count();
    assert!(goals > 50, "a goal in {goals} frames");
    assert!(trace.frames.iter().all(|frame| frame.drones.last().unwrap().goal.is_none()));
}
