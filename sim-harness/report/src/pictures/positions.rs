//! Ways along the tunnel against time.

use super::PictureError;
use super::axes::{Chart, Frame, stroke};
use super::series::{time_span, way};
use super::sheet::{Area, Drawn, Picture, headed};
use super::style::node_colour;
use super::ticks::Axis;
use mission::trace::Trace;

/// The picture of a run.
pub(super) fn picture(trace: &Trace) -> Result<Picture, PictureError> {
    let title = format!("Positions along the tunnel: {}", trace.scenario);
    Picture::draw((960.0, 420.0), &title, |sheet| {
        let subtitle = "Length of the shortest way from the base, for every node";
        let body = headed(sheet, &title, subtitle)?;
        panel(&body, trace, "", true)
    })
}

/// All nodes' ways over time, labelled at their ends.
pub(super) fn panel(area: &Area<'_>, trace: &Trace, title: &str, timed: bool) -> Drawn {
    let (from, to) = time_span(trace);
    let x = Axis::exact(from, to, 8);
    let all = (0..trace.nodes.len()).map(|node| way(trace, node)).collect::<Vec<_>>();
    let y = Axis::covering(all.iter().flatten().map(|p| p.1), 5);
    let frame =
        Frame { title, y_name: "Position, m", x_name: timed.then_some("Time, s"), right: LABELS };
    let mut chart = Chart::new(area, &frame, &x, &y)?;
    let mut labels = Vec::new();
    for (node, points) in trace.nodes.iter().zip(all).rev() {
        let colour = node_colour(node);
        if let Some(end) = points.iter().rev().find(|p| p.1.is_finite()) {
            labels.push((end.1, node.to_string(), colour));
        }
        chart.line(points, stroke(&colour, 1.6))?;
    }
    chart.labels(labels)?;
    Ok(vec![chart.frame(&x)])
}

/// Room for the longest name, in pixels.
pub(super) const LABELS: f64 = 62.0;
