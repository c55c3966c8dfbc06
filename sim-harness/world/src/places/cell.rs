//! Holds what is near a small part of the floor plan, and the ways round the corners there.

use std::sync::OnceLock;

use units::Point2;

use super::{CELL_M, Piece, Places, REACH};
use crate::tunnel::rock;

/// By how much a metre of rock makes a centre-line farther, m: a wall of 0.1 m hides one in a gallery
/// of 2 m. More of it makes the place steeper at the edges of walls.
const ROCK: f32 = 20.0;

/// The most corners round which a way is looked for, the nearest ones: the ways between all of them are
/// kept.
const MOST_CORNERS: usize = 40;

/// What is near one cell, the nearest to its middle first, each with its distance from there, m.
#[derive(Debug)]
pub(super) struct Cell {
    pub(super) middle: Point2,
    /// Numbers of pieces.
    pub(super) pieces: Vec<(f32, u32)>,
    pub(super) walls: Vec<(f32, [Point2; 2])>,
    pub(super) corners: Vec<(f32, Point2)>,
    /// Whether none was left out.
    pub(super) has_all_corners: bool,
    /// The lengths of the ways between the corners, row by row, m; found where they are needed.
    between: OnceLock<Vec<f32>>,
    /// Farther pieces and walls are left out, m.
    pub(super) reach: f32,
}

impl Cell {
    /// What is near a cell with this middle.
    pub(super) fn of(places: &Places, middle: Point2, walls: &[[Point2; 2]]) -> Self {
        let distances = places.pieces.iter().map(|piece| piece.see(middle).distance);
        let mut pieces: Vec<(f32, u32)> = distances.zip(0..).collect();
        pieces.sort_by(|a, b| a.0.total_cmp(&b.0));
        let nearest = pieces.first().map_or(0.0, |(distance, _)| *distance);
        // The nearest one may be behind rock.
        let reach = (REACH + 1.0) * (nearest + CELL_M) + CELL_M;
        pieces.retain(|(distance, _)| *distance <= reach);
        let mut walls: Vec<_> =
            walls.iter().map(|wall| (distance_to_wall(middle, wall), *wall)).collect();
        walls.retain(|(distance, _)| *distance <= reach);
        walls.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut corners: Vec<_> =
            places.corners.iter().map(|corner| (middle.distance(*corner).0, *corner)).collect();
        corners.retain(|(distance, _)| *distance <= reach);
        corners.sort_by(|a, b| a.0.total_cmp(&b.0));
        let has_all_corners = corners.len() <= MOST_CORNERS;
        corners.truncate(MOST_CORNERS);
        Self { middle, pieces, walls, corners, has_all_corners, between: OnceLock::new(), reach }
    }

    /// The length of the straight line between two points near by, which rock makes longer, m.
    pub(super) fn straight(&self, from: Point2, to: Point2) -> f32 {
        let middle = Point2::new(0.5 * (from.x + to.x), 0.5 * (from.y + to.y));
        let length = from.distance(to).0;
        let far = self.middle.distance(middle).0 + 0.5 * length;
        let near = self.walls.iter().take_while(|(distance, _)| *distance <= far);
        length + ROCK * rock(near.map(|(_, wall)| wall), from, to)
    }

    /// The lengths of the ways from a corner to all, m.
    pub(super) fn ways_from(&self, corner: usize) -> &[f32] {
        let between = self.between.get_or_init(|| self.ways_between());
        between.chunks(self.corners.len()).nth(corner).unwrap_or_default()
    }

    /// The lengths of the shortest ways between the corners, by Floyd and Warshall.
    fn ways_between(&self) -> Vec<f32> {
        let count = self.corners.len();
        let mut ways = vec![0.0; count * count];
        for (n, (_, from)) in self.corners.iter().enumerate() {
            for (m, (_, to)) in self.corners.iter().enumerate().take(n) {
                let way = self.straight(*from, *to);
                ways[n * count + m] = way;
                ways[m * count + n] = way;
            }
        }
        for via in 0..count {
            for from in 0..count {
                let first = ways[from * count + via];
                for to in 0..count {
                    let way = first + ways[via * count + to];
                    let known = &mut ways[from * count + to];
                    *known = known.min(way);
                }
            }
        }
        ways
    }
}

/// The distance of a point from a piece of wall, m.
fn distance_to_wall(point: Point2, [a, b]: &[Point2; 2]) -> f32 {
    let length = a.distance(*b).0;
    let wall = Piece { edge: 0, from: 0.0, length, ends: [*a, *b], beyond: [0.0; 2] };
    if length > 0.0 { wall.see(point).distance } else { point.distance(*a).0 }
}
