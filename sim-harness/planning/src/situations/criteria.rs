//! The paper's two criteria of each drop cell, written down as the paper's text has them: a slow
//! definition beside the fast one of the rule in `relay_placement`.

use grid_map::Cell;
use relay_placement::Demand;

use super::{Cave, square};

/// A drop cell with its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scored {
    /// The cell.
    pub cell: Cell,
    /// Twice the criterion c1, so that it is whole: over the cells within 20 m, 2 where the network is
    /// heard too weakly, 1 where it is not heard, −2 where it covers.
    pub twice_c1: i32,
    /// The criterion c2, the distance from the nearest wall, m.
    pub c2_m: f32,
    /// The cells within 20 m that the network does not cover.
    pub gain_cells: usize,
    /// Whether the cell is on the Pareto front of both criteria.
    pub is_on_front: bool,
    /// Whether the cell is beside a wall.
    pub is_beside_wall: bool,
}

/// The drop cells of a goal.
pub struct Criteria {
    /// The goal.
    pub goal: Cell,
    /// The cells, row by row.
    pub cells: Vec<Scored>,
}

impl Criteria {
    /// The values of all drop cells of a goal.
    #[must_use]
    pub fn of(cave: &Cave, goal: Cell) -> Self {
        let mut cells: Vec<_> = cave.drop_cells(goal).map(|cell| scored(cave, cell)).collect();
        let beats = |a: &Scored, b: &Scored| {
            let more = a.twice_c1 > b.twice_c1 || a.c2_m > b.c2_m;
            more && a.twice_c1 >= b.twice_c1 && a.c2_m >= b.c2_m
        };
        let front: Vec<_> =
            cells.iter().map(|cell| !cells.iter().any(|other| beats(other, cell))).collect();
        for (cell, is_on_front) in cells.iter_mut().zip(front) {
            cell.is_on_front = is_on_front;
        }
        Self { goal, cells }
    }

    /// The cell that the paper's method takes of the cells that pass: the one beside a wall that is
    /// nearest the goal, or else, of each the nearest drop cell beside a wall, the one nearest the goal.
    pub(super) fn taken(&self, passes: impl Fn(&Scored) -> bool) -> Option<Cell> {
        let passing = || self.cells.iter().filter(|cell| passes(cell));
        let by_goal = |cell: &Cell| square(*cell, self.goal);
        let beside = passing().filter(|cell| cell.is_beside_wall).map(|cell| cell.cell);
        let projected = || passing().filter_map(|cell| self.projected(cell.cell));
        beside.min_by_key(by_goal).or_else(|| projected().min_by_key(by_goal))
    }

    /// The drop cell beside a wall that is nearest to a cell.
    fn projected(&self, from: Cell) -> Option<Cell> {
        let beside = self.cells.iter().filter(|cell| cell.is_beside_wall).map(|cell| cell.cell);
        beside.min_by_key(|cell| square(*cell, from))
    }

    /// What the method takes by c1 alone, and by c2 alone.
    pub(super) fn by_one(&self) -> [Option<Cell>; 2] {
        let most = self.cells.iter().map(|cell| cell.twice_c1).max();
        let widest = self.cells.iter().map(|cell| cell.c2_m).fold(0.0, f32::max);
        [self.taken(|cell| Some(cell.twice_c1) == most), self.taken(|cell| cell.c2_m >= widest)]
    }

    /// The values of a cell.
    pub(super) fn at(&self, cell: Cell) -> Option<&Scored> {
        self.cells.iter().find(|scored| scored.cell == cell)
    }
}

fn scored(cave: &Cave, cell: Cell) -> Scored {
    let (mut twice_c1, mut gain_cells) = (0, 0);
    for near in cave.around(cell, cave.network.curve().knee.0) {
        let is_covered = cave.network.covers(near);
        twice_c1 += match cave.network.ratio(near).0 {
            _ if is_covered => -2,
            ratio if ratio > 0.0 => 2,
            _ => 1,
        };
        gain_cells += usize::from(!is_covered);
    }
    // On a grid of 0.5 m, the cells that touch a wall are beside it.
    let beside = Demand::DEFAULT.beside_wall.0.max(cave.ground.frame().resolution().0 * 1.01);
    let c2_m = cave.ground.clearance(cell).0;
    let is_beside_wall = c2_m < beside;
    Scored { cell, twice_c1, c2_m, gain_cells, is_on_front: false, is_beside_wall }
}
