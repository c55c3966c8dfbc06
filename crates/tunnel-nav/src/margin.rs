//! The margin of a wide gallery: where the pilot has chosen a side, the drone keeps near the wall of
//! that side.
//!
//! In the middle of a gallery of 5 m both walls are at the end of the beams' reach. Where one ends, its
//! corner is too far away to be flown round, and the drone flies past. So from the choice on, and not
//! only at the junction, the drone follows the wall on the chosen side at a set distance, and the wall
//! on the other side does not count:
//!
//! ```text
//!   ───────────────────────        A drone that keeps to the left, and then is to keep to the right,
//!   ─────→──╮                      flies across, slowly ahead and fast to the side, until it sees the
//!           ╲                      right wall. Where the gallery is wider than the beams reach, it
//!            ╰────→────────        holds its heading in between.
//!   ───────────────────────
//! ```
//!
//! All drones of a chain are told the same choices and the places at which these change, so that all
//! fly on the same side.

use core::f32::consts::SQRT_2;

use units::Metres;

use crate::wall::{Beams, Track};
use crate::{Diagonals, NavConfig, Range, Side};

/// What a drone keeps its distance from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Keeps {
    /// Both walls: the gallery is narrow, or the pilot has chosen no side.
    #[default]
    Middle,
    /// The drone is on its way to the wall on this side, which it does not see yet.
    Crossing(Side),
    /// The wall on this side.
    Wall(Side),
}

/// How a drone crosses to the chosen wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    /// The sideways velocity, m/s, to the left.
    pub(crate) lateral: f32,
    /// The yaw rate, rad/s, where it has come to a wall aslant.
    pub(crate) yaw_rate: Option<f32>,
}

/// The limit of the yaw rate along a wall that is come to aslant, rad/s: half of the drone's own.
const MOST_TURN: f32 = 0.5;

/// Whether the gallery is wide, and what the drone keeps its distance from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Margin {
    is_wide: bool,
    keeps: Keeps,
    /// The way flown since a wall was last seen, m.
    blind: f32,
}

impl Margin {
    /// The length of the beams in the middle of the widest gallery that is not wide, m: the reach of
    /// the paper's rangers (V-B), with which no drone sees both walls of a wider one.
    pub(crate) const NARROW: f32 = 2.0;
    /// The length of the beams of a drone that keeps to the margin, m: 0.8 m from the wall. Our own
    /// number: above the beam length of 0.45 m at which a drone slows down, and near enough for a
    /// corner to be ahead by no more than a metre where the wall ends.
    pub(crate) const KEPT: f32 = 0.8 * SQRT_2;
    /// The speed along the tunnel of a drone that crosses, m/s: half of that with which it flies
    /// sideways, so that it has crossed after half of the gallery's width.
    const CROSSING: f32 = 0.1;
    /// A drone that has flown so far without any wall at its sides is in a wide gallery, m: the way
    /// through a crossing of two galleries that are 2.2 m wide is shorter.
    const BLIND: f32 = 2.5;
    /// A drone has come to the wall where its beams are longer than they shall be by less than this, m.
    const CLOSE: f32 = 0.3;
    /// The two beams at a wall agree to within this part of their mean: half of the ratio test.
    const AGREE: f32 = 0.2;

    pub(crate) const fn new() -> Self {
        Self { is_wide: false, keeps: Keeps::Middle, blind: 0.0 }
    }

    pub(crate) const fn is_wide(&self) -> bool {
        self.is_wide
    }

    /// Lets the drone cross to the chosen side, as in a wide gallery, until it sees both walls.
    pub(crate) const fn cross(&mut self) {
        self.is_wide = true;
    }

    /// Whether the drone keeps to one side.
    pub(crate) fn is_kept(&self) -> bool {
        self.keeps != Keeps::Middle
    }

    pub(crate) const fn keeps(&self) -> Keeps {
        self.keeps
    }

    /// The state after one more measurement, with this side chosen; `is_turning` says whether the drone
    /// flies round the corner on that side.
    pub(crate) fn next(
        self,
        chosen: Option<Side>,
        [left, right]: [Track; 2],
        ranges: &Diagonals,
        moved: Metres,
        is_turning: bool,
    ) -> Self {
        let sees_any = left.is_seen() || right.is_seen();
        let blind = if sees_any { 0.0 } else { self.blind + moved.0.abs() };
        let is_wide = match (left, right) {
            (Track::Seen { length: left }, Track::Seen { length: right }) => {
                left + right > 2.0 * Self::NARROW
            }
            _ => self.is_wide || blind > Self::BLIND,
        };
        let Some(side) = chosen.filter(|_| is_wide) else {
            return Self { is_wide, keeps: Keeps::Middle, blind };
        };
        let sees_wall = Self::beams(ranges, side).agree(Self::AGREE);
        let keeps = match self.keeps {
            Keeps::Wall(kept) if kept == side => Keeps::Wall(side),
            _ if sees_wall || is_turning => Keeps::Wall(side),
            _ => Keeps::Crossing(side),
        };
        Self { is_wide, keeps, blind }
    }

    /// Whether a wall on this side that is lost has ended, and was not only left behind.
    pub(crate) fn counts(&self, side: Side) -> bool {
        match self.keeps {
            Keeps::Middle => true,
            Keeps::Crossing(kept) | Keeps::Wall(kept) => kept == side,
        }
    }

    /// The length of the beams at the chosen wall; `None` in a narrow gallery.
    pub(crate) fn nearest(&self) -> Option<f32> {
        self.is_wide.then_some(Self::KEPT)
    }

    /// The command of a drone that crosses, nose first; `None` for one that does not.
    ///
    /// It flies sideways until a beam of the chosen side sees a wall near. A drone that has come there
    /// aslant, so that its two beams of that side do not agree, turns along the wall.
    pub(crate) fn crossing(&self, config: &NavConfig, ranges: &Diagonals) -> Option<Crossing> {
        let Keeps::Crossing(side) = self.keeps else { return None };
        let length = |beam: Range| beam.length().unwrap_or(config.reach.0).min(config.reach.0);
        let (front, rear) = ranges.beams(side);
        let (front, rear) = (length(front), length(rear));
        let near = front.min(rear);
        let (lateral, turn) = if near < Self::KEPT {
            let turn = 2.0 * config.yaw_gain * (front - rear);
            (config.lateral_gain * (near - Self::KEPT), Some(turn.clamp(-MOST_TURN, MOST_TURN)))
        } else {
            (config.max_lateral.0, None)
        };
        Some(match side {
            Side::Left => Crossing { lateral, yaw_rate: turn },
            Side::Right => Crossing { lateral: -lateral, yaw_rate: turn.map(|turn| -turn) },
        })
    }

    /// The part of this speed, m/s, at which a drone flies along the tunnel: it is slow until it has
    /// come to the wall, whose state is one of these.
    pub(crate) fn pace(&self, speed: f32, [left, right]: [Track; 2]) -> f32 {
        let is_far = match self.keeps {
            Keeps::Middle => false,
            Keeps::Crossing(_) => true,
            Keeps::Wall(Side::Left) => left.is_longer(Self::KEPT + Self::CLOSE),
            Keeps::Wall(Side::Right) => right.is_longer(Self::KEPT + Self::CLOSE),
        };
        if is_far { Self::CROSSING / speed.abs().max(Self::CROSSING) } else { 1.0 }
    }

    /// The beams of a side.
    pub(crate) fn beams(ranges: &Diagonals, side: Side) -> Beams {
        let (front, rear) = ranges.beams(side);
        Beams::new(front, rear)
    }

    /// The ranges without those of a wide gallery's wall on the other side.
    pub(crate) fn without(ranges: &Diagonals, side: Side) -> Diagonals {
        let near = |beam: Range| match beam {
            Range::At(length) if length.0 > Self::NARROW => Range::Clear,
            _ => beam,
        };
        match side {
            Side::Left => Diagonals { ne: near(ranges.ne), se: near(ranges.se), ..*ranges },
            Side::Right => Diagonals { nw: near(ranges.nw), sw: near(ranges.sw), ..*ranges },
        }
    }
}
