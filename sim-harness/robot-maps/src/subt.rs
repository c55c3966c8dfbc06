//! Reads worlds of DARPA's Subterranean (SubT) Challenge.
//!
//! A world is laid out of *tiles*: meshes of 20 m and more, each with *openings* at which others
//! join it. Its `.sdf` gives every tile a pose, its `.dot` (the visibility graph, which the
//! competition's radio model works on) says which tiles are joined, with a cost for the bends
//! between them. [`read`] takes either file, and finds the other beside it.

mod dot;
mod sdf;
mod tiles;

use std::collections::BTreeMap;

use cave_survey::{Files, Refusal, Warning};

use crate::open::{line_of, open, text, whole};
pub use tiles::{Passage, TUNNEL_WIDTH_M};

/// The most that is read of one file, bytes: the largest world of the competition has 1 MB.
const LARGEST: usize = 16 << 20;
/// The most tiles of a world.
pub const MOST_TILES: usize = 20_000;

/// A tile with its pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    /// The name, such as `tile_12`; `base_station` is where the robots start.
    pub name: String,
    /// The model, such as `Tunnel Tile 5`.
    pub model: String,
    /// The place of the tile's origin, m.
    pub at: [f64; 3],
    /// Roll, pitch and yaw, radians.
    pub turned: [f64; 3],
}

/// Two tiles that are joined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// The numbers of the tiles.
    pub tiles: [usize; 2],
    /// The cost of the bends between them, from 1 to 6; `None` where none is given.
    pub cost: Option<f64>,
    /// The place at which they are joined, m.
    pub at: [f64; 3],
}

/// A world.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    /// The world's name.
    pub title: String,
    /// The tiles of the graph, the base station first where there is one.
    pub tiles: Vec<Tile>,
    /// What joins them.
    pub joints: Vec<Joint>,
    /// The remarks of the reader.
    pub warnings: Vec<Warning>,
}

impl Tile {
    /// What is known of the passages through it.
    #[must_use]
    pub fn passage(&self) -> Passage {
        tiles::passage(&self.model)
    }

    /// The places of its openings, m; none for a model that is not known.
    fn openings(&self) -> Vec<[f64; 3]> {
        let local = tiles::openings(&self.model).unwrap_or_default();
        local.iter().map(|opening| self.place(*opening)).collect()
    }

    /// The place of a point that is given in the axes of the tile.
    fn place(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [(sr, cr), (sp, cp), (sy, cy)] = self.turned.map(f64::sin_cos);
        // Roll about x, then pitch about y, then yaw about z, as SDFormat has it.
        let (y, z) = (cr * y - sr * z, sr * y + cr * z);
        let (x, z) = (cp * x + sp * z, cp * z - sp * x);
        let (x, y) = (cy * x - sy * y, sy * x + cy * y);
        [self.at[0] + x, self.at[1] + y, self.at[2] + z]
    }
}

/// Reads the world of which `entry` is the `.dot` or the `.sdf`.
///
/// # Errors
/// [`Refusal`] where it cannot be used.
pub fn read(files: &dyn Files, entry: &str) -> Result<World, Refusal> {
    let stem = entry.rsplit_once('.').map_or(entry, |(stem, _)| stem);
    let graph_file = open(files, &format!("{stem}.dot"), LARGEST)?;
    let scene_file = open(files, &format!("{stem}.sdf"), LARGEST)?;
    let graph = dot::read(text(&graph_file)?, &graph_file.path)?;
    let scene = sdf::read(text(&scene_file)?, &scene_file.path)?;
    let world = laid_out(graph, &scene, &graph_file.path);
    if world.joints.is_empty() {
        let wrong = "no two tiles of the graph that are joined have a pose";
        let remedy = format!("give the {stem}.sdf that belongs to it");
        return Err(Refusal::new(wrong, remedy).at(whole(&graph_file.path)));
    }
    Ok(world)
}

/// The tiles of the graph with their poses. A tile without one is left out, with a remark.
fn laid_out(graph: dot::Graph, scene: &sdf::Scene, file: &str) -> World {
    let mut warnings = graph.warnings;
    let mut remark = |line, text| warnings.push(Warning { place: Some(line_of(file, line)), text });
    let mut tiles = Vec::new();
    let mut numbers = BTreeMap::new();
    for vertex in &graph.vertices {
        match scene.tile(&vertex.name) {
            Some(tile) => {
                numbers.insert(vertex.id, tiles.len());
                tiles.push(tile);
            }
            None => remark(vertex.line, format!("the .sdf has no {}: left out", vertex.name)),
        }
    }
    let mut joints: Vec<Joint> = Vec::new();
    for edge in &graph.edges {
        let ends = edge.ends.map(|id| numbers.get(&id).copied());
        let [Some(from), Some(to)] = ends else { continue };
        let known = |it: &Joint| it.tiles == [from, to] || it.tiles == [to, from];
        if from == to || joints.iter().any(known) {
            continue;
        }
        let (at, gap_m) = joint(&tiles[from], &tiles[to]);
        if gap_m > LARGEST_GAP_M {
            let (one, other) = (&tiles[from].name, &tiles[to].name);
            remark(edge.line, format!("{one} and {other} are {gap_m:.0} m apart: not joined"));
            continue;
        }
        joints.push(Joint { tiles: [from, to], cost: edge.cost, at });
    }
    World { title: scene.title.clone(), tiles, joints, warnings }
}

/// The openings of two tiles that are joined are no farther apart, m: the widest tiles, whose
/// openings are not in the table, are 180 m long (osrf/subt, pull request 964).
const LARGEST_GAP_M: f64 = 180.0;

/// The place at which two tiles are joined, and how far apart they are there, m. Where the openings
/// of one are not known, or no two meet, it is in the middle between what is known of both.
fn joint(one: &Tile, other: &Tile) -> ([f64; 3], f64) {
    let known = |tile: &Tile| match tile.openings() {
        openings if openings.is_empty() => vec![tile.at],
        openings => openings,
    };
    let others = known(other);
    let pairs = known(one).into_iter().flat_map(|a| others.iter().map(move |b| (a, *b)));
    let distance = |(a, b): &([f64; 3], [f64; 3])| {
        (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
    };
    let nearest = pairs.min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let (a, b) = nearest.unwrap_or((one.at, other.at));
    ([0, 1, 2].map(|axis| 0.5 * (a[axis] + b[axis])), distance(&(a, b)))
}
