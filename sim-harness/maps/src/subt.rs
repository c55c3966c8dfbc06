//! The network of a SubT world: its tiles, and the places at which they are joined.

use input::suggest;
use robot_maps::subt::World;
use world::Tunnel;

use super::ended::{Piece, Wanted};
use super::network::{self, Galleries, Network, Station};
use super::spread::Spread;
use super::{
    Ends, Hindrance, HindranceKind, Route, RouteEnd, RouteError, SHORTEST_ROUTE, SUBT_AROUND_M,
    Short,
};

/// The tile at which the robots of a SubT world start.
const START: &str = "base_station";

/// The nodes are the tiles, and then the places at which they are joined.
struct Tiles<'a> {
    world: &'a World,
    /// What each node leads to, how far, and what keeps a drone from flying there.
    edges: Vec<Vec<(usize, f64, Option<HindranceKind>)>>,
}

impl<'a> Tiles<'a> {
    fn of(world: &'a World) -> Self {
        let tiles = world.tiles.len();
        let mut edges = vec![Vec::new(); tiles + world.joints.len()];
        for (number, joint) in world.joints.iter().enumerate() {
            for tile in joint.tiles {
                let way = [0, 1, 2].map(|axis| joint.at[axis] - world.tiles[tile].at[axis]);
                let length = cave_survey::norm(way);
                let hindrance = hindrance(way, world.tiles[tile].passage().is_shaft);
                edges[tile].push((tiles + number, length, hindrance));
                edges[tiles + number].push((tile, length, hindrance));
            }
        }
        Self { world, edges }
    }

    /// The name of the tile at a node, or of the first of those that are joined there.
    fn name(&self, node: usize) -> String {
        let tiles = &self.world.tiles;
        let joined = |joint: usize| self.world.joints.get(joint).map(|it| it.tiles[0]);
        let tile = if node < tiles.len() { Some(node) } else { joined(node - tiles.len()) };
        tile.and_then(|tile| tiles.get(tile)).map_or_else(String::new, |tile| tile.name.clone())
    }

    /// The node of a tile, by its name or the number in it.
    fn named(&self, name: &str) -> Result<usize, RouteError> {
        let tile = format!("tile_{name}");
        let found = self.world.tiles.iter().position(|it| it.name == name || it.name == tile);
        found.ok_or_else(|| RouteError::NoTile(name.to_owned()))
    }

    /// Half of the width at a node, m.
    fn half_m(&self, node: usize) -> f32 {
        let tiles = self.world.tiles.len();
        let width = |tile: usize| self.world.tiles[tile].passage().width_m;
        let width = match self.world.joints.get(node.wrapping_sub(tiles)) {
            Some(joint) => width(joint.tiles[0]).min(width(joint.tiles[1])),
            None => width(node),
        };
        0.5 * width as f32
    }

    /// What ends the flight at the tiles of a route.
    fn hindrances(&self, route: &[usize]) -> Vec<Hindrance> {
        let at = |&node: &usize| {
            let hindered = self.edges[node].iter().filter_map(move |(to, _, kind)| {
                let kind = (*kind)?;
                let (from, to) = (self.name(node), self.beyond(node, *to));
                Some(Hindrance { from, to, kind, beyond_m: 0.0 })
            });
            hindered.collect::<Vec<_>>()
        };
        route.iter().flat_map(at).collect()
    }

    /// Why no way can be flown from one node to another.
    fn hindered(&self, from: usize, to: usize) -> RouteError {
        let next = |node: usize| self.edges[node].iter().map(|(to, length, _)| (*to, *length));
        let way = Spread::from(&[from], f64::INFINITY, next).way(to).unwrap_or_default();
        let (begin, end) = (self.name(from), self.name(to));
        let hindered = way.windows(2).filter_map(|pair| {
            let (_, _, kind) = self.edges[pair[0]].iter().find(|(to, ..)| *to == pair[1])?;
            let tiles = self.world.tiles.len();
            // Of the two halves of the way between two tiles, each may be hindered.
            let (one, joint) =
                if pair[0] < tiles { (pair[0], pair[1]) } else { (pair[1], pair[0]) };
            let (mut from, mut to) = (self.name(one), self.beyond(one, joint));
            if pair[0] >= tiles {
                (from, to) = (to, from);
            }
            kind.map(|kind| Hindrance { from, to, kind, beyond_m: 0.0 })
        });
        let mut hindered: Vec<_> = hindered.collect();
        hindered.dedup_by(|a, b| (&a.from, &a.to) == (&b.from, &b.to));
        match hindered.is_empty() {
            true => RouteError::NoWay(begin, end),
            false => RouteError::Hindered(begin, end, hindered),
        }
    }

    /// The name of the tile that the way from a node over another leads to.
    fn beyond(&self, node: usize, over: usize) -> String {
        let tiles = self.world.tiles.len();
        let joint = self.world.joints.get(over.wrapping_sub(tiles));
        let other = joint.and_then(|it| it.tiles.into_iter().find(|tile| *tile != node));
        self.name(other.unwrap_or(over))
    }
}

impl Network for Tiles<'_> {
    fn neighbours(&self, node: usize) -> Vec<(usize, f64)> {
        let flown = self.edges[node].iter().filter(|(_, _, hindrance)| hindrance.is_none());
        flown.map(|(to, length, _)| (*to, *length)).collect()
    }

    fn at(&self, node: usize) -> [f64; 3] {
        let tiles = self.world.tiles.len();
        match self.world.joints.get(node.wrapping_sub(tiles)) {
            Some(joint) => joint.at,
            None => self.world.tiles[node].at,
        }
    }

    fn halves(&self, way: &[usize]) -> Vec<f64> {
        way.iter().map(|&node| f64::from(self.half_m(node))).collect()
    }

    fn plan(&self, way: &[usize]) -> Vec<Station> {
        let station = |&node: &usize| {
            let [x, y, _] = self.at(node);
            Station { at: [x, y], half_m: self.half_m(node) }
        };
        let mut stations: Vec<Station> = way.iter().map(station).collect();
        stations.dedup_by(|a, b| network::distance(a.at, b.at) < 0.1);
        stations
    }
}

/// What keeps a drone from flying from the middle of a tile to where it is joined.
fn hindrance(way: [f64; 3], is_shaft: bool) -> Option<HindranceKind> {
    let height_m = way[2].abs();
    let slope_deg = height_m.atan2(way[0].hypot(way[1])).to_degrees();
    let shaft = is_shaft.then_some(HindranceKind::Shaft { slope_deg, height_m });
    shaft.or_else(|| HindranceKind::of_rise(slope_deg, height_m))
}

/// Finds a route between tiles and makes its tunnel. Where an end is left open, it begins at the
/// base station, and leads to the farthest tile.
pub(super) fn find(world: &World, ends: &Ends) -> Result<(Route, Tunnel), RouteError> {
    let tiles = Tiles::of(world);
    let node = |name: &Option<String>| name.as_ref().map(|name| tiles.named(name)).transpose();
    let (from, to) = (node(&ends.from)?, node(&ends.to)?);
    let start = from.unwrap_or_else(|| tiles.named(START).unwrap_or(0));
    let way = match to {
        None => network::farthest_from(&tiles, start),
        Some(to) => match network::way(&tiles, start, to) {
            Some(way) => way,
            None => return Err(tiles.hindered(start, to)),
        },
    };
    let piece = Piece::of(&tiles, way, Wanted::Beginning, |node| tiles.name(node));
    if let (Some(_), Some(to), Some(crossing)) = (from, to, &piece.crossing) {
        let crossing = Box::new(crossing.clone());
        return Err(RouteError::Crosses(tiles.name(start), tiles.name(to), crossing));
    }
    let Piece { nodes: way, is_cut, crossing } = piece;
    let length_m = network::length(&tiles, &way);
    let hindrances = tiles.hindrances(&way);
    let end_name = way.last().map_or_else(String::new, |&node| tiles.name(node));
    if length_m < f64::from(SHORTEST_ROUTE) {
        let longest = Some(([tiles.name(start), end_name], length_m));
        let short = Short { longest, hindrances, crossing };
        return Err(RouteError::TooShort(Box::new(short)));
    }
    let ended = RouteEnd::of(is_cut, to.is_some(), crossing.clone(), &hindrances, &end_name);
    let around_m = f64::from(ends.around_m.unwrap_or(SUBT_AROUND_M));
    let found = Galleries::of(&tiles, &way, around_m);
    let tunnel =
        Tunnel::surveyed(found.skeleton(), &found.passages).map_err(RouteError::Geometry)?;
    let passed: Vec<_> = way.iter().filter_map(|node| world.tiles.get(*node)).collect();
    let median_width_m = found.galleries.first().map_or(0.0, |main| main.width);
    let route = Route {
        from: tiles.name(start),
        to: end_name,
        stations: passed.len(),
        assumed_widths: passed.iter().filter(|tile| tile.passage().is_assumed).count(),
        length_m,
        height_range_m: super::range(way.iter().map(|&node| tiles.at(node)[2])),
        is_cut,
        ended,
        hindrances,
        side_galleries: found.galleries.len().saturating_sub(1),
        above_or_below: found.above_or_below,
        median_width_m,
        long_reach_m: super::long_reach(median_width_m),
        marks: super::marks(&found, &way, |node| (tiles.name(node), tiles.at(node)[2])),
        warnings: super::with_remark(&world.warnings, crossing.as_ref()),
        crossing,
    };
    Ok((route, tunnel))
}

/// The remedy for a route that is not in a world.
pub(super) fn remedy(error: &RouteError, world: &World) -> String {
    match error {
        RouteError::NoTile(name) => {
            let meant = suggest::question(name, world.tiles.iter().map(|tile| &*tile.name));
            let example = world.tiles.last().map_or(START, |tile| &tile.name);
            format!("{meant}give the name of a tile, such as {example}")
        }
        RouteError::Hindered(_, _, hindrances) => {
            let last = hindrances.first().map_or("", |first| &*first.from);
            format!("end the route before it, at \"{last}\"")
        }
        RouteError::NoWay(..) => "give two tiles that the graph joins".into(),
        _ => "give other tiles".into(),
    }
}
