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
    /// The curves.
    pub curves: Vec<Curve>,
}

/// One variant over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The name of the variant.
    pub name: String,
    /// The number of the robot, from 0, where the variant is one: it has its colour in every picture.
    pub robot: Option<usize>,
    /// The value at each second. The last one is drawn on to the end of the chart by a thin line.
    pub values: Vec<f32>,
}

impl Curve {
    /// The curve of a variant that is no single robot.
    #[must_use]
    pub const fn of(name: String, values: Vec<f32>) -> Self {
        Self { name, robot: None, values }
    }

    /// The curve of one robot, numbered from 0.
    #[must_use]
    pub fn of_robot(robot: usize, values: Vec<f32>) -> Self {
        Self { name: format!("robot {}", robot + 1), robot: Some(robot), values }
    }
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
            chart.groups.iter().flat_map(|group| &group.curves).map(|it| it.values.len()).max();
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
            for (index, curve) in group.curves.iter().enumerate() {
                let colour = curve.robot.map_or_else(|| category(index), style::robot);
                let at = |(second, known): (usize, &f32)| (second as f64 + 1.0, f64::from(*known));
                let mut points = vec![(0.0, 0.0)];
                points.extend(curve.values.iter().enumerate().map(at));
                if let Some((_, last)) = points.last() {
                    labels.push((*last, curve.name.clone(), colour));
                    let on = vec![(curve.values.len() as f64, *last), (x.to, *last)];
                    drawn.line(on, stroke(&colour, 0.6))?;
                }
                drawn.line(points, stroke(&colour, 1.8))?;
            }
            drawn.labels(labels)?;
        }
        Ok(Vec::new())
    })
}
