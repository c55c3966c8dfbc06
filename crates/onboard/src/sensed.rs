//! The sensor values of one round of the mission.

use agent::{BodyVelocity, Fitness};
use flight::Mode;
use tunnel_nav::{Diagonals, Range};
use units::{Duration, Metres, Radians, Volts};

use crate::mounting::{self, Sides};

/// The state of the drone and the ranges to the walls by its sensors, in the axes of its nose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensed {
    /// The four side beams.
    pub ranges: Diagonals,
    /// Velocity over ground; `None` while nothing measures it.
    pub velocity: Option<BodyVelocity>,
    /// Heading by gyro; `None` while there is none.
    pub heading: Option<Radians>,
    /// Height over ground; `None` while nothing measures it.
    pub height: Option<Metres>,
    /// How far the machine is fit to fly.
    pub fitness: Fitness,
    /// The battery at its terminals; `None` where there is none.
    pub battery: Option<Volts>,
    /// How long the battery still carries the drone; `None` while that is not known.
    pub endurance: Option<Duration>,
}

impl Sensed {
    /// The values of a node without sensors, such as a base.
    pub const NONE: Self = Self {
        ranges: Diagonals {
            nw: Range::Invalid,
            ne: Range::Invalid,
            sw: Range::Invalid,
            se: Range::Invalid,
        },
        velocity: None,
        heading: None,
        height: None,
        fitness: Fitness::Fit,
        battery: None,
        endurance: None,
    };

    /// The values before the first step of the flight code: the drone would not take off.
    pub const NOT_YET: Self = Self { fitness: Fitness::Unfit, ..Self::NONE };

    /// The values of a board, by its flight code and its side rangers, which see as far as `reach`.
    ///
    /// The navigator takes a beam without a reading for one that sees no wall, so a drone that misses
    /// a ranger is not fit to take off.
    #[must_use]
    pub fn by_board(status: &flight::Status, sides: &Sides, reach: Metres) -> Self {
        let fitness = match status.mode {
            Mode::Grounded { .. } if !sides.are_all_there() => Fitness::Unfit,
            mode => mounting::fitness(mode),
        };
        Self {
            ranges: sides.diagonals(reach),
            velocity: status.velocity.map(mounting::from_board),
            heading: Some(mounting::heading(status.attitude.yaw)),
            height: status.height,
            fitness,
            battery: Some(status.battery.volts).filter(|volts| volts.0 > 0.0),
            endurance: status.battery.endurance,
        }
    }
}
