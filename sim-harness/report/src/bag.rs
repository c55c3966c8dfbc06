//! Makes the messages of ROS 2 of a mission, for programs that listen while it is flown ([`Messages`]), and
//! writes them as a bag: `bag.mcap`, whose messages are in CDR with their definitions in
//! the file, and `metadata.yaml`, which makes the folder a bag of rosbag2.
//!
//! Times are those of the mission, as in `trace.mcap`: one trace makes one bag. The book's chapter "What a
//! run leaves behind" lists the topics.

mod content;
mod grid;
mod metadata;
mod topics;

use std::collections::BTreeMap;
use std::io::{self, Seek, Write};

use ::mcap::McapError;
use ::mcap::records::MessageHeader;
use ::mcap::write::{WriteOptions, Writer};

use crate::mcap::Moment;
use metadata::{Known, qos};
use mission::trace::{Frame, Trace};
use ros2_topics::messages::schema;
use ros2_topics::{About, Sink};
pub use topics::{Messages, Place};

/// The name of the file with the messages.
pub(crate) const BAG: &str = "bag.mcap";

/// What CDR in the order of bytes of little-endian machines begins with (DDSI-RTPS 2.5, table 10.3).
const LITTLE_ENDIAN: [u8; 4] = [0, 1, 0, 0];

/// The bag of a mission that is still flown.
pub(crate) struct BagFile<W: Write + Seek> {
    recording: Recording<W>,
    messages: Messages,
}

impl<W: Write + Seek> BagFile<W> {
    /// Begins the bag of a mission.
    pub(crate) fn new(trace: &Trace, place: Place, out: W) -> io::Result<Self> {
        let mut recording = Recording::new(out)?;
        let messages = Messages::new(trace, place, &mut recording)?;
        Ok(Self { recording, messages })
    }

    /// Adds a frame.
    pub(crate) fn frame(&mut self, trace: &Trace, frame: &Frame) -> io::Result<()> {
        self.messages.frame(&mut self.recording, trace, frame)
    }

    /// Ends the file; returns it, and the text of `metadata.yaml`.
    pub(crate) fn finish(mut self, trace: &Trace) -> io::Result<(W, String)> {
        self.messages.finish(&mut self.recording)?;
        self.recording.writer.finish().map_err(as_io)?;
        let text = metadata::text(trace, &self.recording.topics, self.recording.span);
        Ok((self.recording.writer.into_inner(), text))
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
}

impl<W: Write + Seek> Sink for Recording<W> {
    fn topic(&mut self, about: &About<'_>) -> io::Result<usize> {
        let &About { name, kind, is_latched } = about;
        let text = schema(kind);
        let schema = self.writer.add_schema(kind, "ros2msg", text.as_bytes()).map_err(as_io)?;
        let about = BTreeMap::from([("offered_qos_profiles".to_owned(), qos(is_latched, 0))]);
        let channel = self.writer.add_channel(schema, name, "cdr", &about).map_err(as_io)?;
        self.channels.push(channel);
        self.topics.push(Known { name: name.to_owned(), kind, is_latched, count: 0 });
        Ok(self.topics.len() - 1)
    }

    fn put(&mut self, topic: usize, at_us: u64, cdr: &[u8]) -> io::Result<()> {
        let at = Moment { micros: at_us };
        let known = &mut self.topics[topic];
        let header = MessageHeader {
            channel_id: self.channels[topic],
            sequence: known.count,
            log_time: at.nanos(),
            publish_time: at.nanos(),
        };
        known.count = known.count.wrapping_add(1);
        let bytes = [&LITTLE_ENDIAN, cdr].concat();
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
    use scenario::Scenario;

    use super::topics::{DIAGNOSTICS_EVERY, PATHS_EVERY};
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
}
