//! Holds a tunnel: the walls that stop beams and drones and attenuate radio, and the skeleton on
//! which places are measured.

use radio_model::Obstruction;
use units::{Metres, Point2};

use super::layout::{GeometryError, Layout, Passage, outlines, passage_outlines};
use super::wall_index::WallIndex;
use super::{Gallery, Skeleton};
use crate::measure::trace::{CentreLine, FloorPlan};

/// A tunnel, made from a floor plan.
#[derive(Debug)]
pub struct Tunnel {
    outlines: Vec<Vec<Point2>>,
    skeleton: Skeleton,
    edges: Vec<[Point2; 2]>,
    walls: WallIndex,
}

impl Tunnel {
    /// Makes the tunnel from a layout.
    ///
    /// # Errors
    /// [`GeometryError`] where the layout has no walls that could be built.
    pub fn dig(layout: &Layout) -> Result<Self, GeometryError> {
        Ok(Self::within(outlines(layout)?, &layout.galleries))
    }

    /// Makes the tunnel of surveyed passages; the galleries are their centre-lines.
    ///
    /// # Errors
    /// [`GeometryError`] where the passages have no walls that could be built.
    pub fn surveyed(galleries: &[Gallery], passages: &[Passage]) -> Result<Self, GeometryError> {
        Ok(Self::within(passage_outlines(passages)?, galleries))
    }

    fn within(outlines: Vec<Vec<Point2>>, galleries: &[Gallery]) -> Self {
        let mut edges = Vec::new();
        for ring in &outlines {
            let next = ring.iter().cycle().skip(1);
            edges.extend(ring.iter().zip(next).map(|(&a, &b)| [a, b]));
        }
        let walls = WallIndex::new(&edges);
        Self { outlines, skeleton: Skeleton::of(galleries), edges, walls }
    }

    /// The graph of centre-lines.
    #[must_use]
    pub fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// The floor plan for pictures.
    #[must_use]
    pub fn floor_plan(&self) -> FloorPlan {
        let lines = self.skeleton.edges().iter().map(|edge| CentreLine {
            name: edge.name().to_owned(),
            points: edge.line().points().to_vec(),
        });
        FloorPlan { outlines: self.outlines.clone(), centre_lines: lines.collect() }
    }

    /// The distance from `at` to the first wall along the unit vector `direction`, or infinity
    /// where there is none within `reach`.
    #[must_use]
    pub fn range(&self, at: Point2, direction: [f32; 2], reach: f32) -> f32 {
        self.walls.cast(at, direction, reach).map_or(f32::INFINITY, |hit| hit.distance)
    }

    /// Returns the distance as [`range`](Self::range) does, with the cosine of the angle between
    /// the beam and the wall's normal; `None` where there is no wall within `reach`.
    #[must_use]
    pub fn strike(&self, at: Point2, direction: [f32; 2], reach: f32) -> Option<(f32, f32)> {
        let hit = self.walls.cast(at, direction, reach)?;
        Some((hit.distance, hit.slant))
    }

    /// A lower bound on the distance from `at` to the nearest wall, m.
    #[must_use]
    pub fn clearance(&self, at: Point2) -> f32 {
        self.walls.clearance(at)
    }

    /// The place at which the walls stop a disc of this radius at `at`: the nearest place where it
    /// fits, or `None` where it touches no wall.
    #[must_use]
    pub fn bump(&self, at: Point2, radius: f32) -> Option<Point2> {
        let wall = self.walls.touching(at, radius)?;
        let away = [at.x - wall.x, at.y - wall.y];
        let distance = at.distance(wall).0;
        if distance == 0.0 {
            return None;
        }
        let scale = radius / distance;
        Some(Point2::new(wall.x + away[0] * scale, wall.y + away[1] * scale))
    }

    /// Whether the point lies in the free space.
    #[must_use]
    pub fn is_free(&self, at: Point2) -> bool {
        let right_of = |[p, q]: &&[Point2; 2]| {
            (p.y > at.y) != (q.y > at.y) && at.x < p.x + (at.y - p.y) / (q.y - p.y) * (q.x - p.x)
        };
        self.edges.iter().filter(right_of).count() % 2 == 1
    }

    /// The obstacles on the straight line from `a` to `b`, both in the free space.
    #[must_use]
    pub fn obstruction(&self, a: Point2, b: Point2) -> Obstruction {
        let mut crossings: Vec<f32> =
            self.edges.iter().filter_map(|edge| crossing(a, b, edge)).collect();
        crossings.sort_by(f32::total_cmp);
        let length = a.distance(b).0;
        let mut found = Obstruction::NONE;
        for solid in crossings.chunks_exact(2) {
            let rock = (solid[1] - solid[0]) * length;
            // Grazing a corner is not going through a wall.
            if rock > 1e-3 {
                found.walls = found.walls.saturating_add(1);
                found.rock += Metres(rock);
            }
        }
        found
    }
}

/// The crossing of the line with this edge, from 0 (`a`) to 1 (`b`). An edge owns its lower end
/// only, so a line through a corner crosses once.
fn crossing(a: Point2, b: Point2, edge: &[Point2; 2]) -> Option<f32> {
    let [p, q] = *edge;
    let side = |c: Point2| (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    let (sp, sq) = (side(p), side(q));
    if (sp > 0.0) == (sq > 0.0) {
        return None;
    }
    let on_edge = sp / (sp - sq);
    let hit = [p.x + on_edge * (q.x - p.x), p.y + on_edge * (q.y - p.y)];
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let along = ((hit[0] - a.x) * dx + (hit[1] - a.y) * dy) / (dx * dx + dy * dy);
    (0.0..=1.0).contains(&along).then_some(along)
}
