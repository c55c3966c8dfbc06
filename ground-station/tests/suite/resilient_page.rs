//! A page that does with its line what `line.js` does: it connects anew where the line stalls, sends
//! no order without a fresh state, and keeps a stop until a state says that it was heard.

use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use tokio::net::TcpStream;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tokio::time::{interval, sleep, timeout};
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};

type Socket = WebSocketStream<MaybeTlsStream<TcpStream>>;

const BEAT: Duration = Duration::from_millis(250);
const FRESH: Duration = Duration::from_millis(500);
const PATIENCE: Duration = Duration::from_secs(2);
const MOST_PATIENCE: Duration = Duration::from_secs(16);

/// What the person at the page has seen of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seen {
    /// The last state.
    pub(crate) state: Value,
    /// The pages that steered, one after the other.
    pub(crate) steered: Vec<Option<u64>>,
    /// The number of the stop of which the page says that it has not arrived.
    pub(crate) unheard: Option<u64>,
    /// The number of stops that were ordered, and of those the states in which the page has seen the
    /// last of them arrive.
    pub(crate) stops: usize,
    pub(crate) heard_stops: Vec<Value>,
    /// The number of requests of which the page has said that they do not go out.
    pub(crate) not_sent: usize,
}

/// What the person does.
#[derive(Clone, Debug)]
enum Act {
    Ask(Value, Instant),
    Stop,
}

/// A page; its person closes it by dropping it.
pub(crate) struct ResilientPage {
    pub(crate) page: u64,
    acts: mpsc::UnboundedSender<Act>,
    seen: Arc<Mutex<Seen>>,
    life: JoinHandle<()>,
}

impl ResilientPage {
    /// Opens a page with this number.
    pub(crate) fn open(station: SocketAddr, session: &str, page: u64) -> Self {
        let (acts, acted) = mpsc::unbounded_channel();
        let seen = Arc::<Mutex<Seen>>::default();
        let url = format!("ws://{station}/live?session={session}&page={page}");
        let line = PageLine {
            url,
            page,
            seen: Arc::clone(&seen),
            seq: 0,
            written: Vec::new(),
            came: None,
            patience: PATIENCE,
        };
        Self { page, acts, seen, life: tokio::spawn(line.live(acted)) }
    }

    /// The person presses the key of an order or of the button that takes over.
    pub(crate) fn ask(&self, request: Value) {
        let _ = self.acts.send(Act::Ask(request, Instant::now()));
    }

    /// The person presses the key of the stop.
    pub(crate) fn stop(&self) {
        let _ = self.acts.send(Act::Stop);
    }

    pub(crate) fn seen(&self) -> MutexGuard<'_, Seen> {
        self.seen.lock().unwrap()
    }

    /// Waits until what the person has seen is as it must be.
    pub(crate) async fn wait_for(&self, what: &str, is_it: impl Fn(&Seen) -> bool) {
        for _ in 0..3_000 {
            if is_it(&self.seen()) {
                return;
            }
            sleep(Duration::from_millis(20)).await;
        }
        panic!("page {} has seen no {what} within a minute: {:#?}", self.page, *self.seen());
    }
}

impl Drop for ResilientPage {
    fn drop(&mut self) {
        self.life.abort();
    }
}

/// Whether a stop that the station has heard holds.
fn holds(stop: &Value) -> bool {
    stop.is_null() || stop["sending"] != "repeating" || !stop["base_s"].is_null()
}

/// The page's end of its line.
struct PageLine {
    url: String,
    page: u64,
    seen: Arc<Mutex<Seen>>,
    seq: u64,
    /// What was written to this line and not heard yet.
    written: Vec<(u64, Instant)>,
    came: Option<Instant>,
    patience: Duration,
}

impl PageLine {
    async fn live(mut self, mut acts: mpsc::UnboundedReceiver<Act>) {
        let mut url = self.url.clone();
        loop {
            let connecting = timeout(self.patience, connect_async(url.clone()));
            tokio::pin!(connecting);
            let connected = loop {
                tokio::select! {
                    connected = &mut connecting => break connected,
                    Some(act) = acts.recv() => self.act(act, None).await,
                }
            };
            match connected {
                Ok(Ok((socket, _))) => {
                    url = format!("{}&again=true", self.url);
                    self.use_line(socket, &mut acts).await;
                }
                Ok(Err(_)) => sleep(Duration::from_millis(100)).await,
                Err(_) => {}
            }
            self.patience = (2 * self.patience).min(MOST_PATIENCE);
        }
    }

    /// Uses a line until it breaks, or nothing has come over it for too long.
    async fn use_line(&mut self, mut socket: Socket, acts: &mut mpsc::UnboundedReceiver<Act>) {
        let opened = Instant::now();
        self.written.clear();
        self.write_stop(&mut socket).await;
        let mut beats = interval(BEAT);
        loop {
            tokio::select! {
                message = socket.next() => match message {
                    Some(Ok(Message::Text(text))) => self.take(&text),
                    Some(Ok(_)) => {}
                    Some(Err(_)) | None => return,
                },
                Some(act) = acts.recv() => self.act(act, Some(&mut socket)).await,
                _ = beats.tick() => {
                    if self.came.is_some() {
                        self.write(&mut socket, json!({ "do": "beat" }), 0).await;
                    }
                    self.write_stop(&mut socket).await;
                    let age = self.came.map_or(opened.elapsed(), |came| came.elapsed());
                    let lag = self.written.first().map_or(Duration::ZERO, |(_, at)| at.elapsed());
                    if opened.elapsed().min(age.max(lag)) > self.patience {
                        // The socket is left to itself: what was written may still arrive.
                        tokio::spawn(async move {
                            let _ = timeout(Duration::from_secs(60), socket.close(None)).await;
                        });
                        return;
                    }
                }
            }
        }
    }

    fn take(&mut self, text: &str) {
        let state: Value = serde_json::from_str(text).unwrap();
        if state["drones"].is_null() {
            return;
        }
        self.came = Some(Instant::now());
        let heard = state["heard"].as_array().unwrap();
        let own = heard.iter().find(|heard| heard["page"] == self.page);
        let number = |name| own.and_then(|own| own[name].as_u64()).unwrap_or_default();
        let last = number("last");
        if self.written.iter().any(|(seq, at)| *seq <= last && at.elapsed() < FRESH) {
            self.patience = PATIENCE;
        }
        self.written.retain(|(seq, _)| *seq > last);
        let mut seen = self.seen.lock().unwrap();
        if seen.unheard.is_some_and(|stop| stop <= number("stop")) && holds(&state["stop"]) {
            seen.unheard = None;
            seen.heard_stops.push(state["stop"].clone());
        }
        let steers = state["steering"].as_u64();
        if seen.steered.last() != Some(&steers) {
            seen.steered.push(steers);
        }
        seen.state = state;
    }

    async fn act(&mut self, act: Act, socket: Option<&mut Socket>) {
        match (act, socket) {
            (Act::Stop, socket) => {
                self.seq += 1;
                {
                    let mut seen = self.seen.lock().unwrap();
                    (seen.unheard, seen.stops) = (Some(self.seq), seen.stops + 1);
                }
                if let Some(socket) = socket {
                    self.write_stop(socket).await;
                }
            }
            (Act::Ask(request, acted), Some(socket))
                if self.came.is_some_and(|came| came.elapsed() < FRESH)
                    && acted.elapsed() < FRESH =>
            {
                let held = acted.elapsed().as_millis() as u64 + 1;
                self.write(socket, request, held).await;
            }
            (Act::Ask(..), _) => self.seen.lock().unwrap().not_sent += 1,
        }
    }

    async fn write(&mut self, socket: &mut Socket, request: Value, held: u64) {
        self.seq += 1;
        self.written.push((self.seq, Instant::now()));
        self.write_as(socket, request, held, self.seq).await;
    }

    async fn write_stop(&mut self, socket: &mut Socket) {
        let stop = self.seen.lock().unwrap().unheard;
        if let Some(seq) = stop {
            self.write_as(socket, json!({ "do": "stop" }), 0, seq).await;
        }
    }

    async fn write_as(&self, socket: &mut Socket, mut request: Value, held: u64, seq: u64) {
        request["stamp"] = self.seen.lock().unwrap().state["stamp"].clone();
        (request["held"], request["seq"]) = (json!(held), json!(seq));
        // Where the line is broken, reading from it says so.
        let _ = socket.send(Message::Text(request.to_string().into())).await;
    }
}
