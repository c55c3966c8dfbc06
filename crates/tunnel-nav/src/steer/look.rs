//! Looks round for the way on, on new ground, and for the way home.

use core::f32::consts::PI;

use units::MetresPerSecond;

use super::{BEFORE_BEND, BLOCKED, Bearings, HOVERING, NEAR_END, Navigator};
use crate::Diagonals;
use crate::plane::wrapped;
use crate::scan::{Came, Home, Seeks, Stands};

/// A path that has not grown for this many iterations does not grow by itself: 25 s, in which a drone flies
/// 1.2 m at the least speed.
const STUCK: u8 = 125;
/// A drone that has looked round, and still stands there so many iterations later, looks round again: 15 s, in
/// which it flies out of the bend at the least speed. Our own number.
const RESTS: u8 = 75;

impl Navigator {
    /// Whether the drone has flown to and fro at the end of its path for so long that it does not find the way
    /// on by itself.
    fn is_stuck(&mut self, speed: MetresPerSecond) -> bool {
        let end = self.trail.last();
        if end > self.farthest || end < self.farthest - NEAR_END {
            (self.farthest, self.idle) = (end, 0);
        }
        if speed.0 < -HOVERING || self.company.is_ahead(speed.0) || self.scan.is_on() {
            self.idle = 0;
        } else if speed.0 > HOVERING && self.trail.is_near_end(NEAR_END) {
            self.idle = self.idle.saturating_add(1);
        }
        self.idle > STUCK
    }

    /// The yaw rate of a drone that stands before walls on new ground and looks round for the way on.
    pub(super) fn look_round(
        &mut self,
        ranges: &Diagonals,
        nearness: f32,
        off: Option<f32>,
        bearings: &Bearings,
        speed: MetresPerSecond,
    ) -> Option<f32> {
        let heading = bearings.known_heading();
        let end = self.trail.last();
        self.looked = self.looked.filter(|looked| (looked - end).abs() < NEAR_END);
        let is_stuck = self.is_stuck(speed);
        // In a dead end it does not turn again.
        self.rests -= u8::from((1..u8::MAX).contains(&self.rests));
        if self.looked.is_some() && self.rests > 0 {
            return None;
        }
        // A pilot who pauses interrupts no scan.
        if speed.0.abs() <= HOVERING {
            return None;
        }
        // The scan of a drone that flies tail first is the other one's, below.
        if speed.0 < -HOVERING {
            return None;
        }
        let is_at_end = off.is_none() || is_stuck;
        let (Some(heading), true) = (heading, is_at_end) else {
            self.scan.stop();
            return None;
        };
        if self.scan.is_for_home() {
            // A sweep for the way home has kept where home is, and not where the gallery leads.
            self.scan.stop();
        }
        let (was_on, has_found) = (self.scan.is_on(), self.scan.has_found());
        let side = self.fork.side().or(self.led_back.map(|(side, _)| side.opposite()));
        let came = Came { off: self.trail.off(-BEFORE_BEND), centred: self.centred, side };
        let stands = Stands { before_wall: nearness < BLOCKED, is_stuck };
        let yaw_rate = self.scan.step(ranges, heading.0, stands, &Seeks::WayOn(came));
        if was_on && !self.scan.is_on() {
            self.trail.face();
            self.looked = Some(self.trail.last());
            self.rests = if has_found { RESTS } else { u8::MAX };
            self.idle = 0;
        }
        yaw_rate
    }

    /// The yaw rate of a drone that flies tail first, has not come on for long and looks round for the way
    /// home. It flies on there by the walls, and by its path, on which it finds its place again.
    #[inline(never)]
    pub(super) fn look_for_home(
        &mut self,
        ranges: &Diagonals,
        bearings: &Bearings,
        speed: MetresPerSecond,
    ) -> Option<f32> {
        let heading = bearings.known_heading()?;
        // A drone waits at zero speed while the next drone homeward is so near. One that may fly, and sees
        // a drone by its tail beams all the same, sees the drone in front: its tail points away from home.
        let has_turned = self.fork.is_homing() && self.company.is_ahead(speed.0);
        let flies = (self.fork.is_last_home() || has_turned) && speed.0 < -HOVERING;
        let is_lost = self.lost.step(self.trail.at(), flies);
        if !flies {
            if speed.0 < -HOVERING {
                self.scan.stop();
            }
            return None;
        }
        if self.scan.is_on() && !self.scan.is_for_home() {
            // A sweep for the way on has kept where the old gallery leads, and not where home is.
            self.scan.stop();
        }
        let (was_on, has_found) = (self.scan.is_on(), self.scan.has_found());
        if !was_on && !is_lost {
            return None;
        }
        let home = Home { off: self.trail.home(), tried: self.lost.tried(self.trail.at()) };
        let stands = Stands { before_wall: false, is_stuck: is_lost };
        let yaw_rate = self.scan.step(ranges, heading.0, stands, &Seeks::WayHome(home));
        if was_on && !self.scan.is_on() {
            if has_found {
                self.trail.rejoin();
                self.forget_walls();
            }
            self.lost.take(self.trail.at(), wrapped(heading.0 + PI));
        }
        yaw_rate
    }
}

#[cfg(test)]
mod tests {
    use units::{Metres, Radians};

    use super::*;
    use crate::{Guide, Homing, Range};

    /// A drone that has begun to look round at the end of a gallery.
    fn looking_for(seeks: &Seeks) -> (Navigator, Diagonals, Bearings) {
        let (wall, open) = (Range::At(Metres(0.5)), Range::Clear);
        let ranges = Diagonals { nw: wall, ne: wall, sw: open, se: open };
        let bearings = Bearings { heading: Some(Radians(0.3)), ..Bearings::default() };
        let mut drone = Navigator::new();
        drone.scan.step(&ranges, 0.3, Stands { before_wall: true, is_stuck: true }, seeks);
        assert!(drone.scan.is_on());
        (drone, ranges, bearings)
    }

    #[test]
    fn a_drone_that_is_called_home_while_it_looks_for_the_way_on_flies_home_by_its_path() {
        let came = Came { off: Radians(0.0), centred: 0.7, side: None };
        let (mut drone, ranges, bearings) = looking_for(&Seeks::WayOn(came));
        drone.guide(Guide { homing: Homing::Last, ..Guide::NONE });
        let yaw_rate = drone.look_for_home(&ranges, &bearings, MetresPerSecond(-0.2));
        assert_eq!((yaw_rate, drone.scan.is_on()), (None, false));
    }

    #[test]
    fn a_drone_that_is_sent_on_while_it_looks_for_the_way_home_looks_round_anew() {
        let home = Home { off: Radians(PI), tried: None };
        let (mut drone, ranges, bearings) = looking_for(&Seeks::WayHome(home));
        drone.look_round(&ranges, 1.0, None, &bearings, MetresPerSecond(0.2));
        assert!(!drone.scan.is_on());
    }
}
