//! Decides what a bridge sends to its drone, and when: the packets of the client in their order,
//! and empty packets that ask for the drone's own.
//!
//! A drone sends nothing but acknowledgements, so each packet to it is a poll. There is never more
//! than one within 1/rate, repeated packets and the safelink's questions included; while no client
//! is connected there is none.

use std::net::SocketAddr;

use units::{Duration, Instant};

use super::Event;
use super::safelink::{Answer, Safelink};
use crate::{NULL, Polled, is_null};

/// A client that is silent for so long is gone; as `uchain serve` has it.
pub(super) const CLIENT_SILENCE: Duration = Duration::from_secs(3);

/// A drone that acknowledges nothing for so long is out of reach (crazyflie-link 0.5.1, the default
/// of its `timeout`). What waits for it is dropped, since an old set-point must not be flown.
const DRONE_SILENCE: Duration = Duration::from_secs(1);

/// How often a drone is polled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rate(u16);

impl Rate {
    /// A hundred polls a second, which leaves room for the chain's packets on the same channel.
    pub const DEFAULT: Self = Self(100);
    /// The fewest polls per second: with fewer, cflib's requests time out.
    pub const LEAST: u16 = 10;
    /// The most: what a Crazyradio does when nothing limits it.
    pub const MOST: u16 = 1_000;

    /// So many polls per second, if that is within [`Rate::LEAST`] and [`Rate::MOST`].
    #[must_use]
    pub const fn per_second(polls: u16) -> Option<Self> {
        if polls >= Self::LEAST && polls <= Self::MOST { Some(Self(polls)) } else { None }
    }

    /// The polls per second.
    #[must_use]
    pub const fn polls(self) -> u16 {
        self.0
    }

    /// The least time from one poll to the next, rounded up to a microsecond.
    #[must_use]
    pub fn interval(self) -> Duration {
        Duration::from_micros(1_000_000_u64.div_ceil(self.0.into()))
    }
}

/// The counts of a bridge's packets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// The packets that clients have sent.
    pub received: u64,
    /// The packets that the drone has sent to clients.
    pub sent: u64,
    /// The polls.
    pub polls: u64,
    /// The polls that the drone has not acknowledged.
    pub unacknowledged: u64,
}

/// What follows from a datagram.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Heard {
    /// The packet to return to the sender at once.
    pub answer: Option<&'static [u8]>,
    /// The event to print.
    pub event: Option<Event>,
}

/// What follows from an acknowledgement.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Acknowledged {
    /// The packet for the client.
    pub packet: Option<Vec<u8>>,
    /// The event to print.
    pub event: Option<Event>,
}

/// The client that the drone's packets go to.
#[derive(Clone, Copy, Debug)]
struct Client {
    address: SocketAddr,
    heard: Instant,
}

/// Whether the drone is in reach.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reach {
    /// Not known yet: the drone is polled since then.
    Polled(Instant),
    /// It has acknowledged a packet, last at that time.
    Answers(Instant),
    /// It has acknowledged nothing for too long.
    Silent,
}

/// Decides what a bridge sends to its drone.
#[derive(Debug)]
pub struct Poller {
    rate: Rate,
    client: Option<Client>,
    /// The packets on their way in either direction.
    packets: Polled,
    safelink: Safelink,
    reach: Reach,
    /// The earliest time of the next poll.
    next: Instant,
    tally: Tally,
}

impl Poller {
    /// Begins without a client.
    #[must_use]
    pub fn new(rate: Rate) -> Self {
        Self {
            rate,
            client: None,
            packets: Polled::default(),
            safelink: Safelink::NEW,
            reach: Reach::Silent,
            next: Instant::ZERO,
            tally: Tally::default(),
        }
    }

    /// The client that the drone's packets go to.
    #[must_use]
    pub fn client(&self) -> Option<SocketAddr> {
        self.client.map(|client| client.address)
    }

    /// The counts so far.
    #[must_use]
    pub const fn tally(&self) -> Tally {
        self.tally
    }

    /// When the next poll is due; `None` while there is no client.
    #[must_use]
    pub fn due(&self) -> Option<Instant> {
        self.client.map(|_| self.next)
    }

    /// Takes a datagram. A scan is answered and changes nothing; everything else is a packet for the
    /// drone, from the client that its packets go to from now on.
    pub fn receive(&mut self, now: Instant, from: SocketAddr, packet: &[u8]) -> Heard {
        if is_null(packet) {
            return Heard { answer: Some(&[NULL]), event: None };
        }
        if packet.is_empty() {
            return Heard::default();
        }
        let is_new = self.client() != Some(from);
        self.client = Some(Client { address: from, heard: now });
        if is_new {
            self.begin(now);
        }
        self.tally.received += 1;
        // A drone that is out of reach gets nothing that is old by the time it is back.
        if self.reach != Reach::Silent {
            self.packets.give(packet);
        }
        Heard { answer: None, event: is_new.then_some(Event::Connected(from)) }
    }

    /// Ends the connection of a client that is gone.
    pub fn attend(&mut self, now: Instant) -> Option<Event> {
        let client = self.client?;
        if now.since(client.heard) < CLIENT_SILENCE {
            return None;
        }
        self.client = None;
        Some(Event::Gone(client.address))
    }

    /// The packet that is to be sent to the drone now, if one is due.
    pub fn poll(&mut self, now: Instant) -> Option<Vec<u8>> {
        if self.due().is_none_or(|due| now < due) {
            return None;
        }
        self.next = now + self.rate.interval();
        self.tally.polls += 1;
        let question = self.safelink.question().map(Vec::from);
        Some(question.unwrap_or_else(|| self.safelink.numbered(self.packets.next_packet())))
    }

    /// Takes the drone's acknowledgement of the packet that was polled with; `None` when none came.
    pub fn acknowledged(&mut self, now: Instant, answer: Option<&[u8]>) -> Acknowledged {
        let heard = self.safelink.acknowledged(answer);
        let Some(heard) = heard else {
            self.tally.unacknowledged += 1;
            return Acknowledged { packet: None, event: self.miss(now) };
        };
        let event = (!matches!(self.reach, Reach::Answers(_))).then_some(Event::Answers);
        self.reach = Reach::Answers(now);
        if let Answer::Packet(packet) = heard {
            self.packets.acknowledged(packet);
        }
        let packet = self.packets.take_received().pop();
        self.tally.sent += u64::from(packet.is_some());
        Acknowledged { packet, event }
    }

    /// Forgets what the last client has left.
    fn begin(&mut self, now: Instant) {
        self.packets = Polled::default();
        self.safelink = Safelink::NEW;
        self.reach = Reach::Polled(now);
    }

    /// Looks whether the drone has acknowledged nothing for too long.
    fn miss(&mut self, now: Instant) -> Option<Event> {
        let (Reach::Polled(since) | Reach::Answers(since)) = self.reach else { return None };
        if now.since(since) < DRONE_SILENCE {
            return None;
        }
        self.packets = Polled::default();
        self.safelink = Safelink::NEW;
        self.reach = Reach::Silent;
        Some(Event::Silent)
    }
}
