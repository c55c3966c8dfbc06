//! Draws a tunnel as an occupancy map.

use robot_maps::{Cell, Occupancy};
use units::Point2;

use super::Tunnel;

/// What is drawn around the free space, m.
const MARGIN_M: f64 = 0.5;

/// The most cells of a map that is drawn.
pub const MOST_CELLS: usize = 16_000_000;

impl Tunnel {
    /// The occupancy map of the tunnel, in cells of this edge: a cell is free where its middle is,
    /// occupied where it touches a free one, and otherwise unknown, as in a map that a robot made.
    /// `None` where it would have more than [`MOST_CELLS`].
    #[must_use]
    pub fn occupancy(&self, resolution_m: f64) -> Option<Occupancy> {
        let corners = self.outlines().iter().flatten();
        let low = corners.clone().fold([f64::INFINITY; 2], |low, point| {
            [low[0].min(f64::from(point.x)), low[1].min(f64::from(point.y))]
        });
        let high = corners.fold([f64::NEG_INFINITY; 2], |high, point| {
            [high[0].max(f64::from(point.x)), high[1].max(f64::from(point.y))]
        });
        // The grid's lines lie at whole cells from the origin, whatever is drawn.
        let origin = low.map(|low| ((low - MARGIN_M) / resolution_m).floor() * resolution_m);
        let count = |axis: usize| ((high[axis] + MARGIN_M - origin[axis]) / resolution_m).ceil();
        let (columns, rows) = (count(0), count(1));
        if !(columns >= 1.0 && rows >= 1.0 && columns * rows <= MOST_CELLS as f64) {
            return None;
        }
        let (columns, rows) = (columns as usize, rows as usize);
        let mut cells = vec![Cell::Unknown; columns * rows];
        for (row, line) in cells.chunks_exact_mut(columns).enumerate() {
            let y = origin[1] + (row as f64 + 0.5) * resolution_m;
            for pair in self.crossings(y as f32).chunks_exact(2) {
                let cell = |x: f32| ((f64::from(x) - origin[0]) / resolution_m - 0.5).ceil();
                let (from, to) = (cell(pair[0]).max(0.0) as usize, cell(pair[1]).max(0.0) as usize);
                let to = to.min(columns);
                line[from.min(to)..to].fill(Cell::Free);
            }
        }
        walled(&mut cells, columns);
        Some(Occupancy::new(columns, cells, resolution_m, [origin[0], origin[1], 0.0]))
    }

    /// Where a line along x crosses the outlines, in order.
    fn crossings(&self, y: f32) -> Vec<f32> {
        let outlines = self.outlines().iter();
        let edges = outlines.flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
        let crossed = edges.filter(|(p, q)| (p.y > y) != (q.y > y));
        let at = |(p, q): (&Point2, &Point2)| p.x + (y - p.y) / (q.y - p.y) * (q.x - p.x);
        let mut found: Vec<f32> = crossed.map(at).collect();
        found.sort_by(f32::total_cmp);
        found
    }
}

/// Makes the unknown cells that touch free ones occupied.
fn walled(cells: &mut [Cell], columns: usize) {
    let rows = cells.len() / columns;
    let free: Vec<usize> = (0..cells.len()).filter(|cell| cells[*cell] == Cell::Free).collect();
    for cell in free {
        let (column, row) = (cell % columns, cell / columns);
        for y in row.saturating_sub(1)..(row + 2).min(rows) {
            for x in column.saturating_sub(1)..(column + 2).min(columns) {
                let other = &mut cells[y * columns + x];
                if *other == Cell::Unknown {
                    *other = Cell::Occupied;
                }
            }
        }
    }
}
