//! Records what drones that explore know of their area together, as it grows.

use agent::Exploration;
use grid_map::{Cell, CellState, Frame};
use units::Point2;

use super::Mission;

/// The time between two looks at the maps, in which a drone flies two cells. Our own number.
const LOOK_US: u64 = 1_000_000;

/// What the drones together know of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ground {
    /// No drone knows anything.
    #[default]
    Unknown,
    /// The cell is free, and so is what lies around it or a wall stands there.
    Free,
    /// The cell is free, and beside a cell of which no drone knows anything.
    Frontier,
    /// A drone has found a wall.
    Wall,
}

/// A cell that has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// Microseconds since the start of the mission.
    pub time_us: u64,
    /// The cell's number, row by row from the south-western corner.
    pub cell: usize,
    /// What it is from then on.
    pub ground: Ground,
}

/// Where the cells of a [`TeamMap`] lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// The south-western corner of the first cell.
    pub corner: Point2,
    /// The edge of a cell, m.
    pub side_m: f32,
    /// The number of cells in a row.
    pub columns: usize,
    /// The number of rows.
    pub rows: usize,
}

/// The maps of all drones of an exploration, put together once a second: a wall where one drone has found one, and
/// free where one knows that and none a wall. Each drone draws where it believes to be, and so the walls are off
/// by as much as the drones' estimates are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TeamMap {
    lattice: Option<Lattice>,
    cells: Vec<Ground>,
    changes: Vec<Change>,
    next_us: u64,
}

impl TeamMap {
    /// Where the cells lie; `None` where no drone has begun to explore.
    #[must_use]
    pub const fn lattice(&self) -> Option<Lattice> {
        self.lattice
    }

    /// All changes so far, in order of time.
    #[must_use]
    pub fn changes(&self) -> &[Change] {
        &self.changes
    }

    /// Looks at the maps of a mission, when a second has passed since the last look or the mission is over.
    pub fn look(&mut self, mission: &Mission<'_>) {
        let now_us = mission.time_us();
        if now_us < self.next_us && !mission.is_over() {
            return;
        }
        self.next_us = now_us + LOOK_US;
        // The memory of a drone that never began is the map of one cell.
        let maps: Vec<&Exploration> =
            mission.explorations().filter(|map| map.frame().cell_count() > 1).collect();
        let Some(frame) = maps.first().map(|map| *map.frame()) else { return };
        self.lattice = Some(Lattice {
            corner: frame.origin(),
            side_m: frame.resolution().0,
            columns: usize::from(frame.columns()),
            rows: usize::from(frame.rows()),
        });
        self.cells.resize(frame.cell_count(), Ground::Unknown);
        self.take(now_us, &grounds(&frame, &maps));
    }

    fn take(&mut self, time_us: u64, now: &[Ground]) {
        for (cell, (before, ground)) in self.cells.iter_mut().zip(now).enumerate() {
            if before != ground {
                *before = *ground;
                self.changes.push(Change { time_us, cell, ground: *ground });
            }
        }
    }
}

/// What the drones know of each cell together.
fn grounds(frame: &Frame, maps: &[&Exploration]) -> Vec<Ground> {
    let known =
        |cell| maps.iter().map(|map| map.state(cell)).fold(CellState::Unknown, CellState::or);
    let states: Vec<CellState> = frame.cells().map(known).collect();
    let is_unknown = |cell: Cell| states.get(frame.number(cell)) == Some(&CellState::Unknown);
    let ground = |(cell, state): (Cell, &CellState)| match state {
        CellState::Unknown => Ground::Unknown,
        CellState::Occupied => Ground::Wall,
        CellState::Free if frame.sides(cell).any(is_unknown) => Ground::Frontier,
        CellState::Free => Ground::Free,
    };
    frame.cells().zip(&states).map(ground).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_changes_is_kept() {
        let mut map = TeamMap { cells: vec![Ground::Unknown; 3], ..TeamMap::default() };
        map.take(1, &[Ground::Unknown, Ground::Frontier, Ground::Wall]);
        map.take(2, &[Ground::Frontier, Ground::Free, Ground::Wall]);
        let changes: Vec<_> = map.changes().iter().map(|c| (c.time_us, c.cell, c.ground)).collect();
        let wanted = [
            (1, 1, Ground::Frontier),
            (1, 2, Ground::Wall),
            (2, 0, Ground::Frontier),
            (2, 1, Ground::Free),
        ];
        assert_eq!(changes, wanted);
    }
}
