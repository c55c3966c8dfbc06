//! Digs a cave.

use std::f32::consts::TAU;

use grid_map::{Cell, CellState, Frame, GridMap};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use units::{Metres, Point2};

/// The cells of a row or a column.
pub const SIDE: u16 = 200;
/// The bytes of the map, four cells in each.
pub(crate) const MAP_BYTES: usize = SIDE as usize * SIDE as usize / 4;
/// The side of a cell, m.
const RESOLUTION: f32 = 0.5;
/// The number of corridors, and the ranges of their lengths and half widths, m. They are chosen so
/// that a cave fills its map and one relay covers a part of it.
const CORRIDORS: usize = 40;
const LENGTHS: [f32; 2] = [10.0, 40.0];
const HALF_WIDTHS: [f32; 2] = [1.0, 3.0];
/// The most that a corridor turns between two steps of half a metre, rad.
const MOST_TURN: f32 = 0.15;

/// A cave, dug from its seed alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Cave {
    /// The map, of which every cell is known.
    pub map: GridMap<MAP_BYTES>,
    /// The cell at which the first corridor begins.
    pub entrance: Cell,
}

impl Cave {
    /// Digs the cave of a seed.
    ///
    /// # Panics
    /// Never: the frame has the size that the map is made for.
    #[must_use]
    pub fn dig(seed: u64) -> Self {
        let frame = Frame::new(Point2::new(0.0, 0.0), Metres(RESOLUTION), SIDE, SIDE)
            .expect("a frame of constants");
        let mut map = GridMap::new(frame).expect("the map has room for its frame");
        for cell in frame.cells() {
            map.set(cell, CellState::Occupied);
        }
        let entrance = Cell::new(SIDE / 2, SIDE / 2);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut between = |[least, most]: [f32; 2]| {
            least + (most - least) * (random.next_u32() >> 8) as f32 / (1 << 24) as f32
        };
        let mut dug = vec![frame.centre(entrance)];
        for _ in 0..CORRIDORS {
            let from = between([0.0, dug.len() as f32]) as usize;
            let mut at = dug[from.min(dug.len() - 1)];
            let mut heading = between([0.0, TAU]);
            let half_width = between(HALF_WIDTHS);
            for _ in 0..(between(LENGTHS) / RESOLUTION) as usize {
                carve(&mut map, at, half_width);
                dug.push(at);
                heading += between([-MOST_TURN, MOST_TURN]);
                let next = Point2::new(
                    at.x + RESOLUTION * heading.cos(),
                    at.y + RESOLUTION * heading.sin(),
                );
                let is_inside = |v: f32| (1.0..f32::from(SIDE) * RESOLUTION - 1.0).contains(&v);
                if !is_inside(next.x) || !is_inside(next.y) {
                    break;
                }
                at = next;
            }
        }
        Self { map, entrance }
    }
}

/// Frees the cells around a point, but for the outermost ones of the map.
fn carve(map: &mut GridMap<MAP_BYTES>, at: Point2, radius: f32) {
    let frame = *map.frame();
    let Some(middle) = frame.cell_at(at) else { return };
    let reach = (radius / RESOLUTION) as i16 + 1;
    for north in -reach..=reach {
        for east in -reach..=reach {
            let Some(cell) = frame.beside(middle, east, north) else { continue };
            let centre = frame.centre(cell);
            let is_border = |n: u16| n == 0 || n == SIDE - 1;
            let is_near = (centre.x - at.x).hypot(centre.y - at.y) <= radius;
            if is_near && !is_border(cell.row) && !is_border(cell.column) {
                map.set(cell, CellState::Free);
            }
        }
    }
}
