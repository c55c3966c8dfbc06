//! Leads a drone that flies home back to the path by which it came.
//!
//! Walls lead the drone well where it sees one on each side. In a wide gallery, at a junction and in a room it
//! does not, and there a wall ahead may turn it to where it has not been. The path is known there by dead
//! reckoning, and the tail is pointed to a place on it.

use units::MetresPerSecond;

use super::{HOVERING, Navigator, Walls};
use crate::plane::wrapped;

/// The path leads elsewhere than its headings say where the directions differ by more than this, rad: the drone
/// turned at the end of its path, and flew on no farther. A path round a bend differs by less. Our own number.
const ELSEWHERE: f32 = 1.5;

impl Navigator {
    /// The angle by which the nose of a drone on its way home is off so that the tail points to its path. It is
    /// `None` where the walls or the headings of the path lead: `off` is the angle by these, or `None` where the
    /// walls decide.
    pub(super) fn off_home(
        &self,
        walls: Walls,
        off: Option<f32>,
        speed: MetresPerSecond,
    ) -> Option<f32> {
        if speed.0 >= -HOVERING || !self.fork.is_homing() {
            return None;
        }
        let leads = |home: &f32| match off {
            Some(off) => !self.trail.is_old() && wrapped(home - off).abs() > ELSEWHERE,
            None => self.trail.is_old() && !self.fork.is_chosen() && walls != Walls::Both,
        };
        self.trail.pursues().map(|home| home.0).filter(leads)
    }
}
