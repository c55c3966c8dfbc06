//! Pictures of missions, as SVG and PNG.
//!
//! Every picture is made of *panels*: functions that draw one thing (a map, links over time, box
//! plots) into any rectangle, so that the same code makes the three pictures of a run and the
//! composite pages. `plotters` does the plotting and writes the SVG, `tiny-skia` draws the PNG, and
//! the font is part of the program, so that a picture has the same bytes on every machine.
//!
//! Charts have the palette of Okabe and Ito, which people with any colour vision can tell apart, and drones
//! and links have that of the module `palette`; lines are labelled where they end rather than in a legend; the background is always painted, so that a
//! picture reads the same on light and dark pages.

mod axes;
mod boxes;
mod canvas;
mod dashes;
mod drops;
mod explored;
mod figure3;
mod growth;
mod linked;
mod links;
mod map;
mod moving;
pub(crate) mod palette;
mod placement;
mod plan;
mod positions;
mod raster;
mod scale;
mod series;
mod sheet;
mod style;
mod survival;
mod ticks;

use std::fmt;

pub use boxes::{BoxChart, RunGroup, RunValues};
pub use explored::{ExploredChart, ExploredMap};
pub use figure3::{Corridor, Figure3, Variant};
pub use growth::{Curve, GrowthChart, Growths};
pub(super) use map::nested;
pub(super) use palette::node_rgb;
pub use plan::PlanPicture;
pub(super) use series::{GROUND_LOSS, launch_limit, state_name};
pub(super) use sheet::escaped;
pub use sheet::{Picture, PlotFrame};
pub use survival::SurvivalChart;

use cave_worlds::World;
use units::MissionKind;

use mission::trace::Trace;
use planning::drops::Drops;
use planning::situations::Scene;

/// The error when a picture cannot be made. No input of a user causes it, since pictures are drawn
/// in memory and the font is built in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PictureError(String);

impl PictureError {
    fn new(what: impl fmt::Display) -> Self {
        Self(what.to_string())
    }
}

impl fmt::Display for PictureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "drawing a picture: {}", self.0)
    }
}

impl std::error::Error for PictureError {}

/// The floor plan with every drone's way through it and its last place.
///
/// # Errors
/// See [`PictureError`].
pub fn map(trace: &Trace) -> Result<Picture, PictureError> {
    map::picture(trace)
}

/// The mission as a moving picture, an SVG document without a script.
///
/// # Errors
/// See [`PictureError`].
pub fn moving(trace: &Trace) -> Result<String, PictureError> {
    moving::picture(trace)
}

/// The floor plan with the places of a planned chain.
///
/// # Errors
/// See [`PictureError`].
pub fn plan(plan: &PlanPicture<'_>) -> Result<Picture, PictureError> {
    plan::picture(plan)
}

/// The coverage of a map before and after relays are put down.
///
/// # Errors
/// See [`PictureError`].
pub fn drops(world: &World, drops: &Drops) -> Result<Picture, PictureError> {
    drops::picture(world, drops)
}

/// The charts over time that this mission has, each with the name of its file: `positions` of a chain, and
/// `links` of a chain of which a drone ever heard another one.
///
/// # Errors
/// See [`PictureError`].
pub fn over_time(trace: &Trace) -> Result<Vec<(&'static str, Picture)>, PictureError> {
    if trace.mission != MissionKind::Chain {
        return Ok(Vec::new());
    }
    let mut drones = trace.frames.iter().flat_map(|frame| &frame.drones);
    let is_linked = drones.any(|drone| drone.front.is_some() || drone.back.is_some());
    let links = is_linked.then(|| links(trace)).transpose()?;
    let positions = positions(trace)?;
    Ok([("positions", positions)].into_iter().chain(links.map(|links| ("links", links))).collect())
}

/// Each link's strength over time: as received, filtered, and true.
///
/// # Errors
/// See [`PictureError`].
pub fn links(trace: &Trace) -> Result<Picture, PictureError> {
    links::picture(trace)
}

/// Draws every node's way along the tunnel, over time.
///
/// # Errors
/// See [`PictureError`].
pub fn positions(trace: &Trace) -> Result<Picture, PictureError> {
    positions::picture(trace)
}

/// One chart of box plots.
///
/// # Errors
/// See [`PictureError`].
pub fn box_plots(chart: &BoxChart) -> Result<Picture, PictureError> {
    boxes::picture(chart)
}

/// Survival curves: the share of runs that have not settled yet, against time.
///
/// # Errors
/// See [`PictureError`].
pub fn survival(chart: &SurvivalChart) -> Result<Picture, PictureError> {
    survival::picture(chart)
}

/// The paper's figure 3 on one page, panels A to F.
///
/// # Errors
/// See [`PictureError`].
pub fn figure3(figure: &Figure3<'_>) -> Result<Picture, PictureError> {
    figure3::picture(figure)
}

/// Curves of what is known over time.
///
/// # Errors
/// See [`PictureError`].
pub fn growths(chart: &GrowthChart) -> Result<Picture, PictureError> {
    growth::picture(chart)
}

/// Maps of a room that robots explore.
///
/// # Errors
/// See [`PictureError`].
pub fn explored(chart: &ExploredChart) -> Result<Picture, PictureError> {
    explored::picture(chart)
}

/// The figures 2 and 3 of the paper on placing communication nodes, in one cave.
///
/// # Errors
/// See [`PictureError`].
pub fn node_maps(scene: &Scene) -> Result<Picture, PictureError> {
    placement::maps(scene)
}

/// Its figure 4: a cave in each situation.
///
/// # Errors
/// See [`PictureError`].
pub fn node_situations(scenes: &[Scene]) -> Result<Picture, PictureError> {
    placement::situations(scenes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;

    fn charts() -> BoxChart {
        let series = |name: &str, values: &[f32]| RunValues {
            name: name.to_owned(),
            values: values.to_vec(),
        };
        let never = [f32::INFINITY; 3];
        let group = RunGroup {
            label: "S-turns".to_owned(),
            series: vec![series("T0", &never), series("K", &[1.0, 2.0, f32::INFINITY, f32::NAN])],
            told: None,
        };
        BoxChart {
            title: "Convergence".to_owned(),
            value_name: "Time, s".to_owned(),
            infinite_name: "never".to_owned(),
            is_logarithmic: false,
            groups: vec![group],
        }
    }

    fn curves() -> SurvivalChart {
        SurvivalChart {
            title: "Convergence".to_owned(),
            pending: "not settled yet".to_owned(),
            time_name: "Time, s".to_owned(),
            until: 10.0,
            groups: charts().groups,
        }
    }

    #[test]
    fn runs_that_never_finished_are_counted() {
        let picture = box_plots(&charts()).unwrap();
        assert!(picture.svg().contains("3 of 3") && picture.svg().contains("1 of 3"));
    }

    #[test]
    fn the_page_of_figure_3_names_its_panels() {
        let trace = synthetic::mission();
        let figure = Figure3 {
            title: "Figure 3",
            subtitle: "",
            corridors: vec![Corridor { name: "one", trace: &trace }; 3],
            resting: curves(),
            exploration: vec![Variant { name: "T0", trace: &trace }; 3],
            convergence: curves(),
            variance: charts(),
        };
        let picture = figure3(&figure).unwrap();
        for panel in
            ["A\u{2003}one", "C\u{2003}one", "D\u{2003}Exploration, T0", "E\u{2003}", "F\u{2003}"]
        {
            assert!(picture.svg().contains(panel), "{panel}");
        }
    }

    #[test]
    fn a_mission_of_nothing_still_makes_pictures() {
        let mut trace = synthetic::mission();
        trace.frames.truncate(1);
        for drone in &mut trace.frames[0].drones {
            drone.pose.at = units::Point2::new(f32::NAN, f32::NAN);
            drone.way = f32::NAN;
            (drone.front, drone.back) = (None, None);
        }
        for draw in [map, links, positions] {
            draw(&trace).unwrap();
            let mut empty = trace.clone();
            empty.frames.clear();
            empty.nodes.clear();
            empty.floor_plan = world::FloorPlan::default();
            draw(&empty).unwrap();
        }
    }

    #[test]
    fn a_moving_swarm_has_no_head() {
        let head = ">head</text>";
        assert!(moving(&synthetic::mission()).unwrap().contains(head));
        let svg = moving(&synthetic::named_as(units::MissionKind::Swarm)).unwrap();
        assert!(!svg.contains(head) && svg.contains(">0</text>") && svg.contains(">base</text>"));
    }
}
