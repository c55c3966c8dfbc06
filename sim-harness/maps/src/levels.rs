//! Finds passages that lie above one another, which a floor plan would join.

use std::ops::Range;

/// Two passages that overlap in plan are apart where their heights differ by more than this, m: the
/// height of a tunnel.
pub(super) const APART: f64 = 3.0;

/// The distance between the places at which side galleries are compared, m.
const STEP: f64 = 1.0;
/// The distance between the places at which a route is compared with itself, m: half of the narrowest
/// passage, so that none is crossed between two places.
const FINE_STEP: f64 = 0.25;

/// Two places of one route whose passages would touch if the route were straight are parts of the same
/// passage; so are those that are farther along by this factor, as in a bend.
const BENT: f64 = 1.25;

/// A place on a passage, and half of the width there, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) at: [f64; 3],
    pub(super) half: f64,
}

/// The passages that are on the floor plan.
pub(super) struct Levels {
    /// Points of their lines, with half of the width there.
    points: Vec<([f64; 3], f64)>,
}

impl Levels {
    pub(super) const fn new() -> Self {
        Self { points: Vec::new() }
    }

    /// Adds a passage along these places with these half widths.
    pub(super) fn add(&mut self, line: &[[f64; 3]], halves: &[f64]) {
        self.points.extend(sampled(line, halves));
    }

    /// Whether a passage overlaps one that is above or below it.
    pub(super) fn clash(&self, line: &[[f64; 3]], halves: &[f64]) -> bool {
        let meets = |(a, half_a): &([f64; 3], f64)| {
            self.points
                .iter()
                .any(|(b, half_b)| flat(*a, *b) < half_a + half_b && (a[2] - b[2]).abs() > APART)
        };
        sampled(line, halves).iter().any(meets)
    }
}

/// Two legs of one route, by the numbers of their first places, the later of which passes above or below
/// the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Overlap {
    pub(super) leg: usize,
    pub(super) other: usize,
    /// How much higher the later leg is there, m.
    pub(super) higher: f64,
}

/// The part of a route that does not pass above or below itself, by its places, and the overlap that
/// ends it, or else the first of those before it.
pub(super) struct Level {
    pub(super) kept: Range<usize>,
    pub(super) overlap: Option<Overlap>,
}

/// The part from the beginning up to the first overlap.
pub(super) fn beginning(route: &[Place]) -> Level {
    let legs = Legs::of(route);
    let overlap = (1..legs.0.len()).find_map(|leg| legs.overlap(leg, 0));
    let end = overlap.map_or(route.len(), |overlap| overlap.leg + 1);
    Level { kept: 0..end, overlap }
}

/// The longest part without an overlap, the first of several.
pub(super) fn longest(route: &[Place]) -> Level {
    let legs = Legs::of(route);
    let length =
        |kept: &Range<usize>| legs.0[kept.clone()].iter().map(|leg| leg.length).sum::<f64>();
    let (mut first, mut start, mut best) = (None, 0, 0..0);
    for leg in 0..legs.0.len() {
        if let Some(overlap) = legs.overlap(leg, start) {
            first = first.or(Some(overlap));
            start = overlap.other + 1;
        }
        if length(&(start..leg + 1)) > length(&best) {
            best = start..leg + 1;
        }
    }
    let at_end = if best.end < legs.0.len() { legs.overlap(best.end, best.start) } else { None };
    Level { kept: best.start..(best.end + 1).min(route.len()), overlap: at_end.or(first) }
}

/// The legs of a route, each with places on it.
struct Legs(Vec<Leg>);

struct Leg {
    /// Places on the leg, and how far each is along the plan of the route, m.
    places: Vec<(Place, f64)>,
    /// The length of the plan, m.
    length: f64,
}

impl Legs {
    fn of(route: &[Place]) -> Self {
        let mut along = 0.0;
        let leg = |pair: &[Place]| {
            let [from, to] = [pair[0], pair[1]];
            let length = flat(from.at, to.at);
            let steps = (length / FINE_STEP).clamp(1.0, 4000.0).ceil() as u32;
            let place = |step: u32| {
                let part = f64::from(step) / f64::from(steps);
                let between = |a: f64, b: f64| a + part * (b - a);
                let at = [0, 1, 2].map(|axis| between(from.at[axis], to.at[axis]));
                (Place { at, half: between(from.half, to.half) }, along + part * length)
            };
            let places = (0..=steps).map(place).collect();
            along += length;
            Leg { places, length }
        };
        Self(route.windows(2).map(leg).collect())
    }

    /// The overlap of a leg with the last one that it overlaps, of those from `first` on.
    fn overlap(&self, leg: usize, first: usize) -> Option<Overlap> {
        (first..leg).rev().find_map(|other| {
            let higher = self.0[leg].above(&self.0[other])?;
            Some(Overlap { leg, other, higher })
        })
    }
}

impl Leg {
    /// How much higher this leg is than another of the same route where it passes above or below it.
    fn above(&self, other: &Self) -> Option<f64> {
        let pairs = self.places.iter().flat_map(|a| other.places.iter().map(move |b| (a, b)));
        let mut clashes = pairs.filter_map(|((a, along_a), (b, along_b))| {
            let (reach, higher) = (a.half + b.half, a.at[2] - b.at[2]);
            let is_elsewhere = (along_a - along_b).abs() > BENT * reach;
            let clash = higher.abs() > APART && is_elsewhere && flat(a.at, b.at) < reach;
            clash.then_some(higher)
        });
        clashes.next()
    }
}

/// The distance of two places in the plan, m.
fn flat(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Points along a line.
fn sampled(line: &[[f64; 3]], halves: &[f64]) -> Vec<([f64; 3], f64)> {
    let pairs = line.windows(2).zip(halves);
    let points = pairs.flat_map(|(pair, &half)| {
        let [from, to] = [pair[0], pair[1]];
        let steps = (flat(from, to) / STEP).clamp(1.0, 1000.0) as u32;
        (0..=steps).map(move |step| {
            let part = f64::from(step) / f64::from(steps);
            ([0, 1, 2].map(|axis| from[axis] + part * (to[axis] - from[axis])), half)
        })
    });
    points.collect()
}
