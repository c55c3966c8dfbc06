//! One robot in the world: where it truly is, and what its sensors see.

use frontier::{Activity, Beam, Config, Explorer, Gaze, Ground, Inputs, Limits, Motion, Outputs};
use grid_map::{CellState, RayEnd};
use units::{Instant, Metres, Point2, Pose2, Radians};

use crate::drift::Drift;
use crate::run::{LIMITS, RECORDS, ROBOTS, STEPS_PER_SECOND};
use crate::world::{REACH, World};

/// The camera's field of view (thesis, table 3.1).
const VIEW: f32 = std::f32::consts::FRAC_PI_3;
const RAYS: u16 = 90;
/// The Multi-ranger measures so often between two steps of a fifth of a second: each 100 ms, as the
/// task of Bitcraze's firmware (`multiranger.c`).
const READINGS: u16 = 2;
/// What a robot knows to be free at the start: its own place (m).
const OWN_PLACE: f32 = 0.35;
/// Robots keep so far apart from each other, as drones do (`ExploreConfig::distance` of the agent).
const APART: Metres = Metres(0.8);

/// The robots of a run, and an access point.
pub(crate) const TEAM: usize = ROBOTS + 1;

/// The sensor by which a robot maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sensor {
    /// A camera of 60° that sees 4 m far, as the thesis has, with rangers to the other three sides.
    #[default]
    Camera,
    /// The four horizontal beams of the Multi-ranger deck, 4 m at most; the robot turns all the time.
    Rangers,
}

impl Sensor {
    /// The limits of a robot's motion with this sensor.
    pub(crate) const fn limits(self) -> Limits {
        match self {
            Self::Camera => LIMITS,
            Self::Rangers => Limits { gaze: Gaze::Around, ..LIMITS },
        }
    }
}

/// What a robot perceives, and how well.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Senses {
    /// The sensor by which it maps.
    pub sensor: Sensor,
    /// Whether its position drifts as one that is reckoned by optic flow; it is exact otherwise.
    pub drifts: bool,
}

/// A robot as a point.
pub(crate) struct Robot<G> {
    pub(crate) pose: Pose2,
    pub(crate) mind: Box<Explorer<G, TEAM, RECORDS>>,
    limits: Limits,
    sensor: Sensor,
    /// The error of its position; `None` where that is exact.
    drift: Option<Drift>,
    motion: Motion,
    pub(crate) flown: f32,
    pub(crate) touches: u32,
    pub(crate) into_walls: u32,
    /// Whether its body touches a wall now.
    is_at_wall: bool,
    pub(crate) inbox: Vec<Vec<u8>>,
}

impl<G: Ground> Robot<G> {
    pub(crate) fn new(
        config: Config,
        (sensor, drift): (Sensor, Option<Drift>),
        mut ground: G,
        world: &World,
        pose: Pose2,
    ) -> Self {
        let frame = *world.frame();
        let is_own = |cell: &_| frame.centre(*cell).distance(pose.at).0 < OWN_PLACE;
        for cell in frame.cells().filter(is_own).filter(|&cell| !world.is_wall(cell)) {
            ground.set(cell, CellState::Free);
        }
        Self {
            pose,
            mind: Box::new(Explorer::new(config, ground)),
            limits: config.limits,
            sensor,
            drift,
            motion: Motion::default(),
            flown: 0.0,
            touches: 0,
            into_walls: 0,
            is_at_wall: false,
            inbox: Vec::new(),
        }
    }

    /// Looks, hears, and decides.
    pub(crate) fn step(&mut self, now: Instant, world: &World) -> Outputs {
        let beams = self.look(world);
        let inbox = std::mem::take(&mut self.inbox);
        let packets: Vec<&[u8]> = inbox.iter().map(Vec::as_slice).collect();
        let inputs = Inputs { pose: self.reckoned(self.pose), beams: &beams, packets: &packets };
        let outputs = self.mind.step(now, &inputs);
        self.motion = match self.mind.activity() {
            Activity::Stopped => Motion::default(),
            _ => self.apart(now, inputs.pose, outputs.motion),
        };
        outputs
    }

    /// The motion that keeps the robot apart from the others.
    fn apart(&mut self, now: Instant, pose: Pose2, motion: Motion) -> Motion {
        let [east, north] = self.mind.apart(now, pose, motion, APART);
        let (sin, cos) = pose.yaw.sin_cos();
        Motion { velocity: [east * cos + north * sin, north * cos - east * sin], ..motion }
    }

    /// The error of the position that it reckons.
    pub(crate) fn error(&self) -> [f32; 2] {
        self.drift.as_ref().map_or([0.0; 2], Drift::error)
    }

    /// The pose that it takes for its own.
    fn reckoned(&self, pose: Pose2) -> Pose2 {
        let [x, y] = self.error();
        Pose2 { at: Point2::new(pose.at.x + x, pose.at.y + y), ..pose }
    }

    /// The beams of its sensor, where it takes them to end.
    fn look(&self, world: &World) -> Vec<Beam> {
        match self.sensor {
            Sensor::Camera => self.look_ahead(world),
            Sensor::Rangers => self.look_around(world),
        }
    }

    /// The beams of the camera ahead and of the rangers to the other three sides.
    fn look_ahead(&self, world: &World) -> Vec<Beam> {
        let fan = (0..=RAYS).map(|n| (f32::from(n) / f32::from(RAYS) - 0.5) * VIEW);
        let sides = (1..4).map(|n| n as f32 * std::f32::consts::FRAC_PI_2);
        fan.chain(sides).map(|off| self.beam(world, off)).collect()
    }

    /// The beams to four sides, at some angles of the last turn as if that had been on the spot.
    fn look_around(&self, world: &World) -> Vec<Beam> {
        let dt = 1.0 / STEPS_PER_SECOND as f32;
        let turn = self.motion.yaw_rate.clamp(-self.limits.turn, self.limits.turn) * dt;
        let readings = (0..READINGS).map(|n| -turn * f32::from(n) / f32::from(READINGS));
        let sides = |back: f32| (0..4).map(move |n| back + n as f32 * std::f32::consts::FRAC_PI_2);
        readings.flat_map(sides).map(|off| self.beam(world, off)).collect()
    }

    fn beam(&self, world: &World, off: f32) -> Beam {
        let (to, is_wall) = world.ray(self.pose.at, self.pose.yaw.0 + off, REACH);
        let [x, y] = self.error();
        let end = if is_wall { RayEnd::Obstacle } else { RayEnd::Clear };
        Beam::ray(Point2::new(to.x + x, to.y + y), end)
    }

    /// Flies for `dt` seconds.
    pub(crate) fn fly(&mut self, world: &World, dt: f32) {
        let from = self.pose.at;
        self.fly_on(world, dt);
        if let Some(drift) = &mut self.drift {
            drift.fly([self.pose.at.x - from.x, self.pose.at.y - from.y], dt);
        }
    }

    /// Counts a touch of a wall that has begun, for a body of this radius.
    pub(crate) fn note_wall(&mut self, world: &World, radius: Metres) {
        let is_at_wall = world.is_touched(self.pose.at, radius);
        self.touches += u32::from(is_at_wall && !self.is_at_wall);
        self.is_at_wall = is_at_wall;
    }

    /// Flies for `dt` seconds. A robot whose middle would fly into a wall stays where it is.
    fn fly_on(&mut self, world: &World, dt: f32) {
        let Motion { velocity: [forward, left], yaw_rate } = self.motion;
        let yaw = self.pose.yaw.0 + yaw_rate.clamp(-self.limits.turn, self.limits.turn) * dt;
        self.pose.yaw = Radians(yaw.rem_euclid(std::f32::consts::TAU));
        let speed = forward.hypot(left);
        if speed == 0.0 {
            return;
        }
        let by = dt * speed.min(self.limits.speed) / speed;
        let (sin, cos) = yaw.sin_cos();
        let to = Point2::new(
            self.pose.at.x + by * (forward * cos - left * sin),
            self.pose.at.y + by * (forward * sin + left * cos),
        );
        if world.frame().cell_at(to).is_none_or(|cell| world.is_wall(cell)) {
            self.into_walls += 1;
            return;
        }
        self.flown += by * speed;
        self.pose.at = to;
    }
}
