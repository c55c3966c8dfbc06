//! A proxy between pages and the station, whose lines freeze, delay, break in the middle of a frame
//! and reset.
//!
//! The proxy runs on a thread of its own, so that a test that waits does not stop it.

use std::net::SocketAddr;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{mpsc, watch};
use tokio::time::Instant;

/// What the proxy does with its lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Ways {
    frozen_up: bool,
    frozen_down: bool,
    delay: Duration,
    /// How often every line was reset, and how often every line was broken after half of what comes
    /// next.
    resets: u64,
    halvings: u64,
    is_over: bool,
}

/// The direction of a way through the proxy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    Up,
    Down,
}

impl Ways {
    const fn is_frozen(&self, way: Way) -> bool {
        match way {
            Way::Up => self.frozen_up,
            Way::Down => self.frozen_down,
        }
    }
}

/// A running proxy; it ends when it is dropped.
pub(crate) struct StallingProxy {
    pub(crate) at: SocketAddr,
    ways: watch::Sender<Ways>,
    thread: Option<JoinHandle<()>>,
}

impl StallingProxy {
    /// A proxy to this station, which carries everything at once.
    pub(crate) fn to(station: SocketAddr) -> Self {
        let listener = std::net::TcpListener::bind(("127.0.0.1", 0)).unwrap();
        listener.set_nonblocking(true).unwrap();
        let at = listener.local_addr().unwrap();
        let (ways, seen) = watch::channel(Ways::default());
        let thread = thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
            runtime.unwrap().block_on(accept(listener, station, seen));
        });
        Self { at, ways, thread: Some(thread) }
    }

    /// Holds everything back, both ways.
    pub(crate) fn freeze(&self) {
        self.ways.send_modify(|ways| (ways.frozen_up, ways.frozen_down) = (true, true));
    }

    /// Holds back what pages send.
    pub(crate) fn freeze_up(&self) {
        self.ways.send_modify(|ways| ways.frozen_up = true);
    }

    /// Carries everything again, what was held back first.
    pub(crate) fn flow(&self) {
        self.ways.send_modify(|ways| {
            (ways.frozen_up, ways.frozen_down, ways.delay) = (false, false, Duration::ZERO);
        });
    }

    /// Carries everything that much later, each way.
    pub(crate) fn delay(&self, delay: Duration) {
        self.ways.send_modify(|ways| ways.delay = delay);
    }

    /// Resets every line: what was held back is lost.
    pub(crate) fn reset(&self) {
        self.ways.send_modify(|ways| ways.resets += 1);
    }

    /// Breaks every line in the middle of what comes next.
    pub(crate) fn halve(&self) {
        self.ways.send_modify(|ways| ways.halvings += 1);
    }
}

impl Drop for StallingProxy {
    fn drop(&mut self) {
        self.ways.send_modify(|ways| ways.is_over = true);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

async fn accept(listener: std::net::TcpListener, station: SocketAddr, ways: watch::Receiver<Ways>) {
    let listener = TcpListener::from_std(listener).unwrap();
    let mut over = ways.clone();
    loop {
        tokio::select! {
            accepted = listener.accept() => {
                let (page, _) = accepted.unwrap();
                tokio::spawn(carry(page, station, ways.clone()));
            }
            _ = over.wait_for(|ways| ways.is_over) => return,
        }
    }
}

/// Carries one connection until either side ends it, or it is broken.
async fn carry(page: TcpStream, station: SocketAddr, ways: watch::Receiver<Ways>) {
    let Ok(station) = TcpStream::connect(station).await else { return };
    for stream in [&page, &station] {
        stream.set_nodelay(true).unwrap();
        // A line that is dropped is reset.
        stream.set_zero_linger().unwrap();
    }
    let resets = ways.borrow().resets;
    let mut broken = ways.clone();
    let ((from_page, to_page), (from_station, to_station)) =
        (page.into_split(), station.into_split());
    tokio::select! {
        () = async { tokio::join!(
            pump(from_page, to_station, Way::Up, ways.clone()),
            pump(from_station, to_page, Way::Down, ways.clone()),
        ); } => {}
        _ = broken.wait_for(|ways| ways.resets != resets || ways.is_over) => {}
    }
}

/// Carries one way of a connection. An end of it waits its turn as bytes do.
async fn pump(mut from: OwnedReadHalf, to: OwnedWriteHalf, way: Way, ways: watch::Receiver<Ways>) {
    let (put, chunks) = mpsc::channel::<(Instant, Vec<u8>)>(1_024);
    let read = async move {
        let mut bytes = [0; 16 * 1_024];
        while let Ok(length @ 1..) = from.read(&mut bytes).await {
            if put.send((Instant::now(), bytes[..length].to_vec())).await.is_err() {
                return;
            }
        }
    };
    tokio::join!(read, pass_on(chunks, to, way, ways));
}

async fn pass_on(
    mut chunks: mpsc::Receiver<(Instant, Vec<u8>)>,
    mut to: OwnedWriteHalf,
    way: Way,
    mut ways: watch::Receiver<Ways>,
) {
    let halvings = ways.borrow().halvings;
    while let Some((came, bytes)) = chunks.recv().await {
        let delay = ways.borrow().delay;
        tokio::time::sleep_until(came + delay).await;
        let Ok(now) = ways.wait_for(|ways| !ways.is_frozen(way)).await.map(|ways| *ways) else {
            return;
        };
        let end = if now.halvings == halvings { bytes.len() } else { bytes.len() / 2 };
        if to.write_all(&bytes[..end]).await.is_err() || end < bytes.len() {
            break;
        }
    }
    let _ = ways.wait_for(|ways| !ways.is_frozen(way)).await.is_ok();
    let _ = to.shutdown().await;
}
