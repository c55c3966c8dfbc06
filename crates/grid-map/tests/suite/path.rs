//! Shortest paths.

use std::collections::HashMap;
use std::ops::ControlFlow;

use grid_map::{
    Cell, CellState, DIAGONAL_COST, Frame, PathError, Planner, STRAIGHT_COST, TooManyCells, Visit,
};
use proptest::prelude::*;
use units::{Metres, Point2};

use super::{Map, any_map, draw, drawn};

type PlannerOfTests = Planner<512, 2048>;

/// Free cells can be entered; the factor varies from cell to cell.
fn factor(map: &Map, cell: Cell) -> Option<u8> {
    let is_free = map.state(cell) == CellState::Free;
    is_free.then_some(1 + ((cell.row * 7 + cell.column * 3) % 4) as u8)
}

fn costs(planner: &mut PlannerOfTests, map: &Map, start: Cell) -> HashMap<Cell, u32> {
    let mut costs = HashMap::new();
    let visit = |Visit { cell, cost }| {
        assert_eq!(costs.insert(cell, cost), None, "{cell:?} is visited twice");
        ControlFlow::Continue(())
    };
    planner.search(map.frame(), start, |cell| factor(map, cell), visit).unwrap();
    costs
}

/// The cost of one step; `None` where it is not allowed.
fn step(map: &Map, from: Cell, to: Cell) -> Option<u32> {
    let factor_of = |cell| factor(map, cell).map(u32::from);
    match (from.row.abs_diff(to.row), from.column.abs_diff(to.column)) {
        (0, 1) | (1, 0) => Some(STRAIGHT_COST * factor_of(to)?),
        (1, 1) => {
            factor_of(Cell::new(from.column, to.row))?;
            factor_of(Cell::new(to.column, from.row))?;
            Some(DIAGONAL_COST * factor_of(to)?)
        }
        _ => None,
    }
}

proptest! {
    /// The costs satisfy Bellman's equation, which has one solution.
    #[test]
    fn costs_are_those_of_the_cheapest_ways(map in any_map(), column in 0..32u16, row in 0..32u16) {
        let start = Cell::new(column % map.frame().columns(), row % map.frame().rows());
        let mut planner = PlannerOfTests::new();
        let costs = costs(&mut planner, &map, start);
        prop_assert_eq!(costs.get(&start), Some(&0));
        for cell in map.frame().cells().filter(|&cell| cell != start) {
            let around = (-1..=1).flat_map(|north| (-1..=1).map(move |east| (east, north)));
            let from = around.filter_map(|(east, north)| map.frame().beside(cell, east, north));
            let through = from.filter_map(|from| Some(costs.get(&from)? + step(&map, from, cell)?));
            prop_assert_eq!(costs.get(&cell).copied(), through.min(), "{:?}", cell);
        }
        for (&cell, &cost) in &costs {
            let way: Vec<Cell> = planner.way_back(cell).collect();
            prop_assert_eq!(way.last(), Some(&start));
            let steps = way.windows(2).map(|pair| step(&map, pair[1], pair[0]).unwrap());
            prop_assert_eq!(steps.sum::<u32>(), cost);
        }
    }

    /// Cells come in the order of their costs.
    #[test]
    fn cheapest_cells_come_first(map in any_map()) {
        let mut last = 0;
        let visit = |Visit { cost, .. }| {
            assert!(cost >= last);
            last = cost;
            ControlFlow::Continue(())
        };
        let mut planner = PlannerOfTests::new();
        planner.search(map.frame(), Cell::new(0, 0), |cell| factor(&map, cell), visit).unwrap();
    }
}

#[test]
fn ways_lead_round_walls_and_not_between_two_corners() {
    let map = drawn(
        "
        .......
        .#####.
        .#...#.
        .#.S.#.
        .##.##.
        .......",
    );
    let start = Cell::new(3, 2);
    let goal = Cell::new(3, 5);
    let mut planner = PlannerOfTests::new();
    let is_free = |cell: Cell| (map.state(cell) == CellState::Free).then_some(1);
    planner.search(map.frame(), start, is_free, |_| ControlFlow::Continue(())).unwrap();
    let way: Vec<Cell> = planner.way_back(goal).collect();
    let drawing = draw(&map, |cell| way.contains(&cell).then_some('o'));
    let left = "
oooo...
o#####.
o#...#.
o#.o.#.
o##o##.
oooo...
";
    let right = left.lines().map(|line| line.chars().rev().collect::<String>() + "\n");
    let shortest =
        [left.trim_start().to_owned(), right.collect::<String>().trim_start().to_owned()];
    assert!(shortest.contains(&drawing), "{drawing}");
}

#[test]
fn a_search_ends_when_it_is_told_to() {
    let map = drawn("..........");
    let mut planner = PlannerOfTests::new();
    let mut visited = 0;
    let visit = |Visit { cell, .. }| {
        visited += 1;
        if cell.column == 4 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    planner.search(map.frame(), Cell::new(0, 0), |_| Some(1), visit).unwrap();
    assert_eq!(visited, 5);
    assert_eq!(planner.way_back(Cell::new(4, 0)).count(), 5);
    assert_eq!(planner.way_back(Cell::new(7, 0)).count(), 0);
}

#[test]
fn what_cannot_be_searched_is_an_error() {
    let map = drawn("...\n...");
    let go_on = |_| ControlFlow::Continue(());
    let free = |_| Some(1);
    let mut small = Planner::<2, 64>::new();
    let refused = small.search(map.frame(), Cell::new(0, 0), free, go_on);
    assert_eq!(refused, Err(PathError::TooManyCells(TooManyCells { cells: 6, room: 4 })));
    let mut planner = Planner::<3, 3>::new();
    assert_eq!(planner.search(map.frame(), Cell::new(3, 0), free, go_on), Err(PathError::NoStart));
    assert_eq!(planner.search(map.frame(), Cell::new(1, 0), free, go_on), Err(PathError::PoolFull));
    // An error leaves nothing behind.
    assert_eq!(planner.search(map.frame(), Cell::new(0, 0), |_| None, go_on), Ok(()));
}

/// The room for waiting cells that the documentation asks for.
#[test]
fn an_open_grid_of_n_by_n_needs_room_for_sixteen_n() {
    let frame = Frame::new(Point2::default(), Metres(0.1), 160, 160).unwrap();
    let mut planner = Box::new(Planner::<12_800, 2_560>::new());
    for start in [Cell::new(80, 80), Cell::new(0, 0), Cell::new(159, 70)] {
        let mut visited = 0;
        let visit = |_| {
            visited += 1;
            ControlFlow::Continue(())
        };
        planner.search(&frame, start, |_| Some(1), visit).unwrap();
        assert_eq!(visited, 25_600);
    }
}
