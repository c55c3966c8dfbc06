//! Where the chip's main loop is, and when it comes to the next of its steps.
//!
//! The 16 MHz core goes round and round, with nothing to do most of the time: the battery's regulation
//! computes in floating point in each round. What comes during a round waits for the next one. An
//! interrupt for a byte from the line takes the core away from the loop, so that the loop reads bytes
//! more slowly than the line brings them. The times were measured with the vendor's program on an
//! emulated chip (`nrf51-chip`).

use crate::soc::Nanos;

/// A round in which the loop has nothing to do.
pub const ROUND: Nanos = 56_600;
/// The interrupt for a byte from the line.
pub const INTERRUPT: Nanos = 6_300;
/// The loop reads a byte from the line.
pub const PARSING: Nanos = 7_000;
/// From the last byte of a frame to what it orders.
pub const HANDLING: Nanos = 15_600;
/// What each byte of a frame's data adds to that.
pub const COPYING: Nanos = 930;
/// From the moment at which the loop finds a packet off the air to the first byte for the processor,
/// where the packet has `PASSED_ON` bytes,
pub const PASSING_ON: Nanos = 51_000;
const PASSED_ON: Nanos = 25;
/// and what each byte adds to that: it is copied twice.
const COPYING_TWICE: Nanos = 740;

/// The same interrupt while the loop waits for the end of a byte that it sends: it takes no time of the
/// loop but where that byte ends meanwhile. This is the mean; the bytes themselves are not moved.
pub(super) const WHILE_SENDING: Nanos = 3_600;
/// The radio's interrupt for a packet, while the loop sends.
pub(super) const LANDING: Nanos = 6_000;
/// The radio is powered off, on, and set up for a setting.
pub(super) const TUNING: Nanos = 62_000;

/// From the moment at which the loop finds a packet of so many bytes off the air to the first byte for
/// the processor.
pub(super) const fn passing_on(bytes: usize) -> Nanos {
    PASSING_ON - PASSED_ON * COPYING_TWICE + bytes as Nanos * COPYING_TWICE
}

/// The steps of a round, in its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// One packet from the air is passed on.
    Air,
    /// A byte from the line is read, and the next one, up to the end of a frame.
    Line,
    /// That frame is obeyed.
    Frame,
    Battery,
    Signal,
    Power,
}

const STEPS: [Step; 6] =
    [Step::Air, Step::Line, Step::Frame, Step::Battery, Step::Signal, Step::Power];

/// The loop's place in its round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct MainLoop {
    /// The loop comes to the step of this number, or to the end of the steps,
    step: usize,
    /// at this moment.
    at: Nanos,
    /// The loop waits for what it sends until then; an interrupt costs it no time meanwhile.
    sends_until: Nanos,
}

impl MainLoop {
    /// A loop whose first round begins at this moment.
    pub(super) const fn new(since: Nanos) -> Self {
        Self { step: 0, at: since, sends_until: 0 }
    }

    /// When the loop comes to a step that has something to do from `ready` of it on.
    pub(super) fn next(&self, ready: impl Fn(Step) -> Nanos) -> Nanos {
        let reached = |(n, step)| self.reaches(n, ready(step));
        STEPS.into_iter().enumerate().map(reached).min().unwrap_or(Nanos::MAX)
    }

    fn reaches(&self, step: usize, ready: Nanos) -> Nanos {
        if ready == Nanos::MAX {
            Nanos::MAX
        } else if step >= self.step && ready <= self.at {
            self.at
        } else {
            self.at + ROUND * ready.saturating_sub(self.at).div_ceil(ROUND).max(1)
        }
    }

    /// The step that the loop takes now, of those that have something to do.
    pub(super) fn take(&mut self, now: Nanos, ready: impl Fn(Step) -> Nanos) -> Option<Step> {
        if self.at < now {
            (self.step, self.at) = (0, now);
        }
        let mut steps = STEPS.into_iter().enumerate().skip(self.step);
        let (at, step) = steps.find(|(_, step)| ready(*step) <= now)?;
        // It reads bytes until none is left.
        self.step = if step == Step::Line { at } else { at + 1 };
        Some(step)
    }

    /// The loop has had nothing to do up to this moment.
    pub(super) const fn idle_until(&mut self, now: Nanos) {
        if self.at < now {
            self.at += ROUND * (now - self.at).div_ceil(ROUND);
            self.step = 0;
        }
    }

    /// An interrupt takes the core away from the loop.
    pub(super) const fn interrupt(&mut self, now: Nanos) {
        if self.at == now {
            self.idle_until(now + 1);
        }
        if now >= self.sends_until {
            self.at += INTERRUPT;
        } else {
            self.send_longer(WHILE_SENDING);
        }
    }

    /// The radio's interrupt, for a packet that has come off the air. [`PASSING_ON`] has it where the loop
    /// is idle.
    pub(super) const fn land(&mut self, now: Nanos) {
        if now < self.sends_until {
            self.send_longer(LANDING);
        }
    }

    const fn send_longer(&mut self, by: Nanos) {
        self.at += by;
        self.sends_until += by;
    }

    /// The step at which the loop is takes so long.
    pub(super) const fn work(&mut self, time: Nanos) {
        self.at += time;
    }

    /// The loop has found the end of a frame, and goes on to its next step.
    pub(super) const fn leave_line(&mut self) {
        self.step += 1;
    }

    /// When the step at which the loop is begins to send.
    pub(super) const fn at(&self) -> Nanos {
        self.at
    }

    /// The loop waits for the last byte that it sends.
    pub(super) const fn wait_until(&mut self, sent: Nanos) {
        (self.at, self.sends_until) = (sent, sent);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From `since` on one step is ready, and no other.
    fn only(which: Step, since: Nanos) -> impl Fn(Step) -> Nanos + Copy {
        move |step| if step == which { since } else { Nanos::MAX }
    }

    #[test]
    fn what_comes_during_a_round_waits_for_the_next() {
        let main_loop = MainLoop::new(0);
        assert_eq!(main_loop.next(only(Step::Air, 0)), 0);
        assert_eq!(main_loop.next(only(Step::Air, 1)), ROUND);
        assert_eq!(main_loop.next(only(Step::Power, 3 * ROUND)), 3 * ROUND);
        assert_eq!(main_loop.next(|_| Nanos::MAX), Nanos::MAX);
    }

    #[test]
    fn a_step_that_was_passed_comes_again_a_round_later() {
        let mut main_loop = MainLoop::new(0);
        assert_eq!(main_loop.take(0, only(Step::Battery, 0)), Some(Step::Battery));
        main_loop.wait_until(1_000);
        assert_eq!(main_loop.next(only(Step::Signal, 500)), 1_000);
        assert_eq!(main_loop.next(only(Step::Air, 500)), 1_000 + ROUND);
        assert_eq!(main_loop.next(only(Step::Signal, 1_001)), 1_000 + ROUND);
    }

    #[test]
    fn bytes_make_a_round_longer_unless_it_waits_for_what_it_sends() {
        let mut main_loop = MainLoop::new(0);
        main_loop.idle_until(10);
        main_loop.interrupt(10);
        main_loop.interrupt(10_010);
        assert_eq!(main_loop.next(only(Step::Line, 0)), ROUND + 2 * INTERRUPT);
        main_loop.wait_until(500_000);
        main_loop.interrupt(400_000);
        assert_eq!(main_loop.next(only(Step::Power, 0)), 500_000 + WHILE_SENDING);
    }
}
