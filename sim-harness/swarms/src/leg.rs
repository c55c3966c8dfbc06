//! Measures one phase of a flight.

use units::Metres;

/// A phase of the mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Phase {
    /// The first area is surveyed.
    Survey,
    /// The compact formation is set up.
    Setup,
    /// The passage is crossed.
    Crossing,
}

impl Phase {
    /// All phases in their order.
    pub const ALL: [Self; 3] = [Self::Survey, Self::Setup, Self::Crossing];

    /// Returns the name that tables use.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Survey => "survey",
            Self::Setup => "setup",
            Self::Crossing => "crossing",
        }
    }
}

/// What one phase of a flight came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// The phase.
    pub phase: Phase,
    /// The rounds that it took, or nothing when the swarm got stuck. A survey ends when the last
    /// drone reaches its last goal, the set-up when the last drone is at its place or the first one
    /// sets out without it, and a crossing lasts from the first drone's entrance to the last one's
    /// exit.
    pub rounds: Option<u32>,
    /// The rounds in the ideal of the paper's table 1: the way of one drone between its first goal
    /// and its last one, or of the farthest drone to the entrance, at the mean step of 7.5 cm; or
    /// the length of the passage at the longest step of 10 cm.
    pub ideal: f32,
    /// The least distance between two drones after any of their steps; infinite for one drone.
    pub closest_drones: Metres,
    /// The least distance between a drone and a wall after any of its steps; infinite where walls
    /// are not heeded.
    pub closest_wall: Metres,
    /// The links that were lost, each time that one was.
    pub links_lost: u32,
    /// The links that were made, each time that one was.
    pub links_made: u32,
    /// Whether the drones that fly were connected at the end of every round.
    pub connected: bool,
    /// The mean over the drones of the rounds that each took from its own entrance to its own exit;
    /// 0 in other phases.
    pub own_rounds: f32,
}

impl Leg {
    pub(crate) fn new(phase: Phase, ideal: f32) -> Self {
        Self {
            phase,
            rounds: None,
            ideal,
            closest_drones: Metres(f32::INFINITY),
            closest_wall: Metres(f32::INFINITY),
            links_lost: 0,
            links_made: 0,
            connected: true,
            own_rounds: 0.0,
        }
    }
}
