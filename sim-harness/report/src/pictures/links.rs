//! Link strengths against time, one panel for each link.

use plotters::style::Color;

use super::PictureError;
use super::axes::{Chart, Frame, filled, stroke};
use super::positions::LABELS;
use super::series::{LinkSeries, launch_limit, links, time_span};
use super::sheet::{
    Area, Drawn, Fault, Look, Picture, PlotFrame, headed, part, px, size_of, text_width, write,
};
use super::style::{FILTERED, LIMIT, QUIET, RAW, TRUTH};
use super::ticks::Axis;
use mission::trace::Trace;

/// Height of one panel of a picture of its own, in pixels.
const PANEL: f64 = 150.0;
/// More links than this stand in two columns.
const ONE_COLUMN: usize = 5;

/// The picture of a run.
pub(super) fn picture(trace: &Trace) -> Result<Picture, PictureError> {
    let all = links(trace);
    let columns = if all.len() > ONE_COLUMN { 2 } else { 1 };
    let rows = all.len().div_ceil(columns).max(1);
    let size = (if columns == 2 { 1280.0 } else { 960.0 }, rows as f64 * PANEL + 126.0);
    let title = format!("Links: {}", trace.scenario);
    Picture::draw(size, &title, |sheet| {
        let subtitle = "How strongly each node hears the next in front of it, towards the head";
        let body = headed(sheet, &title, subtitle)?;
        key(&body, launch_limit(trace).is_some())?;
        let (width, height) = size_of(&body);
        let below = part(&body, (0.0, 22.0), (width, height - 22.0));
        let right = if columns == 1 { LABELS } else { 16.0 };
        stacked(&below, trace, &all, (columns, right))
    })
}

/// All links, one above the other, on common axes that end `right` pixels before the area does.
pub(super) fn panels(area: &Area<'_>, trace: &Trace, right: f64) -> Drawn {
    stacked(area, trace, &links(trace), (1, right))
}

fn stacked(
    area: &Area<'_>,
    trace: &Trace,
    all: &[LinkSeries],
    (columns, right): (usize, f64),
) -> Drawn {
    let (width, height) = size_of(area);
    if all.is_empty() {
        let middle = (width / 2.0, height / 2.0);
        write(area, "There was no link.", middle, Look::LABEL.centred())?;
        return Ok(Vec::new());
    }
    let limit = launch_limit(trace);
    let rows = all.len().div_ceil(columns);
    // The bottom row is taller by its axis' numbers and name.
    let foot = 30.0;
    let each = (height - foot) / rows as f64;
    let breadth = width / columns as f64;
    let ticks = if each > 110.0 { 5 } else { 3 };
    let y = Axis::covering(all.iter().flat_map(LinkSeries::values).chain(limit), ticks);
    let mut frames = Vec::new();
    for (index, link) in all.iter().enumerate() {
        let (row, column) = (index % rows, index / rows);
        let last = row + 1 == rows || index + 1 == all.len();
        let corner = (column as f64 * breadth, row as f64 * each);
        let size = (breadth, each + if last { foot } else { 0.0 });
        let frame = Frame {
            title: &link.name,
            y_name: if row == 0 { "RSSI, dBm" } else { "" },
            x_name: last.then_some("Time, s"),
            right,
        };
        frames.push(panel(&part(area, corner, size), trace, link, &frame, &y)?);
    }
    Ok(frames)
}

fn panel(
    area: &Area<'_>,
    trace: &Trace,
    link: &LinkSeries,
    frame: &Frame<'_>,
    y: &Axis,
) -> Result<PlotFrame, Fault> {
    let (from, to) = time_span(trace);
    let (width, _) = size_of(area);
    let x = Axis::exact(from, to, if width > 380.0 { 8 } else { 4 });
    let mut chart = Chart::new(area, frame, &x, y)?;
    if let Some(limit) = launch_limit(trace) {
        chart.line([(from, limit), (to, limit)], stroke(&LIMIT, 0.9))?;
    }
    chart.dots(link.dots(), 1.2, filled(&RAW.mix(0.7)))?;
    chart.line(link.line(|s| s.filtered), stroke(&FILTERED, 1.8))?;
    chart.dashes(link.line(|s| s.truth), stroke(&TRUTH, 1.1))?;
    name_peers(area, &chart, link)?;
    Ok(chart.frame(&x))
}

/// The name without all of its first word but a letter: `r4` for `relay 4`.
fn abbreviated(name: &str) -> String {
    let words = name.split_once(' ');
    words.map_or_else(|| name.to_owned(), |(kind, number)| format!("{}{number}", &kind[..1]))
}

/// Writes the neighbours' names at the top of the plot, each where its time begins, shortened where
/// they would run into the next.
fn name_peers(area: &Area<'_>, chart: &Chart<'_>, link: &LinkSeries) -> Result<(), Fault> {
    let (top, _) = chart.vertical();
    let (_, end) = chart.horizontal();
    let starts: Vec<f64> =
        link.peers.iter().map(|(since, _)| chart.pixel((*since, 0.0)).0).collect();
    let ends = starts.iter().skip(1).copied().chain([end]);
    for (((_, name), from), to) in link.peers.iter().zip(&starts).zip(ends) {
        let fits = |name: &&str| text_width(name, Look::LABEL) + 6.0 < to - from;
        let short = abbreviated(name);
        if let Some(name) = [name.as_str(), &short].into_iter().find(fits) {
            write(area, name, (from + 4.0, top - 7.0), Look::LABEL)?;
        }
    }
    Ok(())
}

/// Draws the legend of dots and lines, in one row.
pub(super) fn key(area: &Area<'_>, with_limit: bool) -> Result<(), Fault> {
    use plotters::element::{Circle, PathElement};
    let rule = |x: f64, from: f64, to: f64| vec![(px(x + from), px(6.0)), (px(x + to), px(6.0))];
    let mut x = 0.0;
    for (index, text) in ["received", "filtered on board", "true", "launch limit"]
        .into_iter()
        .enumerate()
        .take(if with_limit { 4 } else { 3 })
    {
        match index {
            0 => {
                for dot in [3.0, 9.0, 15.0] {
                    area.draw(&Circle::new((px(x + dot), px(6.0)), px(1.8), filled(&RAW)))?;
                }
            }
            1 => area.draw(&PathElement::new(rule(x, 0.0, 18.0), stroke(&FILTERED, 1.6)))?,
            2 => {
                for dash in [0.0, 7.0, 14.0] {
                    let dash = rule(x, dash, dash + 4.0);
                    area.draw(&PathElement::new(dash, stroke(&TRUTH, 1.4)))?;
                }
            }
            _ => area.draw(&PathElement::new(rule(x, 0.0, 18.0), stroke(&LIMIT, 1.0)))?,
        }
        write(area, text, (x + 24.0, 6.0), Look::LABEL.coloured(QUIET))?;
        x += 24.0 + text_width(text, Look::LABEL) + 26.0;
    }
    Ok(())
}
