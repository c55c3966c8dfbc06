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
//!
//! Of several relays each is chosen as if those before it were down and not read: each of them covers a
//! cell with the probability that it has a link, times that of its strength there.

use grid_map::{Cell, PathError, Planner};
use heapless::Vec;
use units::{Db, Metres, Point2};

use crate::curve::Curve;
use crate::ground::{Ground, index};
use crate::network::distance;
use crate::place::{Demand, Shortlist};
use crate::plan::MOST_PLANNED;
use crate::score::{Disc, Score};
use crate::signal::Correction;
use crate::squares::{Squares, Sums, visit};

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
            self.count(ground, cell, distance(centre, at), correction(centre), 1.0);
        }
    }

    /// Adds a relay or the base in a cell in the same way, by the way through the cave in place of the
    /// straight line.
    ///
    /// # Errors
    /// [`PathError`] where the search has no room; the nearest cells have been added.
    pub fn add_by_way<const MARKS: usize, const POOL: usize>(
        &mut self,
        ground: &Ground<CELLS>,
        planner: &mut Planner<MARKS, POOL>,
        at: Cell,
        correction: impl Fn(Point2) -> Correction,
    ) -> Result<(), PathError> {
        let resolution = ground.frame().resolution().0;
        visit(ground, planner, at, f32::INFINITY, |cell, way| {
            let correction = correction(ground.frame().centre(cell));
            self.count(ground, cell, Metres(way * resolution), correction, 1.0);
        })
    }

    /// Counts in a relay at this distance from a cell, which works with a probability.
    fn count(
        &mut self,
        ground: &Ground<CELLS>,
        cell: Cell,
        far: Metres,
        Correction { over, deviation, .. }: Correction,
        works: f32,
    ) {
        let spare = self.curve.at(far) + over - self.curve.covered;
        if let Some(slot) = self.missing.get_mut(index(ground.frame(), cell)) {
            *slot *= 1.0 - works * normal(spare, deviation);
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
        let gains = self.gains(ground);
        let discs = self.radii(ground, spread).map(Disc::new);
        let parts = |cell: Cell| {
            let sum = discs.iter().map(|disc| gains.around(ground, cell, disc)).sum();
            self.value(cell, sum)
        };
        let mut shortlist = Shortlist::default();
        for cell in ground.reached() {
            if distance(frame.centre(cell), goal).0 <= demand.within.0 {
                shortlist.offer(ground, demand, cell, parts(cell));
            }
        }
        self.expected(ground, shortlist.pick())
    }

    /// Plans at most `nodes` relays of this spread, each where it is expected to add most to the relays
    /// before it, anywhere: [`Demand::within`] is of no account. There are fewer where none is expected
    /// to add a whole cell.
    #[must_use]
    pub fn plan(
        mut self,
        ground: &Ground<CELLS>,
        demand: &Demand,
        spread: Db,
        nodes: usize,
    ) -> Vec<Expected, MOST_PLANNED> {
        let demand = Demand { within: Metres(f32::INFINITY), ..*demand };
        let correction = Correction { deviation: spread, ..Correction::NONE };
        let mut places = Vec::new();
        while places.len() < nodes.min(MOST_PLANNED) {
            let place = self.choose(ground, Point2::new(0.0, 0.0), &demand, spread);
            let Some(place) = place.filter(|place| place.gain_cells >= 1.0) else { break };
            let _ = places.push(place);
            for cell in ground.reached() {
                let far = distance(ground.frame().centre(cell), place.at);
                self.count(ground, cell, far, correction, place.link);
            }
        }
        places
    }

    /// The same by the way through the cave, for a belief whose relays were added by
    /// [`Belief::add_by_way`].
    #[must_use]
    pub fn plan_by_way<const MARKS: usize, const POOL: usize>(
        mut self,
        ground: &Ground<CELLS>,
        planner: &mut Planner<MARKS, POOL>,
        demand: &Demand,
        spread: Db,
        nodes: usize,
    ) -> Vec<Expected, MOST_PLANNED> {
        let resolution = ground.frame().resolution().0;
        let correction = Correction { deviation: spread, ..Correction::NONE };
        let mut squares = Squares::new(ground);
        let mut places = Vec::new();
        while places.len() < nodes.min(MOST_PLANNED) {
            let radii = self.radii(ground, spread);
            let gains = self.gains(ground);
            let discs = radii.map(Disc::by_way);
            let mut ways = Ways { ground, belief: &self, planner, gains, radii, discs };
            let place = self.expected(ground, squares.choose(ground, demand, &mut ways));
            let Some(place) = place.filter(|place| place.gain_cells >= 1.0) else { break };
            let _ = places.push(place);
            // A search without room has counted the nearest cells, which are those that matter.
            let _ = visit(ground, planner, place.cell, f32::INFINITY, |cell, way| {
                self.count(ground, cell, Metres(way * resolution), correction, place.link);
            });
        }
        places
    }

    /// The probability that no relay covers a cell, in parts, of all cells.
    fn gains(&self, ground: &Ground<CELLS>) -> Score<CELLS> {
        Score::of_reached(ground, |cell| self.parts(cell))
    }

    fn parts(&self, cell: Cell) -> i16 {
        (PARTS * (1.0 - self.covers(cell))) as i16
    }

    /// The value of a cell at which the parts within the radii have this sum.
    fn value(&self, cell: Cell, sum: i32) -> i32 {
        (self.covers(cell) * sum as f32) as i32
    }

    /// The radii that a relay of this spread covers, each as likely as the others, cells.
    fn radii(&self, ground: &Ground<CELLS>, spread: Db) -> [f32; RADII.len()] {
        RADII.map(|z| {
            let weakest = Db(self.curve.covered.0 - z * spread.0);
            self.curve.reach(weakest).0 / ground.frame().resolution().0
        })
    }

    /// The place of a cell with this value.
    fn expected(&self, ground: &Ground<CELLS>, chosen: Option<(Cell, i32)>) -> Option<Expected> {
        let (cell, sum) = chosen.filter(|(_, sum)| *sum > 0)?;
        let gain_cells = sum as f32 / (PARTS * RADII.len() as f32);
        Some(Expected {
            cell,
            at: ground.frame().centre(cell),
            link: self.covers(cell),
            gain_cells,
        })
    }
}

/// The expected coverage of places by the way through the cave.
struct Ways<'a, const CELLS: usize, const MARKS: usize, const POOL: usize> {
    ground: &'a Ground<CELLS>,
    belief: &'a Belief<CELLS>,
    planner: &'a mut Planner<MARKS, POOL>,
    gains: Score<CELLS>,
    /// The radii of a relay by the way, from the smallest on, and the cells within them on open ground.
    radii: [f32; RADII.len()],
    discs: [Disc; RADII.len()],
}

impl<const CELLS: usize, const MARKS: usize, const POOL: usize> Sums
    for Ways<'_, CELLS, MARKS, POOL>
{
    fn is_candidate(&self, cell: Cell) -> bool {
        self.belief.covers(cell) > 0.0
    }

    fn value(&self, cell: Cell, sum: i32) -> i32 {
        self.belief.value(cell, sum)
    }

    fn bound(&self, cell: Cell) -> i32 {
        self.discs.iter().map(|disc| self.gains.around(self.ground, cell, disc)).sum()
    }

    fn sum(&mut self, cell: Cell) -> i32 {
        let (belief, radii, mut sum) = (self.belief, self.radii, 0);
        let [.., farthest] = radii;
        let _ = visit(self.ground, self.planner, cell, farthest, |cell, way| {
            let within = radii.iter().filter(|radius| way <= **radius).count() as i32;
            sum += within * i32::from(belief.parts(cell));
        });
        sum
    }
}

/// The probability that a normal number with this mean and deviation is not negative.
fn normal(mean: Db, deviation: Db) -> f32 {
    if deviation.0 <= 0.0 {
        return if mean.0 >= 0.0 { 1.0 } else { 0.0 };
    }
    0.5 * libm::erfcf(-mean.0 / deviation.0 * core::f32::consts::FRAC_1_SQRT_2)
}
