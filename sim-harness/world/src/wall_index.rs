//! Stores the walls as segments in a grid, which finds the segments near a beam or a drone.
//!
//! A beam is followed from cell to cell and compared with the segments of each; a drone is
//! compared with the segments of the cells around it. A second, finer grid holds a lower bound on
//! the distance to the nearest wall: in nearly every physics step it says that nothing is near.

use units::Point2;

/// One straight piece of wall.
#[derive(Clone, Copy, Debug)]
struct Segment {
    from: Point2,
    /// The vector to its other end, m.
    way: [f32; 2],
    length_squared: f32,
}

/// The first wall that a beam meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hit {
    /// m.
    pub(super) distance: f32,
    /// The cosine of the angle between the beam and the wall's normal.
    pub(super) slant: f32,
}

/// The first of the segments that a beam has been compared with, and how far away it is.
struct Met<'a> {
    distance: f32,
    segment: Option<&'a Segment>,
}

impl<'a> Met<'a> {
    fn consider(&mut self, segment: &'a Segment, at: Point2, direction: [f32; 2]) {
        if let Some(distance) = segment.met_by(at, direction)
            && distance < self.distance
        {
            *self = Self { distance, segment: Some(segment) };
        }
    }

    fn hit(&self, direction: [f32; 2]) -> Option<Hit> {
        Some(Hit { distance: self.distance, slant: self.segment?.slant(direction) })
    }
}

/// All walls of a floor plan.
#[derive(Debug)]
pub(super) struct WallIndex {
    segments: Vec<Segment>,
    grid: Grid,
    nearby: Nearby,
    clearance: Clearance,
}

impl WallIndex {
    /// The walls along these edges of outlines.
    pub(super) fn new(edges: &[[Point2; 2]]) -> Self {
        let segment = |&[a, b]: &[Point2; 2]| {
            let way = [b.x - a.x, b.y - a.y];
            Segment { from: a, way, length_squared: dot(way, way) }
        };
        let segments: Vec<_> = edges.iter().map(segment).collect();
        let bounds = Bounds::of(edges);
        let grid = Grid::new(&bounds, &segments);
        let nearby = Nearby::new(&bounds, &segments);
        let clearance = Clearance::new(&bounds, &segments);
        Self { segments, grid, nearby, clearance }
    }

    /// The first wall within `reach` of `at` along the unit vector `direction`.
    pub(super) fn cast(&self, at: Point2, direction: [f32; 2], reach: f32) -> Option<Hit> {
        let mut best = Met { distance: reach, segment: None };
        let mut consider = |segment| {
            best.consider(segment, at, direction);
            best.distance
        };
        if let Some(nearby) = self.nearby.around(at, reach) {
            nearby.iter().for_each(|segment| {
                consider(segment);
            });
            return best.hit(direction);
        }
        match self.grid.walk(at, direction) {
            Some(mut walk) => loop {
                let mut nearest = reach;
                for &n in self.grid.near(walk.column, walk.row) {
                    nearest = consider(&self.segments[n as usize]);
                }
                if nearest <= walk.leaves_at() || walk.leaves_at() > reach || !walk.step() {
                    break;
                }
            },
            None => self.segments.iter().for_each(|segment| {
                consider(segment);
            }),
        }
        best.hit(direction)
    }

    /// A lower bound on the distance to the nearest wall, m.
    pub(super) fn clearance(&self, at: Point2) -> f32 {
        self.clearance.at_least(at)
    }

    /// The point of the nearest wall, if that is nearer to `at` than `radius`.
    pub(super) fn touching(&self, at: Point2, radius: f32) -> Option<Point2> {
        if self.clearance.at_least(at) > radius {
            return None;
        }
        let mut best = (radius, None);
        self.grid.around(at, radius, |n| {
            let point = self.segments[n as usize].nearest(at);
            let distance = at.distance(point).0;
            if distance < best.0 {
                best = (distance, Some(point));
            }
        });
        best.1
    }
}

impl Segment {
    /// The distance at which a beam meets the segment. (Ericson, *Real-Time Collision Detection*,
    /// 5.1.9: the parameters of the closest points of two lines.)
    fn met_by(&self, at: Point2, direction: [f32; 2]) -> Option<f32> {
        let r = [at.x - self.from.x, at.y - self.from.y];
        let (a, e, f) = (dot(direction, direction), self.length_squared, dot(self.way, r));
        if a <= f32::EPSILON || e <= f32::EPSILON {
            return None;
        }
        let (b, c) = (dot(direction, self.way), dot(direction, r));
        let denominator = a * e - b * b;
        if denominator <= f32::EPSILON || nearly_equal(a * e, b * b) {
            return self.met_lengthways(at, direction);
        }
        let distance = (b * f - c * e) / denominator;
        let along = (b * distance + f) / e;
        (distance >= 0.0 && (0.0..=1.0).contains(&along)).then_some(distance)
    }

    /// The distance for a beam that is parallel to the segment, and meets it only if it runs along
    /// it.
    fn met_lengthways(&self, at: Point2, direction: [f32; 2]) -> Option<f32> {
        let r = [self.from.x - at.x, self.from.y - at.y];
        if dot(r, self.normal()).abs() >= f32::EPSILON {
            return None;
        }
        let near = dot(r, direction);
        let far = near + dot(self.way, direction);
        match (near >= 0.0, far >= 0.0) {
            (true, true) => Some(near.min(far) / dot(direction, direction)),
            (true, false) | (false, true) => Some(0.0),
            (false, false) => None,
        }
    }

    fn normal(&self) -> [f32; 2] {
        let scale = 1.0 / self.length_squared.sqrt();
        [self.way[1] * scale, -self.way[0] * scale]
    }

    fn slant(&self, direction: [f32; 2]) -> f32 {
        dot(direction, self.normal()).abs()
    }

    fn nearest(&self, at: Point2) -> Point2 {
        let along = dot(self.way, [at.x - self.from.x, at.y - self.from.y]);
        if along <= 0.0 {
            self.from
        } else if along >= self.length_squared {
            self.end()
        } else {
            let part = along / self.length_squared;
            Point2::new(self.from.x + self.way[0] * part, self.from.y + self.way[1] * part)
        }
    }

    fn end(&self) -> Point2 {
        Point2::new(self.from.x + self.way[0], self.from.y + self.way[1])
    }
}

fn dot(a: [f32; 2], b: [f32; 2]) -> f32 {
    a[0] * b[0] + a[1] * b[1]
}

/// Whether two positive numbers are at most four apart in the order of all floats.
fn nearly_equal(a: f32, b: f32) -> bool {
    a.to_bits().abs_diff(b.to_bits()) <= 4
}

/// The rectangle around all walls.
#[derive(Clone, Copy)]
struct Bounds {
    low: Point2,
    high: Point2,
}

impl Bounds {
    fn of(edges: &[[Point2; 2]]) -> Self {
        let low = |a: Point2, b: &Point2| Point2::new(a.x.min(b.x), a.y.min(b.y));
        let high = |a: Point2, b: &Point2| Point2::new(a.x.max(b.x), a.y.max(b.y));
        let first = edges.first().map_or_else(Point2::default, |edge| edge[0]);
        let points = || edges.iter().flatten();
        Self { low: points().fold(first, low), high: points().fold(first, high) }
    }

    /// The edge of square cells of at least `least` of which about `most` cover everything.
    fn cell(&self, least: f32, most: f32) -> f32 {
        let (width, height) = (self.high.x - self.low.x, self.high.y - self.low.y);
        least.max((width * height / most).sqrt())
    }
}

/// Rows and columns of square cells.
#[derive(Clone, Copy, Debug)]
struct Lattice {
    low: Point2,
    cell: f32,
    /// Cells in a metre: looked up in every physics step, a product is cheaper than a quotient.
    per_metre: f32,
    columns: usize,
    rows: usize,
}

impl Lattice {
    fn over(bounds: &Bounds, cell: f32) -> Self {
        let columns = ((bounds.high.x - bounds.low.x) / cell) as usize + 1;
        let rows = ((bounds.high.y - bounds.low.y) / cell) as usize + 1;
        Self { low: bounds.low, cell, per_metre: 1.0 / cell, columns, rows }
    }

    /// Column and row of a point; `None` outside.
    fn cell_of(&self, at: Point2) -> Option<(usize, usize)> {
        let column = (at.x - self.low.x) * self.per_metre;
        let row = (at.y - self.low.y) * self.per_metre;
        if !(column >= 0.0 && row >= 0.0) {
            return None;
        }
        // A number becomes 32 bits in a third of the instructions that it takes to become 64.
        let (column, row) = (column as u32 as usize, row as u32 as usize);
        (column < self.columns && row < self.rows).then_some((column, row))
    }

    fn middle(&self, column: usize, row: usize) -> Point2 {
        Point2::new(
            self.low.x + (column as f32 + 0.5) * self.cell,
            self.low.y + (row as f32 + 0.5) * self.cell,
        )
    }

    /// Columns and rows of the cells within `margin` of the rectangle around two points.
    fn around(&self, a: Point2, b: Point2, margin: f32) -> impl Iterator<Item = (usize, usize)> {
        let range = |from: f32, to: f32, low: f32, count: usize| {
            let first = ((from.min(to) - margin - low) * self.per_metre).max(0.0) as u32 as usize;
            let last = ((from.max(to) + margin - low) * self.per_metre).max(0.0) as u32 as usize;
            first.min(count - 1)..=last.min(count - 1)
        };
        let columns = range(a.x, b.x, self.low.x, self.columns);
        let rows = range(a.y, b.y, self.low.y, self.rows);
        rows.flat_map(move |row| columns.clone().map(move |column| (column, row)))
    }
}

/// The segments by cells.
#[derive(Debug)]
struct Grid {
    lattice: Lattice,
    /// The indices in `members` at which each cell's segments begin, row-major, and the end of the
    /// last one's.
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl Grid {
    /// Edge of the smallest cell, m: about the width of a gallery.
    const CELL: f32 = 1.0;
    /// About how many cells there are at most; a larger floor plan has larger cells.
    const MOST_CELLS: f32 = 100_000.0;
    /// A segment belongs to a cell if it comes so near to it, m: more than the rounding in a
    /// beam's way from cell to cell.
    const MARGIN: f32 = 1e-2;

    fn new(bounds: &Bounds, segments: &[Segment]) -> Self {
        let lattice = Lattice::over(bounds, bounds.cell(Self::CELL, Self::MOST_CELLS));
        let mut cells: Vec<Vec<u32>> = vec![Vec::new(); lattice.columns * lattice.rows];
        for (n, segment) in segments.iter().enumerate() {
            for (column, row) in lattice.around(segment.from, segment.end(), Self::MARGIN) {
                if Self::comes_near(&lattice, segment, column, row) {
                    cells[row * lattice.columns + column].push(n as u32);
                }
            }
        }
        let mut starts = vec![0];
        let mut members = Vec::new();
        for cell in cells {
            members.extend(cell);
            starts.push(members.len() as u32);
        }
        Self { lattice, starts, members }
    }

    /// Whether the line of a segment, whose rectangle covers the cell, passes through it.
    fn comes_near(lattice: &Lattice, segment: &Segment, column: usize, row: usize) -> bool {
        let middle = lattice.middle(column, row);
        let [nx, ny] = segment.normal();
        if !nx.is_finite() {
            return true;
        }
        let off = nx * (middle.x - segment.from.x) + ny * (middle.y - segment.from.y);
        off.abs() <= (nx.abs() + ny.abs()) * (0.5 * lattice.cell + Self::MARGIN)
    }

    fn near(&self, column: usize, row: usize) -> &[u32] {
        let cell = row * self.lattice.columns + column;
        &self.members[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// Every segment within `radius` of a point, some of them twice, and some beyond.
    fn around(&self, at: Point2, radius: f32, mut each: impl FnMut(u32)) {
        for (column, row) in self.lattice.around(at, at, radius) {
            self.near(column, row).iter().for_each(|n| each(*n));
        }
    }

    /// The way of a beam from cell to cell; `None` for one that begins outside.
    fn walk(&self, at: Point2, direction: [f32; 2]) -> Option<Walk> {
        let (column, row) = self.lattice.cell_of(at)?;
        let axis = |at: f32, low: f32, index: usize, way: f32| {
            let ahead = index as f32 + if way > 0.0 { 1.0 } else { 0.0 };
            if way == 0.0 {
                (f32::INFINITY, f32::INFINITY)
            } else {
                ((low + ahead * self.lattice.cell - at) / way, (self.lattice.cell / way).abs())
            }
        };
        let (next_x, step_x) = axis(at.x, self.lattice.low.x, column, direction[0]);
        let (next_y, step_y) = axis(at.y, self.lattice.low.y, row, direction[1]);
        let forward = [direction[0] > 0.0, direction[1] > 0.0];
        let (columns, rows) = (self.lattice.columns, self.lattice.rows);
        Some(Walk {
            column,
            row,
            columns,
            rows,
            forward,
            next: [next_x, next_y],
            step: [step_x, step_y],
        })
    }
}

/// A beam on its way through the grid.
struct Walk {
    column: usize,
    row: usize,
    columns: usize,
    rows: usize,
    /// Whether it goes towards larger columns and rows.
    forward: [bool; 2],
    /// The length of the beam where it enters the next column and the next row, m.
    next: [f32; 2],
    step: [f32; 2],
}

impl Walk {
    /// The length of the beam where it leaves the present cell, m.
    fn leaves_at(&self) -> f32 {
        self.next[0].min(self.next[1])
    }

    /// Moves on to the next cell, unless the grid ends here.
    fn step(&mut self) -> bool {
        let axis = usize::from(self.next[1] < self.next[0]);
        let (index, count) =
            if axis == 0 { (&mut self.column, self.columns) } else { (&mut self.row, self.rows) };
        let moved = if self.forward[axis] { index.checked_add(1) } else { index.checked_sub(1) };
        let Some(moved) = moved.filter(|n| *n < count) else { return false };
        *index = moved;
        self.next[axis] += self.step[axis];
        true
    }
}

/// By cells, the segments that a short beam from the cell can meet, where they are few: comparing
/// with each of them is then faster than going from cell to cell.
#[derive(Debug)]
struct Nearby {
    lattice: Lattice,
    /// Where each cell's segments are; `None` where they are many.
    cells: Vec<Option<(u32, u32)>>,
    segments: Vec<Segment>,
}

impl Nearby {
    /// Edge of the smallest cell, m.
    const CELL: f32 = 0.5;
    /// About how many cells there are at most; a larger floor plan has larger cells.
    const MOST_CELLS: f32 = 100_000.0;
    /// The longest beam, m: the reach of the side rangers in the paper.
    const REACH: f32 = 2.0;
    /// The most segments of a cell: a beam of 2 m passes two or three cells, with two or three
    /// segments each.
    const MOST_SEGMENTS: usize = 8;

    fn new(bounds: &Bounds, segments: &[Segment]) -> Self {
        let cell = bounds.cell(Self::CELL, Self::MOST_CELLS);
        let lattice = Lattice::over(bounds, cell);
        let mut near: Vec<Vec<u32>> = vec![Vec::new(); lattice.columns * lattice.rows];
        // From the middle of a cell, over a corner, to the end of the beam.
        let margin = Self::REACH + cell * core::f32::consts::FRAC_1_SQRT_2 + Grid::MARGIN;
        for (n, segment) in segments.iter().enumerate() {
            for (column, row) in lattice.around(segment.from, segment.end(), margin) {
                let middle = lattice.middle(column, row);
                let known = &mut near[row * lattice.columns + column];
                let is_near = middle.distance(segment.nearest(middle)).0 <= margin;
                if is_near && known.len() <= Self::MOST_SEGMENTS {
                    known.push(n as u32);
                }
            }
        }
        let mut nearby = Self { lattice, cells: Vec::new(), segments: Vec::new() };
        for known in near {
            let first = nearby.segments.len() as u32;
            let few = known.len() <= Self::MOST_SEGMENTS;
            if few {
                nearby.segments.extend(known.iter().map(|&n| segments[n as usize]));
            }
            nearby.cells.push(few.then_some((first, nearby.segments.len() as u32)));
        }
        nearby
    }

    /// All segments that a beam of this length can meet from `at`; `None` where they are many, or
    /// the beam is too long.
    fn around(&self, at: Point2, reach: f32) -> Option<&[Segment]> {
        if reach > Self::REACH {
            return None;
        }
        let (column, row) = self.lattice.cell_of(at)?;
        let (first, end) = (*self.cells.get(row * self.lattice.columns + column)?)?;
        self.segments.get(first as usize..end as usize)
    }
}

/// A lower bound on the distance to the nearest wall, by cells.
#[derive(Debug)]
struct Clearance {
    lattice: Lattice,
    cells: Vec<f32>,
}

impl Clearance {
    /// Edge of the smallest cell, m.
    const CELL: f32 = 0.1;
    /// About how many cells there are at most; a larger floor plan has larger cells.
    const MOST_CELLS: f32 = 500_000.0;
    /// Farther from every wall than this all places are alike, m: several times what a drone's
    /// guards need.
    const FAR: f32 = 0.5;

    fn new(bounds: &Bounds, segments: &[Segment]) -> Self {
        let cell = bounds.cell(Self::CELL, Self::MOST_CELLS);
        let lattice = Lattice::over(bounds, cell);
        // The distance from the middle of a cell to its corner.
        let slack = cell * core::f32::consts::FRAC_1_SQRT_2;
        let mut cells = vec![Self::FAR.max(cell) - slack; lattice.columns * lattice.rows];
        for segment in segments {
            let margin = Self::FAR.max(cell);
            for (column, row) in lattice.around(segment.from, segment.end(), margin) {
                let middle = lattice.middle(column, row);
                let distance = middle.distance(segment.nearest(middle)).0 - slack;
                let known = &mut cells[row * lattice.columns + column];
                *known = known.min(distance);
            }
        }
        Self { lattice, cells }
    }

    fn at_least(&self, at: Point2) -> f32 {
        let cell = self.lattice.cell_of(at);
        let known =
            cell.and_then(|(column, row)| self.cells.get(row * self.lattice.columns + column));
        known.copied().unwrap_or(f32::NEG_INFINITY)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::*;

    fn walls(corners: &[(f32, f32)]) -> Vec<[Point2; 2]> {
        let points: Vec<_> = corners.iter().map(|&(x, y)| Point2::new(x, y)).collect();
        points.iter().zip(points.iter().cycle().skip(1)).map(|(a, b)| [*a, *b]).collect()
    }

    /// The answer without the grid.
    fn cast_at_all(index: &WallIndex, at: Point2, direction: [f32; 2], reach: f32) -> Option<f32> {
        let all = index.segments.iter().filter_map(|segment| segment.met_by(at, direction));
        all.filter(|distance| *distance < reach).min_by(f32::total_cmp)
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            rng_seed: RngSeed::Fixed(1),
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        #[test]
        fn a_beam_meets_the_same_wall_with_the_grid_and_without(
            corners in prop::collection::vec((-9.0f32..9.0, -9.0f32..9.0), 3..12),
            (x, y) in (-10.0f32..10.0, -10.0f32..10.0),
            angle in 0.0f32..6.3,
            reach in 0.1f32..25.0,
        ) {
            let index = WallIndex::new(&walls(&corners));
            let (at, direction) = (Point2::new(x, y), [libm::cosf(angle), libm::sinf(angle)]);
            let found = index.cast(at, direction, reach).map(|hit| hit.distance);
            prop_assert_eq!(found, cast_at_all(&index, at, direction, reach));
        }

        #[test]
        fn a_disc_touches_the_nearest_wall_and_none_that_is_farther_than_its_radius(
            corners in prop::collection::vec((-3.0f32..3.0, -3.0f32..3.0), 3..8),
            (x, y) in (-3.0f32..3.0, -3.0f32..3.0),
            radius in 0.01f32..1.5,
        ) {
            let index = WallIndex::new(&walls(&corners));
            let at = Point2::new(x, y);
            let distances = index.segments.iter().map(|s| at.distance(s.nearest(at)).0);
            let least = distances.fold(f32::INFINITY, f32::min);
            let found = index.touching(at, radius).map(|point| at.distance(point).0);
            prop_assert_eq!(found, (least < radius).then_some(least));
        }
    }

    #[test]
    fn a_beam_along_a_wall_meets_its_end_and_one_beside_it_nothing() {
        let index = WallIndex::new(&walls(&[(1.0, 0.0), (4.0, 0.0), (4.0, 5.0), (1.0, 5.0)]));
        let east = [1.0, 0.0];
        let along = index.cast(Point2::new(0.0, 0.0), east, 9.0).unwrap();
        assert_eq!(along.distance, 1.0);
        assert_eq!(index.cast(Point2::new(0.0, -0.1), east, 9.0), None);
        let across = index.cast(Point2::new(2.0, 2.0), east, 9.0).unwrap();
        assert_eq!((across.distance, across.slant), (2.0, 1.0));
        assert_eq!(index.cast(Point2::new(2.0, 2.0), east, 2.0), None);
    }
}
