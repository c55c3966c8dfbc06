//! Who may speak when: turns in a frame of 100 ms that repeats for ever.
//!
//! Every node has two turns in a frame. In the first half of the air's order the base, with the
//! largest number, comes first and each next node towards the head after it: the *outward* wave
//! carries an order through the whole chain within one frame. The *inward* wave carries telemetry
//! the other way. The two are interleaved, slot by slot.

use core::fmt;

use units::{Duration, Instant, NODES, NodeId};
use wire::p2p::{Counter, HEADER, Header, TAG, Wave};
use wire::radio::Datarate;
use wire::syslink::MAX_P2P;

/// A frame: every node speaks twice in it.
pub const FRAME: Duration = Duration::from_millis(100);

/// [`FRAME`] in µs, in which this module reckons.
const FRAME_US: u64 = FRAME.as_micros();

/// A packet begins up to this many µs after its turn, by a hash of its number: two chains, or two
/// newcomers, that happen to have the same turns do not collide for ever.
const JITTER_US: u64 = 300;

/// The radio of the Crazyflie's nRF51 takes this many µs from being told to send to the first bit
/// (nRF51822 product specification, radio timing: TX enable delay).
const RAMP_UP_US: u64 = 140;

/// A byte on the serial line to the radio chip: 10 bits at 1 Mbaud (crazyflie-firmware, `uart_syslink.c`).
const UART_BYTE_US: u64 = 10;
/// What syslink adds to the data of a P2P packet that is sent: start, type, length, port, checksum.
const SYSLINK_SENT: u64 = 7;
/// And to one that is received, which has its RSSI.
const SYSLINK_RECEIVED: u64 = 8;

/// What Enhanced ShockBurst adds on the air: preamble 1, address 5, P2P header 2, CRC 2 bytes, and
/// the 9 bits of its packet control field (crazyflie2-nrf-firmware, `esb.c`).
const ESB_BITS: u64 = 10 * 8 + 9;

const LONGEST: u64 = MAX_P2P as u64;
const SHORTEST: u64 = (HEADER + 1 + TAG) as u64;

/// How late, in µs, a packet may be given to the serial line. What is later waits for its next
/// turn. It is less where the slot has no room for so much.
const LATE_US: u64 = 500;

/// A node's number has no turn at this data rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Full;

impl fmt::Display for Full {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("no turn in the frame for this node's number")
    }
}

impl core::error::Error for Full {}

/// The turns of one node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Schedule {
    node: NodeId,
    datarate: Datarate,
}

/// A moment at which a packet may be given to the serial line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Turn {
    pub(crate) start: Instant,
    pub(crate) wave: Wave,
}

impl Schedule {
    /// The turns of `node`.
    ///
    /// # Errors
    /// [`Full`] for a number that has none.
    pub const fn new(datarate: Datarate, node: NodeId) -> Result<Self, Full> {
        if node.0 < Self::capacity(datarate) { Ok(Self { node, datarate }) } else { Err(Full) }
    }

    /// How many nodes have turns: a packet at 250 kbit/s takes a longer slot.
    #[must_use]
    pub const fn capacity(datarate: Datarate) -> u8 {
        match datarate {
            Datarate::Mbit2 | Datarate::Mbit1 => NODES as u8,
            Datarate::Kbit250 => 8,
        }
    }

    /// How long a turn lasts.
    #[must_use]
    pub const fn slot(&self) -> Duration {
        Duration::from_micros(self.slot_us())
    }

    /// What is nearer to a moment than that is of the same turn.
    pub(crate) const fn half_slot(&self) -> Duration {
        Duration::from_micros(self.slot_us() / 2)
    }

    /// The most packets in one turn.
    #[must_use]
    pub const fn burst(&self) -> u8 {
        match self.datarate {
            Datarate::Mbit2 | Datarate::Mbit1 => 2,
            Datarate::Kbit250 => 1,
        }
    }

    /// How long a packet of `length` bytes is on the air.
    #[must_use]
    pub const fn air_time(&self, length: usize) -> Duration {
        Duration::from_micros(self.air_us(length as u64))
    }

    pub(crate) const fn has(&self, node: NodeId) -> bool {
        node.0 < Self::capacity(self.datarate)
    }

    const fn slot_us(&self) -> u64 {
        FRAME_US / (2 * Self::capacity(self.datarate) as u64)
    }

    const fn air_us(&self, length: u64) -> u64 {
        let bits = 8 * length + ESB_BITS;
        match self.datarate {
            Datarate::Mbit2 => bits / 2,
            Datarate::Mbit1 => bits,
            Datarate::Kbit250 => bits * 4,
        }
    }

    /// From the serial line of the sender to the end of the packet on the air.
    const fn sending_us(&self, length: u64) -> u64 {
        UART_BYTE_US * (SYSLINK_SENT + length) + RAMP_UP_US + self.air_us(length)
    }

    /// Between the packets of a turn: the shortest may follow the longest, and the radio chip has
    /// one buffer, which the next packet overwrites once it is through the serial line
    /// (crazyflie2-nrf-firmware, `esb.c`).
    pub(crate) const fn spacing(&self) -> Duration {
        let serial = UART_BYTE_US * (SYSLINK_SENT + SHORTEST);
        Duration::from_micros(self.sending_us(LONGEST) - serial)
    }

    /// How late a packet of a turn may begin.
    pub(crate) const fn lateness(&self) -> Duration {
        let last = (self.burst() as u64 - 1) * self.spacing().as_micros();
        let room = self.slot_us() - JITTER_US - last - self.sending_us(LONGEST);
        Duration::from_micros(if room < LATE_US { room } else { LATE_US })
    }

    /// Of `node`'s turn, from the beginning of the frame.
    const fn offset_us(&self, node: NodeId, wave: Wave) -> u64 {
        let place = match wave {
            Wave::Outward => 2 * (Self::capacity(self.datarate) - 1).saturating_sub(node.0),
            Wave::Inward => 2 * node.0 + 1,
        };
        place as u64 * self.slot_us()
    }

    /// How long after the beginning of its turn the packet `place` is given to the serial line, if
    /// its number is `counter`.
    pub(crate) fn wait(&self, counter: Counter, place: u8) -> Duration {
        let first = counter.count().wrapping_sub(u32::from(place));
        Duration::from_micros(
            hashed(first, JITTER_US) + u64::from(place) * self.spacing().as_micros(),
        )
    }

    /// When the frame of the sender of this packet began, modulo frames, if all `length` bytes of
    /// it have just come through the serial line.
    pub(crate) fn phase_of(&self, header: &Header, length: usize, arrival: Instant) -> Phase {
        let length = length as u64;
        let ago = self.offset_us(header.from, header.wave)
            + self.wait(header.counter, header.place).as_micros()
            + self.sending_us(length)
            + UART_BYTE_US * (SYSLINK_RECEIVED + length);
        Phase::at(arrival.as_micros() + 2 * FRAME_US - ago)
    }

    /// The turn that `now` is in.
    pub(crate) fn turn_at(&self, now: Instant, phase: Phase) -> Option<Turn> {
        let into = phase.into_frame(now);
        [Wave::Outward, Wave::Inward].into_iter().find_map(|wave| {
            let since = into.checked_sub(self.offset_us(self.node, wave))?;
            let start = now - Duration::from_micros(since);
            (since < self.slot_us()).then_some(Turn { start, wave })
        })
    }

    /// The first turn of `wave` that begins at `earliest` or later.
    pub(crate) fn turn_from(&self, wave: Wave, earliest: Instant, phase: Phase) -> Turn {
        let offset = self.offset_us(self.node, wave);
        let wait = (offset + FRAME_US - phase.into_frame(earliest)) % FRAME_US;
        Turn { start: earliest + Duration::from_micros(wait), wave }
    }
}

/// When frames begin on this node's clock, modulo frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Phase(u32);

impl Phase {
    pub(crate) const fn at(micros: u64) -> Self {
        Self((micros % FRAME_US) as u32)
    }

    fn into_frame(self, now: Instant) -> u64 {
        (now.as_micros() + FRAME_US - u64::from(self.0)) % FRAME_US
    }

    /// By how many µs `other` is later, the shorter way round.
    pub(crate) fn until(self, other: Self) -> i32 {
        let half = FRAME_US as i32 / 2;
        let frame = FRAME_US as i32;
        (other.0 as i32 - self.0 as i32 + half).rem_euclid(frame) - half
    }

    pub(crate) fn moved(self, micros: i32) -> Self {
        Self((self.0 as i32 + micros).rem_euclid(FRAME_US as i32) as u32)
    }
}

/// Knuth's multiplicative hash (The Art of Computer Programming 3, §6.4), scaled to `below`.
fn hashed(number: u32, below: u64) -> u64 {
    (u64::from(number.wrapping_mul(2_654_435_769) >> 16) * below) >> 16
}

/// How long number `node` waits before it speaks for the first time beyond what everybody does, so
/// that of many that are switched on together not all speak together.
pub(crate) fn first_wait(node: NodeId) -> Duration {
    Duration::from_micros(hashed(u32::from(node.0), FRAME_US))
}

const _: () = {
    let rates = [Datarate::Kbit250, Datarate::Mbit1, Datarate::Mbit2];
    let mut at = 0;
    while at < rates.len() {
        let schedule = Schedule { node: NodeId::HEAD, datarate: rates[at] };
        assert!(schedule.lateness().as_micros() >= 200, "the last packet of a turn ends within it");
        at += 1;
    }
};

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use wire::p2p::{Epoch, Kind};

    use super::*;

    #[test]
    fn no_two_turns_of_a_frame_overlap() {
        for datarate in [Datarate::Kbit250, Datarate::Mbit1, Datarate::Mbit2] {
            let mut starts: Vec<u64> = (0..Schedule::capacity(datarate))
                .flat_map(|node| {
                    let schedule = Schedule::new(datarate, NodeId(node)).unwrap();
                    [Wave::Outward, Wave::Inward].map(|wave| schedule.offset_us(NodeId(node), wave))
                })
                .collect();
            starts.sort_unstable();
            let slot = FRAME_US / starts.len() as u64;
            assert!(starts.iter().zip(0..).all(|(start, place)| *start == place * slot));
        }
    }

    #[test]
    fn a_number_without_a_turn_is_refused() {
        assert_eq!(Schedule::new(Datarate::Mbit2, NodeId(16)), Err(Full));
        assert_eq!(Schedule::new(Datarate::Kbit250, NodeId(8)), Err(Full));
        assert!(Schedule::new(Datarate::Kbit250, NodeId(7)).is_ok());
    }

    #[test]
    fn what_was_sent_in_a_turn_tells_the_senders_phase() {
        let (sender, hearer) = (NodeId(5), NodeId(4));
        let sends = Schedule::new(Datarate::Mbit1, sender).unwrap();
        let hears = Schedule::new(Datarate::Mbit1, hearer).unwrap();
        let phase = Phase::at(77_777);
        for (count, place, wave) in
            [(9, 0, Wave::Outward), (10, 1, Wave::Outward), (3, 0, Wave::Inward)]
        {
            let counter = Counter::new(Epoch::FIRST, count).unwrap();
            let header = Header { kind: Kind::Report, from: sender, wave, place, counter };
            let turn = sends.turn_from(wave, Instant::from_millis(5_000), phase);
            let on_line = turn.start + sends.wait(counter, place);
            let length = 52;
            let flight = sends.sending_us(length) + UART_BYTE_US * (SYSLINK_RECEIVED + length);
            let arrival = on_line + Duration::from_micros(flight);
            assert_eq!(hears.phase_of(&header, length as usize, arrival), phase);
        }
    }

    #[test]
    fn a_phase_is_told_from_another_the_shorter_way_round() {
        let (early, late) = (Phase::at(200), Phase::at(99_900));
        assert_eq!(late.until(early), 300);
        assert_eq!(early.until(late), -300);
        assert_eq!(early.moved(-300), late);
    }
}
