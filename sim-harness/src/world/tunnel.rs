//! Holds a tunnel: the walls that stop beams and drones and attenuate radio, and the skeleton on
//! which places are measured.

use radio_model::Obstruction;
use units::{Metres, Point2};

use super::Skeleton;
use super::layout::{GeometryError, Layout, Passage, outlines, passage_outlines};
use super::wall_index::WallIndex;
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
        Ok(Self::within(outlines(layout)?, Skeleton::of(&layout.galleries)))
    }

    /// Makes the tunnel of passages, with the skeleton of their centre-lines.
    ///
    /// # Errors
    /// [`GeometryError`] where the passages have no walls that could be built.
    pub fn surveyed(skeleton: Skeleton, passages: &[Passage]) -> Result<Self, GeometryError> {
        Ok(Self::within(passage_outlines(passages)?, skeleton))
    }

    /// Makes the tunnel whose free space has these outlines, which are closed loops, the last point
    /// not repeated, of which no two cross.
    #[must_use]
    pub fn within(outlines: Vec<Vec<Point2>>, skeleton: Skeleton) -> Self {
        let mut edges = Vec::new();
        for ring in &outlines {
            let next = ring.iter().cycle().skip(1);
            edges.extend(ring.iter().zip(next).map(|(&a, &b)| [a, b]));
        }
        let walls = WallIndex::new(&edges);
        Self { outlines, skeleton, edges, walls }
    }

    /// The graph of centre-lines.
    #[must_use]
    pub fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// The outlines of the free space: closed loops, the last point not repeated.
    #[must_use]
    pub fn outlines(&self) -> &[Vec<Point2>] {
        &self.outlines
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
        obstruction(&self.edges, a, b)
    }

    /// The walls that a straight line from one of the points `from` to one of `to` may cross.
    #[must_use]
    pub(super) fn walls_between(&self, from: &[Point2], to: &[Point2]) -> WallsBetween {
        let ((a, near), (b, far)) = (circle(from), circle(to));
        // Every such line lies within the larger circle's radius of the one between the middles.
        let reach = near.max(far) + 0.1;
        let may_cross = |[p, q]: &&[Point2; 2]| {
            let middle = Point2::new(0.5 * (p.x + q.x), 0.5 * (p.y + q.y));
            distance_to_line(middle, a, b) <= reach + 0.5 * p.distance(*q).0
        };
        WallsBetween(self.edges.iter().filter(may_cross).copied().collect())
    }
}

/// Some of the walls of a tunnel.
pub(super) struct WallsBetween(Vec<[Point2; 2]>);

impl WallsBetween {
    /// The obstacles on a straight line that crosses none of the other walls.
    pub(super) fn obstruction(&self, a: Point2, b: Point2) -> Obstruction {
        obstruction(&self.0, a, b)
    }
}

/// A circle around points: its middle and its radius, m.
fn circle(points: &[Point2]) -> (Point2, f32) {
    let count = points.len().max(1) as f32;
    let sum = points.iter().fold([0.0; 2], |sum, point| [sum[0] + point.x, sum[1] + point.y]);
    let middle = Point2::new(sum[0] / count, sum[1] / count);
    (middle, points.iter().map(|point| middle.distance(*point).0).fold(0.0, f32::max))
}

/// The distance of a point from the piece of line between two others, m.
fn distance_to_line(point: Point2, a: Point2, b: Point2) -> f32 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let (px, py) = (point.x - a.x, point.y - a.y);
    let square = dx * dx + dy * dy;
    let along = if square > 0.0 { ((px * dx + py * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
    let (ex, ey) = (px - along * dx, py - along * dy);
    (ex * ex + ey * ey).sqrt()
}

fn obstruction(edges: &[[Point2; 2]], a: Point2, b: Point2) -> Obstruction {
    let mut crossings: Vec<f32> = edges.iter().filter_map(|edge| crossing(a, b, edge)).collect();
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
