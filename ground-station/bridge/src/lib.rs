//! Connects cfclient and cflib to a real drone: a UDP port on one side, a Crazyradio on the other,
//! and a limit on how often the drone is polled.
//!
//! cfclient can only connect to what its scan finds, and its scan finds a drone over the radio
//! without the `rate_limit` that the chain's own packets need to share the channel with it. It
//! finds UDP ports of this machine, too, so the bridge has one.
//!
//! ```text
//!   cfclient ──UDP──▶ ports ──▶ poller ──▶ Crazyradio ─ ─▶ drone
//!      ▲                          │  ▲                      │
//!      └──────────UDP─────────────┘  └─ ─ acknowledgement ─ ┘
//! ```
//! [`Poller`] decides what is sent, and when; it has neither sockets nor a clock. [`Radio`] is what
//! a Crazyradio does; the tests put a scripted one in its place.

mod address;
#[cfg(feature = "crazyradio")]
mod dongle;
mod polled;
mod poller;
mod ports;
mod safelink;
#[cfg(test)]
mod tests;

use std::fmt;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};

use units::{Duration, Instant};

pub use self::address::RadioAddress;
#[cfg(feature = "crazyradio")]
pub use self::dongle::Crazyradio;
pub use self::polled::{NULL, Polled, is_null};
pub use self::poller::{Acknowledged, Heard, Poller, Rate, Tally};
pub use self::ports::{Datagram, FIRST_PORT, Ports, WAITING};

/// The time after which the loop checks whether it should end, when nothing else is due.
const LOOKS_UP: Duration = Duration::from_millis(100);

/// A radio that sends one packet to one drone and waits for its acknowledgement.
pub trait Radio {
    /// Sends a packet of 1 to 32 bytes. Returns the content of the acknowledgement, and `None` when
    /// the drone has not acknowledged the packet.
    ///
    /// # Errors
    /// If the radio can send nothing any more.
    fn exchange(&mut self, packet: &[u8]) -> Result<Option<Vec<u8>>, RadioLost>;
}

/// The error of a radio that can send nothing any more, in its driver's words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RadioLost(pub String);

impl fmt::Display for RadioLost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the Crazyradio is lost ({}); plug it in and start the bridge again", self.0)
    }
}

impl std::error::Error for RadioLost {}

/// An event that is printed at the terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// A client has connected.
    Connected(SocketAddr),
    /// Nothing was heard of the client for a while; the drone is polled no more.
    Gone(SocketAddr),
    /// The drone has not acknowledged a packet for a while. What waits for it is dropped.
    Silent,
    /// The drone acknowledges packets.
    Answers,
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Connected(client) => write!(f, "client {client} connected"),
            Self::Gone(client) => {
                let silence = poller::CLIENT_SILENCE.as_secs_f32();
                write!(f, "client {client} gone, silent for {silence} s; the drone is not polled")
            }
            Self::Silent => f.write_str(
                "the drone does not answer; is it switched on, and are channel, data rate and \
                 address its own?",
            ),
            Self::Answers => f.write_str("the drone answers"),
        }
    }
}

/// Carries packets between the one port of `ports` and a radio, until `stop` is set.
///
/// `tell` is called for each event, with the time since the start.
///
/// # Errors
/// If the radio is lost.
pub fn run(
    radio: &mut impl Radio,
    ports: Ports,
    rate: Rate,
    stop: &AtomicBool,
    mut tell: impl FnMut(Instant, Event),
) -> Result<Tally, RadioLost> {
    let began = std::time::Instant::now();
    let clock = || Instant::from_micros(began.elapsed().as_micros() as u64);
    let mut poller = Poller::new(rate);
    while !stop.load(Ordering::Relaxed) {
        let pause = clock() + LOOKS_UP;
        let due = poller.due().filter(|due| *due < pause).unwrap_or(pause);
        let due = began + std::time::Duration::from_micros(due.as_micros());
        let mut event = None;
        if let Some(datagram) = ports.next(due) {
            let heard = poller.receive(clock(), datagram.from, datagram.bytes());
            if let Some(answer) = heard.answer {
                ports.send(0, datagram.from, answer);
            }
            event = heard.event;
        }
        let now = clock();
        event.into_iter().chain(poller.attend(now)).for_each(|event| tell(now, event));
        if let Some(packet) = poller.poll(now) {
            let answer = radio.exchange(&packet)?;
            let now = clock();
            let heard = poller.acknowledged(now, answer.as_deref());
            if let (Some(packet), Some(client)) = (heard.packet, poller.client()) {
                ports.send(0, client, &packet);
            }
            heard.event.into_iter().for_each(|event| tell(now, event));
        }
    }
    Ok(poller.tally())
}
