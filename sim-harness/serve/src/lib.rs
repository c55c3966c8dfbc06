//! Serves simulated drones to cflib and cfclient: each drone has a UDP port of its own, with one
//! CRTP packet in each datagram, and simulated time follows real time.
//!
//! Each drone answers by its own on-board server. Only the base takes orders; it sends them to the
//! chain over the simulated radio, from drone to drone, as a real base does.
//!
//! ```text
//!   cflib ──UDP──▶ ports ──▶ chain ──▶ the drones of a world, each with its own CRTP server
//!     ▲                                                                              │
//!     └───────────────────────────────── UDP ────────────────────────────────────────┘
//! ```
//! A drone in an emulator has the server of its firmware, which clients reach by its radio chip, as
//! through a Crazyradio.
//!
//! Only [`Ports`] uses sockets, and only the module `pace` the clock; the rest is as deterministic
//! as any other run.

mod chain;
mod clients;
mod journal;
mod live;
mod pace;
#[cfg(test)]
mod tests;

use std::sync::atomic::{AtomicBool, Ordering};

use bridge::{Datagram, Ports};
use onboard::State;
use units::{Duration, Instant, Order};

use mission::trace::Node;

use self::chain::Chain;
pub use self::chain::Tally;
use self::clients::Taken;
pub use self::journal::Event;
use self::journal::Journal;
pub use self::live::{Companion, Live};
use self::pace::Pace;

/// A step of simulated time: log blocks come at multiples of it, and cflib's periods are.
pub const STEP: Duration = Duration::from_millis(10);

/// The drones that are served, head first, base last.
pub trait World {
    /// Simulated time.
    fn now(&self) -> Instant;
    /// Advances by one [`STEP`].
    fn advance(&mut self);
    /// The drones.
    fn nodes(&self) -> Vec<Node>;
    /// The state of a drone; `None` where that is not known.
    fn state(&self, member: usize) -> Option<State>;
    /// Delivers a packet of a client to a drone.
    fn client(&mut self, member: usize, packet: &[u8]);
    /// Gives `take` the packets that a drone now sends to its client.
    fn poll_client(&mut self, member: usize, take: &mut dyn FnMut(&[u8]));
    /// How many clients a drone serves at most. A drone that is polled answers too late to tell who
    /// asked, and serves one.
    fn most_clients(&self, _member: usize) -> usize {
        1
    }
    /// The operator's order at the base; `None` before the first.
    fn ordered(&self) -> Option<Order>;
    /// Whether the world cannot go on.
    fn is_halted(&self) -> bool {
        false
    }
}

/// Serves a world until its time is up, it cannot go on, or `stop` is set.
///
/// `tell` is called for each event that is printed at the terminal, with the simulated time. Where
/// the machine cannot keep up with `speed`, simulated time goes slower, and the simulation does not
/// change.
pub fn serve<W: World>(
    world: W,
    ports: Ports,
    speed: f64,
    duration: Option<Duration>,
    stop: &AtomicBool,
    mut tell: impl FnMut(Instant, Event),
) -> (W, Tally) {
    let mut chain = Chain::new(world);
    let mut journal = Journal::new(chain.nodes());
    let mut out = |member: usize, to, packet: &[u8]| ports.send(member, to, packet);
    let began = chain.now();
    let mut pace = Pace::new(speed, std::time::Instant::now(), began.as_micros());
    while !stop.load(Ordering::Relaxed)
        && !chain.is_halted()
        && duration.is_none_or(|duration| chain.now().since(began) < duration)
    {
        let due = pace.due((chain.now() + STEP).as_micros());
        let mut late = 0;
        // Once it is time, what has come already; a client that never pauses does not stop time.
        while late < bridge::WAITING
            && let Some(datagram) = ports.next(due)
        {
            let Datagram { member, from, .. } = datagram;
            let taken = chain.receive(member, from, datagram.bytes(), &mut out);
            let clock = std::time::Instant::now();
            late += usize::from(clock >= due);
            let event = match taken {
                Taken::Client => journal.heard(member, from, clock),
                Taken::Displaced { is_first: true } => journal.displaced(member, from),
                Taken::NoClient | Taken::Displaced { is_first: false } => None,
            };
            if let Some(event) = event {
                tell(chain.now(), event);
            }
        }
        chain.step(&mut out);
        let (now, clock) = (chain.now(), std::time::Instant::now());
        let late = pace.reached(now.as_micros(), clock).then_some(Event::Late);
        let gone = journal.gone(clock).map(|(member, drone, client)| {
            chain.gone(member, client, &mut out);
            Event::Gone(drone, client)
        });
        let events = [late, gone, journal.ordered(chain.ordered())];
        events.into_iter().flatten().for_each(|event| tell(now, event));
        for (member, state) in chain.states() {
            if let Some(event) = journal.doing(member, state) {
                tell(now, event);
            }
        }
    }
    let tally = chain.tally();
    (chain.into_world(), tally)
}
