//! The map that several robots have drawn together.

use grid_map::{Cell, CellState, Frame};
use robot_maps::{Cell as MapCell, Occupancy};

/// The map of all robots, of which `states` tells what each knows of a cell: occupied where one says so, free where
/// one says so and none occupied.
pub fn merged<S: Iterator<Item = CellState>>(
    frame: &Frame,
    states: impl Fn(Cell) -> S,
) -> Occupancy {
    let state = |cell| {
        states(cell).fold(MapCell::Unknown, |so_far, state| match (so_far, state) {
            (MapCell::Occupied, _) | (_, CellState::Occupied) => MapCell::Occupied,
            (MapCell::Free, _) | (_, CellState::Free) => MapCell::Free,
            _ => MapCell::Unknown,
        })
    };
    let (origin, resolution) = (frame.origin(), f64::from(frame.resolution().0));
    let origin = [f64::from(origin.x), f64::from(origin.y), 0.0];
    let cells = frame.cells().map(state).collect();
    Occupancy::new(usize::from(frame.columns()), cells, resolution, origin)
}
