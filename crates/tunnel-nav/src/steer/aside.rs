//! Keeps a drone beside the chosen wall of a wide gallery, on new ground and on its path.

use units::Metres;

use super::{LEAST_PACE, Navigator, Side, room_beside};
use crate::margin::{Keeps, Margin};
use crate::wall::Track;
use crate::{Diagonals, NavConfig};

/// The gain, in 1/s, by which a drone in a wide gallery, where no walls keep it in the middle, comes
/// back to its path.
const PATH_GAIN: f32 = 2.0;
/// The drone slows down as it comes near to this distance beside its path, m: where it crossed the
/// gallery the path leads sideways twice as fast as ahead.
const FARTHEST_BESIDE: f32 = 0.2;

impl Navigator {
    /// Keeps to the chosen side of a wide gallery, and returns the ranges without those of the wall that
    /// is left.
    pub(super) fn keep_aside(&mut self, ranges: &Diagonals, moved: Metres) -> Diagonals {
        let tracks = [self.left, self.right];
        let before = self.margin.keeps();
        let is_turning = self.fork.is_at_corner();
        self.margin = self.margin.next(self.fork.side(), tracks, ranges, moved, is_turning);
        let Keeps::Wall(side) = self.margin.keeps() else { return *ranges };
        let (chosen, left) = match side {
            Side::Left => (&mut self.left, &mut self.right),
            Side::Right => (&mut self.right, &mut self.left),
        };
        if before != self.margin.keeps() && !is_turning {
            *chosen = chosen.found(Margin::beams(ranges, side));
        }
        if left.is_longer(Margin::NARROW) {
            *left = Track::LEFT_BEHIND;
        }
        self.centred = Margin::KEPT;
        Margin::without(ranges, side)
    }

    /// The sideways velocity on known ground, m/s, and the part of its speed that the drone may fly.
    /// `sidestep` is the velocity that passes obstacles, `along_wall` the one that walls ask for.
    ///
    /// In a narrow gallery obstacles alone move the drone sideways. In a wide one it follows the wall
    /// where its path does, and elsewhere the path.
    pub(super) fn keep_to_path(
        &self,
        config: &NavConfig,
        ranges: &Diagonals,
        [sidestep, along_wall]: [f32; 2],
    ) -> (f32, f32) {
        if !self.margin.is_kept() {
            return (sidestep, 1.0);
        }
        if self.is_along_wall() {
            return (along_wall, 1.0);
        }
        let aside = self.trail.aside();
        let near = (1.0 - aside.abs() / FARTHEST_BESIDE).max(LEAST_PACE);
        let pull = -PATH_GAIN * aside;
        // Where the drone reckons to be drifts: the path may seem to lie behind a wall.
        let side = if pull > 0.0 { Side::Left } else { Side::Right };
        let room = room_beside(config, ranges, side);
        (sidestep + room * pull, near)
    }

    /// Whether the drone sees the wall that it keeps to, and the path leads along it and not across the
    /// gallery.
    pub(super) fn is_along_wall(&self) -> bool {
        let sees_wall = match self.margin.keeps() {
            Keeps::Wall(Side::Left) => self.left.is_seen(),
            Keeps::Wall(Side::Right) => self.right.is_seen(),
            Keeps::Middle | Keeps::Crossing(_) => false,
        };
        sees_wall && !self.trail.bends() && !self.trail.leads_across()
    }
}
