//! Draws what a place has beside its legs: dead ends, forks and halls.

use random::Stream;

use super::super::plane::{Rectangle, Segment, along, dot, minus, turned};
use super::{Choice, DeadEnd, Legs, Wanted, between};
use units::Branch;

/// How often a feature is drawn again that does not fit.
const TRIES: usize = 8;
/// Dead ends are as long as that, m.
const DEAD_ENDS: Range = [2.0, 8.0];
/// The sides of halls, m: our own bound.
const HALLS: Range = [3.0, 9.0];
/// A side gallery is at least this far from a bend, m: four widths of a narrow gallery.
const FROM_BEND: f32 = 2.5;

/// The least and the most.
type Range = [f32; 2];

/// The dead ends that go with a choice; `None` where there is no room for one that must be there.
pub(super) fn dead_ends(
    random: &mut Stream,
    wanted: &Wanted,
    choice: Choice,
    legs: &Legs,
) -> Option<Vec<DeadEnd>> {
    let mut found = Vec::new();
    match choice {
        Choice::None => {}
        Choice::Changed { first, .. } => {
            let sign = sign(first);
            let fork = (0..TRIES).find_map(|_| {
                let degrees = between(random, 60.0, 100.0);
                at_corner(random, wanted, legs, 1, sign * degrees, &found, [2.0, 6.0])
            });
            found.push(fork?);
        }
        Choice::Always(Branch::Straight) => {
            for _ in 0..1 + random.below(2) {
                let sign = if random.uniform() < 0.5 { 1.0 } else { -1.0 };
                let side = (0..TRIES).find_map(|_| beside(random, wanted, legs, sign, &found));
                found.extend(side);
            }
        }
        Choice::Always(branch) => {
            for _ in 0..1 + random.below(2) {
                let fork = (0..TRIES).find_map(|_| match random.uniform() < 0.5 {
                    true => beside(random, wanted, legs, -sign(branch), &found),
                    false => fork(random, wanted, legs, branch, &found),
                });
                found.extend(fork);
            }
        }
    }
    Some(found)
}

const fn sign(branch: Branch) -> f32 {
    match branch {
        Branch::Left => 1.0,
        Branch::Right => -1.0,
        Branch::Straight => 0.0,
    }
}

/// A dead end straight ahead, or to the other side, where the gallery bends to the chosen one.
fn fork(
    random: &mut Stream,
    wanted: &Wanted,
    legs: &Legs,
    branch: Branch,
    others: &[DeadEnd],
) -> Option<DeadEnd> {
    let count = legs.directions.len();
    let corner = 1 + random.below(count.checked_sub(1)? as u32) as usize;
    let bends = bend_at(legs, corner)?;
    // Branches that part by less are no junction to a drone (docs/src/navigation.md).
    let is_chosen = bends.0 * sign(branch) > 0.0 && bends.1 < libm::cosf(45_f32.to_radians());
    if !is_chosen {
        return None;
    }
    let degrees = match random.uniform() < 0.5 {
        true => 0.0,
        false => -sign(branch) * between(random, 45.0, 90.0),
    };
    at_corner(random, wanted, legs, corner, degrees, others, DEAD_ENDS)
}

/// Sine and cosine of the bend before leg `corner`.
fn bend_at(legs: &Legs, corner: usize) -> Option<(f32, f32)> {
    let before = *legs.directions.get(corner.checked_sub(1)?)?;
    let behind = *legs.directions.get(corner)?;
    Some((before[0] * behind[1] - before[1] * behind[0], dot(before, behind)))
}

/// A dead end from the bend before leg `corner`, at this angle to the leg before.
fn at_corner(
    random: &mut Stream,
    wanted: &Wanted,
    legs: &Legs,
    corner: usize,
    degrees: f32,
    others: &[DeadEnd],
    [least, most]: Range,
) -> Option<DeadEnd> {
    let at = *legs.corners.get(corner)?;
    let before = *legs.directions.get(corner.checked_sub(1)?)?;
    let direction = turned(before, libm::sincosf(degrees.to_radians()));
    let width = between(random, 0.8, 1.6);
    let length = between(random, least, most);
    let line = [at, along(at, direction, length)];
    let meets = |leg: usize| leg + 1 == corner || leg == corner;
    is_clear(legs, others, line, width, wanted, meets).then_some(DeadEnd { line, width })
}

/// A dead end from the middle of a leg, to the side of this sign.
fn beside(
    random: &mut Stream,
    wanted: &Wanted,
    legs: &Legs,
    sign: f32,
    others: &[DeadEnd],
) -> Option<DeadEnd> {
    let leg = random.below(legs.directions.len() as u32) as usize;
    let piece = legs.pieces.iter().rfind(|piece| piece.leg == leg)?;
    let way = minus(piece.line[1], piece.line[0]);
    let length = dot(way, way).sqrt();
    let least = if leg == 0 { wanted.row_m + 1.0 } else { FROM_BEND };
    if length < least + FROM_BEND + 0.5 {
        return None;
    }
    let at = along(piece.line[0], legs.directions[leg], between(random, least, length - FROM_BEND));
    let degrees = sign * between(random, 60.0, 120.0);
    let direction = turned(legs.directions[leg], libm::sincosf(degrees.to_radians()));
    let width = between(random, 0.8, 1.6);
    let reach = piece.half + between(random, DEAD_ENDS[0], DEAD_ENDS[1]);
    let line = [at, along(at, direction, reach)];
    is_clear(legs, others, line, width, wanted, |other| other == leg)
        .then_some(DeadEnd { line, width })
}

/// Whether a dead end leaves rock to all but the legs that it meets.
fn is_clear(
    legs: &Legs,
    others: &[DeadEnd],
    line: Segment,
    width: f32,
    wanted: &Wanted,
    meets: impl Fn(usize) -> bool,
) -> bool {
    let half = 0.5 * width;
    // A gallery goes on beyond its line by half its width.
    let way = minus(line[1], line[0]);
    let length = dot(way, way).sqrt().max(1e-3);
    let line = [line[0], along(line[1], way, half / length)];
    let legs_are_clear = legs
        .pieces
        .iter()
        .filter(|piece| !meets(piece.leg))
        .all(|piece| piece.rock_to(line, half) >= wanted.rock_m);
    let apart = |other: &DeadEnd| {
        super::apart(other.line, line) - half - 0.5 * other.width >= wanted.rock_m
    };
    legs_are_clear && others.iter().all(apart)
}

/// Up to two halls.
pub(super) fn halls(
    random: &mut Stream,
    wanted: &Wanted,
    choice: Choice,
    legs: &mut Legs,
    dead_ends: &[DeadEnd],
) -> Vec<Rectangle> {
    let mut found: Vec<Rectangle> = Vec::new();
    let count = match random.uniform() {
        u if u < 0.60 => 0,
        u if u < 0.90 => 1,
        _ => 2,
    };
    for _ in 0..count {
        let hall = (0..TRIES).find_map(|_| hall(random, wanted, choice, legs, dead_ends, &found));
        found.extend(hall);
    }
    found
}

/// A hall round a straight stretch, or round a bend to the side that the pilot chooses.
fn hall(
    random: &mut Stream,
    wanted: &Wanted,
    choice: Choice,
    legs: &Legs,
    dead_ends: &[DeadEnd],
    others: &[Rectangle],
) -> Option<Rectangle> {
    let size = [between(random, HALLS[0], HALLS[1]), between(random, HALLS[0], HALLS[1])];
    let chosen = choice.leading().map_or(0.0, sign);
    let leg = random.below(legs.directions.len() as u32) as usize;
    let is_bend = chosen != 0.0 && leg > 0 && random.uniform() < 0.7;
    let (inside, legs_inside): (_, &[usize]) = if is_bend {
        let (sine, _) = bend_at(legs, leg)?;
        let is_fork = dead_ends.iter().any(|end| end.line[0] == legs.corners[leg]);
        if sine * chosen <= 0.0 || is_fork {
            return None;
        }
        (legs.corners[leg], &[leg - 1, leg])
    } else {
        let piece = legs.pieces.iter().rfind(|piece| piece.leg == leg)?;
        let way = minus(piece.line[1], piece.line[0]);
        (along(piece.line[0], way, between(random, 0.3, 0.7)), &[leg])
    };
    let reach = |size: f32| (0.5 * size - 1.2).max(0.0);
    let off = [reach(size[0]), reach(size[1])].map(|reach| between(random, -reach, reach));
    // Without a side, the drone flies straight through the middle.
    let off = if is_bend { off } else { [0.3 * off[0], 0.3 * off[1]] };
    let hall = Rectangle { centre: [inside[0] + off[0], inside[1] + off[1]], size };
    let row_end = along([0.0, 0.0], legs.directions[0], wanted.row_m + 1.0);
    let row_is_clear = hall.apart([[0.0, 0.0], row_end]) > 0.5;
    let pieces_are_clear = legs.pieces.iter().all(|piece| {
        if legs_inside.contains(&piece.leg) {
            // The leg's other end is outside, with a stretch of gallery before it.
            piece.line.iter().all(|end| *end == inside || hall.depth(*end) < -1.5)
        } else {
            hall.apart(piece.line) - piece.half >= wanted.rock_m
        }
    });
    let ends_are_clear =
        dead_ends.iter().all(|end| hall.apart(end.line) - 0.5 * end.width >= wanted.rock_m);
    let halls_are_clear = others.iter().all(|other| {
        let gap = |axis: usize| {
            (hall.centre[axis] - other.centre[axis]).abs()
                - 0.5 * (hall.size[axis] + other.size[axis])
        };
        gap(0).max(gap(1)) >= wanted.rock_m
    });
    (row_is_clear && pieces_are_clear && ends_are_clear && halls_are_clear).then_some(hall)
}
