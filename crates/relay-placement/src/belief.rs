//! Chooses a place where the strength of the network is known with its doubt only.
//!
//! Readings leave a normal distribution of the ratio at each cell. A relay without a link covers
//! nothing, so the value of a place is the expected number of cells that it adds,
//!
//! ```text
//!   E = P(link at the place) · Σ over cells  P(the relay covers the cell) · P(the network does not)
//! ```
//!
//! and the place of the largest value is taken, as the theory of decisions has it (L. J. Savage, "The
//! foundations of statistics", 1954). A margin, or a map drawn so many standard deviations lower, asks
//! the same confidence of each place whatever it covers: it leaves a place that adds much with four
//! chances in five for one that adds nothing with nine in ten. The factors are taken as independent.
//!
//! How far the new relay reaches is not known before it is down: its offset and its shadowing spread
//! the radius that it covers. The sum is the mean over [`RADII`] equally likely radii.

use grid_map::Cell;
use units::{Db, Point2};

use crate::curve::Curve;
use crate::ground::{Ground, index};
use crate::network::distance;
use crate::place::{Demand, Shortlist};
use crate::score::{Disc, Score};
use crate::signal::Correction;

/// The standard normal deviations in the middles of eight equally likely parts.
const RADII: [f32; 8] = [-1.534, -0.887, -0.489, -0.157, 0.157, 0.489, 0.887, 1.534];
/// The parts of a cell in which its doubt is counted.
const PARTS: f32 = 100.0;

/// How likely the relays on the ground cover each cell, and their spread.
#[derive(Clone, Debug, PartialEq)]
pub struct Belief<const CELLS: usize> {
    curve: Curve,
    columns: u16,
    /// The probability that no relay covers the cell.
    missing: [f32; CELLS],
}

/// A place that was chosen by its expected coverage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// The cell.
    pub cell: Cell,
    /// Its middle.
    pub at: Point2,
    /// The probability that the network hears a relay there.
    pub link: f32,
    /// The expected number of cells that become covered.
    pub gain_cells: f32,
}

impl<const CELLS: usize> Belief<CELLS> {
    /// The belief without a relay.
    #[must_use]
    pub const fn new(ground: &Ground<CELLS>, curve: Curve) -> Self {
        Self { curve, columns: ground.frame().columns(), missing: [1.0; CELLS] }
    }

    /// Adds a relay or the base with what its strength at a point is over the curve's.
    pub fn add(
        &mut self,
        ground: &Ground<CELLS>,
        at: Point2,
        correction: impl Fn(Point2) -> Correction,
    ) {
        for cell in ground.reached() {
            let centre = ground.frame().centre(cell);
            let Correction { over, deviation, .. } = correction(centre);
            let spare = self.curve.at(distance(centre, at)) + over - self.curve.covered;
            if let Some(slot) = self.missing.get_mut(index(ground.frame(), cell)) {
                *slot *= 1.0 - normal(spare, deviation);
            }
        }
    }

    /// The probability that a relay covers the cell, and hears one that is put down there.
    #[must_use]
    pub fn covers(&self, cell: Cell) -> f32 {
        let at = usize::from(cell.row) * usize::from(self.columns) + usize::from(cell.column);
        let inside = cell.column < self.columns;
        1.0 - self.missing.get(at).copied().filter(|_| inside).unwrap_or(1.0)
    }

    /// The drop cell of the largest expected coverage, beside a wall and with the free width where
    /// that costs little of it, for a relay whose strength has this standard deviation about the
    /// curve. `None` where no drop cell is expected to add anything.
    #[must_use]
    pub fn choose(
        &self,
        ground: &Ground<CELLS>,
        goal: Point2,
        demand: &Demand,
        spread: Db,
    ) -> Option<Expected> {
        let frame = ground.frame();
        let gains = Score::of_reached(ground, |cell| (PARTS * (1.0 - self.covers(cell))) as i16);
        let discs = RADII.map(|z| {
            let weakest = Db(self.curve.covered.0 - z * spread.0);
            Disc::new(self.curve.reach(weakest).0 / frame.resolution().0)
        });
        let parts = |cell: Cell| {
            let sum: i32 = discs.iter().map(|disc| gains.around(ground, cell, disc)).sum();
            (self.covers(cell) * sum as f32) as i32
        };
        let mut shortlist = Shortlist::default();
        for cell in ground.reached() {
            if distance(frame.centre(cell), goal).0 <= demand.within.0 {
                shortlist.offer(ground, demand, cell, parts(cell));
            }
        }
        let (cell, sum) = shortlist.pick().filter(|(_, sum)| *sum > 0)?;
        let gain_cells = sum as f32 / (PARTS * RADII.len() as f32);
        Some(Expected { cell, at: frame.centre(cell), link: self.covers(cell), gain_cells })
    }
}

/// The probability that a normal number with this mean and deviation is not negative.
fn normal(mean: Db, deviation: Db) -> f32 {
    if deviation.0 <= 0.0 {
        return if mean.0 >= 0.0 { 1.0 } else { 0.0 };
    }
    0.5 * libm::erfcf(-mean.0 / deviation.0 * core::f32::consts::FRAC_1_SQRT_2)
}
