//! Gives what the station hears and orders to viewers as it happens: the messages of `station.mcap`.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use station_log::{BaseReport, Limits, Line, OrderEvent, Plan, Schema};
use tokio::sync::broadcast;

use crate::message::{Message, Record};

/// The number of messages that may wait for a slow viewer; older ones are lost to it. A chain of
/// fifteen drones makes some thirty a second.
const WAITING: usize = 1024;

/// A topic, which all viewers know by its number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// The number, from 1.
    pub id: u32,
    /// The topic.
    pub topic: String,
    /// The schema of its messages.
    pub schema: Schema,
}

/// A message on its way to viewers.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The channel.
    pub channel: Arc<Channel>,
    /// The time since 1970 in ns.
    pub nanos: u64,
    /// The message.
    pub json: Arc<[u8]>,
}

/// A topic and its last message, if there was one.
#[derive(Clone, Debug)]
pub struct Topic {
    /// The topic as viewers know it.
    pub channel: Arc<Channel>,
    /// The last message.
    pub last: Option<Sample>,
}

/// The stream.
#[derive(Debug)]
pub struct LiveStream {
    /// It is locked while a message goes to the viewers, so that one who joins misses none and is given
    /// none twice.
    topics: Mutex<Vec<Topic>>,
    viewers: broadcast::Sender<Sample>,
}

impl Default for LiveStream {
    /// A stream with all topics but those of drones, which are added as drones are heard: a viewer
    /// that subscribes at once misses nothing.
    fn default() -> Self {
        let topics = [
            (Plan::TOPIC, Plan::SCHEMA),
            (Limits::TOPIC, Limits::SCHEMA),
            (BaseReport::TOPIC, BaseReport::SCHEMA),
            (OrderEvent::TOPIC, OrderEvent::SCHEMA),
            (Line::NOTICE, Line::SCHEMA),
            (Line::CONSOLE, Line::SCHEMA),
        ];
        let stream = Self { topics: Mutex::default(), viewers: broadcast::Sender::new(WAITING) };
        for (topic, schema) in topics {
            find(&mut stream.lock(), topic, schema);
        }
        stream
    }
}

impl LiveStream {
    /// Gives a record to all viewers.
    pub fn put(&self, record: &Record) {
        // No value of these messages is one that JSON has not.
        let Ok(Message { topic, schema, json }) = Message::of(&record.event) else { return };
        let mut topics = self.lock();
        let found = find(&mut topics, &topic, schema);
        let nanos = u64::try_from(record.at.as_nanos()).unwrap_or(u64::MAX);
        let sample = Sample { channel: Arc::clone(&found.channel), nanos, json: json.into() };
        found.last = Some(sample.clone());
        // An error says that there is no viewer, and so none that lacks the message.
        let _ = self.viewers.send(sample);
    }

    /// All topics so far, and all messages that come from now on.
    pub fn join(&self) -> (Vec<Topic>, broadcast::Receiver<Sample>) {
        let topics = self.lock();
        (topics.clone(), self.viewers.subscribe())
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Topic>> {
        self.topics.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A topic of the list, which is added where it is new.
fn find<'a>(topics: &'a mut Vec<Topic>, topic: &str, schema: Schema) -> &'a mut Topic {
    let at = topics.iter().position(|known| known.channel.topic == topic).unwrap_or(topics.len());
    if at == topics.len() {
        let id = u32::try_from(at).unwrap_or(u32::MAX).saturating_add(1);
        let channel = Arc::new(Channel { id, topic: topic.to_owned(), schema });
        topics.push(Topic { channel, last: None });
    }
    &mut topics[at]
}
