//! Draws the main gallery of a place: its legs, its bends, and its widths.

use random::Stream;

use super::super::plane::{Point, along, apart, distance, dot, minus, turned};
use super::{Choice, Piece, Wanted, between};
use units::Branch;

/// How the bends of a gallery follow each other.
#[derive(Clone, Copy, PartialEq)]
enum Style {
    Wandering,
    RightAngles,
    Hairpins,
    Spiral,
}

/// The bends of a gallery are no less than 20 and no more than 150 degrees: our own bound.
const BENDS: [f32; 2] = [20.0, 150.0];
/// Legs are no shorter and no longer than these, m: our own bound.
const LEGS: [f32; 2] = [3.0, 25.0];
/// Galleries are no narrower and no wider than these, m: our own bound.
const WIDTHS: [f32; 2] = [0.8, 3.0];
/// A bend by more than this in a gallery wider than [`WIDE`] is drawn as two bends, since the outer
/// wall of a bend is a sharp corner that would be deeper than the beams reach.
const SHARP_DEG: f32 = 100.0;
const WIDE: f32 = 1.3;
/// The first bend is at least so far behind the row in which the drones stand, m: a drone that starts
/// in a bend knows neither of its galleries (docs/src/navigation.md), and operators do not lay their
/// drones out there.
const BEHIND_ROW: f32 = 2.5;
/// How often a leg is drawn again that does not fit.
const TRIES: usize = 12;

/// The main gallery.
pub(in super::super) struct Legs {
    /// The points of the centre-line, and the width at each.
    pub(super) points: Vec<(Point, f32)>,
    /// The bends, after the base and before the end.
    pub(super) corners: Vec<Point>,
    pub(super) pieces: Vec<Piece>,
    /// The directions of the legs.
    pub(super) directions: Vec<Point>,
    length: f32,
}

impl Legs {
    pub(super) fn draw(random: &mut Stream, wanted: &Wanted, choice: Choice) -> Option<Self> {
        let style = match random.uniform() {
            u if u < 0.55 => Style::Wandering,
            u if u < 0.75 => Style::RightAngles,
            u if u < 0.88 => Style::Hairpins,
            _ => Style::Spiral,
        };
        let count = 2 + random.below(7) as usize;
        let heading = between(random, 0.0, core::f32::consts::TAU);
        let first = [libm::cosf(heading), libm::sinf(heading)];
        let width = draw_width(random);
        let mut legs = Self {
            points: vec![([0.0, 0.0], width)],
            corners: vec![[0.0, 0.0]],
            pieces: Vec::new(),
            directions: Vec::new(),
            length: 0.0,
        };
        let mut side = if random.uniform() < 0.5 { 1.0 } else { -1.0 };
        for leg in 0..count {
            if leg > 0 {
                side = next_side(random, style, choice, leg, side);
            }
            let tries = if leg == 0 { 1 } else { TRIES };
            let went = (0..tries).any(|_| legs.extend(random, wanted, style, choice, first, side));
            if !went {
                break;
            }
        }
        (legs.directions.len() >= 2).then_some(legs)
    }

    /// Draws one more leg; says whether it fits.
    fn extend(
        &mut self,
        random: &mut Stream,
        wanted: &Wanted,
        style: Style,
        choice: Choice,
        first: Point,
        side: f32,
    ) -> bool {
        let leg = self.directions.len();
        let Some(&(at, width)) = self.points.last() else { return false };
        let least = if leg == 0 { wanted.row_m + BEHIND_ROW } else { LEGS[0] };
        let stretch = random.uniform();
        let length = (LEGS[0] + (LEGS[1] - LEGS[0]) * stretch * stretch).max(least);
        let degrees = bend(random, style, choice, leg);
        let Some(&before) = self.directions.last() else {
            return self.first_leg(random, wanted, first, length, leg);
        };
        let half_turn = libm::sincosf(0.5 * side * degrees.to_radians());
        let between = turned(before, half_turn);
        let direction = turned(between, half_turn);
        let is_cut = degrees > SHARP_DEG && width > WIDE;
        let cut = if is_cut { 0.9 * width + 0.3 } else { 0.0 };
        let starts = along(at, between, cut);
        let mut pieces = Vec::new();
        if is_cut {
            pieces.push(Piece { line: [at, starts], half: 0.5 * width, leg });
        }
        let points = leg_points(random, starts, direction, width, length);
        let widest = points.iter().map(|(_, width)| *width).fold(width, f32::max);
        let end = along(starts, direction, length);
        pieces.push(Piece { line: [starts, end], half: 0.5 * widest, leg });
        let fits = self.length + cut + length <= wanted.longest_m
            && has_room_for_bend(width, degrees, is_cut, length)
            && self.leaves_rock(&pieces, wanted.rock_m, before, at, degrees, width);
        if fits {
            if is_cut {
                self.points.push((starts, width));
            }
            self.points.extend(points);
            self.corners.push(end);
            self.pieces.extend(pieces);
            self.directions.push(direction);
            self.length += cut + length;
        }
        fits
    }

    fn first_leg(
        &mut self,
        random: &mut Stream,
        wanted: &Wanted,
        direction: Point,
        length: f32,
        leg: usize,
    ) -> bool {
        let Some(&(at, width)) = self.points.last() else { return false };
        let length = length.min(0.6 * wanted.longest_m).max(wanted.row_m + BEHIND_ROW);
        let points = leg_points(random, at, direction, width, length);
        let widest = points.iter().map(|(_, width)| *width).fold(width, f32::max);
        let end = along(at, direction, length);
        self.points.extend(points);
        self.corners.push(end);
        self.pieces.push(Piece { line: [at, end], half: 0.5 * widest, leg });
        self.directions.push(direction);
        self.length += length;
        true
    }

    /// Whether pieces of a new leg leave rock to all but the leg that they begin at, and the outer
    /// corner of the bend to them.
    fn leaves_rock(
        &self,
        pieces: &[Piece],
        rock_m: f32,
        before: Point,
        at: Point,
        degrees: f32,
        width: f32,
    ) -> bool {
        let Some(new) = pieces.last() else { return false };
        let others = || self.pieces.iter().filter(|piece| piece.leg + 1 < new.leg);
        let outer = 0.5 * width / libm::cosf(0.5 * degrees.min(SHARP_DEG + 50.0).to_radians());
        let onwards = minus(new.line[1], new.line[0]);
        let length = distance(new.line[0], new.line[1]);
        let bisector = [before[0] - onwards[0] / length, before[1] - onwards[1] / length];
        let size = dot(bisector, bisector).sqrt().max(1e-6);
        let tip = along(at, bisector, outer / size);
        let corner_is_clear =
            others().all(|other| apart(other.line, [at, tip]) - other.half >= rock_m.min(0.8));
        corner_is_clear
            && pieces
                .iter()
                .all(|piece| others().all(|other| other.rock_to(piece.line, piece.half) >= rock_m))
    }
}

/// To which side a gallery bends next: 1 for left.
fn next_side(random: &mut Stream, style: Style, choice: Choice, leg: usize, side: f32) -> f32 {
    if let (1, Choice::Changed { then, .. }) = (leg, choice) {
        return if then == Branch::Left { 1.0 } else { -1.0 };
    }
    match style {
        Style::Wandering | Style::RightAngles if random.uniform() < 0.5 => -side,
        Style::Wandering | Style::RightAngles | Style::Spiral => side,
        Style::Hairpins => -side,
    }
}

/// By how much a gallery bends at the beginning of a leg, degrees.
fn bend(random: &mut Stream, style: Style, choice: Choice, leg: usize) -> f32 {
    if let (1, Choice::Changed { .. }) = (leg, choice) {
        return between(random, 60.0, 100.0);
    }
    match style {
        Style::Wandering => between(random, BENDS[0], 120.0),
        Style::RightAngles => 90.0,
        Style::Hairpins => between(random, 120.0, BENDS[1]),
        Style::Spiral => between(random, 60.0, 120.0),
    }
}

fn draw_width(random: &mut Stream) -> f32 {
    let u = random.uniform();
    WIDTHS[0] + (WIDTHS[1] - WIDTHS[0]) * u * u
}

/// The points of a leg after its first, with the widths: in some legs the gallery becomes wider or
/// narrower.
fn leg_points(
    random: &mut Stream,
    from: Point,
    direction: Point,
    width: f32,
    length: f32,
) -> Vec<(Point, f32)> {
    let mut points = Vec::new();
    let mut last = width;
    if length > 5.0 && random.uniform() < 0.4 {
        let next = draw_width(random);
        let taper = between(random, 0.3, 1.5);
        let at = between(random, 2.0, length - 2.0 - taper);
        points.push((along(from, direction, at), last));
        points.push((along(from, direction, at + taper), next));
        last = next;
    }
    points.push((along(from, direction, length), last));
    points
}

/// Whether the inner walls of a bend are no longer than half of the leg that follows.
fn has_room_for_bend(width: f32, degrees: f32, is_cut: bool, length: f32) -> bool {
    let bend = if is_cut { 0.5 * degrees } else { degrees };
    let tangent = libm::tanf(0.5 * bend.to_radians());
    0.5 * width * tangent + 0.3 < 0.5 * length
}
