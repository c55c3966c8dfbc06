//! The cells that a ray passes, in order (Amanatides and Woo, "A fast voxel traversal algorithm for
//! ray tracing", 1987).

use units::Point2;

use crate::frame::{Cell, Frame};

/// Walks from cell to cell along a ray.
#[derive(Clone, Debug)]
pub(crate) struct Ray {
    frame: Frame,
    /// The cell that comes next; `None` at the end.
    next: Option<Cell>,
    last: Option<Cell>,
    /// The sides that are still to be crossed.
    crossings_left: u32,
    axes: [Axis; 2],
}

/// The crossings of a ray with the sides of the cells, along one axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// The direction: −1, 0 or 1.
    step: i16,
    /// The part of the ray before the next crossing, and between two.
    next: f32,
    between: f32,
}

impl Axis {
    /// The axis of a ray that begins at `from`, in cells, and is `length` cells long.
    fn new(from: f32, length: f32) -> Self {
        // Beginnings lie within the grid, where the conversion is exact.
        let inside = from - f32::from(from as u16);
        if length > 0.0 {
            Self { step: 1, next: (1.0 - inside) / length, between: 1.0 / length }
        } else if length < 0.0 {
            Self { step: -1, next: inside / -length, between: 1.0 / -length }
        } else {
            Self { step: 0, next: f32::INFINITY, between: f32::INFINITY }
        }
    }
}

impl Ray {
    pub(crate) fn new(frame: &Frame, from: Point2, to: Point2) -> Self {
        let (first, last) = (frame.cell_at(from), frame.cell_at(to));
        let ([x, y], [to_x, to_y]) = (frame.in_cells(from), frame.in_cells(to));
        let is_finite = to_x.is_finite() && to_y.is_finite();
        let crossings = |a: u16, b: u16| u32::from(a.abs_diff(b));
        Self {
            frame: *frame,
            next: first.filter(|_| is_finite),
            last,
            // To an end outside the grid the ray goes on until it leaves.
            crossings_left: match (first, last) {
                (Some(a), Some(b)) => crossings(a.row, b.row) + crossings(a.column, b.column),
                _ => u32::from(frame.rows()) + u32::from(frame.columns()),
            },
            axes: [Axis::new(x, to_x - x), Axis::new(y, to_y - y)],
        }
    }

    /// The cell after this one.
    fn after(&mut self, cell: Cell) -> Option<Cell> {
        self.crossings_left = self.crossings_left.checked_sub(1)?;
        let [x, y] = &mut self.axes;
        let is_east_west = match self.last {
            // Rounding must not lead the last steps past the end.
            Some(last) if last.column == cell.column => false,
            Some(last) if last.row == cell.row => true,
            _ => x.next < y.next,
        };
        let axis = if is_east_west { x } else { y };
        axis.next += axis.between;
        let step = axis.step;
        self.frame.beside(
            cell,
            if is_east_west { step } else { 0 },
            if is_east_west { 0 } else { step },
        )
    }
}

impl Iterator for Ray {
    /// The cell, and whether it is the one in which the ray ends.
    type Item = (Cell, bool);

    fn next(&mut self) -> Option<Self::Item> {
        let cell = self.next?;
        let is_last = Some(cell) == self.last;
        self.next = if is_last { None } else { self.after(cell) };
        Some((cell, is_last))
    }
}
