//! Ends the dither of a drone without walls at its sides, which turns to the left in one round and to the
//! right in the next.
//!
//! [`turn_to_open`](super::Navigator::turn_to_open) turns at the full rate, away from the nearer of the leading
//! beams. That finds the way on before a wall. But where the beams meet the two walls of a gallery, which the
//! drone does not know yet because its rear beams still look into the hall or the junction behind it, a turn
//! to either side makes the other one right a round later: the drone turns to and fro, at a third of its
//! speed, and the walls never stand still for long enough to be taken for walls. A drone whose turns change
//! sides flies straight on between the two for a while instead.

use units::Metres;

use super::{BLOCKED, NavConfig, Navigator, OneWay, Walls, nearest};
use crate::{Diagonals, Range};

/// What a change of sides counts, and what a round without one takes from it.
const CHANGE: u8 = 4;
/// The drone dithers from this count on: three changes in a second.
const DITHERS: u8 = 9;
/// It flies straight on for so far, m: half of a narrow gallery, over which walls are confirmed.
const HOLDS: f32 = 0.5;

/// Whether a drone dithers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Dither {
    /// The sign of the last turn.
    sign: f32,
    changes: u8,
    /// Where it began to fly straight on.
    since: Option<Metres>,
}

impl Dither {
    pub(super) const fn new() -> Self {
        Self { sign: 0.0, changes: 0, since: None }
    }

    /// Notes that a drone at `way` would turn at `yaw_rate`, and says whether it is to fly straight on
    /// instead. A drone that a wall stops turns.
    pub(super) fn step(&mut self, way: Metres, yaw_rate: f32, is_blocked: bool) -> bool {
        if yaw_rate != 0.0 {
            let is_change = yaw_rate * self.sign < 0.0;
            self.changes = match is_change {
                true => (self.changes + CHANGE).min(2 * DITHERS),
                false => self.changes.saturating_sub(1),
            };
            self.sign = yaw_rate;
        }
        if self.since.is_none() && self.changes >= DITHERS {
            (self.since, self.changes) = (Some(way), 0);
        }
        self.since = self.since.filter(|since| !is_blocked && (way - *since).0.abs() < HOLDS);
        self.since.is_some()
    }
}

impl Navigator {
    /// Makes a drone that dithers between two beams fly straight on between them.
    pub(super) fn end_dither(
        &mut self,
        config: &NavConfig,
        ranges: &Diagonals,
        ahead: &mut OneWay,
    ) {
        let yaw_rate = if ahead.walls == Walls::Neither { ahead.yaw_rate } else { 0.0 };
        if self.dither.step(self.way, yaw_rate, ahead.nearness < BLOCKED)
            && ahead.walls == Walls::Neither
        {
            let within = |beam: Range| nearest(beam).min(self.centred);
            let aside = within(ranges.nw) - within(ranges.ne);
            (ahead.lateral, ahead.yaw_rate) =
                (config.lateral_gain * aside, config.yaw_gain * aside);
            ahead.pace = ahead.nearness;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rounds of ten in which a drone that would turn so flies straight on.
    fn straight_on(turns: [f32; 10]) -> usize {
        let mut dither = Dither::new();
        turns.iter().filter(|turn| dither.step(Metres(1.0), **turn, false)).count()
    }

    #[test]
    fn a_drone_that_turns_to_and_fro_flies_straight_on() {
        let turns = [1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, -1.0];
        assert_eq!(straight_on(turns), 7);
        assert_eq!(straight_on([1.0; 10]), 0);
        // A bend to one side and the next one to the other.
        assert_eq!(straight_on([1.0, 1.0, 1.0, 0.0, 0.0, -1.0, -1.0, -1.0, -1.0, 1.0]), 0);
    }

    #[test]
    fn a_drone_that_flies_straight_on_does_so_for_half_a_metre_and_not_into_a_wall() {
        let dithers = || {
            let mut dither = Dither::new();
            for turn in [1.0, -1.0, 1.0, -1.0] {
                dither.step(Metres(2.0), turn, false);
            }
            dither
        };
        assert!(dithers().step(Metres(2.4), 0.0, false));
        assert!(!dithers().step(Metres(2.6), 0.0, false));
        assert!(!dithers().step(Metres(2.1), 1.0, true));
    }
}
