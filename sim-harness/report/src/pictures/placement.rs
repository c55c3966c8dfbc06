//! Draws the figures of the paper on placing communication nodes again: figures 2 and 3 on one page, and
//! figure 4, four situations of a goal with the place that the paper's rule chooses.

use grid_map::Cell;
use plotters::element::{Circle, PathElement, Rectangle};
use plotters::style::RGBColor;
use units::Point2;

use super::PictureError;
use super::axes::{filled, stroke};
use super::sheet::{Area, Drawn, Fault, Look, Picture, headed, part, px, size_of, upx, write};
use super::style::{AXIS, CHOSEN, COVERED, FLOOR, INK, LIMIT, PAPER, WALL, category};
use planning::situations::{Cave, Scene, Situation};
use relay_placement::Demand;

/// The side of a map, the gap between two, and the height of their headings, in pixels.
const SIDE: f64 = 400.0;
const GAP: f64 = 28.0;
/// What is left free around a map, so that no mark at its edge is cut, in pixels.
const MARGIN: f64 = 8.0;
const HEADING: f64 = 40.0;
/// The height of the key below the maps.
const KEY: f64 = 34.0;
/// Half of the side of what is shown around a goal, m: what a relay in any drop cell covers.
const AROUND_M: f32 = 33.0;
/// The radii of the marks of goal and place, in pixels.
const MARK: f64 = 5.5;

/// What the cells of a map show.
#[derive(Clone, Copy, PartialEq)]
enum Cells {
    /// Which of them a robot can cross.
    Traversable,
    /// Which of them the network covers.
    Coverage,
    /// How far each is from the nearest wall.
    Distance,
}

/// Figures 2 and 3: the maps of a cave that the rule is given, and what it chooses.
pub(super) fn maps(scene: &Scene) -> Result<Picture, PictureError> {
    let title = "Placing communication nodes, figures 2 and 3 again";
    let subtitle = format!(
        "Cave {}, dug from its seed, 100 by 100 m in cells of 0.5 m; all of it is known, so no cell is \
         drawn as unknown",
        scene.cave.seed
    );
    sheet(title, &subtitle, |body| {
        let panels = [
            (
                "Figure 2, above: traversability",
                "dark: obstacle; light: traversable",
                Cells::Traversable,
                false,
            ),
            (
                "Figure 2, below left: communication",
                "yellow: the network is heard with 37 dB or more",
                Cells::Coverage,
                false,
            ),
            (
                "Figure 2, below right: distance transform",
                "brighter: farther from the nearest wall",
                Cells::Distance,
                false,
            ),
            (
                "Figure 3, above: query, place",
                "the place p* that the rule takes",
                Cells::Coverage,
                true,
            ),
        ];
        for (n, (name, below, cells, is_chosen)) in panels.into_iter().enumerate() {
            let area = panel(body, n, name, below)?;
            let view = View::whole(&scene.cave);
            draw_cells(&area, &view, &scene.cave, cells)?;
            if is_chosen {
                choice(&area, &view, scene)?;
            }
            base(&area, &view, &scene.cave)?;
            scale_bar(&area, &view, 20.0)?;
        }
        Ok(())
    })
}

/// Figure 4: the four situations.
pub(super) fn situations(scenes: &[Scene]) -> Result<Picture, PictureError> {
    let title = "Placing communication nodes, figure 4 again";
    let subtitle =
        "The first cave of each situation, from the farthest goal to the nearest; north is up";
    sheet(title, subtitle, |body| {
        for (n, scene) in scenes.iter().enumerate() {
            let trial = &scene.trial;
            let name = match trial.situation {
                Situation::Far => "Far from all that is covered",
                Situation::Transition => "At the transition",
                Situation::Inside => "Inside what is covered",
                Situation::Covered => "Nearly all is covered",
            };
            let below = format!(
                "cave {}: {:.1} m from p0, {:.0} m\u{b2} new, link {}",
                scene.cave.seed,
                trial.paper.off_goal_m,
                trial.paper.gain_m2,
                format!("{:+.1} dB", trial.paper.margin_db).replace('-', "\u{2212}"),
            );
            let area = panel(body, n, name, &below)?;
            let view = View::around(&scene.cave, trial.goal.cell);
            draw_cells(&area, &view, &scene.cave, Cells::Coverage)?;
            choice(&area, &view, scene)?;
            base(&area, &view, &scene.cave)?;
            scale_bar(&area, &view, 10.0)?;
        }
        Ok(())
    })
}

/// A page of four maps with the key below.
fn sheet(
    title: &str,
    subtitle: &str,
    maps: impl FnOnce(&Area<'_>) -> Result<(), Fault>,
) -> Result<Picture, PictureError> {
    let size = (2.0 * (SIDE + MARGIN) + GAP + 48.0, 78.0 + 2.0 * (SIDE + HEADING) + GAP + KEY);
    Picture::draw(size, title, |sheet| -> Drawn {
        let body = headed(sheet, title, subtitle)?;
        maps(&body)?;
        let (width, height) = size_of(&body);
        key(&part(&body, (0.0, height - KEY), (width, KEY)))?;
        Ok(Vec::new())
    })
}

/// The n-th of the four maps, with its heading above it.
fn panel<'a>(body: &Area<'a>, n: usize, name: &str, below: &str) -> Result<Area<'a>, Fault> {
    let left = (SIDE + GAP) * (n % 2) as f64;
    let top = (SIDE + HEADING + GAP) * (n / 2) as f64;
    write(body, name, (left + MARGIN, top + 10.0), Look::HEADING)?;
    write(body, below, (left + MARGIN, top + 26.0), Look::LABEL)?;
    let side = SIDE + 2.0 * MARGIN;
    Ok(part(body, (left, top + HEADING - MARGIN), (side, side)))
}

/// A square of a cave on a map, north up.
struct View {
    /// The cell in the lower left corner, which may be outside the cave, and the cells along each side.
    corner: [i32; 2],
    cells: i32,
    /// The side of a cell, m, and in pixels: whole ones, so that no seam shows between cells.
    metres: f64,
    scale: f64,
}

impl View {
    fn whole(cave: &Cave) -> Self {
        let frame = cave.ground.frame();
        let cells = i32::from(frame.columns().max(frame.rows()));
        let scale = (SIDE / f64::from(cells)).floor().max(1.0);
        Self { corner: [0, 0], cells, metres: f64::from(frame.resolution().0), scale }
    }

    fn around(cave: &Cave, goal: Cell) -> Self {
        let metres = cave.ground.frame().resolution().0;
        let half = (AROUND_M / metres) as i32;
        let corner = [i32::from(goal.column) - half, i32::from(goal.row) - half];
        let cells = 2 * half + 1;
        let scale = (SIDE / f64::from(cells)).floor().max(1.0);
        Self { corner, cells, metres: f64::from(metres), scale }
    }

    /// The side of the map, in pixels.
    fn side(&self) -> f64 {
        self.scale * f64::from(self.cells)
    }

    /// The pixel of a point of the cave.
    fn pixel(&self, at: Point2) -> (f64, f64) {
        let cells = |metres: f32| f64::from(metres) / self.metres;
        let [west, south] = self.corner.map(f64::from);
        let north = f64::from(self.cells) - (cells(at.y) - south);
        (MARGIN + self.scale * (cells(at.x) - west), MARGIN + self.scale * north)
    }

    fn shows(&self, (x, y): (f64, f64)) -> bool {
        [x, y].iter().all(|v| (MARGIN..=MARGIN + self.side()).contains(v))
    }
}

/// The cells of a map, those of one colour beside each other in a row as one rectangle.
fn draw_cells(area: &Area<'_>, view: &View, cave: &Cave, cells: Cells) -> Result<(), Fault> {
    let at = |n: i32| px(MARGIN + view.scale * f64::from(n));
    for n in 0..view.cells {
        let row = view.corner[1] + view.cells - 1 - n;
        let colour = |column: i32| colour(cave, view.corner[0] + column, row, cells);
        let mut first = 0;
        for column in 1..=view.cells {
            if column < view.cells && colour(column) == colour(first) {
                continue;
            }
            let corners = [(at(first), at(n)), (at(column), at(n + 1))];
            area.draw(&Rectangle::new(corners, filled(&colour(first))))?;
            first = column;
        }
    }
    Ok(())
}

fn colour(cave: &Cave, column: i32, row: i32, cells: Cells) -> RGBColor {
    let cell = u16::try_from(column).ok().zip(u16::try_from(row).ok());
    let cell = cell.map(|(column, row)| Cell::new(column, row));
    let Some(cell) = cell.filter(|cell| cave.ground.is_reached(*cell)) else { return WALL };
    match cells {
        Cells::Traversable => FLOOR,
        Cells::Coverage if cave.network.covers(cell) => COVERED,
        Cells::Coverage => FLOOR,
        Cells::Distance => {
            // Six metres from a wall is white: few caves have a wider place.
            let share = (cave.ground.clearance(cell).0 / 6.0).clamp(0.0, 1.0);
            let level = (100.0 + 155.0 * share) as u8;
            RGBColor(level, level, level)
        }
    }
}

/// The goal with the circle of the drop cells, the front, and the place.
fn choice(area: &Area<'_>, view: &View, scene: &Scene) -> Result<(), Fault> {
    let frame = *scene.cave.ground.frame();
    let centre = |cell: Cell| view.pixel(frame.centre(cell));
    for scored in scene.criteria.cells.iter().filter(|scored| scored.is_on_front) {
        let (x, y) = centre(scored.cell);
        area.draw(&Circle::new((px(x), px(y)), upx(2.0), filled(&category(4))))?;
    }
    let (x, y) = centre(scene.trial.goal.cell);
    ring(area, (x, y), f64::from(Demand::DEFAULT.within.0) / view.metres * view.scale)?;
    mark(area, (x, y), LIMIT)?;
    mark(area, centre(scene.trial.paper.cell), CHOSEN)
}

/// The circle of the drop cells.
fn ring(area: &Area<'_>, (x, y): (f64, f64), radius: f64) -> Result<(), Fault> {
    let corner = |n: i32| {
        let (sin, cos) = (f64::from(n) * std::f64::consts::TAU / 90.0).sin_cos();
        (px(x + radius * cos), px(y + radius * sin))
    };
    let points: Vec<_> = (0..=90).map(corner).collect();
    area.draw(&PathElement::new(points, stroke(&category(2), 1.6)))
}

fn mark(area: &Area<'_>, (x, y): (f64, f64), colour: RGBColor) -> Result<(), Fault> {
    area.draw(&Circle::new((px(x), px(y)), upx(MARK + 1.2), filled(&PAPER)))?;
    area.draw(&Circle::new((px(x), px(y)), upx(MARK), filled(&colour)))
}

/// The base, where the map shows it.
fn base(area: &Area<'_>, view: &View, cave: &Cave) -> Result<(), Fault> {
    let at = view.pixel(cave.ground.frame().centre(cave.world.base));
    if view.shows(at) { square(area, at, INK) } else { Ok(()) }
}

fn square(area: &Area<'_>, (x, y): (f64, f64), colour: RGBColor) -> Result<(), Fault> {
    let corner = |off: f64| (px(x + off), px(y + off));
    area.draw(&Rectangle::new([corner(-MARK - 1.0), corner(MARK + 1.0)], filled(&PAPER)))?;
    area.draw(&Rectangle::new([corner(-MARK), corner(MARK)], filled(&colour)))
}

fn scale_bar(area: &Area<'_>, view: &View, metres: f64) -> Result<(), Fault> {
    let (left, y) = (MARGIN + 10.0, MARGIN + view.side() - 12.0);
    let right = left + metres / view.metres * view.scale;
    let ground = [(px(left - 6.0), px(y - 10.0)), (px(right + 44.0), px(y + 8.0))];
    area.draw(&Rectangle::new(ground, filled(&PAPER)))?;
    let bar = [(left, y - 4.0), (left, y), (right, y), (right, y - 4.0)];
    let bar: Vec<_> = bar.into_iter().map(|(x, y)| (px(x), px(y))).collect();
    area.draw(&PathElement::new(bar, stroke(&INK, 1.0)))?;
    write(area, &format!("{metres:.0} m"), (right + 8.0, y - 2.0), Look::LABEL)
}

/// What the colours and marks mean.
fn key(area: &Area<'_>) -> Result<(), Fault> {
    let y = KEY - 12.0;
    let mut x = MARGIN;
    let entries: [(&str, f64); 7] = [
        ("wall", 62.0),
        ("covered", 84.0),
        ("not covered", 106.0),
        ("base", 66.0),
        ("query p0, within 10 m", 172.0),
        ("Pareto front", 112.0),
        ("place p* of the paper's rule", 0.0),
    ];
    for (n, (name, width)) in entries.into_iter().enumerate() {
        let at = (x + 7.0, y);
        match n {
            0..=2 => swatch(area, at, [WALL, COVERED, FLOOR][n])?,
            3 => square(area, at, INK)?,
            4 => {
                ring(area, at, 8.0)?;
                mark(area, at, LIMIT)?;
            }
            5 => area.draw(&Circle::new((px(at.0), px(at.1)), upx(2.5), filled(&category(4))))?,
            _ => mark(area, at, CHOSEN)?,
        }
        write(area, name, (x + 20.0, y), Look::LABEL)?;
        x += width;
    }
    Ok(())
}

fn swatch(area: &Area<'_>, (x, y): (f64, f64), colour: RGBColor) -> Result<(), Fault> {
    let corners = [(px(x - 7.0), px(y - 6.0)), (px(x + 7.0), px(y + 6.0))];
    area.draw(&Rectangle::new(corners, filled(&colour)))?;
    let [(l, t), (r, b)] = corners;
    let outline = vec![(l, t), (r, t), (r, b), (l, b), (l, t)];
    area.draw(&PathElement::new(outline, stroke(&AXIS, 0.8)))
}
