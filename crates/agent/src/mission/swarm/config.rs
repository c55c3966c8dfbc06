//! The plan of a swarm's mission, and the rules by which it is flown.

use units::{Duration, Metres, MetresPerSecond, Point2, RadiansPerSecond};
use virtual_forces::{Config, Passage, Plan, Survey};

/// The plan of a swarm's mission, and the rules by which it is flown. All drones of a swarm must have
/// the same plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwarmConfig {
    /// The virtual forces.
    pub forces: Config,
    /// The number of drones, which are those from number 0 on.
    pub drones: u16,
    /// The south-western corner of the area that is surveyed.
    pub corner: Point2,
    /// The area's extent to the east and to the north.
    pub area: (Metres, Metres),
    /// The passage to the second area.
    pub passage: Passage,
    /// The speed over ground.
    pub speed: MetresPerSecond,
    /// The rate at which the nose turns to where it should point, 1/s.
    pub turn_gain: f32,
    /// The fastest turn.
    pub turn_limit: RadiansPerSecond,
    /// The error of a position that is allowed for, in standard deviations along an axis: two of each
    /// of two drones are 2.8 of their distance's, and that is within them in 99.5 % of cases.
    pub deviations: f32,
    /// The least error that is allowed for, however well a position is said to be known.
    pub least_error: Metres,
    /// A position with a larger standard deviation counts as lost.
    pub largest_deviation: Metres,
    /// How long a drone hovers without its position before it lands.
    pub patience: Duration,
}

impl SwarmConfig {
    /// Six drones, the area of the paper and its passage c, which begins at the origin. At 0.3 m/s a
    /// drone is carried on by 9 cm through the lag of its velocity loop, less than the 10 cm of a
    /// step. A drone that hovers by its optic flow drifts by a few centimetres a second, so that one
    /// without its position is near another after 10 s (the formation's 0.75 m).
    pub const DEFAULT: Self = Self {
        forces: Config::OURS,
        drones: 6,
        corner: Point2::new(-9.75, -3.75),
        area: (Metres(9.0), Metres(7.5)),
        passage: Passage {
            entrance: Point2::new(0.0, 0.0),
            width: Metres(2.26),
            way: Point2::new(1.0, 0.0),
            length: Metres(6.0),
        },
        speed: MetresPerSecond(0.3),
        turn_gain: 1.0,
        turn_limit: RadiansPerSecond(0.5),
        deviations: 2.0,
        least_error: Metres(0.02),
        largest_deviation: Metres(0.15),
        patience: Duration::from_secs(10),
    };

    /// The largest error of a position with a standard deviation; that of none is twice the error of
    /// the worst that still counts.
    #[must_use]
    pub fn error_of(&self, deviation: Option<Metres>) -> Metres {
        let deviation = deviation.unwrap_or(Metres(2.0 * self.largest_deviation.0));
        Metres((self.deviations * deviation.0).max(self.least_error.0))
    }

    /// The plan as the virtual forces take it.
    #[must_use]
    pub fn plan(&self) -> Plan {
        let survey = Survey::new(&self.forces, self.corner, self.area, self.drones);
        Plan { drones: self.drones, survey, passage: self.passage }
    }
}
