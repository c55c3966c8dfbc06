//! What must be true of every cave.

use cave_worlds::{Cave, measure};
use grid_map::CellState;
use relay_placement::Rule;

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
    for row in measure(3, 2).iter().filter(|row| row.rule == Rule::Ours) {
        assert_eq!(row.nodes, 2);
        assert!(row.link_margin_db >= 0.0, "{row:?}");
    }
}
