//! A line between the station and a drone that can be cut, as a Crazyradio can be unplugged.

use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// A UDP port that carries datagrams to a drone and back until it is cut.
pub(crate) struct Line {
    port: SocketAddr,
    is_cut: Arc<AtomicBool>,
    ending: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Line {
    /// A line to the drone at this address.
    pub(crate) fn to(drone: &str) -> Self {
        let near = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let far = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        far.connect(drone.strip_prefix("udp://").unwrap()).unwrap();
        let port = near.local_addr().unwrap();
        for socket in [&near, &far] {
            socket.set_read_timeout(Some(Duration::from_millis(1))).unwrap();
        }
        let (is_cut, ending) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        let (cut, ends) = (Arc::clone(&is_cut), Arc::clone(&ending));
        let thread = thread::spawn(move || {
            // Asked for each datagram: one that comes after the cut is lost.
            let whole = || !cut.load(Ordering::Relaxed);
            let mut station = None;
            let mut bytes = [0; 64];
            while !ends.load(Ordering::Relaxed) {
                if let Ok((length, from)) = near.recv_from(&mut bytes) {
                    station = Some(from);
                    let _ = whole().then(|| far.send(&bytes[..length]));
                }
                if let (Ok(length), Some(station)) = (far.recv(&mut bytes), station) {
                    let _ = whole().then(|| near.send_to(&bytes[..length], station));
                }
            }
        });
        Self { port, is_cut, ending, thread: Some(thread) }
    }

    /// The address of the station's end.
    pub(crate) fn address(&self) -> String {
        format!("udp://{}", self.port)
    }

    /// Loses every datagram from now on.
    pub(crate) fn cut(&self) {
        self.is_cut.store(true, Ordering::Relaxed);
    }

    /// Carries datagrams again.
    pub(crate) fn mend(&self) {
        self.is_cut.store(false, Ordering::Relaxed);
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        self.ending.store(true, Ordering::Relaxed);
        let _ = self.thread.take().unwrap().join();
    }
}
