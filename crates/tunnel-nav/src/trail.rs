//! The trail: the heading of the nose along the last metres of way.
//!
//! In the middle of a right-angle bend all four beams are equal, whichever of the two galleries the
//! drone is aligned with: the ranges of one moment cannot tell forward from sideways. But a relay
//! that hovers in a bend has flown there, and its gyro kept the heading. The trail holds the
//! heading at each 0.2 m of way; a drone that is about to fly over a stretch again with its nose
//! well off turns to the heading that it had there.
//!
//! The gyro drifts, by 5° to 10° a minute once the board has warmed up. Along walls the walls hold
//! the nose, so on a stretch that was flown before, the difference between the heading now and then
//! is the drift, and is corrected.

use units::{Metres, Radians};

/// The length of way that one heading stands for, m.
const BIN: f32 = 0.2;
/// The number of headings kept: 25.6 m of way. A relay needs a few metres of it to hover in a bend;
/// a drone that comes home past a junction needs all of the way since then.
const BINS: usize = 128;
/// The distance ahead along the way at which the trail is read, m.
const LOOK_AHEAD: f32 = 0.3;
/// A heading along walls that differs from the trail by less than this is the same but for drift,
/// rad. A larger difference does not change the trail: the drone is lost.
const SAME: f32 = 0.5;
/// The part of the difference that is taken for drift, each time: at 5 Hz two thirds of it in 20 s.
/// In that time the gyro drifts by 3°, and a nose that is late in a bend is straight again before
/// much of its lag has been taken for drift.
const FOLLOW: f32 = 0.01;

/// The heading of one stretch.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stretch {
    bin: i32,
    heading: f32,
}

/// The headings of all stretches, and the drift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Trail {
    stretches: [Option<Stretch>; BINS],
    /// The angle by which the gyro's heading has drifted since the start, rad.
    drift: f32,
}

impl Default for Trail {
    fn default() -> Self {
        Self::new()
    }
}

impl Trail {
    pub(crate) const fn new() -> Self {
        Self { stretches: [None; BINS], drift: 0.0 }
    }

    /// Records the heading after this way; `by_walls` says whether walls hold the nose.
    pub(crate) fn record(&mut self, way: Metres, heading: Radians, by_walls: bool) {
        let bin = bin_of(way.0);
        let heading = wrapped(heading.0 - self.drift);
        let Some(slot) = self.stretches.get_mut(slot_of(bin)) else { return };
        match slot {
            Some(known) if known.bin == bin => {
                let off = wrapped(heading - known.heading);
                if by_walls && off.abs() < SAME {
                    self.drift = wrapped(self.drift + FOLLOW * off);
                }
            }
            _ => *slot = Some(Stretch { bin, heading }),
        }
    }

    /// The angle by which the nose is off the heading a little further on in this direction, if the
    /// drone has been there: positive when it must turn counter-clockwise.
    pub(crate) fn off(&self, way: Metres, forward: bool, heading: Radians) -> Option<Radians> {
        let ahead = if forward { way.0 + LOOK_AHEAD } else { way.0 - LOOK_AHEAD };
        let bin = bin_of(ahead);
        let known = (*self.stretches.get(slot_of(bin))?)?;
        let heading = wrapped(heading.0 - self.drift);
        (known.bin == bin).then(|| Radians(wrapped(known.heading - heading)))
    }
}

fn bin_of(way: f32) -> i32 {
    // Towards minus infinity; `as` saturates and turns NaN into zero.
    let bin = (way / BIN) as i32;
    if way < 0.0 { bin.saturating_sub(1) } else { bin }
}

fn slot_of(bin: i32) -> usize {
    bin.rem_euclid(BINS as i32) as usize
}

/// The same angle within half a turn, for angles within one and a half turns of zero, such as the
/// difference of two headings. By comparison: a remainder would link 2 kB of library code.
pub(crate) fn wrapped(angle: f32) -> f32 {
    use core::f32::consts::{PI, TAU};
    if angle > PI {
        angle - TAU
    } else if angle < -PI {
        angle + TAU
    } else {
        angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretch_is_known_once_flown_and_forgotten_far_away() {
        let mut trail = Trail::new();
        assert_eq!(trail.off(Metres(0.0), true, Radians(0.0)), None);
        trail.record(Metres(0.3), Radians(1.5), true);
        let off = trail.off(Metres(0.0), true, Radians(0.2)).unwrap();
        assert!((off.0 - 1.3).abs() < 1e-6);
        assert_eq!(trail.off(Metres(0.0), false, Radians(0.2)), None);
        // 25.6 m on, another stretch takes its place in memory.
        trail.record(Metres(25.9), Radians(0.0), true);
        assert_eq!(trail.off(Metres(0.0), true, Radians(0.2)), None);
    }

    #[test]
    fn a_lost_drone_does_not_spoil_the_memory() {
        let mut trail = Trail::new();
        trail.record(Metres(-0.1), Radians(0.0), true);
        for _ in 0..100 {
            trail.record(Metres(-0.1), Radians(2.0), true);
        }
        assert_eq!(trail.off(Metres(-0.4), true, Radians(0.0)), Some(Radians(0.0)));
        for _ in 0..500 {
            trail.record(Metres(-0.1), Radians(0.3), true); // the gyro drifts
        }
        let off = trail.off(Metres(-0.4), true, Radians(0.3)).unwrap();
        assert!(off.0.abs() < 0.01);
    }

    #[test]
    fn any_bits_are_borne() {
        let mut trail = Trail::new();
        for way in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -f32::MAX] {
            trail.record(Metres(way), Radians(way), true);
            let _ = trail.off(Metres(way), false, Radians(way));
        }
    }
}
