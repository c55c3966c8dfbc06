//! Colours and sizes: the one place where the look of every picture is decided.

use plotters::style::RGBColor;
use units::Role;

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
/// A link that is well above the limit.
pub(super) const STRONG: RGBColor = GREEN;
/// A link that is little above the limit.
pub(super) const FAIR: RGBColor = ORANGE;
/// Limits, and links that are below it.
pub(super) const LIMIT: RGBColor = VERMILION;

// Okabe & Ito, "Color Universal Design", 2008.
const BLUE: RGBColor = RGBColor(0, 114, 178);
const VERMILION: RGBColor = RGBColor(213, 94, 0);
const GREEN: RGBColor = RGBColor(0, 158, 115);
const PURPLE: RGBColor = RGBColor(204, 121, 167);
const SKY: RGBColor = RGBColor(86, 180, 233);
const ORANGE: RGBColor = RGBColor(230, 159, 0);

/// Relays by their numbers: after those of Okabe and Ito, shades of Paul Tol's "muted" scheme, so that
/// no two of fifteen are alike.
const RELAYS: [RGBColor; 15] = [
    BLUE,
    GREEN,
    PURPLE,
    SKY,
    ORANGE,
    RGBColor(136, 34, 85),
    RGBColor(68, 170, 153),
    RGBColor(153, 153, 51),
    RGBColor(85, 68, 170),
    RGBColor(170, 68, 153),
    RGBColor(17, 119, 51),
    RGBColor(221, 204, 119),
    RGBColor(136, 68, 34),
    RGBColor(102, 153, 204),
    RGBColor(136, 136, 136),
];

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

/// A node's colour: the head stands out, the base stays back, and relays that follow each other
/// differ.
pub(super) fn node_colour(node: &Node) -> RGBColor {
    match node.role {
        Role::Head => VERMILION,
        Role::Base => WALL,
        Role::Relay => {
            let turn = usize::from(node.id.0.saturating_sub(1)) % RELAYS.len();
            RELAYS.get(turn).copied().unwrap_or(BLUE)
        }
    }
}

/// A node's colour as red, green and blue.
pub(crate) fn node_rgb(node: &Node) -> [u8; 3] {
    let RGBColor(r, g, b) = node_colour(node);
    [r, g, b]
}
