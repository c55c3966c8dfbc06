//! The live stream for Foxglove, read as its protocol has it:
//! <https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md>.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use mcap::MessageStream;
use mcap::read::Options;
use serde_json::{Value, json};
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::{self, Message};
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};

use crate::page_client::PageClient;
use crate::simulated_chain::SimulatedChain;
use crate::station_process::StationProcess;

/// No base listens there.
const NO_BASE: &str = "udp://127.0.0.1:9";
const SDK: &str = "foxglove.sdk.v1";
const CLASSIC: &str = "foxglove.websocket.v1";

/// A viewer of the stream.
struct Viewer {
    socket: WebSocketStream<MaybeTlsStream<TcpStream>>,
    /// The channels that were named, by number.
    channels: BTreeMap<u64, Value>,
    /// The messages that came, by topic: time in ns and JSON.
    messages: BTreeMap<String, Vec<(u64, Value)>>,
    /// The texts of `status`.
    status: Vec<String>,
}

impl Viewer {
    /// Connects, with these protocols, this query and this origin.
    async fn open(
        at: SocketAddr,
        protocols: &str,
        query: &str,
        origin: Option<&str>,
    ) -> tungstenite::Result<Self> {
        let mut request = format!("ws://{at}/foxglove{query}").into_client_request()?;
        let headers = request.headers_mut();
        headers.insert("sec-websocket-protocol", protocols.parse().unwrap());
        if let Some(origin) = origin {
            headers.insert("origin", origin.parse().unwrap());
        }
        let (socket, _) = connect_async(request).await?;
        let (channels, messages, status) = Default::default();
        let mut viewer = Self { socket, channels, messages, status };
        let hello = viewer.text().await;
        assert_eq!(hello["op"], "serverInfo", "{hello}");
        assert_eq!(hello["capabilities"], json!([]));
        Ok(viewer)
    }

    async fn send(&mut self, request: Value) {
        self.socket.send(Message::Text(request.to_string().into())).await.unwrap();
    }

    async fn text(&mut self) -> Value {
        let message = self.socket.next().await.unwrap().unwrap();
        serde_json::from_str(message.to_text().unwrap()).unwrap()
    }

    /// Takes one message; subscribes to channels that are new, under ten times their number.
    async fn take(&mut self) {
        match self.socket.next().await.expect("the station has closed the stream").unwrap() {
            Message::Text(text) => {
                let message: Value = serde_json::from_str(&text).unwrap();
                match message["op"].as_str().unwrap() {
                    "advertise" => self.learn(message["channels"].as_array().unwrap()).await,
                    "status" => {
                        self.status.push(message["message"].as_str().unwrap().to_owned());
                    }
                    other => panic!("{other}"),
                }
            }
            Message::Binary(bytes) => {
                let (subscription, rest) = bytes[1..].split_first_chunk().unwrap();
                let (nanos, json) = rest.split_first_chunk().unwrap();
                assert_eq!(bytes[0], 1, "the code of message data");
                let channel = u64::from(u32::from_le_bytes(*subscription) / 10);
                let topic = self.channels[&channel]["topic"].as_str().unwrap().to_owned();
                let message = (u64::from_le_bytes(*nanos), serde_json::from_slice(json).unwrap());
                self.messages.entry(topic).or_default().push(message);
            }
            _ => {}
        }
    }

    async fn learn(&mut self, channels: &[Value]) {
        let mut subscriptions = Vec::new();
        for channel in channels {
            let id = channel["id"].as_u64().unwrap();
            assert_eq!(channel["encoding"], "json");
            assert_eq!(channel["schemaEncoding"], "jsonschema");
            let schema: Value = serde_json::from_str(channel["schema"].as_str().unwrap()).unwrap();
            assert_eq!(schema["type"], "object");
            assert!(self.channels.insert(id, channel.clone()).is_none(), "{id} was named twice");
            subscriptions.push(json!({ "id": 10 * id, "channelId": id }));
        }
        self.send(json!({ "op": "subscribe", "subscriptions": subscriptions })).await;
    }

    async fn take_until(&mut self, what: &str, is_it: impl Fn(&Self) -> bool) {
        let taking = async {
            while !is_it(self) {
                self.take().await;
            }
        };
        let in_time = tokio::time::timeout(Duration::from_secs(60), taking).await.is_ok();
        assert!(in_time, "within a minute there was no {what}: {:#?}", self.messages);
    }

    fn has(&self, topic: &str, text: &str) -> bool {
        let messages = self.messages.get(topic).into_iter().flatten();
        messages.into_iter().any(|(_, message)| message.to_string().contains(text))
    }
}

/// The messages of a recording, by topic.
fn recorded(file: &std::path::Path) -> BTreeMap<String, Vec<(u64, Value)>> {
    let bytes = std::fs::read(file).unwrap();
    let mut topics: BTreeMap<_, Vec<_>> = BTreeMap::new();
    let stream = MessageStream::new_with_options(&bytes, Options::IgnoreEndMagic.into());
    for message in stream.unwrap().map_while(Result::ok) {
        let json = serde_json::from_slice(&message.data).unwrap();
        let of_topic = topics.entry(message.channel.topic.clone()).or_default();
        of_topic.push((message.log_time, json));
    }
    topics
}

/// Waits until a recording has the last message of each topic: the station sends a message to its
/// viewers before it is in the file.
async fn wait_until_recorded(
    file: &std::path::Path,
    messages: &BTreeMap<String, Vec<(u64, Value)>>,
) {
    let waiting = async {
        loop {
            let recorded = recorded(file);
            let is_recorded = |(topic, of_topic): (&String, &Vec<(u64, Value)>)| {
                recorded.get(topic).is_some_and(|there| of_topic.iter().all(|m| there.contains(m)))
            };
            if messages.iter().all(is_recorded) {
                return;
            }
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    };
    let in_time = tokio::time::timeout(Duration::from_secs(60), waiting).await.is_ok();
    assert!(in_time, "within a minute not every message was recorded");
}

/// A viewer is given the very messages that are recorded, with their times, from the last one of each
/// topic on that was there before it came.
#[tokio::test]
async fn a_viewer_is_given_what_is_recorded() {
    let chain = SimulatedChain::demo();
    let recording = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("foxglove");
    let _ = std::fs::remove_dir_all(&recording);
    let options = ["--map", "demo", "--record", recording.to_str().unwrap()];
    let station = StationProcess::start(&chain.address(), &options);
    let mut page = PageClient::open(station.page).await;
    page.wait_for_chain().await;
    let mut viewer = Viewer::open(station.page, SDK, "", None).await.unwrap();
    viewer.take_until("plan", |viewer| viewer.has("/map", "outlines")).await;
    page.send(r#"{"do":"order","order":"explore","speed":0.25}"#).await;
    page.wait_for_flight().await;
    page.send(r#"{"do":"stop"}"#).await;
    page.wait_for("answer of every drone", |status| status["stop"]["sending"] == "answered").await;
    let is_stopped = |viewer: &Viewer| {
        (0..4).all(|node| viewer.has(&format!("/drone/{node}/report"), "stopped"))
    };
    viewer.take_until("stopped drones", is_stopped).await;
    assert!(viewer.has("/order", "\"taken\"") && viewer.has("/limits", "launch_limit_dbm"));
    assert_eq!(viewer.status, Vec::<String>::new());
    drop(page);
    let file = recording.join("station.mcap");
    wait_until_recorded(&file, &viewer.messages).await;
    station.kill();
    let recorded = recorded(&file);
    for (topic, messages) in &viewer.messages {
        let first = recorded[topic].iter().position(|message| *message == messages[0]).unwrap();
        let same = &recorded[topic][first..][..messages.len()];
        assert_eq!(same, messages, "{topic}");
    }
}

/// The topics and fields that the layout for the station shows, such as `/drone/0/report.state`, and topics alone.
fn shown_by_the_layout() -> Vec<String> {
    let file =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../sim-harness/assets/viewers/foxglove/station.json");
    let layout: Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    let panels = layout["configById"].as_object().unwrap().values();
    let shown = panels.flat_map(|panel| {
        let paths = panel["paths"].as_array().into_iter().flatten().map(|path| &path["value"]);
        paths.chain(panel.get("topicPath")).map(|path| path.as_str().unwrap().to_owned())
    });
    shown.collect()
}

#[tokio::test]
async fn the_layout_shows_what_is_streamed() {
    let chain = SimulatedChain::demo();
    let station = StationProcess::start(&chain.address(), &["--map", "demo"]);
    let mut page = PageClient::open(station.page).await;
    page.wait_for_chain().await;
    page.send(r#"{"do":"order","order":"explore","speed":0.25}"#).await;
    page.wait_for_flight().await;
    let mut viewer = Viewer::open(station.page, SDK, "", None).await.unwrap();
    let drones =
        |viewer: &Viewer| (0..4).all(|n| viewer.has(&format!("/drone/{n}/report"), "state"));
    viewer.take_until("report of every drone", drones).await;
    let shown = shown_by_the_layout();
    assert!(shown.len() > 12, "{shown:?}");
    for path in shown {
        let (topic, field) = path.split_once('.').unwrap_or((path.as_str(), ""));
        let channel = viewer.channels.values().find(|channel| channel["topic"] == topic);
        let schema = channel.unwrap_or_else(|| panic!("no {topic}"))["schema"].as_str().unwrap();
        let schema: Value = serde_json::from_str(schema).unwrap();
        assert!(field.is_empty() || schema["properties"].get(field).is_some(), "{path}: {schema}");
    }
}

#[tokio::test]
async fn a_viewer_that_asks_for_what_is_not_there_is_told_so_and_is_served_on() {
    let station = StationProcess::start(NO_BASE, &["--map", "demo"]);
    let both = format!("{CLASSIC}, {SDK}");
    let mut viewer = Viewer::open(station.page, &both, "", None).await.unwrap();
    viewer.take_until("plan", |viewer| viewer.has("/map", "outlines")).await;
    let requests = [
        (
            json!({ "op": "subscribe", "subscriptions": [{ "id": 1, "channelId": 99 }] }),
            "channel 99",
        ),
        (
            json!({ "op": "subscribe", "subscriptions": [{ "id": 1, "channelId": 1 }] }),
            "channel 1 has",
        ),
        (json!({ "op": "advertise", "channels": [] }), "not understood"),
    ];
    for (n, (request, wrong)) in requests.into_iter().enumerate() {
        viewer.send(request).await;
        viewer.take_until("status", |viewer| viewer.status.len() > n).await;
        assert!(viewer.status[n].contains(wrong), "{:?}", viewer.status);
    }
    viewer.send(json!({ "op": "unsubscribe", "subscriptionIds": [10] })).await;
    viewer
        .send(json!({ "op": "subscribe", "subscriptions": [{ "id": 10, "channelId": 1 }] }))
        .await;
    viewer.take_until("plan anew", |viewer| viewer.messages["/map"].len() == 2).await;
}

#[tokio::test]
async fn viewers_are_let_in_as_the_page_is() {
    const SITE: Option<&str> = Some("https://app.foxglove.dev");
    let open = StationProcess::start(NO_BASE, &[]);
    assert!(Viewer::open(open.page, CLASSIC, "", None).await.is_ok());
    assert!(Viewer::open(open.page, "mqtt", "", None).await.is_err());
    assert!(Viewer::open(open.page, SDK, "", SITE).await.is_err());
    let locked = StationProcess::start(NO_BASE, &["--token", "fruit bats"]);
    for (query, let_in) in [("", false), ("?token=fruit+cats", false), ("?token=fruit+bats", true)]
    {
        for origin in [None, SITE] {
            let viewer = Viewer::open(locked.page, SDK, query, origin).await;
            assert_eq!(viewer.is_ok(), let_in, "{query} {origin:?}");
        }
    }
}
