//! Draws a mission as one moving picture: an SVG whose parts are moved by SMIL, without a script, so
//! that it also moves where a page shows it as an image.
//!
//! Its still attributes are those of the moment at which the head was farthest, for programs that
//! show no motion.

use std::fmt::Write;

use plotters::style::RGBColor;
use units::{MissionKind, NodeId, Role};

use super::PictureError;
use super::linked::key;
use super::map::{View, bounds, farthest, floor, height_of, scale_bar};
use super::palette::{SPARE_DB, WEAK_DBM, hex, link_colour};
use super::series::{launch_limit, thinned};
use super::sheet::{Picture, escaped, headed, part, px, size_of};
use super::style::{AXIS, INK, PAPER, QUIET};
use mission::trace::{DroneFrame, Frame, Node, Trace, order_words};

/// Width of the picture in pixels, and height of the line of time below the map.
const WIDTH: f64 = 860.0;
const TIMELINE: f64 = 40.0;
/// Moments that are drawn at most; the motion between two is straight.
const MOST_MOMENTS: usize = 240;
/// The last moment is shown for so many moments more, before the mission begins anew.
const REST: usize = 16;
/// The picture ends so long after the last event, µs: then all have landed, or the mission is over.
const AFTER_US: u64 = 10_000_000;
/// Seconds of the mission to one of the picture, and bounds of the picture's length, s.
const SPEED: f64 = 12.0;
const LENGTH_S: (f64, f64) = (8.0, 30.0);
/// The colour of a link changes in steps of this many decibels, so that the picture stays small.
const STEP_DB: f64 = 3.0;
/// Captions that are written at most.
const MOST_CAPTIONS: usize = 60;

/// The picture of a run, as an SVG document.
pub(super) fn picture(trace: &Trace) -> Result<String, PictureError> {
    let title = format!("A mission: {}", trace.scenario);
    let height = height_of(trace) + TIMELINE;
    let mut stage = None;
    let still = Picture::draw((WIDTH, height), &title, |sheet| {
        let body = headed(sheet, &title, "")?;
        let (width, height) = size_of(&body);
        let map = part(&body, (0.0, 0.0), (width, height - TIMELINE));
        let view = View::fitting(bounds(trace), size_of(&map), 0.0);
        floor(&map, &view, &trace.floor_plan)?;
        scale_bar(&map, &view)?;
        if trace.mission == MissionKind::Chain {
            key(&map, launch_limit(trace))?;
        }
        let (left, top) = map.get_pixel_range();
        stage = Some(Stage { view, corner: (left.start, top.start) });
        Ok(Vec::new())
    })?;
    let Some(stage) = stage else { return Ok(still.svg().to_owned()) };
    let mut svg = still.svg().trim_end().trim_end_matches("</svg>").to_owned();
    let until_us = events(trace).last().map_or(u64::MAX, |(at_us, _)| at_us + AFTER_US);
    let told = trace.frames.partition_point(|frame| frame.time_us <= until_us);
    let moments: Vec<&Frame> =
        thinned(trace.frames.get(..told).unwrap_or_default(), MOST_MOMENTS).collect();
    if let (Some(first), Some(last)) = (moments.first(), moments.last()) {
        let film = Film::new(trace, &moments, (first.time_us, last.time_us));
        film.links(&mut svg, &stage);
        film.drones(&mut svg, &stage);
        film.captions(&mut svg);
        film.timeline(&mut svg, height);
    }
    svg.push_str("</svg>\n");
    Ok(svg)
}

/// The places of a node at all moments, in units of the sheet.
type Way = [(i32, i32)];

/// The map's place on the sheet.
struct Stage {
    view: View,
    /// The map's corner, in units of the sheet.
    corner: (i32, i32),
}

impl Stage {
    /// The place of a drone in units of the sheet.
    fn unit(&self, drone: &DroneFrame) -> Option<(i32, i32)> {
        let (x, y) = self.view.of(drone)?;
        Some((self.corner.0 + px(x), self.corner.1 + px(y)))
    }
}

/// The moments of a mission, and how they are spread over the time of the picture.
struct Film<'t> {
    trace: &'t Trace,
    moments: &'t [&'t Frame],
    /// The first and the last time of the mission, µs.
    span_us: (u64, u64),
    /// The length of the picture, s.
    length_s: f64,
    /// The moment whose attributes are the still ones.
    still: usize,
}

impl<'t> Film<'t> {
    fn new(trace: &'t Trace, moments: &'t [&'t Frame], span_us: (u64, u64)) -> Self {
        let seconds = (span_us.1 - span_us.0) as f64 * 1e-6;
        let shown = farthest(trace).map(|frame| frame.time_us);
        let still = shown.and_then(|at| moments.iter().position(|moment| moment.time_us >= at));
        Self {
            trace,
            moments,
            span_us,
            length_s: (seconds / SPEED).clamp(LENGTH_S.0, LENGTH_S.1),
            still: still.unwrap_or(moments.len().saturating_sub(1)),
        }
    }

    /// The part of the picture's time at which a time of the mission is shown.
    fn part(&self, time_us: u64) -> f64 {
        let whole = (self.span_us.1 - self.span_us.0).max(1) as f64;
        let shown = self.moments.len().saturating_sub(1) as f64;
        (time_us.saturating_sub(self.span_us.0)) as f64 / whole * shown / (shown + REST as f64)
    }

    /// An element that moves one attribute through one value for each moment.
    fn motion(&self, out: &mut String, attribute: &str, values: &[String]) {
        let last = values.last().cloned().unwrap_or_default();
        let mut all = values.join(";");
        for _ in 0..REST {
            all.push(';');
            all.push_str(&last);
        }
        let kind = if attribute == "transform" {
            "animateTransform type=\"translate\""
        } else {
            "animate"
        };
        // Writing to a string cannot fail.
        let _ = write!(
            out,
            "<{kind} attributeName=\"{attribute}\" dur=\"{:.1}s\" repeatCount=\"indefinite\" \
             values=\"{all}\"/>",
            self.length_s
        );
    }

    /// An element that sets one attribute at the moments at which it changes.
    fn changes(&self, out: &mut String, attribute: &str, changes: &[(f64, String)]) {
        let mut kept: Vec<&(f64, String)> = Vec::new();
        for change in changes {
            if kept.last().is_none_or(|last| last.1 != change.1) {
                kept.push(change);
            }
        }
        let times: Vec<String> = kept.iter().map(|(part, _)| format!("{part:.4}")).collect();
        let values: Vec<&str> = kept.iter().map(|(_, value)| value.as_str()).collect();
        // Writing to a string cannot fail.
        let _ = write!(
            out,
            "<animate attributeName=\"{attribute}\" calcMode=\"discrete\" dur=\"{:.1}s\" \
             repeatCount=\"indefinite\" keyTimes=\"{}\" values=\"{}\"/>",
            self.length_s,
            times.join(";"),
            values.join(";")
        );
    }

    /// A value for each moment, with the time at which it is shown.
    fn each(&self, value: impl Fn(&Frame) -> String) -> Vec<(f64, String)> {
        self.moments.iter().map(|moment| (self.part(moment.time_us), value(moment))).collect()
    }

    /// The places of a node at all moments; where one is not known, the one before.
    fn places(&self, stage: &Stage, index: usize) -> Vec<(i32, i32)> {
        let known = |moment: &&Frame| moment.drones.get(index).and_then(|drone| stage.unit(drone));
        let mut last = self.moments.iter().find_map(known).unwrap_or_default();
        let places = self.moments.iter().map(|moment| {
            last = known(moment).unwrap_or(last);
            last
        });
        places.collect()
    }

    /// A line from each drone to the one behind it, coloured by the link's true strength.
    fn links(&self, out: &mut String, stage: &Stage) {
        let all: Vec<Vec<(i32, i32)>> =
            (0..self.trace.nodes.len()).map(|index| self.places(stage, index)).collect();
        let index_of = |id: NodeId| self.trace.nodes.iter().position(|node| node.id == id);
        for (index, own) in all.iter().enumerate() {
            let behind = |frame: &Frame| frame.drones.get(index).and_then(|drone| drone.back);
            if !self.moments.iter().any(|moment| behind(moment).is_some()) {
                continue;
            }
            let peers = self.moments.iter().zip(own).enumerate().map(|(n, (moment, own))| {
                let peer = behind(moment).and_then(|link| index_of(link.peer));
                peer.and_then(|peer| all.get(peer)?.get(n)).copied().unwrap_or(*own)
            });
            let peers: Vec<(i32, i32)> = peers.collect();
            let limit = launch_limit(self.trace);
            let colours = self.each(|frame| {
                let truth = behind(frame).map(|link| f64::from(link.truth.0));
                truth.map_or_else(|| "none".to_owned(), |dbm| hex(strength(dbm, limit)))
            });
            self.link(out, (own, &peers), &colours);
        }
    }

    fn link(&self, out: &mut String, (own, peers): (&Way, &Way), colours: &[(f64, String)]) {
        let (from, to) = (own.get(self.still), peers.get(self.still));
        let ((x1, y1), (x2, y2)) = from.zip(to).map_or_else(Default::default, |(a, b)| (*a, *b));
        let colour = colours.get(self.still).map_or("none", |(_, colour)| colour);
        // Writing to a string cannot fail.
        let _ = write!(
            out,
            "<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" stroke=\"{colour}\" \
             stroke-width=\"34\" stroke-linecap=\"round\">"
        );
        for (name, places, axis) in
            [("x1", own, 0), ("y1", own, 1), ("x2", peers, 0), ("y2", peers, 1)]
        {
            let values: Vec<String> = places
                .iter()
                .map(|(x, y)| if axis == 0 { x.to_string() } else { y.to_string() })
                .collect();
            self.motion(out, name, &values);
        }
        self.changes(out, "stroke", colours);
        out.push_str("</line>\n");
    }

    /// A disc for each node: the head's is filled and has its name, any other drone's bears its number.
    fn drones(&self, out: &mut String, stage: &Stage) {
        for (index, node) in self.trace.nodes.iter().enumerate().rev() {
            let places = self.places(stage, index);
            let (x, y) = places.get(self.still).copied().unwrap_or_default();
            // Writing to a string cannot fail.
            let _ = write!(out, "<g transform=\"translate({x} {y})\">{}", mark(node));
            let values: Vec<String> = places.iter().map(|(x, y)| format!("{x} {y}")).collect();
            self.motion(out, "transform", &values);
            out.push_str("</g>\n");
        }
    }

    /// What happens, each as a line that stands until the next.
    fn captions(&self, out: &mut String) {
        let events: Vec<_> = events(self.trace).into_iter().take(MOST_CAPTIONS).collect();
        let ends = events.iter().skip(1).map(|(at_us, _)| self.part(*at_us)).chain([1.0]);
        let still_us = self.moments.get(self.still).map_or(0, |moment| moment.time_us);
        let shown = events.iter().rposition(|(at_us, _)| *at_us <= still_us);
        for (index, ((at_us, words), end)) in events.iter().zip(ends).enumerate() {
            let begin = self.part(*at_us);
            let mut opacity = vec![(0.0, "0".to_owned())];
            if begin <= 0.0 {
                opacity.clear();
            }
            opacity.push((begin, "1".to_owned()));
            if end < 1.0 {
                opacity.push((end, "0".to_owned()));
            }
            let still = u8::from(shown == Some(index));
            let text = escaped(&format!("{}  {words}", clock(*at_us)));
            // Writing to a string cannot fail.
            let _ = write!(
                out,
                "<text x=\"240\" y=\"500\" {} opacity=\"{still}\">{text}",
                font(120, &INK)
            );
            self.changes(out, "opacity", &opacity);
            out.push_str("</text>\n");
        }
    }

    /// A line of time with a mark that runs along it.
    fn timeline(&self, out: &mut String, height: f64) {
        let (left, right, y) = (px(24.0), px(WIDTH - 60.0), px(height - 30.0));
        let at = |part: f64| left + (f64::from(right - left) * part) as i32;
        let shown = self.part(self.span_us.1).max(1e-9);
        // Writing to a string cannot fail.
        let _ = write!(
            out,
            "<path d=\"M{left} {y}H{right}\" stroke=\"{}\" stroke-width=\"12\"/>",
            hex(AXIS)
        );
        let minutes = self.span_us.1 / 60_000_000;
        let step = (minutes / 8 + 1) * 60_000_000;
        for n in 0..=minutes * 60_000_000 / step {
            let x = at(self.part(n * step) / shown);
            let _ = write!(
                out,
                "<path d=\"M{x} {}v60\" stroke=\"{}\" stroke-width=\"12\"/><text x=\"{x}\" \
                 y=\"{}\" text-anchor=\"middle\" {}>{}</text>",
                y - 30,
                hex(AXIS),
                y + 165,
                font(100, &QUIET),
                clock(n * step)
            );
        }
        let values: Vec<String> =
            self.moments.iter().map(|m| at(self.part(m.time_us) / shown).to_string()).collect();
        let still = values.get(self.still).map_or("0", String::as_str);
        let _ = write!(out, "<circle cx=\"{still}\" cy=\"{y}\" r=\"50\" fill=\"{}\">", hex(INK));
        self.motion(out, "cx", &values);
        out.push_str("</circle>\n");
    }
}

/// The colour of a link of this true strength, in steps.
fn strength(dbm: f64, limit: Option<f64>) -> RGBColor {
    let weakest = limit.unwrap_or(WEAK_DBM);
    let steps = ((dbm - weakest).clamp(0.0, SPARE_DB) / STEP_DB).floor();
    link_colour(weakest + steps * STEP_DB, limit)
}

/// The mark of a node about the origin.
fn mark(node: &Node) -> String {
    let (ink, paper) = (hex(INK), hex(PAPER));
    let named = |name: &str| {
        let halo = format!("stroke=\"{paper}\" stroke-width=\"40\" paint-order=\"stroke\"");
        format!("<text y=\"-100\" text-anchor=\"middle\" {halo} {}>{name}</text>", font(110, &INK))
    };
    match node.role {
        Role::Base => format!(
            "<rect x=\"-65\" y=\"-65\" width=\"130\" height=\"130\" fill=\"{ink}\"/>{}",
            named("base")
        ),
        Role::Head if node.mission == MissionKind::Chain => format!(
            "<circle r=\"75\" fill=\"{ink}\" stroke=\"{paper}\" stroke-width=\"20\"/>{}",
            named(&node.to_string())
        ),
        Role::Head | Role::Relay => format!(
            "<circle r=\"75\" fill=\"{paper}\" stroke=\"{ink}\" stroke-width=\"20\"/><text y=\"36\" \
             text-anchor=\"middle\" {}>{}</text>",
            font(100, &INK),
            node.id
        ),
    }
}

/// The attributes of a text of this size in units.
fn font(size: u32, colour: &RGBColor) -> String {
    let family = "DejaVu Sans, Verdana, sans-serif";
    format!("font-family=\"{family}\" font-size=\"{size}\" fill=\"{}\"", hex(*colour))
}

/// `1:05`, in minutes and seconds.
fn clock(time_us: u64) -> String {
    let seconds = time_us / 1_000_000;
    format!("{}:{:02}", seconds / 60, seconds % 60)
}

/// The operator's orders, and the drones that take off and land, in order of time.
fn events(trace: &Trace) -> Vec<(u64, String)> {
    let mut events = Vec::new();
    for (before, now) in trace.frames.iter().zip(trace.frames.iter().skip(1)) {
        if before.order != now.order {
            let words = order_words(now.order);
            events.push((now.time_us, format!("the operator's order: {words}")));
        }
        let states = trace.nodes.iter().zip(before.drones.iter().zip(&now.drones));
        for (node, (before, now_drone)) in states {
            if before.state == now_drone.state {
                continue;
            }
            match now_drone.state.name() {
                "taking-off" => events.push((now.time_us, format!("{node} takes off"))),
                "landed" => events.push((now.time_us, format!("{node} has landed"))),
                _ => {}
            }
        }
    }
    events
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;

    #[test]
    fn every_drone_and_every_link_moves_without_a_script() {
        let trace = synthetic::mission();
        let svg = picture(&trace).unwrap();
        assert_eq!(svg.matches("<animateTransform").count(), trace.nodes.len());
        assert_eq!(svg.matches("attributeName=\"stroke\"").count(), trace.nodes.len() - 1);
        assert!(!svg.contains("<script") && !svg.contains("http://www.w3.org/1999"), "{svg}");
        assert!(svg.len() < 300_000, "{} bytes", svg.len());
        assert!(svg.ends_with("</svg>\n") && svg.matches("</svg>").count() == 1);
    }

    #[test]
    fn links_have_the_colours_of_the_ramp_and_the_map_points_north() {
        let svg = picture(&synthetic::mission()).unwrap();
        let (start, rest) = svg.split_once("attributeName=\"stroke\"").unwrap();
        assert!(start.contains(">N</text>") || start.contains("\nN\n"), "no north");
        let (_, values) = rest.split_once("values=\"").unwrap();
        let (values, _) = values.split_once('"').unwrap();
        let steps =
            (0..=5).map(|step| hex(link_colour(-70.0 + 3.0 * f64::from(step), Some(-70.0))));
        let ramp: Vec<String> = steps.chain(["none".to_owned()]).collect();
        for value in values.split(';') {
            assert!(ramp.iter().any(|colour| colour == value), "{value}");
        }
    }

    #[test]
    fn a_long_mission_of_many_drones_stays_small() {
        let mut trace = synthetic::mission();
        let frames = trace.frames.clone();
        while trace.frames.len() < 5_000 {
            trace.frames.extend(frames.iter().cloned());
        }
        let node = trace.nodes[1];
        for _ in trace.nodes.len()..12 {
            trace.nodes.insert(1, node);
            for frame in &mut trace.frames {
                let drone = frame.drones[1];
                frame.drones.insert(1, drone);
            }
        }
        let size = picture(&trace).unwrap().len();
        assert!(size < 300_000, "{size} bytes");
    }

    #[test]
    fn a_mission_of_nothing_is_still_a_picture() {
        let mut trace = synthetic::mission();
        trace.frames.clear();
        assert!(picture(&trace).unwrap().ends_with("</svg>\n"));
        trace.nodes.clear();
        assert!(picture(&trace).is_ok());
    }
}
