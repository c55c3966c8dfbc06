//! SubT worlds, robots' maps and whole caves as the tunnel of a mission.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use cave_survey::{Memory, read};
use maps::{Ends, MapChoice, Route};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use robot_maps::{Cell, Occupancy, map_server};
use sim_harness::planning::explored::explored;
use units::{Db, Point2};
use world::{NodeKind, Radio, SkeletonPlace, Tunnel};

fn map(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/maps").join(name)
}

fn choice(name: &str, from: &str, to: &str, around_m: Option<f32>) -> MapChoice {
    let given = |name: &str| (!name.is_empty()).then(|| name.to_owned());
    let ends = Ends { from: given(from), to: given(to), around_m };
    MapChoice { file: map(name), ends, ..MapChoice::default() }
}

fn told(choice: &MapChoice) -> String {
    let error = choice.dig().map(|_| ()).unwrap_err().to_string();
    assert_eq!(error.lines().count(), 1, "{error}");
    error
}

fn junctions(tunnel: &Tunnel) -> usize {
    tunnel.skeleton().nodes().iter().filter(|node| node.kind == NodeKind::Junction).count()
}

/// A room of 12 by 4 m in which one cell in a hundred is occupied by noise.
fn speckled() -> Occupancy {
    const COLUMNS: usize = 240;
    const ROWS: usize = 80;
    let mut state = 1_u32;
    let cells = (0..COLUMNS * ROWS).map(|n| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let (column, row) = (n % COLUMNS, n / COLUMNS);
        let is_edge = column < 2 || row < 2 || column >= COLUMNS - 2 || row >= ROWS - 2;
        let is_speck = (state >> 16).is_multiple_of(100);
        if is_edge || is_speck { Cell::Occupied } else { Cell::Free }
    });
    Occupancy::new(COLUMNS, cells.collect(), 0.05, [0.0; 3])
}

#[test]
fn explorers_and_a_route_have_the_same_specks_taken_out() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("speckled");
    std::fs::create_dir_all(&folder).unwrap();
    let (mut yaml, mut image) = (Vec::new(), Vec::new());
    map_server::write(&speckled(), &mut yaml, &mut image).unwrap();
    std::fs::write(folder.join("room.yaml"), yaml).unwrap();
    std::fs::write(folder.join(map_server::IMAGE), image).unwrap();
    let file = folder.join("room.yaml");
    let (world, _) = explored(&file, None).unwrap();
    let seen = world.visible_cells() as f32 * 0.01;
    let (tunnel, _) = MapChoice { file, ..MapChoice::default() }.dig().unwrap();
    let flown = tunnel.occupancy(0.05).unwrap().count(Cell::Free) as f32 * 0.0025;
    assert!(seen > 40.0 && (seen - flown).abs() < 5.0, "{seen} m2 seen, {flown} m2 flown");
}

/// A hall of 10 by 10 m, round or square, with noise in this many of 1000 cells.
fn hall(is_round: bool, noise: u32) -> Occupancy {
    const CELLS: usize = 200;
    let mut state = 1_u32;
    let cells = (0..CELLS * CELLS).map(|n| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let [column, row] = [n % CELLS, n / CELLS];
        let off = [column, row].map(|it| it as f64 + 0.5 - 100.0);
        let is_inside = match is_round {
            true => off[0].hypot(off[1]) < 98.0,
            false => off.iter().all(|off| off.abs() < 98.0),
        };
        if !is_inside || (state >> 16) % 1000 < noise { Cell::Occupied } else { Cell::Free }
    });
    Occupancy::new(CELLS, cells.collect(), 0.05, [0.0; 3])
}

#[test]
fn a_hall_as_wide_as_it_is_long_has_a_way_between_any_two_of_its_points() {
    for (is_round, noise) in [(false, 0), (false, 10), (true, 0), (true, 10)] {
        let hall = hall(is_round, noise);
        let find = |from: &str, to: &str| {
            let given = |name: &str| (!name.is_empty()).then(|| name.to_owned());
            let ends = Ends { from: given(from), to: given(to), around_m: None };
            Route::find_in_grid(&hall, &ends).map(|(route, tunnel)| {
                let at = |text: &str| {
                    let (x, y) = text.split_once(',').unwrap();
                    [x, y].map(|it| it.parse::<f64>().unwrap())
                };
                (at(&route.from), at(&route.to), route.length_m, tunnel)
            })
        };
        let away = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        for (from, to) in [([2.0, 2.5], [8.0, 7.5]), ([2.0, 3.0], [8.0, 3.0])] {
            let text = |[x, y]: [f64; 2]| format!("{x},{y}");
            let (begin, end, length_m, tunnel) = find(&text(from), &text(to)).unwrap();
            assert!(away(begin, from) < 0.3 && away(end, to) < 0.3, "{begin:?} {end:?}");
            let straight = away(from, to);
            assert!((straight - 0.6..2.0 * straight).contains(&length_m), "{length_m}");
            // The whole way is free.
            let main = &tunnel.skeleton().edges()[0];
            let steps = (0..=100).map(|n| main.line().length() * n as f32 / 100.0);
            assert!(steps.into_iter().all(|along| tunnel.is_free(main.line().at(along).0)));
            let (begin, _, length_m, _) = find(&text(from), "").unwrap();
            assert!(away(begin, from) < 0.3 && length_m >= 5.0, "{begin:?} {length_m}");
        }
        let (_, _, length_m, _) = find("", "").unwrap();
        assert!(length_m >= 5.0, "{length_m}");
    }
}

#[test]
fn a_route_through_a_hall_begins_and_ends_where_it_is_asked_to() {
    // The axis of a hall of 12 by 4 m ends 2 m before its ends.
    let ends = Ends { from: Some("0.5,0.5".into()), to: Some("11.5,3.5".into()), around_m: None };
    let (route, _) = Route::find_in_grid(&speckled(), &ends).unwrap();
    assert!(route.length_m > 11.0, "{} to {}: {}", route.from, route.to, route.length_m);
}

#[test]
fn a_subt_world_is_a_network_with_its_loop() {
    let (tunnel, route) = choice("crossing.dot", "", "8", None).dig().unwrap();
    assert_eq!((&*route.from, &*route.to, route.stations), ("base_station", "tile_8", 6));
    assert!((route.length_m - 108.0).abs() < 0.1, "{}", route.length_m);
    // The loop, and the branch to the shaft.
    assert_eq!((route.side_galleries, junctions(&tunnel)), (2, 2));
    let hindrances: Vec<_> = route.hindrances.iter().map(ToString::to_string).collect();
    assert_eq!(hindrances, [] as [&str; 0]);
    // From one end of the loop to the other the way round is 40 m longer than along the route.
    let skeleton = tunnel.skeleton();
    let loop_ = skeleton.edge(skeleton.edge_named("side-1").unwrap());
    let around = if loop_.joints().len() == 2 { loop_.line().length() } else { 0.0 };
    let other = skeleton.edge(skeleton.edge_named("side-2").unwrap()).line().length();
    assert!((around.max(other) - 80.0).abs() < 0.1, "{around} {other}");
    // The passage is as wide as the mesh, and the crossing is open.
    assert!((tunnel.range(Point2::new(20.0, 0.0), [0.0, 1.0], 9.0) - 2.6).abs() < 0.01);
    assert!(tunnel.range(Point2::new(48.0, 0.0), [0.0, 1.0], 15.0) > 12.0);
    assert_eq!(route.long_reach_m, Some(4.0));
}

#[test]
fn side_galleries_are_closed_where_they_are_not_wanted() {
    let (tunnel, route) = choice("crossing.sdf", "", "tile_8", Some(0.0)).dig().unwrap();
    assert_eq!((route.side_galleries, tunnel.skeleton().edges().len()), (0, 1));
    assert!(tunnel.range(Point2::new(48.0, 0.0), [0.0, 1.0], 15.0) < 3.0);
    let (tunnel, _) = choice("crossing.sdf", "", "tile_8", Some(15.0)).dig().unwrap();
    assert!(tunnel.skeleton().edges().len() > 1);
    assert!(tunnel.range(Point2::new(48.0, 0.0), [0.0, 1.0], 15.0) > 9.0);
}

#[test]
fn a_shaft_of_a_subt_world_is_not_flown() {
    let error = told(&choice("crossing.dot", "", "10", None));
    assert!(error.contains("tile_9 to tile_10 is a shaft of"), "{error}");
    assert!(error.contains("end the route before it, at \"tile_9\""), "{error}");
    let error = told(&choice("crossing.dot", "tile_12", "", None));
    assert!(error.contains("the world has no tile \"tile_12\"; did you mean tile_"), "{error}");
}

#[test]
fn a_robots_map_is_a_network_with_its_room() {
    let (tunnel, route) = choice("office.yaml", "-1,0.8", "8.8,4", None).dig().unwrap();
    assert!((route.length_m - 12.5).abs() < 1.0, "{}", route.length_m);
    assert!((route.median_width_m - 1.6).abs() < 0.2, "{}", route.median_width_m);
    assert!(route.side_galleries >= 2, "{}", route.side_galleries);
    assert!(route.warnings[0].to_string().contains("office.pgm beside this file is read"));
    // The pillar stands in the room; the speck in the corridor is none.
    assert_eq!(tunnel.outlines().len(), 2);
    assert_eq!(route.long_reach_m, None);
    let (_, longest) = choice("office.yaml", "", "", None).dig().unwrap();
    assert!(longest.length_m > route.length_m);
}

#[test]
fn a_robots_map_refuses_points_outside() {
    assert!(
        told(&choice("office.yaml", "90,90", "", None))
            .contains("\"90,90\" is no point of the map's free space; give x,y in metres")
    );
    assert!(told(&choice("office.yaml", "station", "", None)).contains("\"station\" is no point"));
    assert!(told(&choice("office.pgm", "", "", None)).contains("an image alone is no map; give"));
}

/// A cave of this many legs along its main passage, with a side passage at every tenth station.
fn cave(legs: usize) -> String {
    let main = (0..legs).map(|n| format!("{n} {} 10 90 0\n", n + 1));
    let sides = (5..legs).step_by(10).map(|n| format!("{n} {n}a 10 0 0\n{n}a {n}b 10 0 0\n"));
    main.chain(sides).collect()
}

#[test]
fn a_cave_is_dug_with_its_junctions_where_that_is_wanted() {
    let survey = read(&Memory::default().with("cave.svx", cave(12)), "cave.svx").unwrap();
    let ends = |around_m| Ends { from: Some("0".into()), to: Some("12".into()), around_m };
    let (route, tunnel) = Route::find(&survey, &ends(Some(50.0))).unwrap();
    assert_eq!((route.side_galleries, junctions(&tunnel)), (1, 1));
    let side = tunnel.skeleton().edge_named("side-1").unwrap();
    let end = SkeletonPlace { edge: side, along: 20.0 };
    assert!((tunnel.skeleton().distance(SkeletonPlace::main(0.0), end).0 - 70.0).abs() < 1e-3);
    let (route, _) = Route::find(&survey, &ends(None)).unwrap();
    assert_eq!(route.side_galleries, 0);
}

#[test]
fn passages_above_one_another_are_not_joined() {
    // A gallery climbs round a corner and passes 12 m above the route.
    let text = "1 2 20 90 0\n2 3 20 90 0\n2 a 20 0 30\na b 10 90 30\nb c 40 180 0\nc d 5 180 0\n";
    let survey = read(&Memory::default().with("cave.svx", text), "cave.svx").unwrap();
    let ends = Ends { from: Some("1".into()), to: Some("3".into()), around_m: Some(100.0) };
    let (route, tunnel) = Route::find(&survey, &ends).unwrap();
    assert_eq!((route.side_galleries, route.above_or_below), (0, 1));
    assert_eq!(tunnel.skeleton().edges().len(), 1);
}

#[test]
fn what_is_dug_does_not_grow_with_the_cave() {
    let size = |legs: usize| {
        let survey = read(&Memory::default().with("cave.svx", cave(legs)), "cave.svx").unwrap();
        let ends = Ends { from: Some("0".into()), to: None, around_m: Some(30.0) };
        let (_, tunnel) = Route::find(&survey, &ends).unwrap();
        let corners: usize = tunnel.outlines().iter().map(Vec::len).sum();
        (tunnel.skeleton().edges().len(), tunnel.skeleton().nodes().len(), corners)
    };
    assert_eq!(size(60), size(3000));
}

#[test]
fn the_radios_table_says_what_stands_between_two_places() {
    let (tunnel, _) = choice("crossing.dot", "", "8", None).dig().unwrap();
    let tunnel = Arc::new(tunnel);
    let law = radio_model::PathLoss::UChain(radio_model::UChain {
        attenuation: radio_model::Attenuation::RockDepth,
        walls: radio_model::Walls::Rock,
        loss_at_1m: Db(40.0),
    });
    let radio = Radio::survey(&tunnel, law);
    let skeleton = tunnel.skeleton();
    for edge in 0..skeleton.edges().len() as u16 {
        for n in 0..30 {
            let a = SkeletonPlace { edge, along: n as f32 };
            let b = SkeletonPlace::main(3.0 * n as f32);
            let [p, q] = [a, b].map(|place| skeleton.at(place).0);
            let link =
                radio_model::Geometry { along: skeleton.distance(a, b), straight: p.distance(q) };
            let exact = law.loss(link, law.term(tunnel.obstruction(p, q))).0;
            let found = radio.strength(a, b).loss().0;
            assert!((found - exact).abs() < 0.3, "{edge} {n}: {found} {exact}");
        }
    }
}

/// Rooms and corridors as cells.
fn drawn(boxes: &[(usize, usize, usize, usize)]) -> Vec<Cell> {
    let mut cells = vec![Cell::Unknown; 40 * 40];
    for &(x, y, w, h) in boxes {
        for row in y..(y + h).min(39) {
            for column in x..(x + w).min(39) {
                cells[row * 40 + column] = Cell::Free;
            }
        }
    }
    cells
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        cases: 64,
        ..ProptestConfig::default()
    })]

    #[test]
    fn a_tunnel_that_is_drawn_and_read_again_has_the_same_free_space(
        boxes in prop::collection::vec((1usize..30, 1usize..30, 4usize..20, 4usize..20), 1..6),
    ) {
        let cells = drawn(&[&boxes[..], &[(1, 18, 38, 6)]].concat());
        let map = Occupancy::new(40, cells, 0.25, [3.0, -4.0, 0.0]);
        let find = |map: &Occupancy, from: &str| {
            Route::find_in_grid(map, &Ends { from: Some(from.into()), ..Ends::default() })
        };
        // A way out of a corner of a large room may be too short to fly.
        let found = find(&map, "3.5,1.25");
        prop_assume!(found.is_ok());
        let (_, tunnel) = found.unwrap();
        // The outlines are simplified within half a cell, so cells at the walls may differ.
        let drawn = tunnel.occupancy(0.25).unwrap();
        let again = find(&drawn, "0,0");
        prop_assume!(again.is_ok());
        let (_, again) = again.unwrap();
        let area = |tunnel: &Tunnel| tunnel.occupancy(0.25).unwrap().count(Cell::Free) as f32;
        let (one, other) = (area(&tunnel), area(&again));
        prop_assert!((one - other).abs() <= 0.05 * one, "{one} {other}");
        // The main gallery lies in the free space.
        for edge in tunnel.skeleton().edges() {
            let length = edge.line().length();
            for n in 0..=10 {
                let at = edge.line().at(length * n as f32 / 10.0).0;
                prop_assert!(tunnel.is_free(at), "{} at {at:?}", edge.name());
            }
        }
    }
}
