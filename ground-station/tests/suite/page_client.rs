//! A client that speaks to the station as its page does.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use serde_json::Value;
use tokio::net::TcpStream as AsyncStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};

/// A page that is open.
pub(crate) struct PageClient {
    socket: WebSocketStream<MaybeTlsStream<AsyncStream>>,
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

impl PageClient {
    /// Opens a page.
    pub(crate) async fn open(at: SocketAddr) -> Self {
        let (socket, _) =
            connect_async(format!("ws://{at}/live?session={}", session(at))).await.unwrap();
        let mut client = Self { socket, page: 0, plan: Value::Null };
        let mut welcome = client.next().await;
        client.page = welcome["page"].as_u64().unwrap();
        client.plan = welcome["plan"].take();
        client
    }

    /// Sends a request of the page.
    pub(crate) async fn send(&mut self, request: &str) {
        self.socket.send(Message::Text(request.into())).await.unwrap();
    }

    async fn next(&mut self) -> Value {
        loop {
            let message =
                self.socket.next().await.expect("the station has closed the page").unwrap();
            if let Message::Text(text) = message {
                return serde_json::from_str(&text).unwrap();
            }
        }
    }

    /// Shows signs of life until the state of the station is as it must be; returns that state.
    pub(crate) async fn wait_for(&mut self, what: &str, is_it: impl Fn(&Value) -> bool) -> Value {
        let mut last = Value::Null;
        let waiting = async {
            loop {
                self.send("{\"do\":\"beat\"}").await;
                last = self.next().await;
                if is_it(&last) {
                    return;
                }
            }
        };
        let in_time = tokio::time::timeout(Duration::from_secs(60), waiting).await.is_ok();
        assert!(in_time, "within a minute there was no {what}: {last:#}");
        last
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
