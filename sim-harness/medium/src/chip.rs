//! Simulates what the radio chip's program does beside the radio (crazyflie2-nrf-firmware, `main.c`).
//!
//! Its main loop waits for every byte that it sends to the flight processor, 10 µs each (`uart.c`).
//! Meanwhile a packet that has come from the flight processor is not given to the radio, and one that
//! has come off the air is not passed on. In each round the loop passes on one packet from the air
//! first, and then handles one from the flight processor.

use wire::radio::timing::{LINE_US_PER_BYTE, line_in_us, line_out_us};

use super::Polling;

/// Bytes of a syslink frame around its data.
const FRAME: u64 = 6;
/// The chip tells the battery's state, in 9 bytes, and the strength of the last packet, in one, so
/// often: `SYSLINK_SEND_PERIOD_MS` and the 10 ms beside it.
const REPORT_PERIOD_US: u64 = 10_000;
const REPORT_US: u64 = LINE_US_PER_BYTE * ((FRAME + 9) + (FRAME + 1));
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
    /// A chip whose reports begin at `phase`, a number in [0, 1), of their period.
    pub(super) fn new(phase: f32, polling: Option<Polling>) -> Self {
        Self {
            line_free_us: 0,
            loop_free_us: 0,
            reports: Chore {
                next_us: (phase * REPORT_PERIOD_US as f32) as u64,
                period_us: REPORT_PERIOD_US,
                takes_us: REPORT_US,
            },
            questions: polling.map(|polling| Chore {
                next_us: 0,
                period_us: polling.period_us,
                takes_us: LINE_US_PER_BYTE * (FRAME + polling.question as u64),
            }),
            waiting: 0,
        }
    }

    /// Takes a packet from the flight processor. Returns when its last byte has come.
    pub(super) fn take(&mut self, now_us: u64, data: usize) -> u64 {
        self.line_free_us = now_us.max(self.line_free_us) + line_out_us(data);
        self.line_free_us
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
        self.loop_free_us = self.free_at(at_us) + line_in_us(data);
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

    fn chip() -> Chip {
        Chip::new(0.5, None)
    }

    #[test]
    fn the_loop_waits_for_every_byte_that_it_sends() {
        let mut chip = chip();
        assert_eq!(chip.forward(1_000, 60), Some(1_680));
        assert_eq!(chip.free_at(1_200), 1_680);
        assert_eq!(chip.forward(1_300, 10), Some(1_680 + 180));
        assert_eq!(chip.free_at(1_900), 1_900);
    }

    #[test]
    fn the_battery_and_the_strength_are_told_every_ten_milliseconds() {
        let mut chip = chip();
        assert_eq!(chip.free_at(4_999), 4_999);
        assert_eq!(chip.free_at(5_100), 5_220);
        assert_eq!(chip.free_at(14_990), 14_990);
        // The loop is at something else when they are due, and tells them then.
        assert_eq!(chip.forward(14_995, 60), Some(15_675));
        assert_eq!(chip.free_at(15_500), 15_895);
        // Times that nothing came in are over.
        assert_eq!(chip.free_at(94_000), 94_000);
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
