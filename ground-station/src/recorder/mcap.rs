//! Writes everything that was recorded to an MCAP file, as JSON messages with a schema.

use std::collections::BTreeMap;
use std::io::{self, Seek, Write};

use ::mcap::McapError;
use ::mcap::records::MessageHeader;
use ::mcap::write::{WriteOptions, Writer};
use serde_json::{Value, json};

use super::{Event, Record, Row};

/// The schemas, by name, as JSON Schema.
const DRONE: (&str, &str) = (
    "uchain.DroneReport",
    r#"{"type":"object","properties":{"node":{"type":"integer"},"state":{"type":"string"},"fault":{"type":"string"},"battery_v":{"type":"number"},"endurance_s":{"type":"number"},"odometer_m":{"type":"number"},"back":{"type":"integer"},"rssi_dbm":{"type":"number"}}}"#,
);
const BASE: (&str, &str) = (
    "uchain.BaseReport",
    r#"{"type":"object","properties":{"link":{"type":"string"},"recalled":{"type":"boolean"},"refused":{"type":"integer"}}}"#,
);
const LINE: (&str, &str) =
    ("uchain.Line", r#"{"type":"object","properties":{"text":{"type":"string"}}}"#);
const ORDER: (&str, &str) = (
    "uchain.Order",
    r#"{"type":"object","properties":{"event":{"type":"string"},"order":{"type":"object"},"fate":{"type":"string"}}}"#,
);

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
        let (topic, schema, message) = message(&record.event);
        let (channel, sequence) = match self.channels.get(&topic) {
            Some(known) => *known,
            None => (self.add(&topic, schema).map_err(io_error)?, 0),
        };
        self.channels.insert(topic, (channel, sequence.wrapping_add(1)));
        let nanos = u64::try_from(record.at.as_nanos()).unwrap_or(u64::MAX);
        let header =
            MessageHeader { channel_id: channel, sequence, log_time: nanos, publish_time: nanos };
        let bytes = serde_json::to_vec(&message)?;
        self.writer.write_to_known_channel(&header, &bytes).map_err(io_error)
    }

    fn add(&mut self, topic: &str, (name, schema): (&str, &str)) -> Result<u16, McapError> {
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

/// The topic, the schema and the message of an event.
fn message(event: &Event) -> (String, (&'static str, &'static str), Value) {
    let order = |message| ("/order".to_owned(), ORDER, message);
    match event {
        Event::Drone(node, report) => {
            (format!("/drone/{node}/report"), DRONE, json!(Row::of(*node, report)))
        }
        Event::Base(base) => (
            "/base".to_owned(),
            BASE,
            json!({ "link": crate::words::link(base.link), "recalled": base.recalled, "refused": base.refused }),
        ),
        Event::Console(text) => ("/console".to_owned(), LINE, json!({ "text": text })),
        Event::Notice(text) => ("/notice".to_owned(), LINE, json!({ "text": text })),
        Event::Ordered(given) => order(json!({ "event": "ordered", "order": given })),
        Event::Fate(given, fate) => {
            order(json!({ "event": "answered", "order": given, "fate": fate }))
        }
        Event::Stop => order(json!({ "event": "stop" })),
        Event::GaveUp => order(json!({ "event": "gave up waiting for answers to the stop" })),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;
    use std::time::Duration;

    use ::mcap::MessageStream;
    use ::mcap::read::Options;

    use super::*;

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

    #[test]
    fn every_schema_is_json() {
        for (name, schema) in [DRONE, BASE, LINE, ORDER] {
            let schema: Value = serde_json::from_str(schema).unwrap();
            assert_eq!(schema["type"], "object", "{name}");
        }
    }
}
