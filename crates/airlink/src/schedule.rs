//! The schedule of transmissions: the turns of each node in a frame of 100 ms that repeats for
//! ever.
//!
//! Every node has two turns in a frame. In the *outward* wave the base, with the largest number,
//! sends first and each next node towards the head after it, so that an order crosses the whole
//! chain within one frame. The *inward* wave carries telemetry the other way. The two waves are
//! interleaved, slot by slot.
//!
//! In a chain that is stretched, so that a node hears only nodes up to two numbers away, no receiver
//! hears two nodes whose numbers are six apart. There a node [may use](Turns::Shared) the turns of the
//! numbers 6 and 12 from its own as well: three times as many.

use core::fmt;

use units::{Duration, Instant, NODES, NodeId};
use wire::p2p::{Counter, HEADER, Header, REUSE, TAG, Wave};
use wire::radio::Datarate;
use wire::radio::timing::{
    RAMP_UP_US, REPORTS_US, air_us, apart_us, handed_soonest_us, sending_us, soonest_us,
};
use wire::syslink::MAX_P2P;

/// Length of a frame, in which every node has two turns.
pub const FRAME: Duration = Duration::from_millis(100);

/// [`FRAME`] in µs, the unit of all calculations in this module.
const FRAME_US: u64 = FRAME.as_micros();

/// A packet begins up to this many µs after its turn, by a hash of its counter, so that two chains,
/// or two newcomers, that happen to have the same turns do not collide for ever.
const JITTER_US: u64 = 300;

const LONGEST: usize = MAX_P2P;
const SHORTEST: usize = HEADER + 1 + TAG;

/// How late, in µs, a packet may be given to the serial line, unless the slot has room for less. A
/// packet that is later waits for the next turn.
const LATE_US: u64 = 500;

/// The error that a node's number has no turn at this data rate.
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
    /// Length of a turn in µs.
    slot_us: u32,
}

/// A turn of this node: from `start` on packets may be given to the serial line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Turn {
    pub(crate) start: Instant,
    pub(crate) wave: Wave,
    /// The node whose number has this turn.
    pub(crate) owner: NodeId,
}

/// The turns that a node may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turns {
    /// Those of its own number.
    Own,
    /// Also those of the numbers that differ from its own by a multiple of [`REUSE`].
    Shared,
}

impl Schedule {
    /// The schedule of `node` at this data rate.
    ///
    /// # Errors
    /// [`Full`] if the node's number has no turns.
    pub const fn new(datarate: Datarate, node: NodeId) -> Result<Self, Full> {
        let capacity = Self::capacity(datarate);
        if node.0 >= capacity {
            return Err(Full);
        }
        let slot_us = (FRAME_US / (2 * capacity as u64)) as u32;
        Ok(Self { node, datarate, slot_us })
    }

    /// The number of nodes that have turns. At 250 kbit/s, where a packet takes a longer slot,
    /// there are fewer.
    #[must_use]
    pub const fn capacity(datarate: Datarate) -> u8 {
        match datarate {
            Datarate::Mbit2 | Datarate::Mbit1 => NODES as u8,
            Datarate::Kbit250 => 8,
        }
    }

    /// Length of a turn.
    #[must_use]
    pub const fn slot(&self) -> Duration {
        Duration::from_micros(self.slot_us())
    }

    /// Half the length of a turn: two moments that are nearer to each other belong to one turn.
    #[inline]
    pub(crate) const fn half_slot(&self) -> Duration {
        Duration::from_micros(self.slot_us() / 2)
    }

    /// The most packets that one turn holds.
    #[must_use]
    pub const fn burst(&self) -> u8 {
        match self.datarate {
            Datarate::Mbit2 | Datarate::Mbit1 => 2,
            Datarate::Kbit250 => 1,
        }
    }

    /// Time that a packet of `length` bytes takes on the air.
    #[must_use]
    pub const fn air_time(&self, length: usize) -> Duration {
        Duration::from_micros(air_us(self.datarate, length))
    }

    /// Whether `node` has turns at this data rate.
    pub(crate) const fn has_turns(&self, node: NodeId) -> bool {
        node.0 < Self::capacity(self.datarate)
    }

    #[inline]
    const fn slot_us(&self) -> u64 {
        self.slot_us as u64
    }

    /// Time in µs from one packet of a turn to the next, so that no second packet cuts the first off,
    /// be it the shortest after the longest.
    const fn apart_us(&self) -> u64 {
        apart_us(self.datarate, LONGEST, SHORTEST)
    }

    /// Time in µs that a turn has left for packets that are late, where its packets are
    /// [`apart_us`](Self::apart_us) from each other: its last packet is off the air before the first
    /// one of the next turn can be on it.
    const fn spare_us(&self) -> u64 {
        let last = (self.burst() as u64 - 1) * self.apart_us();
        let next = handed_soonest_us(SHORTEST) + RAMP_UP_US;
        self.slot_us() + next - JITTER_US - last - sending_us(self.datarate, LONGEST)
    }

    /// Time in µs by which packets are farther apart than they must be, as the turn has room for it.
    /// Where the chip tells its processor the battery's voltage just before it comes to the first
    /// packet, the second is not to cut that one off either.
    const fn margin_us(&self) -> u64 {
        let room = self.spare_us().saturating_sub(LATE_US);
        if room < REPORTS_US { room } else { REPORTS_US }
    }

    /// Time from one packet of a turn to the next. The radio chip has one buffer, and begins to send
    /// the next packet whatever it is sending (crazyflie2-nrf-firmware, `esb.c`).
    pub(crate) const fn spacing(&self) -> Duration {
        Duration::from_micros(self.apart_us() + self.margin_us())
    }

    /// How late a packet may begin so that its turn still has room for it.
    pub(crate) const fn lateness(&self) -> Duration {
        let margins = (self.burst() as u64 - 1) * self.margin_us();
        let room = self.spare_us() - margins;
        Duration::from_micros(if room < LATE_US { room } else { LATE_US })
    }

    /// Time in µs from the beginning of the frame to the turn of `node`.
    #[inline]
    const fn offset_us(&self, node: NodeId, wave: Wave) -> u64 {
        let slot = match wave {
            Wave::Outward => 2 * (Self::capacity(self.datarate) - 1).saturating_sub(node.0),
            Wave::Inward => 2 * node.0 + 1,
        };
        slot as u64 * self.slot_us()
    }

    /// Time from the beginning of a turn to the moment at which its packet `place`, numbered
    /// `counter`, is given to the serial line.
    #[inline]
    pub(crate) fn wait(&self, counter: Counter, place: u8) -> Duration {
        let first = counter.count().wrapping_sub(u32::from(place));
        Duration::from_micros(
            hashed(first, JITTER_US) + u64::from(place) * self.spacing().as_micros(),
        )
    }

    /// Time from the beginning of the sender's frame to the earliest moment at which all `length`
    /// bytes of its packet have come through the receiver's serial line.
    pub(crate) fn since_frame(&self, header: &Header, length: usize) -> Duration {
        let micros = self.offset_us(header.owner, header.wave)
            + self.wait(header.counter, header.place).as_micros()
            + soonest_us(self.datarate, length);
        Duration::from_micros(micros)
    }

    /// The numbers whose turns this node uses.
    fn owners(&self, turns: Turns) -> impl Iterator<Item = NodeId> {
        let (mut next, step) = match turns {
            Turns::Own => (self.node.0, NODES as u8),
            Turns::Shared => (self.node.0 % REUSE, REUSE),
        };
        core::iter::from_fn(move || {
            let owner = next;
            next += step;
            (owner < Self::capacity(self.datarate)).then_some(NodeId(owner))
        })
    }

    /// The turn of this node that `now` is in, if any.
    pub(crate) fn turn_at(&self, now: Instant, phase: FramePhase, turns: Turns) -> Option<Turn> {
        let in_frame = phase.into_frame(now);
        [Wave::Outward, Wave::Inward].into_iter().find_map(|wave| {
            self.owners(turns).find_map(|owner| {
                let since = in_frame.checked_sub(self.offset_us(owner, wave))?;
                let start = now - Duration::from_micros(since);
                (since < self.slot_us()).then_some(Turn { start, wave, owner })
            })
        })
    }

    /// The first turn of `wave` that begins at `earliest` or later.
    #[inline(never)]
    pub(crate) fn turn_from(
        &self,
        wave: Wave,
        earliest: Instant,
        phase: FramePhase,
        turns: Turns,
    ) -> Turn {
        let in_frame = phase.into_frame(earliest) as u32;
        let (mut soonest, mut first) = (u32::MAX, self.node);
        for owner in self.owners(turns) {
            let offset = self.offset_us(owner, wave) as u32;
            let later = if offset >= in_frame { 0 } else { FRAME_US as u32 };
            let wait = offset + later - in_frame;
            if wait < soonest {
                (soonest, first) = (wait, owner);
            }
        }
        Turn { start: earliest + Duration::from_micros(soonest.into()), wave, owner: first }
    }
}

/// The time at which frames begin on this node's clock, in µs modulo the length of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FramePhase(u32);

impl FramePhase {
    pub(crate) const fn at(micros: u64) -> Self {
        Self((micros % FRAME_US) as u32)
    }

    /// The phase of a frame that began `span` before `now`; `span` is shorter than two frames.
    #[inline]
    pub(crate) const fn before(now: Instant, span: Duration) -> Self {
        Self::at(now.as_micros() + 2 * FRAME_US - span.as_micros())
    }

    /// Time in µs from the beginning of the frame to `now`.
    #[inline]
    fn into_frame(self, now: Instant) -> u64 {
        (now.as_micros() + FRAME_US - u64::from(self.0)) % FRAME_US
    }

    /// How many µs `other` is later than this phase, between minus half a frame and half a frame.
    pub(crate) fn until(self, other: Self) -> i32 {
        let half = FRAME_US as i32 / 2;
        let frame = FRAME_US as i32;
        (other.0 as i32 - self.0 as i32 + half).rem_euclid(frame) - half
    }

    /// The phase that is `micros` µs later.
    pub(crate) fn moved(self, micros: i32) -> Self {
        Self((self.0 as i32 + micros).rem_euclid(FRAME_US as i32) as u32)
    }
}

/// Knuth's multiplicative hash (The Art of Computer Programming 3, §6.4), scaled to `below`.
fn hashed(number: u32, below: u64) -> u64 {
    (u64::from(number.wrapping_mul(2_654_435_769) >> 16) * below) >> 16
}

/// The additional time that `node` listens before it sends for the first time, so that nodes that
/// are switched on together do not all begin to send together.
pub(crate) fn first_wait(node: NodeId) -> Duration {
    Duration::from_micros(hashed(u32::from(node.0), FRAME_US))
}

const _: () = {
    let rates = [Datarate::Kbit250, Datarate::Mbit1, Datarate::Mbit2];
    let mut at = 0;
    while at < rates.len() {
        let Ok(schedule) = Schedule::new(rates[at], NodeId::HEAD) else { panic!() };
        assert!(schedule.lateness().as_micros() >= 200, "the last packet of a turn ends within it");
        at += 1;
    }
};

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use wire::p2p::{Epoch, Kind};
    use wire::radio::timing::handed_latest_us;

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
    fn a_packet_sent_in_a_turn_tells_the_senders_phase() {
        let (sender, receiver) = (NodeId(5), NodeId(4));
        let sending = Schedule::new(Datarate::Mbit1, sender).unwrap();
        let receiving = Schedule::new(Datarate::Mbit1, receiver).unwrap();
        let phase = FramePhase::at(77_777);
        for (count, place, wave) in
            [(9, 0, Wave::Outward), (10, 1, Wave::Outward), (3, 0, Wave::Inward)]
        {
            let counter = Counter::new(Epoch::FIRST, count).unwrap();
            let turn = sending.turn_from(wave, Instant::from_millis(5_000), phase, Turns::Shared);
            let (kind, owner) = (Kind::Report, turn.owner);
            let header = Header { kind, from: sender, wave, place, owner, counter };
            let on_line = turn.start + sending.wait(counter, place);
            let length = 52;
            let arrival = on_line + Duration::from_micros(soonest_us(Datarate::Mbit1, length));
            let since = receiving.since_frame(&header, length);
            assert_eq!(FramePhase::before(arrival, since), phase);
        }
    }

    /// What the chip does with two packets of a turn, at each rate and in each phase of its main
    /// loop: the second is given to the radio when the first is off the air.
    #[test]
    fn no_packet_of_a_turn_cuts_off_the_one_before_it() {
        for datarate in [Datarate::Mbit1, Datarate::Mbit2] {
            let spacing_us = Schedule::new(datarate, NodeId::HEAD).unwrap().spacing().as_micros();
            for first in SHORTEST..=LONGEST {
                let off_air_us = handed_latest_us(first) + RAMP_UP_US + air_us(datarate, first);
                for second in SHORTEST..=LONGEST {
                    let handed_us = spacing_us + handed_soonest_us(second);
                    assert!(off_air_us <= handed_us, "{datarate:?}: {first} B, then {second} B");
                    // At 2 Mbit/s the chip may tell its processor something as well.
                    let reports_us = if datarate == Datarate::Mbit2 { REPORTS_US } else { 0 };
                    assert!(off_air_us + reports_us <= handed_us, "{first} B, then {second} B");
                }
            }
        }
    }

    #[test]
    fn these_are_the_times_of_a_turn() {
        let times = [Datarate::Kbit250, Datarate::Mbit1, Datarate::Mbit2].map(|datarate| {
            let schedule = Schedule::new(datarate, NodeId::HEAD).unwrap();
            [schedule.slot(), schedule.spacing(), schedule.lateness()].map(Duration::as_micros)
        });
        assert_eq!(times, [[6_250, 3_353, 500], [3_125, 1_379, 207], [3_125, 1_362, 500]]);
    }

    #[test]
    fn the_difference_of_two_phases_is_taken_the_shorter_way_round() {
        let (early, late) = (FramePhase::at(200), FramePhase::at(99_900));
        assert_eq!(late.until(early), 300);
        assert_eq!(early.until(late), -300);
        assert_eq!(early.moved(-300), late);
    }
}
