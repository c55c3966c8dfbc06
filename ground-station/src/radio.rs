//! Reaches a real base through a Crazyradio: the simulator's bridge, in a thread of this process,
//! with a UDP port between the two.
//!
//! The bridge limits how often the base is polled, asks its radio chip for a safelink, and drops
//! what is old. What comes after the driver's `send_packet` was never run.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::AtomicBool;
use std::thread;

use sim_harness::bridge::{self, Crazyradio, RadioAddress, Rate};
use sim_harness::input_error::InputError;
use sim_harness::serve::Ports;

/// Opens the Crazyradio of an address, and returns the port behind which the base now is. The
/// bridge runs until the station ends, and says on standard error when the base is silent.
///
/// # Errors
/// If the address is none, the Crazyradio is not plugged in or cannot be used, or there is no port.
pub fn open(address: &str) -> Result<SocketAddr, InputError> {
    let address: RadioAddress = address.parse()?;
    let rate = address.rate.unwrap_or(Rate::DEFAULT);
    let mut radio = Crazyradio::open(&address)?;
    let ports = Ports::open(Ipv4Addr::LOCALHOST, 0, 1)?;
    let no_port = || InputError::new("this machine gives no UDP port", "end other programs");
    let port = *ports.addresses().first().ok_or_else(no_port)?;
    thread::spawn(move || {
        let never = AtomicBool::new(false);
        let ended = bridge::run(&mut radio, ports, rate, &never, |_, event| {
            eprintln!("uchain-ground: {event}");
        });
        if let Err(lost) = ended {
            eprintln!("uchain-ground: {lost}");
        }
    });
    Ok(port)
}
