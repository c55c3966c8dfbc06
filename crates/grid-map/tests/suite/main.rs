//! Tests of the grid against plain and slow computations of the same.

mod clearance;
mod cone;
mod frontier;
mod map;
mod path;

use grid_map::{Cell, CellState, Frame, GridMap};
use units::{Metres, Point2};

/// A map for tests: at most 32 by 32 cells of 0.1 m.
pub type Map = GridMap<256>;

/// A frame at an odd place.
pub fn frame(columns: u16, rows: u16) -> Frame {
    Frame::new(Point2::new(-1.3, 0.7), Metres(0.1), columns, rows).unwrap()
}

/// The map that a drawing shows, the north on top: `.` free, `#` occupied, anything else unknown.
pub fn drawn(drawing: &str) -> Map {
    let lines: Vec<&[u8]> = drawing.lines().map(|line| line.trim().as_bytes()).collect();
    let lines: Vec<_> = lines.into_iter().filter(|line| !line.is_empty()).rev().collect();
    let mut map = Map::new(frame(lines[0].len() as u16, lines.len() as u16)).unwrap();
    for cell in map.frame().cells() {
        let state = match lines[usize::from(cell.row)][usize::from(cell.column)] {
            b'.' => CellState::Free,
            b'#' => CellState::Occupied,
            _ => CellState::Unknown,
        };
        map.set(cell, state);
    }
    map
}

/// A drawing with other signs for some cells.
pub fn draw(map: &Map, sign: impl Fn(Cell) -> Option<char>) -> String {
    let mut drawing = String::new();
    for row in (0..map.frame().rows()).rev() {
        for column in 0..map.frame().columns() {
            let cell = Cell::new(column, row);
            drawing.push(sign(cell).unwrap_or(match map.state(cell) {
                CellState::Unknown => '?',
                CellState::Free => '.',
                CellState::Occupied => '#',
            }));
        }
        drawing.push('\n');
    }
    drawing
}

/// Any map of at most 32 by 32 cells, with as many unknown and occupied cells in a hundred.
pub fn any_map() -> impl proptest::strategy::Strategy<Value = Map> {
    use proptest::prelude::*;
    (1..=32u16, 1..=32u16, 0..60u32, 0..40u32).prop_flat_map(
        |(columns, rows, unknown, occupied)| {
            let count = usize::from(columns) * usize::from(rows);
            proptest::collection::vec(0..100u32, count).prop_map(move |draws| {
                let mut map = Map::new(frame(columns, rows)).unwrap();
                for (cell, draw) in map.frame().cells().zip(draws) {
                    let state = match draw {
                        draw if draw < unknown => CellState::Unknown,
                        draw if draw < unknown + occupied => CellState::Occupied,
                        _ => CellState::Free,
                    };
                    map.set(cell, state);
                }
                map
            })
        },
    )
}
