//! The plan of a swarm's mission, the same for all its drones.

use units::{Metres, Point2};

use crate::geometry::along;
use crate::{Passage, Survey};

/// What all drones of a swarm know before they set out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// The number of drones.
    pub drones: u16,
    /// The goals in the first area, and those in the second one; a survey without goals is left out.
    pub surveys: [Survey; 2],
    /// The way to the second area.
    pub passage: Passage,
}

impl Plan {
    /// Returns the length of the way from `here` to `home`, which lies on this side of the passage: the
    /// straight line, or the one through the entrance for a drone that is in the passage or behind it.
    #[must_use]
    pub fn way_home(&self, here: Point2, home: Point2) -> Metres {
        let Passage { entrance, way, .. } = self.passage;
        match along(way, entrance, here) > 0.0 {
            true => Metres(here.distance(entrance).0 + entrance.distance(home).0),
            false => here.distance(home),
        }
    }
}
