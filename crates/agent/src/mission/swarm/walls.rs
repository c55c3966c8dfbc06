//! The walls around a drone, by what its side beams have hit.
//!
//! Four beams see four points. What each of them has hit in the last seconds is kept, in the axes of
//! the world, and hits that are near to each other are taken for one wall between them. A beam that later
//! goes on past a hit takes it back.

use core::f32::consts::FRAC_PI_4;

use tunnel_nav::{Diagonals, Range};
use units::{Duration, Instant, Metres, Point2, Pose2, Radians};
use virtual_forces::Obstacles;

/// The hits of a beam that are kept. With half as many a drone that had turned once had forgotten the edge of the
/// door beside it, and flew into it.
const KEPT: usize = 8;
/// A hit is kept where it is farther than this from the last one, m.
const APART: f32 = 0.08;
/// Two hits nearer than this are on one wall: a drone at 0.3 m/s whose beam misses some rounds, m.
const JOINED: f32 = 0.3;
/// Walls farther away are of no use to the virtual forces, which heed them within half a metre.
const FAR: Metres = Metres(1.0);
/// A hit is kept for so long.
const OLD: Duration = Duration::from_secs(3);

/// A beam that goes on past a hit, this near to it, m, and so much farther, m, has shown that there is no wall: what a
/// ranger sees at the side of its cone lies beside the beam, and an oblique wall is nearer there than in the middle.
const PAST: (f32, f32) = (0.05, 0.05);

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
        for (index, (range, eighths)) in turned.into_iter().enumerate() {
            let (sin, cos) = Radians(pose.yaw.0 + eighths * FRAC_PI_4).sin_cos();
            let way = Point2::new(cos, sin);
            let clear = match range {
                Range::At(distance) => distance.0,
                Range::Clear => FAR.0,
                Range::Invalid => continue,
            };
            self.forget(pose.at, way, clear - PAST.1);
            let (Range::At(distance), Some(hits)) = (range, self.beams.get_mut(index)) else {
                continue;
            };
            let at = Point2::new(pose.at.x + distance.0 * cos, pose.at.y + distance.0 * sin);
            if distance > FAR || is_drone(at) {
                continue;
            }
            // The latest hit is replaced until it is far enough from the one before it.
            let hit = Some(Hit { at, seen: now });
            let [_, before, ..] = *hits;
            if before.is_none_or(|hit| hit.at.distance(at).0 >= APART) {
                hits.rotate_right(1);
            }
            hits[0] = hit;
        }
    }

    /// Forgets the hits that a beam from `here` along the unit vector `way` has passed, up to `clear` metres.
    fn forget(&mut self, here: Point2, way: Point2, clear: f32) {
        for hit in self.beams.iter_mut().flatten() {
            let Some(Hit { at, .. }) = hit else { continue };
            let (x, y) = (at.x - here.x, at.y - here.y);
            let (ahead, aside) = (x * way.x + y * way.y, x * way.y - y * way.x);
            if ahead > 0.0 && ahead < clear && aside.abs() < PAST.0 {
                *hit = None;
            }
        }
    }

    /// The obstacles within `range` of a drone that is `here`.
    pub(super) fn seen(&self, now: Instant, here: Point2, range: Metres) -> Obstacles {
        let fresh = |beam: usize, slot: usize| {
            let hit = (*self.beams.get(beam)?.get(slot)?)?;
            (now.since(hit.seen) <= OLD).then_some(hit.at)
        };
        // The latest hits of all beams come first: of more pieces than obstacles can have, the last are left
        // out.
        let pieces = (0..KEPT).flat_map(|slot| (0..4).map(move |beam| (beam, slot)));
        let pieces = pieces.filter_map(|(beam, slot)| {
            let at = fresh(beam, slot)?;
            let before = fresh(beam, slot + 1).filter(|other| at.distance(*other).0 < JOINED);
            Some((at, before.unwrap_or(at)))
        });
        Obstacles::seen(here, range, pieces)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: Point2 = Point2::new(0.0, 0.0);
    const RANGE: Metres = Metres(0.5);
    /// A turn of 0.8 rad/s, a quarter of a circle between two beams: in 2 s the beams have seen all.
    const TURN: f32 = 0.16;

    /// What four rays see of the line x = 0.4 m, which is a wall from `from` to `to` metres of y.
    fn seen(yaw: f32, (from, to): (f32, f32)) -> Diagonals {
        let ray = |eighths: f32| {
            let (sin, cos) = Radians(yaw + eighths * FRAC_PI_4).sin_cos();
            let y = 0.4 * sin / cos;
            if cos > 0.0 && (from..=to).contains(&y) {
                Range::measured(Metres(0.4 / cos), Metres(2.0))
            } else {
                Range::Clear
            }
        };
        Diagonals { nw: ray(1.0), ne: ray(-1.0), sw: ray(3.0), se: ray(-3.0) }
    }

    /// Turns for `rounds` before such a wall, and returns the walls, and when that was.
    fn turned(walls: &mut Walls, first: u32, rounds: u32, wall: (f32, f32)) -> Instant {
        let mut now = Instant::default();
        for round in first..first + rounds {
            now = Instant::default() + Duration::from_millis(200 * u64::from(round));
            let yaw = TURN * round as f32;
            let pose = Pose2 { at: HERE, yaw: Radians(yaw) };
            walls.look(now, pose, &seen(yaw, wall), |_| false);
        }
        now
    }

    /// In 10 of 60 missions of twelve drones one flew into the edge of a door.
    #[test]
    fn the_whole_wall_before_a_drone_is_known_after_a_turn() {
        let mut walls = Walls::new();
        let now = turned(&mut walls, 0, 12, (-0.9, 0.9));
        let seen = walls.seen(now, HERE, RANGE);
        for y in [-0.25_f32, -0.1, 0.0, 0.1, 0.25] {
            let clearance = seen.clearance(Point2::new(0.4, y));
            assert!(clearance.0 < 0.05, "{y}: {clearance:?}");
        }
    }

    /// Hits that rangers' cones had shifted into a passage closed it.
    #[test]
    fn a_beam_that_goes_on_takes_a_hit_back() {
        let mut walls = Walls::new();
        turned(&mut walls, 0, 12, (-0.9, 0.9));
        let now = turned(&mut walls, 12, 12, (0.3, 0.9));
        let clearance = walls.seen(now, HERE, RANGE).clearance(Point2::new(0.4, 0.0));
        assert!(clearance.0 > 0.2, "{clearance:?}");
    }
}
