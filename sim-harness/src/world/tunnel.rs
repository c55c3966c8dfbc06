//! The walls: what beams hit, what drones bump into, and what radio must pass through.

use parry2d::math::Vector;
use parry2d::query::{PointQuery, Ray, RayCast};
use parry2d::shape::Polyline;
use radio_model::Obstruction;
use units::Metres;

use super::CentreLine;
use super::layout::{GeometryError, Layout, outlines};
use crate::trace::{FloorPlan, Point};

/// A floor plan that can be flown in.
pub struct Tunnel {
    outlines: Vec<Vec<Point>>,
    centre_line: CentreLine,
    walls: Polyline,
    edges: Vec<[Point; 2]>,
    clearance: ClearanceGrid,
}

impl Tunnel {
    /// Digs the tunnel.
    ///
    /// # Errors
    /// [`GeometryError`] where the layout has no walls that could be built.
    pub fn dig(layout: &Layout) -> Result<Self, GeometryError> {
        let outlines = outlines(layout)?;
        let (mut vertices, mut indices) = (Vec::new(), Vec::new());
        let mut edges = Vec::new();
        for ring in &outlines {
            let first = vertices.len() as u32;
            let count = ring.len() as u32;
            vertices.extend(ring.iter().map(|&[x, y]| Vector::new(x, y)));
            indices.extend((0..count).map(|n| [first + n, first + (n + 1) % count]));
            let next = ring.iter().cycle().skip(1);
            edges.extend(ring.iter().zip(next).map(|(&a, &b)| [a, b]));
        }
        let walls = Polyline::new(vertices, Some(indices));
        let clearance = ClearanceGrid::new(&walls);
        let centre_line = CentreLine::new(layout.main.centre_line.clone());
        Ok(Self { outlines, centre_line, walls, edges, clearance })
    }

    /// The centre-line of the main corridor.
    #[must_use]
    pub fn centre_line(&self) -> &CentreLine {
        &self.centre_line
    }

    /// The floor plan for pictures.
    #[must_use]
    pub fn floor_plan(&self) -> FloorPlan {
        FloorPlan {
            outlines: self.outlines.clone(),
            centre_line: self.centre_line.points().to_vec(),
        }
    }

    /// How far it is from `at` to the first wall along the unit vector `direction`, or infinity
    /// where there is none within `reach`.
    #[must_use]
    pub fn range(&self, at: Point, direction: [f32; 2], reach: f32) -> f32 {
        let ray = Ray::new(Vector::new(at[0], at[1]), Vector::new(direction[0], direction[1]));
        self.walls.cast_local_ray(&ray, reach, false).unwrap_or(f32::INFINITY)
    }

    /// The same, with the cosine of the angle between the beam and the wall's normal; `None` where
    /// there is no wall within `reach`.
    #[must_use]
    pub fn strike(&self, at: Point, direction: [f32; 2], reach: f32) -> Option<(f32, f32)> {
        let ray = Ray::new(Vector::new(at[0], at[1]), Vector::new(direction[0], direction[1]));
        let hit = self.walls.cast_local_ray_and_get_normal(&ray, reach, false)?;
        let slant = direction[0] * hit.normal.x + direction[1] * hit.normal.y;
        Some((hit.time_of_impact, slant.abs()))
    }

    /// Where a disc of this radius at `at` is stopped by the walls: the nearest place where it
    /// fits, or `None` where it does not touch any.
    #[must_use]
    pub fn bump(&self, at: Point, radius: f32) -> Option<Point> {
        if self.clearance.at_least(at) > radius {
            return None;
        }
        let here = Vector::new(at[0], at[1]);
        let wall = self.walls.project_local_point(here, false).point;
        let away = here - wall;
        let distance = away.length();
        if distance >= radius || distance == 0.0 {
            return None;
        }
        let free = wall + away * (radius / distance);
        Some([free.x, free.y])
    }

    /// What the straight line from `a` to `b`, both in the free space, goes through.
    #[must_use]
    pub fn obstruction(&self, a: Point, b: Point) -> Obstruction {
        let mut crossings: Vec<f32> =
            self.edges.iter().filter_map(|edge| crossing(a, b, edge)).collect();
        crossings.sort_by(f32::total_cmp);
        let length = super::centre_line::distance(a, b);
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

/// Where between 0 (`a`) and 1 (`b`) the line crosses this edge. An edge owns its lower end only,
/// so a line through a corner crosses once.
fn crossing(a: Point, b: Point, edge: &[Point; 2]) -> Option<f32> {
    let [p, q] = *edge;
    let side = |c: Point| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let (sp, sq) = (side(p), side(q));
    if (sp > 0.0) == (sq > 0.0) {
        return None;
    }
    let on_edge = sp / (sp - sq);
    let hit = [p[0] + on_edge * (q[0] - p[0]), p[1] + on_edge * (q[1] - p[1])];
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let along = ((hit[0] - a[0]) * dx + (hit[1] - a[1]) * dy) / (dx * dx + dy * dy);
    (0.0..=1.0).contains(&along).then_some(along)
}

/// A lower bound on the distance to the nearest wall, looked up in constant time: it tells in
/// nearly every physics step that nothing is near.
struct ClearanceGrid {
    origin: Point,
    /// Cells in a metre: looked up in every physics step, a product is cheaper than a quotient.
    per_metre: f32,
    columns: usize,
    rows: usize,
    cells: Vec<f32>,
}

impl ClearanceGrid {
    /// Edge of the smallest cell in metres.
    const CELL: f32 = 0.1;
    /// About how many cells there are at most; a larger floor plan has larger cells.
    const MOST_CELLS: f32 = 500_000.0;

    fn new(walls: &Polyline) -> Self {
        let bounds = walls.local_aabb();
        let extent = bounds.maxs - bounds.mins;
        let cell = Self::CELL.max((extent.x * extent.y / Self::MOST_CELLS).sqrt());
        let columns = (extent.x / cell) as usize + 1;
        let rows = (extent.y / cell) as usize + 1;
        // From the middle of a cell to its corner.
        let slack = cell * core::f32::consts::FRAC_1_SQRT_2;
        let mut cells = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            for column in 0..columns {
                let middle =
                    bounds.mins + Vector::new(column as f32 + 0.5, row as f32 + 0.5) * cell;
                let wall = walls.project_local_point(middle, false).point;
                cells.push((middle - wall).length() - slack);
            }
        }
        Self { origin: [bounds.mins.x, bounds.mins.y], per_metre: 1.0 / cell, columns, rows, cells }
    }

    fn at_least(&self, at: Point) -> f32 {
        let column = (at[0] - self.origin[0]) * self.per_metre;
        let row = (at[1] - self.origin[1]) * self.per_metre;
        if column < 0.0 || row < 0.0 {
            return f32::NEG_INFINITY;
        }
        let (column, row) = (column as usize, row as usize);
        if column >= self.columns || row >= self.rows {
            return f32::NEG_INFINITY;
        }
        self.cells.get(row * self.columns + column).copied().unwrap_or(f32::NEG_INFINITY)
    }
}
