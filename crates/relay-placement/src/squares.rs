//! Sums over the cells to which a way of the reach of a relay leads, and the best place by them.
//!
//! A sum takes a search. Within a [square](side) of cells it is computed once, for the first of them that
//! comes into question. As relays are added, fewer cells are left to cover, so a sum only falls: the
//! last one bounds it from above, and before the first one the sum over all cells within the reach on
//! open ground does. [`Squares`] searches where the bound can still be the best only (M. Minoux,
//! "Accelerated greedy algorithms for maximizing submodular set functions", 1978).

use core::cmp::Reverse;
use core::ops::ControlFlow;

use grid_map::{Cell, PathError, Planner, STRAIGHT_COST};
use units::Metres;

use crate::ground::Ground;
use crate::place::{Demand, Shortlist};

/// The side of the squares: a tenth of the reach of a relay. It is a choice, for speed.
const BLOCK: Metres = Metres(2.0);
/// The longest side of a square, cells: its cells are counted in 16 bits.
const LONGEST_SIDE: f32 = 255.0;

/// The side of the squares, cells.
pub(crate) fn side<const CELLS: usize>(ground: &Ground<CELLS>) -> u16 {
    let resolution = ground.frame().resolution().0;
    libm::ceilf(BLOCK.0 / resolution).clamp(1.0, LONGEST_SIDE) as u16
}

/// Visits the cells to which a way of at most so many cells leads, nearest first, with their ways in
/// cells.
///
/// # Errors
/// [`PathError`] where the search has no room; the nearest cells have been visited.
pub(crate) fn visit<const CELLS: usize, const MARKS: usize, const POOL: usize>(
    ground: &Ground<CELLS>,
    planner: &mut Planner<MARKS, POOL>,
    from: Cell,
    reach: f32,
    mut of: impl FnMut(Cell, f32),
) -> Result<(), PathError> {
    let free = |cell| ground.is_reached(cell).then_some(1);
    planner.search(ground.frame(), from, free, |visit| {
        let way = visit.cost as f32 / STRAIGHT_COST as f32;
        if way > reach {
            return ControlFlow::Break(());
        }
        of(visit.cell, way);
        ControlFlow::Continue(())
    })
}

/// What is known of the sums in each square.
pub(crate) struct Squares<const CELLS: usize> {
    side: u16,
    /// The squares in a row, and all.
    across: usize,
    count: usize,
    /// The cell of each square for which its sum was computed or bounded, by its place in the square.
    firsts: [u16; CELLS],
    /// The most that this sum can be.
    bounds: [i32; CELLS],
    /// The most that a candidate of the square can be worth in the choice that is made.
    values: [i32; CELLS],
    /// Whether one of them is beside a wall.
    beside_wall: [bool; CELLS],
}

/// The place in its square of no cell.
const NOWHERE: u16 = u16::MAX;
/// The value of a square without candidates, and of one whose sum is known.
const NOTHING: i32 = -1;

/// What a choice is made from.
pub(crate) trait Sums {
    /// Whether a relay may be put down in the cell.
    fn is_candidate(&self, cell: Cell) -> bool;
    /// The value of a cell in whose square the sum is this one; of a smaller sum it is no larger.
    fn value(&self, cell: Cell, sum: i32) -> i32;
    /// A number that the sum at a cell does not exceed, without a search.
    fn bound(&self, cell: Cell) -> i32;
    /// The sum at a cell.
    fn sum(&mut self, cell: Cell) -> i32;
}

impl<const CELLS: usize> Squares<CELLS> {
    pub(crate) fn new(ground: &Ground<CELLS>) -> Self {
        let side = side(ground);
        let [across, down] = [ground.frame().columns(), ground.frame().rows()]
            .map(|cells| usize::from(cells.div_ceil(side)));
        let (firsts, bounds, values) = ([NOWHERE; CELLS], [0; CELLS], [NOTHING; CELLS]);
        let count = across * down;
        Self { side, across, count, firsts, bounds, values, beside_wall: [false; CELLS] }
    }

    /// The candidate that the [`Shortlist`] picks by its value, and the value; `None` where none is worth
    /// anything. The sums must not have
    /// grown since the last choice.
    pub(crate) fn choose(
        &mut self,
        ground: &Ground<CELLS>,
        demand: &Demand,
        sums: &mut impl Sums,
    ) -> Option<(Cell, i32)> {
        self.bound(ground, demand, sums);
        let mut shortlist = Shortlist::default();
        while let Some((square, first)) = self.next(&shortlist) {
            let sum = sums.sum(first);
            let own = self.values.get_mut(square).zip(self.bounds.get_mut(square));
            let Some((value, bound)) = own else { break };
            (*value, *bound) = (NOTHING, sum);
            for cell in self.cells(ground, first).filter(|&cell| sums.is_candidate(cell)) {
                shortlist.offer(ground, demand, cell, sums.value(cell, sum));
            }
        }
        shortlist.pick()
    }

    /// The square that can be worth most, and the cell whose sum decides it; `None` where no square can
    /// change what the shortlist picks.
    fn next(&self, shortlist: &Shortlist) -> Option<(usize, Cell)> {
        let squares = self.values.iter().zip(&self.beside_wall).take(self.count).enumerate();
        let counts = squares.filter(|(square, (value, beside_wall))| {
            **value > 0 && !shortlist.ignores(self.origin(*square), **value, **beside_wall)
        });
        // Of several it is the first, which may make the others not count.
        let (square, _) = counts.max_by_key(|(square, (value, _))| (**value, Reverse(*square)))?;
        let (origin, place) = (self.origin(square), self.firsts.get(square).copied()?);
        Some((square, Cell::new(origin.column + place % self.side, origin.row + place / self.side)))
    }

    /// Bounds what the candidates of each square can be worth.
    fn bound(&mut self, ground: &Ground<CELLS>, demand: &Demand, sums: &impl Sums) {
        self.values.fill(NOTHING);
        self.beside_wall.fill(false);
        for cell in ground.reached().filter(|&cell| sums.is_candidate(cell)) {
            let square = self.square(cell);
            let place = cell.row % self.side * self.side + cell.column % self.side;
            let own = self.firsts.get_mut(square).zip(self.bounds.get_mut(square));
            let (Some((first, bound)), Some(value)) = (own, self.values.get_mut(square)) else {
                continue;
            };
            if *value == NOTHING {
                let known = if *first == place { *bound } else { i32::MAX };
                (*first, *bound) = (place, known.min(sums.bound(cell)));
            }
            *value = sums.value(cell, *bound).max(*value);
            if let Some(slot) = self.beside_wall.get_mut(square) {
                *slot |= demand.is_beside_wall(ground, cell);
            }
        }
    }

    fn square(&self, cell: Cell) -> usize {
        usize::from(cell.row / self.side) * self.across + usize::from(cell.column / self.side)
    }

    /// The first cell of a square.
    fn origin(&self, square: usize) -> Cell {
        // There are no more squares in a row or a column than cells.
        let [row, column] = [square / self.across, square % self.across].map(|n| n as u16);
        Cell::new(column * self.side, row * self.side)
    }

    /// The reachable cells of the square of a cell.
    fn cells<'a>(
        &self,
        ground: &'a Ground<CELLS>,
        of: Cell,
    ) -> impl Iterator<Item = Cell> + use<'a, CELLS> {
        let side = self.side;
        let origin = self.origin(self.square(of));
        let rows = origin.row..origin.row.saturating_add(side);
        let cells = rows.flat_map(move |row| {
            let columns = origin.column..origin.column.saturating_add(side);
            columns.map(move |column| Cell::new(column, row))
        });
        cells.filter(|&cell| ground.is_reached(cell))
    }
}
