//! Simulates what the radio chip's program does beside the radio (crazyflie2-nrf-firmware, `main.c`).
//!
//! Its main loop waits for every byte that it sends to the flight processor (`uart.c`). Meanwhile a
//! packet that has come from the flight processor is not given to the radio, and one that has come off
//! the air is not passed on. In each round the loop passes on one packet from the air first, and then
//! handles one from the flight processor. What comes during a round waits for the next one. The times
//! are those of [`wire::radio::timing`].

use wire::radio::timing::{
    PASSING_ON_NS, REPORTS_US, ROUND_NS, frame_in_ns, handed_soonest_us, line_out_us, received_us,
};

use super::Polling;

/// Bytes of a syslink frame around its data.
const FRAME: u64 = 6;
/// The chip tells the battery's state, in 9 bytes, and the strength of the last packet, in one, so
/// often: `SYSLINK_SEND_PERIOD_MS` and the 10 ms beside it.
const REPORT_PERIOD_US: u64 = 10_000;
/// Packets that have come off the air and wait for the loop: eight slots, of which one is always
/// empty (`esb.c`: `RXQ_LEN`), and the one that is being passed on.
const QUEUE: u8 = 8;

/// Something that the loop does again and again.
#[derive(Clone, Copy)]
struct Chore {
    next_us: u64,
    period_us: u64,
    takes_us: u64,
}

impl Chore {
    /// Whether the chore was due by `until_us`; then it is due again a period later.
    fn falls_due(&mut self, until_us: u64) -> bool {
        let Some(late_us) = until_us.checked_sub(self.next_us) else { return false };
        self.next_us += (late_us / self.period_us + 1) * self.period_us;
        true
    }
}

/// A station's radio chip.
pub(super) struct Chip {
    /// How long before the beginning of time a round of the main loop began, in ns.
    round_ns: u64,
    /// When the serial line from the flight processor is free again.
    line_free_us: u64,
    /// When the main loop is free again.
    loop_free_us: u64,
    reports: Chore,
    /// The operator's questions, which the base's chip passes on.
    questions: Option<Chore>,
    /// Packets that wait for the loop.
    waiting: u8,
}

impl Chip {
    /// A chip whose reports and rounds begin at `phase`, a number in [0, 1), of their period.
    pub(super) fn new(phase: f32, polling: Option<Polling>) -> Self {
        Self {
            round_ns: (phase * ROUND_NS as f32) as u64,
            line_free_us: 0,
            loop_free_us: 0,
            reports: Chore {
                next_us: (phase * REPORT_PERIOD_US as f32) as u64,
                period_us: REPORT_PERIOD_US,
                takes_us: REPORTS_US,
            },
            questions: polling.map(|polling| Chore {
                next_us: 0,
                period_us: polling.true_period_us(),
                takes_us: (PASSING_ON_NS + frame_in_ns(FRAME + polling.question as u64))
                    .div_ceil(1_000),
            }),
            waiting: 0,
        }
    }

    /// The time in µs from `at_us` to the next round of an idle main loop.
    const fn next_round_us(&self, at_us: u64) -> u64 {
        (ROUND_NS - (1_000 * at_us + self.round_ns) % ROUND_NS) / 1_000
    }

    /// Takes a packet from the flight processor. Returns when the main loop has read it, and has
    /// nothing else to do.
    pub(super) fn take(&mut self, now_us: u64, data: usize) -> u64 {
        let from_us = now_us.max(self.line_free_us);
        self.line_free_us = from_us + line_out_us(data);
        from_us + self.next_round_us(from_us) + handed_soonest_us(data)
    }

    /// When the main loop gets to what has come at `at_us`.
    pub(super) fn free_at(&mut self, at_us: u64) -> u64 {
        for chore in [Some(&mut self.reports), self.questions.as_mut()].into_iter().flatten() {
            let due_us = chore.next_us;
            if chore.falls_due(at_us.max(self.loop_free_us)) {
                // Of a chore that was due more often, only the last time may still take the loop.
                let last_us = due_us.max(chore.next_us - chore.period_us);
                self.loop_free_us = self.loop_free_us.max(last_us) + chore.takes_us;
            }
        }
        at_us.max(self.loop_free_us)
    }

    /// Passes a packet that has come off the air to the flight processor. Returns when its last byte
    /// is there, or `None` where the packet is dropped because too many wait.
    pub(super) fn forward(&mut self, at_us: u64, data: usize) -> Option<u64> {
        if self.waiting == QUEUE {
            return None;
        }
        self.waiting += 1;
        let free_us = self.free_at(at_us);
        let round_us = if free_us > at_us { 0 } else { self.next_round_us(at_us) };
        self.loop_free_us = free_us + round_us + received_us(data);
        Some(self.loop_free_us)
    }

    /// A packet has been passed on.
    pub(super) const fn forwarded(&mut self) {
        self.waiting -= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chip whose rounds begin with the time, and whose reports are due at 5 ms.
    fn chip() -> Chip {
        Chip { round_ns: 0, ..Chip::new(0.5, None) }
    }

    #[test]
    fn the_loop_waits_for_every_byte_that_it_sends() {
        let mut chip = chip();
        // The round that begins at 1,018 µs finds the packet.
        let passed_us = 1_018 + received_us(60);
        assert_eq!(chip.forward(1_000, 60), Some(passed_us));
        assert_eq!(chip.free_at(1_200), passed_us);
        let passed_us = passed_us + received_us(10);
        assert_eq!(chip.forward(1_300, 10), Some(passed_us));
        assert_eq!(chip.free_at(passed_us + 100), passed_us + 100);
    }

    #[test]
    fn the_battery_and_the_strength_are_told_every_ten_milliseconds() {
        let mut chip = chip();
        assert_eq!(chip.free_at(4_999), 4_999);
        assert_eq!(chip.free_at(5_100), 5_267);
        assert_eq!(chip.free_at(14_990), 14_990);
        // The loop is at something else when they are due, and tells them then.
        let passed_us = chip.forward(14_995, 60).unwrap();
        assert_eq!(chip.free_at(15_500), passed_us + 267);
        // Times that nothing came in are over.
        assert_eq!(chip.free_at(94_000), 94_000);
    }

    #[test]
    fn a_packet_waits_for_the_round_in_which_it_is_read() {
        let mut waits: Vec<u64> = (0..566)
            .map(|n| chip().take(1_000 * n, 17) - 1_000 * n - handed_soonest_us(17))
            .collect();
        waits.sort_unstable();
        assert_eq!((waits[0], waits[565]), (0, 56));
        assert!(waits[283].abs_diff(28) <= 1);
    }

    #[test]
    fn packets_that_come_faster_than_the_line_is_are_dropped() {
        let mut chip = chip();
        let passed = (0..20).filter(|n| chip.forward(300 * n, 60).is_some()).count();
        assert_eq!(passed, 8);
        chip.forwarded();
        assert!(chip.forward(6_000, 60).is_some());
    }
}
