//! The topics of a mission, and the messages that each of its frames adds to them.

use std::io;

use robot_maps::Occupancy;
use scenario::Scenario;

use super::{content, grid};
use crate::mcap::{BEAMS, Moment};
use mission::trace::{DroneFrame, Frame, LinkFrame, Trace};
use ros2_topics::messages::{
    Clock, DiagnosticArray, Float32, MarkerArray, OccupancyGrid, Odometry, Path, Range, TfMessage,
    Time,
};
use ros2_topics::{Sink, Topic};

/// Frames between two messages of diagnostics: a second.
pub(super) const DIAGNOSTICS_EVERY: usize = 5;
/// Frames between two messages with the path of a drone: ten seconds.
pub(super) const PATHS_EVERY: usize = 50;

/// Topics about all drones.
struct Shared {
    map: Topic<OccupancyGrid>,
    transforms: Topic<TfMessage>,
    fixed: Topic<TfMessage>,
    markers: Topic<MarkerArray>,
    diagnostics: Topic<DiagnosticArray>,
}

/// Topics of one drone.
struct Own {
    odometry: Topic<Odometry>,
    path: Topic<Path>,
    ranges: [Topic<Range>; 4],
    front: [Topic<Float32>; 3],
    back: [Topic<Float32>; 3],
}

/// What the messages tell of a mission that its trace does not.
pub struct Place {
    /// How far the beams reach, m.
    reach: f32,
    map: Option<Occupancy>,
}

impl Place {
    /// Of a scenario.
    #[must_use]
    pub fn of(scenario: &Scenario) -> Self {
        Self { reach: scenario.vehicle.reach, map: grid::of(&scenario.tunnel) }
    }
}

/// Makes the messages of a mission from its frames.
pub struct Messages {
    shared: Shared,
    /// The time of the mission, for programs that take it in place of their own clock.
    clock: Option<Topic<Clock>>,
    drones: Vec<Own>,
    paths: Vec<content::Flown>,
    before: Option<Frame>,
    frames: usize,
    place: Place,
}

impl Messages {
    /// Adds the topics of a mission to a sink.
    ///
    /// # Errors
    /// If the sink does not take a topic.
    pub fn new<S: Sink + ?Sized>(trace: &Trace, place: Place, sink: &mut S) -> io::Result<Self> {
        let shared = Shared::new(sink)?;
        let ids = trace.nodes.iter().map(|node| node.id.to_string());
        let drones = ids.map(|id| Own::new(sink, &id)).collect::<io::Result<_>>()?;
        let paths = trace.nodes.iter().map(|_| content::Flown::default()).collect();
        Ok(Self { shared, clock: None, drones, paths, before: None, frames: 0, place })
    }

    /// The same with the topic `/clock`, which has the time of the mission.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_clock<S: Sink + ?Sized>(
        trace: &Trace,
        place: Place,
        sink: &mut S,
    ) -> io::Result<Self> {
        let clock = Some(Topic::add(sink, "/clock", false)?);
        Ok(Self { clock, ..Self::new(trace, place, sink)? })
    }

    /// Gives the sink the messages of a frame.
    ///
    /// # Errors
    /// If the sink does not take a message.
    pub fn frame<S: Sink + ?Sized>(
        &mut self,
        sink: &mut S,
        trace: &Trace,
        frame: &Frame,
    ) -> io::Result<()> {
        let now = Moment { micros: frame.time_us };
        let Self { shared, clock, drones, paths, before, frames, place } = self;
        if let Some(clock) = clock {
            clock.put(sink, now.micros, &Clock { clock: Time::at_micros(now.micros) })?;
        }
        if before.is_none() {
            if let Some(map) = &place.map {
                shared.map.put(sink, now.micros, &grid::message(map, now))?;
            }
            shared.fixed.put(sink, now.micros, &content::fixed(trace, now))?;
        }
        shared.transforms.put(sink, now.micros, &content::transforms(trace, frame, now))?;
        shared.markers.put(sink, now.micros, &content::markers(trace, frame, now))?;
        if frames.is_multiple_of(DIAGNOSTICS_EVERY) {
            shared.diagnostics.put(sink, now.micros, &content::diagnostics(trace, frame, now))?;
        }
        for (n, (own, drone)) in drones.iter().zip(&frame.drones).enumerate() {
            let Some(node) = trace.nodes.get(n) else { continue };
            let last =
                before.as_ref().and_then(|frame| Some((frame.time_us, frame.drones.get(n)?)));
            own.odometry.put(sink, now.micros, &content::odometry(node, drone, last, now))?;
            own.put_beams(sink, node.id.0, drone, place.reach, now)?;
            own.put_links(sink, drone, now)?;
            paths[n].add(drone, now);
            if frames.is_multiple_of(PATHS_EVERY) {
                own.path.put(sink, now.micros, &paths[n].path(now))?;
            }
        }
        *frames += 1;
        *before = Some(frame.clone());
        Ok(())
    }

    /// Gives the sink the last messages: the whole paths.
    ///
    /// # Errors
    /// If the sink does not take a message.
    pub fn finish<S: Sink + ?Sized>(&mut self, sink: &mut S) -> io::Result<()> {
        let Some(last) = self.before.take() else { return Ok(()) };
        let now = Moment { micros: last.time_us };
        for (own, flown) in self.drones.iter().zip(&self.paths) {
            own.path.put(sink, now.micros, &flown.path(now))?;
        }
        Ok(())
    }
}

impl Shared {
    fn new<S: Sink + ?Sized>(sink: &mut S) -> io::Result<Self> {
        Ok(Self {
            map: Topic::add(sink, "/map", true)?,
            transforms: Topic::add(sink, "/tf", false)?,
            fixed: Topic::add(sink, "/tf_static", true)?,
            markers: Topic::add(sink, "/drones", false)?,
            diagnostics: Topic::add(sink, "/diagnostics", false)?,
        })
    }
}

impl Own {
    fn new<S: Sink + ?Sized>(sink: &mut S, id: &str) -> io::Result<Self> {
        let drone = format!("/drone_{id}");
        let odometry = Topic::add(sink, &format!("{drone}/odom"), false)?;
        let path = Topic::add(sink, &format!("{drone}/path"), false)?;
        let mut range = |beam| Topic::add(sink, &format!("{drone}/range/{beam}"), false);
        let [nw, ne, sw, se] = BEAMS.map(|(beam, _)| range(beam));
        let ranges = [nw?, ne?, sw?, se?];
        let mut link = |side, what| Topic::add(sink, &format!("{drone}/link/{side}/{what}"), false);
        let mut side = |side| -> io::Result<_> {
            Ok([link(side, "raw_dbm")?, link(side, "filtered_dbm")?, link(side, "true_dbm")?])
        };
        Ok(Self { odometry, path, ranges, front: side("front")?, back: side("back")? })
    }

    fn put_beams<S: Sink + ?Sized>(
        &self,
        sink: &mut S,
        id: u8,
        drone: &DroneFrame,
        reach: f32,
        now: Moment,
    ) -> io::Result<()> {
        for ((topic, (beam, _)), metres) in self.ranges.iter().zip(BEAMS).zip(drone.ranges) {
            if !metres.is_nan() {
                let frame = content::beam_frame(id, beam);
                topic.put(sink, now.micros, &content::range(frame, metres, reach, now))?;
            }
        }
        Ok(())
    }

    fn put_links<S: Sink + ?Sized>(
        &self,
        sink: &mut S,
        drone: &DroneFrame,
        now: Moment,
    ) -> io::Result<()> {
        for (topics, link) in [(self.front, drone.front), (self.back, drone.back)] {
            let Some(LinkFrame { raw, filtered, truth, .. }) = link else { continue };
            for (topic, strength) in topics.into_iter().zip([raw, filtered, truth]) {
                topic.put(sink, now.micros, &Float32 { data: strength.0 })?;
            }
        }
        Ok(())
    }
}
