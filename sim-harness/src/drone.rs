//! A drone's body at either fidelity, as a mission sees it: set-points in, senses out.

use agent::{BodyVelocity, Fitness, mounting};
use tunnel_nav::Diagonals;
use units::{Duration, Metres, Point2, Pose2, Radians, Setpoint, Volts};

use crate::craft::{Craft, Surroundings};
use crate::random::Stream;
use crate::vehicle::{Body, Response, VehicleSpec};
use crate::world::Tunnel;

/// What the agent is told of the machine.
#[derive(Clone, Copy, Debug)]
pub struct Senses {
    /// The four side beams.
    pub ranges: Diagonals,
    /// Velocity over ground.
    pub velocity: Option<BodyVelocity>,
    /// Heading by gyro.
    pub heading: Option<Radians>,
    /// Height over ground.
    pub height: Option<Metres>,
    /// How far it is fit to fly.
    pub fitness: Fitness,
    /// The battery at its terminals.
    pub battery: Option<Volts>,
    /// How long the battery still carries it.
    pub endurance: Option<Duration>,
}

impl Senses {
    /// Of a node that does not fly.
    pub(crate) const NONE: Self = Self {
        ranges: Diagonals {
            nw: tunnel_nav::Range::Invalid,
            ne: tunnel_nav::Range::Invalid,
            sw: tunnel_nav::Range::Invalid,
            se: tunnel_nav::Range::Invalid,
        },
        velocity: None,
        heading: None,
        height: None,
        fitness: Fitness::Fit,
        battery: None,
        endurance: None,
    };
}

/// One drone's body.
pub enum Drone {
    /// A point on the floor plan.
    Point(Body),
    /// A rigid body with its motors, its sensors and its flight code.
    Craft(Box<Flown>),
}

/// A craft on a mission.
pub struct Flown {
    /// The craft itself.
    pub craft: Craft,
    setpoint: Setpoint,
}

impl Flown {
    /// A craft that was last given this set-point.
    pub(crate) fn new(craft: Craft, setpoint: Setpoint) -> Self {
        Self { craft, setpoint }
    }
}

impl Drone {
    /// Where it is on the floor plan.
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

    /// Where it is, and the heading of its nose.
    #[must_use]
    pub fn pose(&self) -> Pose2 {
        Pose2 { at: self.position(), yaw: Radians(self.yaw()) }
    }

    /// Height above the ground, m; zero for one that stands on it.
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

    /// Heading of the nose, counter-clockwise from east.
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

    /// How often it has touched a wall.
    #[must_use]
    pub const fn contacts(&self) -> u32 {
        match self {
            Self::Point(body) => body.contacts(),
            Self::Craft(flown) => flown.craft.contacts(),
        }
    }

    /// What it was last told.
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

    pub(crate) fn craft_mut(&mut self) -> Option<&mut Craft> {
        match self {
            Self::Point(_) => None,
            Self::Craft(flown) => Some(&mut flown.craft),
        }
    }

    pub(crate) fn command(&mut self, setpoint: Setpoint) {
        match self {
            Self::Point(body) => body.command(setpoint),
            Self::Craft(flown) => {
                flown.setpoint = setpoint;
                flown.craft.command(mounting::to_board(setpoint));
            }
        }
    }

    /// Somebody else flies it from now on.
    pub(crate) fn hand_over(&mut self) {
        if let Self::Craft(flown) = self {
            flown.craft.fly_from_outside();
        }
    }

    /// Somebody else has told it so.
    pub(crate) fn note(&mut self, setpoint: Setpoint) {
        match self {
            Self::Point(body) => body.command(setpoint),
            Self::Craft(flown) => flown.setpoint = setpoint,
        }
    }

    /// One physics step: 20 ms of the point, a millisecond of the craft.
    pub(crate) fn advance(&mut self, around: Surroundings<'_>, response: Response) {
        match self {
            Self::Point(body) => body.advance(around.tunnel, around.vehicle, response),
            Self::Craft(flown) => flown.craft.advance(around),
        }
    }

    /// What it senses, `elapsed` seconds after it was last asked.
    pub(crate) fn sense(
        &mut self,
        elapsed: f32,
        tunnel: &Tunnel,
        spec: &VehicleSpec,
        random: &mut Stream,
    ) -> Senses {
        match self {
            Self::Point(body) => {
                body.renew_nose();
                Senses {
                    ranges: body.read_ranges(tunnel, spec, random),
                    velocity: Some(body.read_flow(elapsed, spec, random)),
                    heading: Some(Radians(body.yaw())),
                    height: Some(Metres(body.height())),
                    fitness: Fitness::Fit,
                    battery: None,
                    endurance: None,
                }
            }
            Self::Craft(flown) => {
                let status = flown.craft.outputs().status;
                Senses {
                    ranges: flown.craft.diagonals(Metres(spec.reach)),
                    velocity: status.velocity.map(mounting::from_board),
                    heading: Some(mounting::heading(status.attitude.yaw)),
                    height: status.height,
                    fitness: mounting::fitness(status.mode),
                    battery: Some(status.battery.volts),
                    endurance: status.battery.endurance,
                }
            }
        }
    }
}
