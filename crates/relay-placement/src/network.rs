//! The signal-to-noise ratio that the relays on the ground give to each cell.

use grid_map::{Cell, PathError, Planner};
use units::{Db, Metres, Point2};

use crate::curve::Curve;
use crate::ground::{Ground, index};
use crate::signal::{Correction, Refined};
use crate::squares::visit;

/// The map of signal strength: at each reachable cell the best ratio over all relays.
#[derive(Clone, Debug, PartialEq)]
pub struct Network<const CELLS: usize> {
    curve: Curve,
    columns: u16,
    /// The ratio in dB; 0 where no relay is heard.
    ratios: [f32; CELLS],
}

impl<const CELLS: usize> Network<CELLS> {
    /// The network without a relay. It is also where a network begins anew of which a relay is
    /// lost: the ones that are left are added again.
    #[must_use]
    pub const fn new(ground: &Ground<CELLS>, curve: Curve) -> Self {
        Self { curve, columns: ground.frame().columns(), ratios: [0.0; CELLS] }
    }

    /// Adds a relay or the base.
    pub fn add(&mut self, ground: &Ground<CELLS>, at: Point2) {
        self.add_corrected(ground, at, |_| Db(0.0));
    }

    /// Adds a relay or the base whose strength was read: at each cell the ratio of the curve with
    /// the correction there, less so many of its standard deviations. With 1.28 of them, nine of ten
    /// places are at least as strong as the map says.
    pub fn add_refined<const SPOTS: usize>(
        &mut self,
        ground: &Ground<CELLS>,
        at: Point2,
        refined: &Refined<'_, SPOTS>,
        deviations: f32,
    ) {
        self.add_corrected(ground, at, |point| {
            let Correction { over, deviation, .. } = refined.at(point);
            Db(over.0 - deviations * deviation.0)
        });
    }

    /// Adds a relay or the base with what its strength at a point is over the curve's.
    pub fn add_corrected(
        &mut self,
        ground: &Ground<CELLS>,
        at: Point2,
        correction: impl Fn(Point2) -> Db,
    ) {
        for cell in ground.reached() {
            let centre = ground.frame().centre(cell);
            let ratio = self.curve.at(distance(centre, at)).0 + correction(centre).0;
            if let Some(slot) = self.ratios.get_mut(index(ground.frame(), cell)) {
                *slot = slot.max(ratio);
            }
        }
    }

    /// Adds a relay or the base in a cell, by the way through the cave in place of the straight line:
    /// rock lets nothing through.
    ///
    /// # Errors
    /// [`PathError`] where the search has no room; the nearest cells have been added.
    pub fn add_by_way<const MARKS: usize, const POOL: usize>(
        &mut self,
        ground: &Ground<CELLS>,
        planner: &mut Planner<MARKS, POOL>,
        at: Cell,
    ) -> Result<(), PathError> {
        self.add_by_way_corrected(ground, planner, at, |_| Db(0.0))
    }

    /// The same with what its strength at a point is over the curve's.
    ///
    /// # Errors
    /// [`PathError`] where the search has no room; the nearest cells have been added.
    pub fn add_by_way_corrected<const MARKS: usize, const POOL: usize>(
        &mut self,
        ground: &Ground<CELLS>,
        planner: &mut Planner<MARKS, POOL>,
        at: Cell,
        correction: impl Fn(Point2) -> Db,
    ) -> Result<(), PathError> {
        let (curve, frame) = (self.curve, ground.frame());
        visit(ground, planner, at, f32::INFINITY, |cell, way| {
            let far = Metres(way * frame.resolution().0);
            let ratio = curve.at(far).0 + correction(frame.centre(cell)).0;
            if let Some(slot) = self.ratios.get_mut(index(frame, cell)) {
                *slot = slot.max(ratio);
            }
        })
    }

    /// The curve by which the ratios are computed.
    #[must_use]
    pub const fn curve(&self) -> &Curve {
        &self.curve
    }

    /// The ratio at a cell; 0 dB where no relay is heard.
    #[must_use]
    pub fn ratio(&self, cell: Cell) -> Db {
        let at = usize::from(cell.row) * usize::from(self.columns) + usize::from(cell.column);
        let inside = cell.column < self.columns;
        Db(self.ratios.get(at).copied().filter(|_| inside).unwrap_or(0.0))
    }

    /// Whether the ratio at a cell is that of a covered one, or better.
    #[must_use]
    pub fn covers(&self, cell: Cell) -> bool {
        self.ratio(cell) >= self.curve.covered
    }

    /// The number of reachable cells that are covered.
    #[must_use]
    pub fn covered(&self, ground: &Ground<CELLS>) -> usize {
        ground.reached().filter(|&cell| self.covers(cell)).count()
    }
}

/// The distance of two points.
pub(crate) fn distance(a: Point2, b: Point2) -> Metres {
    let (x, y) = (a.x - b.x, a.y - b.y);
    // `hypotf` of libm computes in double precision.
    Metres(libm::sqrtf(x * x + y * y))
}
