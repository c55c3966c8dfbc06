//! Draws the floor plan with the ways and last places of the drones.

use plotters::element::{Circle, PathElement, Polygon};
use plotters::style::{Color, RGBColor};
use units::{MissionKind, Point2};
use world::FloorPlan;

use super::PictureError;
use super::axes::{filled, stroke};
use super::dashes;
use super::series::launch_limit;
use super::sheet::{Area, Drawn, Fault, Look, Picture, headed, px, size_of, text_width, write};
use super::style::{AXIS, FLOOR, PAPER, WALL, node_colour};
use super::{linked, palette, scale};
use mission::trace::{DroneFrame, Frame, Trace};

/// The picture of a run.
pub(super) fn picture(trace: &Trace) -> Result<Picture, PictureError> {
    let title = format!("Map: {}", trace.scenario);
    Picture::draw((960.0, height_of(trace)), &title, |sheet| {
        let subtitle = match farthest(trace) {
            Some(frame) => format!(
                "Ways flown; rings and links: when the head was farthest, at {} s; dots: at the end",
                frame.time_us / 1_000_000
            ),
            None => "Ways flown; places and links at the end".to_owned(),
        };
        let body = headed(sheet, &title, &subtitle)?;
        drawn(&body, trace, "", true)
    })
}

/// The height of a picture 960 pixels wide whose map has the shape of the floor plan.
pub(super) fn height_of(trace: &Trace) -> f64 {
    let (low, high) = bounds(trace);
    let aspect = (high.y - low.y + 2.0) / (high.x - low.x + 2.0);
    (f64::from(aspect) * 912.0 + 118.0).clamp(260.0, 840.0).round()
}

/// The map without links, as large as the area lets it be.
pub(super) fn panel(area: &Area<'_>, trace: &Trace, title: &str) -> Drawn {
    drawn(area, trace, title, false)
}

fn drawn(area: &Area<'_>, trace: &Trace, title: &str, with_links: bool) -> Drawn {
    write(area, title, (0.0, 10.0), Look::HEADING)?;
    let top = if title.is_empty() { 0.0 } else { 22.0 };
    let view = View::fitting(bounds(trace), size_of(area), top);
    floor(area, &view, &trace.floor_plan)?;
    for index in (0..trace.nodes.len()).rev() {
        trajectory(area, &view, trace, index)?;
    }
    let far = farthest(trace);
    let shown = far.or(trace.frames.last());
    if let Some(frame) = shown.filter(|_| with_links) {
        links(area, &view, trace, frame)?;
    }
    if far.is_some() {
        marks(area, &view, trace, trace.frames.last(), Mark::Dot)?;
    }
    marks(area, &view, trace, shown, if far.is_some() { Mark::Ring } else { Mark::Dot })?;
    names(area, &view, trace, shown)?;
    scale_bar(area, &view)?;
    Ok(Vec::new())
}

/// The scale from metres to pixels, the same both ways, north up.
pub(super) struct View {
    /// Pixels to a metre.
    scale: f64,
    /// Pixel of the point (0, 0).
    origin: (f64, f64),
}

/// Room around the map for labels, in pixels; and below it for the scale bar.
const MARGIN: f64 = 14.0;
const FOOT: f64 = 30.0;

impl View {
    pub(super) fn fitting(
        (low, high): (Point2, Point2),
        (width, height): (f64, f64),
        top: f64,
    ) -> Self {
        let (low, high) = ([low.x, low.y], [high.x, high.y]);
        let span = |i: usize| f64::from(high[i] - low[i]).max(1e-3);
        let (room_x, room_y) = (width - 2.0 * MARGIN, height - top - FOOT - MARGIN);
        let scale = (room_x / span(0)).min(room_y / span(1)).max(1e-6);
        let middle = |i: usize| f64::from(high[i] + low[i]) / 2.0;
        let origin = (
            width / 2.0 - middle(0) * scale,
            top + (height - top - FOOT) / 2.0 + middle(1) * scale,
        );
        Self { scale, origin }
    }

    fn pixel(&self, Point2 { x, y }: Point2) -> (f64, f64) {
        (self.origin.0 + f64::from(x) * self.scale, self.origin.1 - f64::from(y) * self.scale)
    }

    /// The place of a drone, if it is finite.
    pub(super) fn of(&self, drone: &DroneFrame) -> Option<(f64, f64)> {
        drone.pose.at.is_finite().then(|| self.pixel(drone.pose.at))
    }

    fn unit(&self, point: Point2) -> (i32, i32) {
        let (x, y) = self.pixel(point);
        (px(x), px(y))
    }
}

/// The smallest rectangle around everything.
pub(super) fn bounds(trace: &Trace) -> (Point2, Point2) {
    let plan = &trace.floor_plan;
    let fixed = plan.outlines.iter().flatten().copied();
    let lines = plan.centre_lines.iter().flat_map(|line| &line.points).copied();
    let flown = trace.frames.iter().flat_map(|frame| &frame.drones).map(|drone| drone.pose.at);
    fixed
        .chain(lines)
        .chain(flown)
        .filter(|p| p.is_finite())
        .fold(None, |seen: Option<(Point2, Point2)>, p| {
            let (low, high) = seen.unwrap_or((p, p));
            let low = Point2::new(low.x.min(p.x), low.y.min(p.y));
            Some((low, Point2::new(high.x.max(p.x), high.y.max(p.y))))
        })
        .unwrap_or((Point2::default(), Point2::new(1.0, 1.0)))
}

pub(super) fn floor(area: &Area<'_>, view: &View, plan: &FloorPlan) -> Result<(), Fault> {
    for (outline, is_free) in nested(&plan.outlines) {
        let corners: Vec<_> = outline.iter().map(|p| view.unit(*p)).collect();
        let fill = if is_free { FLOOR } else { PAPER };
        area.draw(&Polygon::new(corners.clone(), filled(&fill)))?;
        let closed: Vec<_> = corners.iter().chain(corners.first()).copied().collect();
        area.draw(&PathElement::new(closed, stroke(&WALL, 1.4)))?;
    }
    for line in &plan.centre_lines {
        let centre: Vec<_> = line.points.iter().map(|p| view.pixel(*p)).collect();
        for dash in dashes::cut(&centre, 6.0, 5.0) {
            let dash: Vec<_> = dash.into_iter().map(|(x, y)| (px(x), px(y))).collect();
            area.draw(&PathElement::new(dash, stroke(&AXIS, 0.9)))?;
        }
    }
    Ok(())
}

/// The outlines from the outside in, and whether free space begins within each.
pub(crate) fn nested(outlines: &[Vec<Point2>]) -> Vec<(&[Point2], bool)> {
    let mut all: Vec<(usize, &[Point2])> = outlines
        .iter()
        .enumerate()
        .filter_map(|(own, outline)| {
            let corner = *outline.first()?;
            let others = outlines.iter().enumerate().filter(|(other, _)| *other != own);
            let around = others.filter(|(_, other)| contains(other, corner));
            Some((around.count(), outline.as_slice()))
        })
        .collect();
    all.sort_by_key(|(depth, _)| *depth);
    all.into_iter().map(|(depth, outline)| (outline, depth % 2 == 0)).collect()
}

/// Whether a ray from the point eastwards leaves the outline once more than it enters it.
fn contains(outline: &[Point2], at: Point2) -> bool {
    let edges = outline.iter().zip(outline.iter().cycle().skip(1));
    let crossed = |(a, b): &(&Point2, &Point2)| {
        (a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    edges.filter(crossed).count() % 2 == 1
}

fn trajectory(area: &Area<'_>, view: &View, trace: &Trace, index: usize) -> Result<(), Fault> {
    let Some(node) = trace.nodes.get(index) else { return Ok(()) };
    let mut path: Vec<(i32, i32)> = Vec::new();
    let drones = trace.frames.iter().filter_map(|frame| frame.drones.get(index));
    for at in drones.filter_map(|drone| view.of(drone)).map(|(x, y)| (px(x), px(y))) {
        // Half a pixel: less is hovering, and only makes the file larger.
        let moved = |last: &(i32, i32)| (last.0 - at.0).abs() + (last.1 - at.1).abs() >= 5;
        if path.last().is_none_or(moved) {
            path.push(at);
        }
    }
    let colour = node_colour(node).mix(0.85);
    if path.len() > 1 { area.draw(&PathElement::new(path, stroke(&colour, 1.5))) } else { Ok(()) }
}

/// The shapes that labels should not cover.
struct Obstacles {
    /// Points of walls and ways, in pixels: each costs a little.
    ink: Vec<(f64, f64)>,
    /// Marks and labels, left, top, right, bottom in pixels: each costs a lot.
    taken: Vec<(f64, f64, f64, f64)>,
}

impl Obstacles {
    fn new(view: &View, trace: &Trace) -> Self {
        let closed = trace.floor_plan.outlines.iter().flat_map(|outline| {
            outline.iter().zip(outline.iter().cycle().skip(1)).map(|(a, b)| (*a, *b))
        });
        let walls = closed.flat_map(|(a, b)| between(view.pixel(a), view.pixel(b)));
        let ways = trace.frames.iter().step_by(5).flat_map(|frame| &frame.drones);
        let ways = ways.filter_map(|drone| view.of(drone));
        Self { ink: walls.chain(ways).collect(), taken: Vec::new() }
    }

    fn cost(&self, (left, top, right, bottom): (f64, f64, f64, f64)) -> usize {
        let covers = |(x, y): &&(f64, f64)| left < *x && *x < right && top < *y && *y < bottom;
        let clashes =
            self.taken.iter().filter(|t| left < t.2 && t.0 < right && top < t.3 && t.1 < bottom);
        self.ink.iter().filter(covers).count() + 1000 * clashes.count()
    }
}

/// Points three pixels apart on the way from one to another.
fn between(from: (f64, f64), to: (f64, f64)) -> Vec<(f64, f64)> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let steps = (libm::hypot(dx, dy) / 3.0).clamp(1.0, 2000.0) as usize;
    (0..steps)
        .map(|n| n as f64 / steps as f64)
        .map(|t| (from.0 + dx * t, from.1 + dy * t))
        .collect()
}

/// A head that is so near to its farthest place is there, m: it trembles while it hovers.
const THERE: f32 = 0.1;

/// The moment when a chain's head first was farthest in, if it came back from there by a metre or more:
/// then the end of the mission shows less of the chain than that moment.
pub(super) fn farthest(trace: &Trace) -> Option<&Frame> {
    if trace.mission != MissionKind::Chain {
        return None;
    }
    let way = |frame: &Frame| frame.drones.first().map_or(f32::NAN, |drone| drone.way);
    let most = trace.frames.iter().map(way).fold(f32::NAN, f32::max);
    let far = trace.frames.iter().find(|frame| way(frame) >= most - THERE)?;
    let end = trace.frames.last()?;
    (most - way(end) >= 1.0).then_some(far)
}

/// The mark of a place.
#[derive(Clone, Copy)]
enum Mark {
    Dot,
    Ring,
}

/// The places of all drones at one moment.
fn marks(
    area: &Area<'_>,
    view: &View,
    trace: &Trace,
    frame: Option<&Frame>,
    mark: Mark,
) -> Result<(), Fault> {
    let drones = frame.map_or(&[][..], |frame| &frame.drones);
    for (node, drone) in trace.nodes.iter().zip(drones).rev() {
        let Some((x, y)) = view.of(drone) else { continue };
        let (place, colour) = ((px(x), px(y)), node_colour(node));
        area.draw(&Circle::new(place, px(5.5), filled(&PAPER)))?;
        area.draw(&Circle::new(place, px(4.2), filled(&colour)))?;
        if let Mark::Ring = mark {
            area.draw(&Circle::new(place, px(2.2), filled(&PAPER)))?;
        }
    }
    Ok(())
}

/// Writes the names of all drones, each where it hides least.
fn names(area: &Area<'_>, view: &View, trace: &Trace, frame: Option<&Frame>) -> Result<(), Fault> {
    let drones = frame.map_or(&[][..], |frame| &frame.drones);
    let mut obstacles = Obstacles::new(view, trace);
    let places = drones.iter().filter_map(|drone| view.of(drone));
    obstacles.taken.extend(places.map(|(x, y)| (x - 5.0, y - 5.0, x + 5.0, y + 5.0)));
    for (node, drone) in trace.nodes.iter().zip(drones) {
        if let Some(place) = view.of(drone) {
            label(area, &node.to_string(), place, node_colour(node), &mut obstacles)?;
        }
    }
    Ok(())
}

fn label(
    area: &Area<'_>,
    name: &str,
    (x, y): (f64, f64),
    colour: RGBColor,
    obstacles: &mut Obstacles,
) -> Result<(), Fault> {
    let look = Look { bold: true, ..Look::LABEL.centred().coloured(colour) };
    let half = text_width(name, look) / 2.0;
    let (width, height) = size_of(area);
    let boxed = |(cx, cy): (f64, f64)| (cx - half - 2.0, cy - 9.0, cx + half + 2.0, cy + 9.0);
    let around = [14.0, 24.0, 34.0, 46.0, 58.0].into_iter().flat_map(|far| {
        let beside = half + far - 6.0;
        [(0.0, -far), (0.0, far), (beside, 0.0), (-beside, 0.0), (beside, -far), (-beside, -far)]
    });
    let inside = |(cx, cy): &(f64, f64)| {
        cx - half > 0.0 && cy - 7.0 > 0.0 && cx + half < width && cy + 7.0 < height
    };
    let best = around
        .map(|(dx, dy)| (x + dx, y + dy))
        .filter(inside)
        .min_by_key(|centre| obstacles.cost(boxed(*centre)))
        .unwrap_or((x, y - 14.0));
    obstacles.taken.push(boxed(best));
    write(area, name, best, look)
}

/// Draws the scale bar and the arrow to the north at the foot of the map.
pub(super) fn scale_bar(area: &Area<'_>, view: &View) -> Result<(), Fault> {
    let (width, height) = size_of(area);
    scale::bar_and_north(area, (MARGIN, height - 10.0), view.scale, width / 9.0)
}

/// The links of one moment, each in the colour of its strength, with the key to the colours.
fn links(area: &Area<'_>, view: &View, trace: &Trace, frame: &Frame) -> Result<(), Fault> {
    let all = linked::links_at(trace, frame);
    let limit = launch_limit(trace);
    for link in &all {
        let places = link.ends.map(|end| frame.drones.get(end).and_then(|drone| view.of(drone)));
        let [Some(one), Some(other)] = places else { continue };
        let line = [one, other].map(|(x, y)| (px(x), px(y))).to_vec();
        let colour = palette::link_colour(link.dbm, limit);
        area.draw(&PathElement::new(line, stroke(&colour, 2.8)))?;
    }
    if all.is_empty() { Ok(()) } else { linked::key(area, limit) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pillars_are_told_from_boundaries() {
        let square =
            |r: f32| [[-r, -r], [r, -r], [r, r], [-r, r]].map(|[x, y]| Point2::new(x, y)).to_vec();
        let outlines = [square(1.0), square(5.0), square(3.0)];
        let found: Vec<_> = nested(&outlines).iter().map(|(o, free)| (o[2].x, *free)).collect();
        assert_eq!(found, [(5.0, true), (3.0, false), (1.0, true)]);
    }

    #[test]
    fn a_head_that_came_back_is_shown_where_it_was_farthest() {
        let mut trace = crate::synthetic::mission();
        assert_eq!(farthest(&trace), None);
        let far = trace.frames[1200].clone();
        trace.frames.push(trace.frames[100].clone());
        let shown = farthest(&trace).unwrap();
        assert!(shown.drones[0].way >= far.drones[0].way - THERE, "{}", shown.drones[0].way);
        assert!(shown.time_us < far.time_us, "not the last moment of a hover, but the first");
        trace.mission = MissionKind::Swarm;
        assert_eq!(farthest(&trace), None, "a swarm has no head");
    }
}
