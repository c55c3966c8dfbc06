//! Simulates the air between radios: which stations receive which packets, how strongly, and when.
//!
//! The medium is sans-I/O: the owner of the stations hands in the packets that they send
//! ([`Medium::send`]), asks when something happens next ([`Medium::next`]), and lets it happen
//! ([`Medium::advance`]): then a packet may arrive, with all stations that have received it. The
//! strengths of the links come from an [`Ether`], so a mission with its tunnel and a benchmark with a
//! table of losses use the same medium.
//!
//! A packet goes over its sender's serial line, waits for the main loop of the sender's radio chip
//! (`chip`), is on the air, waits for the main loops of the receivers' chips, and goes over their
//! serial lines ([`timing`]). A radio does one thing at a time: while it sends, and while it turns
//! round, it hears nothing. A receiver stays with the first packet whose address it finds (`on_air`),
//! and decodes it if it is stronger by [`MediumConfig::capture`] than each other that is on the air at
//! the same time. What is then left is lost by chance, in a fade, or to the noise of the receiver, or
//! heard with a noisy strength ([`radio_model::Reception`], [`radio_model::Fades`]), drawn from the
//! stream of that directed link.
//!
//! A station that is not on the air is not heard, but any station may be on it: an attacker is a station like
//! the others, at a place that its `Ether` knows, whose bytes are not checked
//! ([`Medium::inject`], [`Medium::jam`]), and may repeat what it hears at another place
//! ([`Medium::repeat`]).

mod chip;
mod config;
pub mod directed_link;
mod on_air;
mod polling;
mod tally;

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::Arc;

use random::{Purpose, Stream};

use radio_model::Draws;
use units::Dbm;
pub use wire::radio::timing;
use wire::syslink::MAX_P2P;

use directed_link::{LinkFades, streams};
use recordings::recorded::{PacketDeviations, RecordedChannel};

use chip::Chip;
pub use config::{Arrives, Ether, MediumConfig};
use on_air::{MOST_STATIONS, OnAir, Transmission};
pub use polling::Polling;
pub use tally::{Loss, Tally};

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

/// A packet that is not on the air yet.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Pending {
    /// When the radio chip has read it, or its radio turns round to send it.
    at_us: u64,
    /// Of packets at the same moment the one that was handed in first goes first.
    number: u64,
    from: usize,
    /// Whether it has to wait for the main loop of the sender's chip.
    queues: bool,
    length: usize,
    data: [u8; MAX_P2P],
}

/// A packet that has come off the air, on its way to the receivers' processors.
struct Landed {
    from: usize,
    length: usize,
    data: [u8; MAX_P2P],
    /// The stations that receive it, and when it is at their processors.
    receipts: Vec<(u64, Receipt)>,
}

/// Which originals a repeater jams, of the packets that it hears.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Jams {
    /// None.
    Nothing,
    /// An original at each receiver that hears the copy more strongly.
    Weaker,
    /// All, at all receivers.
    All,
}

/// A radio that sends what another radio hears.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Repeater {
    /// The station that hears, whatever else is on the air.
    pub ear: usize,
    /// The station that sends.
    pub mouth: usize,
    /// The time from the end of a packet to the beginning of its copy, µs.
    pub delay_us: u64,
    /// The originals that do not arrive.
    pub jams: Jams,
}

/// The air.
pub struct Medium {
    config: MediumConfig,
    /// The random numbers of each link, by sender and receiver.
    links: Vec<Stream>,
    fades: LinkFades,
    /// What recorded packets add to their strengths, where the channel is recorded.
    deviations: Option<PacketDeviations>,
    chips: Vec<Chip>,
    pending: BinaryHeap<Reverse<Pending>>,
    on_air: OnAir,
    landed: Vec<Landed>,
    repeaters: Vec<Repeater>,
    /// The number of packets that were handed in.
    handed: u64,
    /// When something happens next.
    next_us: Option<u64>,
    /// The packet that is arriving, and the stations that receive it.
    arriving: [u8; MAX_P2P],
    heard: Vec<Receipt>,
    tally: Tally,
}

impl Medium {
    /// A medium between so many stations, 64 at most, on which nothing has been sent.
    #[must_use]
    pub fn new(config: MediumConfig, stations: usize, seed: u64) -> Self {
        assert!(stations <= MOST_STATIONS, "{stations} stations are more than a medium has");
        let chip = |n: usize| {
            let phase = Stream::new(seed, Purpose::Chip(n as u8)).uniform();
            Chip::new(phase, config.polling.filter(|polling| polling.station == n))
        };
        Self {
            config,
            links: streams(stations, seed),
            fades: LinkFades::new(config.fades, stations, seed),
            deviations: None,
            chips: (0..stations).map(chip).collect(),
            pending: BinaryHeap::new(),
            on_air: OnAir::default(),
            landed: Vec::new(),
            repeaters: Vec::new(),
            handed: 0,
            next_us: None,
            arriving: [0; MAX_P2P],
            heard: Vec::with_capacity(stations),
            tally: Tally::default(),
        }
    }

    /// The medium with packets that scatter as recorded ones did, where there is a recording.
    #[must_use]
    pub fn through(self, recorded: Option<&Arc<RecordedChannel>>, seed: u64) -> Self {
        let stations = self.chips.len();
        let deviations = recorded.map(|channel| PacketDeviations::new(channel, stations, seed));
        Self { deviations, ..self }
    }

    /// Where packets arrive.
    #[must_use]
    pub const fn arrives(&self) -> Arrives {
        self.config.arrives
    }

    /// Takes bytes that a processor hands to its radio. Those beyond the length of a P2P packet are
    /// cut off.
    pub fn send(&mut self, from: usize, now_us: u64, data: &[u8]) {
        let Some(chip) = self.chips.get_mut(from) else { return };
        let at_us = chip.take(now_us, data.len().min(MAX_P2P));
        self.put(from, at_us, true, data);
    }

    /// Puts bytes on the air at `start_us`, which is now or later.
    pub fn inject(&mut self, from: usize, start_us: u64, data: &[u8]) {
        self.put(from, start_us.saturating_sub(timing::RAMP_UP_US), false, data);
    }

    fn put(&mut self, from: usize, at_us: u64, queues: bool, bytes: &[u8]) {
        let length = bytes.len().min(MAX_P2P);
        let mut data = [0; MAX_P2P];
        data[..length].copy_from_slice(&bytes[..length]);
        let number = self.handed;
        self.handed += 1;
        self.pending.push(Reverse(Pending { at_us, number, from, queues, length, data }));
        self.next_us = Some(self.next_us.map_or(at_us, |next_us| next_us.min(at_us)));
    }

    /// Puts a carrier without a packet on the air: a station receives only packets that are much
    /// stronger.
    pub fn jam(&mut self, from: usize, start_us: u64, until_us: u64) {
        self.on_air.put(Transmission::carrier(from, start_us, until_us));
    }

    /// Has these repeaters, and no others, send what they hear from now on. No repeater repeats
    /// another one.
    pub fn repeat(&mut self, repeaters: &[Repeater]) {
        self.repeaters = repeaters.to_vec();
    }

    /// Sends a packet that has come off the air once more from the repeaters that are in its reach, and
    /// takes it from those at whom they jam it. An ear is better than a drone's radio: nothing on the
    /// air keeps it from hearing, and no packet is lost there by chance.
    fn echo(&mut self, packet: &Transmission, ether: &mut impl Ether) {
        let Transmission { from, length, data, end_us, .. } = *packet;
        if self.repeaters.iter().any(|repeater| repeater.mouth == from) {
            return;
        }
        for at in 0..self.repeaters.len() {
            let Repeater { ear, mouth, delay_us, jams } = self.repeaters[at];
            let reception = self.config.reception;
            if !ether.strength(from, ear).is_some_and(|strength| reception.reaches(strength)) {
                continue;
            }
            self.inject(mouth, end_us + delay_us.max(timing::RAMP_UP_US), &data[..length]);
            let is_radio = |station| {
                self.repeaters.iter().any(|other| [other.ear, other.mouth].contains(&station))
            };
            self.heard.retain(|receipt| {
                is_radio(receipt.by)
                    || match jams {
                        Jams::Nothing => true,
                        Jams::Weaker => {
                            ether.strength(mouth, receipt.by).is_none_or(|copy| copy < receipt.rssi)
                        }
                        Jams::All => false,
                    }
            });
        }
    }

    /// When something happens next on the way of a packet; `None` while there is none.
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

    /// Lets happen what is next: a packet goes on the air, comes off it, or arrives, and then it is
    /// returned. One that no station receives arrives when it comes off the air. All that was sent
    /// before must have been handed in.
    pub fn advance(&mut self, ether: &mut impl Ether) -> Option<Arrival<'_>> {
        let now_us = self.next_us?;
        let arrived = if self.begin(now_us) {
            None
        } else if let Some((at, packet, is_contested)) = self.on_air.end(now_us) {
            self.land(at, &packet, is_contested, ether)
        } else {
            self.deliver(now_us)
        };
        self.next_us = self.soonest();
        let (from, length) = arrived?;
        Some(Arrival { at_us: now_us, from, data: &self.arriving[..length], heard: &self.heard })
    }

    fn soonest(&self) -> Option<u64> {
        let begins_us = self.pending.peek().map(|Reverse(pending)| pending.at_us);
        let arrives_us = self.landed.iter().flat_map(|landed| &landed.receipts);
        let arrives_us = arrives_us.map(|(at_us, _)| *at_us).min();
        [begins_us, self.on_air.next_end_us(), arrives_us].into_iter().flatten().min()
    }

    /// Gives the packet that is next to its radio, if one is, or to the queue of the main loop.
    fn begin(&mut self, now_us: u64) -> bool {
        let is_due = |Reverse(pending): &Reverse<Pending>| pending.at_us == now_us;
        if !self.pending.peek().is_some_and(is_due) {
            return false;
        }
        let Some(Reverse(packet)) = self.pending.pop() else { return false };
        if packet.queues
            && let Some(chip) = self.chips.get_mut(packet.from)
        {
            let free_us = chip.free_at(now_us);
            if free_us > now_us {
                self.pending.push(Reverse(Pending { at_us: free_us, ..packet }));
                return true;
            }
        }
        let datarate = self.config.datarate;
        let start_us = now_us + timing::RAMP_UP_US;
        let air_us = timing::air_us(datarate, packet.length);
        let times = (start_us, start_us + timing::address_us(datarate), start_us + air_us);
        let data = &packet.data[..packet.length];
        self.on_air.put(Transmission::packet(packet.from, times, data));
        self.tally.sent += 1;
        self.tally.bytes += packet.length as u64;
        self.tally.air_us += air_us;
        true
    }

    /// Decides which stations receive a packet that comes off the air, and hands it to their chips,
    /// or returns it where it arrives at the antenna.
    fn land(
        &mut self,
        at: usize,
        packet: &Transmission,
        is_contested: bool,
        ether: &mut impl Ether,
    ) -> Option<(usize, usize)> {
        if is_contested {
            let reception = self.config.reception;
            let air = (self.chips.len(), self.config.capture);
            self.on_air.settle(at, air, ether, |strength| reception.reaches(strength));
        }
        let Transmission { from, length, data, end_us, .. } = *packet;
        self.heard.clear();
        for to in (0..self.chips.len()).filter(|&to| to != from) {
            let at = is_contested.then_some(at);
            match self.reception(packet, at, to, ether) {
                Ok(rssi) => {
                    self.tally.heard += 1;
                    self.heard.push(Receipt { by: to, rssi });
                }
                Err(loss) => self.tally.lose(loss),
            }
        }
        self.echo(packet, ether);
        self.on_air.forget(end_us);
        if self.config.arrives == Arrives::AtAntenna {
            self.arriving = data;
            return Some((from, length));
        }
        let mut receipts = Vec::with_capacity(self.heard.len());
        for receipt in &self.heard {
            match self.chips[receipt.by].forward(end_us, length) {
                Some(at_us) => receipts.push((at_us, *receipt)),
                None => {
                    self.tally.heard -= 1;
                    self.tally.lose(Loss::Deaf);
                }
            }
        }
        if receipts.is_empty() {
            self.arriving = data;
            self.heard.clear();
            return Some((from, length));
        }
        self.landed.push(Landed { from, length, data, receipts });
        None
    }

    /// Takes the packet that is at processors now.
    fn deliver(&mut self, now_us: u64) -> Option<(usize, usize)> {
        let is_due = |landed: &Landed| landed.receipts.iter().any(|(at_us, _)| *at_us == now_us);
        let place = self.landed.iter().position(is_due)?;
        let landed = &mut self.landed[place];
        self.heard.clear();
        for (_, receipt) in landed.receipts.iter().filter(|(at_us, _)| *at_us == now_us) {
            self.heard.push(*receipt);
            self.chips[receipt.by].forwarded();
        }
        landed.receipts.retain(|(at_us, _)| *at_us != now_us);
        self.arriving = landed.data;
        let (from, length) = (landed.from, landed.length);
        if landed.receipts.is_empty() {
            self.landed.swap_remove(place);
        }
        Some((from, length))
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
        let reception = self.config.reception;
        let strength = ether
            .strength(packet.from, to)
            .filter(|&strength| reception.reaches(strength))
            .ok_or(Loss::Weak)?;
        if packet.cut {
            return Err(Loss::Cut);
        }
        if let Some(at) = at {
            self.on_air.contest(at, to, (strength, self.config.capture), ether)?;
        }
        if let Some(polling) = self.config.polling {
            self.bear(polling, packet, to, strength, ether)?;
        }
        if self.fades.is_faded(packet.from, to, packet.end_us) {
            return Err(Loss::Chance);
        }
        let stream = &mut self.links[packet.from * self.chips.len() + to];
        let luck = stream.uniform();
        if luck < reception.loss_rate {
            return Err(Loss::Chance);
        }
        let deviation = self.deviations.as_mut();
        let deviation = deviation.map(|all| all.next(packet.from, to, packet.end_us));
        let draws =
            Draws { luck, normal: stream.gauss(), deviation: deviation.unwrap_or_default() };
        reception.receive(strength, timing::air_bits(packet.length), draws).ok_or(Loss::Weak)
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
        let (datarate, from_us, until_us) = (self.config.datarate, packet.start_us, packet.end_us);
        if to == polling.station {
            let is_deaf = polling.deafens(datarate, from_us, until_us);
            return if is_deaf { Err(Loss::Deaf) } else { Ok(()) };
        }
        if !polling.disturbs(datarate, from_us, until_us) {
            return Ok(());
        }
        let against = ether.strength(polling.station, to);
        if against.is_some_and(|against| strength - against < self.config.capture) {
            return Err(Loss::Collision);
        }
        Ok(())
    }
}
