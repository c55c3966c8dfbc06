//! Defines the occupancy map: a grid of cells that are free, occupied or unknown.

use cave_survey::Warning;

/// The state of one cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// Nothing stands in it.
    Free,
    /// Something stands in it.
    Occupied,
    /// Nothing is known of it.
    Unknown,
}

/// The most cells of a map: 400 m by 400 m of 0.1 m, and 16 MB in memory.
pub(crate) const MOST_CELLS: usize = 16_000_000;

/// An occupancy map.
#[derive(Clone, Debug, PartialEq)]
pub struct Occupancy {
    /// The number of cells along x.
    columns: usize,
    /// Row-major, from the lower left cell.
    cells: Vec<Cell>,
    /// The edge of a cell, m.
    pub resolution_m: f64,
    /// The lower left corner of the lower left cell: x and y in metres, and the yaw of the map about
    /// it in radians.
    pub origin: [f64; 3],
    /// The remarks of the reader.
    pub warnings: Vec<Warning>,
}

impl Occupancy {
    /// Makes a map of so many columns; the cells of an incomplete last row are left out.
    #[must_use]
    pub fn new(columns: usize, mut cells: Vec<Cell>, resolution_m: f64, origin: [f64; 3]) -> Self {
        let columns = columns.max(1);
        cells.truncate(cells.len() / columns * columns);
        Self { columns, cells, resolution_m, origin, warnings: Vec::new() }
    }

    /// The number of cells along x.
    #[must_use]
    pub const fn columns(&self) -> usize {
        self.columns
    }

    /// The number of cells along y.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.cells.len() / self.columns
    }

    /// All cells, row by row from the lower left one.
    #[must_use]
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The state of a cell; unknown outside the map.
    #[must_use]
    pub fn cell(&self, column: usize, row: usize) -> Cell {
        if column >= self.columns {
            return Cell::Unknown;
        }
        self.cells.get(row * self.columns + column).copied().unwrap_or(Cell::Unknown)
    }

    /// The number of cells in this state.
    #[must_use]
    pub fn count(&self, state: Cell) -> usize {
        self.cells.iter().filter(|cell| **cell == state).count()
    }

    /// The place of a point of the grid, given in cells from the lower left corner, in metres.
    #[must_use]
    pub fn place(&self, column: f64, row: f64) -> [f64; 2] {
        let [x, y, yaw] = self.origin;
        let (east, north) = (column * self.resolution_m, row * self.resolution_m);
        let (sin, cos) = yaw.sin_cos();
        [x + cos * east - sin * north, y + sin * east + cos * north]
    }

    /// The point of the grid, in cells from the lower left corner, at a place in metres.
    #[must_use]
    pub fn grid(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (dx, dy) = (x - self.origin[0], y - self.origin[1]);
        let (sin, cos) = self.origin[2].sin_cos();
        [(cos * dx + sin * dy) / self.resolution_m, (cos * dy - sin * dx) / self.resolution_m]
    }
}
