//! Says what goes wrong on a flight.

use units::Metres;

use crate::Phase;

/// What goes wrong on a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trouble {
    /// The largest error of a position. In every round each drone has another error, evenly
    /// distributed over the disc of this radius, in what it knows and tells of its position. All
    /// drones know this radius.
    pub noise: Metres,
    /// The share of the packets that are lost, from 0 to 1, each by itself.
    pub loss: f32,
    /// Whether drones hear of each other's progress a round late.
    pub late_news: bool,
    /// A drone that fails.
    pub failure: Option<Failure>,
}

impl Trouble {
    /// Nothing goes wrong, as in the paper.
    pub const NONE: Self = Self { noise: Metres(0.0), loss: 0.0, late_news: false, failure: None };
}

/// A drone that fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failure {
    /// The drone, from 0.
    pub drone: u16,
    /// The phase in which it fails.
    pub phase: Phase,
    /// The rounds from the beginning of the phase to its failure.
    pub after: u32,
    /// The rounds for which it stands still in the air and goes on sending; a drone that stands for
    /// no round falls down and is silent for good.
    pub stands: u32,
}
