//! The foot of every map: the scale bar, with an arrow that points north.

use plotters::element::{PathElement, Polygon};

use super::axes::{filled, stroke};
use super::sheet::{Area, Fault, Look, px, text_width, write};
use super::style::{INK, QUIET};
use super::ticks::round_step;

/// The longest scale bar, in pixels.
pub(super) const LONGEST: f64 = 90.0;
/// The gap between the length of the scale bar and the arrow, in pixels.
const GAP: f64 = 18.0;

/// Draws a scale bar of at most `room` pixels whose left end is at `at`, where `scale` pixels are a metre, and
/// right of it an arrow to the top of the area, which is north on all maps.
pub(super) fn bar_and_north(
    area: &Area<'_>,
    (left, y): (f64, f64),
    scale: f64,
    room: f64,
) -> Result<(), Fault> {
    let (metres, decimals) = round_step(room.min(LONGEST) / scale);
    let right = left + metres * scale;
    let bar = [(left, y - 4.0), (left, y), (right, y), (right, y - 4.0)];
    let bar: Vec<_> = bar.into_iter().map(|(x, y)| (px(x), px(y))).collect();
    area.draw(&PathElement::new(bar, stroke(&INK, 1.0)))?;
    let (words, look) = (format!("{metres:.decimals$} m"), Look::LABEL.coloured(QUIET));
    write(area, &words, (right + 8.0, y - 2.0), look)?;
    north(area, (right + 8.0 + text_width(&words, look) + GAP, y))
}

fn north(area: &Area<'_>, (x, foot): (f64, f64)) -> Result<(), Fault> {
    let head = [(x, foot - 14.0), (x + 4.0, foot - 5.0), (x - 4.0, foot - 5.0)];
    let head = head.map(|(x, y)| (px(x), px(y))).to_vec();
    area.draw(&Polygon::new(head, filled(&INK)))?;
    let shaft = vec![(px(x), px(foot - 6.0)), (px(x), px(foot + 1.0))];
    area.draw(&PathElement::new(shaft, stroke(&INK, 1.2)))?;
    write(area, "N", (x + 7.0, foot - 3.0), Look::LABEL.coloured(QUIET))
}
