//! The branch that the pilot has chosen: at a junction the drone flies round the corner on that side.
//!
//! Where the wall on the chosen side ends, the last that its leading beam saw of it is a *corner*.
//! The drone remembers where the corner is, as seen from itself, by dead reckoning. It flies on until
//! the corner is abeam, and then around it at a set distance, until it has the wall of the branch at
//! its side. Neither the angle nor the width of the branch need be known:
//!
//! ```text
//!            │ branch │
//!            │    ↑   │          In the frame of a drone that keeps its left wall, x is ahead and y
//!            │    │   │          to the left; every other case is a mirror image of this one.
//!   ─────────┘ ╭──╯   └────
//!     corner   │
//!   ─────→─────╯
//!   ───────────────────────
//! ```
//!
//! To keep the same wall leads out and home: the left wall of the left branch is also the left wall
//! of the gallery from which it branches off. A drone that flies tail first goes round the corner as
//! its mirror image, front to back.

use core::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2, SQRT_2};

use units::{Branch, Metres, Radians};

use crate::margin::Margin;
use crate::plane::wrapped;
use crate::{Diagonals, Range, Side};

/// The corner is passed at no more than this distance, m: half of the narrowest gallery into which a
/// drone turns from a wide one, and more than it slows down for.
const FARTHEST: f32 = 0.5;
/// The corner of a wide gallery is passed at no more than this distance, m: that of a drone which keeps
/// to the margin.
const FARTHEST_IN_WIDE: f32 = Margin::KEPT * FRAC_1_SQRT_2;
/// The corner is passed at no less than this distance, m, above the beam length of 0.45 m at which a
/// drone slows down.
const NEAREST: f32 = 0.38;
/// The drone moves to that distance at this gain, in (m/s)/m.
const DISTANCE_GAIN: f32 = 0.8;
/// The nose turns so that the corner is abeam, at this gain, in 1/s.
const TURN_GAIN: f32 = 2.0;
/// The nose does not turn towards a wall that is nearer than the one that it should have at its side,
/// at this gain, in (rad/s)/m: that of equation (18).
const WALL_GAIN: f32 = 1.5;
/// Both walls are seen again within this many lengths of the beams in the middle of a gallery, behind
/// the place where both have ended: two widths, where the galleries that cross are as wide.
const CROSSING: f32 = 2.9;
/// The gain, in 1/s, by which a drone holds its heading where it flies straight on.
const HOLD_GAIN: f32 = 1.5;
/// A drone that turns by 60°/s around a corner at 0.4 m flies no faster than this, m/s.
const FASTEST: f32 = 0.35;
/// A corner that is farther away is passed, or was none, m.
const GONE: f32 = 2.5;
/// The two beams at the new wall agree to within this part of their mean, half of the ratio test.
const AGREE: f32 = 0.2;
/// The corner is so far behind, rad, when both beams look at the wall of the branch.
const PASSED: f32 = 2.75;
/// While the corner is ahead of abeam by so much, rad, the leading beam looks past it, and the other
/// one at the wall before it: if they agree, nothing has opened.
const AHEAD: core::ops::Range<f32> = 1.05..1.4;
/// The drone has come this far round the corner, rad, when a new wall may be that of the branch.
const ABEAM: f32 = 1.75;

/// Whether a drone flies home, and whether others come after it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Homing {
    /// The drone does not fly home.
    #[default]
    No,
    /// The drone flies home, and other drones may come after it.
    Followed,
    /// The drone flies home as the last one: it may turn round and try another way where it does not come
    /// on.
    Last,
}

/// How a drone is guided at junctions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Guide {
    /// The branch to take; `None` where the pilot has made no choice, and the preferred side counts
    /// where no range decides.
    pub branch: Option<Branch>,
    /// Whether the drone comes back from a branch that it should not have taken. When that ends, what
    /// its trail knows ahead is forgotten.
    pub rejoins: bool,
    /// The way from which on the choices are others than in the last round: what the trail knows
    /// from there on is forgotten, since it leads where the pilot no longer wants to go.
    pub changed_from: Option<Metres>,
    /// Whether another drone is too near, by radio: a beam that has become short at once sees that one.
    pub has_company: bool,
    /// Whether the drone flies home.
    pub homing: Homing,
}

impl Guide {
    /// No choice.
    pub const NONE: Self = Self {
        branch: None,
        rejoins: false,
        changed_from: None,
        has_company: false,
        homing: Homing::No,
    };
}

/// The command for a drone that flies around a corner, in its own axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turning {
    /// The sideways velocity, m/s, to the left.
    pub(crate) lateral: f32,
    /// The yaw rate, rad/s, counter-clockwise.
    pub(crate) yaw_rate: f32,
    /// The speed that is not to be exceeded, m/s.
    pub(crate) fastest: f32,
}

/// The corner that a drone flies around.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Corner {
    /// Where the corner is, from the drone, ahead and to the left, m.
    at: [f32; 2],
    side: Side,
    /// Whether it was ahead when the wall ended; otherwise it was astern.
    ahead: bool,
    /// The distance at which to pass it, m.
    distance: f32,
    /// Where it is farther away than this, it is passed, or was none, m.
    gone: f32,
    /// Whether its wall was the only one that the drone saw.
    is_lone: bool,
}

impl Corner {
    /// The corner at which a wall has ended that is ahead, or else astern, by this part of the distance to
    /// the wall.
    // Once in the program: in both places where it is called it takes 156 B more.
    #[inline(never)]
    fn new(ended: Ended, ahead: bool, part: f32) -> Self {
        let Ended { side, length, is_wide, is_lone } = ended;
        let off = length * FRAC_1_SQRT_2;
        let at = in_frame([part * off, off], side, ahead);
        let distance = off.clamp(NEAREST, if is_wide { FARTHEST_IN_WIDE } else { FARTHEST });
        let gone = GONE.max(1.25 * length);
        Self { at, side, ahead, distance, gone, is_lone }
    }

    /// The corner after a motion of the drone: the way ahead and to the left, m, and the turn, rad.
    /// `None` where it is too far away.
    fn moved(self, (moved, turned): ([f32; 2], f32)) -> Option<Self> {
        let [x, y] = [self.at[0] - moved[0], self.at[1] - moved[1]];
        let (sin, cos) = Radians(-turned).sin_cos();
        let at = [x * cos - y * sin, x * sin + y * cos];
        (at[0] * at[0] + at[1] * at[1] < self.gone * self.gone).then_some(Self { at, ..self })
    }

    /// Whether the drone has gone round it and has the next wall at its side; `None` while it is at
    /// the corner.
    fn passed(&self, ranges: &Diagonals) -> Option<bool> {
        let [x, y] = in_frame(self.at, self.side, self.ahead);
        let bearing = libm::atan2f(y, x);
        let (front, rear) = ranges.beams(self.side);
        let agree = front
            .length()
            .zip(rear.length())
            .is_some_and(|(front, rear)| (front - rear).abs() <= AGREE * 0.5 * (front + rear));
        if agree && bearing > ABEAM {
            Some(true)
        } else if !(-FRAC_PI_2..=PASSED).contains(&bearing) || agree && AHEAD.contains(&bearing) {
            Some(false)
        } else {
            None
        }
    }
}

/// The pilot's choice, and the corners on both sides of the drone.
///
/// A corner is remembered on either side, whatever the choice: the choice may come, or change, while
/// the drone is beside the opening.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Fork {
    guide: Guide,
    left: Option<Corner>,
    right: Option<Corner>,
    /// The heading of the last round.
    heading: Option<f32>,
    /// The crossing of two galleries that the drone flies through.
    crossing: Option<Crossing>,
}

/// A place at which both walls have ended.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Crossing {
    /// The heading of the nose there.
    heading: f32,
    /// The way flown since, m: negative for backward flight.
    way: f32,
    /// The way after which both walls are seen again, m.
    length: f32,
}

/// The side of the drone on which a wall has ended, and the length that its beams had, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ended {
    pub(crate) side: Side,
    pub(crate) length: f32,
    /// Whether it is one of a wide gallery.
    pub(crate) is_wide: bool,
    /// Whether it was the only one that the drone had seen for a while.
    pub(crate) is_lone: bool,
}

impl Fork {
    /// The length of the beams at a wall that is as near as a corner is passed.
    pub(crate) const NEAR: f32 = SQRT_2 * FARTHEST;

    pub(crate) const fn new() -> Self {
        Self { guide: Guide::NONE, left: None, right: None, heading: None, crossing: None }
    }

    /// Whether the pilot has chosen a branch here, so that the tunnel has more than one way.
    pub(crate) const fn is_chosen(&self) -> bool {
        self.guide.branch.is_some()
    }

    /// Notes how the drone is guided, and returns whether it has come back from a wrong branch.
    pub(crate) const fn follow(&mut self, guide: Guide) -> bool {
        let is_back = self.guide.rejoins && !guide.rejoins;
        self.guide = guide;
        is_back
    }

    /// Whether another drone is too near.
    pub(crate) const fn has_company(&self) -> bool {
        self.guide.has_company
    }

    /// Whether the drone flies home and no other comes after it.
    pub(crate) const fn is_last_home(&self) -> bool {
        matches!(self.guide.homing, Homing::Last)
    }

    /// Whether the drone flies home.
    pub(crate) const fn is_homing(&self) -> bool {
        !matches!(self.guide.homing, Homing::No)
    }

    /// The side of the chosen branch; `None` without a choice, and for straight on.
    pub(crate) const fn side(&self) -> Option<Side> {
        match self.guide.branch {
            Some(Branch::Left) => Some(Side::Left),
            Some(Branch::Right) => Some(Side::Right),
            Some(Branch::Straight) | None => None,
        }
    }

    /// Whether the pilot has chosen to fly straight on.
    pub(crate) fn goes_straight(&self) -> bool {
        self.guide.branch == Some(Branch::Straight)
    }

    /// Whether the drone has a corner on the chosen side.
    pub(crate) const fn is_at_corner(&self) -> bool {
        match self.side() {
            Some(Side::Left) => self.left.is_some(),
            Some(Side::Right) => self.right.is_some(),
            None => false,
        }
    }

    /// Forgets the corners at which the drone was.
    pub(crate) const fn forget_corners(&mut self) {
        (self.left, self.right, self.crossing) = (None, None, None);
    }

    /// Moves on by this way, ahead and to the left, with the nose now at `heading`.
    pub(crate) fn advance(&mut self, moved: [Metres; 2], heading: Option<Radians>) {
        let heading = heading.map(|heading| heading.0).filter(|heading| heading.is_finite());
        let turned = self.heading.zip(heading).map(|(before, now)| wrapped(now - before));
        self.heading = heading;
        self.crossing = self.crossing.filter(|_| heading.is_some()).and_then(|crossing| {
            let way = crossing.way + moved[0].0;
            (way.abs() < crossing.length).then_some(Crossing { way, ..crossing })
        });
        // Without a heading there is no dead reckoning.
        let by = turned.map(|turned| (moved.map(|way| way.0), turned));
        self.left = self.left.zip(by).and_then(|(corner, by)| corner.moved(by));
        self.right = self.right.zip(by).and_then(|(corner, by)| corner.moved(by));
    }

    const fn corner_mut(&mut self, side: Side) -> &mut Option<Corner> {
        match side {
            Side::Left => &mut self.left,
            Side::Right => &mut self.right,
        }
    }

    /// Notes that a wall has ended, as these ranges show.
    pub(crate) fn see_end(&mut self, ended: Ended, ranges: &Diagonals) {
        let (front, rear) = ranges.beams(ended.side);
        let corner = Corner::new(ended, length(front) > length(rear), 1.0);
        let Some(heading) = self.heading else { return };
        self.corner_mut(ended.side).get_or_insert(corner);
        if self.left.zip(self.right).is_some_and(|(left, right)| left.ahead == right.ahead) {
            let length = CROSSING * ended.length;
            self.crossing.get_or_insert(Crossing { heading, way: 0.0, length });
        }
    }

    /// Notes that a wall has ended beside the drone, which sees it with its rear beam alone: the corner is
    /// somewhere between abeam and the front beam, and counts as in the middle.
    pub(crate) fn see_ended(&mut self, ended: Ended) {
        *self.corner_mut(ended.side) = Some(Corner::new(ended, true, 0.5));
    }

    /// Whether the drone flies round this corner: it is on the chosen side, or without a choice that of
    /// the only wall. In a gallery of which the drone sees one wall alone, a wall that ends is the inside
    /// of a bend, or a branch, and what lies straight on is not seen.
    fn is_taken(&self, corner: &Corner) -> bool {
        self.side() == Some(corner.side) || self.guide.branch.is_none() && corner.is_lone
    }

    /// Forgets the corners that are passed. Returns the side where the drone has come round the corner that
    /// it takes and has the next wall at that side.
    pub(crate) fn find_wall(&mut self, ranges: &Diagonals) -> Option<Side> {
        let mut found = None;
        for corner in [self.left, self.right].into_iter().flatten() {
            if let Some(passed) = corner.passed(ranges) {
                *self.corner_mut(corner.side) = None;
                if passed && self.is_taken(&corner) {
                    found = Some(corner.side);
                }
            }
        }
        found
    }

    /// The command for a drone that flies forward, or backward, at this speed; `None` where it is not
    /// at a corner.
    pub(crate) fn turning(&self, ranges: &Diagonals, speed: f32) -> Option<Turning> {
        if self.goes_straight() {
            let off = wrapped(self.crossing?.heading - self.heading?);
            return Some(Turning { lateral: 0.0, yaw_rate: HOLD_GAIN * off, fastest: FASTEST });
        }
        let corner =
            [self.left, self.right].into_iter().flatten().find(|one| self.is_taken(one))?;
        if corner.ahead != (speed > 0.0) {
            return None;
        }
        let [x, y] = in_frame(corner.at, corner.side, corner.ahead);
        let (bearing, off) = (libm::atan2f(y, x), libm::sqrtf(x * x + y * y));
        let away = if x > 0.0 { y } else { off };
        let lateral = DISTANCE_GAIN * (away - corner.distance);
        let beyond = bearing - FRAC_PI_2;
        let around = speed.abs().min(FASTEST) / off.max(NEAREST) + TURN_GAIN * beyond;
        let orbit = if beyond >= 0.0 { around } else { 0.0 };
        let (front, rear) = ranges.beams(corner.side);
        let leading = length(if corner.ahead { front } else { rear });
        let wall = WALL_GAIN * (leading - SQRT_2 * corner.distance);
        let yaw_rate = orbit.min(wall);
        // In the frame, to the left and counter-clockwise; a mirror image turns these round.
        let mirrored = corner.side == Side::Right;
        let turns = if mirrored == corner.ahead { -yaw_rate } else { yaw_rate };
        let lateral = if mirrored { -lateral } else { lateral };
        Some(Turning { lateral, yaw_rate: turns, fastest: FASTEST })
    }
}

/// The length of a beam; infinite where it sees nothing.
fn length(beam: Range) -> f32 {
    beam.length().unwrap_or(f32::INFINITY)
}

/// A point of the drone's axes in the frame of a drone that flies forward along its left wall, or the
/// other way round: the mirror images are their own inverses.
fn in_frame([x, y]: [f32; 2], side: Side, ahead: bool) -> [f32; 2] {
    [if ahead { x } else { -x }, if side == Side::Left { y } else { -y }]
}
