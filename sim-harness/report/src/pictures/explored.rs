//! Draws what robots that explore know of a room, and where they fly: the thesis' figures 3.14, 3.16 and
//! 3.17.

use grid_map::{Cell, CellState, Frame};
use plotters::element::{Circle, PathElement, Rectangle};
use plotters::style::RGBColor;
use units::Point2;

use super::PictureError;
use super::axes::{filled, stroke};
use super::scale::{LONGEST, bar_and_north};
use super::sheet::{Area, Drawn, Fault, Look, Picture, headed, part, px, upx, write};
use super::style::{self, AXIS, FLOOR, INK, PAPER, WALL};

/// The side of a map, the gap between two, the height of their headings and of the key, in pixels.
const SIDE: f64 = 240.0;
const GAP: f64 = 22.0;
const HEADING: f64 = 44.0;
const KEY: f64 = 58.0;
/// The height of the key's first line, in pixels; below it is the scale bar.
const KEY_LINE: f64 = 30.0;
/// The radius of a mark, in pixels.
const MARK: f64 = 5.0;
/// The largest radius of a candidate, in pixels: one with unknown cells all around.
const CANDIDATE: f64 = 4.5;
/// The unknown cells around a candidate at the most.
const MOST_GAIN: f32 = 48.0;
/// What is not known, between the colours of floor and wall.
const UNKNOWN: RGBColor = RGBColor(203, 210, 217);

/// A page of maps of one room.
#[derive(Clone, Debug)]
pub struct ExploredChart {
    /// The title of the picture.
    pub title: String,
    /// One line below it.
    pub subtitle: String,
    /// Maps beside each other.
    pub columns: usize,
    /// The maps, row by row.
    pub maps: Vec<ExploredMap>,
}

/// One map.
#[derive(Clone, Debug)]
pub struct ExploredMap {
    /// What stands above it.
    pub name: String,
    /// One line below that.
    pub about: String,
    /// Where the cells lie.
    pub frame: Frame,
    /// What is known of each, in the order of the frame.
    pub cells: Vec<CellState>,
    /// The way of each robot, with its number.
    pub ways: Vec<(usize, Vec<Point2>)>,
    /// Candidates, with the unknown cells around each.
    pub candidates: Vec<(Point2, f32)>,
    /// Targets, with the number of the robot.
    pub targets: Vec<(usize, Point2)>,
}

/// The picture of its own.
pub(super) fn picture(chart: &ExploredChart) -> Result<Picture, PictureError> {
    let columns = chart.columns.max(1);
    let rows = chart.maps.len().div_ceil(columns);
    let width = (SIDE + GAP) * columns as f64 + 48.0;
    let size = (width.max(760.0), 78.0 + (SIDE + HEADING + GAP) * rows as f64 + KEY);
    Picture::draw(size, &chart.title, |sheet| -> Drawn {
        let body = headed(sheet, &chart.title, &chart.subtitle)?;
        for (n, map) in chart.maps.iter().enumerate() {
            let left = (SIDE + GAP) * (n % columns) as f64;
            let top = (SIDE + HEADING + GAP) * (n / columns) as f64;
            write(&body, &map.name, (left, top + 10.0), Look::HEADING)?;
            write(&body, &map.about, (left, top + 27.0), Look::LABEL)?;
            draw(&part(&body, (left, top + HEADING), (SIDE, SIDE)), map)?;
        }
        let top = (SIDE + HEADING + GAP) * rows as f64 - 6.0;
        key(&part(&body, (0.0, top), (width - 48.0, KEY)), chart)?;
        Ok(Vec::new())
    })
}

/// The pixel of a point of the room.
fn pixel(map: &ExploredMap, at: Point2) -> (f64, f64) {
    let (origin, side) = (map.frame.origin(), f64::from(map.frame.resolution().0));
    let scale = scale(map);
    let cells = |metres: f32| f64::from(metres) / side;
    let north = f64::from(map.frame.rows()) - cells(at.y - origin.y);
    (scale * cells(at.x - origin.x), scale * north)
}

/// The pixels of a cell's side: whole ones, so that no seam shows between cells.
fn scale(map: &ExploredMap) -> f64 {
    (SIDE / f64::from(map.frame.columns().max(map.frame.rows()))).floor().max(1.0)
}

fn draw(area: &Area<'_>, map: &ExploredMap) -> Result<(), Fault> {
    cells(area, map)?;
    for (robot, way) in &map.ways {
        let points: Vec<_> = way.iter().map(|at| pixel(map, *at)).collect();
        let line: Vec<_> = points.iter().map(|(x, y)| (px(*x), px(*y))).collect();
        area.draw(&PathElement::new(line, stroke(&style::robot(*robot), 1.8)))?;
        if let (Some(first), Some(last)) = (points.first(), points.last()) {
            area.draw(&Circle::new((px(first.0), px(first.1)), upx(3.5), filled(&PAPER)))?;
            area.draw(&Circle::new(
                (px(first.0), px(first.1)),
                upx(2.5),
                filled(&style::robot(*robot)),
            ))?;
            mark(area, *last, *robot)?;
        }
    }
    for (at, gain) in &map.candidates {
        let (x, y) = pixel(map, *at);
        let radius = 1.2 + CANDIDATE * f64::from(gain / MOST_GAIN).sqrt();
        area.draw(&Circle::new((px(x), px(y)), upx(radius), stroke(&INK, 0.9)))?;
    }
    // Two targets at one place show as two rings.
    for (n, (robot, at)) in map.targets.iter().enumerate() {
        let (x, y) = pixel(map, *at);
        let radius = 7.0 + 4.0 * n as f64;
        area.draw(&Circle::new((px(x), px(y)), upx(radius), stroke(&style::robot(*robot), 2.4)))?;
    }
    Ok(())
}

/// The cells, those of one colour beside each other in a row as one rectangle.
fn cells(area: &Area<'_>, map: &ExploredMap) -> Result<(), Fault> {
    let (frame, scale) = (&map.frame, scale(map));
    let shade = |column: u16, row: u16| {
        let state = map.cells.get(frame.number(Cell::new(column, row))).copied();
        match state.unwrap_or_default() {
            CellState::Unknown => UNKNOWN,
            CellState::Free => FLOOR,
            CellState::Occupied => WALL,
        }
    };
    for row in 0..frame.rows() {
        let top = scale * f64::from(frame.rows() - 1 - row);
        let mut first = 0;
        for column in 1..=frame.columns() {
            if column < frame.columns() && shade(column, row) == shade(first, row) {
                continue;
            }
            let at = |n: u16| px(scale * f64::from(n));
            let corners = [(at(first), px(top)), (at(column), px(top + scale))];
            area.draw(&Rectangle::new(corners, filled(&shade(first, row))))?;
            first = column;
        }
    }
    Ok(())
}

fn mark(area: &Area<'_>, (x, y): (f64, f64), robot: usize) -> Result<(), Fault> {
    area.draw(&Circle::new((px(x), px(y)), upx(MARK + 1.2), filled(&PAPER)))?;
    area.draw(&Circle::new((px(x), px(y)), upx(MARK), filled(&style::robot(robot))))
}

/// What the colours and marks that are on the page mean.
fn key(area: &Area<'_>, chart: &ExploredChart) -> Result<(), Fault> {
    if let Some(map) = chart.maps.first() {
        let metres = f64::from(map.frame.resolution().0);
        bar_and_north(area, (0.0, KEY - 6.0), scale(map) / metres, LONGEST)?;
    }
    let y = KEY_LINE - 12.0;
    let mut x = 0.0;
    for (name, shade, width) in
        [("free", FLOOR, 56.0), ("unknown", UNKNOWN, 84.0), ("wall", WALL, 58.0)]
    {
        let corners = [(px(x), px(y - 6.0)), (px(x + 14.0), px(y + 6.0))];
        area.draw(&Rectangle::new(corners, filled(&shade)))?;
        let [(l, t), (r, b)] = corners;
        let outline = vec![(l, t), (r, t), (r, b), (l, b), (l, t)];
        area.draw(&PathElement::new(outline, stroke(&AXIS, 0.8)))?;
        write(area, name, (x + 20.0, y), Look::LABEL)?;
        x += width + 6.0;
    }
    let ways = chart.maps.iter().flat_map(|map| &map.ways).map(|(robot, _)| *robot);
    for robot in 0..ways.max().map_or(0, |most| most + 1) {
        mark(area, (x + 6.0, y), robot)?;
        write(area, &format!("robot {}", robot + 1), (x + 18.0, y), Look::LABEL)?;
        x += 78.0;
    }
    if chart.maps.iter().any(|map| !map.candidates.is_empty()) {
        area.draw(&Circle::new((px(x + 6.0), px(y)), upx(4.0), stroke(&INK, 0.9)))?;
        let words = "candidate, larger with more unknown cells around it";
        write(area, words, (x + 18.0, y), Look::LABEL)?;
        x += 330.0;
        area.draw(&Circle::new((px(x + 8.0), px(y)), upx(7.0), stroke(&style::robot(0), 2.4)))?;
        write(area, "target of that robot", (x + 22.0, y), Look::LABEL)?;
    } else {
        write(area, "small: start; large: where it is at that time", (x, y), Look::LABEL)?;
    }
    Ok(())
}
