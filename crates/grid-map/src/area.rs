//! A rectangle of cells: where something has changed, so that nothing else need be looked at again.

use core::ops::RangeInclusive;

use crate::frame::{Cell, Frame};

/// A rectangle of at least one cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Area {
    first: Cell,
    last: Cell,
}

impl Area {
    /// One cell.
    #[must_use]
    pub const fn of(cell: Cell) -> Self {
        Self { first: cell, last: cell }
    }

    /// All cells of a grid.
    #[must_use]
    pub const fn whole(frame: &Frame) -> Self {
        // A grid has a row and a column at least.
        let last = Cell::new(frame.columns() - 1, frame.rows() - 1);
        Self { first: Cell::new(0, 0), last }
    }

    /// The smallest rectangle that holds this one and another.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let (a, b) = (self, other);
        Self {
            first: Cell::new(a.first.column.min(b.first.column), a.first.row.min(b.first.row)),
            last: Cell::new(a.last.column.max(b.last.column), a.last.row.max(b.last.row)),
        }
    }

    /// The smallest rectangle that holds this one and another, where there is another.
    #[must_use]
    pub fn and_maybe(self, other: Option<Self>) -> Self {
        other.map_or(self, |other| self.and(other))
    }

    /// The rectangle that is larger by so many cells to each side, as far as the grid goes.
    #[must_use]
    pub fn grown(self, by: u16, frame: &Frame) -> Self {
        let Self { first, last } = self;
        let end = Self::whole(frame).last;
        Self {
            first: Cell::new(first.column.saturating_sub(by), first.row.saturating_sub(by)),
            last: Cell::new(
                last.column.saturating_add(by).min(end.column),
                last.row.saturating_add(by).min(end.row),
            ),
        }
    }

    /// The columns, counted from the west.
    #[must_use]
    pub const fn columns(self) -> RangeInclusive<u16> {
        self.first.column..=self.last.column
    }

    /// The rows, counted from the south.
    #[must_use]
    pub const fn rows(self) -> RangeInclusive<u16> {
        self.first.row..=self.last.row
    }

    /// The part of the rectangle from a row on; `None` where it has no such row.
    #[must_use]
    pub const fn from_row(self, row: u16) -> Option<Self> {
        if row > self.last.row {
            return None;
        }
        let first = if row > self.first.row { row } else { self.first.row };
        Some(Self { first: Cell::new(self.first.column, first), last: self.last })
    }

    /// All cells, row by row from the south, each from the west.
    pub fn cells(self) -> impl Iterator<Item = Cell> + use<> {
        self.rows().flat_map(move |row| self.columns().map(move |column| Cell::new(column, row)))
    }
}
