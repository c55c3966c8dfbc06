//! Charts over time: grid, axes, and lines that say at their end what they are.

use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::cartesian::Cartesian2d;
use plotters::element::{Circle, PathElement};
use plotters::style::{Color, RGBColor, ShapeStyle, TRANSPARENT};

use super::canvas::Canvas;
use super::dashes;
use super::sheet::{Area, Fault, Look, PlotFrame, px, size_of, text_width, upx, write};
use super::style::{AXIS, GRID, QUIET};
use super::ticks::Axis;

/// A chart with its axes drawn, ready for lines.
pub(super) struct Chart<'a> {
    context: ChartContext<'a, Canvas<'a>, Cartesian2d<Axis, Axis>>,
    area: Area<'a>,
}

/// The texts around a chart.
pub(super) struct Frame<'t> {
    /// Top left, bold.
    pub(super) title: &'t str,
    /// The quantity of the y axis and its unit, after the title.
    pub(super) y_name: &'t str,
    /// Below; without it the x axis has neither name nor numbers.
    pub(super) x_name: Option<&'t str>,
    /// Room for labels of lines on the right, in pixels.
    pub(super) right: f64,
}

/// A stroke of this colour and width in pixels.
pub(super) fn stroke(colour: &impl Color, width: f64) -> ShapeStyle {
    ShapeStyle { color: colour.to_rgba(), filled: false, stroke_width: upx(width) }
}

/// A filled shape.
pub(super) fn filled(colour: &impl Color) -> ShapeStyle {
    ShapeStyle { color: colour.to_rgba(), filled: true, stroke_width: 0 }
}

const TOP: f64 = 30.0;
const LEFT: f64 = 40.0;
const BOTTOM: f64 = 40.0;
const BOTTOM_BARE: f64 = 10.0;

impl<'a> Chart<'a> {
    /// Draws the axes.
    pub(super) fn new(
        area: &Area<'a>,
        frame: &Frame<'_>,
        x: &Axis,
        y: &Axis,
    ) -> Result<Self, Fault> {
        write_titles(area, frame)?;
        let bottom = if frame.x_name.is_some() { BOTTOM } else { BOTTOM_BARE };
        let mut context = ChartBuilder::on(area)
            .margin_top(upx(TOP))
            .margin_right(upx(frame.right))
            .margin_bottom(upx(if frame.x_name.is_some() { 0.0 } else { bottom }))
            .x_label_area_size(upx(if frame.x_name.is_some() { bottom } else { 0.0 }))
            .y_label_area_size(upx(LEFT))
            .build_cartesian_2d(x.clone(), y.clone())?;
        context
            .configure_mesh()
            .x_labels(x.ticks.len())
            .y_labels(y.ticks.len())
            .max_light_lines(0)
            .bold_line_style(stroke(&GRID, 0.8))
            .light_line_style(TRANSPARENT)
            .axis_style(stroke(&AXIS, 0.8))
            .set_all_tick_mark_size(upx(4.0))
            .label_style(Look::LABEL.style())
            .draw()?;
        let chart = Self { context, area: area.clone() };
        if let Some(name) = frame.x_name {
            let (_, height) = size_of(area);
            let (left, right) = chart.horizontal();
            let middle = ((left + right) / 2.0, height - 8.0);
            write(area, name, middle, Look::LABEL.centred())?;
        }
        Ok(chart)
    }

    /// A line through these points; where one is not finite, the line is broken.
    pub(super) fn line(
        &mut self,
        points: impl IntoIterator<Item = (f64, f64)>,
        style: ShapeStyle,
    ) -> Result<(), Fault> {
        for run in runs(points) {
            self.context.draw_series([PathElement::new(run, style)])?;
        }
        Ok(())
    }

    /// A dashed line of the same kind.
    pub(super) fn dashes(
        &self,
        points: impl IntoIterator<Item = (f64, f64)>,
        style: ShapeStyle,
    ) -> Result<(), Fault> {
        for run in runs(points) {
            let path: Vec<_> = run.into_iter().map(|p| self.pixel(p)).collect();
            for dash in dashes::cut(&path, DASH, GAP) {
                let dash: Vec<_> = dash.into_iter().map(|(x, y)| (px(x), px(y))).collect();
                self.area.draw(&PathElement::new(dash, style))?;
            }
        }
        Ok(())
    }

    /// Dots.
    pub(super) fn dots(
        &mut self,
        points: impl IntoIterator<Item = (f64, f64)>,
        radius: f64,
        style: ShapeStyle,
    ) -> Result<(), Fault> {
        let finite = points.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite());
        self.context.draw_series(finite.map(|p| Circle::new(p, px(radius), style)))?;
        Ok(())
    }

    /// Labels right of the chart, each as near to its own height as the others let it be.
    pub(super) fn labels(&self, labels: Vec<(f64, String, RGBColor)>) -> Result<(), Fault> {
        let (_, right) = self.horizontal();
        let (top, bottom) = self.vertical();
        let size = Look::LABEL.size;
        let mut placed: Vec<_> = labels
            .into_iter()
            .map(|(y, text, colour)| (self.pixel((0.0, y)).1, text, colour))
            .collect();
        placed.sort_by(|a, b| a.0.total_cmp(&b.0));
        let wanted: Vec<f64> = placed.iter().map(|label| label.0).collect();
        let heights = spread(&wanted, size + 3.0, top, bottom);
        for ((_, text, colour), y) in placed.into_iter().zip(heights) {
            write(&self.area, &text, (right + 8.0, y), Look::LABEL.coloured(colour))?;
        }
        Ok(())
    }

    /// The place of the plot on the sheet.
    pub(super) fn frame(&self, x: &Axis) -> PlotFrame {
        let (xs, ys) = self.context.plotting_area().get_pixel_range();
        let px = |v: i32| f64::from(v) / 10.0;
        PlotFrame {
            left: px(xs.start),
            right: px(xs.end),
            top: px(ys.start),
            bottom: px(ys.end),
            from: x.from,
            to: x.to,
        }
    }

    /// Left and right edge of the plot, in pixels of the panel.
    pub(super) fn horizontal(&self) -> (f64, f64) {
        let (xs, _) = self.context.plotting_area().get_pixel_range();
        let (left, _) = self.area.get_pixel_range();
        (f64::from(xs.start - left.start) / 10.0, f64::from(xs.end - left.start) / 10.0)
    }

    /// Top and bottom edge of the plot, in pixels of the panel.
    pub(super) fn vertical(&self) -> (f64, f64) {
        let (_, ys) = self.context.plotting_area().get_pixel_range();
        let (_, top) = self.area.get_pixel_range();
        (f64::from(ys.start - top.start) / 10.0, f64::from(ys.end - top.start) / 10.0)
    }

    /// A point of the chart in pixels of the panel.
    pub(super) fn pixel(&self, point: (f64, f64)) -> (f64, f64) {
        let (x, y) = self.context.backend_coord(&point);
        let (xs, ys) = self.area.get_pixel_range();
        (f64::from(x - xs.start) / 10.0, f64::from(y - ys.start) / 10.0)
    }
}

/// Pixels of a dash, and of the gap after it.
const DASH: f64 = 4.0;
const GAP: f64 = 3.0;

fn write_titles(area: &Area<'_>, frame: &Frame<'_>) -> Result<(), Fault> {
    write(area, frame.title, (0.0, 10.0), Look::HEADING)?;
    let gap = if frame.title.is_empty() { 0.0 } else { 12.0 };
    let after = text_width(frame.title, Look::HEADING) + gap;
    write(area, frame.y_name, (after, 10.0), Look::LABEL.coloured(QUIET))
}

/// The unbroken parts of a line.
fn runs(points: impl IntoIterator<Item = (f64, f64)>) -> Vec<Vec<(f64, f64)>> {
    let mut runs = vec![Vec::new()];
    for point in points {
        if point.0.is_finite() && point.1.is_finite() {
            if let Some(run) = runs.last_mut() {
                run.push(point);
            }
        } else if runs.last().is_some_and(|run| !run.is_empty()) {
            runs.push(Vec::new());
        }
    }
    runs.retain(|run| run.len() > 1);
    runs
}

/// Moves sorted heights apart until `gap` lies between any two, within `top` and `bottom` where
/// there is room: downwards first, then back up from the bottom.
fn spread(wanted: &[f64], gap: f64, top: f64, bottom: f64) -> Vec<f64> {
    let mut heights = wanted.to_vec();
    let mut least = top;
    for height in &mut heights {
        *height = height.max(least);
        least = *height + gap;
    }
    let mut most = bottom;
    for height in heights.iter_mut().rev() {
        *height = height.min(most);
        most = *height - gap;
    }
    heights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_keep_apart_and_inside() {
        let heights = spread(&[10.0, 11.0, 98.0, 99.0], 12.0, 0.0, 100.0);
        assert_eq!(heights, [10.0, 22.0, 88.0, 100.0]);
    }

    #[test]
    fn a_gap_breaks_a_line() {
        let nan = f64::NAN;
        let found = runs([(0.0, 1.0), (1.0, 1.0), (2.0, nan), (3.0, 1.0), (4.0, 2.0), (5.0, nan)]);
        assert_eq!(found, [vec![(0.0, 1.0), (1.0, 1.0)], vec![(3.0, 1.0), (4.0, 2.0)]]);
    }
}
