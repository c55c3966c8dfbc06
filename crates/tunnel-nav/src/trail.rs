//! The trail: the path that the drone has flown, and the heading of its nose along it.
//!
//! In the middle of a right-angle bend all four beams are equal, whichever of the two galleries the
//! drone is aligned with: the ranges of one moment cannot distinguish forward from sideways, and do
//! not correct the heading there. But a relay that hovers in a bend has flown there, and its
//! gyroscope measured the heading. The trail is a list of points (crumbs), one each 0.2 m, with a
//! position by dead reckoning and the heading of the nose. A drone on known ground finds its place
//! among them and holds the heading that it had there.
//!
//! The place is found by the position and not by the odometer: the forward velocity alone is not
//! the way along the tunnel while the nose points across it, so a drone that flies slowly through a
//! bend and back would look up the trail at another place each time. The position of a drone that
//! has come back along its path is the old one again, whichever way its nose points.
//!
//! Position and heading drift: the optic flow of a hovering drone by a few millimetres a second,
//! the gyro by 5° to 10° a minute. So the trail holds no drone at a position: it gives headings, and
//! to a drone that flies home, where walls do not lead, the direction of the way. Where walls show that the drone is in a straight gallery, both are corrected.

use core::f32::consts::PI;

use units::Radians;

use crate::plane::{Vec2, axes, dot, minus, plus, wrapped};

mod rejoin;

/// The distance between two crumbs, m.
const SPACING: f32 = 0.2;
/// The number of crumbs kept: 120 m of path. A relay needs a few metres of it to hover in a bend;
/// a drone that comes home needs all of the way since its take-off, past junctions and sharp bends:
/// missions to 100 m, with a fifth for what a drone flies beside the straight way.
const CRUMBS: usize = 600;
/// The resolution at which the position of a crumb is kept, m: 16 bits then tell apart places within
/// 131 m. At 0.3 m/s and more the crumbs lie up to 0.28 m apart, and a path that leads straight on for
/// longer than that is not told apart at its far end.
const GRID: f32 = 0.002;
/// The resolution at which the heading of a crumb is kept, rad.
const TURN: f32 = PI / 32_768.0;
/// The path is longer than this nowhere, m.
const FARTHEST_AHEAD: f32 = SPACING * CRUMBS as f32;
/// The number of crumbs ahead and behind among which the place is looked for in each round.
const SEARCH: i32 = 3;
/// The path bends where its heading changes by more than this, rad, from …
const BEND: f32 = 0.35;
/// … this far behind to this far ahead, in crumbs.
const AROUND: f32 = 3.0;
/// A gallery is known to be straight where the path is straight and known this far both ways, m.
const STRAIGHT: f32 = 0.5;
/// A heading that differs by less than this from what walls say is off by drift, rad. A larger
/// difference does not change the trail: what the beams see is another gallery.
const SAME: f32 = 0.6;
/// The part of this difference that is taken for drift in each round: within 4 s most of it.
const FOLLOW: f32 = 0.05;
/// The part of the distance from where the walls say the drone is that is taken for drift of the
/// position in each round.
const PULL: f32 = 0.2;
/// The heading drifts by no more than this in a round, rad, 10° a minute: as much as the gyroscope of a warm
/// board. Walls that ask for more are those of another gallery, or of a bend in which the drone rests.
const DRIFTS: f32 = 0.0006;
/// The part of the distance from the path that is taken for drift of the position in each round,
/// walls or not: 3 mm/s of drift stay below 3 cm.
const LEAK: f32 = 0.02;
/// The drone has left the path where it is farther than this beside it, m.
const LEFT: f32 = 0.4;
/// A drone that is farther than this from its path and has neither left it nor flown beyond its end
/// is not where it reckons to be, m: the path begins anew.
const LOST: f32 = 1.0;
/// A drone on its way home keeps its path though it is so far beside it, m: the path is all that the drone knows
/// of the way, in a gallery of 2 m the drone may fly a metre beside it, and its place drifts. Our own number.
const KEPT_HOME: f32 = 2.0;
/// The path leads across the gallery where its direction has less than this part along the nose: 37° or
/// more between them.
const ACROSS: f32 = 0.8;
/// A detour is longer than this, in crumbs, …
const DETOUR: i32 = 5;
/// … and ends where the drone is nearer than this to an earlier part of its path, m: galleries lie
/// farther apart than this.
const BACK: f32 = 0.35;
/// No tunnel turns by more than this within a crumb, rad, 158°; a drone that flies back turns by half a turn.
const REVERSED: f32 = 2.75;
/// A drone that hovers in a bend drifts, and sees walls that turn it to either side: only a turn of less than
/// this is taken for the bend's, rad.
const ASTERN: f32 = 2.3;
/// A drone that was pushed back from the end of its path has turned into a bend there where its nose is off
/// the path by more than this, rad.
const TURNS: f32 = 0.8;
/// The bend at which a drone has turned too early is no farther back on its path than this, in crumbs: 4 m, …
const FARTHEST_BEND: i32 = 20;
/// … and the drone still stands so far outside of it: 0.6 m.
const PAST_BEND: i32 = 3;
/// A drone flies back beside its path where the path is no farther to its side than this, m: galleries are up
/// to 3 m wide, and in a hall no wall is between either, …
const BESIDE: f32 = 3.0;
/// … and its nose points against the path's headings to within 17°: no bend turns so far.
const OPPOSITE: f32 = 2.85;
/// The drone is farther from the end of its path than this, in crumbs, where what it knows of the path is old:
/// 4 m.
const OLD: i32 = 20;
/// Behind a sharp bend the path comes near its earlier part for so many crumbs, and that is no detour.
const SURE: i32 = 10;
/// Where the path leads home is read so many crumbs behind: 3 m.
const HOMEWARD: i32 = 15;
/// The tail of a drone that flies back to its path points to the path so many crumbs behind: 1 m.
const PURSUED: i32 = 5;
/// No drone moves farther than this in a round, m.
const FARTHEST: f32 = 0.5;

/// Whether a drone flies home, and else which of its ends leads over the last seconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flies {
    /// The drone flies forward.
    NoseFirst,
    /// The drone flies backward.
    TailFirst,
    /// The drone hovers or trembles, so that its velocity of the moment says nothing.
    Hovering,
    /// The drone is on its way home, and may wait there for others.
    Home,
}

/// One point of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Crumb {
    at: Vec2,
    heading: f32,
}

/// A crumb in six bytes. Its coordinates are kept modulo 131 m, so that a path may lead farther.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Packed {
    at: [i16; 2],
    heading: i16,
}

impl Packed {
    const ORIGIN: Self = Self { at: [0; 2], heading: 0 };

    fn new(crumb: Crumb) -> Self {
        Self { at: crumb.at.map(|x| steps(x / GRID)), heading: steps(crumb.heading / TURN) }
    }

    /// The crumb, whose place is the one nearest to this point of those that it may be.
    fn near(self, point: Vec2) -> Crumb {
        let nearest =
            |at: i16, near: f32| near + GRID * f32::from(at.wrapping_sub(steps(near / GRID)));
        let [x, y] = self.at;
        Crumb {
            at: [nearest(x, point[0]), nearest(y, point[1])],
            heading: TURN * f32::from(self.heading),
        }
    }
}

/// The whole number nearest to this one, modulo 65,536.
fn steps(number: f32) -> i16 {
    libm::roundf(number) as i32 as i16
}

/// The path, and the place of the drone on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Trail {
    /// A ring: the crumb with number `n` is at `n` modulo the length.
    crumbs: [Packed; CRUMBS],
    /// The number of the crumb at the end where the drone came from.
    first: i32,
    /// The number of the crumb at the other end; before `first` while there are no crumbs.
    last: i32,
    /// The position of the drone by dead reckoning.
    at: Vec2,
    /// The heading of the nose, less the drift.
    heading: f32,
    /// The number of the crumb behind the drone …
    near: i32,
    /// … and the part of the way from there to the next crumb.
    part: f32,
    /// The angle by which the gyro's heading has drifted since the start, rad.
    drift: f32,
    /// The number of the crumb at which the drone last turned on the spot …
    turned_at: Option<i32>,
    /// … and the angle by which it has turned there since the path reached that crumb, rad.
    turned: f32,
    /// The number of the crumb at which it last turned to the way on after it had looked round.
    faced: Option<i32>,
}

impl Default for Trail {
    fn default() -> Self {
        Self::new()
    }
}

impl Trail {
    pub(crate) const fn new() -> Self {
        Self {
            crumbs: [Packed::ORIGIN; CRUMBS],
            first: 0,
            last: -1,
            at: [0.0; 2],
            heading: 0.0,
            near: 0,
            part: 0.0,
            drift: 0.0,
            turned_at: None,
            turned: 0.0,
            faced: None,
        }
    }

    /// Makes this trail what [`Self::new`] returns, in its place.
    pub(crate) fn renew(&mut self) {
        self.forget();
        self.crumbs.fill(Packed::ORIGIN);
        (self.heading, self.drift) = (0.0, 0.0);
    }

    /// Forgets the whole path: it begins anew where the drone is.
    pub(crate) fn forget(&mut self) {
        self.at = [0.0; 2];
        (self.first, self.last, self.near, self.part) = (0, -1, 0, 0.0);
        (self.turned_at, self.turned, self.faced) = (None, 0.0, None);
    }

    /// Moves the drone by this way, forward and to the left.
    pub(crate) fn advance(&mut self, moved: Vec2, heading: Radians, flies: Flies) {
        self.heading = wrapped(heading.0 - self.drift);
        let [ahead, left] = axes(self.heading);
        let bounded = |way: f32| if way.is_finite() { way.clamp(-FARTHEST, FARTHEST) } else { 0.0 };
        self.at = plus(plus(self.at, ahead, bounded(moved[0])), left, bounded(moved[1]));
        self.locate();
        if self.is_beside() {
            self.at = plus(self.at, minus(self.foot(), self.at), LEAK);
        }
        if self.is_between() {
            self.leave(flies);
        }
        self.extend(flies);
    }

    fn crumb(&self, number: i32) -> Crumb {
        let number = number.clamp(self.first, self.last.max(self.first));
        self.crumbs.get(slot(number)).copied().unwrap_or(Packed::ORIGIN).near(self.at)
    }

    fn put(&mut self, number: i32, crumb: Crumb) {
        if let Some(slot) = self.crumbs.get_mut(slot(number)) {
            *slot = Packed::new(crumb);
        }
    }

    fn here(&self) -> Crumb {
        Crumb { at: self.at, heading: self.heading }
    }

    /// Whether the drone is beside a leg of the path.
    fn is_beside(&self) -> bool {
        self.last > self.first && self.part > 0.0 && self.part < 1.0
    }

    /// Whether the point of the path next to the drone is none of its ends. It may be a crumb where
    /// the path folds back, with the end of the path behind it.
    fn is_between(&self) -> bool {
        let place = self.near as f32 + self.part;
        place > self.first as f32 && place < self.last as f32
    }

    /// The point of the path next to the drone.
    fn foot(&self) -> Vec2 {
        let at = self.crumb(self.near).at;
        plus(at, minus(self.crumb(self.near.saturating_add(1)).at, at), self.part)
    }

    /// Finds the place on the path that is next to the drone.
    fn locate(&mut self) {
        let mut nearest = f32::INFINITY;
        let from = self.near.saturating_sub(SEARCH).max(self.first);
        let to = self.near.saturating_add(SEARCH).min(self.last.saturating_sub(1));
        for number in from..=to {
            let at = self.crumb(number).at;
            let (leg, way) = (minus(self.crumb(number + 1).at, at), minus(self.at, at));
            let square = dot(leg, leg);
            let part = if square > 0.0 { (dot(way, leg) / square).clamp(0.0, 1.0) } else { 0.0 };
            let off = plus(way, leg, -part);
            if dot(off, off) < nearest {
                nearest = dot(off, off);
                (self.near, self.part) = (number, part);
            }
        }
    }

    /// Ends the path here if the drone has left it before its end: what is ahead on it is not where
    /// the drone flies. A drone on its way home leaves it only much farther beside it. A drone beside the
    /// last leg at either end has flown on from there, and one that hovers has drifted from the shorter
    /// part of its path.
    fn leave(&mut self, flies: Flies) {
        let off = minus(self.at, self.foot());
        if dot(off, off) < LEFT * LEFT {
            return;
        }
        let here = self.here();
        let is_at = [self.near <= self.first, self.near.saturating_add(1) >= self.last];
        let ends_ahead = match is_at {
            [false, true] => true,
            [true, false] => false,
            [true, true] | [false, false] => match flies {
                Flies::NoseFirst => true,
                Flies::Home if dot(off, off) < KEPT_HOME * KEPT_HOME => return,
                Flies::TailFirst | Flies::Home => false,
                Flies::Hovering => self.last - self.near <= self.near - self.first,
            },
        };
        self.turned_at = None;
        if ends_ahead {
            self.last = self.near.saturating_add(1);
            self.put(self.last, here);
            self.part = 1.0;
        } else {
            self.first = self.near;
            self.put(self.first, here);
            self.part = 0.0;
        }
    }

    /// Adds a crumb where the drone flies beyond an end of the path. Where the path is not found at
    /// all it begins anew.
    fn extend(&mut self, flies: Flies) {
        let here = self.here();
        if self.last < self.first {
            self.put(0, here);
            (self.first, self.last, self.near, self.part) = (0, 0, 0, 0.0);
            return;
        }
        let off = minus(self.at, self.foot());
        let farthest = if flies == Flies::Home { KEPT_HOME } else { LOST };
        if dot(off, off) > farthest * farthest {
            (self.first, self.near, self.part) = (self.last, self.last, 0.0);
            self.put(self.last, here);
            return;
        }
        let place = self.near as f32 + self.part;
        let beyond = |end: Crumb, sign: f32| {
            let way = minus(self.at, end.at);
            dot(way, way) >= (SPACING - GRID) * (SPACING - GRID)
                && sign * dot(way, axes(end.heading)[0]) > 0.0
        };
        if place >= self.last as f32 && beyond(self.crumb(self.last), 1.0) {
            self.last = self.last.saturating_add(1);
            self.put(self.last, here);
            self.first = self.first.max(self.last.saturating_sub(CRUMBS as i32 - 1));
            (self.near, self.part) = (self.last.saturating_sub(1), 1.0);
            self.end_detour(self.last);
        } else if place <= self.first as f32 && beyond(self.crumb(self.first), -1.0) {
            self.first = self.first.saturating_sub(1);
            self.put(self.first, here);
            self.last = self.last.min(self.first.saturating_add(CRUMBS as i32 - 1));
            (self.near, self.part) = (self.first, 0.0);
            self.end_detour(self.first);
        }
    }

    /// Forgets the detour of a drone that has come back to an earlier part of its path: its place
    /// is there again. `newest` is the number of the crumb where it is.
    fn end_detour(&mut self, newest: i32) {
        if self.faced.is_some_and(|faced| (newest - faced).abs() < SURE) {
            return;
        }
        let mut nearest = (BACK * BACK, None);
        for number in self.first..=self.last {
            let off = minus(self.crumb(number).at, self.at);
            if (number - newest).abs() > DETOUR && dot(off, off) < nearest.0 {
                nearest = (dot(off, off), Some(number));
            }
        }
        let Some(number) = nearest.1 else { return };
        self.turned_at = None;
        if newest == self.last {
            self.last = number;
        } else {
            self.first = number;
        }
        (self.near, self.part) = (number, 0.0);
        self.locate();
    }

    /// The heading this far ahead on the path, in crumbs; beyond its ends that of the end.
    fn heading_at(&self, ahead: f32) -> f32 {
        let place = self.part + ahead;
        let whole = libm::floorf(place);
        let number = self.near.saturating_add(whole as i32);
        let (a, b) = (self.crumb(number).heading, self.crumb(number.saturating_add(1)).heading);
        wrapped(a + (place - whole) * wrapped(b - a))
    }

    /// Whether the path is known this far ahead, in metres.
    pub(crate) fn knows(&self, ahead: f32) -> bool {
        let place = self.near as f32 + self.part + ahead / SPACING;
        place >= self.first as f32 && place <= self.last as f32
    }

    /// The angle by which the nose is off the heading this far ahead, in metres: positive when it
    /// must turn counter-clockwise.
    pub(crate) fn off(&self, ahead: f32) -> Radians {
        Radians(wrapped(self.heading_at(ahead / SPACING) - self.heading))
    }

    /// The part of the path beside which the drone flies back, if it does: the number of the crumb there, and
    /// how far to the left of the nose it lies, m.
    pub(crate) fn beside(&self) -> Option<(i32, f32)> {
        let [ahead, left] = axes(self.heading);
        let against = steps((self.heading + PI) / TURN);
        let mut nearest: Option<(i32, f32)> = None;
        for number in self.first..self.last.saturating_sub(DETOUR) {
            let crumb = self.crumbs.get(slot(number)).copied().unwrap_or(Packed::ORIGIN);
            // By whole numbers first: most of the path leads elsewhere.
            if f32::from(crumb.heading.wrapping_sub(against)).abs() > (PI - OPPOSITE) / TURN {
                continue;
            }
            let off = minus(crumb.near(self.at).at, self.at);
            let aside = dot(off, left);
            let is_here = dot(off, ahead).abs() < SPACING && aside.abs() < BESIDE;
            if is_here && nearest.is_none_or(|(_, least)| aside.abs() < least.abs()) {
                nearest = Some((number, aside));
            }
        }
        nearest
    }

    /// Ends the path at this crumb, beside which the drone is.
    pub(crate) fn end_at(&mut self, number: i32) {
        self.turned_at = None;
        (self.last, self.near, self.part) = (number.saturating_add(1), number, 0.5);
        self.at = self.foot();
    }

    /// Takes the heading of a drone that has turned at the end of its path to where the tunnel goes on.
    pub(crate) fn face(&mut self) {
        self.turned_at = None;
        let Crumb { at, .. } = self.crumb(self.last);
        self.put(self.last, Crumb { at, heading: self.heading });
        self.faced = Some(self.last);
    }

    /// Whether the drone is within so many crumbs of the end of its path.
    pub(crate) const fn is_near_end(&self, crumbs: i32) -> bool {
        self.last - self.near < crumbs
    }

    /// The number of the crumb at the end of the path.
    pub(crate) const fn last(&self) -> i32 {
        self.last
    }

    /// Whether the path here was flown so long ago that the place on it is uncertain.
    pub(crate) fn is_old(&self) -> bool {
        self.last - self.near > OLD
    }

    /// The least of the angles by which the nose is off the headings of the path within so many crumbs.
    pub(crate) fn off_any(&self, window: i32) -> Radians {
        let off = |k: i32| wrapped(self.heading_at(k as f32) - self.heading);
        let offs = (-window..=window).map(off);
        Radians(offs.fold(off(0), |least, off| if off.abs() < least.abs() { off } else { least }))
    }

    /// Whether the path bends here.
    pub(crate) fn bends(&self) -> bool {
        let turn =
            |from: f32, to: f32| wrapped(self.heading_at(to) - self.heading_at(from)).abs() > BEND;
        turn(0.0, AROUND) || turn(-AROUND, 0.0) || turn(-AROUND, AROUND)
    }

    /// Whether the path is known to be straight here.
    pub(crate) fn is_straight(&self) -> bool {
        self.knows(STRAIGHT) && self.knows(-STRAIGHT) && !self.bends()
    }

    /// The unit vector along the path here.
    fn along(&self) -> Vec2 {
        let crumb = self.crumb(self.near);
        let leg = minus(self.crumb(self.near.saturating_add(1)).at, crumb.at);
        let length = libm::sqrtf(dot(leg, leg));
        if length > 0.0 { [leg[0] / length, leg[1] / length] } else { axes(crumb.heading)[0] }
    }

    /// Whether the path here leads sideways, as seen from the nose that flew it.
    pub(crate) fn leads_across(&self) -> bool {
        let ahead = axes(self.crumb(self.near).heading)[0];
        dot(self.along(), ahead).abs() < ACROSS
    }

    /// How far the drone is to the left of the path, m.
    pub(crate) fn aside(&self) -> f32 {
        let along = self.along();
        dot(minus(self.at, self.foot()), [-along[1], along[0]])
    }

    /// Corrects heading and position by the walls of a straight gallery, which say that the nose is
    /// turned from it by `skew`, and that the drone is to the left of its middle by `offset`, m.
    pub(crate) fn correct(&mut self, skew: Radians, offset: f32) {
        if self.bends() {
            return;
        }
        let wrong = -self.off(0.0).0 - skew.0;
        if wrong.abs() < SAME {
            self.drift = wrapped(self.drift + (FOLLOW * wrong).clamp(-DRIFTS, DRIFTS));
        }
        // A crumb that the drone has just laid says where the drone is, and not where the middle is.
        if !self.is_between() {
            return;
        }
        // Across the gallery, and not across the leg here: a leg that leads across it would hold the place.
        let [_, left] = axes(self.heading - skew.0);
        let aside = dot(minus(self.at, self.foot()), left);
        self.at = plus(self.at, left, PULL * (offset - aside));
    }

    /// Takes the heading of a drone that turned on the spot at the end towards which it flies.
    /// Returns `false` if no tunnel turns so far there: the drone faces the way by which it came. The
    /// end then has the heading back with which it was reached.
    ///
    /// A drone that `flies_on`, and does not only tremble about its place, may be in a hairpin.
    pub(crate) fn turn(&mut self, forward: bool, flies_on: bool) -> bool {
        let number = if forward { self.last } else { self.first };
        if (self.near as f32 + self.part - number as f32).abs() > 1.0 {
            if forward && flies_on {
                self.end_in_bend();
            }
            return true;
        }
        let Crumb { at, heading } = self.crumb(number);
        let turned = if self.turned_at == Some(number) { self.turned } else { 0.0 };
        let total = turned + wrapped(self.heading - heading);
        let is_bend = total.abs() <= if flies_on { REVERSED } else { ASTERN };
        let heading = if is_bend { self.heading } else { wrapped(heading - turned) };
        self.turned = if is_bend { total } else { 0.0 };
        self.turned_at = Some(number);
        self.put(number, Crumb { at, heading });
        is_bend
    }

    /// Ends the path of a drone here that was pushed back from the outer wall of a bend while it turned there:
    /// the path does not lead on to where it was.
    fn end_in_bend(&mut self) {
        let off = wrapped(self.heading - self.heading_at(0.0));
        if off.abs() > TURNS && off.abs() <= REVERSED {
            self.last = self.near.saturating_add(1);
            self.put(self.last, self.here());
            self.part = 1.0;
            (self.turned_at, self.turned) = (Some(self.last), off);
        }
    }

    /// Ends the path this far ahead of the drone, in metres: what is beyond leads into a wrong branch.
    /// Returns whether there was any.
    pub(crate) fn forget_from(&mut self, ahead: f32) -> bool {
        let last = (self.part + ahead.min(FARTHEST_AHEAD) / SPACING) as i32;
        let last = self.near.saturating_add(last);
        if last >= self.last || self.last < self.first {
            return false;
        }
        self.turned_at = None;
        if last > self.near {
            self.last = last;
        } else {
            self.last = self.near.saturating_add(1);
            self.put(self.last, self.here());
            self.part = 1.0;
        }
        true
    }

    /// Moves the place of a drone that flies back to before the bend behind it, if the path bends there. Returns
    /// whether it does.
    pub(crate) fn go_before_bend(&mut self) -> bool {
        let here = self.heading_at(0.0);
        let bends = |number: &i32| wrapped(self.crumb(*number).heading - here).abs() > TURNS;
        let farthest = self.near.saturating_add(FARTHEST_BEND).min(self.last);
        let Some(bend) = (self.near..farthest).find(bends) else { return false };
        let number = bend.saturating_add(PAST_BEND).min(self.last.saturating_sub(1));
        (self.near, self.part) = (number, 0.0);
        self.at = self.foot();
        true
    }

    /// The position of the drone by dead reckoning, m.
    pub(crate) const fn at(&self) -> Vec2 {
        self.at
    }

    /// The angle from the nose to the path [`HOMEWARD`] behind, or to the tail where no path is known.
    pub(crate) fn home(&self) -> Radians {
        let way = self.way_to(HOMEWARD, LOST);
        way.map_or(Radians(PI), |[x, y]| Radians(wrapped(libm::atan2f(y, x) - self.heading)))
    }

    /// The angle by which the nose is off so that the tail points to the path [`PURSUED`] behind; `None` where
    /// the path is not known so far, or the drone is there.
    pub(crate) fn pursues(&self) -> Option<Radians> {
        let is_known = self.knows(-SPACING * PURSUED as f32);
        let [x, y] = self.way_to(PURSUED, SPACING).filter(|_| is_known)?;
        Some(Radians(wrapped(libm::atan2f(-y, -x) - self.heading)))
    }

    /// The way from the drone to its path so many crumbs behind, m; `None` where that is no farther than
    /// `nearest`, m.
    fn way_to(&self, behind: i32, nearest: f32) -> Option<Vec2> {
        let way = minus(self.crumb(self.near.saturating_sub(behind)).at, self.at);
        (dot(way, way) > nearest * nearest).then_some(way)
    }

    /// Moves the drone along the path without a measured motion.
    pub(crate) fn shift(&mut self, way: f32) {
        self.at = plus(self.at, axes(self.heading_at(0.0))[0], way);
        self.locate();
    }
}

fn slot(number: i32) -> usize {
    number.rem_euclid(CRUMBS as i32) as usize
}

#[cfg(test)]
mod tests;
