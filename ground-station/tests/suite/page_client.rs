//! A client that speaks to the station as its page does.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use tokio::net::TcpStream as AsyncStream;
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};

type Socket = WebSocketStream<MaybeTlsStream<AsyncStream>>;

/// How often a page asks to steer before it gives up.
const TRIES: usize = 20;

/// A page that is open. It reads all the time, as a browser does, and says with each request which
/// state it has read last.
pub(crate) struct PageClient {
    to_station: SplitSink<Socket, Message>,
    states: watch::Receiver<Value>,
    reader: JoinHandle<()>,
    /// The number of the last request.
    seq: u64,
    pub(crate) page: u64,
    /// The floor plan that the station gave the page.
    pub(crate) plan: Value,
}

/// Sends a request and returns the whole answer.
pub(crate) fn get(at: SocketAddr, path: &str, headers: &[&str]) -> String {
    let mut stream = TcpStream::connect(at).unwrap();
    let lines: String = headers.iter().map(|line| format!("{line}\r\n")).collect();
    write!(stream, "GET {path} HTTP/1.1\r\n{lines}Connection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

/// The session token in the station's page.
pub(crate) fn session(at: SocketAddr) -> String {
    let page = get(at, "/", &[&format!("Host: {at}")]);
    let (_, rest) = page.split_once("name=\"session\" content=\"").expect(&page);
    rest.split_once('"').unwrap().0.to_owned()
}

/// The next message of the station; `None` where it has closed the page.
async fn next(from_station: &mut SplitStream<Socket>) -> Option<Value> {
    loop {
        if let Message::Text(text) = from_station.next().await?.ok()? {
            return Some(serde_json::from_str(&text).unwrap());
        }
    }
}

impl Drop for PageClient {
    fn drop(&mut self) {
        self.reader.abort();
    }
}

impl PageClient {
    /// Opens a page.
    pub(crate) async fn open(at: SocketAddr) -> Self {
        let url = format!("ws://{at}/live?session={}", session(at));
        let (to_station, mut from_station) = connect_async(url).await.unwrap().0.split();
        let mut welcome = next(&mut from_station).await.expect("the station has closed the page");
        let (page, plan) = (welcome["page"].as_u64().unwrap(), welcome["plan"].take());
        let (put, states) = watch::channel(Value::Null);
        let reader = tokio::spawn(async move {
            while let Some(state) = next(&mut from_station).await {
                put.send_replace(state);
            }
        });
        Self { to_station, states, reader, seq: 0, page, plan }
    }

    /// Sends a request of the page, as an act of this moment.
    pub(crate) async fn send(&mut self, request: &str) {
        // The stamp of a test that was held up would be old.
        self.next().await;
        self.send_now(request).await;
    }

    /// Sends a request with the stamp of the last state, however old that is.
    pub(crate) async fn send_now(&mut self, request: &str) {
        self.seq += 1;
        let mut request: Value = serde_json::from_str(request).unwrap();
        request["stamp"] = self.states.borrow()["stamp"].clone();
        request["seq"] = json!(self.seq);
        self.send_as_it_is(&request.to_string()).await;
    }

    /// Sends a request that says nothing about its time.
    pub(crate) async fn send_as_it_is(&mut self, request: &str) {
        self.to_station.send(Message::Text(request.into())).await.unwrap();
    }

    async fn next(&mut self) -> Value {
        self.states.changed().await.expect("the station has closed the page");
        self.states.borrow_and_update().clone()
    }

    /// Shows signs of life until the state of the station is as it must be; returns that state.
    pub(crate) async fn wait_for(&mut self, what: &str, is_it: impl Fn(&Value) -> bool) -> Value {
        let within = Duration::from_secs(60);
        let shown = self.shows(within, is_it).await;
        shown.unwrap_or_else(|last| panic!("within a minute there was no {what}: {last:#}"))
    }

    /// Shows signs of life until the state of the station is as it must be, and returns that state; the last
    /// one where none is for so long.
    async fn shows(
        &mut self,
        within: Duration,
        is_it: impl Fn(&Value) -> bool,
    ) -> Result<Value, Value> {
        let mut last = Value::Null;
        let waiting = async {
            loop {
                last = self.next().await;
                self.send_now("{\"do\":\"beat\"}").await;
                if is_it(&last) {
                    return;
                }
            }
        };
        match tokio::time::timeout(within, waiting).await {
            Ok(()) => Ok(last),
            Err(_) => Err(last),
        }
    }

    /// Asks to steer until the page does: on a machine that is busy a request may arrive too late, and the
    /// station asks for it again.
    pub(crate) async fn steer(&mut self) {
        let page = self.page;
        let steers = |status: &Value| status["steering"] == page;
        for _ in 0..TRIES {
            self.send(r#"{"do":"steer"}"#).await;
            if self.shows(Duration::from_secs(3), steers).await.is_ok() {
                return;
            }
        }
        self.wait_for("page that steers", steers).await;
    }

    /// Waits until the station knows the four drones of the simulated chain.
    pub(crate) async fn wait_for_chain(&mut self) {
        self.wait_for("chain of four drones", |status| {
            status["drones"].as_array().is_some_and(|drones| drones.len() == 4)
        })
        .await;
    }

    /// Waits until the head is in the air.
    pub(crate) async fn wait_for_flight(&mut self) {
        self.wait_for("head in the air", |status| status["drones"][0]["airborne"] == true).await;
    }
}
