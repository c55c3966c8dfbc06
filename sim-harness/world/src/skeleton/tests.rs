//! Distances, ways and places on skeletons small enough to measure by hand.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use units::Point2;

use super::*;

fn gallery(name: &str, corners: &[[f32; 2]]) -> Gallery {
    let centre_line = corners.iter().map(|&[x, y]| Point2::new(x, y)).collect();
    Gallery { name: name.into(), centre_line, width: 1.0 }
}

/// 8 m to the fork, then 10 m to either side.
fn fork() -> Skeleton {
    Skeleton::of(&[
        gallery("main", &[[0.0, 0.0], [8.0, 0.0]]),
        gallery("left", &[[8.0, 0.0], [16.0, 6.0]]),
        gallery("right", &[[8.0, 0.0], [16.0, -6.0]]),
    ])
}

/// A square of 4 m with a stem of 3 m: main goes up the stem and half round, the other half is a
/// gallery that leaves it and comes back to it.
fn ring() -> Skeleton {
    Skeleton::of(&[
        gallery("main", &[[0.0, 0.0], [3.0, 0.0], [3.0, 4.0], [7.0, 4.0]]),
        gallery("round", &[[3.0, 0.0], [7.0, 0.0], [7.0, 4.0]]),
    ])
}

fn place(skeleton: &Skeleton, name: &str, along: f32) -> SkeletonPlace {
    SkeletonPlace { edge: skeleton.edge_named(name).unwrap(), along }
}

fn distance(skeleton: &Skeleton, a: (&str, f32), b: (&str, f32)) -> f32 {
    skeleton.distance(place(skeleton, a.0, a.1), place(skeleton, b.0, b.1)).0
}

#[test]
fn a_corridor_is_one_edge_from_mouth_to_end() {
    let skeleton = Skeleton::of(&[gallery("main", &[[0.0, 0.0], [3.0, 4.0]])]);
    let kinds: Vec<_> = skeleton.nodes().iter().map(|node| node.kind).collect();
    assert_eq!(kinds, [NodeKind::Mouth, NodeKind::End]);
    assert_eq!(distance(&skeleton, ("main", 1.0), ("main", 4.5)), 3.5);
    // Beyond an end a place is as far as its length says.
    assert_eq!(distance(&skeleton, ("main", 1.0), ("main", 200.0)), 199.0);
}

#[test]
fn between_branches_the_way_leads_through_the_fork() {
    let skeleton = fork();
    let kinds: Vec<_> = skeleton.nodes().iter().map(|node| node.kind).collect();
    assert_eq!(kinds, [NodeKind::Mouth, NodeKind::Junction, NodeKind::End, NodeKind::End]);
    assert_eq!(distance(&skeleton, ("left", 5.0), ("right", 3.0)), 8.0);
    assert_eq!(distance(&skeleton, ("main", 6.0), ("right", 3.0)), 5.0);
    assert_eq!(distance(&skeleton, ("left", 10.0), ("main", 0.0)), 18.0);
    assert_eq!(distance(&skeleton, ("left", 2.0), ("left", 9.0)), 7.0);
}

#[test]
fn a_path_leads_along_the_shortest_way() {
    let skeleton = fork();
    let path = skeleton.path(place(&skeleton, "left", 5.0), place(&skeleton, "right", 3.0));
    assert_eq!(path.length(), 8.0);
    assert_eq!(path.at(0.0), place(&skeleton, "left", 5.0));
    assert_eq!(path.at(4.0), place(&skeleton, "left", 1.0));
    assert_eq!(path.at(7.0), place(&skeleton, "right", 2.0));
    assert_eq!(path.at(9.0), place(&skeleton, "right", 3.0));
}

#[test]
fn round_a_ring_the_shorter_way_counts() {
    let skeleton = ring();
    // 8 m along the main gallery, 8 m round: from 1 m before the far corner it is 7 m.
    assert_eq!(distance(&skeleton, ("main", 3.0), ("main", 10.0)), 7.0);
    assert_eq!(distance(&skeleton, ("round", 1.0), ("main", 4.0)), 2.0);
    assert_eq!(distance(&skeleton, ("round", 7.0), ("main", 10.0)), 2.0);
    assert_eq!(distance(&skeleton, ("main", 0.0), ("round", 8.0)), 11.0);
    let shortcut = Skeleton::of(&[
        gallery("main", &[[0.0, 0.0], [0.0, 4.0], [3.0, 4.0], [3.0, 0.0]]),
        gallery("across", &[[0.0, 0.0], [3.0, 0.0]]),
    ]);
    assert_eq!(distance(&shortcut, ("main", 1.0), ("main", 10.0)), 5.0);
    let path = shortcut.path(place(&shortcut, "main", 1.0), place(&shortcut, "main", 10.0));
    assert_eq!((path.length(), path.legs().len()), (5.0, 3));
}

#[test]
fn a_branch_joins_the_gallery_that_it_begins_in_crosses_or_comes_nearest_to() {
    let main = gallery("main", &[[0.0, 0.0], [20.0, 0.0]]);
    // Begins at the wall, half a metre from the middle.
    let wall = Skeleton::of(&[main.clone(), gallery("side", &[[5.0, 0.5], [5.0, 4.0]])]);
    assert_eq!(distance(&wall, ("main", 5.0), ("side", 4.0)), 4.0);
    assert_eq!(wall.edge(1).line().length(), 4.0);
    // Crosses in its middle.
    let cross = Skeleton::of(&[main.clone(), gallery("side", &[[5.0, -3.0], [5.0, 3.0]])]);
    assert_eq!(distance(&cross, ("main", 4.0), ("side", 5.0)), 3.0);
    // Crosses just behind its beginning, which is beyond the wall.
    let stub = Skeleton::of(&[main.clone(), gallery("side", &[[5.0, -0.8], [5.0, 3.0]])]);
    assert!((distance(&stub, ("main", 4.0), ("side", 1.8)) - 2.0).abs() < 1e-5);
    // Ends in it.
    let end = Skeleton::of(&[main.clone(), gallery("side", &[[5.0, 4.0], [5.0, 0.0]])]);
    assert_eq!(distance(&end, ("main", 4.0), ("side", 4.0)), 1.0);
    // Begins on the other side of a room.
    let room = Skeleton::of(&[main, gallery("side", &[[23.0, 0.0], [25.0, 0.0]])]);
    assert_eq!(distance(&room, ("main", 19.0), ("side", 5.0)), 6.0);
}

#[test]
fn only_places_on_one_way_from_the_base_are_in_line() {
    let skeleton = fork();
    let base = place(&skeleton, "main", 0.0);
    let in_line = |a: (&str, f32), b: (&str, f32)| {
        skeleton.in_line(base, place(&skeleton, a.0, a.1), place(&skeleton, b.0, b.1))
    };
    assert!(in_line(("main", 3.0), ("left", 2.0)));
    assert!(in_line(("left", 7.0), ("left", 2.0)));
    assert!(!in_line(("right", 3.0), ("left", 2.0)));
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// On any tree of galleries the distance is a metric, and a path is as long as the distance.
    #[test]
    fn the_geodesic_distance_is_a_metric(
        corners in prop::collection::vec((-9.0f32..9.0, -9.0f32..9.0), 3..6),
        branches in prop::collection::vec(((-9.0f32..9.0, -9.0f32..9.0), (-9.0f32..9.0, -9.0f32..9.0)), 0..4),
        picks in prop::collection::vec((0usize..5, 0.0f32..1.0), 3),
    ) {
        let line = |corners: &[(f32, f32)]| -> Vec<[f32; 2]> {
            corners.iter().map(|&(x, y)| [x, y]).collect()
        };
        let mut galleries = vec![gallery("main", &line(&corners))];
        for (n, (from, to)) in branches.iter().enumerate() {
            galleries.push(gallery(&format!("branch-{n}"), &line(&[*from, *to])));
        }
        let skeleton = Skeleton::of(&galleries);
        let places: Vec<_> = picks.iter().map(|&(edge, part)| {
            let edge = edge % skeleton.edges().len();
            let along = part * skeleton.edges()[edge].line().length();
            SkeletonPlace { edge: edge as u16, along }
        }).collect();
        let way = |a: usize, b: usize| skeleton.distance(places[a], places[b]).0;
        for (a, b) in [(0, 1), (1, 2), (0, 2)] {
            prop_assert!(way(a, b).is_finite());
            prop_assert!((way(a, b) - way(b, a)).abs() < 1e-3);
            let straight = skeleton.at(places[a]).0.distance(skeleton.at(places[b]).0).0;
            prop_assert!(way(a, b) >= straight - 1e-3, "{} m by way, {straight} m straight", way(a, b));
            let path = skeleton.path(places[a], places[b]);
            prop_assert!((path.length() - way(a, b)).abs() < 1e-3);
            let half = path.at(0.5 * path.length());
            let halves = skeleton.distance(places[a], half).0 + skeleton.distance(half, places[b]).0;
            prop_assert!((halves - way(a, b)).abs() < 1e-2, "{halves} m through the middle of {}", way(a, b));
        }
        prop_assert!(way(0, 2) <= way(0, 1) + way(1, 2) + 1e-3);
    }
}
