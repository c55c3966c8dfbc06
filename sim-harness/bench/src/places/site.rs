//! Opens a place, and finds its routes or why it has none.

use std::collections::BTreeSet;
use std::path::Path;

use input::InputError;
use maps::{Ends, Map, MapChoice, Route, RouteEnd};
use rayon::prelude::*;
use scenario::Scenario;
use world::World;

use super::found::Found;
use super::invariants;

/// A route of a place, or the reason why it has none.
pub(super) struct Site {
    /// The name of the place.
    pub(super) place: String,
    /// The station, tile or point at which the base stands.
    pub(super) from: String,
    /// The mission along the route and its world, or why there is none.
    pub(super) ground: Result<Box<Ground>, String>,
    /// Whether it is a survey.
    pub(super) is_survey: bool,
    /// The invariants that do not hold, one line each.
    pub(super) broken: Vec<String>,
}

/// The map's own mission along a route, and the world of it.
pub(super) struct Ground {
    pub(super) scenario: Scenario,
    pub(super) world: World,
    /// Why the route leads no farther.
    pub(super) ended: String,
}

/// The routes of all places: the longest of each, and the longest from each entrance of a survey.
pub(super) fn all(places: &[Found]) -> Vec<Site> {
    places.par_iter().flat_map_iter(of_place).collect()
}

fn of_place(found: &Found) -> Vec<Site> {
    let map = match maps::open(&found.file, None) {
        Ok(map) => map,
        Err(error) => {
            let ground = Err(reason(&found.file, &error));
            let (place, from) = (found.name.clone(), String::new());
            return vec![Site { place, from, ground, is_survey: false, broken: Vec::new() }];
        }
    };
    let mut begins = vec![None];
    if let Map::Survey(survey) = &map {
        let entrances = survey.stations.iter().filter(|it| it.is_entrance && !it.name.is_empty());
        begins.extend(entrances.map(|station| Some(station.name.clone())));
    }
    let mut seen = BTreeSet::new();
    let sites = begins.into_iter().map(|from| site(found, &map, from));
    sites.filter(|site| seen.insert(site.from.clone())).collect()
}

fn site(found: &Found, map: &Map, from: Option<String>) -> Site {
    let ends = Ends { from: from.clone(), ..Ends::default() };
    let (is_survey, broken) = match map {
        Map::Survey(survey) => (true, invariants::broken(survey, &ends, &found.name)),
        Map::Subt(_) | Map::Grid(_) => (false, Vec::new()),
    };
    let ground = ground(&found.file, ends);
    let of_route = |ground: &Ground| Some(ground.scenario.route.as_ref()?.from.clone());
    let from = from.or_else(|| of_route(ground.as_ref().ok()?)).unwrap_or_default();
    Site { place: found.name.clone(), from, ground, is_survey, broken }
}

fn ground(file: &Path, ends: Ends) -> Result<Box<Ground>, String> {
    let choice = MapChoice { file: file.to_owned(), ends, ..MapChoice::default() };
    let scenario =
        Scenario::of_map(choice, None, Vec::new()).map_err(|error| reason(file, &error))?;
    let world = scenario.world();
    let ended = scenario.route.as_ref().map_or_else(String::new, |route| end(route));
    Ok(Box::new(Ground { scenario, world, ended }))
}

/// Where a route ends, and why.
fn end(route: &Route) -> String {
    match &route.ended {
        RouteEnd::Hindered(hindrance) => hindrance.to_string(),
        ended => format!("{}: {ended}", route.to),
    }
}

/// What is wrong, without the file, which the row names.
fn reason(file: &Path, error: &InputError) -> String {
    let told = error.to_string();
    let file = format!("{}: ", file.display());
    told.strip_prefix(&file).map_or_else(|| told.clone(), str::to_owned)
}
