//! Writes everything that was recorded to an MCAP file, as JSON messages with a schema.

use std::collections::BTreeMap;
use std::io::{self, Seek, Write};

use ::mcap::McapError;
use ::mcap::records::MessageHeader;
use ::mcap::write::{WriteOptions, Writer};
use station_log::Schema;

use crate::message::{Message, Record};

/// The file that is being written.
pub(super) struct Recording<W: Write + Seek> {
    writer: Writer<W>,
    /// The channel of each topic, with the number of its messages.
    channels: BTreeMap<String, (u16, u32)>,
    /// The records since the last flush. They go to the file together, as one whole chunk: a reader
    /// takes nothing from a chunk whose end is missing.
    waiting: Vec<Record>,
}

impl<W: Write + Seek> Recording<W> {
    pub(super) fn new(out: W) -> io::Result<Self> {
        let options = WriteOptions::new().library("uchain-ground").compression(None);
        let writer = options.create(out).map_err(io_error)?;
        let mut recording = Self { writer, channels: BTreeMap::new(), waiting: Vec::new() };
        recording.flush()?;
        Ok(recording)
    }

    pub(super) fn write(&mut self, record: Record) {
        self.waiting.push(record);
    }

    fn put(&mut self, record: &Record) -> io::Result<()> {
        let Message { topic, schema, json } = Message::of(&record.event)?;
        let (channel, sequence) = match self.channels.get(&topic) {
            Some(known) => *known,
            None => (self.add(&topic, schema).map_err(io_error)?, 0),
        };
        self.channels.insert(topic, (channel, sequence.wrapping_add(1)));
        let nanos = u64::try_from(record.at.as_nanos()).unwrap_or(u64::MAX);
        let header =
            MessageHeader { channel_id: channel, sequence, log_time: nanos, publish_time: nanos };
        self.writer.write_to_known_channel(&header, &json).map_err(io_error)
    }

    fn add(&mut self, topic: &str, (name, schema): Schema) -> Result<u16, McapError> {
        let schema = self.writer.add_schema(name, "jsonschema", schema.as_bytes())?;
        self.writer.add_channel(schema, topic, "json", &BTreeMap::new())
    }

    /// Ends the chunk: what was written so far can be read when the station is killed.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        for record in std::mem::take(&mut self.waiting) {
            self.put(&record)?;
        }
        self.writer.flush().map_err(io_error)
    }

    pub(super) fn finish(&mut self) -> io::Result<()> {
        self.flush()?;
        self.writer.finish().map(|_| ()).map_err(io_error)
    }
}

fn io_error(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::io::Cursor;
    use std::time::Duration;

    use ::mcap::MessageStream;
    use ::mcap::read::Options;
    use serde_json::{Value, json};
    use station_log::{Plan, PlanLine};

    use super::*;
    use crate::message::Event;
    use crate::order::{Fate, Order, Way};

    /// The messages that a reader finds in these bytes, whose end may be missing.
    fn read(bytes: &[u8]) -> Vec<(String, u64, Value)> {
        let stream = MessageStream::new_with_options(bytes, Options::IgnoreEndMagic.into());
        stream
            .into_iter()
            .flatten()
            .map_while(Result::ok)
            .map(|message| {
                let value = serde_json::from_slice(&message.data).unwrap();
                (message.channel.topic.clone(), message.log_time, value)
            })
            .collect()
    }

    /// A flush ends a chunk: wherever the file ends after it, what was flushed can be read.
    #[test]
    fn a_killed_recording_keeps_what_was_flushed() {
        let mut file = Cursor::new(Vec::new());
        let mut recording = Recording::new(&mut file).unwrap();
        let line = |n: u64| Record {
            at: Duration::from_millis(n),
            event: Event::Notice(format!("line {n}")),
        };
        (0..5).for_each(|n| recording.write(line(n)));
        recording.flush().unwrap();
        (5..9).for_each(|n| recording.write(line(n)));
        recording.finish().unwrap();
        drop(recording);
        let bytes = file.into_inner();
        assert_eq!(read(&bytes).len(), 9);
        let first = (0..bytes.len()).find(|end| read(&bytes[..*end]).len() >= 5).unwrap();
        for end in first..bytes.len() {
            let messages = read(&bytes[..end]);
            assert!(messages.len() >= 5, "{end}");
            let wanted = ("/notice".to_owned(), 4_000_000, json!({ "text": "line 4" }));
            assert_eq!(messages[4], wanted);
        }
    }

    /// One of each event, with every field that it can have.
    fn events() -> Vec<Event> {
        let report = crate::blocks::DroneReport {
            state: 4,
            fault: 20,
            age: units::Duration::ZERO,
            battery: Some(units::Volts(3.9)),
            endurance: Some(units::Duration::from_secs(90)),
            back: Some((units::NodeId(3), units::Dbm(-61.5))),
            odometer: units::Metres(12.5),
        };
        let facts = crate::session::Facts {
            node: units::NodeId(4),
            launch_limit: units::Dbm(-70.0),
            retreat_limit: units::Dbm(-76.0),
        };
        let line = PlanLine { name: "main".into(), points: vec![[0.0, 0.0], [9.5, 0.0]] };
        let plan = Plan { outlines: vec![vec![[0.0, 1.0]; 3]], lines: vec![line], base_m: 0.5 };
        vec![
            Event::Map(plan),
            Event::Limits(facts),
            Event::Base(crate::blocks::BaseReport { link: 2, recalled: false, refused: 1 }),
            Event::Drone(units::NodeId(1), report),
            Event::Console("hello".into()),
            Event::Notice("hello".into()),
            Event::Ordered(Order::Explore { speed: 0.25 }),
            Event::Fate(Order::Branch { way: Way::Left }, Fate::Taken),
            Event::Stop,
            Event::GaveUp,
        ]
    }

    /// Whether a value is of a JSON Schema of the kind that these messages have.
    fn fits(value: &Value, schema: &Value) -> bool {
        match schema["type"].as_str().unwrap() {
            "object" => value.as_object().unwrap().iter().all(|(key, value)| {
                schema["properties"].get(key).is_some_and(|schema| fits(value, schema))
            }),
            "array" => value.as_array().unwrap().iter().all(|each| fits(each, &schema["items"])),
            "string" => value.is_string(),
            "boolean" => value.is_boolean(),
            "integer" => value.is_u64(),
            "number" => value.is_number(),
            other => panic!("{other}"),
        }
    }

    /// What Foxglove asks of an MCAP file with JSON messages
    /// (<https://docs.foxglove.dev/docs/getting-started/frameworks/json>): a summary with chunk
    /// indexes, each channel with messages in JSON and a JSON Schema whose root is an object, and
    /// messages that are of that schema.
    #[test]
    fn a_recording_is_as_foxglove_reads_it() {
        let mut file = Cursor::new(Vec::new());
        let mut recording = Recording::new(&mut file).unwrap();
        for (ms, event) in (0..).zip(events()) {
            recording.write(Record { at: Duration::from_millis(ms), event });
        }
        recording.finish().unwrap();
        drop(recording);
        let bytes = file.into_inner();
        let summary = ::mcap::Summary::read(&bytes).unwrap().unwrap();
        assert_eq!(summary.stats.unwrap().message_count, events().len() as u64);
        assert!(!summary.chunk_indexes.is_empty());
        let mut topics = BTreeSet::new();
        let mut before = 0;
        for message in MessageStream::new(&bytes).unwrap().map(Result::unwrap) {
            let (channel, schema) = (&message.channel, message.channel.schema.as_ref().unwrap());
            assert_eq!((&*channel.message_encoding, &*schema.encoding), ("json", "jsonschema"));
            let schema: Value = serde_json::from_slice(&schema.data).unwrap();
            assert_eq!(schema["type"], "object");
            let value: Value = serde_json::from_slice(&message.data).unwrap();
            assert!(fits(&value, &schema), "{}: {value}", channel.topic);
            assert!(message.log_time >= before);
            before = message.log_time;
            topics.insert(channel.topic.clone());
        }
        let wanted =
            ["/base", "/console", "/drone/1/report", "/limits", "/map", "/notice", "/order"];
        assert_eq!(topics, wanted.map(str::to_owned).into());
    }
}
