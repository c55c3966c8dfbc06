//! Measures how long a leader's round takes with many robots and frontiers in a large map.

#[cfg(any(unix, windows))]
use cpu_time::ThreadTime;
use frontier::{
    Activity, Atlas1024, Beam, Bid, Body, Config, Explorer, Gain, Ground, Inputs, Known, MOST_BIDS,
    MOST_KNOWN, MOST_ROBOTS, Outputs, Packet, Rule, Status, Tile,
};
use grid_map::{Cell, CellState, Frame, RayEnd};
use units::{Instant, Metres, Point2, Pose2, Radians};

use crate::run::{LIMITS, RECORDS, STEPS_PER_SECOND};

// A browser has no clock of the processor time.
#[cfg(not(any(unix, windows)))]
use std::time::Instant as ThreadTime;

/// The numbers of robots that are measured.
pub const SCALE_ROBOTS: [usize; 7] = [1, 2, 4, 8, 16, 32, MOST_ROBOTS];
/// The numbers of frontiers that are measured, in tiles: up to as many as are on the map.
pub const SCALE_TILES: [usize; 3] = [512, 1024, 2304];
/// The side of the map, in cells of 0.1 m.
const SIDE: u16 = 1000;
/// Each so many-th tile of a row and of a column is a frontier.
const SPACING: u16 = 7;
/// The steps of the leader before its round, in which it learns who is there.
const STEPS: u64 = 13;
/// Of so many repetitions the shortest counts.
const REPETITIONS: usize = 5;

type Leader = Explorer<Atlas1024, MOST_ROBOTS, RECORDS>;

/// How long a leader's steps take on one core of this machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The number of robots.
    pub robots: usize,
    /// The number of frontier cells that the leader has on its board.
    pub frontier_cells: usize,
    /// The robots that have got an order in the round.
    pub assigned: usize,
    /// The processor time of the leader's round: it takes in a status and bids of each robot, assigns
    /// candidates to all, and sends orders. In milliseconds.
    pub round_ms: f32,
    /// The processor time of the step, once a second, in which a robot compares its marks with its map, of
    /// which all within its reach has changed, and looks for ways to its candidates, whether it leads or
    /// not. In milliseconds.
    pub map_ms: f32,
}

/// Measures one case: all robots ask for a goal at once.
///
/// # Panics
/// Where the map did not fit [`Atlas1024`], which it does.
#[must_use]
pub fn scale(rule: Rule, robots: usize, tiles: usize) -> Scale {
    let frame = Frame::new(Point2::new(0.0, 0.0), Metres(0.1), SIDE, SIDE).expect("a frame");
    let frontiers: Vec<Tile> = frontiers(&frame).take(tiles).collect();
    let pose = Pose2 { at: Point2::new(50.0, 50.0), yaw: Radians(0.0) };
    let mut leader = Box::new(leader(rule, frame, &frontiers));
    let cells = frontiers.iter().flat_map(|tile| tile.cells(&frame));
    let frontier_cells = cells.filter(|&cell| leader.ground().is_frontier(cell)).count();
    for n in 0..STEPS {
        let packets = all_packets(robots, n, &frame, &[]);
        let _ = step(&mut leader, n, pose, &[], &packets);
    }
    let packets = all_packets(robots, STEPS, &frame, &frontiers);
    let (after, outputs, round_ms) =
        timed(&leader, |leader| step(leader, STEPS, pose, &[], &packets));
    let beams = all_around(pose.at);
    let next = STEPS.next_multiple_of(STEPS_PER_SECOND);
    let (_, _, map_ms) = timed(&leader, |leader| step(leader, next, pose, &beams, &[]));
    let own = usize::from(after.activity() == Activity::Going);
    Scale { robots, frontier_cells, assigned: own + ordered(&after, outputs), round_ms, map_ms }
}

/// Beams that show all within a robot's reach to be free.
fn all_around(at: Point2) -> Vec<Beam> {
    let beam = |degrees: u16| {
        let (sin, cos) = Radians(f32::from(degrees).to_radians()).sin_cos();
        let to = Point2::new(at.x + LIMITS.reach * cos, at.y + LIMITS.reach * sin);
        Beam::ray(to, RayEnd::Clear)
    };
    (0..360).map(beam).collect()
}

/// Tiles of the map far enough from each other to be frontiers of their own.
fn frontiers(frame: &Frame) -> impl Iterator<Item = Tile> {
    let is_chosen = |n: u16| n.is_multiple_of(SPACING);
    Tile::all(frame).filter(move |tile| is_chosen(tile.row()) && is_chosen(tile.column()))
}

/// The robot with the number 0, whose map has these frontiers.
fn leader(rule: Rule, frame: Frame, frontiers: &[Tile]) -> Leader {
    let mut ground = Atlas1024::new(frame).expect("at most 1024 by 1024 cells");
    let cells = frontiers.iter().flat_map(|tile| tile.cells(&frame));
    cells.for_each(|cell: Cell| ground.set(cell, CellState::Free));
    Explorer::new(Config::unbounded(0, rule, LIMITS), ground)
}

/// What all other robots send in a step: each second that they hear all others, and in the round their
/// status and bids for these tiles.
fn all_packets(robots: usize, step: u64, frame: &Frame, tiles: &[Tile]) -> Vec<Vec<u8>> {
    let mut packets = Vec::new();
    for robot in 1..robots as u8 {
        let mut bodies = Vec::new();
        if step % STEPS_PER_SECOND == 2 {
            bodies.extend(statuses(robot, robots as u8).map(Body::Status));
        }
        if !tiles.is_empty() {
            bodies.extend(statuses(robot, robots as u8).take(1).map(Body::Status));
            bodies.push(Body::Bids(bids(robot, frame, tiles)));
        }
        for (n, body) in bodies.into_iter().enumerate() {
            let sequence = (step * 16) as u8 + n as u8;
            packets.push(Packet { origin: robot, sender: robot, sequence, body }.encode().to_vec());
        }
    }
    packets
}

/// A robot's statuses in a row, in which it speaks of all others.
fn statuses(robot: u8, robots: u8) -> impl Iterator<Item = Status> {
    let others: Vec<u8> = (0..robots).filter(|&other| other != robot).collect();
    let packets = others.len().div_ceil(MOST_KNOWN);
    (0..packets).map(move |n| {
        // A status with room left would take back those before it.
        let some = others.iter().cycle().skip(n * MOST_KNOWN).take(others.len().min(MOST_KNOWN));
        let known = some.map(|&robot| Known { robot, is_direct: true, version: 0 }).collect();
        Status { position: place(robot), known, ..Status::default() }
    })
}

fn bids(robot: u8, frame: &Frame, tiles: &[Tile]) -> heapless::Vec<Bid, MOST_BIDS> {
    let bid = |n: usize| {
        let tile = tiles[(usize::from(robot) * 31 + n * 7) % tiles.len()];
        let distance = place(robot).distance(tile.centre(frame));
        Bid { tile, gain: Gain::of_cells(40), distance }
    };
    (0..MOST_BIDS).map(bid).collect()
}

/// Where a robot is: on a grid over the whole map.
fn place(robot: u8) -> Point2 {
    Point2::new(f32::from(robot % 8) * 12.0 + 5.0, f32::from(robot / 8) * 12.0 + 5.0)
}

fn step(leader: &mut Leader, n: u64, pose: Pose2, beams: &[Beam], packets: &[Vec<u8>]) -> Outputs {
    let packets: Vec<&[u8]> = packets.iter().map(Vec::as_slice).collect();
    let now = Instant::from_micros(n * 1_000_000 / STEPS_PER_SECOND);
    leader.step(now, &Inputs { pose, beams, packets: &packets })
}

/// The leader after a step, what it did, and the shortest processor time of some repetitions, ms.
fn timed(
    leader: &Leader,
    mut step: impl FnMut(&mut Leader) -> Outputs,
) -> (Box<Leader>, Outputs, f32) {
    let mut once = || {
        let mut after = Box::new(leader.clone());
        let begun = ThreadTime::now();
        let outputs = std::hint::black_box(step(&mut after));
        (after, outputs, begun.elapsed().as_secs_f32() * 1e3)
    };
    let (mut after, mut outputs, mut least) = once();
    for _ in 1..REPETITIONS {
        let ms;
        (after, outputs, ms) = once();
        least = least.min(ms);
    }
    (after, outputs, least)
}

/// How many robots have orders in these packets and in those that wait behind them.
fn ordered(leader: &Leader, mut outputs: Outputs) -> usize {
    let mut leader = Box::new(leader.clone());
    let mut count = 0;
    for n in 1..=4 {
        for bytes in &outputs.packets {
            if let Ok(Packet { body: Body::Orders(orders), .. }) = Packet::decode(bytes) {
                count += orders.len();
            }
        }
        let pose = Pose2 { at: Point2::new(50.0, 50.0), yaw: Radians(0.0) };
        outputs = step(&mut leader, STEPS + n, pose, &[], &[]);
    }
    count
}
