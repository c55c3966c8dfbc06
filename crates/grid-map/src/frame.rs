//! Relates cells to points of the floor plan.

use core::fmt;

use units::{Metres, Point2};

use crate::ray::Ray;

/// A cell of a grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Cell {
    /// The row, counted from the south.
    pub row: u16,
    /// The column, counted from the west.
    pub column: u16,
}

impl Cell {
    /// The cell of that column and row.
    #[must_use]
    pub const fn new(column: u16, row: u16) -> Self {
        Self { row, column }
    }
}

/// The place, the resolution and the extent of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Frame {
    origin: Point2,
    resolution: f32,
    columns: u16,
    rows: u16,
}

/// A frame that no grid can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FrameError {
    /// The grid has no column or no row.
    Empty,
    /// The origin or the resolution is not finite, or the resolution is not positive.
    NotANumber,
    /// A column or a row has more cells than [`Frame::MOST`].
    TooLong,
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "the grid has no cells"),
            Self::NotANumber => write!(f, "origin and resolution are not finite numbers"),
            Self::TooLong => write!(f, "the grid is longer than {} cells", Frame::MOST),
        }
    }
}

impl Frame {
    /// The most cells of a row or a column.
    pub const MOST: u16 = 8192;

    /// The frame of `columns` by `rows` square cells with sides of `resolution`, whose south-western
    /// corner is `origin`.
    ///
    /// # Errors
    /// [`FrameError`] where no grid can lie so.
    pub const fn new(
        origin: Point2,
        resolution: Metres,
        columns: u16,
        rows: u16,
    ) -> Result<Self, FrameError> {
        if columns == 0 || rows == 0 {
            return Err(FrameError::Empty);
        }
        if columns > Self::MOST || rows > Self::MOST {
            return Err(FrameError::TooLong);
        }
        if !origin.is_finite() || !resolution.0.is_finite() || resolution.0 <= 0.0 {
            return Err(FrameError::NotANumber);
        }
        Ok(Self { origin, resolution: resolution.0, columns, rows })
    }

    /// The south-western corner.
    #[must_use]
    pub const fn origin(&self) -> Point2 {
        self.origin
    }

    /// The side of a cell.
    #[must_use]
    pub const fn resolution(&self) -> Metres {
        Metres(self.resolution)
    }

    /// The number of columns.
    #[must_use]
    pub const fn columns(&self) -> u16 {
        self.columns
    }

    /// The number of rows.
    #[must_use]
    pub const fn rows(&self) -> u16 {
        self.rows
    }

    /// The number of cells.
    #[must_use]
    pub const fn cell_count(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Whether the cell is one of this grid's.
    #[must_use]
    pub const fn contains(&self, cell: Cell) -> bool {
        cell.column < self.columns && cell.row < self.rows
    }

    /// The cell in which a point lies; `None` outside the grid.
    #[must_use]
    pub fn cell_at(&self, point: Point2) -> Option<Cell> {
        let [x, y] = self.in_cells(point);
        let inside =
            x >= 0.0 && y >= 0.0 && x < f32::from(self.columns) && y < f32::from(self.rows);
        // Of a number within the grid the conversion cuts off the fraction.
        inside.then_some(Cell { column: x as u16, row: y as u16 })
    }

    /// The cell in which a point lies, or the one nearest to it.
    pub(crate) fn nearest(&self, point: Point2) -> Cell {
        let [x, y] = self.in_cells(point);
        // A conversion takes what is too large or too small for the nearest number.
        Cell { column: (x as u16).min(self.columns - 1), row: (y as u16).min(self.rows - 1) }
    }

    /// The middle of a cell.
    #[must_use]
    pub fn centre(&self, cell: Cell) -> Point2 {
        let at = |n: u16| (f32::from(n) + 0.5) * self.resolution;
        Point2::new(self.origin.x + at(cell.column), self.origin.y + at(cell.row))
    }

    /// All cells, row by row from the south, each from the west.
    pub fn cells(&self) -> impl Iterator<Item = Cell> + use<> {
        let columns = self.columns;
        (0..self.rows).flat_map(move |row| (0..columns).map(move |column| Cell { row, column }))
    }

    /// The cell that lies so many columns east and rows north of another; `None` outside the grid.
    #[must_use]
    pub const fn beside(&self, cell: Cell, east: i16, north: i16) -> Option<Cell> {
        match (cell.column.checked_add_signed(east), cell.row.checked_add_signed(north)) {
            (Some(column), Some(row)) if column < self.columns && row < self.rows => {
                Some(Cell { row, column })
            }
            _ => None,
        }
    }

    /// The cells of the grid that share a side with this one.
    pub fn sides(&self, cell: Cell) -> impl Iterator<Item = Cell> + use<> {
        let frame = *self;
        [(1, 0), (0, 1), (-1, 0), (0, -1)]
            .into_iter()
            .filter_map(move |(east, north)| frame.beside(cell, east, north))
    }

    /// The cells of the grid through which a line leads, in order, from the one in which it begins;
    /// none where it begins outside the grid.
    pub fn line(&self, from: Point2, to: Point2) -> impl Iterator<Item = Cell> + use<> {
        Ray::new(self, from, to).map(|(cell, _)| cell)
    }

    /// The cell's number, row by row from the south.
    #[must_use]
    pub const fn number(&self, cell: Cell) -> usize {
        self.index(cell)
    }

    /// The cell's number, row by row.
    pub(crate) const fn index(&self, cell: Cell) -> usize {
        cell.row as usize * self.columns as usize + cell.column as usize
    }

    /// A point in cells east and north of the origin.
    pub(crate) fn in_cells(&self, point: Point2) -> [f32; 2] {
        [(point.x - self.origin.x) / self.resolution, (point.y - self.origin.y) / self.resolution]
    }
}
