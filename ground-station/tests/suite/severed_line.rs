//! A line between the station and a drone that can be cut, as a Crazyradio can be unplugged.

use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// A UDP port that carries datagrams to a drone and back until it is cut.
pub(crate) struct Line {
    port: SocketAddr,
    is_cut: Arc<AtomicBool>,
    ending: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

/// How often a thread looks whether the line is still needed.
const LOOK: Duration = Duration::from_millis(50);

impl Line {
    /// A line to the drone at this address.
    pub(crate) fn to(drone: &str) -> Self {
        let near = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let far = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        far.connect(drone.strip_prefix("udp://").unwrap()).unwrap();
        let port = near.local_addr().unwrap();
        for socket in [&near, &far] {
            socket.set_read_timeout(Some(LOOK)).unwrap();
        }
        let (is_cut, ending) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        let station = Arc::new(Mutex::new(None));
        let (out, back) = (station.clone(), station);
        let [to_drone, to_station] = [(), ()].map(|()| (is_cut.clone(), ending.clone()));
        let (near_too, far_too) = (near.try_clone().unwrap(), far.try_clone().unwrap());
        let threads = vec![
            carry(near, to_drone, move |datagram, from| {
                *out.lock().unwrap() = Some(from);
                let _ = far_too.send(datagram);
            }),
            carry(far, to_station, move |datagram, _| {
                if let Some(station) = *back.lock().unwrap() {
                    let _ = near_too.send_to(datagram, station);
                }
            }),
        ];
        Self { port, is_cut, ending, threads }
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
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

/// Carries what comes at a socket, one way, until the line is no longer needed. A datagram that comes
/// after the cut is lost.
fn carry(
    socket: UdpSocket,
    (is_cut, ending): (Arc<AtomicBool>, Arc<AtomicBool>),
    pass_on: impl Fn(&[u8], SocketAddr) + Send + 'static,
) -> JoinHandle<()> {
    thread::spawn(move || {
        let mut bytes = [0; 64];
        while !ending.load(Ordering::Relaxed) {
            if let Ok((length, from)) = socket.recv_from(&mut bytes)
                && !is_cut.load(Ordering::Relaxed)
            {
                pass_on(&bytes[..length], from);
            }
        }
    })
}
