//! The sensor values of one round of the mission.

use agent::{BodyVelocity, Fitness};
use flight::Mode;
use tunnel_nav::{Diagonals, Range};
use units::{Duration, Metres, Radians, Volts};

use crate::Fix;
use crate::mounting::{self, Sides};

/// The state of the drone and the ranges to the walls by its sensors, in the axes of its nose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensed {
    /// The four side beams.
    pub ranges: Diagonals,
    /// The velocity over ground; `None` while no sensor measures it.
    pub velocity: Option<BodyVelocity>,
    /// The heading by gyroscope; `None` while it is unknown.
    pub heading: Option<Radians>,
    /// The height over ground; `None` while no sensor measures it.
    pub height: Option<Metres>,
    /// Where the drone is by a positioning system on board; `None` where there is none, or no new
    /// reading of it.
    pub fix: Option<Fix>,
    /// Whether the drone is fit to take off or to go on flying.
    pub fitness: Fitness,
    /// The voltage at the battery's terminals; `None` where it is unknown.
    pub battery: Option<Volts>,
    /// The time for which the battery still carries the drone; `None` while it is unknown.
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
        fix: None,
        fitness: Fitness::Fit,
        battery: None,
        endurance: None,
    };

    /// The values before the first step of the flight code, with which a drone does not take off.
    pub const NOT_YET: Self = Self { fitness: Fitness::Unfit, ..Self::NONE };

    /// Returns the values of a board from the status of its flight code and from its side rangers,
    /// which measure up to `reach`.
    ///
    /// The navigator treats a beam without a reading as one that sees no wall, so a drone without
    /// one of its rangers is not fit to take off.
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
            fix: None,
            fitness,
            battery: Some(status.battery.volts).filter(|volts| volts.0 > 0.0),
            endurance: status.battery.endurance,
        }
    }
}
