//! Keeps robots apart from each other, by the places that they tell.

use grid_map::CellState;
use units::{Duration, Instant, Metres, Point2, Pose2};

use crate::atlas::{Disc, Ground};
use crate::explorer::Explorer;
use crate::flight::Motion;

/// The speed at which a robot goes out of another one's way, as a part of the fastest. Our own number.
const YIELDING: f32 = 0.5;
/// Nearer than this part of the distance, both robots go out of each other's way. Our own number.
const BOTH: f32 = 0.6;
/// By so much nearer to each other robots come that pass each other, m: to 0.48 m of the 0.8 m of a drone
/// that knows its place. Our own number.
const NEARER: f32 = 0.32;
/// On the way to where it stood in the row, 0.35 m from the next, a robot comes as near as this part of the distance
/// to those with higher numbers, which go out of its way. Our own number: 0.4 of a drone's 0.8 m.
const IN_THE_ROW: f32 = 0.5;
/// A robot that goes out of the way needs this part of the distance clear ahead of it. Our own number.
const CLEAR: f32 = 0.4;
/// A robot that stands, with another one nearer than by so much more than the distance that it keeps, has
/// that one in its way, m: the way that a robot flies in a second, after which it tells its place anew.
const NEWS: f32 = 0.3;
/// For so long a robot that stood in the way counts as an obstacle: the time in which it flies 6 to 9 m.
/// Our own number.
const BLOCKED: Duration = Duration::from_millis(30_000);

/// Where another robot stood in the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Blockade {
    disc: Disc,
    until: Instant,
}

impl<G: Ground, const ROBOTS: usize, const RECORDS: usize> Explorer<G, ROBOTS, RECORDS> {
    /// The velocity, to the east and to the north in m/s, that the robot flies in place of that of
    /// `motion`, which keeps it at this distance from the others, by the places that they told last; at
    /// less while another robot is in the way, so that the two can pass each other.
    pub fn apart(
        &mut self,
        now: Instant,
        pose: Pose2,
        motion: Motion,
        distance: Metres,
    ) -> [f32; 2] {
        self.distance = distance;
        let [forward, left] = motion.velocity;
        let (sin, cos) = pose.yaw.sin_cos();
        let wanted = [forward * cos - left * sin, forward * sin + left * cos];
        let frame = self.ground.frame();
        let is_free = |cell| self.ground.state(cell) == CellState::Free;
        let is_clear = |to: Point2| frame.line(pose.at, to).all(is_free);
        // Robots on their way back follow each other.
        let passes = self.avoided(now).is_some() && !self.is_recalled;
        let nearer = if passes { NEARER } else { 0.0 };
        let distance = (distance.0 - nearer).max(0.0);
        let goes_first = self.is_recalled && self.meeting.is_near(pose.at);
        let number = self.config.number;
        let from = |other: u8| match goes_first && other > number {
            true => IN_THE_ROW * distance,
            false => distance,
        };
        let limits = (from, self.config.limits.speed);
        kept_apart(number, pose.at, wanted, limits, self.others(now), is_clear)
    }

    /// Takes another robot that stands near this one, which stands as well, to be in the way for some time:
    /// in a passage each of two robots may have its goal behind the other. This one then looks for goals on
    /// its own side, and flies back to where it began while it has none. Returns the number of that robot;
    /// `None` where there is none.
    pub(crate) fn note_blockade(&mut self, now: Instant, at: Point2) -> Option<u8> {
        let near = self.team.others(now).map(|(robot, place)| (robot, place, place.distance(at)));
        let nearest = near.min_by(|a, b| a.2.0.total_cmp(&b.2.0));
        let is_in_the_way = |off: Metres| off.0 < self.distance.0 + NEWS;
        let (robot, middle, off) = nearest.filter(|(_, _, off)| is_in_the_way(*off))?;
        let radius = Metres((off.0 - NEARER).max(0.0));
        self.blockade = Some(Blockade { disc: Disc { middle, radius }, until: now + BLOCKED });
        self.meeting.wait_again();
        Some(robot)
    }

    /// The place around another robot that is in the way now.
    pub(crate) fn avoided(&self, now: Instant) -> Option<Disc> {
        self.blockade.filter(|blockade| now < blockade.until).map(|blockade| blockade.disc)
    }
}

/// Another robot: its number and its place.
type Other = (u8, Point2);

/// The velocity, to the east and to the north in m/s, that a robot `number` at `here` flies in place of
/// `wanted`. Within its `distance` (m) of another robot it does not come nearer to it; the one of the higher
/// number goes away from it, unless `is_clear` says that a wall is there. It stops where the way that
/// this leaves is not clear.
fn kept_apart(
    number: u8,
    here: Point2,
    wanted: [f32; 2],
    (distance, speed): (impl Fn(u8) -> f32, f32),
    others: impl Iterator<Item = Other>,
    is_clear: impl Fn(Point2) -> bool,
) -> [f32; 2] {
    let mut velocity = wanted;
    let mut clear = 0.0_f32;
    for (other, at) in others {
        let distance = distance(other);
        let off = at.distance(here).0;
        if off >= distance || off <= 0.0 {
            continue;
        }
        let [east, north] = [(at.x - here.x) / off, (at.y - here.y) / off];
        let towards = velocity[0] * east + velocity[1] * north;
        let yields = number > other || off < BOTH * distance;
        let behind = Point2::new(here.x - east * distance, here.y - north * distance);
        let most = if yields && is_clear(behind) { -YIELDING * speed } else { 0.0 };
        let by = towards - most;
        if by > 0.0 {
            velocity = [velocity[0] - by * east, velocity[1] - by * north];
        }
        clear = clear.max(CLEAR * distance);
    }
    let pace = libm::sqrtf(velocity[0] * velocity[0] + velocity[1] * velocity[1]);
    if velocity == wanted || pace <= 0.0 {
        return velocity;
    }
    let ahead = clear / pace;
    let to = Point2::new(here.x + ahead * velocity[0], here.y + ahead * velocity[1]);
    if is_clear(to) { velocity } else { [0.0; 2] }
}
