//! Compares the legs of drawn galleries with each other: legs that cross, that part too narrowly at a corner, or
//! between which there is no rock.

use units::Point2;
use world::Polyline;

/// The thinnest rock between two galleries, m: a thinner wall is drawn by mistake.
const ROCK_M: f32 = 0.2;

/// The smallest angle between two legs at a corner: that of the sharpest bend which the simulator digs.
const LEAST_ANGLE_DEG: f32 = 30.0;

/// A straight piece of a gallery's centre-line between two corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// The number of the gallery, and that of the leg in it, counted from 0.
    pub number: [usize; 2],
    /// The corners at its ends.
    pub ends: [Point2; 2],
}

/// How two legs come too near to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clash {
    /// They cross.
    Cross,
    /// They part from a corner at this angle, °.
    Angle(f32),
    /// They are this far apart, m.
    Near(f32),
}

/// The legs of galleries.
#[must_use]
pub fn legs(galleries: &[Vec<[f32; 2]>]) -> Vec<Leg> {
    let of_gallery = |(gallery, corners): (usize, &Vec<[f32; 2]>)| {
        let ends =
            corners.windows(2).map(|pair| [pair[0], pair[1]].map(|[x, y]| Point2::new(x, y)));
        ends.enumerate()
            .map(move |(n, ends)| Leg { number: [gallery, n], ends })
            .collect::<Vec<_>>()
    };
    galleries.iter().enumerate().flat_map(of_gallery).collect()
}

/// The first two legs that come too near to each other in galleries of this width, m.
#[must_use]
pub fn first_clash(legs: &[Leg], width_m: f32) -> Option<([Leg; 2], Clash)> {
    legs.iter().enumerate().find_map(|(n, a)| {
        legs[..n].iter().find_map(|b| clash(a, b, legs, width_m).map(|clash| ([*b, *a], clash)))
    })
}

fn clash(a: &Leg, b: &Leg, legs: &[Leg], width_m: f32) -> Option<Clash> {
    if let Some([a, b]) = from_corner(a, b, |p, q| p == q) {
        let angle = a.angle_deg(&b);
        return (angle < LEAST_ANGLE_DEG).then_some(Clash::Angle(angle));
    }
    if a.crosses(b) {
        return Some(Clash::Cross);
    }
    let apart = a.distance(b);
    (apart < least_apart(a, b, legs, width_m)).then_some(Clash::Near(apart))
}

/// How far apart two legs without a common corner must be, m. Two that part from each other at the ends of a leg
/// between them are a bend, inside of which there is no rock.
fn least_apart(a: &Leg, b: &Leg, legs: &[Leg], width_m: f32) -> f32 {
    let is_leg = |p: Point2, q: Point2| legs.iter().any(|l| l.ends == [p, q] || l.ends == [q, p]);
    match from_corner(a, b, is_leg) {
        Some([a, b]) if a.angle_deg(&b) >= 90.0 => width_m / 2.0,
        _ => width_m + ROCK_M,
    }
}

/// Both legs, each turned so that it begins at the end where they are joined.
fn from_corner(a: &Leg, b: &Leg, are_joined: impl Fn(Point2, Point2) -> bool) -> Option<[Leg; 2]> {
    let turns = [(*a, *b), (*a, b.turned()), (a.turned(), *b), (a.turned(), b.turned())];
    let joined = turns.into_iter().find(|(a, b)| are_joined(a.ends[0], b.ends[0]));
    joined.map(|(a, b)| [a, b])
}

impl Leg {
    /// The length, m.
    #[must_use]
    pub fn length(&self) -> f32 {
        self.ends[0].distance(self.ends[1]).0
    }

    fn turned(&self) -> Self {
        Self { ends: [self.ends[1], self.ends[0]], ..*self }
    }

    fn direction(&self) -> [f32; 2] {
        let [a, b] = self.ends;
        [(b.x - a.x) / self.length(), (b.y - a.y) / self.length()]
    }

    /// The angle between the directions of two legs, 0° to 180°.
    fn angle_deg(&self, other: &Self) -> f32 {
        let ([ax, ay], [bx, by]) = (self.direction(), other.direction());
        (ax * by - ay * bx).abs().atan2(ax * bx + ay * by).to_degrees()
    }

    fn crosses(&self, other: &Self) -> bool {
        let are_apart = |leg: &Self, [p, q]: [Point2; 2]| leg.side(p) * leg.side(q) < 0.0;
        are_apart(self, other.ends) && are_apart(other, self.ends)
    }

    /// Positive for a point to the left of the leg, negative to the right.
    fn side(&self, at: Point2) -> f32 {
        let ([x, y], from) = (self.direction(), self.ends[0]);
        x * (at.y - from.y) - y * (at.x - from.x)
    }

    /// The distance of two legs that do not cross, m.
    fn distance(&self, other: &Self) -> f32 {
        let nearest =
            |leg: &Self, at: Point2| Polyline::new(leg.ends.to_vec()).nearest(at).off_squared;
        let ends = other.ends.map(|at| nearest(self, at)).into_iter();
        ends.chain(self.ends.map(|at| nearest(other, at))).fold(f32::INFINITY, f32::min).sqrt()
    }
}
