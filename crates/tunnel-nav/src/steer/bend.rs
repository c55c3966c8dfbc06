//! Turns a drone at a sharp bend, where its gallery ends and goes on at one side.
//!
//! Before a bend of more than a right angle the drone sees a wall on one side, the tunnel opens on the other,
//! and the front beam of that side meets the wall that ends the gallery while its rear beam looks back into
//! the next one. Equation (18) turns by the difference of two distances there, which is small in a narrow
//! gallery and against which the wall that is kept turns the nose: of 400 drawn bends of 100 to 150 degrees in
//! galleries of 0.8 to 1.3 m, 129 held a drone in the pocket behind the bend until it looked round. So the
//! drone turns at its full rate to the side that has opened, until it has turned by half of a right angle; from
//! there its front beams find the way.

use super::{BEFORE_BEND, Navigator, Side, nearest};
use crate::wall::{SAME_GALLERY, Wall};
use crate::{Diagonals, Range};

/// The gallery ends where the front beam over the open side is shorter than this part of the beam to the wall
/// that is kept: in the middle of a right angle the two are equal. Our own number.
const ENDS: f32 = 0.9;
/// Half of a right angle and less, rad: farther on, the rear beam looks back into the gallery by which the
/// drone came. Chosen of 0.6 and 1 by drones that rest in right angles, of which some turned round at 1.
const TURNED: f32 = 0.6;

impl Navigator {
    /// Notes to which side the gallery goes on where it ends ahead.
    pub(super) fn note_bend(&mut self, ranges: &Diagonals) {
        self.bends_to = match self.walls(ranges) {
            (Some(l), None) if self.ends_towards(Side::Right, [ranges.ne, ranges.se], l) => {
                Some(Side::Right)
            }
            (None, Some(r)) if self.ends_towards(Side::Left, [ranges.nw, ranges.sw], r) => {
                Some(Side::Left)
            }
            _ => self.bends_to.filter(|side| self.opens_to(*side) && self.turned(*side) < TURNED),
        };
    }

    /// Whether the tunnel has opened last to this side.
    fn opens_to(&self, side: Side) -> bool {
        self.opening.is_some_and(|(opened, _)| opened == side)
    }

    /// How far the nose has turned to this side from the gallery by which the drone came, rad.
    fn turned(&self, side: Side) -> f32 {
        let came = self.trail.off(-BEFORE_BEND).0;
        if side == Side::Right { came } else { -came }
    }

    /// Whether the gallery ends ahead at a wall that the front beam of the side that has opened sees, nearer
    /// than the wall that is kept on the other, while its rear beam looks into where the gallery goes on.
    pub(super) fn ends_towards(&self, side: Side, [front, rear]: [Range; 2], kept: Wall) -> bool {
        let opens = self.opens_to(side);
        // Past half of a right angle, the rear beam looks back into the gallery by which the drone came.
        let goes_on = self.turned(side) < TURNED;
        let [front, rear] = [front, rear].map(nearest);
        goes_on
            && opens
            && front < ENDS * kept.front.min(self.centred)
            && rear > SAME_GALLERY * self.centred
    }
}
