//! The places of points in plans in which nearest points jump.

use std::path::{Path, PathBuf};

use maps::MapChoice;
use random::{Purpose, Stream};
use units::Point2;
use world::layout::{Layout, Passage, Room};
use world::{Gallery, Skeleton, SkeletonPlace, Tunnel};

fn gallery(name: &str, width: f32, corners: &[[f32; 2]]) -> Gallery {
    let centre_line = corners.iter().map(|&[x, y]| Point2::new(x, y)).collect();
    Gallery { name: name.into(), centre_line, width }
}

fn dug(galleries: &[Gallery], rooms: &[([f32; 2], [f32; 2])]) -> Tunnel {
    let rooms =
        rooms.iter().map(|&([x, y], size)| Room { centre: Point2::new(x, y), size }).collect();
    Tunnel::dig(&Layout { galleries: galleries.to_vec(), widths: Vec::new(), rooms }).unwrap()
}

/// A hall of 6 by 7.4 m with the exit at the far end of the wall opposite the entrance.
fn hall() -> Tunnel {
    let line = [[0.0, 0.0], [8.0, 0.0], [8.0, -6.0], [18.0, -6.0]];
    dug(&[gallery("main", 1.2, &line)], &[([8.0, -3.0], [6.0, 7.4])])
}

/// A passage up to 6 m wide whose stations stand at one wall and at the other, as cavers shoot.
fn zigzag() -> Tunnel {
    let stations = [
        ([0.0, 0.0], 0.8),
        ([5.0, 0.0], 1.5),
        ([7.0, 2.0], 2.5),
        ([8.5, -2.0], 2.5),
        ([10.0, 2.0], 2.5),
        ([12.0, -1.0], 2.0),
        ([17.0, 0.0], 0.8),
    ];
    let stations: Vec<_> = stations.iter().map(|&([x, y], r)| (Point2::new(x, y), r)).collect();
    let centre_line = stations.iter().map(|(at, _)| *at).collect();
    let main = Gallery { name: "main".into(), centre_line, width: 2.0 };
    Tunnel::surveyed(Skeleton::of(&[main]), &[Passage { stations }]).unwrap()
}

/// Two galleries as wide as SubT's, of which one branches off at a right angle.
fn wide_fork() -> Tunnel {
    let main = gallery("main", 5.2, &[[0.0, 0.0], [24.0, 0.0]]);
    dug(&[main, gallery("side", 5.2, &[[12.0, 0.0], [12.0, 14.0]])], &[])
}

/// Galleries that meet at acute angles and turn back beside one another.
fn winding_fork() -> Tunnel {
    let main = [[0.0, 0.0], [6.0, 0.0], [8.0, 3.0], [4.0, 5.0], [8.0, 8.0], [14.0, 8.0]];
    let side = [[6.0, 0.0], [10.0, -2.0], [10.0, -5.0], [5.0, -4.0]];
    dug(&[gallery("main", 1.4, &main), gallery("side", 1.0, &side)], &[])
}

/// The points of a grid that are free, with this much air around them.
fn free_points(tunnel: &Tunnel, step: f32, air: f32) -> Vec<Point2> {
    let corners = tunnel.outlines().iter().flatten();
    let low = corners.clone().fold([f32::MAX; 2], |low, p| [low[0].min(p.x), low[1].min(p.y)]);
    let high = corners.fold([f32::MIN; 2], |high, p| [high[0].max(p.x), high[1].max(p.y)]);
    let count = |axis: usize| ((high[axis] - low[axis]) / step) as u32;
    let point = |n: u32, m: u32| {
        Point2::new(low[0] + (0.37 + n as f32) * step, low[1] + (0.41 + m as f32) * step)
    };
    let all = (0..count(0)).flat_map(|n| (0..count(1)).map(move |m| point(n, m)));
    all.filter(|at| tunnel.is_free(*at) && tunnel.bump(*at, air).is_none()).collect()
}

fn apart(tunnel: &Tunnel, a: SkeletonPlace, b: SkeletonPlace) -> f32 {
    tunnel.skeleton().distance(a, b).0
}

/// The farthest that a place goes for each metre of its point, where that is.
fn steepest(tunnel: &Tunnel, step: f32) -> (f32, Point2) {
    const MOVE_M: f32 = 0.01;
    let mut steepest = (0.0, Point2::default());
    for at in free_points(tunnel, step, 0.05) {
        let here = tunnel.place(at, None);
        for (x, y) in [(MOVE_M, 0.0), (0.0, MOVE_M)] {
            let there = tunnel.place(Point2::new(at.x + x, at.y + y), None);
            let slope = apart(tunnel, here, there) / MOVE_M;
            if slope > steepest.0 {
                steepest = (slope, at);
            }
        }
    }
    steepest
}

/// How wide the passage is at a point: across the nearest centre-line, at least as far as the point is
/// from it.
fn width(tunnel: &Tunnel, at: Point2) -> f32 {
    let lines = tunnel.skeleton().edges().iter().map(|edge| {
        let off = edge.line().nearest(at).off_squared.sqrt();
        edge.width().0.max(2.0 * off)
    });
    lines.fold(f32::INFINITY, f32::min)
}

fn sees(tunnel: &Tunnel, a: Point2, b: Point2) -> bool {
    tunnel.obstruction(a, b).walls == 0
}

#[test]
fn a_step_of_a_centimetre_moves_the_place_by_a_few() {
    for (name, tunnel, most) in [
        ("hall", hall(), 2.5),
        ("zigzag", zigzag(), 2.5),
        ("wide fork", wide_fork(), 3.5),
        ("winding fork", winding_fork(), 4.5),
    ] {
        let (slope, at) = steepest(&tunnel, 0.1);
        assert!(slope < most, "{name}: {slope} m for each at {at:?}");
    }
}

#[test]
fn the_place_of_a_point_does_not_depend_on_how_it_came_there() {
    for (name, tunnel) in [
        ("hall", hall()),
        ("zigzag", zigzag()),
        ("wide fork", wide_fork()),
        ("winding fork", winding_fork()),
    ] {
        let mut random = Stream::new(1, Purpose::Place);
        let mut point = tunnel.skeleton().at(SkeletonPlace::main(0.5)).0;
        let mut last = tunnel.place(point, None);
        let mut heading = 0.0_f32;
        for _ in 0..20_000 {
            heading += 0.3 * (random.uniform() - 0.5);
            let (sin, cos) = heading.sin_cos();
            let next = Point2::new(point.x + 0.05 * cos, point.y + 0.05 * sin);
            if !tunnel.is_free(next) || tunnel.bump(next, 0.1).is_some() {
                heading += 2.0;
                continue;
            }
            point = next;
            last = tunnel.place(point, Some(last));
            assert_eq!(last, tunnel.place(point, None), "{name}: at {point:?}");
        }
    }
}

/// By how many widths of the passage, the mean of those at both points, the straight line of two
/// points is longer than their way, and the way longer than one and a half straight lines where they
/// see one another: the most of each over pairs of these points.
fn differences(tunnel: &Tunnel, points: &[Point2]) -> [f32; 2] {
    let known: Vec<_> =
        points.iter().map(|at| (*at, tunnel.place(*at, None), width(tunnel, *at))).collect();
    let mut most = [0.0_f32; 2];
    for (n, (a, on_a, width_a)) in known.iter().enumerate() {
        for (b, on_b, width_b) in &known[..n] {
            let (straight, way) = (a.distance(*b).0, apart(tunnel, *on_a, *on_b));
            let width = 0.5 * (width_a + width_b);
            most[0] = most[0].max((straight - way) / width);
            let longer = (way - 1.5 * straight) / width;
            if longer > most[1] && straight < 16.0 && sees(tunnel, *a, *b) {
                most[1] = longer;
            }
        }
    }
    most
}

#[test]
fn the_way_and_the_straight_line_differ_by_no_more_than_the_passage_is_wide() {
    for (name, tunnel) in [
        ("hall", hall()),
        ("zigzag", zigzag()),
        ("wide fork", wide_fork()),
        ("winding fork", winding_fork()),
    ] {
        let [shorter, longer] = differences(&tunnel, &free_points(&tunnel, 0.5, 0.1));
        assert!(shorter < 2.0, "{name}: the way is {shorter} widths shorter");
        assert!(longer < 1.25, "{name}: the way is {longer} widths longer");
    }
}

#[test]
fn a_drone_changes_over_to_a_branch_only_where_it_is_clearly_nearer() {
    let tunnel = dug(
        &[
            gallery("main", 1.0, &[[0.0, 0.0], [14.0, 0.0]]),
            gallery("side", 1.0, &[[5.0, 0.0], [5.0, 3.0]]),
        ],
        &[],
    );
    let mut at = SkeletonPlace::main(4.0);
    // Past the mouth of the side gallery, off the middle by less than the loyalty.
    for step in 0..20 {
        at = tunnel.place(Point2::new(4.0 + 0.1 * step as f32, 0.25), Some(at));
        assert_eq!(at.edge, 0);
    }
    at = SkeletonPlace::main(5.0);
    for step in 0..20 {
        at = tunnel.place(Point2::new(5.0, 0.1 * step as f32), Some(at));
    }
    assert_eq!(tunnel.skeleton().edge(at.edge).name(), "side");
    assert!((at.along - 1.9).abs() < 1e-5);
    for step in 0..30 {
        let along = 0.1 * step as f32;
        at = tunnel
            .place(Point2::new(5.0 + (along - 1.9).max(0.0), (1.9 - along).max(0.0)), Some(at));
    }
    assert_eq!((at.edge, (at.along - 6.0).abs() < 1e-4), (0, true));
}

/// A relay that rests in a right angle trembles across its diagonal, and its links do not jump.
#[test]
fn round_a_corner_the_place_of_a_point_moves_with_the_point() {
    let line = [[0.0, 0.0], [5.0, 0.0], [5.0, 4.0], [8.0, 6.0], [12.0, 6.0]];
    let tunnel = dug(&[gallery("main", 1.5, &line)], &[]);
    let corners = [(5.0, 5.0, 0.0), (9.0, 5.0, 4.0), (12.606, 8.0, 6.0)];
    for (length, x, y) in corners {
        for radius in [0.1_f32, 0.3, 0.5, 0.7] {
            let count = 2_000;
            let point = |n: usize| {
                let (sin, cos) = (core::f32::consts::TAU * n as f32 / count as f32).sin_cos();
                Point2::new(x + radius * cos, y + radius * sin)
            };
            let step = core::f32::consts::TAU * radius / count as f32;
            let mut at = tunnel.place(point(0), Some(SkeletonPlace::main(length)));
            for n in 1..=count {
                let next = tunnel.place(point(n), Some(at));
                let moved = (next.along - at.along).abs();
                assert!(moved < 2.5 * step + 1e-4, "{moved} m at {:?}, over {step} m", point(n));
                at = next;
            }
        }
        // On the centre-line nothing has changed.
        for ahead in [-0.8, -0.2, 0.0, 0.1, 0.6] {
            let (point, _) = tunnel.skeleton().edge(0).line().at(length + ahead);
            let at = tunnel.place(point, Some(SkeletonPlace::main(length)));
            assert!((at.along - length - ahead).abs() < 1e-3, "{ahead} m from {length} m: {at:?}");
        }
    }
}

/// A drone that flew round the corner of a wide junction never came within 1.5 m of the junction, and
/// was taken to stay in the gallery that it had left.
#[test]
fn a_drone_that_turns_at_the_wall_of_a_wide_gallery_is_in_the_branch() {
    let tunnel = wide_fork();
    let mut at = SkeletonPlace::main(5.0);
    let mut fly = |x: f32, y: f32| {
        at = tunnel.place(Point2::new(x, y), Some(at));
        at
    };
    (0..52).for_each(|step| _ = fly(5.0 + 0.1 * step as f32, 1.8));
    let end = (0..80).map(|step| fly(10.2, 1.8 + 0.1 * step as f32)).last().unwrap();
    assert_eq!(tunnel.skeleton().edge(end.edge).name(), "side");
    assert!((end.along - 9.7).abs() < 1e-3, "{end:?}");
}

/// In a mission the strength of a link jumped by 10 dB where a relay passed the diagonal.
#[test]
fn round_the_corner_of_a_wide_junction_the_place_of_a_point_moves_with_the_point() {
    let tunnel = wide_fork();
    for (radius, count) in [(0.8_f32, 4_000), (1.8, 8_000), (2.5, 8_000)] {
        let point = |n: usize| {
            let (sin, cos) = (core::f32::consts::TAU * n as f32 / count as f32).sin_cos();
            Point2::new(12.0 + radius * cos, radius * sin)
        };
        let step = core::f32::consts::TAU * radius / count as f32;
        let mut at = tunnel.place(point(0), Some(SkeletonPlace::main(12.0 + radius)));
        for n in 1..=count {
            let next = tunnel.place(point(n), Some(at));
            let moved = apart(&tunnel, at, next);
            assert!(moved < 4.0 * step + 1e-4, "{moved} m at {:?}, over {step} m", point(n));
            at = next;
        }
    }
}

fn caves() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/caves")
}

#[test]
#[ignore = "needs the surveys in ../shared/data"]
fn recorded_caves_keep_the_way_within_a_width_of_the_straight_line() {
    let surveys = [
        "dowprov/DowProv.svx",
        "fulford/Fulfords.mak",
        "mietusia_wyznia/Surveys/Jaskinia_Mietusia_Wyznia/mietusia_wyznia.svx",
    ];
    // The survey of Suhadolca was dived: it has no route.
    for name in surveys {
        let choice =
            MapChoice { file: caves().join(name), within: Some(caves()), ..MapChoice::default() };
        let (tunnel, route) = choice.dig().unwrap();
        let [shorter, longer] = differences(&tunnel, &free_points(&tunnel, 0.7, 0.1));
        let (slope, at) = steepest(&tunnel, 0.3);
        let line = tunnel.skeleton().edge(0).line().length();
        println!("{name}: {shorter} {longer} {slope} {line} of {}", route.length_m);
        assert!(shorter < 2.0, "{name}: the way is {shorter} widths shorter");
        assert!(longer < 1.25, "{name}: the way is {longer} widths longer");
        assert!(slope < 8.0, "{name}: {slope} m for each at {at:?}");
    }
}
