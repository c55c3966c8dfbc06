//! Simulates the bodies of drones. A [`Body`] is the body of one drone at any fidelity: it takes
//! set-points and returns sensor values.
//!
//! | module | holds |
//! |---|---|
//! | [`point`] | a point on the floor plan that follows set-points with a lag |
//! | [`craft`] | a rigid body with motors and sensors, and the flight code in the loop |
//! | [`others`] | the other drones, as a drone's rangers see them |
//! | [`emulated`] | a craft whose firmware runs in an emulator, with the feature `virtual` |

pub mod craft;
#[cfg_attr(not(feature = "virtual"), path = "emulated/absent.rs")]
pub mod emulated;
pub mod others;
pub mod point;

use input::InputError;
use onboard::{Fix, Sensed, mounting};
use units::{Metres, Point2, Pose2, Radians, Setpoint};

use craft::{Craft, Surroundings};
use point::{PointBody, Response};
use random::Stream;
use scenario::VehicleSpec;

/// One drone's body.
pub enum Body {
    /// A point on the floor plan.
    Point(PointBody),
    /// A rigid body with its motors, its sensors and its flight code.
    Craft(Box<Flown>),
}

/// A rigid body that flies in a mission.
pub struct Flown {
    /// The craft itself.
    pub craft: Craft,
    setpoint: Setpoint,
}

impl Flown {
    /// A craft that was last given this set-point.
    pub fn new(craft: Craft, setpoint: Setpoint) -> Self {
        Self { craft, setpoint }
    }
}

impl Body {
    /// The place on the floor plan.
    #[must_use]
    pub const fn position(&self) -> Point2 {
        match self {
            Self::Point(body) => body.position(),
            Self::Craft(flown) => {
                let [x, y, _] = flown.craft.body().position();
                Point2::new(x, y)
            }
        }
    }

    /// The place and the heading of the nose.
    #[must_use]
    pub fn pose(&self) -> Pose2 {
        Pose2 { at: self.position(), yaw: Radians(self.yaw()) }
    }

    /// The height above the ground, m; zero for a drone that stands on it.
    #[must_use]
    pub fn height(&self) -> f32 {
        match self {
            Self::Point(body) => body.height(),
            Self::Craft(flown) => {
                let body = flown.craft.body();
                if body.is_on_floor() { 0.0 } else { body.height().max(0.0) }
            }
        }
    }

    /// The heading of the nose, counter-clockwise from east.
    #[must_use]
    pub fn yaw(&self) -> f32 {
        match self {
            Self::Point(body) => body.yaw(),
            Self::Craft(flown) => {
                let [x, y] = flown.craft.nose();
                libm::atan2f(y, x)
            }
        }
    }

    /// The number of times that it has touched a wall.
    #[must_use]
    pub const fn contacts(&self) -> u32 {
        match self {
            Self::Point(body) => body.contacts(),
            Self::Craft(flown) => flown.craft.contacts(),
        }
    }

    /// The last set-point.
    #[must_use]
    pub const fn setpoint(&self) -> Setpoint {
        match self {
            Self::Point(body) => body.setpoint(),
            Self::Craft(flown) => flown.setpoint,
        }
    }

    /// The craft, at flight level.
    #[must_use]
    pub const fn craft(&self) -> Option<&Craft> {
        match self {
            Self::Point(_) => None,
            Self::Craft(flown) => Some(&flown.craft),
        }
    }

    /// The craft, at flight level, to change it.
    pub fn craft_mut(&mut self) -> Option<&mut Craft> {
        match self {
            Self::Point(_) => None,
            Self::Craft(flown) => Some(&mut flown.craft),
        }
    }

    /// Gives it a set-point in the axes of the nose.
    pub fn command(&mut self, setpoint: Setpoint) {
        match self {
            Self::Point(body) => body.command(setpoint),
            Self::Craft(flown) => {
                flown.setpoint = setpoint;
                flown.craft.command(mounting::to_board(setpoint));
            }
        }
    }

    /// Lets the firmware in an emulator fly the body from now on.
    pub fn hand_over(&mut self) {
        if let Self::Craft(flown) = self {
            flown.craft.fly_from_outside();
        }
    }

    /// Records a set-point of the firmware in an emulator.
    pub fn note(&mut self, setpoint: Setpoint) {
        match self {
            Self::Point(body) => body.command(setpoint),
            Self::Craft(flown) => flown.setpoint = setpoint,
        }
    }

    /// Simulates one physics step: 20 ms of a point, or a millisecond of a rigid body.
    pub fn advance(&mut self, around: Surroundings<'_>, response: Response) {
        match self {
            Self::Point(body) => body.advance(around.tunnel, around.vehicle, response),
            Self::Craft(flown) => flown.craft.advance(around),
        }
    }

    /// The reading of the positioning system, where there is one.
    fn fix(&self, spec: &VehicleSpec, random: &mut Stream) -> Option<Fix> {
        let deviation = spec.position_noise?;
        let Pose2 { at, yaw } = self.pose();
        let mut off = || deviation * random.normal();
        let at = Point2::new(at.x + off(), at.y + off());
        Some(Fix { at, yaw: Some(yaw), deviation: Metres(deviation) })
    }

    /// The sensor values, `elapsed` seconds after they were last read.
    pub fn sense(&mut self, elapsed: f32, around: Surroundings<'_>, random: &mut Stream) -> Sensed {
        let spec = around.vehicle;
        let fix = self.fix(spec, random);
        match self {
            Self::Point(body) => {
                body.renew_nose();
                let (battery, endurance, fitness) = body.read_battery();
                Sensed {
                    fix,
                    ranges: body.read_ranges(around, random),
                    velocity: Some(body.read_flow(elapsed, spec, random)),
                    heading: Some(Radians(body.yaw())),
                    height: Some(Metres(body.height())),
                    fitness,
                    battery,
                    endurance,
                }
            }
            Self::Craft(flown) => {
                let status = &flown.craft.outputs().status;
                let sensed = Sensed::by_board(status, &flown.craft.sides(), Metres(spec.reach));
                Sensed { fix, ..sensed }
            }
        }
    }
}

/// The error of a build without the feature `virtual` that is asked for `what`, which needs the emulator.
#[must_use]
pub fn without_emulator(what: &str) -> InputError {
    let wrong = format!("{what}: this uchain was built without the emulator");
    InputError::new(wrong, "use `cargo sim-virtual` in place of `cargo sim`")
}
