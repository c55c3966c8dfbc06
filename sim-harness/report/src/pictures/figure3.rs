//! Draws the paper's figure 3 on one page: A to C three corridors, each with one run and the survival
//! curves of many, D an exploration with several variants side by side, E survival curves and F box
//! plots over many explorations.

use super::PictureError;
use super::boxes::{self, BoxChart};
use super::series::launch_limit;
use super::sheet::{Area, Drawn, Fault, Look, Picture, headed, part, size_of, write};
use super::survival::{self, SurvivalChart};
use super::{links, map, positions};
use mission::trace::Trace;

/// The contents of the page.
#[derive(Clone, Debug)]
pub struct Figure3<'a> {
    /// The title of the page.
    pub title: &'a str,
    /// One line below it.
    pub subtitle: &'a str,
    /// Panels A to C, from left to right: one run in each corridor.
    pub corridors: Vec<Corridor<'a>>,
    /// Below them, the convergence of many such runs: a group for each corridor.
    pub resting: SurvivalChart,
    /// Panel D: the same exploration flown with each variant, from left to right.
    pub exploration: Vec<Variant<'a>>,
    /// Panel E, the convergence of many explorations.
    pub convergence: SurvivalChart,
    /// Panel F, the variances of the positions.
    pub variance: BoxChart,
}

/// A run in one corridor.
#[derive(Clone, Copy, Debug)]
pub struct Corridor<'a> {
    /// The corridor's name.
    pub name: &'a str,
    /// The runs.
    pub trace: &'a Trace,
}

/// A run with one variant of the policy.
#[derive(Clone, Copy, Debug)]
pub struct Variant<'a> {
    /// The variant's name: `T0`.
    pub name: &'a str,
    /// The runs.
    pub trace: &'a Trace,
}

const WIDTH: f64 = 1440.0;
const MAP: f64 = 190.0;
const POSITIONS: f64 = 210.0;
const LINK: f64 = 92.0;
const CURVES: f64 = 260.0;
const BOXES: f64 = 340.0;
const GUTTER: f64 = 28.0;

/// The page.
pub(super) fn picture(figure: &Figure3<'_>) -> Result<Picture, PictureError> {
    let corridors: Vec<&Trace> = figure.corridors.iter().map(|c| c.trace).collect();
    let variants: Vec<&Trace> = figure.exploration.iter().map(|v| v.trace).collect();
    let top = MAP + POSITIONS + links_height(&corridors) + CURVES;
    let middle = POSITIONS + 24.0 + links_height(&variants);
    let height = 78.0 + KEY + top + middle + CURVES + BOXES + 3.0 * GUTTER + 8.0;
    Picture::draw((WIDTH, height), figure.title, |sheet| {
        let body = headed(sheet, figure.title, figure.subtitle)?;
        let limited = corridors.iter().chain(&variants).any(|t| launch_limit(t).is_some());
        links::key(&body, limited)?;
        let (width, _) = size_of(&body);
        let mut from = KEY;
        corridor_row(&part(&body, (0.0, from), (width, top)), figure)?;
        from += top + GUTTER;
        exploration_row(&part(&body, (0.0, from), (width, middle)), &figure.exploration)?;
        from += middle + GUTTER;
        let curves = part(&body, (0.0, from), (width, CURVES));
        survival::rows(&curves, &figure.convergence, "E\u{2003}")?;
        from += CURVES + GUTTER;
        let boxes = part(&body, (0.0, from), (width, BOXES));
        boxes::panel(&boxes, &figure.variance, &format!("F\u{2003}{}", figure.variance.title))?;
        Ok(Vec::new())
    })
}

/// Height of the key to the links' lines.
const KEY: f64 = 30.0;

/// Room for the run with the most links.
fn links_height(traces: &[&Trace]) -> f64 {
    let most = traces.iter().map(|t| t.nodes.len().saturating_sub(1)).max().unwrap_or(1);
    LINK * most.clamp(1, 6) as f64 + 30.0
}

/// Splits a row into equal columns.
fn columns<'a>(row: &Area<'a>, count: usize) -> Vec<Area<'a>> {
    let (width, height) = size_of(row);
    let count = count.max(1);
    let each = (width - GUTTER * (count - 1) as f64) / count as f64;
    (0..count)
        .map(|index| part(row, ((each + GUTTER) * index as f64, 0.0), (each, height)))
        .collect()
}

fn corridor_row(row: &Area<'_>, figure: &Figure3<'_>) -> Result<(), Fault> {
    let letters = ["A", "B", "C"];
    let (corridors, curves) = (&figure.corridors, &figure.resting);
    for (index, (column, corridor)) in
        columns(row, corridors.len()).iter().zip(corridors).enumerate()
    {
        let letter = letters.get(index).copied().unwrap_or_default();
        let (width, height) = size_of(column);
        let title = format!("{letter}\u{2003}{}", corridor.name);
        map::panel(&part(column, (0.0, 0.0), (width, MAP)), corridor.trace, &title)?;
        let below = part(column, (0.0, MAP), (width, height - MAP - CURVES));
        positions_and_links(&below, corridor.trace)?;
        let Some(group) = curves.groups.get(index) else { continue };
        survival::panel(&part(column, (0.0, height - CURVES), (width, CURVES)), curves, group, "")?;
    }
    Ok(())
}

fn exploration_row(row: &Area<'_>, variants: &[Variant<'_>]) -> Result<(), Fault> {
    for (index, (column, variant)) in columns(row, variants.len()).iter().zip(variants).enumerate()
    {
        let (width, height) = size_of(column);
        let name = match index {
            0 => format!("D\u{2003}Exploration, {}", variant.name),
            _ => variant.name.to_owned(),
        };
        write(column, &name, (0.0, 10.0), Look::HEADING)?;
        let below = part(column, (0.0, 24.0), (width, height - 24.0));
        positions_and_links(&below, variant.trace)?;
    }
    Ok(())
}

fn positions_and_links(area: &Area<'_>, trace: &Trace) -> Drawn {
    let (width, height) = size_of(area);
    positions::panel(&part(area, (0.0, 0.0), (width, POSITIONS)), trace, "", true)?;
    links::panels(
        &part(area, (0.0, POSITIONS), (width, height - POSITIONS)),
        trace,
        positions::LABELS,
    )
}
