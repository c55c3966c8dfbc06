//! Corrects what the drone takes for its place on the path where walls contradict it.

use core::f32::consts::SQRT_2;

use units::{Metres, MetresPerSecond};

use super::{HOVERING, Navigator, ROUND, Side, nearest};
use crate::{Diagonals, Range};

/// A wall that is passed within this many iterations was a corner.
const PATIENCE: u8 = 5;
/// The place has drifted by no more than this, m: 3 % of 25 m of memory, and the corners that were cut.
/// A drone that stood on would shift its whole trail away.
const FARTHEST_SHIFT: f32 = 1.0;
/// A drone that has flown so far back beside its own path, m, was turned round by a bend: behind a sharp
/// bend the galleries part sooner.
const RETURNED: f32 = 1.0;
/// It remembers the side to which it had turned until its path is so much longer, in crumbs of 0.2 m: 5 m.
const REMEMBERED: i32 = 25;
/// A beam to the path beside the drone ends so far behind it, m, where no wall is between.
const BEHIND_PATH: f32 = 0.1;
/// A drone that has stood tail first before a wall for so many iterations, 8 s, after which its place was moved
/// on as far as it may be, …
const STANDS: u8 = 40;
/// … has turned too early, and flies on by the path for so much of its way, m, before walls decide again.
const UNDONE: f32 = 0.8;

impl Navigator {
    /// Turns a drone back that flies nose first beside its own path, with no wall between, to where it came
    /// from: a bend turned it too far, and the tunnel goes on to the other side there.
    pub(super) fn heed_return(&mut self, ranges: &Diagonals, speed: MetresPerSecond) {
        self.led_back = self.led_back.filter(|(_, end)| self.trail.last() < end + REMEMBERED);
        let beside = if speed.0 > HOVERING { self.trail.beside() } else { None };
        let sees = |beam: Range, way: f32| beam != Range::Invalid && nearest(beam) > way;
        let found = beside.filter(|(_, aside)| {
            let beams = if *aside > 0.0 { [ranges.nw, ranges.sw] } else { [ranges.ne, ranges.se] };
            beams.iter().all(|beam| sees(*beam, SQRT_2 * aside.abs() + BEHIND_PATH))
        });
        self.returns = if found.is_some() { self.returns + speed.0 * ROUND } else { 0.0 };
        if let Some((number, aside)) = found
            && self.returns > RETURNED
        {
            self.returns = 0.0;
            self.trail.end_at(number);
            self.faces_back = true;
            self.led_back = Some((if aside > 0.0 { Side::Left } else { Side::Right }, number));
        }
    }

    /// Notices that a drone that flies tail first stands before a wall: where it knows its place on the path
    /// only roughly, it may have turned before the bend. It turns back to the gallery by which it came
    /// there, and flies on along that.
    pub(super) fn undo_turn(&mut self, is_blocked: bool, speed: MetresPerSecond, moved: Metres) {
        self.turned_early = (self.turned_early - moved.0.abs()).max(0.0);
        let stands = is_blocked && speed.0 < -HOVERING && !self.company.is_ahead(speed.0);
        self.stands = if stands { self.stands.saturating_add(1) } else { 0 };
        if self.stands > STANDS {
            self.stands = 0;
            if self.trail.go_before_bend() {
                self.turned_early = UNDONE;
            }
        }
    }

    /// Moves a drone that has stood before a wall for a while on along its trail: the place drifts,
    /// and the drone is already at the bend.
    pub(super) fn pass_corner(&mut self, is_blocked: bool, speed: MetresPerSecond) {
        let is_blocked = is_blocked && speed.0.abs() > HOVERING;
        self.blocked = if is_blocked { self.blocked.saturating_add(1) } else { 0 };
        if self.blocked == 0 && speed.0.abs() > HOVERING {
            self.shifted = (self.shifted - speed.0.abs() * ROUND).max(0.0);
        }
        if self.blocked > PATIENCE && self.shifted < FARTHEST_SHIFT {
            self.shifted += speed.0.abs() * ROUND;
            self.trail.shift(speed.0 * ROUND);
        }
    }
}
