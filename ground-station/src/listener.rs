//! Accepts connections and bounds what each may take, so that a new page is never locked out.
//!
//! A connection costs a file descriptor, of which a process has some hundreds, and no token is
//! needed to open one. So a connection that has not become a page's or a viewer's socket has
//! [`HEADERS`] for the headers of each request and [`REQUESTS`] altogether, and where
//! [`MAX_WAITING`] of them wait, the one that has waited longest gives way to a new one: a page sends
//! its request at once, and is answered long before its turn to give way comes. The sockets of pages
//! and viewers are counted where they are opened.

use std::collections::VecDeque;
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::time::Duration;

use axum::{Extension, Router};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::task::JoinHandle;

/// The time for the headers of a request, and between two requests of a connection.
pub const HEADERS: Duration = Duration::from_secs(5);
/// The time for all requests of a connection; a page and its files take less than one second.
pub const REQUESTS: Duration = Duration::from_secs(15);
/// The number of connections that may wait without being the socket of a page or a viewer.
pub const MAX_WAITING: usize = 128;
/// The number of bytes for the headers of a request. A browser sends the cookies of every program
/// that it has met on this machine.
const MAX_HEADERS: usize = 32 * 1024;
/// The pause after the machine has refused a connection, for want of file descriptors for example.
const PAUSE: Duration = Duration::from_millis(50);

/// The number of bytes that wait in the system for a page that does not read, which may double it:
/// what waits there is old when the page reads on. A state of fifteen drones takes some 8 kB.
const UNREAD: u32 = 64 * 1024;
/// The number of connections that the system keeps until they are accepted.
const BACKLOG: u32 = 1024;

/// The address from which a request came.
#[derive(Clone, Copy, Debug)]
pub struct ClientAddress(pub IpAddr);

/// Opens a port.
///
/// # Errors
/// If the machine does not have the address, or another program has the port.
pub fn open(at: SocketAddr) -> io::Result<TcpListener> {
    let socket = if at.is_ipv4() { TcpSocket::new_v4()? } else { TcpSocket::new_v6()? };
    // As a station that was killed a moment ago leaves it. Windows would share the port.
    #[cfg(not(windows))]
    socket.set_reuseaddr(true)?;
    // The sockets that are accepted have it from here.
    socket.set_send_buffer_size(UNREAD)?;
    socket.bind(at)?;
    socket.listen(BACKLOG)
}

/// Serves the routes until the future is dropped.
pub async fn serve(listener: TcpListener, routes: Router) {
    let mut waiting: VecDeque<JoinHandle<()>> = VecDeque::new();
    loop {
        match listener.accept().await {
            Ok((stream, peer)) => {
                let routes = routes.clone().layer(Extension(ClientAddress(peer.ip())));
                waiting.push_back(tokio::spawn(attend(stream, routes)));
            }
            Err(_) => tokio::time::sleep(PAUSE).await,
        }
        waiting.retain(|connection| !connection.is_finished());
        if waiting.len() > MAX_WAITING
            && let Some(longest) = waiting.pop_front()
        {
            longest.abort();
            // It is closed before the next one is accepted: where many come at once, there is no
            // moment with more of them than there may be.
            let _ = longest.await;
        }
    }
}

/// Answers the requests of a connection until it ends, or has become a socket, which then lives on
/// without it.
async fn attend(stream: TcpStream, routes: Router) {
    // A state or an order waits for no other.
    let _ = stream.set_nodelay(true);
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEADERS)
        .max_buf_size(MAX_HEADERS)
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(routes))
        .with_upgrades();
    // What goes wrong here is the other side's to notice.
    let _ = tokio::time::timeout(REQUESTS, connection).await;
}
