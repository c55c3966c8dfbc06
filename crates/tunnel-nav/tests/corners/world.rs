//! Tunnels for a point-level drone: the free space is a union of convex pieces.

use std::f32::consts::{FRAC_PI_2, PI};

/// A point, or a vector, in metres.
pub(crate) type Vec2 = [f32; 2];

/// The unit vector at this angle, in degrees.
pub(crate) fn unit(angle: f32) -> Vec2 {
    [libm::cosf(angle), libm::sinf(angle)]
}

pub(crate) fn add(a: Vec2, b: Vec2, scale: f32) -> Vec2 {
    [a[0] + scale * b[0], a[1] + scale * b[1]]
}

fn cross(a: Vec2, b: Vec2) -> f32 {
    a[0] * b[1] - a[1] * b[0]
}

/// A tunnel and the centre-line from its mouth to its end.
#[derive(Clone, Debug)]
pub(crate) struct Tunnel {
    pub(crate) name: String,
    /// Convex polygons, counter-clockwise.
    pieces: Vec<Vec<Vec2>>,
    centre: Vec<Vec2>,
    width: f32,
}

/// The place on the centre-line next to a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// The way from the mouth.
    pub(crate) way: f32,
    /// The direction of the centre-line towards the end, smoothed over the width of the tunnel.
    pub(crate) direction: f32,
}

impl Tunnel {
    /// A tunnel that turns by these angles (counter-clockwise), with straights of this length
    /// between.
    pub(crate) fn turning(name: &str, width: f32, straight: f32, turns: &[f32]) -> Self {
        Self::with_legs(name, width, &vec![straight; turns.len() + 1], turns)
    }

    /// A tunnel with legs of these lengths, between which it turns by these angles (counter-clockwise).
    pub(crate) fn with_legs(name: &str, width: f32, legs: &[f32], turns: &[f32]) -> Self {
        let (mut at, mut angle) = ([0.0, 0.0], 0.0);
        let mut centre = vec![at];
        for (leg, turn) in legs.iter().zip(turns.iter().chain([&0.0])) {
            at = add(at, unit(angle), *leg);
            centre.push(at);
            angle += turn;
        }
        Self::along(format!("{name}, {width} m"), centre, width)
    }

    /// A corridor of legs that join: from where, to where, and how wide. The joints are round.
    #[allow(dead_code, reason = "not every test has legs of several widths")]
    pub(crate) fn of_legs(legs: &[(Vec2, Vec2, f32)]) -> Self {
        let mut pieces = Vec::new();
        let mut centre = vec![legs[0].0];
        for &(from, to, width) in legs {
            let d = [to[0] - from[0], to[1] - from[1]];
            let length = libm::hypotf(d[0], d[1]);
            let (ahead, left) = ([d[0] / length, d[1] / length], [-d[1] / length, d[0] / length]);
            let (half, cap) = (0.5 * width, if centre.len() == 1 { 0.5 * width } else { 0.0 });
            let is_last = centre.len() == legs.len();
            let (from, to) =
                (add(from, ahead, -cap), add(to, ahead, if is_last { half } else { 0.0 }));
            pieces.push(vec![
                add(from, left, -half),
                add(to, left, -half),
                add(to, left, half),
                add(from, left, half),
            ]);
            centre.push(add(centre[centre.len() - 1], d, 1.0));
        }
        for (n, pair) in legs.windows(2).enumerate() {
            let radius = 0.5 * pair[0].2.max(pair[1].2);
            let joint = (0..16).map(|k| add(centre[n + 1], unit(PI * k as f32 / 8.0), radius));
            pieces.push(joint.collect());
        }
        let width = legs.iter().map(|leg| leg.2).fold(f32::INFINITY, f32::min);
        Self { name: String::new(), pieces, centre, width }
    }

    /// The same tunnel with a rectangular room between two corners.
    #[allow(dead_code, reason = "not every test has a room")]
    pub(crate) fn with_room(mut self, [a, b]: [Vec2; 2]) -> Self {
        let (low, high) = ([a[0].min(b[0]), a[1].min(b[1])], [a[0].max(b[0]), a[1].max(b[1])]);
        self.pieces.push(vec![low, [high[0], low[1]], high, [low[0], high[1]]]);
        self
    }

    /// The same free space with the centre-line of another tunnel.
    #[allow(dead_code, reason = "not every test has two ways")]
    pub(crate) fn with_centre_of(&self, other: &Self) -> Self {
        Self { centre: other.centre.clone(), ..self.clone() }
    }

    /// A right angle of which the corner is rounded with this radius.
    pub(crate) fn rounded(width: f32, straight: f32, radius: f32) -> Self {
        let pieces = 8;
        let turn = FRAC_PI_2 / pieces as f32;
        let step = 2.0 * radius * libm::tanf(0.5 * turn);
        let (mut at, mut angle) = ([0.0, 0.0], 0.0);
        let mut centre = vec![at];
        at = add(at, unit(0.0), straight - 0.5 * step);
        for _ in 0..pieces {
            centre.push(at);
            angle += turn;
            at = add(at, unit(angle), step);
        }
        centre.push(add(at, unit(angle), straight));
        Self::along(format!("rounded {radius} m, {width} m"), centre, width)
    }

    /// A tunnel with a gallery that leaves at the middle of its first straight, at this angle, in degrees.
    pub(crate) fn with_branch(mut self, name: &str, angle: f32, length: f32) -> Self {
        let [a, b] = [self.centre[0], self.centre[1]];
        let mouth = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        let end = add(mouth, unit(angle.to_radians()), length);
        let branch = Self::along(String::new(), vec![mouth, end], self.width);
        self.pieces.extend(branch.pieces);
        self.name = format!("{name}, {} m", self.width);
        self
    }

    /// A tunnel with a gallery that leaves at this way along its first straight, at this angle to it, in
    /// degrees.
    #[allow(dead_code, reason = "not every test has such a gallery")]
    pub(crate) fn with_gallery(mut self, way: f32, angle: f32, length: f32) -> Self {
        let mouth = self.at(way.min(self.length()) - 1e-3).0;
        let end = add(mouth, unit(angle.to_radians()), length);
        let gallery = Self::along(String::new(), vec![mouth, end], self.width);
        self.pieces.extend(gallery.pieces);
        self
    }

    /// A tunnel with a chamber on its first straight between these ways, of this width and so far off the
    /// centre-line.
    #[allow(dead_code, reason = "not every test has a chamber")]
    pub(crate) fn with_chamber(mut self, [from, to]: [f32; 2], width: f32, off: f32) -> Self {
        let [left, right] = [off + 0.5 * width, off - 0.5 * width];
        self.pieces.push(vec![[from, right], [to, right], [to, left], [from, left]]);
        self
    }

    /// The width from wall to wall.
    #[allow(dead_code, reason = "not every test asks for it")]
    pub(crate) fn width(&self) -> f32 {
        self.width
    }

    fn along(name: String, centre: Vec<Vec2>, width: f32) -> Self {
        let directions: Vec<Vec2> = centre
            .windows(2)
            .map(|pair| {
                let d = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
                let length = libm::sqrtf(d[0] * d[0] + d[1] * d[1]);
                [d[0] / length, d[1] / length]
            })
            .collect();
        let last = centre.len() - 1;
        let walls: Vec<[Vec2; 2]> = (0..=last)
            .map(|n| {
                let (before, after) =
                    (directions[n.saturating_sub(1)], directions[n.min(last - 1)]);
                let mitre = [before[0] + after[0], before[1] + after[1]];
                let scale = width / (mitre[0] * mitre[0] + mitre[1] * mitre[1]);
                let cap = match n {
                    0 => -0.5 * width,
                    _ if n == last => 0.5 * width,
                    _ => 0.0,
                };
                let at = add(centre[n], after, cap);
                let left = [-mitre[1], mitre[0]];
                [add(at, left, scale), add(at, left, -scale)]
            })
            .collect();
        let pieces = walls.windows(2).map(|w| vec![w[0][1], w[1][1], w[1][0], w[0][0]]).collect();
        Self { name, pieces, centre, width }
    }

    /// The length of the centre-line.
    pub(crate) fn length(&self) -> f32 {
        self.legs().map(|(_, _, length)| length).sum()
    }

    /// The ways at which the centre-line turns.
    pub(crate) fn bends(&self) -> Vec<f32> {
        let mut way = 0.0;
        let mut bends: Vec<f32> = self
            .legs()
            .map(|(_, _, length)| {
                way += length;
                way
            })
            .collect();
        bends.pop();
        bends
    }

    fn legs(&self) -> impl Iterator<Item = (Vec2, Vec2, f32)> + '_ {
        self.centre.windows(2).map(|pair| {
            let d = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
            (pair[0], d, libm::sqrtf(d[0] * d[0] + d[1] * d[1]))
        })
    }

    /// The point of the centre-line at this way, and the angle of its direction there.
    pub(crate) fn at(&self, way: f32) -> (Vec2, f32) {
        let mut left = way.max(0.0);
        let mut found = (self.centre[0], 0.0);
        for (from, d, length) in self.legs() {
            found = (add(from, d, left.min(length) / length), libm::atan2f(d[1], d[0]));
            if left <= length {
                break;
            }
            left -= length;
        }
        found
    }

    /// The place on the centre-line next to this point.
    pub(crate) fn place(&self, at: Vec2) -> Place {
        let (mut best, mut way, mut start) = (f32::INFINITY, 0.0, 0.0);
        for (from, d, length) in self.legs() {
            let along = ((at[0] - from[0]) * d[0] + (at[1] - from[1]) * d[1]) / (length * length);
            let along = along.clamp(0.0, 1.0);
            let foot = add(from, d, along);
            let off = (at[0] - foot[0]) * (at[0] - foot[0]) + (at[1] - foot[1]) * (at[1] - foot[1]);
            if off < best {
                (best, way) = (off, start + along * length);
            }
            start += length;
        }
        let reach = self.width;
        let (a, b) = (self.at(way - reach).0, self.at((way + reach).min(self.length())).0);
        Place { way, direction: libm::atan2f(b[1] - a[1], b[0] - a[0]) }
    }

    /// The way from this point in this direction to the first wall.
    pub(crate) fn cast(&self, from: Vec2, direction: Vec2) -> f32 {
        let mut free = 0.0;
        loop {
            let spans = self.pieces.iter().filter_map(|piece| span(piece, from, direction));
            let joined = spans.filter(|&(enter, _)| enter <= free + 1e-4).map(|(_, leave)| leave);
            let farther = joined.fold(free, f32::max);
            if farther == free {
                return free;
            }
            free = farther;
        }
    }

    /// The distance to the nearest wall.
    pub(crate) fn clearance(&self, at: Vec2) -> f32 {
        (0..48).map(|n| self.cast(at, unit(PI * n as f32 / 24.0))).fold(f32::INFINITY, f32::min)
    }
}

/// Where the line through this point enters and leaves a convex polygon.
fn span(piece: &[Vec2], from: Vec2, direction: Vec2) -> Option<(f32, f32)> {
    let (mut enter, mut leave) = (f32::NEG_INFINITY, f32::INFINITY);
    for (n, &a) in piece.iter().enumerate() {
        let b = piece[(n + 1) % piece.len()];
        let edge = [b[0] - a[0], b[1] - a[1]];
        let inside = cross(edge, [from[0] - a[0], from[1] - a[1]]);
        let closing = cross(edge, direction);
        if closing.abs() < 1e-9 {
            if inside < 0.0 {
                return None;
            }
        } else if closing > 0.0 {
            enter = enter.max(-inside / closing);
        } else {
            leave = leave.min(-inside / closing);
        }
    }
    (leave > 0.0 && enter < leave).then_some((enter, leave))
}

/// The same angle within half a turn.
pub(crate) fn wrapped(angle: f32) -> f32 {
    libm::remainderf(angle, 2.0 * PI)
}
