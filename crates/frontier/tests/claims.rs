//! What must be true of candidates, overlap, assignment, clusters and messages.

use frontier::{
    Assignment, Candidate, Chunk, ChunkError, Content, Explorer, MOST_CHUNK_BYTES, RULES, Rule,
    Shape, assign, extract, is_overlapped, leader,
};
use grid_map::{Cell, CellState, Frame, GridMap};
use proptest::prelude::*;
use units::{Metres, Point2};

fn rule(name: &str) -> Rule {
    RULES.iter().find(|entry| entry.name == name).expect("a rule of that name").rule
}

fn given(at: [f32; 2], gain: u8) -> Candidate {
    Candidate { position: Point2::new(at[0], at[1]), gain }
}

fn straight(candidates: &[Candidate]) -> impl Fn(&Explorer, usize) -> Option<Metres> + use<'_> {
    |explorer, n| Some(explorer.position.distance(candidates[n].position))
}

const _: () = assert!(MOST_CHUNK_BYTES <= 60);

#[test]
fn the_bytes_of_a_chunk() {
    let points = heapless::Vec::from_slice(&[given([1.25, -3.0], 48)]).unwrap();
    let chunk = Chunk { from: 2, content: Content::Occupied, round: 7, index: 0, count: 3, points };
    assert_eq!(*chunk.encode(), [0x82, 7, 0, 3, 0x7D, 0x00, 0xD4, 0xFE, 48]);
    assert_eq!(Chunk::decode(&chunk.encode()), Ok(chunk));
    assert_eq!(Chunk::decode(&[0, 0, 1, 1]), Err(ChunkError::Index));
    assert_eq!(Chunk::decode(&[8, 0, 0, 1]), Err(ChunkError::Sender));
    assert_eq!(Chunk::decode(&[0, 0, 0, 1, 9]), Err(ChunkError::Length));
    assert_eq!(Chunk::decode(&[0, 0, 0, 1, 0, 0, 0, 0, 49]), Err(ChunkError::Gain));
}

#[test]
fn a_notch_is_in_the_box_but_not_in_the_concave_area() {
    // A "U" that opens to the north.
    let edge = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0], [0.0, 2.0]].map(|[x, y]| Point2::new(x, y));
    let notch = Point2::new(2.0, 2.0);
    assert!(is_overlapped(notch, &edge, Shape::Box));
    assert!(!is_overlapped(notch, &edge, Shape::Concave));
    assert!(is_overlapped(Point2::new(2.0, 0.0), &edge, Shape::Concave));
    assert!(!is_overlapped(Point2::new(9.0, 9.0), &edge, Shape::Box));
    assert!(!is_overlapped(notch, &[], Shape::Box));
}

#[test]
fn the_best_pair_goes_first_only_where_the_rule_says_so() {
    let candidates = [given([1.0, 0.0], 40), given([-6.0, 0.0], 40)];
    let explorers = [0.0, 1.0].map(|x| Explorer { number: x as u8, position: Point2::new(x, 0.0) });
    let chosen = |name| assign::<8>(&rule(name), &explorers, &candidates, straight(&candidates));
    let pair = |number, candidate| Assignment { number, candidate };
    assert_eq!(*chosen("thesis"), [pair(0, 0), pair(1, 1)]);
    assert_eq!(*chosen("ours"), [pair(1, 0), pair(0, 1)]);
}

#[test]
fn clusters_split_and_merge() {
    let apart = [0b0010, 0b0001, 0b1000, 0b0100, 0, 0, 0, 0];
    assert_eq!([0, 1, 2, 3, 4].map(|robot| leader(&apart, robot)), [0, 0, 2, 2, 4]);
    let joined = [0b0010, 0b0101, 0b1010, 0b0100, 0, 0, 0, 0];
    assert_eq!([0, 1, 2, 3].map(|robot| leader(&joined, robot)), [0; 4]);
    // A link that only one end hears is none.
    assert_eq!(leader(&[0, 0b0001, 0, 0, 0, 0, 0, 0], 1), 1);
}

proptest! {
    #[test]
    fn nobody_shares_a_candidate_and_nobody_idles_without_need(
        places in prop::collection::vec((-9.0_f32..9.0, -9.0_f32..9.0, 0_u8..=48), 0..20),
        starts in prop::collection::vec((-9.0_f32..9.0, -9.0_f32..9.0), 1..=6),
        which in 0..RULES.len(),
    ) {
        let candidates: Vec<_> = places.iter().map(|&(x, y, gain)| given([x, y], gain)).collect();
        let explorers: Vec<_> = (0..).zip(&starts)
            .map(|(number, &(x, y))| Explorer { number, position: Point2::new(x, y) })
            .collect();
        let assigned =
            assign::<32>(&RULES[which].rule, &explorers, &candidates, straight(&candidates));
        prop_assert_eq!(assigned.len(), candidates.len().min(explorers.len()));
        for (n, one) in assigned.iter().enumerate() {
            let clash =
                |other: &Assignment| other.number == one.number || other.candidate == one.candidate;
            prop_assert!(!assigned[..n].iter().any(clash));
        }
    }

    #[test]
    fn no_bytes_panic_and_what_is_read_is_written_alike(
        bytes in prop::collection::vec(any::<u8>(), 0..80),
    ) {
        if let Ok(chunk) = Chunk::decode(&bytes) {
            prop_assert_eq!(&chunk.encode()[..], &bytes[..]);
        }
    }

    #[test]
    fn candidates_keep_their_distance(free in prop::collection::vec((0_u16..30, 0_u16..30), 0..200)) {
        let frame = Frame::new(Point2::new(0.0, 0.0), Metres(0.1), 30, 30).unwrap();
        let mut map = GridMap::<225>::new(frame).unwrap();
        for (column, row) in free {
            map.set(Cell::new(column, row), CellState::Free);
        }
        let found = extract(&map, Metres(0.3));
        prop_assert_eq!(found.is_empty(), map.frontiers().next().is_none());
        for (n, one) in found.iter().enumerate() {
            let is_near = |other: &Candidate| other.position.distance(one.position).0 < 0.3;
            prop_assert!(!found[..n].iter().any(is_near));
        }
    }
}
