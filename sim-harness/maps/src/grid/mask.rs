//! Sets of cells, with a border of one cell that belongs to none.

use std::collections::VecDeque;

use robot_maps::{Cell, Occupancy};

/// What stands in free space and is smaller than this both ways is a speck, m: a drone is 0.16 m wide
/// over its guards.
const SPECK_M: f64 = 0.15;

/// A set of cells.
#[derive(Clone)]
pub(super) struct Mask {
    /// The number of columns, with the border.
    pub(super) width: usize,
    /// Whether each cell belongs to the set, row by row from the lower left one.
    pub(super) cells: Vec<bool>,
}

impl Mask {
    /// The free cells of a map, and the specks among them.
    pub(super) fn free(map: &Occupancy) -> Self {
        let width = map.columns() + 2;
        let mut cells = vec![false; width * (map.rows() + 2)];
        for (row, states) in map.cells().chunks_exact(map.columns()).enumerate() {
            for (column, state) in states.iter().enumerate() {
                cells[(row + 1) * width + column + 1] = *state == Cell::Free;
            }
        }
        let mut mask = Self { width, cells };
        mask.clear_specks(SPECK_M / map.resolution_m);
        mask
    }

    /// The column and the row of a cell in the map.
    pub(super) fn cell(&self, cell: usize) -> (usize, usize) {
        ((cell % self.width).saturating_sub(1), (cell / self.width).saturating_sub(1))
    }

    /// The four cells beside a cell that is not on the border: east, north, west, south.
    pub(super) const fn beside(&self, cell: usize) -> [usize; 4] {
        [cell + 1, cell + self.width, cell - 1, cell - self.width]
    }

    /// The eight cells around a cell that is not on the border, counter-clockwise from the east.
    pub(super) const fn ring(&self, cell: usize) -> [usize; 8] {
        let (above, below) = (cell + self.width, cell - self.width);
        [cell + 1, above + 1, above, above - 1, cell - 1, below - 1, below, below + 1]
    }

    fn is_inner(&self, cell: usize) -> bool {
        let column = cell % self.width;
        let row = cell / self.width;
        column > 0
            && column + 1 < self.width
            && row > 0
            && (row + 1) * self.width < self.cells.len()
    }

    /// Frees groups of cells that are smaller than this both ways, in cells.
    fn clear_specks(&mut self, size: f64) {
        let mut seen = self.cells.clone();
        for start in 0..self.cells.len() {
            if seen[start] || !self.is_inner(start) {
                continue;
            }
            let (mut group, mut next) = (vec![start], 0);
            let (mut low, mut high) = (self.cell(start), self.cell(start));
            let mut is_closed = true;
            seen[start] = true;
            while let Some(&cell) = group.get(next) {
                next += 1;
                let at = self.cell(cell);
                low = (low.0.min(at.0), low.1.min(at.1));
                high = (high.0.max(at.0), high.1.max(at.1));
                for other in self.ring(cell) {
                    is_closed &= self.is_inner(other);
                    if !seen[other] && self.is_inner(other) {
                        seen[other] = true;
                        group.push(other);
                    }
                }
            }
            let extent = 1 + (high.0 - low.0).max(high.1 - low.1);
            if is_closed && extent as f64 <= size {
                group.into_iter().for_each(|cell| self.cells[cell] = true);
            }
        }
    }

    /// The part of the set that a disc of this radius covers which fits into it, in cells, where
    /// `squares` are the squares of the distances of its cells from all others.
    pub(super) fn opened(&self, squares: &[f32], radius: f32) -> Self {
        let fits = |cell: &f32| *cell >= radius * radius;
        let centres =
            Self { width: self.width, cells: squares.iter().map(|it| !fits(it)).collect() };
        let near = super::distance::squares(&centres);
        let covered = near.iter().map(|square| *square < radius * radius);
        let cells = covered.zip(&self.cells).map(|(covered, member)| covered && *member).collect();
        Self { width: self.width, cells }
    }

    /// The cells that are joined to this one side by side.
    pub(super) fn around(&self, start: usize) -> Self {
        let mut cells = vec![false; self.cells.len()];
        let mut queue = VecDeque::from([start]);
        cells[start] = self.cells[start];
        while let Some(cell) = queue.pop_front() {
            for other in self.beside(cell) {
                if self.cells[other] && !cells[other] {
                    cells[other] = true;
                    queue.push_back(other);
                }
            }
        }
        Self { width: self.width, cells }
    }

    /// A cell of the largest group of cells that are joined side by side.
    pub(super) fn in_largest(&self) -> Option<usize> {
        let mut seen = vec![false; self.cells.len()];
        let mut best = (0, None);
        for start in 0..self.cells.len() {
            if seen[start] || !self.cells[start] {
                continue;
            }
            let (mut group, mut count) = (vec![start], 0);
            seen[start] = true;
            while let Some(cell) = group.pop() {
                count += 1;
                for other in self.beside(cell) {
                    if self.cells[other] && !seen[other] {
                        seen[other] = true;
                        group.push(other);
                    }
                }
            }
            if count > best.0 {
                best = (count, Some(start));
            }
        }
        best.1
    }

    /// The ends that are given of a way through the set, and for each that is not the roomy cell that is
    /// farthest from the other; with none given that is the one farthest from `start`.
    pub(super) fn with_far_ends(
        &self,
        given: Vec<usize>,
        start: usize,
        is_roomy: impl Fn(usize) -> bool,
    ) -> Vec<usize> {
        let away = |one: usize, other: usize| {
            let ((x, y), (to_x, to_y)) = (self.cell(one), self.cell(other));
            x.abs_diff(to_x).pow(2) + y.abs_diff(to_y).pow(2)
        };
        let members = || (0..self.cells.len()).filter(|cell| self.cells[*cell] && is_roomy(*cell));
        let mut ends = given;
        while ends.len() < 2 {
            let from = ends.first().copied().unwrap_or(start);
            let Some(farthest) = members().max_by_key(|cell| away(*cell, from)) else { break };
            ends.push(farthest);
        }
        ends
    }

    /// The cell of the set that is nearest to a point of the map, in cells, and no farther than this.
    pub(super) fn nearest(&self, [column, row]: [f64; 2], most: f64) -> Option<usize> {
        let away = |cell: usize| {
            let (x, y) = self.cell(cell);
            (x as f64 + 0.5 - column).hypot(y as f64 + 0.5 - row)
        };
        let members = (0..self.cells.len()).filter(|cell| self.cells[*cell]);
        let near = members.filter(|cell| away(*cell) <= most.max(1.0));
        near.min_by(|a, b| away(*a).total_cmp(&away(*b)))
    }
}
