//! Computes the outlines of the free space from centre-lines, widths and rooms.
//!
//! It uses only sums, products and square roots, so that the outlines have the same bits on every
//! machine.

use std::fmt;

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::overlay::{FloatOverlay, OverlayOptions};
use units::Point2;

use super::Gallery;

/// A rectangle of free space with sides along x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// The middle of the room.
    pub centre: Point2,
    /// The extent of the room along x and y, in metres.
    pub size: [f32; 2],
}

/// The free space of a floor plan: galleries and rooms.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// The galleries, of which there must be one; the first is the main one.
    pub galleries: Vec<Gallery>,
    /// The widths of each gallery at the points of its centre-line, m; empty for a gallery that is as
    /// wide everywhere as [`Gallery::width`] says.
    pub widths: Vec<Vec<f32>>,
    /// The rooms, which are united with the galleries.
    pub rooms: Vec<Room>,
}

impl Layout {
    /// Returns the layout of a single corridor.
    #[must_use]
    pub fn corridor(centre_line: &[[f32; 2]], width: f32) -> Self {
        let centre_line = centre_line.iter().map(|&[x, y]| Point2::new(x, y)).collect();
        let main = Gallery { name: "main".into(), centre_line, width };
        Self { galleries: vec![main], widths: Vec::new(), rooms: Vec::new() }
    }
}

impl Gallery {
    /// Whether it has walls that could be built where it has these widths at the points of its
    /// centre-line, or, without any, its own everywhere.
    ///
    /// # Errors
    /// [`GeometryError`] where it has not.
    pub fn check(&self, widths: &[f32]) -> Result<(), GeometryError> {
        corridor_pieces(self, widths).map(|_| ())
    }
}

impl Room {
    /// Whether it has walls that could be built.
    ///
    /// # Errors
    /// [`GeometryError`] where it has not.
    pub fn check(&self) -> Result<(), GeometryError> {
        room_piece(self).map(|_| ())
    }
}

/// A layout that cannot be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GeometryError {
    /// A centre-line with fewer than two points.
    TooShort,
    /// Two successive points of a centre-line in the same place; the number of the second.
    Repeated(usize),
    /// A bend is too sharp for its inner wall; the number is that of the piece of centre-line.
    TooSharp(usize),
    /// The gallery is so narrow that its walls would touch a drone in its middle.
    TooNarrow,
    /// A number that is not finite, or a room without extent.
    NotANumber,
    /// A coordinate or a size beyond [`FARTHEST`].
    TooLarge,
    /// The number of widths is not that of the points of the centre-line.
    WidthsAndPoints,
}

impl fmt::Display for GeometryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooShort => write!(f, "a centre-line has fewer than two points"),
            Self::Repeated(n) => write!(f, "points {} and {} are the same", n - 1, n),
            Self::TooSharp(n) => {
                write!(f, "the piece after point {n} is too short for the bends at its ends")
            }
            Self::TooNarrow => write!(f, "the corridor is narrower than {LEAST_WIDTH} m"),
            Self::TooLarge => write!(f, "a coordinate or a size is over {FARTHEST} m"),
            Self::NotANumber => write!(f, "a coordinate or a size is not a positive finite number"),
            Self::WidthsAndPoints => write!(f, "there are not as many widths as points"),
        }
    }
}

/// The narrowest corridor: a Crazyflie is 0.16 m wide over its guards and needs as much again on
/// each side for its sensors' and its flow's errors.
pub const LEAST_WIDTH: f32 = 0.5;

/// No coordinate is farther from the origin and nothing larger than this, in metres: beyond it an
/// `f32` no longer holds a tenth of a millimetre.
pub const FARTHEST: f32 = 500.0;

/// Numbers that a floor plan can be drawn from.
fn sound<'a>(numbers: impl IntoIterator<Item = &'a f32>) -> Result<(), GeometryError> {
    for number in numbers {
        if !number.is_finite() {
            return Err(GeometryError::NotANumber);
        }
        if number.abs() > FARTHEST {
            return Err(GeometryError::TooLarge);
        }
    }
    Ok(())
}

/// The outlines of the free space: closed loops, the last point not repeated.
///
/// # Errors
/// [`GeometryError`] where a corridor has no walls that could be built.
pub fn outlines(layout: &Layout) -> Result<Vec<Vec<Point2>>, GeometryError> {
    let mut pieces = Vec::new();
    for (n, gallery) in layout.galleries.iter().enumerate() {
        let widths = layout.widths.get(n).map_or(&[][..], Vec::as_slice);
        pieces.extend(corridor_pieces(gallery, widths)?);
    }
    for room in &layout.rooms {
        pieces.push(room_piece(room)?);
    }
    Ok(united(&pieces))
}

/// The outlines of the union of pieces.
fn united(pieces: &[Piece]) -> Vec<Vec<Point2>> {
    let union = FloatOverlay::with_subj_custom(pieces, OverlayOptions::ogc(), Default::default())
        .overlay(OverlayRule::Subject, FillRule::Positive);
    union.iter().flatten().map(|ring| rounded(ring)).filter(|ring| ring.len() >= 3).collect()
}

/// The ring in the precision of everything else, without points that fall together there.
fn rounded(ring: &[[f64; 2]]) -> Vec<Point2> {
    let mut points: Vec<_> = ring.iter().map(|&[x, y]| Point2::new(x as f32, y as f32)).collect();
    points.dedup();
    points
}

/// A surveyed passage: it is as wide at each station as was measured there.
#[derive(Clone, Debug, PartialEq)]
pub struct Passage {
    /// The middle of the passage at each station, and half of its width there, m.
    pub stations: Vec<(Point2, f32)>,
}

/// The outlines of the free space of surveyed passages: between two stations the walls are straight,
/// and at each station they go round it, so that any bend has walls.
///
/// # Errors
/// [`GeometryError`] where a number is none that walls can be drawn from.
pub fn passage_outlines(passages: &[Passage]) -> Result<Vec<Vec<Point2>>, GeometryError> {
    let mut pieces = Vec::new();
    for Passage { stations } in passages {
        sound(stations.iter().flat_map(|(at, half)| [&at.x, &at.y, half]))?;
        if stations.iter().any(|(_, half)| 2.0 * half < LEAST_WIDTH) {
            return Err(GeometryError::TooNarrow);
        }
        pieces.extend(stations.iter().map(|&(at, half)| round(at, half)));
        pieces.extend(stations.windows(2).filter_map(|pair| between(pair[0], pair[1])));
    }
    Ok(united(&pieces))
}

/// A dodecagon around a point.
fn round(at: Point2, half: f32) -> Piece {
    let (x, y, r) = (f64::from(at.x), f64::from(at.y), f64::from(half));
    let (long, short) = (r * 0.75f64.sqrt(), r * 0.5);
    let quarter = [[r, 0.0], [long, short], [short, long]];
    let turned = |turns: usize| {
        quarter.map(|[a, b]| match turns {
            0 => [x + a, y + b],
            1 => [x - b, y + a],
            2 => [x - a, y - b],
            _ => [x + b, y - a],
        })
    };
    (0..4).flat_map(turned).collect()
}

/// The quadrilateral between two stations.
fn between((a, half_a): (Point2, f32), (b, half_b): (Point2, f32)) -> Option<Piece> {
    let [ax, ay, bx, by] = [a.x, a.y, b.x, b.y].map(f64::from);
    let (dx, dy) = (bx - ax, by - ay);
    let length = (dx * dx + dy * dy).sqrt();
    if length < 1e-6 {
        return None;
    }
    let (nx, ny) = (-dy / length, dx / length);
    let [p, q] = [half_a, half_b].map(f64::from);
    Some(vec![
        [ax - nx * p, ay - ny * p],
        [bx - nx * q, by - ny * q],
        [bx + nx * q, by + ny * q],
        [ax + nx * p, ay + ny * p],
    ])
}

/// Corners of a piece of free space, counter-clockwise.
type Piece = Vec<[f64; 2]>;

/// Sides of rooms lie on whole steps of this, m. The side of a room that is given by its middle and its
/// extent is off by the rounding of both, and two rooms that meet there would leave a wall between them.
const SIDE_STEP: f64 = 1e-4;

fn room_piece(room: &Room) -> Result<Piece, GeometryError> {
    sound([&room.centre.x, &room.centre.y].into_iter().chain(&room.size))?;
    if room.size.iter().any(|&s| s <= 0.0) {
        return Err(GeometryError::NotANumber);
    }
    let (x, y) = (f64::from(room.centre.x), f64::from(room.centre.y));
    let [w, h] = room.size.map(|s| f64::from(s) / 2.0);
    let [west, south, east, north] =
        [x - w, y - h, x + w, y + h].map(|side| (side / SIDE_STEP).round() * SIDE_STEP);
    Ok(vec![[west, south], [east, south], [east, north], [west, north]])
}

/// Cosine of the sharpest bend, 150°: beyond it the mitre of the outer wall is longer than four
/// widths, and a gallery that turns straight back has no mitre at all.
const SHARPEST: f64 = -0.866;

/// One quadrilateral for each piece of the centre-line, meeting at the mitres of the bends. Between
/// two points of different widths the walls are straight.
fn corridor_pieces(corridor: &Gallery, widths: &[f32]) -> Result<Vec<Piece>, GeometryError> {
    let coordinates = corridor.centre_line.iter().flat_map(|point| [&point.x, &point.y]);
    sound(coordinates.chain([&corridor.width]).chain(widths))?;
    if !widths.is_empty() && widths.len() != corridor.centre_line.len() {
        return Err(GeometryError::WidthsAndPoints);
    }
    if widths.iter().chain([&corridor.width]).any(|width| *width < LEAST_WIDTH) {
        return Err(GeometryError::TooNarrow);
    }
    let points: Vec<[f64; 2]> =
        corridor.centre_line.iter().map(|p| [p.x, p.y].map(f64::from)).collect();
    let directions = directions(&points)?;
    for (n, pair) in directions.windows(2).enumerate() {
        let [before, after] = [pair[0], pair[1]];
        if before[0] * after[0] + before[1] * after[1] < SHARPEST {
            return Err(GeometryError::TooSharp(n));
        }
    }
    let half = |n: usize| f64::from(widths.get(n).copied().unwrap_or(corridor.width)) / 2.0;
    let edges = mitres(&points, &directions, half);

    let mut pieces = Vec::with_capacity(directions.len());
    for (n, (pair, direction)) in edges.windows(2).zip(&directions).enumerate() {
        let [(left_a, right_a), (left_b, right_b)] = [pair[0], pair[1]];
        let forward = |a: [f64; 2], b: [f64; 2]| {
            (b[0] - a[0]) * direction[0] + (b[1] - a[1]) * direction[1] > 1e-6
        };
        if !(forward(left_a, left_b) && forward(right_a, right_b)) {
            return Err(GeometryError::TooSharp(n));
        }
        pieces.push(vec![right_a, right_b, left_b, left_a]);
    }
    Ok(pieces)
}

fn directions(points: &[[f64; 2]]) -> Result<Vec<[f64; 2]>, GeometryError> {
    if points.len() < 2 {
        return Err(GeometryError::TooShort);
    }
    let direction = |(n, pair): (usize, &[[f64; 2]])| {
        let (dx, dy) = (pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
        let length = (dx * dx + dy * dy).sqrt();
        if length < 1e-6 {
            return Err(GeometryError::Repeated(n + 1));
        }
        Ok([dx / length, dy / length])
    };
    points.windows(2).enumerate().map(direction).collect()
}

/// The wall points left and right of each point of the centre-line: at the ends the corridor goes
/// on straight for half its width, so that base and head do not stand with their backs to a wall.
fn mitres(
    points: &[[f64; 2]],
    directions: &[[f64; 2]],
    half: impl Fn(usize) -> f64,
) -> Vec<([f64; 2], [f64; 2])> {
    let last = points.len() - 1;
    let edge = |n: usize, point: &[f64; 2]| {
        let half = half(n);
        let before = directions[n.saturating_sub(1)];
        let after = directions[n.min(last - 1)];
        // Half the width over the cosine of half the bend, along the mitre.
        let mitre = [before[0] + after[0], before[1] + after[1]];
        let scale = 2.0 * half / (mitre[0] * mitre[0] + mitre[1] * mitre[1]).max(1e-9);
        let side = [-mitre[1] * scale, mitre[0] * scale];
        let cap = if n == 0 {
            -half
        } else if n == last {
            half
        } else {
            0.0
        };
        let end = [point[0] + cap * after[0], point[1] + cap * after[1]];
        ([end[0] + side[0], end[1] + side[1]], [end[0] - side[0], end[1] - side[1]])
    };
    points.iter().enumerate().map(|(n, point)| edge(n, point)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The side of the one room is 6 m, that of the other 6.0000005 m in the numbers of a scenario.
    #[test]
    fn rooms_that_meet_have_no_wall_between_them() {
        let mut layout = Layout::corridor(&[[0.0, 0.0], [10.0, 0.0]], 0.5);
        let room = |x, width| Room { centre: Point2::new(x, 0.0), size: [width, 2.0] };
        layout.rooms = vec![room(4.625, 2.75), room(8.35, 4.7)];
        let outlines = outlines(&layout).unwrap();
        assert_eq!(outlines.len(), 1);
        let between = |point: &Point2| (point.x - 6.0).abs() < 0.1 && point.y.abs() < 0.9;
        assert!(!outlines[0].iter().any(between), "{outlines:?}");
    }
}
