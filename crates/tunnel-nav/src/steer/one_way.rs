//! The command by which a drone keeps between walls, or along one, for one direction of flight: equations (17)
//! and (18), and the turn where no wall leads on.

use super::{BLOCKED, LEAST_PACE, Navigator, Side, Walls, nearest};
use crate::fork::Fork;
use crate::wall::{Beams, SAME_GALLERY, Wall};
use crate::{Diagonals, NavConfig, Range};

/// On known ground, where the path leads, only an obstacle nearer than this moves the drone aside, m along
/// the beam: the path leads round the inner corner of a bend at 0.38 m or more.
const ASIDE: f32 = 0.6;
/// An obstacle is beside the drone, and not ahead of it, where one leading beam is shorter than this
/// part of the other: both see a wall ahead, at up to 10° from square to it within 0.7.
const BESIDE: f32 = 0.5;
/// The path turns ahead where its heading there differs from that of the nose by more than this, rad.
const BENT: f32 = 0.35;
/// With no wall at its side a drone turns away from an obstacle that is nearer than this many times
/// the distance at which it would follow it.
const TURN_BELOW: f32 = 1.6;
/// A single wall is kept no farther than this part of the ranger's reach.
const WIDEST: f32 = 0.6;

/// The command for a drone that flies nose first.
pub(super) struct OneWay {
    pub(super) lateral: f32,
    pub(super) yaw_rate: f32,
    /// The sideways velocity that passes the obstacles before the leading beams.
    pub(super) sidestep: f32,
    /// The part of the speed that is safe before these obstacles, 0 to 1.
    pub(super) nearness: f32,
    /// The part of the speed that is safe for a drone that turns away from them, 0 to 1.
    pub(super) pace: f32,
    pub(super) walls: Walls,
}

impl Navigator {
    /// The walls to steer by. Where the tunnel opened to a side, a wall on that side alone is that of
    /// another gallery.
    pub(super) fn walls(&self, ranges: &Diagonals) -> (Option<Wall>, Option<Wall>) {
        let left = self.left.wall(Beams::new(ranges.nw, ranges.sw));
        let right = self.right.wall(Beams::new(ranges.ne, ranges.se));
        match (left, right, self.opening) {
            (Some(_), None, Some((Side::Left, _))) | (None, Some(_), Some((Side::Right, _))) => {
                (None, None)
            }
            _ => (left, right),
        }
    }

    /// The command for one direction of flight; `hint` is the angle by which the path turns there.
    pub(super) fn one_way(&self, config: &NavConfig, ranges: &Diagonals, hint: f32) -> OneWay {
        let (c_l, c_r) = (config.lateral_gain, config.yaw_gain);
        let (left, right) = self.walls(ranges);
        let ends = self.ends_towards(ranges, [left, right]);
        let keep = self.centred.max(config.wall_distance.0).min(WIDEST * config.reach.0);
        // The branch may be narrower than the gallery before: along the chosen wall alone the drone
        // keeps near it, until it sees both.
        let keep = match (left, right, self.fork.side()) {
            (Some(_), None, Some(Side::Left)) | (None, Some(_), Some(Side::Right)) => {
                keep.min(self.margin.nearest().unwrap_or(Fork::NEAR))
            }
            _ => keep,
        };
        // An obstacle that the beam over the lost wall sees nearer than the wall that is kept is
        // ahead, and the tunnel turns to the lost side. But where no side has opened, one that only
        // this beam sees is beside the drone, on that very side.
        let ahead = |over_lost: Range, over_kept: Range| {
            let turn = c_r * (keep - nearest(over_lost)).max(0.0);
            let is_beside =
                self.opening.is_none() && nearest(over_lost) < BESIDE * nearest(over_kept);
            if is_beside { -turn } else { turn }
        };
        // Where both beams over the lost wall end nearer than the wall that is kept, the gallery has become
        // narrower than the drone knows: it keeps the middle.
        let keep_by = |kept: f32, front: Range, rear: Range| {
            let other = nearest(front).max(nearest(rear));
            if other < kept { keep.min(0.5 * (kept + other)) } else { keep }
        };
        let turn = config.max_yaw_rate.0;
        let (lateral, yaw_rate, walls) = match (left, right) {
            // The gallery ends ahead and goes on at the side that has opened.
            _ if ends == Some(Side::Right) => (0.0, -turn, Walls::Neither),
            _ if ends == Some(Side::Left) => (0.0, turn, Walls::Neither),
            // Both leading beams end at a wall ahead: the gallery ends, and its sides are not seen ahead.
            (Some(l), Some(r)) if l.ends() && r.ends() => (0.0, 0.0, Walls::Both),
            // Equation (17).
            (Some(l), Some(r)) => {
                (c_l * (l.front - r.front), c_r * (l.excess() - r.excess()), Walls::Both)
            }
            // Equation (18), and its mirror image.
            (Some(l), None) => {
                let yaw_rate = 2.0 * c_r * l.excess() - ahead(ranges.ne, ranges.nw);
                let keep = keep_by(l.front, ranges.ne, ranges.se);
                (c_l * (l.front - keep), yaw_rate, Walls::One(Side::Left))
            }
            (None, Some(r)) => {
                let yaw_rate = -2.0 * c_r * r.excess() + ahead(ranges.nw, ranges.ne);
                let keep = keep_by(r.front, ranges.nw, ranges.sw);
                (c_l * (keep - r.front), yaw_rate, Walls::One(Side::Right))
            }
            (None, None) => (0.0, self.turn_to_open(config, ranges, hint), Walls::Neither),
        };
        let turns_away = walls == Walls::Neither && yaw_rate != 0.0;
        let most = if turns_away { LEAST_PACE } else { 1.0 };
        let nearness = pace(config, ranges);
        let near = if self.margin.is_kept() { keep } else { keep.min(ASIDE) };
        let within = |beam: Range| nearest(beam).min(near);
        let sidestep = c_l * (within(ranges.nw) - within(ranges.ne));
        let (lateral, yaw_rate) = match (self.margin.crossing(config, ranges), walls) {
            (Some(crossing), _) => (crossing.lateral, crossing.yaw_rate.unwrap_or(yaw_rate)),
            // On the way home the one wall may be that of a chamber, and hold the drone before the jamb of a throat.
            (None, Walls::One(_)) if nearness < BLOCKED && self.fork.is_homing() => {
                (sidestep, yaw_rate)
            }
            (None, _) => (lateral, yaw_rate),
        };
        OneWay { lateral, yaw_rate, sidestep, nearness, pace: nearness.min(most), walls }
    }

    /// The yaw rate with no wall to follow and an obstacle ahead: towards an open leading beam, else
    /// to the side that has opened, else to the side to which the end of the path turned, else
    /// towards the longer leading beam, or the preferred side where they are alike.
    fn turn_to_open(&self, config: &NavConfig, ranges: &Diagonals, hint: f32) -> f32 {
        let length = |beam: Range| nearest(beam).min(config.reach.0);
        let (left, right) = (length(ranges.nw), length(ranges.ne));
        // To fly straight on, the drone passes the corners of the galleries that cross.
        let turns_below = match self.fork.goes_straight() {
            true => config.slow_below.0,
            false => TURN_BELOW * config.wall_distance.0,
        };
        if left.min(right) > turns_below {
            return 0.0;
        }
        let is_open = |length: f32| length > SAME_GALLERY * self.centred;
        // Where nothing opens before a wall that both leading beams see the gallery ends, and no turn leads
        // on.
        let beams = [ranges.nw, ranges.ne, ranges.sw, ranges.se];
        let is_square = left.min(right) >= BESIDE * left.max(right);
        if self.opening.is_none() && is_square && beams.iter().all(|beam| !is_open(nearest(*beam)))
        {
            return 0.0;
        }
        // A front beam that looks past the corner of the bend ends there; where the rear beam of the side that
        // has opened looks far, that side leads on.
        let leads_on =
            |side: Side, rear: Range| self.bends_to == Some(side) && is_open(nearest(rear));
        let alike = (left - right).abs() < 0.1 * (left + right);
        let to_left = match (is_open(left), is_open(right), self.opening) {
            _ if self.led_back.is_some() => {
                self.led_back.is_some_and(|(side, _)| side == Side::Right)
            }
            (true, false, Some((Side::Right, _)))
                if leads_on(Side::Right, ranges.se) && left < config.reach.0 =>
            {
                false
            }
            (false, true, Some((Side::Left, _)))
                if leads_on(Side::Left, ranges.sw) && right < config.reach.0 =>
            {
                true
            }
            (true, false, _) => true,
            (false, true, _) => false,
            // An obstacle that one beam alone sees is beside the drone.
            _ if left < BESIDE * right => false,
            _ if right < BESIDE * left => true,
            (_, _, Some((side, _))) => side == Side::Left,
            _ if hint.abs() > BENT => hint > 0.0,
            _ if alike => self.fork.side().unwrap_or(config.prefer) == Side::Left,
            _ => left > right,
        };
        let turn = config.max_yaw_rate.0;
        if to_left { turn } else { -turn }
    }
}

/// The part of the speed that is safe before the obstacles that the leading beams see.
fn pace(config: &NavConfig, ranges: &Diagonals) -> f32 {
    if (ranges.nw, ranges.ne) == (Range::Invalid, Range::Invalid) {
        // A drone without a valid range does not fly.
        return 0.0;
    }
    let nearest = nearest(ranges.nw).min(nearest(ranges.ne));
    ((nearest - config.danger.0) / (config.slow_below.0 - config.danger.0)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use units::Metres;

    use super::*;
    use crate::wall::Track;
    use crate::{Guide, Homing};

    /// A drone on its way home before the jamb of a throat, nearer than 0.25 m to its rear right beam, which sees
    /// the left wall of the chamber alone: what the beams say of the turns to both sides cancels out.
    #[test]
    fn on_the_way_home_a_drone_before_the_jamb_of_a_throat_moves_off_it() {
        let at = |metres| Range::At(Metres(metres));
        let jamb = Diagonals { nw: at(1.7), ne: Range::Clear, sw: at(1.2), se: at(0.2) };
        let lateral = |homing| {
            let mut drone = Navigator::new();
            drone.centred = 1.39;
            (drone.left, drone.right) = (Track::Seen { length: 1.45 }, Track::LEFT_BEHIND);
            drone.guide(Guide { homing, ..Guide::NONE });
            drone.one_way(&NavConfig::DEFAULT, &jamb.seen_backwards(), 0.0).lateral
        };
        assert_eq!(lateral(Homing::No), 0.0);
        assert!(lateral(Homing::Followed) > 0.1, "{}", lateral(Homing::Followed));
        assert_eq!(lateral(Homing::Followed), lateral(Homing::Last));
    }
}
