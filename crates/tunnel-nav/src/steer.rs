//! From four ranges and a speed along the tunnel to a command for the body.

use units::{Metres, MetresPerSecond, RadiansPerSecond};

use crate::{Diagonals, Range};

/// Left or right of the drone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Side {
    /// y > 0.
    Left,
    /// y < 0.
    Right,
}

/// Which walls the command was made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Walls {
    /// Centred between two.
    Both,
    /// Following one.
    One(Side),
    /// Following none.
    Neither,
}

/// Gains and limits of the centring policy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NavConfig {
    /// C_l of equations (17) and (18), in (m/s)/m. 2 in the authors' firmware (0.02 m/s per cm),
    /// whose vehicle followed at once; with a lag of 0.3 s a corridor's 2√2·C_l must stay below 2.
    pub lateral_gain: f32,
    /// C_r of equations (17) and (18), in (rad/s)/m.
    pub yaw_gain: f32,
    /// Two beams of a side that differ by more than this part of their mean see no wall: 40 %
    /// "after calibration tests" (section IV-E).
    pub ratio: f32,
    /// D of equation (18): how far along its beam a single wall is kept.
    pub wall_distance: Metres,
    /// The range that stands for "nothing seen" in the maths: the ranger's reach, 2 m (V-B).
    pub reach: Metres,
    /// Below this beam length the drone slows down for what lies ahead,
    pub slow_below: Metres,
    /// and below this it stops and is pushed away. RANGER_DANGER_DIST of the authors' firmware.
    pub danger: Metres,
    /// How hard it is pushed, in (m/s)/m.
    pub push_gain: f32,
    /// Limit of the sideways velocity.
    pub max_lateral: MetresPerSecond,
    /// Limit of the yaw rate. The authors flew 30°/s at 0.2 m/s; a right angle at 0.4 m/s in a
    /// corridor of 1 m needs twice that.
    pub max_yaw_rate: RadiansPerSecond,
    /// Where to turn when nothing tells: every drone of a chain must have the same answer.
    pub prefer: Side,
}

impl NavConfig {
    /// For a Crazyflie with a multi-ranger deck in tunnels of 0.8 m and wider.
    pub const DEFAULT: Self = Self {
        lateral_gain: 0.6,
        yaw_gain: 0.5,
        ratio: 0.4,
        wall_distance: Metres(0.5),
        reach: Metres(2.0),
        slow_below: Metres(0.45),
        danger: Metres(0.2),
        push_gain: 2.0,
        max_lateral: MetresPerSecond(0.2),
        max_yaw_rate: RadiansPerSecond(1.05),
        prefer: Side::Right,
    };
}

impl Default for NavConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// A command in body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NavCommand {
    /// Along x: what was asked for, less where something is in the way.
    pub forward: MetresPerSecond,
    /// Along y.
    pub lateral: MetresPerSecond,
    /// Counter-clockwise.
    pub yaw_rate: RadiansPerSecond,
    /// What it was made from.
    pub walls: Walls,
}

/// Speeds below this are hovering: neither end of the drone leads.
const HOVERING: f32 = 0.05;

/// One iteration of the centring policy: what to fly, to go along the tunnel at `speed` (negative:
/// tail first) with these ranges.
#[must_use]
pub fn steer(config: &NavConfig, ranges: &Diagonals, speed: MetresPerSecond) -> NavCommand {
    let ahead = one_way(config, ranges);
    let astern = one_way(config, &ranges.seen_backwards());
    let leading = if speed.0 < 0.0 { &astern } else { &ahead };

    // 1 when flying nose first, 0 when tail first, between the two when hovering.
    let nose_leads = (0.5 + 0.5 * speed.0 / HOVERING).clamp(0.0, 1.0);
    let blend = |nose: f32, tail: f32| nose_leads * nose + (1.0 - nose_leads) * tail;

    let push = push_away(config, ranges);
    let lateral = blend(ahead.lateral, astern.lateral) + push.lateral;
    // Mirroring front to back turns counter-clockwise into clockwise.
    let yaw_rate = blend(ahead.yaw_rate, -astern.yaw_rate);
    NavCommand {
        forward: MetresPerSecond(speed.0 * leading.pace + push.forward),
        lateral: MetresPerSecond(lateral).limited_to(config.max_lateral),
        yaw_rate: RadiansPerSecond(yaw_rate).limited_to(config.max_yaw_rate),
        walls: leading.walls,
    }
}

/// The policy for a drone that flies nose first.
struct OneWay {
    lateral: f32,
    yaw_rate: f32,
    /// The part of the speed that is safe, 0 to 1.
    pace: f32,
    walls: Walls,
}

fn one_way(config: &NavConfig, ranges: &Diagonals) -> OneWay {
    let (c_l, c_r) = (config.lateral_gain, config.yaw_gain);
    let left = wall(config, ranges.nw, ranges.sw);
    let right = wall(config, ranges.ne, ranges.se);
    let (lateral, yaw_rate, walls) = match (left, right) {
        // Equation (17).
        (Some(l), Some(r)) => {
            (c_l * (l.front - r.front), c_r * (l.excess() - r.excess()), Walls::Both)
        }
        // Equation (18), and its mirror image.
        (Some(l), None) => (
            c_l * (l.front - config.wall_distance.0),
            2.0 * c_r * l.excess(),
            Walls::One(Side::Left),
        ),
        (None, Some(r)) => (
            c_l * (config.wall_distance.0 - r.front),
            -2.0 * c_r * r.excess(),
            Walls::One(Side::Right),
        ),
        (None, None) => (0.0, turn_to_open(config, ranges), Walls::Neither),
    };
    OneWay { lateral, yaw_rate, pace: pace(config, ranges), walls }
}

/// A side on which both beams see the same wall, in metres along the beams.
struct Wall {
    front: f32,
    rear: f32,
}

impl Wall {
    /// How much farther the wall is in front: positive when the nose points away from it.
    fn excess(&self) -> f32 {
        self.front - self.rear
    }
}

/// The 40 % ratio test.
fn wall(config: &NavConfig, front: Range, rear: Range) -> Option<Wall> {
    let (Range::At(Metres(front)), Range::At(Metres(rear))) = (front, rear) else {
        return None;
    };
    let mean = 0.5 * (front + rear);
    ((front - rear).abs() <= config.ratio * mean).then_some(Wall { front, rear })
}

/// With no wall to follow: towards the longer of the two leading beams, or the preferred side
/// where something is ahead on both.
fn turn_to_open(config: &NavConfig, ranges: &Diagonals) -> f32 {
    let length = |beam: Range| match beam {
        Range::At(d) => d.0.min(config.reach.0),
        Range::Clear | Range::Invalid => config.reach.0,
    };
    let (left, right) = (length(ranges.nw), length(ranges.ne));
    let difference = left - right;
    let blocked = left.max(right) < config.reach.0;
    if blocked && difference.abs() < 0.2 * (left + right) {
        let turn = config.max_yaw_rate.0;
        return match config.prefer {
            Side::Left => turn,
            Side::Right => -turn,
        };
    }
    2.0 * config.yaw_gain * difference
}

/// Slows down for what the leading beams see.
fn pace(config: &NavConfig, ranges: &Diagonals) -> f32 {
    let nearest = nearest(ranges.nw).min(nearest(ranges.ne));
    ((nearest - config.danger.0) / (config.slow_below.0 - config.danger.0)).clamp(0.0, 1.0)
}

fn nearest(beam: Range) -> f32 {
    match beam {
        Range::At(d) => d.0,
        Range::Clear | Range::Invalid => f32::INFINITY,
    }
}

/// A velocity away from everything inside the danger distance.
struct Push {
    forward: f32,
    lateral: f32,
}

fn push_away(config: &NavConfig, ranges: &Diagonals) -> Push {
    let push = |beam: Range| config.push_gain * (config.danger.0 - nearest(beam)).max(0.0);
    let (nw, ne, sw, se) = (push(ranges.nw), push(ranges.ne), push(ranges.sw), push(ranges.se));
    // Each beam stands at 45° to both axes.
    let along = core::f32::consts::FRAC_1_SQRT_2;
    Push { forward: along * (sw + se - nw - ne), lateral: along * (ne + se - nw - sw) }
}
