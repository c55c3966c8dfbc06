//! Simulates the operator's own traffic: a Crazyradio beside the base polls it a hundred or a
//! thousand times a second, and the base answers. Neither keeps to a drone's slots.
//!
//! `rate_limit=100` in the address is what Bitcraze tells users of P2P to give, as a dongle that
//! asks as fast as it can leaves no time on the air to other stations (docs of crazyflie-firmware, `p2p_api.md`).

use wire::radio::Datarate;

use super::timing::{TURN_US, raw_air_us};

/// A dongle at work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polling {
    /// The station that it asks. The dongle is beside it: all others hear both equally well.
    pub station: usize,
    /// Microseconds between two questions.
    pub period_us: u64,
    /// Bytes of a question: one where the operator has nothing to say, 31 at most.
    pub question: usize,
    /// Bytes of an answer: the log of ten variables at 100 Hz is 27 or so.
    pub answer: usize,
    /// One in so many answers is that long; the others are one byte, as the base has nothing to say.
    pub answers_every: u64,
}

impl Polling {
    /// The rate that the vendor's documentation asks for, with a log running.
    #[must_use]
    pub const fn of(station: usize) -> Self {
        Self { station, period_us: 10_000, question: 1, answer: 28, answers_every: 1 }
    }

    /// A dongle without a rate limit, as cflib drives it: it asks as soon as it is answered, about a
    /// thousand times a second over USB, and pauses only after ten empty answers, which a log at
    /// 100 Hz prevents (crazyflie-lib-python, `cflib/crtp/radiodriver.py`, `_RadioDriverThread.run`).
    #[must_use]
    pub const fn unlimited(station: usize) -> Self {
        Self { period_us: 1_000, answers_every: 10, ..Self::of(station) }
    }

    /// When the question of this number begins: the host's timers are good to a millisecond or
    /// two, or a frame of ten questions would meet the same slots for ever.
    const fn begin_us(&self, number: u64) -> u64 {
        let mixed = number.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40;
        number * self.period_us + mixed % (self.period_us / 5 + 1)
    }

    const fn end_us(&self, datarate: Datarate, number: u64) -> u64 {
        let answer = if number.is_multiple_of(self.answers_every) { self.answer } else { 1 };
        let air = raw_air_us(datarate, self.question as u64) + raw_air_us(datarate, answer as u64);
        self.begin_us(number) + air + TURN_US
    }

    /// Whether question or answer is on the air at any time between these two.
    pub(super) fn overlaps(&self, datarate: Datarate, from_us: u64, until_us: u64) -> bool {
        let first = (from_us / self.period_us).saturating_sub(1);
        let last = until_us / self.period_us;
        (first..=last).any(|number| {
            self.begin_us(number) < until_us && from_us < self.end_us(datarate, number)
        })
    }
}
