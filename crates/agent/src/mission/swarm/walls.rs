//! The walls around a drone, by what its side beams have hit.
//!
//! Four beams see four points. What each of them has hit in the last seconds is kept, in the axes of
//! the world, and hits that are near to each other are taken for one wall between them.

use core::f32::consts::FRAC_PI_4;

use tunnel_nav::{Diagonals, Range};
use units::{Duration, Instant, Metres, Point2, Pose2, Radians};
use virtual_forces::Obstacles;

/// The hits of a beam that are kept.
const KEPT: usize = 4;
/// A hit is kept where it is farther than this from the last one, m.
const APART: f32 = 0.08;
/// Two hits nearer than this are on one wall: a drone at 0.3 m/s whose beam misses some rounds, m.
const JOINED: f32 = 0.3;
/// Walls farther away are of no use to the virtual forces, which heed them within half a metre.
const FAR: Metres = Metres(1.0);
/// A hit is kept for so long.
const OLD: Duration = Duration::from_secs(3);

/// What a beam has hit.
#[derive(Clone, Copy, Debug)]
struct Hit {
    at: Point2,
    seen: Instant,
}

/// What the four beams have hit, the latest first.
#[derive(Clone, Debug)]
pub(super) struct Walls {
    beams: [[Option<Hit>; KEPT]; 4],
}

impl Walls {
    /// No walls.
    pub(super) const fn new() -> Self {
        Self { beams: [[None; KEPT]; 4] }
    }

    /// Takes in the ranges of a drone at `pose`, but for hits of other drones.
    pub(super) fn look(
        &mut self,
        now: Instant,
        pose: Pose2,
        ranges: &Diagonals,
        is_drone: impl Fn(Point2) -> bool,
    ) {
        let Diagonals { nw, ne, sw, se } = *ranges;
        let turned = [(nw, 1.0), (ne, -1.0), (sw, 3.0), (se, -3.0)];
        for (hits, (range, eighths)) in self.beams.iter_mut().zip(turned) {
            let Range::At(distance) = range else { continue };
            let (sin, cos) = Radians(pose.yaw.0 + eighths * FRAC_PI_4).sin_cos();
            let at = Point2::new(pose.at.x + distance.0 * cos, pose.at.y + distance.0 * sin);
            if distance > FAR || is_drone(at) {
                continue;
            }
            // The latest hit is replaced until it is far enough from the one before it.
            let hit = Some(Hit { at, seen: now });
            let [first, second, third, fourth] = *hits;
            let near = second.is_some_and(|hit| hit.at.distance(at).0 < APART);
            *hits = match first {
                Some(_) if !near => [hit, first, second, third],
                _ => [hit, second, third, fourth],
            };
        }
    }

    /// The obstacles within `range` of a drone that is `here`.
    pub(super) fn seen(&self, now: Instant, here: Point2, range: Metres) -> Obstacles {
        let fresh = |hit: &Option<Hit>| hit.filter(|hit| now.since(hit.seen) <= OLD);
        let pieces = self.beams.iter().flat_map(|hits| {
            let before = hits.iter().skip(1).map(fresh).chain([None]);
            hits.iter().map(fresh).zip(before).filter_map(|(hit, before)| {
                let at = hit?.at;
                let joined =
                    before.map(|hit| hit.at).filter(|other| at.distance(*other).0 < JOINED);
                Some((at, joined.unwrap_or(at)))
            })
        });
        Obstacles::seen(here, range, pieces)
    }
}
