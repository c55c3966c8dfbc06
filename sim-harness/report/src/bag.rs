//! Writes a mission as a bag of ROS 2: `bag.mcap`, whose messages are in CDR with their definitions in
//! the file, and `metadata.yaml`, which makes the folder a bag of rosbag2.
//!
//! Times are those of the mission, as in `trace.mcap`: one trace makes one bag. The book's chapter "What a
//! run leaves behind" lists the topics.

mod content;
mod grid;
mod messages;
mod metadata;

use std::collections::BTreeMap;
use std::io::{self, Seek, Write};
use std::marker::PhantomData;

use ::mcap::McapError;
use ::mcap::records::MessageHeader;
use ::mcap::write::{WriteOptions, Writer};
use byteorder::LittleEndian;
use robot_maps::Occupancy;
use scenario::Scenario;

use crate::mcap::{BEAMS, Moment};
use messages::{
    DiagnosticArray, Float32, MarkerArray, Message, OccupancyGrid, Odometry, Path, Range,
    TfMessage, schema,
};
use metadata::{Known, qos};
use mission::trace::{DroneFrame, Frame, LinkFrame, Trace};

/// The name of the file with the messages.
pub(crate) const BAG: &str = "bag.mcap";

/// What CDR in the order of bytes of little-endian machines begins with (DDSI-RTPS 2.5, table 10.3).
const LITTLE_ENDIAN: [u8; 4] = [0, 1, 0, 0];

/// Frames between two messages of diagnostics: a second.
const DIAGNOSTICS_EVERY: usize = 5;
/// Frames between two messages with the path of a drone: ten seconds.
const PATHS_EVERY: usize = 50;

/// A topic with messages of one kind.
struct Topic<M> {
    index: usize,
    kind: PhantomData<fn(M)>,
}

impl<M> Clone for Topic<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M> Copy for Topic<M> {}

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

/// The bag of a mission that is still flown.
pub(crate) struct BagFile<W: Write + Seek> {
    recording: Recording<W>,
    shared: Shared,
    drones: Vec<Own>,
    paths: Vec<content::Flown>,
    before: Option<Frame>,
    frames: usize,
    place: Place,
}

/// What the bag tells of a mission that its trace does not.
pub(crate) struct Place {
    /// How far the beams reach, m.
    reach: f32,
    map: Option<Occupancy>,
}

impl Place {
    /// Of a scenario.
    pub(crate) fn of(scenario: &Scenario) -> Self {
        Self { reach: scenario.vehicle.reach, map: grid::of(&scenario.tunnel) }
    }
}

impl<W: Write + Seek> BagFile<W> {
    /// Begins the bag of a mission.
    pub(crate) fn new(trace: &Trace, place: Place, out: W) -> io::Result<Self> {
        let mut recording = Recording::new(out)?;
        let shared = Shared::new(&mut recording)?;
        let ids = trace.nodes.iter().map(|node| node.id.to_string());
        let drones = ids.map(|id| Own::new(&mut recording, &id)).collect::<io::Result<_>>()?;
        let paths = trace.nodes.iter().map(|_| content::Flown::default()).collect();
        Ok(Self { recording, shared, drones, paths, before: None, frames: 0, place })
    }

    /// Adds a frame.
    pub(crate) fn frame(&mut self, trace: &Trace, frame: &Frame) -> io::Result<()> {
        let now = Moment { micros: frame.time_us };
        let Self { recording, shared, drones, paths, before, frames, place } = self;
        if before.is_none() {
            if let Some(map) = &place.map {
                recording.put(shared.map, now, &grid::message(map, now))?;
            }
            recording.put(shared.fixed, now, &content::fixed(trace, now))?;
        }
        recording.put(shared.transforms, now, &content::transforms(trace, frame, now))?;
        recording.put(shared.markers, now, &content::markers(trace, frame, now))?;
        if frames.is_multiple_of(DIAGNOSTICS_EVERY) {
            recording.put(shared.diagnostics, now, &content::diagnostics(trace, frame, now))?;
        }
        for (n, (own, drone)) in drones.iter().zip(&frame.drones).enumerate() {
            let Some(node) = trace.nodes.get(n) else { continue };
            let last =
                before.as_ref().and_then(|frame| Some((frame.time_us, frame.drones.get(n)?)));
            let odometry = content::odometry(node, drone, last, now);
            recording.put(own.odometry, now, &odometry)?;
            own.put_beams(recording, node.id.0, drone, place.reach, now)?;
            own.put_links(recording, drone, now)?;
            paths[n].add(drone, now);
            if frames.is_multiple_of(PATHS_EVERY) {
                recording.put(own.path, now, &paths[n].path(now))?;
            }
        }
        *frames += 1;
        *before = Some(frame.clone());
        Ok(())
    }

    /// Ends the file; returns it, and the text of `metadata.yaml`.
    pub(crate) fn finish(mut self, trace: &Trace) -> io::Result<(W, String)> {
        if let Some(last) = self.before.take() {
            let now = Moment { micros: last.time_us };
            for (own, flown) in self.drones.iter().zip(&self.paths) {
                self.recording.put(own.path, now, &flown.path(now))?;
            }
        }
        self.recording.writer.finish().map_err(as_io)?;
        let text = metadata::text(trace, &self.recording.topics, self.recording.span);
        Ok((self.recording.writer.into_inner(), text))
    }
}

impl Shared {
    fn new<W: Write + Seek>(recording: &mut Recording<W>) -> io::Result<Self> {
        Ok(Self {
            map: recording.topic("/map", true)?,
            transforms: recording.topic("/tf", false)?,
            fixed: recording.topic("/tf_static", true)?,
            markers: recording.topic("/drones", false)?,
            diagnostics: recording.topic("/diagnostics", false)?,
        })
    }
}

impl Own {
    fn new<W: Write + Seek>(recording: &mut Recording<W>, id: &str) -> io::Result<Self> {
        let drone = format!("/drone_{id}");
        let odometry = recording.topic(&format!("{drone}/odom"), false)?;
        let path = recording.topic(&format!("{drone}/path"), false)?;
        let mut range = |beam| recording.topic(&format!("{drone}/range/{beam}"), false);
        let [nw, ne, sw, se] = BEAMS.map(|(beam, _)| range(beam));
        let ranges = [nw?, ne?, sw?, se?];
        let mut link = |side, what| recording.topic(&format!("{drone}/link/{side}/{what}"), false);
        let mut side = |side| -> io::Result<_> {
            Ok([link(side, "raw_dbm")?, link(side, "filtered_dbm")?, link(side, "true_dbm")?])
        };
        Ok(Self { odometry, path, ranges, front: side("front")?, back: side("back")? })
    }

    fn put_beams<W: Write + Seek>(
        &self,
        recording: &mut Recording<W>,
        id: u8,
        drone: &DroneFrame,
        reach: f32,
        now: Moment,
    ) -> io::Result<()> {
        for ((topic, (beam, _)), metres) in self.ranges.iter().zip(BEAMS).zip(drone.ranges) {
            if !metres.is_nan() {
                let frame = content::beam_frame(id, beam);
                recording.put(*topic, now, &content::range(frame, metres, reach, now))?;
            }
        }
        Ok(())
    }

    fn put_links<W: Write + Seek>(
        &self,
        recording: &mut Recording<W>,
        drone: &DroneFrame,
        now: Moment,
    ) -> io::Result<()> {
        for (topics, link) in [(self.front, drone.front), (self.back, drone.back)] {
            let Some(LinkFrame { raw, filtered, truth, .. }) = link else { continue };
            for (topic, strength) in topics.into_iter().zip([raw, filtered, truth]) {
                recording.put(topic, now, &Float32 { data: strength.0 })?;
            }
        }
        Ok(())
    }
}

/// The file being written.
struct Recording<W: Write + Seek> {
    writer: Writer<W>,
    topics: Vec<Known>,
    channels: Vec<u16>,
    /// The times of the first message and of the last.
    span: Option<(Moment, Moment)>,
}

impl<W: Write + Seek> Recording<W> {
    fn new(out: W) -> io::Result<Self> {
        let options = WriteOptions::new().profile("ros2").library("uchain").compression(None);
        let writer = options.create(out).map_err(as_io)?;
        Ok(Self { writer, topics: Vec::new(), channels: Vec::new(), span: None })
    }

    /// A topic; one that is latched is sent to those who join later, too.
    fn topic<M: Message>(&mut self, name: &str, is_latched: bool) -> io::Result<Topic<M>> {
        let text = schema(M::NAME);
        let schema = self.writer.add_schema(M::NAME, "ros2msg", text.as_bytes()).map_err(as_io)?;
        let about = BTreeMap::from([("offered_qos_profiles".to_owned(), qos(is_latched, 0))]);
        let channel = self.writer.add_channel(schema, name, "cdr", &about).map_err(as_io)?;
        self.channels.push(channel);
        self.topics.push(Known { name: name.to_owned(), kind: M::NAME, is_latched, count: 0 });
        Ok(Topic { index: self.topics.len() - 1, kind: PhantomData })
    }

    fn put<M: Message>(&mut self, topic: Topic<M>, at: Moment, message: &M) -> io::Result<()> {
        let known = &mut self.topics[topic.index];
        let header = MessageHeader {
            channel_id: self.channels[topic.index],
            sequence: known.count,
            log_time: at.nanos(),
            publish_time: at.nanos(),
        };
        known.count = known.count.wrapping_add(1);
        let mut bytes = LITTLE_ENDIAN.to_vec();
        let body = cdr_encoding::to_vec::<M, LittleEndian>(message).map_err(io::Error::other)?;
        bytes.extend(body);
        self.span = Some((self.span.map_or(at, |(first, _)| first), at));
        self.writer.write_to_known_channel(&header, &bytes).map_err(as_io)
    }
}

fn as_io(error: McapError) -> io::Error {
    crate::mcap::WriteError::from(error).into()
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use ::mcap::MessageStream;

    use super::*;
    use crate::synthetic;

    fn written(trace: &Trace) -> (Vec<u8>, String) {
        let place = Place::of(&Scenario::open("straight").unwrap());
        let mut bag = BagFile::new(trace, place, Cursor::new(Vec::new())).unwrap();
        trace.frames.iter().for_each(|frame| bag.frame(trace, frame).unwrap());
        let (file, metadata) = bag.finish(trace).unwrap();
        (file.into_inner(), metadata)
    }

    #[test]
    fn every_topic_is_in_the_bag_and_in_its_metadata() {
        let trace = synthetic::mission();
        let (file, metadata) = written(&trace);
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        for message in MessageStream::new(&file).unwrap() {
            let message = message.unwrap();
            let schema = message.channel.schema.as_ref().unwrap();
            assert_eq!((&*schema.encoding, &*message.channel.message_encoding), ("ros2msg", "cdr"));
            assert_eq!(message.data[..4], LITTLE_ENDIAN);
            *counts.entry(message.channel.topic.clone()).or_default() += 1;
        }
        let frames = trace.frames.len();
        for (topic, count) in [
            ("/map", 1),
            ("/tf_static", 1),
            ("/tf", frames),
            ("/drones", frames),
            ("/diagnostics", frames.div_ceil(DIAGNOSTICS_EVERY)),
            ("/drone_4/odom", frames),
            ("/drone_1/path", frames.div_ceil(PATHS_EVERY) + 1),
            ("/drone_0/range/nw", frames),
            ("/drone_1/link/front/filtered_dbm", counts["/drone_1/link/front/raw_dbm"]),
        ] {
            assert_eq!(counts[topic], count, "{topic}");
            let entry = format!("name: {topic}\n");
            let told = metadata.split(&entry).nth(1).unwrap();
            let told = told.split("message_count: ").nth(1).unwrap().lines().next().unwrap();
            assert_eq!(told, count.to_string(), "{topic}");
        }
        assert!(!counts.contains_key("/drone_0/link/front/raw_dbm"));
        assert!(metadata.contains(&format!("message_count: {}\n", counts.values().sum::<usize>())));
    }

    #[test]
    fn one_trace_makes_one_bag() {
        let trace = synthetic::mission();
        assert!(written(&trace) == written(&trace));
    }

    /// A string begins with its length, and a number stands at a multiple of its size, counted from
    /// behind the encapsulation.
    #[test]
    fn messages_are_aligned() {
        let header = messages::Header { frame_id: "map".into(), ..Default::default() };
        let path = Path { header, poses: vec![Default::default()] };
        let bytes = cdr_encoding::to_vec::<_, LittleEndian>(&path).unwrap();
        // Stamp 8, length and "map" with its zero 8, length of poses 4; of the pose: stamp 8, an empty
        // string 5, padding to the next eight, and seven numbers.
        assert_eq!(bytes.len(), 8 + 8 + 4 + 8 + 5 + 7 + 7 * 8);
    }

    #[test]
    fn a_schema_has_the_definitions_of_all_that_it_holds() {
        let text = schema("nav_msgs/msg/Path");
        for part in ["std_msgs/Header", "geometry_msgs/Quaternion", "builtin_interfaces/Time"] {
            assert_eq!(text.matches(&format!("\nMSG: {part}\n")).count(), 1, "{text}");
        }
        assert!(text.starts_with("std_msgs/Header header\n"));
    }
}
