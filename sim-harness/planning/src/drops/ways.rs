//! The distance of a reading from what it is a reading of.

use std::ops::ControlFlow;

use cave_worlds::{CELLS, WorldPlanner};
use grid_map::{Cell, STRAIGHT_COST};
use relay_placement::Ground;
use units::{Metres, Point2};

use super::Coverage;

/// The distances of points from one that stands in a cell.
pub(crate) enum Ways {
    /// In a straight line from here.
    Straight(Point2),
    /// By the way through the cave: each cell that a way leads to, with its middle and the way.
    Geodesic(Vec<(Point2, Metres)>),
}

impl Ways {
    pub(super) fn new(
        coverage: Coverage,
        ground: &Ground<CELLS>,
        planner: &mut WorldPlanner,
        from: Cell,
    ) -> Self {
        let frame = ground.frame();
        if coverage == Coverage::Straight {
            return Self::Straight(frame.centre(from));
        }
        let mut ways = Vec::new();
        let free = |cell| ground.is_reached(cell).then_some(1);
        // A search without room ends early, with the nearest cells visited.
        let _ = planner.search(frame, from, free, |visit| {
            let way = visit.cost as f32 / STRAIGHT_COST as f32 * frame.resolution().0;
            ways.push((frame.centre(visit.cell), Metres(way)));
            ControlFlow::Continue(())
        });
        Self::Geodesic(ways)
    }

    /// The distance of a point; by the way it is that of the nearest cell with a way, and from there
    /// the straight line.
    pub(super) fn to(&self, point: Point2) -> Metres {
        let far = |at: Point2| Metres((at.x - point.x).hypot(at.y - point.y));
        match self {
            Self::Straight(from) => far(*from),
            Self::Geodesic(ways) => {
                let nearest = ways.iter().min_by(|(a, _), (b, _)| far(*a).0.total_cmp(&far(*b).0));
                nearest.map_or(Metres(f32::INFINITY), |(at, way)| *way + far(*at))
            }
        }
    }
}
