//! One robot in the world: where it truly is, and what its sensors see.

use frontier::{Beam, Config, Explorer, Ground, Inputs, Limits, Motion, Outputs};
use grid_map::{CellState, RayEnd};
use units::{Instant, Point2, Pose2, Radians};

use crate::run::{RECORDS, ROBOTS};
use crate::world::{REACH, World};

/// The camera's field of view (thesis, table 3.1).
const VIEW: f32 = std::f32::consts::FRAC_PI_3;
const RAYS: u16 = 90;
/// What a robot knows to be free at the start: its own place (m).
const OWN_PLACE: f32 = 0.35;

/// A robot as a point.
pub(crate) struct Robot<G> {
    pub(crate) pose: Pose2,
    pub(crate) mind: Box<Explorer<G, ROBOTS, RECORDS>>,
    limits: Limits,
    motion: Motion,
    pub(crate) flown: f32,
    pub(crate) touches: u32,
    pub(crate) inbox: Vec<Vec<u8>>,
}

impl<G: Ground> Robot<G> {
    pub(crate) fn new(config: Config, mut ground: G, world: &World, pose: Pose2) -> Self {
        let frame = *world.frame();
        let is_own = |cell: &_| frame.centre(*cell).distance(pose.at).0 < OWN_PLACE;
        for cell in frame.cells().filter(is_own).filter(|&cell| !world.is_wall(cell)) {
            ground.set(cell, CellState::Free);
        }
        Self {
            pose,
            mind: Box::new(Explorer::new(config, ground)),
            limits: config.limits,
            motion: Motion::default(),
            flown: 0.0,
            touches: 0,
            inbox: Vec::new(),
        }
    }

    /// Looks, hears, and decides.
    pub(crate) fn step(&mut self, now: Instant, world: &World) -> Outputs {
        let beams = self.look(world);
        let inbox = std::mem::take(&mut self.inbox);
        let packets: Vec<&[u8]> = inbox.iter().map(Vec::as_slice).collect();
        let inputs = Inputs { pose: self.pose, beams: &beams, packets: &packets };
        let outputs = self.mind.step(now, &inputs);
        self.motion = outputs.motion;
        outputs
    }

    /// The beams of the camera ahead and of the rangers to the other three sides.
    fn look(&self, world: &World) -> Vec<Beam> {
        let fan = (0..=RAYS).map(|n| (f32::from(n) / f32::from(RAYS) - 0.5) * VIEW);
        let sides = (1..4).map(|n| n as f32 * std::f32::consts::FRAC_PI_2);
        let beam = |off: f32| {
            let (to, is_wall) = world.ray(self.pose.at, self.pose.yaw.0 + off, REACH);
            Beam { to, end: if is_wall { RayEnd::Obstacle } else { RayEnd::Clear } }
        };
        fan.chain(sides).map(beam).collect()
    }

    /// Flies for `dt` seconds. A robot that would fly into a wall stays where it is.
    pub(crate) fn fly(&mut self, world: &World, dt: f32) {
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
            self.touches += 1;
            return;
        }
        self.flown += by * speed;
        self.pose.at = to;
    }
}
