//! What is asked of a place for a relay, and which of several is taken.

use grid_map::Cell;
use units::{Db, Metres, Point2};

use crate::ground::Ground;

/// The least share of the possible new coverage that [`Shortlist::pick`] takes to stand beside a
/// wall and leave a free width. It is a choice: without such a limit the worst of 20 caves, seeds 0
/// to 19 of `cave-worlds`, kept 0.54 of the coverage, and with it 0.81.
const LEAST_SHARE: f32 = 0.8;

/// What is asked of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// The farthest from the goal that a relay is put down: 10 m in the paper.
    pub within: Metres,
    /// The distance from the wall up to which a place is beside it: 0.5 m in the paper. On a
    /// coarser grid a cell beside a wall is always near it.
    pub beside_wall: Metres,
    /// How much more than [`Curve::covered`](crate::Curve::covered) the link to the network is to
    /// be: the margin that `uchain plan relays` keeps as well.
    pub margin: Db,
    /// The free width that is to be left beside the relay, so that the next robot passes. It is a
    /// choice, not a measurement.
    pub free_width: Metres,
}

impl Demand {
    /// The paper's distances, and our margin and width.
    pub const DEFAULT: Self = Self {
        within: Metres(10.0),
        beside_wall: Metres(0.5),
        margin: Db(3.0),
        free_width: Metres(1.0),
    };
}

impl Demand {
    /// Whether a cell is beside a wall.
    pub(crate) fn is_beside_wall<const CELLS: usize>(
        &self,
        ground: &Ground<CELLS>,
        cell: Cell,
    ) -> bool {
        let limit = self.beside_wall.0.max(ground.frame().resolution().0 * 1.01);
        ground.clearance(cell).0 < limit
    }
}

/// A place for a relay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The cell.
    pub cell: Cell,
    /// Its middle.
    pub at: Point2,
    /// The cells that become covered by it.
    pub gain_cells: usize,
    /// The ratio at which the network hears it.
    pub link: Db,
    /// The free width left beside it.
    pub free_width: Metres,
}

impl Place {
    pub(crate) fn new<const CELLS: usize>(
        ground: &Ground<CELLS>,
        cell: Cell,
        gain: i32,
        link: Db,
    ) -> Self {
        Self {
            cell,
            at: ground.frame().centre(cell),
            gain_cells: usize::try_from(gain).unwrap_or(0),
            link,
            free_width: ground.free_width(cell),
        }
    }
}

/// Whether the first cell is to be taken rather than the second: by its gain, and of two with the same
/// gain by their order, row by row.
fn is_before((cell, gain): (Cell, i32), (other, most): (Cell, i32)) -> bool {
    let order = |cell: Cell| (cell.row, cell.column);
    gain > most || gain == most && order(cell) < order(other)
}

/// Of the cells that were offered the one of the largest gain in each class: beside a wall with the
/// free width; with the free width; beside a wall; any.
#[derive(Default)]
pub(crate) struct Shortlist {
    most: [Option<(Cell, i32)>; 4],
}

impl Shortlist {
    /// Takes note of a cell.
    pub(crate) fn offer<const CELLS: usize>(
        &mut self,
        ground: &Ground<CELLS>,
        demand: &Demand,
        cell: Cell,
        gain: i32,
    ) {
        // A cell that gains no more than the first class offers is never picked; the width, which
        // takes long to measure, is left out.
        let first = self.most.first().copied().flatten();
        if first.is_some_and(|first| !is_before((cell, gain), first)) {
            return;
        }
        let is_wide = ground.free_width(cell) >= demand.free_width;
        let class = match (is_wide, demand.is_beside_wall(ground, cell)) {
            (true, true) => 0,
            (true, false) => 1,
            (false, true) => 2,
            (false, false) => 3,
        };
        if let Some(slot) = self.most.get_mut(class)
            && slot.is_none_or(|most| is_before((cell, gain), most))
        {
            *slot = Some((cell, gain));
        }
    }

    /// Whether this cell, with this gain or a smaller one, would not be picked any more, and none after
    /// it; of cells of which none is beside a wall, where that is said.
    pub(crate) fn ignores(&self, cell: Cell, gain: i32, is_beside_wall: bool) -> bool {
        let best = self.most.iter().flatten().map(|(_, gain)| *gain).max().unwrap_or(0);
        // A cell is never picked where its own class, or an earlier one, has a cell that is before it.
        let earlier = self.most.iter().take(if is_beside_wall { 1 } else { 2 }).flatten();
        let is_first = earlier.copied().all(|most| is_before((cell, gain), most));
        !is_first || (gain as f32) < LEAST_SHARE * best as f32
    }

    /// The cell of the first class that costs little coverage, and its gain.
    pub(crate) fn pick(&self) -> Option<(Cell, i32)> {
        let best = self.most.iter().flatten().map(|(_, gain)| *gain).max()?;
        let least = LEAST_SHARE * best as f32;
        self.most.iter().flatten().find(|(_, gain)| *gain as f32 >= least).copied()
    }
}
