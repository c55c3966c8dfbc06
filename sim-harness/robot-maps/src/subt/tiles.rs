//! Holds what is known of the models of tiles: where their openings are, and how wide.
//!
//! The openings are those of the table `connectionPoints` in SubT's own `ConnectionHelper.cc`
//! (osrf/subt, `subt_ign/src`), in metres and in the axes of the tile. A model with lights has the
//! shape of the one without. The widths are measured on the meshes of `subt_gazebo/models`.

/// The width of a tunnel at the height at which drones fly, m: between the posts of
/// `tunnel_tile_5.dae` at 0.34 m above its floor, at x = ±2.598 m.
pub const TUNNEL_WIDTH_M: f64 = 5.2;

/// The width of the openings of a cave's tile at 0.3 m above its floor, m: in `cave_tile_1.obj`,
/// the walls of an opening lean from ±2.310 m at the floor to ±2.665 m at a height of 1.871 m. That
/// of the later tiles of types A and B, whose meshes are not in the repository, is assumed to be
/// the same.
const CAVE_WIDTH_M: f64 = 4.7;

/// What is known of the passages through a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// The width, m.
    pub width_m: f64,
    /// Whether the width is assumed.
    pub is_assumed: bool,
    /// Whether the tile is a vertical shaft.
    pub is_shaft: bool,
}

/// The passages of a model.
pub(super) fn passage(model: &str) -> Passage {
    let plain = plain(model);
    let is_tunnel = plain.starts_with("tunnel tile");
    let width_m = if plain.starts_with("cave") { CAVE_WIDTH_M } else { TUNNEL_WIDTH_M };
    Passage { width_m, is_assumed: !is_tunnel, is_shaft: plain.contains("vertical shaft") }
}

/// The openings of a model, m; `None` for a model that is not known.
pub(super) fn openings(model: &str) -> Option<&'static [[f64; 3]]> {
    let plain = plain(model);
    let alike = OPENINGS.iter().find(|(models, _)| models.contains(&&*plain));
    alike.map(|(_, openings)| *openings)
}

/// The name of a model without its lights, in the spelling of the table.
fn plain(model: &str) -> String {
    let model = model.to_ascii_lowercase().replace("%20", " ").replace('_', " ");
    let words = model.split_whitespace().filter(|word| *word != "lights");
    words.collect::<Vec<_>>().join(" ")
}

/// The models of one shape, and its openings.
type Shape = (&'static [&'static str], &'static [[f64; 3]]);

const OPENINGS: &[Shape] = &[
    // The staging areas, under the name of the base station, which stands 8 m behind their middle
    // and is turned by a right angle: the tunnels' opens 10 m before the middle, the caves' 12.5 m.
    (&["base station"], &[[0.0, 18.0, 0.0], [0.0, 20.5, 0.0]]),
    (
        &[
            "constrained tunnel tile short",
            "constrained tunnel tile tall",
            "tunnel tile 5",
            "rough tunnel tile straight",
        ],
        &[[0.0, -10.0, 0.0], [0.0, 10.0, 0.0]],
    ),
    (&["tunnel bend right"], &[[0.0, 0.0, 0.0], [15.0, 25.0, 0.0]]),
    (&["tunnel corner left"], &[[0.0, 0.0, 0.0], [-10.0, 15.0, 0.0]]),
    (&["tunnel corner right"], &[[0.0, 0.0, 0.0], [10.0, 15.0, 0.0]]),
    (&["tunnel elevation"], &[[0.0, 0.0, 0.0], [0.0, 20.0, 5.0]]),
    (
        &["tunnel intersection"],
        &[[0.0, 0.0, 0.0], [7.5, 7.5, 0.0], [-7.5, 7.5, 0.0], [0.0, 15.0, 0.0]],
    ),
    (&["tunnel intersection t"], &[[0.0, 0.0, 0.0], [7.5, 7.5, 0.0], [-7.5, 7.5, 0.0]]),
    (&["tunnel straight"], &[[0.0, 0.0, 0.0], [0.0, 5.0, 0.0]]),
    (
        &["tunnel tile 1", "tunnel tile 3", "tunnel tile 4"],
        &[[0.0, 10.0, 0.0], [10.0, 0.0, 0.0], [0.0, -10.0, 0.0], [-10.0, 0.0, 0.0]],
    ),
    (&["tunnel tile 2"], &[[10.0, 0.0, 0.0], [0.0, -10.0, 0.0]]),
    (
        &[
            "tunnel tile 6",
            "tunnel tile 7",
            "rough tunnel tile ramp",
            "rough tunnel tile vertical shaft",
        ],
        &[[0.0, -10.0, 0.0], [0.0, 10.0, 5.0]],
    ),
    (&["rough tunnel tile 90-degree turn"], &[[0.0, -10.0, 0.0], [10.0, 0.0, 0.0]]),
    (
        &["rough tunnel tile 4-way intersection"],
        &[[0.0, -10.0, 0.0], [0.0, 10.0, 0.0], [10.0, 0.0, 0.0], [-10.0, 0.0, 0.0]],
    ),
    (&["urban straight"], &[[0.0, 20.0, 0.0], [0.0, -20.0, 0.0]]),
    (&["urban bend right"], &[[0.0, -20.0, 0.0], [20.0, 0.0, 0.0]]),
    (&["urban bend left"], &[[0.0, -20.0, 0.0], [-20.0, 0.0, 0.0]]),
    (
        &["urban superpose"],
        &[[0.0, 20.0, 0.0], [0.0, -20.0, 0.0], [-20.0, 0.0, 10.0], [20.0, 0.0, 10.0]],
    ),
    (&["urban 3-way right intersection"], &[[0.0, 20.0, 0.0], [0.0, -20.0, 0.0], [20.0, 0.0, 0.0]]),
    (
        &["urban straight door right", "urban straight door right flipped"],
        &[[20.0, 0.0, 0.0], [-20.0, 0.0, 0.0], [-16.021, 3.94, 0.94]],
    ),
    (
        &["urban straight door left", "urban straight door left flipped"],
        &[[20.0, 0.0, 0.0], [-20.0, 0.0, 0.0], [-16.021, -3.94, 0.94]],
    ),
    (
        &["urban straight door right extension"],
        &[[20.0, 0.0, 0.0], [-20.0, 0.0, 0.0], [0.0, 20.0, 0.0]],
    ),
    (&["urban service room centered"], &[[0.0, 20.0, 0.0]]),
    (&["urban service room"], &[[-16.023, 3.906, 0.919]]),
    (
        &["urban service room straight", "urban 2 story large side 2"],
        &[[0.0, -20.0, 0.0], [0.0, 20.0, 0.0]],
    ),
    (
        &["urban platform"],
        &[
            [20.0, 0.0, 0.0],
            [-20.0, 0.0, 0.0],
            [0.0, 20.0, 1.7],
            [23.979, 3.906, 0.94],
            [-23.979, 3.906, 0.94],
        ],
    ),
    (
        &["urban platform open"],
        &[
            [20.0, 0.0, 0.0],
            [-20.0, 0.0, 0.0],
            [0.0, 20.0, 0.0],
            [23.979, 3.906, 0.919],
            [-23.979, 3.906, 0.919],
            [23.982, 11.743, 0.919],
        ],
    ),
    (&["urban stairwell platform"], &[[0.0, 20.0, 11.69], [0.0, -20.0, 1.69]]),
    (
        &["urban stairwell platform centered", "urban 2 story large side 1"],
        &[[0.0, 20.0, 10.0], [0.0, -20.0, 0.0]],
    ),
    (&["urban starting area"], &[[-16.021, 3.94, 0.919]]),
    (&["urban elevation up"], &[[0.0, 20.0, 5.0], [0.0, -20.0, 0.0]]),
    (&["urban elevation down"], &[[0.0, 20.0, 0.0], [0.0, -20.0, 5.0]]),
    (
        &["urban 2 story"],
        &[[0.0, 20.0, 10.0], [0.0, -20.0, 0.0], [-20.0, 0.0, 10.0], [20.0, 0.0, 0.0]],
    ),
    (&["urban large room split"], &[[0.0, -20.0, 0.0], [-20.0, 0.0, 0.0], [0.0, 20.0, 0.0]]),
    (
        &[
            "cave straight 01",
            "cave straight 01 type b",
            "cave straight 02 type b",
            "cave straight 03 type b",
            "cave straight 04 type b",
            "cave straight 05 type b",
        ],
        &[[0.0, 12.5, 0.0], [0.0, -12.5, 0.0]],
    ),
    (
        &["cave corner 01 type b", "cave corner 02 type b", "cave corner 30f type b"],
        &[[-12.5, 0.0, 0.0], [0.0, 12.5, 0.0]],
    ),
    (&["cave 3 way 01 type b"], &[[12.5, 0.0, 0.0], [-12.5, 0.0, 0.0], [0.0, 12.5, 0.0]]),
    (&["cave elevation type b"], &[[0.0, 12.5, 0.0], [0.0, -12.5, 10.0]]),
    (&["cave vertical shaft type b"], &[[0.0, 12.5, 20.0], [0.0, -12.5, 0.0]]),
    (&["cave cavern split 01 type b"], &[[0.0, 25.0, 25.0], [12.5, 0.0, 0.0], [-12.5, 0.0, 0.0]]),
    (&["cave cavern split 02 type b"], &[[12.5, 0.0, 0.0], [-12.5, 0.0, 0.0]]),
    (&["cave corner 30 type b", "cave corner 30 d type b"], &[[12.5, 0.0, 0.0], [0.0, 12.5, 0.0]]),
    (&["cave corner 30f d type b"], &[[12.5, 0.0, 0.0], [0.0, -12.5, 0.0]]),
    (&["cave 2 way 01 type a"], &[[-25.0, 0.0, 0.0], [25.0, 0.0, 0.0]]),
    (&["cave 3 way 01 type a"], &[[0.0, -25.0, 0.0], [-25.0, 50.0, 0.0], [50.0, 25.0, 0.0]]),
    (&["cave 3 way 02 type a"], &[[-50.0, 25.0, 0.0], [25.0, 50.0, 0.0], [0.0, -25.0, 0.0]]),
    (
        &["cave 3 way elevation 01 type a"],
        &[[0.0, 50.0, 0.0], [-100.0, -50.0, -25.0], [0.0, -50.0, -25.0]],
    ),
    (
        &["cave 3 way elevation 02 type a"],
        &[[0.0, -50.0, 0.0], [-100.0, -50.0, -25.0], [0.0, 50.0, 0.0]],
    ),
    (
        &["cave 3 way elevation 03 type a"],
        &[[0.0, 50.0, 75.0], [50.0, 0.0, -50.0], [0.0, -50.0, 0.0]],
    ),
    (
        &["cave 4 way 01 type a"],
        &[[0.0, 25.0, 0.0], [25.0, 0.0, 0.0], [0.0, -25.0, 0.0], [-25.0, 0.0, 0.0]],
    ),
    (
        &["cave cavern type a"],
        &[[-25.0, 0.0, 25.0], [25.0, 0.0, 25.0], [0.0, 25.0, 0.0], [0.0, -25.0, 0.0]],
    ),
    (&["cave corner 01 type a"], &[[25.0, 0.0, 0.0], [0.0, -25.0, 0.0]]),
    (&["cave corner 02 type a"], &[[0.0, 25.0, 0.0], [25.0, -50.0, 0.0]]),
    (&["cave corner 03 type a"], &[[-25.0, 0.0, 0.0], [0.0, -25.0, 0.0]]),
    (&["cave corner 04 type a"], &[[0.0, 50.0, 25.0], [-50.0, -50.0, 0.0]]),
    (&["cave elevation 01 type a"], &[[0.0, -50.0, 0.0], [0.0, 50.0, 75.0]]),
    (&["cave elevation 02 type a"], &[[-50.0, 0.0, 75.0], [50.0, 0.0, 0.0]]),
    (&["cave elevation corner type a"], &[[25.0, 75.0, 25.0], [0.0, -100.0, 0.0]]),
    (&["cave elevation straight type a"], &[[0.0, 50.0, 25.0], [0.0, -50.0, 0.0]]),
    (&["cave split type a"], &[[0.0, -50.0, 0.0], [0.0, 50.0, 0.0]]),
    (&["cave straight shift type a"], &[[-25.0, 25.0, 0.0], [25.0, -25.0, 0.0]]),
    (
        &["cave straight type a", "cave transition type a to and from type b"],
        &[[0.0, 25.0, 0.0], [0.0, -25.0, 0.0]],
    ),
    (&["cave u turn 01 type a"], &[[-25.0, -25.0, 0.0], [25.0, -25.0, 0.0]]),
    (&["cave u turn elevation type a"], &[[-50.0, -25.0, 0.0], [0.0, -25.0, 25.0]]),
    (&["cave vertical shaft cantilevered type a"], &[[0.0, 0.0, 10.0], [0.0, 50.0, 25.0]]),
    (
        &["cave vertical shaft straight bottom type a"],
        &[[0.0, 0.0, 10.0], [0.0, 25.0, 0.0], [0.0, -25.0, 0.0]],
    ),
    (
        &["cave vertical shaft straight top type a"],
        &[[0.0, 25.0, 0.0], [0.0, -25.0, 0.0], [0.0, 0.0, 0.0]],
    ),
    (&["cave vertical shaft type a"], &[[0.0, 0.0, 10.0], [0.0, 0.0, 25.0]]),
    (&["cave vertical shaft dead end type a"], &[[0.0, 0.0, 10.0]]),
    (&["universal straight 10"], &[[0.0, 5.0, 0.0], [0.0, -5.0, 0.0]]),
    (&["universal straight 5"], &[[0.0, 2.5, 0.0], [0.0, -2.5, 0.0]]),
    (&["universal straight 2.5"], &[[0.0, 1.25, 0.0], [0.0, -1.25, 0.0]]),
    (&["universal shift 5x5"], &[[0.0, 2.5, 0.0], [2.5, -2.5, 0.0]]),
    (&["universal shift 2.5x2.5"], &[[0.0, 1.25, 0.0], [1.25, -1.25, 0.0]]),
    (&["cave tunnel transition"], &[[0.0, 25.0, 0.0], [0.0, -25.0, 0.0], [-25.0, 0.0, 0.0]]),
    (&["urban cave transition"], &[[0.0, -12.0, 0.0], [0.0, 12.0, 0.0], [-25.0, 0.0, 0.0]]),
    (&["urban cave transition straight"], &[[0.0, -5.0, 0.0], [0.0, 5.0, 0.0]]),
    (&["urban tunnel transition"], &[[0.0, 0.0, 0.0], [0.0, -15.0, -5.0]]),
    (
        &["4-way finals transition 2"],
        &[[8.0, 0.0, 0.0], [-8.0, 0.0, 0.0], [0.0, 8.0, 0.0], [0.0, -8.0, 0.0]],
    ),
];
