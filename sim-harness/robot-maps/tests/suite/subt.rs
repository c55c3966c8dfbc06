//! SubT worlds: which tiles are joined, and where.

use cave_survey::Memory;
use robot_maps::Refusal;
use robot_maps::subt::{self, World};

/// Three tiles in a row and one round a corner, as SubT's tools write them.
const DOT: &str = "/* Visibility graph */
graph {
  /* ==== Vertices ==== */
  0   [label=\"0::base_station::BaseStation\"];
  1   [label=\"1::tunnel_tile_5::tile_1\"];
  2   [label=\"2::tunnel_tile_2::tile_2\"];

  0  -- 1   [label=1];
  1  -- 2   [label=3];  /* Corner */
}
";

fn include(name: &str, model: &str, pose: &str) -> String {
    let uri = format!("https://fuel.ignitionrobotics.org/1.0/OpenRobotics/models/{model}");
    format!("<include><name>{name}</name><pose>{pose}</pose><uri>{uri}</uri></include>\n")
}

fn sdf() -> String {
    let base = include("base_station", "Base Station", "-8 0 0 0 0 -1.570796");
    let one = include("tile_1", "Tunnel Tile 5", "20 0 0 0 0 -1.570796");
    let two = include("tile_2", "Tunnel Tile 2", "40 0 0 0 0 3.141593");
    let cap = include("blocker_1", "Tunnel Tile Blocker", "51 0 0 0 0 0");
    format!(
        "<?xml version=\"1.0\"?>\n<sdf version=\"1.6\"><world name=\"small\">\n{base}{one}{two}{cap}</world></sdf>\n"
    )
}

fn read(dot: &str, sdf: &str) -> Result<World, Refusal> {
    subt::read(&Memory::default().with("w.dot", dot).with("w.sdf", sdf), "w.dot")
}

fn near(a: [f64; 3], b: [f64; 3]) -> bool {
    (0..3).all(|axis| (a[axis] - b[axis]).abs() < 0.01)
}

#[test]
fn tiles_are_joined_at_their_openings() {
    let world = read(DOT, &sdf()).unwrap();
    let names: Vec<_> = world.tiles.iter().map(|tile| &*tile.name).collect();
    assert_eq!((&*world.title, names), ("small", vec!["base_station", "tile_1", "tile_2"]));
    assert!(near(world.joints[0].at, [10.0, 0.0, 0.0]), "{:?}", world.joints);
    assert!(near(world.joints[1].at, [30.0, 0.0, 0.0]), "{:?}", world.joints);
    assert_eq!((world.joints[1].tiles, world.joints[1].cost), ([1, 2], Some(3.0)));
    assert!(world.warnings.is_empty());
    assert_eq!(
        subt::read(&Memory::default().with("w.dot", DOT).with("w.sdf", sdf()), "w.sdf"),
        Ok(world)
    );
}

#[test]
fn a_tile_that_has_no_pose_is_left_out_with_a_remark() {
    let world = read(DOT, &sdf().replace("tile_2", "tile_9")).unwrap();
    assert_eq!((world.tiles.len(), world.joints.len()), (2, 1));
    assert_eq!(world.warnings[0].to_string(), "w.dot:6: the .sdf has no tile_2: left out");
}

#[test]
fn a_model_that_is_not_known_is_joined_where_it_stands() {
    let world = read(DOT, &sdf().replace("Tunnel Tile 2", "A Tile of Next Year")).unwrap();
    assert!(near(world.joints[1].at, [35.0, 0.0, 0.0]), "{:?}", world.joints);
    assert!(world.tiles[2].passage().is_assumed && !world.tiles[1].passage().is_assumed);
}

#[test]
fn bad_input_is_refused_with_place_and_remedy() {
    for (dot, sdf, told) in [
        ("no graph at all", sdf(), "w.dot: this is no graph; give the .dot"),
        ("graph { }", sdf(), "w.dot: the graph has no vertices"),
        (
            "graph {\n 1 [label=\"1::a::tile_1\"];\n\n x -- 1;\n}",
            sdf(),
            "w.dot:4: \"x\" is no vertex",
        ),
        (DOT, "<sdf>\n<world></sdf>".into(), "w.sdf:2: this is no XML"),
        (DOT, "<sdf></sdf>".into(), "w.sdf: it has no world"),
        (
            DOT,
            sdf().replace("20 0 0 0", "20 0 0"),
            "w.sdf:4: the pose of tile_1 is not six numbers",
        ),
        (
            DOT,
            "<sdf><world/></sdf>".into(),
            "no two tiles of the graph that are joined have a pose",
        ),
    ] {
        let error = read(dot, &sdf).unwrap_err().to_string();
        assert!(error.contains(told) && error.lines().count() == 1, "{error}");
    }
    let alone = Memory::default().with("w.dot", DOT);
    let error = subt::read(&alone, "w.dot").unwrap_err().to_string();
    assert!(error.contains("there is no file \"w.sdf\""), "{error}");
}
