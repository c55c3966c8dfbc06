//! The VL53L1x: the distance along a beam, if enough light comes back.
//!
//! A beam is a cone of nine rays; the nearest of those with a strong reflection counts. The
//! reflected light falls with the square of the distance and with the slant of the surface, and
//! below a limit there is no reading. Beams are fixed to the body: a tilted one can see the floor.

use std::iter;

use random::Stream;
use sensors::vl53l1x::{CountRate, RangeStatus, Reading};
use units::{Metres, Point2};
use world::Tunnel;

use super::Surroundings;
use super::body::{Rotation, Vector, turned};

/// The rays beside the middle one: cosine and sine of their angle to it, and their sensitivity in
/// parts of its own. The whole array sees 27° (UM2555), where half of the sensitivity is assumed to be
/// left; the vendor's estimator reckons with half a cone of 7.5° (`mm_tof.c`), where four fifths
/// are left if it falls as a bell curve does.
const RINGS: [([f32; 2], f32); 2] = [([0.991_44, 0.130_53], 0.8), ([0.972_37, 0.233_45], 0.5)];
/// A ray counts when it returns at least this part of the strongest ray's light.
const STRONG: f32 = 0.5;
/// The reflectance of walls and floor: grey. The data sheet tests with 17, 54 and 88 %.
const REFLECTANCE: f32 = 0.5;
/// The least light for a reading, in parts of that from a white wall square to the beam at 1 m: the
/// data sheet's 3.6 m on 88 % and 1.7 m on 17 % in the dark at 100 ms are 0.07 and 0.06; a budget
/// of 33 ms takes √3 times that.
const LEAST_SIGNAL: f32 = 0.11;
/// The light that comes back from a drone at 1 m, which covers a small part of the beam, in the same parts
/// ([`others`](crate::others)).
const DRONE: f32 = 0.0074;
/// Standard deviation of the reflected light, as a part of it. No source.
const FADING: f32 = 0.1;
/// Photons counted of a signal of 1, Mcps. No source; the tests of the drivers have the same size.
const RATE: f32 = 10.0;
/// Standard deviation of the error that stays, m: the data sheet's ranging error of ±20 mm, read
/// as three of them.
const OFFSET: f32 = 0.007;
/// The least distance at which the sensor is accurate, m (data sheet).
const NEAREST: f32 = 0.04;

/// Standard deviation of one reading at this distance, m: the vendor's (`zranger2.c`).
#[must_use]
pub fn deviation(distance: f32) -> f32 {
    // ln(0.2 / 0.0025) / 1.5
    let steepness = 2.921_35;
    0.0025 * (1.0 + libm::expf(steepness * (distance - 2.5)))
}

/// One sensor.
#[derive(Clone, Debug)]
pub struct Ranger {
    offset: f32,
    stream: u8,
}

impl Ranger {
    /// A sensor with a constant error of its own.
    #[must_use]
    pub fn new(random: &mut Stream) -> Self {
        Self { offset: OFFSET * random.gauss(), stream: 0 }
    }

    /// A measurement of the floor from `height` above it by a sensor that looks along the body's
    /// −z.
    pub fn look_down(&mut self, height: f32, upright: f32, random: &mut Stream) -> Reading {
        let seen = (upright > 0.2).then(|| Seen {
            distance: height.max(0.0) / upright,
            signal: REFLECTANCE * upright.powi(3) / (height * height).max(NEAREST * NEAREST),
        });
        self.reading(seen, random)
    }

    /// A measurement from here along the unit vector `beam`, given in body axes and level there.
    pub fn look_along(
        &mut self,
        around: Surroundings<'_>,
        position: Vector,
        rotation: &Rotation,
        beam: [f32; 2],
        random: &mut Stream,
    ) -> Reading {
        let middle = [([beam[0], beam[1], 0.0], 1.0)];
        let ring = |([cosine, sine], sensitivity): ([f32; 2], f32)| {
            let [x, y] = [beam[0] * cosine, beam[1] * cosine];
            let [left_x, left_y] = [-beam[1] * sine, beam[0] * sine];
            [
                [x + left_x, y + left_y, 0.0],
                [x - left_x, y - left_y, 0.0],
                [x, y, sine],
                [x, y, -sine],
            ]
            .map(|ray| (ray, sensitivity))
        };
        let rays = middle.into_iter().chain(RINGS.into_iter().flat_map(ring));
        let mut seen: [Option<Seen>; 9] = [None; 9];
        let mut strongest = 0.0_f32;
        for ((ray, sensitivity), seen) in rays.zip(&mut seen) {
            *seen = strike(around.tunnel, position, turned(rotation, ray))
                .map(|seen| Seen { signal: sensitivity * seen.signal, ..seen });
            strongest = strongest.max(seen.map_or(0.0, |seen| seen.signal));
        }
        let nearest = nearest(seen, strongest);
        // A drone stands apart from the wall behind it, so that the sensor reports it as the nearer of two.
        let [x, y, _] = turned(rotation, [beam[0], beam[1], 0.0]);
        let drone = around.others.seen(Point2::new(position[0], position[1]), position[2], [x, y]);
        let drone = drone.map(|distance| {
            let square = distance.max(NEAREST) * distance.max(NEAREST);
            Seen { distance, signal: DRONE / (square * square) }
        });
        let nearer =
            drone.filter(|drone| nearest.is_none_or(|wall| drone.distance < wall.distance));
        self.reading(nearer.or(nearest), random)
    }

    /// The reading by the light that comes back.
    fn reading(&mut self, seen: Option<Seen>, random: &mut Stream) -> Reading {
        self.stream = if self.stream == u8::MAX { 128 } else { self.stream + 1 };
        let signal = seen.map_or(0.0, |seen| seen.signal * (1.0 + FADING * random.gauss()));
        let reading = |distance, sigma, status| Reading {
            distance: Metres(distance),
            sigma: Metres(sigma),
            status,
            signal: CountRate(RATE * signal.max(0.0)),
            ambient: CountRate(0.1),
            stream: self.stream,
        };
        let Some(seen) = seen.filter(|_| signal >= LEAST_SIGNAL) else {
            return reading(0.0, 0.1, RangeStatus::SignalFail);
        };
        let mut sigma = deviation(seen.distance);
        if seen.distance < NEAREST {
            sigma += 0.005;
        }
        let distance = seen.distance + self.offset + sigma * random.gauss();
        // The reading is in whole millimetres.
        let millimetres = libm::roundf(distance.max(0.0) * 1e3);
        reading(millimetres * 1e-3, sigma, RangeStatus::Valid)
    }
}

/// The surface that one ray meets.
#[derive(Clone, Copy)]
struct Seen {
    distance: f32,
    signal: f32,
}

/// The nearest of the surfaces that return a strong part of the strongest one's light.
fn nearest<const RAYS: usize>(seen: [Option<Seen>; RAYS], strongest: f32) -> Option<Seen> {
    let strong = seen.into_iter().flatten().filter(|s| s.signal >= STRONG * strongest);
    strong.min_by(|a, b| a.distance.total_cmp(&b.distance))
}

/// The distance that a level beam along the unit vector `beam` tells on a floor plan, by the level rays of its cone, m;
/// infinite where it meets nothing within `reach`.
pub(crate) fn level_range(tunnel: &Tunnel, at: Point2, beam: [f32; 2], reach: f32) -> f32 {
    let [x, y] = beam;
    let beside = RINGS.into_iter().flat_map(|([cosine, sine], sensitivity)| {
        [sine, -sine].map(|sine| ([x * cosine - y * sine, y * cosine + x * sine], sensitivity))
    });
    let mut seen = [None; 5];
    let mut strongest = 0.0_f32;
    for ((way, sensitivity), seen) in iter::once((beam, 1.0)).chain(beside).zip(&mut seen) {
        *seen = tunnel.strike(at, way, reach).map(|(distance, slant)| {
            let signal = sensitivity * slant / (distance * distance).max(NEAREST * NEAREST);
            Seen { distance, signal }
        });
        strongest = strongest.max(seen.map_or(0.0, |seen| seen.signal));
    }
    nearest(seen, strongest).map_or(f32::INFINITY, |seen| seen.distance)
}

/// The length of a ray, m.
const FARTHEST: f32 = 4.0;

/// The first surface that a ray along `way` (world axes, about a unit vector) meets: a wall or the
/// floor.
fn strike(tunnel: &Tunnel, from: Vector, way: Vector) -> Option<Seen> {
    let level = libm::sqrtf(way[0] * way[0] + way[1] * way[1]);
    let seen = |distance: f32, slant: f32| Seen {
        distance,
        signal: REFLECTANCE * slant / (distance * distance).max(NEAREST * NEAREST),
    };
    let floor = (way[2] < -1e-3).then(|| seen(from[2] / -way[2], -way[2]));
    let wall = (level > 0.1).then(|| [way[0] / level, way[1] / level]).and_then(|heading| {
        let reach = floor.map_or(FARTHEST, |f| f.distance.min(FARTHEST)) * level;
        let (distance, slant) = tunnel.strike(Point2::new(from[0], from[1]), heading, reach)?;
        Some(seen(distance / level, slant * level))
    });
    wall.or(floor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deviation_is_the_vendors_at_its_two_points() {
        assert!((deviation(2.5) - 0.005).abs() < 1e-6);
        assert!((deviation(4.0) - 0.2025).abs() < 1e-3);
    }
}
