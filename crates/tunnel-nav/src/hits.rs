//! The places where the beams met walls a moment ago.
//!
//! Four beams at 45° do not see what is beside the drone and right before it: a corner that a beam has
//! passed stands between two of them while the drone flies by, and with it everything that can be
//! touched. So the last hits near the drone are kept, by dead reckoning over a few metres, and the drone
//! flies no nearer to them than it may.

use core::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_4};

use units::{Metres, Radians};

use crate::plane::{Vec2, distance, turned};
use crate::{Diagonals, Range};

/// The hits that are kept; more than a corner shows within [`KEPT`].
const HITS: usize = 24;
/// Hits farther away than this are of no use, m: the drone flies that far in a few seconds.
const KEPT: f32 = 1.2;
/// A hit is new where it is farther than this from all others, m. This number and those below are our own,
/// chosen by drawn places.
const NEW: f32 = 0.08;
/// A hit is forgotten after so many iterations, 20 s, in which a hovering drone drifts by some
/// centimetres.
const FORGOTTEN: u8 = 100;
/// A beam within this angle of a hit shows whether it is still there, as the sine: 10°, …
const SEEN_WITHIN: f32 = 0.17;
/// … where it reaches so much farther, m.
const FARTHER: f32 = 0.15;
/// The drone slows down towards a hit that is nearer than this, m, …
const SLOWS: f32 = 0.32;
/// … and flies no nearer than this, m: the drone is a disc of 0.08 m (`radius_m` of the simulator's vehicle),
/// and the place errs by as much.
const NEAREST: f32 = 0.18;
/// The speed at which it may come nearer to a hit from where it begins to slow down, m/s.
const FASTEST: f32 = 0.4 * FRAC_1_SQRT_2;

/// A place, or none: an empty one is all zeros, so that a new navigator is cleared and not copied.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Hit {
    at: Vec2,
    /// The iterations for which it is still kept; 0 where there is none.
    left: u8,
}

impl Hit {
    const NONE: Self = Self { at: [0.0; 2], left: 0 };
}

/// The hits, and the drone among them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hits {
    hits: [Hit; HITS],
    /// The position of the drone by dead reckoning, m, and its heading by gyroscope, rad.
    at: Vec2,
    heading: Option<Radians>,
}

impl Default for Hits {
    fn default() -> Self {
        Self::new()
    }
}

impl Hits {
    pub(crate) const fn new() -> Self {
        Self { hits: [Hit::NONE; HITS], at: [0.0; 2], heading: None }
    }

    /// Moves the drone by this way, forward and to the left, and keeps what its beams see.
    #[inline(never)]
    pub(crate) fn advance(
        &mut self,
        moved: [Metres; 2],
        heading: Option<Radians>,
        ranges: &Diagonals,
    ) {
        let Some(heading) = heading.filter(|heading| heading.0.is_finite()) else {
            self.heading = None;
            self.hits.fill(Hit::NONE);
            return;
        };
        self.heading = Some(heading);
        let [x, y] = turned(moved.map(|way| way.0), heading);
        self.at = [self.at[0] + x, self.at[1] + y];
        for hit in &mut self.hits {
            let is_near = distance(hit.at, self.at) < KEPT;
            hit.left = if is_near { hit.left.saturating_sub(1) } else { 0 };
        }
        let beams = [(ranges.nw, 1.0), (ranges.ne, -1.0), (ranges.sw, 3.0), (ranges.se, -3.0)];
        for (beam, eighths) in beams {
            let direction = turned([1.0, 0.0], Radians(heading.0 + eighths * FRAC_PI_4));
            self.look(beam, direction);
        }
    }

    /// Forgets the hits through which this beam reaches, and keeps its own.
    fn look(&mut self, beam: Range, direction: Vec2) {
        if beam == Range::Invalid {
            return;
        }
        let length = beam.length().unwrap_or(KEPT);
        for hit in &mut self.hits {
            let [x, y] = [hit.at[0] - self.at[0], hit.at[1] - self.at[1]];
            let along = x * direction[0] + y * direction[1];
            let beside = (x * direction[1] - y * direction[0]).abs();
            if along > 0.0 && beside < SEEN_WITHIN * along && along + FARTHER < length {
                hit.left = 0;
            }
        }
        if length >= KEPT {
            return;
        }
        let at = [self.at[0] + length * direction[0], self.at[1] + length * direction[1]];
        let mut known = self.hits.iter_mut().filter(|hit| hit.left > 0);
        if let Some(hit) = known.find(|hit| distance(hit.at, at) < NEW) {
            hit.left = FORGOTTEN;
            return;
        }
        let far = |hit: &Hit| if hit.left > 0 { distance(hit.at, self.at) } else { f32::INFINITY };
        let farthest = self.hits.iter_mut().reduce(|a, b| if far(b) > far(a) { b } else { a });
        if let Some(slot) = farthest {
            *slot = Hit { at, left: FORGOTTEN };
        }
    }

    /// This velocity, forward and to the left, without what of it leads nearer to a hit than the drone may
    /// come. Of the hits on either side the one counts that stands most in the way.
    #[inline(never)]
    pub(crate) fn keep_clear(&self, velocity: Vec2) -> Vec2 {
        let Some(heading) = self.heading else { return velocity };
        let [mut left, mut right] = [[0.0; 2]; 2];
        let (mut most_left, mut most_right) = (0.0, 0.0);
        for hit in self.hits.iter().filter(|hit| hit.left > 0) {
            let off = distance(hit.at, self.at);
            if off >= SLOWS || off <= 0.0 {
                continue;
            }
            let to = [(hit.at[0] - self.at[0]) / off, (hit.at[1] - self.at[1]) / off];
            let to = turned(to, Radians(-heading.0));
            let nearer = to[0] * velocity[0] + to[1] * velocity[1];
            let excess = nearer - ((off - NEAREST) / (SLOWS - NEAREST)).max(0.0) * FASTEST;
            let (worst, most) = match to[1] > 0.0 {
                true => (&mut left, &mut most_left),
                false => (&mut right, &mut most_right),
            };
            if excess > *most {
                (*worst, *most) = (to.map(|axis| excess * axis), excess);
            }
        }
        let forward = velocity[0] - left[0] - right[0];
        // Two hits in the way stop the drone, and do not turn it round.
        let forward = if velocity[0] > 0.0 { forward.max(0.0) } else { forward.min(0.0) };
        [forward, velocity[1] - left[1] - right[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EAST: Option<Radians> = Some(Radians(0.0));
    const CLEAR: Diagonals =
        Diagonals { nw: Range::Clear, ne: Range::Clear, sw: Range::Clear, se: Range::Clear };

    fn at(length: f32) -> Range {
        Range::At(Metres(length))
    }

    /// A drone that has flown east for 0.4 m past a corner, which its beam to the right has seen 0.15 m
    /// beside its path, and now has it abeam.
    fn beside_a_corner() -> Hits {
        let mut hits = Hits::new();
        hits.advance([Metres(0.0); 2], EAST, &Diagonals { ne: at(0.21), ..CLEAR });
        for _ in 0..3 {
            hits.advance([Metres(0.05), Metres(0.0)], EAST, &CLEAR);
        }
        hits
    }

    #[test]
    fn a_drone_keeps_clear_of_a_corner_that_no_beam_sees_any_more() {
        let [forward, lateral] = beside_a_corner().keep_clear([0.2, -0.1]);
        assert!((forward - 0.2).abs() < 0.01, "it flies on: {forward}");
        assert!(lateral.abs() < 0.01, "and no nearer: {lateral}");
        let away = beside_a_corner().keep_clear([0.2, 0.1]);
        assert_eq!(away, [0.2, 0.1]);
    }

    #[test]
    fn a_hit_through_which_a_beam_reaches_is_forgotten() {
        let mut hits = Hits::new();
        hits.advance([Metres(0.0); 2], EAST, &Diagonals { ne: at(0.21), ..CLEAR });
        hits.advance([Metres(0.0); 2], EAST, &CLEAR);
        assert_eq!(hits.keep_clear([0.1, -0.1]), [0.1, -0.1]);
    }

    #[test]
    fn hits_are_forgotten_in_time_and_without_a_heading() {
        let mut hits = beside_a_corner();
        for _ in 0..FORGOTTEN {
            hits.advance([Metres(0.0); 2], EAST, &CLEAR);
        }
        assert_eq!(hits.keep_clear([0.2, -0.1]), [0.2, -0.1]);
        let mut hits = beside_a_corner();
        hits.advance([Metres(0.0); 2], None, &CLEAR);
        assert_eq!(hits.keep_clear([0.2, -0.1]), [0.2, -0.1]);
    }

    #[test]
    fn one_hit_makes_no_drone_faster_and_lets_it_come_no_nearer_than_it_may() {
        for ahead in 0..60 {
            // The hit lies 0.21 m off, to the right ahead, and comes abeam and behind.
            let mut hits = Hits::new();
            hits.advance([Metres(0.0); 2], EAST, &Diagonals { ne: at(0.21), ..CLEAR });
            let flown = 0.005 * ahead as f32;
            let unseen = Diagonals { ne: Range::Invalid, se: Range::Invalid, ..CLEAR };
            hits.advance([Metres(flown), Metres(0.0)], EAST, &unseen);
            let to = [0.1485 - flown, -0.1485];
            let off = libm::hypotf(to[0], to[1]);
            for velocity in [[0.4, 0.0], [-0.2, 0.2], [0.2, -0.2], [-0.2, -0.2]] {
                let clear = hits.keep_clear(velocity);
                let speed = |v: Vec2| libm::hypotf(v[0], v[1]);
                assert!(speed(clear) <= speed(velocity) + 1e-6, "{velocity:?}: {clear:?}");
                let nearer = (to[0] * clear[0] + to[1] * clear[1]) / off;
                let most = FASTEST * ((off - NEAREST) / (SLOWS - NEAREST)).max(0.0);
                // Half a millimetre a second for the rounded place of the hit.
                assert!(nearer <= most + 5e-4, "{velocity:?} at {off}: {nearer} of {most}");
            }
        }
    }

    #[test]
    fn hits_on_both_sides_slow_a_drone_down_and_push_it_to_neither() {
        let mut hits = Hits::new();
        hits.advance([Metres(0.0); 2], EAST, &Diagonals { nw: at(0.2), ne: at(0.2), ..CLEAR });
        hits.advance([Metres(0.06), Metres(0.0)], EAST, &CLEAR);
        let [forward, lateral] = hits.keep_clear([0.4, 0.0]);
        assert!((0.0..0.25).contains(&forward) && lateral.abs() < 1e-6, "{forward}, {lateral}");
    }

    #[test]
    fn any_number_is_borne() {
        let mut hits = beside_a_corner();
        hits.advance([Metres(f32::NAN), Metres(0.0)], EAST, &CLEAR);
        let _ = hits.keep_clear([f32::NAN, 0.1]);
        hits.advance([Metres(0.0); 2], Some(Radians(f32::NAN)), &CLEAR);
        assert_eq!(hits.keep_clear([0.2, -0.1]), [0.2, -0.1]);
    }
}
