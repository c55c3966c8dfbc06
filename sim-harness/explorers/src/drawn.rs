//! The map that several robots have drawn together.

use grid_map::{Cell, CellState, Frame};
use robot_maps::{Cell as MapCell, Occupancy};

/// The map of all robots, of which `states` tells what each knows of a cell; they are put together by
/// [`CellState::or`].
pub fn merged<S: Iterator<Item = CellState>>(
    frame: &Frame,
    states: impl Fn(Cell) -> S,
) -> Occupancy {
    let state = |cell| match states(cell).fold(CellState::Unknown, CellState::or) {
        CellState::Occupied => MapCell::Occupied,
        CellState::Free => MapCell::Free,
        CellState::Unknown => MapCell::Unknown,
    };
    let (origin, resolution) = (frame.origin(), f64::from(frame.resolution().0));
    let origin = [f64::from(origin.x), f64::from(origin.y), 0.0];
    let cells = frame.cells().map(state).collect();
    Occupancy::new(usize::from(frame.columns()), cells, resolution, origin)
}
