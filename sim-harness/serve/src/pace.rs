//! Makes simulated time follow real time.

use std::time::{Duration, Instant};

/// The lag of simulated time that is still caught up with, after a short delay; a longer lag is
/// accepted for good.
const SLACK: Duration = Duration::from_millis(250);
/// The time over which the machine is judged.
const WINDOW: Duration = Duration::from_secs(5);
/// The part of that time that may be lost.
const LOST: f64 = 0.05;

/// The pace of simulated time.
pub(super) struct Pace {
    /// Simulated seconds per second.
    speed: f64,
    /// A moment on the wall, and the simulated microsecond that belongs to it.
    anchor: (Instant, u64),
    /// The begin of the time over which lags are added up.
    judged: Instant,
    lost: Duration,
    complained: bool,
}

impl Pace {
    /// `speed` simulated seconds per second, from now on.
    pub(super) const fn new(speed: f64, now: Instant, simulated_us: u64) -> Self {
        let anchor = (now, simulated_us);
        Self { speed, anchor, judged: now, lost: Duration::ZERO, complained: false }
    }

    /// When on the wall a simulated moment is due.
    pub(super) fn due(&self, simulated_us: u64) -> Instant {
        let ahead = simulated_us.saturating_sub(self.anchor.1);
        self.anchor.0 + Duration::from_secs_f64(ahead as f64 * 1e-6 / self.speed)
    }

    /// Takes every simulated moment as it is reached. Returns true once, when the machine does not
    /// keep up.
    pub(super) fn reached(&mut self, simulated_us: u64, now: Instant) -> bool {
        let lag = now.saturating_duration_since(self.due(simulated_us));
        if lag > SLACK {
            self.anchor = (now, simulated_us);
            self.lost += lag;
        }
        let judged = now.saturating_duration_since(self.judged);
        if judged < WINDOW {
            return false;
        }
        let slow = self.lost.as_secs_f64() > LOST * judged.as_secs_f64();
        (self.judged, self.lost) = (now, Duration::ZERO);
        slow && !std::mem::replace(&mut self.complained, true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_US: u64 = 10_000;

    /// A machine that takes `cost` for each step: the speed it reached, and how often it
    /// complained.
    fn run(speed: f64, cost: Duration, steps: u64) -> (f64, usize) {
        let start = Instant::now();
        let mut pace = Pace::new(speed, start, 0);
        let (mut wall, mut complaints) = (start, 0);
        for step in 1..=steps {
            wall = wall.max(pace.due(step * STEP_US)) + cost;
            complaints += usize::from(pace.reached(step * STEP_US, wall));
        }
        ((steps * STEP_US) as f64 * 1e-6 / (wall - start).as_secs_f64(), complaints)
    }

    #[test]
    fn simulated_time_follows_the_wall_at_the_speed_asked() {
        for speed in [0.1, 1.0, 7.5] {
            let (reached, complaints) = run(speed, Duration::from_micros(100), 10_000);
            assert!((reached / speed - 1.0).abs() < 0.001, "{reached} instead of {speed}");
            assert_eq!(complaints, 0);
        }
    }

    #[test]
    fn a_machine_that_cannot_keep_up_is_slower_and_says_so_once() {
        let (reached, complaints) = run(2.0, Duration::from_millis(10), 10_000);
        assert!((reached - 1.0).abs() < 0.01, "{reached}");
        assert_eq!(complaints, 1);
    }

    #[test]
    fn a_hiccup_is_caught_up_with() {
        let start = Instant::now();
        let mut pace = Pace::new(1.0, start, 0);
        assert!(!pace.reached(STEP_US, start + Duration::from_millis(200)));
        assert_eq!(pace.due(2 * STEP_US), start + Duration::from_millis(20));
    }

    #[test]
    fn a_machine_that_slept_does_not_make_up_for_it() {
        let start = Instant::now();
        let mut pace = Pace::new(1.0, start, 0);
        let late = start + Duration::from_secs(100);
        assert!(!pace.reached(1_000 * STEP_US, start + Duration::from_secs(10)));
        assert!(pace.reached(1_001 * STEP_US, late));
        assert_eq!(pace.due(1_002 * STEP_US), late + Duration::from_millis(10));
    }
}
