//! Distances from obstacles.

use grid_map::{CellState, Clearance, FARTHEST_CLEARANCE, TooManyCells};
use proptest::prelude::*;

use super::{any_map, drawn, frame};

type ClearanceOfTests = Clearance<1024>;

proptest! {
    #[test]
    fn clearance_is_the_distance_to_the_nearest_obstacle(map in any_map()) {
        let mut clearance = ClearanceOfTests::new(frame(1, 1)).unwrap();
        clearance.update(&map).unwrap();
        let is_obstacle = |cell: &grid_map::Cell| map.state(*cell) == CellState::Occupied;
        let obstacles: Vec<_> = map.frame().cells().filter(is_obstacle).collect();
        let most = u32::from(FARTHEST_CLEARANCE).pow(2);
        for cell in map.frame().cells() {
            let squares = obstacles.iter().map(|obstacle| {
                let rows = u32::from(cell.row.abs_diff(obstacle.row));
                let columns = u32::from(cell.column.abs_diff(obstacle.column));
                rows * rows + columns * columns
            });
            let nearest = squares.min().filter(|&square| square <= most);
            prop_assert_eq!(clearance.squared(cell).map(u32::from), nearest, "{:?}", cell);
        }
    }
}

#[test]
fn a_map_that_is_too_large_changes_nothing() {
    let map = drawn("..#\n...");
    let mut small = Clearance::<5>::new(frame(1, 1)).unwrap();
    let before = small.clone();
    assert_eq!(small.update(&map), Err(TooManyCells { cells: 6, room: 5 }));
    assert_eq!(small, before);
    assert!(Clearance::<5>::new(frame(3, 2)).is_err());
}
