//! Draws box plots: medians, quartiles and outliers of groups of runs, and the number of runs
//! without a finite value.
//!
//! The box spans the quartiles (linear interpolation, Hyndman and Fan's type 7, as R and NumPy do),
//! the whiskers reach to the last value within 1.5 times the box's height of it (Tukey), and values
//! beyond are dots. Infinite values, of runs that never reached the measured event, cannot be drawn
//! to scale: their number is written above their box, and NaN is left out.

use plotters::element::{Circle, PathElement, Rectangle};
use plotters::style::{Color, RGBColor};

use input::counted;

use super::PictureError;
use super::axes::{filled, stroke};
use super::dashes;
use super::sheet::{
    Area, Drawn, Fault, Look, Picture, headed, part, px, size_of, text_width, write,
};
use super::style::{AXIS, GRID, INK, PAPER, QUIET, category};
use super::ticks::Axis;

/// One chart of box plots.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxChart {
    /// The title of the picture.
    pub title: String,
    /// The quantity and its unit: `Convergence time, s`.
    pub value_name: String,
    /// The meaning of an infinite value, printed after a count of them: `never`.
    pub infinite_name: String,
    /// Whether equal heights are equal factors, for values of which a few are many times the others.
    pub is_logarithmic: bool,
    /// The groups, from left to right.
    pub groups: Vec<RunGroup>,
}

/// The runs of all variants in one corridor.
#[derive(Clone, Debug, PartialEq)]
pub struct RunGroup {
    /// The corridor's name.
    pub label: String,
    /// The variants, in the order in which they are drawn; the same in every group.
    pub series: Vec<RunValues>,
    /// The mean that a paper gives for this group, drawn as a dashed line across it; then the means of the series
    /// are drawn too.
    pub told: Option<f32>,
}

/// What was measured in the runs of one variant.
#[derive(Clone, Debug, PartialEq)]
pub struct RunValues {
    /// The variant's name: `T0`.
    pub name: String,
    /// One value for each run, in the unit that the chart names; infinite for a run that never
    /// reached the event.
    pub values: Vec<f32>,
}

/// The picture of its own.
pub(super) fn picture(chart: &BoxChart) -> Result<Picture, PictureError> {
    let boxes: usize = chart.groups.iter().map(|group| group.series.len()).sum();
    let width = (boxes as f64 * 64.0 + 200.0).clamp(520.0, 1200.0);
    Picture::draw((width, 420.0), &chart.title, |sheet| {
        let body = headed(sheet, &chart.title, &legend(chart))?;
        panel(&body, chart, "")
    })
}

/// What the marks mean, and how many runs a box stands for.
fn legend(chart: &BoxChart) -> String {
    let runs = runs_of(chart.groups.iter().flat_map(|group| &group.series));
    let told = if chart.groups.iter().any(|group| group.told.is_some()) {
        "; white: mean; dashed: the paper's mean"
    } else {
        ""
    };
    format!("Box: quartiles; whiskers: within 1.5 boxes of it; {runs}{told}")
}

/// How many runs each of the series stands for, in words.
pub(super) fn runs_of<'a>(series: impl Iterator<Item = &'a RunValues> + Clone) -> String {
    let counts = series.map(|it| it.values.len());
    match (counts.clone().min(), counts.max()) {
        (Some(least), Some(most)) if least == most => format!("{} each", counted(most, "run")),
        (Some(least), Some(most)) => format!("{least} to {most} runs each"),
        _ => "no runs".to_owned(),
    }
}

/// The chart, as large as the area.
pub(super) fn panel(area: &Area<'_>, chart: &BoxChart, title: &str) -> Drawn {
    write(area, title, (0.0, 10.0), Look::HEADING)?;
    let gap = if title.is_empty() { 0.0 } else { 12.0 };
    let after = text_width(title, Look::HEADING) + gap;
    write(area, &chart.value_name, (after, 10.0), Look::LABEL)?;
    let (width, height) = size_of(area);
    let plot = part(area, (LEFT, TOP), (width - LEFT, height - TOP - FOOT));
    let axis = if chart.is_logarithmic {
        Axis::logarithmic(finite(chart))
    } else {
        Axis::from_zero(finite(chart), 5)
    };
    grid(area, &plot, &axis)?;
    let breadth = (width - LEFT) / chart.groups.len().max(1) as f64;
    for (index, group) in chart.groups.iter().enumerate() {
        let left = LEFT + breadth * index as f64;
        let column = part(area, (left, 0.0), (breadth, height));
        draw_group(&column, group, &axis, &chart.infinite_name)?;
    }
    Ok(Vec::new())
}

/// Room for the axis' numbers; for title and counts above; for names below.
const LEFT: f64 = 56.0;
const TOP: f64 = 44.0;
const FOOT: f64 = 40.0;

fn finite(chart: &BoxChart) -> impl Iterator<Item = f64> {
    let measured = chart.groups.iter().flat_map(|group| &group.series).flat_map(|it| &it.values);
    let told = chart.groups.iter().filter_map(|group| group.told.as_ref());
    measured.chain(told).map(|v| f64::from(*v)).filter(|v| v.is_finite())
}

fn grid(area: &Area<'_>, plot: &Area<'_>, axis: &Axis) -> Result<(), Fault> {
    let (width, height) = size_of(plot);
    for tick in &axis.ticks {
        let y = at(axis, *tick, height);
        let colour = if *tick == axis.from { AXIS } else { GRID };
        let rule = vec![(0, px(y)), (px(width), px(y))];
        plot.draw(&PathElement::new(rule, stroke(&colour, 0.8)))?;
        write(area, &axis.label(*tick), (LEFT - 8.0, TOP + y), Look::LABEL.right())?;
    }
    Ok(())
}

/// Height of a value from the top of a plot of this height, in pixels.
fn at(axis: &Axis, value: f64, height: f64) -> f64 {
    height * (1.0 - axis.share(value))
}

fn draw_group(
    column: &Area<'_>,
    group: &RunGroup,
    axis: &Axis,
    infinite_name: &str,
) -> Result<(), Fault> {
    let (width, height) = size_of(column);
    let slot = (width * 0.86 / group.series.len().max(1) as f64).min(90.0);
    let first = (width - slot * group.series.len() as f64) / 2.0;
    for (index, series) in group.series.iter().enumerate() {
        let x = first + slot * (index as f64 + 0.5);
        let colour = category(index);
        let plot = part(column, (0.0, TOP), (width, height - TOP - FOOT));
        if let Some(summary) = Summary::of(&series.values) {
            draw_box(&plot, &summary, axis, x, (slot * 0.6).min(34.0), colour)?;
        }
        if let (Some(mean), Some(_)) = (mean(&series.values), group.told) {
            let middle = (px(x), px(at(axis, mean, height - TOP - FOOT)));
            plot.draw(&Circle::new(middle, px(3.5), filled(&INK)))?;
            plot.draw(&Circle::new(middle, px(2.3), filled(&PAPER)))?;
        }
        let name = Look::LABEL.centred().coloured(INK);
        write(column, &series.name, (x, height - FOOT + 12.0), name)?;
        never(column, series, (x, slot), infinite_name)?;
    }
    if let Some(told) = group.told {
        let plot = part(column, (0.0, TOP), (width, height - TOP - FOOT));
        let y = at(axis, f64::from(told), height - TOP - FOOT);
        let ends = [(0.05 * width, y), (0.95 * width, y)];
        for dash in dashes::cut(&ends, 6.0, 4.0) {
            let dash: Vec<_> = dash.into_iter().map(|(x, y)| (px(x), px(y))).collect();
            plot.draw(&PathElement::new(dash, stroke(&INK, 1.2)))?;
        }
    }
    let name = Look { bold: true, ..Look::LABEL.centred() };
    write(column, &group.label, (width / 2.0, height - 8.0), name)
}

/// Prints the number of infinite values, above the plot.
fn never(
    column: &Area<'_>,
    series: &RunValues,
    (x, slot): (f64, f64),
    infinite_name: &str,
) -> Result<(), Fault> {
    let infinite = series.values.iter().filter(|v| v.is_infinite()).count();
    if infinite == 0 {
        return Ok(());
    }
    let of = series.values.iter().filter(|v| !v.is_nan()).count();
    let look = Look::LABEL.centred().sized(9.5);
    let (count, words) = (format!("{infinite} of {of}"), infinite_name.to_owned());
    let whole = format!("{count} {words}");
    if text_width(&whole, look) < slot {
        return write(column, &whole, (x, TOP - 10.0), look);
    }
    // Where even the count has no room beside its neighbours, the part in a hundred has.
    let count = if text_width(&count, look) < slot { count } else { percent(infinite, of) };
    write(column, &count, (x, TOP - 18.0), look)?;
    write(column, &words, (x, TOP - 7.0), look)
}

/// `69 %`; a part that is there but would round to nothing keeps a decimal.
fn percent(part: usize, of: usize) -> String {
    let percent = 100.0 * part as f64 / of.max(1) as f64;
    if percent < 1.0 { format!("{percent:.1} %") } else { format!("{percent:.0} %") }
}

fn draw_box(
    plot: &Area<'_>,
    summary: &Summary,
    axis: &Axis,
    x: f64,
    width: f64,
    colour: RGBColor,
) -> Result<(), Fault> {
    let (_, height) = size_of(plot);
    let y = |value: f64| px(at(axis, value, height));
    let (left, right) = (px(x - width / 2.0), px(x + width / 2.0));
    let [low, q1, median, q3, high] = summary.five;
    for (from, to) in [(low, q1), (q3, high)] {
        let whisker = vec![(px(x), y(from)), (px(x), y(to))];
        plot.draw(&PathElement::new(whisker, stroke(&QUIET, 1.0)))?;
    }
    for outlier in &summary.outliers {
        plot.draw(&Circle::new((px(x), y(*outlier)), px(1.6), filled(&QUIET.mix(0.5))))?;
    }
    let corners = [(left, y(q3)), (right, y(q1))];
    plot.draw(&Rectangle::new(corners, filled(&PAPER)))?;
    plot.draw(&Rectangle::new(corners, filled(&colour.mix(0.35))))?;
    let [(l, t), (r, b)] = corners;
    let outline = vec![(l, t), (r, t), (r, b), (l, b), (l, t)];
    plot.draw(&PathElement::new(outline, stroke(&colour, 1.2)))?;
    let line = vec![(left, y(median)), (right, y(median))];
    plot.draw(&PathElement::new(line, stroke(&INK, 2.0)))
}

/// A box plot's numbers.
#[derive(Clone, Debug, PartialEq)]
struct Summary {
    /// Lower whisker, lower quartile, median, upper quartile, upper whisker.
    five: [f64; 5],
    outliers: Vec<f64>,
}

impl Summary {
    /// The quartiles of the finite values; `None` where there are none.
    fn of(values: &[f32]) -> Option<Self> {
        let mut sorted: Vec<f64> =
            values.iter().map(|v| f64::from(*v)).filter(|v| v.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let [q1, median, q3] = [0.25, 0.5, 0.75].map(|p| quantile(&sorted, p));
        let (q1, median, q3) = (q1?, median?, q3?);
        let reach = 1.5 * (q3 - q1);
        let (inside, outliers): (Vec<f64>, Vec<f64>) =
            sorted.into_iter().partition(|v| (q1 - reach..=q3 + reach).contains(v));
        let (low, high) = (*inside.first()?, *inside.last()?);
        Some(Self { five: [low.min(q1), q1, median, q3, high.max(q3)], outliers })
    }
}

/// The mean of the finite values; `None` where there are none.
fn mean(values: &[f32]) -> Option<f64> {
    let finite: Vec<f64> = values.iter().map(|v| f64::from(*v)).filter(|v| v.is_finite()).collect();
    (!finite.is_empty()).then(|| finite.iter().sum::<f64>() / finite.len() as f64)
}

fn quantile(sorted: &[f64], p: f64) -> Option<f64> {
    let place = p * sorted.len().checked_sub(1)? as f64;
    let below = *sorted.get(place.floor() as usize)?;
    let above = *sorted.get(place.ceil() as usize)?;
    Some(below + (above - below) * (place - place.floor()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_are_those_of_numpy() {
        // numpy.percentile([1, 2, 3, 4, 100], [25, 50, 75]) = [2, 3, 4]; 100 is beyond 4 + 1.5·2.
        let summary = Summary::of(&[4.0, 100.0, 1.0, f32::INFINITY, 3.0, f32::NAN, 2.0]).unwrap();
        assert_eq!(summary.five, [1.0, 2.0, 3.0, 4.0, 4.0]);
        assert_eq!(summary.outliers, [100.0]);
    }

    #[test]
    fn nothing_finite_is_no_box() {
        assert_eq!(Summary::of(&[f32::INFINITY, f32::NAN]), None);
        assert_eq!(Summary::of(&[]), None);
    }
}
