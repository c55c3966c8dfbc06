//! Frontiers and their gains.

use grid_map::{CellState, MOST_GAIN};
use proptest::prelude::*;

use super::{any_map, draw, drawn};

#[test]
fn frontiers_are_free_cells_beside_unknown_ones() {
    let map = drawn(
        "
        ?????????
        ?#######?
        ?#.....??
        ?#.....??
        ?#.......
        ?########",
    );
    let frontiers = draw(&map, |cell| map.is_frontier(cell).then_some('F'));
    let expected = "
?????????
?#######?
?#....F??
?#....F??
?#.....FF
?########
";
    assert_eq!(frontiers, expected.trim_start());
    assert_eq!(map.frontiers().count(), 4);
}

proptest! {
    #[test]
    fn gains_count_what_is_unknown_around(map in any_map()) {
        for cell in map.frame().cells() {
            let within = |a: u16, b: u16| a.abs_diff(b) <= 3;
            let counts = |other: &grid_map::Cell| {
                *other != cell && within(other.row, cell.row) && within(other.column, cell.column)
            };
            let around = map.frame().cells().filter(counts);
            let unknown = around.filter(|&other| map.state(other) == CellState::Unknown).count();
            prop_assert_eq!(usize::from(map.gain(cell)), unknown);
            prop_assert!(map.gain(cell) <= MOST_GAIN);
        }
    }

    /// A cell beside an unknown one of the grid is a frontier exactly where it is free.
    #[test]
    fn where_nothing_is_unknown_there_is_no_frontier(map in any_map()) {
        for cell in map.frame().cells() {
            let beside = map.frame().cells().filter(|other| {
                other.row.abs_diff(cell.row) + other.column.abs_diff(cell.column) == 1
            });
            let touches = beside.into_iter().any(|other| map.state(other) == CellState::Unknown);
            let is_free = map.state(cell) == CellState::Free;
            prop_assert_eq!(map.is_frontier(cell), is_free && touches);
        }
    }
}
