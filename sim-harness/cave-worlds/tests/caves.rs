//! What must be true of every cave, and of the worlds that maps make.

use cave_worlds::{Cave, World, WorldError, WorldPlanner, measure};
use grid_map::CellState;
use relay_placement::{Curve, Demand, Network, Plan, Rule};
use robot_maps::{Cell, Occupancy};

#[test]
fn a_cave_is_closed_and_its_entrance_free() {
    for seed in 0..5 {
        let Cave { map, entrance } = Cave::dig(seed);
        assert_eq!(map.state(entrance), CellState::Free);
        let frame = map.frame();
        let is_border = |n: u16| n == 0 || n == cave_worlds::SIDE - 1;
        let border = frame.cells().filter(|cell| is_border(cell.row) || is_border(cell.column));
        assert!(border.into_iter().all(|cell| map.state(cell) == CellState::Occupied));
    }
}

#[test]
fn the_relays_of_our_rule_are_linked() {
    let rows = measure(&World::dig(3), 2, 3).unwrap();
    for row in rows.iter().filter(|row| row.rule == Rule::Ours) {
        assert_eq!(row.nodes, 2);
        assert!(row.link_margin_db.is_some_and(|margin| margin >= 0.0), "{row:?}");
    }
    assert!(rows.iter().all(|row| row.of_bound.is_some_and(|share| share <= 1.0)), "{rows:?}");
}

/// With goals in dead ends, eight relays put down one by one covered 0.671 of what the best steps
/// cover.
#[test]
fn eight_relays_of_the_cave_200090_are_not_led_into_dead_ends() {
    let world = World::dig(200_090);
    let ground = world.ground(&mut WorldPlanner::new()).unwrap();
    let mut network = Network::new(&ground, Curve::DEFAULT);
    network.add(&ground, ground.frame().centre(world.base));
    let plan = Plan::new(&ground, &network, &Demand::DEFAULT, 8);
    let most = plan.at_most_cells(&ground, &network, 8);
    assert_eq!(plan.places().len(), 8);
    assert!(plan.gain_cells() as f32 >= 0.75 * most as f32, "{} of {most}", plan.gain_cells());
}

/// A room of 500 by 300 cells of 5 cm with a wall around it, and its lower left corner at (−5, −5).
fn room() -> Occupancy {
    let is_wall = |n: usize| [0, 499].contains(&(n % 500)) || [0, 299].contains(&(n / 500));
    let cells = (0..150_000).map(|n| if is_wall(n) { Cell::Occupied } else { Cell::Free });
    Occupancy::new(500, cells.collect(), 0.05, [-5.0, -5.0, 0.3])
}

#[test]
fn a_large_map_is_made_coarser_and_keeps_its_walls() {
    let world = World::of("room", &room(), None).unwrap();
    let frame = world.map.frame();
    assert_eq!((frame.columns(), frame.rows()), (250, 150));
    assert!((frame.resolution().0 - 0.1).abs() < 1e-6);
    let is_border = |cell: &grid_map::Cell| cell.column == 0 || cell.row == 0;
    let mut border = frame.cells().filter(is_border);
    assert!(border.all(|cell| world.map.state(cell) == CellState::Occupied));
    let [x, y] = world.in_file(frame.centre(world.base));
    assert!(x.hypot(y) < 0.15, "the base is at {x}, {y}");
    world.ground(&mut WorldPlanner::new()).unwrap();
}

/// A gallery of 200 m by 2 m in cells of 5 cm had no free cell left, because blocks of 1 m were made of
/// it: as many as a square map of that length takes.
#[test]
fn a_long_narrow_map_keeps_its_passage() {
    let is_wall = |n: usize| [0, 39].contains(&(n % 40)) || [0, 3999].contains(&(n / 40));
    let cells = (0..160_000).map(|n| if is_wall(n) { Cell::Occupied } else { Cell::Free });
    let gallery = Occupancy::new(40, cells.collect(), 0.05, [-1.0, 0.0, 0.0]);
    let world = World::of("gallery", &gallery, None).unwrap();
    let frame = world.map.frame();
    assert_eq!((frame.columns(), frame.rows()), (20, 2000));
    let ground = world.ground(&mut WorldPlanner::new()).unwrap();
    assert_eq!(ground.reached().count(), 18 * 1998);
}

/// A passage of one cell that is lost where cells are put together is not "no free cell".
#[test]
fn a_passage_that_is_lost_is_told_from_a_map_without_free_cells() {
    let cells = (0..1_000_000).map(|n| if n / 1000 == 500 { Cell::Free } else { Cell::Occupied });
    let narrow = Occupancy::new(1000, cells.collect(), 0.5, [0.0; 3]);
    assert_eq!(World::of("narrow", &narrow, None), Err(WorldError::NoFreeBlock(2.5)));
}

#[test]
fn a_base_that_cannot_stand_is_refused() {
    let refused = |base| World::of("room", &room(), Some(base)).unwrap_err();
    assert!(matches!(refused([100.0, 0.0]), WorldError::BaseOutside(_)));
    assert!(matches!(refused([f64::NAN, 0.0]), WorldError::BaseOutside(_)));
    assert!(matches!(refused([-5.0, -4.99]), WorldError::BaseNotFree(_)));
    let solid = Occupancy::new(10, vec![Cell::Occupied; 100], 0.5, [0.0; 3]);
    assert_eq!(World::of("solid", &solid, None), Err(WorldError::NoFreeCell));
}
