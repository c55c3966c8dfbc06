//! Writes `trace.mcap`, the mission for the viewers Foxglove and Rerun.
//!
//! Foxglove draws `SceneUpdate`s and knows every well-known schema; Rerun draws point clouds,
//! transforms and logs of the same family, and plots any number in any protobuf message. So
//! places and links are written twice, as a scene and as points, and everything else once. The
//! book's chapter "What a run leaves behind" lists topics and fields.
//!
//! Times are those of the mission: it begins at 0, the first of January 1970. The file holds no
//! other clock and no counter from outside, so one trace makes one file.

mod scene;
mod schema;

use std::collections::BTreeMap;
use std::fmt;
use std::io::{Seek, Write};

use ::mcap::McapError;
use ::mcap::records::{MessageHeader, Metadata};
use ::mcap::write::{WriteOptions, Writer};
use foxglove::Encode;
use foxglove::messages::Timestamp;
use prost::Message;
use recordings::messages::{self, DroneState, Link};

use mission::trace::{Frame, Trace};
pub(crate) use scene::{BEAMS, RADIUS, spatial};
use schema::{drone_state, link};

/// The frame of reference of the floor plan.
const MAP_FRAME: &str = "map";

/// A mission could not be written as MCAP: almost always because the disk is full.
#[derive(Debug)]
pub struct WriteError(McapError);

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "writing MCAP: {}", self.0)
    }
}

impl std::error::Error for WriteError {}

impl From<McapError> for WriteError {
    fn from(error: McapError) -> Self {
        Self(error)
    }
}

impl From<WriteError> for std::io::Error {
    fn from(error: WriteError) -> Self {
        match error.0 {
            McapError::Io(error) => error,
            other => Self::other(other),
        }
    }
}

/// Writes the whole mission.
///
/// # Errors
/// See [`WriteError`].
pub fn write(trace: &Trace, out: impl Write + Seek) -> Result<(), WriteError> {
    let mut file = TraceFile::new(trace, out)?;
    for frame in &trace.frames {
        file.frame(trace, frame)?;
    }
    file.finish(trace).map(drop)
}

/// The file of a mission that is still flown.
pub(super) struct TraceFile<W: Write + Seek> {
    recording: Recording<W>,
    drones: Vec<DroneTopics>,
    shared: SharedTopics,
    /// The frame before; none before the map is written.
    before: Option<Frame>,
}

impl<W: Write + Seek> TraceFile<W> {
    pub(super) fn new(trace: &Trace, out: W) -> Result<Self, WriteError> {
        let mut recording = Recording::new(out)?;
        recording.describe(trace)?;
        let drones = (0..trace.nodes.len())
            .map(|index| DroneTopics::new(&mut recording, index, trace))
            .collect::<Result<Vec<_>, _>>()?;
        let shared = SharedTopics::new(&mut recording)?;
        Ok(Self { recording, drones, shared, before: None })
    }

    pub(super) fn frame(&mut self, trace: &Trace, frame: &Frame) -> Result<(), WriteError> {
        if self.before.is_none() {
            self.map(trace, Moment { micros: frame.time_us })?;
        }
        let Self { recording, drones, shared, before } = self;
        write_frame(recording, trace, frame, before.as_ref(), shared, drones)?;
        self.before = Some(frame.clone());
        Ok(())
    }

    fn map(&mut self, trace: &Trace, start: Moment) -> Result<(), WriteError> {
        let Self { recording, shared, .. } = self;
        recording.put(shared.map, start, &scene::map(&trace.floor_plan, start))?;
        recording.put(shared.walls, start, &scene::walls(&trace.floor_plan, start))
    }

    pub(super) fn finish(mut self, trace: &Trace) -> Result<W, WriteError> {
        if self.before.is_none() {
            self.map(trace, Moment { micros: 0 })?;
        }
        self.recording.writer.finish()?;
        Ok(self.recording.writer.into_inner())
    }
}

fn write_frame<W: Write + Seek>(
    recording: &mut Recording<W>,
    trace: &Trace,
    frame: &Frame,
    before: Option<&Frame>,
    shared: &SharedTopics,
    drones: &[DroneTopics],
) -> Result<(), WriteError> {
    let now = Moment { micros: frame.time_us };
    recording.put(shared.transforms, now, &scene::transforms(trace, frame, now))?;
    recording.put(shared.drones, now, &scene::drones(trace, frame, now))?;
    recording.put(shared.points, now, &scene::points(trace, frame, now))?;
    recording.put(shared.links, now, &scene::link_points(trace, frame, now))?;
    for change in scene::state_changes(trace, frame, before, now) {
        recording.put(shared.log, now, &change)?;
    }
    for (topics, drone) in drones.iter().zip(&frame.drones) {
        recording.put(topics.state, now, &drone_state(drone))?;
        for (topic, frame) in [(topics.front, &drone.front), (topics.back, &drone.back)] {
            if let Some(known) = frame {
                recording.put(topic, now, &link(known))?;
            }
        }
    }
    Ok(())
}

/// A time of the mission.
#[derive(Clone, Copy)]
pub(crate) struct Moment {
    /// The time since the beginning of the mission.
    pub(crate) micros: u64,
}

impl Moment {
    pub(crate) fn nanos(self) -> u64 {
        self.micros.saturating_mul(1000)
    }

    fn timestamp(self) -> Timestamp {
        // A mission of 136 years is cut off here.
        let seconds = u32::try_from(self.micros / 1_000_000).unwrap_or(u32::MAX);
        Timestamp::new(seconds, (self.micros % 1_000_000) as u32 * 1000)
    }
}

/// A channel of the file.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Topic(u16);

/// Topics about all drones.
#[derive(Clone, Copy)]
struct SharedTopics {
    map: Topic,
    walls: Topic,
    transforms: Topic,
    drones: Topic,
    points: Topic,
    links: Topic,
    log: Topic,
}

impl SharedTopics {
    fn new<W: Write + Seek>(recording: &mut Recording<W>) -> Result<Self, WriteError> {
        use foxglove::messages::{FrameTransforms, Log, PointCloud, SceneUpdate};
        Ok(Self {
            map: recording.topic::<SceneUpdate>("/map")?,
            walls: recording.topic::<PointCloud>("/map/walls")?,
            transforms: recording.topic::<FrameTransforms>("/tf")?,
            drones: recording.topic::<SceneUpdate>("/drones")?,
            points: recording.topic::<PointCloud>("/drones/points")?,
            links: recording.topic::<PointCloud>("/drones/links")?,
            log: recording.topic::<Log>("/log")?,
        })
    }
}

/// Topics of one drone.
#[derive(Clone, Copy)]
struct DroneTopics {
    state: Topic,
    front: Topic,
    back: Topic,
}

impl DroneTopics {
    fn new<W: Write + Seek>(
        recording: &mut Recording<W>,
        index: usize,
        trace: &Trace,
    ) -> Result<Self, WriteError> {
        let id = trace.nodes.get(index).map_or_else(String::new, |node| node.id.to_string());
        Ok(Self {
            state: recording.own_topic(DroneState::schema(), &format!("/drone/{id}/state"))?,
            front: recording.own_topic(Link::schema(), &format!("/drone/{id}/link/front"))?,
            back: recording.own_topic(Link::schema(), &format!("/drone/{id}/link/back"))?,
        })
    }
}

/// The file being written.
struct Recording<W: Write + Seek> {
    writer: Writer<W>,
    /// Messages so far.
    counts: BTreeMap<Topic, u32>,
}

impl<W: Write + Seek> Recording<W> {
    fn new(out: W) -> Result<Self, WriteError> {
        let writer = WriteOptions::new()
            .library("uchain")
            // A compressor costs a minute of every first build; `mcap compress` makes up for it.
            .compression(None)
            .create(out)?;
        Ok(Self { writer, counts: BTreeMap::new() })
    }

    /// The scenario of the record.
    fn describe(&mut self, trace: &Trace) -> Result<(), WriteError> {
        let mut metadata = BTreeMap::from([
            ("scenario".to_owned(), trace.scenario.clone()),
            ("launch_limit_dbm".to_owned(), trace.launch_limit.0.to_string()),
        ]);
        metadata.extend(trace.seed.map(|seed| ("seed".to_owned(), seed.to_string())));
        self.writer.write_metadata(&Metadata { name: "mission".to_owned(), metadata })?;
        Ok(())
    }

    fn topic<M: Encode>(&mut self, name: &str) -> Result<Topic, WriteError> {
        let schema = match M::get_schema() {
            Some(schema) => self.writer.add_schema(&schema.name, &schema.encoding, &schema.data)?,
            None => 0,
        };
        self.channel(schema, name, &M::get_message_encoding())
    }

    /// A topic with messages of our own.
    fn own_topic(&mut self, schema: messages::Schema, name: &str) -> Result<Topic, WriteError> {
        let (message, text) = schema;
        let schema = self.writer.add_schema(&message, "protobuf", &text)?;
        self.channel(schema, name, "protobuf")
    }

    fn channel(&mut self, schema: u16, name: &str, encoding: &str) -> Result<Topic, WriteError> {
        Ok(Topic(self.writer.add_channel(schema, name, encoding, &BTreeMap::new())?))
    }

    fn put(&mut self, topic: Topic, at: Moment, message: &impl Message) -> Result<(), WriteError> {
        let count = self.counts.entry(topic).or_default();
        let header = MessageHeader {
            channel_id: topic.0,
            sequence: *count,
            log_time: at.nanos(),
            publish_time: at.nanos(),
        };
        *count = count.wrapping_add(1);
        self.writer.write_to_known_channel(&header, &message.encode_to_vec())?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use ::mcap::MessageStream;

    use super::*;
    use crate::synthetic;
    use mission::trace::LinkFrame;

    fn written(trace: &Trace) -> Vec<u8> {
        let mut out = Cursor::new(Vec::new());
        write(trace, &mut out).unwrap();
        out.into_inner()
    }

    #[test]
    fn everything_reads_back() {
        let trace = synthetic::mission();
        let file = written(&trace);
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        let mut last = 0;
        for message in MessageStream::new(&file).unwrap() {
            let message = message.unwrap();
            assert!(message.log_time >= last);
            last = message.log_time;
            assert_eq!(message.channel.schema.as_ref().unwrap().encoding, "protobuf");
            *counts.entry(message.channel.topic.clone()).or_default() += 1;
        }
        assert_eq!(last, trace.frames.last().unwrap().time_us * 1000);
        assert_eq!((counts["/map"], counts["/map/walls"]), (1, 1));
        for topic in [
            "/tf",
            "/drones",
            "/drones/points",
            "/drones/links",
            "/drone/0/state",
            "/drone/4/state",
        ] {
            assert_eq!(counts[topic], trace.frames.len(), "{topic}");
        }
        let links = trace.frames.iter().filter(|frame| frame.drones[1].front.is_some()).count();
        assert_eq!(counts["/drone/1/link/front"], links);
        assert!(!counts.contains_key("/drone/0/link/front"));
    }

    #[test]
    fn drones_have_the_names_of_their_mission() {
        use foxglove::messages::{Log, SceneUpdate};
        for (mission, name) in synthetic::SECOND_NAMES {
            let mut trace = synthetic::named_as(mission);
            trace.frames.truncate(1);
            let file = written(&trace);
            let of = |topic| {
                let messages = MessageStream::new(&file).unwrap().map(Result::unwrap);
                messages.filter(move |message| message.channel.topic == topic)
            };
            let scene = SceneUpdate::decode(&*of("/drones").next().unwrap().data).unwrap();
            assert_eq!(scene.entities[1].texts[0].text, format!("{name}\narmed"));
            let log = Log::decode(&*of("/log").nth(1).unwrap().data).unwrap();
            assert_eq!(log.message, format!("{name}: armed"));
        }
    }

    #[test]
    fn a_link_is_a_row_of_points_from_one_drone_to_the_other() {
        let mut trace = synthetic::mission();
        // Relay 1 and the head alone, on the straight at the beginning.
        trace.frames = vec![trace.frames[400].clone()];
        let frame = &mut trace.frames[0];
        frame.drones.iter_mut().skip(2).for_each(|drone| drone.front = None);
        let ends = [1, 0].map(|drone| spatial(&frame.drones[drone]));
        let file = written(&trace);
        let mut messages = MessageStream::new(&file).unwrap().map(Result::unwrap);
        let message = messages.find(|message| message.channel.topic == "/drones/links").unwrap();
        let cloud = foxglove::messages::PointCloud::decode(&*message.data).unwrap();
        let number = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().unwrap());
        let points: Vec<[f32; 3]> =
            cloud.data.chunks(16).map(|p| [0, 4, 8].map(|at| number(&p[at..at + 4]))).collect();
        assert_eq!([points[0], points[points.len() - 1]], ends);
        let gap =
            |pair: &[[f32; 3]]| libm::hypotf(pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
        assert!(points.windows(2).all(|pair| gap(pair) < 0.5), "{points:?}");
    }

    #[test]
    fn a_link_keeps_its_numbers_even_where_they_are_zero() {
        let mut trace = synthetic::mission();
        trace.frames.truncate(1);
        let link = LinkFrame {
            peer: units::NodeId(0),
            raw: units::Dbm(0.0),
            filtered: units::Dbm(-61.5),
            truth: units::Dbm(-62.25),
        };
        trace.frames[0].drones[1].front = Some(link);
        let file = written(&trace);
        let message = MessageStream::new(&file)
            .unwrap()
            .map(Result::unwrap)
            .find(|message| message.channel.topic == "/drone/1/link/front")
            .unwrap();
        // Field 1 is a varint, 2 to 4 are floats: all four are on the wire.
        assert_eq!(message.data.len(), 2 + 3 * 5);
        assert_eq!(Link::decode(&*message.data).unwrap(), super::link(&link));
    }

    #[test]
    fn one_trace_makes_one_file() {
        let trace = synthetic::mission();
        assert!(written(&trace) == written(&trace));
    }

    #[test]
    fn a_trace_holds_the_packets_of_both_neighbours() {
        let recording = recordings::formats::mcap::parse(
            &written(&synthetic::mission()),
            std::path::Path::new("trace.mcap"),
        )
        .unwrap();
        let trace = synthetic::mission();
        let links = trace.frames.iter().flat_map(|frame| &frame.drones);
        let packets: usize =
            links.map(|d| usize::from(d.front.is_some()) + usize::from(d.back.is_some())).sum();
        assert_eq!(recording.samples.len(), packets);
        assert!(recording.links.contains(&"1 from 0".to_owned()), "{:?}", recording.links);
        assert!(recording.samples.iter().all(|sample| sample.ends.is_some()));
    }

    /// A recorder that is killed leaves a file without its end.
    #[test]
    fn a_file_that_was_cut_gives_what_stands_before_the_cut() {
        let whole = written(&synthetic::mission());
        let all = recordings::formats::mcap::parse(&whole, std::path::Path::new("trace.mcap"))
            .unwrap()
            .samples
            .len();
        for cut in [whole.len() / 2, whole.len() - 9, whole.len() - 1] {
            let recording =
                recordings::formats::mcap::parse(&whole[..cut], std::path::Path::new("trace.mcap"));
            let samples = recording.map_or(0, |recording| recording.samples.len());
            assert!(samples <= all);
        }
        assert!(
            recordings::formats::mcap::parse(
                b"\x89MCAP0\r\nnothing",
                std::path::Path::new("trace.mcap")
            )
            .is_err()
        );
    }
}
