//! Makes a tunnel of a cave survey: a route through it, on a floor plan.
//!
//! The *graph* of a survey has a node for each point that a station stands at, and an edge for each
//! leg of the cave. A *route* is a way along legs that a drone can fly. Its plan is horizontal: the
//! stations without their heights, moved to the middle of the passage, with the passage's width at
//! each. Widths come from passage dimensions, else from splays; where there are neither, one is
//! assumed, and the route says at how many stations.

mod graph;
mod open;
mod plan;
mod widths;

use std::path::PathBuf;

use cave_survey::{StationId, Survey};

use super::{GeometryError, Tunnel};
use crate::input_error::InputError;
use crate::suggest;
pub use graph::{Hindrance, HindranceKind, STEEPEST_DEG};
pub use open::open;
pub use widths::ASSUMED_WIDTH;

use graph::Graph;

/// The longest route, m: the radio survey of a tunnel grows with the square of its length. A longer
/// one is cut here.
pub const LONGEST_ROUTE: f32 = 300.0;
/// The shortest route, m: drones stand in a row at its beginning, and have to go somewhere.
pub const SHORTEST_ROUTE: f32 = 5.0;

/// The ends between which a route is wanted; either may be left open.
#[derive(Clone, Debug, Default)]
pub struct Ends {
    /// The station at which the base stands.
    pub from: Option<String>,
    /// The station to which the head flies.
    pub to: Option<String>,
}

/// A survey, and the route that is wanted in it.
#[derive(Clone, Debug, Default)]
pub struct MapChoice {
    /// The survey's file.
    pub file: PathBuf,
    /// The folder in which what it includes must lie; where left out, the survey's own.
    pub within: Option<PathBuf>,
    /// The ends of the route.
    pub ends: Ends,
}

impl MapChoice {
    /// Reads the survey and makes the tunnel of the route.
    ///
    /// # Errors
    /// [`InputError`] where the survey cannot be used, or has no such route.
    pub fn dig(&self) -> Result<(Tunnel, Route), InputError> {
        let survey = open(&self.file, self.within.as_deref())?;
        let found = Route::find(&survey, &self.ends);
        let (route, tunnel) = found.map_err(|error| {
            InputError::new(error.to_string(), error.remedy(&survey)).in_file(&self.file)
        })?;
        Ok((tunnel, route))
    }
}

/// A route through a cave.
#[derive(Clone, Debug, PartialEq)]
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
    /// What ends the flight at the stations of the route, and where.
    pub hindrances: Vec<Hindrance>,
}

/// Why there is no route.
#[derive(Clone, Debug, PartialEq)]
pub enum RouteError {
    /// The survey has no station of that name.
    Unknown(String),
    /// No legs of the cave lead from one station to the other.
    Apart(String, String),
    /// The way between two stations cannot be flown; these are its hindrances.
    Hindered(String, String, Vec<Hindrance>),
    /// No way of [`SHORTEST_ROUTE`] can be flown; these hindrances are beside what can be.
    TooShort(Vec<Hindrance>),
    /// The plan has no walls that could be built.
    Geometry(GeometryError),
}

impl std::fmt::Display for RouteError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unknown(name) => write!(f, "the survey has no station \"{name}\""),
            Self::Apart(from, to) => write!(f, "no legs lead from \"{from}\" to \"{to}\""),
            Self::Hindered(from, to, hindrances) => {
                write!(f, "the way from \"{from}\" to \"{to}\" cannot be flown")?;
                first_three(hindrances, f)
            }
            Self::TooShort(hindrances) => {
                write!(f, "there is no way of {SHORTEST_ROUTE} m that can be flown")?;
                first_three(hindrances, f)
            }
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
            Self::TooShort(_) => "give another station, or another survey".into(),
            Self::Geometry(_) => "give other stations".into(),
        }
    }
}

/// The name of a station.
fn example(survey: &Survey) -> &str {
    let name = survey.stations.iter().map(|station| &*station.name).find(|name| !name.is_empty());
    name.unwrap_or("1")
}

impl Route {
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
        let nodes = match (node(&ends.from)?, node(&ends.to)?) {
            (Some(from), Some(to)) => graph.way(from, to)?,
            (Some(from), None) => graph.farthest_from(from),
            (None, Some(to)) => graph.farthest_from(to).into_iter().rev().collect(),
            (None, None) => graph.longest(),
        };
        let (nodes, is_cut) = graph.cut(nodes, LONGEST_ROUTE);
        let length_m = graph.length(&nodes);
        if length_m < f64::from(SHORTEST_ROUTE) {
            return Err(RouteError::TooShort(graph.hindrances_beside(&nodes)));
        }
        let (plan, assumed_widths) = plan::plan(&graph, &nodes);
        let tunnel = plan.dig().map_err(RouteError::Geometry)?;
        let name = |node: Option<&usize>| node.map_or_else(String::new, |&node| graph.name(node));
        let heights = nodes.iter().map(|&node| graph.at(node)[2]);
        let highest = heights.clone().fold(f64::NEG_INFINITY, f64::max);
        let route = Self {
            from: name(nodes.first()),
            to: name(nodes.last()),
            stations: nodes.len(),
            assumed_widths,
            length_m,
            height_range_m: highest - heights.fold(f64::INFINITY, f64::min),
            is_cut,
            hindrances: graph.hindrances_beside(&nodes),
        };
        Ok((route, tunnel))
    }
}

/// A name for a point: that of its first named station.
fn named(survey: &Survey, stations: &[StationId]) -> String {
    let names = stations.iter().map(|&station| &survey.stations[station].name);
    names.clone().find(|name| !name.is_empty()).cloned().unwrap_or_else(|| "(unnamed)".into())
}
