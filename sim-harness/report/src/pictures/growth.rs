//! Draws what grows over time, such as what is known: a chart for each group, with a curve for each variant.

use super::PictureError;
use super::axes::{Chart, Frame, stroke};
use super::sheet::{Picture, headed, part, size_of};
use super::style::{self, category};
use super::ticks::Axis;

/// One row of charts.
#[derive(Clone, Debug, PartialEq)]
pub struct GrowthChart {
    /// The title of the picture.
    pub title: String,
    /// One line below it.
    pub subtitle: String,
    /// The quantity: `Part of the room that is known`.
    pub value_name: String,
    /// The top of the value axis.
    pub most: f64,
    /// The charts, from left to right.
    pub groups: Vec<Growths>,
}

/// The curves of one chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Growths {
    /// The name of the chart.
    pub label: String,
    /// The name of each variant, and its value at each second.
    pub curves: Vec<(String, Vec<f32>)>,
}

/// Room for the variants' names on the right, in pixels.
const LABELS: f64 = 80.0;
/// Size of the picture, in pixels.
const PICTURE: (f64, f64) = (1200.0, 420.0);
/// Gap between two charts, in pixels.
const GUTTER: f64 = 20.0;

/// The picture of its own.
pub(super) fn picture(chart: &GrowthChart) -> Result<Picture, PictureError> {
    Picture::draw(PICTURE, &chart.title, |sheet| {
        let body = headed(sheet, &chart.title, &chart.subtitle)?;
        let (width, height) = size_of(&body);
        let count = chart.groups.len().max(1) as f64;
        let each = (width - GUTTER * (count - 1.0)) / count;
        let longest =
            chart.groups.iter().flat_map(|group| &group.curves).map(|it| it.1.len()).max();
        let x = Axis::exact(0.0, longest.unwrap_or(1) as f64, 6);
        let y = Axis::exact(0.0, chart.most, 5);
        for (index, group) in chart.groups.iter().enumerate() {
            let area = part(&body, ((each + GUTTER) * index as f64, 0.0), (each, height));
            let frame = Frame {
                title: &group.label,
                y_name: &chart.value_name,
                x_name: Some("Time, s"),
                right: LABELS,
            };
            let mut drawn = Chart::new(&area, &frame, &x, &y)?;
            let mut labels = Vec::new();
            for (index, (name, curve)) in group.curves.iter().enumerate() {
                // A robot has its colour in every picture.
                let robot = name.strip_prefix("robot ").and_then(|n| n.parse::<usize>().ok());
                let colour = robot.map_or_else(|| category(index), |n| style::robot(n.max(1) - 1));
                let at = |(second, known): (usize, &f32)| (second as f64 + 1.0, f64::from(*known));
                let mut points = vec![(0.0, 0.0)];
                points.extend(curve.iter().enumerate().map(at));
                if let Some((_, last)) = points.last() {
                    labels.push((*last, name.clone(), colour));
                }
                drawn.line(points, stroke(&colour, 1.8))?;
            }
            drawn.labels(labels)?;
        }
        Ok(Vec::new())
    })
}
