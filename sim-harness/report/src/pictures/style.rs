//! The colours of paper, ink and ground, and those of charts; [`palette`] has those of drones and links.

use plotters::style::RGBColor;

use super::palette;
use mission::trace::Node;

/// The page.
pub(super) const PAPER: RGBColor = RGBColor(255, 255, 255);
/// Titles and whatever must be read.
pub(super) const INK: RGBColor = RGBColor(31, 41, 51);
/// Labels of axes, subtitles.
pub(super) const QUIET: RGBColor = RGBColor(97, 110, 124);
/// Axes.
pub(super) const AXIS: RGBColor = RGBColor(154, 165, 177);
/// Grid lines.
pub(super) const GRID: RGBColor = RGBColor(228, 231, 235);
/// Free space on a map.
pub(super) const FLOOR: RGBColor = RGBColor(243, 244, 246);
/// Ground that the network covers, as light as text on it needs: the hue of the paper's figures.
pub(super) const COVERED: RGBColor = RGBColor(250, 219, 125);
/// Walls on a map.
pub(super) const WALL: RGBColor = RGBColor(82, 96, 109);
/// Single packets.
pub(super) const RAW: RGBColor = RGBColor(154, 165, 177);
/// The colour of filtered strengths.
pub(super) const FILTERED: RGBColor = SKY;
/// The colour of true strengths.
pub(super) const TRUTH: RGBColor = INK;
/// The place that the rule of a paper chooses.
pub(super) const CHOSEN: RGBColor = GREEN;
/// Limits, in the colour of the links that are below them.
pub(super) const LIMIT: RGBColor = palette::WEAK;

// Okabe & Ito, "Color Universal Design", 2008.
const BLUE: RGBColor = RGBColor(0, 114, 178);
const VERMILION: RGBColor = palette::WEAK;
const GREEN: RGBColor = RGBColor(0, 158, 115);
const PURPLE: RGBColor = RGBColor(204, 121, 167);
const SKY: RGBColor = RGBColor(86, 180, 233);
const ORANGE: RGBColor = RGBColor(230, 159, 0);

/// The variants of a chart, in order.
pub(super) fn category(index: usize) -> RGBColor {
    const ALL: [RGBColor; 6] = [AXIS, ORANGE, BLUE, GREEN, PURPLE, VERMILION];
    ALL.get(index % ALL.len()).copied().unwrap_or(BLUE)
}

/// The colours of robots, which differ from the grey of what all of them share.
pub(super) fn robot(index: usize) -> RGBColor {
    let turn = [2, 5, 3][index % 3];
    category(turn)
}

/// A node's colour, see [`palette`].
pub(super) fn node_colour(node: &Node) -> RGBColor {
    palette::node_shade(node).light
}
