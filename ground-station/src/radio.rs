//! Reaches a real drone through a Crazyradio: the simulator's bridge, in a thread of this process,
//! with a UDP port between the two.
//!
//! The bridge limits how often the drone is polled, asks its radio chip for a safelink, and drops
//! what is old. What comes after the driver's `send_packet` was never run.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use bridge::{self, Crazyradio, Ports, RadioAddress, Rate};
use input::InputError;

/// A bridge between a UDP port and a drone, which ends when it is dropped.
#[derive(Debug)]
pub struct Bridge {
    port: SocketAddr,
    ending: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Bridge {
    /// Opens the Crazyradio of an address. The bridge says on standard error when the drone is
    /// silent.
    ///
    /// # Errors
    /// If the Crazyradio is not plugged in or cannot be used, or there is no port.
    pub fn open(address: &RadioAddress) -> Result<Self, InputError> {
        let rate = address.rate.unwrap_or(Rate::DEFAULT);
        let mut radio = Crazyradio::open(address)?;
        let ports = Ports::open(Ipv4Addr::LOCALHOST, 0, 1)?;
        let no_port = || InputError::new("this machine gives no UDP port", "end other programs");
        let port = *ports.addresses().first().ok_or_else(no_port)?;
        let ending = Arc::new(AtomicBool::new(false));
        let ends = Arc::clone(&ending);
        let thread = thread::spawn(move || {
            let ended = bridge::run(&mut radio, ports, rate, &ends, |_, event| {
                eprintln!("uchain-ground: {event}");
            });
            if let Err(lost) = ended {
                eprintln!("uchain-ground: {lost}");
            }
        });
        Ok(Self { port, ending, thread: Some(thread) })
    }

    /// The UDP port behind which the drone is.
    #[must_use]
    pub const fn port(&self) -> SocketAddr {
        self.port
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        self.ending.store(true, Ordering::Relaxed);
        // A thread that panicked has ended, too.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}
