//! The law's terms for pairs of places, computed where they are first asked for.
//!
//! Places are tabulated in blocks of 16 by 16 pairs. A block is computed as a whole: what stands
//! between two short stretches of galleries is found once for all its pairs. A mission asks for the
//! blocks of the stretches that its drones fly, so that the table of a large network takes no more
//! than that of a small one.

use std::sync::{Arc, OnceLock};

use radio_model::PathLoss;
use units::Point2;

use super::Radio;
use crate::{SkeletonPlace, Tunnel};

/// The number of successive places along each side of a block.
const SIDE: usize = 16;

/// The terms of a block, row-major.
type Block = Box<[f32; SIDE * SIDE]>;

/// The terms for all pairs of tabulated places.
pub(super) struct Table {
    law: PathLoss,
    tunnel: Arc<Tunnel>,
    /// The indices at which each edge's places begin, and the one at which the last edge's end.
    starts: Vec<usize>,
    points: Vec<Point2>,
    /// The blocks by row, up to the one on the diagonal: a term is the same in both directions.
    rows: Vec<OnceLock<Box<[OnceLock<Block>]>>>,
}

/// Between which of the tabulated places a place lies.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Index {
    pub(super) before: usize,
    pub(super) after: usize,
    /// The place between the two, as a part from 0 to 1.
    pub(super) part: f32,
    /// The nearer of the two.
    pub(super) nearest: usize,
}

impl Table {
    pub(super) fn of(tunnel: &Arc<Tunnel>, law: PathLoss) -> Self {
        let mut starts = vec![0];
        let mut points = Vec::new();
        for edge in tunnel.skeleton().edges() {
            let count = (edge.line().length() / Radio::STEP) as usize + 2;
            points.extend((0..count).map(|n| edge.line().at(n as f32 * Radio::STEP).0));
            starts.push(points.len());
        }
        let rows = (0..points.len().div_ceil(SIDE)).map(|_| OnceLock::new()).collect();
        Self { law, tunnel: Arc::clone(tunnel), starts, points, rows }
    }

    pub(super) fn index(&self, place: SkeletonPlace) -> Index {
        let edge = usize::from(place.edge).min(self.starts.len() - 2);
        let (first, last) = (self.starts[edge], self.starts[edge + 1] - 1);
        let steps = (place.along / Radio::STEP).clamp(0.0, (last - first) as f32);
        let before = first + steps as u32 as usize;
        Index {
            before,
            after: (before + 1).min(last),
            part: steps - (steps as u32) as f32,
            nearest: (first + (steps + 0.5) as u32 as usize).min(last),
        }
    }

    /// The term between two places.
    pub(super) fn at(&self, row: usize, column: usize) -> f32 {
        let (row, column) = (row.max(column), row.min(column));
        let blocks = self.rows[row / SIDE].get_or_init(|| {
            (0..=row / SIDE).map(|_| OnceLock::new()).collect::<Vec<_>>().into_boxed_slice()
        });
        let block = blocks[column / SIDE].get_or_init(|| self.block(row / SIDE, column / SIDE));
        block[row % SIDE * SIDE + column % SIDE]
    }

    fn block(&self, row: usize, column: usize) -> Block {
        let places = |block: usize| block * SIDE..((block + 1) * SIDE).min(self.points.len());
        let [rows, columns] = [places(row), places(column)];
        let [from, to] = [&rows, &columns].map(|range| &self.points[range.clone()]);
        let walls = self.tunnel.walls_between(from, to);
        let same = self.law.term(radio_model::Obstruction::NONE);
        let mut block = Box::new([same; SIDE * SIDE]);
        for r in rows {
            for c in columns.clone().take_while(|c| *c < r) {
                let between = walls.obstruction(self.points[r], self.points[c]);
                block[r % SIDE * SIDE + c % SIDE] = self.law.term(between);
            }
        }
        block
    }
}

#[cfg(test)]
mod tests {
    use radio_model::{Attenuation, UChain, Walls};
    use units::Db;

    use super::*;
    use crate::layout::Layout;

    #[test]
    fn a_link_takes_one_block_of_a_long_gallery() {
        let tunnel = Tunnel::dig(&Layout::corridor(&[[0.0, 0.0], [400.0, 0.0]], 2.0)).unwrap();
        let (attenuation, walls) = (Attenuation::RockDepth, Walls::Rock);
        let law = PathLoss::UChain(UChain { attenuation, walls, loss_at_1m: Db(40.0) });
        let table = Table::of(&Arc::new(tunnel), law);
        assert_eq!(table.at(5, 3000), table.at(3000, 5));
        let rows = table.rows.iter().filter_map(OnceLock::get);
        let blocks = rows.flat_map(|blocks| blocks.iter()).filter(|block| block.get().is_some());
        assert_eq!(blocks.count(), 1);
    }
}
