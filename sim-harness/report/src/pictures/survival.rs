//! Draws survival curves: for each variant the share of its runs that have not come to an event yet,
//! against time. A run that never comes to it is in the picture to the end.

use super::PictureError;
use super::axes::{Chart, Frame, stroke};
use super::boxes::{RunGroup, RunValues};
use super::sheet::{Area, Drawn, Fault, Picture, headed, part, size_of};
use super::style::category;
use super::ticks::Axis;

/// One row of charts, a chart for each group.
#[derive(Clone, Debug, PartialEq)]
pub struct SurvivalChart {
    /// The title of the picture.
    pub title: String,
    /// The quantity on the axis of time and its unit: `Time since the start, s`.
    pub time_name: String,
    /// The time at which all runs end, in the unit of `time_name`.
    pub until: f64,
    /// The charts, from left to right; the values are times, infinite where the event never came.
    pub groups: Vec<RunGroup>,
}

/// The quantity on the other axis, which has no unit.
const SHARE: &str = "Share of runs not settled to 3 dB yet";
/// Room for the variants' names and last shares on the right, in pixels.
const LABELS: f64 = 92.0;
/// Size of the picture of its own, in pixels.
const PICTURE: (f64, f64) = (1200.0, 400.0);
/// Gap between two charts, in pixels.
const GUTTER: f64 = 20.0;

/// The picture of its own.
pub(super) fn picture(chart: &SurvivalChart) -> Result<Picture, PictureError> {
    Picture::draw(PICTURE, &chart.title, |sheet| {
        let subtitle =
            "A run that never settles stays at the top; at the right: the share at the end";
        let body = headed(sheet, &chart.title, subtitle)?;
        row(&body, chart, "")
    })
}

/// All charts side by side.
pub(super) fn row(area: &Area<'_>, chart: &SurvivalChart, title: &str) -> Drawn {
    let (width, height) = size_of(area);
    let count = chart.groups.len().max(1) as f64;
    let each = (width - GUTTER * (count - 1.0)) / count;
    for (index, group) in chart.groups.iter().enumerate() {
        let column = part(area, ((each + GUTTER) * index as f64, 0.0), (each, height));
        let prefix = if index == 0 { title } else { "" };
        panel(&column, chart, group, &format!("{prefix}{}", group.label))?;
    }
    Ok(Vec::new())
}

/// The chart of one group.
pub(super) fn panel(
    area: &Area<'_>,
    chart: &SurvivalChart,
    group: &RunGroup,
    title: &str,
) -> Result<(), Fault> {
    let (x, y) = (Axis::exact(0.0, chart.until, 6), Axis::exact(0.0, 1.03, 5));
    let frame = Frame { title, y_name: SHARE, x_name: Some(&chart.time_name), right: LABELS };
    let mut drawn = Chart::new(area, &frame, &x, &y)?;
    let mut labels = Vec::new();
    for (index, series) in group.series.iter().enumerate() {
        let points = steps(series, chart.until);
        let colour = category(index);
        if let Some((_, last)) = points.last() {
            labels.push((*last, format!("{} {last:.2}", series.name), colour));
        }
        // Of lines that lie on each other, the ones below stand out on both sides.
        let above = group.series.len() - 1 - index;
        drawn.line(points, stroke(&colour, 1.6 + 0.9 * above as f64))?;
    }
    drawn.labels(labels)
}

/// The corners of the curve: all runs at first, and a step down where one comes to the event. NaN is
/// no run.
fn steps(series: &RunValues, until: f64) -> Vec<(f64, f64)> {
    let mut times: Vec<f64> =
        series.values.iter().map(|time| f64::from(*time)).filter(|time| !time.is_nan()).collect();
    times.sort_by(f64::total_cmp);
    let runs = times.len();
    if runs == 0 {
        return Vec::new();
    }
    let share = |left: usize| left as f64 / runs as f64;
    let mut points = vec![(0.0, 1.0)];
    for (gone, time) in times.iter().take_while(|time| **time <= until).enumerate() {
        points.push((*time, share(runs - gone)));
        points.push((*time, share(runs - gone - 1)));
    }
    let last = points.last().map_or(1.0, |(_, share)| *share);
    points.push((until, last));
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_that_never_settles_is_counted_to_the_end() {
        let values = vec![20.0, f32::INFINITY, 10.0, f32::NAN, f32::INFINITY];
        let series = RunValues { name: "K".to_owned(), values };
        let expected =
            [(0.0, 1.0), (10.0, 1.0), (10.0, 0.75), (20.0, 0.75), (20.0, 0.5), (63.0, 0.5)];
        assert_eq!(steps(&series, 63.0), expected);
        let never = RunValues { name: "K".to_owned(), values: vec![f32::INFINITY] };
        assert_eq!(steps(&never, 63.0), [(0.0, 1.0), (63.0, 1.0)]);
        assert!(steps(&RunValues { name: "K".to_owned(), values: vec![] }, 63.0).is_empty());
    }
}
