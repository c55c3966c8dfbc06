//! Flies along the way to a goal, and looks at it.

use core::f32::consts::{FRAC_PI_2, PI, TAU};

use grid_map::{Cell, CellState};
use units::{Duration, Point2, Pose2, Radians};

use crate::atlas::Ground;
use crate::rule::Facing;
use crate::tile::Tile;

/// A cell of the way that is nearer counts as passed (m).
const PASSED: f32 = 0.1;
/// A robot in a cell stands in its middle within this distance (m).
const CENTRED: f32 = 0.02;
/// A robot that turns while it flies leaves its line by no more than this angle (rad): 0.3 rad/s, the
/// thesis' fastest turn, for a fifth of a second, and a third.
const DRIFT: f32 = 0.08;
/// The factor from the distance to the cell that a robot aims at to its highest speed (1/s): one step
/// of a fifth of a second does not lead beyond.
const APPROACH: f32 = 5.0;
/// The same where it is to stay: a drone that lags by 0.3 s does not sway about the point. Our own number.
const APPROACH_POINT: f32 = 1.0;
/// A robot is at the end of its way at this distance (m).
const ARRIVED: f32 = 0.12;
/// How many cells ahead on its way a robot aims, which smooths the way of a grid.
const AHEAD: usize = 3;
/// A robot that flies nose first turns on the spot above this angle (rad).
const TURN_FIRST: f32 = 0.5;
/// A robot turns on the spot to a goal that it can see from where it is above this angle (rad): a
/// turn may show what it would fly for. It is just within half the field of view of the thesis'
/// camera.
const LOOK_FIRST: f32 = 0.5;
/// A robot turns on the spot to the way that it flies above this angle (rad). Our own number: with 1.2
/// the time of three robots is the same within 2 %, and two fly some 5 % more (40 seeds from 100000
/// on in five plans).
const MOVE_BELOW: f32 = 0.6;
/// A robot faces a place within this angle (rad).
const FACING: f32 = 0.1;
/// The factor from the angle that is left to the rate of turn (1/s).
const TURN_GAIN: f32 = 2.0;
/// Cells to each side of a tile's middle in which a robot looks for the unknown.
const AROUND: i16 = 3;

/// How a robot sees, and so how it flies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gaze {
    /// A camera looks ahead: the robot flies nose first and turns to what it wants to see.
    Ahead,
    /// Rangers look to four sides: the robot flies in any direction, over cells that it knows to be
    /// free, and turns all the time.
    Around,
}

/// The limits of a robot's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Metres a second.
    pub speed: f32,
    /// Radians a second.
    pub turn: f32,
    /// How far the robot sees, metres.
    pub reach: f32,
    /// How the robot sees.
    pub gaze: Gaze,
}

/// What the robot's controller is to do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// The velocity in body axes: forward and left, metres a second.
    pub velocity: [f32; 2],
    /// The rate of turn, counter-clockwise, radians a second.
    pub yaw_rate: f32,
}

/// What came of one step of flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Progress {
    /// The robot flies on.
    Flying(Motion),
    /// The robot is at the end of the way and faces the goal.
    Arrived,
    /// An obstacle lies on the way.
    Blocked,
}

/// The direction from one point to another, counter-clockwise from east.
fn bearing(from: Point2, to: Point2) -> f32 {
    libm::atan2f(to.y - from.y, to.x - from.x)
}

/// An angle as one between −π and π.
pub(crate) fn wrapped(angle: f32) -> f32 {
    angle - TAU * libm::floorf((angle + PI) / TAU)
}

/// Flies on along the way to `end`, from where `tile` is looked at; the last search of the ground has
/// found the way.
pub(crate) fn fly<G: Ground>(
    ground: &G,
    pose: Pose2,
    (end, tile): (Cell, Tile),
    limits: Limits,
    facing: Facing,
) -> Progress {
    let frame = *ground.frame();
    if pose.at.distance(frame.centre(end)).0 < ARRIVED {
        return Progress::Arrived;
    }
    let Some(next) = next_cell(ground, pose.at, end) else { return Progress::Blocked };
    let off = wrapped(bearing(pose.at, frame.centre(next)) - pose.yaw.0);
    let left = pose.at.distance(frame.centre(next)).0;
    let speed = limits.speed.min(left * APPROACH);
    let (sin, cos) = Radians(off).sin_cos();
    let sideways = [speed * cos, speed * sin];
    let motion = match (limits.gaze, facing) {
        (Gaze::Ahead, Facing::Way) => {
            let forward = if libm::fabsf(off) < TURN_FIRST { speed } else { 0.0 };
            Motion { velocity: [forward, 0.0], yaw_rate: turn(off, limits) }
        }
        (Gaze::Ahead, Facing::Goal) if is_known_free(ground, pose.at, next) => {
            let (aim, is_near) = match in_sight(ground, pose.at, tile) {
                Some(unknown) => (unknown, pose.at.distance(unknown).0 < limits.reach),
                None => (farthest_in_sight(ground, pose.at, end), false),
            };
            let off = wrapped(bearing(pose.at, aim) - pose.yaw.0);
            // What a turn shows needs no flight.
            let waits = libm::fabsf(off) > if is_near { LOOK_FIRST } else { MOVE_BELOW };
            Motion {
                velocity: if waits { [0.0; 2] } else { sideways },
                yaw_rate: turn(off, limits),
            }
        }
        // The robot looks before it flies into the unknown.
        (Gaze::Ahead, Facing::Goal) => {
            let velocity = if libm::fabsf(off) < TURN_FIRST { sideways } else { [0.0; 2] };
            Motion { velocity, yaw_rate: turn(off, limits) }
        }
        // A quarter turn shows what lies on the way.
        (Gaze::Around, _) => {
            let is_free = |cell| ground.state(cell) == CellState::Free;
            let is_open = frame.line(pose.at, frame.centre(next)).all(is_free);
            Motion { velocity: if is_open { sideways } else { [0.0; 2] }, yaw_rate: limits.turn }
        }
    };
    Progress::Flying(motion)
}

/// The motion straight to a point.
pub(crate) fn fly_to(pose: Pose2, to: Point2, limits: Limits) -> Motion {
    let speed = limits.speed.min(pose.at.distance(to).0 * APPROACH_POINT);
    let (sin, cos) = Radians(bearing(pose.at, to) - pose.yaw.0).sin_cos();
    let yaw_rate = match limits.gaze {
        Gaze::Around => limits.turn,
        Gaze::Ahead => 0.0,
    };
    Motion { velocity: [speed * cos, speed * sin], yaw_rate }
}

/// Whether the map knows the cells on a straight line as free, and those beside it at all.
fn is_known_free<G: Ground>(ground: &G, from: Point2, to: Cell) -> bool {
    let frame = ground.frame();
    let is_known = |cell: Cell| {
        let beside = |off: i16| (-1..=1).map(move |other| (off, other));
        let around = (-1..=1).flat_map(beside);
        let mut cells = around.filter_map(|(east, north)| frame.beside(cell, east, north));
        cells.all(|near| ground.state(near) != CellState::Unknown)
    };
    let mut line = frame.line(from, frame.centre(to));
    line.all(|cell| ground.state(cell) == CellState::Free && is_known(cell))
}

/// The middle of the unknown around a tile, where no obstacle hides it.
pub(crate) fn in_sight<G: Ground>(ground: &G, from: Point2, tile: Tile) -> Option<Point2> {
    let unknown = unknown_around(ground, tile);
    is_in_sight(ground, from, unknown).then_some(unknown)
}

fn is_in_sight<G: Ground>(ground: &G, from: Point2, to: Point2) -> bool {
    ground.frame().line(from, to).all(|cell| ground.state(cell) != CellState::Occupied)
}

/// The point of the way to `end` that is farthest along the way and that no obstacle hides.
fn farthest_in_sight<G: Ground>(ground: &G, from: Point2, end: Cell) -> Point2 {
    let frame = *ground.frame();
    let mut cell = Some(end);
    for _ in 0..frame.cell_count() {
        let Some(one) = cell else { break };
        let to = frame.centre(one);
        if is_in_sight(ground, from, to) {
            return to;
        }
        cell = ground.before(one);
    }
    frame.centre(end)
}

/// Turns to what is unknown around a tile, or, with rangers to four sides, until one of them has looked
/// there; the robot has been at the end of its way for `elapsed`.
pub(crate) fn look<G: Ground>(
    ground: &G,
    pose: Pose2,
    tile: Tile,
    limits: Limits,
    elapsed: Duration,
) -> Progress {
    let (yaw_rate, is_over) = match limits.gaze {
        Gaze::Ahead => {
            let off = wrapped(bearing(pose.at, unknown_around(ground, tile)) - pose.yaw.0);
            (turn(off, limits), libm::fabsf(off) < FACING)
        }
        Gaze::Around => (limits.turn, elapsed.as_secs_f32() * limits.turn > FRAC_PI_2),
    };
    if is_over {
        return Progress::Arrived;
    }
    Progress::Flying(Motion { velocity: [0.0; 2], yaw_rate })
}

/// The angle by which a robot has to turn at the beginning of its way to `end`.
pub(crate) fn first_turn<G: Ground>(ground: &G, pose: Pose2, end: Cell) -> f32 {
    let to = next_cell(ground, pose.at, end).unwrap_or(end);
    libm::fabsf(wrapped(bearing(pose.at, ground.frame().centre(to)) - pose.yaw.0))
}

fn turn(off: f32, limits: Limits) -> f32 {
    (off * TURN_GAIN).max(-limits.turn).min(limits.turn)
}

/// The cell of the way to aim at: some cells beyond the one nearest to the robot, or fewer where an
/// obstacle lies on the straight line there. `None` where the next cell is an obstacle.
fn next_cell<G: Ground>(ground: &G, from: Point2, end: Cell) -> Option<Cell> {
    let frame = *ground.frame();
    let off = |cell: Cell| frame.centre(cell).distance(from).0;
    let mut nearest = off(end);
    let mut beyond = [end; AHEAD + 1];
    let mut aims = beyond;
    // The way from its end to its start, with the last cells before the one in hand in `beyond`.
    let mut cell = Some(end);
    for _ in 0..frame.cell_count() {
        let Some(one) = cell else { break };
        beyond.rotate_right(1);
        if let Some(first) = beyond.first_mut() {
            *first = one;
        }
        if off(one) <= nearest {
            (nearest, aims) = (off(one), beyond);
        }
        cell = ground.before(one);
    }
    let ahead = aims.into_iter().rev().filter(|&aim| off(aim) >= PASSED || aim == end);
    let mut clear = ahead.filter(|&aim| is_clear(ground, from, aim));
    clear.next().or_else(|| beside_walls(ground, from, &aims))
}

/// The cell to aim at for a robot that stands near a wall: it goes from cell to cell, and where it
/// would cut a corner first to the middle of its own cell.
fn beside_walls<G: Ground>(ground: &G, from: Point2, way: &[Cell]) -> Option<Cell> {
    let frame = ground.frame();
    let own = frame.cell_at(from);
    let next = way.iter().copied().find(|&cell| Some(cell) != own).or(own)?;
    if ground.state(next) == CellState::Occupied {
        return None;
    }
    let to = frame.centre(next);
    let lines = [-DRIFT, 0.0, DRIFT].map(|by| is_in_sight(ground, from, turned(from, to, by)));
    if lines == [true; 3] {
        return Some(next);
    }
    own.filter(|&own| frame.centre(own).distance(from).0 > CENTRED)
}

/// A point turned about another one by a small angle (rad).
fn turned(about: Point2, point: Point2, by: f32) -> Point2 {
    let (x, y) = (point.x - about.x, point.y - about.y);
    Point2::new(about.x + x - by * y, about.y + y + by * x)
}

/// Whether a straight line keeps away from obstacles.
fn is_clear<G: Ground>(ground: &G, from: Point2, to: Cell) -> bool {
    let frame = ground.frame();
    let is_free = |cell| ground.state(cell) != CellState::Occupied && !ground.is_near_wall(cell);
    frame.line(from, frame.centre(to)).all(is_free)
}

/// The middle of the unknown cells around a tile, or the tile's own where none is unknown.
fn unknown_around<G: Ground>(ground: &G, tile: Tile) -> Point2 {
    let frame = *ground.frame();
    let (mut count, mut sum) = (0.0, [0.0; 2]);
    for east in -AROUND..=AROUND {
        for north in -AROUND..=AROUND {
            let Some(cell) = frame.beside(tile.middle(), east, north) else { continue };
            if ground.state(cell) == CellState::Unknown {
                let at = frame.centre(cell);
                (count, sum) = (count + 1.0, [sum[0] + at.x, sum[1] + at.y]);
            }
        }
    }
    let centre = tile.centre(&frame);
    if count > 0.0 { Point2::new(sum[0] / count, sum[1] / count) } else { centre }
}
