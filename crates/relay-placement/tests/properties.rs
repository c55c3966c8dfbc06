//! What must be true of every place that a rule chooses.

use grid_map::{Cell, CellState, Frame, GridMap, Planner};
use proptest::prelude::*;
use relay_placement::{Curve, Demand, Ground, GroundError, MOST_PLANNED, Network, Plan, Rule};
use units::{Db, Metres, Point2};

const SIDE: u16 = 40;
const CELLS: usize = 1600;
const START: Cell = Cell::new(20, 20);

fn planner() -> Planner<800, 2000> {
    Planner::new()
}

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
    Ground::new(map, &mut planner(), START).unwrap()
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
            if let Some(place) = rule.choose(&ground, &network, goal, &Demand::DEFAULT, seed, &mut planner()) {
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
            let Some(place) = Rule::Ours.choose(&ground, &network, goal, &demand, 0, &mut planner()) else { break };
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
        let place = Rule::Ours.choose(&ground, &network, goal, &Demand::DEFAULT, 0, &mut planner());
        prop_assert!(!linked || place.is_some());
        let best = Rule::Best.choose(&ground, &network, goal, &Demand::DEFAULT, 0, &mut planner());
        let gain = |place: Option<relay_placement::Place>| place.map_or(0, |it| it.gain_cells);
        prop_assert!(gain(place) as f32 >= 0.799 * gain(best) as f32);
        prop_assert!(place.is_none_or(|place| place.link >= Curve::DEFAULT.covered));
    }

    #[test]
    fn each_place_of_a_plan_is_linked_to_those_before(
        (map, ground) in maps(),
        nodes in 0usize..=MOST_PLANNED + 1,
        away in 0.0f32..30.0,
    ) {
        let base = ground.frame().centre(START);
        let mut network = Network::new(&ground, Curve::DEFAULT);
        network.add(&ground, Point2::new(base.x + away, base.y));
        let plan = Plan::new(&ground, &network, &Demand::DEFAULT, nodes);
        prop_assert!(plan.places().len() <= nodes.min(MOST_PLANNED));
        for place in plan.places() {
            prop_assert_eq!(map.state(place.cell), CellState::Free);
            prop_assert!(network.ratio(place.cell) >= Curve::DEFAULT.covered);
            prop_assert!((network.ratio(place.cell).0 - place.link.0).abs() < 1e-3);
            network.add(&ground, place.at);
        }
    }

    /// A plan by the way searches only where it has to, and chooses what one finds that searches
    /// everywhere.
    #[test]
    fn a_plan_by_the_way_is_that_of_one_choice_after_the_other(
        (map, resolution) in (proptest::collection::vec(proptest::bool::weighted(0.3), CELLS), 0.4f32..3.0),
        nodes in 1usize..=8,
        start in (0u16..SIDE, 0u16..SIDE),
        margin in 0.0f32..12.0,
    ) {
        let mut map = map_of(&map, resolution);
        let start = Cell::new(start.0, start.1);
        map.set(start, CellState::Free);
        let mut planner = planner();
        let ground = Ground::<CELLS>::new(&map, &mut planner, start).unwrap();
        let mut network = Network::new(&ground, Curve::DEFAULT);
        network.add_by_way(&ground, &mut planner, start).unwrap();
        let demand = Demand { within: Metres(f32::INFINITY), margin: Db(margin), ..Demand::DEFAULT };
        let plan = Plan::by_way(&ground, &network, &mut planner, &demand, nodes);
        let goal = ground.frame().centre(start);
        for place in plan.places() {
            let one = Rule::OursGeodesic.choose(&ground, &network, goal, &demand, 0, &mut planner);
            prop_assert_eq!(Some(*place), one);
            network.add_by_way(&ground, &mut planner, place.cell).unwrap();
        }
        if plan.places().len() < nodes {
            let next = Rule::OursGeodesic.choose(&ground, &network, goal, &demand, 0, &mut planner);
            prop_assert!(next.is_none_or(|place| place.gain_cells == 0), "{:?}", next);
        }
    }

    /// Once the margin was given up, the order of the relays took links without it before others.
    #[test]
    fn few_relays_of_a_plan_keep_the_margin((_, ground) in maps(), nodes in 1usize..=4) {
        let mut network = Network::new(&ground, Curve::DEFAULT);
        network.add(&ground, ground.frame().centre(START));
        let plan = Plan::new(&ground, &network, &Demand::DEFAULT, nodes);
        let least = Curve::DEFAULT.covered.0 + Demand::DEFAULT.margin.0 - 1e-3;
        prop_assert!(plan.places().iter().all(|place| place.link.0 >= least), "{plan:?}");
    }

    #[test]
    fn no_set_of_relays_covers_more_than_the_bound(
        (_, ground) in maps(),
        others in proptest::collection::vec((0u16..SIDE, 0u16..SIDE), 1..6),
    ) {
        let mut network = Network::new(&ground, Curve::DEFAULT);
        network.add(&ground, ground.frame().centre(START));
        let before = network.covered(&ground);
        let plan = Plan::new(&ground, &network, &Demand::DEFAULT, others.len());
        let most = plan.at_most_cells(&ground, &network, others.len());
        prop_assert!(plan.gain_cells() <= most);
        let cells = others.iter().map(|&(column, row)| Cell::new(column, row));
        for cell in cells.filter(|&cell| ground.is_reached(cell)) {
            network.add(&ground, ground.frame().centre(cell));
        }
        // Cells whose middles lie at 20 m exactly may fall to either side.
        prop_assert!(network.covered(&ground) - before <= most + 12 * others.len());
    }

    #[test]
    fn the_reach_of_a_ratio_is_where_the_curve_has_it(ratio in 0.1f32..70.0) {
        let there = Curve::DEFAULT.at(Curve::DEFAULT.reach(Db(ratio)));
        prop_assert!((there.0 - ratio).abs() < 1e-2, "{there:?} for {ratio}");
    }
}

/// A corridor of 60 m, which one relay does not cover: the plan goes on from relay to relay.
#[test]
fn a_plan_follows_a_corridor_to_its_end() {
    let walls: Vec<bool> =
        (0..CELLS).map(|n| !(19..22).contains(&(n / usize::from(SIDE)))).collect();
    let map = map_of(&walls, 3.0);
    let ground = ground_of(&map);
    let mut network = Network::new(&ground, Curve::DEFAULT);
    network.add(&ground, ground.frame().centre(START));
    let plan = Plan::new(&ground, &network, &Demand::DEFAULT, MOST_PLANNED);
    for place in plan.places() {
        network.add(&ground, place.at);
    }
    assert_eq!(network.covered(&ground), ground.reached().count());
}

/// In cells of 16 m no neighbour has the margin, and each has a link.
#[test]
fn a_plan_gives_up_the_margin_where_only_that_leads_on() {
    let ground = ground_of(&map_of(&[false; CELLS], 16.0));
    let mut network = Network::new(&ground, Curve::DEFAULT);
    network.add(&ground, ground.frame().centre(START));
    let plan = Plan::new(&ground, &network, &Demand::DEFAULT, 3);
    assert_eq!(plan.places().len(), 3);
    for place in plan.places() {
        assert!(place.gain_cells > 0 && place.link >= Curve::DEFAULT.covered, "{place:?}");
    }
}

#[test]
fn a_start_in_a_wall_is_refused() {
    let mut map = map_of(&[false; CELLS], 0.5);
    map.set(START, CellState::Occupied);
    let ground = Ground::<CELLS>::new(&map, &mut planner(), START);
    assert_eq!(ground, Err(GroundError::StartNotFree));
}
