//! From four ranges and a speed along the tunnel to a command for the body.

use units::{Metres, MetresPerSecond, Radians, RadiansPerSecond};

use crate::trail::Trail;
use crate::wall::{Beams, Track};
use crate::{Diagonals, Range};

/// Left or right of the drone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Side {
    /// y > 0.
    Left,
    /// y < 0.
    Right,
}

/// Which walls the command was made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    /// A side whose beams differ by more than this part of their mean has no wall: 40 % "after
    /// calibration tests" (section IV-E).
    pub ratio: f32,
    /// A wall that was lost beside another is believed again after its beams have agreed, to
    /// within half the ratio, over this part of their length of way.
    pub confirm: f32,
    /// D of equation (18), the least of it: how far along its beam a single wall is kept. Where
    /// the drone was centred between two walls before, it keeps the distance that it had then, as
    /// the authors' firmware does: a drone that hugs the outer wall of a bend sees the wall ahead
    /// too late to turn.
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
        confirm: 0.5,
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

/// The nose is turned to where the trail says, against the walls, when it is farther off than
/// this: walls 45° apart look alike in a bend, a heading error in a gallery stays below 20°.
const ASTRAY: f32 = 0.45;
/// How fast, in 1/s.
const TRAIL_GAIN: f32 = 1.5;
/// Less than this part of its speed is left to a drone that stands before a wall.
const BLOCKED: f32 = 0.2;
/// One iteration, s: the 5 Hz of section V-B.
const ROUND: f32 = 0.2;
/// A wall that is passed in so many iterations was a corner.
const PATIENCE: u8 = 5;
/// The most that trail and odometer are apart, m: four right angles make 1.5.
const MOST_SLIP: f32 = 2.0;
/// While its nose is a radian or more off the trail, and while it turns away from what is ahead,
/// a drone flies only this part of its speed.
const LEAST_PACE: f32 = 0.3;

/// Where the drone is by its own sensors: how far it has come, and where its nose points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bearings {
    /// Way along the tunnel since take-off, by optic flow.
    pub way: Metres,
    /// Heading by gyro, from any origin, within half a turn, drifting slowly; `None` while there
    /// is none.
    pub heading: Option<Radians>,
}

/// The centring policy with what it remembers: which walls it has, and the trail.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Navigator {
    left: Track,
    right: Track,
    /// The length of the beams when there were two walls, in metres.
    centred: f32,
    trail: Trail,
    way: Metres,
    /// How far the trail is ahead of the odometer: a way flown round a bend is not as long out as
    /// back, and a drone that stands before a wall on a known way is already at the bend.
    slip: Metres,
    /// For how many iterations it has stood so.
    blocked: u8,
}

impl Navigator {
    /// A drone that has seen nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            left: Track::Unknown,
            right: Track::Unknown,
            centred: 0.0,
            trail: Trail::new(),
            way: Metres::ZERO,
            slip: Metres::ZERO,
            blocked: 0,
        }
    }

    /// One iteration: what to fly, to go along the tunnel at `speed` (negative: tail first) with
    /// these ranges, being there.
    pub fn step(
        &mut self,
        config: &NavConfig,
        ranges: &Diagonals,
        speed: MetresPerSecond,
        bearings: &Bearings,
    ) -> NavCommand {
        let moved = bearings.way - self.way;
        self.way = bearings.way;
        self.look(config, ranges, moved);
        let bearings = &Bearings { way: bearings.way + self.slip, ..*bearings };
        let off = self.off_trail(bearings, speed);
        let ahead = self.one_way(config, ranges);
        let astern = self.one_way(config, &ranges.seen_backwards());
        let leading = if speed.0 < 0.0 { &astern } else { &ahead };
        if off.is_some() && leading.nearness < BLOCKED {
            self.blocked = self.blocked.saturating_add(1);
        } else {
            self.blocked = 0;
        }
        if self.blocked > PATIENCE {
            let slip = self.slip.0 + speed.0 * ROUND;
            self.slip = Metres(slip.clamp(-MOST_SLIP, MOST_SLIP));
        }

        // 1 when flying nose first, 0 when tail first, between the two when hovering.
        let nose_leads = (0.5 + 0.5 * speed.0 / HOVERING).clamp(0.0, 1.0);
        let blend = |nose: f32, tail: f32| nose_leads * nose + (1.0 - nose_leads) * tail;

        let push = push_away(config, ranges);
        let mut lateral = blend(ahead.lateral, astern.lateral) + push.lateral;
        // Without walls the way is found by the trail alone, and what is ahead is passed: turning
        // away from it would lead off the trail, and that back to it, for ever.
        let by_trail = off.filter(|off| off.abs() > ASTRAY || leading.walls == Walls::Neither);
        // Mirroring front to back turns counter-clockwise into clockwise.
        let (yaw_rate, pace) = match by_trail {
            Some(off) => {
                if leading.walls == Walls::Neither {
                    lateral += leading.sidestep;
                }
                (TRAIL_GAIN * off, leading.nearness * (1.0 - off.abs()).max(LEAST_PACE))
            }
            None => (blend(ahead.yaw_rate, -astern.yaw_rate), leading.pace),
        };
        NavCommand {
            forward: MetresPerSecond(speed.0 * pace + push.forward),
            lateral: MetresPerSecond(lateral).limited_to(config.max_lateral),
            yaw_rate: RadiansPerSecond(yaw_rate).limited_to(config.max_yaw_rate),
            walls: leading.walls,
        }
    }

    /// How far the nose of a drone on its way somewhere is off the trail, in radians, where there
    /// is one.
    fn off_trail(&mut self, bearings: &Bearings, speed: MetresPerSecond) -> Option<f32> {
        let heading = bearings.heading.filter(|heading| heading.0.is_finite())?;
        let by_walls = self.left.is_seen() || self.right.is_seen();
        self.trail.record(bearings.way, heading, by_walls);
        let off = self.trail.off(bearings.way, speed.0 >= 0.0, heading)?;
        (speed.0.abs() > HOVERING).then_some(off.0)
    }

    /// Which walls there are now.
    fn look(&mut self, config: &NavConfig, ranges: &Diagonals, moved: Metres) {
        let (left, right) = (Beams::new(ranges.nw, ranges.sw), Beams::new(ranges.ne, ranges.se));
        let (had_left, had_right) = (self.left.is_seen(), self.right.is_seen());
        self.left = self.left.next(config, left, moved, had_right, self.centred);
        self.right = self.right.next(config, right, moved, had_left, self.centred);
        match (self.left, self.right) {
            (Track::Seen { length: left }, Track::Seen { length: right }) => {
                self.centred = 0.5 * (left + right);
            }
            // Never between two walls yet: keep to where the one is.
            (Track::Seen { length }, _) | (_, Track::Seen { length }) if self.centred == 0.0 => {
                self.centred = length;
            }
            _ => {}
        }
    }

    fn one_way(&self, config: &NavConfig, ranges: &Diagonals) -> OneWay {
        let (c_l, c_r) = (config.lateral_gain, config.yaw_gain);
        let left = self.left.wall(Beams::new(ranges.nw, ranges.sw));
        let right = self.right.wall(Beams::new(ranges.ne, ranges.se));
        let keep = self.centred.max(config.wall_distance.0).min(WIDEST * config.reach.0);
        // What the beam over the lost wall sees nearer than the wall that is kept is ahead.
        let ahead = |beam: Range| c_r * (keep - nearest(beam)).max(0.0);
        let (lateral, yaw_rate, walls) = match (left, right) {
            // Equation (17).
            (Some(l), Some(r)) => {
                (c_l * (l.front - r.front), c_r * (l.excess() - r.excess()), Walls::Both)
            }
            // Equation (18), and its mirror image.
            (Some(l), None) => {
                let yaw_rate = 2.0 * c_r * l.excess() - ahead(ranges.ne);
                (c_l * (l.front - keep), yaw_rate, Walls::One(Side::Left))
            }
            (None, Some(r)) => {
                let yaw_rate = -2.0 * c_r * r.excess() + ahead(ranges.nw);
                (c_l * (keep - r.front), yaw_rate, Walls::One(Side::Right))
            }
            (None, None) => (0.0, turn_to_open(config, ranges), Walls::Neither),
        };
        let turns_away = walls == Walls::Neither && yaw_rate != 0.0;
        let most = if turns_away { LEAST_PACE } else { 1.0 };
        let nearness = pace(config, ranges);
        let within = |beam: Range| nearest(beam).min(keep);
        OneWay {
            lateral,
            yaw_rate,
            sidestep: c_l * (within(ranges.nw) - within(ranges.ne)),
            nearness,
            pace: nearness.min(most),
            walls,
        }
    }
}

/// The policy for a drone that flies nose first.
struct OneWay {
    lateral: f32,
    yaw_rate: f32,
    /// The sideways velocity that passes what the leading beams see.
    sidestep: f32,
    /// The part of the speed that is safe for what they see, 0 to 1,
    nearness: f32,
    /// and for a drone that turns away from it.
    pace: f32,
    walls: Walls,
}

/// With no wall to follow and something ahead: towards the longer of the two leading beams, or
/// the preferred side where they are alike.
fn turn_to_open(config: &NavConfig, ranges: &Diagonals) -> f32 {
    let length = |beam: Range| nearest(beam).min(config.reach.0);
    let (left, right) = (length(ranges.nw), length(ranges.ne));
    if left.min(right) > TURN_BELOW * config.wall_distance.0 {
        return 0.0;
    }
    let turn = config.max_yaw_rate.0;
    let to_left = if (left - right).abs() < 0.1 * (left + right) {
        config.prefer == Side::Left
    } else {
        left > right
    };
    if to_left { turn } else { -turn }
}

/// With no wall at its side a drone turns away from what is ahead nearer than this many times the
/// distance at which it would follow it.
const TURN_BELOW: f32 = 1.6;

/// A single wall is kept no farther than this part of what the ranger sees.
const WIDEST: f32 = 0.6;

/// Slows down for what the leading beams see.
fn pace(config: &NavConfig, ranges: &Diagonals) -> f32 {
    if (ranges.nw, ranges.ne) == (Range::Invalid, Range::Invalid) {
        // It flies nowhere blind.
        return 0.0;
    }
    let nearest = nearest(ranges.nw).min(nearest(ranges.ne));
    ((nearest - config.danger.0) / (config.slow_below.0 - config.danger.0)).clamp(0.0, 1.0)
}

fn nearest(beam: Range) -> f32 {
    beam.length().unwrap_or(f32::INFINITY)
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
