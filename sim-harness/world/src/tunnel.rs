//! Holds a tunnel: the walls that stop beams and drones and attenuate radio, and the skeleton on
//! which places are measured.

use radio_model::Obstruction;
use units::{Metres, Point2};

use super::Skeleton;
use super::layout::{GeometryError, Layout, Passage, outlines, passage_outlines};
use super::places::Places;
use super::wall_index::WallIndex;
use crate::{CentreLine, FloorPlan};

/// A tunnel, made from a floor plan.
#[derive(Debug)]
pub struct Tunnel {
    outlines: Vec<Vec<Point2>>,
    skeleton: Skeleton,
    edges: Vec<[Point2; 2]>,
    walls: WallIndex,
    places: Places,
}

impl Tunnel {
    /// Makes the tunnel from a layout.
    ///
    /// # Errors
    /// [`GeometryError`] where the layout has no walls that could be built.
    pub fn dig(layout: &Layout) -> Result<Self, GeometryError> {
        Ok(Self::within(outlines(layout)?, Skeleton::of(&layout.galleries)))
    }

    /// Makes the tunnel of passages, with the skeleton of their centre-lines, which lead straight
    /// through a chamber in which a survey's line turns back.
    ///
    /// # Errors
    /// [`GeometryError`] where the passages have no walls that could be built.
    pub fn surveyed(skeleton: Skeleton, passages: &[Passage]) -> Result<Self, GeometryError> {
        let found = Self::within(passage_outlines(passages)?, skeleton);
        let sees = |a, b| found.obstruction(a, b).walls == 0;
        let skeleton = found.skeleton.clone().straightened(sees);
        let corners = corners(&found.outlines, &found.edges);
        let places = Places::of(&skeleton, &found.edges, corners);
        Ok(Self { skeleton, places, ..found })
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
        let places = Places::of(&skeleton, &edges, corners(&outlines, &edges));
        Self { outlines, skeleton, edges, walls, places }
    }

    /// The graph of centre-lines.
    #[must_use]
    pub fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// What is known of the places of points.
    pub(super) const fn places(&self) -> &Places {
        &self.places
    }

    /// The pieces of wall.
    pub(super) fn wall_pieces(&self) -> &[[Point2; 2]] {
        &self.edges
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
        is_free(&self.edges, at)
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

fn is_free(edges: &[[Point2; 2]], at: Point2) -> bool {
    let right_of = |[p, q]: &&[Point2; 2]| {
        (p.y > at.y) != (q.y > at.y) && at.x < p.x + (at.y - p.y) / (q.y - p.y) * (q.x - p.x)
    };
    edges.iter().filter(right_of).count() % 2 == 1
}

/// The corners of the rock that a way may lead round, a little off the rock.
fn corners(outlines: &[Vec<Point2>], edges: &[[Point2; 2]]) -> Vec<Point2> {
    /// How far off, m: less than a drone's radius, and more than rounding.
    const OFF_M: f32 = 0.01;
    /// The sine of a bend that is none.
    const STRAIGHT: f32 = 1e-3;
    let unit = |a: Point2, b: Point2| {
        let length = a.distance(b).0.max(f32::MIN_POSITIVE);
        [(b.x - a.x) / length, (b.y - a.y) / length]
    };
    outlines
        .iter()
        .flat_map(|ring| {
            let next = |n: usize| ring[(n + 1) % ring.len()];
            let longest = (0..ring.len()).max_by(|a, b| {
                ring[*a].distance(next(*a)).0.total_cmp(&ring[*b].distance(next(*b)).0)
            });
            let is_left_free = longest.is_some_and(|n| {
                let (a, b, [x, y]) = (ring[n], next(n), unit(ring[n], next(n)));
                let middle =
                    Point2::new(0.5 * (a.x + b.x) - OFF_M * y, 0.5 * (a.y + b.y) + OFF_M * x);
                is_free(edges, middle)
            });
            let corner = move |n: usize| {
                let (at, before) = (next(n), unit(ring[n], next(n)));
                let behind = unit(at, next(n + 1));
                let left = before[0] * behind[1] - before[1] * behind[0];
                let is_corner = if is_left_free { left < -STRAIGHT } else { left > STRAIGHT };
                // Between the two walls of the corner is rock.
                let (x, y) = (before[0] - behind[0], before[1] - behind[1]);
                let scale = OFF_M / (x * x + y * y).sqrt().max(f32::MIN_POSITIVE);
                is_corner.then(|| Point2::new(at.x + scale * x, at.y + scale * y))
            };
            (0..ring.len()).filter_map(corner).collect::<Vec<_>>()
        })
        .collect()
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
    let crossings = crossings(edges, a, b);
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

/// The length of rock on the straight line from `a`, in the free space, to `b`, which may be in the
/// rock, m.
pub(super) fn rock<'a>(
    edges: impl IntoIterator<Item = &'a [Point2; 2]>,
    a: Point2,
    b: Point2,
) -> f32 {
    let crossings = crossings(edges, a, b);
    let solid = |pair: &[f32]| pair.get(1).unwrap_or(&1.0) - pair.first().unwrap_or(&1.0);
    crossings.chunks(2).map(solid).sum::<f32>() * a.distance(b).0
}

/// Where the straight line from `a` to `b` crosses the edges, from 0 (`a`) to 1 (`b`), in order.
fn crossings<'a>(
    edges: impl IntoIterator<Item = &'a [Point2; 2]>,
    a: Point2,
    b: Point2,
) -> Vec<f32> {
    let mut found: Vec<f32> = edges.into_iter().filter_map(|edge| crossing(a, b, edge)).collect();
    found.sort_by(f32::total_cmp);
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
