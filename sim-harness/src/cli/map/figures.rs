//! The figures of a map, as JSON and as a table.

use cave_survey::Survey;
use maps::{Ends, Map, Route};
use robot_maps::subt::World;
use robot_maps::{Cell, Occupancy, Warning};
use serde_json::{Value, json};

use report::route_json;

/// The figures as JSON.
pub(super) fn figures(map: &Map) -> Value {
    match map {
        Map::Survey(survey) => survey_figures(survey),
        Map::Subt(world) => subt_figures(world),
        Map::Grid(map) => grid_figures(map),
    }
}

/// The figures as a table.
pub(super) fn table(map: &Map) -> String {
    let mut rows = match map {
        Map::Survey(survey) => survey_rows(survey),
        Map::Subt(world) => subt_rows(world),
        Map::Grid(map) => grid_rows(map),
    };
    if !map.warnings().is_empty() {
        rows.push(("warnings", format!("{}", map.warnings().len())));
    }
    rows.iter().map(|(name, value)| format!("{name:<17}{value}\n")).collect()
}

type Rows = Vec<(&'static str, String)>;

/// The number with three decimals: a survey knows no more.
fn millimetres(metres: f64) -> f64 {
    (metres * 1000.0).round() / 1000.0
}

fn texts(warnings: &[Warning]) -> Vec<String> {
    warnings.iter().map(ToString::to_string).collect()
}

fn survey_figures(survey: &Survey) -> Value {
    let it = survey.summary();
    let misclosure = survey.misclosure.as_ref().map_or(0.0, |it| it.error);
    let worst = survey.misclosure.as_ref().map(|it| {
        json!({ "misclosure_m": millimetres(it.error), "length_m": millimetres(it.length), "station": it.station })
    });
    json!({
        "title": survey.title,
        "legs": it.legs,
        "length_m": millimetres(it.length_m),
        "measured_length_m": millimetres(it.measured_length_m),
        "splays": it.splays,
        "stations": it.stations,
        "with_dimensions": it.with_dimensions,
        "loops": it.loops,
        "misclosure_m": millimetres(misclosure),
        "worst_loop": worst,
        "dived_m": millimetres(it.dived_m),
        "entrances": entrances(survey),
        "route": default_route(survey),
        "warnings": texts(&survey.warnings),
    })
}

/// The names of the stations that the survey marks as entrances.
fn entrances(survey: &Survey) -> Vec<&str> {
    let entrances = survey.stations.iter().filter(|station| station.is_entrance);
    let mut names: Vec<_> = entrances.map(|station| &*station.name).collect();
    names.dedup();
    names
}

/// The route that is flown where neither end is named.
fn default_route(survey: &Survey) -> Value {
    match Route::find(survey, &Ends::default()) {
        Ok((route, _)) => route_json(&route),
        Err(error) => json!({ "none": error.to_string() }),
    }
}

/// The rows about the entrances, the water and the route.
fn route_rows(survey: &Survey, rows: &mut Rows) {
    /// The most entrances that are listed.
    const MOST: usize = 5;
    let names = entrances(survey);
    if !names.is_empty() {
        let more = names.len().saturating_sub(MOST);
        let more = if more == 0 { String::new() } else { format!(" and {more} more") };
        rows.push(("entrances", names[..names.len().min(MOST)].join(", ") + &more));
    }
    let dived_m = survey.summary().dived_m;
    if dived_m > 0.0 {
        rows.push(("under water", format!("{dived_m:.2} m")));
    }
    match Route::find(survey, &Ends::default()) {
        Ok((route, _)) => {
            let Route { from, to, length_m, ended, .. } = route;
            rows.push(("longest route", format!("{from} to {to}, {length_m:.1} m")));
            rows.push(("route ends", ended.to_string()));
        }
        Err(error) => rows.push(("longest route", error.to_string())),
    }
}

fn survey_rows(survey: &Survey) -> Rows {
    let it = survey.summary();
    let mut rows = Vec::new();
    if let Some(title) = &survey.title {
        rows.push(("title", title.clone()));
    }
    rows.push(("legs", format!("{}, and {} splays", it.legs, it.splays)));
    rows.push((
        "length",
        format!("{:.2} m, as measured {:.2} m", it.length_m, it.measured_length_m),
    ));
    rows.push(("stations", format!("{}", it.stations)));
    rows.push(("with dimensions", format!("{}", it.with_dimensions)));
    let closes = survey.misclosure.as_ref().map_or_else(String::new, |worst| {
        let at = if worst.station.is_empty() {
            String::new()
        } else {
            format!(", at {}", worst.station)
        };
        format!("; the worst misses by {:.2} m in {:.0} m{at}", worst.error, worst.length)
    });
    rows.push(("loops", format!("{}{closes}", it.loops)));
    route_rows(survey, &mut rows);
    rows
}

fn subt_figures(world: &World) -> Value {
    let assumed = world.tiles.iter().filter(|tile| tile.passage().is_assumed).count();
    json!({
        "title": world.title,
        "tiles": world.tiles.len(),
        "joints": world.joints.len(),
        "junctions": junctions(world),
        "assumed_widths": assumed,
        "length_m": millimetres(length_m(world)),
        "height_range_m": millimetres(height_range_m(world)),
        "warnings": texts(&world.warnings),
    })
}

fn subt_rows(world: &World) -> Rows {
    vec![
        ("title", world.title.clone()),
        ("tiles", format!("{}, joined at {} places", world.tiles.len(), world.joints.len())),
        ("junctions", format!("{}", junctions(world))),
        ("length", format!("{:.0} m", length_m(world))),
        ("heights", format!("{:.0} m from the lowest tile to the highest", height_range_m(world))),
    ]
}

/// The number of tiles at which three passages or more meet.
fn junctions(world: &World) -> usize {
    let joined =
        |tile: usize| world.joints.iter().filter(|joint| joint.tiles.contains(&tile)).count();
    (0..world.tiles.len()).filter(|tile| joined(*tile) > 2).count()
}

/// The length of all passages, from the middle of each tile to where it is joined, m.
fn length_m(world: &World) -> f64 {
    let halves = world.joints.iter().flat_map(|joint| {
        joint.tiles.map(|tile| {
            let at = world.tiles[tile].at;
            cave_survey::norm([0, 1, 2].map(|axis| joint.at[axis] - at[axis]))
        })
    });
    halves.sum()
}

fn height_range_m(world: &World) -> f64 {
    let heights = world.tiles.iter().map(|tile| tile.at[2]);
    let highest = heights.clone().fold(f64::NEG_INFINITY, f64::max);
    highest - heights.fold(f64::INFINITY, f64::min)
}

fn grid_figures(map: &Occupancy) -> Value {
    let area = |state| millimetres(map.count(state) as f64 * map.resolution_m.powi(2));
    json!({
        "columns": map.columns(),
        "rows": map.rows(),
        "resolution_m": map.resolution_m,
        "origin": map.origin,
        "free_m2": area(Cell::Free),
        "occupied_m2": area(Cell::Occupied),
        "unknown_m2": area(Cell::Unknown),
        "warnings": texts(&map.warnings),
    })
}

fn grid_rows(map: &Occupancy) -> Rows {
    let [x, y, yaw] = map.origin;
    let metres = |cells: usize| cells as f64 * map.resolution_m;
    let area = |state| map.count(state) as f64 * map.resolution_m.powi(2);
    vec![
        ("cells", format!("{} by {}, of {} m", map.columns(), map.rows(), map.resolution_m)),
        ("size", format!("{:.2} m by {:.2} m", metres(map.columns()), metres(map.rows()))),
        ("lower left", format!("{x} m, {y} m, turned by {yaw} rad")),
        ("free", format!("{:.1} m²", area(Cell::Free))),
        ("occupied", format!("{:.1} m²", area(Cell::Occupied))),
        ("unknown", format!("{:.1} m²", area(Cell::Unknown))),
    ]
}
