//! Simulates the operator's own traffic: a Crazyradio beside the base polls it a hundred or a
//! thousand times a second, and the base answers. Neither keeps to a drone's slots.
//!
//! `rate_limit=100` in the address is what Bitcraze tells users of P2P to give, as a dongle that
//! asks as fast as it can leaves no time on the air to other stations (docs of crazyflie-firmware, `p2p_api.md`).

use wire::radio::Datarate;

use super::timing::{ANSWERS_AFTER_US, LISTENS_AFTER_US, payload_air_us};

/// How often a second the base has something to say: a log of ten variables.
const LOG_HZ: f32 = 100.0;

/// How much longer than asked for the pause between two questions is: a host that is to wait for 10 ms
/// wakes up some tens of microseconds later, and a dongle without a rate limit asks as soon as USB
/// lets it.
const LONGER_PERMILLE: u64 = 7;

/// A dongle at work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polling {
    /// The station that it asks. The dongle is beside it: all others hear both equally well.
    pub station: usize,
    /// Microseconds between two questions, as the host is asked for.
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

    /// Microseconds between two questions, as the host keeps them.
    pub(super) const fn true_period_us(&self) -> u64 {
        self.period_us + self.period_us * LONGER_PERMILLE / 1_000
    }

    /// When the question of this number begins: the host's timers are good to 2 ms, and a dongle
    /// without a rate limit keeps no time at all. A pause is never shorter than was asked for, so that
    /// the questions wander through the frames of a chain. With less jitter, or without the wandering,
    /// all frames would meet the questions at the same places, for ever.
    fn begin_us(&self, number: u64) -> u64 {
        let mixed = mixed(number);
        let jitter_us = (self.period_us * 6 / 10).min(2_000);
        number * self.true_period_us() + mixed % (jitter_us + 1)
    }

    /// When a question begins and ends on the air, and when the answer does.
    fn spans(&self, datarate: Datarate, number: u64) -> [(u64, u64); 2] {
        let answer = if number.is_multiple_of(self.answers_every) { self.answer } else { 1 };
        let asked_us = self.begin_us(number);
        let heard_us = asked_us + payload_air_us(datarate, self.question);
        let answers_us = heard_us + ANSWERS_AFTER_US;
        [(asked_us, heard_us), (answers_us, answers_us + payload_air_us(datarate, answer))]
    }

    /// Whether any question of those that may matter between these two moments is as said.
    fn any(&self, from_us: u64, until_us: u64, is: impl Fn(u64) -> bool) -> bool {
        let period_us = self.true_period_us();
        let first = (from_us / period_us).saturating_sub(2);
        (first..=until_us / period_us).any(is)
    }

    /// Whether the station that is asked is deaf at any time between these two: from the beginning of
    /// a question until its radio receives again behind the answer.
    pub(super) fn deafens(&self, datarate: Datarate, from_us: u64, until_us: u64) -> bool {
        self.any(from_us, until_us, |number| {
            let [(asked_us, _), (_, answered_us)] = self.spans(datarate, number);
            asked_us < until_us && from_us < answered_us + LISTENS_AFTER_US
        })
    }

    /// Whether question or answer is on the air at any time between these two.
    pub(super) fn disturbs(&self, datarate: Datarate, from_us: u64, until_us: u64) -> bool {
        self.any(from_us, until_us, |number| {
            let spans = self.spans(datarate, number);
            spans.iter().any(|(begin_us, end_us)| *begin_us < until_us && from_us < *end_us)
        })
    }
}

/// A number that has nothing to do with those of the questions before and after (the finaliser of
/// SplitMix64; Steele, Lea, Flood 2014). With multiples of one number a step of 99 questions,
/// which is about a frame, would always be the same step of the result.
const fn mixed(number: u64) -> u64 {
    let z = number.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ z >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Measured with the vendor's program on an emulated chip: the chip receives again 348 µs behind
    /// a question that it answers with one byte.
    #[test]
    fn a_station_is_deaf_from_a_question_until_348_microseconds_behind_it() {
        let polling = Polling { answers_every: u64::MAX, ..Polling::at(0, 1_000.0) };
        let asked_us = polling.begin_us(7);
        let heard_us = asked_us + payload_air_us(Datarate::Mbit2, 1);
        let is_deaf = |at_us| polling.deafens(Datarate::Mbit2, at_us, at_us + 1);
        assert!(!is_deaf(asked_us - 1) && is_deaf(asked_us));
        let behind_us = (0..).find(|behind_us| !is_deaf(heard_us + behind_us)).unwrap();
        assert!((340..=348).contains(&behind_us), "{behind_us}");
        // The others hear while neither question nor answer is on the air.
        let is_disturbed = |at_us| polling.disturbs(Datarate::Mbit2, at_us, at_us + 1);
        assert!(is_disturbed(asked_us) && is_disturbed(heard_us + ANSWERS_AFTER_US));
        assert!(!is_disturbed(heard_us) && !is_disturbed(heard_us + ANSWERS_AFTER_US - 1));
    }

    /// A packet that is sent again in each frame of 100 ms is soon sent while no question is on the air.
    #[test]
    fn a_packet_that_is_repeated_in_each_frame_gets_through() {
        let polling = Polling::at(0, 1_000.0);
        let meets = |at_us: u64| polling.disturbs(Datarate::Mbit2, at_us, at_us + 261);
        let share = (0..2_000).filter(|n| meets(n * 997)).count();
        assert!((800..1_100).contains(&share), "{share} of 2,000 are met");
        let in_a_row =
            |from_us: u64| (0..20).take_while(|frame| meets(from_us + frame * 100_000)).count();
        let long = (0..20_000).filter(|n| in_a_row(10_000_000 + n * 1_331) >= 10).count();
        // Were each met by chance, 0.5 to the tenth are 20 of 20,000.
        assert!(long < 60, "{long} of 20,000 are met ten times in a row");
    }

    /// Seen from the frames of a chain, which last 100 ms, each millisecond of a frame is met as often
    /// as any other.
    #[test]
    fn questions_do_not_meet_the_same_turns_in_every_frame() {
        for hz in [100.0, 1_000.0] {
            let polling = Polling::at(0, hz);
            let mut met = [0_u32; 1_000];
            for frame in 0..2_000_u64 {
                for (at, met) in met.iter_mut().enumerate() {
                    let at_us = frame * 100_000 + 100 * at as u64;
                    *met += u32::from(polling.deafens(Datarate::Mbit2, at_us, at_us + 1));
                }
            }
            let (least, most) = (met.iter().min().unwrap(), met.iter().max().unwrap());
            assert!(*most < 2 * least, "{hz} questions a second: {least} to {most} of 2,000");
        }
    }
}
