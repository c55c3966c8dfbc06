//! The centring policy: it computes velocities and a yaw rate from four ranges and a speed along
//! the tunnel.

mod aside;
mod bend;
mod detour;
mod dither;
mod home;
mod look;
mod lost;
mod one_way;
mod place;
mod slide;

use self::detour::Detour;
use self::dither::Dither;
use self::lost::Lost;
use self::one_way::OneWay;
use self::slide::Slide;
use units::{Metres, MetresPerSecond, Radians, RadiansPerSecond};

use crate::company::Company;
use crate::fork::{Ended, Fork, Guide};
use crate::gallery::{Expected, Gallery};
use crate::hits::Hits;
use crate::margin::Margin;
use crate::ranges::Bridge;
use crate::scan::Scan;
use crate::trail::{Flies, Trail};
use crate::wall::{Beams, SAME_GALLERY, Track};
use crate::{Diagonals, Range};

/// A side of the drone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Side {
    /// The left side, y > 0.
    Left,
    /// The right side, y < 0.
    Right,
}

impl Side {
    /// The other side.
    #[must_use]
    pub(crate) const fn opposite(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }
}

/// The walls that the command was made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Walls {
    /// The drone is centred between two walls.
    Both,
    /// The drone follows the wall on this side.
    One(Side),
    /// The drone follows no wall.
    Neither,
}

/// Gains and limits of the centring policy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NavConfig {
    /// The gain C_l of equations (17) and (18), in (m/s)/m. It is 2 in the authors' firmware (0.02
    /// m/s per cm), whose vehicle followed without a lag; with a lag of 0.3 s a corridor's 2√2·C_l
    /// must stay below 2.
    pub lateral_gain: f32,
    /// The gain C_r of equations (17) and (18), in (rad/s)/m.
    pub yaw_gain: f32,
    /// A side whose beams differ by more than this part of their mean has no wall: 40 % "after
    /// calibration tests" (section IV-E).
    pub ratio: f32,
    /// A wall that was lost while the other side still had one counts again after its two beams
    /// have agreed, to within half the ratio, while the drone flew this part of their length.
    pub confirm: f32,
    /// The D of equation (18): the least length of the beams at which a single wall is kept. A
    /// drone that was centred between two walls before keeps the distance that it had then, as in
    /// the authors' firmware: a drone that flies close to the outer wall of a bend sees the wall
    /// ahead too late to turn.
    pub wall_distance: Metres,
    /// The range that stands for "no obstacle" in the maths: the ranger's reach, 2 m (V-B).
    pub reach: Metres,
    /// Below this beam length the drone slows down for an obstacle ahead.
    pub slow_below: Metres,
    /// Below this beam length the drone stops and moves away from the obstacle (RANGER_DANGER_DIST
    /// of the authors' firmware).
    pub danger: Metres,
    /// The gain of this motion away from an obstacle, in (m/s)/m.
    pub push_gain: f32,
    /// The limit of the sideways velocity.
    pub max_lateral: MetresPerSecond,
    /// The limit of the yaw rate. The authors flew 30°/s at 0.2 m/s; a right angle at 0.4 m/s in a
    /// corridor of 1 m needs twice that.
    pub max_yaw_rate: RadiansPerSecond,
    /// The side to turn to when no range decides: every drone of a chain must turn to the same one.
    pub prefer: Side,
}

impl NavConfig {
    /// The constants for a Crazyflie with a multi-ranger deck in tunnels of 0.8 m and wider.
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
    /// The velocity along x: the speed that was asked for, or less where an obstacle is in the way.
    pub forward: MetresPerSecond,
    /// The velocity along y.
    pub lateral: MetresPerSecond,
    /// The yaw rate, counter-clockwise.
    pub yaw_rate: RadiansPerSecond,
    /// The walls that the command was made from.
    pub walls: Walls,
}

impl NavCommand {
    /// The command to stay over the place.
    pub const STILL: Self = Self {
        forward: MetresPerSecond::ZERO,
        lateral: MetresPerSecond::ZERO,
        yaw_rate: RadiansPerSecond(0.0),
        walls: Walls::Neither,
    };
}

/// The speed below which the drone hovers, so that neither of its ends leads, m/s.
const HOVERING: f32 = 0.05;

/// The nose is turned to the trail's heading, against the walls, when it is farther off than this,
/// rad: walls 45° apart look alike in a bend, and a heading error in a gallery stays below 20°.
const ASTRAY: f32 = 0.45;
/// The gain of this turn, in 1/s.
const TRAIL_GAIN: f32 = 1.5;
/// A drone with less than this part of its speed left stands before a wall.
const BLOCKED: f32 = 0.2;
/// The time of one iteration, s: the 5 Hz of section V-B.
const ROUND: f32 = 0.2;
/// A wall is the only one where the drone has seen none on the other side for so far, m: the way through a
/// crossing of two galleries that are 2.2 m wide is shorter.
const LONE: f32 = 2.5;
/// On the way home the path was flown long ago, and the place on it is known to within this many crumbs of
/// 0.2 m: 1.6 m, as in 25 m of flight at 3 % and past bends that were cut.
const UNSURE: i32 = 8;
/// There the walls steer, as on new ground, unless the nose is farther off all of that part of the path than
/// this, rad.
const ALLOWED: f32 = 0.5;
/// A corner is passed within this many lengths of the beams in the middle: two and a half widths.
const CORNER: f32 = 3.5;
/// A side of which one beam is shorter than this part of its usual length does not open, however
/// long the other beam is: the drone stands at an angle before a wall there.
const ASKEW: f32 = 0.5;
/// The time ahead for which the trail is read, s.
const LOOK_AHEAD: f32 = 1.5;
/// The farthest that the trail is read ahead, m.
const FARTHEST_LOOK: f32 = 0.3;
/// A wall has ended beside the drone where the front beam is longer than the rear one by more than this: the
/// ratio test, 40 % of their mean.
const ENDED: f32 = 1.5;
/// This last part of the path counts as new ground for a drone that flies on, m: it must turn where
/// the tunnel turns, and not where it stopped.
const FRONTIER: f32 = 0.4;
/// The end of the path is near within this many crumbs, 1.6 m.
const NEAR_END: i32 = 8;
/// The path this far behind leads along the gallery by which the drone came to a bend, m.
const BEFORE_BEND: f32 = 1.5;
/// Before a wall, the path this far ahead says to which side the tunnel turns, m.
const HINT: f32 = 0.4;
/// The gain, in 1/s, by which the trail holds the nose where walls decide: enough against a nose
/// that turns freely in a bend, and an eighth of what two walls do.
const HOLD_GAIN: f32 = 0.3;
/// The part of a new speed in the average speed: the average of 3 s.
const CREEP: f32 = 0.07;
/// A drone with this average speed or more flies to another place; with less it only drifts to and
/// fro, m/s.
const CREEPING: f32 = 0.02;
/// The part of its speed that a drone flies while its nose is a radian or more off the trail, and
/// while it turns away from an obstacle ahead.
const LEAST_PACE: f32 = 0.3;

/// The position of the drone by its own sensors: the distance flown, and the heading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bearings {
    /// The distance flown forward along the tunnel since take-off, by optic flow.
    pub way: Metres,
    /// The distance flown to the left since take-off, by optic flow, in the body axes of each
    /// moment.
    pub aside: Metres,
    /// The heading by gyroscope, from any origin, within half a turn; it drifts slowly, and is
    /// `None` while it is unknown.
    pub heading: Option<Radians>,
}

impl Bearings {
    /// The heading, where it is known and finite.
    pub(crate) fn known_heading(&self) -> Option<Radians> {
        self.heading.filter(|heading| heading.0.is_finite())
    }
}

/// The state of the centring policy: the walls that the drone follows, and the trail.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Navigator {
    left: Track,
    right: Track,
    /// The length of the beams when there were two walls, in metres.
    centred: f32,
    trail: Trail,
    way: Metres,
    aside: Metres,
    /// The number of iterations for which the drone has stood before a wall.
    blocked: u8,
    /// How far the trail was moved on since then, m.
    shifted: f32,
    /// The iterations for which it has stood tail first before a wall, and how much farther it
    /// flies by the heading of the gallery before, m.
    stands: u8,
    turned_early: f32,
    detour: Detour,
    bridge: Bridge,
    company: Company,
    hits: Hits,
    /// The side on which the tunnel last opened while there was a wall on the other, and the way
    /// then: the tunnel may turn there.
    opening: Option<(Side, Metres)>,
    /// The speed along the tunnel, averaged over some seconds, m/s.
    creep: f32,
    /// Whether the drone is turning back to its path, which it faced the wrong way.
    faces_back: bool,
    fork: Fork,
    scan: Scan,
    /// The farthest crumb of the path, and the iterations in which it has not grown though the drone flies
    /// nose first at its end.
    farthest: i32,
    idle: u8,
    /// The crumb at the end of the path where it has looked round …
    looked: Option<i32>,
    /// … and the iterations after which it may do so again there.
    rests: u8,
    /// Whether the drone has lost its way home.
    lost: Lost,
    /// The side to which the drone turned in a bend from where it flew back, and the crumb at which its path
    /// ended then.
    led_back: Option<(Side, i32)>,
    /// How far it has flown beside its own path, back to where it came from, m.
    returns: f32,
    /// The way flown since a wall was last seen on the left and on the right, m, forward positive.
    unseen: [f32; 2],
    slide: Slide,
    /// The side to which the gallery goes on at an end that the drone has come to.
    bends_to: Option<Side>,
    /// Whether it turns to and fro without walls at its sides.
    dither: Dither,
    /// The way at which the tunnel last opened, to any side.
    opened: Option<Metres>,
    /// How the drone keeps to the chosen side of a wide gallery.
    margin: Margin,
}

impl Navigator {
    /// The state of a drone that has seen no wall.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            left: Track::Unknown,
            right: Track::Unknown,
            centred: 0.0,
            trail: Trail::new(),
            way: Metres::ZERO,
            aside: Metres::ZERO,
            blocked: 0,
            shifted: 0.0,
            stands: 0,
            turned_early: 0.0,
            detour: Detour::new(),
            bridge: Bridge::new(),
            company: Company::new(),
            hits: Hits::new(),
            opening: None,
            creep: 0.0,
            faces_back: false,
            fork: Fork::new(),
            scan: Scan::new(),
            farthest: 0,
            idle: 0,
            looked: None,
            rests: 0,
            lost: Lost::new(),
            led_back: None,
            returns: 0.0,
            unseen: [0.0; 2],
            slide: Slide::new(),
            bends_to: None,
            dither: Dither::new(),
            opened: None,
            margin: Margin::new(),
        }
    }

    /// Makes this navigator what [`Self::new`] returns, in its place: the path alone would take 3.6 kB of the
    /// stack.
    pub fn renew(&mut self) {
        let Self {
            left,
            right,
            centred,
            trail,
            way,
            aside,
            blocked,
            shifted,
            stands,
            turned_early,
            detour,
            bridge,
            company,
            hits,
            opening,
            creep,
            faces_back,
            fork,
            scan,
            farthest,
            idle,
            looked,
            rests,
            lost,
            led_back,
            returns,
            unseen,
            slide,
            bends_to,
            dither,
            opened,
            margin,
        } = self;
        trail.renew();
        *left = Track::Unknown;
        *right = Track::Unknown;
        *centred = 0.0;
        *way = Metres::ZERO;
        *aside = Metres::ZERO;
        *blocked = 0;
        *shifted = 0.0;
        *stands = 0;
        *turned_early = 0.0;
        *detour = Detour::new();
        *bridge = Bridge::new();
        *company = Company::new();
        *hits = Hits::new();
        *opening = None;
        *creep = 0.0;
        *faces_back = false;
        *fork = Fork::new();
        *scan = Scan::new();
        *farthest = 0;
        *idle = 0;
        *looked = None;
        *rests = 0;
        *lost = Lost::new();
        *led_back = None;
        *returns = 0.0;
        *unseen = [0.0; 2];
        *slide = Slide::new();
        *bends_to = None;
        *dither = Dither::new();
        *opened = None;
        *margin = Margin::new();
    }

    /// Notes how the drone is guided at the junctions that come.
    pub fn guide(&mut self, guide: Guide) {
        let is_back = self.fork.follow(guide) && self.trail.forget_from(0.0);
        if let Some(from) = guide.changed_from {
            let is_known = self.trail.forget_from((from - self.way).0.max(0.0));
            if from <= self.way && (is_known || is_back) {
                self.forget_walls();
            }
        }
    }

    /// Looks at the walls anew: what the drone saw of them on its way back is no longer ahead.
    fn forget_walls(&mut self) {
        (self.left, self.right, self.opening) = (Track::Unknown, Track::Unknown, None);
        self.fork.forget_corners();
        let Some(side) = self.fork.side() else { return };
        let latest = self.bridge.latest();
        // It may have come back along the wall on the other side, from where it does not see the one
        // that leads into the branch.
        let sees = |side: Side| Margin::beams(latest, side).is_nearer(Margin::KEPT);
        if sees(side.opposite()) && !sees(side) {
            self.margin.cross();
        }
        // It may be beside the branch, into which its front beam looks: the wall there will not end once more.
        let (front, rear) = latest.beams(side);
        if let Some(length) = rear.length().filter(|rear| nearest(front) > ENDED * rear) {
            let is_wide = self.margin.is_wide();
            self.fork.see_ended(Ended { side, length, is_wide, is_lone: false });
        }
    }

    /// The way at which the tunnel last opened to a side: at a junction, and in a bend.
    #[must_use]
    pub const fn opened(&self) -> Option<Metres> {
        self.opened
    }

    /// Carries out one iteration and returns the command with which a drone at `bearings`, with
    /// these ranges, flies along the tunnel at `speed` (negative for backward flight).
    // A part of its own in the program: within the agent's step it takes 400 B more.
    #[inline(never)]
    pub fn step(
        &mut self,
        config: &NavConfig,
        ranges: &Diagonals,
        speed: MetresPerSecond,
        bearings: &Bearings,
    ) -> NavCommand {
        let seen = self.bridge.fill(ranges);
        let moved = [bearings.way - self.way, bearings.aside - self.aside];
        let ranges = &self.company.without(&seen, self.fork.has_company(), moved);
        self.hits.advance(moved, bearings.heading, ranges);
        let ranges = &self.keep_aside(ranges, moved[0]);
        (self.way, self.aside) = (bearings.way, bearings.aside);
        self.fork.advance(moved, bearings.heading);
        self.look(config, ranges, moved[0]);
        let gallery = self.find_place(ranges, bearings, moved, speed);
        // A drone that turns on the spot is where its path ends, whichever way its nose points.
        let off = if self.scan.is_on() { None } else { self.off_trail(ranges, bearings, speed) };
        self.note_bend(ranges);
        let mut ahead = self.one_way(config, ranges, self.trail.off(HINT).0);
        if speed.0 > HOVERING {
            self.end_dither(config, ranges, &mut ahead);
        }
        let astern = self.one_way(config, &ranges.seen_backwards(), -self.trail.off(-HINT).0);
        let leading = if speed.0 < 0.0 { &astern } else { &ahead };
        let off = self.off_home(leading.walls, off, bearings, speed).or(off);
        self.pass_corner(off.is_some() && leading.nearness < BLOCKED, speed);
        self.undo_turn(leading.nearness < BLOCKED, speed, moved[0]);

        // 1 when flying nose first, 0 when tail first, between the two when hovering.
        let nose_leads = (0.5 + 0.5 * speed.0 / HOVERING).clamp(0.0, 1.0);
        let blend = |nose: f32, tail: f32| nose_leads * nose + (1.0 - nose_leads) * tail;
        // Only in a straight gallery are walls a better guide than the trail.
        let is_straight = gallery.is_some_and(|gallery| gallery.whole) && !self.trail.bends();
        let (lateral, yaw_rate, pace) = match off {
            Some(off) if !is_straight || off.abs() > ASTRAY => {
                let pace = leading.nearness * (1.0 - off.abs()).max(LEAST_PACE);
                let sidestep = blend(ahead.sidestep, astern.sidestep);
                let along_wall = blend(ahead.lateral, astern.lateral);
                let (lateral, most) = self.keep_to_path(config, ranges, [sidestep, along_wall]);
                (lateral, TRAIL_GAIN * off, pace.min(most))
            }
            // A drone that stands before a wall there has not flown round the corner, or through.
            None if leading.nearness >= BLOCKED
                && let Some(turning) = self.fork.turning(ranges, speed.0) =>
            {
                let most = turning.fastest / speed.0.abs().max(turning.fastest);
                // Beside the drone may be the wall before the corner, or the next one.
                let side = if turning.lateral > 0.0 { Side::Left } else { Side::Right };
                let lateral = room_beside(config, ranges, side) * turning.lateral;
                (lateral, turning.yaw_rate, leading.nearness.min(most))
            }
            _ => {
                let most = self.margin.pace(speed.0, [self.left, self.right]);
                // Mirroring front to back turns counter-clockwise into clockwise.
                let yaw_rate = blend(ahead.yaw_rate, -astern.yaw_rate);
                let hold = HOLD_GAIN * off.unwrap_or(0.0);
                (blend(ahead.lateral, astern.lateral), yaw_rate + hold, leading.pace.min(most))
            }
        };
        let pace = if self.company.is_ahead(speed.0) { 0.0 } else { pace };
        let yaw_rate = yaw_rate + self.slide_turn(moved, speed, leading);
        let (lateral, yaw_rate) =
            match off.and_then(|off| self.go_round(ranges, leading, speed, off)) {
                Some(detour) => detour,
                None => (lateral, yaw_rate),
            };
        let on = self.look_round(ranges, leading.nearness, off, bearings, speed);
        let home = self.look_for_home(ranges, bearings, speed);
        let (lateral, yaw_rate, pace) = match home.or(on) {
            Some(yaw_rate) => (0.0, yaw_rate, 0.0),
            None => (lateral, yaw_rate, pace),
        };
        let push = push_away(config, &seen);
        let lateral = MetresPerSecond(lateral + push.lateral).limited_to(config.max_lateral);
        let [forward, lateral] = self.hits.keep_clear([speed.0 * pace + push.forward, lateral.0]);
        NavCommand {
            forward: MetresPerSecond(forward),
            lateral: MetresPerSecond(lateral).limited_to(config.max_lateral),
            yaw_rate: RadiansPerSecond(yaw_rate).limited_to(config.max_yaw_rate),
            walls: leading.walls,
        }
    }

    /// Updates the place on the trail, and returns the straight gallery that the beams see, if they
    /// do.
    fn find_place(
        &mut self,
        ranges: &Diagonals,
        bearings: &Bearings,
        moved: [Metres; 2],
        speed: MetresPerSecond,
    ) -> Option<Gallery> {
        let heading = bearings.known_heading()?;
        self.trail.advance(moved.map(|way| way.0), heading, self.flies(speed));
        let by_two = || {
            let walls = [self.left.is_seen(), self.right.is_seen()];
            let expected = Expected { aside: self.trail.aside(), walls };
            self.trail.is_straight().then(|| Gallery::by_two(ranges, self.centred, expected))?
        };
        let gallery = Gallery::by_all(ranges, self.centred).or_else(by_two)?;
        if !self.margin.is_kept() || self.is_along_wall() {
            self.trail.correct(gallery.skew, gallery.offset);
        }
        Some(gallery)
    }

    /// Whether the drone has flown for a while in the direction of its speed of the moment.
    fn goes_on(&self, speed: MetresPerSecond) -> bool {
        self.creep * speed.0 > 0.0 && self.creep.abs() > CREEPING
    }

    /// Whether the drone flies home, and else which of its ends leads, by the speed of the moment if the drone
    /// has flown so for a while.
    fn flies(&self, speed: MetresPerSecond) -> Flies {
        if self.fork.is_homing() {
            // It keeps its path, too, while it waits for another drone.
            return Flies::Home;
        }
        match self.goes_on(speed) {
            true if speed.0 > 0.0 => Flies::NoseFirst,
            true => Flies::TailFirst,
            false => Flies::Hovering,
        }
    }

    /// The angle by which the nose is off the trail, in radians; `None` on new ground.
    fn off_trail(
        &mut self,
        ranges: &Diagonals,
        bearings: &Bearings,
        speed: MetresPerSecond,
    ) -> Option<f32> {
        bearings.known_heading()?;
        self.creep += CREEP * (speed.0 - self.creep);
        let creeps = self.goes_on(speed);
        let ahead = (LOOK_AHEAD * speed.0).clamp(-FARTHEST_LOOK, FARTHEST_LOOK);
        let flies_on = creeps || speed.0.abs() > HOVERING;
        self.heed_return(ranges, speed);
        let knows = self.trail.knows(ahead + FRONTIER * speed.0.signum());
        self.faces_back &= self.trail.off(0.0).0.abs() > ASTRAY;
        if flies_on && !knows && !self.faces_back {
            if self.trail.turn(speed.0 > 0.0, creeps) {
                return None;
            }
            self.faces_back = true;
        }
        if speed.0 < -HOVERING && self.turned_early > 0.0 {
            return Some(self.trail.off(ahead).0);
        }
        // At a junction the walls would lead into the other branch.
        if speed.0 < -HOVERING && self.trail.is_old() && !self.fork.is_chosen() {
            let off = self.trail.off_any(UNSURE);
            return (off.0.abs() > ALLOWED).then_some(off.0);
        }
        Some(self.trail.off(ahead).0)
    }

    /// The sideways velocity and the yaw rate of a drone that has stood before an obstacle for a while on
    /// ground that it knows, its nose `off` the trail.
    fn go_round(
        &mut self,
        ranges: &Diagonals,
        leading: &OneWay,
        speed: MetresPerSecond,
        off: f32,
    ) -> Option<(f32, f32)> {
        if speed.0.abs() <= HOVERING {
            self.detour = Detour::new();
            return None;
        }
        // The leading beams see the obstacle, the others the room beside the drone.
        let trailing = if speed.0 < 0.0 { [ranges.nw, ranges.ne] } else { [ranges.sw, ranges.se] };
        let room = trailing.map(nearest);
        let off_path = self.trail.aside();
        let lateral = self.detour.step(leading.nearness, self.aside.0, off_path, room)?;
        Some((lateral, TRAIL_GAIN * off))
    }

    /// Updates the walls of both sides.
    fn look(&mut self, config: &NavConfig, ranges: &Diagonals, moved: Metres) {
        let (left, right) = (Beams::new(ranges.nw, ranges.sw), Beams::new(ranges.ne, ranges.se));
        let before = [self.left, self.right];
        self.left = before[0].next(config, left, moved, before[1].is_seen(), self.centred);
        self.right = before[1].next(config, right, moved, before[0].is_seen(), self.centred);
        match (self.left, self.right) {
            (Track::Seen { length: left }, Track::Seen { length: right }) => {
                self.centred = 0.5 * (left + right);
            }
            // There were never two walls yet: keep the distance to the one.
            (Track::Seen { length }, _) | (_, Track::Seen { length }) if self.centred == 0.0 => {
                self.centred = length;
            }
            _ => {}
        }
        for (unseen, now) in self.unseen.iter_mut().zip([self.left, self.right]) {
            *unseen = if now.is_seen() { 0.0 } else { *unseen + moved.0 };
        }
        self.note_opening(config, before, [left, right]);
        self.note_ends(before, [left, right], ranges);
    }

    /// Whether a wall on this side is the only one that the drone sees, and has been so for a while.
    fn is_lone(&self, side: Side) -> bool {
        let [left, right] = self.unseen;
        let other = if side == Side::Left { right } else { left };
        other.abs() > LONE
    }

    /// Notes to which side the tunnel opens while there is a wall on the other, or where the only wall ends,
    /// and forgets where it opened once that is far away.
    fn note_opening(&mut self, config: &NavConfig, before: [Track; 2], beams: [Beams; 2]) {
        let opens = |side: Side, before: Track, now: Track, beams: Beams, other: Track| {
            let is_new = now.is_lost() && !before.is_lost();
            // Round the corner of a chosen branch the wall that is found is that of the branch.
            let is_only = self.is_lone(side) && self.fork.side().is_none();
            let is_askew = beams.is_nearer(ASKEW * self.centred);
            let is_open = !is_askew && beams.opens(SAME_GALLERY * self.centred);
            is_new && (other.is_seen() || is_only) && is_open
        };
        if opens(Side::Left, before[0], self.left, beams[0], self.right) {
            self.opening = Some((Side::Left, self.way));
        } else if opens(Side::Right, before[1], self.right, beams[1], self.left) {
            self.opening = Some((Side::Right, self.way));
        } else if let Some((side, way)) = self.opening {
            // Where the drone saw one wall alone, the gallery may be as wide as the beams reach.
            let usual = if self.is_lone(side) { config.reach.0 } else { self.centred };
            self.opening = self.opening.filter(|_| (self.way - way).0.abs() <= CORNER * usual);
        }
    }

    /// Notes where walls have ended, for the branch that the pilot has chosen, and for bends at which the
    /// only wall ends.
    fn note_ends(&mut self, before: [Track; 2], beams: [Beams; 2], ranges: &Diagonals) {
        if let Some(side) = self.fork.find_wall(ranges) {
            // The drone is in the branch, whose walls are the tunnel's now.
            self.opening = None;
            let (track, beams) = match side {
                Side::Left => (&mut self.left, beams[0]),
                Side::Right => (&mut self.right, beams[1]),
            };
            *track = track.found(beams);
            // The branch may be narrower: the drone keeps its distance until it sees both walls.
            if let Track::Seen { length } = *track {
                self.centred = length;
            }
        }
        let sides = [(Side::Left, self.left), (Side::Right, self.right)];
        for ((before, (side, now)), beams) in before.into_iter().zip(sides).zip(beams) {
            if let Track::Seen { length } = before
                && now.is_lost()
                && self.margin.counts(side)
                && beams.opens(SAME_GALLERY * self.centred)
            {
                self.opened = Some(self.way);
                let (is_wide, is_lone) = (self.margin.is_wide(), self.is_lone(side));
                self.fork.see_end(Ended { side, length, is_wide, is_lone }, ranges);
            }
        }
    }
}

/// The part of a sideways velocity that is safe beside the obstacles on this side.
fn room_beside(config: &NavConfig, ranges: &Diagonals, side: Side) -> f32 {
    let (front, rear) = ranges.beams(side);
    let nearest = nearest(front).min(nearest(rear));
    ((nearest - config.danger.0) / (config.slow_below.0 - config.danger.0)).clamp(0.0, 1.0)
}

fn nearest(beam: Range) -> f32 {
    beam.length().unwrap_or(f32::INFINITY)
}

/// The velocity away from every obstacle within the danger distance.
pub(crate) struct Push {
    pub(crate) forward: f32,
    pub(crate) lateral: f32,
}

pub(crate) fn push_away(config: &NavConfig, ranges: &Diagonals) -> Push {
    let push = |beam: Range| config.push_gain * (config.danger.0 - nearest(beam)).max(0.0);
    let (nw, ne, sw, se) = (push(ranges.nw), push(ranges.ne), push(ranges.sw), push(ranges.se));
    // Each beam stands at 45° to both axes.
    let along = core::f32::consts::FRAC_1_SQRT_2;
    Push { forward: along * (sw + se - nw - ne), lateral: along * (ne + se - nw - sw) }
}
