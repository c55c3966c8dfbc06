//! Simulates the operator's own traffic: a Crazyradio beside the base polls it a hundred or a
//! thousand times a second, and the base answers. Neither keeps to a drone's slots.
//!
//! `rate_limit=100` in the address is what Bitcraze tells users of P2P to give, as a dongle that
//! asks as fast as it can leaves no time on the air to other stations (docs of crazyflie-firmware, `p2p_api.md`).

use wire::radio::Datarate;

use super::timing::{RAMP_UP_US, payload_air_us};

/// How often a second the base has something to say: a log of ten variables.
const LOG_HZ: f32 = 100.0;

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
    /// A dongle that asks so often a second, beside a base that logs 100 times a second.
    ///
    /// 100 is the rate that the vendor's documentation asks for. Without a rate limit, as cflib drives
    /// it, a dongle asks as soon as it is answered, about a thousand times a second over USB, and
    /// pauses only after ten empty answers, which a log at 100 Hz prevents (crazyflie-lib-python,
    /// `cflib/crtp/radiodriver.py`, `_RadioDriverThread.run`).
    #[must_use]
    pub fn at(station: usize, hz: f32) -> Self {
        Self {
            station,
            // Less than a question in a quarter of an hour is none.
            period_us: (1e6 / hz).min(1e9) as u64,
            question: 1,
            answer: 28,
            answers_every: ((hz / LOG_HZ).round() as u64).max(1),
        }
    }

    /// When the question of this number begins: the host's timers are good to 2 ms, and a dongle
    /// without a rate limit keeps no time at all. With less jitter all frames of a chain would meet the
    /// questions at the same places, for ever.
    fn begin_us(&self, number: u64) -> u64 {
        let mixed = number.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40;
        let jitter_us = (self.period_us * 6 / 10).min(2_000);
        number * self.period_us + mixed % (jitter_us + 1)
    }

    fn end_us(&self, datarate: Datarate, number: u64) -> u64 {
        let answer = if number.is_multiple_of(self.answers_every) { self.answer } else { 1 };
        let air = payload_air_us(datarate, self.question) + payload_air_us(datarate, answer);
        self.begin_us(number) + air + RAMP_UP_US
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
