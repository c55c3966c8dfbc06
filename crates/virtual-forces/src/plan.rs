//! The plan of a swarm's mission, the same for all its drones.

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
