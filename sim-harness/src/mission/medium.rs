//! Simulates the air between radios: which stations receive which packets, how strongly, and when.
//!
//! The medium is sans-I/O: the owner of the stations hands in the packets that they send
//! ([`Medium::send`]), asks when the next packet arrives ([`Medium::next`]), and takes it
//! ([`Medium::arrive`]) with all stations that have received it. The strengths of the links come from
//! an [`Ether`], so a mission with its tunnel and a benchmark with a table of losses use the same
//! medium.
//!
//! A packet goes over its sender's serial line, on the air, and over the receivers' serial lines
//! ([`timing`]). A radio does one thing at a time: while it sends, and while it turns round, it
//! hears nothing. Of two packets at once a receiver hears the one that is stronger by
//! [`MediumConfig::capture`], or neither; of more than two, the strongest counts against the
//! rest one by one. What is then left is lost by chance, or heard with noise
//! ([`radio_model::Reception`]), drawn from the stream of that directed link.
//!
//! A station that is not on the air is not heard, but any station may be on it: an attacker is a station like
//! the others, at a place that its `Ether` knows, whose bytes are not checked
//! ([`Medium::inject`], [`Medium::jam`]).

mod polling;
mod section;
mod tally;
pub mod timing;

use radio_model::{Draws, Reception};
use units::{Db, Dbm};
use wire::radio::Datarate;
use wire::syslink::MAX_P2P;

use crate::random::{Purpose, Stream};

pub use polling::Polling;
pub use section::RadioSpec;
pub(crate) use section::RadioTable;
pub use tally::{Loss, Tally};

/// How strongly stations hear each other.
pub trait Ether {
    /// The strength of `from`'s signal at `to`, without noise; `None` where one of them is dead.
    fn strength(&mut self, from: usize, to: usize) -> Option<Dbm>;
}

impl<F: FnMut(usize, usize) -> Option<Dbm>> Ether for F {
    fn strength(&mut self, from: usize, to: usize) -> Option<Dbm> {
        self(from, to)
    }
}

/// The constants of the air and of the radios.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MediumConfig {
    /// The rate at which all stations send.
    pub datarate: Datarate,
    /// Noise, chance and sensitivity.
    pub reception: Reception,
    /// A packet is heard through another that is weaker by this much. 12 dB is what Nordic's
    /// support names as the co-channel ratio of the nRF24L01 at 2 Mbit/s; the nRF51, whose radio
    /// descends from it, may differ by a few dB.
    pub capture: Db,
    /// The operator's dongle, if one is at work.
    pub polling: Option<Polling>,
    /// Where packets arrive.
    pub arrives: Arrives,
}

/// Where a packet arrives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arrives {
    /// At the processor: behind the receiver's serial line.
    #[default]
    AtProcessor,
    /// At the antenna, as soon as it is off the air: the owner of the stations has their
    /// serial lines.
    AtAntenna,
}

impl MediumConfig {
    /// At the drones' default rate, without a dongle that polls.
    #[must_use]
    pub const fn of(reception: Reception) -> Self {
        Self {
            datarate: Datarate::Mbit2,
            reception,
            capture: Db(12.0),
            polling: None,
            arrives: Arrives::AtProcessor,
        }
    }
}

/// A station that has received a packet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receipt {
    /// The number of the station.
    pub by: usize,
    /// The strength that its radio reports.
    pub rssi: Dbm,
}

/// A packet that has arrived at the stations that have received it.
#[derive(Debug)]
pub struct Arrival<'a> {
    /// The moment of its arrival, µs.
    pub at_us: u64,
    /// The station that has sent the packet.
    pub from: usize,
    /// Its bytes.
    pub data: &'a [u8],
    /// The stations that have received it, in the order of their numbers.
    pub heard: &'a [Receipt],
}

/// A packet or a carrier on the air.
#[derive(Clone, Copy)]
struct Transmission {
    from: usize,
    start_us: u64,
    end_us: u64,
    arrives_us: u64,
    /// Whether it is a packet that no station has heard yet.
    waits: bool,
    cut: bool,
    length: usize,
    data: [u8; MAX_P2P],
}

impl Transmission {
    /// A carrier without a packet.
    const fn carrier(from: usize, start_us: u64, end_us: u64) -> Self {
        Self {
            from,
            start_us,
            end_us,
            arrives_us: end_us,
            waits: false,
            cut: false,
            length: 0,
            data: [0; MAX_P2P],
        }
    }

    const fn overlaps(&self, from_us: u64, until_us: u64) -> bool {
        self.start_us < until_us && from_us < self.end_us
    }
}

/// The air.
pub struct Medium {
    config: MediumConfig,
    stations: usize,
    /// One stream per directed link, sender-major.
    links: Vec<Stream>,
    /// When the serial line of each station is free again.
    line_free_us: Vec<u64>,
    /// The packets that have not arrived yet, and those that were on the air together with them.
    on_air: Vec<Transmission>,
    /// When the next packet arrives.
    next_us: Option<u64>,
    /// The packet that is arriving, and the stations that receive it.
    arriving: Transmission,
    heard: Vec<Receipt>,
    tally: Tally,
}

impl Medium {
    /// A medium between so many stations, on which nothing has been sent.
    #[must_use]
    pub fn new(config: MediumConfig, stations: usize, seed: u64) -> Self {
        let link = |n: usize| Purpose::Link((n / stations) as u8, (n % stations) as u8);
        Self {
            config,
            stations,
            links: (0..stations * stations).map(|n| Stream::new(seed, link(n))).collect(),
            line_free_us: vec![0; stations],
            on_air: Vec::new(),
            next_us: None,
            arriving: Transmission::carrier(0, 0, 0),
            heard: Vec::with_capacity(stations),
            tally: Tally::default(),
        }
    }

    /// Where packets arrive.
    #[must_use]
    pub const fn arrives(&self) -> Arrives {
        self.config.arrives
    }

    /// Takes bytes that a processor hands to its radio. Those beyond the length of a P2P packet are
    /// cut off.
    pub fn send(&mut self, from: usize, now_us: u64, data: &[u8]) {
        let Some(free_us) = self.line_free_us.get_mut(from) else { return };
        let over_us = now_us.max(*free_us) + timing::line_out_us(data.len().min(MAX_P2P));
        *free_us = over_us;
        self.inject(from, over_us + timing::TURN_US, data);
    }

    /// Puts bytes on the air at `start_us`, which is now or later.
    pub fn inject(&mut self, from: usize, start_us: u64, data: &[u8]) {
        let data = &data[..data.len().min(MAX_P2P)];
        let end_us = start_us + timing::air_us(self.config.datarate, data.len());
        for own in self.on_air.iter_mut().filter(|other| other.from == from && other.waits) {
            if own.overlaps(start_us, end_us) {
                own.cut = true;
                own.end_us = start_us;
            }
        }
        let arrives_us = match self.config.arrives {
            Arrives::AtProcessor => end_us + timing::line_in_us(data.len()),
            Arrives::AtAntenna => end_us,
        };
        let carrier = Transmission::carrier(from, start_us, end_us);
        let mut packet = Transmission { arrives_us, waits: true, length: data.len(), ..carrier };
        packet.data[..data.len()].copy_from_slice(data);
        self.on_air.push(packet);
        self.next_us = Some(self.next_us.map_or(arrives_us, |next_us| next_us.min(arrives_us)));
        self.tally.sent += 1;
        self.tally.bytes += data.len() as u64;
        self.tally.air_us += end_us - start_us;
    }

    /// Puts a carrier without a packet on the air: a station receives only packets that are much
    /// stronger.
    pub fn jam(&mut self, from: usize, start_us: u64, until_us: u64) {
        self.on_air.push(Transmission::carrier(from, start_us, until_us));
    }

    /// When the next packet on its way arrives; `None` while there is none.
    #[must_use]
    pub const fn next(&self) -> Option<u64> {
        self.next_us
    }

    /// Whether nothing is on the air, nor on its way there.
    #[must_use]
    pub const fn is_silent(&self) -> bool {
        self.next_us.is_none()
    }

    /// The tally of all packets so far.
    #[must_use]
    pub const fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Takes the packet that arrives next. All that was sent before it arrived must have been
    /// handed in.
    pub fn arrive(&mut self, ether: &mut impl Ether) -> Option<Arrival<'_>> {
        let next_us = self.next_us?;
        let at = self.on_air.iter().position(|on| on.waits && on.arrives_us == next_us)?;
        let packet = self.on_air[at];
        let is_contested = self.is_contested(&packet, at);
        self.heard.clear();
        for to in (0..self.stations).filter(|&to| to != packet.from) {
            let at = is_contested.then_some(at);
            match self.reception(&packet, at, to, ether) {
                Ok(rssi) => {
                    self.tally.heard += 1;
                    self.heard.push(Receipt { by: to, rssi });
                }
                Err(loss) => self.tally.lose(loss),
            }
        }
        self.on_air[at].waits = false;
        self.forget(packet.arrives_us);
        self.arriving = packet;
        let Transmission { from, arrives_us, length, ref data, .. } = self.arriving;
        Some(Arrival { at_us: arrives_us, from, data: &data[..length], heard: &self.heard })
    }

    /// Whether anything else on the air can keep a station from hearing this packet: another
    /// packet at the same time, or one for which a radio turns round.
    fn is_contested(&self, packet: &Transmission, at: usize) -> bool {
        let from_us = packet.start_us.saturating_sub(timing::TURN_US);
        let until_us = packet.end_us + timing::TURN_US;
        let others = self.on_air.iter().enumerate().filter(|(n, _)| *n != at);
        others.into_iter().any(|(_, other)| other.overlaps(from_us, until_us))
    }

    /// Decides whether one receiver gets one packet, and how strongly. The packet's place `at` among all that
    /// is on the air is given where others contest it.
    fn reception(
        &mut self,
        packet: &Transmission,
        at: Option<usize>,
        to: usize,
        ether: &mut impl Ether,
    ) -> Result<Dbm, Loss> {
        let strength = ether
            .strength(packet.from, to)
            .filter(|&strength| self.config.reception.reaches(strength))
            .ok_or(Loss::Weak)?;
        if packet.cut {
            return Err(Loss::Cut);
        }
        if let Some(at) = at {
            self.contest(packet, at, to, strength, ether)?;
        }
        if let Some(polling) = self.config.polling {
            self.bear(polling, packet, to, strength, ether)?;
        }
        let stream = &mut self.links[packet.from * self.stations + to];
        let luck = stream.uniform();
        if luck < self.config.reception.loss_rate {
            return Err(Loss::Chance);
        }
        let draws = Draws { luck, normal: stream.gauss() };
        self.config.reception.receive(strength, draws).ok_or(Loss::Chance)
    }

    /// Whether the packet is lost to another one that is on the air at the same time.
    fn contest(
        &self,
        packet: &Transmission,
        at: usize,
        to: usize,
        strength: Dbm,
        ether: &mut impl Ether,
    ) -> Result<(), Loss> {
        let Transmission { start_us, end_us, .. } = *packet;
        for (_, other) in self.on_air.iter().enumerate().filter(|(n, _)| *n != at) {
            // A radio that sends is deaf while it turns round as well.
            let deaf_until = end_us + timing::TURN_US;
            if other.from == to
                && other.overlaps(start_us.saturating_sub(timing::TURN_US), deaf_until)
            {
                return Err(Loss::Deaf);
            }
            if other.from == to || !other.overlaps(start_us, end_us) {
                continue;
            }
            let against = ether.strength(other.from, to);
            if against.is_some_and(|against| strength - against < self.config.capture) {
                return Err(Loss::Collision);
            }
        }
        Ok(())
    }

    /// Whether the packet is lost to the operator's dongle, or to the base's answers to it.
    fn bear(
        &self,
        polling: Polling,
        packet: &Transmission,
        to: usize,
        strength: Dbm,
        ether: &mut impl Ether,
    ) -> Result<(), Loss> {
        if !polling.overlaps(self.config.datarate, packet.start_us, packet.end_us) {
            return Ok(());
        }
        if to == polling.station {
            return Err(Loss::Deaf);
        }
        let against = ether.strength(polling.station, to);
        if against.is_some_and(|against| strength - against < self.config.capture) {
            return Err(Loss::Collision);
        }
        Ok(())
    }

    /// Forgets packets that were over before any that has yet to arrive began.
    fn forget(&mut self, now_us: u64) {
        let waiting = || self.on_air.iter().filter(|on| on.waits);
        self.next_us = waiting().map(|on| on.arrives_us).min();
        let first_us = waiting().map(|on| on.start_us).fold(now_us, u64::min);
        let first_us = first_us.saturating_sub(timing::TURN_US);
        self.on_air.retain(|on| on.waits || on.end_us > first_us);
    }
}
