//! The scan of a drone that stands before walls on new ground: it turns by a quarter, in which its four
//! beams sweep the whole circle, and then faces the way on.
//!
//! In a bend of more than a right angle the way on lies behind the drone's shoulder, and the beams of one
//! moment see no difference between it and the gallery by which the drone came. But where that gallery
//! leads the trail knows, and how wide it is the walls have shown: the way on is where the beams reach
//! farther than its walls would let them.

use core::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2, FRAC_PI_4, PI};

use units::Radians;

use crate::plane::wrapped;
use crate::steer::Side;
use crate::{Diagonals, Range};

/// The directions that are told apart, 10° each.
const BINS: usize = 36;
/// The angle from one direction to the next, rad.
const BIN: f32 = 2.0 * PI / BINS as f32;
/// So many iterations the drone stands before it scans: in other bends it has turned before. 3 s, our own
/// number.
const STANDS: u8 = 15;
/// The yaw rate of the sweep, rad/s: 9° in an iteration, so that no direction is left out.
const SWEEP: f32 = 0.8;
/// The drone faces the way on when its nose is off it by less than this, rad.
const FACES: f32 = 0.06;
/// The gain of the turn to the way on, in 1/s.
const GAIN: f32 = 1.5;
/// The way on is free for at least so far, m: the drone slows down for what is nearer than 0.45 m.
const FREE: f32 = 0.6;
/// The beams see at least so much farther there than the walls of the old gallery would let them, m.
const FARTHER: f32 = 0.3;
/// Half the width of a gallery of which the drone has not seen both walls, m: wider ones are out of reach.
const WIDE: f32 = 1.5;
/// Ranges count up to this one, the reach of the beams, m.
const SEEN: f32 = 2.0;
/// Directions are of one way where what they score differs by less than this, m.
const ALIKE: f32 = 0.3;
/// What a direction on the side that the pilot has chosen scores above the others, m: more than any range.
const CHOSEN: f32 = 3.0;
/// The unit in which ranges are kept, m.
const UNIT: f32 = 0.02;
/// A way home is free for at least so far in the mean, m: farther than the walls of a narrow gallery. Our
/// own number, as the next two.
const HOME_FREE: f32 = 1.0;
/// What the direction in which the path leads home scores, m, and the opposite one less than none; our own
/// number.
const PATH_SCORES: f32 = 0.25;
/// A way counts as tried within this angle, rad.
const TRIED_WITHIN: f32 = 0.8;

/// What the drone knows of the gallery by which it came.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Came {
    /// The angle from the nose to the direction in which the drone flew there.
    pub(crate) off: Radians,
    /// The length of the beams in its middle, in metres, or 0.
    pub(crate) centred: f32,
    /// The side on which the way on is looked for first.
    pub(crate) side: Option<Side>,
}

/// What the drone knows of the way home.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Home {
    /// The angle from the nose to where its path says that home is.
    pub(crate) off: Radians,
    /// The heading of the way that it has tried here, rad.
    pub(crate) tried: Option<f32>,
}

/// What a drone looks for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Seeks {
    /// The way on, for its nose, of a drone that came by this gallery.
    WayOn(Came),
    /// The way home, for its tail.
    WayHome(Home),
}

/// Why a drone would look round.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stands {
    /// It stands before a wall.
    pub(crate) before_wall: bool,
    /// It has not come on for long.
    pub(crate) is_stuck: bool,
}

/// The state of the scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scan {
    /// The drone flies, or has stood for so many iterations.
    Off {
        /// The iterations.
        stood: u8,
    },
    /// The drone turns and keeps what its beams see.
    Sweeping {
        /// The heading at the start, rad.
        from: f32,
        /// The direction of the old gallery, outward, or that of home by the path, rad.
        gallery: f32,
        /// The range in each direction, in units of 2 cm; 0 where none was measured.
        ranges: [u8; BINS],
        /// Whether it turns counter-clockwise.
        to_left: bool,
        /// Whether it looks for the way home.
        is_for_home: bool,
    },
    /// The drone turns to the way on, or back where there is none.
    Turning {
        /// The heading, rad.
        to: f32,
        /// Whether it has found a way.
        found: bool,
        /// Whether it has looked for the way home.
        is_for_home: bool,
    },
}

impl Default for Scan {
    fn default() -> Self {
        Self::new()
    }
}

impl Scan {
    pub(crate) const fn new() -> Self {
        Self::Off { stood: 0 }
    }

    /// Whether the drone turns on the spot.
    pub(crate) const fn is_on(&self) -> bool {
        !matches!(self, Self::Off { .. })
    }

    /// Whether the drone turns to a way that it has found.
    pub(crate) const fn has_found(&self) -> bool {
        matches!(self, Self::Turning { found: true, .. })
    }

    /// Whether the drone looks round for the way home.
    pub(crate) const fn is_for_home(&self) -> bool {
        matches!(
            self,
            Self::Sweeping { is_for_home: true, .. } | Self::Turning { is_for_home: true, .. }
        )
    }

    /// Ends the scan of a drone that is to fly elsewhere.
    pub(crate) fn stop(&mut self) {
        *self = Self::new();
    }

    /// Carries out one iteration for a drone with this heading, which stands before a wall or does not, and
    /// returns the yaw rate of a drone that turns on the spot.
    pub(crate) fn step(
        &mut self,
        beams: &Diagonals,
        heading: f32,
        stands: Stands,
        seeks: &Seeks,
    ) -> Option<f32> {
        match self {
            Self::Off { stood } => {
                *stood = if stands.before_wall { stood.saturating_add(1) } else { 0 };
                if *stood == STANDS || stands.is_stuck {
                    let off = match seeks {
                        Seeks::WayOn(came) => came.off,
                        Seeks::WayHome(home) => home.off,
                    };
                    let gallery = wrapped(heading + off.0);
                    let length = |beam: Range| beam.length().unwrap_or(f32::INFINITY);
                    let to_left = length(beams.nw) > length(beams.ne);
                    let is_for_home = matches!(seeks, Seeks::WayHome(_));
                    let ranges = [0; BINS];
                    *self = Self::Sweeping { from: heading, gallery, ranges, to_left, is_for_home };
                    return Some(0.0);
                }
                None
            }
            Self::Sweeping { from, gallery, ranges, to_left, is_for_home } => {
                note(ranges, beams, heading);
                if wrapped(heading - *from).abs() < FRAC_PI_2 {
                    return Some(if *to_left { SWEEP } else { -SWEEP });
                }
                let way = match seeks {
                    Seeks::WayOn(came) => way_on(ranges, *gallery, came),
                    Seeks::WayHome(home) => {
                        way_home(ranges, *gallery, home.tried).map(|way| wrapped(way + PI))
                    }
                };
                let is_for_home = *is_for_home;
                *self =
                    Self::Turning { to: way.unwrap_or(*from), found: way.is_some(), is_for_home };
                Some(0.0)
            }
            Self::Turning { to, .. } => {
                let off = wrapped(*to - heading);
                if off.abs() < FACES {
                    *self = Self::new();
                }
                Some(GAIN * off)
            }
        }
    }
}

/// Keeps what the beams see.
fn note(ranges: &mut [u8; BINS], beams: &Diagonals, heading: f32) {
    let all = [(beams.nw, 1.0), (beams.ne, -1.0), (beams.sw, 3.0), (beams.se, -3.0)];
    for (beam, eighths) in all {
        let units = match beam {
            Range::Invalid => continue,
            Range::Clear => u8::MAX,
            Range::At(length) => (length.0 / UNIT).clamp(1.0, 254.0) as u8,
        };
        let slot = ranges.get_mut(bin(heading + eighths * FRAC_PI_4));
        if let Some(slot) = slot {
            *slot = if *slot == 0 { units } else { units.min(*slot) };
        }
    }
}

/// The number of the direction in which this angle lies.
fn bin(angle: f32) -> usize {
    (libm::roundf(angle / BIN) as i32).rem_euclid(BINS as i32) as usize
}

/// The heading of the way on, if the ranges show one: the middle of the sector in which they reach farthest
/// beyond the walls of the old gallery. Its edge would lead past the inner corner, between two beams.
fn way_on(ranges: &[u8; BINS], gallery: f32, came: &Came) -> Option<f32> {
    let mut scores = [f32::NEG_INFINITY; BINS];
    for (number, score) in scores.iter_mut().enumerate() {
        let angle = wrapped(number as f32 * BIN);
        let off = wrapped(angle - gallery);
        let is_there = match came.side {
            Some(Side::Left) => off > 0.0,
            Some(Side::Right) => off < 0.0,
            None => true,
        };
        if let Some(farther) = farther(ranges, number, gallery, came.centred) {
            *score = if is_there { farther + CHOSEN } else { farther };
        }
    }
    middle_of_best(&scores)
}

/// The heading of the way home, if the ranges show one: where they reach far, if possible to where `home`
/// is by the path, and not where the drone has tried.
fn way_home(ranges: &[u8; BINS], home: f32, tried: Option<f32>) -> Option<f32> {
    let mut scores = [f32::NEG_INFINITY; BINS];
    for (number, score) in scores.iter_mut().enumerate() {
        let angle = wrapped(number as f32 * BIN);
        let within = |other: f32| wrapped(angle - other).abs();
        let (mut sum, mut count, mut free) = (0.0, 0.0, f32::INFINITY);
        for (_, range) in sector(ranges, number) {
            (sum, count, free) = (sum + range, count + 1.0, free.min(range));
        }
        let mean = sum / count;
        if count == 0.0 || free <= FREE || mean <= HOME_FREE {
            continue;
        }
        let by_path = PATH_SCORES * Radians(within(home)).sin_cos().1;
        let by_trial =
            if tried.is_some_and(|tried| within(tried) < TRIED_WITHIN) { CHOSEN } else { 0.0 };
        *score = mean + by_path - by_trial;
    }
    middle_of_best(&scores)
}

/// The directions of the sector of 30° around one in which a range was measured, and the ranges, m.
fn sector(ranges: &[u8; BINS], number: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
    [number + BINS - 1, number, number + 1].into_iter().filter_map(|direction| {
        let units = ranges.get(direction % BINS).copied().filter(|units| *units > 0)?;
        Some((direction, (UNIT * f32::from(units)).min(SEEN)))
    })
}

/// The middle of the directions around the best one that score alike.
fn middle_of_best(scores: &[f32; BINS]) -> Option<f32> {
    let at = |number: i32| {
        let slot = number.rem_euclid(BINS as i32) as usize;
        scores.get(slot).copied().unwrap_or(f32::NEG_INFINITY)
    };
    let best =
        (0..BINS as i32).fold(0, |best, number| if at(number) > at(best) { number } else { best });
    let least = at(best) - ALIKE;
    if !least.is_finite() {
        return None;
    }
    let run = |step: i32| (1..BINS as i32 / 2).take_while(|n| at(best + step * n) >= least).count();
    let middle = best as f32 + 0.5 * (run(1) as f32 - run(-1) as f32);
    Some(wrapped(middle * BIN))
}

/// How much farther the beams reach in the sector of 30° around a direction than the walls of the old gallery
/// would let them, in the mean, m; `None` where the sector is not free or they do not.
fn farther(ranges: &[u8; BINS], number: usize, gallery: f32, centred: f32) -> Option<f32> {
    let half = if centred > 0.0 { FRAC_1_SQRT_2 * centred } else { WIDE };
    let (mut farther, mut free) = (0.0, f32::INFINITY);
    for (direction, range) in sector(ranges, number) {
        let back = wrapped(wrapped(direction as f32 * BIN - 2.0 * PI - gallery) - PI).abs();
        let wall = if back < FRAC_PI_2 { half / Radians(back).sin_cos().0.max(0.05) } else { half };
        farther += (range - wall.min(SEEN)) / 3.0;
        free = free.min(range);
    }
    (free > FREE && farther > FARTHER).then_some(farther)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STANDING: Stands = Stands { before_wall: true, is_stuck: false };
    const CAME: Came = Came { off: Radians(0.0), centred: 0.7, side: None };

    /// What the beams see at the end of a gallery of 1 m that leads east, with open ways in these
    /// directions, in degrees.
    fn seen(open: &[i32]) -> [u8; BINS] {
        let mut ranges = [0; BINS];
        for (number, units) in ranges.iter_mut().enumerate() {
            let angle = number as f32 * BIN;
            let back = wrapped(angle - PI).abs();
            let wall = if back < FRAC_PI_2 { 0.5 / libm::sinf(back).max(0.05) } else { 0.4 };
            let is_open = open
                .iter()
                .any(|way| wrapped(angle - (*way as f32).to_radians()).abs() < 15_f32.to_radians());
            *units = (wall.min(2.0).max(if is_open { 1.8 } else { 0.0 }) / UNIT) as u8;
        }
        ranges
    }

    #[test]
    fn the_way_on_is_found_behind_the_shoulder() {
        for degrees in (-150..=150).step_by(10) {
            let to = way_on(&seen(&[degrees]), 0.0, &CAME).unwrap().to_degrees();
            assert!((to - degrees as f32).abs() <= 10.0, "{to} for {degrees}");
        }
    }

    #[test]
    fn a_dead_end_has_no_way_on() {
        assert_eq!(way_on(&seen(&[]), 0.0, &CAME), None);
        assert_eq!(way_on(&seen(&[180]), 0.0, &CAME), None);
        assert_eq!(way_on(&[0; BINS], 0.0, &CAME), None);
    }

    #[test]
    fn of_two_ways_the_drone_takes_the_one_on_its_side() {
        for (side, degrees) in [(Side::Left, 120.0), (Side::Right, -60.0)] {
            let came = Came { side: Some(side), ..CAME };
            let to = way_on(&seen(&[120, -60]), 0.0, &came).unwrap().to_degrees();
            assert!((to - degrees).abs() <= 10.0, "{to}");
        }
    }

    #[test]
    fn the_way_home_is_where_the_path_leads_and_not_where_the_drone_has_tried() {
        let ranges = seen(&[90, -100]);
        let to = |home: f32, tried: Option<f32>| {
            let tried = tried.map(f32::to_radians);
            way_home(&ranges, home.to_radians(), tried).unwrap().to_degrees()
        };
        let is_near = |a: f32, b: f32| (a - b).abs() <= 10.0;
        assert!(is_near(to(70.0, None), 90.0), "{}", to(70.0, None));
        assert!(is_near(to(-80.0, None), -100.0), "{}", to(-80.0, None));
        assert!(!is_near(to(70.0, Some(90.0)), 90.0), "{}", to(70.0, Some(90.0)));
        let dead_end = way_home(&seen(&[]), 0.0, Some(PI)).unwrap().to_degrees();
        assert!(is_near(dead_end.abs(), 180.0), "the only way, though tried: {dead_end}");
        assert_eq!(way_home(&[0; BINS], 0.0, None), None);
    }

    #[test]
    fn a_sweep_ends_and_the_drone_faces_the_way_on() {
        let (mut scan, mut heading) = (Scan::new(), 0.0_f32);
        let ranges = seen(&[130]);
        for _ in 0..60 {
            let beam = |degrees: f32| {
                let units = ranges[bin(heading + degrees.to_radians())];
                Range::measured(units::Metres(UNIT * f32::from(units)), units::Metres(2.0))
            };
            let beams =
                Diagonals { nw: beam(45.0), ne: beam(-45.0), sw: beam(135.0), se: beam(-135.0) };
            let came = Came { off: Radians(wrapped(-heading)), ..CAME };
            let was_on = scan.is_on();
            heading +=
                0.2 * scan.step(&beams, heading, STANDING, &Seeks::WayOn(came)).unwrap_or(0.0);
            if was_on && !scan.is_on() {
                let off = wrapped(wrapped(heading) - 130_f32.to_radians()).to_degrees();
                assert!(off.abs() < 20.0, "{off}");
                return;
            }
        }
        panic!("it turns for ever");
    }
}
