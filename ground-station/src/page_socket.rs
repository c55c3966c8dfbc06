//! Attends to the socket of a page: reads what the page asks for, and writes the states to it.
//!
//! Reading and writing do not wait for each other. A page that stops reading fills the buffers of
//! the line, after which nothing can be written to it; it is written to no more after [`WRITE`], and
//! it steers no more, since it echoes no fresh stamp. What it sends is still read, so that its stop
//! is heard. Where nothing has come from it for [`SILENCE`], its socket is closed.

use std::time::Duration;

use axum::extract::ws::{Message, WebSocket};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use tokio::time::{MissedTickBehavior, interval, timeout};

use crate::freshness::Echo;
use crate::station::{Handle, Request};
use crate::steering::PageId;

/// The time that a message may take to be written; the buffers of a line hold many messages.
pub const WRITE: Duration = Duration::from_secs(5);
/// The time after which a socket from which nothing has come is closed. A browser answers a ping
/// even where it has slowed down the timers of a hidden page.
pub const SILENCE: Duration = Duration::from_secs(20);
/// The time between two pings.
pub const PING: Duration = Duration::from_secs(5);

/// Attends to a page until it is closed or silent.
pub async fn attend(socket: WebSocket, page: PageId, station: &Handle) {
    let (to_page, from_page) = socket.split();
    let written = async {
        write(to_page, page, station).await;
        std::future::pending().await
    };
    tokio::select! {
        () = read(from_page, page, station) => {}
        () = written => {}
    }
}

/// Gives the page's requests to the station.
async fn read(mut socket: SplitStream<WebSocket>, page: PageId, station: &Handle) {
    while let Ok(Some(Ok(message))) = timeout(SILENCE, socket.next()).await {
        match message {
            Message::Text(text) => {
                let echo = serde_json::from_str::<Echo>(&text);
                // A message that is no request comes from no page of this station.
                let (Ok(echo), Ok(request)) = (echo, serde_json::from_str::<Request>(&text)) else {
                    return;
                };
                station.send(page, echo, request).await;
            }
            Message::Close(_) => return,
            Message::Binary(_) | Message::Ping(_) | Message::Pong(_) => {}
        }
    }
}

/// Writes the states to the page, until it takes no more.
async fn write(mut socket: SplitSink<WebSocket, Message>, page: PageId, station: &Handle) {
    let mut status = station.status();
    let mut pings = interval(PING);
    pings.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let welcome = format!(
        "{{\"page\":{},\"plan\":{},\"links\":{}}}",
        page.0,
        station.plan(),
        station.links().json()
    );
    let mut next = Message::Text(welcome.into());
    while let Ok(Ok(())) = timeout(WRITE, socket.send(next)).await {
        next = tokio::select! {
            changed = status.changed() => {
                if changed.is_err() {
                    return;
                }
                Message::Text(status.borrow_and_update().to_string().into())
            }
            _ = pings.tick() => Message::Ping(Vec::new().into()),
        };
    }
}
