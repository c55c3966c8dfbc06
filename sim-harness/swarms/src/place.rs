//! Lays out the places that a swarm flies in: an area, and a passage to a second one.

use units::{Metres, Point2};
use virtual_forces::Passage;

/// The width of the areas (section 6.2 of the paper).
pub const AREA_WIDTH: Metres = Metres(7.5);
/// The length of every passage between its two ends. The paper does not state it.
const LENGTH: f32 = 6.0;
/// The way between the first area and the wall in which the passage begins: D_int, so that no row of
/// the survey runs along that wall.
const FORECOURT: f32 = 0.75;
/// How far the middle of d is beside the straight line between its ends.
const BEND: f32 = 1.5;
/// The length of each wedge in e along its wall, and the width that two wedges leave between them,
/// which is that of a. They are wedges because before blunt blocks three drones and more stay for
/// ever by the paper's rule, and the paper's drones did not.
const WEDGE: (f32, f32) = (1.0, 0.95);

/// The five passages of the paper. The entrances have the widths of its section 6.2; the lengths, the
/// shape of d and the wedges of e are not stated there, and are this simulator's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Straight, for a queue.
    A,
    /// Straight, for two rows.
    B,
    /// Straight, for three rows.
    C,
    /// As wide as b, with one corner in the middle.
    D,
    /// Straight and as wide as b, with wedges at both walls that leave a width as in a.
    E,
}

impl Place {
    /// All places, in the order of their letters.
    pub const ALL: [Self; 5] = [Self::A, Self::B, Self::C, Self::D, Self::E];

    /// Returns the paper's letter.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::A => "a",
            Self::B => "b",
            Self::C => "c",
            Self::D => "d",
            Self::E => "e",
        }
    }

    const fn width(self) -> f32 {
        match self {
            Self::A => 0.95,
            Self::B | Self::D | Self::E => 1.51,
            Self::C => 2.26,
        }
    }

    /// Returns what the drones know of the passage: it begins at the origin, and leads along x.
    #[must_use]
    pub const fn passage(self) -> Passage {
        Passage {
            entrance: Point2::new(0.0, 0.0),
            width: Metres(self.width()),
            way: Point2::new(1.0, 0.0),
            length: Metres(LENGTH),
        }
    }

    /// Returns the length of the passage along its middle.
    #[must_use]
    pub fn path(self) -> Metres {
        match self {
            Self::D => Metres(2.0 * libm::hypotf(0.5 * LENGTH, BEND)),
            Self::A | Self::B | Self::C | Self::E => Metres(LENGTH),
        }
    }

    /// Returns the walls of the passage, and those of the areas at its ends.
    #[must_use]
    pub fn walls(self) -> Vec<(Point2, Point2)> {
        let (half, outer) = (0.5 * self.width(), 0.5 * AREA_WIDTH.0);
        let bend = if self == Self::D { BEND } else { 0.0 };
        let mut walls = Vec::new();
        for side in [1.0, -1.0] {
            let line = [
                (0.0, side * outer),
                (0.0, side * half),
                (0.5 * LENGTH, bend + side * half),
                (LENGTH, side * half),
                (LENGTH, side * outer),
            ];
            walls.extend(pieces(&line));
            if self == Self::E {
                let (start, end) = (0.5 * (LENGTH - WEDGE.0), 0.5 * (LENGTH + WEDGE.0));
                let (wall, edge) = (side * half, side * 0.5 * WEDGE.1);
                walls.extend(pieces(&[(start, wall), (0.5 * LENGTH, edge), (end, wall)]));
            }
        }
        walls
    }

    /// Returns the first area for a swarm of so many drones: its corner, its length and its width. It
    /// is the paper's, 9 m long, for up to six drones; for more it is as much longer, so that each
    /// drone still has two rows.
    #[must_use]
    pub fn area(drones: u16) -> (Point2, (Metres, Metres)) {
        let length = 1.5 * f32::from(drones.max(6));
        let corner = Point2::new(-FORECOURT - length, -0.5 * AREA_WIDTH.0);
        (corner, (Metres(length), AREA_WIDTH))
    }
}

fn pieces(line: &[(f32, f32)]) -> impl Iterator<Item = (Point2, Point2)> + '_ {
    let point = |(x, y): (f32, f32)| Point2::new(x, y);
    line.iter().zip(line.iter().skip(1)).map(move |(a, b)| (point(*a), point(*b)))
}
