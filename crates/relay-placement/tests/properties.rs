//! What must be true of every place that a rule chooses.

use grid_map::{Cell, CellState, Frame, GridMap, Planner};
use proptest::prelude::*;
use relay_placement::{Curve, Demand, Ground, GroundError, Network, Rule};
use units::{Metres, Point2};

const SIDE: u16 = 40;
const CELLS: usize = 1600;
const START: Cell = Cell::new(20, 20);

fn map_of(walls: &[bool], resolution: f32) -> GridMap<400> {
    let frame = Frame::new(Point2::new(-3.0, 7.0), Metres(resolution), SIDE, SIDE).unwrap();
    let mut map = GridMap::new(frame).unwrap();
    for (cell, wall) in frame.cells().zip(walls) {
        let state = if *wall && cell != START { CellState::Occupied } else { CellState::Free };
        map.set(cell, state);
    }
    map
}

fn ground_of(map: &GridMap<400>) -> Ground<CELLS> {
    Ground::new(map, &mut Planner::<800, 2000>::new(), START).unwrap()
}

/// A map of 40 by 40 cells, a fifth of which are walls.
fn maps() -> impl Strategy<Value = (GridMap<400>, Ground<CELLS>)> {
    (proptest::collection::vec(proptest::bool::weighted(0.2), CELLS), 0.25f32..2.0).prop_map(
        |(walls, resolution)| {
            let map = map_of(&walls, resolution);
            let ground = ground_of(&map);
            (map, ground)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_place_is_free_and_near_the_goal((map, ground) in maps(), seed: u64) {
        let goal = ground.frame().centre(START);
        let mut network = Network::new(&ground, Curve::DEFAULT);
        network.add(&ground, goal);
        for rule in Rule::ALL {
            if let Some(place) = rule.choose(&ground, &network, goal, &Demand::DEFAULT, seed) {
                let off = (place.at.x - goal.x).hypot(place.at.y - goal.y);
                prop_assert_eq!(map.state(place.cell), CellState::Free, "{}", rule.name());
                prop_assert!(off <= 10.0 + 1e-4, "{} at {off} m", rule.name());
            }
        }
    }

    #[test]
    fn a_relay_never_takes_coverage_and_gives_what_was_said((_, ground) in maps()) {
        let goal = ground.frame().centre(START);
        let demand = Demand { within: Metres(100.0), ..Demand::DEFAULT };
        let mut network = Network::new(&ground, Curve::DEFAULT);
        network.add(&ground, goal);
        for _ in 0..4 {
            let before = network.covered(&ground);
            let Some(place) = Rule::Ours.choose(&ground, &network, goal, &demand, 0) else { break };
            network.add(&ground, place.at);
            let after = network.covered(&ground);
            prop_assert!(after >= before);
            // Cells whose middles lie at 20 m exactly may fall to either side.
            prop_assert!((after - before).abs_diff(place.gain_cells) <= 12);
        }
    }

    #[test]
    fn ours_is_linked_wherever_a_linked_place_exists((_, ground) in maps(), away in 0.0f32..60.0) {
        let goal = ground.frame().centre(START);
        let mut network = Network::new(&ground, Curve::DEFAULT);
        network.add(&ground, Point2::new(goal.x + away, goal.y));
        let linked = ground.reached().any(|cell| {
            let at = ground.frame().centre(cell);
            (at.x - goal.x).hypot(at.y - goal.y) < 9.999 && network.covers(cell)
        });
        let place = Rule::Ours.choose(&ground, &network, goal, &Demand::DEFAULT, 0);
        prop_assert!(!linked || place.is_some());
        let best = Rule::Best.choose(&ground, &network, goal, &Demand::DEFAULT, 0);
        let gain = |place: Option<relay_placement::Place>| place.map_or(0, |it| it.gain_cells);
        prop_assert!(gain(place) as f32 >= 0.799 * gain(best) as f32);
        prop_assert!(place.is_none_or(|place| place.link >= Curve::DEFAULT.covered));
    }
}

#[test]
fn a_start_in_a_wall_is_refused() {
    let mut map = map_of(&[false; CELLS], 0.5);
    map.set(START, CellState::Occupied);
    let ground = Ground::<CELLS>::new(&map, &mut Planner::<800, 2000>::new(), START);
    assert_eq!(ground, Err(GroundError::StartNotFree));
}
