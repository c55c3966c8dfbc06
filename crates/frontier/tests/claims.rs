//! What must be true of overlap, assignment, clusters, frontiers and packets.

use frontier::{
    Assignment, Atlas160, Changes, Distances, Gain, Ground, MOST_BYTES, Mark, Packet, PacketError,
    Place, RULES, RobotSet, Rule, RuleEntry, Shape, Tile, Utility, assign, cluster, frontiers,
    is_overlapped,
};
use grid_map::{Area, Cell, CellState, Frame};
use proptest::prelude::*;
use units::{Metres, Point2};

fn rule(name: &str) -> Rule {
    RuleEntry::named(name).expect("a rule of that name").rule
}

fn place([x, y]: [f32; 2], gain: f32) -> Place {
    Place { position: Point2::new(x, y), gain }
}

/// Robots at points, with straight distances.
struct Points {
    robots: Vec<Point2>,
    places: Vec<Point2>,
}

impl Distances for Points {
    fn robots(&self) -> usize {
        self.robots.len()
    }

    fn distance(&self, robot: usize, place: usize) -> Option<Metres> {
        Some(self.robots[robot].distance(self.places[place]))
    }
}

fn assigned(rule: &Rule, robots: &[[f32; 2]], places: &[Place]) -> Vec<Assignment> {
    let point = |&[x, y]: &[f32; 2]| Point2::new(x, y);
    let points = Points {
        robots: robots.iter().map(point).collect(),
        places: places.iter().map(|place| place.position).collect(),
    };
    assign::<8>(rule, &mut places.to_vec(), &points).into_iter().collect()
}

#[test]
fn a_notch_is_in_the_box_but_not_in_the_concave_area() {
    // A "U" that opens to the north.
    let edge = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0], [0.0, 2.0]].map(|[x, y]| Point2::new(x, y));
    let is_in = |point, shape| is_overlapped(point, edge.iter().copied(), shape);
    let notch = Point2::new(2.0, 2.0);
    assert!(is_in(notch, Shape::Box));
    assert!(!is_in(notch, Shape::Concave));
    assert!(is_in(Point2::new(2.0, 0.0), Shape::Concave));
    assert!(!is_in(Point2::new(9.0, 9.0), Shape::Box));
    assert!(!is_overlapped(notch, core::iter::empty(), Shape::Box));
}

#[test]
fn the_best_pair_goes_first_only_where_the_rule_says_so() {
    let places = [place([1.0, 0.0], 40.0), place([-6.0, 0.0], 40.0)];
    let chosen = |name| assigned(&rule(name), &[[0.0, 0.0], [1.0, 0.0]], &places);
    let pair = |robot, place| Assignment { robot, place };
    assert_eq!(chosen("thesis"), [pair(0, 0), pair(1, 1)]);
    assert_eq!(chosen("ours"), [pair(1, 0), pair(0, 1)]);
}

#[test]
fn clusters_split_and_merge() {
    let of = |links: &[&[u8]], robot: u8| {
        let hears = |n: u8| links[usize::from(n)].iter().copied().collect::<RobotSet>();
        cluster(robot, hears).iter().collect::<Vec<u8>>()
    };
    let apart: [&[u8]; 5] = [&[1], &[0], &[3], &[2], &[]];
    assert_eq!([of(&apart, 1), of(&apart, 2), of(&apart, 4)], [vec![0, 1], vec![2, 3], vec![4]]);
    let joined: [&[u8]; 4] = [&[1], &[0, 2], &[1, 3], &[2]];
    assert_eq!(of(&joined, 3), [0, 1, 2, 3]);
    // A link that only one end hears is none.
    assert_eq!(of(&[&[], &[0]], 1), [1]);
}

#[test]
fn the_bytes_of_changes() {
    let tile = Tile::new(5, 1023).unwrap();
    let marks = [(tile, Mark::Frontier(Gain::of_cells(48)))].into_iter().collect();
    let body = frontier::Body::Changes(Changes { base: 1, upto: 0x0203, marks });
    let packet = Packet { origin: 2, sender: 3, sequence: 7, body };
    let bytes = packet.encode();
    assert_eq!(*bytes, [0x42, 3, 7, 1, 0, 3, 2, 0x05, 0xFC, 0xFF]);
    assert_eq!(Packet::decode(&bytes), Ok(packet));
    assert_eq!(Packet::decode(&bytes[..9]), Err(PacketError::Length));
    assert_eq!(Packet::decode(&[0x42, 64, 7, 1, 0, 3, 2]), Err(PacketError::Robot));
    assert_eq!(Packet::decode(&[0x42, 3, 7, 1, 0, 1, 0]), Err(PacketError::Version));
    assert_eq!(Packet::decode(&[0xC2, 3, 7, 1, 0, 0, 0x20]), Err(PacketError::Code));
}

const LAMBDA: f32 = 0.2;

/// The greedy rule, by comparing all pairs anew for each robot.
fn assigned_slowly(rule: &Rule, robots: &[[f32; 2]], places: &[Place]) -> Vec<Assignment> {
    let (mut places, mut done) = (places.to_vec(), Vec::new());
    while done.len() < robots.len() {
        let mut best: Option<(f32, Assignment)> = None;
        for (robot, [x, y]) in robots.iter().enumerate() {
            let is_done = done.iter().any(|one: &Assignment| one.robot == robot);
            for (n, place) in places.iter().enumerate().filter(|(_, place)| place.gain >= 0.0) {
                let way = Point2::new(*x, *y).distance(place.position).0;
                let utility = place.gain * libm::expf(-LAMBDA * way);
                if !is_done && best.is_none_or(|(most, _)| utility > most) {
                    best = Some((utility, Assignment { robot, place: n }));
                }
            }
        }
        let Some((_, one)) = best else { break };
        let at = places[one.place].position;
        frontier::take(rule, &mut places, at);
        done.push(one);
    }
    done
}

proptest! {
    #[test]
    fn no_two_robots_share_a_place_and_none_waits_without_need(
        places in prop::collection::vec((-9.0_f32..9.0, -9.0_f32..9.0, 0.0_f32..48.0), 0..20),
        robots in prop::collection::vec([-9.0_f32..9.0, -9.0_f32..9.0], 1..=6),
        which in 0..RULES.len(),
    ) {
        let places: Vec<_> = places.iter().map(|&(x, y, gain)| place([x, y], gain)).collect();
        let assigned = assigned(&RULES[which].rule, &robots, &places);
        // Places that are one take each other away.
        prop_assert!(assigned.len() <= places.len().min(robots.len()));
        prop_assert!(assigned.is_empty() == places.is_empty());
        for (n, one) in assigned.iter().enumerate() {
            let clash = |other: &Assignment| other.robot == one.robot || other.place == one.place;
            prop_assert!(!assigned[..n].iter().any(clash));
        }
    }

    #[test]
    fn the_fast_greedy_assignment_is_the_slow_one(
        places in prop::collection::vec((-9.0_f32..9.0, -9.0_f32..9.0, 1.0_f32..48.0), 0..20),
        robots in prop::collection::vec([-9.0_f32..9.0, -9.0_f32..9.0], 1..=6),
    ) {
        let places: Vec<_> = places.iter().map(|&(x, y, gain)| place([x, y], gain)).collect();
        let utility = Utility::Exponential { lambda: LAMBDA, crowd: false };
        let rule = Rule { utility, ..rule("ours") };
        prop_assert_eq!(assigned(&rule, &robots, &places), assigned_slowly(&rule, &robots, &places));
    }

    #[test]
    fn no_bytes_panic_and_what_is_read_is_written_alike(
        bytes in prop::collection::vec(any::<u8>(), 0..80),
    ) {
        if let Ok(packet) = Packet::decode(&bytes) {
            prop_assert!(bytes.len() <= MOST_BYTES);
            prop_assert_eq!(&packet.encode()[..], &bytes[..]);
        }
    }

    #[test]
    fn each_frontier_of_the_map_lies_in_a_frontier_tile(
        free in prop::collection::vec((0_u16..32, 0_u16..32), 0..200),
    ) {
        let frame = Frame::new(Point2::new(0.0, 0.0), Metres(0.1), 32, 32).unwrap();
        let mut ground = Atlas160::new(frame).unwrap();
        for (column, row) in free {
            ground.set(Cell::new(column, row), CellState::Free);
        }
        let tiles: Vec<Tile> = frontiers(&ground).map(|(tile, _)| tile).collect();
        for cell in frame.cells() {
            let tile = Tile::of(cell).unwrap();
            prop_assert!(!ground.is_frontier(cell) || tiles.contains(&tile));
        }
        for tile in tiles {
            prop_assert!(tile.cells(&frame).any(|cell| ground.is_frontier(cell)));
        }
    }

    /// Which cells are too near to an obstacle does not depend on how often the ways were searched
    /// meanwhile, and no cell changes its state beyond the area that the ground tells.
    #[test]
    fn what_has_changed_is_brought_up_to_date(
        changes in prop::collection::vec((0..40u16, 0..40u16, 0..3usize, any::<bool>()), 1..60),
    ) {
        let frame = Frame::new(Point2::new(0.0, 0.0), Metres(0.1), 40, 40).unwrap();
        let new = || Box::new(Atlas160::new(frame).unwrap());
        let (mut often, mut once) = (new(), new());
        let middle = frame.centre(Cell::new(20, 20));
        for (column, row, state, searches) in changes {
            let cell = Cell::new(column, row);
            let state = [CellState::Unknown, CellState::Free, CellState::Occupied][state];
            let had = often.state(cell);
            often.set(cell, state);
            once.set(cell, state);
            prop_assert_eq!(often.take_changed(), (had != state).then_some(Area::of(cell)));
            if searches {
                often.begin_search(middle, None);
            }
        }
        often.begin_search(middle, None);
        once.begin_search(middle, None);
        let near = |ground: &Atlas160| -> Vec<Cell> {
            frame.cells().filter(|&cell| ground.is_near_wall(cell)).collect()
        };
        prop_assert_eq!(near(&often), near(&once));
    }
}
