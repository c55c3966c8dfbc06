//! Opens the UDP ports of a served chain, one per drone, and receives the datagrams that arrive at
//! them.
//!
//! A datagram is one CRTP packet as it stands: header and up to 30 bytes, no checksum. Each port
//! has a thread that only listens; everything else happens in the thread that moves time.

use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use input::InputError;

/// The first of the ten ports that cflib looks at when it scans (cflib, udpdriver.py).
pub const FIRST_PORT: u16 = 19_850;

/// The longest CRTP packet: a header and 30 bytes (crazyflie-firmware, crtp.h).
const LONGEST: usize = 31;

/// Datagrams that wait to be looked at; the rest wait in the system's own queue.
pub const WAITING: usize = 256;

/// How often a listening thread checks whether it should end.
const LOOKS_UP: Duration = Duration::from_millis(100);

/// A datagram that arrived.
pub struct Datagram {
    /// The drone at whose port it came in, by its place, head first.
    pub member: usize,
    /// The address of the sender.
    pub from: SocketAddr,
    length: usize,
    bytes: [u8; LONGEST],
}

impl Datagram {
    /// The packet.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

/// The ports of one chain, head first.
pub struct Ports {
    sockets: Vec<Arc<UdpSocket>>,
    addresses: Vec<SocketAddr>,
    inbox: Receiver<Datagram>,
    listeners: Vec<JoinHandle<()>>,
    closing: Arc<AtomicBool>,
}

impl Ports {
    /// Opens `count` successive ports from `first` on; where `first` is 0, any that are free.
    ///
    /// # Errors
    /// If one of the ports cannot be opened.
    pub fn open(host: Ipv4Addr, first: u16, count: usize) -> Result<Self, InputError> {
        let sockets = in_a_row(first, count)?
            .into_iter()
            .map(|port| bind(SocketAddrV4::new(host, port)).map(Arc::new))
            .collect::<Result<Vec<_>, _>>()?;
        let addresses = sockets
            .iter()
            .map(|socket| socket.local_addr())
            .collect::<io::Result<Vec<_>>>()
            .map_err(|error| refused(SocketAddrV4::new(host, first), &error))?;
        let (sender, inbox) = sync_channel(WAITING);
        let closing = Arc::new(AtomicBool::new(false));
        let listeners = sockets
            .iter()
            .enumerate()
            .map(|(member, socket)| {
                let (socket, sender) = (Arc::clone(socket), sender.clone());
                let closing = Arc::clone(&closing);
                thread::spawn(move || listen(member, &socket, &sender, &closing))
            })
            .collect();
        Ok(Self { sockets, addresses, inbox, listeners, closing })
    }

    /// The addresses of the drones, head first.
    #[must_use]
    pub fn addresses(&self) -> &[SocketAddr] {
        &self.addresses
    }

    /// The next datagram that is there, or comes before `deadline`.
    pub fn next(&self, deadline: Instant) -> Option<Datagram> {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return self.inbox.try_recv().ok();
        }
        match self.inbox.recv_timeout(left) {
            Ok(datagram) => Some(datagram),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => {
                // No thread listens any more; time still has to pass.
                thread::sleep(left);
                None
            }
        }
    }

    /// Sends a packet from a drone's port. Where no client receives it, it is lost, as on the air.
    pub fn send(&self, member: usize, to: SocketAddr, packet: &[u8]) {
        if let Some(socket) = self.sockets.get(member) {
            let _ = socket.send_to(packet, to);
        }
    }
}

impl Drop for Ports {
    fn drop(&mut self) {
        self.closing.store(true, Ordering::Relaxed);
        // A listener may be waiting for room in the inbox.
        while self.inbox.try_recv().is_ok() {}
        for listener in self.listeners.drain(..) {
            while !listener.is_finished() {
                while self.inbox.try_recv().is_ok() {}
                thread::sleep(Duration::from_millis(1));
            }
            let _ = listener.join();
        }
    }
}

fn in_a_row(first: u16, count: usize) -> Result<Vec<u16>, InputError> {
    if first == 0 {
        return Ok(vec![0; count]);
    }
    let ports: Vec<_> = (first..=u16::MAX).take(count).collect();
    if ports.len() == count {
        return Ok(ports);
    }
    Err(InputError::new(
        format!("there are no {count} ports from {first} on"),
        "give a smaller --port",
    ))
}

fn bind(address: SocketAddrV4) -> Result<UdpSocket, InputError> {
    UdpSocket::bind(address)
        .and_then(|socket| socket.set_read_timeout(Some(LOOKS_UP)).map(|()| socket))
        .map_err(|error| refused(address, &error))
}

fn refused(address: SocketAddrV4, error: &io::Error) -> InputError {
    match error.kind() {
        ErrorKind::AddrInUse => InputError::new(
            format!("UDP port {address} is in use"),
            "end the program that has it, or give another --port",
        ),
        ErrorKind::AddrNotAvailable => InputError::new(
            format!("{} is no address of this machine", address.ip()),
            "give --host one that is, or 0.0.0.0 for all of them",
        ),
        _ => InputError::new(
            format!("cannot listen on {address} ({error})"),
            "give another --host or --port",
        ),
    }
}

fn listen(member: usize, socket: &UdpSocket, inbox: &SyncSender<Datagram>, closing: &AtomicBool) {
    // One byte more than a packet may have, to tell a longer one by.
    let mut buffer = [0; LONGEST + 1];
    while !closing.load(Ordering::Relaxed) {
        // Errors are time-outs, or tell of a client that has gone away: nothing to mend.
        let Ok((length, from)) = socket.recv_from(&mut buffer) else { continue };
        let mut bytes = [0; LONGEST];
        match (bytes.get_mut(..length), buffer.get(..length)) {
            (Some(to), Some(received)) if length > 0 => to.copy_from_slice(received),
            _ => continue,
        }
        if inbox.send(Datagram { member, from, length, bytes }).is_err() {
            return;
        }
    }
}
