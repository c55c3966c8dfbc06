//! Speaks to a viewer by Foxglove's WebSocket protocol: it names the channels, and sends the messages
//! of those to which the viewer subscribes.
//!
//! Of the [protocol](https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md) this is the part
//! that every server has; a viewer can order nothing. With a subscription comes the channel's last
//! message, so that a viewer sees the plan and the limits that were known before it came.

use std::collections::BTreeMap;
use std::sync::Arc;

use axum::extract::ws::{Message, WebSocket};
use serde::Deserialize;
use serde_json::{Value, json};
use tokio::sync::broadcast::error::RecvError;
use tokio::time::{Instant, interval, timeout};

use crate::live_stream::{Channel, LiveStream, Sample, Topic};
use crate::page_socket::{PING, SILENCE, WRITE};

/// The names under which viewers ask for the protocol: that of Foxglove's SDK, and the one before.
/// What is spoken here is the same in both.
pub const PROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];

/// The first byte of a binary message that carries a channel's message.
const MESSAGE_DATA: u8 = 1;

/// How grave the text of a `status` is.
#[derive(Clone, Copy, Debug)]
enum Level {
    Warning = 1,
    Error = 2,
}

/// A request of a viewer.
#[derive(Debug, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
enum Request {
    Subscribe {
        subscriptions: Vec<Subscription>,
    },
    #[serde(rename_all = "camelCase")]
    Unsubscribe {
        subscription_ids: Vec<u32>,
    },
}

/// A viewer's wish for the messages of a channel, under a number of the viewer's own.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Subscription {
    id: u32,
    channel_id: u32,
}

/// What one viewer has been told, and what it has asked for.
#[derive(Debug, Default)]
struct Viewer {
    /// The last message of each channel that the viewer knows, if there was one.
    known: BTreeMap<u32, Option<Sample>>,
    /// The number of the subscription to each channel that has one.
    subscribed: BTreeMap<u32, u32>,
}

/// Attends to a viewer until it goes away, takes no more or says nothing more.
pub async fn attend(mut socket: WebSocket, stream: &LiveStream) {
    let (topics, mut samples) = stream.join();
    let mut viewer = Viewer::default();
    let mut answers = vec![server_info(), viewer.learn(topics)];
    let mut pings = interval(PING);
    let mut heard = Instant::now();
    loop {
        for answer in answers {
            let Ok(Ok(())) = timeout(WRITE, socket.send(answer)).await else { return };
        }
        answers = tokio::select! {
            message = socket.recv() => {
                heard = Instant::now();
                match message {
                    Some(Ok(Message::Text(text))) => viewer.heed(&text),
                    Some(Ok(Message::Binary(_))) => vec![status(Level::Error, "nothing can be published here")],
                    Some(Ok(Message::Ping(_) | Message::Pong(_))) => Vec::new(),
                    Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                }
            }
            _ = pings.tick() => {
                if heard.elapsed() >= SILENCE {
                    return;
                }
                vec![Message::Ping(Vec::new().into())]
            }
            sample = samples.recv() => match sample {
                Ok(sample) => viewer.show(sample),
                Err(RecvError::Lagged(lost)) => {
                    vec![status(Level::Warning, &format!("{lost} messages were lost: the viewer is too slow"))]
                }
                Err(RecvError::Closed) => return,
            },
        };
    }
}

impl Viewer {
    /// Names channels, which are new to the viewer.
    fn learn(&mut self, topics: Vec<Topic>) -> Message {
        let channels: Vec<_> = topics.iter().map(|topic| advertised(&topic.channel)).collect();
        self.known.extend(topics.into_iter().map(|topic| (topic.channel.id, topic.last)));
        text(&json!({ "op": "advertise", "channels": channels }))
    }

    /// Takes a message of the stream.
    fn show(&mut self, sample: Sample) -> Vec<Message> {
        let channel = Arc::clone(&sample.channel);
        if !self.known.contains_key(&channel.id) {
            return vec![self.learn(vec![Topic { channel, last: Some(sample) }])];
        }
        let message = self.subscribed.get(&channel.id).map(|id| data(*id, &sample));
        self.known.insert(channel.id, Some(sample));
        message.into_iter().collect()
    }

    /// Takes a request of the viewer.
    fn heed(&mut self, request: &str) -> Vec<Message> {
        match serde_json::from_str(request) {
            Ok(Request::Subscribe { subscriptions }) => {
                subscriptions.into_iter().filter_map(|wish| self.subscribe(wish)).collect()
            }
            Ok(Request::Unsubscribe { subscription_ids }) => {
                self.subscribed.retain(|_, id| !subscription_ids.contains(id));
                Vec::new()
            }
            Err(error) => vec![status(Level::Error, &format!("not understood: {error}"))],
        }
    }

    /// Begins a subscription. Returns the channel's last message, if there was one, or what is wrong.
    fn subscribe(&mut self, Subscription { id, channel_id }: Subscription) -> Option<Message> {
        let Some(last) = self.known.get(&channel_id) else {
            return Some(status(Level::Error, &format!("there is no channel {channel_id}")));
        };
        if self.subscribed.contains_key(&channel_id) {
            let wrong = format!("channel {channel_id} has its subscription");
            return Some(status(Level::Warning, &wrong));
        }
        self.subscribed.insert(channel_id, id);
        last.as_ref().map(|sample| data(id, sample))
    }
}

fn text(message: &Value) -> Message {
    Message::Text(message.to_string().into())
}

fn server_info() -> Message {
    text(&json!({ "op": "serverInfo", "name": "uchain-ground", "capabilities": [] }))
}

fn status(level: Level, message: &str) -> Message {
    text(&json!({ "op": "status", "level": level as u8, "message": message }))
}

fn advertised(channel: &Channel) -> Value {
    let (name, schema) = channel.schema;
    json!({
        "id": channel.id,
        "topic": channel.topic,
        "encoding": "json",
        "schemaName": name,
        "schema": schema,
        "schemaEncoding": "jsonschema",
    })
}

/// Message data: the subscription, the time in ns, and the message.
fn data(subscription: u32, sample: &Sample) -> Message {
    let mut bytes = Vec::with_capacity(1 + 4 + 8 + sample.json.len());
    bytes.push(MESSAGE_DATA);
    bytes.extend(subscription.to_le_bytes());
    bytes.extend(sample.nanos.to_le_bytes());
    bytes.extend(sample.json.iter());
    Message::Binary(bytes.into())
}
