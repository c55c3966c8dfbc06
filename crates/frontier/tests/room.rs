//! A robot has marks for some hundred tiles; those that it needs no more must make room for others.

use frontier::{
    Activity, Atlas160, Beam, Body, Config, Explorer, Gaze, Inputs, Known, Limits, Mark, Packet,
    Rule, Status, Tile, frontiers,
};
use grid_map::{Frame, RayEnd};
use std::collections::BTreeMap;
use units::{Instant, Metres, Point2, Pose2, Radians};

const RECORDS: usize = 256;
/// How far the robot sees, m.
const REACH: f32 = 1.5;

type Robot = Explorer<Atlas160, 3, RECORDS>;

/// Robot 0, which flies, and what robot 1 hears of it all the time. Robot 2 has spoken once.
struct Flight {
    robot: Box<Robot>,
    now_ms: u64,
    sequence: u8,
    /// The version of robot 0's marks that robot 1 has, and the marks.
    version: u16,
    marks: BTreeMap<(u16, u16), Mark>,
    /// The packets of changes that robot 1 does not receive.
    lost: u32,
}

impl Flight {
    fn new(frame: Frame) -> Self {
        let limits = Limits { speed: 0.3, turn: 0.3, reach: REACH, gaze: Gaze::Around };
        // All frontiers count, so that they can be compared with those of the map.
        let rule = Rule { least_frontier: 1, ..Rule::OURS };
        let ground = Atlas160::new(frame).expect("there is room");
        let robot = Box::new(Explorer::new(Config::unbounded(0, rule, limits), ground));
        Self { robot, now_ms: 0, sequence: 0, version: 0, marks: BTreeMap::new(), lost: 0 }
    }

    /// One second: the robot sees all around it, and hears these robots.
    fn second(&mut self, at: Point2, speakers: &[u8]) {
        self.step(at, speakers);
        (1..5).for_each(|_| self.step(at, &[]));
    }

    /// A fifth of a second of that.
    fn step(&mut self, at: Point2, speakers: &[u8]) {
        self.now_ms += 200;
        let beam = |n: u16| {
            let (sin, cos) = Radians(f32::from(n) * 0.02).sin_cos();
            Beam::ray(Point2::new(at.x + REACH * cos, at.y + REACH * sin), RayEnd::Clear)
        };
        let beams: Vec<Beam> = (0..315).map(beam).collect();
        let statuses: Vec<Vec<u8>> = speakers.iter().map(|&robot| self.status(robot)).collect();
        let packets: Vec<&[u8]> = statuses.iter().map(Vec::as_slice).collect();
        let pose = Pose2 { at, yaw: Radians(0.0) };
        let inputs = Inputs { pose, beams: &beams, packets: &packets };
        let outputs = self.robot.step(Instant::from_millis(self.now_ms), &inputs);
        outputs.packets.iter().for_each(|packet| self.take(packet));
    }

    /// Robot 0 stands there for half a minute; robot 1 must then have heard of each frontier of its map, and
    /// of no other tile.
    fn ends_with_what_is_left(&mut self, at: Point2) {
        (0..30).for_each(|_| self.second(at, &[1]));
        let is_open = |(_, mark): &(_, &Mark)| matches!(mark, Mark::Frontier(_));
        let told: Vec<_> = self.marks.iter().filter(is_open).map(|(tile, _)| *tile).collect();
        let left = frontiers(self.robot.ground());
        let left: Vec<_> = left.map(|(tile, _)| (tile.row(), tile.column())).collect();
        assert!(!left.is_empty() && left.len() < RECORDS);
        assert_eq!(told, left);
    }

    fn status(&mut self, robot: u8) -> Vec<u8> {
        self.sequence += 1;
        let version = if robot == 1 { self.version } else { 0 };
        let known = Known { robot: 0, is_direct: true, version };
        let body = Body::Status(Status {
            position: Point2::new(0.0, 0.0),
            activity: Activity::Going,
            goal: Tile::default(),
            version: 0,
            known: [known].into_iter().collect(),
        });
        let packet = Packet { origin: robot, sender: robot, sequence: self.sequence, body };
        packet.encode().to_vec()
    }

    /// Robot 1 takes the changes that follow on what it has.
    fn take(&mut self, packet: &[u8]) {
        let Ok(Packet { origin: 0, body: Body::Changes(changes), .. }) = Packet::decode(packet)
        else {
            return;
        };
        if self.lost > 0 {
            self.lost -= 1;
        } else if (changes.base..changes.upto).contains(&self.version) {
            self.version = changes.upto;
            let marks = changes.marks.iter();
            self.marks.extend(marks.map(|(tile, mark)| ((tile.row(), tile.column()), *mark)));
        }
    }
}

/// Robot 0 flies over 16 by 16 m, where many more tiles are a frontier for a while than it has marks for.
/// Robot 2, which is out of range, never tells that it knows which are none any more. Robot 1 hears of
/// each frontier that is left all the same.
#[test]
fn what_was_a_frontier_makes_room_for_what_is_one() {
    let frame = Frame::new(Point2::new(-8.0, -8.0), Metres(0.1), 160, 160).expect("a frame");
    let mut flight = Flight::new(frame);
    flight.second(Point2::new(-6.0, -6.0), &[1, 2]);
    for row in 0..7 {
        for step in 0..24 {
            let east = if row % 2 == 0 { step } else { 23 - step };
            let (x, y) = (-6.0 + 0.5 * east as f32, -6.0 + 2.0 * row as f32);
            flight.second(Point2::new(x, y), &[1]);
        }
    }
    flight.ends_with_what_is_left(Point2::new(5.5, 6.0));
}

/// What robot 1 was told, and what changed more than once while it was out of range, is taken back when it
/// is in range again: robot 0 sees first a part of what lies beyond the frontiers that it has told, and then
/// the rest.
#[test]
fn what_was_told_is_taken_back() {
    let frame = Frame::new(Point2::new(-8.0, -8.0), Metres(0.1), 160, 160).expect("a frame");
    let mut flight = Flight::new(frame);
    (0..10).for_each(|_| flight.second(Point2::new(0.0, 0.0), &[1]));
    let places = [[0.0, 0.0], [1.3, 1.9], [0.6, 2.4], [-0.4, 1.6], [0.4, 1.2], [1.5, 0.6]];
    for [x, y] in places.into_iter().flat_map(|place| [place; 10]) {
        flight.second(Point2::new(x, y), &[]);
    }
    flight.ends_with_what_is_left(Point2::new(1.5, 0.6));
}

/// A robot that has flown to and fro is as far from where it began as its map says, and not as far as it
/// has flown.
#[test]
fn the_way_back_is_that_on_the_map() {
    let frame = Frame::new(Point2::new(-8.0, -8.0), Metres(0.1), 160, 160).expect("a frame");
    let mut flight = Flight::new(frame);
    let within = |flight: &mut Flight, at, most| {
        flight.robot.is_within(Instant::from_millis(flight.now_ms), at, Metres(most))
    };
    let ways = [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 2.5, 2.0, 1.5, 1.0, 0.5];
    for x in ways {
        let at = Point2::new(x, 0.0);
        flight.second(at, &[]);
        assert!(within(&mut flight, at, 6.0), "it has flown no more than that");
    }
    let here = Point2::new(0.5, 0.0);
    assert!(within(&mut flight, here, 1.0), "5.5 m were flown, and the start is half a metre away");
    assert!(!within(&mut flight, here, 0.3), "it is farther away than that");
}

/// A robot that flies has new marks in each second. A packet that was lost on the way is sent again all the same,
/// and not only when the robot rests.
#[test]
fn a_lost_packet_is_sent_again_while_the_robot_flies_on() {
    let frame = Frame::new(Point2::new(-8.0, -8.0), Metres(0.1), 160, 160).expect("a frame");
    let mut flight = Flight::new(frame);
    let fly = |flight: &mut Flight, from: u16, to: u16| {
        for step in 5 * from..5 * to {
            let speakers: &[u8] = if step.is_multiple_of(5) { &[1] } else { &[] };
            flight.step(Point2::new(-6.0 + 0.06 * f32::from(step), 0.0), speakers);
        }
    };
    fly(&mut flight, 0, 4);
    flight.lost = 1;
    let held = flight.version;
    fly(&mut flight, 4, 12);
    assert!(flight.version > held, "stuck at {held}");
    fly(&mut flight, 12, 30);
    flight.ends_with_what_is_left(Point2::new(3.0, 0.0));
}
