//! Draws survival curves: for each variant the share of its runs that have not come to an event yet,
//! against time. A run that never comes to it is in the picture to the end.

use super::PictureError;
use super::axes::{Chart, Frame, stroke};
use super::boxes::{RunGroup, RunValues, runs_of};
use super::sheet::{Area, Drawn, Fault, Picture, headed, part, size_of};
use super::style::{INK, category};
use super::ticks::Axis;

/// Charts beside each other, a chart for each group.
#[derive(Clone, Debug, PartialEq)]
pub struct SurvivalChart {
    /// The title of the picture.
    pub title: String,
    /// The runs that a curve counts, to which the event has not happened yet: `not settled to 3 dB yet`.
    pub pending: String,
    /// The quantity on the axis of time and its unit: `Time since the start, s`. A way may stand for a time.
    pub time_name: String,
    /// The time at which all runs end, in the unit of `time_name`.
    pub until: f64,
    /// The charts, from left to right; the values are times, infinite where the event never came. A mean
    /// that a paper gives is a dashed line at that time.
    pub groups: Vec<RunGroup>,
}

impl SurvivalChart {
    /// The greatest finite time of some groups and a little more, as the end of a chart whose runs have no
    /// common end.
    #[must_use]
    pub fn end_of(groups: &[RunGroup]) -> f64 {
        let values = groups.iter().flat_map(|group| &group.series).flat_map(|it| &it.values);
        let told = groups.iter().filter_map(|group| group.told.as_ref());
        let finite = values.chain(told).filter(|time| time.is_finite());
        let last = finite.fold(0.0, |last: f32, time| last.max(*time));
        if last > 0.0 { 1.05 * f64::from(last) } else { 1.0 }
    }
}

/// Room for the variants' names and last shares on the right, in pixels.
const LABELS: f64 = 92.0;
/// Width of the picture of its own, height of a row of it and of what stands above, in pixels.
const WIDTH: f64 = 1200.0;
const ROW: f64 = 330.0;
const HEAD: f64 = 70.0;
/// Gap between two charts, in pixels.
const GUTTER: f64 = 20.0;
/// The most charts in a row.
const COLUMNS: usize = 3;
/// So many curves stand out on both sides of those above them.
const NESTED: usize = 4;

/// The picture of its own.
pub(super) fn picture(chart: &SurvivalChart) -> Result<Picture, PictureError> {
    let rows = chart.groups.len().div_ceil(COLUMNS).max(1);
    Picture::draw((WIDTH, HEAD + ROW * rows as f64), &chart.title, |sheet| {
        let body = headed(sheet, &chart.title, &legend(chart))?;
        self::rows(&body, chart, "")
    })
}

/// What the curves mean, and how many runs each stands for.
fn legend(chart: &SurvivalChart) -> String {
    let runs = runs_of(chart.groups.iter().flat_map(|group| &group.series));
    let told = if chart.groups.iter().any(|group| group.told.is_some()) {
        "; dashed: the paper's mean"
    } else {
        ""
    };
    format!(
        "Share of runs {}, {runs}; one to which it never happens stays at the top; at the right: the share at \
         the end{told}",
        chart.pending,
    )
}

/// All charts beside each other, in as many rows as they need.
pub(super) fn rows(area: &Area<'_>, chart: &SurvivalChart, title: &str) -> Drawn {
    let (width, height) = size_of(area);
    let columns = chart.groups.len().clamp(1, COLUMNS);
    let rows = chart.groups.len().div_ceil(columns).max(1);
    let wide = (width - GUTTER * (columns as f64 - 1.0)) / columns as f64;
    let high = (height - GUTTER * (rows as f64 - 1.0)) / rows as f64;
    for (index, group) in chart.groups.iter().enumerate() {
        let [column, row] = [index % columns, index / columns].map(|n| n as f64);
        let corner = ((wide + GUTTER) * column, (high + GUTTER) * row);
        let prefix = if index == 0 { title } else { "" };
        let title = format!("{prefix}{}", group.label);
        panel(&part(area, corner, (wide, high)), chart, group, &title)?;
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
    let share = format!("Share of runs {}", chart.pending);
    // A narrow chart has its axis named by the subtitle of the picture alone.
    let y_name = if chart.groups.len() > COLUMNS { "Share of runs" } else { &share };
    let frame = Frame { title, y_name, x_name: Some(&chart.time_name), right: LABELS };
    let mut drawn = Chart::new(area, &frame, &x, &y)?;
    let mut labels = Vec::new();
    for (index, series) in group.series.iter().enumerate() {
        let points = steps(series, chart.until);
        let colour = category(index);
        if let Some((_, last)) = points.last() {
            labels.push((*last, format!("{} {last:.2}", series.name), colour));
        }
        // Of lines that lie on each other, the ones below stand out on both sides.
        let above = (group.series.len() - 1 - index).min(NESTED);
        drawn.line(points, stroke(&colour, 1.6 + 0.9 * above as f64))?;
    }
    if let Some(told) = group.told.map(f64::from) {
        drawn.dashes([(told, 0.0), (told, 1.0)], stroke(&INK, 1.2))?;
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
