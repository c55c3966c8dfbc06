//! Finds a spot on the floor for a drone that is to land for good: beside a wall, on even floor, and
//! not in the mouth of a side gallery.
//!
//! A drone on the ground is in the way of the next one, and where it tips over as it lands it may not
//! take off again. The search has the phases of a robot that drops a relay (T. Stegun Vaquero et al.,
//! i-SAIRAS 2020, sections 3.1 and 3.3), as far as they suit a drone that knows no map: it *goes* to
//! the nearer wall, *gathers* what the rangers tell of walls and floor while it flies along that wall,
//! first ahead and then back, and flies to the place at which to *drop*.
//!
//! ```text
//!   ═══════════════╗     ╔═══════════════   A spot: both beams of one side see a wall within 0.5 m,
//!     ←── ↑ ──→    ║     ║                  those of the other side leave a width to pass, and the
//!         │                                 height over ground stays the same over a stretch of the
//!   ══════╧═══════════════════════════════  way. A mouth may lie on the other side.
//! ```
//!
//! Where obstacles end the way in both directions and nothing on it was beside a wall, the nose is across
//! the gallery: it turns by a quarter, once, and the search begins anew.
//!
//! Where the whole way has no such place, the search ends at one that is beside the wall and lacks
//! the width or the even floor; where there is no wall either, where it began. Of places at which a
//! link is too weak, the one is kept at which the weaker link was strongest.
//!
//! A drone lands only where its links bear it. One that has come to its place, or as near to it as an
//! obstacle lets it come, and may not land looks on from there, towards the neighbour to which its link is
//! weaker: so two drones of which each has gone too far from the other come towards each other, and
//! neither waits for the other. The search is bounded in way and time, and turns round where the link to
//! the drone that it leaves gets too weak.

mod look;
mod place;

use core::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

use units::{
    Db, Duration, Instant, Metres, MetresPerSecond, Point2, Pose2, Radians, RadiansPerSecond,
};

use crate::steer::push_away;
use crate::{Diagonals, NavCommand, NavConfig, Range, Side, Walls};
use look::{Seen, leading, look, nearer_wall};
use place::{Kind, Spare, Stretch};

/// The constants of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotConfig {
    /// The speed along the wall and towards it. Our own number: at 5 Hz the floor is read every 3 cm.
    pub speed: MetresPerSecond,
    /// The distance from the wall that the drone keeps. Our own number: a Crazyflie with guards is
    /// 0.16 m wide.
    pub wall: Metres,
    /// Up to this distance from the wall a place is beside it: 0.5 m in the paper.
    pub beside: Metres,
    /// The free width that is to be left, as the beams measure it: 1 m, as for planned drops
    /// (`relay_placement::Demand`), less the 17 % by which a ranger with a cone of 27° reads a wall too
    /// near that it looks at from 45°.
    pub free_width: Metres,
    /// The farthest that the drone flies along the wall, to either side. Our own number: a link in a
    /// gallery loses some decibels over it.
    pub most_way: Metres,
    /// The floor is to be even over this length of the way. Our own number: four times the distance
    /// between the motors of a Crazyflie.
    pub stretch: Metres,
    /// Over it the readings of the height differ by less than this. Our own number: with one leg so
    /// much higher than the others a Crazyflie stands at an angle of 18°.
    pub unevenness: Metres,
    /// The drone looks for so long at most, and then flies to the best place so far.
    pub gathering: Duration,
    /// After so long the search ends where the drone is: gathering, and the way of twice
    /// [`SpotConfig::most_way`] at [`SpotConfig::speed`]. Whether the drone lands there is the caller's
    /// to decide.
    pub most_time: Duration,
}

impl SpotConfig {
    /// The constants for a Crazyflie in galleries of 0.8 m and wider.
    pub const DEFAULT: Self = Self {
        speed: MetresPerSecond(0.15),
        wall: Metres(0.35),
        beside: Metres(0.5),
        free_width: Metres(0.85),
        most_way: Metres(1.5),
        stretch: Metres(0.4),
        unevenness: Metres(0.03),
        gathering: Duration::from_secs(45),
        most_time: Duration::from_secs(70),
    };

    /// The length of a beam at the wall that the drone keeps to.
    fn beam(&self) -> f32 {
        self.wall.0 / FRAC_1_SQRT_2
    }
}

impl Default for SpotConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What a drone that looks for a spot senses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotView {
    /// The ranges of the side beams.
    pub ranges: Diagonals,
    /// The height over ground; `None` while it is not measured.
    pub height: Option<Metres>,
    /// The way along the tunnel since take-off.
    pub way: Metres,
    /// The pose by the drone's own reckoning, from any origin.
    pub pose: Pose2,
    /// By how much the links to the drones in front and behind are stronger than they have to be for
    /// a place to be taken; `None` for a link that the drone does not need.
    pub over: [Option<Db>; 2],
    /// Whether the drone may land here by its links.
    pub may_land: bool,
    /// Whether the drone in front, and the one behind, leave room to come nearer.
    pub has_room: [bool; 2],
}

impl SpotView {
    /// By how much the weaker of the two links is stronger than it has to be, dB.
    fn weaker(&self) -> f32 {
        let [front, back] = self.over.map(strength);
        front.min(back)
    }

    /// Whether both links are strong enough for a place to be taken.
    fn is_linked(&self) -> bool {
        self.weaker() >= 0.0
    }

    /// The direction towards the neighbour to which the link is weaker.
    fn towards_weaker(&self) -> Direction {
        let [front, back] = self.over.map(strength);
        if back < front { Direction::Behind } else { Direction::Ahead }
    }

    /// Whether the link to the drone that is left in this direction is the weaker one, and too weak.
    fn is_strained(&self, direction: Direction) -> bool {
        !self.is_linked() && self.towards_weaker() != direction
    }
}

/// The number of a link's strength: that of a link which is not needed is beyond all others, and one
/// that is no number is below.
fn strength(over: Option<Db>) -> f32 {
    over.map_or(f32::INFINITY, |over| if over.0.is_nan() { f32::NEG_INFINITY } else { over.0 })
}

/// A direction along the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Direction {
    Ahead,
    Behind,
}

impl Direction {
    /// The sign of the way.
    const fn sign(self) -> f32 {
        match self {
            Self::Ahead => 1.0,
            Self::Behind => -1.0,
        }
    }

    const fn opposite(self) -> Self {
        match self {
            Self::Ahead => Self::Behind,
            Self::Behind => Self::Ahead,
        }
    }
}

/// What the drone is doing.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Stage {
    /// The drone looks along the wall; first of all it goes there.
    Looking {
        direction: Direction,
        /// From where on a link that gets too weak ends the leg.
        from: Metres,
        /// Whether the drone has looked in the other direction before.
        is_second: bool,
    },
    /// The drone flies to the place at which it lands.
    Dropping {
        /// Its way since take-off.
        to: Metres,
        /// When the drone came there, and might not land.
        waits_since: Option<Instant>,
    },
}

/// A search that is under way.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SpotSearch {
    since: Instant,
    /// The way at which it began.
    from: Metres,
    /// The pose in which it began.
    begun: Pose2,
    /// By how much the gallery turns to the left of that, to which the nose is held.
    turn: Radians,
    /// The wall to land at, once one is seen.
    edge: Option<Edge>,
    /// The ways at which the left and the right side last turned out to be mouths.
    open: [Option<Metres>; 2],
    /// Whether the nose was turned by a quarter, because it was across the gallery.
    is_turned: bool,
    stage: Stage,
    /// The way since which the drone has been beside the wall.
    beside_since: Option<Metres>,
    stretch: Option<Stretch>,
    spare: Option<Spare>,
}

/// The wall to land at. In the middle of a mouth both beams end at its sides, and look as if they saw
/// a wall ahead of them, which goes away as the drone comes nearer; so its place is noted.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Edge {
    side: Side,
    /// The distance of the wall from the line on which the search began.
    off: Metres,
    /// The way at which that was measured.
    way: Metres,
    /// Whether the drone has come to the wall.
    is_reached: bool,
    /// By how much the drone has moved away from it, to pass corners.
    passed: Metres,
}

/// A drone that has come to its place and may not land waits so long for its links: their filters
/// follow within a second, and its neighbour may be about to stop as well.
const PATIENCE: Duration = Duration::from_secs(2);
/// The drone is at its place when it is nearer than this along the way, m: a round and a half of
/// flight.
const NEAR: f32 = 0.05;
/// The drone is at the wall when its distance from it is off by less than this, m: the rest of
/// [`SpotConfig::beside`] over [`SpotConfig::wall`].
const AT_WALL: f32 = 0.15;
/// A wall that is farther off than it was by more than this is the inside of a mouth, m.
const GONE: f32 = 0.1;
/// The way by which the line is moved in a round, m: that of the drone at its speed.
const STEP: Metres = Metres(0.03);
/// What looked like a wall from the middle of a mouth is none over this way, m.
const MOUTH: f32 = 0.4;
/// The most by which a wall goes aside over a metre of the way, m, and by which it turns, rad: it
/// comes to 20° within the way that the drone looks at.
const BEND: f32 = 0.4;
/// The most that the nose is turned, rad: a heading error in a gallery stays below 20°.
const MOST_TURN: f32 = 0.35;
/// A wall that is turned to the way by more than this is no place to land at, rad: its beams differ by
/// a fifth, half of the ratio test.
const ALONG: f32 = 0.1;
/// A leading beam shorter than this part of its length at the wall sees an obstacle ahead.
const AHEAD: f32 = 0.75;
/// The gain of the distance from the wall, and that of the angle to it, 1/s: below the bandwidth of
/// a velocity loop with a lag of 0.3 s.
const GAIN: f32 = 1.0;

impl SpotSearch {
    /// A search that begins at this moment, way and pose.
    #[must_use]
    pub const fn begin(now: Instant, way: Metres, pose: Pose2) -> Self {
        Self {
            since: now,
            from: way,
            begun: pose,
            turn: Radians::ZERO,
            edge: None,
            open: [None; 2],
            is_turned: false,
            stage: Stage::Looking { direction: Direction::Ahead, from: way, is_second: false },
            beside_since: None,
            stretch: None,
            spare: None,
        }
    }

    /// Returns the search after another round; `None` where the drone is to land.
    #[must_use]
    pub fn step(mut self, config: &SpotConfig, now: Instant, view: &SpotView) -> Option<Self> {
        let elapsed = now.since(self.since);
        if elapsed >= config.most_time {
            return None;
        }
        if self.is_turning(view) {
            return Some(self);
        }
        if self.spare.is_none() {
            self.offer(Spare { way: view.way, kind: Kind::Open, weaker: view.weaker() });
        }
        self.find_edge(view);
        let wall = self.wall(view);
        let is_away = self.is_away(config, view);
        if let (Seen::Wall { skew, distance }, Some(edge)) = (wall, self.edge) {
            let is_reached = edge.is_reached || !is_away;
            // A gallery winds, and a mouth is there at once.
            let most = BEND * (view.way - edge.way).0.abs();
            if is_reached {
                let turned = (view.pose.yaw - Radians(skew) - self.begun.yaw - self.turn).wrapped();
                let turn = self.turn.0 + bounded(turned.0, most);
                self.turn = Radians(bounded(turn, MOST_TURN));
            }
            let moved = self.off(view, edge.side, distance) - edge.off;
            let off = edge.off + Metres(bounded(moved.0, most));
            self.edge = Some(Edge { off, way: view.way, is_reached, ..edge });
        }
        self.pass_corner(config, view);
        let found = self.gather(config, view, wall);
        let is_over = elapsed >= config.gathering;
        self.stage = match self.stage {
            Stage::Dropping { to, waits_since } => {
                let ahead = (to - view.way).0;
                let is_there = ahead.abs() <= NEAR && !is_away;
                if is_there && view.may_land {
                    return None;
                }
                let is_stopped = is_there || !is_away && self.is_shut(config, view, ahead);
                match waits_since {
                    _ if !is_stopped => Stage::Dropping { to, waits_since: None },
                    Some(since) if now.since(since) >= PATIENCE => {
                        // Where the way to the place is blocked, the drone lands before it.
                        if view.may_land {
                            return None;
                        }
                        self.looks_on(view)
                    }
                    since => Stage::Dropping { to, waits_since: since.or(Some(now)) },
                }
            }
            Stage::Looking { .. } if is_over || found.is_some() => {
                let to = found.unwrap_or_else(|| self.spare_way());
                Stage::Dropping { to, waits_since: None }
            }
            Stage::Looking { direction, from, is_second }
                if self.is_leg_over(config, view, direction, from) =>
            {
                (self.stretch, self.beside_since) = (None, None);
                if is_second && self.is_across(config, view, direction) {
                    self.turns(view)
                } else if is_second {
                    Stage::Dropping { to: self.spare_way(), waits_since: None }
                } else {
                    let direction = direction.opposite();
                    Stage::Looking { direction, from: self.from, is_second: true }
                }
            }
            stage => stage,
        };
        Some(self)
    }

    /// The command with which the drone flies in this round.
    #[must_use]
    pub fn command(&self, config: &SpotConfig, nav: &NavConfig, view: &SpotView) -> NavCommand {
        let wall = self.wall(view);
        let most = config.speed.0;
        let wanted = match self.stage {
            // The drone turns its nose first, and goes to the wall.
            _ if self.is_turning(view) || self.is_away(config, view) => 0.0,
            Stage::Looking { direction, .. } => direction.sign() * most,
            Stage::Dropping { to, .. } => bounded(GAIN * (to - view.way).0, most),
        };
        let is_blocked = wanted != 0.0 && is_blocked(config, view, wanted);
        let forward = if is_blocked { 0.0 } else { wanted };
        let aside = if self.is_turning(view) { 0.0 } else { self.aside(config, view) };
        let lateral = bounded(GAIN * aside, most);
        let off = self.nose_off(view);
        let push = push_away(nav, &view.ranges);
        let walls = match (wall, self.side()) {
            (Seen::Wall { .. }, Some(side)) => Walls::One(side),
            _ => Walls::Neither,
        };
        NavCommand {
            forward: MetresPerSecond(forward + push.forward),
            lateral: MetresPerSecond(lateral + push.lateral).limited_to(nav.max_lateral),
            yaw_rate: RadiansPerSecond(bounded(GAIN * off.0, nav.max_yaw_rate.0)),
            walls,
        }
    }

    /// Takes up the nearer wall where there is none yet, or where the one on its way to which the
    /// drone was has turned out to be a mouth.
    fn find_edge(&mut self, view: &SpotView) {
        if let Some(edge) = self.edge
            && !edge.is_reached
            && self.is_gone(view, edge)
        {
            self.edge = None;
            let [left, right] = &mut self.open;
            *(if edge.side == Side::Left { left } else { right }) = Some(view.way);
        }
        let is_open = self.open.map(|at| at.is_some_and(|way| (view.way - way).0.abs() < MOUTH));
        if self.edge.is_none()
            && let Some((side, distance)) = nearer_wall(&view.ranges, is_open)
        {
            let off = self.off(view, side, distance);
            self.edge =
                Some(Edge { side, off, way: view.way, is_reached: false, passed: Metres::ZERO });
        }
    }

    /// Whether the nose is across the gallery: an obstacle ends the way back as well, and nothing along
    /// it was beside a wall. From the middle, across, all four beams end at the walls ahead and behind,
    /// and look as if they saw walls on both sides.
    fn is_across(&self, config: &SpotConfig, view: &SpotView, direction: Direction) -> bool {
        let is_open = self.spare.is_none_or(|spare| spare.kind == Kind::Open);
        is_open && !self.is_turned && self.is_shut(config, view, direction.sign())
    }

    /// Turns the nose by a quarter, along the gallery, and begins to look anew.
    fn turns(&mut self, view: &SpotView) -> Stage {
        let yaw = (self.begun.yaw + Radians(FRAC_PI_2)).wrapped();
        let turned = Self {
            begun: Pose2 { yaw, ..view.pose },
            is_turned: true,
            ..Self::begin(self.since, view.way, view.pose)
        };
        *self = turned;
        self.stage
    }

    /// By how much the nose is to turn to the left.
    fn nose_off(&self, view: &SpotView) -> Radians {
        (self.begun.yaw + self.turn - view.pose.yaw).wrapped()
    }

    /// Whether the drone turns by a quarter.
    fn is_turning(&self, view: &SpotView) -> bool {
        self.is_turned && self.nose_off(view).0.abs() > MOST_TURN
    }

    /// Moves the line on which the drone flies away from a corner ahead, on the side of the wall.
    fn pass_corner(&mut self, config: &SpotConfig, view: &SpotView) {
        let direction = match self.stage {
            Stage::Looking { direction, .. } => direction.sign(),
            Stage::Dropping { to, .. } => (to - view.way).0,
        };
        if !self.passes_corner(config, view, direction) {
            return;
        }
        if let Some(edge) = &mut self.edge {
            edge.off -= STEP;
            edge.passed += STEP;
        }
    }

    /// Whether there is a corner ahead in this direction, at the wall alone, which the drone can pass.
    fn passes_corner(&self, config: &SpotConfig, view: &SpotView, direction: f32) -> bool {
        self.edge.is_some_and(|edge| {
            let [at_wall, beside] = [edge.side, edge.side.opposite()]
                .map(|side| is_near(config, leading(&view.ranges, side, direction)));
            edge.is_reached && at_wall && !beside && edge.passed < config.wall
        })
    }

    /// Whether the drone gets no farther in this direction.
    fn is_shut(&self, config: &SpotConfig, view: &SpotView, direction: f32) -> bool {
        is_blocked(config, view, direction) && !self.passes_corner(config, view, direction)
    }

    fn side(&self) -> Option<Side> {
        self.edge.map(|edge| edge.side)
    }

    /// How far what is at this distance to a side is from the line on which the search began.
    fn off(&self, view: &SpotView, side: Side, distance: f32) -> Metres {
        let (sin, cos) = self.begun.yaw.sin_cos();
        let Point2 { x, y } = view.pose.at;
        let left = (y - self.begun.at.y) * cos - (x - self.begun.at.x) * sin;
        Metres(distance + if side == Side::Left { left } else { -left })
    }

    /// How far to the left the line is on which the drone flies, m: along the wall, also where it sees
    /// none, or without a wall the line on which it began.
    fn aside(&self, config: &SpotConfig, view: &SpotView) -> f32 {
        match self.edge {
            None => -self.off(view, Side::Left, 0.0).0,
            Some(Edge { side, off, .. }) => {
                let nearer = (off - config.wall - self.off(view, side, 0.0)).0;
                if side == Side::Left { nearer } else { -nearer }
            }
        }
    }

    /// Whether the drone has to come to that line before it flies on.
    fn is_away(&self, config: &SpotConfig, view: &SpotView) -> bool {
        self.aside(config, view).abs() > AT_WALL
    }

    /// Whether what looks like the wall is farther off than the wall was.
    fn is_gone(&self, view: &SpotView, edge: Edge) -> bool {
        let seen = look(&view.ranges, edge.side);
        matches!(seen, Seen::Wall { distance, .. }
            if (self.off(view, edge.side, distance) - edge.off).0 > GONE)
    }

    /// The wall that the drone is to land at.
    fn wall(&self, view: &SpotView) -> Seen {
        match self.edge {
            None => Seen::Nothing,
            Some(edge) if self.is_gone(view, edge) => Seen::Other,
            Some(edge) => look(&view.ranges, edge.side),
        }
    }

    /// Takes in what the rangers see here, and returns the middle of the stretch once it is a spot.
    fn gather(&mut self, config: &SpotConfig, view: &SpotView, wall: Seen) -> Option<Metres> {
        let Some(is_wide) = self.beside(config, view, wall) else {
            // A beam that was missed for a moment ends no stretch.
            if wall != Seen::Unknown {
                (self.stretch, self.beside_since) = (None, None);
            }
            return None;
        };
        let since = *self.beside_since.get_or_insert(view.way);
        let weaker = view.weaker();
        let along = view.way - since;
        // A shorter wall may be the inside of a narrow mouth.
        if along.0.abs() >= 0.5 * config.stretch.0 {
            let way = view.way - config.stretch * (0.25_f32.copysign(along.0));
            self.offer(Spare { way, kind: Kind::Beside, weaker });
        }
        let height = view.height.filter(|height| height.0.is_finite())?;
        let begun = Stretch { from: view.way, heights: [height; 2], is_wide, weaker };
        let stretch = match self.stretch {
            Some(before) if before.is_like(&begun) => before.and(config, begun),
            _ => begun,
        };
        self.stretch = Some(stretch);
        if (view.way - stretch.from).0.abs() < config.stretch.0 {
            return None;
        }
        self.stretch = None;
        let way = stretch.from + (view.way - stretch.from) / 2.0;
        let kind = if is_wide { Kind::Spot } else { Kind::Even };
        self.offer(Spare { way, kind, weaker: stretch.weaker });
        (is_wide && stretch.weaker >= 0.0).then_some(way)
    }

    /// Keeps a place if it is better than the one that is kept.
    fn offer(&mut self, place: Spare) {
        if self.spare.is_none_or(|spare| place.is_better_than(&spare)) {
            self.spare = Some(place);
        }
    }

    /// The stage of a drone that may not land at the place to which it came: it looks on from there,
    /// towards the neighbour to which its link is weaker, and what it knew of places is out of date.
    fn looks_on(&mut self, view: &SpotView) -> Stage {
        (self.stretch, self.beside_since, self.spare) = (None, None, None);
        Stage::Looking { direction: view.towards_weaker(), from: view.way, is_second: false }
    }

    /// Whether the drone is beside the wall and not in a mouth; if so, whether the free width is left.
    fn beside(&self, config: &SpotConfig, view: &SpotView, wall: Seen) -> Option<bool> {
        let Seen::Wall { distance, skew } = wall else { return None };
        if distance > config.beside.0 || skew.abs() > ALONG {
            return None;
        }
        let (front, rear) = view.ranges.beams(self.side()?.opposite());
        // A beam that sees nothing reaches farther than the width.
        let is_wide = |beam: Range| {
            beam.length().is_none_or(|beam| beam * FRAC_1_SQRT_2 >= config.free_width.0)
        };
        Some(is_wide(front) && is_wide(rear))
    }

    /// Where to land without a spot.
    fn spare_way(&self) -> Metres {
        self.spare.map_or(self.from, |spare| spare.way)
    }

    /// Whether a leg in this direction has come to its end. Up to `from` the drone has been everywhere
    /// already, with links.
    fn is_leg_over(
        &self,
        config: &SpotConfig,
        view: &SpotView,
        direction: Direction,
        from: Metres,
    ) -> bool {
        let out = |from: Metres| (view.way - from).0 * direction.sign();
        let [front, back] = view.has_room;
        let has_room = if direction == Direction::Ahead { front } else { back };
        let is_strained = out(from) >= 0.0 && view.is_strained(direction);
        let is_far = out(self.from) >= config.most_way.0 || is_strained;
        is_far || !has_room || self.is_shut(config, view, direction.sign())
    }
}

/// The number within ±`most`; 0 for one that is no number.
fn bounded(number: f32, most: f32) -> f32 {
    if number.is_nan() { 0.0 } else { number.max(-most).min(most) }
}

/// Whether there is an obstacle before the beams that lead in this direction.
fn is_blocked(config: &SpotConfig, view: &SpotView, direction: f32) -> bool {
    let sides = [Side::Left, Side::Right];
    sides.into_iter().any(|side| is_near(config, leading(&view.ranges, side, direction)))
}

/// Whether a leading beam sees an obstacle ahead.
fn is_near(config: &SpotConfig, beam: Range) -> bool {
    beam.length().is_some_and(|beam| beam < AHEAD * config.beam())
}
