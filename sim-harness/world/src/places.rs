//! Finds where along the skeleton a point of the floor plan lies.
//!
//! Near a centre-line that is its foot. Farther off, in a hall or beside a bend, a point has several
//! feet, and the nearest one changes by metres where the point passes the line between them. The
//! place of a point is therefore the *mean* of the centre-lines around it, with weights that fall
//! from those of the foot to zero at [`REACH`] times its distance: on a straight gallery the two
//! sides weigh the same, and the mean is the foot; close to a bend, where the foot is near, so is all
//! that counts. A centre-line that the point does not see is as far off as the way round a corner of the
//! rock, so that a gallery on the other side of a wall has no part in the mean, and one that comes
//! into view has its part already.
//!
//! The place is a function of the point, and it is continuous. How the point came there matters only
//! where the route passes above or below itself, which one plan shows as a crossing.

mod cell;

use std::cell::RefCell;
use std::sync::OnceLock;

use units::Point2;

use super::skeleton::Mass;
use super::{Skeleton, SkeletonPlace, Tunnel};
use cell::Cell;

/// The distance at which a centre-line counts no more, in distances of the nearest one. Chosen for
/// the steepness of the place in the plans of this module's tests: with 2 it is a third more, with 4
/// a tenth less, and more bends have a part in each place.
const REACH: f32 = 3.0;

/// The length of the stretches of a centre-line that are hidden behind a wall or not, m.
const STRETCH_M: f32 = 0.5;

/// The edge of a cell, in which the same centre-lines and walls are near, m.
const CELL_M: f32 = 2.0;

/// A point nearer to a centre-line than this is on it, m.
const ON_THE_LINE_M: f32 = 1e-4;

/// The way from a point's last place to a centre-line that passes above or below, in distances of the
/// point from it, and what is added to that, m: no drone flies so far round in one round.
const ANOTHER_LEVEL: f32 = 10.0;
const ANOTHER_LEVEL_M: f32 = 3.0;

/// The centre-lines as straight pieces, and which of them are near.
#[derive(Debug)]
pub(super) struct Places {
    pieces: Vec<Piece>,
    /// The corners of the rock, round which a way may lead.
    corners: Vec<Point2>,
    low: Point2,
    columns: usize,
    rows: usize,
    /// The cells, row-major, each filled when a point in it is first asked for.
    cells: Vec<OnceLock<Cell>>,
}

/// A straight piece of a centre-line.
#[derive(Clone, Copy, Debug)]
struct Piece {
    edge: u16,
    /// The length along the edge at which it begins, m.
    from: f32,
    length: f32,
    ends: [Point2; 2],
    /// How far the gallery goes on beyond the piece's beginning and end, m: at the mouth and at a
    /// dead end there is floor behind the last point of the centre-line.
    beyond: [f32; 2],
}

/// Where a point is, seen from a piece.
#[derive(Clone, Copy)]
struct Seen {
    /// The foot on the line through the piece, counted from its beginning, m.
    foot: f32,
    /// The distance from that line, m.
    off: f32,
    /// The foot on the piece itself, as a part of its length.
    part: f32,
    /// The distance from the piece, m.
    distance: f32,
}

impl Piece {
    fn see(&self, point: Point2) -> Seen {
        let [a, b] = self.ends;
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let (px, py) = (point.x - a.x, point.y - a.y);
        let part = (px * dx + py * dy) / (dx * dx + dy * dy);
        let nearest = part.clamp(0.0, 1.0);
        let (ex, ey) = (px - nearest * dx, py - nearest * dy);
        Seen {
            foot: part * self.length,
            off: (px * dy - py * dx).abs() / self.length,
            part: nearest,
            distance: (ex * ex + ey * ey).sqrt(),
        }
    }

    /// The point this far from the piece's beginning, m.
    fn at(&self, along: f32) -> Point2 {
        let [a, b] = self.ends;
        let part = along / self.length;
        Point2::new(a.x + part * (b.x - a.x), a.y + part * (b.y - a.y))
    }

    fn place(&self, part: f32) -> SkeletonPlace {
        SkeletonPlace { edge: self.edge, along: self.from + part * self.length }
    }
}

impl Places {
    /// The places on a skeleton in the free space with these walls and these corners of the rock.
    pub(super) fn of(skeleton: &Skeleton, walls: &[[Point2; 2]], corners: Vec<Point2>) -> Self {
        let pieces = skeleton.edges().iter().enumerate().flat_map(|(n, edge)| {
            let points = edge.line().points();
            let last = points.len().saturating_sub(2);
            // Not as far as the wall, which has two sides.
            let half = 0.45 * edge.width().0;
            let [open, shut] =
                skeleton.free_ends(n).map(|is_free| if is_free { half } else { 0.0 });
            points.windows(2).enumerate().map(move |(k, pair)| Piece {
                edge: n as u16,
                from: edge.line().length_at(k),
                length: edge.line().length_at(k + 1) - edge.line().length_at(k),
                ends: [pair[0], pair[1]],
                beyond: [if k == 0 { open } else { 0.0 }, if k == last { shut } else { 0.0 }],
            })
        });
        let pieces: Vec<Piece> = pieces.collect();
        let points = walls.iter().flatten().chain(pieces.iter().flat_map(|piece| &piece.ends));
        let low = points.clone().fold([f32::INFINITY; 2], |l, p| [l[0].min(p.x), l[1].min(p.y)]);
        let high = points.fold([f32::NEG_INFINITY; 2], |h, p| [h[0].max(p.x), h[1].max(p.y)]);
        let count = |axis: usize| ((high[axis] - low[axis]) / CELL_M) as usize + 1;
        let (columns, rows) = (count(0), count(1));
        let cells = (0..columns * rows).map(|_| OnceLock::new()).collect();
        Self { pieces, corners, low: Point2::new(low[0], low[1]), columns, rows, cells }
    }

    /// The cell of a point; the nearest one for a point outside.
    fn cell(&self, point: Point2, walls: &[[Point2; 2]]) -> &Cell {
        let index = |at: f32, low: f32, count: usize| {
            (((at - low) / CELL_M).max(0.0) as usize).min(count - 1)
        };
        let column = index(point.x, self.low.x, self.columns);
        let row = index(point.y, self.low.y, self.rows);
        self.cells[row * self.columns + column].get_or_init(|| {
            let middle = |n: usize, low: f32| low + (n as f32 + 0.5) * CELL_M;
            let middle = Point2::new(middle(column, self.low.x), middle(row, self.low.y));
            Cell::of(self, middle, walls)
        })
    }
}

impl Tunnel {
    /// The place of a point of the free space on the skeleton. `last` is where the point was a moment
    /// before, which decides between two levels of a route that crosses itself in the plan.
    #[must_use]
    pub fn place(&self, point: Point2, last: Option<SkeletonPlace>) -> SkeletonPlace {
        let mut around = Around::new(self, point, last);
        let near = around.nearest().or_else(|| {
            around.last = None;
            around.nearest()
        });
        let Some((piece, seen, distance)) = near else { return SkeletonPlace::default() };
        if distance <= ON_THE_LINE_M {
            return self.skeleton().settled(piece.place(seen.part));
        }
        let mut masses = Vec::new();
        around.weigh(distance, &mut masses);
        let place = match masses.is_empty() {
            true => piece.place(seen.part),
            false => self.skeleton().middle(&masses),
        };
        self.skeleton().settled(place)
    }
}

/// A point and what is around it.
struct Around<'a> {
    tunnel: &'a Tunnel,
    cell: &'a Cell,
    point: Point2,
    last: Option<SkeletonPlace>,
    /// The distance from the middle of the cell, m.
    off_middle: f32,
    /// No wall is nearer, m.
    clearance: f32,
    /// The lengths of the straight lines to corners, by their numbers, as far as they are known, m.
    to_corners: RefCell<Vec<(usize, f32)>>,
}

impl<'a> Around<'a> {
    fn new(tunnel: &'a Tunnel, point: Point2, last: Option<SkeletonPlace>) -> Self {
        let cell = tunnel.places().cell(point, tunnel.wall_pieces());
        let off_middle = cell.middle.distance(point).0;
        let clearance = tunnel.clearance(point);
        Self { tunnel, cell, point, last, off_middle, clearance, to_corners: RefCell::default() }
    }

    /// The pieces that may be nearer than what `within` says when each is reached.
    fn pieces(&self) -> impl Iterator<Item = (f32, &'a Piece)> {
        let (off, pieces) = (self.off_middle, &self.tunnel.places().pieces);
        let near = self.cell.pieces.iter();
        near.filter_map(move |(distance, n)| Some((distance - off, pieces.get(*n as usize)?)))
    }

    /// The piece nearest to the point, and how far it counts to be.
    fn nearest(&self) -> Option<(&'a Piece, Seen, f32)> {
        let mut best: Option<(&Piece, Seen, f32)> = None;
        for (at_least, piece) in self.pieces() {
            let known = best.map_or(f32::INFINITY, |(.., distance)| distance);
            if at_least > known {
                break;
            }
            let seen = piece.see(self.point);
            if seen.distance < known && self.is_on_this_level(piece, &seen) {
                let foot = piece.at(seen.part * piece.length);
                let distance = self.way(foot, known);
                if distance < known {
                    best = Some((piece, seen, distance));
                }
            }
        }
        best
    }

    /// Collects what the pieces weigh where the nearest is this far off: nothing where all that counts
    /// is one straight piece, in full view to both sides of the foot, so that the mean is the foot.
    fn weigh(&self, nearest: f32, into: &mut Vec<Mass>) {
        let reach = (REACH * nearest).min(self.cell.reach - self.off_middle);
        let mut is_plain = true;
        for (at_least, piece) in self.pieces() {
            if at_least >= reach {
                break;
            }
            let seen = piece.see(self.point);
            if seen.distance >= reach || !self.is_on_this_level(piece, &seen) {
                continue;
            }
            let half = (reach * reach - seen.off * seen.off).max(0.0).sqrt();
            let low = (seen.foot - half).max(-piece.beyond[0]);
            let high = (seen.foot + half).min(piece.length + piece.beyond[1]);
            is_plain &= low == seen.foot - half && high == seen.foot + half;
            let sum = |low, high| {
                let (mass, along) = weight(&seen, low, high, reach);
                Mass { edge: piece.edge, along: f64::from(piece.from) + along, mass }
            };
            if self.clearance >= reach || self.sees_all(piece.at(low), piece.at(high)) {
                into.push(sum(low, high));
                continue;
            }
            let mut whole = Vec::new();
            is_plain &= self.stretches(piece, [low, high], reach, |low, high, part| {
                let mass = sum(low, high);
                whole.push(Mass { mass: f64::from(part) * mass.mass, ..mass });
            });
            into.extend(Mass::joined(&whole));
        }
        if is_plain && into.len() == 1 {
            into.clear();
        }
    }

    /// Calls `each` for the stretches of a piece with the part of it that counts, and returns whether
    /// all of it does.
    fn stretches(
        &self,
        piece: &Piece,
        [low, high]: [f32; 2],
        reach: f32,
        mut each: impl FnMut(f32, f32, f32),
    ) -> bool {
        let mut all = true;
        let (first, last) = ((low / STRETCH_M).floor() as i32, (high / STRETCH_M).ceil() as i32);
        for n in first..last {
            let from = (n as f32 * STRETCH_M).max(low);
            let to = ((n + 1) as f32 * STRETCH_M).min(high);
            let middle = piece.at(0.5 * (from + to));
            let straight = self.point.distance(middle).0;
            let way = self.way(middle, reach);
            let part = if way > straight { shaded(straight, way, reach) } else { 1.0 };
            all &= part == 1.0;
            if part > 0.0 {
                each(from, to, part);
            }
        }
        all
    }

    /// The length of the way from the point to another, straight or round corners; where there is
    /// none that is shorter than `most`, the straight one through the rock, m.
    fn way(&self, to: Point2, most: f32) -> f32 {
        let straight = self.point.distance(to).0;
        if straight <= self.clearance {
            return straight;
        }
        let direct = self.cell.straight(self.point, to);
        if direct <= straight {
            return straight;
        }
        let mut best = direct;
        for (n, (_, last)) in self.cell.corners.iter().enumerate() {
            let rest = last.distance(to).0;
            if self.point.distance(*last).0 + rest >= best.min(most) {
                continue;
            }
            let rest = self.cell.straight(*last, to);
            best = best.min(self.way_to_corner(n, best.min(most) - rest) + rest);
        }
        best
    }

    /// The length of the way to a corner; infinite where there is none that is shorter than `most`, m.
    fn way_to_corner(&self, corner: usize, most: f32) -> f32 {
        let corners = &self.cell.corners;
        let mut best = f32::INFINITY;
        for ((n, (_, first)), rest) in corners.iter().enumerate().zip(self.cell.ways_from(corner)) {
            if self.point.distance(*first).0 + rest < best.min(most) {
                best = best.min(self.to_corner(n, *first) + rest);
            }
        }
        best
    }

    /// The length of the straight line to a corner, m.
    fn to_corner(&self, n: usize, corner: Point2) -> f32 {
        let mut known = self.to_corners.borrow_mut();
        if let Some((_, length)) = known.iter().find(|(m, _)| *m == n) {
            return *length;
        }
        let length = self.cell.straight(self.point, corner);
        known.push((n, length));
        length
    }

    /// Whether the point sees all that lies between two others: nothing of the rock is in the
    /// triangle.
    fn sees_all(&self, a: Point2, b: Point2) -> bool {
        let side =
            |p: Point2, q: Point2, r: Point2| (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
        let is_in = |corner: Point2| {
            let sides =
                [side(self.point, a, corner), side(a, b, corner), side(b, self.point, corner)];
            sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
        };
        let is_free = |to: Point2| {
            let straight = self.point.distance(to).0;
            straight <= self.clearance || self.cell.straight(self.point, to) <= straight
        };
        let far = self.off_middle + self.point.distance(a).0.max(self.point.distance(b).0);
        let mut near = self.cell.corners.iter().take_while(|(distance, _)| *distance <= far);
        self.cell.has_all_corners
            && !near.any(|(_, corner)| is_in(*corner))
            && is_free(a)
            && is_free(b)
    }

    fn is_on_this_level(&self, piece: &Piece, seen: &Seen) -> bool {
        self.last.is_none_or(|last| {
            let way = self.tunnel.skeleton().distance(last, piece.place(seen.part)).0;
            way <= ANOTHER_LEVEL * seen.distance + ANOTHER_LEVEL_M
        })
    }
}

/// The part that is left of the weight of a stretch to which the way is longer than the straight line.
fn shaded(straight: f32, way: f32, reach: f32) -> f32 {
    let weight = |distance: f32| 1.0 / (distance * distance) - 1.0 / (reach * reach);
    let (behind, free) = (weight(way), weight(straight));
    if free > 0.0 { (behind / free).clamp(0.0, 1.0) } else { 0.0 }
}

/// The weight of a stretch of a piece and its mean length along the piece, m: each point at the
/// distance d counts 1/d² − 1/reach².
fn weight(seen: &Seen, low: f32, high: f32, reach: f32) -> (f64, f64) {
    let [foot, reach] = [seen.foot, reach].map(f64::from);
    let off = f64::from(seen.off).max(1e-4 * reach);
    let (a, b) = (f64::from(low) - foot, f64::from(high) - foot);
    let per_square = 1.0 / (reach * reach);
    let mass = (libm::atan(b / off) - libm::atan(a / off)) / off - (b - a) * per_square;
    let square = |t: f64| off * off + t * t;
    let moment = 0.5 * libm::log(square(b) / square(a)) - 0.5 * (b * b - a * a) * per_square;
    if mass > 0.0 { (mass, foot + (moment / mass).max(a).min(b)) } else { (0.0, foot) }
}
