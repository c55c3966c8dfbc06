//! Draws the coverage of a map before and after relays are put down.

use cave_worlds::World;
use grid_map::{Cell, Frame};
use input::counted;
use plotters::element::{Circle, Rectangle};
use plotters::style::RGBColor;
use units::Point2;

use super::axes::{filled, stroke};
use super::sheet::{Area, Fault, Look, Picture, headed, px, size_of, text_width, upx, write};
use super::style::{AXIS, FLOOR, INK, PAPER, WALL, category};
use super::{PictureError, scale};
use planning::drops::{Drops, Shown};

/// The size of the picture, in pixels: two panels side by side.
const SIZE: (f64, f64) = (1200.0, 700.0);
/// The gap between the panels, and the height of their headings, in pixels.
const GAP: f64 = 24.0;
const HEADING: f64 = 24.0;
/// The height of the foot with scale bar and key, in pixels.
const FOOT: f64 = 34.0;
/// The radius of the mark of a relay, in pixels.
const MARK: f64 = 8.0;

/// The picture of a plan of drops.
pub(super) fn picture(world: &World, drops: &Drops) -> Result<Picture, PictureError> {
    let title = format!("Drops: {}", world.name);
    let relays = counted(drops.places.len(), "relay");
    Picture::draw(SIZE, &title, |sheet| {
        let subtitle = format!("Coverage of the base, and with {relays} on the ground");
        let body = headed(sheet, &title, &subtitle)?;
        for (left, is_after) in [(true, false), (false, true)] {
            panel(&body, left, world, drops, is_after)?;
        }
        foot(&body, world)?;
        Ok(Vec::new())
    })
}

/// The scale bar with the arrow to the north, and what colours and marks mean.
fn foot(area: &Area<'_>, world: &World) -> Result<(), Fault> {
    let (_, height) = size_of(area);
    let frame = world.map.frame();
    let view = View::fitting(frame, 0.0, panel_size(area));
    let y = height - 8.0;
    scale::bar_and_north(
        area,
        (0.0, y),
        view.scale / f64::from(frame.resolution().0),
        scale::LONGEST,
    )?;
    let entries = [
        ("wall", Shown::Wall),
        ("out of reach", Shown::OutOfReach),
        ("not covered", Shown::Uncovered),
        ("covered by the base", Shown::CoveredByBase),
        ("covered by relays", Shown::CoveredByRelays),
    ];
    let breadth = |words: &str| 20.0 + text_width(words, Look::LABEL) + 14.0;
    let mut x = 190.0;
    for (words, shown) in entries {
        let corners = [(px(x), px(y - 10.0)), (px(x + 14.0), px(y + 2.0))];
        area.draw(&Rectangle::new(corners, filled(&colour(shown, true))))?;
        area.draw(&Rectangle::new(corners, stroke(&AXIS, 0.8)))?;
        write(area, words, (x + 20.0, y - 4.0), Look::LABEL)?;
        x += breadth(words);
    }
    let corner = |off: f64| (px(x + 7.0 + off), px(y - 4.0 + off));
    area.draw(&Rectangle::new([corner(-MARK / 2.0), corner(MARK / 2.0)], filled(&INK)))?;
    write(area, "base", (x + 20.0, y - 4.0), Look::LABEL)?;
    x += breadth("base");
    area.draw(&Circle::new((px(x + 7.0), px(y - 4.0)), upx(MARK), filled(&INK)))?;
    let words = "relay, in the order in which they are put down";
    write(area, words, (x + 20.0, y - 4.0), Look::LABEL)
}

/// The width and the height of the place of one map, in pixels.
fn panel_size(area: &Area<'_>) -> (f64, f64) {
    let (width, height) = size_of(area);
    ((width - GAP) / 2.0, height - HEADING - FOOT)
}

/// One map, in the left or the right half.
fn panel(
    area: &Area<'_>,
    is_left: bool,
    world: &World,
    drops: &Drops,
    is_after: bool,
) -> Result<(), Fault> {
    let size = panel_size(area);
    let half = size.0;
    let left = if is_left { 0.0 } else { half + GAP };
    let network = if is_after { &drops.after } else { &drops.before };
    let covered = drops.square_metres(network.covered(&drops.ground));
    let when = if is_after { "After" } else { "Before" };
    write(area, &format!("{when}: {covered:.0} m² covered"), (left, 10.0), Look::HEADING)?;
    let view = View::fitting(world.map.frame(), left, size);
    for row in 0..world.map.frame().rows() {
        cells_of_row(area, &view, world, drops, is_after, row)?;
    }
    let frame = world.map.frame();
    let (x, y) = view.pixel(frame, frame.centre(world.base));
    let corner = |off: f64| (px(x + off), px(y + off));
    area.draw(&Rectangle::new([corner(-MARK / 2.0), corner(MARK / 2.0)], filled(&INK)))?;
    if !is_after {
        return Ok(());
    }
    for (n, place) in drops.places.iter().enumerate() {
        let (x, y) = view.pixel(frame, place.at);
        area.draw(&Circle::new((px(x), px(y)), upx(MARK), filled(&INK)))?;
        let look = Look::LABEL.centred().coloured(PAPER);
        write(area, &(n + 1).to_string(), (x, y), look)?;
    }
    Ok(())
}

/// The cells of a row, those of one colour beside each other as one rectangle.
fn cells_of_row(
    area: &Area<'_>,
    view: &View,
    world: &World,
    drops: &Drops,
    is_after: bool,
    row: u16,
) -> Result<(), Fault> {
    let columns = world.map.frame().columns();
    let colour = |column| colour(drops.shown(world, Cell::new(column, row)), is_after);
    let mut first = 0;
    for column in 1..=columns {
        if column < columns && colour(column) == colour(first) {
            continue;
        }
        let corners = view.corners(world.map.frame(), row, first, column);
        area.draw(&Rectangle::new(corners, filled(&colour(first))))?;
        first = column;
    }
    Ok(())
}

fn colour(shown: Shown, is_after: bool) -> RGBColor {
    match shown {
        Shown::Wall => WALL,
        Shown::OutOfReach => PAPER,
        Shown::CoveredByBase => category(2),
        Shown::CoveredByRelays if is_after => category(3),
        Shown::CoveredByRelays | Shown::Uncovered => FLOOR,
    }
}

/// The scale from cells to pixels, the same both ways, north up.
struct View {
    left: f64,
    top: f64,
    /// Pixels to a cell.
    scale: f64,
}

impl View {
    fn fitting(frame: &Frame, left: f64, (width, height): (f64, f64)) -> Self {
        let scale = (width / f64::from(frame.columns())).min(height / f64::from(frame.rows()));
        Self { left, top: HEADING, scale }
    }

    fn pixel(&self, frame: &Frame, at: Point2) -> (f64, f64) {
        let cells = |metres: f32| f64::from(metres / frame.resolution().0);
        let north = f64::from(frame.rows()) - cells(at.y - frame.origin().y);
        let east = cells(at.x - frame.origin().x);
        (self.left + self.scale * east, self.top + self.scale * north)
    }

    /// The corners of the cells of a row from the column `first` to before `end`.
    fn corners(&self, frame: &Frame, row: u16, first: u16, end: u16) -> [(i32, i32); 2] {
        let x = |column: u16| px(self.left + self.scale * f64::from(column));
        let y = |row: u16| px(self.top + self.scale * f64::from(frame.rows() - row));
        [(x(first), y(row + 1)), (x(end), y(row))]
    }
}
