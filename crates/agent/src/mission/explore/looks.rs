//! What the side beams of a drone that turns show of the place around it.

use core::f32::consts::FRAC_PI_4;

use frontier::{Beam, Cone, Side};
use grid_map::RayEnd;
use heapless::Vec;
use tunnel_nav::{Diagonals, Range};
use units::{Metres, Point2, Pose2, Radians};

/// The side beams: north-west, north-east, south-west and south-east.
const BEAMS: usize = 4;
/// Their directions from the nose, in eighths of a half turn to the left.
const EIGHTHS: [f32; BEAMS] = [1.0, -1.0, 3.0, -3.0];
/// A drone that has turned less than this between two readings does not tell from them on which side of a beam the
/// surface is, rad. Our own number: half of what it turns in a round at the mission's rate.
const LEAST_TURN: f32 = 0.05;
/// A distance that changes by more than this part of itself in a turn of a radian is that of a surface at the edge of the
/// beam; one square to the beam does not change. Our own number: such a surface is slanted by 27° and more.
const SLANTED: f32 = 0.5;
/// A distance that grows by more is that of another surface. Our own number: one that is slanted by 63°.
const GONE: f32 = 2.0;
/// A distance that changes less does so by the errors of the ranger and of the place, m: twice the
/// standard deviation of the way between two places that are known to a centimetre.
const LEAST_CHANGE: f32 = 0.03;

/// How far the beams see, and how widely.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// A longer range counts as no obstacle up to here.
    pub(super) reach: Metres,
    /// How far a beam that meets nothing shows the place to be free.
    pub(super) clear: Metres,
    /// The cone that a beam sees; `None` for a ray.
    pub(super) cone: Option<Cone>,
}

/// The last readings of the side beams, and where the drone was.
#[derive(Clone, Copy, Debug)]
pub(super) struct Looks {
    pose: Pose2,
    /// What each beam told, m; `None` where it had no reading.
    distances: [Option<f32>; BEAMS],
}

impl Looks {
    /// No reading.
    pub(super) const NONE: Self = Self {
        pose: Pose2 { at: Point2::new(0.0, 0.0), yaw: Radians::ZERO },
        distances: [None; BEAMS],
    };

    /// Takes the readings at a pose; returns what they show, but for hits of other drones and beams without a reading.
    pub(super) fn take(
        &mut self,
        pose: Pose2,
        ranges: &Diagonals,
        sight: Sight,
        is_drone: impl Fn(Point2) -> bool,
    ) -> Vec<Beam, BEAMS> {
        let Diagonals { nw, ne, sw, se } = *ranges;
        let last = *self;
        self.pose = pose;
        let mut beams = Vec::new();
        let looks = [nw, ne, sw, se].into_iter().zip(EIGHTHS).zip(&mut self.distances);
        for ((range, eighths), known) in looks {
            let before = known.take();
            let (distance, end) = match range {
                Range::At(distance) if distance <= sight.reach => (distance, RayEnd::Obstacle),
                Range::At(_) => (sight.reach, RayEnd::Clear),
                Range::Clear => (sight.clear, RayEnd::Clear),
                Range::Invalid => continue,
            };
            *known = Some(distance.0);
            let (sin, cos) = Radians(pose.yaw.0 + eighths * FRAC_PI_4).sin_cos();
            let to = Point2::new(pose.at.x + distance.0 * cos, pose.at.y + distance.0 * sin);
            if end == RayEnd::Clear || !is_drone(to) {
                let side = before.map_or(Side::Unknown, |before| {
                    last.side(before, pose, [cos, sin], distance.0)
                });
                // There is room for all four.
                let _ = beams.push(Beam { to, end, cone: sight.cone, side });
            }
        }
        beams
    }

    /// On which side of a beam the surface is that told `before` at the last pose, and that looks along `way` and tells
    /// `distance` now.
    fn side(&self, before: f32, pose: Pose2, way: [f32; 2], distance: f32) -> Side {
        let turned = (pose.yaw - self.pose.yaw).wrapped().0;
        let moved = [pose.at.x - self.pose.at.x, pose.at.y - self.pose.at.y];
        let change = distance - (before - moved[0] * way[0] - moved[1] * way[1]);
        if turned.abs() < LEAST_TURN || change.abs() < LEAST_CHANGE {
            return Side::Unknown;
        }
        let slant = change / (turned * distance);
        if change > 0.0 && slant.abs() > GONE {
            Side::Unknown
        } else if slant > SLANTED {
            Side::Right
        } else if slant < -SLANTED {
            Side::Left
        } else {
            Side::Unknown
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIGHT: Sight = Sight { reach: Metres(2.0), clear: Metres(1.2), cone: None };

    fn at(yaw: f32) -> Pose2 {
        Pose2 { at: Point2::new(0.0, 0.0), yaw: Radians(yaw) }
    }

    /// Ranges of which the north-western one alone is a reading, m.
    fn ranges(nw: f32) -> Diagonals {
        Diagonals {
            nw: Range::At(Metres(nw)),
            ne: Range::Invalid,
            sw: Range::Invalid,
            se: Range::Invalid,
        }
    }

    /// The side that the north-western beam tells after two readings, a tenth of a radian apart.
    fn side(first: f32, second: f32) -> Side {
        let mut looks = Looks::NONE;
        looks.take(at(0.0), &ranges(first), SIGHT, |_| false);
        looks.take(at(0.1), &ranges(second), SIGHT, |_| false)[0].side
    }

    #[test]
    fn a_distance_that_shrinks_in_a_turn_to_the_left_is_that_of_a_surface_at_the_left() {
        assert_eq!(side(1.1, 1.0), Side::Left);
        assert_eq!(side(1.0, 1.1), Side::Right);
    }

    #[test]
    fn a_jamb_is_seen_as_it_enters_the_beam_and_what_follows_it_is_not_known() {
        assert_eq!(side(1.8, 1.0), Side::Left);
        assert_eq!(side(1.0, 1.8), Side::Unknown);
    }

    #[test]
    fn a_wall_square_to_the_beam_is_on_neither_side() {
        assert_eq!(side(1.0, 1.02), Side::Unknown);
    }

    #[test]
    fn the_way_of_the_drone_counts_out_of_what_it_tells() {
        let mut looks = Looks::NONE;
        looks.take(at(0.0), &ranges(1.0), SIGHT, |_| false);
        // 0.06 m nearer along the beam at 45°, to a wall square to it.
        let nearer = Pose2 { at: Point2::new(0.042, 0.042), yaw: Radians(0.1) };
        assert_eq!(looks.take(nearer, &ranges(0.94), SIGHT, |_| false)[0].side, Side::Unknown);
    }
}
