//! Makes a tunnel of a cave survey, of a SubT world or of a robot's map: a route through it, on a
//! floor plan, with the galleries that lead away from the route.
//!
//! The *graph* of a survey has a node for each point that a station stands at, and an edge for each
//! leg of the cave. A *route* is a way along legs that a drone can fly. Its plan is horizontal: the
//! stations without their heights, moved to the middle of the passage, with the passage's width at
//! each. Widths come from passage dimensions, else from splays; where there are neither, one is
//! assumed, and the route says at how many stations.

mod cells;
mod corners;
mod ended;
mod graph;
mod grid;
mod hindrance;
mod levels;
mod network;
mod open;
mod plan;
pub mod sites;
mod spread;
mod subt;
pub mod tunnel;
mod widths;

use std::path::PathBuf;
use std::sync::Arc;

use cave_survey::{Memory, StationId, Survey, Warning};
use robot_maps::Occupancy;
use world::{GeometryError, Tunnel};

pub use cells::cells;
pub use ended::{Crossing, RouteEnd};
pub use hindrance::{HIGHEST_STEP, Hindrance, HindranceKind, STEEPEST_DEG};
pub use open::{Map, open, open_in};
pub use widths::ASSUMED_WIDTH;

use ended::{Piece, Wanted};
use graph::Graph;
use input::{InputError, suggest};
use network::Galleries;

/// The longest route, m: the radio survey of a tunnel grows with the square of its length. A longer
/// one is cut here.
pub const LONGEST_ROUTE: f32 = 300.0;
/// The shortest route, m: drones stand in a row at its beginning, and have to go somewhere.
pub const SHORTEST_ROUTE: f32 = 5.0;

/// How far from the route the galleries of a SubT world are dug, m: farther than a link reaches
/// round a corner.
const SUBT_AROUND_M: f32 = 60.0;

/// The reach of a mission's side rangers where nothing else is said, m, and the longest that the
/// VL53L1X measures, in its long distance mode (its data sheet, DS12385, section 1: 4 m).
const USUAL_REACH_M: f32 = 2.0;
const LONGEST_REACH_M: f32 = 4.0;

/// The reach that rangers at 45° to the walls need to see both from the middle of a passage, where it
/// is more than the usual, and no more than there is.
fn long_reach(width_m: f32) -> Option<f32> {
    let slanted = 0.5 * width_m * core::f32::consts::SQRT_2;
    (slanted > USUAL_REACH_M).then_some(LONGEST_REACH_M)
}

/// The ends between which a route is wanted; either may be left open.
#[derive(Clone, Debug, Default)]
pub struct Ends {
    /// The station, tile or point at which the base stands.
    pub from: Option<String>,
    /// The one to which the head flies.
    pub to: Option<String>,
    /// How far from the route other galleries are dug, m; where left out, none of a survey are, and
    /// those within 60 m of a SubT world.
    pub around_m: Option<f32>,
}

/// A map, and the route that is wanted in it.
#[derive(Clone, Debug, Default)]
pub struct MapChoice {
    /// The map's file.
    pub file: PathBuf,
    /// The folder in which what it includes must lie; where left out, the file's own.
    pub within: Option<PathBuf>,
    /// The ends of the route.
    pub ends: Ends,
    /// The files of the map where they are in memory, as in a page of the browser; `file` is the name
    /// of one of them. Where left out, they are on disk.
    pub memory: Option<Arc<Memory>>,
}

impl MapChoice {
    /// Reads the map and makes the tunnel of the route.
    ///
    /// # Errors
    /// [`InputError`] where the map cannot be used, or has no such route.
    pub fn dig(&self) -> Result<(Tunnel, Route), InputError> {
        let map = match &self.memory {
            Some(files) => open_in(&**files, &self.file)?,
            None => open(&self.file, self.within.as_deref())?,
        };
        let found = match &map {
            Map::Survey(survey) => Route::find(survey, &self.ends)
                .map_err(|error| (error.to_string(), error.remedy(survey))),
            Map::Subt(world) => subt::find(world, &self.ends)
                .map_err(|error| (error.to_string(), subt::remedy(&error, world))),
            Map::Grid(map) => Route::find_in_grid(map, &self.ends)
                .map_err(|error| (error.to_string(), grid::remedy(&error))),
        };
        let (route, tunnel) =
            found.map_err(|(wrong, remedy)| InputError::new(wrong, remedy).in_file(&self.file))?;
        Ok((tunnel, route))
    }
}

/// A station of a route.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// The name.
    pub station: String,
    /// How far it is along the floor plan of the route, m.
    pub along_m: f32,
    /// Its height above the first station of the route, m.
    pub height_m: f32,
}

/// A route through a map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Route {
    /// The name of the station at which it begins.
    pub from: String,
    /// The name of the station at which it ends.
    pub to: String,
    /// How many stations it passes, its ends included.
    pub stations: usize,
    /// At how many of them the width is assumed.
    pub assumed_widths: usize,
    /// The length of its legs, m.
    pub length_m: f64,
    /// The difference in height between its highest and its lowest station, m.
    pub height_range_m: f64,
    /// Whether it was cut at [`LONGEST_ROUTE`].
    pub is_cut: bool,
    /// Why the route leads no farther.
    pub ended: RouteEnd,
    /// Where the way of which it is a piece passes above or below itself.
    pub crossing: Option<Crossing>,
    /// The legs at the stations of the route that cannot be flown, those with the most beyond them first.
    pub hindrances: Vec<Hindrance>,
    /// How many galleries lead away from the route.
    pub side_galleries: usize,
    /// How many more there would be, which pass above or below others.
    pub above_or_below: usize,
    /// The width of the passage in the middle of the range of its widths, m.
    pub median_width_m: f32,
    /// The reach that side rangers need to see both walls of that passage, m, where it is more than
    /// a map's own mission is flown with; the mission then takes it.
    pub long_reach_m: Option<f32>,
    /// The stations or tiles that it passes, the first one's included.
    pub marks: Vec<Mark>,
    /// The remarks of the reader, and that about a way which passes above or below itself.
    pub warnings: Vec<Warning>,
}

/// Why there is no route.
#[derive(Clone, Debug, PartialEq)]
pub enum RouteError {
    /// The survey has no station of that name.
    Unknown(String),
    /// The world has no tile of that name.
    NoTile(String),
    /// No way that can be flown leads from one place to the other.
    NoWay(String, String),
    /// A name that is no point in the free space of a map.
    NoPoint(String),
    /// No legs of the cave lead from one station to the other.
    Apart(String, String),
    /// The way between two stations cannot be flown; these are its hindrances.
    Hindered(String, String, Vec<Hindrance>),
    /// The way between two stations passes above or below itself.
    Crosses(String, String, Box<Crossing>),
    /// No way of [`SHORTEST_ROUTE`] can be flown.
    TooShort(Box<Short>),
    /// The plan has no walls that could be built.
    Geometry(GeometryError),
}

/// The reasons why no way of [`SHORTEST_ROUTE`] can be flown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Short {
    /// The ends of the longest way that can be flown, and its length, m; `None` where there is none.
    pub longest: Option<([String; 2], f64)>,
    /// The hindrances beside that way, or all hindrances of the cave where there is no such way.
    pub hindrances: Vec<Hindrance>,
    /// Where a longer way would pass above or below itself.
    pub crossing: Option<Crossing>,
}

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "there is no way of {SHORTEST_ROUTE} m that can be flown")?;
        if let Some(([from, to], length_m)) = self.longest.as_ref().filter(|it| it.1 > 0.0) {
            write!(f, ", but {length_m:.1} m from {from} to {to}")?;
        }
        match &self.crossing {
            Some(crossing) => write!(f, ": {crossing}"),
            None => first_three(&self.hindrances, f),
        }
    }
}

impl std::fmt::Display for RouteError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unknown(name) => write!(f, "the survey has no station \"{name}\""),
            Self::NoTile(name) => write!(f, "the world has no tile \"{name}\""),
            Self::NoWay(from, to) => {
                write!(f, "no way that can be flown leads from \"{from}\" to \"{to}\"")
            }
            Self::NoPoint(text) => write!(f, "\"{text}\" is no point of the map's free space"),
            Self::Apart(from, to) => write!(f, "no legs lead from \"{from}\" to \"{to}\""),
            Self::Hindered(from, to, hindrances) => {
                write!(f, "the way from \"{from}\" to \"{to}\" cannot be flown")?;
                first_three(hindrances, f)
            }
            Self::Crosses(from, to, crossing) => {
                write!(f, "the way from \"{from}\" to \"{to}\" cannot be flown: {crossing}")
            }
            Self::TooShort(short) => write!(f, "{short}"),
            Self::Geometry(error) => write!(f, "the route has no floor plan: {error}"),
        }
    }
}

/// Writes the first hindrances behind a colon.
fn first_three(hindrances: &[Hindrance], f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
    for (n, hindrance) in hindrances.iter().take(3).enumerate() {
        write!(f, "{} {hindrance}", if n == 0 { ":" } else { "," })?;
    }
    match hindrances.len().saturating_sub(3) {
        0 => Ok(()),
        more => write!(f, ", and {more} more"),
    }
}

impl RouteError {
    /// The remedy, with names of the survey where some are like the wrong one.
    fn remedy(&self, survey: &Survey) -> String {
        match self {
            Self::Unknown(name) => {
                let names = survey.stations.iter().map(|station| &*station.name);
                let meant = suggest::question(name, names.filter(|name| !name.is_empty()));
                format!("{meant}give the full name of a station, such as {}", example(survey))
            }
            Self::Apart(..) => "give two stations that legs join".into(),
            Self::Hindered(_, _, hindrances) => {
                let last = hindrances.first().map_or("", |first| &*first.from);
                format!("end the route before it, at \"{last}\", or leave out one end")
            }
            Self::Crosses(_, _, crossing) => {
                format!("end the route before it, at \"{}\", or leave out one end", crossing.leg[0])
            }
            Self::TooShort(_) => "give another station, or another survey".into(),
            Self::Geometry(_) | Self::NoPoint(_) | Self::NoTile(_) | Self::NoWay(..) => {
                "give other stations".into()
            }
        }
    }
}

/// The name of a station.
fn example(survey: &Survey) -> &str {
    let name = survey.stations.iter().map(|station| &*station.name).find(|name| !name.is_empty());
    name.unwrap_or("1")
}

impl Route {
    /// A place along the plan of the route as a caver finds it: so far past a station with a name.
    #[must_use]
    pub fn by_station(&self, along_m: f32) -> Option<String> {
        /// A place so near to a station is at it, m.
        const AT: f32 = 0.5;
        let named = self.marks.iter().filter(|mark| mark.station != UNNAMED);
        let behind = named.take_while(|mark| mark.along_m <= along_m + AT).last()?;
        let station = &behind.station;
        let past = along_m - behind.along_m;
        Some(match past.abs() < AT {
            true => format!("at {station}"),
            false => format!("{past:.0} m past {station}"),
        })
    }

    /// The hindrances but for the one that ends the route.
    pub fn hindrances_aside(&self) -> impl Iterator<Item = &Hindrance> {
        let is_end = |it: &&Hindrance| matches!(&self.ended, RouteEnd::Hindered(end) if end == *it);
        self.hindrances.iter().filter(move |it| !is_end(it))
    }

    /// Finds a route and makes its tunnel. Where an end is left open, the route is the longest that
    /// can be flown from the other; where both are, the longest of the cave, beginning at the end
    /// that is nearer to an entrance, or else at the higher one.
    ///
    /// # Errors
    /// [`RouteError`] where there is none.
    pub fn find(survey: &Survey, ends: &Ends) -> Result<(Self, Tunnel), RouteError> {
        let graph = Graph::of(survey);
        let node = |name: &Option<String>| match name {
            None => Ok(None),
            Some(name) => match survey.station_named(name).and_then(|it| graph.node_of(it)) {
                Some(node) => Ok(Some(node)),
                None => Err(RouteError::Unknown(name.clone())),
            },
        };
        let piece = piece(&graph, node(&ends.from)?, node(&ends.to)?)?;
        let name = |node: Option<&usize>| node.map_or_else(String::new, |&node| graph.name(node));
        let Piece { nodes, is_cut, crossing } = piece;
        let [from, to] = [name(nodes.first()), name(nodes.last())];
        let length_m = network::length(&graph, &nodes);
        let hindrances = graph.hindrances_beside(&nodes);
        if length_m < f64::from(SHORTEST_ROUTE) {
            let longest = (nodes.len() > 1).then_some(([from, to], length_m));
            let short = Short { longest, hindrances, crossing };
            return Err(RouteError::TooShort(Box::new(short)));
        }
        // A route without a beginning of its own is cut there.
        let is_cut_at_end = is_cut && (ends.from.is_some() || ends.to.is_none());
        let is_asked = ends.to.is_some();
        let ended = RouteEnd::of(is_cut_at_end, is_asked, crossing.clone(), &hindrances, &to);
        let (_, assumed_widths) = plan::plan(&graph, &nodes);
        let around_m = f64::from(ends.around_m.unwrap_or(0.0));
        let found = Galleries::of(&graph, &nodes, around_m);
        let tunnel =
            Tunnel::surveyed(found.skeleton(), &found.passages).map_err(RouteError::Geometry)?;
        let median_width_m = found.galleries.first().map_or(0.0, |main| main.width);
        let route = Self {
            from,
            to,
            stations: nodes.len(),
            assumed_widths,
            length_m,
            height_range_m: range(nodes.iter().map(|&node| graph.position(node)[2])),
            is_cut,
            ended,
            hindrances,
            side_galleries: found.galleries.len().saturating_sub(1),
            above_or_below: found.above_or_below,
            median_width_m,
            long_reach_m: long_reach(median_width_m),
            marks: marks(&found, &nodes, |node| (graph.name(node), graph.position(node)[2])),
            warnings: with_remark(&survey.warnings, crossing.as_ref()),
            crossing,
        };
        Ok((route, tunnel))
    }

    /// Finds a route through an occupancy map and makes its tunnel. The ends are points such as
    /// `1.5,-2`, in metres; where they are left open, the route is the longest.
    ///
    /// # Errors
    /// [`RouteError`] where there is none.
    pub fn find_in_grid(map: &Occupancy, ends: &Ends) -> Result<(Self, Tunnel), RouteError> {
        grid::find(map, ends)
    }
}

/// The difference between the highest and the lowest of these heights.
fn range(heights: impl Iterator<Item = f64> + Clone) -> f64 {
    heights.clone().fold(f64::NEG_INFINITY, f64::max) - heights.fold(f64::INFINITY, f64::min)
}

/// The marks of a route, of the names and heights of its nodes.
fn marks(found: &Galleries, nodes: &[usize], of: impl Fn(usize) -> (String, f64)) -> Vec<Mark> {
    let first = nodes.first().map_or(0.0, |&node| of(node).1);
    let mark = |(&node, &along_m): (&usize, &f32)| {
        let (station, height) = of(node);
        Mark { station, along_m, height_m: (height - first) as f32 }
    };
    nodes.iter().zip(&found.along).map(mark).collect()
}

/// The remarks of a map, with one about a way that passes above or below itself.
fn with_remark(warnings: &[Warning], crossing: Option<&Crossing>) -> Vec<Warning> {
    let remark = crossing.map(|crossing| Warning {
        place: None,
        text: format!("{crossing}: the route is the piece beside it"),
    });
    warnings.iter().cloned().chain(remark).collect()
}

/// The piece of a survey that becomes the route between two ends, either of which may be open.
fn piece(graph: &Graph<'_>, from: Option<usize>, to: Option<usize>) -> Result<Piece, RouteError> {
    let name = |node: usize| graph.name(node);
    let beginning = |way| Piece::of(graph, way, Wanted::Beginning, name);
    match (from, to) {
        (Some(from), Some(to)) => {
            let piece = beginning(graph.way(from, to)?);
            match piece.crossing {
                Some(crossing) => {
                    Err(RouteError::Crosses(name(from), name(to), Box::new(crossing)))
                }
                None => Ok(piece),
            }
        }
        (Some(from), None) => Ok(beginning(network::farthest_from(graph, from))),
        // The end that was asked for is kept, and the base stands where that lets it.
        (None, Some(to)) => Ok(beginning(network::farthest_from(graph, to)).reversed()),
        (None, None) => Ok(Piece::of(graph, graph.longest(), Wanted::Longest, name)),
    }
}

/// What a station without a name is called.
const UNNAMED: &str = "(unnamed)";

/// A name for a point: that of its first named station.
fn named(survey: &Survey, stations: &[StationId]) -> String {
    let names = stations.iter().map(|&station| &survey.stations[station].name);
    names.clone().find(|name| !name.is_empty()).cloned().unwrap_or_else(|| UNNAMED.into())
}
